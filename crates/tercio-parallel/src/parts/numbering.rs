//! What the parts of a model have to know of the whole.

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice, pod_read_unaligned};
use tercio_mesh::cluster::Whole;
use tercio_mesh::{Aabb, ClusteredMesh, checksum};
use tercio_raster::context::faces_of;
use tercio_raster::conventions::MAX_NUMBERS;
use tercio_scene::{Scene, Share};

use super::PartsError;
use crate::ParallelError;
use crate::comm::Communicator;
use crate::comm::collective::all_reduce_arrays;

/// What the other ranks have to know of a part.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Summary {
    /// Bits of the origin.
    origin: [u64; 3],
    exponent: i64,
    /// Checksums of layout and materials.
    layout: u64,
    materials: u64,
    checksum: u64,
    triangles: u64,
    /// Input faces, and those up to the last one that has a triangle.
    faces: u64,
    used_faces: u64,
    /// 1 if the colours of any triangle are not opaque.
    translucent: u64,
    /// World-space bounds.
    min: [f64; 3],
    max: [f64; 3],
}

impl Summary {
    fn of(mesh: &ClusteredMesh, faces: u64) -> Self {
        let text = |text: String| checksum::of(text.as_bytes());
        Self {
            origin: mesh.origin.to_array().map(f64::to_bits),
            exponent: mesh.exponent.into(),
            layout: text(format!("{:?}", mesh.layout())),
            materials: text(format!("{:?}", mesh.materials)),
            checksum: mesh.checksum(),
            triangles: mesh.triangle_count() as u64,
            faces,
            used_faces: faces_of(mesh),
            translucent: mesh.is_translucent().into(),
            min: mesh.bounds.min.to_array(),
            max: mesh.bounds.max.to_array(),
        }
    }

    /// What differs from another part, so that they cannot be parts of one model.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        let differs = [
            (self.origin != other.origin, "another origin"),
            (self.exponent != other.exponent, "another unit"),
            (self.layout != other.layout, "other normals, colours or attributes"),
            (self.materials != other.materials, "other materials"),
        ];
        differs.into_iter().find(|(differs, _)| *differs).map(|(_, what)| what)
    }
}

/// Makes a mesh this rank's part of the model that the meshes of all ranks are together, in the order of the ranks, and returns
/// its share of it. All ranks have to call this. `faces` is the number of input faces from the first one of this part to the
/// first one of the next rank's.
///
/// The meshes must have the same origin, unit, layout and materials, also those without triangles, and vertices in the order of
/// the whole model ([`ClusteredMesh::as_part_of`]). Then the mesh has the bounds of all of them, is translucent if any of them
/// is, and has a checksum that is made from theirs.
///
/// # Errors
/// [`PartsError::Differs`], [`PartsError::TooLarge`], on all ranks; [`ParallelError::Comm`]. The mesh is unchanged then.
pub fn number(
    comm: &mut impl Communicator,
    mesh: &mut ClusteredMesh,
    faces: u64,
) -> Result<Share, ParallelError> {
    let rank = comm.rank();
    let blocks = comm.all_gather(bytes_of(&Summary::of(mesh, faces)).to_vec())?;
    let all: Vec<Summary> = blocks.iter().map(|block| pod_read_unaligned(block)).collect();
    let different = all.iter().enumerate().find_map(|(rank, of)| Some((rank, of.difference(&all[0])?)));
    if let Some((rank, what)) = different {
        return Err(PartsError::Differs { rank, what }.into());
    }
    // As the whole model's, without faces behind the last one that has a triangle.
    let (mut share, mut first_face) = (Share::default(), 0u64);
    for (number, of) in all.iter().enumerate() {
        if number == rank {
            (share.first_triangle, share.first_face) = (share.triangles, first_face);
        }
        if of.triangles > 0 {
            share.faces = first_face.saturating_add(of.used_faces);
        }
        share.triangles = share.triangles.saturating_add(of.triangles);
        first_face = first_face.saturating_add(of.faces);
    }
    if share.triangles > MAX_NUMBERS || first_face.max(share.faces) > MAX_NUMBERS {
        let (triangles, faces) = (share.triangles, first_face.max(share.faces));
        return Err(PartsError::TooLarge { triangles, faces }.into());
    }
    // Behind the last face is nothing to be numbered.
    share.first_face = share.first_face.min(share.faces);
    let bounds = all
        .iter()
        .filter(|of| of.triangles > 0)
        .fold(Aabb::EMPTY, |bounds, of| bounds.union(Aabb { min: of.min.into(), max: of.max.into() }));
    let checksums: Vec<u64> = all.iter().map(|of| of.checksum).collect();
    let translucent = all.iter().any(|of| of.translucent != 0);
    let whole = Whole { bounds, translucent, checksum: checksum::of(cast_slice(&checksums)) };
    *mesh = std::mem::take(mesh).as_part_of(&whole);
    Ok(share)
}

/// Agrees on which instances may be less than opaque because of their materials, of which a rank sees only those of its own
/// triangles. All ranks have to call this with scenes of the same instances, after they have got their materials.
///
/// # Errors
/// [`ParallelError::Comm`].
pub fn share_materials(comm: &mut impl Communicator, scene: &mut Scene) -> Result<(), ParallelError> {
    let of_instance =
        |i: &tercio_scene::Instance| u8::from(i.materials.as_ref().is_some_and(|m| m.is_translucent()));
    let mut translucent: Vec<u8> = scene.instances.iter().map(of_instance).collect();
    all_reduce_arrays(comm, &mut translucent, u8::max)?;
    for (number, is_translucent) in translucent.into_iter().enumerate() {
        let instance = &scene.instances[number];
        if let (Some(materials), Some(_)) = (&instance.materials, instance.share) {
            let of_part = materials.for_part(&instance.mesh, scene, is_translucent != 0);
            scene.instances[number].materials = Some(of_part);
        }
    }
    Ok(())
}
