use proptest::prelude::*;

use super::*;
use crate::machines::Topology;
use crate::workloads::BoundingBox;

const COSTS: Costs = Costs {
    polygon: 2.0,
    set_up: 3.0,
    entry: 1.0,
    pixel: 0.5,
    composite: 0.25,
    primitive: 48,
    descriptor: 84,
    sample: 8,
    delivered: 4,
};

fn setting(processors: usize, topology: Topology) -> Setting {
    Setting {
        width: 64,
        height: 64,
        processors,
        region: None,
        assignment: Assignment::Interleaved,
        network: NetworkModel {
            topology,
            bandwidth: 1.0,
            hop: 0.0,
            message: 0.0,
            packing: Packing::OneADestination,
            delivery: Delivery::FirstProcessor,
            node: None,
        },
        costs: COSTS,
        simd: None,
    }
}

fn simulate(scene: &BoxScene, organisation: Organisation, s: &Setting) -> SortReport {
    super::simulate(scene, organisation, s).unwrap()
}

fn scene(boxes: &[(i32, i32, i32, i32)]) -> BoxScene {
    let of = |&(x0, y0, x1, y1)| BoundingBox { visible: true, pixels: PixelBox { x0, y0, x1, y1 } };
    BoxScene { boxes: boxes.iter().map(of).collect() }
}

/// For every number of processors; of a ring's those that divide it.
#[test]
fn the_usual_group_is_one_that_the_machine_can_have() {
    let [ring, cluster] =
        ["princeton-engine", "cluster-64"].map(|n| crate::machines::builtin(n).unwrap().unwrap());
    for processors in 1..300 {
        let divisors = (1..=processors.min(16)).filter(|group| processors % group == 0);
        assert_eq!(usual_group(&ring, processors), divisors.max().unwrap());
        assert_eq!(usual_group(&cluster, processors), processors.min(16));
    }
}

#[test]
fn sort_twice_without_groups_is_another_organisation() {
    let all: Vec<_> = (0..12).map(|k| (5 * k, 3 * k, 5 * k + 8, 3 * k + 9)).collect();
    let scene = scene(&all);
    for machine in ["princeton-engine", "cluster-64"] {
        let machine = crate::machines::builtin(machine).unwrap().unwrap();
        for group in [1, 2, 4] {
            let twice = Organisation::SortTwice(group);
            let all = [Organisation::SortMiddle, Organisation::SortLast, twice];
            let s = Setting::of(&machine, 4, (64, 64), None, &all).unwrap();
            let times = |of| {
                let r = simulate(&scene, of, &s);
                [r.geometry.seconds, r.redistribution_seconds, r.raster.seconds, r.composition_seconds]
            };
            let same = all[..2].iter().copied().find(|&other| times(other) == times(twice));
            assert_eq!(twice.without_groups(4), same, "{} {group}", machine.name);
        }
    }
}

#[test]
fn sort_middle_by_hand() {
    // Four owners of 32x32 pixels. Polygon 0 lies in all four, polygon 1 in the last one.
    let s = setting(4, Topology::Crossbar);
    let r = simulate(&scene(&[(30, 30, 33, 33), (40, 40, 40, 40)]), Organisation::SortMiddle, &s);
    assert_eq!(r.overlap, 2.5);
    assert_eq!(r.geometry, Computing { seconds: 5.0, mean: 2.5 });
    // The last owner: two polygons, four pixels and one.
    assert_eq!(r.raster.seconds, 2.0 + 0.5 * 5.0);
    // Processor 0 sends three descriptors, 1 sends one to processor 3.
    assert_eq!((r.redistribution.messages, r.redistribution.bytes), (4, 4 * 84));
    assert_eq!(r.redistribution_seconds, 3.0 * 84.0);
    assert_eq!(r.composition_seconds, 0.0);
    // Three owners deliver a quarter of the picture each.
    assert_eq!((r.delivery.messages, r.delivery.bytes, r.delivery_seconds), (3, 3 * 4096, 3.0 * 4096.0));
}

#[test]
fn polygons_for_one_destination_share_a_message() {
    // Eight polygons in the last of four regions, two of them on each processor.
    let scene = scene(&[(40, 40, 40, 40); 8]);
    let mut s = setting(4, Topology::Crossbar);
    s.network.message = 1000.0;
    let batched = simulate(&scene, Organisation::SortMiddle, &s);
    assert_eq!((batched.redistribution.messages, batched.redistribution.bytes), (3, 6 * 84));
    assert_eq!(batched.redistribution_seconds, 6.0 * 84.0 + 3.0 * 1000.0);
    s.network.packing = Packing::OneAPolygon;
    let single = simulate(&scene, Organisation::SortMiddle, &s);
    assert_eq!((single.redistribution.messages, single.redistribution.bytes), (6, 6 * 84));
    assert_eq!(single.redistribution_seconds, 6.0 * 84.0 + 6.0 * 1000.0);
}

#[test]
fn a_smaller_last_group_is_composited() {
    let r = simulate(&scene(&[(0, 0, 1, 1)]), Organisation::SortTwice(4), &setting(5, Topology::Crossbar));
    // Processor 4 has a whole picture, of which four owners each take a quarter; three of them deliver theirs.
    assert_eq!((r.composition.messages, r.composition.bytes), (4, 4096 * 8));
    assert_eq!(r.composition_seconds, 4096.0 * 8.0 + 1024.0 * 0.25);
    assert_eq!(r.delivery.bytes, 3 * 1024 * 4);
}

#[test]
fn a_display_takes_the_picture_without_messages() {
    let mut s = setting(4, Topology::Crossbar);
    s.network.delivery = Delivery::Display;
    let r = simulate(&scene(&[(0, 0, 1, 1)]), Organisation::SortLast, &s);
    assert_eq!((r.delivery, r.delivery_seconds), (Traffic::default(), 0.0));
    assert!(r.composition.bytes > 0);
}

#[test]
fn sort_last_swaps_halves() {
    let r = simulate(&scene(&[(0, 0, 1, 1)]), Organisation::SortLast, &setting(4, Topology::Crossbar));
    // Half the picture, then a quarter, from each processor to its partner.
    assert_eq!(r.composition.bytes, 4 * (2048 + 1024) * 8);
    assert_eq!(r.composition_seconds, (2048.0 + 1024.0) * 8.0 + (2048.0 + 1024.0) * 0.25);
    assert_eq!(r.redistribution, Traffic::default());
    // Three: the third first sends its picture to another.
    let r = simulate(&scene(&[(0, 0, 1, 1)]), Organisation::SortLast, &setting(3, Topology::Crossbar));
    assert_eq!(r.composition.bytes, (4096 + 2 * 2048) * 8);
}

#[test]
fn sort_first_repeats_the_geometry_work() {
    let s = setting(4, Topology::Crossbar);
    let r = simulate(&scene(&[(30, 30, 33, 33)]), Organisation::SortFirst, &s);
    // Each of four owners transforms and sets it up.
    assert_eq!(r.geometry, Computing { seconds: 5.0, mean: 5.0 });
    assert_eq!(r.redistribution.bytes, 3 * 48);
}

#[test]
fn a_million_processors() {
    let boxes: Vec<_> =
        (0..20_000).map(|k| (k * 7 % 1000, k * 13 % 1000, k * 7 % 1000 + 5, k * 13 % 1000 + 4)).collect();
    let s = Setting { width: 1024, height: 1024, ..setting(1 << 20, Topology::Mesh) };
    let r = simulate(&scene(&boxes), Organisation::SortTwice(1024), &s);
    assert_eq!(r.raster.mean * (1 << 20) as f64, r.overlap * 20_000.0 + 0.5 * 30.0 * 20_000.0);
    assert!(r.composition.bytes > 0 && r.seconds().is_finite());
}

proptest! {
    /// The limits of sort-twice are the plain classes.
    #[test]
    fn one_group_is_sort_middle_and_groups_of_one_are_sort_last(
        boxes in prop::collection::vec((0i32..60, 0i32..60, 0i32..20, 0i32..20), 1..50),
        n in 1usize..33,
    ) {
        let boxes: Vec<_> = boxes.into_iter().map(|(x, y, w, h)| (x, y, x + w, y + h)).collect();
        let scene = scene(&boxes);
        let s = setting(n, Topology::Mesh);
        let run = |o| SortReport { organisation: Organisation::SortLast, ..simulate(&scene, o, &s) };
        prop_assert_eq!(run(Organisation::SortTwice(n)), run(Organisation::SortMiddle));
        prop_assert_eq!(run(Organisation::SortTwice(1)), run(Organisation::SortLast));
    }

    /// No pixel is lost, whoever owns it, and one processor has neither traffic nor imbalance.
    #[test]
    fn all_pixels_are_drawn(
        boxes in prop::collection::vec((-9i32..70, -9i32..70, 0i32..20, 0i32..20), 1..50),
        n in 1usize..33,
        g in 1usize..33,
    ) {
        let boxes: Vec<_> = boxes.into_iter().map(|(x, y, w, h)| (x, y, x + w, y + h)).collect();
        let scene = scene(&boxes);
        let screen = PixelBox::screen(64, 64);
        let pixels: u64 = scene.boxes.iter().filter_map(|b| b.pixels.intersection(&screen)).map(|b| b.area()).sum();
        let only_pixels = Costs { entry: 0.0, ..COSTS };
        for o in [Organisation::SortFirst, Organisation::SortTwice(g)] {
            let r = simulate(&scene, o, &Setting { costs: only_pixels, ..setting(n, Topology::FatTree) });
            prop_assert!((r.raster.mean * n as f64 - 0.5 * pixels as f64).abs() < 1e-6);
            prop_assert!(n > 1 || (r.redistribution.bytes == 0 && r.composition.bytes == 0 && r.delivery.bytes == 0));
        }
    }
}

#[test]
fn what_an_organisation_does_not_use_may_be_missing() {
    use crate::machines::{Machine, builtin};
    type Removed = (&'static str, fn(&mut Machine));
    let keys: [Removed; 6] = [
        ("bytes.primitive", |m| drop(m.bytes.remove(&DataKind::Primitive))),
        ("bytes.descriptor", |m| drop(m.bytes.remove(&DataKind::Descriptor))),
        ("bytes.sample", |m| drop(m.bytes.remove(&DataKind::Sample))),
        ("costs.cluster-drawn", |m| drop(m.costs.remove(&Operation::ClusterDrawn))),
        ("costs.pixel", |m| drop(m.costs.remove(&Operation::Pixel))),
        ("costs.composite-pixel", |m| drop(m.costs.remove(&Operation::CompositePixel))),
    ];
    let scene = scene(&[(3, 3, 40, 50), (30, 30, 33, 33), (10, 2, 11, 60), (0, 0, 63, 63)]);
    let machine = builtin("cluster-64").unwrap().unwrap();
    let optional = |organisation, key| match organisation {
        Organisation::SortFirst => key == "costs.composite-pixel",
        Organisation::SortMiddle => matches!(key, "costs.composite-pixel" | "bytes.primitive"),
        Organisation::SortLast | Organisation::SortTwice(_) => key == "bytes.primitive",
    };
    let all = [
        Organisation::SortFirst,
        Organisation::SortMiddle,
        Organisation::SortLast,
        Organisation::SortTwice(2),
    ];
    for organisation in all {
        let of = |machine: &Machine| Setting::of(machine, 4, (64, 64), None, &[organisation]);
        let whole = simulate(&scene, organisation, &of(&machine).unwrap());
        for (key, remove) in keys {
            let mut without = machine.clone();
            remove(&mut without);
            match of(&without) {
                // What is not asked for makes no difference.
                Ok(setting) => {
                    assert!(optional(organisation, key), "{organisation:?}: {key}");
                    assert_eq!(simulate(&scene, organisation, &setting), whole, "{organisation:?}: {key}");
                    assert!(setting.costs.uncharged(organisation).iter().all(|o| !key.ends_with(o.name())));
                }
                Err(error) => {
                    assert!(!optional(organisation, key), "{organisation:?}: {key}");
                    assert!(error.to_string().contains(key), "{error}");
                }
            }
            let error = Setting::of(&without, 4, (64, 64), None, &all).unwrap_err();
            assert!(error.to_string().contains(key), "{error}");
        }
    }
}
