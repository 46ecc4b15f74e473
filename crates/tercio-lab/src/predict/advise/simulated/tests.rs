use super::super::tests::{boxes, counters};
use super::*;
use crate::machines::{Packing, Sourced, builtin};

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
    assert!(lines[1].contains("powers of two processors, with regions as large as possible"), "{lines:?}");
}

/// Of every class: what is found on 2n processors is no slower than on n.
#[test]
fn more_processors_are_never_worse() {
    for machine in machines() {
        let mut before = [f64::INFINITY; 4];
        for processors in [1, 2, 4, 16, 64] {
            let found = found(&machine, 600, processors);
            for (class, before) in CLASSES.into_iter().zip(&mut before) {
                let of_class = found.frames.iter().filter(|f| name(f.plan.organisation) == name(class(2)));
                let best = of_class.map(SimulatedFrame::total).fold(f64::INFINITY, f64::min);
                assert!(best <= *before, "{} {processors}: {best} {before}", name(class(2)));
                *before = best;
            }
        }
    }
}

/// Brute force: all plans on all powers of two, every size of groups among them. The search finds the best of each class, or
/// one that is a tenth slower.
#[test]
fn few_plans_find_nearly_the_best_of_all() {
    for machine in machines() {
        let (counters, boxes) = (counters(600), boxes(600));
        let search =
            Search { machine: &machine, topology: None, counters: &counters, boxes: &boxes, size: SIZE };
        let few = found(&machine, 600, 64);
        for class in CLASSES {
            let mut plans = Vec::new();
            for ranks in (0..7).map(|bit| 1usize << bit) {
                let groups =
                    if name(class(2)) == "sort-twice" { search.groups(ranks).collect() } else { vec![2] };
                for group in groups {
                    for region in REGIONS {
                        plans.extend(ASSIGNMENTS.map(|a| search.plan(class(group), ranks, region, a)));
                    }
                }
            }
            let least = |frames: &[SimulatedFrame]| {
                let of_class = frames.iter().filter(|f| name(f.plan.organisation) == name(class(2)));
                of_class.map(SimulatedFrame::total).fold(f64::INFINITY, f64::min)
            };
            let all = search.simulate(&plans).unwrap();
            let (all, few) = (least(&all), least(&few.frames));
            assert!(
                all <= few && few <= if name(class(2)) == "sort-twice" { 1.1 } else { 1.0 } * all,
                "{} {}: {few} {all}",
                machine.name,
                name(class(2))
            );
        }
    }
}

/// What no class can be faster than, of all frames of the search.
#[test]
fn no_frame_is_faster_than_its_work_shared_evenly() {
    for machine in machines() {
        let (counters, boxes) = (counters(600), boxes(600));
        let search =
            Search { machine: &machine, topology: None, counters: &counters, boxes: &boxes, size: SIZE };
        let work = search.work().unwrap();
        assert!(work > 0.0);
        let frames = found(&machine, 600, 100).frames;
        assert!(frames.iter().all(|f| f.total() >= work / f.plan.ranks as f64), "{}", machine.name);
    }
}

/// Of a million processors some classes are not simulated, which is said; and the answer is no worse than that of 8,192.
#[test]
fn classes_whose_times_only_rise_are_given_up() {
    let machine = builtin("cluster-64").unwrap().unwrap();
    let [some, many] = [8192, 1_000_000].map(|processors| found(&machine, 600, processors));
    assert!(many.frames[0].total() <= some.frames[0].total());
    assert!(!many.given_up.is_empty());
    let said = &many.explanation()[1];
    for (class, last) in &many.given_up {
        let of_class = many.frames.iter().filter(|f| name(f.plan.organisation) == *class);
        assert_eq!(of_class.map(|f| f.plan.ranks).max(), Some(*last), "{class}");
        assert!(
            said.contains(&format!("{class} on more than {last} processors: its time has risen")),
            "{said}"
        );
    }
    assert!(said.contains("powers of two, and 1000000 processors"), "{said}");
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
