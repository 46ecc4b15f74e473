//! Finds the edges of an indexed mesh.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use glam::{DVec3, Vec3};

use crate::loops::prelude::*;

use super::polygons::{self, BentSide, Corners, Joined, OfPolygons};
use super::{Edge, EdgeKind, Edges, Folds, Selection, bend, normals_beside};
use crate::Mesh;
use crate::adjacency::Adjacency;
use crate::topology::Parts;
use crate::trig::sin_cos;
use crate::weld::position_representatives;

/// A triangle at an edge, seen from the end with the lower number.
#[derive(Clone, Copy)]
struct Beside {
    /// The other end.
    to: u32,
    triangle: u32,
    /// Number of the corner of the triangle at which the edge begins.
    corner: u8,
    apex: u32,
    /// Whether the triangle runs towards the other end.
    away: bool,
}

/// An edge, and its place in the order: three times its first triangle, plus a corner of it.
type Placed = (u64, Edge);

/// A polygon: the input face, and the bits of its [`Attribute::POLYGON`](crate::Attribute::POLYGON).
pub type Polygon = (u32, u32);

/// What was found in a part of the mesh.
#[derive(Default)]
struct Found {
    edges: Vec<Placed>,
    /// Sides that are no edges, if all edges are selected.
    joined: Vec<Joined>,
    /// Edges at which an odd number of triangles meets, or not as many run one way as the other.
    open: u64,
    /// Edges of more than two triangles.
    crowded: u64,
}

/// The selected edges; `polygon` is the one that a triangle comes from: two triangles of the same are not divided by an edge. The edges
/// of a triangle are in the order of its corners, of which `turned` says which one is first.
pub fn edges(
    mesh: &Mesh,
    selection: Selection,
    polygon: impl Fn(u32) -> Polygon + Sync,
    turned: impl Fn([u32; 3]) -> [u32; 3] + Sync,
) -> Edges {
    let same = position_representatives(mesh);
    let around = Adjacency::new(&mesh.triangles, mesh.positions.len(), |v| same[v as usize]);
    let sides: Vec<AtomicU8> = mesh.triangles.iter().map(|_| AtomicU8::new(0)).collect();
    let parts = Parts::new(mesh.triangles.len());
    let finder = Finder {
        mesh,
        same: &same,
        around: &around,
        sides: &sides,
        parts: &parts,
        polygon,
        turned: &turned,
        selection,
    };
    let found = (0..mesh.positions.len() as u32)
        .into_par_iter()
        .with_min_len(1 << 12)
        .fold(
            || (Found::default(), Vec::new()),
            |(mut found, mut scratch), v| {
                finder.at_vertex(v, &mut scratch, &mut found);
                (found, scratch)
            },
        )
        .map(|(found, _)| found)
        .reduce(Found::default, |mut a, b| {
            a.edges.extend(b.edges);
            a.joined.extend(b.joined);
            Found { open: a.open + b.open, crowded: a.crowded + b.crowded, ..a }
        });
    let Found { edges: mut placed, joined, open, crowded } = found;
    placed.par_sort_unstable_by_key(|edge| edge.0);

    // Vertices in the order in which edges use them, whatever their numbers in the mesh.
    let mut numbers = vec![Edge::NONE; mesh.positions.len()];
    let mut positions = Vec::new();
    let mut number = |v: u32| {
        let known = &mut numbers[v as usize];
        if *known == Edge::NONE {
            *known = positions.len() as u32;
            positions.push(mesh.positions[v as usize]);
        }
        *known
    };
    let list: Vec<Edge> = placed
        .into_iter()
        .map(|(_, edge)| Edge {
            ends: edge.ends.map(&mut number),
            apexes: edge.apexes.map(|v| if v == Edge::NONE { v } else { number(v) }),
            ..edge
        })
        .collect();
    let positions = Arc::new(positions);
    let is_solid = open == 0 && !mesh.triangles.is_empty();
    let is_outward = is_solid && crowded == 0 && all_parts_are_outward(mesh, &parts);
    let sides: Vec<u8> = sides.into_iter().map(AtomicU8::into_inner).collect();
    let corners = |t: u32| turned(mesh.triangles[t as usize]);
    let at = |t: u32, corner: u8| {
        DVec3::from(mesh.positions[corners(t)[usize::from(corner)] as usize].map(f64::from))
    };
    let vertex = |t: u32, corner: u8| same[corners(t)[usize::from(corner)] as usize];
    let of_polygons = polygons::of_polygons(&sides, &joined, Corners { at, vertex }, &numbers, &positions);
    let OfPolygons { beyond, bent, slivers } = of_polygons;
    let vertex = |t: u32, corner: u8| numbers[vertex(t, corner) as usize];
    let bounds = positions
        .iter()
        .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[min, max], &p| [min.min(p.into()), max.max(p.into())]);
    let of_list = |list: Vec<Edge>| Edges {
        origin: mesh.origin,
        exponent: mesh.exponent,
        positions: Arc::clone(&positions),
        list,
        is_solid,
        is_outward,
        bounds,
        ..Edges::default()
    };
    // The triangle that an edge is listed for is the first one that has both of its ends.
    let number_of = |(t, from): (u32, u8)| {
        let ends = [from, (from + 1) % 3].map(|corner| corners(t)[usize::from(corner)]);
        let ends = ends.map(|v| same[v as usize]);
        let has_both = |t: &&u32| {
            let all = mesh.triangles[**t as usize].map(|v| same[v as usize]);
            ends.iter().all(|end| all.contains(end))
                && all[0] != all[1]
                && all[1] != all[2]
                && all[2] != all[0]
        };
        // Of one of its ends that has few: time stays linear where many edges begin at one vertex.
        let few = ends.iter().map(|&end| around.at(end as usize)).min_by_key(|triangles| triangles.len())?;
        let first = few.iter().filter(has_both).min()?;
        let ends = ends.map(|v| numbers[v as usize]);
        let start = list.partition_point(|edge| edge.triangle < *first);
        let is_it = |edge: &&Edge| edge.ends == ends || edge.ends == [ends[1], ends[0]];
        let of_first = list[start..].iter().take_while(|edge| edge.triangle == *first);
        of_first.zip(start as u32..).find(|(edge, _)| is_it(edge)).map(|(_, number)| number)
    };
    let folds = (!bent.is_empty() || !slivers.is_empty()).then(|| {
        let edge =
            |BentSide { joined: Joined { triangles: [a, b], corners: [of_a, of_b] }, .. }: &BentSide| Edge {
                ends: [vertex(*a, *of_a), vertex(*a, (of_a + 1) % 3)],
                apexes: [vertex(*a, (of_a + 2) % 3), vertex(*b, (of_b + 2) % 3)],
                kind: EdgeKind::Inner,
                triangle: *a,
            };
        let numbers = |fold: &BentSide| fold.edges.map(|side| side.and_then(number_of).unwrap_or(Edge::NONE));
        // A vertex that no edge uses, inside of a polygon, has no number.
        let is_known = |edge: &Edge| !edge.ends.iter().chain(&edge.apexes).any(|&v| v == Edge::NONE);
        let all: Vec<(Edge, [u32; 4])> = bent.par_iter().map(|fold| (edge(fold), numbers(fold))).collect();
        let (list, edges) = all.into_iter().filter(|(edge, _)| is_known(edge)).unzip();
        let slivers = slivers.into_par_iter().filter_map(number_of).collect();
        Box::new(Folds { sides: of_list(list), edges, slivers })
    });
    Edges { sides, beyond, folds, ..of_list(list) }
}

/// Does each part of a closed surface have its outside on the outside: is its volume, as its triangles are wound, above 0?
fn all_parts_are_outward(mesh: &Mesh, parts: &Parts) -> bool {
    // One after another: the volume must not depend on the threads.
    let mut volumes = vec![0.0; mesh.triangles.len()];
    let origin = mesh.positions.first().copied().unwrap_or_default();
    let at =
        |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from)) - DVec3::from(origin.map(f64::from));
    for (triangle, &[a, b, c]) in (0..).zip(&mesh.triangles) {
        volumes[parts.find(triangle) as usize] += at(a).dot(at(b).cross(at(c)));
    }
    // A triangle without area is a part of its own, and has no volume.
    volumes.iter().all(|&volume| volume >= 0.0)
}

struct Finder<'a, F, T> {
    mesh: &'a Mesh,
    same: &'a [u32],
    around: &'a Adjacency,
    /// [`Edges::sides`].
    sides: &'a [AtomicU8],
    /// Triangles that are connected by edges of two.
    parts: &'a Parts,
    polygon: F,
    turned: T,
    selection: Selection,
}

impl<F: Fn(u32) -> Polygon, T: Fn([u32; 3]) -> [u32; 3]> Finder<'_, F, T> {
    /// Finds the edges from a vertex to those with higher numbers.
    fn at_vertex(&self, v: u32, scratch: &mut Vec<Beside>, found: &mut Found) {
        scratch.clear();
        for &triangle in self.around.at(v as usize) {
            let c = (self.turned)(self.mesh.triangles[triangle as usize]).map(|v| self.same[v as usize]);
            if c[0] == c[1] || c[1] == c[2] || c[2] == c[0] {
                continue;
            }
            for corner in 0..3 {
                let (from, to, apex) = (c[corner], c[(corner + 1) % 3], c[(corner + 2) % 3]);
                let corner = corner as u8;
                if from == v && to > v {
                    scratch.push(Beside { to, triangle, corner, apex, away: true });
                } else if to == v && from > v {
                    scratch.push(Beside { to: from, triangle, corner, apex, away: false });
                }
            }
        }
        scratch.sort_unstable_by_key(|beside| (beside.to, beside.triangle));
        for group in scratch.chunk_by(|a, b| a.to == b.to) {
            self.edge(v, group, found);
        }
    }

    /// Adds an edge, if it is selected, with all triangles at it.
    fn edge(&self, v: u32, group: &[Beside], found: &mut Found) {
        let away = group.iter().filter(|beside| beside.away).count();
        found.open += u64::from(2 * away != group.len());
        found.crowded += u64::from(group.len() > 2);
        if let [a, b] = group {
            self.parts.join(a.triangle, b.triangle);
        }
        let kind = match group.len() {
            1 => EdgeKind::Boundary,
            2 => EdgeKind::Inner,
            _ => EdgeKind::NonManifold,
        };
        // Any fold may be an outline, also one inside of a polygon.
        let joins_polygon = self.selection != Selection::Silhouette;
        if let [a, b] = group {
            let is_joined = joins_polygon && (self.polygon)(a.triangle) == (self.polygon)(b.triangle);
            if is_joined && self.selection == Selection::All {
                let (triangles, corners) = ([a.triangle, b.triangle], [a.corner, b.corner]);
                found.joined.push(Joined { triangles, corners });
            }
            if is_joined || !self.is_selected(v, a, b) {
                return;
            }
        }
        for beside in group {
            // The side from a corner to the next one is opposite to the third.
            let side = (beside.corner + 2) % 3;
            self.sides[beside.triangle as usize].fetch_or(1 << side, Ordering::Relaxed);
        }
        for pair in group.chunks(2) {
            let first = pair[0];
            let ends = if first.away { [v, first.to] } else { [first.to, v] };
            let apexes = [first.apex, pair.get(1).map_or(Edge::NONE, |second| second.apex)];
            let place = 3 * u64::from(first.triangle) + u64::from(first.corner);
            found.edges.push((place, Edge { ends, apexes, kind, triangle: first.triangle }));
        }
    }

    /// Is an edge between two triangles selected?
    fn is_selected(&self, v: u32, a: &Beside, b: &Beside) -> bool {
        let most = match self.selection {
            Selection::All => return true,
            Selection::Boundary => return false,
            Selection::Feature(angle) => angle,
            Selection::Silhouette => 0.0,
        };
        let at = |v: u32| DVec3::from(self.mesh.positions[v as usize].map(f64::from));
        let (sin, cos) = bend(normals_beside(at(v), at(a.to), [at(a.apex), at(b.apex)]));
        if self.selection == Selection::Silhouette {
            // What is flat up to rounding is never a silhouette.
            return sin > 1e-9 * cos.abs() || cos < 0.0;
        }
        let (sin_bend, cos_bend) = sin_cos(most.clamp(0.0, std::f64::consts::PI));
        sin * cos_bend - cos * sin_bend > 0.0
    }
}
