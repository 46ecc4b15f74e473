//! The best organisation for a machine and a model: all candidates are predicted, the fastest is explained.
//!
//! If a machine has the costs of the renderer and its ranks ([`Plan::by_renderer`]), the advice is about the renderer and
//! comes from the models of its threads and ranks. The simulator of the sorting classes then estimates the others,
//! comparable only with its own figures.
//! Without such a model, the advice is the simulator's.

use rayon::prelude::*;
use serde::Serialize;

use super::PredictError;
use super::counts::Counters;
use super::frame::FrameTime;
use super::ranks::renderer::{RankSeconds, RanksFrame};
use super::ranks::simulated::SimulatedFrame;
use super::ranks::{MOST_RANKS, Picture, Plan, Simulated, TILE_EDGES, on_threads, predict, simulate};
use crate::machines::{Control, Machine, Topology};
use crate::simulators::sorting::{Assignment, Organisation};
use crate::workloads::BoxScene;

/// A frame predicted by the models that are compared with the renderer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rendered {
    /// How the processors share it.
    pub plan: RenderedPlan,
    /// The prediction.
    pub frame: Frame,
}

/// How the renderer uses processors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RenderedPlan {
    /// One process with threads.
    Threads {
        /// Threads.
        threads: usize,
        /// Pixels along the edge of a tile.
        region: u32,
    },
    /// Ranks, of one thread or several.
    Ranks(Plan),
}

/// A predicted frame of the renderer.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Frame {
    /// Of threads.
    Threads(FrameTime),
    /// Of ranks.
    Ranks(RanksFrame),
}

impl Frame {
    /// Seconds of the frame.
    pub fn total(&self) -> f64 {
        match self {
            Self::Threads(time) => time.total(),
            Self::Ranks(frame) => frame.total(),
        }
    }

    /// The parts of rank 0's frame; a process without ranks only draws.
    fn phases(&self) -> [(&'static str, f64); 6] {
        match self {
            Self::Threads(time) => {
                let [draw, rest @ ..] = RanksFrame::PHASES;
                let rest = rest.map(|name| (name, 0.0));
                [(draw, time.total()), rest[0], rest[1], rest[2], rest[3], rest[4]]
            }
            Self::Ranks(frame) => frame.phases(),
        }
    }
}

impl Rendered {
    /// The plan in words.
    pub fn describe(&self) -> String {
        match self.plan {
            RenderedPlan::Threads { threads, region } => {
                format!("threads, {threads} of one process, regions of {region} pixels")
            }
            RenderedPlan::Ranks(plan) => {
                let region = match &self.frame {
                    Frame::Ranks(frame) => frame.region,
                    Frame::Threads(_) => 0,
                };
                let (class, ranks, threads) = (class(plan.organisation), plan.ranks, plan.threads);
                format!("{class}, {ranks} ranks of {threads} threads, regions of {region} pixels")
            }
        }
    }

    fn class(&self) -> &'static str {
        match self.plan {
            RenderedPlan::Threads { .. } => "threads",
            RenderedPlan::Ranks(plan) => class(plan.organisation),
        }
    }
}

/// Predictions, the fastest first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// Plans that the renderer has, by the model that is compared with it.
    pub renderer: Vec<Rendered>,
    /// All plans by the simulator of the sorting classes.
    pub simulated: Vec<SimulatedFrame>,
}

/// The candidates of the simulator: the four classes, groups of every power of two, regions of 16 to 128 pixels and the
/// largest possible, both assignments. Groups of a SIMD machine divide its processors.
pub fn plans(machine: &Machine, ranks: usize, topology: Option<Topology>) -> Vec<Plan> {
    let mut organisations = vec![Organisation::SortFirst, Organisation::SortMiddle, Organisation::SortLast];
    let divides = |g: &usize| machine.processors.control == Control::Mimd || ranks.is_multiple_of(*g);
    let groups = (1..usize::BITS).map(|bit| 1usize << bit).take_while(|g| *g < ranks).filter(divides);
    organisations.extend(groups.map(Organisation::SortTwice));
    let mut plans = Vec::new();
    for organisation in organisations {
        for region in [None, Some(16), Some(32), Some(64), Some(128)] {
            for assignment in [Assignment::Interleaved, Assignment::Blocks] {
                // An owner of the whole picture needs no regions.
                let divided = organisation != Organisation::SortLast;
                if divided || (region.is_none() && assignment == Assignment::Interleaved) {
                    plans.push(Plan { organisation, ranks, threads: 1, region, assignment, topology });
                }
            }
        }
    }
    plans
}

/// The plans of the renderer on up to so many processors of a machine, with tiles of every size: 1, 2, 4 ... threads of
/// one process, and ranks with threads, sort-first and sort-last, that use all of the processors.
pub fn renderer_plans(machine: &Machine, processors: usize) -> Vec<RenderedPlan> {
    let powers = (0..usize::BITS).map(|bit| 1usize << bit).take_while(|&number| number < processors);
    let numbers: Vec<usize> = powers.chain([processors]).collect();
    let share = |threads: usize| threads as u64 <= machine.most_threads();
    let mut plans = Vec::new();
    for region in TILE_EDGES {
        let threads = numbers.iter().filter(|&&threads| share(threads));
        plans.extend(threads.map(|&threads| RenderedPlan::Threads { threads, region }));
        for &ranks in &numbers {
            let threads = processors / ranks;
            if ranks == 1 || ranks > MOST_RANKS || !processors.is_multiple_of(ranks) || !share(threads) {
                continue;
            }
            for organisation in [Organisation::SortFirst, Organisation::SortLast] {
                let (region, assignment) = (Some(region), Assignment::Interleaved);
                plans.push(RenderedPlan::Ranks(Plan {
                    organisation,
                    ranks,
                    threads,
                    region,
                    assignment,
                    topology: None,
                }));
            }
        }
    }
    plans
}

/// Why a machine has no predictions of the renderer's frames, if so.
pub fn why_not(machine: &Machine, topology: Option<Topology>) -> Option<Simulated> {
    let (organisation, assignment) = (Organisation::SortFirst, Assignment::Interleaved);
    Plan { organisation, ranks: 1, threads: 1, region: None, assignment, topology }.by_renderer(machine).err()
}

/// Predicts plans: those of the renderer by its models, all others by the simulator.
///
/// # Errors
/// As [`predict`], [`on_threads`] and [`simulate`].
pub fn advise(
    machine: &Machine,
    picture: &Picture,
    counters: &Counters,
    boxes: &BoxScene,
    (rendered, simulated): (&[RenderedPlan], &[Plan]),
) -> Result<Advice, PredictError> {
    let mut renderer = Vec::new();
    let rendered = if why_not(machine, None).is_none() { rendered } else { &[] };
    for &plan in rendered {
        // Ranks are counted on all threads of this process.
        let frame = match plan {
            RenderedPlan::Threads { threads, region } => {
                Some(Frame::Threads(on_threads(machine, picture, Some(region), threads)?))
            }
            RenderedPlan::Ranks(of_ranks) => predict(machine, picture, &of_ranks)?.ok().map(Frame::Ranks),
        };
        renderer.extend(frame.map(|frame| Rendered { plan, frame }));
    }
    let size = (picture.settings.width, picture.settings.height);
    let simulated: Result<Vec<SimulatedFrame>, _> =
        simulated.par_iter().map(|plan| simulate(machine, counters, boxes, size, plan)).collect();
    let mut simulated = simulated?;
    // Plans with equal times stay in the order of the lists, simple plans first.
    renderer.sort_by(|a, b| a.frame.total().total_cmp(&b.frame.total()));
    simulated.sort_by(|a, b| a.total().total_cmp(&b.total()));
    Ok(Advice { renderer, simulated })
}

impl Advice {
    /// Why the first one is the fastest, and what limits the best of each other class.
    pub fn explanation(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(best) = self.renderer.first() {
            lines.push(why_rendered(best, self.renderer.len()));
            lines.push(self.searched());
            let of_class = |r: &Rendered| (r.class(), r.frame.total(), r.describe());
            let phases = |k: usize| self.renderer[k].frame.phases().to_vec();
            lines.extend(others(&self.renderer.iter().map(of_class).collect::<Vec<_>>(), phases));
            lines.push("the rest is from the simulator of the sorting classes, another model".into());
        }
        if let Some(best) = self.simulated.first() {
            lines.push(why_simulated(best));
            let of_class = |s: &SimulatedFrame| (class(s.plan.organisation), s.total(), describe(&s.plan));
            let phases = |k: usize| self.simulated[k].phases().to_vec();
            lines.extend(others(&self.simulated.iter().map(of_class).collect::<Vec<_>>(), phases));
        }
        lines
    }
}

impl Advice {
    /// What the plans of the renderer are, and what it has besides.
    fn searched(&self) -> String {
        let mut ranks = Vec::new();
        let mut threads = 1;
        for rendered in &self.renderer {
            match rendered.plan {
                RenderedPlan::Threads { threads: some, .. } => threads = threads.max(some),
                RenderedPlan::Ranks(plan) => ranks.push((plan.ranks, plan.threads)),
            }
        }
        ranks.sort_unstable();
        ranks.dedup();
        let ranks: Vec<_> = ranks.iter().map(|(r, t)| format!("{r} x {t}")).collect();
        let ranks = if ranks.is_empty() {
            "no ranks".into()
        } else {
            format!("ranks x threads {}", ranks.join(", "))
        };
        format!(
            "compared are up to {threads} threads of one process, and {ranks}, in sort-first and sort-last with direct \
             send; the renderer's sort-middle, sort-twice and other divisions and compositions are not"
        )
    }
}

fn milliseconds(seconds: f64) -> String {
    format!("{:.3} ms", seconds * 1e3)
}

fn why_rendered(best: &Rendered, compared: usize) -> String {
    let total = milliseconds(best.frame.total());
    let plan = format!(
        "{} is fastest of the {compared} plans of the renderer compared, {total} a frame",
        best.describe()
    );
    match &best.frame {
        Frame::Threads(time) => format!(
            "{plan}: front end {}, geometry {}, rasterization {}, shading {}, memory {}, picture {}; busiest over mean \
             thread {:.2}",
            milliseconds(time.front_end),
            milliseconds(time.geometry),
            milliseconds(time.raster),
            milliseconds(time.shading),
            milliseconds(time.memory),
            milliseconds(time.picture),
            time.imbalance,
        ),
        Frame::Ranks(f) => {
            let (name, seconds) = longest(&f.phases());
            format!(
                "{plan}: rank 0 spends most on {name}, {}; busiest over mean rank {:.2} in drawing and {:.2} in all; {} \
                 bytes in {} messages; {} bytes in the rank that needs most",
                milliseconds(seconds),
                f.imbalance(|r| r.draw),
                f.imbalance(RankSeconds::busy),
                f.bytes,
                f.messages,
                f.memory.total(),
            )
        }
    }
}

fn why_simulated(best: &SimulatedFrame) -> String {
    let (name, seconds) = longest(&best.phases());
    format!(
        "{} is fastest of the classes simulated, {} a frame: its longest phase is {name} with {}; busiest over mean rank {:.2} in geometry and \
         {:.2} in rasterization",
        describe(&best.plan),
        milliseconds(best.total()),
        milliseconds(seconds),
        best.sorting.geometry.imbalance(),
        best.sorting.raster.imbalance(),
    )
}

fn longest(phases: &[(&'static str, f64)]) -> (&'static str, f64) {
    phases.iter().copied().fold(phases[0], |best, p| if p.1 > best.1 { p } else { best })
}

/// The best of each class except the first, with the phase in which it loses most.
fn others(
    plans: &[(&'static str, f64, String)],
    phases: impl Fn(usize) -> Vec<(&'static str, f64)>,
) -> Vec<String> {
    let (mut lines, mut seen, ours) = (Vec::new(), vec![plans[0].0], phases(0));
    for (k, (class, total, description)) in plans.iter().enumerate() {
        if seen.contains(class) {
            continue;
        }
        seen.push(*class);
        let (name, theirs, ours) = phases(k)
            .into_iter()
            .zip(&ours)
            .map(|(o, b)| (o.0, o.1, b.1))
            .fold(("", 0.0, 0.0), |worst, p| if p.1 - p.2 > worst.1 - worst.2 { p } else { worst });
        lines.push(format!(
            "{description} takes {:.2} times as long, {}: {name} takes {} instead of {}",
            total / plans[0].1,
            milliseconds(*total),
            milliseconds(theirs),
            milliseconds(ours),
        ));
    }
    lines
}

fn class(organisation: Organisation) -> &'static str {
    match organisation {
        Organisation::SortFirst => "sort-first",
        Organisation::SortMiddle => "sort-middle",
        Organisation::SortLast => "sort-last",
        Organisation::SortTwice(_) => "sort-twice",
    }
}

/// A plan of the simulator in words.
pub fn describe(plan: &Plan) -> String {
    let mut text = class(plan.organisation).to_string();
    if let Organisation::SortTwice(group) = plan.organisation {
        text += &format!(" in groups of {group}");
    }
    if plan.organisation != Organisation::SortLast {
        let regions = plan.region.map_or("as large as possible".into(), |e| format!("of {e} pixels"));
        let assignment = match plan.assignment {
            Assignment::Interleaved => "interleaved",
            Assignment::Blocks => "in blocks",
        };
        text += &format!(", regions {regions} {assignment}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines::builtin;
    use crate::workloads::{BoundingBox, PixelBox};

    fn counters(boxes: u64) -> Counters {
        let binned = Counters {
            triangles: boxes,
            triangles_apart: boxes,
            triangles_binned: boxes,
            ..Counters::default()
        };
        Counters {
            entries: boxes,
            entries_drawn: boxes,
            stamps: boxes,
            stamps_alone: boxes,
            pixels: 1 << 20,
            ..binned
        }
    }

    fn scene(boxes: u64) -> BoxScene {
        let at = |k: u64| (k * 7919 % 1_000_003 % 1000) as i32;
        let of = |k| {
            let (x, y) = (at(k), at(k * 31 + 5));
            BoundingBox { visible: true, pixels: PixelBox { x0: x, y0: y, x1: x + 2, y1: y + 2 } }
        };
        BoxScene { boxes: (0..boxes).map(of).collect() }
    }

    /// No model: the simulator needs only boxes.
    fn picture<R>(size: (u32, u32), work: impl FnOnce(&Picture) -> R) -> R {
        let scene = tercio_scene::Scene::default();
        let camera = crate::predict::views::camera(
            &tercio_mesh::Aabb { min: glam::DVec3::ZERO, max: glam::DVec3::ONE },
            size,
            0,
            1,
        );
        let settings = tercio_raster::Settings::one_sample(size.0, size.1);
        work(&Picture { scene: &scene, camera: &camera, settings: &settings })
    }

    #[test]
    fn the_first_plan_is_the_fastest_and_the_others_are_explained() {
        let machine = builtin("princeton-engine").unwrap().unwrap();
        let plans = (renderer_plans(&machine, 64), plans(&machine, 64, None));
        let advice = picture((1024, 1024), |picture| {
            advise(&machine, picture, &counters(3000), &scene(3000), (&plans.0, &plans.1)).unwrap()
        });
        assert!(advice.renderer.is_empty(), "no costs of the renderer's ranks");
        let simulated = &advice.simulated;
        assert_eq!(simulated.len(), plans.1.len());
        assert!(simulated.windows(2).all(|w| w[0].total() <= w[1].total()));
        let lines = advice.explanation();
        assert_eq!(lines.len(), 4, "one line a class: {lines:?}");
        // Sending 3,000 polygons is faster than sending megabytes of pixels round a ring.
        let first = simulated[0].plan.organisation;
        assert!(matches!(first, Organisation::SortMiddle | Organisation::SortFirst));
        assert!(lines.iter().any(|l| l.starts_with("sort-last") && l.contains("composition")), "{lines:?}");
    }

    #[test]
    fn what_the_renderer_has_is_explained_by_its_own_model() {
        let machine = builtin("server-128").unwrap().unwrap();
        let (scene, bounds) =
            crate::predict::calibrate::prepare(tercio_mesh::builtin::make("builtin:gyroid@5k").unwrap());
        let (camera, settings) = (
            crate::predict::views::camera(&bounds, (160, 120), 0, 1),
            tercio_raster::Settings::one_sample(160, 120),
        );
        let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
        let plans = (renderer_plans(&machine, 4), plans(&machine, 4, None));
        let advice =
            advise(&machine, &picture, &counters(100), &self::scene(100), (&plans.0, &plans.1)).unwrap();
        assert_eq!(advice.renderer.len(), plans.0.len());
        assert!(advice.renderer.windows(2).all(|w| w[0].frame.total() <= w[1].frame.total()));
        for Rendered { plan, frame } in &advice.renderer {
            let again = match *plan {
                RenderedPlan::Threads { threads, region } => {
                    Frame::Threads(on_threads(&machine, &picture, Some(region), threads).unwrap())
                }
                RenderedPlan::Ranks(of_ranks) => {
                    Frame::Ranks(predict(&machine, &picture, &of_ranks).unwrap().unwrap())
                }
            };
            assert_eq!(&again, frame, "{plan:?}");
        }
        let lines = advice.explanation();
        let best = &advice.renderer[0];
        assert!(lines[0].starts_with(&best.describe()), "{lines:?}");
        assert!(lines[0].contains(&milliseconds(best.frame.total())), "{lines:?}");
        // The search covers threads, and ranks with threads: a plan of each is there, and the best is the best of all.
        for (ranks, threads) in [(1, 1), (1, 2), (1, 4), (2, 2), (4, 1)] {
            let is_it = |r: &Rendered| match r.plan {
                RenderedPlan::Threads { threads: t, .. } => (1, t) == (ranks, threads),
                RenderedPlan::Ranks(plan) => (plan.ranks, plan.threads) == (ranks, threads),
            };
            assert!(advice.renderer.iter().any(is_it), "{ranks} ranks of {threads} threads");
        }
        assert!(!lines.iter().any(|l| l.contains("what the renderer has")), "{lines:?}");
        assert!(lines[1].contains("4 threads") && lines[1].contains("2 x 2, 4 x 1"), "{lines:?}");
        // The best, the search, two other classes, the separator, four classes of the simulator.
        assert_eq!(lines.len(), 2 + 2 + 1 + 4, "{lines:?}");
    }

    #[test]
    fn ranks_of_several_threads_draw_faster_than_ranks_of_one() {
        let machine = builtin("server-128").unwrap().unwrap();
        let (scene, bounds) =
            crate::predict::calibrate::prepare(tercio_mesh::builtin::make("builtin:gyroid@20k").unwrap());
        let (camera, settings) = (
            crate::predict::views::camera(&bounds, (320, 240), 0, 1),
            tercio_raster::Settings::one_sample(320, 240),
        );
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
        let error = picture((64, 64), |picture| {
            let plans = plans(&machine, 129, None);
            advise(&machine, picture, &counters(1), &scene(1), (&[], &plans)).unwrap_err()
        });
        assert!(error.to_string().contains("expected at most 128 processors, found 129"), "{error}");
        let machine = builtin("voodoo-sli").unwrap().unwrap();
        let error = picture((64, 64), |picture| {
            let plans = plans(&machine, 2, None);
            advise(&machine, picture, &counters(1), &scene(1), (&[], &plans)).unwrap_err()
        });
        assert!(
            error.to_string().contains("missing in its description: network, bytes.primitive"),
            "{error}"
        );
    }
}
