//! `tercio info` from the outside.

mod common;

use common::{OCTAHEDRON, Place};

#[test]
fn a_model_is_described_for_people() {
    let place = Place::new();
    let said = place.run("info model.off").quietly_well();
    for part in ["model.off", "OFF", "triangles", "vertices", "closed", "consistently wound", "times"] {
        assert!(said.text().contains(part), "{part} is not in {}", said.text());
    }
    // Values stand below each other.
    let columns: Vec<_> = said
        .text()
        .lines()
        .map(|l| l.find("  ").map(|at| at + l[at..].len() - l[at..].trim_start().len()))
        .collect();
    assert!(columns.iter().all(|c| *c == columns[0]), "{}", said.text());
}

#[test]
fn a_model_is_described_for_programs() {
    let place = Place::new();
    for said in
        [place.run("info model.off --json"), place.run_with_input("info - --json", OCTAHEDRON.as_bytes())]
    {
        let said = said.quietly_well();
        let info: serde_json::Value = serde_json::from_str(said.text()).unwrap();
        assert_eq!((&info["triangles"], &info["vertices"]), (&8.into(), &6.into()));
        assert_eq!(info["bounds"]["max"], serde_json::json!([1.0, 1.0, 1.0]));
        assert_eq!((&info["topology"]["closed"], &info["topology"]["components"]), (&true.into(), &1.into()));
        assert_eq!((&info["normals"], &info["vertex_colors"]), (&"none".into(), &false.into()));
        for key in
            ["attributes", "materials", "warnings", "repaired", "memory_bytes", "milliseconds", "format"]
        {
            assert!(!info[key].is_null(), "{key}");
        }
    }
}

#[test]
fn a_missing_model_is_an_error() {
    Place::new().run("info missing.ply").failed(1, &["missing.ply: "]);
}
