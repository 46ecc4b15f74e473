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

#[test]
fn frames_of_ranks_are_recorded_and_the_last_one_is_counted_by_partner() {
    let place = Place::new();
    for (ranks, count) in [("--ranks 3 --organisation sort-middle", 3), ("", 1)] {
        let report = bench(&place, &format!("--frames 4 --trace t.json {ranks}"));
        let trace: Value = serde_json::from_slice(&place.read("t.json")).expect("JSON");
        let events = trace["traceEvents"].as_array().expect("events");
        let drawn = |rank: u64, frame: u64| {
            let is_it = |event: &&Value| {
                event["name"] == "draw" && event["pid"] == rank && event["args"]["frame"] == frame
            };
            events.iter().filter(is_it).count()
        };
        // With the first frame, which is not measured.
        for (rank, frame) in (0..count).flat_map(|rank| (1..6).map(move |frame| (rank, frame))) {
            assert_eq!(drawn(rank, frame), 1, "rank {rank}, frame {frame}");
        }
        assert_eq!((drawn(0, 0), drawn(0, 6)), (0, 0));
        let last = &report["last_frame_of_ranks"];
        assert_eq!(last.is_null(), count == 1);
        for (number, rank) in last["ranks"].as_array().into_iter().flatten().enumerate() {
            let sum = |key: &str| -> u64 {
                let partners = rank["partners"].as_array().expect("partners").iter();
                let of_frame = partners.filter(|with| with["kind"] != "barrier");
                of_frame.map(|with| with[key].as_u64().expect("a number")).sum()
            };
            for key in ["sent_messages", "sent_bytes", "taken_messages", "taken_bytes"] {
                assert_eq!(rank["traffic"][key], sum(key), "rank {number}: {key}");
            }
        }
    }
}
