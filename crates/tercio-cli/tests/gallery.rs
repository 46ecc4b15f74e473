//! The gallery of the documentation shows what the program draws.

use std::path::Path;

use tercio_testkit::gallery;

#[test]
fn every_picture_of_the_gallery_is_drawn_by_its_command() {
    let entries = gallery::entries();
    let drawn = tempfile::tempdir().unwrap();
    gallery::draw(&entries, Path::new(env!("CARGO_BIN_EXE_tercio")), drawn.path()).unwrap();
    let changed = gallery::changed(drawn.path(), &gallery::folder()).unwrap();
    assert!(changed.is_empty(), "changed: {}; cargo xtask gallery draws them again", changed.join(", "));
}
