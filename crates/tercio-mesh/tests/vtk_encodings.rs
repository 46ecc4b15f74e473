//! The same model in every encoding of VTK's files, written here, and what is wrong with files that are cut or changed.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use tercio_mesh::AttributeDomain::{Triangle, Vertex};
use tercio_mesh::io::input::Input;
use tercio_mesh::io::{ReadModel, ReadOptions, read, read_input};
use tercio_mesh::{Attribute, ReadError};

/// Two tetrahedra with a common face, and a point that belongs to none.
const POINTS: [[f64; 3]; 6] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [9.0, 9.0, 9.0], [0.0, 0.0, -2.0]];
const CELLS: [[i64; 4]; 2] = [[0, 1, 2, 3], [0, 2, 1, 5]];
const VELOCITY: [[f32; 3]; 6] = [
    [0.5, 1.0, -1.0],
    [1.5, 2.0, f32::NAN],
    [2.5, 3.0, -3.0],
    [3.5, 4.0, -4.0],
    [4.5, 5.0, -5.0],
    [5.5, 6.0, -6.0],
];
const REGION: [i32; 2] = [7, -8];

fn try_read(bytes: &[u8]) -> Result<ReadModel, ReadError> {
    let options = ReadOptions { memory_limit: Some(64 << 20), ..ReadOptions::default() };
    read_input(&Input::from_bytes("a", bytes.to_vec(), &options)?, &options)
}

/// The surface of the two: three faces of each.
fn check(what: &str, bytes: &[u8]) {
    let model = try_read(bytes).unwrap_or_else(|e| panic!("{what}: {e}"));
    let mesh = &model.mesh;
    assert_eq!(mesh.positions.len(), 5, "{what}");
    assert_eq!(mesh.positions[3], [0.0, 0.0, 1.0], "{what}");
    assert_eq!(mesh.triangles, [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 4], [2, 1, 4], [1, 0, 4]], "{what}");
    assert_eq!(mesh.face_of_triangle.as_deref(), Some(&[0, 0, 0, 1, 1, 1][..]), "{what}");
    let value = |name: &str, domain| -> Vec<u32> {
        let is = |a: &&Attribute| a.name == name && a.domain == domain;
        let found = mesh.attributes.iter().find(is).unwrap_or_else(|| panic!("{what}: no {name}"));
        found.values.iter().map(|v| v.to_bits()).collect()
    };
    for k in 0..3 {
        let expected: Vec<u32> = [0, 1, 2, 3, 5].map(|p: usize| VELOCITY[p][k].to_bits()).into();
        assert_eq!(value(&format!("flow speed:{k}"), Vertex), expected, "{what}");
    }
    assert_eq!(value("region", Triangle), [7.0, 7.0, 7.0, -8.0, -8.0, -8.0].map(f32::to_bits), "{what}");
}

/// Writes numbers as text or as bytes.
fn numbers<T: ToString, const N: usize>(text: bool, values: &[T], bytes: impl Fn(&T) -> [u8; N]) -> Vec<u8> {
    let mut out = Vec::new();
    for value in values {
        if text {
            write!(out, "{} ", value.to_string().to_lowercase()).unwrap();
        } else {
            out.extend(bytes(value));
        }
    }
    out.push(b'\n');
    out
}

fn legacy(text: bool, offsets: bool) -> Vec<u8> {
    let kind = if text { "ASCII" } else { "BINARY" };
    let mut file =
        format!("# vtk DataFile Version 5.1\ntwo\n{kind}\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 double\n")
            .into_bytes();
    file.extend(numbers(text, POINTS.as_flattened(), |x| x.to_be_bytes()));
    if offsets {
        file.extend(b"CELLS 3 8\nOFFSETS vtktypeint64\n");
        file.extend(numbers(text, &[0i64, 4, 8], |x| x.to_be_bytes()));
        file.extend(b"CONNECTIVITY vtktypeint64\n");
        file.extend(numbers(text, CELLS.as_flattened(), |x| x.to_be_bytes()));
    } else {
        file.extend(b"CELLS 2 10\n");
        let list: Vec<i32> = CELLS.iter().flat_map(|c| [4].into_iter().chain(c.map(|v| v as i32))).collect();
        file.extend(numbers(text, &list, |x| x.to_be_bytes()));
    }
    file.extend(b"CELL_TYPES 2\n");
    file.extend(numbers(text, &[10i32, 10], |x| x.to_be_bytes()));
    file.extend(b"CELL_DATA 2\nSCALARS region int\nLOOKUP_TABLE default\n");
    file.extend(numbers(text, &REGION, |x| x.to_be_bytes()));
    file.extend(b"METADATA\nINFORMATION 1\nNAME L2_NORM LOCATION vtkDataArray\nDATA 1\n\n");
    file.extend(b"POINT_DATA 6\nFIELD more 1\nflow%20speed 3 6 float\n");
    file.extend(numbers(text, VELOCITY.as_flattened(), |x| x.to_be_bytes()));
    file
}

#[derive(Clone, Copy, Debug)]
struct Xml {
    ascii: bool,
    appended: bool,
    base64: bool,
    big_endian: bool,
    wide: bool,
    compressor: Option<&'static str>,
}

impl Xml {
    fn word(&self, n: usize) -> Vec<u8> {
        match (self.wide, self.big_endian) {
            (true, true) => (n as u64).to_be_bytes().to_vec(),
            (true, false) => (n as u64).to_le_bytes().to_vec(),
            (false, true) => (n as u32).to_be_bytes().to_vec(),
            (false, false) => (n as u32).to_le_bytes().to_vec(),
        }
    }

    /// An array with its head.
    fn encode(&self, bytes: &[u8]) -> Vec<u8> {
        const BLOCK: usize = 32;
        let text =
            |bytes: &[u8]| if self.base64 { STANDARD.encode(bytes).into_bytes() } else { bytes.to_vec() };
        let Some(compressor) = self.compressor else {
            return text(&[&self.word(bytes.len())[..], bytes].concat());
        };
        let blocks: Vec<Vec<u8>> = bytes
            .chunks(BLOCK)
            .map(|block| match compressor {
                "vtkZLibDataCompressor" => {
                    let mut zlib =
                        flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
                    zlib.write_all(block).unwrap();
                    zlib.finish().unwrap()
                }
                // A block of LZ4 that holds nothing but literals.
                _ if block.len() < 15 => [&[(block.len() as u8) << 4][..], block].concat(),
                _ => [&[0xf0, block.len() as u8 - 15][..], block].concat(),
            })
            .collect();
        let sizes = [blocks.len(), BLOCK, bytes.len() % BLOCK].into_iter().chain(blocks.iter().map(Vec::len));
        let head: Vec<u8> = sizes.flat_map(|n| self.word(n)).collect();
        [text(&head), text(&blocks.concat())].concat()
    }

    fn file(&self) -> Vec<u8> {
        let mut data = Vec::new();
        let (ascii, big) = (self.ascii, self.big_endian);
        let mut array = |kind: &str, name: &str, components: usize, mut bytes: Vec<u8>| {
            let open =
                format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
            if ascii {
                return format!(
                    "{open} format=\"ascii\">\n{}</DataArray>\n",
                    String::from_utf8(bytes).unwrap()
                );
            }
            bytes.pop();
            if self.appended {
                let offset = data.len();
                data.extend(self.encode(&bytes));
                return format!("{open} format=\"appended\" offset=\"{offset}\"/>\n");
            }
            let text = String::from_utf8(self.encode(&bytes)).unwrap();
            format!("{open} format=\"binary\">\n  {text}\n</DataArray>\n")
        };
        let double = |x: &f64| if big { x.to_be_bytes() } else { x.to_le_bytes() };
        let single = |x: &f32| if big { x.to_be_bytes() } else { x.to_le_bytes() };
        let long = |x: &i64| if big { x.to_be_bytes() } else { x.to_le_bytes() };
        let int = |x: &i32| if big { x.to_be_bytes() } else { x.to_le_bytes() };
        let points = array("Float64", "Points", 3, numbers(ascii, POINTS.as_flattened(), double));
        let connectivity = array("Int64", "connectivity", 1, numbers(ascii, CELLS.as_flattened(), long));
        let offsets = array("Int32", "offsets", 1, numbers(ascii, &[4, 8], int));
        let types = array("UInt8", "types", 1, numbers(ascii, &[10u8, 10], |x| [*x]));
        let velocity = array("Float32", "flow speed", 3, numbers(ascii, VELOCITY.as_flattened(), single));
        let region = array("Int32", "region", 1, numbers(ascii, &REGION, int));
        let order = if big { "BigEndian" } else { "LittleEndian" };
        let header = if self.wide { "UInt64" } else { "UInt32" };
        let compressor = self.compressor.map_or(String::new(), |c| format!(" compressor=\"{c}\""));
        let mut file = format!(
            "<?xml version=\"1.0\"?>\n<!-- a -->\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
             byte_order=\"{order}\" header_type=\"{header}\"{compressor}>\n<UnstructuredGrid>\n\
             <Piece NumberOfPoints=\"6\" NumberOfCells=\"2\">\n<PointData>\n{velocity}</PointData>\n<CellData>\n\
             {region}</CellData>\n<Points>\n{points}</Points>\n<Cells>\n{connectivity}{offsets}{types}</Cells>\n\
             </Piece>\n</UnstructuredGrid>\n"
        )
        .into_bytes();
        if self.appended {
            let encoding = if self.base64 { "base64" } else { "raw" };
            file.extend(format!("<AppendedData encoding=\"{encoding}\">\n  _").into_bytes());
            file.extend(data);
            file.extend(b"\n</AppendedData>\n");
        }
        file.extend(b"</VTKFile>\n");
        file
    }
}

fn all() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for text in [false, true] {
        for offsets in [false, true] {
            files.push((format!("legacy, text {text}, offsets {offsets}"), legacy(text, offsets)));
        }
    }
    let mut xml = |xml: Xml| files.push((format!("{xml:?}"), xml.file()));
    let ascii =
        Xml { ascii: true, appended: false, base64: false, big_endian: false, wide: false, compressor: None };
    xml(ascii);
    for (appended, base64) in [(false, true), (true, true), (true, false)] {
        for (big_endian, wide) in [(false, false), (true, false), (false, true), (true, true)] {
            for compressor in [None, Some("vtkZLibDataCompressor"), Some("vtkLZ4DataCompressor")] {
                xml(Xml { ascii: false, appended, base64, big_endian, wide, compressor });
            }
        }
    }
    files
}

#[test]
fn every_encoding_gives_the_same_model() {
    let files = all();
    assert_eq!(files.len(), 4 + 1 + 36);
    files.iter().for_each(|(what, bytes)| check(what, bytes));
}

#[test]
fn lzma_is_read() {
    // Written by VTK 9.7.2.
    let array = |kind: &str, name: &str, components, text: &str| {
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">{text}</DataArray>"
        )
    };
    let points = "AQAAAACAAAAkAAAARAAAAA==/Td6WFoAAAFpIt42AsATJCEBFgDVqc1f4AAjAAtdAABszlC68jL3hAAAAACPcKOIAAEjJJsmLKKQQpkNAQAAAAABWVo=";
    let corners = "AQAAAACAAAAYAAAARAAAAA==/Td6WFoAAAFpIt42AsASGCEBFgD3L0Dw4AAXAApdAABqfrsUbxs9d+AAAADMXIxPAAEiGF1rWJSQQpkNAQAAAAABWVo=";
    let ends = "AQAAAACAAAAIAAAAPAAAAA==/Td6WFoAAAFpIt42AsAMCCEBFgCe23ypAQAHAwAAAAAAAAAAitit6wABHAhEYCrIkEKZDQEAAAAAAVla";
    let file = format!(
        "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\" compressor=\"vtkLZMADataCompressor\"><PolyData>\
         <Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><Points>{}</Points><Polys>{}{}</Polys></Piece></PolyData></VTKFile>",
        array("Float32", "Points", 3, points),
        array("Int64", "connectivity", 1, corners),
        array("Int64", "offsets", 1, ends)
    );
    let model = try_read(file.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(model.mesh.triangles, [[0, 1, 2]]);
    assert_eq!(model.mesh.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let damaged = try_read(file.replace("AtdAABszlC68", "AtdAABszlCaa").as_bytes()).unwrap_err().to_string();
    assert!(damaged.contains("block 0 of 1 of array \"Points\", compressed by LZMA"), "{damaged}");
}

/// An error names the place and is no panic, wherever a file ends or a byte is changed.
#[test]
fn damaged_files_give_errors_or_models() {
    for (what, bytes) in all() {
        for cut in (0..bytes.len().saturating_sub(2)).step_by(13) {
            // A legacy file may end after its cells.
            if let Err(error) = try_read(&bytes[..cut]) {
                assert!(error.to_string().starts_with("a: "), "{what}: {error}");
            }
        }
        let mut random = 1u32;
        for _ in 0..150 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let mut changed = bytes.clone();
            changed[(random >> 8) as usize % bytes.len()] = random as u8;
            if let Ok(model) = try_read(&changed) {
                let vertices = model.mesh.positions.len() as u32;
                assert!(model.mesh.triangles.iter().flatten().all(|&v| v < vertices), "{what}");
            }
        }
    }
}

#[test]
fn collections_are_one_model_and_name_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("a.vtk", &legacy(false, true));
    write("b.vtk", &legacy(true, false));
    write("p.pvtu", b"<VTKFile type=\"PUnstructuredGrid\"><PUnstructuredGrid><Piece Source=\"a.vtk\"/><Piece Source=\"no.vtu\"/></PUnstructuredGrid></VTKFile>");
    write("m.vtm", b"<VTKFile type=\"vtkMultiBlockDataSet\"><vtkMultiBlockDataSet><Block index=\"0\"><DataSet index=\"0\" file=\"p.pvtu\"/></Block><DataSet index=\"1\" file=\"b.vtk\"/></vtkMultiBlockDataSet></VTKFile>");
    write("t.pvd", b"<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"2\" file=\"m.vtm\"/><DataSet timestep=\"1\" file=\"b.vtk\"/></Collection></VTKFile>");
    write(
        "self.pvd",
        b"<VTKFile type=\"Collection\"><Collection><DataSet file=\"self.pvd\"/></Collection></VTKFile>",
    );
    write(
        "none.pvd",
        b"<VTKFile type=\"Collection\"><Collection><DataSet file=\"x.vtp\"/></Collection></VTKFile>",
    );
    let options = ReadOptions::default();
    let open = |name: &str| read(folder.path().join(name), &options);
    let model = open("m.vtm").unwrap();
    assert_eq!((model.mesh.triangles.len(), model.mesh.positions.len()), (12, 10));
    assert_eq!(model.mesh.triangles[6], [5, 6, 8]);
    assert_eq!(model.mesh.face_of_triangle.unwrap(), [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3]);
    assert_eq!(model.report.warnings, ["1 file of the model not found: no.vtu"]);
    assert!(model.report.companions.iter().any(|c| c.ends_with("a.vtk")), "{:?}", model.report.companions);
    let first = open("t.pvd").unwrap();
    assert_eq!(first.mesh.triangles.len(), 6);
    assert_eq!(first.report.warnings, ["holds 2 times, of which the first is read, 1"]);
    // One that no output may replace, though it is of another time.
    assert!(first.report.companions.iter().any(|c| c.ends_with("m.vtm")), "{:?}", first.report.companions);
    let at = |step| read(folder.path().join("t.pvd"), &ReadOptions { step: Some(step), ..options });
    let (first, second) = (at(0).unwrap(), at(1).unwrap());
    assert_eq!((first.mesh.triangles.len(), second.mesh.triangles.len()), (6, 12));
    assert!(first.report.warnings.is_empty(), "{:?}", first.report.warnings);
    assert!(at(2).unwrap_err().to_string().contains("a time of number 2, found 2 times"));
    let times = |name: &str| {
        let input = tercio_mesh::io::input::open(folder.path().join(name), &options).unwrap();
        tercio_mesh::io::vtk::times(&input, &options).unwrap()
    };
    assert_eq!((times("t.pvd"), times("m.vtm"), times("a.vtk")), (vec![1.0, 2.0], vec![], vec![]));
    let message = |name| open(name).expect_err(name).to_string();
    assert!(message("self.pvd").contains("a collection inside itself"), "{}", message("self.pvd"));
    assert!(
        message("none.pvd").contains("its files beside it (x.vtp), found none"),
        "{}",
        message("none.pvd")
    );
}

/// The faces between the pieces of a grid are inside, whether the pieces are in files of their own or in one; towards a piece that is
/// missing there is an outside.
#[test]
fn pieces_of_a_grid_have_no_walls_between_them() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).unwrap();
    let coordinates = |[low, high]: [i64; 2]| {
        let numbers: Vec<String> = (low..=high).map(|n| (n as f64 * 0.5).to_string()).collect();
        format!("<DataArray type=\"Float32\" format=\"ascii\">{}</DataArray>", numbers.join(" "))
    };
    let text = |extent: &[[i64; 2]; 3]| {
        extent.as_flattened().iter().map(i64::to_string).collect::<Vec<_>>().join(" ")
    };
    let piece = |kind: &str, extent: &[[i64; 2]; 3]| {
        let inner = match kind {
            "RectilinearGrid" => format!("<Coordinates>{}</Coordinates>", extent.map(coordinates).concat()),
            _ => String::new(),
        };
        format!("<Piece Extent=\"{}\">{inner}</Piece>", text(extent))
    };
    let file = |kind: &str, pieces: &str| {
        format!("<VTKFile type=\"{kind}\"><{kind} Spacing=\"0.5 0.5 0.5\">{pieces}</{kind}></VTKFile>")
    };
    // Cut along two axes at different places, with numbers below 0.
    let extents = [
        [[-3, 1], [0, 2], [4, 9]],
        [[1, 5], [0, 2], [4, 9]],
        [[-3, 2], [2, 6], [4, 9]],
        [[2, 5], [2, 6], [4, 9]],
    ];
    let triangles = |[x, y, z]: [usize; 3]| 4 * (x * y + y * z + z * x);
    for (kind, ending) in [("ImageData", "vti"), ("RectilinearGrid", "vtr")] {
        let mut sources = String::new();
        for (number, extent) in extents.iter().enumerate() {
            write(&format!("{number}.{ending}"), file(kind, &piece(kind, extent)));
            sources += &format!("<Piece Extent=\"{}\" Source=\"{number}.{ending}\"/>", text(extent));
        }
        write("all.xml", file(&format!("P{kind}"), &sources));
        let pieces = extents.iter().map(|extent| piece(kind, extent)).collect::<String>();
        write("one.xml", file(kind, &pieces));
        write("whole.xml", file(kind, &piece(kind, &[[-3, 5], [0, 6], [4, 9]])));
        let options = ReadOptions::default();
        let surface = |name: &str| {
            let mesh = read(folder.path().join(name), &options).unwrap().mesh;
            let corner = |&v: &u32| mesh.positions[v as usize].map(f32::to_bits);
            let mut faces: Vec<_> = mesh.triangles.iter().map(|t| t.each_ref().map(corner)).collect();
            faces.sort_unstable();
            faces
        };
        let whole = surface("whole.xml");
        assert_eq!(whole.len(), triangles([8, 6, 5]));
        assert_eq!(surface("all.xml"), whole, "{kind}");
        assert_eq!(surface("one.xml"), whole, "{kind}");
        std::fs::remove_file(folder.path().join(format!("0.{ending}"))).unwrap();
        // Without its outside, and with what it touched: 2 x 5 faces of one neighbour, 4 x 5 of the other.
        let lost = 2 * (2 * 4 * 2 + 4 * 5 + 2 * 5);
        assert_eq!(surface("all.xml").len(), whole.len() - lost + 2 * (2 * 5 + 4 * 5), "{kind}");
    }
}

/// The time of a file is that of its field data, in all encodings, and a file without them has none.
#[test]
fn files_have_a_time() {
    let time = |bytes: &[u8]| {
        let options = ReadOptions::default();
        let input = Input::from_bytes("a", bytes.to_vec(), &options).unwrap();
        tercio_mesh::io::vtk::time(&input, &options).map_err(|e| e.to_string())
    };
    for (what, bytes) in all() {
        assert_eq!(time(&bytes), Ok(None), "{what}");
    }
    let xml = |name: &str, number: &str| {
        format!(
            "<VTKFile type=\"PolyData\"><PolyData><FieldData><DataArray type=\"Int32\" Name=\"CYCLE\" NumberOfTuples=\"1\" format=\"ascii\">7</DataArray>\
             <DataArray type=\"Float64\" Name=\"{name}\" NumberOfTuples=\"1\" format=\"ascii\">{number}</DataArray></FieldData></PolyData></VTKFile>"
        )
    };
    assert_eq!(time(xml("TimeValue", "0.25").as_bytes()), Ok(Some(0.25)));
    assert_eq!(time(xml("TIME", "-3").as_bytes()), Ok(Some(-3.0)));
    assert_eq!(time(xml("time", "1").as_bytes()), Ok(None));
    assert_eq!(time(xml("TimeValue", "").as_bytes()), Ok(None));
    assert_eq!(time(xml("TimeValue", "nan").as_bytes()), Ok(None));
    let legacy = |fields: &str| {
        format!("# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n{fields}POINTS 0 float\n")
    };
    let fields = "FIELD FieldData 2\nCYCLE 1 1 int\n7\nTIME 1 1 double\n1.5\n";
    assert_eq!(time(legacy(fields).as_bytes()), Ok(Some(1.5)));
    assert_eq!(time(legacy("").as_bytes()), Ok(None));
    // Of points, an array of this name is data.
    let data = format!("{}POINT_DATA 0\n{fields}", legacy(""));
    assert_eq!(time(data.as_bytes()), Ok(None));
    let binary = [&b"# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nFIELD FieldData 1\nTimeValue 1 1 double\n"[..], &2.5f64.to_be_bytes(), b"\nPOINTS 0 float\n"].concat();
    assert_eq!(time(&binary), Ok(Some(2.5)));
}

/// Beside cells that are hidden there is an outside.
#[test]
fn hidden_cells_of_a_piece_hide_no_faces_of_another() {
    let piece = |extent: &str, hidden: &str| {
        let array =
            format!("<DataArray type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">{hidden}</DataArray>");
        let array = if hidden.is_empty() { String::new() } else { array };
        format!("<Piece Extent=\"{extent}\"><CellData>{array}</CellData></Piece>")
    };
    let triangles = |pieces: &[String]| {
        let file =
            format!("<VTKFile type=\"ImageData\"><ImageData>{}</ImageData></VTKFile>", pieces.concat());
        try_read(file.as_bytes()).unwrap_or_else(|e| panic!("{e}")).mesh.triangles.len()
    };
    let first = piece("0 2 0 2 0 2", "");
    assert_eq!(triangles(std::slice::from_ref(&first)), 48);
    assert_eq!(triangles(&[first.clone(), piece("2 4 0 2 0 2", "")]), 80);
    assert_eq!(triangles(&[first.clone(), piece("2 4 0 2 0 2", "32 32 32 32 32 32 32 32")]), 48);
    // Half of the cells, which are open towards the other half.
    assert_eq!(triangles(&[first, piece("2 4 0 2 0 2", "32 0 32 0 32 0 32 0")]), 48 + 2 * (4 + 4 + 8));
}
