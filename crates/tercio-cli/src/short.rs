//! What makes a command line short: the command that need not be named, and the short help.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::Command;

use crate::commands::render::EXAMPLES;

/// The options of `render` that its short help lists; --help lists all.
const RENDER: [&str; 17] = [
    "model",
    "more",
    "output",
    "size",
    "view",
    "azimuth",
    "elevation",
    "zoom",
    "up_axis",
    "eye",
    "turntable",
    "camera_path",
    "shading",
    "color",
    "opacity",
    "background",
    "verbose",
];

/// The definition with a short help that fits a screen.
pub fn with_short_help(program: Command) -> Command {
    let program = program.mut_subcommand("sheet", |sheet| {
        let sheet = sheet.mut_args(|argument| {
            let id = argument.get_id().as_str();
            let is_listed = RENDER.contains(&id) || ["columns", "caption"].contains(&id);
            let argument = argument.hide_short_help(!is_listed);
            // Small pictures, on paper.
            match argument.get_id().as_str() {
                "size" => argument.default_value("256x256"),
                "background" => argument.default_value("#ffffff"),
                "more" => argument.help("More models"),
                "output" => {
                    let help = "The sheet (.png, .jpg, .webp, .ppm), or `-` for standard output";
                    argument.help(help).long_help(help)
                }
                _ => argument,
            }
        });
        let about = "Draws many models, or many views of one, into one picture: a contact sheet";
        let more = "--help lists all options, which are those of render, and has examples.";
        sheet.about(about).long_about(about).after_help(more).after_long_help(EXAMPLES)
    });
    program.mut_subcommand("render", |render| {
        let render = render.mut_args(|argument| {
            let is_listed = RENDER.contains(&argument.get_id().as_str());
            argument.hide_short_help(!is_listed)
        });
        // Examples are part of the long help.
        let examples = render.get_after_help().cloned().unwrap_or_default();
        let more = "--help lists all options: series and films, several models and scene files, light, effects, data, annotation, clipping, outputs, ranks, tuning.";
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
        let mut program = crate::definition().max_term_width(100);
        program.build();
        let render = program.find_subcommand_mut("render").unwrap();
        let short = render.render_help().to_string();
        assert!(short.lines().count() <= 60, "{} lines:\n{short}", short.lines().count());
        let long = render.render_long_help().to_string();
        for option in ["--tile-size", "--organisation", "--turntable", "--ao", "Examples:"] {
            assert!(
                long.contains(option) && (option == "--turntable" || !short.contains(option)),
                "{option}"
            );
        }
        for id in RENDER {
            assert!(render.get_arguments().any(|a| a.get_id() == id), "{id}");
        }
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
