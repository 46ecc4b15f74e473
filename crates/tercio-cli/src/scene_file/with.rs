//! Models that `--with` adds.

use std::path::Path;

use super::Member;
use super::definition::{Class, Definition};
use super::layers::{Given, Settings};
use crate::output::UsageError;

/// `FILE;KEY=VALUE;...`
///
/// # Errors
/// [`UsageError`].
pub fn read(text: &str, definition: &mut Definition) -> Result<Member, UsageError> {
    let wrong = |reason: String| UsageError(format!("--with '{text}': {reason}"));
    let mut parts = split(text).into_iter();
    let file = parts.next().unwrap_or_default();
    if file.trim().is_empty() {
        return Err(wrong("expected the name of a file first".into()));
    }
    let mut settings = Settings::default();
    for part in parts.filter(|part| !part.trim().is_empty()) {
        let (key, value) = match part.split_once('=') {
            Some((key, value)) => (key.trim(), Some(value.trim())),
            None => (part.trim(), None),
        };
        let key = key.trim_start_matches("--");
        match definition.class(key) {
            Some(Class::Model) => {}
            Some(_) => {
                return Err(wrong(format!(
                    "{key} is an option of the whole picture: give it apart from --with"
                )));
            }
            None => {
                return Err(wrong(format!("there is no option {key}{}", definition.like(key, &[]))));
            }
        }
        let name = definition.find(key).and_then(|option| option.get_long()).unwrap_or(key).to_owned();
        let given = match (value, settings.take(&name)) {
            (Some(value), Some(Given::Values(mut values))) => {
                values.push(value.into());
                Given::Values(values)
            }
            (Some(value), _) => Given::Values(vec![value.into()]),
            (None, _) => Given::Flag,
        };
        definition.check(&name, &given).map_err(wrong)?;
        settings.set(&name, given);
    }
    Ok(Member { files: vec![Path::new(&file).into()], settings, placements: Vec::new() })
}

/// The parts between single semicolons; a double one is a semicolon.
fn split(text: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut characters = text.chars().peekable();
    while let Some(c) = characters.next() {
        if c == ';' && characters.next_if_eq(&';').is_none() {
            parts.push(String::new());
        } else if let Some(last) = parts.last_mut() {
            last.push(c);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn semicolons_separate_unless_they_are_doubled() {
        assert_eq!(split("a.ply;b=1;c"), ["a.ply", "b=1", "c"]);
        assert_eq!(split("a;;b.ply;bar-title=x;;"), ["a;b.ply", "bar-title=x;"]);
        assert_eq!(split(""), [""]);
    }
}
