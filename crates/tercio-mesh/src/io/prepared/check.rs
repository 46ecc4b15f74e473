//! Checks that the clusters of a file have the properties that a renderer relies on.

use crate::loops::prelude::*;

use super::format::Kind;
use crate::cluster::{ClusteredMesh, Layout, MAX_TRIANGLES, MAX_VERTICES, check};

/// The wrong part, what was expected in it, what was found.
pub type Wrong = (Kind, String, String);

/// Exponents for which the unit of a mesh is a normal number with room for calculations.
const EXPONENTS: std::ops::RangeInclusive<i32> = -300..=300;

/// Are the arrays as long as the heads say, and are the clusters contiguous?
pub fn sizes(mesh: &ClusteredMesh) -> Result<(), Wrong> {
    let wrong = |kind, expected: String, found: String| Err((kind, expected, found));
    if !mesh.origin.is_finite() || !EXPONENTS.contains(&mesh.exponent) {
        let found = format!("the origin {} and the exponent {}", mesh.origin, mesh.exponent);
        return wrong(Kind::Description, "a finite origin and a usable unit".into(), found);
    }
    let offsets = &mesh.layout.offsets;
    let are_all = offsets.is_empty() || offsets.len() == mesh.layout.attributes.len();
    if !are_all || !offsets.iter().all(|offset| offset.is_finite()) {
        let found = format!("{offsets:?}");
        return wrong(Kind::Description, "a finite offset for each attribute".into(), found);
    }
    let count = mesh.clusters.len();
    if mesh.starts.len() != count + 1 {
        return wrong(Kind::Starts, format!("{} numbers", count + 1), mesh.starts.len().to_string());
    }
    let mut end = 0;
    let mut triangles = 0;
    for (number, head) in mesh.clusters.iter().enumerate() {
        let (vertices, own) = (usize::from(head.vertices), usize::from(head.triangles));
        if !check::has_valid_counts(head) {
            let expected = format!(
                "1 to {MAX_VERTICES} vertices and 1 to {MAX_TRIANGLES} triangles in cluster {number}"
            );
            return wrong(Kind::Heads, expected, format!("{vertices} and {own}"));
        }
        if mesh.starts[number] as usize != end {
            let found = mesh.starts[number].to_string();
            return wrong(Kind::Starts, format!("cluster {number} at line {end}"), found);
        }
        end += mesh.layout.lines(head);
        triangles += own;
    }
    if mesh.starts[count] as usize != end || mesh.lines.len() != end + Layout::LINES_BEHIND {
        let expected = format!("{} lines", end + Layout::LINES_BEHIND);
        return wrong(Kind::Lines, expected, mesh.lines.len().to_string());
    }
    if triangles > crate::mesh::MAX_ELEMENTS as usize {
        let expected = format!("at most {} triangles", crate::mesh::MAX_ELEMENTS);
        return wrong(Kind::Heads, expected, triangles.to_string());
    }
    match &mesh.face_of_triangle {
        Some(faces) if faces.len() != triangles => {
            wrong(Kind::Faces, format!("{triangles} face numbers"), faces.len().to_string())
        }
        _ => Ok(()),
    }
}

/// Does every cluster's memory begin with its head, are the vertices inside the box, do corners and primitives exist? There are
/// this many primitives.
pub fn clusters(mesh: &ClusteredMesh, triangles: u64) -> Result<(), Wrong> {
    let wrong = |number: usize, expected: &str| {
        (Kind::Lines, format!("{expected} of cluster {number}"), "others".to_owned())
    };
    mesh.clusters.par_iter().enumerate().with_min_len(64).try_for_each(|(number, head)| {
        check::cluster(&mesh.cluster(number), head, triangles, &mesh.materials).map_err(|e| wrong(number, e))
    })
}
