//! Arrays that say more than their numbers: colours, hidden points, and bits.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use crate::AttributeDomain::Vertex;
use crate::io::input::Input;
use crate::io::{ReadModel, ReadOptions, read_input};
use crate::{Attribute, ReadError};

fn try_read(bytes: &[u8]) -> Result<ReadModel, ReadError> {
    let options = ReadOptions::default();
    read_input(&Input::from_bytes("a", bytes.to_vec(), &options)?, &options)
}

fn read(bytes: &[u8]) -> ReadModel {
    try_read(bytes).unwrap_or_else(|error| panic!("{error}"))
}

fn values<'a>(model: &'a ReadModel, name: &str) -> &'a [f32] {
    let found = model.mesh.attributes.iter().find(|a| a.name == name && a.domain == Vertex);
    found.map(|a| &a.values[..]).unwrap_or_else(|| panic!("no {name}"))
}

/// A legacy file with a triangle whose points have colours.
fn colored(kind: &str, components: usize, colors: &[u8]) -> Vec<u8> {
    let list = "POLYGONS 1 4\n";
    let data = format!("\nPOINT_DATA 3\nCOLOR_SCALARS c {components}\n");
    let head = format!("# vtk DataFile Version 3.0\nx\n{kind}\nDATASET POLYDATA\nPOINTS 3 float\n");
    let points = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    if kind == "ASCII" {
        return [
            head.as_bytes(),
            b"0 0 0 1 0 0 0 1 0\n",
            list.as_bytes(),
            b"3 0 1 2",
            data.as_bytes(),
            colors,
        ]
        .concat();
    }
    let points: Vec<u8> = points.into_iter().flat_map(f32::to_be_bytes).collect();
    let corners: Vec<u8> = [3i32, 0, 1, 2].into_iter().flat_map(i32::to_be_bytes).collect();
    [head.as_bytes(), &points, b"\n", list.as_bytes(), &corners, data.as_bytes(), colors].concat()
}

/// As many digits as VTK writes.
fn divided(colors: &[u8]) -> String {
    colors.iter().map(|&c| format!("{:.5e} ", f64::from(c) / 255.0)).collect()
}

#[test]
fn colours_are_bytes_in_text_too() {
    for (components, colors) in [
        (1, &[0, 1, 3][..]),
        (1, &[0, 1, 1]),
        (3, &[255, 0, 0, 0, 128, 0, 7, 77, 254]),
        (3, &[1, 0, 0, 0, 1, 0, 0, 0, 1]),
        (4, &[255, 0, 0, 10, 0, 128, 0, 255, 7, 77, 254, 0]),
    ] {
        let text = read(&colored("ASCII", components, divided(colors).as_bytes()));
        let bytes = read(&colored("BINARY", components, colors));
        for component in 0..components {
            let name = Attribute::component_name("c", component, components);
            let expected: Vec<f32> =
                colors.iter().skip(component).step_by(components).map(|&c| c.into()).collect();
            assert_eq!(values(&text, &name), expected);
            assert_eq!(values(&bytes, &name), expected);
        }
        assert_eq!(text.mesh.vertex_colors, bytes.mesh.vertex_colors);
        assert!(text.mesh.vertex_colors.is_some());
        assert!(text.report.warnings.is_empty(), "{:?}", text.report.warnings);
    }
    let every: Vec<u8> = (0..=255).collect();
    for colors in every.windows(3) {
        let text = read(&colored("ASCII", 1, divided(colors).as_bytes()));
        assert_eq!(values(&text, "c"), [0, 1, 2].map(|i: usize| f32::from(colors[i])));
    }
}

/// VTK takes one component as luminance, and a second one as alpha.
#[test]
fn one_component_of_colours_is_grey() {
    let grey = |value: u8, alpha| [value, value, value, alpha];
    let of_values = vec![grey(0, 255), grey(128, 255), grey(255, 255)];
    let with_alpha = vec![grey(3, 255), grey(200, 10), grey(255, 0)];
    let cases = [(1, vec![0, 128, 255], of_values), (2, vec![3, 255, 200, 10, 255, 0], with_alpha)];
    for (components, colors, expected) in cases {
        let text = colored("ASCII", components, divided(&colors).as_bytes());
        for bytes in [text, colored("BINARY", components, &colors)] {
            assert_eq!(read(&bytes).mesh.vertex_colors.as_ref(), Some(&expected));
        }
    }
    let text = String::from_utf8(colored("ASCII", 1, b"0.5")).expect("a text");
    let of_cell = text.replace("POINT_DATA 3", "CELL_DATA 1");
    assert_eq!(read(of_cell.as_bytes()).mesh.face_colors, Some(vec![grey(128, 255)]));
}

#[test]
fn colours_outside_are_cut_off_with_a_warning() {
    let model = read(&colored("ASCII", 1, b"-0.5 1.5 255"));
    assert_eq!(values(&model, "c"), [0.0, 255.0, 255.0]);
    assert_eq!(model.report.warnings, ["array \"c\" has colours outside 0 to 1, which are taken as 0 or 1"]);
}

/// An XML file of image data whose points have ghosts: 0, but for these.
fn grid(dims: [usize; 3], ghosts: &[(usize, u8)], cell_data: &str) -> Vec<u8> {
    let mut all = vec![0; dims.iter().product()];
    ghosts.iter().for_each(|&(point, bits)| all[point] = bits);
    let extent: String = dims.iter().map(|n| format!("0 {} ", n - 1)).collect();
    format!(
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"{extent}\"><Piece Extent=\"{extent}\"><PointData>\
         <DataArray type=\"UInt8\" Name=\"vtkGhostType\">{}</DataArray></PointData>{cell_data}</Piece></ImageData>\
         </VTKFile>",
        words(&all)
    )
    .into_bytes()
}

fn words(numbers: &[u8]) -> String {
    numbers.iter().map(|n| format!("{n} ")).collect()
}

/// Cells of flat grids, and faces of volumes.
fn faces(bytes: &[u8]) -> usize {
    read(bytes).mesh.triangles.len() / 2
}

#[test]
fn cells_of_grids_with_hidden_points_are_gone() {
    // VTK's numbers: of its geometry filter for flat grids, of its surface filter for volumes.
    assert_eq!(faces(&grid([5, 5, 1], &[(12, 2)], "")), 12);
    assert_eq!(faces(&grid([5, 5, 1], &[(12, 3)], "")), 12);
    assert_eq!(faces(&grid([5, 1, 5], &[(12, 2)], "")), 12);
    assert_eq!(faces(&grid([5, 5, 1], &[(12, 1), (0, 1)], "")), 16);
    let solid = [5; 3];
    assert_eq!(faces(&grid(solid, &[], "")), 96);
    assert_eq!(faces(&grid(solid, &[(62, 1)], "")), 96);
    assert_eq!(faces(&grid(solid, &[(62, 2)], "")), 120);
    assert_eq!(faces(&grid(solid, &[(12, 2)], "")), 104);
    assert_eq!(faces(&grid(solid, &[(37, 2)], "")), 112);
    let segments = |ghosts: &[_]| read(&grid([5, 1, 1], ghosts, "")).strokes.segments.len();
    assert_eq!((segments(&[]), segments(&[(2, 1)]), segments(&[(2, 2)])), (4, 4, 2));
    let hidden: Vec<u32> =
        read(&grid([5, 5, 1], &[(12, 2)], "")).mesh.face_of_triangle.expect("cells are gone");
    assert!(hidden.iter().all(|cell| ![5, 6, 9, 10].contains(cell)), "{hidden:?}");
    // Cells that are hidden themselves are gone as well.
    let cells = "<CellData><DataArray type=\"UInt8\" Name=\"vtkGhostType\">32 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1\
                 </DataArray></CellData>";
    assert_eq!(faces(&grid([5, 5, 1], &[(12, 2)], cells)), 10);
}

#[test]
fn cells_of_legacy_grids_with_hidden_points_are_gone() {
    let points: String = (0..9).map(|i| format!("{} {} 0 ", i % 3, i / 3)).collect();
    for (ghosts, left) in [("2 0 0 0 0 0 0 0 1", 3), ("0 2 0 0 0 0 0 0 0", 2), ("0 0 0 0 2 0 0 0 0", 0)] {
        for geometry in [
            format!("STRUCTURED_GRID\nDIMENSIONS 3 3 1\nPOINTS 9 float\n{points}"),
            "STRUCTURED_POINTS\nDIMENSIONS 3 3 1".into(),
            "RECTILINEAR_GRID\nDIMENSIONS 3 3 1\nX_COORDINATES 3 float\n0 1 2\nY_COORDINATES 3 float\n0 1 2\n\
             Z_COORDINATES 1 float\n0"
                .into(),
        ] {
            let head = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET";
            let data = "POINT_DATA 9\nSCALARS vtkGhostType unsigned_char 1\nLOOKUP_TABLE default";
            let file = format!("{head} {geometry}\n{data}\n{ghosts}\n");
            assert_eq!(faces(file.as_bytes()), left, "{geometry}");
        }
    }
}

#[test]
fn faces_of_unstructured_grids_with_hidden_points_are_not_drawn() {
    // A tetrahedron, a triangle and a line, all with the first point.
    let file = |kind: &str, cells: &str, ghosts: &str| {
        format!(
            "# vtk DataFile Version 3.0\nx\nASCII\nDATASET {kind}\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n{cells}\n\
             POINT_DATA 4\nSCALARS vtkGhostType unsigned_char 1\nLOOKUP_TABLE default\n{ghosts}\n"
        )
        .into_bytes()
    };
    let drawn = |bytes: &[u8]| {
        let model = read(bytes);
        (model.mesh.triangles.len(), model.strokes.segments.len())
    };
    let cells = "CELLS 3 12\n4 0 1 2 3 3 0 1 3 2 0 1\nCELL_TYPES 3\n10 5 3";
    assert_eq!(drawn(&file("UNSTRUCTURED_GRID", cells, "1 0 0 0")), (5, 1));
    assert_eq!(drawn(&file("UNSTRUCTURED_GRID", cells, "2 0 0 0")), (1, 0));
    assert_eq!(drawn(&file("UNSTRUCTURED_GRID", cells, "0 0 2 0")), (2, 1));
    // VTK draws polygons all the same.
    assert_eq!(drawn(&file("POLYDATA", "POLYGONS 1 4\n3 0 1 2", "2 0 0 0")), (1, 0));
}

/// An XML file with a triangle and three values of two bits: `array` is the text of an element, `end` follows all.
fn bits(attributes: &str, of_file: &str, array: &str, end: &[u8]) -> Vec<u8> {
    let mut file = format!(
        "<VTKFile type=\"PolyData\"{of_file}><PolyData><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><PointData>\
         <DataArray type=\"Bit\" Name=\"mask\" NumberOfComponents=\"5\" {attributes}>{array}</DataArray></PointData>\
         <Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">0 0 0 1 0 0 0 1 0</DataArray></Points><Polys>\
         <DataArray type=\"Int32\" Name=\"connectivity\">0 1 2</DataArray>\
         <DataArray type=\"Int32\" Name=\"offsets\">3</DataArray></Polys></Piece></PolyData>"
    )
    .into_bytes();
    file.extend(end);
    file
}

#[test]
fn bits_are_read_from_every_encoding() {
    let expected = [[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let check = |what: &str, file: &[u8]| {
        let model = read(file);
        for (component, expected) in expected.iter().enumerate() {
            assert_eq!(values(&model, &format!("mask:{component}")), expected, "{what}");
        }
        assert!(model.report.warnings.is_empty(), "{what}: {:?}", model.report.warnings);
    };
    let packed = [0b1011_0010, 0b0010_0010];
    let head = 2u32.to_le_bytes();
    let raw = [&head[..], &packed].concat();
    check("text", &bits("format=\"ascii\"", "", "1 0 1 1 0 0 1 0 0 0 1 0 0 0 1", b"</VTKFile>"));
    check("base64", &bits("format=\"binary\"", "", &STANDARD.encode(&raw), b"</VTKFile>"));
    // A block of LZ4 that holds nothing but literals.
    let sizes: Vec<u8> = [1u32, 32, 2, 3].into_iter().flat_map(u32::to_le_bytes).collect();
    let block = [&[0x20][..], &packed].concat();
    let lz4 = " compressor=\"vtkLZ4DataCompressor\"";
    let text = STANDARD.encode(&sizes) + &STANDARD.encode(&block);
    check("compressed", &bits("format=\"binary\"", lz4, &text, b"</VTKFile>"));
    let appended = |encoding: &str, data: &[u8]| {
        let open = format!("<AppendedData encoding=\"{encoding}\">_");
        [open.as_bytes(), data, b"</AppendedData></VTKFile>"].concat()
    };
    let at_start = "format=\"appended\" offset=\"0\"";
    check("raw", &bits(at_start, "", "", &appended("raw", &raw)));
    check("raw, compressed", &bits(at_start, lz4, "", &appended("raw", &[sizes, block].concat())));
    check("appended base64", &bits(at_start, "", "", &appended("base64", STANDARD.encode(&raw).as_bytes())));

    let long = STANDARD.encode([&3u32.to_le_bytes()[..], &packed, &[0]].concat());
    let Err(error) = try_read(&bits("format=\"binary\"", "", &long, b"</VTKFile>")) else {
        panic!("too many bytes")
    };
    assert!(error.to_string().contains("array \"mask\", 15 bits in 2 bytes, found 3 bytes"), "{error}");
    let Err(few) = try_read(&bits("format=\"ascii\"", "", "1 0 1", b"</VTKFile>")) else {
        panic!("too few bits")
    };
    assert!(few.to_string().contains("3 tuples of array \"mask\""), "{few}");
}

#[test]
fn components_have_the_names_of_the_file() {
    let names = |bytes: &[u8]| -> Vec<(String, Option<String>)> {
        let mesh = read(bytes).mesh;
        mesh.attributes.into_iter().map(|a| (a.name, a.component)).collect()
    };
    let named = |name: &str, component: Option<&str>| (name.to_owned(), component.map(str::to_owned));
    let xml = "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\">\
        <PointData><DataArray type=\"Float32\" Name=\"s\" NumberOfComponents=\"2\" ComponentName1=\"syy\" format=\"ascii\">\
        1 2 3 4 5 6</DataArray><DataArray type=\"Float32\" Name=\"p\" format=\"ascii\">1 2 3</DataArray></PointData>\
        <Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points>\
        <Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray>\
        <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray></Polys></Piece></PolyData></VTKFile>";
    let expected = [named("s:0", None), named("s:1", Some("syy")), named("p", None)];
    assert_eq!(names(xml.as_bytes()), expected);
    let metadata = "METADATA\nCOMPONENT_NAMES\ns%20xx\nsyy\nINFORMATION 0\n\n";
    let front = "# vtk DataFile Version 5.1\n\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n\
        METADATA\nINFORMATION 0\n\nPOLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2\nPOINT_DATA 3\n";
    let expected = [named("s:0", Some("s xx")), named("s:1", Some("syy")), named("p", None)];
    let field = format!("{front}FIELD f 2\ns 2 3 float\n1 2 3 4 5 6\n{metadata}p 1 3 float\n1 2 3\n");
    assert_eq!(names(field.as_bytes()), expected);
    let scalars = format!(
        "{front}SCALARS s float 2\nLOOKUP_TABLE default\n1 2 3 4 5 6\n{metadata}SCALARS p float\n1 2 3\n"
    );
    assert_eq!(names(scalars.as_bytes()), expected);
}

/// The time of a legacy file is found wherever its field is before the data of points and cells.
#[test]
fn times_are_before_the_data() {
    let time = |bytes: &[u8]| {
        let options = ReadOptions::default();
        super::time(&Input::from_bytes("a", bytes.to_vec(), &options).expect("bytes"), &options)
    };
    for (kind, points, cells, number) in [
        ("ASCII", &b"0 0 0 1 0 0 0 1 0\n"[..], &b"3 0 1 2\n"[..], &b"2.5\n"[..]),
        ("BINARY", &[0; 36], &[0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2], &[0x40, 0x20, 0, 0]),
    ] {
        let head = format!("# vtk DataFile Version 3.0\nx\n{kind}\n");
        let field = [&b"FIELD FieldData 1\nTIME 1 1 float\n"[..], number].concat();
        let parts = [
            &b"DATASET POLYDATA\n"[..],
            b"POINTS 3 float\n",
            points,
            b"POLYGONS 1 4\n",
            cells,
            b"CELL_DATA 1\n",
        ];
        for place in [1, 3, 5] {
            let (before, behind) = parts.split_at(place);
            let file = [head.as_bytes(), &before.concat(), &field, &behind.concat()].concat();
            assert_eq!(time(&file).expect(kind), Some(2.5), "{kind} {place}");
        }
        let without = [head.as_bytes(), &parts.concat()].concat();
        assert_eq!(time(&without).expect(kind), None, "{kind}");
        // An array of cells is none of the file.
        let behind = [&without[..], &field].concat();
        assert_eq!(time(&behind).expect(kind), None, "{kind}");
    }
}
