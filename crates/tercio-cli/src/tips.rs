//! Tips for wrong usage that the parser of arguments has none for.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Command;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};

/// Adds to an error about a surplus argument that an option takes its value after `=`, if one stands before what looks
/// like its value: `--ao 0.5` is `--ao` without a value, and one more model.
pub fn add(error: &mut Error, program: &Command, arguments: impl Iterator<Item = OsString>) {
    if error.get(ContextKind::Suggested).is_some() {
        return;
    }
    // The value may also have been read as one of several models, where another option is missing.
    let surplus = match (error.kind(), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::UnknownArgument, Some(ContextValue::String(surplus))) => surplus.clone(),
        (ErrorKind::MissingRequiredArgument, _) => String::new(),
        _ => return,
    };
    if let Some(tip) = equals_tip(program, arguments, &surplus) {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
}

/// Why there are too many models, if one of them is the value of an option.
pub fn surplus_model(models: &[PathBuf]) -> Option<String> {
    let program = crate::definition();
    let arguments = crate::short::with_command(&program, std::env::args_os());
    let models: Vec<_> = models.iter().map(|model| model.to_string_lossy()).collect();
    let tip = equals_tip(&program, arguments.into_iter(), models.get(1)?)?;
    Some(format!("unexpected argument '{}': {tip}", models[1]))
}

/// That an option takes its value after `=`, if one stands before what looks like its value.
fn equals_tip(program: &Command, arguments: impl Iterator<Item = OsString>, surplus: &str) -> Option<String> {
    let arguments: Vec<_> = arguments.skip(1).map(|a| a.to_string_lossy().into_owned()).collect();
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
    Some(format!("the value of '{option}' stands after an equals sign: '{option}={value}'"))
}
