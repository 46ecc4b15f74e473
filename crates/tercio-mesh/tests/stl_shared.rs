//! Every STL file of the shared data.

mod common_shared;

use common_shared::{assert_complete, check_outcomes, data, files, read_checked};

/// File, whether it is binary, facets.
#[rustfmt::skip]
const GOOD: &[(&str, bool, usize)] = &[
    ("42400-IDGH.stl", true, 11036),
    ("ADIS16480.STL", false, 7436),
    ("assimp/Spider_ascii.stl", false, 1368),
    ("assimp/Spider_binary.stl", true, 1368),
    ("assimp/Wuson.stl", true, 3732),
    ("assimp/sphereWithHole.stl", false, 285),
    ("assimp/triangle.stl", false, 1),
    ("assimp/triangle_with_empty_solid.stl", false, 1),
    ("assimp/triangle_with_two_solids.stl", false, 2),
    ("featuretype.STL", true, 3476),
    ("gears.stl", false, 19426),
    ("multibody.stl", false, 32),
    ("numpy-stl/stl_ascii/HalfDonut.stl", false, 288),
    ("numpy-stl/stl_ascii/Moon.stl", false, 116),
    ("numpy-stl/stl_binary/CubeInvalidUnicode.stl", true, 12),
    ("numpy-stl/stl_binary/HalfDonut.stl", true, 288),
    ("numpy-stl/stl_binary/Moon.stl", true, 116),
    ("numpy-stl/stl_binary/StarWithEmptyHeader.stl", true, 68),
    ("numpy-stl/stl_binary/rear_case.stl", true, 18808),
    ("two_objects_mixed_case_names.stl", false, 24),
];

/// File, and whether it is read; each was judged individually.
#[rustfmt::skip]
const BROKEN: &[(&str, bool)] = &[
    ("malformed/derived/stl/ascii_truncated.stl", false),
    ("malformed/derived/stl/ascii_two_vertices_only.stl", false),
    ("malformed/derived/stl/bin_count_too_large.stl", false),
    ("malformed/derived/stl/bin_header_starts_with_solid.stl", true),
    ("malformed/derived/stl/bin_nan_inf.stl", true),
    ("malformed/derived/stl/bin_truncated_mid_triangle.stl", false),
    ("malformed/stl/openscad/bad-stl-wing.stl", true),
    ("malformed/stl/openscad/empty.stl", false),
    ("malformed/stl/openscad/invalidvertex.stl", false),
    ("malformed/stl/openscad/unparseable.stl", false),
    ("malformed/stl/trimesh/busted.STL", true),
];

#[test]
fn good_files_have_the_counts_of_other_readers() {
    let Some(data) = data() else { return };
    let folder = data.join("meshes/stl");
    for path in files(&folder, &["stl"]) {
        let name = path.strip_prefix(&folder).unwrap().to_str().unwrap();
        let model = read_checked(&path).unwrap_or_else(|e| panic!("{e}"));
        let Some(&(_, is_binary, facets)) = GOOD.iter().find(|g| g.0 == name) else {
            panic!("{name} is not in the table");
        };
        assert_eq!(model.report.format, if is_binary { "STL, binary" } else { "STL, ASCII" }, "{name}");
        assert_eq!(model.mesh.triangles.len(), facets, "{name}");
        assert_eq!(model.mesh.positions.len(), 3 * facets, "{name}");
    }
}

#[test]
fn broken_files_give_the_expected_outcomes() {
    let Some(data) = data() else { return };
    assert_complete(&data, &["malformed/stl", "malformed/derived/stl"], &["stl"], BROKEN);
    check_outcomes(&data, BROKEN);
}
