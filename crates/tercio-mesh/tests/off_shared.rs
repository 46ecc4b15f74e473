//! Every OFF file of the shared data.

mod common_shared;

use common_shared::{assert_complete, check_outcomes, data, files, read_checked};

/// File, vertices, faces, triangles where they are known.
#[rustfmt::skip]
const GOOD: &[(&str, usize, u64, Option<usize>)] = &[
    ("cgal/P.off", 26, 25, None),
    ("cgal/boeing.off", 2741, 2564, Some(2564)),
    ("cgal/cow.off", 2904, 5804, Some(5804)),
    ("cgal/cross_quad.off", 40, 38, Some(76)),
    ("cgal/cube_poly.off", 8, 7, Some(12)),
    ("cgal/elephant-with-holes.off", 2798, 4463, Some(4463)),
    ("cgal/elephant.off", 2775, 5558, Some(5558)),
    ("cgal/knot1.off", 3200, 6400, Some(6400)),
    ("cgal/mesh_with_colors.off", 8, 4, None),
    ("cgal/polygon_mesh.off", 16344, 32245, Some(32245)),
    ("cgal/star.off", 14, 24, Some(24)),
    ("cgal/triceratops.off", 2832, 5660, Some(5660)),
    ("cgal/tripod.off", 24, 44, Some(44)),
    ("fertility.off", 4494, 9000, Some(9000)),
    ("geomview/abstr.off", 36, 20, None),
    ("geomview/cube.off", 8, 6, Some(12)),
    ("geomview/dodec.off", 20, 12, Some(36)),
    ("geomview/facecube.off", 8, 6, Some(12)),
    ("geomview/octa.off", 6, 8, Some(8)),
    ("geomview/textured_dodec.off", 20, 12, Some(36)),
    ("geomview/tref.off", 1280, 320, Some(640)),
    ("geomview/vertcube.off", 8, 6, Some(12)),
    ("intersection_quads.off", 1726, 3328, Some(3328)),
    ("lion.off", 8356, 16674, Some(16674)),
    ("trimesh/comments.off", 8, 6, Some(12)),
    ("trimesh/whitespace.off", 8, 6, Some(12)),
];

/// File, and whether it is read; each was judged individually.
#[rustfmt::skip]
const BROKEN: &[(&str, bool)] = &[
    ("malformed/assimp/OutOfMemory.off", false),
    ("malformed/derived/off/count_mismatch.off", false),
    ("malformed/derived/off/huge_counts.off", false),
    ("malformed/derived/off/index_out_of_range.off", false),
    ("malformed/derived/off/truncated_vertices.off", false),
    ("malformed/off/invalid.off", false),
];

#[test]
fn good_files_have_the_counts_of_other_readers() {
    let Some(data) = data() else { return };
    let folder = data.join("meshes/off");
    for path in files(&folder, &["off"]) {
        let name = path.strip_prefix(&folder).unwrap().to_str().unwrap();
        let model = read_checked(&path).unwrap_or_else(|e| panic!("{e}"));
        let Some(&(_, vertices, faces, triangles)) = GOOD.iter().find(|g| g.0 == name) else {
            panic!("{name} is not in the table");
        };
        assert_eq!((model.mesh.positions.len(), model.report.faces), (vertices, faces), "{name}");
        assert!(triangles.is_none_or(|n| n == model.mesh.triangles.len()), "{name}");
        assert_eq!(model.report.warnings, [""; 0], "{name}");
    }
}

#[test]
fn broken_files_give_the_expected_outcomes() {
    let Some(data) = data() else { return };
    assert_complete(&data, &["malformed/assimp", "malformed/off", "malformed/derived/off"], &["off"], BROKEN);
    check_outcomes(&data, BROKEN);
}
