use proptest::prelude::*;

use super::destinations::{Destinations, Route, copies};
use super::stage::{Descriptor, Stage};
use super::*;
use crate::workloads::synthetic::{Distribution, Spread};
use crate::workloads::{BoundingBox, BoxScene, PixelBox, ScreenMap};

fn machine(processors: u32) -> Machine {
    Machine { processors, ..Machine::princeton_engine() }
}

/// A screen one pixel high: column c belongs to processor c.
fn row(columns: u32) -> ScreenMap {
    ScreenMap::columns(columns, 1, columns)
}

fn span(first: i32, last: i32) -> BoundingBox {
    BoundingBox { visible: true, pixels: PixelBox::new([first, 0], [last, 0]).unwrap() }
}

/// A scene of `n` processors whose polygon number 1 covers columns 8 to 10; processor 1 sends it.
fn figure_a6() -> Destinations {
    let mut route = Route::default();
    let machine = machine(16);
    let algorithm = Algorithm { strides: vec![4, 1], ..Algorithm::sort_middle(&machine) };
    route.find(&machine, &algorithm, &row(16), 1, &span(8, 10).pixels);
    let mut destinations = Destinations::default();
    destinations.push(&route);
    destinations
}

#[test]
fn strides_of_figure_a6() {
    let destinations = figure_a6();
    let first = Descriptor { polygon: 0, base: 0, end: 15 };
    let copies: Vec<_> = first.hops(&destinations, 4).map(|h| first.copy(h, 4)).collect();
    let holders: Vec<_> = copies.iter().map(|c| c.holder(&destinations, 16)).collect();
    assert_eq!(holders, [5, 9]);
    let second = copies.iter().map(|c| {
        c.hops(&destinations, 1).map(|h| c.copy(h, 1).holder(&destinations, 16)).collect::<Vec<_>>()
    });
    assert_eq!(second.collect::<Vec<_>>(), [vec![8], vec![9, 10]]);
}

#[test]
fn passes_of_figure_a6() {
    let machine = machine(16);
    let algorithm = Algorithm { strides: vec![4, 1], ..Algorithm::sort_middle(&machine) };
    let culled = BoundingBox { visible: false, ..span(0, 0) };
    let scene = BoxScene { boxes: vec![culled, span(8, 10)] };
    let run = simulate(&machine, &algorithm, &row(16), &scene).unwrap();
    // Two hops of 4 to processor 9, then three of 1 from processor 5 to 8.
    assert_eq!(run.stages.iter().map(|s| s.passes).collect::<Vec<_>>(), [2, 3]);
    assert_eq!(run.communication(), 2 * (6 * 42 + 30) + 3 * (3 * 42 + 30));
    assert_eq!(
        run.received.iter().enumerate().filter(|r| *r.1 > 0).map(|r| r.0).collect::<Vec<_>>(),
        [8, 9, 10]
    );
    assert_eq!((run.copies, run.checks), (3, Checks::default()));
    assert_eq!(run.geometry.instructions, 1000 + 5000);
    assert_eq!(run.raster.instructions, 100);
}

#[test]
fn copies_of_section_5_4() {
    // A.2.1, n = 16, m = 2: polygon 5 lies on processors 5 and 13.
    assert_eq!(copies(5, 16, 2).collect::<Vec<_>>(), [5, 13]);
    assert_eq!(copies(21, 16, 1).collect::<Vec<_>>(), [5]);
}

#[test]
fn the_sender_is_the_rightmost_holder_left_of_the_first_destination() {
    let machine = machine(16);
    let algorithm = Algorithm { duplication: 4, ..Algorithm::sort_middle(&machine) };
    let source = |polygon, first, last| {
        let mut route = Route::default();
        route.find(&machine, &algorithm, &row(16), polygon, &span(first, last).pixels);
        (route.source, route.stops.iter().map(|s| s.0).collect::<Vec<_>>())
    };
    // Polygon 2 lies on processors 2, 6, 10 and 14.
    assert_eq!(source(2, 9, 11), (6, vec![3, 4, 5]));
    assert_eq!(source(2, 10, 10), (10, vec![0]));
    assert_eq!(source(2, 0, 1), (14, vec![2, 3]));
}

#[test]
fn the_geometry_stage_of_the_teapot() {
    // A.2.1: 9,408 polygons, 16 copies, 1,024 processors: 147 polygons for the busiest.
    let machine = machine(1024);
    let algorithm = Algorithm { duplication: 16, ..Algorithm::sort_middle(&machine) };
    let boxes = vec![BoundingBox { visible: false, ..span(0, 0) }; 9408];
    let run =
        simulate(&machine, &algorithm, &ScreenMap::columns(768, 512, 1024), &BoxScene { boxes }).unwrap();
    assert_eq!((run.geometry.examined, run.geometry.instructions), (147, 147_000));
    assert_eq!((run.passes(), run.checks.passed()), (0, true));
}

#[test]
fn a_sparse_network_turns_once_for_every_queued_polygon() {
    // Section 5.1: each batch of polygons goes all the way round.
    let machine = machine(8);
    let scene = BoxScene { boxes: (0..24).map(|b| span((b + 1) % 8, (b + 1) % 8)).collect() };
    let mut algorithm = Algorithm::sort_middle(&machine);
    let dense = simulate(&machine, &algorithm, &row(8), &scene).unwrap();
    algorithm.test_period = 8;
    let sparse = simulate(&machine, &algorithm, &row(8), &scene).unwrap();
    // Every polygon's one destination is its sender's neighbour.
    assert_eq!((dense.passes(), sparse.passes()), (3, 24));
    assert_eq!(dense.stages[0].occupied, 24);
}

#[test]
fn groups_limit_the_distance_of_a_polygon() {
    // Figure 6-1: 15 processors in groups of 3. One polygon a processor goes at most g - 1 = 2 passes.
    let machine = machine(15);
    let algorithm = Algorithm { group: 3, ..Algorithm::sort_middle(&machine) };
    let map = ScreenMap::columns(3, 1, 3);
    let boxes = (0..15).map(|b| span(b % 3, (b % 3 + b % 2).min(2))).collect();
    let run = simulate(&machine, &algorithm, &map, &BoxScene { boxes }).unwrap();
    assert!(run.checks.passed());
    assert!(run.passes() <= 2, "{}", run.passes());
    assert_eq!(run.received.iter().sum::<u32>() as u64, run.copies);
}

#[test]
fn compositing_of_figures_6_2_and_6_3() {
    let rows: Vec<_> = (0..16).map(|j| compositing::owner(15, 3, 0, j)).collect();
    assert_eq!(rows, [0, 3, 6, 9, 12, 0, 3, 6, 9, 12, 0, 3, 6, 9, 12, 0]);
    assert_eq!((compositing::start(15, 3, 0, 4), compositing::owner(15, 3, 0, 4)), (0, 12));
    assert_eq!((compositing::owner(15, 3, 1, 4), compositing::owner(15, 3, 2, 2)), (13, 8));
    // Equation 6.2, and one group has nothing to composite.
    assert_eq!(compositing::passes(1024, 16, 768 * 512), 24192);
    assert_eq!(compositing::passes(1024, 1024, 768 * 512), 0);
    // Section 6.4: one group a processor is classical dense sort-last, 24 instructions a pass.
    assert_eq!(Machine::princeton_engine().pixel_pass(1), 24);
}

#[test]
fn costs_of_passes() {
    let machine = Machine::princeton_engine();
    // Table 4.2 and section 7.4.
    assert_eq!((machine.pass(1), machine.pass(16)), (156, 786));
}

#[test]
fn invalid_parameters_are_refused() {
    let machine = machine(16);
    let plain = Algorithm::sort_middle(&machine);
    let check = |change: &dyn Fn(&mut Algorithm)| {
        let mut algorithm = plain.clone();
        change(&mut algorithm);
        algorithm.check(&machine, 4).err().map(|e| e.to_string())
    };
    assert_eq!(check(&|_| ()), None);
    for (error, change) in [
        (
            "expected a duplication that divides the 16 processors, found 3",
            (|a| a.duplication = 3) as fn(&mut Algorithm),
        ),
        ("expected a group that divides the 16 processors, found 0", |a| a.group = 0),
        ("expected a test period of at least 1 pass, found 0", |a| a.test_period = 0),
        ("expected strides that fall from at most 15 to 1, found [4]", |a| a.strides = vec![4]),
        ("expected strides that fall from at most 15 to 1, found [16, 1]", |a| a.strides = vec![16, 1]),
        ("expected strides that fall from at most 15 to 1, found []", |a| a.strides = vec![]),
        ("expected strides that fall from at most 15 to 1, found [2, 2, 1]", |a| a.strides = vec![2, 2, 1]),
        ("expected a screen map of at most 2 processors, found one of 4", |a| a.group = 2),
    ] {
        assert_eq!(check(&change).as_deref(), Some(error));
    }
}

#[test]
fn a_million_polygons_on_1024_processors() {
    let machine = Machine::princeton_engine();
    let distribution = Distribution {
        width: 768,
        height: 512,
        polygons: 1_000_000,
        visible: 1.0,
        size: [3.8, 12.0],
        spread: [Spread::Normal { deviation: 60.0 }, Spread::Uniform],
        seed: 1,
    };
    let map = ScreenMap::columns(768, 512, 1024);
    let run = simulate(&machine, &Algorithm::sort_middle(&machine), &map, &distribution.boxes()).unwrap();
    assert_eq!((run.visible, run.checks), (1_000_000, Checks::default()));
    // Figure 4-2: about one shift a polygon.
    let shifts = run.passes() as f64 / run.visible as f64;
    assert!((0.8..1.1).contains(&shifts), "{shifts}");
}

/// The copies that one of the two implementations of a stage reports: each processor's own list.
type Reported = Vec<Vec<(u64, Descriptor)>>;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_stage_equals_its_stepwise_form(
        n in 1u32..14, stride in 1u32..13, test_period in 1u32..15, seed in 0u64..1000,
        boxes in prop::collection::vec((0i32..14, 0i32..14), 0..60),
    ) {
        let machine = machine(n);
        let (stride, columns) = (stride.min(n.max(2) - 1), n as i32);
        let algorithm = Algorithm { duplication: 1, ..Algorithm::sort_middle(&machine) };
        let mut destinations = Destinations::default();
        let mut queues = vec![Vec::new(); n as usize];
        let mut route = Route::default();
        for (b, (first, extent)) in boxes.into_iter().enumerate() {
            let first = first % columns;
            let polygon = b as u64 * (seed + 1) % 97;
            route.find(&machine, &algorithm, &row(n), polygon, &span(first, (first + extent % 5).min(columns - 1)).pixels);
            queues[route.source as usize].push(Descriptor { polygon: destinations.len() as u32, base: 0, end: n - 1 });
            destinations.push(&route);
        }
        // A second stage sends what the first one has received.
        for stride in [stride, 1] {
            let stage = Stage { processors: n, stride, test_period };
            let mut copies: [Reported; 2] = [vec![Vec::new(); n as usize], vec![Vec::new(); n as usize]];
            let [fast, plain] = &mut copies;
            let fast_passes = stage.run(&destinations, &queues, |t, p, copy| fast[p as usize].push((t, copy)));
            let plain_passes =
                stepwise::run(&stage, &destinations, &queues, |t, p, copy| plain[p as usize].push((t, copy)));
            fast.iter_mut().for_each(|list| list.sort_by_key(|c| c.0));
            prop_assert_eq!(fast_passes, plain_passes);
            prop_assert_eq!(&*fast, &*plain);
            queues = plain.iter().map(|list| list.iter().map(|c| c.1).collect()).collect();
        }
    }

    #[test]
    fn every_algorithm_passes_the_checks(
        groups in 1u32..5, members in 1u32..5, duplication in 1u32..5, test_period in 1u32..9,
        strides in prop::collection::btree_set(2u32..20, 0..4), side in 1u32..4,
        boxes in prop::collection::vec((any::<bool>(), -3i32..20, -3i32..8, 0i32..9, 0i32..5), 0..50),
    ) {
        let machine = machine(groups * members * duplication);
        let group = members * duplication;
        let limit = machine.processors.max(2) - 1;
        let strides = strides.into_iter().rev().filter(|&d| d <= limit).chain([1]).collect();
        let algorithm = Algorithm { duplication, test_period, strides, group };
        let map = ScreenMap::tiles(17, 5, side, group);
        let boxes: Vec<_> = boxes.into_iter().map(|(visible, x, y, w, h)| BoundingBox {
            visible,
            pixels: PixelBox::new([x, y], [x + w, y + h]).unwrap(),
        }).collect();
        let run = simulate(&machine, &algorithm, &map, &BoxScene { boxes: boxes.clone() }).unwrap();
        prop_assert_eq!(run.checks, Checks::default());
        // Every processor with a pixel of a box rasterizes it, whatever the group.
        let mut overlap = Vec::new();
        let copies: usize = boxes.iter().filter(|b| b.visible).map(|b| {
            map.overlap(&b.pixels, &mut overlap);
            overlap.len()
        }).sum();
        prop_assert_eq!(run.copies, copies as u64);
        prop_assert_eq!(run.received.iter().map(|&r| u64::from(r)).sum::<u64>(), copies as u64);
    }
}
