//! From world space to the picture: what the camera means for one frame and one instance.
//!
//! Matrices are made in `f64` and rounded to `f32` once; a vertex then passes through [`ObjectView::project`],
//! the one sequence of operations by which every path of the renderer reaches the screen.
//!
//! Two things keep `f32` exact enough at any size and from anywhere. Lengths are measured in [`View::unit`], a power of
//! two of about the size of the scene, so that the picture of a model does not depend on its units. And positions are
//! taken relative to [`ObjectView::pivot`], the point of the mesh's box next to the eye: what is near the eye then has
//! errors relative to its distance, not to the size of the scene.

use glam::{DMat3, DVec3};
use tercio_mesh::mesh::{exponent_of, power_of_two};
use tercio_mesh::{Aabb, ClusteredMesh};
use tercio_scene::camera::{CameraBasis, CameraError};
use tercio_scene::{Camera, Instance, Projection};

use crate::conventions::{GUARD, SMALL_EXTENT, SUBPIXELS};

/// The camera of one frame.
#[derive(Clone, Debug)]
pub struct View {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The eye in world space.
    pub eye: DVec3,
    /// The camera's axes in world space.
    pub basis: CameraBasis,
    /// False for an orthographic camera.
    pub perspective: bool,
    /// Sub-pixels a world unit, at distance 1 for a perspective camera.
    pub scale: f64,
    /// Distance of the near plane along the line of sight, world units.
    pub near: f64,
    /// A distance beyond everything (orthographic depth only), world units.
    pub far: f64,
    /// World units a unit of length of the `f32` numbers of a frame: a power of two, such that no distance of the
    /// scene is above 1.
    pub unit: f64,
}

/// Automatic near planes of perspective cameras inside the scene stand at this part of the scene's radius, 1e-12: far
/// nearer than `f32` tells positions apart, but for those next to the mesh's origin. It costs nothing, because depths
/// are relative to the near plane.
const NEAREST: f64 = 1.0 / (1u64 << 40) as f64;

/// No near plane stands nearer than this, in [`View::unit`].
const LEAST_NEAR: f64 = 1.0 / (1u64 << 60) as f64;

/// The largest factor by which depths, which are at most 1, are multiplied to be weights of corners: times areas, which
/// are below 2^49 together, and squared, they then stay inside `f32`. The least weight, [`LEAST_NEAR`] times this, still
/// is a vector's length and not nothing.
const MOST_WEIGHT: f64 = (1u64 << 12) as f64;

/// The least power of two that is above a length; 1 for a length of 0.
fn unit_above(length: f64) -> f64 {
    if length.is_normal() { power_of_two(exponent_of(length) + 1) } else { 1.0 }
}

impl View {
    /// The view of `camera` on a scene with these world-space bounds.
    ///
    /// # Errors
    /// [`CameraError`].
    pub fn new(camera: &Camera, bounds: &Aabb, width: u32, height: u32) -> Result<Self, CameraError> {
        let basis = camera.basis()?;
        let half_height = f64::from(height) * 0.5 * f64::from(SUBPIXELS);
        let (perspective, scale) = match camera.projection {
            Projection::Perspective { fov_y } => {
                let (sin, cos) = tercio_mesh::trig::sin_cos(fov_y * 0.5);
                (true, half_height * cos / sin)
            }
            Projection::Orthographic { height } => (false, half_height * 2.0 / height),
        };
        let (mut nearest, mut farthest) = (0.0, 1.0);
        if !bounds.is_empty() {
            let along = bounds.corners().map(|c| basis.forward.dot(c - camera.eye));
            nearest = along.iter().copied().fold(f64::INFINITY, f64::min);
            farthest = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        }
        // A perspective camera may stand inside the model. In front of the model the plane's place does not matter,
        // because depth is relative to it; half way to the model it cuts nothing.
        let size = bounds.radius().max(f64::MIN_POSITIVE.sqrt());
        let automatic =
            if perspective { (NEAREST * size).max(0.5 * nearest) } else { nearest.max(0.0) - 1e-3 * size };
        let near = camera.near.unwrap_or(if perspective { automatic } else { automatic.max(0.0) });
        let far = farthest.max(near) + 1e-2 * size;
        let unit = unit_above(size.max(farthest.abs()).max(nearest.abs()).max(near));
        // As the kernels have it, so that distances follow from depths without a bias.
        let near = if perspective { f64::from((near / unit).max(LEAST_NEAR) as f32) * unit } else { near };
        Ok(Self { width, height, eye: camera.eye, basis, perspective, scale, near, far, unit })
    }

    /// Distance along the line of sight, in world units, of a depth above 0.
    pub fn distance(&self, depth: f32) -> f32 {
        let d = f64::from(depth);
        let distance = if self.perspective { self.near / d } else { self.far - d * (self.far - self.near) };
        distance as f32
    }

    /// Screen coordinates of the middle of the picture.
    fn middle(&self) -> [i32; 2] {
        [self.width as i32 * SUBPIXELS / 2, self.height as i32 * SUBPIXELS / 2]
    }

    /// The view of one instance.
    pub fn object(&self, instance: &Instance) -> ObjectView {
        let mesh = &*instance.mesh;
        // From the mesh's numbers to world axes relative to the eye.
        let linear = instance.world_from_object.matrix3 * mesh.unit();
        let shift = instance.world_from_object.transform_point3(mesh.origin) - self.eye;
        let b = &self.basis;
        // A row of the combined matrix: `axis . (linear * p + shift) * scale + add`.
        let row = |axis: DVec3, scale: f64, add: f64| {
            let r = linear.transpose() * axis * scale;
            [r.x, r.y, r.z, axis.dot(shift) * scale + add]
        };
        let inverse_unit = 1.0 / self.unit;
        let (x, y, w, d) = if self.perspective {
            let scale = self.scale * inverse_unit;
            let w = row(b.forward, inverse_unit, 0.0);
            (row(b.right, scale, 0.0), row(b.up, -scale, 0.0), w, [0.0, 0.0, 0.0, self.near * inverse_unit])
        } else {
            let k = 1.0 / (self.far - self.near);
            let d = row(b.forward, -k, self.far * k);
            (row(b.right, self.scale, 0.0), row(b.up, -self.scale, 0.0), [0.0, 0.0, 0.0, 1.0], d)
        };
        let inverse = linear.inverse();
        let mirrored = linear.determinant() < 0.0;
        // It keeps the side of a plane on which a normal stands, of mirror images too. Its scale is taken out, so that
        // normals times areas neither vanish nor overflow.
        let normal_matrix = inverse.transpose();
        let largest = normal_matrix.to_cols_array().into_iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let scale = if largest > 0.0 && largest.is_finite() { 1.0 / largest } else { 1.0 };
        let normal_matrix = normal_matrix * if mirrored { -scale } else { scale };
        let f = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32];
        let rows = |m: DMat3| [f(m.row(0)), f(m.row(1)), f(m.row(2))];
        let eye = inverse * -shift;
        let pivot = self.pivot(mesh, eye);
        let at_pivot = DVec3::from(pivot.map(f64::from));
        let single = |r: [f64; 4]| {
            let [x, y, z, add] = r;
            [x as f32, y as f32, z as f32, (DVec3::new(x, y, z).dot(at_pivot) + add) as f32]
        };
        // Towards the viewer in local coordinates: the eye itself, or the direction of all rays.
        let viewer = if self.perspective { eye - at_pivot } else { inverse * -b.forward };
        let size = mesh.bounds.size().max_element() / mesh.unit();
        ObjectView {
            perspective: self.perspective,
            pivot,
            x: single(x),
            y: single(y),
            w: single(w),
            d: single(d),
            near: (self.near * inverse_unit) as f32,
            weight: if self.perspective { (self.unit / self.near).min(MOST_WEIGHT) as f32 } else { 1.0 },
            offset: self.middle(),
            exact: ClipRows { x, y, w, d },
            viewer: f(viewer),
            eye_from_local: rows(linear * inverse_unit),
            eye_from_pivot: f((linear * at_pivot + shift) * inverse_unit),
            normal_matrix: rows(normal_matrix),
            mirrored,
            similarity: similarity(linear),
            edge_scale: if size > 0.0 { (f64::from(1 << 20) / size) as f32 } else { 1.0 },
        }
    }

    /// The point of a mesh's box next to the eye, both in the mesh's numbers.
    fn pivot(&self, mesh: &ClusteredMesh, eye: DVec3) -> [f32; 3] {
        let bounds = mesh.local_bounds();
        if bounds.is_empty() || !eye.is_finite() {
            return [0.0; 3];
        }
        let p = eye.max(bounds.min).min(bounds.max);
        [p.x as f32, p.y as f32, p.z as f32]
    }

    /// The directions towards the viewer, see [`Sight`].
    pub fn sight(&self) -> Sight {
        let b = &self.basis;
        let f = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32];
        let along = if self.perspective { 1.0 / self.scale } else { 0.0 };
        Sight {
            base: f(-b.forward),
            right: f(b.right * -along),
            down: f(b.up * along),
            middle: self.middle(),
            // Half of the square's diagonal, and room for rounding.
            spread: (f64::from(SMALL_EXTENT) * std::f64::consts::FRAC_1_SQRT_2 * along * 1.01 + 1e-3) as f32,
        }
    }
}

/// The directions from a point of the picture towards the viewer, in world axes, of any length:
/// `(base + right * x) + down * y` with x and y in sub-pixels from the middle of the picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sight {
    /// In the middle of the picture, length 1.
    pub base: [f32; 3],
    /// Growth a sub-pixel to the right; zero for an orthographic camera.
    pub right: [f32; 3],
    /// Growth a sub-pixel downwards.
    pub down: [f32; 3],
    /// Screen coordinates of the middle of the picture.
    pub middle: [i32; 2],
    /// No direction in a square of [`SMALL_EXTENT`] differs by more from that in the middle of the square.
    pub spread: f32,
}

impl Sight {
    /// The direction at a point, in sub-pixels from the middle of the picture.
    pub fn at(&self, [x, y]: [i32; 2]) -> [f32; 3] {
        let [x, y] = [x as f32, y as f32];
        [0, 1, 2].map(|k| (self.base[k] + self.right[k] * x) + self.down[k] * y)
    }
}

/// The factor by which a map scales, if it scales all directions alike.
fn similarity(linear: DMat3) -> Option<f64> {
    let gram = linear.transpose() * linear;
    let square = (gram.x_axis.x + gram.y_axis.y + gram.z_axis.z) / 3.0;
    let error = (gram - DMat3::from_diagonal(DVec3::splat(square))).to_cols_array();
    error.into_iter().all(|e| e.abs() <= 1e-9 * square).then(|| square.sqrt())
}

/// The rows of the matrix to clip space, not rounded.
#[derive(Clone, Copy, Debug)]
pub struct ClipRows {
    /// Sub-pixels to the right of the middle, times w.
    pub x: [f64; 4],
    /// Sub-pixels below the middle, times w.
    pub y: [f64; 4],
    /// Distance along the line of sight in [`View::unit`]; 1 for an orthographic camera.
    pub w: [f64; 4],
    /// Depth times w.
    pub d: [f64; 4],
}

/// A camera's view of one instance: from positions as the mesh stores them to the screen.
#[derive(Clone, Debug)]
pub struct ObjectView {
    /// False for an orthographic camera.
    pub perspective: bool,
    /// What positions are taken relative to, in the mesh's numbers.
    pub pivot: [f32; 3],
    /// Row of the matrix that gives x times w, from positions relative to the pivot, as all rows.
    pub x: [f32; 4],
    /// Row that gives y times w.
    pub y: [f32; 4],
    /// Row that gives w (perspective), in [`View::unit`].
    pub w: [f32; 4],
    /// Row that gives the depth (orthographic).
    pub d: [f32; 4],
    /// Distance of the near plane, in [`View::unit`].
    pub near: f32,
    /// By which the depth of a corner is multiplied to be its weight: 1 / w, or less for all corners where the near plane
    /// is very near; 1 for an orthographic camera.
    pub weight: f32,
    /// Screen coordinates of the middle of the picture.
    pub offset: [i32; 2],
    /// The same rows in `f64` and from positions as the mesh has them, for clipping and for cluster tests.
    pub exact: ClipRows,
    /// The eye in local coordinates relative to the pivot; for an orthographic camera the direction towards the viewer.
    pub viewer: [f32; 3],
    /// Linear part of the map from local coordinates to world axes, in [`View::unit`].
    pub eye_from_local: [[f32; 3]; 3],
    /// Where the pivot is relative to the eye, in world axes and [`View::unit`].
    pub eye_from_pivot: [f32; 3],
    /// Normals from object space to world space, length not kept. Negated in a mirror image, whose fronts appear
    /// clockwise: times an area that is positive where a triangle appears counter-clockwise, a normal points to the side
    /// that is seen.
    pub normal_matrix: [[f32; 3]; 3],
    /// The instance is a mirror image: its fronts are clockwise.
    pub mirrored: bool,
    /// World units a unit of the mesh's numbers, if it is the same in all directions.
    pub similarity: Option<f64>,
    /// Brings edges to a size at which their products neither vanish nor overflow: to at most 2^20.
    pub edge_scale: f32,
}

/// A vertex on its way to the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenVertex {
    /// Screen coordinate, sub-pixels from the left.
    pub x: i32,
    /// Screen coordinate, sub-pixels from the top.
    pub y: i32,
    /// Depth.
    pub d: f32,
    /// False if it lies before the near plane or outside the guard band: `x`, `y` and `d` then mean nothing.
    pub inside: bool,
}

impl ObjectView {
    /// A position relative to the pivot. The kernels repeat this lane by lane.
    #[inline]
    pub fn relative(&self, p: [f32; 3]) -> [f32; 3] {
        [p[0] - self.pivot[0], p[1] - self.pivot[1], p[2] - self.pivot[2]]
    }

    /// Projects one position. The kernels repeat this sequence lane by lane.
    #[inline]
    pub fn project(&self, p: [f32; 3]) -> ScreenVertex {
        let p = self.relative(p);
        let row = |r: &[f32; 4]| ((p[0] * r[0] + p[1] * r[1]) + p[2] * r[2]) + r[3];
        let (cx, cy) = (row(&self.x), row(&self.y));
        let (x, y, d, behind) = if self.perspective {
            let w = row(&self.w);
            let inverse = 1.0 / w;
            (cx * inverse, cy * inverse, self.near * inverse, !(w >= self.near))
        } else {
            let d = row(&self.d);
            (cx, cy, d, !(d <= 1.0))
        };
        let inside = !behind && x.abs() <= GUARD && y.abs() <= GUARD;
        if !inside {
            return ScreenVertex { x: 0, y: 0, d: 0.0, inside };
        }
        let snap = |v: f32| v.round_ties_even() as i32;
        ScreenVertex { x: snap(x) + self.offset[0], y: snap(y) + self.offset[1], d, inside }
    }
}
