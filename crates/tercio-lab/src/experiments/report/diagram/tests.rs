use super::*;
use crate::machines::{NAMES, SortingClass, Topology, load, parse};

#[test]
fn every_machine_is_sorted_where_its_class_says_and_what_travels_is_named() {
    for name in NAMES {
        let machine = load(name).unwrap();
        let element = svg(&machine);
        assert!(element.starts_with("<svg") && element.trim_end().ends_with("</svg>"), "{name}");
        let sorts = match machine.sorting.class {
            SortingClass::None => 0,
            SortingClass::SortFirst | SortingClass::SortMiddle | SortingClass::SortLast => 1,
            SortingClass::SortTwice => 2,
            // The engines' triangles are sorted into the tiles of a heap.
            SortingClass::Hybrid => {
                if machine.tile_engine.is_some() {
                    1
                } else {
                    2
                }
            }
        };
        assert_eq!(element.matches(">sort</text>").count(), sorts, "{name}");
    }
    let ring = svg(&load("princeton-engine").unwrap());
    assert!(ring.contains("descriptors, 84 B each") && ring.contains("processor 1024"));
    assert!(!ring.contains("pixels, "));
}

#[test]
fn the_stages_and_queues_of_tile_engines_are_drawn() {
    let element = |name: &str| svg(&load(name).unwrap());
    let count = |name: &str, label: &str| element(name).matches(&format!(">{label}</text>")).count();
    for stage in
        ["front end", "triangle heap", "set-up triangle", "draw triangle", "set-up span", "draw span"]
    {
        assert_eq!(count("hybris-asic", stage), 1, "{stage}");
    }
    // Four stages and a tile buffer for each engine; two lanes of two stages and two spans each in the 2x2 engine.
    assert_eq!((count("hybris-asic", "engine 1"), count("hybris-asic-two-engines", "engine 2")), (5, 5));
    assert_eq!((count("hybris-asic-2x2", "odd lines"), count("hybris-asic-2x2", "odd pixels")), (2, 2));
    assert_eq!((count("hybris-asic", "queue of 16"), count("hybris-asic-2x2", "queues of 16 and 4")), (2, 2));
    assert_eq!((count("hybris-fpga", "register"), count("hybris-fpga", "bus, 100 MB/s")), (2, 1));
    assert_eq!((count("hybris-dual-cpu", "heap 2"), count("hybris-dual-cpu", "processor 2")), (1, 6));
    assert_eq!(count("hybris-single-cpu", "register"), 0, "nested loops have no queues");
}

/// The words of a diagram.
fn words(element: &str) -> Vec<String> {
    let texts = element.split("</text>").filter_map(|part| part.rsplit_once('>'));
    texts.map(|(_, words)| words.to_owned()).filter(|words| !words.trim().is_empty()).collect()
}

#[test]
fn every_diagram_shows_the_numbers_of_its_keys_and_what_travels() {
    let mut stages = 0;
    for name in NAMES {
        let machine = load(name).unwrap();
        if machine.tile_engine.is_some() {
            continue;
        }
        let words = words(&svg(&machine));
        let shown = |what: &str| assert!(words.iter().any(|w| w == what), "{name}: {what} in {words:?}");
        for stage in &machine.stages {
            let count = stage.count.whole();
            let is = words.iter().any(|w| {
                w.strip_prefix(&format!("{count} ")).is_some_and(|rest| rest.starts_with(&stage.name))
            });
            assert!(is, "{name}: {count} {} in {words:?}", stage.name);
            stage.receives.iter().for_each(|what| shown(what));
            if let Some(topology) = stage.over {
                assert!(words.iter().any(|w| w.starts_with(topology.name())), "{name}: {topology:?}");
            }
            stages += 1;
        }
        if machine.stages.is_empty() {
            let (count, per_node) = (machine.processors.count.whole(), machine.processors.per_node.as_ref());
            match per_node.map(|n| n.whole()) {
                Some(n) => shown(&format!("{} nodes of {n} processors", count / n)),
                None => shown(&format!("{count} processors")),
            }
        }
    }
    assert!(stages > 30, "{stages}");
}

/// What the documents say of machines whose stages differ (000, 1.1.1 and 2.2; 001, 2.1.2), written out.
#[test]
fn stages_have_the_numbers_of_the_documents() {
    let has = |name: &str, expected: &[&str], never: &[&str]| {
        let words = words(&svg(&load(name).unwrap()));
        for what in expected {
            assert!(words.iter().any(|w| w == what), "{name}: {what} in {words:?}");
        }
        for what in never {
            assert!(!words.iter().any(|w| w.contains(what)), "{name}: {what} in {words:?}");
        }
    };
    let stages = ["5 geometry processors", "in a pipeline", "1 polygon processor", "1 edge processor"];
    has("sgi-gtx", &stages, &["descriptors", "20 geometry"]);
    has("sgi-gtx", &["5 span processors", "spans", "20 image engines", "4 for each", "17 to 20"], &[]);
    let engines = ["12 geometry engines", "20 fragment generators", "320 image engines", "16 for each"];
    has("sgi-reality-engine", &engines, &["descriptors"]);
    has("pixel-planes-5", &["32 graphics processors", "16 renderers", "ring, 5 Gbit/s a link"], &[]);
    has("powervr-naomi-2", &["1 geometry chip", "2 tile chips"], &["2 geometry"]);
    has("princeton-engine", &["1024 processors", "ring, 28 MB/s a link"], &["crossbar"]);
}

/// Lines of one sort, as many as there are.
fn strokes(name: &str) -> usize {
    let page = page(&load(name).unwrap());
    let lines = page.shapes.iter().filter_map(|shape| match shape {
        Shape::Lines { style, lines } if style.color == SORT => Some(lines.len()),
        _ => None,
    });
    lines.sum()
}

#[test]
fn networks_are_drawn_by_their_shape() {
    // A ring has one line for each of three boxes on both sides and its own; a crossbar has a line for each pair.
    assert_eq!(strokes("princeton-engine"), 7);
    assert_eq!(strokes("two-core-2026"), 4);
    // Broadcast by one host to two boards over a bus.
    assert_eq!(strokes("voodoo-sli"), 4);
    let ring = load("princeton-engine").unwrap().to_toml().unwrap();
    let mut drawings = std::collections::BTreeSet::new();
    for topology in ["ring", "mesh", "torus", "fat-tree", "crossbar", "bus", "memory"] {
        let text = ring.replacen("topology = \"ring\"", &format!("topology = \"{topology}\""), 1);
        let machine = parse("m.toml", &text).unwrap();
        let same_words = svg(&machine).replace(&format!("{topology}, 28 MB/s"), "");
        assert!(drawings.insert(same_words), "{topology} is drawn as another one");
    }
}

#[test]
fn units_are_joined_to_those_that_they_serve() {
    let gtx = columns(&load("sgi-gtx").unwrap());
    let ends = |i: usize| columns::joined(&gtx[i], &gtx[i + 1]);
    // Into the first and out of the last processor of a pipeline, and each span processor to its own engines.
    let [first, .., last] = ROWS[2] else { panic!() };
    assert_eq!(ends(0), [[ROWS[0][0], *first]]);
    assert_eq!(ends(1), [[*last, ROWS[0][0]]]);
    assert_eq!(ends(4), ROWS[2].iter().map(|&y| [y, y]).collect::<Vec<_>>());
    // Each of 8 last splitters has two processors; the first two and the last one of 16 are drawn.
    let parks = columns(&load("parks-splitter").unwrap());
    let leaves = network::leaves(15);
    assert_eq!(leaves.len(), 8);
    let joined = columns::joined(&parks[2], &parks[3]);
    let expected = [[leaves[0], ROWS[2][0]], [leaves[0], ROWS[2][1]], [leaves[7], ROWS[2][2]]];
    assert_eq!(joined, expected);
    assert!(parks.iter().all(|c| !matches!(c.link, Link::Over { topology: Topology::Crossbar, .. })));
}
