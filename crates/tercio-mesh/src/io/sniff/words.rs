//! Formats recognised by the words that they begin with.

use super::super::obj::transcode;

/// How much of a file is examined.
const FRONT: usize = 1 << 14;

/// First lines that could be mistaken for a comment of OBJ or OFF.
#[rustfmt::skip]
const COMMENTS: &[(&str, &str)] = &[
    ("#VRML V1.0", "a VRML 1.0 world"),
    ("#VRML V2.0", "a VRML 2.0 world"),
    ("#VRML V", "a VRML world"),
    ("#X3D V", "an X3D world"),
    ("#Inventor V", "an Open Inventor scene"),
    ("#usda", "a USD scene"),
    ("#?RADIANCE", "a Radiance picture"),
    ("#!/", "a script"),
];

#[rustfmt::skip]
const WORDS: &[(&str, &str)] = &[
    ("PXR-USDC", "a USD scene"),
    ("BLENDER", "a Blender scene"),
    ("DRACO", "a Draco mesh"),
    ("OCTM", "an OpenCTM mesh"),
    ("AC3Db", "an AC3D model"),
    ("xof ", "a DirectX model"),
    ("; FBX", "an FBX scene"),
    ("3D Geometry File Format", "a Rhino model"),
    ("ISO-10303-21", "a STEP model"),
    ("$MeshFormat", "a Gmsh mesh"),
    ("MeshVersionFormatted", "a Medit mesh"),
    ("LASF", "the beginning of a LAS point cloud"),
    ("ASTM-E57", "an E57 point cloud"),
    ("VOX ", "a MagicaVoxel model"),
    ("NRRD000", "an NRRD volume"),
    ("ObjectType", "a MetaImage volume"),
    ("NDims", "a MetaImage volume"),
    ("SIMPLE  =", "a FITS file"),
    ("MATLAB 5.0 MAT-file", "a MATLAB file"),
    ("PAR1", "a Parquet table"),
    ("GRIB", "a GRIB file"),
    ("GIF87a", "a GIF picture"),
    ("GIF89a", "a GIF picture"),
    ("%PDF", "a PDF document"),
    ("%!PS", "a PostScript document"),
    ("{\\rtf", "an RTF document"),
    ("fLaC", "FLAC sound"),
    ("MThd", "MIDI music"),
    ("newmtl", "a material library (MTL) without its OBJ"),
    ("version https://git-lfs", "a Git LFS pointer, not the file that it stands for"),
    ("-----BEGIN", "a key or a certificate (PEM)"),
];

/// The format whose signature looks like a comment.
pub(super) fn comment_name(bytes: &[u8]) -> Option<String> {
    let front = bytes.get(..FRONT).unwrap_or(bytes);
    if front.iter().find(|b| !b.is_ascii_whitespace()).is_none_or(|b| !matches!(b, b'#' | 0xef | 0xff | 0xfe))
    {
        return None;
    }
    let front = transcode::front(bytes, FRONT);
    let text = front.trim_ascii_start();
    // Some programs leave several blanks before the version.
    let version = text.strip_prefix(b"#VRML ").map(<[u8]>::trim_ascii_start).unwrap_or_default();
    match version {
        [b'V', ..] => find(COMMENTS, &[b"#VRML ", version].concat()),
        _ => find(COMMENTS, text),
    }
}

/// The format of a file that begins with a known word, after white space and comments.
pub(super) fn name(bytes: &[u8]) -> Option<String> {
    let text = transcode::front(bytes, FRONT);
    let mut text = text.trim_ascii_start();
    while text.starts_with(b"#") {
        let line = text.iter().position(|&b| b == b'\n').unwrap_or(text.len());
        text = text.get(line..).unwrap_or_default().trim_ascii_start();
    }
    if let Some(name) = find(WORDS, text) {
        return Some(name);
    }
    let name = match text {
        [b'{', ..] | [b'[', b'{', ..] => return json(text),
        [b'<', ..] => xml(text),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'A', b'V', b'E', ..] => "WAV sound",
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "a WebP picture",
        [b'R', b'I', b'F', b'F', _, _, _, _, b'A', b'V', b'I', b' ', ..] => "an AVI video",
        [b'F', b'O', b'R', b'M', _, _, _, _, b'L', b'W', ..] => "a LightWave model",
        [_, _, _, _, b'f', b't', b'y', b'p', ..] => "an MP4 video",
        [b'P', b'1'..=b'7', b' ' | b'\n' | b'\r' | b'\t', ..] => "a PNM picture",
        [b'P', b'F' | b'f', b'\n', ..] => "a PFM picture",
        _ if bytes.get(257..).is_some_and(|rest| rest.starts_with(b"ustar")) => "a TAR archive",
        _ if is_dxf(text) => "a DXF drawing",
        _ if is_iges(text) => "an IGES model",
        _ => return None,
    };
    Some(name.into())
}

fn find(table: &[(&str, &str)], text: &[u8]) -> Option<String> {
    let (_, name) = table.iter().find(|(word, _)| text.starts_with(word.as_bytes()))?;
    Some((*name).into())
}

fn position(text: &[u8], word: &str) -> Option<usize> {
    text.windows(word.len()).position(|w| w == word.as_bytes())
}

/// JSON; of its dialects glTF is a model format, whose version is in the object "asset".
fn json(text: &[u8]) -> Option<String> {
    position(text, "\"")?;
    let gltf = |word| position(text, word).is_some();
    let Some(at) = position(text, "\"asset\"") else {
        return Some(if gltf("\"bufferViews\"") || gltf("\"meshes\"") { "glTF" } else { "JSON" }.into());
    };
    let asset = text.get(at..).unwrap_or_default();
    let version = position(asset, "\"version\"").and_then(|at| {
        let value = asset.get(at + "\"version\"".len()..)?;
        let value = value.trim_ascii_start().strip_prefix(b":")?.trim_ascii_start();
        let value = value.strip_prefix(b"\"").unwrap_or(value);
        let length = value.iter().position(|b| !b.is_ascii_digit() && *b != b'.')?;
        std::str::from_utf8(value.get(..length.min(8))?).ok()
    });
    Some(version.filter(|v| !v.is_empty()).map_or("glTF".into(), |v| format!("glTF {v}")))
}

/// XML, identified by its first well-known element.
fn xml(text: &[u8]) -> &'static str {
    #[rustfmt::skip]
    const ROOTS: &[(&str, &str)] = &[
        ("<COLLADA", "a COLLADA scene"),
        ("<X3D", "an X3D world"),
        ("<svg", "an SVG picture"),
        ("<html", "an HTML page"),
        ("<HTML", "an HTML page"),
        ("<!DOCTYPE html", "an HTML page"),
        ("<!doctype html", "an HTML page"),
        ("<amf", "an AMF model"),
        ("<kml", "a KML file"),
        ("<robot", "a URDF robot"),
    ];
    let found = ROOTS.iter().filter_map(|(root, name)| Some((position(text, root)?, name))).min();
    found.map_or("XML", |(_, name)| name)
}

/// The code 0, then the word SECTION.
fn is_dxf(text: &[u8]) -> bool {
    let mut words = text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
    words.next() == Some(b"0") && words.next() == Some(b"SECTION")
}

/// Lines of 80 columns, of which the 73rd holds the letter of the section.
fn is_iges(text: &[u8]) -> bool {
    text.get(72) == Some(&b'S') && text.get(73..80).is_some_and(|n| n.trim_ascii() == b"1" || n == b"0000001")
}
