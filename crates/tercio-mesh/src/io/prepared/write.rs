//! Writes prepared models.

use std::io::{self, Write};

use super::format::{ALIGNMENT, Description, Header, Kind, MAGIC, Part, VERSION};
use crate::checksum;
use crate::cluster::ClusteredMesh;

/// Writes a mesh; `about` is arbitrary information from the program.
///
/// # Errors
/// Errors of `out`; on a big-endian machine always, as there is no format for it.
pub fn write(mesh: &ClusteredMesh, about: &[u8], out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    if cfg!(target_endian = "big") {
        return Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "prepared models are for little-endian machines",
        ));
    }
    let description = serde_json::to_vec(&Description::of(mesh))?;
    let parts: [&[u8]; Kind::ALL.len()] = Kind::ALL.map(|kind| match kind {
        Kind::Description => &description[..],
        Kind::About => about,
        Kind::Heads => bytemuck::cast_slice(mesh.clusters()),
        Kind::Starts => bytemuck::cast_slice(&mesh.starts),
        Kind::Faces => mesh.face_of_triangle.as_ref().map_or(&[][..], |faces| bytemuck::cast_slice(faces)),
        Kind::Lines => bytemuck::cast_slice(&mesh.lines),
    });
    let mut offset = size_of::<Header>() as u64;
    let parts_at = parts.map(|bytes| {
        offset = offset.next_multiple_of(ALIGNMENT);
        let part = Part { offset, bytes: bytes.len() as u64, checksum: checksum::of(bytes) };
        offset += part.bytes;
        part
    });
    let mut header =
        Header { magic: MAGIC, version: VERSION, file_bytes: offset, parts: parts_at, checksum: 0 };
    header.checksum = checksum::of(&bytemuck::bytes_of(&header)[..Header::CHECKED]);
    out.write_all(bytemuck::bytes_of(&header))?;
    let mut written = size_of::<Header>() as u64;
    for (part, bytes) in parts_at.iter().zip(parts) {
        io::copy(&mut io::Read::take(io::repeat(0), part.offset - written), out)?;
        out.write_all(bytes)?;
        written = part.offset + part.bytes;
    }
    Ok(())
}
