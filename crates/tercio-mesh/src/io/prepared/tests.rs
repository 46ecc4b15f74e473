//! What was written is read back; files that were shortened or altered are rejected.

use super::format::{Header, Kind};
use super::*;
use crate::checksum;
use crate::cluster::{ClusteredMesh, PartitionOptions, partition};
use crate::io::ReadOptions;
use crate::io::input::{self, Input};
use crate::{
    Attribute, AttributeDomain, FileMaterial, FileTexture, FileTextures, Mesh, ReadError, TextureChannel,
    builtin,
};

/// A mesh with everything that a mesh can have.
fn mesh() -> Mesh {
    let mut mesh = builtin::make("builtin:teapot@2k").expect("a built-in model");
    let (v, t) = (mesh.positions.len() as u32, mesh.triangles.len() as u32);
    mesh.origin = glam::DVec3::new(0.1, -1e6, 1.0 / 3.0);
    mesh.exponent = -200;
    mesh.vertex_colors = Some((0..v).map(u32::to_le_bytes).collect());
    mesh.face_colors = Some((0..t).map(u32::to_be_bytes).collect());
    mesh.texcoords = Some((0..v).map(|i| [i as f32 * 0.5, f32::NAN]).collect());
    mesh.triangle_materials =
        Some((0..t).map(|i| if i % 3 == 0 { Mesh::NO_MATERIAL } else { i % 2 }).collect());
    mesh.face_of_triangle = Some((0..t).map(|i| i / 2).collect());
    mesh.materials = ["plain", "with \"quotes\" and \u{fc}"]
        .map(|name| FileMaterial {
            name: name.into(),
            diffuse: [0.1, 1.0 / 3.0, 0.7],
            opacity: 0.3,
            specular: Some([0.1, 0.2, 1.0 / 3.0]),
            illumination: Some(1),
            textures: FileTextures {
                diffuse: Some(FileTexture {
                    clamp: true,
                    scale: [0.7, -1.1],
                    gain: 1.0 / 3.0,
                    channel: Some(TextureChannel::Alpha),
                    ..FileTexture::new("wood.png")
                }),
                ..FileTextures::default()
            },
            other_textures: vec!["bump.png".into()],
            ..FileMaterial::default()
        })
        .into();
    mesh.attributes = vec![
        Attribute {
            name: "quality".into(),
            domain: AttributeDomain::Vertex,
            values: (0..v).map(|i| i as f32).collect(),
            offset: 0.0,
            component: None,
        },
        Attribute {
            name: "part".into(),
            domain: AttributeDomain::Triangle,
            values: (0..t).map(|i| -(i as f32)).collect(),
            offset: 1e9,
            component: None,
        },
    ];
    mesh
}

fn bytes_of(mesh: &ClusteredMesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(mesh, b"about it", &mut bytes).expect("room in memory");
    bytes
}

fn read_bytes(bytes: Vec<u8>) -> Result<Prepared, ReadError> {
    let options = ReadOptions::default();
    read(&Input::from_bytes("model.tercio", bytes, &options)?, &options)
}

fn same(a: &ClusteredMesh, b: &ClusteredMesh) -> bool {
    let faces = |m: &ClusteredMesh| m.face_of_triangle.as_deref().map(<[u32]>::to_vec);
    (a.origin, a.exponent, a.bounds, a.layout()) == (b.origin, b.exponent, b.bounds, b.layout())
        && a.materials == b.materials
        && a.clusters() == b.clusters()
        && (a.triangle_count(), a.vertex_count()) == (b.triangle_count(), b.vertex_count())
        && *a.starts == *b.starts
        && *a.lines == *b.lines
        && faces(a) == faces(b)
}

#[test]
fn what_was_written_is_read_back() {
    for mesh in [mesh(), builtin::make("builtin:sphere@500").expect("a model"), Mesh::default()] {
        let mesh = partition(mesh, &PartitionOptions::default());
        let bytes = bytes_of(&mesh);
        let copied = read_bytes(bytes.clone()).expect("a prepared model");
        assert!(same(&copied.mesh, &mesh));
        assert_eq!((copied.about.as_slice(), copied.mesh.mapped_bytes()), (&b"about it"[..], 0));

        let file = tempfile::NamedTempFile::new().expect("a temporary file");
        std::fs::write(file.path(), &bytes).expect("room for it");
        let options = ReadOptions { memory_limit: Some(1), progress: None, ..ReadOptions::default() };
        let input = input::open(file.path(), &options).expect("the file");
        let mapped = read(&input, &options).expect("a prepared model").mesh;
        drop(input);
        assert!(same(&mapped, &mesh));
        assert!(mapped.mapped_bytes() >= mesh.lines.len() * 64);
        assert_eq!(bytes_of(&mapped), bytes, "the same file from the same model");
    }
}

#[test]
fn every_shortened_file_is_rejected() {
    let bytes = bytes_of(&partition(
        builtin::make("builtin:sphere@100").expect("a model"),
        &PartitionOptions::default(),
    ));
    for length in (0..bytes.len()).step_by(97).chain([bytes.len() - 1]) {
        let refused = read_bytes(bytes[..length].to_vec());
        assert!(matches!(refused, Err(ReadError::Malformed { .. })), "{length} bytes");
    }
    let longer = read_bytes([&bytes[..], &[0]].concat());
    assert!(matches!(longer, Err(ReadError::Malformed { .. })));
}

#[test]
fn every_altered_byte_of_a_part_is_detected() {
    let bytes = bytes_of(&partition(mesh(), &PartitionOptions::default()));
    let header: Header = bytemuck::pod_read_unaligned(&bytes[..size_of::<Header>()]);
    let places =
        header.parts.iter().flat_map(|p| (p.offset..p.offset + p.bytes).step_by(1 + p.bytes as usize / 40));
    for place in (0..size_of::<Header>() as u64).chain(places) {
        let mut altered = bytes.clone();
        altered[place as usize] ^= 1 << (place % 8);
        let refused = read_bytes(altered);
        assert!(
            matches!(refused, Err(ReadError::Malformed { .. } | ReadError::Unsupported { .. })),
            "byte {place} of {}",
            bytes.len()
        );
    }
}

/// Changes a part, and updates its checksum and that of the header.
fn forge(bytes: &[u8], kind: Kind, change: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let mut header: Header = bytemuck::pod_read_unaligned(&bytes[..size_of::<Header>()]);
    let part = &mut header.parts[kind as usize];
    let range = part.offset as usize..(part.offset + part.bytes) as usize;
    change(&mut bytes[range.clone()]);
    part.checksum = checksum::of(&bytes[range]);
    header.checksum = checksum::of(&bytemuck::bytes_of(&header)[..Header::CHECKED]);
    bytes[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(&header));
    bytes
}

#[test]
fn forged_clusters_are_rejected() {
    let mesh = partition(mesh(), &PartitionOptions::default());
    let bytes = bytes_of(&mesh);
    let corner = 64 + 4 * 4 * mesh.clusters()[0].vertices.next_multiple_of(16) as usize;
    let refused = |kind, what: &str, change: &dyn Fn(&mut [u8])| {
        let error = read_bytes(forge(&bytes, kind, change)).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.contains(what), "{what}: {error:?}");
    };
    refused(Kind::Heads, "vertices", &|b| b[36] = 65);
    refused(Kind::Heads, "triangles", &|b| b[37] = 0);
    refused(Kind::Heads, "cluster", &|b| b[36] -= 1);
    refused(Kind::Starts, "at line", &|b| b[4] ^= 1);
    refused(Kind::Lines, "the head", &|b| b[0] ^= 1);
    refused(Kind::Lines, "inside of the box", &|b| b[64..68].copy_from_slice(&f32::NAN.to_le_bytes()));
    refused(Kind::Lines, "corners that are vertices", &|b| b[corner] = 64);
    refused(Kind::Description, "finite", &|b| {
        let text = String::from_utf8(b.to_vec()).expect("JSON").replacen("-200", "-400", 1);
        b.copy_from_slice(text.as_bytes());
    });
}

#[test]
fn other_versions_and_transfers_as_text_are_reported() {
    let bytes = bytes_of(&ClusteredMesh::default());
    let mut newer = bytes.clone();
    newer[12] = 9;
    let error = read_bytes(newer).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(error.contains("version 9"), "{error}");
    let mut text = bytes;
    text.remove(7);
    let error = read_bytes(text.clone()).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(is_prepared(&text) && error.contains("expected the bytes"), "{error}");
}
