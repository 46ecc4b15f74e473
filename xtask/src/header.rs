//! `cargo xtask header`: the header of the C interface, made of the functions of tercio-capi.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use tercio_testkit::workspace_root;

/// The files with functions and types, in the order of the header.
const SOURCES: [&str; 7] = ["arrays", "error", "threads", "session", "parts", "camera", "picture"];

const TOP: &str = "\
/*
 * tercio: draws polygon models without a GPU; here, what a program computes, while it computes it.
 *
 * Functions return 0, or another number if they failed; tercio_last_error has the reason then. Those that are called collective have
 * to be called by all processes of a session, in the same order and with the same values, except for arrays; the others have to be
 * called with the same values by all processes before the next collective one.
 *
 * Made by `cargo xtask header`. docs/in-situ.md explains how to use it.
 */";

/// Writes the header.
///
/// # Errors
/// The source cannot be parsed, or the file not be written.
pub fn run() -> Result<()> {
    let path = path();
    std::fs::write(&path, make()?).with_context(|| format!("writing {}", path.display()))?;
    println!("{}", path.display());
    Ok(())
}

/// Where the header is.
pub fn path() -> PathBuf {
    workspace_root().join("crates/tercio-capi/include/tercio.h")
}

fn make() -> Result<String> {
    let config = cbindgen::Config {
        language: cbindgen::Language::C,
        header: Some(TOP.into()),
        include_guard: Some("TERCIO_H".into()),
        cpp_compat: true,
        no_includes: true,
        sys_includes: vec!["stddef.h".into(), "stdint.h".into()],
        usize_is_size_t: true,
        documentation_style: cbindgen::DocumentationStyle::Doxy,
        line_length: 130,
        ..cbindgen::Config::default()
    };
    let folder = workspace_root().join("crates/tercio-capi/src");
    let sources = SOURCES.iter().map(|name| folder.join(name).with_extension("rs"));
    let builder = sources.fold(cbindgen::Builder::new().with_config(config), cbindgen::Builder::with_src);
    let mut bytes = Vec::new();
    builder.generate().context("reading the functions of tercio-capi")?.write(&mut bytes);
    Ok(for_c(&String::from_utf8(bytes)?))
}

/// The text without what documentation has for Rust: the sections about `unsafe`, and links.
fn for_c(text: &str) -> String {
    let mut out: Vec<String> = Vec::new();
    let mut is_about_safety = false;
    for line in text.lines() {
        is_about_safety |= line.trim() == "* # Safety";
        if line.trim() == "*/" && is_about_safety {
            is_about_safety = false;
            while out.last().is_some_and(|last| last.trim() == "*") {
                out.pop();
            }
        }
        if !is_about_safety {
            out.push(line.replace("[`", "").replace("`]", "").replace('`', ""));
        }
    }
    out.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_is_that_of_the_functions() {
        let found = std::fs::read_to_string(path()).expect("the header is there");
        let expected = make().expect("the source is valid");
        let line = found.lines().zip(expected.lines()).position(|(found, expected)| found != expected);
        let line = line.unwrap_or_else(|| found.lines().count().min(expected.lines().count())) + 1;
        assert!(
            found == expected,
            "tercio.h differs from line {line} on: 'cargo xtask header' makes it again"
        );
    }

    #[test]
    fn every_function_is_in_the_header() {
        let header = make().expect("the source is valid");
        let mut count = 0;
        for entry in std::fs::read_dir(workspace_root().join("crates/tercio-capi/src")).expect("the source") {
            let source = std::fs::read_to_string(entry.expect("a file").path()).expect("text");
            for rest in source.split("extern \"C\" fn ").skip(1) {
                let name = rest.split('(').next().expect("a name");
                assert!(header.contains(&format!("{name}(")), "{name}");
                count += 1;
            }
        }
        assert!(count > 20, "{count}");
        assert!(!header.contains("Safety") && !header.contains("[tercio"), "what is for Rust");
    }
}
