//! Clusters of a part of a model as bytes, and a mesh of clusters from several parts.
//!
//! The bytes of a cluster are its stretch of memory, in which primitives have their numbers in the whole model, then, if they
//! are sent, the numbers of its triangles' input faces in the whole model, 32 bits each. Numbers are little-endian.

use crate::loops::prelude::*;
use bytemuck::{Zeroable, bytes_of, cast_slice, cast_slice_mut, pod_read_unaligned};
use glam::Vec3;

use super::check;
use super::{Cluster, ClusteredMesh, Layout, Line, MAX_TRIANGLES, Whole};

/// Why bytes are not clusters of a part of a model, or cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// The bytes end inside a cluster.
    #[error("byte {at}: the bytes end inside a cluster")]
    Short {
        /// Offset of the cluster.
        at: usize,
    },
    /// The head of a cluster has counts that no cluster has.
    #[error("byte {at}: a cluster of {vertices} vertices and {triangles} triangles")]
    Head {
        /// Offset of the cluster.
        at: usize,
        /// Number of vertices.
        vertices: u8,
        /// Number of triangles.
        triangles: u8,
    },
    /// A cluster is not valid.
    #[error("cluster {cluster}: expected {expected}, found others")]
    Cluster {
        /// Its number among those of all bytes that were read.
        cluster: usize,
        /// What was expected.
        expected: &'static str,
    },
    /// The number of a primitive or a face does not fit into 32 bits.
    #[error("the {what} of a cluster do not fit into 32 bits")]
    Numbers {
        /// Which numbers.
        what: &'static str,
    },
    /// The clusters need 2^32 cache lines or more.
    #[error("the clusters need more than 256 GiB")]
    TooLarge,
}

/// Appends clusters as bytes, for [`Assembly::read`]. `first_primitive` is the number in the whole model of the mesh's primitive
/// 0, and `first_face` that of its face 0 if the numbers of faces are written.
///
/// # Errors
/// [`TransferError::Numbers`]; some of the clusters are appended then.
///
/// # Panics
/// If there is no such cluster.
pub fn write_clusters(
    mesh: &ClusteredMesh,
    clusters: impl IntoIterator<Item = usize>,
    first_primitive: u64,
    first_face: Option<u64>,
    out: &mut Vec<u8>,
) -> Result<(), TransferError> {
    for cluster in clusters {
        let view = mesh.cluster(cluster);
        if u32::try_from(first_primitive.saturating_add(view.greatest_primitive())).is_err() {
            return Err(TransferError::Numbers { what: "primitive numbers" });
        }
        // No more than the greatest of them, so exact.
        let first = view.head().first_primitive + first_primitive as u32;
        let head = Cluster { first_primitive: first, ..*view.head() };
        out.extend_from_slice(bytes_of(&head));
        out.extend_from_slice(&cast_slice::<Line, u8>(mesh.stretch(cluster))[size_of::<Cluster>()..]);
        let Some(first_face) = first_face else { continue };
        for face in mesh.faces(cluster) {
            let face = first_face.saturating_add(u64::from(face));
            let face = u32::try_from(face).map_err(|_| TransferError::Numbers { what: "face numbers" })?;
            out.extend(face.to_le_bytes());
        }
    }
    Ok(())
}

/// A mesh that is put together from clusters of several parts of a model.
#[derive(Debug)]
pub struct Assembly<'a> {
    /// The part of this process: it has what is common to all parts.
    part: &'a ClusteredMesh,
    /// Triangles of the whole model.
    triangles: u64,
    /// Faces of the whole model, if the numbers of faces are sent.
    faces: Option<u64>,
    heads: Vec<Cluster>,
    starts: Vec<u32>,
    lines: Vec<Line>,
    face_of_slot: Vec<u32>,
}

impl<'a> Assembly<'a> {
    /// No clusters yet. `part` is a part of the model, which has this many triangles; `faces` is the number of its input faces
    /// if their numbers are in the bytes.
    pub fn new(part: &'a ClusteredMesh, triangles: u64, faces: Option<u64>) -> Self {
        let (heads, starts, lines) = (Vec::new(), vec![0], Vec::new());
        Self { part, triangles, faces, heads, starts, lines, face_of_slot: Vec::new() }
    }

    /// Number of clusters.
    pub fn clusters(&self) -> usize {
        self.heads.len()
    }

    /// Adds clusters from bytes that [`write_clusters`] wrote for a part of the same model, with the numbers of faces if these
    /// are in use here. No more is believed than what is needed to take them apart; [`Assembly::finish`] checks the rest.
    ///
    /// # Errors
    /// [`TransferError`]; some of the clusters are added then.
    pub fn read(&mut self, bytes: &[u8]) -> Result<(), TransferError> {
        let mut rest = bytes;
        while !rest.is_empty() {
            let at = bytes.len() - rest.len();
            let short = TransferError::Short { at };
            let head: Cluster = match rest.first_chunk::<{ size_of::<Cluster>() }>() {
                Some(head) => pod_read_unaligned(head),
                None => return Err(short),
            };
            if !check::has_valid_counts(&head) {
                let Cluster { vertices, triangles, .. } = head;
                return Err(TransferError::Head { at, vertices, triangles });
            }
            let (first, count) = (self.lines.len(), self.part.layout().lines(&head));
            let (stretch, behind) = rest.split_at_checked(count * Line::BYTES).ok_or(short.clone())?;
            let of_faces =
                if self.faces.is_some() { usize::from(head.triangles) * size_of::<u32>() } else { 0 };
            let (faces, behind) = behind.split_at_checked(of_faces).ok_or(short)?;
            let end = u32::try_from(first + count).map_err(|_| TransferError::TooLarge)?;
            self.lines.resize(first + count, Line::zeroed());
            cast_slice_mut::<Line, u8>(&mut self.lines[first..]).copy_from_slice(stretch);
            self.heads.push(head);
            self.starts.push(end);
            if let Some(most) = self.faces {
                let (numbers, _) = faces.as_chunks::<{ size_of::<u32>() }>();
                self.face_of_slot.extend(numbers.iter().map(|&number| u32::from_le_bytes(number)));
                if self.face_of_slot.iter().rev().take(numbers.len()).any(|&face| u64::from(face) >= most) {
                    let expected = "face numbers of the model";
                    return Err(TransferError::Cluster { cluster: self.heads.len() - 1, expected });
                }
                self.face_of_slot.resize(self.heads.len() * MAX_TRIANGLES, 0);
            }
            rest = behind;
        }
        Ok(())
    }

    /// Adds clusters of a mesh that was put together before, for a part of the same model. All of them are checked again.
    ///
    /// # Errors
    /// [`TransferError::Cluster`] if the part's clusters store something else now; [`TransferError::TooLarge`]. Some of the clusters
    /// are added then.
    ///
    /// # Panics
    /// If there is no such cluster.
    pub fn keep(
        &mut self,
        mesh: &ClusteredMesh,
        clusters: impl IntoIterator<Item = usize>,
    ) -> Result<(), TransferError> {
        for cluster in clusters {
            if mesh.layout != self.part.layout || mesh.face_of_slot.is_some() != self.faces.is_some() {
                let expected = "what the clusters of the part store";
                return Err(TransferError::Cluster { cluster: self.heads.len(), expected });
            }
            self.lines.extend_from_slice(mesh.stretch(cluster));
            self.heads.push(mesh.clusters[cluster]);
            self.starts.push(u32::try_from(self.lines.len()).map_err(|_| TransferError::TooLarge)?);
            if let Some(faces) = &mesh.face_of_slot {
                let first = cluster * MAX_TRIANGLES;
                self.face_of_slot.extend_from_slice(&faces[first..first + MAX_TRIANGLES]);
            }
        }
        Ok(())
    }

    /// The mesh of all clusters, a part of the same model. Its primitives have their numbers in the whole model, and so have its
    /// faces if their numbers were read.
    ///
    /// # Errors
    /// The first cluster that is not valid, and [`TransferError::Cluster`].
    pub fn finish(mut self) -> Result<ClusteredMesh, (usize, TransferError)> {
        self.lines.extend([Line::zeroed(); Layout::LINES_BEHIND]);
        let &ClusteredMesh { origin, exponent, bounds, translucent, .. } = self.part;
        let mut mesh = ClusteredMesh {
            origin,
            exponent,
            materials: self.part.materials.clone(),
            face_of_slot: self.faces.is_some().then_some(self.face_of_slot),
            layout: self.part.layout.clone(),
            clusters: self.heads.into(),
            starts: self.starts.into(),
            lines: self.lines.into(),
            ..ClusteredMesh::default()
        };
        let unit = mesh.unit();
        let is_inside = |p: [f32; 3]| {
            let p = origin + Vec3::from(p).as_dvec3() * unit;
            p.cmpge(bounds.min).all() && p.cmple(bounds.max).all()
        };
        let check = |(number, head): (usize, &Cluster)| {
            check::cluster(&mesh.cluster(number), head, self.triangles, &mesh.materials)?;
            if !is_inside(head.min) || !is_inside(head.max) {
                return Err("a box inside of the model's");
            }
            if head.is_translucent() && !translucent {
                return Err("opaque triangles, as in the model");
            }
            Ok(())
        };
        let wrong = mesh.clusters.par_iter().enumerate().with_min_len(64).find_map_first(|(number, head)| {
            check((number, head))
                .err()
                .map(|expected| (number, TransferError::Cluster { cluster: number, expected }))
        });
        if let Some(wrong) = wrong {
            return Err(wrong);
        }
        mesh.sum_up();
        Ok(mesh.as_part_of(&Whole { bounds, translucent, checksum: self.part.checksum() }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::{PartitionOptions, partition};
    use crate::{Aabb, builtin};

    fn sphere() -> ClusteredMesh {
        partition(builtin::make("builtin:sphere@2k").expect("a model"), &PartitionOptions::default())
    }

    #[test]
    fn clusters_are_read_as_they_were_written() {
        let mesh = sphere();
        let (triangles, count) = (mesh.triangle_count() as u64 + 7, mesh.clusters().len());
        let mut bytes = Vec::new();
        write_clusters(&mesh, [3, 1], 7, Some(5), &mut bytes).expect("numbers fit");
        let mut assembly = Assembly::new(&mesh, triangles, Some(triangles));
        assembly.read(&bytes).expect("clusters");
        let read = assembly.finish().expect("valid clusters");
        assert_eq!((read.clusters().len(), read.bounds, read.checksum()), (2, mesh.bounds, mesh.checksum()));
        for (new, old) in [(0, 3), (1, 1)] {
            let (new_view, old_view) = (read.cluster(new), mesh.cluster(old));
            assert_eq!(
                (new_view.positions(), new_view.normals()),
                (old_view.positions(), old_view.normals())
            );
            for t in 0..old_view.triangles() {
                assert_eq!(new_view.corners_of(t), old_view.corners_of(t));
                assert_eq!(new_view.primitive(t), old_view.primitive(t) + 7);
                assert_eq!(read.face(new, t), mesh.face(old, t) + 5);
            }
            assert!(read.faces(new).eq(mesh.faces(old).map(|face| face + 5)));
        }
        let all = write_clusters(&mesh, 0..count, u64::from(u32::MAX) - 10, None, &mut bytes);
        assert_eq!(all, Err(TransferError::Numbers { what: "primitive numbers" }));
    }

    #[test]
    fn damaged_bytes_are_errors_or_valid_clusters() {
        let mesh = sphere();
        let triangles = mesh.triangle_count() as u64;
        let mut bytes = Vec::new();
        write_clusters(&mesh, [0, 1], 0, Some(0), &mut bytes).expect("numbers fit");
        let read = |bytes: &[u8]| {
            let mut assembly = Assembly::new(&mesh, triangles, Some(triangles));
            assembly.read(bytes)?;
            assembly.finish().map_err(|(_, error)| error)
        };
        let first = mesh.stretch(0).len() * Line::BYTES + mesh.cluster(0).triangles() * size_of::<u32>();
        for length in (0..bytes.len()).filter(|&length| length > 0 && length != first) {
            assert!(matches!(read(&bytes[..length]), Err(TransferError::Short { .. })), "{length} bytes");
        }
        let mut errors = 0;
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x80;
            match read(&damaged) {
                Err(_) => errors += 1,
                Ok(mesh) => mesh.views().for_each(|view| {
                    (0..view.triangles()).for_each(|t| assert!(view.primitive(t) < triangles as u32));
                    assert!(view.corners().into_iter().flatten().all(|&v| usize::from(v) < view.vertices()));
                }),
            }
        }
        // Corners, most coordinates, primitive numbers and faces; not what is only seen.
        assert!(errors * 4 > bytes.len(), "{errors} of {}", bytes.len());
        // A smaller model.
        let bounds = Aabb { max: mesh.bounds.center(), ..mesh.bounds };
        let smaller = sphere().as_part_of(&Whole { bounds, translucent: false, checksum: 1 });
        let mut assembly = Assembly::new(&smaller, triangles, Some(triangles));
        assembly.read(&bytes).expect("clusters");
        let wrong = assembly.finish();
        assert!(wrong.is_err());
    }
}
