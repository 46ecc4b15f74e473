//! How messages travel: on one level, or inside nodes and between them.
//!
//! Ranks are numbered node by node. Where the partners of a rank lie follows from how far apart they are in this order: see
//! [`Reach`].

use tercio_parallel::numbers::gcd;

use super::network::{Network, Source};
use super::terms::Load;
use crate::machines::{Machine, MachineError, Topology};
use crate::simulators::sorting::network::{Links, NetworkModel};

/// Seconds of a message of which the processor is busy, at most.
const BUSY: f64 = 2e-6;

/// Messages of one level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wire {
    /// Seconds of a small message.
    pub latency: f64,
    /// Seconds of it that the processor is busy.
    pub busy: f64,
    /// Bytes a second through a port; infinite if memory is handed over.
    pub bandwidth: f64,
}

/// Messages of all levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wires {
    /// Between nodes, whose ranks share a port; between ranks, if there are no nodes.
    pub between: Wire,
    /// Ranks of a node, and messages inside it, each rank with a port of its own.
    pub inside: Option<(usize, Wire)>,
}

/// How far apart the ranks are that exchange messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reach {
    /// A rank's partners are among so many consecutive ranks.
    pub within: usize,
    /// They are so many ranks apart.
    pub stride: usize,
}

impl From<Network> for Wires {
    /// One level. Between threads of a process a processor is busy during all of a message.
    fn from(network: Network) -> Self {
        let Network { latency, bandwidth, source } = network;
        let busy = match source {
            Source::Constants => latency,
            Source::Measured { .. } => latency.min(BUSY),
        };
        Self { between: Wire { latency, busy, bandwidth }, inside: None }
    }
}

impl Wires {
    /// The wires of a described machine between `ranks` ranks of `threads` threads, in another shape if one is given. Links that
    /// many messages share, as on a ring, make the ports slower: as much as if every rank sent the same to ranks near and far.
    ///
    /// # Errors
    /// [`MachineError::Missing`] without a network.
    pub fn of(
        machine: &Machine,
        topology: Option<Topology>,
        ranks: usize,
        threads: usize,
    ) -> Result<Self, MachineError> {
        let network = NetworkModel::of(machine, topology)?;
        if network.node.is_none() && !machine.is_over_mpi() && topology.is_none() {
            // Threads of one process.
            return Ok(Network::in_process(machine)?.into());
        }
        let per_node = network.node.map_or(1, |node| (node.processors / threads.max(1)).max(1));
        let flat = NetworkModel { node: None, ..network };
        let (slower, hops) = contention(&flat, ranks.div_ceil(per_node));
        let between = Wire {
            latency: network.message + hops * network.hop,
            busy: network.message,
            bandwidth: network.bandwidth / slower,
        };
        let inside = network.node.map(|node| {
            let of_node = NetworkModel {
                topology: node.topology,
                bandwidth: node.bandwidth,
                hop: node.hop,
                message: node.message,
                ..flat
            };
            let (slower, hops) = contention(&of_node, per_node.min(ranks));
            let latency = node.message + hops * node.hop;
            (per_node, Wire { latency, busy: node.message, bandwidth: node.bandwidth / slower })
        });
        Ok(Self { between, inside })
    }

    /// The same with a unit of time that is so many seconds.
    #[must_use]
    pub fn in_units_of(self, seconds: f64) -> Self {
        let of = |wire: Wire| Wire {
            latency: wire.latency / seconds,
            busy: wire.busy / seconds,
            bandwidth: wire.bandwidth * seconds,
        };
        Self { between: of(self.between), inside: self.inside.map(|(node, wire)| (node, of(wire))) }
    }

    /// The share of the ranks' partners that is on their own node, in the mean over all places that groups of consecutive ranks have
    /// on the nodes.
    fn share_inside(&self, reach: Reach) -> f64 {
        let Some((node, _)) = self.inside else { return 0.0 };
        let (node, within, stride) = (node.max(1), reach.within.max(1), reach.stride.max(1));
        // Ordered pairs of as many consecutive ranks that are multiples of the stride apart.
        let pairs = |ranks: usize| {
            let (each, more) = (ranks / stride, ranks % stride);
            (more * (each + 1) * each + (stride - more) * each * each.saturating_sub(1)) as u64
        };
        let of_group = pairs(within);
        if of_group == 0 {
            return 1.0;
        }
        // Nodes cut a group into pieces. Its first rank is at a multiple of the common divisor in a node.
        let step = gcd(node, within);
        let inside: u64 = (0..node)
            .step_by(step)
            .map(|place| {
                let first = within.min(node - place);
                let (whole, last) = ((within - first) / node, (within - first) % node);
                pairs(first) + whole as u64 * pairs(node) + pairs(last)
            })
            .sum();
        inside as f64 / ((node / step) as u64 * of_group) as f64
    }

    /// Seconds of a small message.
    pub fn latency(&self, reach: Reach) -> f64 {
        match self.inside {
            Some((_, wire)) if self.share_inside(reach) == 1.0 => wire.latency,
            _ => self.between.latency,
        }
    }

    /// Seconds of a message that the processor is busy.
    pub fn busy(&self, reach: Reach) -> f64 {
        let share = self.share_inside(reach);
        share * self.inside.map_or(0.0, |(_, wire)| wire.busy) + (1.0 - share) * self.between.busy
    }

    /// Seconds in which the busiest ports pass the bytes of all ranks. Links inside nodes and between them are busy at the same
    /// time.
    pub fn ports(&self, loads: &[Load], reach: Reach) -> f64 {
        let most = loads.iter().map(|load| load.out.max(load.into)).fold(0.0, f64::max);
        let Some((node, wire)) = self.inside else { return most / self.between.bandwidth };
        let share = self.share_inside(reach);
        let of_node = |loads: &[Load]| {
            let [out, into] =
                [|l: &Load| l.out, |l: &Load| l.into].map(|of| loads.iter().map(of).sum::<f64>());
            out.max(into)
        };
        let nodes = loads.chunks(node.max(1)).map(of_node).fold(0.0, f64::max);
        (most * share / wire.bandwidth).max(nodes * (1.0 - share) / self.between.bandwidth)
    }

    /// The same if this many ranks of so many, scattered evenly among them, pass the same bytes.
    pub fn ports_evenly(&self, bytes: f64, (ranks, of): (usize, usize), reach: Reach) -> f64 {
        let Some((node, wire)) = self.inside else { return bytes / self.between.bandwidth };
        let share = self.share_inside(reach);
        let on_node = (node.min(of) * ranks).div_ceil(of.max(1));
        let nodes = bytes * on_node as f64;
        (bytes * share / wire.bandwidth).max(nodes * (1.0 - share) / self.between.bandwidth)
    }
}

/// The load of the busiest link relative to that of the busiest port, at least 1, and the most links of a path, if all members send
/// to members at every power of two as a distance.
fn contention(network: &NetworkModel, members: usize) -> (f64, f64) {
    if members < 2 {
        return (1.0, 0.0);
    }
    let mut links = Links::new(network, members);
    let mut ports = Links::new(&NetworkModel { topology: Topology::Crossbar, ..*network }, members);
    for distance in (0..usize::BITS).map(|bit| 1usize << bit).take_while(|&distance| distance < members) {
        for from in 0..members {
            links.send(from, (from + distance) % members, 1);
            ports.send(from, (from + distance) % members, 1);
        }
    }
    let (links, ports) = (links.traffic(), ports.traffic());
    let slower = links.busiest_link / ports.busiest_link.max(1.0);
    (slower.max(1.0), f64::from(links.most_hops))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machines;

    const ALL: Reach = Reach { within: 16, stride: 1 };

    fn nodes() -> Wires {
        Wires {
            between: Wire { latency: 1e-5, busy: 2e-6, bandwidth: 1e9 },
            inside: Some((4, Wire { latency: 1e-6, busy: 1e-6, bandwidth: 4e9 })),
        }
    }

    /// The formula against every pair of ranks.
    #[test]
    fn the_share_of_partners_on_a_node_is_that_of_all_pairs() {
        let reaches =
            [(16, 1), (16, 2), (16, 4), (16, 8), (4, 1), (4, 2), (8, 1), (2, 1), (12, 5), (64, 32), (100, 7)];
        // Nodes that the groups fill, and others, which cut them anywhere.
        for (node, (within, stride)) in
            [1usize, 3, 4, 6, 9, 16, 42].into_iter().flat_map(|n| reaches.map(|r| (n, r)))
        {
            let (mut inside, mut all) = (0u32, 0u32);
            for from in 0..node * within {
                let first = from / within * within;
                for to in (first..first + within)
                    .filter(|to| *to != from && to.abs_diff(from).is_multiple_of(stride))
                {
                    all += 1;
                    inside += u32::from(from / node == to / node);
                }
            }
            let wires = Wires { inside: nodes().inside.map(|(_, wire)| (node, wire)), ..nodes() };
            let share = wires.share_inside(Reach { within, stride });
            assert!((share - f64::from(inside) / f64::from(all)).abs() < 1e-12, "{node} {within} {stride}");
        }
        // Nobody to send to.
        assert_eq!(nodes().share_inside(Reach { within: 1, stride: 1 }), 1.0);
    }

    /// Every rank sends 5 bytes to each other one, message by message through the ports.
    #[test]
    fn ranks_of_a_node_share_its_port() {
        let load = Load { messages: 15.0, out: 75.0, into: 75.0, work: 0.0 };
        let (mut own, mut node) = ([0.0; 16], [0.0; 4]);
        for from in 0..16 {
            for to in (0..16).filter(|&to| to != from) {
                if from / 4 == to / 4 { own[from] += 5.0 } else { node[from / 4] += 5.0 }
            }
        }
        let expected = (own[0] / 4e9f64).max(node[0] / 1e9);
        let seconds = nodes().ports(&[load; 16], ALL);
        assert!((seconds - expected).abs() < 1e-15, "{seconds} {expected}");
        assert_eq!(nodes().ports_evenly(75.0, (16, 16), ALL), seconds);
        // One rank in four: one on each node.
        assert_eq!(nodes().ports_evenly(75.0, (4, 16), ALL), seconds / 4.0);
        let in_node = Reach { within: 4, stride: 1 };
        assert_eq!((nodes().latency(in_node), nodes().latency(ALL)), (1e-6, 1e-5));
        assert_eq!(nodes().ports(&[load; 4], in_node), 75.0 / 4e9);
    }

    #[test]
    fn a_ring_is_slower_than_a_crossbar_and_threads_hand_memory_over() {
        let cluster = machines::load("cluster-64").expect("built in");
        let of = |topology| Wires::of(&cluster, Some(topology), 8192, 1).expect("it has a network").between;
        let (ring, crossbar) = (of(Topology::Ring), of(Topology::Crossbar));
        assert!(ring.bandwidth < crossbar.bandwidth / 2.0, "{ring:?} {crossbar:?}");
        assert!(ring.latency > crossbar.latency);
        let wires = Wires::of(&cluster, None, 64, 8).expect("it has a network");
        assert_eq!(wires.inside.map(|inside| inside.0), Some(16), "ranks of 8 threads on 128 processors");
        let server = machines::load("server-128").expect("built in");
        let wires = Wires::of(&server, None, 64, 1).expect("it has a network");
        assert_eq!((wires.between.bandwidth, wires.inside), (f64::INFINITY, None));
    }
}
