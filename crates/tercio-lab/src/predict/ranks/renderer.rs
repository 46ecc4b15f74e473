//! A frame of the real renderer's ranks: drawing, packing, sending and compositing, charged and scheduled.

use serde::Serialize;
use tercio_parallel::Organisation;
use tercio_parallel::organisation::envelope::TRAILER;
use tercio_parallel::organisation::tile_edge;
use tercio_raster::context::FrameContext;
use tercio_raster::{Renderer, Settings};
use tercio_scene::{Camera, Scene};

use super::drawing::drawing;
use super::exchange::{Exchange, ExchangeCosts, RankMemory};
use super::schedule::{Noticed, Played, Stage, Step, Wires, play};
use super::traffic::{Messages, Sharing, Traffic};
use crate::machines::{Machine, MachineError, Topology};
use crate::predict::PredictError;
use crate::predict::counts::{Counted, Counters, TileWork};
use crate::predict::frame::{Caches, FrameTime};
use crate::simulators::sorting::network::{Links, NetworkModel};

/// The work of all ranks for a frame, counted by drawing their parts one after another.
#[derive(Clone, Debug)]
pub struct RanksWork {
    /// How they share it.
    pub sharing: Sharing,
    /// What they send.
    pub messages: Messages,
    /// The work of each one's renderer.
    pub drawing: Vec<Counters>,
    /// Threads of each rank.
    pub threads: usize,
    /// The work in the tiles of each rank, if it has several threads.
    pub tiles: Vec<Vec<TileWork>>,
}

impl RanksWork {
    /// Counts a frame of ranks of one thread each. `settings` are those of the whole frame.
    ///
    /// # Errors
    /// What makes the frame impossible to draw.
    pub fn count(
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        how: (usize, tercio_parallel::Sharing),
    ) -> Result<Self, PredictError> {
        Self::with_threads(scene, camera, settings, how, 1)
    }

    /// The same for ranks of some threads each.
    ///
    /// # Errors
    /// What makes the frame impossible to draw.
    pub fn with_threads(
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        (ranks, sharing): (usize, tercio_parallel::Sharing),
        threads: usize,
    ) -> Result<Self, PredictError> {
        let sharing = Sharing {
            organisation: sharing.organisation,
            division: sharing.division,
            ranks,
            size: (settings.width, settings.height),
            edge: tile_edge(scene, settings, sharing.organisation, ranks),
        };
        let settings = Settings { tile_size: Some(sharing.edge), ..settings.clone() };
        let context = FrameContext::new(scene, camera, &settings, threads)?;
        let load = Renderer::estimate_load(&context);
        let owners = sharing.division.owners(&context.grid, &load, ranks);
        let clusters = match sharing.organisation {
            Organisation::SortLast => Renderer::divide_clusters(&context, ranks),
            _ => Vec::new(),
        };
        let mut traffic = Traffic::new(&sharing, &scene.background);
        let (mut drawn, mut tiles) = (Vec::new(), Vec::new());
        for rank in 0..ranks {
            let drawing = drawing(scene, camera, &settings, &sharing, &owners, &clusters, (rank, threads))?;
            traffic.add(&drawing);
            drawn.push(drawing.counters);
            tiles.push(drawing.tiles);
        }
        Ok(Self { messages: traffic.finish(&owners), sharing, drawing: drawn, threads, tiles })
    }

    /// Seconds in which a rank draws, without keys.
    fn drawing_seconds(&self, machine: &Machine, rank: usize) -> f64 {
        let frame = self.drawing[rank];
        if self.threads == 1 {
            return FrameTime::on_one_thread(machine, &frame).total();
        }
        let counted = Counted { frame, tiles: self.tiles[rank].clone() };
        FrameTime::on_threads(machine, &counted, self.threads).total()
    }
}

/// Seconds of a rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RankSeconds {
    /// Dividing the picture by an estimate of the work.
    pub divide: f64,
    /// Drawing, keys included.
    pub draw: f64,
    /// Packing for other owners and compositing.
    pub compose: f64,
    /// Packing for rank 0, unpacking there.
    pub collect: f64,
    /// Sending and receiving messages.
    pub message: f64,
    /// Waiting for messages.
    pub wait: f64,
    /// Waiting for a processor.
    pub queue: f64,
    /// From the beginning of the frame to its end on this rank.
    pub end: f64,
}

impl RankSeconds {
    fn of(played: &Played) -> Self {
        let [draw, compose, collect, message, divide] = played.busy;
        let Played { waited: wait, queued: queue, end, .. } = *played;
        Self { divide, draw, compose, collect, message, wait, queue, end }
    }

    /// Work, without waiting.
    pub fn busy(&self) -> f64 {
        self.divide + self.draw + self.compose + self.collect + self.message
    }
}

/// How messages reach other ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Carrier {
    /// Ranks are threads of one process: memory is handed over.
    Threads,
    /// Ranks are processes of one machine: the receiver copies the message.
    Processes,
    /// Ranks are on different machines.
    Network,
}

impl Carrier {
    /// The carrier of a description. If it has a number of processors that share a memory, ranks are machines.
    pub fn of(machine: &Machine) -> Self {
        if machine.processors.per_node.is_some() {
            Self::Network
        } else if machine.is_over_mpi() {
            Self::Processes
        } else {
            Self::Threads
        }
    }
}

/// A predicted frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RanksFrame {
    /// How the ranks share it.
    pub organisation: Organisation,
    /// Pixels along the edge of a region.
    pub region: u32,
    /// How messages reach other ranks.
    pub carrier: Carrier,
    /// Every rank, in order.
    pub ranks: Vec<RankSeconds>,
    /// Messages of all ranks.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// The largest number of bytes that one rank sends.
    pub most_bytes_sent: u64,
    /// Memory of the rank that needs the most.
    pub memory: RankMemory,
}

impl RanksFrame {
    /// Names of the parts of a frame, in the order in which they occur.
    pub const PHASES: [&'static str; 7] =
        ["dividing", "drawing", "composing", "collecting", "messages", "waiting", "queueing"];

    /// Seconds until rank 0 has the picture.
    pub fn total(&self) -> f64 {
        self.ranks.first().map_or(0.0, |first| first.end)
    }

    /// The busiest and the mean rank's seconds of something.
    pub fn busiest_and_mean(&self, of: impl Fn(&RankSeconds) -> f64) -> (f64, f64) {
        let times = self.ranks.iter().map(of);
        let (most, sum) = times.fold((0.0f64, 0.0), |(most, sum), t| (most.max(t), sum + t));
        (most, sum / self.ranks.len().max(1) as f64)
    }

    /// Busiest over mean rank, 1 where nothing is done.
    pub fn imbalance(&self, of: impl Fn(&RankSeconds) -> f64) -> f64 {
        let (busiest, mean) = self.busiest_and_mean(of);
        if mean > 0.0 { busiest / mean } else { 1.0 }
    }

    /// The parts of the frame's time on rank 0, by name, in the order in which they occur; their sum is
    /// [`Self::total`].
    pub fn phases(&self) -> [(&'static str, f64); 7] {
        let first = self.ranks.first().copied().unwrap_or_default();
        let RankSeconds { divide, draw, compose, collect, message, wait, queue, .. } = first;
        let seconds = [divide, draw, compose, collect, message, wait, queue];
        std::array::from_fn(|k| (Self::PHASES[k], seconds[k]))
    }
}

/// Predicts a frame of ranks. Threads of a rank share its drawing, packing and merging of tiles.
///
/// If the description has a number of processors that share a memory, consecutive ranks fill one node after the other:
/// messages take the time of the network, or of their node, and the ranks of a node share its cache. Otherwise ranks share
/// caches, there may be fewer `processors` than ranks, and messages stay in memory: threads of one process hand it
/// over, over MPI ([`Machine::over_mpi`]) the receiver copies the message, at the bandwidth of the network. The serial
/// share of a description is that of threads that divide one frame; ranks have nothing to divide.
///
/// # Errors
/// [`MachineError::Missing`] without a network.
pub fn predict(
    machine: &Machine,
    costs: &ExchangeCosts,
    work: &RanksWork,
    processors: usize,
) -> Result<RanksFrame, MachineError> {
    let (sharing, ranks) = (&work.sharing, work.sharing.ranks);
    let carrier = Carrier::of(machine);
    let mut network = NetworkModel::of(machine, None)?;
    if let Some(node) = &mut network.node {
        node.processors = (node.processors / work.threads).max(1);
    }
    let together = network.node.map_or(ranks, |node| node.processors.min(ranks));
    let cache = (together, Caches::of(machine, 1).exchange);
    let copied = carrier != Carrier::Threads;
    let exchange = Exchange::new(sharing, &work.messages, &work.drawing, cache, copied);
    let wake_up = machine.processors.wake_up.as_ref().map_or(0.0, |w| w.value);
    let nap = machine.processors.nap.as_ref().map_or(0.0, |nap| nap.value);
    let wires = match carrier {
        Carrier::Network => on_network(&network, work, nap),
        Carrier::Threads => {
            Wires { latency: 0.0, bandwidth: f64::INFINITY, noticed: Noticed::Woken(wake_up) }
        }
        Carrier::Processes => {
            Wires { latency: 0.0, bandwidth: f64::INFINITY, noticed: Noticed::Polling(nap) }
        }
    };
    let byte = if carrier == Carrier::Processes { 1.0 / network.bandwidth } else { 0.0 };
    // Ranks of one node exchange messages in its memory only.
    let message = match network.node {
        Some(node) if ranks <= node.processors => node.message,
        _ => network.message,
    };
    let costs = Costs { machine, exchange: costs, message, byte };
    let programs: Vec<Vec<Step>> = (0..ranks).map(|rank| program(&costs, work, &exchange, rank)).collect();
    let played = play(&programs, (processors / work.threads).max(1), wires);
    let (messages, bytes) = work.messages.total();
    let memory = (0..ranks).map(|rank| exchange.memory(rank)).max_by_key(RankMemory::total);
    Ok(RanksFrame {
        organisation: sharing.organisation,
        region: sharing.edge,
        carrier,
        ranks: played.iter().map(RankSeconds::of).collect(),
        messages,
        bytes,
        most_bytes_sent: (0..ranks).map(|rank| work.messages.counts(rank).bytes).max().unwrap_or(0),
        memory: memory.unwrap_or_default(),
    })
}

/// Costs of a rank's steps.
struct Costs<'a> {
    machine: &'a Machine,
    exchange: &'a ExchangeCosts,
    /// Seconds of sending or receiving a message.
    message: f64,
    /// Additional seconds for each byte that is received.
    byte: f64,
}

/// The steps of a rank, as the renderer takes them.
fn program(costs: &Costs, work: &RanksWork, exchange: &Exchange, rank: usize) -> Vec<Step> {
    let Costs { machine, exchange: costs, message, byte } = *costs;
    let ranks = work.sharing.ranks;
    let messages = &work.messages;
    let mut steps = Vec::new();
    let send = |steps: &mut Vec<Step>, to: usize, content: u64| {
        let bytes = content + TRAILER as u64;
        steps.extend([Step::Work(Stage::Message, message), Step::Send { to, bytes }]);
    };
    let take = |steps: &mut Vec<Step>, from: usize, content: u64| {
        let seconds = message + byte * (content + TRAILER as u64) as f64;
        steps.extend([Step::Take { from }, Step::Work(Stage::Message, seconds)]);
    };
    let dividing = costs.seconds(&exchange.dividing());
    if dividing > 0.0 {
        steps.push(Step::Work(Stage::Divide, dividing));
    }
    // Between front end and back end; the front end is charged with drawing, behind it.
    for (distance, bytes) in gathering(messages, ranks) {
        send(&mut steps, (rank + ranks - distance) % ranks, bytes);
        take(&mut steps, (rank + distance) % ranks, bytes);
    }
    let threads = work.threads as f64;
    let seconds = work.drawing_seconds(machine, rank) + costs.seconds(&exchange.keys(rank)) / threads;
    steps.push(Step::Work(Stage::Draw, seconds));
    if ranks == 1 {
        return steps;
    }
    steps.push(Step::Work(Stage::Compose, costs.seconds(&exchange.packing(rank)) / threads));
    for to in (1..ranks).map(|step| (rank + step) % ranks) {
        if let Some(pixels) = messages.between(rank, to) {
            send(&mut steps, to, pixels.keyed_bytes());
        }
    }
    for (from, composing) in exchange.composing(rank) {
        take(&mut steps, from, messages.between(from, rank).map_or(0, |pixels| pixels.keyed_bytes()));
        steps.push(Step::Work(Stage::Compose, costs.seconds(&composing) / threads));
    }
    let finished = &messages.finished;
    if rank == 0 || finished[rank].is_sent {
        steps.push(Step::Work(Stage::Collect, costs.seconds(&exchange.finishing(rank))));
    }
    if finished[rank].is_sent {
        send(&mut steps, 0, finished[rank].sent().bytes());
    }
    for from in (1..ranks).filter(|&from| rank == 0 && finished[from].is_sent) {
        take(&mut steps, from, finished[from].sent().bytes());
        steps.push(Step::Work(Stage::Collect, costs.seconds(&exchange.collecting(from))));
    }
    steps
}

/// The messages in which every rank learns which tiles the others have drawn: how far they go, and the bytes of their contents.
fn gathering(messages: &Messages, ranks: usize) -> impl Iterator<Item = (usize, u64)> {
    let (rounds, bytes) = messages.gathered;
    let block = bytes / (ranks as u64 - 1).max(1);
    (0..rounds).map(move |round| {
        let distance = 1 << round;
        (distance, block * distance.min(ranks - distance) as u64)
    })
}

/// The network as seen by all messages of a frame: with the bandwidth at which its busiest links, inside a node or
/// between nodes, pass what the busiest port passes, and the latency of its longest path.
fn on_network(network: &NetworkModel, work: &RanksWork, nap: f64) -> Wires {
    let ranks = work.sharing.ranks;
    let mut links = Links::new(network, ranks);
    let mut ports = Links::new(&NetworkModel { topology: Topology::Crossbar, node: None, ..*network }, ranks);
    for from in 0..ranks {
        let composed = (0..ranks).filter_map(|to| Some((to, work.messages.between(from, to)?.keyed_bytes())));
        let finished =
            Some(&work.messages.finished[from]).filter(|f| f.is_sent).map(|f| (0, f.sent().bytes()));
        let gathered = gathering(&work.messages, ranks);
        let gathered = gathered.map(|(distance, bytes)| ((from + ranks - distance) % ranks, bytes));
        for (to, content) in composed.chain(finished).chain(gathered) {
            let bytes = content + TRAILER as u64;
            links.send(from, to, bytes);
            ports.send(from, to, bytes);
        }
    }
    let (links, ports) = (links.traffic(), ports.traffic());
    let seconds = network.seconds_of_links(&links);
    // Without nodes, no faster than a port.
    let fastest = if network.node.is_some() { f64::INFINITY } else { network.bandwidth };
    let inside = network.node.map_or(0.0, |node| f64::from(links.inside.most_hops) * node.hop);
    Wires {
        latency: f64::from(links.most_hops) * network.hop + inside,
        bandwidth: if seconds > 0.0 { (ports.busiest_link / seconds).min(fastest) } else { fastest },
        noticed: Noticed::Polling(nap),
    }
}

#[cfg(test)]
mod tests;
