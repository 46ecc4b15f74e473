//! What surfaces of different roughness mirror of a panorama: octahedral maps, blurred by the distribution of microfacets.

use glam::{DMat3, DVec3};
use tercio_mesh::loops::prelude::*;
use tercio_mesh::trig::{acos, atan2, sin_cos};

use super::Panorama;

/// One map for each roughness of [`LEVELS`].
#[derive(Clone, PartialEq)]
pub struct Mirrored {
    maps: Vec<Map>,
}

/// Roughness, texels along the edge (of the sharp map at most), and the most rows of the panorama that it is made from. Roughnesses are those of
/// [`position`].
const LEVELS: [(f64, usize, usize); 6] =
    [(0.0, 1024, 1024), (0.125, 192, 128), (0.25, 128, 64), (0.5, 128, 32), (0.75, 96, 32), (1.0, 64, 32)];

/// The place of a roughness between the levels.
fn position(roughness: f32) -> f32 {
    if roughness < 0.25 { roughness * 8.0 } else { 2.0 + (roughness - 0.25) * 4.0 }
}

impl Mirrored {
    pub fn new(panorama: &Panorama, axes: DMat3) -> Self {
        let mut smaller = panorama.clone();
        let maps = LEVELS.map(|(roughness, edge, rows)| {
            while smaller.height() > rows {
                smaller = smaller.halved();
            }
            let edge = if roughness > 0.0 { edge } else { edge.min(4 * smaller.height()).max(256) };
            Map::new(&Directions::new(&smaller, axes), roughness, edge)
        });
        Self { maps: maps.into() }
    }

    /// Interpolated light.
    pub fn at(&self, direction: [f32; 3], roughness: f32) -> [f32; 3] {
        let last = (LEVELS.len() - 1) as f32;
        let at = position(roughness);
        let at = if at > 0.0 { at } else { 0.0 };
        let at = if at < last { at } else { last };
        let level = if at < last { at as usize } else { LEVELS.len() - 2 };
        let part = at - level as f32;
        let place = octahedral(direction);
        let [a, b] = [level, level + 1].map(|level| self.maps[level].at(place));
        [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * part)
    }
}

/// The pixels of a panorama, as directions in world space.
struct Directions {
    pixels: Vec<(DVec3, f64, [f32; 3])>,
    rows: usize,
    axes: DMat3,
}

impl Directions {
    fn new(panorama: &Panorama, axes: DMat3) -> Self {
        let mut pixels = Vec::new();
        panorama
            .for_each(|direction, solid_angle, color| pixels.push((axes * direction, solid_angle, color)));
        Self { pixels, rows: panorama.height(), axes }
    }

    /// The mean light around a direction, weighted by the distribution of microfacets of Trowbridge and Reitz and by the
    /// cosine; `a` is the square of the roughness.
    fn blurred(&self, around: DVec3, a: f64) -> [f32; 3] {
        // Beyond this angle, a lobe has less than 1 % of its light.
        let reach = (24.0 * a + 0.02).min(std::f64::consts::FRAC_PI_2);
        let least = sin_cos(reach).1;
        let height = acos((self.axes.transpose() * around).y.clamp(-1.0, 1.0));
        let row = |angle: f64| angle / std::f64::consts::PI * self.rows as f64;
        let first = (row(height - reach).floor().max(0.0)) as usize;
        let end = (row(height + reach).ceil() as usize).min(self.rows);
        let columns = 2 * self.rows;
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for &(direction, solid_angle, color) in &self.pixels[first * columns..end * columns] {
            let cosine = direction.dot(around);
            if cosine <= least {
                continue;
            }
            // The half vector is at half the angle.
            let spread = 1.0 - (1.0 - a * a) * (0.5 + 0.5 * cosine);
            let weight = solid_angle * cosine / (spread * spread);
            total += weight;
            (0..3).for_each(|k| sum[k] += weight * f64::from(color[k]));
        }
        // A small panorama may have no pixel within reach.
        if total > 0.0 { sum.map(|sum| (sum / total) as f32) } else { self.sharp(around) }
    }

    /// The light in a direction: that of the four nearest pixels.
    fn sharp(&self, direction: DVec3) -> [f32; 3] {
        let own = self.axes.transpose() * direction;
        let columns = 2 * self.rows;
        let y = acos(own.y.clamp(-1.0, 1.0)) / std::f64::consts::PI * self.rows as f64 - 0.5;
        let x = (atan2(own.x, -own.z) / std::f64::consts::TAU + 0.5) * columns as f64 - 0.5;
        let (left, above) = (x.floor(), y.floor());
        let pixel = |right: i64, down: i64| {
            let row = (above as i64 + down).clamp(0, self.rows as i64 - 1) as usize;
            let column = (left as i64 + right).rem_euclid(columns as i64) as usize;
            self.pixels[row * columns + column].2.map(f64::from)
        };
        let mix = |a: [f64; 3], b: [f64; 3], part: f64| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * part);
        let [upper, lower] = [0, 1].map(|down| mix(pixel(0, down), pixel(1, down), x - left));
        mix(upper, lower, y - above).map(|c| c as f32)
    }
}

/// A square of all directions: the faces of an octahedron, those of negative y outside. The border repeats what lies
/// beyond it, so that four texels can be interpolated everywhere.
#[derive(Clone, PartialEq)]
struct Map {
    edge: usize,
    /// With a border of one texel.
    texels: Vec<[f32; 3]>,
}

impl Map {
    fn new(directions: &Directions, roughness: f64, edge: usize) -> Self {
        let stride = edge + 2;
        let texel = |i: usize| {
            let [x, y] = [i % stride, i / stride].map(|c| (c as f64 - 0.5) / edge as f64 * 2.0 - 1.0);
            let direction = direction(x, y);
            match roughness {
                0.0 => directions.sharp(direction),
                _ => directions.blurred(direction, roughness * roughness),
            }
        };
        let texels = (0..stride * stride).into_par_iter().map(texel).collect();
        Self { edge, texels }
    }

    /// The light at a place of the square, -1 to 1.
    fn at(&self, place: [f32; 2]) -> [f32; 3] {
        let edge = self.edge as f32;
        let place = place.map(|c| {
            let c = (c * 0.5 + 0.5) * edge + 0.5;
            // NaN, too.
            let c = if c > 0.5 { c } else { 0.5 };
            if c < edge + 0.5 { c } else { edge + 0.5 }
        });
        let [column, row] = place.map(|c| c as usize);
        let [right, down] = [place[0] - column as f32, place[1] - row as f32];
        let stride = self.edge + 2;
        let first = row * stride + column;
        let texel = |i: usize| self.texels[first + i];
        let mix = |a: [f32; 3], b: [f32; 3], part: f32| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * part);
        mix(mix(texel(0), texel(1), right), mix(texel(stride), texel(stride + 1), right), down)
    }
}

/// The place of a unit vector in the square.
fn octahedral([x, y, z]: [f32; 3]) -> [f32; 2] {
    let sum = (x.abs() + y.abs()) + z.abs();
    let [u, v] = [x / sum, z / sum];
    let sign = |c: f32| if c < 0.0 { -1.0 } else { 1.0 };
    if y < 0.0 { [(1.0 - v.abs()) * sign(u), (1.0 - u.abs()) * sign(v)] } else { [u, v] }
}

/// The unit vector of a place in the square; places beyond a border are those on the other half of that border.
fn direction(u: f64, v: f64) -> DVec3 {
    let folded = |u: f64, v: f64| if u.abs() > 1.0 { (u.signum() * (2.0 - u.abs()), -v) } else { (u, v) };
    let (u, v) = folded(u, v);
    let (v, u) = folded(v, u);
    let y = 1.0 - u.abs() - v.abs();
    let sign = |c: f64| if c < 0.0 { -1.0 } else { 1.0 };
    let (x, z) = if y < 0.0 { ((1.0 - v.abs()) * sign(u), (1.0 - u.abs()) * sign(v)) } else { (u, v) };
    DVec3::new(x, y, z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_their_directions() {
        for i in 0..81 {
            for j in 0..81 {
                let [u, v] = [i, j].map(|i| f64::from(i) / 40.0 - 1.0);
                let found = octahedral(direction(u, v).as_vec3().to_array()).map(f64::from);
                // The four corners are one direction, and places on a border are two.
                let is_border = u.abs() == 1.0 || v.abs() == 1.0;
                let back = direction(found[0], found[1]);
                assert!((back - direction(u, v)).length() < 1e-5, "{u} {v}");
                assert!(
                    is_border || (found[0] - u).abs() + (found[1] - v).abs() < 1e-5,
                    "{u} {v}: {found:?}"
                );
            }
        }
    }
}
