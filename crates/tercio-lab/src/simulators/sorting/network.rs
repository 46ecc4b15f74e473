//! The load of a network's links.
//!
//! A path's links are counted in constant time by recording only where it begins and ends on each line of links
//! (differences, summed up in the end); in the tree by walking up to the common ancestor.

use serde::Serialize;

use crate::machines::{self, Delivery, Machine, MachineError, Packing, Topology};

/// A network of some processors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NetworkModel {
    /// Its shape; with nodes, that of the network between them.
    pub topology: Topology,
    /// Bytes a second of one link in one direction.
    pub bandwidth: f64,
    /// Seconds of a hop.
    pub hop: f64,
    /// Seconds that a processor spends on every message it sends or receives.
    pub message: f64,
    /// How polygons are packed into messages.
    pub packing: Packing,
    /// Where the finished picture goes.
    pub delivery: Delivery,
    /// Consecutive processors that share a memory; `None` if each has a link of its own.
    pub node: Option<NodeModel>,
}

/// The processors of a node, and the network inside it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NodeModel {
    /// Processors.
    pub processors: usize,
    /// Shape of their network.
    pub topology: Topology,
    /// Bytes a second of one link in one direction.
    pub bandwidth: f64,
    /// Seconds of a hop.
    pub hop: f64,
    /// Seconds that a processor spends on every message it sends or receives.
    pub message: f64,
}

impl NetworkModel {
    /// The network of a machine; between nodes, or else between processors, in another shape if one is given.
    ///
    /// # Errors
    /// [`MachineError::Missing`] without a network.
    pub fn of(machine: &Machine, topology: Option<Topology>) -> Result<Self, MachineError> {
        let network = machine.need(machine.network.as_ref(), "network")?;
        let node = machine.node.as_ref().zip(machine.processors.per_node.as_ref());
        let of_node = |(node, processors): (&machines::Network, &machines::Sourced<_>)| NodeModel {
            processors: processors.whole().max(1) as usize,
            topology: node.topology,
            bandwidth: node.bandwidth.value,
            hop: node.hop.value,
            message: node.message.value,
        };
        Ok(Self {
            topology: topology.unwrap_or(network.topology),
            bandwidth: network.bandwidth.value,
            hop: network.hop.value,
            message: network.message.value,
            packing: network.packing,
            delivery: network.delivery,
            node: node.map(of_node),
        })
    }

    /// Seconds in which the busiest links pass their bytes. Links inside nodes and between them are busy at the same
    /// time.
    pub fn seconds_of_links(&self, traffic: &Traffic) -> f64 {
        let inside = self.node.map_or(0.0, |node| traffic.inside.busiest_link / node.bandwidth);
        inside.max(traffic.busiest_link / self.bandwidth)
    }

    /// Seconds of a phase of communication.
    pub fn seconds(&self, traffic: &Traffic) -> f64 {
        let of_node = |node: NodeModel| {
            f64::from(traffic.inside.most_hops) * node.hop
                + traffic.inside.most_messages as f64 * node.message
        };
        self.seconds_of_links(traffic)
            + f64::from(traffic.most_hops) * self.hop
            + traffic.most_messages as f64 * self.message
            + self.node.map_or(0.0, of_node)
    }
}

/// Counts of a communication phase. Those of links, hops and messages of one processor are of the network between
/// nodes, or between processors if there are no nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Traffic {
    /// Messages between different processors.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Bytes on the busiest link, divided by its capacity relative to a plain link.
    pub busiest_link: f64,
    /// Links of the longest path.
    pub most_hops: u32,
    /// The largest number of messages that one processor sends, or that one receives.
    pub most_messages: u64,
    /// The part inside nodes.
    pub inside: Inside,
}

/// Counts of a communication phase inside nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Inside {
    /// Bytes.
    pub bytes: u64,
    /// Bytes on the busiest link of any node.
    pub busiest_link: f64,
    /// Links of the longest path.
    pub most_hops: u32,
    /// The largest number of messages that one processor sends to its node, or receives from it.
    pub most_messages: u64,
}

impl Traffic {
    /// The sum of two phases, one after the other.
    pub fn then(self, o: Self) -> Self {
        let (a, b) = (self.inside, o.inside);
        Self {
            messages: self.messages + o.messages,
            bytes: self.bytes + o.bytes,
            busiest_link: self.busiest_link + o.busiest_link,
            most_hops: self.most_hops + o.most_hops,
            most_messages: self.most_messages + o.most_messages,
            inside: Inside {
                bytes: a.bytes + b.bytes,
                busiest_link: a.busiest_link + b.busiest_link,
                most_hops: a.most_hops + b.most_hops,
                most_messages: a.most_messages + b.most_messages,
            },
        }
    }
}

/// The links of a network, to which messages are added.
#[derive(Clone, Debug)]
pub struct Links {
    /// Between nodes, or between processors.
    between: Level,
    /// Processors of a node, and the links of each.
    nodes: Option<(usize, Vec<Level>)>,
    /// Messages of each processor to and from others of its node, then to and from other nodes.
    sent: [Vec<u32>; 2],
    taken: [Vec<u32>; 2],
    messages: u64,
    bytes: u64,
    bytes_inside: u64,
}

impl Links {
    /// Idle links between `processors`, which are numbered node by node, along the ring, row by row through the mesh
    /// and each plane of the torus, and from left to right below the tree.
    pub fn new(network: &NetworkModel, processors: usize) -> Self {
        let n = processors.max(1);
        let none = || [vec![0; n], vec![0; n]];
        let (between, nodes) = match network.node {
            None => (Level::new(network.topology, n), None),
            Some(node) => {
                let starts = (0..n).step_by(node.processors);
                let levels = starts.map(|first| Level::new(node.topology, node.processors.min(n - first)));
                let levels: Vec<_> = levels.collect();
                (Level::new(network.topology, levels.len()), Some((node.processors, levels)))
            }
        };
        Self { between, nodes, sent: none(), taken: none(), messages: 0, bytes: 0, bytes_inside: 0 }
    }

    /// Adds a message; one to the sender itself costs nothing.
    ///
    /// # Panics
    /// If there is no such processor.
    pub fn send(&mut self, from: usize, to: usize, bytes: u64) {
        if from == to {
            return;
        }
        self.messages += 1;
        self.bytes += bytes;
        let level = match &mut self.nodes {
            Some((p, nodes)) if from / *p == to / *p => {
                nodes[from / *p].send(from % *p, to % *p, bytes);
                self.bytes_inside += bytes;
                0
            }
            nodes => {
                let p = nodes.as_ref().map_or(1, |nodes| nodes.0);
                self.between.send(from / p, to / p, bytes);
                1
            }
        };
        self.sent[level][from] += 1;
        self.taken[level][to] += 1;
    }

    /// The counts of all messages.
    pub fn traffic(&self) -> Traffic {
        let most = |level: usize| {
            u64::from(self.sent[level].iter().chain(&self.taken[level]).copied().max().unwrap_or(0))
        };
        let nodes = || self.nodes.iter().flat_map(|nodes| &nodes.1);
        Traffic {
            messages: self.messages,
            bytes: self.bytes,
            busiest_link: self.between.busiest_link(),
            most_hops: self.between.most_hops,
            most_messages: most(1),
            inside: Inside {
                bytes: self.bytes_inside,
                busiest_link: nodes().map(Level::busiest_link).fold(0.0, f64::max),
                most_hops: nodes().map(|level| level.most_hops).max().unwrap_or(0),
                most_messages: most(0),
            },
        }
    }
}

/// The links of one level: between nodes, or inside a node.
#[derive(Clone, Debug)]
struct Level {
    loads: Loads,
    ends: usize,
    most_hops: u32,
}

/// Bytes, or their differences along a line of links. The two directions of a link are separate.
#[derive(Clone, Debug)]
enum Loads {
    /// One line round all processors, upwards and downwards.
    Ring([Vec<i64>; 2]),
    /// Rows of `side` links, right and left; columns, down and up.
    Mesh { side: usize, rows: [Vec<i64>; 2], columns: [Vec<i64>; 2] },
    /// Rings along each dimension, one after the other, upwards and downwards.
    Torus { sides: [usize; 3], lines: [[Vec<i64>; 2]; 3] },
    /// Links above the nodes of each level, leaves first: up and down.
    FatTree(Vec<[Vec<u64>; 2]>),
    /// Into the switch and out of it.
    Crossbar([Vec<u64>; 2]),
    /// All bytes on one medium.
    Shared(u64),
}

impl Level {
    fn new(topology: Topology, ends: usize) -> Self {
        let n = ends.max(1);
        let loads = match topology {
            // A path may pass number 0: the line is unrolled to twice its length.
            Topology::Ring => Loads::Ring([vec![0; 2 * n + 1], vec![0; 2 * n + 1]]),
            Topology::Mesh => {
                let side = (1..).find(|s| s * s >= n).unwrap_or(1);
                let lines = || [vec![0; side * (side + 1)], vec![0; side * (side + 1)]];
                Loads::Mesh { side, rows: lines(), columns: lines() }
            }
            Topology::Torus => {
                let sides = sides_of_torus(n);
                let lines = sides.map(|side| [0, 1].map(|_| vec![0; n / side * (2 * side + 1)]));
                Loads::Torus { sides, lines }
            }
            Topology::FatTree => {
                let levels = n.next_power_of_two().trailing_zeros();
                Loads::FatTree((0..levels).map(|l| [vec![0; (n >> l) + 1], vec![0; (n >> l) + 1]]).collect())
            }
            Topology::Crossbar => Loads::Crossbar([vec![0; n], vec![0; n]]),
            Topology::Bus | Topology::Memory => Loads::Shared(0),
        };
        Self { loads, ends: n, most_hops: 0 }
    }

    fn send(&mut self, from: usize, to: usize, bytes: u64) {
        let n = self.ends;
        let hops = match &mut self.loads {
            Loads::Ring(lines) => add_round(lines, 0, n, (from, to), bytes),
            Loads::Torus { sides, lines } => {
                let [x, y, _] = *sides;
                let place = |k: usize| [k % x, k / x % y, k / (x * y)];
                let (mut at, end) = (place(from), place(to));
                let mut hops = 0;
                for (dimension, (&side, lines)) in sides.iter().zip(lines).enumerate() {
                    // Which of the rings along this dimension.
                    let ring = match dimension {
                        0 => at[1] + y * at[2],
                        1 => at[0] + x * at[2],
                        _ => at[0] + x * at[1],
                    };
                    let start = ring * (2 * side + 1);
                    hops += add_round(lines, start, side, (at[dimension], end[dimension]), bytes);
                    at[dimension] = end[dimension];
                }
                hops
            }
            Loads::Mesh { side, rows, columns } => {
                let ((x0, y0), (x1, y1)) = ((from % *side, from / *side), (to % *side, to / *side));
                // Along the row first, then along the column.
                let line = *side + 1;
                add_between(rows, y0 * line, x0, x1, bytes);
                add_between(columns, x1 * line, y0, y1, bytes);
                x0.abs_diff(x1) + y0.abs_diff(y1)
            }
            Loads::FatTree(levels) => {
                let (mut a, mut b, mut height) = (from, to, 0);
                while a != b {
                    levels[height][0][a] += bytes;
                    levels[height][1][b] += bytes;
                    (a, b, height) = (a / 2, b / 2, height + 1);
                }
                2 * height
            }
            Loads::Crossbar([into, out]) => {
                into[from] += bytes;
                out[to] += bytes;
                2
            }
            Loads::Shared(all) => {
                *all += bytes;
                1
            }
        };
        self.most_hops = self.most_hops.max(hops as u32);
    }

    /// Bytes on the busiest link, divided by its capacity relative to a plain link.
    fn busiest_link(&self) -> f64 {
        match &self.loads {
            Loads::Ring(lines) => {
                let n = self.ends;
                lines.iter().map(|l| busiest_of_ring(l, n)).max().unwrap_or(0) as f64
            }
            Loads::Torus { sides, lines } => {
                let of = |(&side, lines): (&usize, &[Vec<i64>; 2])| {
                    let rings = lines.iter().flat_map(|line| line.chunks(2 * side + 1));
                    rings.map(|ring| busiest_of_ring(ring, side)).max().unwrap_or(0)
                };
                sides.iter().zip(lines).map(of).max().unwrap_or(0) as f64
            }
            Loads::Mesh { side, rows, columns } => {
                let lines = rows.iter().chain(columns);
                lines.flat_map(|l| l.chunks(*side + 1)).map(busiest).max().unwrap_or(0) as f64
            }
            Loads::FatTree(levels) => {
                let of_level = |(height, links): (usize, &[Vec<u64>; 2])| {
                    let most = links.iter().flatten().copied().max().unwrap_or(0);
                    most as f64 / (1u64 << height) as f64
                };
                levels.iter().enumerate().map(of_level).fold(0.0, f64::max)
            }
            Loads::Crossbar(ports) => ports.iter().flatten().copied().max().unwrap_or(0) as f64,
            Loads::Shared(all) => *all as f64,
        }
    }
}

/// Ends along each dimension of a torus of `n`: as near to a cube as divisors of `n` allow.
fn sides_of_torus(n: usize) -> [usize; 3] {
    let divisor = |n: usize, power: u32| {
        (1..=n).take_while(|d| d.pow(power) <= n).filter(|&d| n.is_multiple_of(d)).last().unwrap_or(1)
    };
    let x = divisor(n, 3);
    let y = divisor(n / x, 2);
    [x, y, n / x / y]
}

/// Adds bytes on the way round a ring of `n` ends whose unrolled lines begin at `start`, in the shorter direction, upwards if both
/// are equal; the hops.
fn add_round(
    lines: &mut [Vec<i64>; 2],
    start: usize,
    n: usize,
    (from, to): (usize, usize),
    bytes: u64,
) -> usize {
    let up = (to + n - from) % n;
    let down = n - up;
    if up <= down {
        add(&mut lines[0], start + from, start + from + up, bytes);
        up
    } else {
        add(&mut lines[1], start + to, start + to + down, bytes);
        down
    }
}

/// Adds bytes to the links `first` to `end` - 1 of a line.
fn add(line: &mut [i64], first: usize, end: usize, bytes: u64) {
    line[first] += bytes as i64;
    line[end] -= bytes as i64;
}

/// Adds bytes between two positions of the line that begins at `start`; one line for each direction.
fn add_between(lines: &mut [Vec<i64>; 2], start: usize, from: usize, to: usize, bytes: u64) {
    match from.cmp(&to) {
        std::cmp::Ordering::Less => add(&mut lines[0], start + from, start + to, bytes),
        std::cmp::Ordering::Greater => add(&mut lines[1], start + to, start + from, bytes),
        std::cmp::Ordering::Equal => {}
    }
}

/// The largest prefix sum of differences.
fn busiest(line: &[i64]) -> i64 {
    line.iter()
        .scan(0, |sum, d| {
            *sum += d;
            Some(*sum)
        })
        .max()
        .unwrap_or(0)
}

/// The same for a line that goes round twice: links k and k + n are the same.
fn busiest_of_ring(line: &[i64], n: usize) -> i64 {
    let mut loads = vec![0; n];
    let mut sum = 0;
    for (k, d) in line.iter().enumerate() {
        sum += d;
        loads[k % n] += sum;
    }
    loads.into_iter().max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Reference: every message on every link of its path, counted one by one.
    fn reference(topology: Topology, n: usize, messages: &[(usize, usize, u64)]) -> u64 {
        let mut loads = std::collections::BTreeMap::new();
        for &(from, to, bytes) in messages {
            let mut at = from;
            while at != to {
                let next = match topology {
                    Topology::Ring if (to + n - at) % n <= n - (to + n - at) % n => (at + 1) % n,
                    Topology::Ring => (at + n - 1) % n,
                    Topology::Torus => {
                        let [x, y, z] = sides_of_torus(n);
                        // A step of one dimension: its length, its ring, and how many numbers further the next end is.
                        let step = |stride: usize, side: usize| {
                            let (a, b) = (at / stride % side, to / stride % side);
                            let up = (b + side - a) % side <= side - (b + side - a) % side;
                            let next = if up { (a + 1) % side } else { (a + side - 1) % side };
                            (a != b).then_some(at - a * stride + next * stride)
                        };
                        step(1, x).or_else(|| step(x, y)).or_else(|| step(x * y, z)).unwrap()
                    }
                    _ => {
                        let side = (1..).find(|s| s * s >= n).unwrap();
                        match (at % side).cmp(&(to % side)) {
                            std::cmp::Ordering::Less => at + 1,
                            std::cmp::Ordering::Greater => at - 1,
                            std::cmp::Ordering::Equal if at < to => at + side,
                            std::cmp::Ordering::Equal => at - side,
                        }
                    }
                };
                *loads.entry((at, next)).or_insert(0) += bytes;
                at = next;
            }
        }
        loads.into_values().max().unwrap_or(0)
    }

    fn traffic(topology: Topology, n: usize, messages: &[(usize, usize, u64)]) -> Traffic {
        let mut links = Links::new(&plain(topology), n);
        messages.iter().for_each(|&(from, to, bytes)| links.send(from, to, bytes));
        links.traffic()
    }

    fn plain(topology: Topology) -> NetworkModel {
        let (packing, delivery) = (Packing::default(), Delivery::default());
        NetworkModel { topology, bandwidth: 1.0, hop: 0.0, message: 0.0, packing, delivery, node: None }
    }

    #[test]
    fn messages_inside_a_node_use_no_link_between_nodes() {
        let topology = Topology::Crossbar;
        let node = NodeModel { processors: 4, topology, bandwidth: 10.0, hop: 0.0, message: 1.0 };
        let network = NetworkModel { message: 100.0, node: Some(node), ..plain(topology) };
        let mut links = Links::new(&network, 10);
        links.send(0, 3, 70);
        let inside = links.traffic();
        assert_eq!((inside.busiest_link, inside.inside.busiest_link, inside.inside.bytes), (0.0, 70.0, 70));
        assert_eq!(network.seconds(&inside), 7.0 + 1.0);
        // Processors of a node share its one link: from node 0 to node 1 and node 2, which has two processors.
        links.send(1, 5, 30);
        links.send(2, 9, 20);
        let both = links.traffic();
        assert_eq!((both.messages, both.bytes, both.busiest_link, both.most_messages), (3, 120, 50.0, 1));
        assert_eq!(network.seconds(&both), 50.0 + 100.0 + 1.0);
    }

    #[test]
    fn a_ring_by_hand() {
        // 0 to 2 upwards over links 0-1 and 1-2; 5 to 1 upwards round the corner over 5-0 and 0-1.
        let t = traffic(Topology::Ring, 6, &[(0, 2, 10), (5, 1, 7), (4, 4, 99)]);
        assert_eq!((t.busiest_link, t.most_hops, t.bytes, t.messages), (17.0, 2, 17, 2));
    }

    #[test]
    fn a_torus_by_hand() {
        assert_eq!(
            [8, 12, 60, 7, 8192].map(sides_of_torus),
            [[2, 2, 2], [2, 2, 3], [3, 4, 5], [1, 1, 7], [16, 16, 32]]
        );
        // 27 ends: from (0, 0, 0) to (2, 1, 0) is one step back round x, one along y; a second message shares the latter.
        let t = traffic(Topology::Torus, 27, &[(0, 5, 10), (2, 5, 7)]);
        assert_eq!((t.busiest_link, t.most_hops), (17.0, 2));
        // Three rings carry more than one.
        let all: Vec<_> = (0..64).flat_map(|a| (0..64).map(move |b| (a, b, 3))).collect();
        let [torus, ring] = [Topology::Torus, Topology::Ring].map(|of| traffic(of, 64, &all).busiest_link);
        assert!(torus * 4.0 < ring, "{torus} {ring}");
    }

    #[test]
    fn a_tree_carries_all_to_all_as_well_as_a_crossbar() {
        let all: Vec<_> = (0..16).flat_map(|a| (0..16).map(move |b| (a, b, 3))).collect();
        let tree = traffic(Topology::FatTree, 16, &all);
        let crossbar = traffic(Topology::Crossbar, 16, &all);
        // A leaf's link is the bottleneck of both.
        assert_eq!((tree.busiest_link, crossbar.busiest_link), (45.0, 45.0));
        assert_eq!((tree.most_hops, crossbar.most_hops, tree.most_messages), (8, 2, 15));
        assert!(traffic(Topology::Mesh, 16, &all).busiest_link > 45.0);
        assert!(
            traffic(Topology::Ring, 16, &all).busiest_link > traffic(Topology::Mesh, 16, &all).busiest_link
        );
    }

    proptest! {
        #[test]
        fn loads_equal_those_of_the_reference(
            n in 1usize..40,
            messages in prop::collection::vec((0usize..40, 0usize..40, 1u64..9), 0..60),
        ) {
            let messages: Vec<_> = messages.into_iter().map(|(a, b, w)| (a % n, b % n, w)).collect();
            for topology in [Topology::Ring, Topology::Mesh, Topology::Torus] {
                let walked = reference(topology, n, &messages);
                prop_assert_eq!(traffic(topology, n, &messages).busiest_link, walked as f64);
            }
        }
    }
}
