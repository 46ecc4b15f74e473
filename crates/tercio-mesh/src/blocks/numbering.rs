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
    /// Numbers the vertices of a block from 0 on, and writes the corners of each triangle, rotated by
    /// [`crate::Mesh::canonical`]. The block has at most 2^16 / 3 triangles.
    pub fn number(&mut self, triangles: impl Iterator<Item = [u32; 3]>, corners: &mut [[u16; 3]]) {
        // First all loads of triangles, so that their cache misses overlap; then the look-ups, which depend on each
        // other.
        self.corners.clear();
        self.corners.extend(triangles);
        self.table.clear();
        let Self { corners: from, vertices, table } = self;
        // One entry more, because every corner's vertex is written after the last one, whether it is new or not.
        vertices.resize(from.len() * 3 + 1, 0);
        let mut count = 0;
        for (to, &[a, b, c]) in corners.iter_mut().zip(&*from) {
            let mut number = |v| table.number(v, vertices, &mut count);
            let numbers = [number(a), number(b), number(c)];
            *to = rotate([a, b, c], numbers);
        }
        vertices.truncate(count);
    }
}

/// Maps mesh vertices to numbers in the block. Consecutive vertices of the mesh usually occur together, so the table
/// has lines only for the vertices near those that have occurred.
struct Table {
    /// Line of the table that holds the vertices `i * LINE` and on; 0 if there is none yet.
    lines: Vec<u32>,
    /// Numbers plus one, 0 for vertices that have not occurred; line 0 belongs to no vertices.
    numbers: Vec<u16>,
    /// Indices of the nonzero entries of `lines`.
    used: Vec<u32>,
}

/// Vertices that share a line: as many numbers as fit into a cache line.
const LINE: usize = 32;

impl Default for Table {
    fn default() -> Self {
        Self { lines: Vec::new(), numbers: vec![0; LINE], used: Vec::new() }
    }
}

impl Table {
    fn clear(&mut self) {
        self.used.drain(..).for_each(|i| self.lines[i as usize] = 0);
        self.numbers.truncate(LINE);
    }

    /// The vertex's number; a new vertex is appended to the first `count` ones of `vertices`. Without branches on
    /// whether it is new, which cannot be predicted.
    #[inline(always)]
    fn number(&mut self, vertex: u32, vertices: &mut [u32], count: &mut usize) -> u16 {
        let (line, place) = (vertex as usize / LINE, vertex as usize % LINE);
        let line = match self.lines.get(line) {
            Some(&number) if number != 0 => number,
            _ => self.open(line),
        };
        let entry = &mut self.numbers[line as usize * LINE + place];
        let is_new = *entry == 0;
        vertices[*count] = vertex;
        *count += usize::from(is_new);
        *entry = if is_new { *count as u16 } else { *entry };
        *entry - 1
    }

    /// Adds a line to the table.
    #[cold]
    #[inline(never)]
    fn open(&mut self, line: usize) -> u32 {
        if line >= self.lines.len() {
            self.lines.resize((line + 1).next_power_of_two(), 0);
        }
        let number = (self.numbers.len() / LINE) as u32;
        self.numbers.resize(self.numbers.len() + LINE, 0);
        self.lines[line] = number;
        self.used.push(line as u32);
        number
    }
}

/// Numbers of a triangle's corners, rotated as [`Mesh::canonical`] rotates the corners, without branches: which
/// corner is the lowest cannot be predicted.
#[inline(always)]
fn rotate([a, b, c]: [u32; 3], [x, y, z]: [u16; 3]) -> [u16; 3] {
    let first = u32::from((b < a) & (b <= c)) + 2 * u32::from((c < a) & (c < b));
    let all = u64::from(x) | u64::from(y) << 16 | u64::from(z) << 32;
    let rotated = all >> (16 * first) | all << (48 - 16 * first);
    [rotated as u16, (rotated >> 16) as u16, (rotated >> 32) as u16]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mesh;

    #[test]
    fn rotation_is_canonical() {
        for i in 0..27u32 {
            let t = [i % 3, i / 3 % 3, i / 9];
            let rotated = rotate(t, t.map(|v| v as u16 + 65_000));
            assert_eq!(rotated.map(|v| u32::from(v) - 65_000), Mesh::canonical(t), "{t:?}");
        }
    }

    #[test]
    fn numbers_name_the_corners_of_a_block_with_scattered_vertices() {
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
        assert!(numbering.vertices.len() > 40_000);
    }
}
