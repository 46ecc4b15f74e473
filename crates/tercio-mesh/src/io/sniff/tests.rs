use std::io::Write as _;

use flate2::Compression;
use flate2::write::GzEncoder;
use proptest::prelude::*;

use super::super::{ReadModel, ReadOptions, read_input};
use super::*;

fn try_read(bytes: &[u8]) -> Result<ReadModel, ReadError> {
    let options = ReadOptions::default();
    read_input(&Input::from_bytes("a", bytes.to_vec(), &options)?, &options)
}

fn rejected(bytes: &[u8]) -> String {
    match try_read(bytes) {
        Err(error) => error.to_string(),
        Ok(model) => panic!("{:?} was read: {:?}", bytes.escape_ascii().to_string(), model.report),
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).unwrap()
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const OFF: &str = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
                   endfacet\nendsolid a\n";

fn binary_stl() -> Vec<u8> {
    let mut bytes = b"seed".to_vec();
    bytes.resize(80, 0);
    bytes.extend(1u32.to_le_bytes());
    let numbers = [0f32, 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0.];
    bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend([0; 2]);
    bytes
}

fn binary_ply() -> Vec<u8> {
    let header = PLY.replace("ascii", "binary_little_endian");
    let mut bytes = header.as_bytes()[..header.find("0 0 0\n").unwrap()].to_vec();
    bytes.extend([0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|x| x.to_le_bytes()));
    bytes.push(3);
    bytes.extend([0u32, 1, 2].iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

fn models() -> [(&'static str, Vec<u8>); 6] {
    [
        ("PLY, ASCII", PLY.into()),
        ("PLY, binary little-endian", binary_ply()),
        ("OBJ", OBJ.into()),
        ("OFF", OFF.into()),
        ("STL, ASCII", STL.into()),
        ("STL, binary", binary_stl()),
    ]
}

/// Reads the triangle; returns the warnings.
#[track_caller]
fn triangle(format: &str, bytes: &[u8]) -> Vec<String> {
    let model = try_read(bytes).unwrap_or_else(|e| panic!("{format}: {e}"));
    assert_eq!(model.report.format, format);
    assert_eq!(model.mesh.positions, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], "{format}");
    assert_eq!(model.mesh.triangles, [[0, 1, 2]], "{format}");
    model.report.warnings
}

#[test]
fn good_models_are_read_without_a_warning() {
    for (format, bytes) in models() {
        assert_eq!(triangle(format, &bytes), [""; 0]);
        assert_eq!(triangle(format, &gzip(&bytes)), [""; 0]);
        let (first, second) = bytes.split_at(bytes.len() / 2);
        assert_eq!(triangle(format, &[gzip(first), gzip(second)].concat()), [""; 0], "two members");
    }
}

#[test]
fn what_surrounds_a_model_is_skipped_with_a_warning() {
    for (format, bytes) in models() {
        let put = |before: &[u8], after: &[u8]| [before, &bytes, after].concat();
        let packed = gzip(&bytes);
        let mut odd = vec![
            (put(b"", &[0; 1000]), "1000 zero bytes"),
            (put(b"", &[0]), "1 zero byte"),
            ([&packed[..], &[0; 512]].concat(), "ignored 512 zero bytes after the gzip data"),
            ([&packed[..], b"garbage"].concat(), "ignored 7 bytes after the gzip data"),
        ];
        if format != "STL, binary" {
            odd.push((put(b"\xef\xbb\xbf", b""), "ignored the byte order mark at the front"));
            odd.push((put(b"made by hand\n", b""), ""));
            odd.push((put(b"made by hand\r\n\n", b""), ""));
            assert_eq!(triangle(format, &put(b"\n\r\n \t\n", b"")), [""; 0]);
        }
        for (bytes, expected) in odd {
            let warnings = triangle(format, &bytes);
            // Binary PLY names the surplus differently.
            let expected =
                if format.starts_with("PLY, bin") { &expected[..expected.len().min(2)] } else { expected };
            assert!(
                warnings.len() == 1 && warnings[0].contains(expected),
                "{format}: {warnings:?} {expected}"
            );
        }
    }
}

#[test]
fn places_in_errors_count_from_the_front_of_the_file() {
    let message = |before: &str, text: &str| rejected(&[before.as_bytes(), text.as_bytes()].concat());
    for before in ["", "\u{feff}", "\n\n", "made by hand\n", "\u{feff}\nmade by hand\n"] {
        let lines = before.matches('\n').count();
        for (text, line) in [
            (PLY.replace("3 0 1 2", "3 0 1 x"), 13),
            (OFF.replace("3 0 1 2", "3 0 1 x"), 6),
            (OBJ.replace("f 1 2 3", "f 1 2 x"), 4),
            (STL.replace("vertex 0 1 0", "vertex 0 x 0"), 6),
        ] {
            let message = message(before, &text);
            assert!(message.starts_with(&format!("a: line {}: ", lines + line)), "{before:?}: {message}");
        }
    }
    let cut = |before: &[u8]| {
        let whole = [before, &binary_ply()].concat();
        rejected(&whole[..whole.len() - 1])
    };
    let place =
        |message: String| message.split(' ').nth(2).unwrap().trim_end_matches(':').parse::<usize>().unwrap();
    assert_eq!(place(cut(b"made by hand\n")), place(cut(b"")) + 13);
}

#[test]
fn empty_files_are_called_empty() {
    assert_eq!(rejected(b""), "a: the file is empty");
    assert_eq!(rejected(&gzip(b"")), "a: the file is empty: the gzip data holds nothing");
    assert_eq!(rejected(b" \n\t\r\n"), "a: holds nothing but white space");
    assert_eq!(rejected(b"\xef\xbb\xbf"), "a: holds nothing but a byte order mark");
    assert_eq!(rejected(&[0; 84]), "a: holds nothing but zeros");
    assert_eq!(rejected(b"# a\n\n# b\n"), "a: holds nothing but comments");
    assert_eq!(
        rejected(b"# a\nmtllib a.mtl\no b\n"),
        "a: holds nothing but names of OBJ, without any geometry"
    );
}

#[test]
fn a_gzip_file_that_is_cut_is_called_truncated() {
    for (_, bytes) in models() {
        let whole = gzip(&bytes);
        for n in 2..whole.len() {
            let message = rejected(&whole[..n]);
            assert!(message.starts_with("a: truncated gzip data"), "{n} of {}: {message}", whole.len());
        }
        let mut damaged = whole.clone();
        damaged[whole.len() - 7] ^= 1;
        assert!(rejected(&damaged).starts_with("a: damaged gzip data"), "{}", rejected(&damaged));
    }
}

#[test]
fn known_formats_are_named() {
    let at = |at: usize, word: &[u8]| [vec![0; at], word.to_vec(), vec![7; 600]].concat();
    let bmp = [&b"BM"[..], &[100, 0, 0, 0], &[1; 94]].concat();
    let with_length = |front: &[u8]| [front, &[9; 300]].concat();
    let gltf = br#"{ "scenes": [], "asset": { "generator": "x", "version" : "2.0" }, "nodes": [] }"#;
    for (bytes, name) in [
        (&gltf[..], "glTF 2.0"),
        (br#"{"asset":{"version":"1.0"}}"#, "glTF 1.0"),
        (br#"{"accessors": [], "bufferViews": []}"#, "glTF"),
        (br#"[{"a": 1}]"#, "JSON"),
        (&with_length(b"glTF\x02\0\0\0"), "binary glTF 2.0"),
        (&at(128, b"DICM"), "a DICOM file"),
        (&at(344, b"n+1\0"), "a NIfTI volume"),
        (&at(257, b"ustar"), "a TAR archive"),
        (&with_length(b"\x89PNG\r\n\x1a\n"), "a PNG picture"),
        (&with_length(b"\xff\xd8\xff\xe0"), "a JPEG picture"),
        (&bmp, "a BMP picture"),
        (&with_length(b"PK\x03\x04....3D/3dmodel.model"), "a 3MF model"),
        (&with_length(b"PK\x03\x04"), "a ZIP archive"),
        (&gzip(&gzip(OBJ.as_bytes())), "gzip data inside gzip data"),
        (b"#VRML V2.0 utf8\nShape {}\n", "a VRML 2.0 world"),
        (b"<?xml version=\"1.0\"?>\n<!-- x --><COLLADA xmlns=\"\">", "a COLLADA scene"),
        (b"<a><b/></a>", "XML"),
        (b"# Blender MTL\nnewmtl a\nKd 1 0 0\n", "a material library (MTL) without its OBJ"),
        (b"NRRD0004\ntype: short\n", "an NRRD volume"),
        (b"0\nSECTION\n2\nHEADER\n", "a DXF drawing"),
        (b"%PDF-1.7\n", "a PDF document"),
    ] {
        let expected = format!(
            "a: this is {name}, which tercio does not read (it reads PLY, OBJ, STL, OFF, VTK, PCD, LAS, LAZ, point clouds as text, each also gzip-compressed)"
        );
        assert_eq!(rejected(bytes), expected);
        let input = Input::from_bytes("a", bytes.to_vec(), &ReadOptions::default()).unwrap();
        assert_eq!(sniff(&input), None, "{name}");
    }
}

#[test]
fn a_good_binary_stl_is_read_whatever_its_header_begins_with() {
    let dicom = [&[0; 76][..], b"DICM"].concat();
    for front in [
        &b"U3D\0"[..],
        b"#VRML to STL",
        b"#VRML V2.0 utf8",
        b"ply \n",
        b"ply\nformat binary_little_endian 1.0\n",
        b"OFF ",
        b"OFF BINARY\n",
        b"OFF\n3 1 0\n",
        b"solid a\nfacet normal 0 0 1\n",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\n",
        b"PK\x03\x04",
        b"\x7fELF",
        b"\xff\xfev\0 \0",
        &dicom,
    ] {
        let mut bytes = binary_stl();
        bytes[..80].fill(b' ');
        bytes[..front.len()].copy_from_slice(front);
        assert_eq!(triangle("STL, binary", &bytes), [""; 0], "{}", front.escape_ascii());
        // The count alone is not evidence.
        bytes[84..].fill(0xff);
        assert!(try_read(&bytes).is_err(), "{}", front.escape_ascii());
    }
}

#[test]
fn comments_that_begin_like_signatures_are_comments() {
    for comment in ["#VRML2OBJ", "#VRML to OBJ", "#X3D export", "#Inventory 7"] {
        assert_eq!(triangle("OBJ", format!("{comment}\n{OBJ}").as_bytes()), [""; 0], "{comment}");
    }
    for (signature, name) in [
        ("#VRML V1.0 ascii", "a VRML 1.0 world"),
        ("#VRML    V2.0 utf8", "a VRML 2.0 world"),
        ("#VRML V3", "a VRML world"),
        ("#X3D V3.2 utf8", "an X3D world"),
        ("#Inventor V2.1 ascii", "an Open Inventor scene"),
    ] {
        let message = rejected(format!("{signature}\n{OBJ}").as_bytes());
        assert!(message.contains(&format!("this is {name}, which")), "{message}");
    }
}

#[test]
fn geometry_may_follow_thousands_of_names() {
    for line in ["mtllib a-long-name-of-a-library.mtl\n", "usemtl abc\n", "o a\n# b\n", "made\n"] {
        let many = match line {
            "made\n" => format!("{line}{}", "g abcdef\n".repeat(40_000)),
            _ => line.repeat(60_000),
        };
        assert!(many.len() > 1 << 18);
        let text = [&many, OBJ].concat();
        assert_eq!(try_read(text.as_bytes()).map(|m| m.mesh.triangles.len()).unwrap(), 1, "{line}");
        rejected([&many, "so much for that\nand no more\n"].concat().as_bytes());
        if line != "made\n" {
            assert!(rejected(many.as_bytes()).ends_with("names of OBJ, without any geometry"), "{line}");
        }
    }
}

#[test]
fn texts_of_other_kinds_are_rejected() {
    let notes = "# Reading OBJ\n\nA file may look like this:\n\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n\nSo much for\n\
                 the basics. There is more,\nand it is harder.\n";
    for text in [
        "[model]\nv = 1 2 3\ng = 9.81\ns = off\n",
        "name = \"a\"\n[deps]\nv = \"1\"\n",
        "s: 1\ng: 2\nv:\n  - 1\n  - 2\n",
        "v,1,2,3\nv,4,5,6\n",
        "x,y\n1,2\n3,4\n",
        "1 2\n4 5\n7 8\n",
        "1 2 3\n4 5 6 7\n8 9 10\n",
        "o hello\nthis is a log\n",
        "p\nf\n",
        "s 1\n",
        "usemtl a\nset -e\nfor f in *; do echo; done\n",
        "g++ -O2 a.c\n",
        "ply is a file format\nformat it is\n",
        "a\nb\nply\nformat ascii 1.0\nend_header\n",
        "OFF the record\n",
        "solid state physics\nhas facets\n",
        "not\nsolid\nground\n",
        notes,
    ] {
        rejected(text.as_bytes());
        for mark in ["", "\u{feff}"] {
            let units: Vec<u16> = format!("{mark}{text}").encode_utf16().collect();
            rejected(&units.iter().flat_map(|u| u.to_le_bytes()).collect::<Vec<_>>());
            rejected(&units.iter().flat_map(|u| u.to_be_bytes()).collect::<Vec<_>>());
        }
    }
}

#[test]
fn invalid_normals_are_counted_in_every_format() {
    let broken = ["0 0 0", "nan 0 1", "0 1 0"];
    let off =
        format!("NOFF\n3 1 0\n0 0 0 {}\n1 0 0 {}\n0 1 0 {}\n3 0 1 2\n", broken[0], broken[1], broken[2]);
    let obj = format!(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn {}\nvn {}\nvn {}\nf 1//1 2//2 3//3\n",
        broken[0], broken[1], broken[2]
    );
    let normals = "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n";
    let mut ply = PLY.replace("property float z\n", normals);
    for (point, normal) in ["\n0 0 0\n", "\n1 0 0\n", "\n0 1 0\n"].into_iter().zip(broken) {
        ply = ply.replace(point, &format!("{} {normal}\n", point.trim_end()));
    }
    let mut binary =
        ply.replace("ascii", "binary_big_endian").as_bytes()[..ply.find("0 0 0 ").unwrap() + 12].to_vec();
    let nan = f32::NAN;
    for x in [0f32, 0., 0., 0., 0., 0., 1., 0., 0., nan, 0., 1., 0., 1., 0., 0., 1., 0.] {
        binary.extend(x.to_be_bytes());
    }
    binary.push(3);
    binary.extend([0u32, 1, 2].iter().flat_map(|v| v.to_be_bytes()));
    for bytes in [off.into_bytes(), obj.into_bytes(), ply.into_bytes(), binary] {
        let model = try_read(&bytes).unwrap_or_else(|e| panic!("{e}"));
        let format = &model.report.format;
        let up = crate::OctNormal::from_vector([0.0, 1.0, 0.0]);
        let none = crate::OctNormal::NONE;
        assert_eq!(model.mesh.normals, Some(vec![none, none, up]), "{format}");
        assert_eq!(
            model.report.warnings,
            ["2 of 3 normals are missing, zero or not finite; made from the triangles instead"],
            "{format}"
        );
        let all = String::from_utf8_lossy(&bytes).replace("0 1 0\n3 ", "0 0 0\n3 ");
        if all.contains("NOFF") {
            let all = try_read(all.as_bytes()).unwrap();
            assert_eq!(all.mesh.normals, None, "none is left");
            assert_eq!(all.report.warnings.len(), 1);
        }
    }
}

proptest! {
    #[test]
    fn random_bytes_are_never_a_model(bytes in prop::collection::vec(any::<u8>(), 0..3000)) {
        prop_assert!(try_read(&bytes).is_err());
    }

    #[test]
    fn random_words_are_never_a_model(lines in prop::collection::vec(line(), 0..40)) {
        // Single letters followed by numbers make an OBJ if there are at least as many of them as of lines that OBJ
        // does not know.
        let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        let (mut known, mut vertices, mut others) = (0, 0, 0);
        for line in lines.iter().map(|line| words(line.split('#').next().unwrap_or_default())) {
            let Some((keyword, values)) = line.split_first() else { continue };
            let numbers = values.iter().take_while(|w| fast_float2::parse::<f64, _>(w).is_ok()).count();
            match keyword.as_str() {
                "v" if numbers >= 3 => vertices += 1,
                "vn" | "vt" | "vp" | "f" | "fo" | "l" | "p" if numbers > 0 => known += 1,
                "o" | "g" | "s" | "mg" | "sp" => {}
                _ => others += 1,
            }
        }
        prop_assume!(vertices == 0 || vertices + known < others);
        prop_assert!(try_read(lines.join("\n").as_bytes()).is_err());
    }
}

/// Words, and occasionally a line that could be a vertex.
fn line() -> impl Strategy<Value = String> {
    prop_oneof![8 => "[a-z=:{}\"#0-9. ]{0,12}", 1 => "v( -?[0-9.]{1,3}){0,4}( [a-z]{1,2})?"]
}
