//! The first program of the README is the one that the library's page begins with, where it is compiled and run.

use std::path::Path;

/// The lines of the first Rust code block, as the reader sees them.
fn program<'a>(lines: impl Iterator<Item = &'a str>, fence: &str) -> Vec<&'a str> {
    let block = lines.skip_while(|line| *line != fence).skip(1).take_while(|line| *line != "```");
    block.filter(|line| !line.starts_with("# ")).collect()
}

#[test]
fn the_readme_shows_the_program_of_the_librarys_page_and_it_fits_eight_lines() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = std::fs::read_to_string(folder.join("../../README.md")).expect("the README");
    let page = include_str!("../src/lib.rs").lines();
    let page =
        page.map_while(|line| line.strip_prefix("//!")).map(|line| line.strip_prefix(' ').unwrap_or(line));
    let program_of_page = program(page, "```");
    assert!((1..=8).contains(&program_of_page.len()), "{program_of_page:#?}");
    assert_eq!(program(readme.lines(), "```rust"), program_of_page);
}
