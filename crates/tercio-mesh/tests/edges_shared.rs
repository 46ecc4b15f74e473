//! Edges of shared models, counted as by VTK 9.7.2 (vtkCleanPolyData with point merging, vtkExtractEdges and vtkFeatureEdges with a
//! feature angle of 30 degrees).

use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::edges::{EdgeKind, Edges, Selection};
use tercio_mesh::io::{self, ReadOptions};
use tercio_mesh::{clean, weld};

/// File; all edges, edges of one triangle, edges of more than two triangles; bent ones. VTK counts 8 more of these in
/// 42400-IDGH.stl, at triangles without area, and 18 more in shark.ply, where it compares normals of polygons that are not flat,
/// not of the triangles at the edge.
const COUNTS: [(&str, [usize; 3], usize); 5] = [
    ("stl/gears.stl", [29139, 0, 0], 5200),
    ("stl/featuretype.STL", [5502, 576, 0], 1435),
    ("stl/42400-IDGH.stl", [16554, 0, 0], 2099 - 8),
    ("stl/multibody.stl", [48, 0, 0], 28),
    ("ply/shark.ply", [5120, 0, 0], 880 - 18),
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

/// Sides of polygons of VTK files as VTK 9.7.2 has them: of the polygons and the triangles of strips that vtkDataSetSurfaceFilter finds,
/// with points identified by position, and of quadratic cells (the last two) of the faces that one cell alone has
/// (vtkCell::GetFace, vtkCell::GetEdge), each in two halves.
const OF_CELLS: [(&str, usize); 24] = [
    ("cells/HexagonalPrism.vtk", 18),
    ("cells/Hexahedron.vtu", 12),
    ("cells/PentagonalPrism.vtu", 15),
    ("cells/Pixel.vtk", 4),
    ("cells/Polygon.vtk", 6),
    ("cells/Pyramid.vtk", 8),
    ("cells/Quad.vtk", 4),
    ("cells/Tetra.vtu", 6),
    ("cells/TriangleStrip.vtk", 17),
    ("cells/TriangleStrip.vtu", 17),
    ("cells/Voxel.vtu", 12),
    ("cells/Wedge.vtk", 9),
    ("blow.vtk", 1760),
    ("can.vtu", 7360),
    ("cow.vtp", 6165),
    ("cowHead.vtp", 12067),
    ("disk_out_ref_surface.vtp", 3976),
    ("filledContours.vtp", 62),
    ("hexa.vtk", 5808),
    ("polyEx.vtk", 12),
    ("usa.vtk", 2587),
    ("v.vtk", 244),
    ("notch_disp.vtu", 10092),
    ("tetra.vtu", 24),
];

#[test]
fn sides_of_polygons_are_those_of_vtk() {
    let Some(data) = tercio_testkit::data::require_shared("edges of cells") else { return };
    for (name, expected) in OF_CELLS {
        let file = data.join("meshes/vtk").join(name);
        let mut mesh = io::read(file, &ReadOptions::default()).expect("a model").mesh;
        clean::clean(&mut mesh);
        weld::weld(&mut mesh);
        let found = Edges::of_mesh(&mesh, Selection::All).list.len();
        let clusters = partition(mesh, &PartitionOptions::default());
        let split = Edges::of_clusters(&clusters, Selection::All).list.len();
        assert_eq!((found, split), (expected, expected), "{name}");
    }
}
