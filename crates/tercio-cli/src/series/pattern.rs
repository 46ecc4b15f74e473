//! Names of many outputs from one: `frame_{:04}.png`, `{view}.png`, `thumbs/{name}.png`; and texts in pictures that differ so.

use std::path::{Path, PathBuf};

use super::form::Form;

/// What a name may say about a picture.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// `{}` or `{frame}`: the number of the picture in its series, counted from 0.
    pub frame: Option<usize>,
    /// `{view}`: the name of the view.
    pub view: Option<String>,
    /// `{step}`: the number of the model in a series of models, counted from 0.
    pub step: Option<usize>,
    /// `{name}`: the name of the model's file without folder and ending.
    pub name: Option<String>,
    /// `{time}`: the time of the model in its collection, or of its file.
    pub time: Option<f64>,
}

const KNOWN: [&str; 6] = ["", "frame", "view", "step", "name", "time"];

/// What there is, for errors.
const EXPECTED: &str =
    "expected {}, {frame}, {view}, {step}, {time} or {name}, numbers also as {:04} or {time:.2f}";

/// A piece of a pattern.
enum Piece<'a> {
    Text(&'a str),
    /// What is between braces, the name in it, and the form of its number.
    Place(&'a str, &'a str, Form),
}

/// The pieces of a text; an error if there are placeholders, but not of these names and forms.
fn pieces(text: &str) -> Result<Vec<Piece<'_>>, String> {
    let mut pieces = Vec::new();
    let mut rest = text;
    while let Some(open) = rest.find(['{', '}']) {
        let (before, after) = rest.split_at(open);
        pieces.push(Piece::Text(before));
        if after.starts_with("{{") || after.starts_with("}}") {
            pieces.push(Piece::Text(&after[..1]));
            rest = &after[2..];
            continue;
        }
        let inner = after.strip_prefix('{').and_then(|after| after.split_once('}'));
        let Some((inner, after)) = inner else {
            return Err(format!("\"{text}\": a brace without the other one; {{{{ and }}}} stand for braces"));
        };
        let (name, width) = inner.split_once(':').map_or((inner, None), |(name, width)| (name, Some(width)));
        if !KNOWN.contains(&name) {
            return Err(format!(
                "\"{text}\": there is no {{{name}}}: {EXPECTED}; {{{{{inner}}}}} stands for {{{inner}}}"
            ));
        }
        let form = width.map_or(Ok(Form::default()), |form| Form::parse(form, name));
        let form = form.map_err(|reason| format!("\"{text}\": {{{inner}}}: {reason}"))?;
        pieces.push(Piece::Place(inner, name, form));
        rest = after;
    }
    pieces.push(Piece::Text(rest));
    Ok(pieces)
}

/// Whether a path has a placeholder of this name; "" also stands for `{frame}`.
pub fn has(path: &Path, name: &str) -> bool {
    let pieces = path.to_str().map_or_else(|| Ok(Vec::new()), pieces).unwrap_or_default();
    pieces.iter().any(|piece| match piece {
        Piece::Text(_) => false,
        Piece::Place(_, found, _) => *found == name || (name.is_empty() && *found == "frame"),
    })
}

/// Whether a text differs from picture to picture; one with an error, which is reported when it is filled in, does not.
pub fn has_placeholders(text: &str) -> bool {
    pieces(text).is_ok_and(|pieces| pieces.iter().any(|piece| matches!(piece, Piece::Place(..))))
}

/// Whether the name of a file has what looks like a placeholder: a word in braces, known or not. Braces around anything else, as in
/// `{1}`, are part of a name without placeholders and doubled braces.
fn has_any(name: &str) -> bool {
    let is_doubled = name.contains("{{") || name.contains("}}");
    is_doubled
        || name.split('{').skip(1).any(|behind| {
            let rest = behind.trim_start_matches(|c: char| c.is_ascii_alphabetic() || c == '_');
            rest.starts_with([':', '}'])
        })
}

/// Checks that there are the placeholders of a name.
///
/// # Errors
/// As [`expand`].
pub fn check(path: &Path) -> Result<(), String> {
    match path.to_str().filter(|text| has_any(text)) {
        Some(text) => pieces(text).map(drop),
        None => Ok(()),
    }
}

/// The path with its placeholders filled in; what is not known stays as it is.
///
/// # Errors
/// One sentence, for a placeholder that does not exist, or that is not known if there is nothing to fill in later.
pub fn expand(path: &Path, names: &Names, is_last: bool) -> Result<PathBuf, String> {
    let text = path.to_str().unwrap_or_default();
    if !has_any(text) {
        return Ok(path.into());
    }
    expand_text(text, names, is_last).map(PathBuf::from)
}

/// The text with its placeholders filled in; what is not known stays as it is, unless it `is_last`. Doubled braces stand for braces.
///
/// # Errors
/// As [`expand`].
pub fn expand_text(text: &str, names: &Names, is_last: bool) -> Result<String, String> {
    let mut out = String::new();
    for piece in pieces(text)? {
        match piece {
            // Braces stay doubled until the last pass.
            Piece::Text(brace @ ("{" | "}")) if !is_last => out.push_str(&brace.repeat(2)),
            Piece::Text(text) => out.push_str(text),
            Piece::Place(inner, name, form) => {
                let filled = match name {
                    "view" => names.view.clone(),
                    "name" => names.name.clone(),
                    "step" => names.step.map(|n| form.count(n)),
                    "time" => names.time.map(|time| form.time(time)),
                    _ => names.frame.map(|n| form.count(n)),
                };
                match filled {
                    // The names of files may have braces, too.
                    Some(filled) if !is_last => out.push_str(&literal(&filled)),
                    Some(filled) => out.push_str(&filled),
                    None if is_last => {
                        let model = names.name.as_ref().filter(|_| name == "time");
                        let model = model.map_or_else(String::new, |model| format!(" ({model})"));
                        return Err(format!("\"{text}\": {}{model}", unknown(name)));
                    }
                    None => out.push_str(&format!("{{{inner}}}")),
                }
            }
        }
    }
    Ok(out)
}

/// A text of which nothing is a placeholder: its braces are doubled.
pub fn literal(text: &str) -> String {
    text.replace('{', "{{").replace('}', "}}")
}

/// Why there is nothing to fill in for `{time}`.
pub const NO_TIME: &str = "{time} is the time of the model in its collection (.pvd; with {name} in the output's name, --time or --step choose one), or the number TimeValue or TIME in the field data of a VTK file, and it has none";

fn unknown(name: &str) -> &'static str {
    match name {
        "view" => "{view} needs --view",
        "step" => {
            "{step} numbers a series of models, and here is one: give several, without {name} in the output's name, or a collection of times (.pvd)"
        }
        "name" => "{name} is the name of a model",
        "time" => NO_TIME,
        _ => {
            "{frame} numbers a series of pictures, and of this model there is one: give --turntable, --camera-path or several --view; or several models, without {name} in the output's name"
        }
    }
}

/// The name of a model for `{name}`: that of its file without folder, without the ending of a compressed file, and without
/// that of its format.
pub fn name_of(model: &Path) -> String {
    let text = model.to_string_lossy();
    if let Some(builtin) = text.strip_prefix("builtin:") {
        return builtin.into();
    }
    if text == "-" {
        return "stdin".into();
    }
    let name = model.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let is_gz = name.len() > 3 && name.to_ascii_lowercase().ends_with(".gz");
    let name = if is_gz { &name[..name.len() - 3] } else { &name };
    Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(pattern: &str) -> Result<String, String> {
        let names = Names {
            frame: Some(7),
            view: Some("top".into()),
            step: Some(3),
            name: Some("a{b".into()),
            time: Some(0.1 + 0.2),
        };
        expand(Path::new(pattern), &names, true).map(|p| p.to_string_lossy().into_owned())
    }

    #[test]
    fn placeholders_are_filled_in() {
        for (pattern, expected) in [
            ("frame_{:04}.png", "frame_0007.png"),
            ("{frame:02}-{view}.png", "07-top.png"),
            ("{}{step}{name}", "73a{b"),
            ("{name}/{{x}}.png", "a{b/{x}.png"),
            ("t{time}_{time:.2f}_{time:07.3}", "t0.3_0.30_000.300"),
            // No placeholder: the name of a file.
            ("plain{1}.png", "plain{1}.png"),
        ] {
            assert_eq!(filled(pattern).as_deref(), Ok(expected));
        }
        for bad in ["{}{other}", "{:x}.png", "{}{", "{:099}", "{:.2}", "{time:x}", "{time:.}", "f_{foo}.png"]
        {
            assert!(filled(bad).is_err(), "{bad}");
        }
        assert_eq!(filled("{frame").as_deref(), Ok("{frame"));
        let error = filled("f_{foo:03}.png").unwrap_err();
        assert!(
            ["{foo}", "{frame}", "{name}", "{{foo:03}} stands for"].iter().all(|word| error.contains(word)),
            "{error}"
        );
    }

    /// In a text, unlike in the name of a file, braces are always those of placeholders.
    #[test]
    fn braces_in_texts_are_doubled() {
        let filled = |text: &str| expand_text(text, &Names::default(), true);
        assert_eq!(filled("{{foo}} a{{1}}").as_deref(), Ok("{foo} a{1}"));
        for bad in ["{foo}", "{1}", "a { b", "}", "{}"] {
            assert!(filled(bad).is_err(), "{bad}");
        }
        assert!(has_placeholders("{time:.2}") && !has_placeholders("a {{b}}"));
    }

    #[test]
    fn what_is_not_known_yet_is_filled_in_later() {
        let first = Names { name: Some("a{b".into()), ..Names::default() };
        let path = expand(Path::new("{name}_{:03}_{view}_{{}}{name}"), &first, false).unwrap();
        let second = Names { frame: Some(5), view: Some("top".into()), ..Names::default() };
        let path = expand(&path, &second, true).unwrap();
        assert_eq!(path, Path::new("a{b_005_top_{}a{b"));
        assert!(expand(Path::new("{view}.png"), &Names::default(), true).unwrap_err().contains("--view"));
    }

    #[test]
    fn braces_in_names_of_models_stay() {
        for model in ["a{b}", "a{1}", "}{"] {
            let names = Names { name: Some(model.into()), ..Names::default() };
            let path = expand(Path::new("{name}.png"), &names, false).unwrap();
            assert_eq!(expand(&path, &Names::default(), true), Ok(format!("{model}.png").into()));
        }
    }

    #[test]
    fn models_have_names() {
        let names = ["a/b.ply.gz", "c.stl", "d", "builtin:teapot@1M", "-", "e.f.obj", ".gz"];
        let expected = ["b", "c", "d", "teapot@1M", "stdin", "e.f", ".gz"];
        assert_eq!(names.map(|n| name_of(Path::new(n))), expected);
    }
}
