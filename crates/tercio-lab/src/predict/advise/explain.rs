//! The advice in words.

use std::collections::BTreeSet;

use tercio_parallel::{Composition, Organisation};

use super::splits::{EVERY, MOST_BY_FORMULAS, Split};
use super::{Advice, Candidate, Frame, How, Uncertainty};
use crate::predict::choose::candidates::MANY;
use crate::predict::choose::parts_of;
use crate::predict::difference::named;
use crate::words::counted;

/// Splits that are listed; more are counted.
const LISTED: usize = 12;

/// What [`others`] compares.
pub struct Line {
    /// Of several of the same class only the first is shown.
    pub class: &'static str,
    /// Seconds.
    pub seconds: f64,
    /// Whether they are a formula's estimate instead of a count.
    pub is_estimate: bool,
    /// In words.
    pub words: String,
}

impl Candidate {
    /// In words.
    pub fn describe(&self) -> String {
        let Split { ranks, threads } = self.split;
        match self.how {
            How::OneProcess { region } => {
                format!("threads, {threads} of one process, tiles of {region} pixels")
            }
            How::Ranks { sharing, region } => {
                let (group, division, composition) = parts_of(&sharing, ranks);
                let mut text = sharing.organisation.name().to_string();
                let mut add = |part: Option<String>| text.extend(part.map(|part| format!(", {part}")));
                add(group.map(|group| format!("groups of {group}")));
                add(division.map(|division| division.to_string()));
                add(composition.map(|composition| match composition {
                    Composition::RadixK(radices) => format!("radix-k of {radices}"),
                    other => other.to_string(),
                }));
                add(region.map(|region| format!("tiles of {region} pixels")));
                let threads = counted(threads as u64, "thread", "threads");
                format!("{text}, {ranks} ranks of {threads}")
            }
        }
    }

    fn class(&self) -> &'static str {
        match self.how {
            How::OneProcess { .. } => "threads",
            How::Ranks { sharing, .. } => match sharing.organisation {
                Organisation::SortTwice { .. } => "sort-twice",
                other => other.name(),
            },
        }
    }

    /// Seconds of parts that all models have.
    pub fn parts(&self) -> [(&'static str, f64); 5] {
        let seconds = match &self.frame {
            Frame::Threads(time) => [time.front_end, 0.0, time.total() - time.front_end, 0.0, 0.0],
            Frame::Counted(frame) => {
                let [divide, draw, compose, collect, messages, waiting, queueing] =
                    frame.phases().map(|phase| phase.1);
                [divide, messages + waiting + queueing, draw, compose, collect]
            }
            Frame::Formulas { terms, .. } => {
                [terms.front_end, terms.exchange, terms.draw, terms.composite, terms.collect]
            }
        };
        let names = ["the front end", "exchanging and waiting", "drawing", "compositing", "collecting"];
        std::array::from_fn(|k| (names[k], seconds[k]))
    }
}

impl Advice {
    /// Why the first one is the fastest, what was compared, how sure that is, and what limits the best of each other class.
    pub fn explanation(&self) -> Vec<String> {
        let Some(best) = self.candidates.first() else { return Vec::new() };
        let mut lines = vec![self.why(best), self.searched(), self.not_searched(), self.how_sure(best)];
        let line = |c: &Candidate| Line {
            class: c.class(),
            seconds: c.frame.total(),
            is_estimate: !c.frame.is_counted(),
            words: c.describe(),
        };
        let all: Vec<Line> = self.candidates.iter().map(line).collect();
        lines.extend(others(&all, |k| self.candidates[k].parts().to_vec()));
        lines
    }

    fn why(&self, best: &Candidate) -> String {
        let parts = best.parts().map(|(name, seconds)| format!("{name} {}", milliseconds(seconds)));
        let detail = match &best.frame {
            Frame::Threads(time) => format!("busiest over mean thread {:.2}", time.imbalance),
            Frame::Counted(frame) => {
                let memory = frame.memory.total();
                let (bytes, messages) = (frame.bytes, frame.messages);
                format!("{bytes} bytes in {messages} messages; {memory} bytes in the rank that needs most")
            }
            Frame::Formulas { sent, .. } => {
                format!("about {:.0} bytes in {:.0} messages", sent.bytes, sent.messages)
            }
        };
        let mut text = format!(
            "{} is fastest of the {} candidates, {} a frame ({}): {}; {detail}",
            best.describe(),
            self.candidates.len(),
            milliseconds(best.frame.total()),
            best.frame.model(),
            parts.join(", ")
        );
        let counted = self.candidates.iter().find(|candidate| candidate.frame.is_counted());
        if let Some(counted) = counted.filter(|_| !best.frame.is_counted()) {
            text += &format!(
                "; no model counts it, and the fastest that is counted is {}, {}",
                counted.describe(),
                milliseconds(counted.frame.total())
            );
        }
        text
    }

    /// What was compared.
    fn searched(&self) -> String {
        let one = |c: &&Candidate| matches!(c.how, How::OneProcess { .. });
        let threads = self.candidates.iter().filter(one).map(|c| c.split.threads);
        let threads: BTreeSet<usize> = threads.collect();
        let threads = match threads.last() {
            Some(1) => "1 thread".to_owned(),
            Some(most) if threads.len() > LISTED => format!("1 to {most} threads"),
            _ => threads.iter().map(usize::to_string).collect::<Vec<_>>().join(", ") + " threads",
        };
        let ranks: BTreeSet<Split> = self.candidates.iter().filter(|c| !one(c)).map(|c| c.split).collect();
        let of_threads = format!(
            "compared are {} ways to use threads of one process ({threads}, tiles of 8 to 128 pixels)",
            self.candidates.iter().filter(one).count()
        );
        if ranks.is_empty() {
            return of_threads;
        }
        let list = if ranks.len() > LISTED {
            let most = ranks.iter().map(|s| s.processors()).max().unwrap_or(0);
            format!("{} splits of 2 to {most} processors into ranks and threads", ranks.len())
        } else {
            let all: Vec<_> = ranks.iter().map(|s| format!("{} x {}", s.ranks, s.threads)).collect();
            format!("ranks x threads {}", all.join(", "))
        };
        format!(
            "{of_threads}, and {} ways to share a frame ({list}; every organisation, division, group and composition, of more than 16 \
             ranks not every group and radix, of more than {MANY} fewer groups and divisions)",
            self.candidates.iter().filter(|c| !one(c)).count()
        )
    }

    /// What was not, and why.
    fn not_searched(&self) -> String {
        let of_splits = match self.left_out {
            0 => String::new(),
            n => format!(
                "; {n} splits of more than {MOST_BY_FORMULAS} ranks: the formulas would take too long"
            ),
        };
        format!(
            "not compared are other tiles of ranks than the renderer chooses, except for the best if its ranks are counted: the formulas \
             do not know what small tiles cost; of more than {EVERY} processors other numbers than powers of two, the middles between them \
             and whole nodes{of_splits}; --parts: whole models are \
             counted; --sorting, which is as requested; --simd, --binning and --no-cluster-culling, which serve comparisons"
        )
    }

    fn how_sure(&self, best: &Candidate) -> String {
        let range = |[fast, slow]: [f64; 2]| format!("{} to {}", milliseconds(fast), milliseconds(slow));
        let Some([low, high]) = self.interval(best) else {
            let assumed = best.assumed.map_or_else(String::new, |ends| {
                format!("; by what is assumed of the machine's numbers alone it takes {}", range(ends))
            });
            return format!(
                "neither the machine nor one whose costs it has was calibrated: its predictions have no stated uncertainty{assumed}"
            );
        };
        let like = self.candidates.iter().skip(1).filter(|c| self.is_like_the_best(c) == Some(true)).count();
        let most = if high.is_finite() { format!(" to {}", milliseconds(high)) } else { " or more".into() };
        let whose = match &self.uncertainty {
            Some(Uncertainty { is_assumed: true, residual, .. }) => {
                format!("residuals of its costs that are assumed ({:.1} %)", residual * 100.0)
            }
            Some(Uncertainty { costs_of: Some(name), .. }) => format!("the residuals of its costs on {name}"),
            _ => "the residuals of the machine's costs".to_owned(),
        };
        let of = match &best.frame {
            Frame::Threads(_) => whose,
            Frame::Counted(_) | Frame::Formulas { .. } => {
                format!("the measured error of ranks, or {whose} if larger,")
            }
        };
        let of = match best.assumed {
            None => of,
            Some(ends) => {
                format!("{of} and what is assumed of the machine's numbers (alone {})", range(ends))
            }
        };
        format!(
            "by {of} it takes {}{most}; {like} of the others are not to be told apart from it",
            milliseconds(low)
        )
    }
}

/// Seconds as text.
pub fn milliseconds(seconds: f64) -> String {
    format!("{:.3} ms", seconds * 1e3)
}

/// The part with the most seconds.
pub fn longest(phases: &[(&'static str, f64)]) -> (&'static str, f64) {
    phases.iter().copied().fold(phases[0], |best, p| if p.1 > best.1 { p } else { best })
}

/// The least milliseconds that are shown.
const SHOWN: f64 = 0.001;

/// The best of each class except the first, with the parts in which it loses and gains, the largest first, as many as
/// [`named`] has it.
pub fn others(lines: &[Line], parts: impl Fn(usize) -> Vec<(&'static str, f64)>) -> Vec<String> {
    let Some(best) = lines.first() else { return Vec::new() };
    let (mut texts, mut seen, ours) = (Vec::new(), vec![best.class], parts(0));
    for (k, Line { class, seconds, is_estimate, words }) in lines.iter().enumerate() {
        if seen.contains(class) {
            continue;
        }
        seen.push(*class);
        let mut text =
            format!("{words} takes {:.2} times as long, {}", seconds / best.seconds, milliseconds(*seconds));
        text += match (best.is_estimate, is_estimate) {
            (true, false) => " as counted, if the formulas are right about the first",
            (false, true) => " if the formulas are right about it",
            _ => "",
        };
        let parts = parts(k).into_iter().zip(&ours);
        let mut more: Vec<_> = parts.map(|(theirs, ours)| (theirs.0, (theirs.1 - ours.1) * 1e3)).collect();
        more.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let sizes: Vec<f64> = more.iter().map(|part| part.1).collect();
        let of_part = |part: &(&str, f64)| format!("{} {:+.3} ms", part.0, part.1);
        let list: Vec<_> = more[..named(&sizes, SHOWN)].iter().map(of_part).collect();
        if !list.is_empty() {
            text += &format!(": {:+.3} ms, made up of {}", (seconds - best.seconds) * 1e3, list.join(", "));
        }
        texts.push(text);
    }
    texts
}
