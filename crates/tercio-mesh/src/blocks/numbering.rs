//! Numbers the vertices of a block in the order of their first use.

/// Numbers vertices; the working memory of one thread.
#[derive(Default)]
pub(crate) struct Numbering {
    /// Mesh vertex of each number.
    pub vertices: Vec<u32>,
    table: Table,
    /// Mesh vertices of each triangle.
    corners: Vec<[u32; 3]>,
}

impl Numbering {
    /// Numbers the vertices of a block from 0 on, and writes the corners of each triangle turned by
    /// [`crate::Mesh::canonical`]. The block has at most 2^16 / 3 triangles.
    pub fn number(&mut self, triangles: impl Iterator<Item = [u32; 3]>, corners: &mut [[u16; 3]]) {
        // First all loads from far memory, so that they overlap; then the search, which stops and goes.
        self.corners.clear();
        self.corners.extend(triangles);
        self.table.clear();
        let Self { corners: from, vertices, table } = self;
        // One more, because every corner is written behind the last vertex, new or not.
        vertices.resize(from.len() * 3 + 1, 0);
        let mut count = 0;
        for (to, &[a, b, c]) in corners.iter_mut().zip(&*from) {
            if (count + 3) * 2 > table.slots.len() {
                table.grow(&vertices[..count]);
            }
            let mut number = |v| table.number(v, vertices, &mut count);
            let numbers = [number(a), number(b), number(c)];
            *to = turn([a, b, c], numbers);
        }
        vertices.truncate(count);
    }
}

/// From mesh vertices to numbers: open addressing, with lines of slots for vertices that follow each other,
/// because those usually come together.
#[derive(Default)]
struct Table {
    /// Mesh vertex in the high half, its number plus one in the low half; 0 for a free slot.
    slots: Vec<u64>,
}

/// Slots that share a cache line.
const LINE: u32 = 8;
/// Slots at first: few enough for the L2 cache, many enough that vertices seldom meet.
const SLOTS: usize = 1 << 16;

impl Table {
    fn clear(&mut self) {
        self.slots.clear();
        self.slots.resize(SLOTS, 0);
    }

    /// The slot where a vertex stands or would stand.
    #[inline(always)]
    fn slot(&self, vertex: u32) -> usize {
        let mask = self.slots.len() - 1;
        let line = u64::from(vertex / LINE).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        let mut i = (line as usize * LINE as usize + (vertex % LINE) as usize) & mask;
        loop {
            let slot = self.slots[i];
            if slot == 0 || (slot >> 32) as u32 == vertex {
                return i;
            }
            i = (i + 1) & mask;
        }
    }

    /// The vertex's number; a new vertex is added to the `count` first ones of `vertices`. Without branches
    /// on whether it is new, which cannot be predicted.
    #[inline(always)]
    fn number(&mut self, vertex: u32, vertices: &mut [u32], count: &mut usize) -> u16 {
        let place = self.slot(vertex);
        let slot = self.slots[place];
        let is_new = slot == 0;
        vertices[*count] = vertex;
        *count += usize::from(is_new);
        let next = if is_new { *count as u32 } else { slot as u32 };
        self.slots[place] = u64::from(vertex) << 32 | u64::from(next);
        (next - 1) as u16
    }

    #[cold]
    fn grow(&mut self, vertices: &[u32]) {
        let size = self.slots.len() * 2;
        self.slots.clear();
        self.slots.resize(size, 0);
        for (i, &v) in vertices.iter().enumerate() {
            let place = self.slot(v);
            self.slots[place] = u64::from(v) << 32 | (i as u64 + 1);
        }
    }
}

/// Numbers of a triangle's corners turned as [`Mesh::canonical`] turns the corners, without branches: which
/// one is the lowest cannot be predicted.
#[inline(always)]
fn turn([a, b, c]: [u32; 3], [x, y, z]: [u16; 3]) -> [u16; 3] {
    let first = u32::from((b < a) & (b <= c)) + 2 * u32::from((c < a) & (c < b));
    let all = u64::from(x) | u64::from(y) << 16 | u64::from(z) << 32;
    let turned = all >> (16 * first) | all << (48 - 16 * first);
    [turned as u16, (turned >> 16) as u16, (turned >> 32) as u16]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mesh;

    #[test]
    fn turning_is_canonical() {
        for i in 0..27u32 {
            let t = [i % 3, i / 3 % 3, i / 9];
            let turned = turn(t, t.map(|v| v as u16 + 65_000));
            assert_eq!(turned.map(|v| u32::from(v) - 65_000), Mesh::canonical(t), "{t:?}");
        }
    }

    #[test]
    fn numbers_name_the_corners_of_a_block_with_more_vertices_than_slots() {
        let triangles: Vec<[u32; 3]> =
            (0..20_000u32).map(|i| [i * 7 % 50_021, i * 31 % 50_021 * 65_537, i]).collect();
        let mut numbering = Numbering::default();
        let mut corners = vec![[0; 3]; triangles.len()];
        for _ in 0..2 {
            numbering.number(triangles.iter().copied(), &mut corners);
            for (corners, &triangle) in corners.iter().zip(&triangles) {
                let named = corners.map(|v| numbering.vertices[usize::from(v)]);
                assert_eq!(named, Mesh::canonical(triangle));
            }
        }
        assert!(numbering.vertices.len() > SLOTS / 2);
    }
}
