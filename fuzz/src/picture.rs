//! From the bytes of a file to pixels: read, repair, weld, make normals, partition into clusters, draw in different
//! ways, and compare.

use tercio::glam::DVec3;
use tercio::mesh::cluster::{PartitionOptions, partition};
use tercio::mesh::io::ReadOptions;
use tercio::mesh::io::input::Input;
use tercio::mesh::io::prepared;
use tercio::mesh::{Mesh, OctNormal, ReadError};
use tercio::raster::{
    Binning, Cull, Filter, Frame, Outputs, Renderer, SamplePattern, SampleShading, Sampling, Settings,
    Shading, SimdLevel, Sorting, reference,
};
use tercio::scene::{Camera, Framing, Projection, Scene};
use tercio::{LoadError, LoadOptions, Normals};

/// Models are loaded twice, and clusters, normals and welding take more time than reading.
const MEMORY_LIMIT: u64 = 16 << 20;

/// Larger models are loaded and not drawn: the reference renderer is slow.
const MOST_TRIANGLES: usize = 2_000;

/// Draws the bytes in three ways: the reference renderer, the renderer with default choices, and the renderer at the
/// lowest SIMD level with another partition, tile size and sorting. All planes must be equal.
///
/// # Panics
/// If loading or drawing does, if a loaded mesh is inconsistent, or if pictures differ.
pub fn draw_bytes(bytes: &[u8]) {
    crate::allow_damage();
    // The view is derived from the number of bytes, so that an input is reproducible and every view occurs.
    let number = bytes.len();
    let crease_angle = [Some(1.0), None, Some(0.2)][number % 3];
    let options = LoadOptions {
        memory_limit: Some(MEMORY_LIMIT),
        normals: if number % 5 == 4 { Normals::File } else { Normals::FileOrMade { crease_angle } },
        details: number.is_multiple_of(7),
        ..LoadOptions::default()
    };
    let read = ReadOptions { memory_limit: options.memory_limit, progress: None, ..ReadOptions::default() };
    let input = || Input::from_bytes("fuzz", bytes.to_vec(), &read);
    let loaded = input().map(|input| options.load_input(&input));
    let plain = input().map(|input| options.load_mesh_input(&input));
    let (Ok(loaded), Ok(plain)) = (loaded, plain) else { return };
    let (loaded, plain) = match (loaded, plain) {
        (Ok(loaded), Ok(plain)) => (loaded, plain.mesh),
        // Clusters take memory that the plain mesh does not need.
        (Err(LoadError::Read(ReadError::MemoryLimit { .. })), _) => return,
        (Err(error), Err(other)) => return assert_eq!(error.to_string(), other.to_string()),
        (Err(error), Ok(_)) => panic!("loads without clusters, but not with them: {error}"),
        (Ok(_), Err(_)) if prepared::is_prepared(bytes) => return,
        (Ok(_), Err(error)) => panic!("loads with clusters, but not without: {error}"),
    };
    check(&plain);
    if plain.triangles.len() > MOST_TRIANGLES {
        return;
    }
    let mut scene = Scene::from_mesh(loaded.mesh);
    if number.is_multiple_of(2) {
        scene.instances[0].surface.specular = 0.0;
    }
    let odd = PartitionOptions {
        max_vertices: 9,
        max_triangles: 5,
        shuffle_seed: Some(number as u64),
        ..PartitionOptions::default()
    };
    let mut cut_otherwise = Scene::from_mesh(partition(plain.clone(), &odd));
    cut_otherwise.instances[0].surface = scene.instances[0].surface;
    let camera = camera(&scene, number / 3);
    let settings = settings(number);
    let drawn = Renderer::new().render(&scene, &camera, &settings);
    let lowest = Settings {
        simd: SimdLevel::available().first().copied(),
        sorting: Sorting::Triangles,
        binning: Binning::BoundingBox,
        cluster_culling: false,
        tile_size: Some(8),
        ..settings.clone()
    };
    let otherwise = Renderer::new().render(&cut_otherwise, &camera, &lowest);
    let expected = reference::render(&[&plain], &scene, &camera, &settings);
    match (drawn, otherwise, expected) {
        (Ok(drawn), Ok(otherwise), Ok(expected)) => {
            assert_same(&drawn, &expected, "the reference");
            assert_same(&otherwise, &expected, "another partition, lowest SIMD level");
            // Drawing only colours uses kernels of its own.
            let alone = Settings { outputs: Outputs::default(), ..settings };
            let alone = Renderer::new().render(&scene, &camera, &alone).expect("drawn before");
            assert!(alone.planes.color == expected.planes.color, "colours alone differ");
        }
        (Err(a), Err(b), Err(c)) => {
            let [a, b, c] = [a, b, c].map(|error| error.to_string());
            assert!(a == b && b == c, "{a}\n{b}\n{c}");
        }
        (a, b, c) => panic!("{:?}, {:?}, {:?}", a.err(), b.err(), c.err()),
    }
}

/// Draws the bytes as a prepared model. Its bounds may be wrong, and then the picture is: only a panic, a hang or too
/// much memory is a failure.
///
/// # Panics
/// If reading or drawing does.
pub fn draw_prepared(bytes: &[u8]) {
    let options = ReadOptions { memory_limit: Some(MEMORY_LIMIT), progress: None, ..ReadOptions::default() };
    let Ok(input) = Input::from_bytes("fuzz", bytes.to_vec(), &options) else { return };
    let mesh = match prepared::read(&input, &options) {
        Ok(prepared) => prepared.mesh,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    assert_eq!(mesh.triangles().count(), mesh.triangle_count());
    let number = bytes.len();
    let scene = Scene::from_mesh(mesh);
    let camera = camera(&scene, number);
    for sorting in [Sorting::Clusters, Sorting::Triangles] {
        let settings = Settings { sorting, ..settings(number) };
        // Coordinates may be out of range, which is an error.
        let _ = Renderer::new().render(&scene, &camera, &settings);
    }
}

/// The invariants of a mesh that is ready for drawing.
fn check(mesh: &Mesh) {
    assert!(mesh.positions.as_flattened().iter().all(|c| c.is_finite()), "a position is not finite");
    assert!(
        mesh.triangles.as_flattened().iter().all(|&v| (v as usize) < mesh.positions.len()),
        "a corner is none"
    );
    let whole = |n: &OctNormal| *n != OctNormal::NONE;
    assert!(mesh.normals.iter().flatten().all(whole), "a broken normal was not replaced");
}

/// From outside, from inside, orthographic, or very near.
fn camera(scene: &Scene, view: usize) -> Camera {
    let framing = Framing { azimuth: (view * 37 % 360) as f64, ..Framing::new(48, 36) };
    let framed = framing.camera_for_scene(scene);
    let bounds = scene.bounds();
    match view % 4 {
        0 => framed,
        _ if bounds.is_empty() => framed,
        1 => Framing { fov_y: None, elevation: -30.0, ..framing }.camera_for_scene(scene),
        2 => Camera {
            eye: bounds.center(),
            target: bounds.center() + DVec3::new(0.3, -0.2, 1.0) * bounds.radius().max(1e-300),
            projection: Projection::Perspective { fov_y: 1.5 },
            shift: [0.3, -0.2],
            ..framed
        },
        _ => Camera { eye: bounds.min + (bounds.max - bounds.min) * 1e-7, ..framed },
    }
}

fn settings(number: usize) -> Settings {
    let outputs = Outputs::ALL;
    let tent = Sampling { filter: Filter::Tent, ..Sampling::of(SamplePattern::Sparse2) };
    let by_sample = Sampling { shading: SampleShading::Sample, ..Sampling::of(SamplePattern::Ordered4x4) };
    Settings {
        outputs,
        shading: [Shading::Phong, Shading::Flat, Shading::Gouraud, Shading::Unlit][number / 2 % 4],
        cull: [Cull::Auto, Cull::None, Cull::Back, Cull::Front][number / 8 % 4],
        sampling: [Sampling::NONE, Sampling::default(), tent, by_sample][number / 3 % 4],
        ..Settings::new(48, 36)
    }
}

fn assert_same(found: &Frame, expected: &Frame, what: &str) {
    if let Some(difference) = found.difference(expected) {
        panic!("differs from {what}: {difference}");
    }
}
