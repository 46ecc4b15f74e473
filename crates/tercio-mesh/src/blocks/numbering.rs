//! A block of triangles with vertices numbered inside the block.

use glam::Vec3;

use crate::Mesh;

/// A block's triangles over its own vertices, and which triangles each vertex has.
#[derive(Default)]
pub(super) struct LocalMesh {
    /// Mesh vertex of each local one, in the order of first use.
    pub vertices: Vec<u32>,
    /// Positions of the vertices.
    pub positions: Vec<[f32; 3]>,
    /// Local vertices of each triangle, turned by [`Mesh::canonical`].
    pub triangles: Vec<[u16; 3]>,
    /// Unit normals of the triangles; zero without area.
    pub normals: Vec<[f32; 3]>,
    /// Mean of the triangles' areas, times two.
    pub area: f32,
    /// Where each vertex's triangles begin in `around`, and one more.
    starts: Vec<u32>,
    /// Triangles round the vertices.
    around: Vec<u16>,
    table: Table,
    /// Mesh vertices of each triangle.
    corners: Vec<[u32; 3]>,
}

impl LocalMesh {
    /// Takes a new block. It has at most 2^16 / 3 triangles.
    pub fn fill(&mut self, mesh: &Mesh, triangles: impl ExactSizeIterator<Item = [u32; 3]>) {
        self.vertices.clear();
        self.triangles.clear();
        self.table.clear();
        // First all loads from far memory, so that they overlap; then the search, which stops and goes.
        self.corners.clear();
        self.corners.extend(triangles);
        let Self { corners, vertices, triangles, table, .. } = self;
        triangles.extend(corners.iter().map(|&[a, b, c]| {
            let local = [table.number(a, vertices), table.number(b, vertices), table.number(c, vertices)];
            turn([a, b, c], local)
        }));
        self.positions.clear();
        self.positions.extend(vertices.iter().map(|&v| mesh.positions[v as usize]));
        self.orient();
        self.connect();
    }

    /// Triangles that have the vertex as a corner; twice or more where it is two corners of one.
    #[inline]
    pub fn around(&self, vertex: u16) -> &[u16] {
        let v = usize::from(vertex);
        &self.around[self.starts[v] as usize..self.starts[v + 1] as usize]
    }

    fn orient(&mut self) {
        let mut sum = 0.0;
        self.normals.clear();
        let point = |v: u16| Vec3::from(self.positions[usize::from(v)]);
        self.normals.extend(self.triangles.iter().map(|&[a, b, c]| {
            let (a, b, c) = (point(a), point(b), point(c));
            let normal = (b - a).cross(c - a);
            let area = normal.length();
            sum += area;
            (normal / area.max(f32::MIN_POSITIVE)).to_array()
        }));
        self.area = sum / self.triangles.len() as f32;
    }

    fn connect(&mut self) {
        self.starts.clear();
        self.starts.resize(self.vertices.len() + 2, 0);
        // Two places ahead, so that filling leaves every start where it belongs.
        for &v in self.triangles.as_flattened() {
            self.starts[usize::from(v) + 2] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.around.resize(self.triangles.len() * 3, 0);
        for (t, corners) in self.triangles.iter().enumerate() {
            for &v in corners {
                let place = &mut self.starts[usize::from(v) + 1];
                self.around[*place as usize] = t as u16;
                *place += 1;
            }
        }
    }
}

/// From mesh vertices to local numbers: open addressing, with lines of slots for vertices that follow each
/// other, because those usually come together.
#[derive(Default)]
struct Table {
    /// Local numbers plus one; 0 for a free slot.
    slots: Vec<u16>,
}

/// Slots that share a cache line.
const LINE: u32 = 32;
/// Slots at first: few enough for the L2 cache, many enough that vertices seldom meet.
const SLOTS: usize = 1 << 16;

impl Table {
    fn clear(&mut self) {
        self.slots.clear();
        self.slots.resize(SLOTS, 0);
    }

    /// The slot where a vertex stands or would stand.
    #[inline]
    fn slot(&self, vertex: u32, vertices: &[u32]) -> usize {
        let mask = self.slots.len() - 1;
        let line = u64::from(vertex / LINE).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        let mut i = (line as usize * LINE as usize + (vertex % LINE) as usize) & mask;
        loop {
            let local = self.slots[i];
            if local == 0 || vertices[usize::from(local) - 1] == vertex {
                return i;
            }
            i = (i + 1) & mask;
        }
    }

    /// The vertex's number; a new vertex is added to `vertices`.
    #[inline]
    fn number(&mut self, vertex: u32, vertices: &mut Vec<u32>) -> u16 {
        let slot = self.slot(vertex, vertices);
        let local = self.slots[slot];
        if local != 0 {
            return local - 1;
        }
        vertices.push(vertex);
        self.slots[slot] = vertices.len() as u16;
        if vertices.len() * 2 > self.slots.len() {
            self.grow(vertices);
        }
        (vertices.len() - 1) as u16
    }

    #[cold]
    fn grow(&mut self, vertices: &[u32]) {
        let size = self.slots.len() * 2;
        self.slots.clear();
        self.slots.resize(size, 0);
        for (i, &v) in vertices.iter().enumerate() {
            let slot = self.slot(v, vertices);
            self.slots[slot] = i as u16 + 1;
        }
    }
}

/// The local numbers of a triangle turned as [`Mesh::canonical`] turns `mesh`, without branches: which
/// corner is the lowest cannot be predicted.
#[inline]
fn turn([a, b, c]: [u32; 3], local: [u16; 3]) -> [u16; 3] {
    let first = u32::from(b < a && b <= c) + 2 * u32::from(c < a && c < b);
    let [x, y, z] = local.map(u128::from);
    let turned = (x | y << 16 | z << 32 | x << 48 | y << 64) >> (16 * first);
    [turned as u16, (turned >> 16) as u16, (turned >> 32) as u16]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_is_canonical() {
        for i in 0..27u32 {
            let t = [i % 3, i / 3 % 3, i / 9];
            let turned = turn(t, t.map(|v| v as u16 + 65_000));
            assert_eq!(turned.map(|v| u32::from(v) - 65_000), Mesh::canonical(t), "{t:?}");
        }
    }
}
