//! `tercio bench` through its JSON output.

mod common;

use common::Place;
use serde_json::Value;

fn bench(place: &Place, arguments: &str) -> Value {
    let outcome =
        place.run(&format!("bench model.off --size 64x48 --json --quiet {arguments}")).ok_silently();
    serde_json::from_str(outcome.text()).expect("JSON")
}

fn pixels(report: &Value) -> Vec<u64> {
    let views = report["views"].as_array().expect("views");
    views.iter().map(|view| view["pixels"].as_u64().expect("a number")).collect()
}

#[test]
fn the_camera_moves_round_the_model() {
    let report = bench(&Place::new(), "--frames 4");
    let eye = |view: usize, k: usize| report["views"][view]["camera"]["eye"][k].as_f64().expect("a number");
    assert_eq!((eye(0, 0), eye(0, 2)), (0.0, 4.4));
    assert!((eye(1, 0) - 4.4).abs() < 1e-9 && eye(1, 2).abs() < 1e-9);
    assert_eq!(eye(0, 1), eye(1, 1));
    assert_eq!(pixels(&report).len(), 4);
    assert!(pixels(&report).iter().all(|&pixels| pixels > 100));
    assert!(report["median_ms"].as_f64() > Some(0.0));
    assert!(report["core_bytes_per_triangle"].as_f64() > Some(0.0));
}

#[test]
fn a_fixed_camera_sees_the_same_every_time() {
    let place = Place::new();
    let near = pixels(&bench(&place, "--frames 3 --eye 0,0,5 --fov 40"));
    assert_eq!(near, [near[0]; 3]);
    let far = pixels(&bench(&place, "--frames 1 --eye 0,0,50 --fov 40"))[0];
    assert!(far > 0 && far < near[0] / 50, "{far} {near:?}");
    let inside = pixels(&bench(&place, "--frames 1 --eye 0,0,0 --target 0,0.1,-1"))[0];
    assert_eq!(inside, 64 * 48);
    place.run("bench model.off --fov 40").failed(2, &["--eye"]);
    place.run("bench model.off --target 1,2,3").failed(2, &["--eye"]);
}

#[test]
fn copies_are_drawn_and_reported() {
    let place = Place::new();
    let one = bench(&place, "--frames 1");
    assert_eq!(one["copies"], serde_json::json!([[0.0, 0.0, 0.0]]));
    let eight = bench(&place, "--frames 1 --copies 8");
    assert_eq!(eight["copies"].as_array().map(Vec::len), Some(8));
    assert_eq!(eight["triangles"], 64);
    // The camera is farther away, to see them all.
    assert!(eight["views"][0]["camera"]["eye"][2].as_f64() > one["views"][0]["camera"]["eye"][2].as_f64());
    place.run("bench model.off --copies 0").failed(2, &["--copies"]);
}
