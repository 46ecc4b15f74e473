use super::super::tests::{boxes, counters};
use super::*;
use crate::machines::{Packing, Sourced, builtin};
use crate::workloads::BoundingBox;

const SIZE: (u32, u32) = (256, 192);

fn found(machine: &Machine, polygons: u64, processors: usize) -> Found {
    search(machine, &counters(polygons), &boxes(polygons), SIZE, None, processors).unwrap()
}

/// A machine, and one whose polygons travel one by one, so that two processors are far slower than one.
fn machines() -> Vec<Machine> {
    let of = |name| builtin(name).unwrap().unwrap();
    let mut unpacked = of("server-128");
    unpacked.network.as_mut().unwrap().packing = Packing::OneAPolygon;
    let mut slow = of("cluster-64");
    for network in [&mut slow.network, &mut slow.node].into_iter().flatten() {
        network.message = Sourced::new(1e-4, "0.1 ms".into(), "assumed".into());
    }
    vec![of("princeton-engine"), of("cluster-64"), of("server-128"), unpacked, slow]
}

#[test]
fn the_first_is_the_fastest_and_the_others_are_explained() {
    let machine = builtin("princeton-engine").unwrap().unwrap();
    let found = search(&machine, &counters(3000), &boxes(3000), (1024, 1024), None, 64).unwrap();
    assert!(found.frames.windows(2).all(|w| w[0].total() <= w[1].total()));
    let lines = found.explanation();
    assert_eq!(lines.len(), 5, "what is compared, and one line a class: {lines:?}");
    // Sending 3,000 polygons is faster than sending megabytes of pixels round a ring.
    let first = found.frames[0].plan.organisation;
    assert!(matches!(first, Organisation::SortMiddle | Organisation::SortFirst));
    assert!(lines.iter().any(|l| l.starts_with("sort-twice") && l.contains("composition")), "{lines:?}");
    assert!(lines[1].contains("1 to 16 processors and powers of two up to 64, with regions as large as possible and of 1, 2, 4, 8, 16"), "{lines:?}");
}

/// The explanation mentions only what applies to so few processors.
#[test]
fn few_processors_are_explained_in_few_words() {
    let machine = builtin("cluster-64").unwrap().unwrap();
    let said = |processors| found(&machine, 100, processors).explanation()[1].clone();
    assert_eq!(said(1), "the simulator compares 1 processor");
    assert!(said(2).starts_with("the simulator compares 1 to 2 processors, with regions"), "{}", said(2));
    assert!(!said(2).contains("sort-twice") && said(7).contains("sort-twice on each number"), "{}", said(7));
    assert!(
        !said(7).contains("over 32")
            && said(40).contains("over 32")
            && said(40).contains("powers of two and 40"),
        "{}",
        said(40)
    );
}

/// Of every class: what is found on 2n processors is no slower than on n.
#[test]
fn more_processors_are_never_worse() {
    for machine in machines() {
        let mut before = [f64::INFINITY; 4];
        let most = machine.processors.count.whole() as usize;
        for processors in [1, 2, 4, 16, 64, 128, 512].into_iter().filter(|&processors| processors <= most) {
            let found = found(&machine, 600, processors);
            for (class, before) in CLASSES.into_iter().zip(&mut before) {
                let of_class = found.frames.iter().filter(|f| name(f.plan.organisation) == name(class(2)));
                let best = of_class.map(SimulatedFrame::total).fold(f64::INFINITY, f64::min);
                assert!(best <= *before, "{} {} {processors}: {best} {before}", machine.name, name(class(2)));
                *before = best;
            }
        }
    }
}

fn a_search<'a>(machine: &'a Machine, counters: &'a Counters, boxes: &'a BoxScene) -> Search<'a> {
    Search { machine, topology: None, counters, boxes, size: SIZE, edges: edges(boxes, SIZE) }
}

/// The fastest of a class on some numbers of processors.
fn least(frames: &[SimulatedFrame], class: Class, may: impl Fn(usize) -> bool) -> f64 {
    let of_class = frames.iter().filter(|f| name(f.plan.organisation) == name(class(2)) && may(f.plan.ranks));
    of_class.map(SimulatedFrame::total).fold(f64::INFINITY, f64::min)
}

/// Brute force: all plans on all numbers of processors that the search always compares, every size of groups among them. Of
/// sort-first, -middle and -last the search finds the best, and of sort-twice one that is a tenth slower.
#[test]
fn few_plans_find_nearly_the_best_of_all() {
    let most = 40;
    for machine in machines() {
        let (counters, boxes) = (counters(600), boxes(600));
        let search = a_search(&machine, &counters, &boxes);
        let few = found(&machine, 600, most);
        for class in CLASSES {
            let is_twice = name(class(2)) == "sort-twice";
            let mut plans = Vec::new();
            for ranks in 1..=most {
                let groups = if is_twice { search.groups(ranks).collect() } else { vec![2] };
                for group in groups {
                    for region in std::iter::once(None).chain(EDGES.map(Some)) {
                        plans.extend(ASSIGNMENTS.map(|a| search.plan(class(group), ranks, (region, a))));
                    }
                }
            }
            let all = search.simulate(&plans).unwrap();
            let always = |ranks| few.numbers.contains(&ranks);
            let [all, few] = [&all, &few.frames].map(|frames| least(frames, class, always));
            let most = if is_twice { 1.1 } else { 1.0 } * all;
            assert!(all <= few && few <= most, "{} {}: {few} {all}", machine.name, name(class(2)));
        }
    }
}

/// Divisions that are left out because another is the same give the same frames.
#[test]
fn different_divisions_are_all_that_there_are() {
    for machine in machines() {
        let (counters, boxes) = (counters(200), boxes(200));
        let search = a_search(&machine, &counters, &boxes);
        let cases = [(1, 1), (2, 2), (12, 12), (48, 48), (48, 16), (50, 16), (6, 4)];
        let is_possible = |case: &(usize, usize)| {
            machine.processors.control == Control::Mimd || case.0.is_multiple_of(case.1)
        };
        for (ranks, group) in cases.into_iter().filter(is_possible) {
            let organisation =
                if ranks == group { Organisation::SortMiddle } else { Organisation::SortTwice(group) };
            let seconds = |divisions: Vec<_>| {
                let plans: Vec<Plan> =
                    divisions.into_iter().map(|d| search.plan(organisation, ranks, d)).collect();
                let frames = search.simulate(&plans).unwrap().into_iter();
                let mut all: Vec<f64> = frames.map(|frame| frame.total()).collect();
                all.sort_by(f64::total_cmp);
                all.dedup();
                all
            };
            let every =
                std::iter::once(None).chain(EDGES.map(Some)).flat_map(|edge| ASSIGNMENTS.map(|a| (edge, a)));
            let (different, every) =
                (seconds(search.divisions(organisation, ranks)), seconds(every.collect()));
            assert_eq!(different, every, "{} {organisation:?} {ranks}", machine.name);
        }
    }
}

/// Regions are left out only if they are very many, and that is said.
#[test]
fn small_regions_of_large_pictures_are_left_out() {
    let scene = boxes(10);
    assert_eq!(edges(&scene, (1024, 768)), EDGES);
    assert_eq!(edges(&scene, (64, 48)), EDGES[..7]);
    assert_eq!(edges(&scene, (4096, 4096)), EDGES[1..]);
    assert_eq!(edges(&scene, (40_000, 40_000)), EDGES[4..]);
    let large =
        |k: i32| BoundingBox { visible: k > 0, pixels: PixelBox { x0: -5, y0: 0, x1: 2000, y1: 767 } };
    let scene = BoxScene { boxes: (0..7).map(large).collect() };
    // 6 * 1024 * 768 pixels.
    assert_eq!(edges(&scene, (1024, 768)), EDGES[1..]);
    let machine = builtin("cluster-64").unwrap().unwrap();
    let found = search(&machine, &counters(7), &scene, (1024, 768), None, 4).unwrap();
    assert!(
        found.explanation()[1].contains("not compared are regions of 1 pixel, into"),
        "{:?}",
        found.explanation()
    );
}

/// What no class can be faster than, of all frames of the search.
#[test]
fn no_frame_is_faster_than_its_work_shared_evenly() {
    for machine in machines() {
        let (counters, boxes) = (counters(600), boxes(600));
        let search = a_search(&machine, &counters, &boxes);
        let work = search.work().unwrap();
        assert!(work > 0.0);
        let frames = found(&machine, 600, 100).frames;
        assert!(frames.iter().all(|f| f.total() >= work / f.plan.ranks as f64), "{}", machine.name);
    }
}

/// Of very many processors some classes are not simulated, which is said; and the answer is no worse than that of 8,192. Classes
/// that are simulated are with all regions.
#[test]
fn classes_whose_times_only_rise_are_given_up() {
    let machine = builtin("cluster-64").unwrap().unwrap();
    let [some, many] = [8192, 150_000].map(|processors| found(&machine, 600, processors));
    assert!(many.frames[0].total() <= some.frames[0].total());
    assert!(!many.given_up.is_empty());
    let said = &many.explanation()[1];
    for (class, last) in &many.given_up {
        let of_class = many.frames.iter().filter(|f| name(f.plan.organisation) == *class);
        assert_eq!(of_class.map(|f| f.plan.ranks).max(), Some(*last), "{class}");
        assert!(said.contains(&format!("{class} on more than {last} processors: its time")), "{said}");
    }
    assert!(said.contains("1 to 16 processors, powers of two and 150000"), "{said}");
    let (counters, boxes) = (counters(600), boxes(600));
    let search = a_search(&machine, &counters, &boxes);
    for class in [CLASSES[0], CLASSES[1]] {
        let plan = search.plan(class(2), 1 << 17, (Some(64), Assignment::Interleaved));
        let with_regions = search.simulate(&[plan]).unwrap()[0].total();
        assert!(least(&many.frames, class, |ranks| ranks == 1 << 17) <= with_regions, "{}", name(class(2)));
    }
    // The first rise is that of messages: two processors have some, and one has none. It does not end the search.
    let unpacked = &machines()[3];
    let found = found(unpacked, 5000, 64);
    let best = |ranks: usize| {
        let of_middle = found
            .frames
            .iter()
            .filter(|f| f.plan.organisation == Organisation::SortMiddle && f.plan.ranks == ranks);
        of_middle.map(SimulatedFrame::total).fold(f64::INFINITY, f64::min)
    };
    assert!(best(2) > best(1), "{} {}", best(2), best(1));
    assert!(best(64).is_finite() && best(64) < best(2), "{}", best(64));
}
