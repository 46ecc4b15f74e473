//! Every VTK file of the shared data, against facts of VTK itself.

mod common_shared;

use common_shared::{assert_complete, check_outcomes, data, files, read_checked};
use tercio_mesh::AttributeDomain::{self, Triangle, Vertex};

/// The mean of an attribute over all vertices that triangles use, or over the triangles.
type Mean = (AttributeDomain, &'static str, f64);

/// File, triangles, area, bounds of the triangles, line segments, points, and means of some arrays.
///
/// Source: VTK 9.7.2, `vtkDataSetSurfaceFilter` and `vtkTriangleFilter` at their default settings, sums in `f64`; points that it repeats at the
/// edges of image data count once. In
/// `notch_disp.vtu` VTK leaves 144 triangles of faces inside, which it splits along other diagonals on both sides; there the
/// faces that VTK's cells list once were counted.
#[rustfmt::skip]
#[allow(clippy::approx_constant, reason = "areas of real files")]
#[allow(clippy::type_complexity, reason = "one row a file")]
const GOOD: &[(&str, usize, f64, Option<[f64; 6]>, usize, usize, &[Mean])] = &[
    ("meshes/vtk/Human.vtp", 34660, 20556.9967, Some([-52.5820007, -10.7853241, -82.5619888, 52.5820007, 33.4603386, 84.9918365]), 0, 0, &[(Vertex, "Color:0", 0.859099915), (Vertex, "Color:1", 0.804589112)]),
    ("meshes/vtk/SurfaceVectors.vtk", 756, 105.339998, Some([0.0, -5.75, 1.0, 0.0, 5.75, 10.1599998]), 0, 0, &[(Vertex, "V:1", 0.000596728325), (Vertex, "V:2", -4.16790796), (Triangle, "ObjectId", 1.0), (Triangle, "PedigreeElementId", 1648.97619)]),
    ("meshes/vtk/blow.vtk", 1186, 1145.40829, Some([0.0, -12.0, -11.0, 7.0, 36.0, 13.0]), 0, 0, &[(Vertex, "displacement1:0", 0.497445653), (Vertex, "displacement1:1", -4.29577118e-05)]),
    ("meshes/vtk/can.vtu", 7360, 487.771657, Some([-12.1696062, -3.60042429, -18.3354759, 6.00286722, 5.56220198, -13.4564514]), 0, 0, &[(Vertex, "DISPL:0", -3.95295371), (Vertex, "DISPL:1", -1.91879525), (Triangle, "EQPS", 0.823554342)]),
    ("meshes/vtk/cow.vtp", 5804, 108.84224, Some([-4.44583511, -3.63703609, -1.70140505, 5.99808788, 2.75972009, 1.70140505]), 0, 0, &[]),
    ("meshes/vtk/cowHead.vtp", 8044, 13.6482275, Some([3.18314433, 0.483893216, -1.43996978, 5.98250961, 2.75285602, 1.43996978]), 0, 0, &[(Vertex, "Gauss_Curvature", 2.67978397)]),
    ("meshes/vtk/disk_out_ref_surface.vtp", 3976, 1173.19311, Some([-5.75, -5.75, -10.0, 5.75, 5.75, 10.1599998]), 0, 0, &[(Vertex, "GlobalNodeId", 4442.97186), (Vertex, "PedigreeNodeId", 4442.97186), (Triangle, "PedigreeElementId", 4047.58853), (Triangle, "ObjectId", 1.0)]),
    ("meshes/vtk/faults.vtk", 0, 0.0, None, 1965, 0, &[]),
    ("meshes/vtk/filledContours.vtp", 48, 24.0, Some([0.0, 0.0, 0.0, 12.0, 2.0, 0.0]), 0, 0, &[(Vertex, "Scalars_", 170.481744)]),
    ("meshes/vtk/fran_cut.vtk", 4224, 0.0337604825, Some([0.0, -0.204799995, -0.118986003, 0.105599999, -0.0512003005, 0.00411238987]), 0, 0, &[]),
    ("meshes/vtk/hello.vtk", 0, 0.0, None, 15, 0, &[]),
    ("meshes/vtk/hexa.vtk", 5808, 5.48960588, Some([0.0, 0.0, 0.0, 0.956521988, 0.956521988, 0.956521988]), 0, 0, &[(Vertex, "scalars", 12.2783364)]),
    ("meshes/vtk/notch_disp.vtu", 15136, 0.0884001517, Some([0.0, 0.0, 0.0, 0.400000006, 0.100000001, 0.00999999978]), 0, 0, &[(Vertex, "Nodal Displacement:0", 1.34959973e-06)]),
    ("meshes/vtk/political.vtp", 0, 0.0, None, 94161, 0, &[]),
    ("meshes/vtk/polyEx.vtk", 12, 6.0, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[(Vertex, "my_scalars", 3.5), (Triangle, "cell_scalars", 2.5), (Triangle, "cell_normals:0", 0.0)]),
    ("meshes/vtk/tetra.vtu", 24, 3.19897721, Some([0.0, -0.5, -2.0, 3.0, 0.800000012, 1.0]), 0, 0, &[(Vertex, "scalars", 0.454545455)]),
    ("meshes/vtk/usa.vtk", 3498, 1088.17593, Some([-168.052994, 18.9249992, 0.0, -66.9524994, 71.3424988, 0.0]), 0, 0, &[]),
    ("meshes/vtk/v.vtk", 196, 337.796689, Some([0.0, 0.0, 0.0, 19.7999992, 19.2600002, 1.0]), 0, 0, &[]),
    ("meshes/vtk/vtk.vtk", 0, 0.0, None, 7, 0, &[]),
    ("meshes/vtk/cells/HexagonalPrism.vtk", 20, 4.29903811, Some([0.0669872981, 0.0, 0.0, 0.933012702, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/HexagonalPrism.vtu", 20, 4.29903811, Some([0.0669872981, 0.0, 0.0, 0.933012702, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Hexahedron.vtk", 12, 6.0, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Hexahedron.vtu", 12, 6.0, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Line.vtk", 0, 0.0, None, 1, 0, &[]),
    ("meshes/vtk/cells/Line.vtu", 0, 0.0, None, 1, 0, &[]),
    ("meshes/vtk/cells/PentagonalPrism.vtk", 16, 4.12774676, Some([0.0954915, 0.0244717, 0.0, 1.0, 0.975528, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/PentagonalPrism.vtu", 16, 4.12774676, Some([0.0954915, 0.0244717, 0.0, 1.0, 0.975528, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Pixel.vtk", 2, 1.0, Some([0.0, 0.0, 0.0, 1.0, 1.0, 0.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Pixel.vtu", 2, 1.0, Some([0.0, 0.0, 0.0, 1.0, 1.0, 0.0]), 0, 0, &[]),
    ("meshes/vtk/cells/PolyLine.vtk", 0, 0.0, None, 4, 0, &[]),
    ("meshes/vtk/cells/PolyLine.vtu", 0, 0.0, None, 4, 0, &[]),
    ("meshes/vtk/cells/PolyVertex.vtk", 0, 0.0, None, 0, 6, &[]),
    ("meshes/vtk/cells/PolyVertex.vtu", 0, 0.0, None, 0, 6, &[]),
    ("meshes/vtk/cells/Polygon.vtk", 4, 0.980000032, Some([0.0, -0.100000001, 0.0, 1.0, 1.20000005, 0.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Polygon.vtu", 4, 0.980000032, Some([0.0, -0.100000001, 0.0, 1.0, 1.20000005, 0.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Pyramid.vtk", 6, 3.41421356, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Pyramid.vtu", 6, 3.41421356, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Quad.vtk", 2, 1.0, Some([0.0, 0.0, 0.0, 1.0, 1.0, 0.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Quad.vtu", 2, 1.0, Some([0.0, 0.0, 0.0, 1.0, 1.0, 0.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Tetra.vtk", 4, 2.3660254, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Tetra.vtu", 4, 2.3660254, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Triangle.vtk", 1, 0.5, Some([0.0, 0.0, 0.0, 1.0, 1.0, 0.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Triangle.vtu", 1, 0.5, Some([0.0, 0.0, 0.0, 1.0, 1.0, 0.0]), 0, 0, &[]),
    ("meshes/vtk/cells/TriangleStrip.vtk", 8, 3.87500001, Some([0.0, -0.200000003, 0.0, 4.5, 1.10000002, 0.0]), 0, 0, &[]),
    ("meshes/vtk/cells/TriangleStrip.vtu", 8, 3.87500001, Some([0.0, -0.200000003, 0.0, 4.5, 1.10000002, 0.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Vertex.vtk", 0, 0.0, None, 0, 1, &[]),
    ("meshes/vtk/cells/Vertex.vtu", 0, 0.0, None, 0, 1, &[]),
    ("meshes/vtk/cells/Voxel.vtk", 12, 6.0, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Voxel.vtu", 12, 6.0, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Wedge.vtk", 8, 4.41421356, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[]),
    ("meshes/vtk/cells/Wedge.vtu", 8, 4.41421356, Some([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), 0, 0, &[]),
    ("volumes/vtk/hydrogen.vti", 47628, 23814.0, Some([0.0, 0.0, 0.0, 63.0, 63.0, 63.0]), 0, 0, &[(Vertex, "probability_density", 0.000395783339)]),
    ("volumes/vtk/vase.vti", 108944, 54472.0, Some([0.0, 0.0, 0.0, 114.0, 100.0, 74.0]), 0, 0, &[(Vertex, "SLCImage", 0.0)]),
];

/// File, and whether it is read; each was judged individually.
const BROKEN: &[(&str, bool)] = &[
    ("malformed/derived/vtk/lines_index_out_of_range.vtk", false),
    ("malformed/derived/vtk/no_dataset_line.vtk", false),
    ("malformed/derived/vtk/points_count_too_large.vtk", false),
    ("malformed/derived/vtk/truncated.vtk", false),
    ("malformed/derived/vtkxml/not_wellformed.vtp", false),
    ("malformed/derived/vtkxml/number_of_points_wrong.vtp", false),
    ("malformed/derived/vtkxml/truncated_appended.vtp", false),
];

const EXTENSIONS: &[&str] = &["vtk", "vtp", "vtu", "vti", "vts", "vtr"];

#[test]
fn good_files_have_the_facts_of_vtk() {
    let Some(data) = data() else { return };
    let mut wrong = Vec::new();
    let all = ["meshes/vtk", "volumes/vtk"].iter().flat_map(|folder| files(&data.join(folder), EXTENSIONS));
    for path in all {
        let name = path.strip_prefix(&data).unwrap().to_str().unwrap();
        let Some(&(_, triangles, area, bounds, segments, dots, means)) = GOOD.iter().find(|g| g.0 == name)
        else {
            panic!("{name} is not in the table");
        };
        let model = read_checked(&path).unwrap_or_else(|e| panic!("{e}"));
        let (mesh, strokes) = (&model.mesh, &model.strokes);
        let point = |v: u32| {
            let p = mesh.positions[v as usize];
            [0, 1, 2].map(|k| mesh.origin[k] + f64::from(p[k]))
        };
        let mut used = mesh.triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let (mut sum, mut low, mut high) = (0.0, [f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &t in &mesh.triangles {
            let [a, b, c] = t.map(point);
            let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
            let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            sum += cross.iter().map(|c| c * c).sum::<f64>().sqrt() / 2.0;
            for p in [a, b, c] {
                (0..3).for_each(|k| (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k])));
            }
        }
        let mut differ = |what: &str, found: f64, expected: f64| {
            if (found - expected).abs() > 2e-5 * expected.abs().max(1e-9) {
                wrong.push(format!("{name}: {what} {found}, not {expected}"));
            }
        };
        differ("triangles", mesh.triangles.len() as f64, triangles as f64);
        differ("area", sum, area);
        differ("segments", strokes.segments.len() as f64, segments as f64);
        differ("points", strokes.points.len() as f64, dots as f64);
        for (k, &expected) in bounds.iter().flatten().enumerate() {
            differ("bounds", if k < 3 { low[k] } else { high[k - 3] }, expected);
        }
        for &(domain, attribute, expected) in means {
            let Some(found) = mesh.attributes.iter().find(|a| a.name == attribute && a.domain == domain)
            else {
                panic!("{name}: no {attribute}");
            };
            let values: Vec<f64> = match domain {
                Vertex => used.iter().map(|&v| f64::from(found.values[v as usize])).collect(),
                Triangle => found.values.iter().map(|&v| f64::from(v)).collect(),
            };
            differ(attribute, values.iter().sum::<f64>() / values.len() as f64, expected);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn broken_files_give_clear_errors() {
    let Some(data) = data() else { return };
    assert_complete(&data, &["malformed/derived/vtk", "malformed/derived/vtkxml"], EXTENSIONS, BROKEN);
    check_outcomes(&data, BROKEN);
    for (name, expected) in [
        (BROKEN[0].0, "line 31: expected a vertex number from 0 to 21, found 999999"),
        (BROKEN[1].0, "line 5: expected DATASET and the kind of data set, found \"POINTS\""),
        (BROKEN[2].0, "expected 6000000000 numbers of the points, found"),
        (BROKEN[5].0, "points, as stated by the piece of line"),
    ] {
        let error = read_checked(&data.join(name)).expect_err(name).to_string();
        assert!(error.contains(expected), "{error}");
    }
}
