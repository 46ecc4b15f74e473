//! The page of all keys, `docs/laboratory/files.md`: made from the code that reads the files.
//!
//! `TERCIO_BLESS=1 cargo test -p tercio-lab --lib handbook` writes it.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::{Machine, parse};
use crate::units::{Bytes, BytesPerSecond, Count, Cycles, Hertz, PolygonRate, Quantity, Ratio, Seconds};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/laboratory/files.md");
const DESCRIPTION: &str = include_str!("description.rs");
const SECTIONS: &str = include_str!("sections.rs");
const STAGES: &str = include_str!("stages.rs");
const KINDS: &str = include_str!("kinds.rs");
const OPERATIONS: &str = include_str!("operations.rs");

/// Sections with the code of their structure and its name.
const STRUCTURES: [(&str, &str, &str); 12] = [
    ("", DESCRIPTION, "Machine"),
    ("sorting", DESCRIPTION, "Sorting"),
    ("processors", DESCRIPTION, "Processors"),
    ("stages", STAGES, "Stage"),
    ("screen", DESCRIPTION, "Screen"),
    ("network", DESCRIPTION, "Network"),
    ("heap", SECTIONS, "Heap"),
    ("sdram", SECTIONS, "Sdram"),
    ("tile-engine", SECTIONS, "TileEngine"),
    ("transfer", SECTIONS, "Transfer"),
    ("calibration", SECTIONS, "Calibration"),
    ("uncertainty", SECTIONS, "Assumptions"),
];
/// Sections whose keys are the variants of an enumeration.
const ENUMERATIONS: [(&str, &str, &str); 2] =
    [("bytes", DESCRIPTION, "DataKind"), ("costs", OPERATIONS, "Operation")];
/// Keys with the enumeration of their words.
const WORDS: [(&str, &str); 7] = [
    ("sorting.class", "SortingClass"),
    ("sorting.screen", "ScreenDivision"),
    ("processors.control", "Control"),
    ("stages.arrangement", "Arrangement"),
    ("network.topology", "Topology"),
    ("network.packing", "Packing"),
    ("network.delivery", "Delivery"),
];

/// A field or a variant.
struct Item {
    key: String,
    /// The type; empty for a variant.
    of: String,
    /// Its documentation.
    what: String,
    /// It has a default: a key that need not be given, or the variant that stands for it.
    is_default: bool,
}

impl Item {
    fn is_required(&self) -> bool {
        !self.is_default && !self.of.starts_with("Option") && !self.of.starts_with("BTreeMap")
    }
}

/// The word that an enumeration has by default.
fn default_word(name: &str) -> Option<String> {
    items(KINDS, name).into_iter().find(|item| item.is_default).map(|item| item.key)
}

fn kebab(name: &str) -> String {
    let mut key = String::new();
    for c in name.chars() {
        if c.is_ascii_uppercase() && !key.is_empty() {
            key.push('-');
        }
        key.push(if c == '_' { '-' } else { c.to_ascii_lowercase() });
    }
    key
}

/// The public fields of a structure, or the variants of an enumeration.
fn items(code: &str, name: &str) -> Vec<Item> {
    let begins = |line: &str| {
        [format!("pub struct {name} {{"), format!("pub enum {name} {{")].contains(&line.to_owned())
    };
    let body = code.lines().skip_while(|line| !begins(line)).skip(1).take_while(|line| *line != "}");
    let (mut found, mut what, mut is_default) = (Vec::new(), Vec::new(), false);
    for line in body.map(str::trim) {
        if let Some(text) = line.strip_prefix("///") {
            what.push(text.trim());
        } else if line.starts_with("#[") {
            is_default |= line.starts_with("#[serde(default") || line == "#[default]";
        } else {
            let item = line.strip_prefix("pub ").unwrap_or(line).trim_end_matches(',');
            let (key, of) = item.split_once(": ").unwrap_or((item, ""));
            found.push(Item { key: kebab(key), of: of.into(), what: what.join(" "), is_default });
            what.clear();
            is_default = false;
        }
    }
    assert!(!found.is_empty(), "no structure {name}");
    found
}

/// The unit of a field, or what it is.
fn unit(of: &str) -> String {
    let inner = of.trim_start_matches("Option<").trim_end_matches('>');
    let of_quantity =
        |name: &str, unit: &str| if unit.is_empty() { name.into() } else { format!("{name}, {unit}") };
    macro_rules! quantity {
        ($($type:ident),*) => {
            match inner {
                $(concat!("Sourced<", stringify!($type)) => of_quantity($type::NAME, $type::UNIT),)*
                "String" => "text".into(),
                "bool" => "`true` or `false`".into(),
                name if name.starts_with("Vec<") => "sections, one each".into(),
                name if WORDS.iter().any(|words| words.1 == name) => "one of the words below".into(),
                _ => "a section".into(),
            }
        };
    }
    quantity!(Bytes, BytesPerSecond, Count, Cycles, Hertz, PolygonRate, Ratio, Seconds)
}

/// The header of a section, which a file may have several times if it is that of a list.
fn header(section: &str) -> String {
    if section == "stages" { format!("[[{section}]]") } else { format!("[{section}]") }
}

/// The lines of the documentation of a module.
fn documentation(code: &str) -> String {
    let lines = code.lines().take_while(|line| line.starts_with("//!"));
    lines.map(|line| format!("{}\n", line.trim_start_matches("//!").trim_start_matches(' '))).collect()
}

fn page() -> String {
    let mut page = String::from(
        "# Files of the laboratory\n\nMade from the code that reads the files; a test compares this page with it.\n\n\
         ## Machines\n\nA machine is a TOML file. Every number has its source: `{ value = \"14 MHz\", source = \"000, \
         2.3\" }`. Prefixes of units (k, M, G, Ki, m, u, n)\nare understood; the table gives base units. A section or key \
         that is *optional* has no value if it is not given:\na command that needs it names it and ends with an error.\n",
    );
    for (section, code, name) in STRUCTURES {
        let title =
            if section.is_empty() { "Top of the file".into() } else { format!("`{}`", header(section)) };
        let _ = writeln!(page, "\n### {title}\n\n| key | what it is | given | meaning |\n|---|---|---|---|");
        for item in items(code, name) {
            let given = match WORDS.iter().find(|words| words.1 == item.of).and_then(|w| default_word(w.1)) {
                Some(word) => format!("`{word}` by default"),
                None if item.of == "bool" => "`false` by default".into(),
                None if item.is_required() => "required".into(),
                None => "optional".into(),
            };
            let Item { key, of, what, .. } = item;
            let _ = writeln!(page, "| `{key}` | {} | {given} | {what} |", unit(&of));
        }
        if section == "network" {
            page.push_str("\nThe sections `[node]` and `[mpi]` have the same keys.\n");
        }
    }
    for (section, code, name) in ENUMERATIONS {
        let what = if section == "costs" {
            "All are optional: numbers of cycles of the processors' clock (`\"100 cycles\"`), or times (`\"20 ns\"`)."
        } else {
            "All are optional: bytes of one."
        };
        let _ = writeln!(page, "\n### `[{section}]`\n\n{what}\n\n| key | meaning |\n|---|---|");
        items(code, name).iter().for_each(|i| {
            let _ = writeln!(page, "| `{}` | {} |", i.key, i.what);
        });
    }
    page.push_str("\n### `[claims]`\n\nKeys of any name, each a rate in polygon/s that a document or the maker states.\n");
    for (key, name) in WORDS {
        let _ = writeln!(page, "\n### Words of `{key}`\n\n| word | meaning |\n|---|---|");
        items(KINDS, name).iter().for_each(|i| {
            let _ = writeln!(page, "| `{}` | {} |", i.key, i.what);
        });
    }
    for (title, code) in [
        ("Workloads: boxes (`.boxes`)", include_str!("../workloads/boxes.rs")),
        ("Workloads: polygons (`.polygons`)", include_str!("../workloads/polygons.rs")),
        ("Screen maps", include_str!("../workloads/screen_map/mod.rs")),
    ] {
        let _ = write!(page, "\n## {title}\n\n{}", documentation(code));
    }
    page
}

#[test]
fn the_page_of_all_keys_is_that_of_the_code() {
    let made = page();
    if std::env::var_os("TERCIO_BLESS").is_some() {
        std::fs::write(PAGE, &made).unwrap();
    }
    let kept = std::fs::read_to_string(PAGE).unwrap();
    assert!(
        made == kept,
        "docs/laboratory/files.md is stale: TERCIO_BLESS=1 cargo test -p tercio-lab --lib handbook"
    );
}

/// The names in backquotes of the error for a key that does not exist, without that key.
fn expected_keys(section: &str) -> BTreeSet<String> {
    let machine: Machine = super::load("hybris-asic").unwrap();
    let text = machine.to_toml().unwrap();
    // In front of everything else, or as a section of its own.
    let text = match section {
        "" => format!("no-such-key = 1\n{text}"),
        _ => {
            let without: String = text
                .split("\n[")
                .filter(|part| {
                    !part.starts_with(&format!("{section}]")) && !part.starts_with(&format!("{section}."))
                })
                .collect::<Vec<_>>()
                .join("\n[");
            let header = header(section);
            format!("{without}\n{header}\nno-such-key = {{ value = \"1 cycle\", source = \"x\" }}\n")
        }
    };
    let message = parse("x.toml", &text).unwrap_err().to_string();
    let listed = message.split_once("expected").unwrap_or_else(|| panic!("{section}: {message}")).1;
    listed.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn the_keys_of_the_page_are_those_that_are_read() {
    for (section, code, name) in STRUCTURES.into_iter().chain(ENUMERATIONS) {
        let listed: BTreeSet<_> = items(code, name).into_iter().map(|i| i.key).collect();
        assert_eq!(listed, expected_keys(section), "[{section}]");
    }
}

/// What the page calls required is missed, and nothing else.
#[test]
fn required_keys_are_those_that_are_missed() {
    let table = |name: &str| super::load(name).unwrap().to_toml().unwrap().parse::<toml::Table>().unwrap();
    let (engine, stages) = (table("hybris-asic"), table("sgi-gtx"));
    let mut tried = 0;
    for (section, code, name) in STRUCTURES {
        let whole = if section == "stages" { &stages } else { &engine };
        for item in items(code, name) {
            let mut without = whole.clone();
            let table = match section {
                "" => Some(&mut without),
                "stages" => without["stages"].as_array_mut().unwrap()[0].as_table_mut(),
                _ => without.get_mut(section).and_then(toml::Value::as_table_mut),
            };
            let Some(removed) = table.and_then(|table| table.remove(&item.key)) else { continue };
            let read = parse("x.toml", &without.to_string());
            let missed = read.is_err_and(|e| e.to_string().contains("missing field"));
            assert_eq!(missed, item.is_required(), "[{section}] {} = {removed}", item.key);
            tried += 1;
        }
    }
    assert!(tried > 30, "{tried}");
}

#[test]
fn the_examples_of_the_page_are_read() {
    let page = std::fs::read_to_string(PAGE).unwrap();
    let examples: Vec<_> =
        page.split("```text\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    let [boxes, polygons, map] = examples[..] else { panic!("{examples:?}") };
    assert_eq!(crate::workloads::BoxScene::parse(boxes).unwrap().boxes.len(), 2);
    assert!(crate::workloads::PolygonScene::parse(polygons).is_ok());
    assert!(crate::workloads::ScreenMap::parse(map).is_ok());
}
