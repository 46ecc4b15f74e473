//! Every OBJ and MTL file of the shared data.

mod common_shared;

use common_shared::{assert_complete, check_outcomes, data, files, read_checked};
use tercio_mesh::io::input::Input;
use tercio_mesh::io::{ReadOptions, read_input};

/// File, `v` lines, faces, triangles, and whether vertices may be split for texture coordinates or normals.
#[rustfmt::skip]
const GOOD: &[(&str, usize, u64, usize, bool)] = &[
    ("assimp/box_UTF16BE.obj", 8, 6, 12, false),
    ("assimp/box_longline.obj", 8, 6, 944, false),
    ("assimp/box_mat_with_spaces.obj", 8, 6, 12, false),
    ("assimp/box_without_lineending.obj", 8, 6, 12, false),
    ("assimp/concave_polygon.obj", 64, 1, 64, true),
    ("assimp/cube_usemtl.obj", 8, 12, 12, true),
    ("assimp/cube_with_vertexcolors.obj", 8, 12, 12, true),
    ("assimp/number_formats.obj", 15, 1, 1, false),
    ("assimp/point_cloud.obj", 3, 0, 0, true),
    ("assimp/regr01.obj", 2108, 2710, 2710, true),
    ("assimp/testline.obj", 8, 0, 0, false),
    ("assimp/testmixed.obj", 8, 6, 12, false),
    ("assimp/testpoints.obj", 8, 0, 0, false),
    ("capsule/capsule.obj", 5252, 10200, 10200, true),
    ("classic/al.obj", 3618, 3442, 7152, false),
    ("classic/cessna.obj", 3745, 3897, 7446, false),
    ("classic/shuttle.obj", 310, 393, 616, false),
    ("classic/trumpet.obj", 11908, 11362, 23696, false),
    ("cow.obj", 2903, 5804, 5804, false),
    ("doorman/doorman.obj", 6959, 9783, 9783, true),
    ("fandisk.obj", 6475, 12946, 12946, false),
    ("fuze/fuze.obj", 502, 1000, 1000, true),
    ("nefertiti.obj", 49971, 99938, 99938, false),
    ("rocker-arm.obj", 10044, 20088, 20088, false),
    ("space-shuttle-orbiter/space-shuttle-orbiter.obj", 6107, 11542, 11542, true),
    ("spider/spider.obj", 762, 1368, 1368, true),
    ("spot/spot_quadrangulated.obj", 2930, 2928, 5856, true),
    ("spot/spot_triangulated.obj", 2930, 5856, 5856, true),
    ("stanford-bunny.obj", 35947, 69451, 69451, false),
    ("suzanne.obj", 507, 500, 968, true),
    ("teapot.obj", 3644, 6320, 6320, false),
    ("tinyobjloader/catmark_torus_creases0.obj", 32, 32, 64, true),
    ("tinyobjloader/cornell_box.obj", 76, 18, 36, false),
    ("tinyobjloader/cube-vertexcol.obj", 8, 6, 12, false),
    ("tinyobjloader/issue-295-trianguation-failure.obj", 16, 14, 28, true),
    ("tinyobjloader/leading-decimal-dot-issue-201.obj", 3, 1, 1, false),
    ("tinyobjloader/line-prim.obj", 8, 0, 0, false),
    ("tinyobjloader/map-bump.obj", 218, 400, 400, true),
    ("tinyobjloader/pbr-mat-ext.obj", 4, 1, 2, false),
    ("tinyobjloader/points-prim.obj", 8, 0, 0, false),
    ("tinyobjloader/skin-weight.obj", 8, 6, 12, false),
    ("tinyobjloader/smoothing-group-two-squares.obj", 6, 2, 3, false),
    ("tinyobjloader/texture-options-issue-85.obj", 3, 1, 1, false),
    ("trimesh/cube_compressed.obj", 8, 12, 12, true),
    ("trimesh/face_in_group_name.obj", 1, 0, 0, false),
    ("trimesh/groups.obj", 1156, 2308, 2308, true),
    ("trimesh/jacked.obj", 8, 12, 12, true),
    ("trimesh/negative_indices.obj", 8, 6, 12, true),
    ("trimesh/not_convex.obj", 288, 96, 96, false),
    ("trimesh/polygonfaces.obj", 5, 1, 3, false),
    ("trimesh/quadknot.obj", 1440, 1440, 2880, true),
    ("trimesh/tube.obj", 128, 120, 120, true),
    ("trimesh/two_objects.obj", 12, 16, 16, false),
];

/// File, and whether it is read; each was judged individually.
#[rustfmt::skip]
const BROKEN: &[(&str, bool)] = &[
    ("malformed/assimp/empty.obj", false),
    ("malformed/assimp/malformed.obj", false),
    ("malformed/derived/obj/index_out_of_range.obj", false),
    ("malformed/derived/obj/index_overflow_i64.obj", false),
    ("malformed/derived/obj/index_zero.obj", false),
    ("malformed/derived/obj/nan_inf_vertices.obj", true),
    ("malformed/derived/obj/negative_index_too_far.obj", false),
    ("malformed/derived/obj/truncated_mid_line.obj", false),
    ("malformed/obj/tinyobjloader/invalid-face-definition.obj", true),
    ("malformed/obj/tinyobjloader/invalid-relative-vertex-index.obj", false),
    ("malformed/obj/tinyobjloader/issue-140-zero-face-idx.obj", false),
    ("malformed/obj/tinyobjloader/missing_material_file.obj", true),
    ("malformed/obj/tinyobjloader/test-nan.obj", true),
    ("malformed/obj/trimesh/nancolor.obj", true),
    ("malformed/obj/trimesh/notenoughindices.obj", true),
    ("malformed/obj/ufbx_fuzz/fuzz_0000.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0010.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0020.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0030.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0040.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0050.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0060.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0070.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0080.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0090.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0100.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0110.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0120.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0130.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0140.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0150.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0160.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0170.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0180.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0190.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0200.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0210.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0220.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0230.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0240.obj", false),
    ("malformed/obj/ufbx_fuzz/fuzz_0250.obj", false),
];

#[test]
fn good_files_have_the_counts_of_other_readers() {
    let Some(data) = data() else { return };
    let folder = data.join("meshes/obj");
    for path in files(&folder, &["obj"]) {
        let name = path.strip_prefix(&folder).unwrap().to_str().unwrap();
        let model = read_checked(&path).unwrap_or_else(|e| panic!("{e}"));
        let Some(&(_, v, faces, triangles, may_split)) = GOOD.iter().find(|g| g.0 == name) else {
            panic!("{name} is not in the table");
        };
        assert_eq!((model.report.faces, model.mesh.triangles.len()), (faces, triangles), "{name}");
        let vertices = model.mesh.positions.len();
        assert!(vertices == v || (may_split && vertices > v), "{name}: {vertices} vertices");
    }
}

#[test]
fn broken_files_give_the_expected_outcomes() {
    let Some(data) = data() else { return };
    assert_complete(&data, &["malformed/assimp", "malformed/obj", "malformed/derived/obj"], &["obj"], BROKEN);
    check_outcomes(&data, BROKEN);
}

#[test]
fn broken_material_libraries_are_not_errors() {
    let Some(data) = data() else { return };
    for path in files(&data.join("malformed/mtl"), &["mtl"]) {
        let name = path.file_name().unwrap().to_str().unwrap();
        let text = format!("mtllib {name}\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        let options = ReadOptions::default();
        let mut input = Input::from_bytes("a.obj", text.into_bytes(), &options).unwrap();
        input.base = path.parent().map(Into::into);
        let model = read_input(&input, &options).unwrap();
        assert_eq!(model.mesh.triangles.len(), 1);
        assert!(model.report.warnings.iter().any(|w| w.contains("no definition")), "{name}");
    }
}
