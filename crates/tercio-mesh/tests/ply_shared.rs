//! Every PLY file of the shared data folder, which is beside the repository and not part of it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tercio_mesh::ReadError;
use tercio_mesh::io::{ReadModel, ReadOptions, read};
use tercio_testkit::require_shared;

/// The data folder; `None` if this machine has none. On the build server it must exist.
fn data() -> Option<PathBuf> {
    require_shared("a test of the PLY reader")
}

/// All files below a folder, by name.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { folders.push(path) } else { found.push(path) }
        }
    }
    found.sort();
    found
}

fn read_in_time(path: &Path) -> Result<ReadModel, ReadError> {
    let begin = Instant::now();
    let model = read(path, &ReadOptions::default());
    let time = begin.elapsed();
    assert!(time < Duration::from_secs(10), "{} took {time:?}", path.display());
    if let Ok(ReadModel { mesh, .. }) = &model {
        let vertices = mesh.positions.len();
        let triangles = mesh.triangles.len();
        assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < vertices));
        assert!(mesh.normals.as_ref().is_none_or(|n| n.len() == vertices));
        assert!(mesh.vertex_colors.as_ref().is_none_or(|c| c.len() == vertices));
        assert!(mesh.texcoords.as_ref().is_none_or(|t| t.len() == vertices));
        assert!(mesh.face_colors.as_ref().is_none_or(|c| c.len() == triangles));
        assert!(mesh.face_of_triangle.as_ref().is_none_or(|f| f.len() == triangles));
    }
    model
}

/// File, vertices, triangles, faces.
const MESHES: [(&str, usize, usize, u64); 41] = [
    ("assimp/Wuson.ply", 11_184, 3_732, 3_732),
    ("assimp/cube.ply", 8, 12, 6),
    ("assimp/cube_binary.ply", 8, 12, 12),
    ("assimp/cube_binary_header_with_RN_newline.ply", 8, 12, 12),
    ("assimp/cube_uv.ply", 24, 12, 6),
    ("assimp/float-color.ply", 3, 1, 1),
    // Declares a list at its vertices that is missing in the file.
    ("assimp/issue623.ply", 24, 0, 0),
    ("assimp/points.ply", 4, 0, 0),
    ("dragon_vrip.ply.gz", 437_645, 871_414, 871_414),
    ("dragon_vrip_res2.ply.gz", 100_250, 202_520, 202_520),
    ("dragon_vrip_res3.ply.gz", 22_998, 47_794, 47_794),
    ("dragon_vrip_res4.ply.gz", 5_205, 11_102, 11_102),
    ("happly/platonic_shelf.ply", 50, 80, 50),
    ("happly/platonic_shelf_ascii.ply", 50, 80, 50),
    ("happly/platonic_shelf_big_endian.ply", 50, 80, 50),
    ("igea.ply", 134_345, 268_686, 268_686),
    ("pepper.ply", 14_980, 29_956, 29_956),
    ("ply-rs/all_atomic_types_ok_ascii.ply", 0, 0, 0),
    ("ply-rs/empty_ok_ascii.ply", 0, 0, 0),
    ("ply-rs/exponent_values_ok_ascii.ply", 0, 0, 0),
    ("ply-rs/greg_turk_example1_ok_ascii.ply", 8, 12, 6),
    ("ply-rs/greg_turk_example2_ok_ascii.ply", 8, 12, 7),
    ("ply-rs/house_2_ok_ascii.ply", 5, 3, 3),
    ("ply-rs/house_2_ok_little_endian.ply", 5, 3, 3),
    ("ply-rs/leading_spaces_ok_ascii.ply", 0, 0, 0),
    ("pymeshlab/colored_airplane.ply", 7_017, 10_796, 10_796),
    ("shark.ply", 2_560, 5_116, 2_562),
    ("stratocaster.ply", 4_500, 8_660, 8_660),
    ("trimesh/cycloidal.ply", 21_384, 43_368, 43_368),
    ("trimesh/featuretype.ply", 5_096, 3_476, 3_476),
    // 502 vertices in the file, 162 copies at texture seams.
    ("trimesh/fuze.ply", 664, 1_000, 1_000),
    ("trimesh/fuze_ascii.ply", 664, 1_000, 1_000),
    ("trimesh/metadata.ply", 4, 2, 2),
    ("trimesh/mirror.ply", 143, 286, 286),
    ("trimesh/multi.ply", 4, 2, 1),
    ("trimesh/plane.ply", 4, 2, 1),
    ("trimesh/points_ascii_with_lists.ply", 5, 0, 0),
    ("trimesh/points_emptyface.ply", 1_024, 0, 0),
    ("trimesh/sphere.ply", 642, 1_280, 1_280),
    ("trimesh/suzanne.ply", 1_966, 968, 500),
    ("trimesh/tet.ply", 4, 4, 4),
];

#[test]
fn all_meshes_have_their_counts() {
    let Some(data) = data() else { return };
    let folder = data.join("meshes/ply");
    for (name, vertices, triangles, faces) in MESHES {
        let model = read_in_time(&folder.join(name)).unwrap_or_else(|e| panic!("{e}"));
        let found = (model.mesh.positions.len(), model.mesh.triangles.len(), model.report.faces);
        assert_eq!(found, (vertices, triangles, faces), "{name}");
        assert!(model.report.format.starts_with("PLY, "), "{name}");
    }
    for path in files(&folder).iter().filter(|p| p.extension().is_none_or(|e| e != "txt")) {
        let name = path.strip_prefix(&folder).unwrap().to_str().unwrap();
        assert!(MESHES.iter().any(|m| m.0 == name), "no line for {name} in the table");
    }
}

#[test]
fn three_encodings_of_one_mesh_agree() {
    let Some(data) = data() else { return };
    let model = |name| read_in_time(&data.join("meshes/ply/happly").join(name)).unwrap();
    let little = model("platonic_shelf.ply");
    for name in ["platonic_shelf_ascii.ply", "platonic_shelf_big_endian.ply"] {
        let other = model(name);
        assert_eq!(little.mesh.triangles, other.mesh.triangles);
        assert_eq!(little.mesh.face_of_triangle, other.mesh.face_of_triangle);
        assert_eq!(little.mesh.origin, other.mesh.origin);
        assert_eq!(little.mesh.positions, other.mesh.positions, "{name}");
    }
}

#[test]
fn the_contents_of_the_files_are_read() {
    let Some(data) = data() else { return };
    let model = |name| read_in_time(&data.join("meshes/ply").join(name)).unwrap();
    let airplane = model("pymeshlab/colored_airplane.ply").mesh;
    assert!(airplane.vertex_colors.is_some());
    assert_eq!(airplane.attributes[0].name, "quality");
    let metadata = model("trimesh/metadata.ply").mesh;
    assert_eq!(metadata.attributes[0].name, "face_type");
    assert_eq!(metadata.attributes[0].values, [12.0, 90.0]);
    let float_color = model("assimp/float-color.ply").mesh;
    assert_eq!(float_color.vertex_colors, Some(vec![[0, 0, 255, 255]; 3]));
    assert!(model("trimesh/cycloidal.ply").mesh.face_colors.is_some());
    assert!(model("trimesh/suzanne.ply").mesh.texcoords.is_some());
    assert!(model("trimesh/featuretype.ply").mesh.normals.is_some());
    let fuze = model("trimesh/fuze.ply").mesh;
    assert_eq!(fuze.materials[0].textures.diffuse.as_ref().map(|t| t.file.as_str()), Some("fuze uv.jpg"));
    assert!(fuze.texcoords.is_some() && fuze.face_colors.is_some());
    assert_eq!(model("assimp/points.ply").report.not_drawn.points, 4);
    // Five edges.
    assert_eq!(model("ply-rs/greg_turk_example2_ok_ascii.ply").report.not_drawn.lines, 5);
}

/// File and text of its error; empty if it is read.
const BROKEN: [(&str, &str); 11] = [
    ("assimp/empty.ply", "the file is empty"),
    ("derived/ply/ascii_index_out_of_range.ply", "line 526: expected a vertex number from 0 to 501"),
    ("derived/ply/ascii_nan_inf_vertex.ply", ""),
    ("derived/ply/ascii_negative_list_count.ply", "line 524: expected a list length"),
    (
        "derived/ply/bin_truncated_in_faces.ply",
        "byte 49679: expected 24 bytes of a list of 6 of element face 981",
    ),
    ("derived/ply/bin_vertex_count_too_large.ply", "line 5: expected at least 16 bytes for each of 99999999"),
    ("derived/ply/count_overflow_u64.ply", "line 13: expected the number of instances of element face"),
    ("derived/ply/missing_end_header.ply", "line 20: expected a header line or \"end_header\""),
    (
        "derived/ply/negative_count.ply",
        "line 13: expected the number of instances of element face, found \"-5\"",
    ),
    ("ply/payload/payload_JVN42386607", "line 3: expected the properties x, y and z in element vertex"),
    ("ply/ply-rs/single_elements_err_ascii.ply", "line 5: expected at least 4 bytes for each of 2 instances"),
];

#[test]
fn broken_files_give_the_expected_errors() {
    let Some(data) = data() else { return };
    let folder = data.join("malformed");
    for (name, expected) in BROKEN {
        match read_in_time(&folder.join(name)) {
            Ok(_) => assert_eq!(expected, "", "{name} was read"),
            Err(error) => {
                let error = error.to_string();
                assert!(!expected.is_empty() && error.contains(expected), "{name}: {error}");
            }
        }
    }
    for path in files(&folder) {
        let is_ply = path.extension().is_some_and(|e| e == "ply")
            || path.strip_prefix(&folder).is_ok_and(|p| p.starts_with("ply"));
        let name = path.strip_prefix(&folder).unwrap().to_str().unwrap();
        assert!(!is_ply || BROKEN.iter().any(|b| b.0 == name), "no line for {name} in the table");
    }
}
