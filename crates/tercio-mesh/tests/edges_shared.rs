//! Edges of shared models, counted as by VTK 9.7.2 (vtkCleanPolyData with point merging, vtkExtractEdges and vtkFeatureEdges with a
//! feature angle of 30 degrees).

use tercio_mesh::edges::{EdgeKind, Edges, Selection};
use tercio_mesh::io::{self, ReadOptions};
use tercio_mesh::{clean, weld};

/// File; all edges, edges of one triangle, edges of more than two triangles; bent ones. VTK counts 8 more of these in
/// 42400-IDGH.stl, at triangles without area, and 18 more in shark.ply, where it compares normals of polygons that are not flat,
/// not of the triangles at the edge. Eleven of its quads are folded by more than 80 degrees: there, edges are found along the fold.
const COUNTS: [(&str, [usize; 3], usize); 5] = [
    ("stl/gears.stl", [29139, 0, 0], 5200),
    ("stl/featuretype.STL", [5502, 576, 0], 1435),
    ("stl/42400-IDGH.stl", [16554, 0, 0], 2099 - 8),
    ("stl/multibody.stl", [48, 0, 0], 28),
    ("ply/shark.ply", [5120 + 11, 0, 0], 880 - 18 + 11),
];

#[test]
fn edges_are_as_many_as_vtk_finds() {
    let Some(data) = tercio_testkit::data::require_shared("edges of shared models") else { return };
    for (name, expected, bent) in COUNTS {
        let mut mesh =
            io::read(data.join("meshes").join(name), &ReadOptions::default()).expect("a model").mesh;
        clean::clean(&mut mesh);
        weld::weld(&mut mesh);
        let all = Edges::of_mesh(&mesh, Selection::All);
        let features = Edges::of_mesh(&mesh, Selection::Feature(30f64.to_radians()));
        let found = [all.list.len(), all.count(EdgeKind::Boundary), all.count(EdgeKind::NonManifold)];
        assert_eq!((found, features.count(EdgeKind::Inner)), (expected, bent), "{name}");
    }
}
