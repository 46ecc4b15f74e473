//! Models, their parts, and scenes of either.

use std::ops::Range;

use glam::{DAffine3, DQuat, DVec3};
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::{Aabb, ClusteredMesh, Mesh, builtin, normals};
use tercio_parallel::comm::Communicator;
use tercio_parallel::comm::threads::ThreadComm;
use tercio_parallel::{ParallelError, parts};
use tercio_scene::{Camera, Instance, Projection, Scene};

/// A model with normals, colours, and two triangles in most faces; some of the colours are not opaque if `alpha` is below 255.
pub fn model(name: &str, alpha: u8) -> Mesh {
    let mut mesh = builtin::make(name).expect("a model");
    normals::make_normals(&mut mesh, None);
    let shade = |k: usize| (k * 37 % 256) as u8;
    let vertices = mesh.positions.len();
    mesh.vertex_colors = Some((0..vertices).map(|k| [shade(k), shade(k / 7), 90, u8::MAX]).collect());
    let triangles = mesh.triangles.len();
    if alpha < u8::MAX {
        // Only at the end: most parts have none.
        let of = |k: usize| if k * 5 > triangles * 4 { alpha } else { u8::MAX };
        mesh.face_colors = Some((0..triangles).map(|k| [shade(k), 200, shade(k / 3), of(k)]).collect());
    }
    // A few faces have no triangles.
    mesh.face_of_triangle = Some((0..triangles as u32).map(|t| t / 2 + t / 100).collect());
    mesh
}

/// A range of a model's triangles, with the vertices that they use in the order of the model, and the number of faces up to the
/// first one of the triangles behind.
pub fn part(mesh: &Mesh, range: Range<usize>) -> (ClusteredMesh, u64) {
    let first_face = |at: usize| match &mesh.face_of_triangle {
        Some(faces) => faces.get(at).or(faces.last()).map_or(0, |&face| face + u32::from(at >= faces.len())),
        None => at as u32,
    };
    let mut used: Vec<u32> = mesh.triangles[range.clone()].as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let new = |old: u32| used.binary_search(&old).expect("a vertex in use") as u32;
    fn pick<T: Copy>(used: &[u32], values: &Option<Vec<T>>) -> Option<Vec<T>> {
        values.as_ref().map(|values| used.iter().map(|&v| values[v as usize]).collect())
    }
    fn cut<T: Copy>(range: &Range<usize>, values: &Option<Vec<T>>) -> Option<Vec<T>> {
        values.as_ref().map(|values| values[range.clone()].to_vec())
    }
    let begin = first_face(range.start);
    let own = Mesh {
        origin: mesh.origin,
        exponent: mesh.exponent,
        positions: used.iter().map(|&v| mesh.positions[v as usize]).collect(),
        triangles: mesh.triangles[range.clone()].iter().map(|t| t.map(new)).collect(),
        normals: pick(&used, &mesh.normals),
        vertex_colors: pick(&used, &mesh.vertex_colors),
        face_colors: cut(&range, &mesh.face_colors),
        texcoords: pick(&used, &mesh.texcoords),
        attributes: Vec::new(),
        materials: mesh.materials.clone(),
        triangle_materials: cut(&range, &mesh.triangle_materials),
        face_of_triangle: cut(&range, &mesh.face_of_triangle)
            .map(|faces| faces.into_iter().map(|face| face - begin).collect()),
    };
    let faces = u64::from(first_face(range.end) - begin);
    (partition(own, &PartitionOptions { max_triangles: 32, ..PartitionOptions::default() }), faces)
}

/// The parts between these cuts, which need not be in order.
pub fn split(mesh: &Mesh, cuts: &[usize]) -> Vec<(ClusteredMesh, u64)> {
    let mut cuts = cuts.to_vec();
    cuts.extend([0, mesh.triangles.len()]);
    cuts.sort_unstable();
    cuts.windows(2).map(|pair| part(mesh, pair[0]..pair[1])).collect()
}

/// About equal parts.
pub fn split_evenly(mesh: &Mesh, ranks: usize) -> Vec<(ClusteredMesh, u64)> {
    let cuts: Vec<usize> = (1..ranks).map(|k| mesh.triangles.len() * k / ranks).collect();
    split(mesh, &cuts)
}

pub fn whole(mesh: &Mesh, dress: impl Fn(&mut Scene)) -> Scene {
    let mut scene = Scene::from_mesh(partition(mesh.clone(), &PartitionOptions::default()));
    dress(&mut scene);
    scene
}

/// A rank's scene of its part.
pub fn in_parts(
    comm: &mut ThreadComm,
    parts: &[(ClusteredMesh, u64)],
    dress: impl Fn(&mut Scene),
) -> Result<Scene, ParallelError> {
    let (mut mesh, faces) = parts[comm.rank()].clone();
    let share = parts::number(comm, &mut mesh, faces)?;
    let mut scene = Scene::from_mesh(mesh);
    scene.instances[0].share = Some(share);
    dress(&mut scene);
    parts::share_materials(comm, &mut scene)?;
    Ok(scene)
}

/// Adds a second instance, rotated, mirrored, smaller, in the middle of the first.
pub fn twice(scene: &mut Scene) {
    let place = scene.bounds().center();
    let (scale, turn) = (DVec3::new(0.5, -0.4, 0.6), DQuat::from_rotation_y(1.0));
    let turned = DAffine3::from_scale_rotation_translation(scale, turn, place * 0.7);
    let second = Instance { world_from_object: turned, ..scene.instances[0].clone() };
    scene.instances.push(second);
}

/// A camera at this many radii from the centre; below 1 the near plane cuts the model.
pub fn camera(bounds: &Aabb, radii: f64) -> Camera {
    let eye = bounds.center() + DVec3::new(0.3, 0.4, 0.9).normalize() * bounds.radius() * radii;
    let target = bounds.center() + DVec3::X * 1e-3;
    let projection = Projection::Perspective { fov_y: 0.8 };
    Camera { eye, target, up: DVec3::Y, projection, near: None, shift: [0.0; 2] }
}
