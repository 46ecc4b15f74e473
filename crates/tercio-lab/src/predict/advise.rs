//! The best organisation for a machine and a model: all candidates are predicted, the fastest is explained.
//!
//! If there is a model of the renderer's ranks for a plan ([`Plan::by_renderer`]), the advice is about the renderer and
//! comes from it. The simulator of the sorting classes then estimates the others, comparable only with its own figures.
//! Without such a model, the advice is the simulator's.

use rayon::prelude::*;
use serde::Serialize;

use super::PredictError;
use super::counts::Counters;
use super::ranks::renderer::{RankSeconds, RanksFrame};
use super::ranks::simulated::SimulatedFrame;
use super::ranks::{Picture, Plan, TILE_EDGES, predict, simulate};
use crate::machines::{Machine, Topology};
use crate::simulators::sorting::{Assignment, Organisation};
use crate::workloads::BoxScene;

/// A frame predicted by the model of the renderer's ranks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rendered {
    /// How the ranks share it.
    pub plan: Plan,
    /// The prediction.
    pub frame: RanksFrame,
}

impl Rendered {
    /// The plan in words.
    pub fn describe(&self) -> String {
        format!("{}, regions of {} pixels", class(self.plan.organisation), self.frame.region)
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

/// The candidates: the four classes, groups of every power of two, regions of 16 to 128 pixels and the largest
/// possible, both assignments.
pub fn plans(ranks: usize, topology: Option<Topology>) -> Vec<Plan> {
    let mut organisations = vec![Organisation::SortFirst, Organisation::SortMiddle, Organisation::SortLast];
    let groups = (1..usize::BITS).map(|bit| 1usize << bit).take_while(|g| *g < ranks);
    organisations.extend(groups.map(Organisation::SortTwice));
    let mut plans = Vec::new();
    for organisation in organisations {
        for region in [None, Some(16), Some(32), Some(64), Some(128)] {
            for assignment in [Assignment::Interleaved, Assignment::Blocks] {
                // An owner of the whole picture needs no regions.
                let divided = organisation != Organisation::SortLast;
                if divided || (region.is_none() && assignment == Assignment::Interleaved) {
                    plans.push(Plan { organisation, ranks, region, assignment, topology });
                }
            }
        }
    }
    plans
}

/// The plans that the renderer supports: both organisations, with tiles of every size.
pub fn renderer_plans(ranks: usize) -> Vec<Plan> {
    let of_region = |region| {
        [Organisation::SortFirst, Organisation::SortLast].map(|organisation| {
            let assignment = Assignment::Interleaved;
            Plan { organisation, ranks, region: Some(region), assignment, topology: None }
        })
    };
    TILE_EDGES.into_iter().flat_map(of_region).collect()
}

/// Predicts plans: each that the renderer supports by its model, all by the simulator.
///
/// # Errors
/// As [`predict`] and [`simulate`].
pub fn advise(
    machine: &Machine,
    picture: &Picture,
    counters: &Counters,
    boxes: &BoxScene,
    (rendered, simulated): (&[Plan], &[Plan]),
) -> Result<Advice, PredictError> {
    let mut renderer = Vec::new();
    for plan in rendered {
        // Ranks are counted on all threads of this process.
        if let Ok(frame) = predict(machine, picture, plan)? {
            renderer.push(Rendered { plan: *plan, frame });
        }
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
            lines.push(why_rendered(best));
            let of_class = |r: &Rendered| (class(r.plan.organisation), r.frame.total(), r.describe());
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

fn milliseconds(seconds: f64) -> String {
    format!("{:.3} ms", seconds * 1e3)
}

fn why_rendered(best: &Rendered) -> String {
    let f = &best.frame;
    let (name, seconds) = longest(&f.phases());
    format!(
        "{} is fastest of what the renderer has, {} a frame: rank 0 spends most on {name}, {}; busiest over mean rank \
         {:.2} in drawing and {:.2} in all; {} bytes in {} messages; {} bytes in the rank that needs most",
        best.describe(),
        milliseconds(f.total()),
        milliseconds(seconds),
        f.imbalance(|r| r.draw),
        f.imbalance(RankSeconds::busy),
        f.bytes,
        f.messages,
        f.memory.total(),
    )
}

fn why_simulated(best: &SimulatedFrame) -> String {
    let (name, seconds) = longest(&best.phases());
    format!(
        "{} is fastest, {} a frame: its longest phase is {name} with {}; busiest over mean rank {:.2} in geometry and \
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
        let plans = (renderer_plans(64), plans(64, None));
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
        let machine = builtin("two-core-2026").unwrap().unwrap();
        let (scene, bounds) =
            crate::predict::calibrate::prepare(tercio_mesh::builtin::make("builtin:gyroid@5k").unwrap());
        let (camera, settings) = (
            crate::predict::views::camera(&bounds, (160, 120), 0, 1),
            tercio_raster::Settings::one_sample(160, 120),
        );
        let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
        let plans = (renderer_plans(4), plans(4, None));
        let advice =
            advise(&machine, &picture, &counters(100), &self::scene(100), (&plans.0, &plans.1)).unwrap();
        assert_eq!(advice.renderer.len(), plans.0.len());
        assert!(advice.renderer.windows(2).all(|w| w[0].frame.total() <= w[1].frame.total()));
        for Rendered { plan, frame } in &advice.renderer {
            assert_eq!(predict(&machine, &picture, plan).unwrap().as_ref(), Ok(frame), "{plan:?}");
        }
        let lines = advice.explanation();
        let best = &advice.renderer[0];
        assert!(lines[0].starts_with(&best.describe()), "{lines:?}");
        assert!(lines[0].contains(&milliseconds(best.frame.total())), "{lines:?}");
        assert!(lines[0].contains(&format!("{} bytes in {}", best.frame.bytes, best.frame.messages)));
        // The renderer's other class, the separator, four classes of the simulator.
        assert_eq!(lines.len(), 2 + 1 + 4, "{lines:?}");
    }

    #[test]
    fn a_machine_without_a_network_is_reported() {
        let machine = builtin("voodoo-sli").unwrap().unwrap();
        let error = picture((64, 64), |picture| {
            let plans = plans(2, None);
            advise(&machine, picture, &counters(1), &scene(1), (&[], &plans)).unwrap_err()
        });
        assert!(error.to_string().contains("network is needed"), "{error}");
    }
}
