//! The reference of all commands and options as Markdown, made from their definition.

use std::fmt::Write as _;

use clap::{Arg, ArgAction, Command};

/// The page. Precondition: the program is [built](Command::build).
pub fn page(program: &Command) -> String {
    let mut page = "# Options\n\nMade by `cargo xtask options` from the definition of the options, which is also that of `--help`, of \
        `tercio man` and of `tercio completions`.\n"
        .to_owned();
    let mut all = Vec::new();
    collect(program, "tercio", &mut all);
    page += "\n| command | |\n|---|---|\n";
    for (name, command) in &all {
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        let _ = writeln!(page, "| [`{name}`](#{}) | {} |", name.replace(' ', "-"), cell(&about));
    }
    for (name, command) in &all {
        describe(name, command, &mut page);
    }
    page
}

/// A command and its own commands, with their names.
fn collect<'a>(command: &'a Command, name: &str, all: &mut Vec<(String, &'a Command)>) {
    all.push((name.to_owned(), command));
    let is_listed = |command: &&Command| !command.is_hide_set() && command.get_name() != "help";
    for own in command.get_subcommands().filter(is_listed) {
        collect(own, &format!("{name} {}", own.get_name()), all);
    }
}

fn describe(name: &str, command: &Command, page: &mut String) {
    let _ = write!(page, "\n## {name}\n");
    let about = command.get_long_about().or(command.get_about());
    if let Some(about) = about {
        let _ = write!(page, "\n{}\n", text(&about.to_string()));
    }
    let usage = command.clone().render_usage().to_string();
    let _ = write!(page, "\n    {}\n", usage.trim_start_matches("Usage: ").replace('\n', "\n    "));
    // In the order in which their first option is defined, as in --help.
    let mut headings: Vec<Option<&str>> = Vec::new();
    let arguments: Vec<&Arg> = command.get_arguments().filter(|a| !a.is_hide_set()).collect();
    for argument in &arguments {
        if !headings.contains(&argument.get_help_heading()) {
            headings.push(argument.get_help_heading());
        }
    }
    for heading in headings {
        if let Some(heading) = heading {
            let _ = write!(page, "\n### {heading}\n");
        }
        page.push('\n');
        arguments.iter().filter(|a| a.get_help_heading() == heading).for_each(|a| option(a, page));
    }
    let after = command.get_after_long_help().or(command.get_after_help());
    if let Some(after) = after.map(ToString::to_string).filter(|after| !after.trim().is_empty()) {
        let _ = write!(page, "\n```text\n{}\n```\n", after.trim());
    }
}

/// An item of a list.
fn option(argument: &Arg, page: &mut String) {
    let values: Vec<&str> =
        argument.get_value_names().unwrap_or_default().iter().map(|v| v.as_str()).collect();
    let takes_value = matches!(argument.get_action(), ArgAction::Set | ArgAction::Append);
    let value = if takes_value {
        values.iter().map(|v| format!("<{v}>")).collect::<Vec<_>>().join(" ")
    } else {
        String::new()
    };
    let is_optional = argument.get_num_args().is_some_and(|range| range.min_values() == 0);
    let long = argument.get_long().map(|long| match (value.as_str(), is_optional && takes_value) {
        ("", _) => format!("--{long}"),
        (value, true) => format!("--{long}[={value}]"),
        (value, false) => format!("--{long} {value}"),
    });
    let short = argument.get_short().map(|short| format!("-{short}"));
    let names: Vec<String> = short.into_iter().chain(long).collect();
    let names = if names.is_empty() { value } else { names.join("`, `") };
    let help = argument.get_long_help().or(argument.get_help()).map(ToString::to_string).unwrap_or_default();
    let help = text(&help).replace('\n', "\n  ").replace("  \n", "\n");
    let _ = write!(page, "- **`{names}`**  \n  {help}");
    let default: Vec<_> = argument.get_default_values().iter().map(|v| v.to_string_lossy()).collect();
    if takes_value && !default.is_empty() && !argument.is_hide_default_value_set() {
        let _ = write!(page, " [default: `{}`]", default.join(" "));
    }
    let aliases = argument.get_visible_aliases().unwrap_or_default();
    if !aliases.is_empty() {
        let aliases: Vec<String> = aliases.iter().map(|alias| format!("`--{alias}`")).collect();
        let _ = write!(page, " [also {}]", aliases.join(", "));
    }
    page.push('\n');
    let possible = argument.get_possible_values();
    if takes_value && !argument.is_hide_possible_values_set() {
        for value in possible.iter().filter(|value| !value.is_hide_set()) {
            let help =
                value.get_help().map(|help| format!(": {}", text(&help.to_string()))).unwrap_or_default();
            let _ = writeln!(page, "  - `{}`{help}", value.get_name());
        }
    }
}

/// Help as Markdown: what would be a tag or emphasis is written as it is, and lines that are indented are kept as they are.
fn text(help: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    let mut is_fenced = false;
    for line in help.trim_end().lines() {
        let is_indented = line.starts_with("  ");
        if is_indented != is_fenced {
            lines.push(if is_indented { "```text" } else { "```" }.into());
            is_fenced = is_indented;
        }
        let escaped = || line.replace('<', "\\<").replace('*', "\\*").replace('_', "\\_");
        lines.push(if is_indented { line.into() } else { escaped() });
    }
    if is_fenced {
        lines.push("```".into());
    }
    lines.join("\n")
}

/// The same for a cell of a table.
fn cell(help: &str) -> String {
    text(help).replace('\n', " ").replace('|', "\\|")
}
