//! A machine with tile engines: its pipeline from the front end over the triangle heap to the tile buffer.

use glam::{DVec2, dvec2};
use tercio::vector::Shape;

use super::{FONT, INK, SORT, join, outline, text};
use crate::machines::{Heap, Machine, TileEngine};

const STAGES: [&str; 7] = [
    "front end",
    "triangle heap",
    "set-up triangle",
    "draw triangle",
    "set-up span",
    "draw span",
    "tile buffer",
];
/// Left edge of the first stage, and the distance from one to the next.
const LEFT: f64 = 6.0;
const PITCH: f64 = 108.0;
const WIDTH: f64 = 88.0;
/// The rows lie between these heights.
const TOP: f64 = 50.0;
const BOTTOM: f64 = 182.0;
/// Engines and lanes that are drawn at most.
const MOST: u64 = 2;

/// The shapes of the pipeline.
pub(super) fn push(shapes: &mut Vec<Shape>, machine: &Machine, heap: &Heap, engine: &TileEngine) {
    let few = |count: u64| count.clamp(1, MOST) as usize;
    let (heaps, engines) = (few(heap.heaps.whole()), few(engine.engines.whole()));
    let lanes = few(engine.interleave.whole());
    let in_software = !machine.costs.is_empty();
    let rows = [heaps, heaps, engines, engines * lanes, engines * lanes, engines * lanes * lanes, engines];
    let unit = if in_software { "processor" } else { "engine" };
    let parity = |k: usize, what: &str| format!("{} {what}", ["even", "odd"][k % 2]);
    for (stage, (name, of)) in STAGES.into_iter().zip(rows).enumerate() {
        text(shapes, name, FONT - 1.0, dvec2(left(stage) + 0.5 * WIDTH, 24.0), INK);
        for k in 0..of {
            let label = match stage {
                0 if in_software => format!("processor {}", k + 1),
                0 => "host".into(),
                1 => format!("heap {}", k + 1),
                3 | 4 if lanes > 1 => parity(k, "lines"),
                5 if lanes > 1 => parity(k, "pixels"),
                _ => format!("{unit} {}", k + 1),
            };
            let size = dvec2(WIDTH, height(of));
            outline(shapes, dvec2(left(stage), middle(k, of) - 0.5 * size.y), size, &label);
        }
    }
    for (stage, pair) in rows.windows(2).enumerate() {
        let (from, to) = (pair[0], pair[1]);
        let joined = |a: usize, b: usize| match stage {
            // Every engine reads the tiles that it owns from all heaps.
            1 => true,
            // A stage belongs to one of the stage before it, or is the one of several after it.
            _ => a * to / from == b || b * from / to == a,
        };
        let color = if stage == 0 || (stage == 1 && engines > 1) { SORT } else { INK };
        let pairs = (0..from).flat_map(|a| (0..to).map(move |b| (a, b))).filter(|&(a, b)| joined(a, b));
        let (right, next) = (left(stage) + WIDTH, left(stage + 1));
        join(shapes, color, pairs.map(|(a, b)| [dvec2(right, middle(a, from)), dvec2(next, middle(b, to))]));
    }
    text(shapes, "sort", FONT, gap(0, 42.0), SORT);
    let below = |shapes: &mut Vec<Shape>, stage: usize, words: &str, color| {
        text(shapes, words, FONT - 1.0, gap(stage, 200.0), color);
    };
    below(shapes, 0, &format!("nodes, {} each", heap.node), SORT);
    if let Some(bus) = &machine.transfer {
        below(shapes, 1, &format!("bus, {}", bus.bandwidth), INK);
    }
    if !in_software {
        // A queue is before each stage that iterates.
        let (before, after) = (engine.fifo.whole(), engine.fifo_after_broadcast.whole());
        let queue = match (lanes, before) {
            (1, 0 | 1) => "register".into(),
            (1, _) => format!("queue of {before}"),
            _ => format!("queues of {before} and {after}"),
        };
        below(shapes, 2, &queue, INK);
        below(shapes, 4, &queue, INK);
    }
}

fn left(stage: usize) -> f64 {
    LEFT + PITCH * stage as f64
}

/// The point between a stage and the next.
fn gap(stage: usize, y: f64) -> DVec2 {
    dvec2(left(stage) + 0.5 * (WIDTH + PITCH), y)
}

/// Height of one of `of` boxes, and its middle.
fn height(of: usize) -> f64 {
    ((BOTTOM - TOP) / of as f64 - 8.0).min(34.0)
}

fn middle(k: usize, of: usize) -> f64 {
    TOP + (BOTTOM - TOP) * (k as f64 + 0.5) / of as f64
}
