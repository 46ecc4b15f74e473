//! Formats recognised by bytes that are not text and so do not occur in the header of a model.

/// Offset, bytes, name.
#[rustfmt::skip]
const MAGIC: &[(usize, &[u8], &str)] = &[
    // Compressed data and archives.
    (0, b"\x1f\x8b", "gzip data inside gzip data"),
    (0, b"PK\x03\x04", "a ZIP archive"),
    (0, b"PK\x05\x06", "an empty ZIP archive"),
    (0, b"BZh91AY&SY", "bzip2 data"),
    (0, b"\xfd7zXZ\0", "xz data"),
    (0, b"\x28\xb5\x2f\xfd", "Zstandard data"),
    (0, b"\x04\x22\x4d\x18", "LZ4 data"),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
    (0, b"Rar!\x1a\x07", "a RAR archive"),
    (0, b"\x1f\x9d", "compress (.Z) data"),
    // Models and scenes.
    (0, b"glTF\x01\0\0\0", "binary glTF 1.0"),
    (0, b"glTF\x02\0\0\0", "binary glTF 2.0"),
    (0, b"Kaydara FBX Binary  \0", "an FBX scene"),
    (0, b"U3D\0", "a U3D model"),
    (0, b"Ogawa\xff", "an Alembic scene"),
    (0, b"Ogawa\0", "an Alembic scene"),
    // Volumes, tables and numbers.
    (128, b"DICM", "a DICOM file"),
    (344, b"n+1\0", "a NIfTI volume"),
    (344, b"ni1\0", "the header of a NIfTI volume"),
    (4, b"n+2\0\r\n\x1a\n", "a NIfTI-2 volume"),
    (0, b"\x89HDF\r\n\x1a\n", "an HDF5 file"),
    (0, b"CDF\x01", "a NetCDF file"),
    (0, b"CDF\x02", "a NetCDF file"),
    (0, b"CDF\x05", "a NetCDF file"),
    (0, b"\x93NUMPY", "a NumPy array"),
    (0, b"SQLite format 3\0", "an SQLite database"),
    // Pictures, sound, documents.
    (0, b"\x89PNG\r\n\x1a\n", "a PNG picture"),
    (0, b"\xff\xd8\xff", "a JPEG picture"),
    (0, b"\0\0\0\x0cjP  \r\n\x87\n", "a JPEG 2000 picture"),
    (0, b"\xff\x4f\xff\x51", "a JPEG 2000 picture"),
    (0, b"II*\0", "a TIFF picture"),
    (0, b"MM\0*", "a TIFF picture"),
    (0, b"II+\0", "a BigTIFF picture"),
    (0, b"MM\0+", "a BigTIFF picture"),
    (0, b"\x76\x2f\x31\x01", "an OpenEXR picture"),
    (0, b"DDS \x7c\0\0\0", "a DDS picture"),
    (0, b"\xabKTX ", "a KTX picture"),
    (0, b"\0\0\x01\0\x01\0", "an icon"),
    (0, b"ID3\x03", "MP3 sound"),
    (0, b"ID3\x04", "MP3 sound"),
    (0, b"OggS\0", "Ogg sound or video"),
    (0, b"\x1a\x45\xdf\xa3", "a Matroska video"),
    (0, b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "a Microsoft Office document"),
    // Programs.
    (0, b"\x7fELF", "a program (ELF)"),
    (0, b"\xfe\xed\xfa\xce", "a program (Mach-O)"),
    (0, b"\xfe\xed\xfa\xcf", "a program (Mach-O)"),
    (0, b"\xce\xfa\xed\xfe", "a program (Mach-O)"),
    (0, b"\xcf\xfa\xed\xfe", "a program (Mach-O)"),
    (0, b"\xca\xfe\xba\xbe", "a program (Java or Mach-O)"),
    (0, b"\0asm", "a program (WebAssembly)"),
    (0, b"!<arch>\n", "a library (ar archive)"),
];

/// The name of the format, to follow "this is".
pub(super) fn name(bytes: &[u8]) -> Option<String> {
    let has = |at: usize, word: &[u8]| bytes.get(at..).is_some_and(|rest| rest.starts_with(word));
    let word = |at: usize| bytes.get(at..)?.first_chunk().copied().map(u32::from_le_bytes);
    if has(0, b"PK\x03\x04") {
        return Some(zip(bytes).into());
    }
    if let Some((.., name)) = MAGIC.iter().find(|(at, word, _)| has(*at, word)) {
        return Some((*name).into());
    }
    let length = u32::try_from(bytes.len()).ok();
    // Two letters are too little evidence, so the length that follows them has to be right, too.
    let name = if has(0, b"BM") && length.is_some() && word(2) == length {
        "a BMP picture"
    } else if has(0, b"MM") && length.is_some() && word(2) == length {
        "a 3DS scene"
    } else if has(0, b"MZ") && word(60).is_some_and(|at| has(at as usize, b"PE\0\0")) {
        "a program (Windows)"
    } else {
        return None;
    };
    Some(name.into())
}

/// Several model formats are ZIP archives; the names of the files inside are not compressed.
fn zip(bytes: &[u8]) -> &'static str {
    let front = bytes.get(..4096).unwrap_or(bytes);
    let names = |word: &[u8]| front.windows(word.len()).any(|w| w == word);
    if names(b"3D/3dmodel.model") || names(b"3dmodel.model") {
        "a 3MF model"
    } else if names(b".usdc") || names(b".usda") {
        "a USDZ scene"
    } else if names(b".kml") {
        "a KMZ file"
    } else {
        "a ZIP archive"
    }
}
