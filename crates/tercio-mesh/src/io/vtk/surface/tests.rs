//! Surfaces of cells against closed forms: a cell whose other nodes lie straight between its corners has the area and the volume
//! of the cell without them.
//!
//! Source of the order of nodes: VTK, the classes of the cells (`vtkBiQuadraticQuadraticHexahedron` and others).

use crate::io::input::Input;
use crate::io::{ReadModel, ReadOptions, read_input};

fn read(text: &str) -> ReadModel {
    let options = ReadOptions::default();
    let input = Input::from_bytes("cells.vtk", text.as_bytes().to_vec(), &options);
    input.and_then(|input| read_input(&input, &options)).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Area and enclosed volume of the triangles.
fn area_and_volume(model: &ReadModel) -> [f64; 2] {
    let at = |v: u32| glam::Vec3::from(model.mesh.positions[v as usize]).as_dvec3();
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(at);
        [(b - a).cross(c - a).length() / 2.0, a.dot(b.cross(c)) / 6.0]
    };
    model.mesh.triangles.iter().map(of).fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]])
}

/// A legacy file with one cell.
fn one_cell(cell_type: u8, nodes: &[[f64; 3]]) -> String {
    let numbers = |count: usize| (0..count).map(|i| format!(" {i}")).collect::<String>();
    let points: String = nodes.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let n = nodes.len();
    format!(
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {n} double\n{points}CELLS 1 {}\n{n}{}\n\
         CELL_TYPES 1\n{cell_type}\n",
        n + 1,
        numbers(n)
    )
}

const TETRA: &[[f64; 3]] = &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
const HEXAHEDRON: &[[f64; 3]] = &[
    [0., 0., 0.],
    [1., 0., 0.],
    [1., 1., 0.],
    [0., 1., 0.],
    [0., 0., 1.],
    [1., 0., 1.],
    [1., 1., 1.],
    [0., 1., 1.],
];
const WEDGE: &[[f64; 3]] =
    &[[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [0., 0., 1.], [0., 1., 1.], [1., 0., 1.]];
const PYRAMID: &[[f64; 3]] = &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0.5, 0.5, 1.]];
const TRIANGLE: &[[f64; 3]] = &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
const QUAD: &[[f64; 3]] = &[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

/// Each further node is the mean of these corners.
type Between = &'static [&'static [usize]];

const OF_TETRA: Between = &[&[0, 1], &[1, 2], &[2, 0], &[0, 3], &[1, 3], &[2, 3]];
const OF_HEXAHEDRON: [&[usize]; 12] = [
    &[0, 1],
    &[1, 2],
    &[2, 3],
    &[3, 0],
    &[4, 5],
    &[5, 6],
    &[6, 7],
    &[7, 4],
    &[0, 4],
    &[1, 5],
    &[2, 6],
    &[3, 7],
];
const OF_WEDGE: [&[usize]; 9] =
    [&[0, 1], &[1, 2], &[2, 0], &[3, 4], &[4, 5], &[5, 3], &[0, 3], &[1, 4], &[2, 5]];
const OF_PYRAMID: [&[usize]; 8] = [&[0, 1], &[1, 2], &[2, 3], &[3, 0], &[0, 4], &[1, 4], &[2, 4], &[3, 4]];

#[test]
fn cells_with_nodes_between_corners_have_the_surface_of_their_corners() {
    let with = |edges: &[&'static [usize]], faces: &[&'static [usize]]| [edges, faces].concat();
    let all = [0, 1, 2, 3, 4, 5, 6, 7];
    let all: &'static [usize] = Box::leak(Box::new(all));
    // Type, corners, the other nodes, and triangles: of a face with nodes between its corners one for each of its nodes, less two, of one
    // with a node in the middle one for each of the others.
    let cells = [
        (10, TETRA, vec![], 4),
        (12, HEXAHEDRON, vec![], 12),
        (13, WEDGE, vec![], 8),
        (14, PYRAMID, vec![], 6),
        (22, TRIANGLE, with(&[&[0, 1], &[1, 2], &[2, 0]], &[]), 4),
        (23, QUAD, with(&[&[0, 1], &[1, 2], &[2, 3], &[3, 0]], &[]), 6),
        (24, TETRA, OF_TETRA.to_vec(), 16),
        (25, HEXAHEDRON, OF_HEXAHEDRON.to_vec(), 36),
        (26, WEDGE, OF_WEDGE.to_vec(), 26),
        (27, PYRAMID, OF_PYRAMID.to_vec(), 22),
        (28, QUAD, with(&[&[0, 1], &[1, 2], &[2, 3], &[3, 0]], &[&[0, 1, 2, 3]]), 8),
        (
            29,
            HEXAHEDRON,
            with(
                &OF_HEXAHEDRON,
                &[
                    &[0, 4, 7, 3],
                    &[1, 2, 6, 5],
                    &[0, 1, 5, 4],
                    &[3, 7, 6, 2],
                    &[0, 3, 2, 1],
                    &[4, 5, 6, 7],
                    all,
                ],
            ),
            48,
        ),
        (30, QUAD, with(&[&[0, 1], &[2, 3]], &[]), 4),
        (31, WEDGE, OF_WEDGE[..6].to_vec(), 20),
        (32, WEDGE, with(&OF_WEDGE, &[&[0, 1, 3, 4], &[1, 2, 4, 5], &[2, 0, 3, 5]]), 32),
        (
            33,
            HEXAHEDRON,
            with(&OF_HEXAHEDRON, &[&[0, 4, 7, 3], &[1, 2, 6, 5], &[0, 1, 5, 4], &[3, 7, 6, 2]]),
            44,
        ),
        (34, TRIANGLE, with(&[&[0, 1], &[1, 2], &[2, 0]], &[&[0, 1, 2]]), 6),
        (36, QUAD, with(&[&[0, 1], &[1, 2], &[2, 3], &[3, 0]], &[]), 6),
        (
            37,
            PYRAMID,
            with(
                &OF_PYRAMID,
                &[&[0, 1, 2, 3], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4], &[0, 1, 2, 3, 4]],
            ),
            32,
        ),
    ];
    // Nothing is parallel to an axis, and all lengths differ.
    let axes = glam::DMat3::from_cols_array(&[2.0, 0.3, -0.2, 0.5, 1.5, 0.4, -0.3, 0.2, 1.0]);
    let place = |p: &[f64; 3]| (axes * glam::DVec3::from(*p) + glam::dvec3(0.25, -3.0, 0.5)).to_array();
    for (cell_type, corners, between, triangles) in cells {
        let corners: Vec<[f64; 3]> = corners.iter().map(place).collect();
        let mean = |of: &&[usize]| {
            let sum: glam::DVec3 = of.iter().map(|&c| glam::DVec3::from(corners[c])).sum();
            (sum / of.len() as f64).to_array()
        };
        let nodes: Vec<_> = corners.iter().copied().chain(between.iter().map(mean)).collect();
        let model = read(&one_cell(cell_type, &nodes));
        let linear = match corners.len() {
            3 => 5,
            4 if corners[3..] == [place(&QUAD[3])] => 9,
            4 => 10,
            5 => 14,
            6 => 13,
            _ => 12,
        };
        let expected = area_and_volume(&read(&one_cell(linear, &corners)));
        let found = area_and_volume(&model);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-5, "type {cell_type}: {found} instead of {expected}");
        }
        assert_eq!(model.mesh.triangles.len(), triangles, "type {cell_type}");
        if corners.len() > 4 || linear == 10 {
            let det = axes.determinant();
            let volume = match linear {
                10 => det / 6.0,
                14 => det / 3.0,
                13 => det / 2.0,
                _ => det,
            };
            assert!((found[1] - volume).abs() < 1e-5, "type {cell_type}: volume {}", found[1]);
        }
    }
}

#[test]
fn a_structured_grid_in_xml_has_its_outer_surface() {
    // 3 x 2 x 2 cells of a sheared box.
    let mut points = String::new();
    let mut values = String::new();
    for k in 0..3 {
        for j in 0..3 {
            for i in 0..4 {
                let [x, y, z] = [f64::from(i) + 0.5 * f64::from(j), 2.0 * f64::from(j), 3.0 * f64::from(k)];
                points += &format!("{x} {y} {z}\n");
                values += &format!("{}\n", 100 * i + 10 * j + k);
            }
        }
    }
    let model = read(&format!(
        r#"<?xml version="1.0"?>
<VTKFile type="StructuredGrid" version="1.0" byte_order="LittleEndian"><StructuredGrid WholeExtent="0 3 0 2 0 2">
<Piece Extent="0 3 0 2 0 2"><PointData Scalars="n"><DataArray type="Int32" Name="n" format="ascii">{values}</DataArray></PointData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">{points}</DataArray></Points></Piece></StructuredGrid></VTKFile>"#
    ));
    let [area, volume] = area_and_volume(&model);
    let side = 4.0f64.hypot(1.0);
    assert!((area - 2.0 * (3.0 * 4.0 + 3.0 * 6.0 + side * 6.0)).abs() < 1e-4, "{area}");
    assert!((volume - 3.0 * 4.0 * 6.0).abs() < 1e-4, "{volume}");
    assert_eq!(model.mesh.triangles.len(), 2 * 2 * (3 * 2 + 3 * 2 + 2 * 2));
    let values = &model.mesh.attributes[0].values;
    for (at, value) in model.mesh.positions.iter().zip(values) {
        let [j, k] = [at[1] / 2.0, at[2] / 3.0];
        let i = at[0] - 0.5 * j;
        // The point in the middle is not on the surface.
        assert!((value - (100.0 * i + 10.0 * j + k)).abs() < 1e-3, "{at:?}: {value}");
    }
}

#[test]
fn a_face_of_no_points_is_no_face() {
    // A tetrahedron as a polyhedron with a fifth face.
    let model = read(
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n\
         CELLS 1 19\n18 5 3 0 1 3 3 1 2 3 0 3 2 0 3 3 0 2 1\nCELL_TYPES 1\n42\n",
    );
    assert_eq!(model.mesh.triangles.len(), 4);
    assert!((area_and_volume(&model)[1] - 1.0 / 6.0).abs() < 1e-6);
}
