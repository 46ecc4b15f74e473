//! Meshes, scenes and comparisons that the tests of the renderer share.
#![allow(dead_code, reason = "each test binary uses a part of it")]

use std::sync::Arc;

use glam::DVec3;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::{Mesh, OctNormal};
use tercio_raster::frame::NO_PRIMITIVE;
use tercio_raster::projection::clip::clip_triangle;
use tercio_raster::view::{ScreenVertex, View};
use tercio_raster::{Binning, Cull, Frame, Outputs, Renderer, Settings, SimdLevel, Sorting, reference};
use tercio_scene::{Camera, Instance, Projection, Scene};

/// A small random number generator (SplitMix64 of Steele, Lea and Flood), the same on every machine.
pub struct Random(pub u64);

impl Random {
    /// A number from 0 to 1.
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

/// Random triangles in a cube around the origin, with sizes over three orders of magnitude, with colours and normals.
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

/// An octahedron with every side subdivided into n * n triangles and projected onto the unit sphere: closed, wound
/// outwards, with normals.
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

/// A scene of one mesh under the default lights, clustered with these options.
pub fn scene_with(mesh: &Mesh, options: &PartitionOptions) -> Scene {
    Scene::from_mesh(Arc::new(partition(mesh.clone(), options)))
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
        shift: [0.0; 2],
    }
}

pub fn orthographic(eye: [f64; 3], target: [f64; 3], height: f64) -> Camera {
    Camera { projection: Projection::Orthographic { height }, ..perspective(eye, target, 30.0) }
}

/// Settings that request every plane.
pub fn everything(width: u32, height: u32) -> Settings {
    let outputs = Outputs::ALL;
    Settings { outputs, ..Settings::one_sample(width, height) }
}

pub fn draw(scene: &Scene, camera: &Camera, settings: &Settings) -> Frame {
    Renderer::new().render(scene, camera, settings).expect("a picture")
}

pub fn draw_reference(mesh: &Mesh, scene: &Scene, camera: &Camera, settings: &Settings) -> Frame {
    reference::render(&vec![mesh; scene.instances.len()], scene, camera, settings).expect("a picture")
}

/// Fails with the first difference if two frames are not the same.
#[track_caller]
pub fn assert_same(expected: &Frame, found: &Frame, what: &str) {
    if let Some(difference) = found.difference(expected) {
        panic!("{what}: {difference}");
    }
}

/// Runs some work in a thread pool of its own.
pub fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool").install(work)
}

/// The same scene with a second instance: rotated, mirrored, smaller and to the side.
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

/// Draws with each of the settings that must not change the picture, and expects the bytes of the reference.
/// `partitions` are further partitions of the mesh into clusters: maximum number of vertices, of triangles, seed of the
/// triangles' order.
pub fn check_paths(
    mesh: &Mesh,
    camera: &Camera,
    settings: &Settings,
    partitions: &[(usize, usize, Option<u64>)],
    what: &str,
) {
    let plain = scene(mesh);
    let expected = draw_reference(mesh, &plain, camera, settings);
    let check = |s: Settings, name: String| {
        assert_same(&expected, &draw(&plain, camera, &s), &format!("{what}, {name}"));
    };
    for simd in SimdLevel::available() {
        for binning in [Binning::BoundingBox, Binning::Exact] {
            for sorting in [Sorting::Clusters, Sorting::Triangles] {
                let s = Settings { simd: Some(simd), binning, sorting, ..settings.clone() };
                check(s, format!("{simd}, {binning:?}, {sorting:?}"));
            }
        }
    }
    for tile_size in [8, 16, 32, 64, 128] {
        let s = Settings { tile_size: Some(tile_size), ..settings.clone() };
        check(s, format!("tiles of {tile_size}"));
    }
    for threads in [1, 2, 3, 7] {
        with_threads(threads, || check(settings.clone(), format!("{threads} threads")));
    }
    check(Settings { cluster_culling: false, ..settings.clone() }, "no cluster culling".into());
    if settings.cull == Cull::Auto {
        check(Settings { cull: Cull::None, ..settings.clone() }, "no culling".into());
    }
    for &(max_vertices, max_triangles, shuffle_seed) in partitions {
        let options = PartitionOptions { max_vertices, max_triangles, shuffle_seed, ..Default::default() };
        let found = draw(&scene_with(mesh, &options), camera, settings);
        assert_same(&expected, &found, &format!("{what}, clusters of {max_vertices} and {max_triangles}"));
    }
}

/// A random unit vector, uniformly distributed.
pub fn direction(random: &mut Random) -> DVec3 {
    loop {
        let p = random.point(1.0);
        if (0.1..=1.0).contains(&p.length()) {
            return p.normalize();
        }
    }
}

/// Which pixels show a triangle.
pub fn covered(frame: &Frame) -> Vec<bool> {
    frame.planes.ids.iter().map(|&id| id != NO_PRIMITIVE).collect()
}

/// Settings that request the ids only.
pub fn ids_only(width: u32, height: u32) -> Settings {
    let outputs = Outputs { color: false, ids: true, ..Outputs::default() };
    Settings { outputs, ..Settings::one_sample(width, height) }
}

/// Does a triangle with corners in whole sub-pixels cover the sample of a pixel? Textbook edge functions in 128 bits,
/// with the top-left rule. Returns 0 if not, 1 if it does and appears clockwise on the screen, -1 if it appears
/// counter-clockwise.
pub fn covers(corners: [[i32; 2]; 3], pixel: [i32; 2]) -> i32 {
    let p = corners.map(|c| c.map(i128::from));
    let s = pixel.map(|c| i128::from(c) * 256 + 128);
    let side = |a: [i128; 2], b: [i128; 2], p: [i128; 2]| {
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    };
    let area = side(p[0], p[1], p[2]);
    let p = if area > 0 { p } else { [p[0], p[2], p[1]] };
    let inside = |k: usize| {
        let (a, b) = (p[k], p[(k + 1) % 3]);
        // In a clockwise triangle, with y downwards, a left edge points upwards, a top edge to the right.
        let (left, top) = (b[1] < a[1], b[1] == a[1] && b[0] > a[0]);
        let value = side(a, b, s);
        value > 0 || value == 0 && (left || top)
    };
    if area != 0 && (0..3).all(inside) { area.signum() as i32 } else { 0 }
}

/// Projects all triangles of the plain meshes of a scene's instances, clips them if necessary, and calls `emit` with
/// each triangle or piece: the instance, and the corners in the order of the mesh.
pub fn each_triangle(
    meshes: &[&Mesh],
    scene: &Scene,
    camera: &Camera,
    (width, height): (u32, u32),
    mut emit: impl FnMut(usize, [ScreenVertex; 3]),
) {
    let view = View::new(camera, &scene.bounds(), width, height).expect("a camera");
    for (instance, mesh) in meshes.iter().enumerate() {
        let object = view.object(&scene.instances[instance]);
        for &t in &mesh.triangles {
            let positions = Mesh::canonical(t).map(|v| mesh.positions[v as usize]);
            let projected = positions.map(|p| object.project(p));
            if projected.iter().all(|v| v.inside) {
                emit(instance, projected);
            } else {
                clip_triangle(&object, positions, projected, |piece| emit(instance, piece));
            }
        }
    }
}

/// How often each sample is covered, back faces minus front faces: the winding number of the surface on the screen,
/// after snapping and clipping. For a closed mesh it is 1 if the eye is inside, and 0 if the eye is outside and nothing
/// is clipped at the near plane.
pub fn winding(mesh: &Mesh, scene: &Scene, camera: &Camera, width: u32, height: u32) -> Vec<i32> {
    let mut counts = vec![0; width as usize * height as usize];
    each_triangle(&[mesh], scene, camera, (width, height), |_, v| {
        let corners = v.map(|v| [v.x, v.y]);
        let range = |k: usize, size: u32| {
            let (least, most) =
                (corners.map(|c| c[k]).into_iter().min(), corners.map(|c| c[k]).into_iter().max());
            (least.unwrap_or(0) >> 8).max(0)..=(most.unwrap_or(0) >> 8).min(size as i32 - 1)
        };
        for y in range(1, height) {
            for x in range(0, width) {
                counts[y as usize * width as usize + x as usize] += covers(corners, [x, y]);
            }
        }
    });
    counts
}

/// Draws with each of the settings that must not change the picture, and expects the bytes of the reference.
#[track_caller]
pub fn check_all(mesh: &Mesh, plain: &Scene, camera: &Camera, settings: &Settings, what: &str) {
    let expected = draw_reference(mesh, plain, camera, settings);
    let check = |s: Settings, name: String| {
        assert_same(&expected, &draw(plain, camera, &s), &format!("{what}, {name}"));
    };
    for simd in SimdLevel::available() {
        for sorting in [Sorting::Clusters, Sorting::Triangles] {
            check(Settings { simd: Some(simd), sorting, ..settings.clone() }, format!("{simd}, {sorting:?}"));
        }
    }
    for tile_size in [8, 16, 64, 128] {
        check(Settings { tile_size: Some(tile_size), ..settings.clone() }, format!("tiles of {tile_size}"));
    }
    for threads in [1, 2, 5] {
        with_threads(threads, || check(settings.clone(), format!("{threads} threads")));
    }
    for sorting in [Sorting::Clusters, Sorting::Triangles] {
        let s = Settings { layer_memory: 0, tile_size: Some(8), sorting, ..settings.clone() };
        check(s, format!("slices, {sorting:?}"));
    }
}

/// The ray through a point of a picture of this size, in pixels from its upper left corner: where it begins, and its direction.
pub fn ray(camera: &Camera, size: [u32; 2], [x, y]: [f64; 2]) -> (DVec3, DVec3) {
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    let [width, height] = size.map(f64::from);
    let (across, above) = (x - width / 2.0, height / 2.0 - y);
    match camera.projection {
        Projection::Perspective { fov_y } => {
            let per_pixel = 2.0 * (fov_y / 2.0).tan() / height;
            (camera.eye, forward + (right * across + up * above) * per_pixel)
        }
        Projection::Orthographic { height: world } => {
            let per_pixel = world / height;
            (camera.eye + (right * across + up * above) * per_pixel, forward)
        }
    }
}
