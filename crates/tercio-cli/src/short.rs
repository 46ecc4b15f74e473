//! What makes a command line short: the command that need not be named, and the short help.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::{Arg, Command};

use crate::commands::render::EXAMPLES;

/// The options of `render` that its short help lists, each in a few words; --help lists all, and says all of them.
const RENDER: [(&str, &str); 13] = [
    ("model", "A file, `-` for standard input, or builtin:NAME@COUNT"),
    ("more", "More models: a picture each, or the steps of a series"),
    ("output", "Picture (.png, .jpg, .webp, .ppm), drawing (.svg, .pdf), film (.gif, .webp, .mp4)"),
    ("size", "Width and height in pixels"),
    ("view", "Where the camera is"),
    ("azimuth", "Degrees round the up axis [default: 15]"),
    ("elevation", "Degrees above the horizon [default: 18]"),
    ("turntable", "N pictures of a full turn, as a film or a series"),
    ("color", "Colour of a model that has none of its own"),
    ("opacity", "Opacity of the model, 0 to 1"),
    ("background", "A colour, two for a gradient, or transparent"),
    ("color_by", "Colours by an attribute; tercio info lists them"),
    ("mode", "What is drawn"),
];

/// Those of `sheet`.
const SHEET: [(&str, &str); 2] = [
    ("columns", "Number of columns"),
    ("caption", "What is written below each picture, as {name} or {view}"),
];

/// Groups of options that are only in the long help of the commands beside `render` and `sheet`.
const LONG_GROUPS: [&str; 7] = [
    "Running",
    "Textures",
    "Anti-aliasing",
    "Tuning (the picture stays the same)",
    "Ranks (the picture stays the same)",
    "Camera",
    "Random polygons",
];

/// Commands whose short help would not fit, each with single options that are only in its long help.
const LONG: [(&str, &[&str]); 9] = [
    ("bench", &["toss"]),
    ("predict", &["tile_size", "sorting", "share_processors", "region", "blocks", "simulate"]),
    ("advise", &["tile_size", "sorting"]),
    ("validate", &["sorting", "clock"]),
    ("workload", &[]),
    ("calibrate", &[]),
    ("ring", &[]),
    ("sorting", &["region", "assignment", "unbatched"]),
    ("hybris", &[]),
];

/// The command, and all that are part of it, with a short help that fits a screen; the long one has everything.
fn shortened(command: Command) -> Command {
    let command = command.mut_subcommands(shortened);
    let Some((_, rest)) = LONG.iter().find(|(name, _)| *name == command.get_name()) else { return command };
    let command = command.mut_args(|argument| {
        let of_group = argument.get_help_heading().is_some_and(|heading| LONG_GROUPS.contains(&heading));
        if argument.get_id() == "model" {
            return in_short_help(argument, &RENDER);
        }
        let is_left_out = of_group || rest.iter().any(|id| argument.get_id() == id);
        if is_left_out { argument.hide_short_help(true) } else { argument }
    });
    let remarks = command.get_after_help().cloned().unwrap_or_default();
    command.after_help("--help lists all options; it has examples.").after_long_help(remarks)
}

/// An option in the short help, if it is `listed` there.
fn in_short_help(argument: Arg, listed: &[(&str, &'static str)]) -> Arg {
    let text = listed.iter().find(|(id, _)| argument.get_id() == id).map(|(_, text)| *text);
    match (text, argument.get_long_help().or(argument.get_help()).cloned()) {
        (Some(text), Some(long)) => argument.help(text).long_help(long),
        _ => argument.hide_short_help(text.is_none()),
    }
}

/// An option whose value may be below 0, so that the error is about the value, and not about an option `-3`.
fn taking_numbers(argument: Arg) -> Arg {
    let takes_one = argument.get_long().is_some() && argument.get_action().takes_values();
    if takes_one && !argument.is_require_equals_set() {
        argument.allow_negative_numbers(true)
    } else {
        argument
    }
}

/// The definition with a short help that fits a screen.
pub fn with_short_help(program: Command) -> Command {
    let program = program.mut_subcommand("sheet", |sheet| {
        let sheet = sheet.mut_args(|argument| {
            let is_of_render = RENDER.iter().any(|(id, _)| argument.get_id() == id);
            let argument =
                in_short_help(taking_numbers(argument), if is_of_render { &RENDER } else { &SHEET });
            // Small pictures, on paper.
            match argument.get_id().as_str() {
                "size" => argument.default_value("256x256"),
                "background" => argument.default_value("#ffffff"),
                "more" => argument.help("More models").long_help("More models"),
                // They do not fit beside those of sheets.
                "turntable" | "opacity" => argument.hide_short_help(true),
                "output" => {
                    let help = "The sheet (.png, .jpg, .webp, .ppm), or `-` for standard output";
                    argument.help(help).long_help(help)
                }
                _ => argument,
            }
        });
        let about = "Draws many models, or many views of one, into one picture: a contact sheet";
        let more = "--help lists all options: those of render, too; it has examples.";
        sheet.about(about).long_about(about).after_help(more).after_long_help(EXAMPLES)
    });
    let program = program.mut_subcommands(shortened);
    program.mut_subcommand("render", |render| {
        let render = render.mut_args(|argument| in_short_help(taking_numbers(argument), &RENDER));
        // Examples are part of the long help.
        let examples = render.get_after_help().cloned().unwrap_or_default();
        let more = "--help lists all options: light, data, lines, annotation, clipping, series and films, several models, ranks, tuning; it has examples.";
        render.after_help(more).after_long_help(examples)
    })
}

/// The arguments, with the word `render` where it was left out: `tercio MODEL -o PICTURE`.
pub fn with_command(program: &Command, arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = arguments.collect();
    if arguments.get(1).is_some_and(|first| means_render(program, first)) {
        arguments.insert(1, "render".into());
    }
    arguments
}

fn means_render(program: &Command, first: &OsStr) -> bool {
    let text = first.to_string_lossy();
    if program.find_subcommand(first).is_some()
        || ["help", "-h", "--help", "-V", "--version"].contains(&&*text)
    {
        return false;
    }
    // A mistyped command has none of these, and the parser has a tip for it.
    text.starts_with('-')
        || text.starts_with("builtin:")
        || text.contains(['.', '/', '\\', '*'])
        || Path::new(first).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_word_render_may_be_left_out() {
        let program = crate::definition();
        let means = |first: &str| means_render(&program, first.as_ref());
        assert!(["a.ply", "builtin:teapot@1M", "-o", "-", "../a", "*.stl"].into_iter().all(means));
        assert!(!["render", "info", "rendr", "help", "--help", "-V", "bench"].into_iter().any(means));
    }

    #[test]
    fn the_short_help_fits_a_screen_and_the_long_one_has_everything() {
        let mut program = crate::definition().term_width(80);
        program.build();
        let mut seen = Vec::new();
        check_short_help(&mut program, &mut seen);
        assert_eq!(seen.len(), LONG.len(), "{seen:?}");
        let render = program.find_subcommand_mut("render").unwrap();
        let short = render.render_help().to_string();
        let long = render.render_long_help().to_string();
        for option in ["--tile-size", "--organisation", "--turntable", "--ao", "Examples:"] {
            assert!(
                long.contains(option) && (option == "--turntable" || !short.contains(option)),
                "{option}"
            );
        }
        for (id, _) in RENDER {
            assert!(render.get_arguments().any(|a| a.get_id() == id), "{id}");
        }
        let sheet = program.find_subcommand("sheet").unwrap();
        assert!(SHEET.iter().all(|(id, _)| sheet.get_arguments().any(|a| a.get_id() == id)));
    }

    /// The short help of a command and of all its commands fits; each option of their short help is in the long one, which ends with
    /// what a short one leaves out.
    fn check_short_help(command: &mut Command, seen: &mut Vec<String>) {
        let name = command.get_name().to_owned();
        let (short, long) = (command.render_help().to_string(), command.render_long_help().to_string());
        assert!(short.lines().count() <= 40, "{name}: {} lines:\n{short}", short.lines().count());
        assert!(short.lines().all(|line| line.chars().count() <= 80), "{name}: {short}");
        assert!(
            long.contains("Exit code: ") || name == "help" || command.has_subcommands(),
            "{name}: {long}"
        );
        if let Some((_, rest)) = LONG.iter().find(|(long, _)| *long == name) {
            assert!(
                rest.iter().all(|id| command.get_arguments().any(|a| a.get_id() == id)),
                "{name}: {rest:?}"
            );
            assert!(!short.contains("--memory-limit") && !short.contains("--tile-size"), "{name}: {short}");
            assert!(long.contains("Examples:"), "{name}: {long}");
            seen.push(name);
        }
        command
            .get_subcommands_mut()
            .filter(|c| c.get_name() != "help")
            .for_each(|c| check_short_help(c, seen));
    }

    /// What follows "tercio" in the examples of a command and its own commands; without pipes, redirections and remarks.
    fn examples(command: &Command) -> Vec<String> {
        let help = command.get_after_long_help().or(command.get_after_help());
        let help = help.map(ToString::to_string).unwrap_or_default();
        let lines = help.lines().filter_map(|line| line.strip_prefix("  tercio "));
        let until = |line: &str, end: &str| line.split(end).next().unwrap_or_default().to_string();
        let own = lines.map(|line| until(&until(&until(line, "   ("), " | "), " > "));
        own.chain(command.get_subcommands().flat_map(examples)).collect()
    }

    #[test]
    fn all_examples_can_be_typed() {
        let program = crate::definition();
        let all = examples(&program);
        assert!(all.len() > 40, "{all:?}");
        for example in all {
            // Every second piece between quotes is one word.
            let mut words = vec!["tercio".into()];
            for (number, piece) in example.split('\'').enumerate() {
                let quoted = number % 2 == 1;
                let of_piece = if quoted { vec![piece] } else { piece.split_whitespace().collect() };
                words.extend(of_piece.into_iter().map(OsString::from));
            }
            let words = with_command(&program, words.into_iter());
            let parsed = program.clone().try_get_matches_from(&words);
            assert!(parsed.is_ok(), "{example}: {}", parsed.err().map(|e| e.to_string()).unwrap_or_default());
        }
    }

    #[test]
    fn the_definition_is_consistent() {
        crate::definition().debug_assert();
    }
}
