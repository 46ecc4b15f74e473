//! Scene files and configuration files: what a command line can say, as TOML.
//!
//! A file holds settings, `key = value`, and tables of settings: a scene file those of models (`[[model]]`) and of further places
//! of a model (`[[model.instance]]`), a configuration file those for names of files (`[pattern."*.stl"]`). What the keys
//! mean is not known here: programs have options of these names.
//!
//! ```
//! let text = "size = [640, 480]\n[[model]]\nfile = \"a.ply\"\nopacity = 0.5\n[[model.instance]]\ntranslate = [1, 0, 0]\n";
//! let scene = tercio::scene_file::SceneFile::read(text.as_bytes())?;
//! assert_eq!(scene.settings[0].value.text().as_deref(), Some("640,480"));
//! assert_eq!((scene.models[0].settings[1].key.as_str(), scene.models[0].settings[1].line), ("opacity", 4));
//! assert_eq!(scene.models[0].instances[0].settings.len(), 1);
//! # Ok::<(), tercio::scene_file::SceneFileError>(())
//! ```

use std::fmt::Write as _;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// One setting.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Its name.
    pub key: String,
    /// Its value.
    pub value: Value,
    /// The line of the file, counted from 1.
    pub line: usize,
}

/// The value of a setting.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Value {
    /// Yes or no.
    Flag(bool),
    /// A text.
    Text(String),
    /// A number, with the digits of the file.
    Number(String),
    /// Several values.
    List(Vec<Value>),
    /// Values with names.
    Named(Vec<(String, Value)>),
}

/// Settings in a table of their own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// The settings, in the order of the file.
    pub settings: Vec<Setting>,
    /// The line where the table begins, counted from 1.
    pub line: usize,
}

/// A model of a scene file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModelTable {
    /// The settings, in the order of the file.
    pub settings: Vec<Setting>,
    /// Further places of the model.
    pub instances: Vec<Table>,
    /// The line where the table begins, counted from 1.
    pub line: usize,
}

/// A scene file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneFile {
    /// Settings of the whole picture.
    pub settings: Vec<Setting>,
    /// The models, in the order of the file.
    pub models: Vec<ModelTable>,
}

/// A configuration file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Configuration {
    /// Settings for all pictures.
    pub settings: Vec<Setting>,
    /// Settings for models whose file names match a pattern, in the order of the file.
    pub patterns: Vec<(String, Table)>,
}

/// Why a file is none of these.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{reason}", line.map_or_else(String::new, |line| format!("line {line}: ")))]
pub struct SceneFileError {
    /// The line, counted from 1, if it is known.
    pub line: Option<usize>,
    /// What is wrong.
    pub reason: String,
}

impl Value {
    /// The value as on a command line: elements of lists with commas between them, names with equals signs. `None` for a flag.
    pub fn text(&self) -> Option<String> {
        match self {
            Self::Flag(_) => None,
            Self::Text(text) | Self::Number(text) => Some(text.clone()),
            Self::List(values) => {
                let texts: Option<Vec<String>> = values.iter().map(Self::text).collect();
                texts.map(|texts| texts.join(","))
            }
            Self::Named(values) => {
                let texts = values.iter().map(|(name, value)| Some(format!("{name}={}", value.text()?)));
                texts.collect::<Option<Vec<_>>>().map(|texts| texts.join(","))
            }
        }
    }

    /// The value that has this text: a number or a list of numbers where these are written so in TOML with the same
    /// digits, else a text.
    pub fn from_text(text: &str) -> Self {
        if is_plain_number(text) {
            return Self::Number(text.into());
        }
        let parts: Vec<&str> = text.split(',').collect();
        if parts.len() > 1 && parts.iter().all(|part| is_plain_number(part)) {
            return Self::List(parts.into_iter().map(|part| Self::Number(part.into())).collect());
        }
        Self::Text(text.into())
    }

    fn write(&self, out: &mut String) {
        match self {
            Self::Flag(flag) => out.push_str(if *flag { "true" } else { "false" }),
            Self::Text(text) => out.push_str(&quoted(text)),
            Self::Number(digits) => out.push_str(digits),
            Self::List(values) => {
                out.push('[');
                for (number, value) in values.iter().enumerate() {
                    out.push_str(if number > 0 { ", " } else { "" });
                    value.write(out);
                }
                out.push(']');
            }
            Self::Named(values) => {
                out.push_str("{ ");
                for (number, (name, value)) in values.iter().enumerate() {
                    out.push_str(if number > 0 { ", " } else { "" });
                    let _ = write!(out, "{} = ", key(name));
                    value.write(out);
                }
                out.push_str(" }");
            }
        }
    }
}

/// An integer or a decimal fraction as TOML has them, without what other writings of the same number would have.
fn is_plain_number(text: &str) -> bool {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let (whole, fraction) = digits.split_once('.').map_or((digits, None), |(w, f)| (w, Some(f)));
    let are_digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let is_whole = are_digits(whole) && (whole.len() == 1 || !whole.starts_with('0')) && whole.len() <= 18;
    // Integers have no negative zero.
    is_whole && fraction.is_none_or(are_digits) && text != "-0"
}

/// A text on one line, which keys have to be on.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

fn key(name: &str) -> String {
    let is_bare = |b: u8| b.is_ascii_alphanumeric() || b == b'-' || b == b'_';
    if !name.is_empty() && name.bytes().all(is_bare) { name.into() } else { quoted(name) }
}

impl SceneFile {
    /// Reads a scene file.
    ///
    /// # Errors
    /// [`SceneFileError`]: no TOML, tables that are not those of models, values that are dates.
    pub fn read(bytes: &[u8]) -> Result<Self, SceneFileError> {
        let document = Document::new(bytes)?;
        let table = document.parse()?;
        let mut scene = Self::default();
        for entry in document.entries(&table) {
            if entry.key == "model" {
                for (line, model) in document.tables(&entry, "[[model]]")? {
                    scene.models.push(document.model(model, line)?);
                }
            } else {
                scene.settings.push(document.setting(&entry, "[[model]]")?);
            }
        }
        Ok(scene)
    }

    /// The file's text, which [`SceneFile::read`] reads as the same scene, apart from the lines.
    pub fn to_toml(&self) -> String {
        let mut out = String::new();
        write_settings(&mut out, &self.settings);
        for model in &self.models {
            out.push_str("\n[[model]]\n");
            write_settings(&mut out, &model.settings);
            for instance in &model.instances {
                out.push_str("\n[[model.instance]]\n");
                write_settings(&mut out, &instance.settings);
            }
        }
        out
    }
}

fn write_settings(out: &mut String, settings: &[Setting]) {
    for setting in settings {
        let _ = write!(out, "{} = ", key(&setting.key));
        setting.value.write(out);
        out.push('\n');
    }
}

impl Configuration {
    /// Reads a configuration file.
    ///
    /// # Errors
    /// [`SceneFileError`]: no TOML, tables that are not those of patterns, values that are dates.
    pub fn read(bytes: &[u8]) -> Result<Self, SceneFileError> {
        let document = Document::new(bytes)?;
        let table = document.parse()?;
        let mut configuration = Self::default();
        for entry in document.entries(&table) {
            match entry.value {
                DeValue::Table(patterns) if entry.key == "pattern" => {
                    for pattern in document.entries(patterns) {
                        let DeValue::Table(settings) = pattern.value else {
                            let reason = "expected a table, such as [pattern.\"*.stl\"]";
                            return Err(pattern.wrong(reason));
                        };
                        let table = Table {
                            settings: document.settings(settings, "[pattern.\"*.stl\"]")?,
                            line: pattern.line,
                        };
                        configuration.patterns.push((pattern.key.into(), table));
                    }
                }
                _ => configuration.settings.push(document.setting(&entry, "[pattern.\"*.stl\"]")?),
            }
        }
        Ok(configuration)
    }
}

struct Document<'a> {
    text: &'a str,
    /// Where lines begin.
    lines: Vec<usize>,
}

/// A key with its value.
struct Entry<'t> {
    key: &'t str,
    value: &'t DeValue<'t>,
    at: usize,
    line: usize,
}

impl Entry<'_> {
    fn wrong(&self, reason: &str) -> SceneFileError {
        SceneFileError { line: Some(self.line), reason: format!("{}: {reason}", self.key) }
    }
}

impl<'a> Document<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, SceneFileError> {
        let lines = |text: &str| text.bytes().enumerate().filter(|b| b.1 == b'\n').map(|b| b.0 + 1).collect();
        match std::str::from_utf8(bytes) {
            Ok(text) => {
                let text = text.strip_prefix('\u{feff}').unwrap_or(text);
                Ok(Self { text, lines: lines(text) })
            }
            Err(error) => {
                let line = bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
                Err(SceneFileError { line: Some(line), reason: "not a text in UTF-8".into() })
            }
        }
    }

    fn line(&self, at: usize) -> usize {
        self.lines.partition_point(|&begin| begin <= at) + 1
    }

    fn parse(&self) -> Result<DeTable<'a>, SceneFileError> {
        let parsed = DeTable::parse(self.text).map(Spanned::into_inner);
        parsed.map_err(|error| SceneFileError {
            line: error.span().map(|span| self.line(span.start)),
            reason: error.message().lines().collect::<Vec<_>>().join(" "),
        })
    }

    /// The entries of a table, in the order of the file.
    fn entries<'t>(&self, table: &'t DeTable<'_>) -> Vec<Entry<'t>> {
        let entry = |(key, value): (&'t Spanned<_>, &'t Spanned<_>)| {
            let at = key.span().start;
            let key: &'t std::borrow::Cow<'_, str> = key.get_ref();
            Entry { key, value: value.get_ref(), at, line: self.line(at) }
        };
        let mut entries: Vec<Entry<'t>> = table.iter().map(entry).collect();
        entries.sort_by_key(|entry| entry.at);
        entries
    }

    fn settings(&self, table: &DeTable<'_>, tables: &str) -> Result<Vec<Setting>, SceneFileError> {
        self.entries(table).iter().map(|entry| self.setting(entry, tables)).collect()
    }

    /// A setting; `tables` are the tables that there may be.
    fn setting(&self, entry: &Entry<'_>, tables: &str) -> Result<Setting, SceneFileError> {
        if matches!(entry.value, DeValue::Table(table) if table.iter().any(|(_, v)| matches!(v.get_ref(), DeValue::Table(_))))
        {
            return Err(entry.wrong(&format!("there is no such table; there are {tables}")));
        }
        let value = value(entry.value, MOST_LEVELS).map_err(|reason| entry.wrong(&reason))?;
        Ok(Setting { key: entry.key.into(), value, line: entry.line })
    }

    /// The tables of an array, with their lines.
    fn tables<'t>(
        &self,
        entry: &Entry<'t>,
        name: &str,
    ) -> Result<Vec<(usize, &'t DeTable<'t>)>, SceneFileError> {
        let DeValue::Array(array) = entry.value else {
            return Err(entry.wrong(&format!("expected tables, each of which begins with {name}")));
        };
        let table = |value: &'t Spanned<DeValue<'t>>| match value.get_ref() {
            DeValue::Table(table) => Ok((self.line(value.span().start), table)),
            _ => Err(entry.wrong(&format!("expected tables, each of which begins with {name}"))),
        };
        array.iter().map(table).collect()
    }

    fn model(&self, table: &DeTable<'_>, line: usize) -> Result<ModelTable, SceneFileError> {
        let mut model = ModelTable { line, ..ModelTable::default() };
        for entry in self.entries(table) {
            if entry.key == "instance" {
                for (line, instance) in self.tables(&entry, "[[model.instance]]")? {
                    let settings = self.settings(instance, "[[model.instance]]")?;
                    model.instances.push(Table { settings, line });
                }
            } else {
                model.settings.push(self.setting(&entry, "[[model.instance]]")?);
            }
        }
        Ok(model)
    }
}

/// Lists and tables in a value, one in the other: dotted keys make as many as they have dots.
const MOST_LEVELS: usize = 16;

/// A value of at most so many `levels` of lists and tables.
fn value(value: &DeValue<'_>, levels: usize) -> Result<Value, String> {
    let inside = |value: &DeValue<'_>| match levels.checked_sub(1) {
        Some(levels) => self::value(value, levels),
        None => Err(format!("expected at most {MOST_LEVELS} lists and tables, one in the other")),
    };
    Ok(match value {
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::String(text) => Value::Text(text.clone().into_owned()),
        DeValue::Integer(integer) => {
            let number = i128::from_str_radix(integer.as_str(), integer.radix());
            Value::Number(number.map_err(|_| "a number that is too large")?.to_string())
        }
        DeValue::Float(float) => Value::Number(float.as_str().into()),
        DeValue::Array(values) => {
            Value::List(values.iter().map(|v| inside(v.get_ref())).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => {
            let named = table.iter().map(|(name, v)| Ok((name.get_ref().to_string(), inside(v.get_ref())?)));
            Value::Named(named.collect::<Result<_, String>>()?)
        }
        DeValue::Datetime(_) => return Err("a date has no meaning here; a text has quotation marks".into()),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn scene(text: &str) -> Result<SceneFile, String> {
        SceneFile::read(text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn settings_models_and_instances_have_their_lines() {
        let text = "size = \"64x48\"\n\n[[model]]\nfile = 'a.ply'\nclip = [[1, 0, 0, -0.50], \"x:0.5\"]\n\
                    [[model.instance]]\nscale = 0x10\n[[model]]\nfile=\"b\"\nno-bar = true\n";
        let scene = scene(text).expect("a scene");
        assert_eq!((scene.settings[0].line, scene.models.len()), (1, 2));
        let [first, second] = &scene.models[..] else { panic!("two models") };
        assert_eq!((first.line, first.settings[1].line, first.instances[0].line), (3, 5, 6));
        let Value::List(clips) = &first.settings[1].value else { panic!("a list") };
        assert_eq!(clips.iter().map(|c| c.text().unwrap()).collect::<Vec<_>>(), ["1,0,0,-0.50", "x:0.5"]);
        assert_eq!(first.instances[0].settings[0].value, Value::Number("16".into()));
        assert_eq!(second.settings[1].value, Value::Flag(true));
    }

    /// Dotted keys are tables in tables, which are written in braces, of which a parser takes fewer than of dots.
    #[test]
    fn values_are_nested_a_little() {
        let nested = |levels: usize| format!("a = [{{ {} = 1 }}]\n", vec!["b"; levels].join("."));
        let read = scene(&nested(MOST_LEVELS - 1)).expect("a scene");
        assert_eq!(scene(&read.to_toml()).map(without_lines), Ok(without_lines(read)));
        for levels in [MOST_LEVELS, 2 * MOST_LEVELS] {
            let error = scene(&nested(levels)).expect_err("too deep");
            assert!(error.contains("expected at most 16 lists and tables, one in the other"), "{error}");
        }
        // These the parser refuses.
        assert!(scene(&nested(5000)).is_err());
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, parts) in [
            ("a = 1\nb = \n", &["line 2: "][..]),
            ("a = 1979-05-27\n", &["line 1: a: ", "date"]),
            ("\nmodel = 3\n", &["line 2: model: ", "[[model]]"]),
            ("model = [1]\n", &["line 1: model: "]),
            ("[model]\nfile = 'a'\n", &["line 1: model: ", "[[model]]"]),
            ("[a.b.c]\nd = 1\n", &["line 1: a: ", "no such table"]),
            ("[[model]]\ninstance = 3\n", &["line 2: instance: "]),
            ("a = 1\na = 2\n", &["line 2: "]),
            ("a = 99999999999999999999999999999999999999999999\n", &["line 1: "]),
        ] {
            let error = scene(text).expect_err(text);
            parts.iter().for_each(|part| assert!(error.contains(part), "{text:?}: {error}"));
        }
        let error = SceneFile::read(b"a = 1\n\xff").expect_err("no text").to_string();
        assert!(error.starts_with("line 2: not a text"), "{error}");
    }

    #[test]
    fn configurations_have_patterns_in_order() {
        let text = "size = [8, 8]\n[pattern.\"*.stl\"]\nup-axis = 'z'\n[pattern.\"*\"]\ncolor = 'red'\n";
        let configuration = Configuration::read(text.as_bytes()).expect("a configuration");
        let names: Vec<&str> = configuration.patterns.iter().map(|p| p.0.as_str()).collect();
        assert_eq!(names, ["*.stl", "*"]);
        assert_eq!(configuration.patterns[1].1.settings[0].line, 5);
        for bad in ["pattern = 1\npattern.b = 2", "[pattern]\na = 1\n", "[other.a]\nb.c = 1\n"] {
            assert!(Configuration::read(bad.as_bytes()).is_err(), "{bad}");
        }
    }

    #[test]
    fn numbers_keep_their_digits() {
        for text in [
            "0",
            "-3",
            "0.50",
            "1,2.5,-3",
            "-0",
            "12345678901234567890",
            "1e5",
            "+1",
            "01",
            ".5",
            "1.",
            "x",
            "",
        ] {
            let value = Value::from_text(text);
            assert_eq!(value.text().as_deref(), Some(text));
            let is_number = matches!(&value, Value::Number(_));
            assert_eq!(is_number, ["0", "-3", "0.50"].contains(&text), "{text}");
        }
    }

    fn values() -> impl Strategy<Value = Value> {
        let leaf = prop_oneof![
            any::<bool>().prop_map(Value::Flag),
            any::<String>().prop_map(|text| Value::from_text(&text)),
            "-?[0-9]{1,4}(\\.[0-9]{1,3})?".prop_map(|text| Value::from_text(&text)),
        ];
        leaf.prop_recursive(2, 8, 4, |inner| prop::collection::vec(inner, 0..4).prop_map(Value::List))
    }

    fn tables() -> impl Strategy<Value = Vec<Setting>> {
        let setting = |(key, value)| Setting { key, value, line: 0 };
        let keys = any::<String>().prop_filter("names of tables", |k| k != "model" && k != "instance");
        prop::collection::btree_map(keys, values(), 0..5)
            .prop_map(move |all| all.into_iter().map(setting).collect())
    }

    fn without_lines(mut scene: SceneFile) -> SceneFile {
        let clear = |settings: &mut Vec<Setting>| settings.iter_mut().for_each(|s| s.line = 0);
        clear(&mut scene.settings);
        for model in &mut scene.models {
            model.line = 0;
            clear(&mut model.settings);
            for instance in &mut model.instances {
                instance.line = 0;
                clear(&mut instance.settings);
            }
        }
        scene
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again(
            settings in tables(),
            models in prop::collection::vec((tables(), prop::collection::vec(tables(), 0..3)), 0..3),
        ) {
            let table = |settings| Table { settings, line: 0 };
            let model = |(settings, instances): (_, Vec<_>)| {
                ModelTable { settings, instances: instances.into_iter().map(table).collect(), line: 0 }
            };
            let scene = SceneFile { settings, models: models.into_iter().map(model).collect() };
            let read = SceneFile::read(scene.to_toml().as_bytes()).expect("what was written");
            prop_assert_eq!(without_lines(read), scene);
        }

        #[test]
        fn any_text_is_read_or_refused(text in "(?s)[\\[\\]{}=\"'#a-c.0-9, \n-]{0,60}|.{0,60}") {
            let _ = SceneFile::read(text.as_bytes());
            let _ = Configuration::read(text.as_bytes());
        }
    }
}
