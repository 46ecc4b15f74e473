//! Edges of shared models, counted as by VTK 9.7.2 (vtkCleanPolyData with point merging, vtkExtractEdges and vtkFeatureEdges with a
//! feature angle of 30 degrees).

use tercio_mesh::edges::{EdgeKind, Edges, Selection};
use tercio_mesh::io::{self, ReadOptions};
use tercio_mesh::{clean, weld};

/// File; all edges, edges of one triangle, bent ones, edges of more than two triangles.
const COUNTS: [(&str, [usize; 4]); 5] = [
    ("stl/gears.stl", [29139, 0, 5200, 0]),
    ("stl/featuretype.STL", [5502, 576, 1435, 0]),
    ("stl/42400-IDGH.stl", [16554, 0, 2099, 0]),
    ("stl/multibody.stl", [48, 0, 28, 0]),
    ("ply/shark.ply", [5120, 0, 880, 0]),
];

#[test]
fn edges_are_as_many_as_vtk_finds() {
    let Some(data) = tercio_testkit::data::require_shared("edges of shared models") else { return };
    for (name, expected) in COUNTS {
        let mut mesh =
            io::read(data.join("meshes").join(name), &ReadOptions::default()).expect("a model").mesh;
        clean::clean(&mut mesh);
        weld::weld(&mut mesh);
        let all = Edges::of_mesh(&mesh, Selection::All);
        let features = Edges::of_mesh(&mesh, Selection::Feature(30f64.to_radians()));
        let found = [
            all.list.len(),
            all.count(EdgeKind::Boundary),
            features.count(EdgeKind::Inner),
            all.count(EdgeKind::NonManifold),
        ];
        assert_eq!(found, expected, "{name}");
    }
}
