//! Schoen's gyroid (1970), in its usual approximation: sin x cos y + sin y cos z + sin z cos x = 0.
//!
//! A sheet of endless passages: every line of sight crosses many layers, so most of the surface is occluded.
//!
//! The surface is made by dual marching cubes (Nielson 2004): a vertex for each sheet in each grid cell whose corners
//! are on both sides, a quadrilateral across each grid edge whose ends are. Near a saddle the surface can cross a
//! face of a cell in two branches, however fine the grid is, and the gyroid is all saddles; so which crossings belong
//! to one sheet is found from face to face of the cell, with the asymptotic decider (Nielson and Hamann 1991) where a
//! face has four crossings. One vertex for all would make the mesh touch itself there. The vertices are then moved
//! onto the surface, along its gradient.

use crate::loops::prelude::*;
use glam::DVec3;

use super::soup::cube_root;
use crate::trig::sin_cos;
use crate::{Mesh, OctNormal};

/// Grid cells per period: for many triangles, for few, and the least that keeps the mesh manifold.
const FINE: f64 = 28.0;
const COARSE: f64 = 18.0;
const COARSEST: f64 = 12.0;
/// Triangles per period for one cell per period: twice the mean of |nx| + |ny| + |nz| (3/2) times the area of the
/// surface in a cubic period of side 1 (3.0915).
const TRIANGLES: f64 = 9.2745;
/// Most periods along a side of the cube: larger triangle counts make the grid finer instead.
const MOST_PERIODS: f64 = 12.0;
/// Phase of the cube in the periodic surface: arbitrary, so that no grid point lies on the surface.
const PHASE: [f64; 3] = [0.37, 1.13, 2.71];
const NONE: u32 = u32::MAX;

/// The edges of a cell: number of the lower corner (bit k: the upper end along axis k), and axis. Edge 4 axis + n
/// runs along the axis.
const EDGES: [(usize, usize); 12] =
    [(0, 0), (2, 0), (4, 0), (6, 0), (0, 1), (1, 1), (4, 1), (5, 1), (0, 2), (1, 2), (2, 2), (3, 2)];
/// The faces of a cell: four corners in cyclic order, and the edges from each to the next.
const SIDES: [([usize; 4], [usize; 4]); 6] = [
    ([0, 1, 3, 2], [0, 5, 1, 4]),
    ([4, 5, 7, 6], [2, 7, 3, 6]),
    ([0, 1, 5, 4], [0, 9, 2, 8]),
    ([2, 3, 7, 6], [1, 11, 3, 10]),
    ([0, 2, 6, 4], [4, 10, 6, 8]),
    ([1, 3, 7, 5], [5, 11, 7, 9]),
];

/// The gyroid inside the cube from -1 to 1, of about `count` triangles, at least about 600; open where the cube cuts
/// it. It has about 9 periods along a side at 5.4 million triangles.
pub fn gyroid(count: u64) -> Mesh {
    let target = count as f64;
    let fineness = COARSE + (FINE - COARSE) * (target / 1e5).min(1.0);
    let cube = target / (TRIANGLES * fineness * fineness);
    // Below one period the cube root is not needed.
    let periods = if cube > 1.0 { cube_root(cube).min(MOST_PERIODS) } else { 0.75 };
    let cells = (target / (TRIANGLES * periods)).sqrt().round().max(COARSEST) as usize;

    // The estimate ignores the border, where quadrilaterals are missing; adjust the number of periods until the count
    // is met.
    let mut best: Option<(f64, Field)> = None;
    let mut periods = target / (TRIANGLES * (cells * cells) as f64);
    for _ in 0..8 {
        periods = periods.clamp(0.3, cells as f64 / COARSEST);
        let field = Field::new(cells, periods);
        let made = 2.0 * field.count_quads() as f64;
        let error = (made / target - 1.0).abs();
        if best.as_ref().is_none_or(|b| error < b.0) {
            best = Some((error, field));
        }
        if error < 0.01 {
            break;
        }
        periods *= target / made.max(1.0);
    }
    best.map(|b| b.1.mesh()).unwrap_or_default()
}

/// The function on a grid of `cells`³ cells. It is a sum of products of functions of one coordinate.
struct Field {
    cells: usize,
    /// Radians per unit of length.
    wave: f64,
    /// Sine and cosine at the grid points along each axis.
    tables: [Vec<(f64, f64)>; 3],
}

impl Field {
    fn new(cells: usize, periods: f64) -> Self {
        let wave = std::f64::consts::PI * periods;
        let step = 2.0 / cells as f64;
        let table = |phase: f64| {
            (0..=cells).map(|i| sin_cos((i as f64 * step - 1.0) * wave + phase)).collect::<Vec<_>>()
        };
        Self { cells, wave, tables: PHASE.map(table) }
    }

    /// The values at the grid points of the plane z = k, row after row of x.
    fn plane(&self, k: usize, values: &mut Vec<f64>) {
        let [xs, ys, zs] = &self.tables;
        let (sz, cz) = zs[k];
        values.clear();
        for &(sy, cy) in ys {
            values.extend(xs.iter().map(|&(sx, cx)| sx * cy + sy * cz + sz * cx));
        }
    }

    fn count_quads(&self) -> u64 {
        let n = self.cells;
        let side = n + 1;
        (0..n)
            .into_par_iter()
            .map_init(<(Vec<f64>, Vec<f64>)>::default, |(low, high), k| {
                self.plane(k, low);
                self.plane(k + 1, high);
                let crosses = |a: f64, b: f64| u64::from((a < 0.0) != (b < 0.0));
                let mut quads = 0;
                for j in 0..n {
                    let rows = j * side..(j + 1) * side;
                    let (row, up) = (&low[rows.clone()], &high[rows]);
                    let next = &low[(j + 1) * side..(j + 2) * side];
                    if k > 0 && j > 0 {
                        quads += row.windows(2).map(|w| crosses(w[0], w[1])).sum::<u64>();
                    }
                    if k > 0 {
                        quads += row[1..n].iter().zip(&next[1..n]).map(|(&a, &b)| crosses(a, b)).sum::<u64>();
                    }
                    if j > 0 {
                        quads += row[1..n].iter().zip(&up[1..n]).map(|(&a, &b)| crosses(a, b)).sum::<u64>();
                    }
                }
                quads
            })
            .sum()
    }

    /// The function and its gradient (per radian) at a point of the cube.
    fn at(&self, p: DVec3) -> (f64, DVec3) {
        let [(sx, cx), (sy, cy), (sz, cz)] = [0, 1, 2].map(|k| sin_cos(p[k] * self.wave + PHASE[k]));
        let gradient = DVec3::new(cx * cy - sz * sx, cy * cz - sx * sy, cz * cx - sy * sz);
        (sx * cy + sy * cz + sz * cx, gradient)
    }

    fn mesh(&self) -> Mesh {
        // Vertices are numbered layer after layer, so that layers can be made independently.
        let counts: Vec<u32> = (0..self.cells)
            .into_par_iter()
            .map_init(Layer::default, |layer, k| layer.number(self, k, 0))
            .collect();
        let firsts: Vec<u32> =
            counts.iter().scan(0, |sum, &n| Some(std::mem::replace(sum, *sum + n))).collect();
        let layers: Vec<_> = (0..self.cells)
            .into_par_iter()
            .map_init(<(Layer, Layer)>::default, |(below, layer), k| {
                if k > 0 {
                    below.number(self, k - 1, firsts[k - 1]);
                }
                layer.number(self, k, firsts[k]);
                let (positions, normals): (Vec<_>, Vec<_>) = layer.vertices(self, k).unzip();
                let mut triangles = Vec::with_capacity(positions.len() * 2);
                layer.quads(self.cells, (k > 0).then_some(&*below), |[a, b, c, d]| {
                    triangles.extend([[a, b, c], [a, c, d]]);
                });
                (positions, normals, triangles)
            })
            .collect();

        let vertices = counts.iter().map(|&n| n as usize).sum();
        let mut mesh = Mesh {
            positions: Vec::with_capacity(vertices),
            triangles: Vec::with_capacity(layers.iter().map(|l| l.2.len()).sum()),
            ..Mesh::default()
        };
        let mut normals = Vec::with_capacity(vertices);
        for (p, n, t) in layers {
            mesh.positions.extend(p);
            normals.extend(n);
            mesh.triangles.extend(t);
        }
        mesh.normals = Some(normals);
        mesh
    }
}

/// For each edge of a cell the number of the sheet that crosses it, and the number of sheets.
type Sheets = ([u8; 12], u8);
const NO_SHEET: u8 = u8::MAX;

fn sheets(values: &[f64; 8]) -> Sheets {
    let crosses = EDGES.map(|(a, axis)| (values[a] < 0.0) != (values[a | 1 << axis] < 0.0));
    let mut of: [u8; 12] = std::array::from_fn(|e| if crosses[e] { e as u8 } else { NO_SHEET });
    let mut join = |a: usize, b: usize| {
        let (low, high) = (of[a].min(of[b]), of[a].max(of[b]));
        of.iter_mut().filter(|s| **s == high).for_each(|s| *s = low);
    };
    for (corners, edges) in &SIDES {
        let mut crossed = edges.iter().copied().filter(|&e| crosses[e]);
        match (crossed.next(), crossed.next(), crossed.next()) {
            (Some(a), Some(b), None) => join(a, b),
            (Some(_), Some(_), Some(_)) => {
                let v = corners.map(|c| values[c]);
                // The bilinear saddle, (v0 v2 - v1 v3) / (v0 + v2 - v1 - v3), has the sign of v0 and v2, so
                // that these are connected, if the numerator is positive: the denominator has that sign too.
                let first_connected = v[0] * v[2] > v[1] * v[3];
                let [e01, e12, e23, e30] = *edges;
                // The branches cut off the corners that are not connected.
                let pairs = if first_connected { [(e01, e12), (e23, e30)] } else { [(e30, e01), (e12, e23)] };
                pairs.into_iter().for_each(|(a, b)| join(a, b));
            }
            _ => {}
        }
    }
    // Renumber the sheets in order of first use.
    let mut count = 0;
    let mut numbers = [NO_SHEET; 12];
    for e in 0..12 {
        if crosses[e] {
            if of[e] as usize == e {
                numbers[e] = count;
                count += 1;
            } else {
                numbers[e] = numbers[of[e] as usize];
            }
        }
    }
    (numbers, count)
}

/// The cells between two grid planes.
#[derive(Default)]
struct Layer {
    low: Vec<f64>,
    high: Vec<f64>,
    /// The first vertex of each cell that has one.
    numbers: Vec<u32>,
    /// Cells with more than one sheet, in order.
    several: Vec<(u32, [u8; 12])>,
}

impl Layer {
    /// Fills the layer; returns the number of its vertices.
    fn number(&mut self, field: &Field, k: usize, first: u32) -> u32 {
        field.plane(k, &mut self.low);
        field.plane(k + 1, &mut self.high);
        let (n, side) = (field.cells, field.cells + 1);
        let mut next = first;
        self.numbers.clear();
        self.several.clear();
        for j in 0..n {
            for i in 0..n {
                let p = j * side + i;
                let negative = [p, p + 1, p + side, p + side + 1]
                    .iter()
                    .map(|&q| u32::from(self.low[q] < 0.0) + u32::from(self.high[q] < 0.0))
                    .sum::<u32>();
                match negative {
                    0 | 8 => self.numbers.push(NONE),
                    _ => {
                        let (of, count) = sheets(&self.corners(side, i, j));
                        if count > 1 {
                            self.several.push((self.numbers.len() as u32, of));
                        }
                        self.numbers.push(next);
                        next += u32::from(count);
                    }
                }
            }
        }
        next - first
    }

    /// The values at the corners of a cell.
    fn corners(&self, side: usize, i: usize, j: usize) -> [f64; 8] {
        std::array::from_fn(|c| {
            let plane = if c & 4 == 0 { &self.low } else { &self.high };
            plane[(j + (c >> 1 & 1)) * side + i + (c & 1)]
        })
    }

    fn vertices(&self, field: &Field, k: usize) -> impl Iterator<Item = ([f32; 3], OctNormal)> {
        let (n, step) = (field.cells, 2.0 / field.cells as f64);
        self.numbers.iter().enumerate().filter(|c| *c.1 != NONE).flat_map(move |(cell, _)| {
            let (i, j) = (cell % n, cell / n);
            let corner = DVec3::new(i as f64, j as f64, k as f64) * step - 1.0;
            let values = self.corners(n + 1, i, j);
            let (of, count) = sheets(&values);
            (0..count).map(move |sheet| {
                // The mean of the points where the sheet crosses edges, then two steps of Newton's method to the
                // surface, but not out of the cell, or the mesh could fold over.
                let mut p = corner + mean_crossing(&values, &of, sheet) * step;
                for _ in 0..2 {
                    let (value, gradient) = field.at(p);
                    p -= gradient * (value / (gradient.length_squared() * field.wave));
                    p = p.clamp(corner, corner + step);
                }
                let normal = field.at(p).1;
                (p.as_vec3().to_array(), OctNormal::encode(normal.as_vec3().to_array()))
            })
        })
    }

    /// The vertex of the sheet that crosses an edge of a cell.
    fn vertex(&self, cell: usize, edge: usize) -> u32 {
        let first = self.numbers[cell];
        match self.several.binary_search_by_key(&(cell as u32), |s| s.0) {
            Ok(at) => first + u32::from(self.several[at].1[edge]),
            Err(_) => first,
        }
    }

    /// The quadrilaterals across the edges that begin on the layer's lower plane, except along its border. Their
    /// front is the side where the function is positive.
    fn quads(&self, n: usize, below: Option<&Self>, mut emit: impl FnMut([u32; 4])) {
        let side = n + 1;
        for j in 0..n {
            for i in 0..n {
                let p = j * side + i;
                let negative = self.low[p] < 0.0;
                // The cells around an edge along an axis, counter-clockwise seen from the edge's far end: layer and
                // cell index. The edge is a different one of the twelve in each.
                let mut across = |axis: usize, far: f64, ring: [(&Self, usize, usize); 4]| {
                    if negative == (far < 0.0) {
                        return;
                    }
                    // In the order of the ring the edge is at the cell's upper end along both other axes, along the
                    // second only, along none, along the first only.
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    let lower_corner = [1 << u | 1 << v, 1 << v, 0, 1 << u];
                    let [a, b, c, d] = std::array::from_fn(|k| {
                        let (layer, i, j) = ring[k];
                        let edge = EDGES.iter().position(|&e| e == (lower_corner[k], axis)).unwrap_or(0);
                        layer.vertex(j * n + i, edge)
                    });
                    emit(if negative { [a, b, c, d] } else { [a, d, c, b] });
                };
                if i > 0 && j > 0 {
                    let ring = [(self, i - 1, j - 1), (self, i, j - 1), (self, i, j), (self, i - 1, j)];
                    across(2, self.high[p], ring);
                }
                if let Some(below) = below {
                    if j > 0 {
                        let ring = [(below, i, j - 1), (below, i, j), (self, i, j), (self, i, j - 1)];
                        across(0, self.low[p + 1], ring);
                    }
                    if i > 0 {
                        let ring = [(below, i - 1, j), (self, i - 1, j), (self, i, j), (below, i, j)];
                        across(1, self.low[p + side], ring);
                    }
                }
            }
        }
    }
}

/// Mean of the sheet's crossings of cell edges, in units of the cell.
fn mean_crossing(values: &[f64; 8], of: &[u8; 12], sheet: u8) -> DVec3 {
    let (mut sum, mut crossings) = (DVec3::ZERO, 0.0);
    for (&(a, axis), _) in EDGES.iter().zip(of).filter(|e| *e.1 == sheet) {
        let (va, vb) = (values[a], values[a | 1 << axis]);
        let mut at = [0, 1, 2].map(|k| (a >> k & 1) as f64);
        at[axis] = va / (va - vb);
        sum += DVec3::from(at);
        crossings += 1.0;
    }
    sum / crossings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::analyze;

    #[test]
    fn a_gyroid_is_manifold_inside() {
        for count in [1000, 3000, 30_000, 400_000] {
            let mesh = gyroid(count);
            let found = analyze(&mesh);
            assert!(found.consistently_wound, "{found:?}");
            assert_eq!((found.non_manifold_edges, found.flipped_edges), (0, 0), "{count}");
            // All boundary edges lie in the outermost cells.
            let mut uses = std::collections::HashMap::new();
            for t in &mesh.triangles {
                for k in 0..3 {
                    let (a, b) = (t[k], t[(k + 1) % 3]);
                    *uses.entry((a.min(b), a.max(b))).or_insert(0) += 1;
                }
            }
            let cell = 2.0 * COARSEST.max((count as f64 / 9.3 / 12.0).sqrt()).recip();
            for ((a, b), n) in uses {
                if n == 1 {
                    for v in [a, b] {
                        let p = mesh.positions[v as usize];
                        assert!(p.iter().any(|x| x.abs() > 1.0 - 2.0 * cell as f32), "{count}: {p:?}");
                    }
                }
            }
            super::super::tests::check_normals(&mesh, if count < 10_000 { 0.3 } else { 0.6 });
        }
    }
}
