//! The estimate of the work in each tile, by which ranks divide the picture.

use std::sync::Arc;

use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_raster::binning::Sorted;
use tercio_raster::context::FrameContext;
use tercio_raster::{ClusterSet, Part, Renderer, Settings};
use tercio_scene::{Camera, Instance, Projection, Scene};

/// The estimate, and the entries of the bins, of each tile.
fn load_and_fill(scene: &Scene, camera: &Camera, settings: &Settings) -> (Vec<u64>, Vec<u64>) {
    let context = FrameContext::new(scene, camera, settings, 1).expect("a frame");
    let load = Renderer::estimate_load(&context);
    let mut sorted = Sorted::default();
    Renderer::new().sort(&context, &mut sorted);
    let fill = (0..context.grid.count() as u32).map(|tile| sorted.fill(tile)).collect();
    (load, fill)
}

/// Tiles with entries have work, and about their share of it.
#[test]
fn the_estimate_follows_the_bins() {
    for model in ["builtin:gyroid@60k", "builtin:terrain@60k", "builtin:teapot@900k"] {
        let mesh = builtin::make(model).expect("a model");
        let scene = Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())));
        let settings = Settings { tile_size: Some(64), ..Settings::one_sample(640, 480) };
        let perspective = settings.framing().camera_for_scene(&scene);
        let height = scene.bounds().radius() * 1.5;
        let parallel = Camera { projection: Projection::Orthographic { height }, ..perspective };
        for camera in [perspective, parallel] {
            let (load, fill) = load_and_fill(&scene, &camera, &settings);
            let tiles = load.len() as f64;
            let (work, entries) = (load.iter().sum::<u64>() as f64, fill.iter().sum::<u64>() as f64);
            let (mut apart, mut of_even_shares, mut unseen) = (0.0, 0.0, 0);
            for (&load, &fill) in load.iter().zip(&fill) {
                unseen += if load == 0 { fill } else { 0 };
                apart += (load as f64 / work - fill as f64 / entries).abs();
                of_even_shares += (1.0 / tiles - fill as f64 / entries).abs();
            }
            assert!(unseen as f64 <= 0.005 * entries, "{model}: {unseen} of {entries} entries are not seen");
            // Hidden clusters have entries, too, but less work.
            assert!(
                apart < 0.6 * of_even_shares,
                "{model}: the shares differ by {apart}, even ones by {of_even_shares}"
            );
        }
    }
}

/// Every cluster is in one set; each set has about the same work, and less is drawn that another one hides than of consecutive clusters.
#[test]
fn clusters_are_divided_by_visible_work() {
    // Triangles and pixels drawn beside those of the whole: of the sets, and of as many consecutive clusters.
    let mut of_all = [0.0; 2];
    for model in ["builtin:gyroid@200k", "builtin:terrain@200k", "builtin:teapot@200k"] {
        let mesh = builtin::make(model).expect("a model");
        let scene = Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())));
        let settings = Settings { tile_size: Some(32), ..Settings::one_sample(640, 480) };
        let near = settings.framing().camera_for_scene(&scene);
        // From behind, where the first clusters are hidden, and so near that most are outside the picture.
        let behind = Camera { eye: near.target * 2.0 - near.eye, ..near };
        let inside = Camera { eye: near.target + (near.eye - near.target) * 0.4, ..near };
        for camera in [near, behind, inside] {
            let drawn = |clusters: ClusterSet| {
                let settings = Settings { clusters, ..settings.clone() };
                let stats = Renderer::new().render(&scene, &camera, &settings).expect("a picture").stats;
                (stats.backend.triangles_drawn + stats.backend.pixels_shaded) as f64
            };
            let whole = drawn(ClusterSet::ALL);
            let context = FrameContext::new(&scene, &camera, &settings, 1).expect("a frame");
            let clusters = context.clusters();
            for parts in [1, 2, 3, 8] {
                let sets = Renderer::divide_clusters(&context, parts);
                let most_clusters = check_division(&sets, parts, clusters);
                assert!(
                    most_clusters <= 3 * clusters as usize / parts,
                    "{model}: {most_clusters} of {clusters}"
                );
                let work: Vec<f64> = sets.into_iter().map(drawn).collect();
                let all: f64 = work.iter().sum();
                let most = work.iter().fold(0.0, |most, &work| f64::max(most, work));
                assert!(most <= 1.3 * all / parts as f64, "{model}, {parts} parts: {work:?}");
                let part = |number| Part { number, of: parts as u32 }.range(clusters);
                let of_consecutive: f64 = (0..parts as u32).map(|number| drawn(part(number).into())).sum();
                of_all = [of_all[0] + all - whole, of_all[1] + of_consecutive - whole];
            }
        }
    }
    assert!(of_all[0] < 0.75 * of_all[1], "{of_all:?}");
}

/// Checks that every cluster is in one of the sets, and returns the size of the largest one.
fn check_division(sets: &[ClusterSet], parts: usize, clusters: u32) -> usize {
    assert_eq!(sets.len(), parts);
    let numbers = |set: &ClusterSet| set.ranges(clusters).into_iter().flatten().collect::<Vec<u32>>();
    let sets: Vec<_> = sets.iter().map(numbers).collect();
    let mut all = sets.concat();
    all.sort_unstable();
    assert!(all.iter().copied().eq(0..clusters), "{} of {clusters} clusters", all.len());
    sets.iter().map(Vec::len).max().unwrap_or(0)
}

/// Whatever there is to divide: few clusters, none, none in the picture, many of which each stands for several, and some that each
/// cover the picture.
#[test]
fn every_cluster_is_in_one_set() {
    let partitioned = |model: &str, max_triangles: usize| {
        let mesh = builtin::make(model).expect("a model");
        let options = PartitionOptions { max_triangles, ..Default::default() };
        Scene::from_mesh(Arc::new(partition(mesh, &options)))
    };
    let with_copies = |mut scene: Scene| {
        for place in [-0.7, 1.3] {
            let world_from_object = glam::DAffine3::from_translation(glam::DVec3::X * place);
            scene.instances.push(Instance { world_from_object, ..scene.instances[0].clone() });
        }
        scene
    };
    let settings = Settings { tile_size: Some(32), ..Settings::one_sample(640, 480) };
    let few = partitioned("builtin:teapot@1k", 128);
    let near = settings.framing().camera_for_scene(&few);
    let away = Camera { target: near.eye * 2.0 - near.target, ..near };
    let inside = Camera { eye: near.target, target: near.target + near.eye, ..near };
    let none = Scene { instances: Vec::new(), ..few.clone() };
    let many = with_copies(partitioned("builtin:sphere@100k", 8));
    let large = with_copies(partitioned("builtin:soup@30k", 64));
    for scene in [&few, &none, &many, &large] {
        for camera in [near, away, inside] {
            let context = FrameContext::new(scene, &camera, &settings, 1).expect("a frame");
            for parts in [1, 2, 7, 50, 300] {
                let sets = Renderer::divide_clusters(&context, parts);
                let most = check_division(&sets, parts, context.clusters());
                // Outside the picture it is divided by number.
                let is_away = camera == away;
                assert!(
                    !is_away || most <= (context.clusters() as usize).div_ceil(parts),
                    "{most} of {parts}"
                );
            }
        }
    }
    assert!(many.cluster_count() > 3 * 4096);
}

/// Where all clusters are large, few of them are looked at, and stand for the others.
#[test]
fn large_clusters_do_not_take_long() {
    let mesh = builtin::make("builtin:soup@300k").expect("a model");
    let scene = Scene::from_mesh(Arc::new(partition(
        mesh,
        &PartitionOptions { max_triangles: 64, ..Default::default() },
    )));
    let settings = Settings { tile_size: Some(32), ..Settings::one_sample(3840, 2160) };
    let camera = settings.framing().camera_for_scene(&scene);
    let context = FrameContext::new(&scene, &camera, &settings, 1).expect("a frame");
    let load = Renderer::estimate_load(&context);
    // As many as the scene has, within a factor: what is hidden counts half.
    let triangles = scene.instances[0].mesh.triangle_count() as u64;
    let work = load.iter().sum::<u64>();
    assert!(work > triangles / 8, "{work} for {triangles} triangles");
}
