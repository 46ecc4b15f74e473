//! Messages on standard error, each written at once: a line, but for wrong usage.

use std::borrow::Cow;
use std::io;

use anstream::adapter::strip_str;
use anstream::{AutoStream, ColorChoice};
use anstyle::{AnsiColor, Style};
use anyhow::Error;
use tercio::LoadError;
use tercio::mesh::ReadError;
use tercio_mpi::write_line;

use crate::memory;

/// The style of clap's usage errors.
const ERROR: Style = AnsiColor::Red.on_default().bold();
const WARNING: Style = AnsiColor::Yellow.on_default().bold();

/// `error: ...`
pub fn error(error: &Error) {
    say(ERROR, "error", &text(error));
}

/// `error: ...` of wrong usage, with what else the parser says of it.
pub fn usage_error(error: &Error) {
    let text = format!("{}\n\nFor more information, try '--help'.", line(ERROR, "error", &text(error)));
    write_line(&text);
}

/// The parser's message, in one piece: it prints in several, between which mpirun or another process may print.
pub fn answer(answer: &clap::Error) {
    write_line(for_this_run(&answer.render().ansi().to_string()).trim_end_matches('\n'));
}

/// An error with every cause that the text does not already contain.
pub fn text(error: &Error) -> String {
    error.chain().fold(String::new(), |text, cause| match words(cause) {
        cause if text.is_empty() => cause,
        cause if text.ends_with(&cause) => text,
        cause => format!("{text}: {cause}"),
    })
}

/// The text of a cause. The library does not know who set its limit; the message adds it.
fn words(cause: &(dyn std::error::Error + 'static)) -> String {
    let read = match cause.downcast_ref() {
        Some(LoadError::Read(error)) => Some(error),
        _ => cause.downcast_ref(),
    };
    match read {
        Some(ReadError::MemoryLimit { file, what, needed, limit }) => {
            let source = memory::limit_source();
            format!("{file}: needs {needed} bytes for {what}, the limit is {limit} bytes ({source})")
        }
        _ => cause.to_string(),
    }
}

/// The prefix of errors on the standard error of this run, for code that must not allocate.
pub fn error_prefix() -> String {
    let coloured = cfg!(unix) && AutoStream::choice(&io::stderr()) != ColorChoice::Never;
    let style = if coloured { ERROR } else { Style::new() };
    format!("{style}error:{style:#} ")
}

/// `warning: ...`
pub fn warning(text: &str) {
    say(WARNING, "warning", text);
}

/// A line for `-v`.
pub fn note(text: &str) {
    write_line(text);
}

fn say(style: Style, kind: &str, text: &str) {
    write_line(&line(style, kind, text));
}

fn line(style: Style, kind: &str, text: &str) -> String {
    // File names may contain line breaks, but a message is one line.
    let text: Vec<_> = text.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
    for_this_run(&format!("{style}{kind}:{style:#} {}", text.join(" "))).into_owned()
}

/// Coloured like usage errors: on terminals with colours, unless NO_COLOR is set; everywhere if CLICOLOR_FORCE is.
fn for_this_run(text: &str) -> Cow<'_, str> {
    match AutoStream::choice(&io::stderr()) {
        ColorChoice::Never => strip_str(text).to_string().into(),
        _ => text.into(),
    }
}
