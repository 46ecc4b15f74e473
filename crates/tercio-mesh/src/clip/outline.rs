//! The outline of a cut: the edges at which a surface ends in the plane, as a graph.
//!
//! No loops are followed. An outline is closed if at each of its points as many edges begin as end; then every point of
//! the plane has a winding number, which says whether it is inside, also where outlines touch or cross.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::plane::LocalPlane;
use crate::weld::position_bits;

/// A directed edge in the plane, in the coordinates of the mesh. A cap that has it in this direction continues the
/// surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub from: [f32; 3],
    pub to: [f32; 3],
    /// How many surfaces end here.
    pub weight: i32,
}

/// An edge between two points of an [`Outline`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    pub from: u32,
    pub to: u32,
    /// Number of edges from `from` to `to`, less those in the other direction; 1 with [`Rule::EvenOdd`].
    pub weight: i32,
}

/// What is inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// What has a winding number that is not zero.
    NonZero,
    /// What is separated from the outside by an odd number of edges: for surfaces whose triangles do not all run the
    /// same way round.
    EvenOdd,
}

/// The closed outlines of a cut.
#[derive(Debug)]
pub(super) struct Outline {
    /// In the coordinates of the mesh, all different.
    pub points: Vec<[f32; 3]>,
    /// The same points projected along an axis, to the two axes after it; there, two may be one.
    pub flat: Vec<[f64; 2]>,
    pub links: Vec<Link>,
    pub rule: Rule,
    /// Number of outlines that have no point in common.
    pub closed: u64,
    /// Number of those that were left out because they have an end, or a branch.
    pub open: u64,
}

/// Coordinates below this are zero; products of smaller ones underflow.
const TINY: f64 = 1e-40;

impl Outline {
    pub fn new(segments: &[Segment], plane: &LocalPlane) -> Self {
        let axis = plane.main_axis();
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let (mut points, mut flat) = (Vec::new(), Vec::new());
        let mut numbers = HashMap::new();
        let mut number = |p: [f32; 3]| {
            *numbers.entry(position_bits(p)).or_insert_with(|| {
                points.push(p);
                flat.push([u, v].map(|k| if f64::from(p[k]).abs() < TINY { 0.0 } else { f64::from(p[k]) }));
                (points.len() - 1) as u32
            })
        };
        let mut edges = Edges::default();
        for s in segments {
            let (from, to) = (number(s.from), number(s.to));
            edges.add(from, to, s.weight);
        }
        edges.finish(points, flat)
    }
}

/// Edges between points, each pair of points once.
#[derive(Default)]
struct Edges {
    places: HashMap<(u32, u32), usize>,
    list: Vec<Edge>,
}

struct Edge {
    low: u32,
    high: u32,
    /// Edges upwards less those downwards.
    net: i32,
    is_odd: bool,
}

/// The edges at a point.
#[derive(Clone, Copy, Default)]
struct Balance {
    /// Those that begin less those that end.
    net: i32,
    is_odd: bool,
}

impl Edges {
    fn add(&mut self, from: u32, to: u32, weight: i32) {
        if from == to {
            return;
        }
        let (low, high) = (from.min(to), from.max(to));
        let place = match self.places.entry((low, high)) {
            Entry::Occupied(place) => *place.get(),
            Entry::Vacant(place) => {
                self.list.push(Edge { low, high, net: 0, is_odd: false });
                *place.insert(self.list.len() - 1)
            }
        };
        let edge = &mut self.list[place];
        edge.net = edge.net.saturating_add(if from < to { weight } else { weight.saturating_neg() });
        edge.is_odd ^= weight % 2 != 0;
    }

    fn balances(&self, points: usize) -> Vec<Balance> {
        let mut all = vec![Balance::default(); points];
        for edge in &self.list {
            for (point, net) in [(edge.low, edge.net), (edge.high, edge.net.saturating_neg())] {
                let balance = &mut all[point as usize];
                balance.net = balance.net.saturating_add(net);
                balance.is_odd ^= edge.is_odd;
            }
        }
        all
    }

    fn finish(self, points: Vec<[f32; 3]>, flat: Vec<[f64; 2]>) -> Outline {
        let balances = self.balances(points.len());
        let mut parts = Parts((0..points.len() as u32).collect());
        self.list.iter().for_each(|edge| parts.join(edge.low, edge.high));
        // For each part, by its lowest point: has it an end, and are its edges consistent?
        let mut is_open = vec![false; points.len()];
        let mut rule = Rule::NonZero;
        for (point, balance) in (0..).zip(&balances) {
            is_open[parts.find(point) as usize] |= balance.is_odd;
        }
        for (point, balance) in (0..).zip(&balances) {
            if balance.net != 0 && !is_open[parts.find(point) as usize] {
                rule = Rule::EvenOdd;
            }
        }
        let mut has_edges = vec![false; points.len()];
        let mut links = Vec::new();
        for edge in &self.list {
            let part = parts.find(edge.low) as usize;
            let weight = if rule == Rule::NonZero { edge.net } else { i32::from(edge.is_odd) };
            if weight == 0 {
                continue;
            }
            has_edges[part] = true;
            if !is_open[part] {
                links.push(Link { from: edge.low, to: edge.high, weight });
            }
        }
        let count =
            |open: bool| (0..points.len()).filter(|&p| has_edges[p] && is_open[p] == open).count() as u64;
        Outline { closed: count(false), open: count(true), points, flat, links, rule }
    }
}

/// Union-find; the root of a part is its lowest number.
struct Parts(Vec<u32>);

impl Parts {
    fn find(&mut self, mut v: u32) -> u32 {
        while self.0[v as usize] != v {
            let up = self.0[self.0[v as usize] as usize];
            self.0[v as usize] = up;
            v = up;
        }
        v
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
