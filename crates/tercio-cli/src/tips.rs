//! Tips for wrong usage that the parser of arguments has none for.

use std::ffi::OsString;

use clap::Command;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};

/// Adds to an error about a surplus argument that an option takes its value after `=`, if one stands before what looks
/// like its value: `--ao 0.5` is `--ao` without a value, and one more model.
pub fn add(error: &mut Error, program: &Command, arguments: impl Iterator<Item = OsString>) {
    if error.kind() != ErrorKind::UnknownArgument || error.get(ContextKind::Suggested).is_some() {
        return;
    }
    let Some(ContextValue::String(surplus)) = error.get(ContextKind::InvalidArg) else {
        return;
    };
    let arguments: Vec<_> = arguments.skip(1).map(|a| a.to_string_lossy().into_owned()).collect();
    let Some(command) = arguments.first().and_then(|name| program.find_subcommand(name)) else {
        return;
    };
    let takes_equals = |argument: &str| {
        let name = argument.strip_prefix("--");
        name.is_some_and(|name| {
            command.get_arguments().any(|a| a.is_require_equals_set() && a.get_long() == Some(name))
        })
    };
    // Before a model's name, the value was read as that name, and the name is the surplus argument.
    let is_value = |value: &str| value == surplus || value.starts_with('#') || value.parse::<f64>().is_ok();
    let mut pairs = arguments.windows(2);
    if let Some([option, value]) = pairs.find(|pair| takes_equals(&pair[0]) && is_value(&pair[1])) {
        let tip = format!("the value of '{option}' stands after an equals sign: '{option}={value}'");
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
}
