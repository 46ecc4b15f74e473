//! Planes of triangles in 32 bits, and what they cull before a vertex is read.
//!
//! Three coordinates of the normal and the distance of the plane have eight bits each. An eye is behind a plane only if it
//! is so by more than rounding can have moved the plane: a triangle that is culled shows its back, and those near the limit
//! are left to set-up (document 001, 3.2.4).

use glam::DVec3;
use tercio_mesh::Mesh;

use super::partition::{PARTITION, partitions, vertices};

/// The largest number of eight bits with a sign.
const STEPS: f64 = 127.0;

/// The unit normal of a triangle whose front shows its corners counter-clockwise; `None` without area.
fn normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let n = (b - a).cross(c - a);
    let length = n.length();
    (length > 0.0).then(|| n / length)
}

/// The corners of a triangle of a mesh, in its own coordinates.
fn corners(mesh: &Mesh, triangle: [u32; 3]) -> [DVec3; 3] {
    triangle.map(|v| DVec3::from_array(mesh.positions[v as usize].map(f64::from)))
}

/// A ball round an object: the origin and the unit of its planes' distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its centre.
    pub centre: DVec3,
    /// Its radius, in the object's unit.
    pub radius: f64,
}

/// A plane in 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plane {
    /// The unit normal in steps of 1/127.
    pub normal: [i8; 3],
    /// The distance from the ball's centre in steps of 1/127 of its radius.
    pub distance: i8,
}

impl Plane {
    /// The plane of a triangle inside the ball; `None` if the triangle has no area.
    pub fn new(corners: [DVec3; 3], ball: Ball) -> Option<Self> {
        let normal = normal(corners)?;
        let distance = normal.dot(corners[0] - ball.centre) / ball.radius;
        let steps = |x: f64| (x * STEPS).round().clamp(-STEPS, STEPS) as i8;
        Some(Self { normal: normal.to_array().map(steps), distance: steps(distance) })
    }

    /// Whether an eye is certainly behind it.
    pub fn is_behind(&self, eye: DVec3, ball: Ball) -> bool {
        let eye = eye - ball.centre;
        let normal = DVec3::from_array(self.normal.map(f64::from));
        let height = normal.dot(eye) - f64::from(self.distance) * ball.radius;
        // Each of the four numbers is at most half a step off.
        let margin = 0.5 * (eye.abs().element_sum() + ball.radius);
        height < -margin
    }
}

/// What planes in 32 bits cull of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Culled {
    /// Triangles.
    pub triangles: u64,
    /// Those that show the eye their back, or have no area, by 64-bit arithmetic.
    pub back: u64,
    /// Those that are culled by their plane.
    pub by_plane: u64,
    /// Those that are culled though they show their front: none.
    pub wrong: u64,
    /// Partitions.
    pub partitions: u64,
    /// Partitions all of whose triangles are culled by their planes.
    pub whole: u64,
    /// Vertices, those of each partition counted once.
    pub vertices: u64,
    /// Vertices of the partitions that are culled.
    pub spared: u64,
}

/// Counts what an eye culls of a model in partitions of 500 triangles. Eye and ball are in the mesh's own coordinates.
pub fn count(mesh: &Mesh, eye: DVec3, ball: Ball) -> Culled {
    let mut all = Culled::default();
    for numbers in partitions(mesh, PARTITION) {
        let mut culled = 0;
        for &number in &numbers {
            let corners = corners(mesh, mesh.triangles[number as usize]);
            let back = normal(corners).is_none_or(|n| n.dot(eye - corners[0]) <= 0.0);
            let by_plane = Plane::new(corners, ball).is_some_and(|p| p.is_behind(eye, ball));
            all.back += u64::from(back);
            all.wrong += u64::from(by_plane && !back);
            culled += u64::from(by_plane);
        }
        let of_partition = u64::from(vertices(mesh, &numbers));
        let whole = culled == numbers.len() as u64;
        all.triangles += numbers.len() as u64;
        all.by_plane += culled;
        all.partitions += 1;
        all.whole += u64::from(whole);
        all.vertices += of_partition;
        all.spared += u64::from(whole) * of_partition;
    }
    all
}

/// Triangles that show their back from everywhere in the directions within an angle, whose sine is `sine`, of the
/// direction to the eye: what a test of normals against a direction culls (document 001, 3.2.4, on normal masks).
pub fn behind_all(mesh: &Mesh, towards_eye: DVec3, sine: f64) -> u64 {
    let normals = mesh.triangles.iter().filter_map(|&triangle| normal(corners(mesh, triangle)));
    normals.filter(|n| n.dot(towards_eye) < -sine).count() as u64
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use tercio_mesh::builtin;

    use super::*;

    const UNIT: Ball = Ball { centre: DVec3::ZERO, radius: 1.0 };

    /// Six times the signed volume of the tetrahedron of triangle and eye, by Leibniz' formula in whole numbers: negative
    /// behind the triangle.
    fn volume(corners: [[i128; 3]; 3], eye: [i128; 3]) -> i128 {
        let m = corners.map(|c| [c[0] - eye[0], c[1] - eye[1], c[2] - eye[2]]);
        let mut sum = 0;
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            sum += m[0][i] * m[1][j] * m[2][k] - m[0][i] * m[1][k] * m[2][j];
        }
        -sum
    }

    proptest! {
        /// No triangle that shows its front, even by a hair, is culled; and one well behind is.
        #[test]
        fn what_is_culled_shows_its_back(
            corners in prop::array::uniform3(prop::array::uniform3(-577i32..578)),
            eye in prop::array::uniform3(-4000i32..4001),
        ) {
            let exact = volume(corners.map(|c| c.map(i128::from)), eye.map(i128::from));
            let thousandths = |c: [i32; 3]| DVec3::from_array(c.map(|x| f64::from(x) / 1000.0));
            let (corners, eye) = (corners.map(thousandths), thousandths(eye));
            let Some(plane) = Plane::new(corners, UNIT) else { return Ok(()) };
            let behind = plane.is_behind(eye, UNIT);
            prop_assert!(!behind || exact < 0);
            // Twice the margin is beyond all rounding.
            let height = normal(corners).unwrap().dot(eye - corners[0]);
            let margin = 0.5 / STEPS * (eye.abs().element_sum() + 1.0);
            prop_assert!(behind || height > -2.001 * margin);
        }
    }

    #[test]
    fn from_a_distance_more_than_half_of_a_sphere_is_hidden() {
        let mesh = builtin::make("builtin:sphere@40k").unwrap();
        for distance in [1.5, 3.0, 30.0] {
            let c = count(&mesh, DVec3::new(0.0, 0.6 * distance, 0.8 * distance), UNIT);
            let share = |n: u64| n as f64 / c.triangles as f64;
            // The part of a ball's surface beyond the horizon.
            assert!((share(c.back) - 0.5 * (1.0 + 1.0 / distance)).abs() < 0.005, "{distance} {c:?}");
            assert!(c.wrong == 0 && c.by_plane < c.back && share(c.by_plane) > share(c.back) - 0.03, "{c:?}");
            assert!(c.whole > 0 && c.spared < c.vertices, "{c:?}");
        }
        for sine in [0.0f64, 0.2, 0.5] {
            let share =
                behind_all(&mesh, DVec3::new(0.6, 0.0, 0.8), sine) as f64 / mesh.triangles.len() as f64;
            assert!((share - 0.5 * (1.0 - sine)).abs() < 0.005, "{sine} {share}");
        }
    }
}
