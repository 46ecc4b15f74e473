//! Simulates when ranks work, wait and end: their steps on processors and on the network.
//!
//! A rank runs until it has to wait for a message. If there are more ranks than processors, the ready ones wait in a
//! queue, and a rank whose time slice has expired goes to its end, like threads of equal priority in an operating
//! system. Ranks that poll while they wait stay on their processors, each with a queue of its own: to the system, all
//! processors are busy, and nothing is to be moved. A message leaves when its sender's port is free, crosses the network
//! and enters when its receiver's port is free.

use std::collections::VecDeque;

/// Seconds after which a rank gives its processor up if others wait for it: about the time slice of Linux.
const SLICE: f64 = 3e-3;

/// The stages of a rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Drawing its share.
    Draw,
    /// Packing what is composited, merging what it receives.
    Compose,
    /// Packing for rank 0, unpacking there.
    Collect,
    /// Sending and receiving messages, whatever their content.
    Message,
    /// Estimating the work in all tiles, and dividing them.
    Divide,
}

/// A step of a rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Computes for a number of seconds.
    Work(Stage, f64),
    /// Sends a message of a number of bytes.
    Send {
        /// The receiving rank.
        to: usize,
        /// Its size.
        bytes: u64,
    },
    /// Receives the next message of a rank, and waits for it if necessary.
    Take {
        /// The sending rank.
        from: usize,
    },
}

/// The network.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wires {
    /// Latency in seconds.
    pub latency: f64,
    /// Bandwidth of a rank's port in bytes a second; infinite if messages are handed over in one memory.
    pub bandwidth: f64,
    /// How a rank that waits notices a message.
    pub noticed: Noticed,
}

/// How a rank that waits notices a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noticed {
    /// The arrival wakes it, which takes so many seconds.
    Woken(f64),
    /// It polls, from some time on at intervals between which it sleeps. Each time it wakes up, it takes so many seconds of its
    /// processor from a rank that works there.
    Polling(f64),
}

/// How a process waits (`tercio-mpi`): it polls for `AWAKE` seconds, then sleeps repeatedly, each time for the share
/// `SLEEPS` of the time it has waited, at most `LONGEST` seconds; the system lets it sleep about `LONGER` seconds
/// longer.
const AWAKE: f64 = 200e-6;
const SLEEPS: f64 = 1.0 / 16.0;
const LONGEST: f64 = 2e-3;
const LONGER: f64 = 50e-6;

/// The longest time for which the share of a processor that polling ranks take is the same, until all of their sleeps have the same length.
const STEP: f64 = 100e-6;

/// How often a second a process that has waited for so many seconds wakes up to poll.
fn naps_per_second(waited: f64) -> f64 {
    if waited < AWAKE { 0.0 } else { 1.0 / ((waited * SLEEPS).min(LONGEST) + LONGER) }
}

/// When a process that sleeps finds a message, in seconds since it began to wait.
fn found(arrives: f64) -> f64 {
    if arrives <= AWAKE {
        return arrives;
    }
    let mut wakes = AWAKE;
    while wakes < arrives && wakes * SLEEPS < LONGEST {
        wakes += wakes * SLEEPS + LONGER;
    }
    // From then on all sleeps have the same length.
    wakes + ((arrives - wakes) / (LONGEST + LONGER)).ceil().max(0.0) * (LONGEST + LONGER)
}

/// The result of a rank.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Played {
    /// Seconds of its work, by [`Stage`], as actually spent.
    pub busy: [f64; 5],
    /// Seconds it waited for messages.
    pub waited: f64,
    /// Seconds it waited for a processor.
    pub queued: f64,
    /// The time of its end.
    pub end: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Ready { since: f64 },
    Running { slice: f64 },
    Waiting { since: f64, from: usize },
    Done,
}

struct Play<'a> {
    programs: &'a [Vec<Step>],
    wires: Wires,
    processors: usize,
    now: f64,
    /// For each rank: the number of its step, and the seconds left of it.
    at: Vec<(usize, f64)>,
    states: Vec<State>,
    line: VecDeque<usize>,
    /// Arrival times of messages, for each sender and receiver.
    arrivals: Vec<VecDeque<f64>>,
    /// When each rank notices the message that it waits for; infinite if none is on its way.
    learns: Vec<f64>,
    leaving: Vec<f64>,
    entering: Vec<f64>,
    played: Vec<Played>,
}

/// Simulates the programs of all ranks on `processors` processors, at least 1. A rank that waits for a message that is
/// never sent stays there.
pub fn play(programs: &[Vec<Step>], processors: usize, wires: Wires) -> Vec<Played> {
    let n = programs.len();
    let mut play = Play {
        programs,
        wires,
        processors: processors.max(1),
        now: 0.0,
        at: vec![(0, 0.0); n],
        states: vec![State::Ready { since: 0.0 }; n],
        line: (0..n).collect(),
        arrivals: vec![VecDeque::new(); n * n],
        learns: vec![f64::INFINITY; n],
        leaving: vec![0.0; n],
        entering: vec![0.0; n],
        played: vec![Played::default(); n],
    };
    (0..n).for_each(|rank| play.begin_step(rank));
    while play.turn() {}
    play.played
}

impl Play<'_> {
    /// Starts the current step of a rank.
    fn begin_step(&mut self, rank: usize) {
        self.at[rank].1 = match self.programs[rank].get(self.at[rank].0) {
            Some(Step::Work(_, seconds)) => *seconds,
            _ => 0.0,
        };
    }

    /// Advances the time to the next event. False if there is none.
    fn turn(&mut self) -> bool {
        while let Some(rank) = self.next_in_line() {
            if let State::Ready { since } = self.states[rank] {
                self.played[rank].queued += self.now - since;
            }
            self.states[rank] = State::Running { slice: SLICE };
            self.go_on(rank);
        }
        let running = self.running();
        let mut next = f64::INFINITY;
        for &rank in &running {
            next = next.min(self.at[rank].1 / self.pace(rank));
            if let State::Running { slice } = self.states[rank]
                && self.line.iter().any(|&other| self.home(other) == self.home(rank))
            {
                next = next.min(slice);
            }
        }
        let learns = self.learns.iter().copied().fold(f64::INFINITY, f64::min);
        next = next.min((learns - self.now).max(0.0));
        if next.is_infinite() {
            return false;
        }
        if running.iter().any(|&rank| self.pace_changes(rank)) {
            next = next.min(STEP);
        }
        let paces: Vec<f64> = running.iter().map(|&rank| self.pace(rank)).collect();
        self.now += next;
        for (&rank, pace) in running.iter().zip(paces) {
            self.pass(rank, next, pace);
        }
        for rank in 0..self.states.len() {
            if self.learns[rank] > self.now {
                continue;
            }
            if let State::Waiting { since, .. } = self.states[rank] {
                self.learns[rank] = f64::INFINITY;
                self.played[rank].waited += self.now - since;
                self.states[rank] = State::Ready { since: self.now };
                self.line.push_back(rank);
            }
        }
        true
    }

    /// The processor that a rank stays on, if it does.
    fn home(&self, rank: usize) -> Option<usize> {
        matches!(self.wires.noticed, Noticed::Polling(_)).then_some(rank % self.processors)
    }

    /// Do ranks that poll take time from others?
    fn share_processors(&self) -> bool {
        matches!(self.wires.noticed, Noticed::Polling(nap) if nap > 0.0)
            && self.states.len() > self.processors
    }

    /// How long each rank has waited that polls on the processor of a running one.
    fn polling_beside(&self, rank: usize) -> impl Iterator<Item = f64> {
        self.states.iter().enumerate().filter_map(move |(other, state)| match *state {
            State::Waiting { since, .. } if self.home(other) == self.home(rank) => Some(self.now - since),
            _ => None,
        })
    }

    /// The share of a processor that a running rank has.
    fn pace(&self, rank: usize) -> f64 {
        let Noticed::Polling(nap) = self.wires.noticed else { return 1.0 };
        if !self.share_processors() {
            return 1.0;
        }
        1.0 / (1.0 + nap * self.polling_beside(rank).map(naps_per_second).sum::<f64>())
    }

    /// Whether that share changes before anything happens.
    fn pace_changes(&self, rank: usize) -> bool {
        self.share_processors() && self.polling_beside(rank).any(|waited| waited * SLEEPS < LONGEST)
    }

    /// Takes the first rank out of the queue for which a processor is free.
    fn next_in_line(&mut self) -> Option<usize> {
        if self.line.is_empty() {
            return None;
        }
        let running = self.running();
        let is_free = |home: Option<usize>| match home {
            Some(_) => running.iter().all(|&rank| self.home(rank) != home),
            None => running.len() < self.processors,
        };
        let at = self.line.iter().position(|&rank| is_free(self.home(rank)))?;
        self.line.remove(at)
    }

    fn running(&self) -> Vec<usize> {
        let is_running = |&rank: &usize| matches!(self.states[rank], State::Running { .. });
        (0..self.states.len()).filter(is_running).collect()
    }

    /// Computes when a rank notices the message that it waits for, if that is on its way.
    fn expect(&mut self, rank: usize) {
        let State::Waiting { since, from } = self.states[rank] else { return };
        if let Some(&arrival) = self.arrivals[from * self.states.len() + rank].front() {
            self.learns[rank] = match self.wires.noticed {
                Noticed::Polling(_) => since + found(arrival - since),
                Noticed::Woken(seconds) => arrival + seconds,
            };
        }
    }

    /// A running rank computes for `seconds`, of which it has the share `pace` of its processor.
    fn pass(&mut self, rank: usize, seconds: f64, pace: f64) {
        let State::Running { slice } = self.states[rank] else { return };
        let (step, left) = self.at[rank];
        if let Some(Step::Work(stage, _)) = self.programs[rank].get(step) {
            self.played[rank].busy[*stage as usize] += seconds * pace;
            self.played[rank].queued += seconds * (1.0 - pace);
        }
        let left = left - seconds * pace;
        // A remainder from rounding is no work.
        if left <= 1e-15 {
            self.at[rank].0 += 1;
            self.begin_step(rank);
            self.states[rank] = State::Running { slice: slice - seconds };
            self.go_on(rank);
        } else {
            self.at[rank].1 = left;
            self.states[rank] = State::Running { slice: slice - seconds };
        }
        if let State::Running { slice } = self.states[rank]
            && slice <= 1e-12
        {
            self.states[rank] = State::Ready { since: self.now };
            self.line.push_back(rank);
        }
    }

    /// Does all steps of a running rank that take no time.
    fn go_on(&mut self, rank: usize) {
        let n = self.states.len();
        loop {
            let (step, left) = self.at[rank];
            match self.programs[rank].get(step).copied() {
                None => {
                    self.states[rank] = State::Done;
                    self.played[rank].end = self.now;
                    return;
                }
                Some(Step::Work(..)) if left > 0.0 => return,
                Some(Step::Work(..)) => {}
                Some(Step::Send { to, bytes }) => {
                    let seconds = bytes as f64 / self.wires.bandwidth;
                    let leaves = self.now.max(self.leaving[rank]);
                    self.leaving[rank] = leaves + seconds;
                    let arrives = (leaves + self.wires.latency).max(self.entering[to]) + seconds;
                    self.entering[to] = arrives;
                    self.arrivals[rank * n + to].push_back(arrives);
                    self.expect(to);
                }
                Some(Step::Take { from }) => {
                    let arrivals = &mut self.arrivals[from * n + rank];
                    if arrivals.front().is_none_or(|&arrival| arrival > self.now) {
                        self.states[rank] = State::Waiting { since: self.now, from };
                        self.expect(rank);
                        return;
                    }
                    arrivals.pop_front();
                }
            }
            self.at[rank].0 += 1;
            self.begin_step(rank);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const APART: usize = 99;
    const AT_ONCE: Wires = Wires { latency: 0.0, bandwidth: f64::INFINITY, noticed: Noticed::Woken(0.0) };

    fn ends(programs: &[Vec<Step>], processors: usize, wires: Wires) -> Vec<f64> {
        play(programs, processors, wires).iter().map(|p| (p.end * 1e9).round() / 1e9).collect()
    }

    fn work(seconds: f64) -> Step {
        Step::Work(Stage::Draw, seconds)
    }

    #[test]
    fn ranks_share_processors_in_turn() {
        // Shorter than a slice: one after another.
        let short = vec![vec![work(1e-3)], vec![work(2e-3)], vec![work(1e-3)]];
        assert_eq!(ends(&short, APART, AT_ONCE), [1e-3, 2e-3, 1e-3]);
        assert_eq!(ends(&short, 1, AT_ONCE), [1e-3, 3e-3, 4e-3]);
        assert_eq!(ends(&short, 2, AT_ONCE), [1e-3, 2e-3, 2e-3]);
        // Longer: 3 ms each in turn.
        let long = vec![vec![work(7e-3)], vec![work(4e-3)]];
        let played = play(&long, 1, AT_ONCE);
        assert_eq!(ends(&long, 1, AT_ONCE), [11e-3, 10e-3]);
        assert!((played[0].queued - 4e-3).abs() < 1e-12, "{played:?}");
        assert!((played[0].busy[0] - 7e-3).abs() < 1e-12, "{played:?}");
    }

    #[test]
    fn ranks_wait_for_messages() {
        let send = Step::Send { to: 0, bytes: 100 };
        let programs = vec![vec![work(1.0), Step::Take { from: 1 }, work(1.0)], vec![work(3.0), send]];
        assert_eq!(ends(&programs, APART, AT_ONCE), [4.0, 3.0]);
        let slow = Wires { latency: 0.5, bandwidth: 50.0, noticed: Noticed::Woken(0.0) };
        assert_eq!(ends(&programs, APART, slow), [3.0 + 0.5 + 2.0 + 1.0, 3.0]);
        assert!((play(&programs, APART, slow)[0].waited - 4.5).abs() < 1e-12);
    }

    #[test]
    fn ranks_that_poll_stay_on_their_processors() {
        let polling = Wires { noticed: Noticed::Polling(0.0), ..AT_ONCE };
        // Ranks 0 and 2 have one processor, ranks 1 and 3 the other.
        let programs = [vec![work(2e-3)], vec![work(1e-3)], vec![work(2e-3)], vec![work(1e-3)]];
        assert_eq!(ends(&programs, 2, polling), [2e-3, 1e-3, 4e-3, 2e-3]);
        assert_eq!(ends(&programs, 2, AT_ONCE), [2e-3, 1e-3, 3e-3, 3e-3]);
    }

    #[test]
    fn a_rank_that_polls_takes_time_from_one_that_works() {
        let send = Step::Send { to: 0, bytes: 100 };
        let programs = [vec![Step::Take { from: 1 }], vec![work(4e-3), send]];
        let end = |nap: f64, processors: usize| {
            play(&programs, processors, Wires { noticed: Noticed::Polling(nap), ..AT_ONCE })[1]
        };
        // With a processor of its own, and where waking up takes no time, it takes none.
        assert!((end(20e-6, 2).end - 4e-3).abs() < 1e-12 && (end(0.0, 1).end - 4e-3).abs() < 1e-12);
        // From 0.2 ms on it wakes up, first every 62 us, after 4 ms every 300 us.
        let shared = end(20e-6, 1);
        let naps: f64 = (2..40).map(|k| 100e-6 * naps_per_second(f64::from(k) * 100e-6)).sum();
        let taken = shared.end - 4e-3;
        // While it takes time, less work is done.
        assert!(taken > 0.85 * 20e-6 * naps && taken < 20e-6 * naps, "{taken} {naps}");
        assert!((shared.busy[0] - 4e-3).abs() < 1e-12 && (shared.queued - taken).abs() < 1e-12, "{shared:?}");
        // Work of any length is played at once, in the end with sleeps of the same length.
        let programs = [vec![Step::Take { from: 1 }], vec![work(1e6), Step::Send { to: 0, bytes: 100 }]];
        let long = play(&programs, 1, Wires { noticed: Noticed::Polling(20e-6), ..AT_ONCE })[1].end;
        assert!((long / 1e6 - (1.0 + 20e-6 / (LONGEST + LONGER))).abs() < 1e-6, "{long}");
    }

    #[test]
    fn an_arrival_wakes_a_rank_that_waits() {
        let send = Step::Send { to: 0, bytes: 100 };
        let woken = Wires { noticed: Noticed::Woken(0.25), ..AT_ONCE };
        let end = |before: f64| {
            ends(&[vec![work(before), Step::Take { from: 1 }], vec![work(1.0), send]], APART, woken)
        };
        // One that does not wait yet takes the message at once.
        assert_eq!([end(0.5)[0], end(2.0)[0]], [1.25, 2.0]);
    }

    #[test]
    fn a_rank_that_sleeps_finds_a_message_later() {
        let send = Step::Send { to: 0, bytes: 100 };
        let waits = |seconds: f64| {
            let programs = [vec![Step::Take { from: 1 }, work(1e-3)], vec![work(seconds), send]];
            ends(&programs, APART, Wires { noticed: Noticed::Polling(0.0), ..AT_ONCE })[0]
        };
        assert_eq!(waits(150e-6), 1150e-6);
        // It wakes after 200, 262.5 and 328.906 us.
        assert_eq!([waits(210e-6), waits(262e-6), waits(263e-6)], [1262.5e-6, 1262.5e-6, 1_328_906e-9]);
        assert!((0.3..0.3021).contains(&(waits(0.3) - 1e-3)));
    }

    #[test]
    fn a_port_passes_one_message_after_another() {
        let send = Step::Send { to: 0, bytes: 100 };
        let takes = vec![Step::Take { from: 1 }, Step::Take { from: 2 }];
        let wires = Wires { latency: 0.0, bandwidth: 100.0, noticed: Noticed::Woken(0.0) };
        assert_eq!(ends(&[takes, vec![send], vec![send]], APART, wires), [2.0, 0.0, 0.0]);
        let both = vec![send, Step::Send { to: 2, bytes: 100 }];
        let programs = [vec![Step::Take { from: 1 }], both, vec![Step::Take { from: 1 }]];
        assert_eq!(ends(&programs, APART, wires), [1.0, 0.0, 2.0]);
    }

    #[test]
    fn a_message_that_is_never_sent_ends_the_simulation() {
        assert_eq!(ends(&[vec![Step::Take { from: 1 }], vec![work(1.0)]], APART, AT_ONCE), [0.0, 1.0]);
    }
}
