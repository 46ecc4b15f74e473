//! Meshes, scenes and comparisons that the tests of the renderer share.
#![allow(dead_code, reason = "every test binary takes what it needs")]

use std::sync::Arc;

use glam::DVec3;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::{Mesh, OctNormal};
use tercio_raster::{Frame, Outputs, Renderer, Settings, reference};
use tercio_scene::{Camera, Instance, Projection, Scene};

/// A small generator of numbers from 0 to 1, the same everywhere (Steele, Lea and Flood's SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.next()
    }

    pub fn point(&mut self, reach: f64) -> DVec3 {
        DVec3::new(self.between(-reach, reach), self.between(-reach, reach), self.between(-reach, reach))
    }
}

/// Random triangles in a cube round zero, of sizes over three orders of magnitude, with colours and normals.
pub fn soup(triangles: usize, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let mut mesh = Mesh::default();
    let (mut normals, mut colors) = (Vec::new(), Vec::new());
    for t in 0..triangles as u32 {
        let middle = random.point(1.0);
        let size = 0.003 * 1000f64.powf(random.next() * random.next());
        for _ in 0..3 {
            mesh.positions.push((middle + random.point(size)).as_vec3().to_array());
            normals.push(OctNormal::encode(random.point(1.0).as_vec3().to_array()));
            colors.push([(random.next() * 256.0) as u8, (random.next() * 256.0) as u8, 128, 255]);
        }
        mesh.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
    }
    mesh.normals = Some(normals);
    mesh.vertex_colors = Some(colors);
    mesh
}

/// An octahedron with every side cut into n * n triangles, pushed out to the unit sphere: closed, outwards
/// wound, with normals.
pub fn sphere(n: u32) -> Mesh {
    let mut numbers = std::collections::HashMap::new();
    let mut mesh = Mesh::default();
    let mut vertex = |p: [i32; 3], mesh: &mut Mesh| {
        *numbers.entry(p).or_insert_with(|| {
            let v = DVec3::from(p.map(f64::from)).normalize();
            mesh.positions.push(v.as_vec3().to_array());
            mesh.positions.len() as u32 - 1
        })
    };
    let n = n as i32;
    for side in 0..8 {
        let sign = [0, 1, 2].map(|k| if side >> k & 1 == 0 { 1 } else { -1 });
        let flip = sign.iter().product::<i32>() < 0;
        for i in 0..n {
            for j in 0..n - i {
                let at = |i: i32, j: i32| [sign[0] * i, sign[1] * j, sign[2] * (n - i - j)];
                let mut add = |a, b, c| {
                    let t = [a, b, c].map(|p| vertex(p, &mut mesh));
                    mesh.triangles.push(if flip { [t[0], t[2], t[1]] } else { t });
                };
                add(at(i, j), at(i + 1, j), at(i, j + 1));
                if i + j + 1 < n {
                    add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                }
            }
        }
    }
    mesh.normals = Some(mesh.positions.iter().map(|&p| OctNormal::encode(p)).collect());
    mesh
}

/// One mesh under the default lights, clustered in this way.
pub fn scene_with(mesh: &Mesh, options: &PartitionOptions) -> Scene {
    Scene::of_mesh(Arc::new(partition(mesh.clone(), options)))
}

pub fn scene(mesh: &Mesh) -> Scene {
    scene_with(mesh, &PartitionOptions::default())
}

pub fn perspective(eye: [f64; 3], target: [f64; 3], degrees: f64) -> Camera {
    Camera {
        eye: eye.into(),
        target: target.into(),
        up: DVec3::new(0.1, 1.0, 0.05),
        projection: Projection::Perspective { fov_y: degrees.to_radians() },
        near: None,
    }
}

pub fn orthographic(eye: [f64; 3], target: [f64; 3], height: f64) -> Camera {
    Camera { projection: Projection::Orthographic { height }, ..perspective(eye, target, 30.0) }
}

/// Settings that ask for every plane.
pub fn everything(width: u32, height: u32) -> Settings {
    let outputs = Outputs { color: true, color16: true, depth: true, ids: true, normals: true };
    Settings { outputs, ..Settings::new(width, height) }
}

pub fn draw(scene: &Scene, camera: &Camera, settings: &Settings) -> Frame {
    Renderer::new().render(scene, camera, settings).expect("a picture")
}

pub fn draw_reference(mesh: &Mesh, scene: &Scene, camera: &Camera, settings: &Settings) -> Frame {
    reference::render(&vec![mesh; scene.instances.len()], scene, camera, settings).expect("a picture")
}

/// Fails with the first pixel that differs in any plane.
#[track_caller]
pub fn assert_same(expected: &Frame, found: &Frame, what: &str) {
    let bits = |f: &Frame| -> Vec<_> {
        let normals: Vec<[u32; 3]> = f.normals.iter().map(|n| n.map(f32::to_bits)).collect();
        let depth: Vec<u32> = f.depth.iter().map(|d| d.to_bits()).collect();
        let pixels = f.width as usize * f.height as usize;
        let get = |p: usize| {
            (
                f.ids.get(p).copied(),
                depth.get(p).copied(),
                f.color.get(p).copied(),
                f.color16.get(p).copied(),
                normals.get(p).copied(),
            )
        };
        (0..pixels).map(get).collect()
    };
    assert_eq!((expected.width, expected.height), (found.width, found.height), "{what}");
    let (a, b) = (bits(expected), bits(found));
    let different = a.iter().zip(&b).filter(|(a, b)| a != b).count();
    if let Some(p) = (0..a.len()).find(|&p| a[p] != b[p]) {
        let (x, y) = (p % expected.width as usize, p / expected.width as usize);
        panic!(
            "{what}: {different} of {} pixels differ, first ({x}, {y}):\n expected {:?}\n found    {:?}",
            a.len(),
            a[p],
            b[p]
        );
    }
}

/// Runs in a pool of its own.
pub fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool").install(work)
}

/// The same scene with a second instance, turned, smaller and to the side.
pub fn with_second_instance(mut scene: Scene) -> Scene {
    let turned = glam::DAffine3::from_scale_rotation_translation(
        DVec3::new(0.5, -0.4, 0.6),
        glam::DQuat::from_rotation_y(1.0),
        DVec3::new(0.7, 0.3, 0.2),
    );
    let second = Instance { world_from_object: turned, ..scene.instances[0].clone() };
    scene.instances.push(second);
    scene
}
