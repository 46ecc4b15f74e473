//! One tile engine, cycle by cycle.
//!
//! Four stages form a pipeline: *Set-up Triangle* clips a triangle to the tile, *Draw Triangle* makes a span of every
//! row, *Set-up Span* clips it at the tile's border, *Draw Span* draws its pixels. A stage makes one step per cycle;
//! there is a FIFO before each stage that iterates. In the 2x2 interleaved engine a triangle is broadcast to two Draw
//! Triangle stages, even and odd rows, and each of their spans to two Draw Span stages, even and odd pixels. In the
//! scan-line interleaved one it is broadcast to four Draw Triangle stages with a Draw Span stage each.
//!
//! Within a cycle the last stage moves first: an entry taken from a FIFO makes room for one that is written in the same
//! cycle, and that one is visible in the next cycle. So a queue of depth 1 is a register.
//!
//! Source: document 001, 3.6.1, 3.6.2, 3.6.5, figures 3.20, 3.24 and 3.26; an iteration a cycle: 4.4.

use std::collections::VecDeque;

use serde::Serialize;

use work::Span;
pub use work::TileWork;

use crate::machines;

/// Configuration of an engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct EngineSettings {
    /// Cycles of Set-up Triangle, at least 1.
    pub set_up_triangle: u64,
    /// Entries of a FIFO between stages, before the broadcast if there is one.
    pub fifo: usize,
    /// Entries of a FIFO after a broadcast.
    pub fifo_after_broadcast: usize,
    /// Draw Triangle stages: every triangle is broadcast to them, and of n each draws every n-th row.
    pub rows: usize,
    /// Draw Span stages of each of them: every span is broadcast to them, and of n each draws every n-th pixel.
    pub columns: usize,
}

impl EngineSettings {
    /// The engine of a description.
    pub fn of(engine: &machines::TileEngine) -> Self {
        Self {
            set_up_triangle: engine.set_up_triangle.whole(),
            fifo: engine.fifo.whole() as usize,
            fifo_after_broadcast: engine.fifo_after_broadcast.whole() as usize,
            rows: engine.interleave.whole() as usize,
            columns: engine.interleave.whole() as usize,
        }
    }
}

/// How the instances of one stage used their cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct StageCounts {
    /// Made a step.
    pub busy: u64,
    /// Had work, but no room for the result.
    pub stalled: u64,
    /// Had no work.
    pub starved: u64,
}

/// What a stage did in one cycle.
#[derive(Clone, Copy)]
enum Step {
    Busy,
    Stalled,
    Starved,
}

impl StageCounts {
    fn count(&mut self, step: Step) {
        match step {
            Step::Busy => self.busy += 1,
            Step::Stalled => self.stalled += 1,
            Step::Starved => self.starved += 1,
        }
    }

    fn plus(self, o: Self) -> Self {
        Self {
            busy: self.busy + o.busy,
            stalled: self.stalled + o.stalled,
            starved: self.starved + o.starved,
        }
    }
}

/// A tile, or the sum of several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct EngineCounts {
    /// Cycles from the first triangle's set-up to the last pixel.
    pub cycles: u64,
    /// Triangles received.
    pub triangles: u64,
    /// Pixels drawn, hidden or not.
    pub pixels: u64,
    /// Set-up Triangle, Draw Triangle, Set-up Span, Draw Span.
    pub stages: [StageCounts; 4],
    /// Largest number of entries of the FIFOs of triangles and of spans, before the broadcast and after it.
    pub fifo_peaks: [usize; 4],
    /// Sum over the cycles of the entries of the FIFOs of triangles and of spans before the broadcast.
    pub fifo_entry_cycles: [u64; 2],
}

impl EngineCounts {
    /// One tile after the other.
    pub fn plus(self, o: Self) -> Self {
        Self {
            cycles: self.cycles + o.cycles,
            triangles: self.triangles + o.triangles,
            pixels: self.pixels + o.pixels,
            stages: std::array::from_fn(|k| self.stages[k].plus(o.stages[k])),
            fifo_peaks: std::array::from_fn(|k| self.fifo_peaks[k].max(o.fifo_peaks[k])),
            fifo_entry_cycles: std::array::from_fn(|k| self.fifo_entry_cycles[k] + o.fifo_entry_cycles[k]),
        }
    }

    /// Cycles a triangle.
    pub fn cycles_per_triangle(&self) -> f64 {
        if self.triangles == 0 { 0.0 } else { self.cycles as f64 / self.triangles as f64 }
    }
}

/// A queue with a depth.
struct Fifo<T> {
    entries: VecDeque<T>,
    depth: usize,
    peak: usize,
}

impl<T: Copy> Fifo<T> {
    fn new(depth: usize) -> Self {
        Self { entries: VecDeque::new(), depth: depth.max(1), peak: 0 }
    }

    fn has_room(&self) -> bool {
        self.entries.len() < self.depth
    }

    fn push(&mut self, entry: T) {
        self.entries.push_back(entry);
        self.peak = self.peak.max(self.entries.len());
    }
}

/// A Draw Span stage and the queue before it.
struct DrawSpan {
    queue: Fifo<Span>,
    left: u32,
}

/// A Draw Triangle stage with the queue before it, its Set-up Span stage and the queue after that.
struct DrawTriangle {
    queue: Fifo<u32>,
    /// Current triangle and its next row.
    current: Option<(u32, usize)>,
    register: Fifo<Span>,
    spans: Fifo<Span>,
    draw_spans: Vec<DrawSpan>,
}

struct Pipeline<'a> {
    settings: EngineSettings,
    work: &'a [TileWork],
    next: usize,
    set_up_left: u64,
    triangles: Fifo<u32>,
    lanes: Vec<DrawTriangle>,
    counts: EngineCounts,
}

/// Runs one tile through an empty engine.
///
/// # Panics
/// If the engine has no Draw Triangle or no Draw Span stage.
pub fn run_tile(settings: EngineSettings, work: &[TileWork]) -> EngineCounts {
    let EngineSettings { rows, columns, .. } = settings;
    assert!(rows > 0 && columns > 0, "an engine has at least one stage of each kind");
    // Without a broadcast the only queue is the one before it.
    let lane = |_| DrawTriangle {
        queue: Fifo::new(if rows == 1 { settings.fifo } else { settings.fifo_after_broadcast }),
        current: None,
        register: Fifo::new(1),
        spans: Fifo::new(settings.fifo),
        draw_spans: (0..columns)
            .map(|_| DrawSpan { queue: Fifo::new(settings.fifo_after_broadcast), left: 0 })
            .collect(),
    };
    let mut pipeline = Pipeline {
        settings: EngineSettings { set_up_triangle: settings.set_up_triangle.max(1), ..settings },
        work,
        next: 0,
        set_up_left: settings.set_up_triangle.max(1),
        triangles: Fifo::new(settings.fifo),
        lanes: (0..rows).map(lane).collect(),
        counts: EngineCounts {
            triangles: work.len() as u64,
            pixels: work.iter().map(TileWork::pixels).sum(),
            ..Default::default()
        },
    };
    while !pipeline.is_done() {
        pipeline.cycle();
    }
    pipeline.finish()
}

impl Pipeline<'_> {
    fn is_done(&self) -> bool {
        let lane_done = |l: &DrawTriangle| {
            l.queue.entries.is_empty()
                && l.current.is_none()
                && l.register.entries.is_empty()
                && l.spans.entries.is_empty()
                && l.draw_spans.iter().all(|d| d.queue.entries.is_empty() && d.left == 0)
        };
        self.next == self.work.len() && self.triangles.entries.is_empty() && self.lanes.iter().all(lane_done)
    }

    fn cycle(&mut self) {
        let EngineSettings { rows, columns, .. } = self.settings;
        for (number, lane) in self.lanes.iter_mut().enumerate() {
            for (column, stage) in lane.draw_spans.iter_mut().enumerate() {
                // Without a broadcast Draw Span takes its spans from the queue after Set-up Span.
                let queue = if columns == 1 { &mut lane.spans } else { &mut stage.queue };
                self.counts.stages[3].count(draw_span(queue, &mut stage.left, column, columns));
            }
            if columns > 1
                && lane.draw_spans.iter().all(|d| d.queue.has_room())
                && let Some(span) = lane.spans.entries.pop_front()
            {
                lane.draw_spans.iter_mut().for_each(|d| d.queue.push(span));
            }
            self.counts.stages[2].count(set_up_span(&mut lane.register, &mut lane.spans));
            let queue = if rows == 1 { &mut self.triangles } else { &mut lane.queue };
            let made = draw_triangle(self.work, queue, &mut lane.current, &mut lane.register, number, rows);
            self.counts.stages[1].count(made);
        }
        if rows > 1
            && self.lanes.iter().all(|l| l.queue.has_room())
            && let Some(triangle) = self.triangles.entries.pop_front()
        {
            self.lanes.iter_mut().for_each(|l| l.queue.push(triangle));
        }
        let made = self.set_up_triangle();
        self.counts.stages[0].count(made);
        self.counts.cycles += 1;
        self.counts.fifo_entry_cycles[0] += self.triangles.entries.len() as u64;
        self.counts.fifo_entry_cycles[1] +=
            self.lanes.iter().map(|l| l.spans.entries.len() as u64).sum::<u64>();
    }

    fn set_up_triangle(&mut self) -> Step {
        let Some(work) = self.work.get(self.next) else { return Step::Starved };
        if self.set_up_left > 1 {
            self.set_up_left -= 1;
            return Step::Busy;
        }
        if !work.spans.is_empty() {
            if !self.triangles.has_room() {
                return Step::Stalled;
            }
            self.triangles.push(self.next as u32);
        }
        self.next += 1;
        self.set_up_left = self.settings.set_up_triangle;
        Step::Busy
    }

    fn finish(self) -> EngineCounts {
        let most = |peaks: &mut dyn Iterator<Item = usize>| peaks.max().unwrap_or(0);
        EngineCounts {
            fifo_peaks: [
                self.triangles.peak,
                most(&mut self.lanes.iter().map(|l| l.queue.peak)),
                most(&mut self.lanes.iter().map(|l| l.spans.peak)),
                most(&mut self.lanes.iter().flat_map(|l| l.draw_spans.iter().map(|d| d.queue.peak))),
            ],
            ..self.counts
        }
    }
}

/// One pixel of the columns with remainder `column`; a span without any costs the cycle in which it is taken.
fn draw_span(queue: &mut Fifo<Span>, left: &mut u32, column: usize, step: usize) -> Step {
    if *left == 0 {
        let Some(span) = queue.entries.pop_front() else { return Step::Starved };
        *left = span.pixels(column, step);
    }
    *left = left.saturating_sub(1);
    Step::Busy
}

/// Clips a span; an empty one is dropped.
fn set_up_span(register: &mut Fifo<Span>, spans: &mut Fifo<Span>) -> Step {
    let Some(&span) = register.entries.front() else { return Step::Starved };
    if span.pixels(0, 1) > 0 {
        if !spans.has_room() {
            return Step::Stalled;
        }
        spans.push(span);
    }
    register.entries.pop_front();
    Step::Busy
}

/// One row of those with remainder `lane`; a triangle without any costs the cycle in which it is taken.
fn draw_triangle(
    work: &[TileWork],
    queue: &mut Fifo<u32>,
    current: &mut Option<(u32, usize)>,
    register: &mut Fifo<Span>,
    lane: usize,
    step: usize,
) -> Step {
    let (triangle, row) = match *current {
        Some(at) => at,
        None => {
            let Some(triangle) = queue.entries.pop_front() else { return Step::Starved };
            let first = work[triangle as usize].first_row;
            (triangle, (lane as i32 - first).rem_euclid(step as i32) as usize)
        }
    };
    let spans = &work[triangle as usize].spans;
    let Some(&span) = spans.get(row) else {
        *current = None;
        return Step::Busy;
    };
    if !register.has_room() {
        *current = Some((triangle, row));
        return Step::Stalled;
    }
    register.push(span);
    let next = row + step;
    *current = (next < spans.len()).then_some((triangle, next));
    Step::Busy
}

#[cfg(test)]
mod tests;
mod work;
