//! Prints facts of models, to be compared with those of other programs: a line of JSON for each file, with triangles,
//! area, bounds, line segments, points, and the mean of every attribute over the vertices that triangles use, or over
//! the triangles.

use serde_json::{Map, json};
use tercio_mesh::io::{ReadOptions, read};
use tercio_mesh::{Attribute, AttributeDomain};

fn main() {
    for file in std::env::args().skip(1) {
        let model = match read(&file, &ReadOptions::default()) {
            Ok(model) => model,
            Err(error) => {
                println!("{}", json!({ "file": file, "error": error.to_string() }));
                continue;
            }
        };
        let mesh = &model.mesh;
        let mut used = mesh.triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let point = |v: u32| mesh.origin + glam::Vec3::from(mesh.positions[v as usize]).as_dvec3();
        let area: f64 = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(point);
                (b - a).cross(c - a).length() / 2.0
            })
            .sum();
        let (mut low, mut high) = (glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY);
        used.iter().for_each(|&v| (low, high) = (low.min(point(v)), high.max(point(v))));
        let (mut vertices, mut triangles) = (Map::new(), Map::new());
        for attribute in mesh.attributes.iter().filter(|a| !Attribute::is_polygon(&a.name, a.domain)) {
            let value = |&v: &u32| f64::from(attribute.values[v as usize]);
            let (to, sum, count) = match attribute.domain {
                AttributeDomain::Vertex => (&mut vertices, used.iter().map(value).sum::<f64>(), used.len()),
                AttributeDomain::Triangle => {
                    let sum = attribute.values.iter().map(|&v| f64::from(v)).sum();
                    (&mut triangles, sum, mesh.triangles.len())
                }
            };
            to.insert(attribute.name.clone(), json!(sum / count as f64));
        }
        let bounds = (!used.is_empty()).then(|| [low.to_array(), high.to_array()].concat());
        println!(
            "{}",
            json!({
                "file": file, "format": model.report.format, "warnings": model.report.warnings,
                "triangles": mesh.triangles.len(), "area": area, "bounds": bounds,
                "segments": model.strokes.segments.len(), "dots": model.strokes.points.len(),
                "cells": model.report.faces, "pd": vertices, "cd": triangles,
            })
        );
    }
}
