//! Drops what cannot be drawn.

mod drops;
mod quick;

use std::collections::HashMap;
use std::ops::Range;

use crate::loops::prelude::*;
use fearless_simd::{Level, dispatch};
use serde::{Deserialize, Serialize};

use crate::Mesh;
use crate::hash::Key;
use crate::mesh::SAFE_MAGNITUDES;
use crate::weld::position_bits;

const CHUNK: usize = 1 << 15;

/// What [`clean`] found.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Cleaned {
    /// Triangles dropped because two corners are at the same position.
    pub duplicate_corner: u64,
    /// Triangles dropped because their three distinct corners are collinear.
    pub degenerate: u64,
    /// Triangles without area that were kept because they close a T-junction.
    pub stitching_kept: u64,
    /// Vertices whose position was not finite and was replaced.
    pub non_finite_vertices: u64,
    /// Triangles dropped because they used such a vertex.
    pub non_finite_triangles: u64,
}

impl Cleaned {
    /// Number of triangles dropped.
    pub fn total(&self) -> u64 {
        self.duplicate_corner + self.degenerate + self.non_finite_triangles
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Fault {
    NonFinite,
    DuplicateCorner,
    /// Collinear; the value is the longest edge, 0 to 2: edge k begins at corner k.
    Flat(u8),
}

/// Drops the triangles that cannot be drawn, in place; the others keep their order. No vertex is removed or
/// renumbered.
///
/// Dropped are triangles with a non-finite corner, with two corners at the same position, and those whose area is
/// exactly zero (their cross product in `f64` is). Of the last, those are kept that close a T-junction: their longest
/// edge and one of the others (by position) are used by other kept triangles. They cover no pixel of their own, but
/// without them the mesh would not be closed, and simplifying or smoothing it would tear it open there.
///
/// Non-finite positions become that of the first finite vertex, or zero, so that bounds stay finite. Positions so
/// large or so small that calculations with them would overflow or underflow `f32` get another unit
/// ([`Mesh::bring_into_range`]).
///
/// # Panics
///
/// If a triangle's vertex does not exist, or an array of the mesh is too short.
pub fn clean(mesh: &mut Mesh) -> Cleaned {
    let Drops { mut found, drops, .. } = find_drops(mesh, 0..mesh.triangles.len());
    let (non_finite, largest) = mend_positions(&mut mesh.positions);
    found.non_finite_vertices = non_finite;
    if !drops.is_empty() {
        drops::drop_triangles(mesh, &drops);
    }
    // Vertices that no triangle uses do not count. Nearly always one triangle shows that there is nothing to do.
    let first = mesh.triangles.first().map_or(0.0, |&t| largest_of(mesh, t));
    if !SAFE_MAGNITUDES.contains(&largest) || !SAFE_MAGNITUDES.contains(&first) {
        mesh.bring_into_range(largest_used(mesh, &(0..mesh.triangles.len())));
    }
    found
}

/// What [`clean_part`] did.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CleanedPart {
    /// Counts of the part's own triangles, and the non-finite vertices of all.
    pub found: Cleaned,
    /// The part's own triangles now.
    pub own: Range<usize>,
    /// The largest absolute value of a coordinate of them.
    pub largest: f32,
}

/// As [`clean`], for a part of a model, whose triangles are `own`, with those of other parts around it. The unit stays: it
/// depends on the whole model ([`Mesh::bring_into_range`]).
///
/// # Panics
/// As [`clean`].
pub fn clean_part(mesh: &mut Mesh, own: Range<usize>) -> CleanedPart {
    let Drops { mut found, drops } = find_drops(mesh, own.clone());
    (found.non_finite_vertices, _) = mend_positions(&mut mesh.positions);
    let before = |end: usize| end - drops.partition_point(|&t| (t as usize) < end);
    let own = before(own.start)..before(own.end);
    if !drops.is_empty() {
        drops::drop_triangles(mesh, &drops);
    }
    let largest = largest_used(mesh, &own);
    CleanedPart { found, own, largest }
}

/// Triangles that cannot be drawn.
struct Drops {
    /// Counts of some of the triangles.
    found: Cleaned,
    /// The numbers of all, in ascending order.
    drops: Vec<u32>,
}

/// Finds the triangles that are dropped, and counts those in `counted`.
fn find_drops(mesh: &Mesh, counted: Range<usize>) -> Drops {
    let mut found = Cleaned::default();
    let level = Level::new();
    let positions = &mesh.positions;
    let mut faults: Vec<(u32, Fault)> = mesh
        .triangles
        .par_chunks(CHUNK)
        .enumerate()
        .flat_map_iter(|(n, chunk)| {
            let mut suspects = Vec::new();
            dispatch!(level, _ => quick::find_suspects(positions, chunk, &mut suspects));
            suspects.into_iter().filter_map(move |k| {
                let fault = fault_of(chunk[k as usize].map(|v| positions[v as usize]))?;
                Some(((n * CHUNK) as u32 + k, fault))
            })
        })
        .collect();

    let flat: Vec<(u32, u8)> = faults
        .iter()
        .filter_map(|&(t, f)| if let Fault::Flat(longest) = f { Some((t, longest)) } else { None })
        .collect();
    if !flat.is_empty() {
        let faulty: Vec<u32> = faults.iter().map(|f| f.0).collect();
        let mut kept = stitching(mesh, &flat, &faulty).into_iter();
        faults.retain(|f| !matches!(f.1, Fault::Flat(_)) || !kept.next().unwrap_or(false));
    }
    let is_counted = |t: u32| counted.contains(&(t as usize));
    for (_, fault) in faults.iter().filter(|fault| is_counted(fault.0)) {
        match fault {
            Fault::NonFinite => found.non_finite_triangles += 1,
            Fault::DuplicateCorner => found.duplicate_corner += 1,
            Fault::Flat(_) => found.degenerate += 1,
        }
    }
    found.stitching_kept = flat.iter().filter(|flat| is_counted(flat.0)).count() as u64 - found.degenerate;
    Drops { found, drops: faults.iter().map(|f| f.0).collect() }
}

/// The largest absolute value of a coordinate of some triangles.
fn largest_used(mesh: &Mesh, triangles: &Range<usize>) -> f32 {
    let used = mesh.triangles[triangles.clone()].par_iter().with_min_len(CHUNK);
    used.map(|&t| largest_of(mesh, t)).reduce(|| 0.0, f32::max)
}

/// The largest absolute value of a coordinate of a triangle.
fn largest_of(mesh: &Mesh, triangle: [u32; 3]) -> f32 {
    let coordinates = triangle.map(|v| mesh.positions[v as usize]);
    coordinates.as_flattened().iter().fold(0.0, |most, c| most.max(c.abs()))
}

#[cold]
fn fault_of(corners: [[f32; 3]; 3]) -> Option<Fault> {
    if !corners.as_flattened().iter().all(|x| x.is_finite()) {
        return Some(Fault::NonFinite);
    }
    let [a, b, c] = corners;
    if a == b || b == c || c == a {
        return Some(Fault::DuplicateCorner);
    }
    let edge = |p: [f32; 3], q: [f32; 3]| std::array::from_fn(|k| f64::from(q[k]) - f64::from(p[k]));
    let [e, f, g]: [[f64; 3]; 3] = [edge(a, b), edge(b, c), edge(c, a)];
    let cross = [e[1] * g[2] - e[2] * g[1], e[2] * g[0] - e[0] * g[2], e[0] * g[1] - e[1] * g[0]];
    if cross != [0.0; 3] {
        return None;
    }
    let square = [e, f, g].map(|v| v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    let longest = (1..3).fold(0, |m, k| if square[k] > square[m] { k } else { m });
    Some(Fault::Flat(longest as u8))
}

type EdgeKey = [[u32; 3]; 2];

fn edge_key(a: [u32; 3], b: [u32; 3]) -> EdgeKey {
    if a <= b { [a, b] } else { [b, a] }
}

/// Which of the flat triangles (with the number of their longest edge) are kept; `faulty` are all triangles that may
/// be dropped, in order.
///
/// Flat triangles may support each other (several points on one long edge), so all begin as kept, and those without
/// support are dropped until every remaining one is supported.
fn stitching(mesh: &Mesh, flat: &[(u32, u8)], faulty: &[u32]) -> Vec<bool> {
    let corners = |t: u32| mesh.triangles[t as usize].map(|v| position_bits(mesh.positions[v as usize]));

    // Number the edges of the flat triangles.
    let mut number_of: HashMap<EdgeKey, u32> = HashMap::new();
    let edges: Vec<[u32; 3]> = flat
        .iter()
        .map(|&(t, _)| {
            let c = corners(t);
            std::array::from_fn(|k| {
                let next = number_of.len() as u32;
                *number_of.entry(edge_key(c[k], c[(k + 1) % 3])).or_insert(next)
            })
        })
        .collect();

    // Count their uses by good triangles. A bit per hash of a position saves most look-ups.
    let bits = (flat.len() * 64).next_power_of_two().max(1 << 12);
    let mut met = vec![0u64; bits / 64];
    let key = Key::of_this_run();
    let bit = |c: [u32; 3]| key.of_three(c) as usize & (bits - 1);
    for &(t, _) in flat {
        for c in corners(t) {
            met[bit(c) / 64] |= 1 << (bit(c) % 64);
        }
    }
    let mut uses = vec![0u32; number_of.len()];
    let hits: Vec<u32> = (0..mesh.triangles.len() as u32)
        .into_par_iter()
        .with_min_len(CHUNK)
        .flat_map_iter(|t| {
            let c = corners(t);
            let m = c.map(|c| met[bit(c) / 64] >> (bit(c) % 64) & 1 == 1);
            (0..3)
                .filter_map(move |k| {
                    let n = (k + 1) % 3;
                    (m[k] && m[n]).then(|| edge_key(c[k], c[n]))
                })
                .filter(move |_| faulty.binary_search(&t).is_err())
                .filter_map(|key| number_of.get(&key).copied())
        })
        .collect();
    hits.into_iter().chain(edges.iter().flatten().copied()).for_each(|e| uses[e as usize] += 1);

    // The flat triangles at each edge, to recheck them when a neighbour is dropped.
    let mut at_edge: Vec<(u32, u32)> = Vec::with_capacity(edges.len() * 3);
    for (i, e) in edges.iter().enumerate() {
        at_edge.extend(e.iter().map(|&e| (e, i as u32)));
    }
    at_edge.sort_unstable();

    let mut kept = vec![true; flat.len()];
    let mut doubtful: Vec<u32> = (0..flat.len() as u32).collect();
    while let Some(i) = doubtful.pop() {
        let (e, longest) = (edges[i as usize], flat[i as usize].1 as usize);
        let shared = |k: usize| uses[e[k % 3] as usize] > 1;
        if !kept[i as usize] || shared(longest) && (shared(longest + 1) || shared(longest + 2)) {
            continue;
        }
        kept[i as usize] = false;
        for edge in e {
            uses[edge as usize] -= 1;
            if uses[edge as usize] == 1 {
                let first = at_edge.partition_point(|&(x, _)| x < edge);
                doubtful.extend(at_edge[first..].iter().take_while(|x| x.0 == edge).map(|x| x.1));
            }
        }
    }
    kept
}

/// Replaces non-finite positions; returns how many there were, and the largest absolute value of a finite coordinate.
fn mend_positions(positions: &mut [[f32; 3]]) -> (u64, f32) {
    let finite = |p: &[f32; 3]| p.iter().all(|x| x.is_finite());
    let (bad, largest) = positions
        .par_chunks(CHUNK)
        .map(|chunk| {
            // Without their signs, numbers are ordered as their bits are, and infinity and NaN come behind all others.
            let bits = chunk.as_flattened().iter().map(|c| (c.to_bits() << 1 >> 1) as i32);
            let largest = f32::from_bits(bits.fold(0, i32::max) as u32);
            if largest < f32::INFINITY {
                return (0, largest);
            }
            let bad = chunk.iter().filter(|p| !finite(p)).count() as u64;
            // Infinity and NaN are left out: they do not compare as less than infinity.
            let magnitudes = chunk.as_flattened().iter().map(|c| c.abs());
            (bad, magnitudes.fold(0.0f32, |most, c| if c > most && c < f32::INFINITY { c } else { most }))
        })
        .reduce(|| (0, 0.0), |a, b| (a.0 + b.0, a.1.max(b.1)));
    if bad > 0 {
        let substitute = positions.iter().copied().find(finite).unwrap_or_default();
        positions.par_iter_mut().filter(|p| !finite(p)).for_each(|p| *p = substitute);
    }
    (bad, largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Attribute, AttributeDomain};
    use proptest::prelude::*;

    fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
        Mesh { positions: positions.to_vec(), triangles: triangles.to_vec(), ..Mesh::default() }
    }

    #[test]
    fn each_fault_is_counted_and_all_arrays_stay_parallel() {
        let nan = f32::NAN;
        let mut m = mesh(
            &[
                [0., 0., 0.],
                [1., 0., 0.],
                [0., 1., 0.],
                [2., 0., 0.],
                [nan, 0., 0.],
                [1., 0., -0.0],
                [f32::INFINITY, 7., 1.],
            ],
            &[[0, 1, 2], [0, 1, 1], [0, 1, 3], [1, 3, 2], [0, 4, 1], [0, 1, 5], [2, 6, 0], [2, 1, 0]],
        );
        m.face_colors = Some((0..8).map(|i| [i; 4]).collect());
        m.triangle_materials = Some((0..8).collect());
        m.attributes.push(Attribute {
            name: "a".into(),
            domain: AttributeDomain::Triangle,
            values: (0..8u8).map(f32::from).collect(),
            offset: 0.0,
            component: None,
        });
        let found = clean(&mut m);
        let expected = Cleaned {
            duplicate_corner: 2,
            degenerate: 1,
            stitching_kept: 0,
            non_finite_vertices: 2,
            non_finite_triangles: 2,
        };
        assert_eq!(found, expected);
        assert_eq!(found.total(), 5);
        assert_eq!(m.triangles, [[0, 1, 2], [1, 3, 2], [2, 1, 0]]);
        assert_eq!(m.face_of_triangle.as_deref(), Some(&[0, 3, 7][..]));
        assert_eq!(m.triangle_materials.as_deref(), Some(&[0, 3, 7][..]));
        assert_eq!(m.face_colors.as_deref(), Some(&[[0; 4], [3; 4], [7; 4]][..]));
        assert_eq!(m.attributes[0].values, [0., 3., 7.]);
        assert_eq!(m.positions[4], [0.0; 3]);
        assert_eq!(clean(&mut m), Cleaned::default());
    }

    #[test]
    fn flat_triangles_that_close_t_junctions_are_kept() {
        // A large triangle below the x axis, small ones above it that meet at (1, 0), (2, 0) and (3, 0), and flat
        // ones between: one is supported by the two others.
        let p = [
            [0., 0., 0.],
            [1., 0., 0.],
            [2., 0., 0.],
            [3., 0., 0.],
            [4., 0., 0.],
            [2., -2., 0.],
            [2., 2., 0.],
            [9., 0., 0.],
        ];
        let good = [[0, 5, 4], [0, 1, 6], [1, 2, 6], [2, 3, 6], [3, 4, 6]];
        let stitches = [[0, 4, 2], [0, 2, 1], [2, 4, 3]];
        let mut m = mesh(&p, &[&good[..], &stitches, &[[0, 4, 7]]].concat());
        let found = clean(&mut m);
        assert_eq!((found.stitching_kept, found.degenerate), (3, 1));
        assert_eq!(m.triangles.len(), 8);
        // Without the large triangle there is nothing to stitch to.
        let mut m = mesh(&p, &[&good[1..], &stitches].concat());
        let found = clean(&mut m);
        assert_eq!((found.stitching_kept, found.degenerate), (0, 3));
        assert_eq!(m.triangles, good[1..]);
    }

    #[test]
    fn very_small_and_very_large_triangles_are_kept() {
        for s in [1e-38f32, 1e-20, 1.0, 1e19, 3e38] {
            let mut m = mesh(&[[0., 0., 0.], [s, 0., 0.], [0., 0., s]], &[[0, 1, 2]]);
            assert_eq!(clean(&mut m).total(), 0, "{s}");
        }
        // A NaN in a coordinate that does not enter the nonzero component of the cross product.
        let mut m = mesh(&[[0., 0., f32::NAN], [1., 0., 0.], [0., 1., 0.]], &[[0, 1, 2]]);
        assert_eq!(clean(&mut m).non_finite_triangles, 1);
        let mut m = mesh(&[[0., 0., 0.], [1., 0., 0.], [0., 1., f32::NEG_INFINITY]], &[[0, 1, 2]]);
        assert_eq!(clean(&mut m).non_finite_triangles, 1);
    }

    proptest! {
        #[test]
        fn what_is_kept_is_good_and_cleaning_again_does_nothing(
            p in prop::collection::vec(prop::array::uniform3((0u8..4).prop_map(f32::from)), 1..40),
            t in prop::collection::vec(prop::array::uniform3(any::<prop::sample::Index>()), 0..200),
        ) {
            let t: Vec<[u32; 3]> = t.iter().map(|t| [0, 1, 2].map(|k| t[k].index(p.len()) as u32)).collect();
            let mut m = mesh(&p, &t);
            let found = clean(&mut m);
            prop_assert_eq!(t.len() as u64, m.triangles.len() as u64 + found.total());
            if let Some(face) = &m.face_of_triangle {
                let left: Vec<_> = face.iter().map(|&f| t[f as usize]).collect();
                prop_assert_eq!(&left, &m.triangles);
            }
            let flat = m.triangles.iter().filter(|t| fault_of(t.map(|v| p[v as usize])).is_some()).count();
            prop_assert_eq!(flat as u64, found.stitching_kept);
            let again = clean(&mut m);
            prop_assert_eq!(again.total(), 0);
            prop_assert_eq!(again.stitching_kept, found.stitching_kept);
        }
    }
}
