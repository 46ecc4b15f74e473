//! Joins vertices at the same position.
//!
//! Vertices are distributed by the hash of their content into shards small enough for the cache, and each shard is
//! searched for equal ones by one task, in the order of vertex numbers. So the result depends neither on the number
//! of threads nor on the key of the hash.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::loops::prelude::*;

use crate::hash::Key;
use crate::{AttributeDomain, Mesh};

/// Vertices that one task distributes at a time.
const CHUNK: usize = 1 << 18;
/// Vertices in a shard, on average.
const SHARD: usize = 1 << 13;
/// Vertices that are distributed at once; more are processed in rounds, to bound the memory.
const ROUND: usize = 1 << 24;

/// Joins vertices whose positions have equal bits (-0 counts as 0) and whose other data (normal, colour, texture
/// coordinates, vertex attributes) are equal too. Returns the number of removed vertices.
///
/// The first of equal vertices is kept, and kept vertices kept in order. Triangles keep their order and corners.
/// Vertices that no triangle uses are joined like all others.
///
/// # Panics
///
/// If an array of the mesh is too short for its vertices, or a triangle's vertex does not exist.
pub fn weld(mesh: &mut Mesh) -> u64 {
    let same = {
        let mesh = &*mesh;
        let data = VertexData::of(mesh);
        if data.is_empty() {
            first_at_position(&mesh.positions)
        } else {
            let key = Key::of_this_run();
            first_equals(&mesh.positions, key, |v| data.hash(key, v), |a, b| data.equal(a, b))
        }
    };

    // Numbers of the vertices that are kept.
    let kept: Vec<u32> = same
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(n, chunk)| {
            chunk.iter().enumerate().filter(|&(k, &s)| s as usize == n * CHUNK + k).count() as u32
        })
        .collect();
    let total: u32 = kept.iter().sum();
    let gone = same.len() as u64 - u64::from(total);
    if gone == 0 {
        return 0;
    }
    let firsts: Vec<u32> = kept.iter().scan(0, |sum, &n| Some(std::mem::replace(sum, *sum + n))).collect();
    let mut numbers = vec![0u32; same.len()];
    numbers.par_chunks_mut(CHUNK).zip(same.par_chunks(CHUNK)).zip(firsts).enumerate().for_each(
        |(n, ((numbers, same), mut next))| {
            for (k, (number, &s)) in numbers.iter_mut().zip(same).enumerate() {
                if s as usize == n * CHUNK + k {
                    *number = next;
                    next += 1;
                }
            }
        },
    );

    mesh.triangles.par_iter_mut().for_each(|t| *t = t.map(|v| numbers[same[v as usize] as usize]));
    drop(numbers);
    keep_firsts(&mut mesh.positions, &same);
    mesh.normals.iter_mut().for_each(|a| keep_firsts(a, &same));
    mesh.vertex_colors.iter_mut().for_each(|a| keep_firsts(a, &same));
    mesh.texcoords.iter_mut().for_each(|a| keep_firsts(a, &same));
    for a in &mut mesh.attributes {
        if a.domain == AttributeDomain::Vertex {
            keep_firsts(&mut a.values, &same);
        }
    }
    gone
}

/// For each vertex the lowest vertex number with the same position (-0 counts as 0).
pub fn position_representatives(mesh: &Mesh) -> Vec<u32> {
    first_at_position(&mesh.positions)
}

/// For each position the index of the first equal one (-0 counts as 0).
pub(crate) fn first_at_position(positions: &[[f32; 3]]) -> Vec<u32> {
    first_equals(positions, Key::of_this_run(), |_| 0, |_, _| true)
}

/// True if every vertex number is used exactly once: a list of unconnected triangles, as in STL files.
pub fn is_soup(mesh: &Mesh) -> bool {
    let vertices = mesh.positions.len();
    if vertices != mesh.triangles.len() * 3 {
        return false;
    }
    let in_order = |(i, t): (usize, &[u32; 3])| {
        let first = 3 * i as u64;
        t.iter().zip(first..).all(|(&v, k)| u64::from(v) == k)
    };
    if mesh.triangles.par_iter().enumerate().all(in_order) {
        return true;
    }
    let words: Vec<AtomicU32> = (0..vertices.div_ceil(32)).map(|_| AtomicU32::new(0)).collect();
    mesh.triangles.par_iter().all(|t| {
        t.iter().all(|&v| words[v as usize / 32].fetch_or(1 << (v % 32), Relaxed) >> (v % 32) & 1 == 0)
    })
}

fn keep_firsts<T: Copy>(array: &mut Vec<T>, same: &[u32]) {
    let mut to = 0;
    for (from, &s) in same.iter().enumerate() {
        if s as usize == from {
            array[to] = array[from];
            to += 1;
        }
    }
    array.truncate(to);
    array.shrink_to_fit();
}

/// The bits of a position, with -0 stored as 0.
#[inline]
pub fn position_bits(p: [f32; 3]) -> [u32; 3] {
    p.map(|x| if x == 0.0 { 0 } else { x.to_bits() })
}

/// The data of vertices besides their position.
struct VertexData<'a> {
    normals: &'a [crate::OctNormal],
    colors: &'a [[u8; 4]],
    texcoords: &'a [[f32; 2]],
    attributes: Vec<&'a [f32]>,
}

impl<'a> VertexData<'a> {
    fn of(mesh: &'a Mesh) -> Self {
        Self {
            normals: mesh.normals.as_deref().unwrap_or_default(),
            colors: mesh.vertex_colors.as_deref().unwrap_or_default(),
            texcoords: mesh.texcoords.as_deref().unwrap_or_default(),
            attributes: mesh
                .attributes
                .iter()
                .filter(|a| a.domain == AttributeDomain::Vertex)
                .map(|a| a.values.as_slice())
                .collect(),
        }
    }

    fn is_empty(&self) -> bool {
        self.normals.is_empty()
            && self.colors.is_empty()
            && self.texcoords.is_empty()
            && self.attributes.is_empty()
    }

    fn hash(&self, key: Key, v: usize) -> u64 {
        let mut h = 0;
        if let Some(n) = self.normals.get(v) {
            h = key.add(h, u64::from(n.0));
        }
        if let Some(&c) = self.colors.get(v) {
            h = key.add(h, u64::from(u32::from_le_bytes(c)));
        }
        if let Some(t) = self.texcoords.get(v) {
            h = key.add(h, u64::from(t[0].to_bits()) | u64::from(t[1].to_bits()) << 32);
        }
        self.attributes.iter().fold(h, |h, a| key.add(h, u64::from(a[v].to_bits())))
    }

    fn equal(&self, a: usize, b: usize) -> bool {
        let bits = |t: [f32; 2]| t.map(f32::to_bits);
        self.normals.get(a) == self.normals.get(b)
            && self.colors.get(a) == self.colors.get(b)
            && self.texcoords.get(a).copied().map(bits) == self.texcoords.get(b).copied().map(bits)
            && self.attributes.iter().all(|x| x[a].to_bits() == x[b].to_bits())
    }
}

/// A vertex to be put into a shard, with all that most comparisons need.
#[derive(Clone, Copy, Default)]
struct Entry {
    hash: u32,
    vertex: u32,
    position: [u32; 3],
}

/// For each vertex the lowest one with the same position and, according to `equal`, the same other data; `data_hash`
/// is a hash of that data.
fn first_equals(
    positions: &[[f32; 3]],
    key: Key,
    data_hash: impl Fn(usize) -> u64 + Sync,
    equal: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<u32> {
    let n = positions.len();
    let rounds = n.div_ceil(ROUND).clamp(1, 8);
    let shards = (n / rounds / SHARD).next_power_of_two();
    let hash = |v: usize| key.of_three(position_bits(positions[v])) ^ data_hash(v);
    // The upper half of the hash, as a fraction, selects the round and the shard; its low half is left for the table.
    let bucket = |h: u64| (((h >> 32) * (rounds * shards) as u64) >> 32) as usize;

    let result: Vec<AtomicU32> = (0..n).into_par_iter().map(|_| AtomicU32::new(0)).collect();
    let starts: Vec<usize> = (0..n).step_by(CHUNK).collect();
    for round in 0..rounds {
        let first_bucket = round * shards;
        let distributed: Vec<(Vec<Entry>, Vec<u32>)> = starts
            .par_iter()
            .map(|&start| {
                distribute(
                    start..n.min(start + CHUNK),
                    positions,
                    hash,
                    |h| bucket(h).checked_sub(first_bucket).filter(|&s| s < shards),
                    shards,
                )
            })
            .collect();

        (0..shards).into_par_iter().for_each_init(Vec::new, |table: &mut Vec<(u32, u32)>, shard| {
            let pieces = || {
                distributed.iter().map(|(list, ends)| {
                    let begin = if shard == 0 { 0 } else { ends[shard - 1] };
                    &list[begin as usize..ends[shard] as usize]
                })
            };
            // At most half full; an entry is a piece number and an index in the piece, or a hole.
            const HOLE: (u32, u32) = (u32::MAX, 0);
            let count: usize = pieces().map(<[_]>::len).sum();
            let mask = (count * 2).next_power_of_two() - 1;
            table.clear();
            table.resize(mask + 1, HOLE);
            let list: Vec<&[Entry]> = pieces().collect();
            for (p, piece) in list.iter().enumerate() {
                for (i, d) in piece.iter().enumerate() {
                    let mut slot = d.hash as usize & mask;
                    let first = loop {
                        if table[slot] == HOLE {
                            table[slot] = (p as u32, i as u32);
                            break d.vertex;
                        }
                        let (q, j) = table[slot];
                        let other = &list[q as usize][j as usize];
                        if other.hash == d.hash
                            && other.position == d.position
                            && equal(other.vertex as usize, d.vertex as usize)
                        {
                            break other.vertex;
                        }
                        slot = (slot + 1) & mask;
                    };
                    result[d.vertex as usize].store(first, Relaxed);
                }
            }
        });
    }
    result.into_iter().map(AtomicU32::into_inner).collect()
}

/// The vertices of a range sorted by shard, and where each shard ends.
fn distribute(
    range: std::ops::Range<usize>,
    positions: &[[f32; 3]],
    hash: impl Fn(usize) -> u64,
    shard_of: impl Fn(u64) -> Option<usize>,
    shards: usize,
) -> (Vec<Entry>, Vec<u32>) {
    let mut ends = vec![0u32; shards];
    for v in range.clone() {
        if let Some(s) = shard_of(hash(v)) {
            ends[s] += 1;
        }
    }
    let mut sum = 0;
    for e in &mut ends {
        (*e, sum) = (sum, sum + *e);
    }
    let mut list = vec![Entry::default(); sum as usize];
    for v in range {
        let h = hash(v);
        if let Some(s) = shard_of(h) {
            list[ends[s] as usize] =
                Entry { hash: h as u32, vertex: v as u32, position: position_bits(positions[v]) };
            ends[s] += 1;
        }
    }
    (list, ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Attribute;
    use proptest::prelude::*;

    /// A soup on a coarse lattice, so that many corners coincide.
    fn soup(corners: &[[i8; 3]]) -> Mesh {
        let n = corners.len() / 3;
        Mesh {
            positions: corners[..n * 3]
                .iter()
                .map(|c| c.map(|x| if x == 9 { -0.0 } else { x.into() }))
                .collect(),
            triangles: (0..n as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            ..Mesh::default()
        }
    }

    fn corners_of(mesh: &Mesh) -> Vec<[[u32; 3]; 3]> {
        mesh.triangles.iter().map(|t| t.map(|v| position_bits(mesh.positions[v as usize]))).collect()
    }

    proptest! {
        #[test]
        fn no_triangle_changes_and_a_second_weld_does_nothing(
            corners in prop::collection::vec(prop::array::uniform3(prop_oneof![-2i8..3, Just(9)]), 0..400),
            split: bool,
        ) {
            let mut mesh = soup(&corners);
            if split {
                mesh.vertex_colors = Some((0..mesh.positions.len()).map(|v| [(v % 2) as u8; 4]).collect());
                mesh.attributes.push(Attribute {
                    name: "q".into(),
                    domain: AttributeDomain::Vertex,
                    values: (0..mesh.positions.len()).map(|v| (v % 3) as f32).collect(), offset: 0.0, component: None });
            }
            let before = mesh.clone();
            let key = |m: &Mesh, v: usize| (
                position_bits(m.positions[v]),
                m.vertex_colors.as_ref().map(|c| c[v]),
                m.attributes.first().map(|a| a.values[v].to_bits()),
            );
            let gone = weld(&mut mesh);
            // The naive way: a list of the vertices found.
            let mut seen = Vec::new();
            for v in 0..before.positions.len() {
                let k = key(&before, v);
                if !seen.contains(&k) {
                    seen.push(k);
                }
            }
            prop_assert_eq!(gone as usize, before.positions.len() - seen.len());
            let after: Vec<_> = (0..mesh.positions.len()).map(|v| key(&mesh, v)).collect();
            prop_assert_eq!(after, seen);
            prop_assert_eq!(corners_of(&mesh), corners_of(&before));
            prop_assert_eq!(weld(&mut mesh), 0);
        }
    }

    #[test]
    fn representatives_are_the_lowest_and_do_not_depend_on_threads() {
        let positions: Vec<[f32; 3]> = (0..700_000u32)
            .map(|i| [(i.wrapping_mul(2_654_435_761) >> 7) as f32 % 1000.0, (i % 97) as f32, 0.5])
            .collect();
        let mut firsts = std::collections::HashMap::new();
        let expected: Vec<u32> =
            positions.iter().zip(0..).map(|(p, i)| *firsts.entry(p.map(f32::to_bits)).or_insert(i)).collect();
        let mesh = Mesh { positions, ..Mesh::default() };
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| position_representatives(&mesh)), expected);
        }
    }

    #[test]
    fn the_key_changes_nothing_but_the_hash() {
        let positions: Vec<[f32; 3]> =
            (0..60_000u32).map(|i| [(i * 7 % 101) as f32, (i % 89) as f32, (i % 3) as f32]).collect();
        let firsts = |seed| first_equals(&positions, Key::fixed(seed), |_| 0, |_, _| true);
        let expected = firsts(1);
        assert!((2..8).all(|seed| firsts(seed) == expected));
        assert_eq!(first_at_position(&positions), expected);
    }

    #[test]
    fn vertices_of_one_position_are_distinguished_without_comparing_all_pairs() {
        let n = 300_000;
        let mut mesh = Mesh {
            positions: vec![[1.0; 3]; n],
            texcoords: Some((0..n).map(|i| [i as f32, 0.0]).collect()),
            ..Mesh::default()
        };
        // If the hash ignored any data in which they differ, this would be called billions of times.
        let data = VertexData::of(&mesh);
        let comparisons = AtomicU32::new(0);
        let key = Key::of_this_run();
        let equal = |a, b| {
            comparisons.fetch_add(1, Relaxed);
            data.equal(a, b)
        };
        let firsts = first_equals(&mesh.positions, key, |v| data.hash(key, v), equal);
        assert!(firsts.iter().zip(0..).all(|(&first, v)| first == v));
        assert!(comparisons.load(Relaxed) < 1000, "{comparisons:?} comparisons");
        assert_eq!(weld(&mut mesh), 0);
        mesh.texcoords = None;
        assert_eq!(weld(&mut mesh), n as u64 - 1);
    }

    #[test]
    fn soups_are_recognised() {
        let mut mesh = soup(&[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 1, 0], [1, 0, 0]]);
        assert!(is_soup(&mesh));
        mesh.triangles = vec![[5, 4, 3], [2, 1, 0]];
        assert!(is_soup(&mesh));
        mesh.triangles = vec![[5, 4, 3], [2, 1, 5]];
        assert!(!is_soup(&mesh));
        weld(&mut mesh);
        assert!(!is_soup(&mesh));
    }
}
