//! Pictures that are drawn in bands because of their size.

mod common;

use std::io::Read as _;
use std::process::Stdio;

use common::Place;

/// One pixel row more than the largest picture that is kept in memory.
const SIZE: &str = "--size 65536x1025 --aa 1 --threads 2";

#[test]
fn a_picture_in_bands() {
    let place = Place::new();
    let stats = |name: &str| -> serde_json::Value {
        let arguments = format!("render model.off -o {name} --stats s.json --memory-limit 1G {SIZE}");
        place.run(&arguments).ok_silently();
        serde_json::from_slice(&place.read("s.json")).expect("JSON")
    };
    let (bands, whole) = (stats("a.png"), stats("a.ppm"));
    for counts in ["/frame/frontend", "/frame/backend/pixels_visible", "/picture"] {
        assert_eq!(bands.pointer(counts), whole.pointer(counts), "{counts}");
    }
    place.run("compare a.png a.ppm --threshold 0").ok_silently();

    // The same file from ranks, which keep the picture in memory.
    place.run(&format!("render model.off -o b.png --ranks 2 --organisation sort-first {SIZE}")).ok_silently();
    assert!(place.read("a.png") == place.read("b.png"));
}

#[test]
fn nothing_in_any_band() {
    let place = Place::new();
    let behind = "--eye 0,0,100 --target 0,0,200";
    let outcome = place.run(&format!("render builtin:teapot@1k -o a.png {behind} {SIZE}"));
    outcome.failed(1, &["nothing was drawn: all 992 triangles are behind the camera"]);
    assert!(!place.names().contains(&"a.png".to_owned()));
    place.run(&format!("render builtin:teapot@1k -o a.png --allow-empty {behind} {SIZE}"));
    assert!(place.names().contains(&"a.png".to_owned()));
}

#[test]
fn a_reader_that_has_enough_is_no_error() {
    let place = Place::new();
    let arguments = format!("render model.off -o - --stats s.json --quiet {SIZE}");
    let mut child = place.command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdout = child.stdout.take().unwrap();
    stdout.read_exact(&mut [0; 8]).unwrap();
    drop(stdout);
    let outcome = child.wait_with_output().unwrap();
    assert_eq!((outcome.status.code(), String::from_utf8(outcome.stderr).as_deref()), (Some(0), Ok("")));
    let stats: serde_json::Value = serde_json::from_slice(&place.read("s.json")).expect("JSON");
    assert!(stats["frame"]["backend"]["pixels_visible"].as_u64() > Some(100_000), "{stats:#}");
}
