//! The commands and statements of the README hold.

mod common;

use common::Place;

fn readme() -> String {
    std::fs::read_to_string(tercio_testkit::workspace_root().join("README.md")).expect("the README")
}

#[test]
fn the_picture_of_the_readme_is_what_its_command_draws() {
    let readme = readme();
    let command =
        readme.lines().find_map(|line| line.strip_prefix("cargo run --release -- ")).expect("a command");
    let name = command.split_whitespace().last().expect("a file name");
    assert!(readme.contains(&format!("(docs/images/{name})")), "the README shows no {name}");
    let place = Place::new();
    place.run(command).ok_silently();
    let shown = std::fs::read(tercio_testkit::workspace_root().join("docs/images").join(name)).unwrap();
    assert!(
        place.read(name) == shown,
        "docs/images/{name} is not what '{command}' draws: cargo xtask figures"
    );
}

#[test]
fn the_readme_says_how_to_install() {
    let readme = readme();
    for part in ["cargo install --path crates/tercio-cli", "cargo xtask dist", "target/release/tercio"] {
        assert!(readme.contains(part), "{part}");
    }
}
