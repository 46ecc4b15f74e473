use tercio_parallel::{Composition, Organisation as RendererOrganisation};
use tercio_raster::Settings;
use tercio_scene::{Camera, Scene};

use super::explain::{Line, others};
use super::simulated::search;
use super::*;
use crate::machines::builtin;
use crate::predict::calibrate::prepare;
use crate::predict::choose::sights::Sights;
use crate::predict::counts::Counters;
use crate::predict::ranks::on_threads;
use crate::predict::views;
use crate::workloads::{BoundingBox, BoxScene, PixelBox};

pub(super) fn counters(boxes: u64) -> Counters {
    let binned =
        Counters { triangles: boxes, triangles_apart: boxes, triangles_binned: boxes, ..Counters::default() };
    Counters {
        entries: boxes,
        entries_drawn: boxes,
        stamps: boxes,
        stamps_alone: boxes,
        pixels: 1 << 20,
        ..binned
    }
}

pub(super) fn boxes(boxes: u64) -> BoxScene {
    let at = |k: u64| (k * 7919 % 1_000_003 % 1000) as i32;
    let of = |k| {
        let (x, y) = (at(k), at(k * 31 + 5));
        BoundingBox { visible: true, pixels: PixelBox { x0: x, y0: y, x1: x + 2, y1: y + 2 } }
    };
    BoxScene { boxes: (0..boxes).map(of).collect() }
}

fn made(model: &str, size: (u32, u32)) -> (Scene, Camera, Settings) {
    let (scene, bounds) = prepare(tercio_mesh::builtin::make(model).unwrap());
    (scene, views::camera(&bounds, size, 0, 1), Settings::one_sample(size.0, size.1))
}

fn advice(machine: &str, model: &str, processors: usize, topology: Option<Topology>) -> Advice {
    let (scene, camera, settings) = made(model, (160, 120));
    let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
    advise(&builtin(machine).unwrap().unwrap(), &picture, processors, topology).unwrap()
}

/// Checks that what is named of each other class makes up nine tenths of the difference; how many classes there are.
fn differences_are_made_up(lines: &[String]) -> usize {
    let size = |text: &str| text.trim_end_matches(" ms").rsplit(' ').next().unwrap().parse::<f64>().unwrap();
    let of_classes = lines.iter().filter_map(|line| line.split_once(", made up of "));
    let checked = of_classes.map(|(before, parts)| {
        let (net, parts) = (size(before), parts.split(", ").map(size).collect::<Vec<_>>());
        let rounding = 0.0005 * (parts.len() + 1) as f64;
        let left = (net - parts.iter().sum::<f64>()).abs();
        assert!(left <= (0.1 * net).max(0.001) + rounding, "{before}: {parts:?}");
        assert!(parts.windows(2).all(|pair| pair[0].abs() >= pair[1].abs()), "{parts:?}");
    });
    checked.count()
}

#[test]
fn differences_to_other_classes_are_made_up_by_what_is_named() {
    let machine = builtin("princeton-engine").unwrap().unwrap();
    let found = search(&machine, &counters(3000), &boxes(3000), (1024, 1024), None, 64).unwrap();
    assert_eq!(differences_are_made_up(&found.explanation()), 3);
    for (machine, processors) in [("server-128", 4), ("server-128", 128), ("cluster-64", 300)] {
        let advice = advice(machine, "builtin:gyroid@5k", processors, None);
        assert_eq!(differences_are_made_up(&advice.explanation()), 4, "{machine} {processors}");
    }
    // What is gained is named, and what is lost and no tenth of the difference is not.
    let line = |class, milliseconds: f64| Line {
        class,
        seconds: milliseconds * 1e-3,
        is_estimate: class == "sort-middle",
        words: class.into(),
    };
    let parts = [[20.0, 12.0, 3.0], [34.9, 3.6, 3.2]];
    let names = ["redistribution", "composition", "delivery"];
    let of = |k: usize| names.into_iter().zip(parts[k].map(|ms| ms * 1e-3)).collect();
    assert_eq!(
        others(&[line("sort-last", 35.0), line("sort-middle", 41.7)], of),
        [
            "sort-middle takes 1.19 times as long, 41.700 ms if the formulas are right about it: +6.700 ms, made up of redistribution +14.900 ms, \
             composition -8.400 ms"
        ]
    );
}

#[test]
fn a_machine_without_costs_of_ranks_has_no_candidates() {
    let advice = advice("princeton-engine", "builtin:teapot@1k", 64, None);
    assert!(advice.candidates.is_empty() && advice.explanation().is_empty());
    assert_eq!(why_not(&builtin("princeton-engine").unwrap().unwrap()), Some(Simulated::Costs));
}

/// Every split, organisation, division and composition of `--organisation auto` is a candidate, once.
#[test]
fn all_that_the_renderer_can_do_is_searched() {
    let advice = advice("server-128", "builtin:gyroid@5k", 4, None);
    assert!(advice.candidates.windows(2).all(|w| w[0].frame.total() <= w[1].frame.total()));
    assert!(advice.candidates.iter().all(|c| c.frame.total().is_finite() && c.frame.total() > 0.0));
    for (ranks, threads) in [(2, 1), (2, 2), (3, 1), (4, 1)] {
        let all = crate::predict::choose::candidates::Limits::ALL.candidates(ranks).unwrap();
        for sharing in all {
            let how = How::Ranks { sharing, region: None };
            let is = |c: &&Candidate| c.how == how && c.split == Split { ranks, threads };
            assert_eq!(advice.candidates.iter().filter(is).count(), 1, "{sharing:?} {ranks} x {threads}");
        }
    }
    for threads in [1, 2, 3, 4] {
        let of = |c: &&Candidate| matches!(c.how, How::OneProcess { .. }) && c.split.threads == threads;
        assert_eq!(advice.candidates.iter().filter(of).count(), TILE_EDGES.len());
    }
    let has = |organisation: RendererOrganisation, composition| {
        advice.candidates.iter().any(|c| match c.how {
            How::Ranks { sharing: s, .. } => s.organisation == organisation && s.composition == composition,
            How::OneProcess { .. } => false,
        })
    };
    assert!(has(RendererOrganisation::SortTwice { group: 2 }, Composition::Tree));
    assert!(has(RendererOrganisation::SortLast, Composition::BinarySwap));
    assert!(has(RendererOrganisation::SortTwice { group: 3 }, Composition::Ring));
    // Of two and four ranks that is binary swap, of three direct send.
    assert!(!has(RendererOrganisation::SortLast, Composition::TwoThreeSwap));
}

/// The page quotes how many candidates there are, without the other tiles of the best ranks.
#[test]
fn the_page_has_the_numbers_of_candidates() {
    let number = |machine: &str, processors: usize| {
        let machine = builtin(machine).unwrap().unwrap();
        let all = crate::predict::choose::candidates::Limits::ALL;
        let of = |split: &Split| all.candidates(split.ranks).unwrap().len();
        let of_ranks: usize = splits::of_ranks(&machine, processors).iter().map(of).sum();
        of_ranks + splits::threads(&machine, processors).len() * TILE_EDGES.len()
    };
    // As few as are really predicted.
    let four = advice("server-128", "builtin:gyroid@5k", 4, None).candidates;
    let tiles = |c: &&Candidate| matches!(c.how, How::Ranks { region: Some(_), .. });
    assert_eq!(four.len() - four.iter().filter(tiles).count(), number("server-128", 4));
    let words = |number: usize| match (number / 1000, number % 1000) {
        (0, rest) => rest.to_string(),
        (thousands, rest) => format!("{thousands},{rest:03}"),
    };
    let [server, few, cluster] =
        [("server-128", 128), ("server-128", 16), ("cluster-64", 8192)].map(|(m, n)| words(number(m, n)));
    let sentence = format!(
        "{server} for `server-128`, {few} with `--processors 16`, {cluster} for the 8,192 processors of `cluster-64`"
    );
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/laboratory/advice.md");
    let page = std::fs::read_to_string(page).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(page.contains(&sentence), "{sentence}");
}

#[test]
fn the_best_is_explained_and_what_was_compared_is_said() {
    let advice = advice("server-128", "builtin:gyroid@5k", 4, None);
    let (lines, best) = (advice.explanation(), &advice.candidates[0]);
    assert!(lines[0].starts_with(&best.describe()), "{lines:?}");
    let number = advice.candidates.len();
    assert!(lines[0].contains(&format!("fastest of the {number} candidates")), "{lines:?}");
    assert!(
        lines[1].contains("1, 2, 3, 4 threads") && lines[1].contains("2 x 1, 2 x 2, 3 x 1, 4 x 1"),
        "{lines:?}"
    );
    assert!(lines[2].starts_with("not compared are other tiles of ranks"), "{lines:?}");
    assert!(lines[3].contains("assumed of the machine's numbers"), "{lines:?}");
    // The best, the search, what is missing, the uncertainty, and the classes threads, sort-first, -middle, -last and -twice but one.
    assert_eq!(lines.len(), 4 + 4, "{lines:?}");
    assert!(!lines[2].contains("splits of more than"), "{lines:?}");
    let fewer = Advice { left_out: 3, ..advice.clone() };
    let missing = &fewer.explanation()[2];
    assert!(
        missing.contains("; 3 splits of more than 32768 ranks: the formulas would take too long"),
        "{missing}"
    );
    let parts: f64 = best.parts().iter().map(|part| part.1).sum();
    assert!((parts - best.frame.total()).abs() < 1e-12);
}

/// The formulas take as long as the count of the work, for one rank of one thread, on machines of any speed.
#[test]
fn formulas_have_the_speed_of_the_machine() {
    let (scene, camera, settings) = made("builtin:gyroid@20k", (320, 240));
    let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
    let machine = builtin("server-128").unwrap().unwrap();
    let mut slow = machine.clone();
    slow.costs.values_mut().for_each(|cost| cost.value *= 3.0);
    let one = |machine: &Machine| on_threads(machine, &picture, None, 1).unwrap().total();
    assert!((one(&slow) / one(&machine) - 3.0).abs() < 1e-9);
    for machine in [&machine, &slow] {
        let rates = formulas::rates(machine, &picture).unwrap();
        let sharing = [RendererOrganisation::SortMiddle.into()];
        let terms = Sights::new(&picture, 1).predict(&sharing, &formulas::alone(&rates)).unwrap()[0].terms;
        assert!(
            ((terms.front_end + terms.draw) / one(machine) - 1.0).abs() < 1e-9,
            "{terms:?} {}",
            one(machine)
        );
    }
    let all = |machine: &Machine| {
        let splits = [Split { ranks: 2, threads: 1 }, Split { ranks: 4, threads: 1 }];
        formulas::ranks(machine, &picture, None, &splits, None).unwrap()
    };
    for (fast, slow) in all(&machine).iter().zip(&all(&slow)) {
        let ratio = slow.frame.total() / fast.frame.total();
        // Messages are as fast.
        assert!(ratio > 1.5 && ratio < 3.0 + 1e-9, "{} {ratio}", fast.describe());
        assert!(fast.frame.total() > one(&machine) / fast.split.ranks as f64, "{}", fast.describe());
    }
}

/// Whoever is first among those that can be counted was counted by the model of ranks.
#[test]
fn the_best_ranks_are_counted() {
    let (scene, camera, settings) = made("builtin:gyroid@20k", (320, 240));
    let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
    let machine = builtin("server-128").unwrap().unwrap();
    let splits = [Split { ranks: 2, threads: 1 }, Split { ranks: 2, threads: 4 }];
    let mut candidates = formulas::ranks(&machine, &picture, None, &splits, None).unwrap();
    let only = |c: &Candidate| c.counted().is_some();
    candidates.retain(only);
    assert_eq!(candidates.len(), 4, "sort-first and sort-last");
    sort(&mut candidates);
    let by_formulas = candidates.clone();
    refine(&machine, &picture, &mut candidates).unwrap();
    // The best is also counted with tiles of the other sizes, and all of these are in their places.
    assert_eq!(candidates.len(), 4 + TILE_EDGES.len() - 1);
    assert!(candidates.windows(2).all(|w| w[0].frame.total() <= w[1].frame.total()));
    let with_tiles = candidates.iter().filter_map(|c| match c.how {
        How::Ranks { region: Some(region), .. } => Some((region, c)),
        _ => None,
    });
    for (region, candidate) in with_tiles {
        assert!(
            candidate.describe().contains(&format!("tiles of {region} pixels")),
            "{}",
            candidate.describe()
        );
        let formulas = Frame::Formulas { terms: Terms::default(), sent: Sums::default() };
        let plan = Candidate { frame: formulas, ..candidate.clone() }.counted().unwrap();
        let tiles = Settings { tile_size: Some(region), ..settings.clone() };
        let requested = Picture { settings: &tiles, ..picture };
        let frame = predict(&machine, &requested, &Plan { region: None, ..plan }).unwrap().unwrap();
        assert_eq!(candidate.frame, Frame::Counted(Box::new(frame)));
    }
    // Requested tiles are the only ones.
    let tiles = Settings { tile_size: Some(32), ..settings.clone() };
    let mut candidates_of_32 = by_formulas;
    refine(&machine, &Picture { settings: &tiles, ..picture }, &mut candidates_of_32).unwrap();
    assert_eq!(candidates_of_32.len(), 4);
    let best = &candidates[0];
    let Frame::Counted(frame) = &best.frame else { panic!("{}", best.describe()) };
    let again = Candidate {
        frame: Frame::Formulas { terms: Terms::default(), sent: Sums::default() },
        ..best.clone()
    };
    let plan = again.counted().unwrap();
    assert_eq!(predict(&machine, &picture, &plan).unwrap().unwrap(), **frame);
    assert!(best.counted().is_none(), "once");
}

/// What no model counts is skipped, and what may be as fast is counted all the same; and it is said that the first is an estimate.
#[test]
fn what_cannot_be_counted_does_not_keep_others_from_being_counted() {
    let (scene, camera, settings) = made("builtin:gyroid@20k", (320, 240));
    let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
    let machine = builtin("server-128").unwrap().unwrap();
    let splits = [Split { ranks: 2, threads: 1 }, Split { ranks: 3, threads: 1 }];
    let mut candidates = formulas::ranks(&machine, &picture, None, &splits, None).unwrap();
    candidates.extend(one_process(&machine, &picture, 1).unwrap());
    let by_hand = candidates.iter_mut().find(|candidate| candidate.counted().is_none()).unwrap();
    by_hand.frame =
        Frame::Formulas { terms: Terms { draw: 1e-9, ..Terms::default() }, sent: Sums::default() };
    sort(&mut candidates);
    refine(&machine, &picture, &mut candidates).unwrap();
    assert!(!candidates[0].frame.is_counted());
    let counted = candidates.iter().position(|candidate| candidate.frame.is_counted()).unwrap();
    assert!(candidates[..counted].iter().all(|candidate| candidate.counted().is_none()));
    assert!(matches!(candidates[counted].frame, Frame::Counted(_)), "{}", candidates[counted].describe());
    let fastest = candidates[counted].describe();
    let lines = Advice { candidates, uncertainty: None, left_out: 0 }.explanation();
    assert!(
        lines[0].contains(&format!("no model counts it, and the fastest that is counted is {fastest}")),
        "{lines:?}"
    );
    assert!(
        lines[4..].iter().all(
            |line| line.contains("as counted, if the formulas are right") || !line.starts_with("threads")
        ),
        "{lines:?}"
    );
    assert!(lines[4..].iter().any(|line| line.starts_with("threads")), "{lines:?}");
}

/// Predictions 5 % off: the best takes 0.91 to 1.11 s; 1.2 s may be 1.09, and 1.3 at least 1.18.
#[test]
fn candidates_like_the_best_are_those_that_may_be_as_fast() {
    let candidate = |raster| {
        let (split, how) = (Split { ranks: 1, threads: 1 }, How::OneProcess { region: 8 });
        Candidate {
            split,
            how,
            frame: Frame::Threads(FrameTime { raster, ..FrameTime::default() }),
            assumed: None,
        }
    };
    let candidates = [1.0, 1.2, 1.3].map(candidate).into();
    let advice = Advice {
        candidates,
        uncertainty: Some(Uncertainty { residual: 0.05, costs_of: None, is_assumed: false }),
        left_out: 0,
    };
    let like = advice.candidates.iter().map(|c| advice.is_like_the_best(c)).collect::<Vec<_>>();
    assert_eq!(like, [Some(true), Some(true), Some(false)]);
    let sure = &advice.explanation()[3];
    assert!(sure.contains("it takes 909.091 ms to 1111.111 ms; 1 of the others"), "{sure}");
    // What is assumed of the machine moves both: intervals overlap, but with the same numbers 1.3 s are never 1.
    let both = |ends: [[f64; 2]; 2]| {
        let mut two = advice.clone();
        two.candidates.remove(1);
        two.candidates.iter_mut().zip(ends).for_each(|(c, ends)| c.assumed = Some(ends));
        let [best, other] = [0, 1].map(|k| two.interval(&two.candidates[k]).unwrap());
        assert!(other[0] < best[1], "{other:?} {best:?}");
        two.is_like_the_best(&two.candidates[1])
    };
    assert_eq!(both([[0.5, 2.0], [0.65, 2.6]]), Some(false));
    assert_eq!(both([[0.5, 2.0], [0.59, 2.6]]), Some(true));
    assert_eq!(both([[0.5, 2.0], [0.65, 2.3]]), Some(true));
    let none = Advice { uncertainty: None, ..advice };
    assert_eq!(none.is_like_the_best(&none.candidates[1]), None);
}

/// Slower numbers make slower frames; with borrowed residuals every candidate has an interval around its prediction.
#[test]
fn what_is_assumed_of_a_machine_is_propagated_to_every_candidate() {
    let Advice { candidates, .. } = advice("server-128", "builtin:gyroid@5k", 4, None);
    for c in &candidates {
        let ([fast, slow], seconds) = (c.assumed.unwrap(), c.frame.total());
        assert!(fast < seconds && seconds < slow, "{} {fast} {seconds} {slow}", c.describe());
    }
    let uncertainty =
        Some(Uncertainty { residual: 0.05, costs_of: Some("two-core-2026".into()), is_assumed: false });
    let advice = Advice { candidates, uncertainty, left_out: 0 };
    for c in &advice.candidates {
        let ([low, high], [fast, slow]) = (advice.interval(c).unwrap(), c.assumed.unwrap());
        assert!(low < fast && slow < high, "{}", c.describe());
    }
    let sure = &advice.explanation()[3];
    assert!(sure.contains("on two-core-2026") && sure.contains("assumed of the machine's numbers"), "{sure}");
}

/// Costs, messages and bandwidths that are all off by the same factor move a frame by that factor: on threads and ranks.
#[test]
fn frames_are_homogeneous_in_what_is_assumed() {
    let (scene, camera, settings) = made("builtin:gyroid@5k", (160, 120));
    let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
    let mut machine = builtin("cluster-64").unwrap().unwrap();
    let off = Some(crate::machines::Sourced::new(1.0, "100 %".into(), "assumed".into()));
    machine.uncertainty = Some(crate::machines::Assumptions {
        costs: off.clone(),
        memory_bandwidth: off.clone(),
        network_bandwidth: off.clone(),
        message: off.clone(),
        wake_up: off,
        ..Default::default()
    });
    let splits =
        [Split { ranks: 4, threads: 1 }, Split { ranks: 256, threads: 1 }, Split { ranks: 4, threads: 64 }];
    let ranks = formulas::ranks(&machine, &picture, None, &splits, None).unwrap();
    let threads = one_process(&machine, &picture, 8).unwrap();
    for c in ranks.iter().chain(&threads) {
        let ([fast, slow], seconds) = (c.assumed.unwrap(), c.frame.total());
        assert!((2.0 * fast / seconds - 1.0).abs() < 1e-6, "{} {fast} {seconds}", c.describe());
        assert!((slow / seconds / 2.0 - 1.0).abs() < 1e-6, "{} {slow} {seconds}", c.describe());
    }
}

/// Waking up takes as long whatever the work is: it is no part of the share of a thread, and every rank waits for it once.
#[test]
fn ranks_wait_once_until_their_threads_have_woken_up() {
    let (scene, camera, settings) = made("builtin:gyroid@20k", (320, 240));
    let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
    let mut machine = builtin("server-128").unwrap().unwrap();
    machine.uncertainty = None;
    let splits =
        [Split { ranks: 2, threads: 1 }, Split { ranks: 2, threads: 4 }, Split { ranks: 8, threads: 4 }];
    let mut with = |wake_up: f64| {
        machine.processors.wake_up =
            Some(crate::machines::Sourced::new(wake_up, String::new(), String::new()));
        formulas::ranks(&machine, &picture, None, &splits, None).unwrap()
    };
    let (none, some, long) = (with(0.0), with(4e-6), with(1.0));
    for ((none, some), long) in none.iter().zip(&some).zip(&long) {
        let [none_s, some_s, long_s] = [none, some, long].map(|c| c.frame.total());
        let expected = if none.split.threads == 1 { 0.0 } else { 3e-6 };
        assert!((some_s - none_s - expected).abs() < 1e-12, "{} {none_s} {some_s}", none.describe());
        // A frame that is shorter is one thread's, not a second's.
        assert!(long_s >= some_s && long_s < 0.1, "{} {long_s}", none.describe());
    }
}

#[test]
fn another_network_changes_ranks_only() {
    let own = advice("cluster-64", "builtin:gyroid@5k", 256, None);
    let ring = advice("cluster-64", "builtin:gyroid@5k", 256, Some(Topology::Ring));
    // Tiles of other sizes are counted for the machine's own network only.
    let usual = |advice: &Advice| {
        let has_tiles = |c: &&Candidate| matches!(c.how, How::Ranks { region: Some(_), .. });
        advice.candidates.len() - advice.candidates.iter().filter(has_tiles).count()
    };
    assert_eq!(usual(&own), ring.candidates.len());
    let threads = |advice: &Advice| -> Vec<f64> {
        let one = advice.candidates.iter().filter(|c| c.split.ranks == 1);
        one.map(|c| c.frame.total()).collect()
    };
    assert_eq!(threads(&own), threads(&ring));
    assert!(ring.candidates.iter().all(|c| !matches!(c.frame, Frame::Counted(_))));
}

#[test]
fn ranks_of_several_threads_draw_faster_than_ranks_of_one() {
    let machine = builtin("server-128").unwrap().unwrap();
    let (scene, camera, settings) = made("builtin:gyroid@20k", (320, 240));
    let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
    for organisation in [Organisation::SortFirst, Organisation::SortLast] {
        let draw = |threads| {
            let (region, assignment) = (Some(16), Assignment::Interleaved);
            let plan = Plan { organisation, ranks: 2, threads, region, assignment, topology: None };
            let frame = predict(&machine, &picture, &plan).unwrap().unwrap();
            (frame.busiest_and_mean(|r| r.draw).0, frame.bytes, frame.messages)
        };
        let (one, four) = (draw(1), draw(4));
        assert_eq!((one.1, one.2), (four.1, four.2), "threads send nothing");
        assert!(four.0 < one.0 && four.0 > one.0 / 4.0, "{four:?} {one:?}");
    }
}

#[test]
fn missing_parts_and_too_many_processors_are_reported() {
    let machine = builtin("server-128").unwrap().unwrap();
    let (scene, camera, settings) = made("builtin:teapot@1k", (64, 64));
    let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
    let error = advise(&machine, &picture, 129, None).unwrap_err();
    assert!(error.to_string().contains("expected at most 128 processors, found 129"), "{error}");
    let machine = builtin("voodoo-sli").unwrap().unwrap();
    let error = search(&machine, &counters(1), &boxes(1), (64, 64), None, 2).unwrap_err();
    assert!(error.to_string().contains("missing in its description: network, bytes.primitive"), "{error}");
}
