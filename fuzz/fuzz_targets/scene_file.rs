//! Scene files and configurations: what is read is the same after it was written.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tercio::scene_file::{Configuration, SceneFile};

fuzz_target!(|bytes: &[u8]| {
    let _ = Configuration::read(bytes);
    let Ok(scene) = SceneFile::read(bytes) else { return };
    // Without the lines, which may differ.
    let text = scene.to_toml();
    let again = SceneFile::read(text.as_bytes()).expect("what was written");
    assert_eq!(again.to_toml(), text);
    assert_eq!(again.models.len(), scene.models.len());
});
