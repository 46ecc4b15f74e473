//! Small valid files as seeds for fuzzing: made here, and copied from the test data where it is available.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;

use anyhow::Result;
use flate2::Compression;
use flate2::write::GzEncoder;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::io::prepared;
use tercio_mesh::{Attribute, AttributeDomain, Mesh, OctNormal};

use super::Target;

/// Writes the seeds of a target into its corpus and returns their number.
///
/// # Errors
/// The file system's reason.
pub fn write(target: Target, corpus: &Path, largest: u64) -> Result<usize> {
    let mut count = 0;
    for (number, seed) in made(target).into_iter().enumerate() {
        fs::write(corpus.join(format!("seed-{number:02}")), seed)?;
        count += 1;
    }
    if let Some(data) = tercio_testkit::shared_data() {
        count += copy_small(&data, &data, extensions(target), corpus, largest)?;
    }
    Ok(count)
}

fn extensions(target: Target) -> &'static [&'static str] {
    match target {
        Target::Ply => &["ply"],
        Target::Obj => &["obj"],
        Target::Stl => &["stl"],
        Target::Off => &["off"],
        Target::Pcd => &["pcd"],
        Target::Las => &["las", "laz"],
        Target::Xyz => &["xyz", "pts", "txt", "csv"],
        Target::Vtk => &["vtk", "vtp", "vtu", "vti", "vts", "vtr"],
        Target::SniffRead => &["ply", "obj", "stl", "off", "gz"],
        Target::Picture => &["ply", "obj", "stl", "off"],
        Target::Prepared | Target::CameraPath | Target::ColorMap | Target::SceneFile => &[],
    }
}

/// Copies the files in `folder` and its subfolders that are small and have one of the endings, under names that show
/// where they come from.
fn copy_small(folder: &Path, data: &Path, ends: &[&str], corpus: &Path, largest: u64) -> Result<usize> {
    let mut count = 0;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        if entry.file_type()?.is_dir() {
            count += copy_small(&path, data, ends, corpus, largest)?;
            continue;
        }
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        if ends.contains(&extension.as_str()) && entry.metadata()?.len() <= largest {
            let below = path.strip_prefix(data).unwrap_or(&path).to_string_lossy().replace('/', "-");
            // Read and written, not copied: the data is read-only, and a copy would be, too.
            fs::write(corpus.join(format!("shared-{below}")), fs::read(&path)?)?;
            count += 1;
        }
    }
    Ok(count)
}

fn made(target: Target) -> Vec<Vec<u8>> {
    match target {
        Target::Ply => ply(),
        Target::Obj => obj(),
        Target::Stl => stl(),
        Target::Off => off(),
        Target::Vtk => vtk(),
        Target::Pcd => pcd(),
        Target::Las => las(),
        Target::Xyz => xyz(),
        Target::Picture => [ply(), obj(), stl(), off(), vtk()].concat(),
        Target::Prepared => prepared(),
        Target::CameraPath => camera_path(),
        Target::ColorMap => color_maps(),
        Target::SceneFile => scene_files(),
        Target::SniffRead => {
            let plain = [ply(), obj(), stl(), off(), vtk(), las(), xyz()].concat();
            let packed: Vec<_> = plain.iter().map(|bytes| gzip(bytes)).collect();
            [plain, packed].concat()
        }
    }
}

/// The three formats of keyframes.
fn camera_path() -> Vec<Vec<u8>> {
    let csv = "# turn\ntime,eye_x,eye_y,eye_z,target_x,target_y,target_z,up_x,up_y,up_z,fov\n0,0,0,5,0,0,0,0,1,0,30\n1.5,5,0,0,,,,,,,\n2,0,0,5,0,0,0,0,1,0,30\n";
    let json = r#"{"keyframes": [{"time": 0, "eye": [1, 2, 3]}, {"time": 1e1, "eye": [-1, 2, 3], "target": [0, 0, 0], "up": [0, 0, 1], "fov": 45}]}"#;
    let toml =
        "[[keyframes]]\ntime = 0\neye = [0, 1, 5]\n\n[[keyframes]]\ntime = 1.25\neye = [5, 1, 0]\nfov = 20\n";
    [csv, json, toml].map(|text| text.as_bytes().to_vec()).to_vec()
}

/// A scene, another one written inline, and a configuration.
fn scene_files() -> Vec<Vec<u8>> {
    let scene = "# parts\nsize = [640, 480]\nview = \"iso\"\nlight = [\"head\", \"dir:1,1,0\"]\n\n[[model]]\nfile = \"a.ply\"\n\
                 opacity = 0.5\n[[model.instance]]\ntranslate = [1, -2.5e3, 0x1f]\n[[model]]\nfile = 'b.stl'\nedges = true\n";
    let inline = "model = [{ file = 'a', instance = [{ scale = 2 }], categories = { 1 = \"bone\" } }]\n";
    let configuration = "background = 'white'\n[pattern.\"*.stl\"]\nup-axis = 'z'\n";
    [scene, inline, configuration].map(|text| text.as_bytes().to_vec()).to_vec()
}

fn color_maps() -> Vec<Vec<u8>> {
    let json = br#"[{"Name": "m", "RGBPoints": [-1, 0, 0, 0, 0, 1, 0.5, 0, 1, 1, 1, 1]}]"#;
    let lists: [&[u8]; 4] = [
        b"#000000\n#ff8000\n",
        b"r,g,b\n0, 0, 0\n1, 0.5, 1\n",
        b"# map\n0 0 0 0\n5 1 0 0\n9 1 1 1\n",
        b"0 0 0\n255 128 9",
    ];
    lists.into_iter().chain([&json[..]]).map(<[u8]>::to_vec).collect()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    // Writing to a vector does not fail.
    encoder.write_all(bytes).and_then(|()| encoder.finish()).unwrap_or_default()
}

/// The corners of a tetrahedron; its faces are the four triples of corners.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.5]];
const FACES: [[u8; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

#[derive(Clone, Copy)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

/// Writes the values of a PLY body with their declared types.
struct Body {
    encoding: Encoding,
    bytes: Vec<u8>,
}

impl Body {
    /// One value of the scalar type that PLY calls `kind`.
    fn put(&mut self, kind: &str, value: f64) {
        let big = match kind {
            _ if matches!(self.encoding, Encoding::Ascii) => {
                self.bytes.extend(format!("{value} ").as_bytes());
                return;
            }
            "char" | "int8" => (value as i8).to_be_bytes().to_vec(),
            "uchar" | "uint8" => (value as u8).to_be_bytes().to_vec(),
            "short" | "int16" => (value as i16).to_be_bytes().to_vec(),
            "ushort" | "uint16" => (value as u16).to_be_bytes().to_vec(),
            "int" | "int32" => (value as i32).to_be_bytes().to_vec(),
            "uint" | "uint32" => (value as u32).to_be_bytes().to_vec(),
            "float" | "float32" => (value as f32).to_be_bytes().to_vec(),
            _ => value.to_be_bytes().to_vec(),
        };
        match self.encoding {
            Encoding::Little => self.bytes.extend(big.iter().rev()),
            _ => self.bytes.extend(big),
        }
    }

    fn end_of_element(&mut self) {
        if matches!(self.encoding, Encoding::Ascii) {
            self.bytes.push(b'\n');
        }
    }
}

fn ply() -> Vec<Vec<u8>> {
    let plain = [("x", "float"), ("y", "float"), ("z", "float")];
    let everything = [
        ("x", "double"),
        ("y", "float64"),
        ("z", "float32"),
        ("nx", "float"),
        ("ny", "float"),
        ("nz", "float"),
        ("red", "uchar"),
        ("green", "uint8"),
        ("blue", "uchar"),
        ("alpha", "uchar"),
        ("s", "float"),
        ("t", "float"),
        ("a", "char"),
        ("b", "short"),
        ("c", "ushort"),
        ("d", "int"),
        ("e", "uint32"),
        ("confidence", "int16"),
    ];
    let mut files = Vec::new();
    for encoding in [Encoding::Ascii, Encoding::Little, Encoding::Big] {
        files.push(ply_file(encoding, &plain, ("uchar", "int"), false));
        files.push(ply_file(encoding, &everything, ("ushort", "uint"), false));
        files.push(ply_file(encoding, &plain, ("int", "short"), true));
    }
    files
}

/// A tetrahedron with these vertex properties; `list` has the types of a list's count and of its values. The faces are
/// polygons with colours, or one triangle strip.
fn ply_file(encoding: Encoding, vertex: &[(&str, &str)], list: (&str, &str), strips: bool) -> Vec<u8> {
    let word = match encoding {
        Encoding::Ascii => "ascii",
        Encoding::Little => "binary_little_endian",
        Encoding::Big => "binary_big_endian",
    };
    let mut header = format!("ply\nformat {word} 1.0\ncomment a seed\nobj_info none\nelement vertex 4\n");
    for (name, kind) in vertex {
        let _ = writeln!(header, "property {kind} {name}");
    }
    let (count, index) = list;
    if strips {
        let _ = write!(header, "element tristrips 1\nproperty list {count} {index} vertex_indices\n");
    } else {
        let _ = write!(header, "element face 4\nproperty list {count} {index} vertex_indices\n");
        header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
        header += "element edge 1\nproperty int vertex1\nproperty int vertex2\n";
    }
    header += "end_header\n";

    let mut body = Body { encoding, bytes: header.into_bytes() };
    for (number, corner) in CORNERS.iter().enumerate() {
        for (place, (_, kind)) in vertex.iter().enumerate() {
            let value = corner.get(place).map_or((number * place) as f64, |c| f64::from(*c));
            body.put(kind, value);
        }
        body.end_of_element();
    }
    if strips {
        let strip = [0, 2, 1, 3, -1, 2, 0, 3];
        body.put(count, strip.len() as f64);
        strip.iter().for_each(|corner| body.put(index, f64::from(*corner)));
        body.end_of_element();
        return body.bytes;
    }
    for face in FACES {
        body.put(count, 3.0);
        face.iter().for_each(|corner| body.put(index, f64::from(*corner)));
        (0..3).for_each(|channel| body.put("uchar", f64::from(channel) * 100.0));
        body.end_of_element();
    }
    [2.0, 3.0].iter().for_each(|corner| body.put("int", *corner));
    body.end_of_element();
    body.bytes
}

fn obj() -> Vec<Vec<u8>> {
    let texts = [
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "# all kinds of corners\nmtllib a.mtl b.mtl\no thing\nv 0 0 0 1 0.5 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\n\
         v 0 1 0 1 1 1\nvt 0 0\nvt 1 0 0\nvt 1 1\nvt 0 1\nvn 0 0 1\ng left right\nusemtl red\ns 1\n\
         f 1 2 3\nf 1/1 2/2 3/3\nusemtl blue\ns off\nf 1//1 2//1 3//1\nf 1/1/1 2/2/1 3/3/1 4/4/1\n\
         f -4/-4/-1 -3/-3/-1 -2/-2/-1\nl 1 2 3\np 1\n",
        "v 0 0 0\r\nv 2 0 0\r\nv 2 2 0\r\nv 1 5e-1 0\r\nv 0 2 0\r\nf 1 2 \\\r\n 3 4 5\r\n",
    ];
    texts.map(|text| text.as_bytes().to_vec()).into()
}

fn stl() -> Vec<Vec<u8>> {
    let mut text = String::new();
    for solid in ["one", "two words", ""] {
        let _ = writeln!(text, "solid {solid}");
        for face in FACES {
            text += "  facet normal 0 0 1\n    outer loop\n";
            for corner in face {
                let [x, y, z] = CORNERS[usize::from(corner)];
                let _ = writeln!(text, "      vertex {x:e} {y} {z}");
            }
            text += "    endloop\n  endfacet\n";
        }
        let _ = writeln!(text, "endsolid {solid}");
    }
    let binary = |title: &[u8], attribute: u16| {
        let mut bytes = title.to_vec();
        bytes.resize(80, b' ');
        bytes.extend((FACES.len() as u32).to_le_bytes());
        for face in FACES {
            bytes.extend([0; 12]);
            let corners = face.iter().flat_map(|corner| CORNERS[usize::from(*corner)]);
            corners.for_each(|coordinate| bytes.extend(coordinate.to_le_bytes()));
            bytes.extend(attribute.to_le_bytes());
        }
        bytes
    };
    vec![
        text.into_bytes(),
        binary(b"seed", 0),
        binary(b"solid seed", 0),
        binary(b"COLOR=\x80\x40\x20\xff", 0x9234),
    ]
}

fn off() -> Vec<Vec<u8>> {
    let mut files = Vec::new();
    // The keyword, and what follows a vertex's coordinates.
    let dialects = [
        ("OFF", ""),
        ("COFF", " 255 128 0 255"),
        ("NOFF", " 0 0 1"),
        ("STOFF", " 0.5 0.25"),
        ("CNOFF", " 0 0 1 0.5 0.25 0 1"),
        ("STCNOFF", " 0 0 1 1 0 0 1 0.5 0.25"),
        ("4OFF", " 1"),
    ];
    for (word, tail) in dialects {
        let mut text = format!("{word}\n# a seed\n4 4 6\n");
        for [x, y, z] in CORNERS {
            let _ = writeln!(text, "{x} {y} {z}{tail}");
        }
        for ([a, b, c], color) in FACES.iter().zip(["", " 7", " 255 0 0", " 0.5 0.5 0.5 1.0"]) {
            let _ = writeln!(text, "3 {a} {b} {c}{color}");
        }
        files.push(text.into_bytes());
    }
    files.push(b"OFF 5 1 0 0 0 0 2 0 0 2 2 0 1 0.5 0 0 2 0 5 0 1 2 3 4\n".to_vec());
    files.push(b"nOFF\n2\n3 1 0\n0 0\n1 0\n0 1\n3 0 1 2\n".to_vec());
    for (big_endian, with_colors) in [(true, true), (false, true), (true, false)] {
        files.push(binary_off("OFF", &[], big_endian, with_colors));
    }
    let normal_and_color = [0.0, 0.0, 2.0, 1.0, 0.5, 0.25, 1.0];
    files.push(binary_off("CNOFF", &normal_and_color, true, true));
    files.push(binary_off("ST4OFF", &[1.0, 0.5, 0.25], true, true));
    files.push(binary_off("nOFF 5", &[1.0, 2.0], true, true));
    files
}

/// Two points in each encoding.
fn pcd() -> Vec<Vec<u8>> {
    let header = |data: &str| {
        format!(
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 2\n\
             HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA {data}\n"
        )
        .into_bytes()
    };
    let packed = [&[36, 0, 0, 0, 32, 0, 0, 0, 15][..], &[1; 16], &[15], &[2; 16]].concat();
    vec![
        [header("ascii"), b"0 0 1 255\n1 nan 2 65280\n".to_vec()].concat(),
        [header("binary"), vec![0x3f; 32]].concat(),
        [header("binary_compressed"), packed].concat(),
    ]
}

/// Three points in every format, not compressed, and a compressed file whose points are damaged.
fn las() -> Vec<Vec<u8>> {
    let sizes = [20u16, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];
    let file = |format: u8, size: u16, laszip: &[u8]| {
        let mut bytes = vec![0; 375];
        let begin = 375 + if laszip.is_empty() { 0 } else { 54 + laszip.len() as u32 };
        let mut put = |at: usize, with: &[u8]| bytes[at..at + with.len()].copy_from_slice(with);
        put(0, b"LASF");
        put(24, &[1, 4]);
        put(94, &375u16.to_le_bytes());
        put(96, &begin.to_le_bytes());
        put(100, &u32::from(!laszip.is_empty()).to_le_bytes());
        put(104, &[format]);
        put(105, &size.to_le_bytes());
        put(107, &3u32.to_le_bytes());
        (0..3).for_each(|k| put(131 + 8 * k, &0.01f64.to_le_bytes()));
        put(247, &3u64.to_le_bytes());
        if !laszip.is_empty() {
            let head = [
                &[0, 0][..],
                b"laszip encoded\0\0",
                &22204u16.to_le_bytes(),
                &[laszip.len() as u8, 0],
                &[0; 32],
            ];
            bytes.extend(head.concat());
            bytes.extend(laszip);
        }
        bytes.extend((0..3 * size).map(|i| (i % 7) as u8));
        bytes
    };
    let plain = sizes.iter().zip(0..).map(|(&size, format)| file(format, size, &[]));
    let item = |kind: u16, size: u16, version: u16| [kind, size, version].map(u16::to_le_bytes).concat();
    let laszip = |compressor: u8, items: &[u8]| {
        let head = [
            &[compressor, 0, 0, 0, 2, 2, 0, 0, 0, 0, 0, 0][..],
            &50_000u32.to_le_bytes(),
            &[255; 16],
            &[1, 0],
        ];
        [&head.concat()[..], items].concat()
    };
    let packed = [file(0x80, 20, &laszip(1, &item(6, 20, 2))), file(0x86, 30, &laszip(3, &item(10, 30, 3)))];
    plain.chain(packed).collect()
}

/// Text clouds of several dialects.
fn xyz() -> Vec<Vec<u8>> {
    let texts = [
        "0 0 0\n1 0 0\n0 1 nan\n",
        "2\n0 0 0 -5 255 0 9\n1 0 0 7 0 1 2\n",
        "//X,Y,Z,R,G,B,Intensity\n0,0,0,1,2,3,0.5\n1,0,2,1,2,3,\n",
        "x;y;z;name\n1;2;3;a\n4;5;6;b\n",
        "# c\n0 0 0 255 0 0 0 0 1\n0 1 0 255 0 0 0 0 1\n1 1 0 255 0 0 0 0 1\n",
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}

/// Polygons, a volume and grids, in text and in binary.
fn vtk() -> Vec<Vec<u8>> {
    let legacy =
        |kind: &str, body: &str| format!("# vtk DataFile Version 3.0\na seed\n{kind}\nDATASET {body}");
    let points: String = CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let faces: String = FACES.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n")).collect();
    let data = "CELL_DATA 4\nSCALARS id int 1\nLOOKUP_TABLE default\n1 2 3 4\nPOINT_DATA 4\nVECTORS v float\n\
                1 0 0 0 1 0 0 0 1 nan 0 0\nFIELD f 1\nt 1 4 double\n1 2 3 4\nMETADATA\nCOMPONENT_NAMES\nt\n\n";
    let polygons = format!(
        "POLYDATA\nPOINTS 4 float\n{points}VERTICES 1 2\n1 0\nLINES 1 3\n2 0 1\nPOLYGONS 4 16\n{faces}\
         TRIANGLE_STRIPS 1 5\n4 0 1 2 3\n"
    );
    let tetra =
        format!("UNSTRUCTURED_GRID\nPOINTS 4 double\n{points}CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n");
    let offsets = format!(
        "POLYDATA\nPOINTS 4 float\n{points}POLYGONS 5 12\nOFFSETS vtktypeint64\n0 3 6 9 12\nCONNECTIVITY \
         vtktypeint64\n0 2 1 0 1 3 1 2 3 2 0 3\n{data}"
    );
    let grid = "STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 2 3\nPOINT_DATA 8\nSCALARS s char\n\
                LOOKUP_TABLE default\n1 2 3 4 5 6 7 8\n";
    let lines = "RECTILINEAR_GRID\nDIMENSIONS 2 3 1\nX_COORDINATES 2 float\n0 1\nY_COORDINATES 3 float\n0 1 4\n\
                 Z_COORDINATES 1 float\n0\n";
    let mut files: Vec<Vec<u8>> =
        [&polygons, &tetra, &offsets, grid, lines].map(|body| legacy("ASCII", body).into_bytes()).into();
    let mut binary = legacy("BINARY", "POLYDATA\nPOINTS 4 float\n").into_bytes();
    binary.extend(CORNERS.as_flattened().iter().flat_map(|x| x.to_be_bytes()));
    binary.extend(b"\nPOLYGONS 4 16\n");
    binary.extend(FACES.iter().flat_map(|&[a, b, c]| [3, a, b, c]).flat_map(|n| u32::from(n).to_be_bytes()));
    files.push(binary);
    let array =
        |kind: &str, name: &str, rest: &str| format!("<DataArray type=\"{kind}\" Name=\"{name}\" {rest}");
    let corners: String = FACES.iter().flatten().map(|c| format!("{c} ")).collect();
    let text = |kind: &str, name: &str, n: u8, text: &str| {
        array(kind, name, &format!("NumberOfComponents=\"{n}\" format=\"ascii\">{text}</DataArray>"))
    };
    files.push(
        format!(
            "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"4\" NumberOfPolys=\"4\"><PointData>{}\
             </PointData><Points>{}</Points><Polys>{}{}</Polys></Piece></PolyData></VTKFile>",
            text("Float64", "t", 1, "1 2 nan 4"),
            text("Float32", "Points", 3, &points),
            text("Int64", "connectivity", 1, &corners),
            text("Int32", "offsets", 1, "3 6 9 12")
        )
        .into_bytes(),
    );
    let appended = |at: usize| format!("format=\"appended\" offset=\"{at}\"/>");
    let mut raw = format!(
        "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\"><PolyData><Piece NumberOfPoints=\"4\" \
         NumberOfPolys=\"4\"><Points>{}</Points><Polys>{}{}</Polys></Piece></PolyData><AppendedData \
         encoding=\"raw\">_",
        array("Float32", "Points", &format!("NumberOfComponents=\"3\" {}", appended(0))),
        array("UInt8", "connectivity", &appended(52)),
        array("UInt8", "offsets", &appended(68))
    )
    .into_bytes();
    raw.extend(48u32.to_le_bytes());
    raw.extend(CORNERS.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    raw.extend(12u32.to_le_bytes());
    raw.extend(FACES.as_flattened());
    raw.extend(4u32.to_le_bytes());
    raw.extend([3, 6, 9, 12]);
    raw.extend(b"</AppendedData></VTKFile>");
    files.push(raw);
    files
}

/// A tetrahedron without optional data, and one with all of it.
fn prepared() -> Vec<Vec<u8>> {
    let plain = Mesh {
        positions: CORNERS.to_vec(),
        triangles: FACES.map(|face| face.map(u32::from)).to_vec(),
        ..Mesh::default()
    };
    let attribute = |name: &str, domain| Attribute {
        name: name.into(),
        domain,
        values: vec![0.5; 4],
        offset: 0.0,
        component: None,
    };
    let full = Mesh {
        normals: Some(CORNERS.map(OctNormal::encode).to_vec()),
        vertex_colors: Some(vec![[10, 20, 30, 255]; 4]),
        texcoords: Some(vec![[0.5, 0.25]; 4]),
        face_colors: Some(vec![[200, 100, 50, 128]; 4]),
        triangle_materials: Some(vec![0, Mesh::NO_MATERIAL, 0, 7]),
        face_of_triangle: Some(vec![0, 0, 1, 2]),
        attributes: vec![attribute("v", AttributeDomain::Vertex), attribute("t", AttributeDomain::Triangle)],
        ..plain.clone()
    };
    let write = |mesh| {
        let mut bytes = Vec::new();
        let written = prepared::write(&partition(mesh, &PartitionOptions::default()), b"a seed", &mut bytes);
        // Writing to a vector does not fail.
        written.map(|()| bytes).unwrap_or_default()
    };
    [plain, full].map(write).into()
}

/// A tetrahedron in binary: the keyword, and what follows a vertex's coordinates. The colours of the faces have 0, 1, 3
/// and 4 components.
fn binary_off(keyword: &str, tail: &[f32], big_endian: bool, with_colors: bool) -> Vec<u8> {
    let mut words = vec![4u32, 4, 6];
    for corner in CORNERS {
        words.extend(corner.iter().chain(tail).map(|number| number.to_bits()));
    }
    for (face, components) in FACES.iter().zip([0, 1, 3, 4]) {
        words.push(3);
        words.extend(face.map(u32::from));
        if with_colors {
            words.push(components);
            words.extend((0..components).map(|_| 0.5f32.to_bits()));
        }
    }
    let bytes = words.into_iter().flat_map(|w| if big_endian { w.to_be_bytes() } else { w.to_le_bytes() });
    format!("{keyword} BINARY\n").into_bytes().into_iter().chain(bytes).collect()
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum as _;

    use super::*;

    #[test]
    fn binary_stl_has_the_size_that_follows_from_its_count() {
        for seed in &stl()[1..] {
            assert_eq!(seed.len(), 84 + 50 * FACES.len());
        }
    }

    #[test]
    fn binary_ply_of_both_byte_orders_has_one_size() {
        let sizes: Vec<_> = ply().iter().map(|seed| seed.len()).collect();
        // "little" is three letters longer than "big".
        assert_eq!(sizes[3..6], [sizes[6] + 3, sizes[7] + 3, sizes[8] + 3]);
    }

    #[test]
    fn seeds_are_written_once_and_small() {
        let folder = tempfile::tempdir().unwrap();
        for target in Target::value_variants() {
            let corpus = folder.path().join(target.name());
            fs::create_dir(&corpus).unwrap();
            let count = write(*target, &corpus, 4096).unwrap();
            assert_eq!(write(*target, &corpus, 4096).unwrap(), count, "seeds can be written again");
            let files: Vec<_> = fs::read_dir(&corpus).unwrap().map(|file| file.unwrap()).collect();
            assert_eq!(files.len(), count);
            assert!(count >= made(*target).len());
            assert!(files.iter().all(|file| file.metadata().unwrap().len() <= 4096));
        }
    }
}
