//! Finds the test data that projects share: the folder `shared/data` beside the checkout.

#![allow(dead_code, reason = "each test binary uses a part of this")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tercio_mesh::ReadError;
use tercio_mesh::io::{ReadModel, ReadOptions, read};
use tercio_testkit::require_shared;

/// The data folder. Without it a test is skipped, except on CI, where it must exist.
pub fn data() -> Option<PathBuf> {
    require_shared("a test of the readers")
}

/// All files under a folder with one of these extensions, sorted.
pub fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, extensions));
        } else if path.extension().is_some_and(|e| extensions.iter().any(|x| e.eq_ignore_ascii_case(x))) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Reads a file, checks that all indices of the mesh are in range and that it took no longer than ten seconds.
pub fn read_checked(path: &Path) -> Result<ReadModel, ReadError> {
    let start = Instant::now();
    let result = read(path, &ReadOptions::default());
    assert!(start.elapsed() < Duration::from_secs(10), "{} took {:?}", path.display(), start.elapsed());
    if let Ok(model) = &result {
        check(&path.display().to_string(), model);
    }
    result
}

/// Invariants of every mesh that a reader returns.
pub fn check(name: &str, model: &ReadModel) {
    let mesh = &model.mesh;
    let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < vertices), "{name}: index");
    assert!(mesh.normals.as_ref().is_none_or(|n| n.len() == vertices), "{name}: normals");
    assert!(mesh.texcoords.as_ref().is_none_or(|t| t.len() == vertices), "{name}: texcoords");
    assert!(mesh.vertex_colors.as_ref().is_none_or(|c| c.len() == vertices), "{name}: vertex colours");
    assert!(mesh.face_colors.as_ref().is_none_or(|c| c.len() == triangles), "{name}: face colours");
    let elements = |a: &tercio_mesh::Attribute| match a.domain {
        tercio_mesh::AttributeDomain::Vertex => vertices,
        tercio_mesh::AttributeDomain::Triangle => triangles,
    };
    assert!(mesh.attributes.iter().all(|a| a.values.len() == elements(a)), "{name}: attributes");
    let strokes = &model.strokes;
    let ends = strokes.segments.iter().flatten().chain(&strokes.points);
    assert!({ ends }.all(|&v| (v as usize) < strokes.positions.len()), "{name}: strokes");
    let whole = |a: &tercio_mesh::Attribute| a.values.len() == strokes.positions.len();
    assert!(strokes.attributes.iter().all(whole), "{name}: attributes of strokes");
    if let Some(faces) = &mesh.face_of_triangle {
        assert_eq!(faces.len(), triangles, "{name}: faces");
        assert!(
            faces.is_sorted() && faces.iter().all(|&f| u64::from(f) < model.report.faces),
            "{name}: faces"
        );
    } else {
        assert_eq!(model.report.faces as usize, triangles, "{name}: faces");
    }
    if let Some(numbers) = &mesh.triangle_materials {
        assert_eq!(numbers.len(), triangles, "{name}: materials");
        let known = |&n: &u32| n == tercio_mesh::Mesh::NO_MATERIAL || (n as usize) < mesh.materials.len();
        assert!(numbers.iter().all(known), "{name}: materials");
    }
}

/// Reads every file of a table of broken ones; `true` marks one that can still be read.
pub fn check_outcomes(data: &Path, table: &[(&str, bool)]) {
    let mut wrong = Vec::new();
    for &(name, readable) in table {
        let result = read_checked(&data.join(name));
        if std::env::var_os("SHOW").is_some() {
            match &result {
                Ok(m) => println!(
                    "{name}: {} v {} t {:?}",
                    m.mesh.positions.len(),
                    m.mesh.triangles.len(),
                    m.report.warnings
                ),
                Err(e) => println!("{e}"),
            }
        }
        if result.is_ok() != readable {
            wrong.push(format!("{name}: {:?}", result.map(|m| m.report)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Checks that every file of these folders is in the table, so that none is forgotten.
pub fn assert_complete(data: &Path, folders: &[&str], extensions: &[&str], table: &[(&str, bool)]) {
    for path in folders.iter().flat_map(|f| files(&data.join(f), extensions)) {
        let name = path.strip_prefix(data).unwrap().to_str().unwrap();
        assert!(table.iter().any(|(n, _)| *n == name), "{name} is not in the table");
    }
}
