//! The vertices that an open cluster could take next.

/// Vertices outside a cluster that would complete a triangle with two vertices inside.
///
/// Those that close a notch of the outline come first, among equals the one that came to the rim first. That makes
/// clusters as round as choosing by distance from the centre does, without visiting any vertex twice. The candidates
/// are bit sets, so that none is in a set twice and choosing one needs no search.
pub(super) struct Rim {
    /// Number of each vertex in the rim, [`UNMET`] for the others.
    numbers: Box<[u8; 1 << 16]>,
    /// Vertices that came to the rim of the open cluster, in order.
    vertices: [u16; MOST],
    /// Number of triangles that each of them completes.
    completes: [u16; MOST],
    count: usize,
    /// Candidates by their numbers, a set for each urgency; a more urgent one may remain in the less urgent sets,
    /// too.
    candidates: [[u64; 2]; 3],
}

/// Most vertices in the rim of one cluster; further ones are ignored, which happens only where very many triangles
/// meet at a vertex.
const MOST: usize = 128;

const UNMET: u8 = u8::MAX;

impl Default for Rim {
    fn default() -> Self {
        let numbers = vec![UNMET; 1 << 16].into_boxed_slice();
        let numbers =
            numbers.try_into().unwrap_or_else(|_| unreachable!("the table was made with this length"));
        Self { numbers, vertices: [0; MOST], completes: [0; MOST], count: 0, candidates: [[0; 2]; 3] }
    }
}

impl Rim {
    pub fn clear(&mut self) {
        for &vertex in &self.vertices[..self.count] {
            self.numbers[usize::from(vertex)] = UNMET;
        }
        self.completes[..self.count].fill(0);
        self.count = 0;
        self.candidates = [[0; 2]; 3];
    }

    /// Counts one more triangle that the vertex would complete. `live` is the number of its triangles in no cluster:
    /// a vertex that completes all of these is urgent, because it could never be taken at so low a cost again.
    #[inline]
    pub fn reach(&mut self, vertex: u16, live: u16) {
        let number = &mut self.numbers[usize::from(vertex)];
        if *number == UNMET {
            if self.count == MOST {
                return;
            }
            *number = self.count as u8;
            self.vertices[self.count] = vertex;
            self.count += 1;
        }
        let number = usize::from(*number) % MOST;
        let completes = &mut self.completes[number];
        *completes += 1;
        let urgency = if (*completes == live) | (*completes > 2) { 2 } else { usize::from(*completes) - 1 };
        self.candidates[urgency % 3][number / 64] |= 1 << (number % 64);
    }

    /// Removes and returns the vertex to take next.
    #[inline]
    pub fn pop(&mut self) -> Option<u16> {
        let [low, middle, high] = self.candidates;
        // Which of these is empty cannot be predicted, so they are selected without branches.
        let [first, second] = if high != [0; 2] {
            high
        } else if middle != [0; 2] {
            middle
        } else {
            low
        };
        if first | second == 0 {
            return None;
        }
        let half = usize::from(first == 0);
        let word = if first == 0 { second } else { first };
        let rest = !(word & word.wrapping_neg());
        for urgency in &mut self.candidates {
            urgency[half] &= rest;
        }
        Some(self.vertices[half * 64 + word.trailing_zeros() as usize % 64])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn popped(rim: &mut Rim) -> Vec<u16> {
        std::iter::from_fn(|| rim.pop()).collect()
    }

    #[test]
    fn urgent_vertices_come_first_and_each_comes_once() {
        let mut rim = Rim::default();
        for _ in 0..2 {
            rim.clear();
            for (vertex, live) in [(7, 6), (8, 6), (9, 1), (60_000, 6), (8, 6), (3, 6), (3, 6), (3, 6)] {
                rim.reach(vertex, live);
            }
            assert_eq!(popped(&mut rim), [9, 3, 8, 7, 60_000]);
            rim.reach(7, 6);
            assert_eq!(popped(&mut rim), [7]);
        }
    }

    #[test]
    fn vertices_past_the_limit_are_ignored() {
        let mut rim = Rim::default();
        (0..1000).for_each(|v| rim.reach(v, 9));
        rim.reach(100, 9);
        let expected: Vec<u16> = std::iter::once(100).chain((0..128).filter(|v| *v != 100)).collect();
        assert_eq!(popped(&mut rim), expected);
        rim.clear();
        rim.reach(999, 9);
        assert_eq!(popped(&mut rim), [999]);
    }
}
