//! Files of some bytes that ask for much: numbers in a head may not cost more time or memory than the bytes behind them, or the
//! memory limit, allow. Each of them ran for seconds to minutes, took gigabytes, or overflowed.

use std::fmt::Write as _;
use std::io::Write as _;

use tercio_mesh::ReadError;
use tercio_mesh::io::input::Input;
use tercio_mesh::io::{ReadModel, ReadOptions, read_input};

fn try_read(bytes: &[u8], limit: u64) -> Result<ReadModel, ReadError> {
    let options = ReadOptions { memory_limit: Some(limit), ..ReadOptions::default() };
    read_input(&Input::from_bytes("a", bytes.to_vec(), &options)?, &options)
}

const LEGACY: &str = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n";

/// 300 arrays of 65,536 components of nothing would be 19.7 million attributes.
#[test]
fn arrays_of_no_tuples_are_no_attributes() {
    for (what, points) in [("POINT_DATA", "0 float"), ("CELL_DATA", "2 float\n0 0 0 1 1 1")] {
        let mut text = format!("{LEGACY}POINTS {points}\n{what} 0\nFIELD f 300\n");
        for number in 0..300 {
            let _ = writeln!(text, "a{number} 65536 0 int");
        }
        let model = try_read(text.as_bytes(), 64 << 20).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert!(model.mesh.attributes.is_empty() && model.strokes.attributes.is_empty(), "{what}");
    }
}

/// The name of an array stands before each of its components.
#[test]
fn names_of_components_are_counted() {
    let name = "n".repeat(3000);
    let mut of_vtk = format!("{LEGACY}POINTS 1 float\n0 0 0\nPOINT_DATA 1\nSCALARS {name} int 4000\n");
    of_vtk.push_str("LOOKUP_TABLE default\n");
    of_vtk.push_str(&"1 ".repeat(4000));
    let of_pcd = format!(
        "VERSION 0.7\nFIELDS x y z {name}\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 4000\nPOINTS 0\nDATA ascii\n"
    );
    for (what, text) in [("VTK", of_vtk), ("PCD", of_pcd)] {
        let error = try_read(text.as_bytes(), 8 << 20).expect_err(what);
        assert!(matches!(error, ReadError::MemoryLimit { .. }), "{what}: {error}");
        assert!(try_read(text.as_bytes(), 1 << 30).is_ok(), "{what}");
    }
}

/// Two pieces that share one block of 65,536 numbers: attributes are not searched for one by one.
#[test]
fn pieces_with_very_many_attributes_are_joined() {
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    packed.write_all(&[7; 65536]).unwrap();
    let packed = packed.finish().unwrap();
    let head = [1u32, 65536, 0, packed.len() as u32].map(u32::to_le_bytes).concat();
    let points =
        "<Points><DataArray type='Float32' NumberOfComponents='3' format='ascii'>0 0 0</DataArray></Points>";
    let data = "<PointData><DataArray type='UInt8' Name='a' NumberOfComponents='65536' format='appended' offset='0'/></PointData>";
    let piece = format!("<Piece NumberOfPoints='1'>{points}{data}</Piece>");
    let before = format!(
        "<VTKFile type='PolyData' byte_order='LittleEndian' header_type='UInt32' compressor='vtkZLibDataCompressor'><PolyData>\
         {piece}{piece}</PolyData><AppendedData encoding='raw'>_"
    );
    let bytes = [before.as_bytes(), &head, &packed, b"</AppendedData></VTKFile>"].concat();
    let model = try_read(&bytes, 1 << 30).unwrap_or_else(|e| panic!("{e}"));
    let attributes = &model.mesh.attributes;
    assert_eq!((attributes.len(), &attributes[65535].name[..]), (65536, "a:65535"));
    assert!(attributes.iter().all(|a| a.values == [7.0, 7.0]));
    // 120 bytes and more for each of them.
    let error = try_read(&bytes, 16 << 20).expect_err("too little memory");
    assert!(matches!(error, ReadError::MemoryLimit { .. }), "{error}");
}

/// Errors name the line of an array, whatever order arrays are read in. The first 64 different warnings are reported, and the number of the rest.
#[test]
fn places_and_warnings_of_many_arrays() {
    let mut text = String::from(
        "<VTKFile type='PolyData' byte_order='LittleEndian'><PolyData>\n<Piece NumberOfPoints='2'>\n<PointData>\n",
    );
    // Those after the first are of arrays that were warned of before, which are not counted again.
    for number in (0..100).chain(0..100) {
        let _ =
            writeln!(text, "<DataArray type='Int32' Name='a{number}' format='ascii'>0 33554433</DataArray>");
    }
    let points = "<Points><DataArray type='Float32' NumberOfComponents='3' format='ascii'>0 0 0 1 1 1</DataArray></Points>";
    let whole = format!("{text}</PointData>\n{points}\n</Piece></PolyData></VTKFile>");
    let model = try_read(whole.as_bytes(), 64 << 20).unwrap_or_else(|e| panic!("{e}"));
    let warnings = &model.report.warnings;
    assert!(
        warnings.len() <= 66 && warnings.iter().any(|w| w == "36 more warnings of this kind"),
        "{warnings:?}"
    );
    for (from, to, line) in
        [("'a41' format='ascii'>0", "'a41' format='ascii'>x", 45), (">0 0 0 1", ">0 y 0 1", 205)]
    {
        let error = try_read(whole.replace(from, to).as_bytes(), 64 << 20).expect_err(to).to_string();
        assert!(error.starts_with(&format!("a: line {line}: ")), "{error}");
    }
}

/// Edges without properties have no bytes: three times 2^63 - 1 of them.
#[test]
fn numbers_of_edges_do_not_overflow() {
    let edges = "element edge 9223372036854775807\n".repeat(3);
    let vertices = "element vertex 2\nproperty char x\nproperty char y\nproperty char z\n";
    for face in ["2 0 1", "1 0"] {
        let faces = "element face 1\nproperty list uchar int vertex_indices\n";
        let text =
            format!("ply\nformat ascii 1.0\n{edges}{vertices}{faces}end_header\n0 0 0\n1 1 1\n{face}\n");
        let model = try_read(text.as_bytes(), 64 << 20).unwrap_or_else(|e| panic!("{face}: {e}"));
        assert_eq!(model.report.not_drawn.lines, u64::MAX, "{face}");
    }
}
