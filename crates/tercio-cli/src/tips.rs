//! Tips for wrong usage: what another program calls an option, a near misspelling, a value after an equals sign. Where none of
//! these helps there is none.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use clap::{Arg, Command};

use crate::other_programs;

/// Gives an error about wrong usage the tip that helps, in place of the parser's own.
pub fn add(error: &mut Error, program: &Command, arguments: &[OsString]) {
    // The value may also have been read as one of several models, where another option is missing.
    let surplus = match (error.kind(), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::UnknownArgument, Some(ContextValue::String(surplus))) => surplus.clone(),
        (ErrorKind::MissingRequiredArgument, _) => String::new(),
        _ => return,
    };
    if surplus.starts_with('-') {
        return for_unknown_option(error, program, arguments, &surplus);
    }
    if error.get(ContextKind::Suggested).is_none()
        && let Some(tip) = equals_tip(program, arguments, &surplus)
    {
        suggest(error, tip);
    }
}

fn suggest(error: &mut Error, tip: impl Into<StyledStr>) {
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
}

fn for_unknown_option(error: &mut Error, program: &Command, arguments: &[OsString], surplus: &str) {
    let command = arguments.get(1).and_then(|name| program.find_subcommand(name));
    // The parser finds names similar that have a few letters in common, and takes what begins with a hyphen for a value.
    let own = error.remove(ContextKind::SuggestedArg);
    let is_file = Path::new(surplus).exists();
    if !is_file {
        error.remove(ContextKind::Suggested);
    }
    if own.is_some()
        && let Some(command) = command
    {
        // It also names the option that it found.
        let mut command = command.clone().bin_name(format!("tercio {}", command.get_name()));
        error.insert(ContextKind::Usage, ContextValue::StyledStr(command.render_usage()));
    }
    let is_render = command.is_some_and(|command| ["render", "sheet"].contains(&command.get_name()));
    if let Some(tip) = other_programs::tip(surplus).filter(|_| is_render) {
        suggest(error, tip);
    } else if let Some(name) = command.and_then(|command| near(command, surplus)) {
        error.insert(ContextKind::SuggestedArg, ContextValue::String(name));
    }
}

/// The option that a misspelt one means: one that begins with it, or one with the same first letters and few other ones.
fn near(command: &Command, surplus: &str) -> Option<String> {
    let name = surplus.strip_prefix("--")?.split('=').next()?;
    let longs: Vec<&str> =
        command.get_arguments().filter(|option| !option.is_hide_set()).filter_map(Arg::get_long).collect();
    let begins: Vec<&str> =
        longs.iter().copied().filter(|long| name.len() > 2 && long.starts_with(name)).collect();
    if let [one] = begins[..] {
        return Some(format!("--{one}"));
    }
    let letters = |text: &str| text.chars().take(2).collect::<String>();
    let distance = |long: &str| strsim::damerau_levenshtein(long, name);
    let is_near = |long: &&&str| {
        let most = if name.len() < 8 { 1 } else { 2 };
        // Of three letters, another one makes another word: only a missing one is a slip.
        let is_word = name.len() > 3 || long.len() > name.len();
        is_word && letters(long) == letters(name) && distance(long) <= most
    };
    let found = longs.iter().filter(is_near).min_by_key(|long| distance(long));
    found.map(|long| format!("--{long}"))
}

/// Why there are too many models, if one of them is the value of an option.
pub fn surplus_model(models: &[PathBuf]) -> Option<String> {
    let program = crate::definition();
    let arguments = crate::arguments(&program);
    let models: Vec<_> = models.iter().map(|model| model.to_string_lossy()).collect();
    let tip = equals_tip(&program, &arguments, models.get(1)?)?;
    Some(format!("unexpected argument '{}': {tip}", models[1]))
}

/// That an option takes its value after `=`, if one stands before what looks like its value: `--ao 0.5` is `--ao` without a
/// value, and one more model.
fn equals_tip(program: &Command, arguments: &[OsString], surplus: &str) -> Option<String> {
    let arguments: Vec<_> = arguments.iter().skip(1).map(|a| a.to_string_lossy().into_owned()).collect();
    let command = arguments.first().and_then(|name| program.find_subcommand(name))?;
    let takes_equals = |argument: &str| {
        let name = argument.strip_prefix("--");
        name.is_some_and(|name| {
            command.get_arguments().any(|a| a.is_require_equals_set() && a.get_long() == Some(name))
        })
    };
    // Before a model's name, the value was read as that name, and the name is the surplus argument.
    let is_value = |value: &str| value == surplus || value.starts_with('#') || value.parse::<f64>().is_ok();
    let mut pairs = arguments.windows(2);
    let [option, value] = pairs.find(|pair| takes_equals(&pair[0]) && is_value(&pair[1]))? else {
        return None;
    };
    Some(format!("the value of '{option}' follows an equals sign: '{option}={value}'"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspellings_are_near_and_nothing_else() {
        let program = crate::definition();
        let render = program.find_subcommand("render").expect("a command");
        let found = |given: &str| near(render, given);
        for (given, meant) in [
            ("--azimut", "--azimuth"),
            ("--elevaton=3", "--elevation"),
            ("--colour-by", "--color-by"),
            ("--backgruond", "--background"),
            ("--turntabel", "--turntable"),
            ("--ortho", "--orthographic"),
            ("--zom", "--zoom"),
        ] {
            assert_eq!(found(given).as_deref(), Some(meant), "{given}");
        }
        for given in
            ["--wireframe", "--foo", "--max-size", "--ref", "--style2", "--screen", "--transmission", "-b"]
        {
            assert_eq!(found(given), None, "{given}");
        }
    }
}
