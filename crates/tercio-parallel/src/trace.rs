//! When each rank did what: a recording of frames, in the trace event format of Chrome, which its `about:tracing` and Perfetto
//! show.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

pub use crate::clock::now;

/// A step of a rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Step {
    /// Loading the model.
    Load,
    /// Comparing the ranks' tasks, and waiting for each other before that.
    Agree,
    /// The front end: culling, and sorting into tiles.
    FrontEnd,
    /// Dividing the picture; writing and reading bins.
    Redistribute,
    /// The back end; without ranks, the whole frame.
    Draw,
    /// Packing pixels or fragments for other owners, and merging theirs.
    Composite,
    /// Packing finished pixels for rank 0; there, unpacking them.
    Collect,
    /// Waiting for messages, or for the others at the beginning of a frame.
    Wait,
    /// Sending the counts and times of a frame to rank 0; there, receiving them.
    Report,
}

impl Step {
    /// The name in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Load => "load",
            Self::Agree => "agree",
            Self::FrontEnd => "front end",
            Self::Redistribute => "redistribute",
            Self::Draw => "draw",
            Self::Composite => "composite",
            Self::Collect => "collect",
            Self::Wait => "wait",
            Self::Report => "report",
        }
    }
}

/// A piece of time, in nanoseconds of [the clock](now).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Span {
    /// Its beginning.
    pub begin: u64,
    /// Its end.
    pub end: u64,
}

impl Span {
    /// From then until now.
    pub fn since(begin: u64) -> Self {
        Self { begin, end: now() }
    }
}

/// What a rank did in a piece of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Event {
    /// What it did.
    pub step: Step,
    /// The number of the frame, from 1; 0 outside of frames.
    pub frame: u32,
    /// When.
    #[serde(flatten)]
    pub span: Span,
}

/// What one rank did.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Timeline {
    /// In any order.
    pub events: Vec<Event>,
}

impl Timeline {
    /// Adds what the rank did.
    pub fn add(&mut self, step: Step, frame: u32, span: Span) {
        self.events.push(Event { step, frame, span });
    }

    /// Counts frames from the one after this one.
    pub(crate) fn count_frames_from(&mut self, drawn_before: u32) {
        for event in self.events.iter_mut().filter(|event| event.frame > 0) {
            event.frame = event.frame.wrapping_sub(drawn_before);
        }
    }

    /// Moves the clock of all events back by this many nanoseconds.
    pub(crate) fn shift(&mut self, back: i64) {
        for Event { span, .. } in &mut self.events {
            // A clock that began later than that of rank 0 may get below zero.
            for time in [&mut span.begin, &mut span.end] {
                *time = time.saturating_add_signed(back.saturating_neg());
            }
        }
    }
}

/// Runs work, and notes it in a timeline if there is one.
pub(crate) fn timed<T>(
    timeline: &mut Option<Timeline>,
    step: Step,
    frame: u32,
    work: impl FnOnce() -> T,
) -> T {
    let Some(timeline) = timeline else { return work() };
    let begin = now();
    let result = work();
    timeline.add(step, frame, Span::since(begin));
    result
}

/// What all ranks did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trace {
    /// Every rank, in order.
    pub ranks: Vec<Timeline>,
}

impl Trace {
    /// What a single rank did in its first frame.
    pub fn of_one(step: Step, span: Span) -> Self {
        let mut trace = Self::default();
        trace.add(0, step, 1, span);
        trace
    }

    /// Adds what a rank did.
    pub fn add(&mut self, rank: usize, step: Step, frame: u32, span: Span) {
        self.ranks.resize_with(self.ranks.len().max(rank + 1), Timeline::default);
        self.ranks[rank].add(step, frame, span);
    }

    /// Adds what the ranks did in further frames, which get the numbers after those that are there.
    pub fn append(&mut self, further: Self) {
        let frames = self.ranks.iter().flat_map(|rank| &rank.events).map(|event| event.frame);
        let before = frames.max().unwrap_or(0);
        self.ranks.resize_with(self.ranks.len().max(further.ranks.len()), Timeline::default);
        for (rank, theirs) in further.ranks.into_iter().enumerate() {
            for Event { step, frame, span } in theirs.events {
                let frame = if frame == 0 { 0 } else { frame.saturating_add(before) };
                self.add(rank, step, frame, span);
            }
        }
    }

    /// Chrome's trace event format: each rank is a process, each step a complete event; times are in microseconds since the
    /// first event.
    pub fn json(&self) -> Value {
        let all = self.ranks.iter().flat_map(|rank| &rank.events);
        let first = all.map(|event| event.span.begin).min().unwrap_or(0);
        let mut events = Vec::new();
        for (rank, timeline) in self.ranks.iter().enumerate() {
            let name = format!("rank {rank}");
            events.push(
                json!({ "name": "process_name", "ph": "M", "pid": rank, "tid": 0, "args": { "name": name } }),
            );
            events.push(
                json!({ "name": "process_sort_index", "ph": "M", "pid": rank, "tid": 0, "args": { "sort_index": rank } }),
            );
            let mut of_rank = timeline.events.clone();
            of_rank.sort_by_key(|event| (event.span.begin, event.span.end));
            for Event { step, frame, span } in of_rank {
                events.push(json!({
                    "name": step.name(),
                    "cat": "tercio",
                    "ph": "X",
                    "pid": rank,
                    "tid": 0,
                    "ts": span.begin.saturating_sub(first) as f64 / 1e3,
                    "dur": span.end.saturating_sub(span.begin) as f64 / 1e3,
                    "args": { "frame": frame },
                }));
            }
        }
        json!({ "traceEvents": events, "displayTimeUnit": "ms" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_has_a_process_for_each_rank_and_times_since_the_first_event() {
        let mut trace = Trace::default();
        let of =
            |step, begin, end| Timeline { events: vec![Event { step, frame: 1, span: Span { begin, end } }] };
        trace.append(Trace {
            ranks: vec![of(Step::Draw, 5_000_000, 7_500_000), of(Step::Wait, 4_000_000, 4_000_500)],
        });
        trace.append(Trace { ranks: vec![of(Step::FrontEnd, 4_500_000, 5_000_000)] });
        let json = trace.json();
        let events = json["traceEvents"].as_array().expect("events");
        let complete: Vec<_> = events
            .iter()
            .filter(|event| event["ph"] == "X")
            .map(|event| {
                let time = |key: &str| event[key].as_f64().expect("microseconds");
                let frame = event["args"]["frame"].as_u64();
                (event["pid"].as_u64(), event["name"].as_str(), frame, time("ts"), time("dur"))
            })
            .collect();
        let expected = [
            (Some(0), Some("front end"), Some(2), 500.0, 500.0),
            (Some(0), Some("draw"), Some(1), 1000.0, 2500.0),
            (Some(1), Some("wait"), Some(1), 0.0, 0.5),
        ];
        assert_eq!(complete, expected);
        let names = events.iter().filter(|event| event["name"] == "process_name");
        let names: Vec<_> = names.map(|event| event["args"]["name"].as_str()).collect();
        assert_eq!(names, [Some("rank 0"), Some("rank 1")]);
    }

    #[test]
    fn the_clock_of_a_timeline_is_moved() {
        let mut timeline = Timeline::default();
        timeline.add(Step::Draw, 1, Span { begin: 100, end: 130 });
        timeline.shift(-20);
        assert_eq!(timeline.events[0].span, Span { begin: 120, end: 150 });
        timeline.shift(130);
        assert_eq!(timeline.events[0].span, Span { begin: 0, end: 20 });
    }
}
