//! The vertices that an open cluster could take next.

/// Vertices outside a cluster that would complete a triangle with two vertices inside.
#[derive(Default)]
pub(super) struct Rim {
    /// The vertices, in no order.
    pub vertices: Vec<u16>,
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    nx: Vec<f32>,
    ny: Vec<f32>,
    nz: Vec<f32>,
    weight: Vec<f32>,
}

/// The rim holds no more; only a fan of hundreds of triangles has a longer one.
pub(super) const MOST: usize = 256;

/// What a vertex's squared distance from the middle of the cluster is multiplied by, for one completed
/// triangle, two, and so on: a vertex in a notch of the outline goes before one on a spike.
const WEIGHTS: [f32; 4] = [1.0, 0.7, 0.4, 0.2];

/// The same for a vertex whose last triangles are completed: it would never be taken so cheaply again.
const LAST: f32 = 0.1;

/// How much a triangle that turns away from the cluster's normals is put back. Found by trial on the dragon:
/// without it 5 % more triangles survive the cone test, with 0.95 clusters become ragged.
const BEND: f32 = 0.8;

impl Rim {
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.x.clear();
        self.y.clear();
        self.z.clear();
        self.nx.clear();
        self.ny.clear();
        self.nz.clear();
        self.weight.clear();
    }

    /// Adds a vertex that completes one triangle, whose unit normal is given, and tells its place.
    #[inline]
    pub fn push(&mut self, vertex: u16, [x, y, z]: [f32; 3], [nx, ny, nz]: [f32; 3]) -> usize {
        self.vertices.push(vertex);
        self.x.push(x);
        self.y.push(y);
        self.z.push(z);
        self.nx.push(nx);
        self.ny.push(ny);
        self.nz.push(nz);
        self.weight.push(WEIGHTS[0]);
        self.vertices.len() - 1
    }

    /// States how many triangles the vertex at a place completes, and whether they are its last.
    #[inline]
    pub fn weigh(&mut self, place: usize, completes: u32, last: bool) {
        let w = WEIGHTS[(completes as usize - 1).min(3)];
        self.weight[place] = if last { w * LAST } else { w };
    }

    /// Place of the vertex that comes next in a cluster about a centre with normals about an axis.
    ///
    /// `square` is added to squared distances: the larger, the more the normals count.
    #[inline]
    pub fn best(&self, [cx, cy, cz]: [f32; 3], [ax, ay, az]: [f32; 3], square: f32) -> Option<usize> {
        let n = self.vertices.len();
        let (x, y, z, w) = (&self.x[..n], &self.y[..n], &self.z[..n], &self.weight[..n]);
        let (nx, ny, nz) = (&self.nx[..n], &self.ny[..n], &self.nz[..n]);
        let mut best = u32::MAX;
        for i in 0..n {
            let (dx, dy, dz) = (x[i] - cx, y[i] - cy, z[i] - cz);
            let bend = 1.0 - BEND * (nx[i] * ax + ny[i] * ay + nz[i] * az);
            let cost = (dx * dx + dy * dy + dz * dz + square) * (bend * bend) * w[i];
            // Bits of positive numbers sort as the numbers do; the lowest eight make room for the place.
            best = best.min((cost.to_bits() & !0xff) | i as u32);
        }
        (n > 0).then_some((best & 0xff) as usize)
    }

    /// Removes the vertex at a place, and tells which vertex stands there now.
    #[inline]
    pub fn remove(&mut self, place: usize) -> Option<u16> {
        self.vertices.swap_remove(place);
        self.x.swap_remove(place);
        self.y.swap_remove(place);
        self.z.swap_remove(place);
        self.nx.swap_remove(place);
        self.ny.swap_remove(place);
        self.nz.swap_remove(place);
        self.weight.swap_remove(place);
        self.vertices.get(place).copied()
    }
}
