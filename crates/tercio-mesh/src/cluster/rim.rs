//! The vertices that an open cluster could take next.

/// Vertices outside a cluster that would complete a triangle with two vertices inside.
///
/// Those that close a notch of the outline come first, among equals the one that came to the rim first. That makes
/// clusters as round as choosing by distance from the middle does, and looks at nothing twice. The vertices that
/// wait are sets of bits, so that none stands there twice and choosing one needs no search.
pub(super) struct Rim {
    /// Number at the rim of each vertex, [`UNMET`] for the others.
    numbers: Box<[u8; 1 << 16]>,
    /// Vertices that came to the rim of the cluster, in order.
    vertices: [u16; MOST],
    /// Triangles that each of them completes.
    completes: [u16; MOST],
    count: usize,
    /// Those that wait, by their numbers, for each urgency; a more urgent one may wait among the less urgent, too.
    waiting: [[u64; 2]; 3],
}

/// Vertices that come to the rim of one cluster; what more come are left out, which only many triangles round one
/// vertex can bring about.
const MOST: usize = 128;

const UNMET: u8 = u8::MAX;

impl Default for Rim {
    fn default() -> Self {
        let numbers = vec![UNMET; 1 << 16].into_boxed_slice();
        let numbers =
            numbers.try_into().unwrap_or_else(|_| unreachable!("the table was made with this length"));
        Self { numbers, vertices: [0; MOST], completes: [0; MOST], count: 0, waiting: [[0; 2]; 3] }
    }
}

impl Rim {
    pub fn clear(&mut self) {
        for &vertex in &self.vertices[..self.count] {
            self.numbers[usize::from(vertex)] = UNMET;
        }
        self.completes[..self.count].fill(0);
        self.count = 0;
        self.waiting = [[0; 2]; 3];
    }

    /// A vertex would complete one triangle more. `live` are its triangles that no cluster has: one whose last
    /// triangles are completed would never be taken so cheaply again.
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
        self.waiting[urgency % 3][number / 64] |= 1 << (number % 64);
    }

    /// The vertex that comes next.
    #[inline]
    pub fn pop(&mut self) -> Option<u16> {
        let [low, middle, high] = self.waiting;
        // Which of these is empty cannot be predicted: they are selected, not branched on.
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
        for urgency in &mut self.waiting {
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
    fn what_does_not_fit_is_left_out() {
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
