use std::collections::BTreeMap;

use super::*;
use crate::units::BytesPerSecond;

const SMALL: &str = r#"
name = "A machine"
summary = "For tests."

[sorting]
class = "sort-middle"
screen = "tiles"
how = "In words."
source = "000, 1"

[processors]
count = { value = 4, source = "000, 1" }
clock = { value = "100 MHz", source = "000, 1" }

[costs]
pixel = { value = "21 cycles", source = "002, 4" }
vertex = { value = "300 ns", source = "002, 4" }
"#;

/// The message about `SMALL` with one line replaced.
fn error(from: &str, to: &str) -> String {
    assert!(SMALL.contains(from));
    parse("m.toml", &SMALL.replacen(from, to, 1)).unwrap_err().to_string()
}

#[test]
fn every_builtin_machine_is_readable_and_survives_being_written() {
    for name in NAMES {
        let machine = builtin(name).unwrap().unwrap_or_else(|e| panic!("{e}"));
        assert!(!machine.name.is_empty() && !machine.summary.is_empty(), "{name}");
        let again = parse(name, &machine.to_toml().unwrap()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(machine, again, "{name}");
    }
}

#[test]
fn costs_become_seconds() {
    let machine = parse("m.toml", SMALL).unwrap();
    assert_eq!(machine.seconds(Operation::Pixel), Some(21.0 / 100e6));
    assert_eq!(machine.seconds(Operation::Vertex), Some(300.0 * 1e-9));
    assert_eq!(machine.seconds(Operation::Segment), None);
}

#[test]
fn mistakes_are_reported_with_file_and_line() {
    let unit = error("\"100 MHz\"", "\"100 MB\"");
    assert!(unit.starts_with("m.toml:13:") && unit.contains("clock rate: expected Hz"), "{unit}");
    let source =
        error("clock = { value = \"100 MHz\", source = \"000, 1\" }", "clock = { value = \"100 MHz\" }");
    assert!(source.starts_with("m.toml:13:") && source.contains("source"), "{source}");
    let empty = error("value = 4, source = \"000, 1\"", "value = 4, source = \" \"");
    assert!(empty.starts_with("m.toml:12:") && empty.contains("where the number comes from"), "{empty}");
    let key = error("pixel = ", "pixle = ");
    assert!(key.starts_with("m.toml:16:") && key.contains("pixle"), "{key}");
    let class = error("\"sort-middle\"", "\"sort-centre\"");
    assert!(class.starts_with("m.toml:6:") && class.contains("sort-middle"), "{class}");
    let zero = error("value = 4", "value = 0");
    assert!(zero.starts_with("m.toml:12:1: processors.count") && zero.contains("found 0"), "{zero}");
    let whole = error("value = 4", "value = 4.5");
    assert!(whole.starts_with("m.toml:12:") && whole.contains("whole number"), "{whole}");
    let clock = error("clock = { value = \"100 MHz\", source = \"000, 1\" }\n", "");
    assert!(clock.starts_with("m.toml:15:1: costs.pixel"), "{clock}");
    let many = error("value = 4", "value = \"99999999999\"");
    assert!(many.starts_with("m.toml:12:1: processors.count: expected at most 1048576"), "{many}");
    // A number in a table of its own, as `lab machines` writes it.
    let written =
        parse("m.toml", SMALL).unwrap().to_toml().unwrap().replacen("value = \"4\"", "value = \"0\"", 1);
    let line = written.lines().position(|line| line == "[processors.count]").unwrap() + 1;
    let own = parse("m.toml", &written).unwrap_err().to_string();
    assert!(own.starts_with(&format!("m.toml:{line}:1: processors.count: expected more than 0")), "{own}");
    let most = error("21 cycles", "1e19 cycles");
    assert!(most.starts_with("m.toml:16:1: costs.pixel: expected at most 1000000 cycles"), "{most}");
    let bytes = error("[costs]", "[bytes]\ndescriptor = { value = \"1e19 B\", source = \"000\" }\n[costs]");
    assert!(bytes.starts_with("m.toml:16:1: bytes.descriptor: expected at most 1073741824 B"), "{bytes}");
    let fewer = error("[costs]", "at-most = { value = 3, source = \"000\" }\n[costs]");
    assert!(fewer.starts_with("m.toml:15:1: processors.at-most: expected at least"), "{fewer}");
    let node = error("[costs]", "per-node = { value = 2, source = \"000\" }\n[costs]");
    assert!(node.starts_with("m.toml:15:1: processors.per-node: expected a section node"), "{node}");
    let none = error("[costs]", "[uncertainty]\ncosts-of = \"nobody\"\n[costs]");
    assert!(none.starts_with("m.toml:16:1: uncertainty.costs-of") && none.contains("found nobody"), "{none}");
    let serial = error("[costs]", "[uncertainty]\nserial = { value = \"101 %\", source = \"x\" }\n[costs]");
    assert!(serial.starts_with("m.toml:16:1: uncertainty.serial: expected at least"), "{serial}");
    let clock = error("100 MHz", "1e300 MHz");
    assert!(
        clock.starts_with("m.toml:13:1: processors.clock: expected at most 1000000000000 Hz, found 1e300"),
        "{clock}"
    );
    let slow = error("100 MHz", "1e-300 Hz");
    assert!(
        slow.starts_with("m.toml:13:1: processors.clock: expected at least 1 Hz, found 1e-300"),
        "{slow}"
    );
    let off = error("[costs]", "[uncertainty]\ncosts = { value = \"1e300\", source = \"x\" }\n[costs]");
    assert!(off.starts_with("m.toml:16:1: uncertainty.costs: expected at most 1000, found 1e300"), "{off}");
    let broken = error("[costs]", "[costs");
    assert!(broken.starts_with("m.toml:15:"), "{broken}");
}

/// Of numbers that times are divided by, or that memory and time of a simulation grow with, those that no machine has.
#[test]
fn numbers_that_no_machine_has_are_refused() {
    let text = builtin("hybris-dual-cpu").unwrap().unwrap().to_toml().unwrap();
    let refused = |text: &str, section: &str, key: &str, value: &str, expected: &str| {
        let head = format!("[{section}.{key}]\nvalue = \"");
        let (before, after) = text.split_once(&head).unwrap_or_else(|| panic!("{section}.{key} in {text}"));
        let (old, rest) = after.split_once('"').unwrap();
        let error = parse("m.toml", &format!("{before}{head}{value}\"{rest}")).unwrap_err().to_string();
        let line = before.lines().count() + 1;
        let all = format!("m.toml:{line}:1: {section}.{key}: expected {expected}, found {value}");
        assert_eq!(error, all, "instead of {old}");
    };
    refused(&text, "heap", "heaps", "1000000", "at most 64");
    refused(&text, "tile-engine", "engines", "1000000", "at most 1024");
    let mut cluster = builtin("cluster-64").unwrap().unwrap();
    cluster.processors.nap = Some(Sourced::new(20e-6, "20 us".into(), "a test".into()));
    cluster.processors.exchange_cache = Some(Sourced::new(8e6, "8 MB".into(), "a test".into()));
    let text = cluster.to_toml().unwrap();
    for section in ["network", "node"] {
        refused(&text, section, "bandwidth", "1e300 B/s", "at most 1000000000000000 B/s");
        refused(&text, section, "bandwidth", "1e-300 B/s", "at least 1 B/s");
        refused(&text, section, "message", "1e300 s", "at most 1000 s");
        refused(&text, section, "hop", "1e300 s", "at most 1000 s");
    }
    refused(&text, "processors", "wake-up", "1e300 s", "at most 1000 s");
    refused(&text, "processors", "nap", "1e300 s", "at most 1000 s");
    refused(&text, "processors", "exchange-cache", "1e300 B", "at most 1125899906842624 B");
    refused(&text, "processors", "own-cache", "1e300 B", "at most 1125899906842624 B");
}

/// Costs of 0 are as good as none, and are named with what was found.
#[test]
fn work_that_costs_nothing_is_refused() {
    let free = parse("m.toml", &SMALL.replace("21 cycles", "0 cycles").replace("300 ns", "0 ns")).unwrap();
    let error = free.need_costs(&[&[Operation::Pixel, Operation::Stamp], &[Operation::Vertex]]).unwrap_err();
    assert!(
        error.to_string().ends_with(
            "costs.pixel of more than 0 (found 0 cycles) or costs.stamp, costs.vertex of more than 0 (found 0 ns)"
        ),
        "{error}"
    );
    assert!(parse("m.toml", SMALL).unwrap().need_costs(&[&[Operation::Pixel, Operation::Stamp]]).is_ok());
}

#[test]
fn an_unknown_name_lists_the_known_ones() {
    let error = load("no-such-machine").unwrap_err().to_string();
    assert!(error.contains("no-such-machine") && error.contains("princeton-engine"), "{error}");
}

#[test]
fn descriptions_have_the_numbers_of_the_documents() {
    let machine = |name| builtin(name).unwrap().unwrap();
    let princeton = machine("princeton-engine");
    assert_eq!(princeton.processors.memory.unwrap().value, 640.0 * 1024.0);
    // 16 bits a cycle of 14 MHz.
    assert_eq!(princeton.network.unwrap().bandwidth.get(), BytesPerSecond::new(2.0 * 14e6));
    // The time of document 002's uniprocessor for 248 polygons: 5.77 million cycles of 300 ns.
    let parks = machine("parks-uniprocessor");
    let cost = |o| parks.seconds(o).unwrap();
    let seconds = 248.0 * cost(Operation::Polygon)
        + 731.0 * cost(Operation::Vertex)
        + 1411.0 * cost(Operation::Segment)
        + 251_224.0 * cost(Operation::Pixel);
    assert!((seconds - 5_766_526.5 * 300e-9).abs() < 1e-5, "{seconds}");
}

/// Each processor of a SIMD machine has a memory of its own: none of them are threads.
#[test]
fn processors_of_a_simd_machine_share_no_memory() {
    for name in ["princeton-engine", "magic-1"] {
        let machine = builtin(name).unwrap().unwrap();
        assert!(machine.may_share_memory(1).is_ok());
        let error = machine.may_share_memory(2).unwrap_err().to_string();
        assert!(error.contains("expected at most 1 processors that share a memory, found 2"), "{error}");
    }
}

#[test]
fn a_machine_may_have_an_mpi_network_beside_that_of_its_threads() {
    let machine = builtin("two-core-2026").unwrap().unwrap();
    let missing = machine.clone().over_mpi().unwrap_err().to_string();
    assert!(missing.contains("mpi"), "{missing}");
    let section = "\n[mpi]\ntopology = \"crossbar\"\nbandwidth = { value = \"3 GB/s\", source = \"measured\" }\n\
        hop = { value = \"0 s\", source = \"measured\" }\nmessage = { value = \"2 us\", source = \"measured\" }\n";
    let text = machine.to_toml().unwrap() + section;
    let with = parse("m.toml", &text).unwrap();
    assert_eq!(with.network, machine.network);
    assert_eq!(with.over_mpi().unwrap().network.unwrap().bandwidth.get(), BytesPerSecond::new(3e9));
    let line = text.lines().position(|l| l == "[mpi]").unwrap() + 3;
    let error = parse("m.toml", &text.replace("3 GB/s", "0 GB/s")).unwrap_err().to_string();
    assert!(error.starts_with(&format!("m.toml:{line}:")) && error.contains("bandwidth"), "{error}");
    let error = parse("m.toml", &text.replace("3 GB/s", "3 s")).unwrap_err().to_string();
    assert!(error.starts_with(&format!("m.toml:{line}:")), "{error}");
}

/// What its summary calls like server-128 is, except what it says of messages, shared cache and memory.
#[test]
fn a_node_of_the_cluster_differs_from_the_server_only_where_its_summary_says_so() {
    let [cluster, server] = ["cluster-64", "server-128"].map(|name| builtin(name).unwrap().unwrap());
    let (node, alone) = (cluster.node.unwrap(), server.network.unwrap());
    assert_eq!((node.topology, node.bandwidth.value), (alone.topology, alone.bandwidth.value));
    assert_eq!(node.hop.value, alone.hop.value);
    let says = |what: &str| assert!(cluster.summary.contains(what), "{what}: {}", cluster.summary);
    if node.message.value != alone.message.value {
        says(&format!("{} for {}", node.message, alone.message));
    }
    let (ours, theirs) = (cluster.processors, server.processors);
    assert_eq!(ours.per_node.unwrap().value, theirs.count.value);
    assert_eq!(ours.own_cache.unwrap().value, theirs.own_cache.unwrap().value);
    if ours.shared_cache.map(|c| c.value) != theirs.shared_cache.map(|c| c.value) {
        says("without shared cache");
    }
    if ours.memory_bandwidth.map(|b| b.value) != theirs.memory_bandwidth.map(|b| b.value) {
        says("and bandwidth of memory");
    }
    let values =
        |costs: BTreeMap<Operation, Sourced<Cost>>| costs.into_values().map(|c| c.value).collect::<Vec<_>>();
    assert_eq!(values(cluster.costs), values(server.costs));
}

/// The values of a description that another file quotes, by section and key, with their sources.
fn numbers(name: &str) -> Vec<(String, String, String)> {
    let text = builtin(name).unwrap().unwrap().to_toml().unwrap();
    let table: toml::Table = text.parse().unwrap();
    let sections = table.iter().filter_map(|(section, keys)| Some((section, keys.as_table()?)));
    let of_section = |(section, keys): (&String, &toml::Table)| {
        let section = section.clone();
        let number = move |(key, number): (&String, &toml::Value)| {
            let text = |what: &str| number.get(what)?.as_str().map(str::to_owned);
            Some((format!("{section}.{key}"), text("value")?, text("source")?))
        };
        keys.iter().filter_map(number).collect::<Vec<_>>()
    };
    sections.flat_map(of_section).collect()
}

/// A number whose source is "a core for a core of X", or "as X", is that of X.
#[test]
fn numbers_quoted_from_another_machine_follow_it() {
    let mut compared = 0;
    for name in NAMES {
        for (key, value, source) in numbers(name) {
            let Some(other) = NAMES.iter().find(|n| {
                source.ends_with(&format!("a core for a core of {n}")) || source.ends_with(&format!("as {n}"))
            }) else {
                continue;
            };
            // The memory of a node is what threads of one process exchange messages in.
            let theirs = key.replacen("node.", "network.", 1);
            let theirs = if key == "processors.per-node" { "processors.count".into() } else { theirs };
            let found = numbers(other).into_iter().find(|n| n.0 == theirs);
            let found = found.unwrap_or_else(|| panic!("{name}: {other} has no {theirs}"));
            assert_eq!(value, found.1, "{name}: {key} is quoted from {other}");
            compared += 1;
        }
    }
    assert!(compared > 60, "{compared}");
}

/// A stage needs units, what it sorts, and as many sorts as the class has; mistakes are reported where they are.
#[test]
fn stages_agree_with_the_class() {
    let with = |stages: &str| parse("m.toml", &SMALL.replace("[costs]", &format!("{stages}[costs]")));
    let one = "[[stages]]\nname = \"host\"\ncount = { value = 1, source = \"x\" }\n";
    let two = "[[stages]]\nname = \"chip\"\ncount = { value = 2, source = \"x\" }\nreceives = \"spans\"\nsorted = true\n";
    let good = format!("{one}{two}");
    assert_eq!(with(&good).unwrap().stages.len(), 2);
    let error = |stages: &str| with(stages).unwrap_err().to_string();
    let none = error(&good.replace("value = 2", "value = 0"));
    assert!(none.starts_with("m.toml:20:1: stages.count: expected more than 0, found 0"), "{none}");
    let many = error(&good.replace("value = 2", "value = 10000000"));
    assert!(many.starts_with("m.toml:20:1: stages.count: expected at most 1048576"), "{many}");
    let what = error(&good.replace("receives = \"spans\"\n", ""));
    assert!(what.starts_with("m.toml:21:1: stages.sorted: expected what is sorted"), "{what}");
    let nameless = error(&good.replace("\"chip\"", "\"\""));
    assert!(nameless.starts_with("m.toml:19:1: stages.name: expected what one"), "{nameless}");
    let sorts = error(&format!("{two}{two}"));
    assert!(sorts.starts_with("m.toml:19:1: stages.sorted: expected true in 1 stages"), "{sorts}");
    assert!(sorts.contains("sorting.class is sort-middle; found 2"), "{sorts}");
    assert!(error(one).contains("found 0"), "{}", error(one));
    let eight = error(&format!("{}{two}", one.repeat(8)));
    assert!(eight.contains("expected at most 8 stages, found 9"), "{eight}");
    let shape = error(&good.replace("sorted = true", "over = \"star\""));
    assert!(shape.starts_with("m.toml:22:") && shape.contains("fat-tree"), "{shape}");
    // In a table of its own, as `lab machines` writes it.
    let written = with(&good).unwrap().to_toml().unwrap().replacen("value = \"2\"", "value = \"0\"", 1);
    let line = written.lines().position(|line| line == "value = \"0\"").unwrap();
    let own = parse("m.toml", &written).unwrap_err().to_string();
    assert!(own.starts_with(&format!("m.toml:{line}:1: stages.count")), "{own}");
}
