//! Any number of ranks gives the bytes of one renderer.

mod common;

use std::sync::Arc;

use common::*;

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::comm::Kind;
use tercio_parallel::in_process::draw;
use tercio_parallel::{
    ClusterDivision, Composition, Division, Encoding, Organisation, RankReport, Ranks, Sharing,
};
use tercio_raster::{
    Cull, Filter, Outputs, Renderer, SamplePattern, SampleShading, Sampling, Settings, Shading, Sorting,
};
use tercio_scene::{Camera, Instance, Projection, Scene};

/// Ranks send fragments, or pixels that were made from them.
#[test]
fn pixels_of_several_samples() {
    let scene = with_second_instance(scene("builtin:soup@2k", 128));
    for sampling in [
        Sampling::default(),
        Sampling { shading: SampleShading::Sample, ..Sampling::of(SamplePattern::Sparse2) },
        Sampling::of(SamplePattern::Ordered4x4),
    ] {
        for (outputs, radii) in [(EVERYTHING, 2.6), (Outputs::default(), 0.4)] {
            let camera = camera(&scene, radii, false);
            let settings = Settings { outputs, sampling, ..Settings::new(131, 93) };
            let expected = Renderer::new().render(&scene, &camera, &settings).expect("a picture");
            for organisation in ALL {
                for count in [1, 2, 3, 5] {
                    let ranks = Ranks { count, threads: 1 + count % 2, sharing: organisation.into() };
                    check_against(&expected, &scene, &camera, &settings, ranks, &format!("{sampling:?}"));
                }
            }
        }
    }
}

/// Ranks draw no clusters, and send no fragments, that are behind what another rank hides.
#[test]
fn what_another_rank_hides_is_not_drawn() {
    let mut scene = scene("builtin:sphere@4k", 64);
    let small = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.3),
        DQuat::IDENTITY,
        DVec3::new(0.1, 0.1, -1.5),
    );
    let behind = Instance { world_from_object: small, ..scene.instances[0].clone() };
    scene.instances.push(behind);
    let radius = scene.instances[0].mesh.local_bounds().radius();
    let camera = Camera {
        eye: DVec3::Z * radius * 4.0,
        target: DVec3::ZERO,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y: 0.7 },
        near: None,
        shift: [0.0; 2],
    };
    // The first rank draws the sphere in front, the other one that behind it.
    let drawn = |scene: &Scene, sampling: Sampling, composition: Composition| {
        let settings = Settings { sampling, tile_size: Some(32), ..Settings::new(203, 190) };
        let clusters = ClusterDivision::Consecutive;
        let sharing = Sharing { composition, clusters, ..Organisation::SortLast.into() };
        let ranks = Ranks { count: scene.instances.len(), threads: 1, sharing };
        let report = check(scene, &camera, &settings, ranks, "behind");
        let of_rank = |rank: &RankReport| (rank.frame.backend.clusters_drawn, rank.pixels.fragment_bytes);
        report.ranks.iter().map(of_rank).collect::<Vec<_>>()
    };
    let tent = Sampling { filter: Filter::Tent, ..Sampling::default() };
    for composition in Composition::ALL {
        let (found, all) =
            (drawn(&scene, Sampling::default(), composition), drawn(&scene, tent, composition));
        for rank in 0..2 {
            assert_eq!(found[rank].0 > 0, rank == 0, "rank {rank} draws {} clusters", found[rank].0);
            assert!(all[rank].0 > 0, "rank {rank} with a wide filter");
        }
        let bytes = |of: &[(u64, u64)]| of.iter().map(|(_, bytes)| bytes).sum::<u64>();
        assert!(4 * bytes(&found) < bytes(&all), "{} and {} bytes", bytes(&found), bytes(&all));
        // A rank that has no tile in common with these two, and is rank 0.
        let mut apart = scene.clone();
        let aside = DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.1),
            DQuat::IDENTITY,
            DVec3::new(-1.3, -1.2, 0.0) * radius,
        );
        apart.instances.insert(0, Instance { world_from_object: aside, ..scene.instances[0].clone() });
        let found = drawn(&apart, Sampling::default(), composition);
        assert!(found[0].0 > 0 && found[1].0 > 0 && found[2].0 == 0, "{composition}: {found:?}");
        assert_eq!(found[0].1, 0, "{composition}: {found:?}");
    }
}

/// What a rank hides in many tiles is sent in more than one message for each group of them; with sparse encoding nothing is sent.
#[test]
fn what_is_hidden_in_many_tiles() {
    let mut scene = scene("builtin:sphere@4k", 64);
    let moved = DAffine3::from_translation(DVec3::new(0.1, 0.1, -1.5));
    scene.instances.push(Instance { world_from_object: moved, ..scene.instances[0].clone() });
    let settings = Settings { tile_size: Some(8), ..Settings::new(1200, 900) };
    let camera = camera(&scene, 1.5, false);
    let told = |encoding: Encoding| {
        let clusters = ClusterDivision::Consecutive;
        let sharing = Sharing { encoding, clusters, ..Organisation::SortLast.into() };
        let report = check(&scene, &camera, &settings, Ranks { count: 2, threads: 1, sharing }, "many tiles");
        // What the first rank, which is in front, tells.
        let told = report.ranks[0].partners.iter().find(|with| with.kind == Kind::Occlusion);
        told.map(|with| (with.traffic.sent_messages, with.traffic.sent_bytes))
    };
    // There are four groups.
    let (messages, bytes) = told(Encoding::Visible).expect("ranks tell what they hide");
    assert!(messages > 4, "{messages} messages");
    assert!(bytes <= messages * 3600, "{bytes} bytes in {messages} messages");
    assert_eq!(told(Encoding::Sparse), None);
}

/// Ranks send the layers of what is not opaque, in one round or in many.
#[test]
fn what_is_not_opaque() {
    let opaque = with_second_instance(scene("builtin:soup@2k", 128));
    let mut scene = opaque.clone();
    scene.instances[0].surface.opacity = 0.4;
    let by_sample = Sampling { shading: SampleShading::Sample, ..Sampling::of(SamplePattern::Sparse2) };
    let tent = Sampling { filter: Filter::Tent, ..Sampling::of(SamplePattern::Sparse8) };
    for (sampling, outputs, radii) in [
        (Sampling::default(), EVERYTHING, 1.5),
        (Sampling::default(), Outputs::default(), 0.4),
        (Sampling::NONE, EVERYTHING, 1.5),
        (by_sample, EVERYTHING, 0.4),
        (tent, Outputs::default(), 1.5),
        (Sampling::of(SamplePattern::Sparse16), Outputs { depth: true, ..Outputs::default() }, 1.5),
        (Sampling::NONE, Outputs { ids: true, color: false, ..Outputs::default() }, 1.5),
    ] {
        let camera = camera(&scene, radii, false);
        // With this little memory every tile is a round, drawn in slices of depth.
        for layer_memory in [128 << 20, 1] {
            let settings = Settings { outputs, sampling, layer_memory, ..Settings::new(131, 93) };
            let expected = Renderer::new().render(&scene, &camera, &settings).expect("a picture");
            for (organisation, count) in ALL.into_iter().flat_map(|o| [1, 2, 3, 5].map(|count| (o, count))) {
                let ranks = Ranks { count, threads: 1 + count % 2, sharing: organisation.into() };
                let what = format!("{sampling:?}, {radii} radii, {layer_memory} bytes");
                let report = check_against(&expected, &scene, &camera, &settings, ranks, &what);
                let layers: u64 = report.ranks.iter().map(|rank| rank.pixels.fragment_bytes).sum();
                assert_eq!(layers > 0, organisation.composites(count), "{what}");
            }
        }
    }
    // Small rounds need more messages.
    let messages = |layer_memory| {
        let settings = Settings { layer_memory, ..Settings::new(131, 93) };
        let ranks = Ranks { count: 3, threads: 1, sharing: Organisation::SortLast.into() };
        check(&scene, &camera(&scene, 1.5, false), &settings, ranks, "rounds").messages
    };
    assert!(messages(1) > 2 * messages(128 << 20), "{} and {}", messages(1), messages(128 << 20));
}

/// Surfaces that show data, opaque and not.
#[test]
fn colors_by_data() {
    let mut mesh = builtin::make("builtin:soup@2k").expect("a model");
    let values = (0..mesh.positions.len()).map(|v| (v * 37 % 101) as f32).collect();
    let (name, domain) = ("x".into(), tercio_mesh::AttributeDomain::Vertex);
    mesh.attributes.push(tercio_mesh::Attribute { name, domain, values, offset: 0.0, component: None });
    let plain = Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())));
    let map = tercio_scene::ColorMap::named("turbo").expect("a known map");
    for opacities in [vec![], vec![0.2, 1.0]] {
        let lines =
            tercio_scene::color_map::Isolines { values: vec![50.0], color: [0, 0, 0, 255], width: 2.0 };
        let colors = tercio_scene::DataColors {
            opacities,
            isolines: Some(lines),
            ..tercio_scene::DataColors::new("x", map.clone(), [10.0, 90.0])
        };
        for source in [tercio_scene::DataSource::Attribute(0), tercio_scene::DataSource::Along(DVec3::Y)] {
            let mut scene = plain.clone();
            let data = tercio_scene::SurfaceData::Mapped { source, colors: Arc::new(colors.clone()) };
            scene.instances[0].data = Some(Arc::new(data));
            let scene = with_second_instance(scene);
            let camera = camera(&scene, 1.5, false);
            for (organisation, count) in ALL.into_iter().flat_map(|o| [2, 3].map(|count| (o, count))) {
                let settings = Settings { outputs: EVERYTHING, ..Settings::new(101, 73) };
                let ranks = Ranks { count, threads: 1, sharing: organisation.into() };
                check(&scene, &camera, &settings, ranks, "data");
            }
        }
    }
}

/// Layers of several ranks at the same depth are blended in the order of their primitives.
#[test]
fn layers_at_equal_depths() {
    let mut twice = scene("builtin:teapot@2k", 16);
    let mut second = twice.instances[0].clone();
    second.surface.base_color = [1.0, 0.0, 0.0];
    twice.instances.push(second);
    for instance in &mut twice.instances {
        instance.surface.opacity = 0.6;
    }
    let camera = camera(&twice, 2.6, false);
    let settings = Settings { outputs: EVERYTHING, ..Settings::new(100, 80) };
    let mut swapped = twice.clone();
    swapped.instances.reverse();
    let [first, other] =
        [&twice, &swapped].map(|scene| Renderer::new().render(scene, &camera, &settings).expect("a picture"));
    assert_ne!(first.planes.color, other.planes.color, "the order does not matter");
    for count in [2, 3, 8] {
        let ranks = Ranks { count, threads: 1, sharing: Organisation::SortLast.into() };
        check(&twice, &camera, &settings, ranks, "equal depths");
    }
}

/// With a filter that is wider than a pixel, samples of one rank contribute to pixels of another.
#[test]
fn filters_wider_than_a_pixel() {
    let scene = scene("builtin:soup@2k", 128);
    let camera = camera(&scene, 2.6, false);
    let sampling = Sampling { filter: Filter::Tent, ..Sampling::default() };
    let settings = Settings { outputs: EVERYTHING, sampling, ..Settings::new(131, 93) };
    let expected = Renderer::new().render(&scene, &camera, &settings).expect("a picture");
    for organisation in ALL {
        for count in [1, 2, 5] {
            let ranks = Ranks { count, threads: 1, sharing: organisation.into() };
            let (found, _) = draw(ranks, &scene, &camera, &settings).expect("a picture");
            assert_same(&expected, &found, &format!("{ranks:?}"));
        }
    }
}

#[test]
fn every_number_of_ranks() {
    for model in ["builtin:teapot@6k", "builtin:soup@2k", "builtin:gyroid@4k"] {
        let scene = with_second_instance(scene(model, 128));
        for (radii, orthographic) in [(2.6, false), (0.4, false), (2.0, true)] {
            let camera = camera(&scene, radii, orthographic);
            for organisation in ALL {
                for count in 1..=9 {
                    let settings = Settings { outputs: EVERYTHING, ..Settings::one_sample(131, 93) };
                    let ranks = Ranks { count, threads: 1 + count % 2, sharing: organisation.into() };
                    check(&scene, &camera, &settings, ranks, model);
                }
            }
        }
    }
}

/// Every way to divide the picture and to composite, in pixels, fragments and layers.
#[test]
fn every_division_and_composition() {
    let opaque = with_second_instance(scene("builtin:gyroid@4k", 64));
    let mut clear = opaque.clone();
    clear.instances[1].surface.opacity = 0.5;
    let camera = camera(&opaque, 2.0, false);
    for (scene, settings) in [
        (&opaque, Settings::one_sample(131, 93)),
        (&opaque, Settings::new(131, 93)),
        (&clear, Settings::new(131, 93)),
    ] {
        let settings = Settings { tile_size: Some(16), ..settings };
        let expected = Renderer::new().render(scene, &camera, &settings).expect("a picture");
        for count in [2, 5, 8, 11] {
            let draw = |sharing: Sharing| {
                let ranks = Ranks { count, threads: 1, sharing };
                let (found, _) = draw(ranks, scene, &camera, &settings).expect("a picture");
                assert_same(&expected, &found, &format!("{ranks:?}"));
            };
            for division in Division::ALL {
                draw(Sharing { division, ..Organisation::SortFirst.into() });
                draw(Sharing { division, ..Organisation::SortMiddle.into() });
            }
            for composition in Composition::ALL.into_iter().chain([2, 3].map(Composition::radix_k)) {
                let is_possible =
                    |of: &Encoding| *of != Encoding::Dense || settings.sampling.pattern.count() == 1;
                for encoding in Encoding::ALL.into_iter().filter(is_possible) {
                    draw(Sharing { composition, encoding, ..Organisation::SortLast.into() });
                    draw(Sharing { composition, encoding, ..Organisation::SortTwice { group: 3 }.into() });
                }
            }
        }
    }
}

#[test]
fn among_equal_depths_the_lower_primitive_is_seen() {
    // The same model twice at the same position, in another colour: every sample is a tie between ranks.
    let mut twice = scene("builtin:teapot@2k", 16);
    let mut second = twice.instances[0].clone();
    second.surface.base_color = [1.0, 0.0, 0.0];
    let first = twice.clone();
    twice.instances.push(second);
    let camera = camera(&first, 2.6, false);
    let settings = Settings { outputs: EVERYTHING, ..Settings::one_sample(100, 80) };
    let expected = Renderer::new().render(&first, &camera, &settings).expect("a picture");
    for organisation in ALL {
        for count in [2, 3, 8] {
            let ranks = Ranks { count, threads: 1, sharing: organisation.into() };
            let (found, _) = draw(ranks, &twice, &camera, &settings).expect("a picture");
            assert_same(&expected, &found, &format!("{ranks:?}"));
        }
    }
}

#[test]
fn more_ranks_than_clusters_or_regions() {
    let few = scene("builtin:teapot@100", 128);
    let clusters = few.instances[0].mesh.clusters().len();
    assert!(clusters < 9, "{clusters}");
    let mut clear = few.clone();
    clear.instances[0].surface.opacity = 0.5;
    let camera = camera(&few, 2.6, false);
    for organisation in ALL {
        for (width, height) in [(1, 1), (9, 3), (64, 48), (33, 100)] {
            for count in [2, 5, 9] {
                let ranks = Ranks { count, threads: 1, sharing: organisation.into() };
                for settings in [Settings::one_sample(width, height), Settings::new(width, height)] {
                    let settings = Settings { outputs: EVERYTHING, ..settings };
                    check(&few, &camera, &settings, ranks, "few clusters");
                    check(&clear, &camera, &settings, ranks, "few clusters that are not opaque");
                }
            }
        }
    }
}

#[test]
fn an_empty_scene() {
    let mut empty = scene("builtin:teapot@1k", 128);
    empty.instances.clear();
    let camera = Camera { eye: DVec3::Z, ..camera(&scene("builtin:teapot@1k", 128), 2.0, false) };
    let with = |organisation: Organisation| Sharing::from(organisation);
    let composited =
        Composition::ALL.map(|composition| Sharing { composition, ..with(Organisation::SortLast) });
    for sharing in ALL.map(with).into_iter().chain(composited) {
        for count in [1, 2, 3] {
            for settings in [Settings::one_sample(40, 30), Settings::new(40, 30)] {
                let settings = Settings { outputs: EVERYTHING, ..settings };
                let ranks = Ranks { count, threads: 1, sharing };
                let report = check(&empty, &camera, &settings, ranks, "nothing");
                let sent = |r: &RankReport| r.pixels.sent + r.pixels.fragment_bytes + r.bin_bytes;
                assert_eq!((report.ranks.iter().map(sent).sum::<u64>(), report.pixels_visible()), (0, 0));
            }
        }
    }
}

#[test]
fn frames_do_not_affect_later_frames() {
    let scene = with_second_instance(scene("builtin:teapot@6k", 128));
    let cameras: Vec<_> = [2.6, 5.0, 0.4, 30.0].map(|radii| camera(&scene, radii, false)).to_vec();
    let mut clear = scene.clone();
    clear.instances[1].surface.opacity = 0.5;
    let only_ids = Outputs { ids: true, ..Outputs::NONE };
    for (organisation, scene) in ALL.into_iter().flat_map(|o| [(o, &scene), (o, &clear)]) {
        for settings in [
            Settings::one_sample(90, 70),
            Settings::new(90, 70),
            Settings { outputs: only_ids, layer_memory: 1, ..Settings::new(90, 70) },
        ] {
            let settings = Settings { tile_size: Some(8), ..settings };
            let ranks = Ranks { count: 4, threads: 1, sharing: organisation.into() };
            let reports = tercio_parallel::draw_frames(ranks, scene, &cameras, &settings, |number, frame| {
                let expected = Renderer::new().render(scene, &cameras[number], &settings).expect("a picture");
                assert_same(&expected, frame, &format!("{organisation:?}, frame {number}"));
            });
            assert_eq!(reports.expect("pictures").len(), cameras.len());
        }
    }
}

#[test]
fn sort_last_shares_the_clusters_and_sort_first_the_picture() {
    let scene = scene("builtin:gyroid@40k", 128);
    let camera = camera(&scene, 2.6, false);
    let settings = Settings { outputs: EVERYTHING, tile_size: Some(32), ..Settings::one_sample(256, 192) };
    let clusters = scene.instances[0].mesh.clusters().len() as u64;
    let ranks = |organisation: Organisation| Ranks { count: 4, threads: 1, sharing: organisation.into() };
    let last = check(&scene, &camera, &settings, ranks(Organisation::SortLast), "gyroid");
    assert_eq!(last.ranks.iter().map(|r| r.clusters).sum::<u64>(), clusters);
    // Which tiles are touched, two messages of each rank; pixels, at most one to each other rank; and finished pixels.
    assert!((4 * 2 + 3..=4 * 2 + 4 * 3 + 3).contains(&last.messages), "{}", last.messages);
    assert_eq!(last.region, 32);
    let (sent, compared): (u64, u64) =
        last.ranks.iter().fold((0, 0), |sum, r| (sum.0 + r.pixels.sent, sum.1 + r.pixels.compared));
    assert!(sent == compared && sent > 0);
    let first = check(&scene, &camera, &settings, ranks(Organisation::SortFirst), "gyroid");
    assert_eq!(first.messages, 3);
    assert!(first.bytes < last.bytes, "{} bytes of finished pixels, {} with keys", first.bytes, last.bytes);
    for rank in &first.ranks {
        assert_eq!(rank.clusters, clusters);
        assert!(rank.frame.frontend.clusters_elsewhere > 0, "rank {} drew everything", rank.rank);
    }
}

#[test]
fn errors_are_returned_by_the_rank_that_fails() {
    let scene = scene("builtin:teapot@1k", 128);
    let camera = camera(&scene, 2.6, false);
    for organisation in ALL {
        let ranks = Ranks { count: 3, threads: 1, sharing: organisation.into() };
        let wide = Settings { width: 0, ..Settings::one_sample(8, 8) };
        let error = draw(ranks, &scene, &camera, &wide).unwrap_err().to_string();
        assert!(error.contains("width must be 1 to"), "{error}");
        for refused in [
            Settings { band: Some(0..64), tile_size: Some(64), ..Settings::new(128, 128) },
            Settings { unresolved: true, ..Settings::new(128, 128) },
            Settings { keep_fragments: true, ..Settings::new(128, 128) },
        ] {
            let error = draw(ranks, &scene, &camera, &refused).unwrap_err().to_string();
            assert!(error.contains("ranks draw whole pictures"), "{error}");
        }
        let nowhere = Camera { target: camera.eye, ..camera };
        let error = draw(ranks, &scene, &nowhere, &Settings::one_sample(8, 8)).unwrap_err().to_string();
        assert!(error.contains("eye and target"), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn any_setting(
        (model, most_triangles, second) in (0usize..4, 1usize..129, any::<bool>()),
        (width, height) in (1u32..150, 1u32..150),
        (count, threads, organisation, group) in (1usize..10, 1usize..4, 0usize..4, 1usize..6),
        (radii, orthographic) in (0.05f64..4.0, any::<bool>()),
        (tile, cull, shading, sorting) in (0usize..6, 0usize..4, 0usize..4, any::<bool>()),
        (planes, samples, tent, by_sample) in (0u32..256, 0usize..8, any::<bool>(), any::<bool>()),
        (opacity, little_memory) in (prop_oneof![Just(1.0f32), 0.0f32..1.0], any::<bool>()),
        (division, composition, radix) in (0..Division::ALL.len(), 0..Composition::ALL.len(), 2u32..6),
        (encoding, is_compact) in (0..Encoding::ALL.len(), any::<bool>()),
    ) {
        let model = ["builtin:sphere@500", "builtin:teapot@2k", "builtin:soup@300", "builtin:terrain@1k"][model];
        let scene = scene(model, most_triangles);
        let mut scene = if second { with_second_instance(scene) } else { scene };
        scene.instances[0].surface.opacity = opacity;
        let wants = |bit: u32| planes >> bit & 1 == 1;
        let settings = Settings {
            tile_size: [None, Some(8), Some(16), Some(32), Some(64), Some(128)][tile],
            cull: [Cull::Auto, Cull::None, Cull::Back, Cull::Front][cull],
            shading: [Shading::Flat, Shading::Gouraud, Shading::Phong, Shading::Unlit][shading],
            sorting: if sorting { Sorting::Clusters } else { Sorting::Triangles },
            outputs: Outputs {
                color: wants(0),
                color16: wants(1),
                depth: wants(2),
                ids: wants(3),
                normals: wants(4),
                keys: wants(5),
                linear: wants(6),
                ties: wants(7),
            },
            sampling: Sampling {
                filter: if tent { Filter::Tent } else { Filter::Box },
                shading: if by_sample { SampleShading::Sample } else { SampleShading::Pixel },
                ..Sampling::of(SamplePattern::ALL[samples.saturating_sub(1)])
            },
            layer_memory: if little_memory { 1 } else { 128 << 20 },
            ..Settings::new(width, height)
        };
        let organisation = [
            Organisation::SortFirst,
            Organisation::SortMiddle,
            Organisation::SortLast,
            Organisation::SortTwice { group },
        ][organisation];
        let composition = match Composition::ALL[composition] {
            Composition::RadixK(_) => Composition::radix_k(radix),
            composition => composition,
        };
        let has_fragments = scene.instances[0].is_translucent() || settings.sampling.pattern.count() > 1;
        let encoding = match Encoding::ALL[encoding] {
            Encoding::Dense if has_fragments => Encoding::Visible,
            encoding => encoding,
        };
        let clusters = if is_compact { ClusterDivision::Compact } else { ClusterDivision::Consecutive };
        let division = Division::ALL[division];
        let sharing = Sharing { organisation, division, composition, encoding, clusters };
        let camera = camera(&scene, radii, orthographic);
        check(&scene, &camera, &settings, Ranks { count, threads, sharing }, model);
    }
}
