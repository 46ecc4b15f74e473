//! From world space to the screen: the transforms of one frame and of one instance.
//!
//! Matrices are computed in `f64` and rounded to `f32` once; a vertex then passes through [`ObjectView::project`],
//! the only sequence of operations by which every path of the renderer projects vertices.
//!
//! Two measures keep `f32` accurate enough at any size and at any position. Lengths are measured in [`View::unit`], a
//! power of two of about the size of the scene, so that the picture of a model does not depend on its units. And
//! positions are taken relative to [`ObjectView::pivot`], the point of the mesh's box nearest to the eye: the errors of
//! a position near the eye are then relative to its distance, not to the size of the scene.

use glam::{DMat3, DVec3};
use tercio_mesh::mesh::{exponent_of, power_of_two};
use tercio_mesh::{Aabb, ClusteredMesh};
use tercio_scene::camera::{CameraBasis, CameraError};
use tercio_scene::{Camera, Instance, Projection};

use crate::conventions::{GUARD, SMALL_EXTENT, SUBPIXELS};

/// The camera of one frame.
#[derive(Clone, Debug)]
pub struct View {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The eye in world space.
    pub eye: DVec3,
    /// The camera's axes in world space.
    pub basis: CameraBasis,
    /// Screen coordinates of the point where the line of sight meets the picture: its middle, unless the camera is
    /// shifted. No pixel is farther from it than the guard band.
    pub middle: [i32; 2],
    /// False for an orthographic camera.
    pub perspective: bool,
    /// Sub-pixels per world unit, at distance 1 for a perspective camera.
    pub scale: f64,
    /// Distance of the near plane along the line of sight, world units.
    pub near: f64,
    /// A distance farther than all of the scene, world units; the depth of an orthographic camera is relative to it.
    pub far: f64,
    /// The unit of length of the `f32` numbers of a frame, in world units: a power of two, such that no distance in the
    /// scene is above 1.
    pub unit: f64,
}

/// Distance of the automatic near plane of a perspective camera inside the scene, relative to the scene's radius:
/// 1e-12, far below the differences of position that `f32` can represent, except next to the mesh's origin. A near
/// plane this close costs no precision, because depths are relative to it.
const AUTO_NEAR: f64 = 1.0 / (1u64 << 40) as f64;

/// The smallest distance of a near plane, in [`View::unit`].
const MIN_NEAR: f64 = 1.0 / (1u64 << 60) as f64;

/// The largest factor from depths, which are at most 1, to weights of corners. Areas, whose sum is below 2^49, times
/// these weights, and the squares of such products, then stay inside the range of `f32`. The smallest weight,
/// [`MIN_NEAR`] times this factor, is still a vector length that is not treated as zero.
const MAX_WEIGHT: f64 = (1u64 << 12) as f64;

/// The smallest power of two that is above a length; 1 for a length of 0.
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
        // A perspective camera may be inside the model. If it is outside, the distance of the near plane does not
        // matter for precision, because depth is relative to it; half way to the model it clips nothing.
        let size = bounds.radius().max(f64::MIN_POSITIVE.sqrt());
        let automatic =
            if perspective { (AUTO_NEAR * size).max(0.5 * nearest) } else { nearest.max(0.0) - 1e-3 * size };
        let near = camera.near.unwrap_or(if perspective { automatic } else { automatic.max(0.0) });
        let far = farthest.max(near) + 1e-2 * size;
        let unit = unit_above(size.max(farthest.abs()).max(nearest.abs()).max(near));
        // Rounded as the kernels use it, so that distances computed from depths have no bias.
        let near = if perspective { f64::from((near / unit).max(MIN_NEAR) as f32) * unit } else { near };
        let middle = middle(camera, width, height)?;
        Ok(Self { width, height, eye: camera.eye, basis, middle, perspective, scale, near, far, unit })
    }

    /// Distance along the line of sight, in world units, from a depth above 0.
    pub fn distance(&self, depth: f32) -> f32 {
        let d = f64::from(depth);
        let distance = if self.perspective { self.near / d } else { self.far - d * (self.far - self.near) };
        distance as f32
    }

    /// The view of one instance.
    pub fn object(&self, instance: &Instance) -> ObjectView {
        let mesh = &*instance.mesh;
        // From mesh coordinates to world axes relative to the eye.
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
        // It keeps a normal on its side of the triangle, in mirror images too. Its scale is normalized, so that
        // products of normals and areas neither underflow nor overflow.
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
            weight: if self.perspective { (self.unit / self.near).min(MAX_WEIGHT) as f32 } else { 1.0 },
            offset: self.middle,
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

    /// The point of a mesh's box nearest to the eye, both in mesh coordinates.
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
            middle: self.middle,
            // Half of the square's diagonal, with a margin for rounding.
            spread: (f64::from(SMALL_EXTENT) * std::f64::consts::FRAC_1_SQRT_2 * along * 1.01 + 1e-3) as f32,
        }
    }
}

/// Where the line of sight meets the picture, in whole sub-pixels: an ordinary and a shifted camera then project with
/// the same operations, and snap to the same places.
fn middle(camera: &Camera, width: u32, height: u32) -> Result<[i32; 2], CameraError> {
    let [right, up] = camera.shift;
    let per_height = f64::from(height) * f64::from(SUBPIXELS);
    let mut middle = [0; 2];
    for (k, (size, shift)) in [(width, right), (height, -up)].into_iter().enumerate() {
        let size = f64::from(size) * f64::from(SUBPIXELS);
        let at = 0.5 * size + (shift * per_height).round();
        // Triangles are clipped at the guard band, which must not be inside the picture.
        if at.max(size - at) > f64::from(GUARD) {
            let range = "so small that no pixel is farther than 32768 pixels from the line of sight (for stereo: a \
                         smaller distance of the eyes, or a larger convergence)";
            return Err(CameraError::OutOfRange { what: "shift", range, value: camera.shift[k] });
        }
        middle[k] = at as i32;
    }
    Ok(middle)
}

/// The directions from points of the picture towards the viewer, in world axes, not normalized:
/// `(base + right * x) + down * y` with x and y in sub-pixels from the middle of the picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sight {
    /// The direction in the middle of the picture, length 1.
    pub base: [f32; 3],
    /// Increment per sub-pixel to the right; zero for an orthographic camera.
    pub right: [f32; 3],
    /// Increment per sub-pixel downwards; zero for an orthographic camera.
    pub down: [f32; 3],
    /// [`View::middle`].
    pub middle: [i32; 2],
    /// An upper bound of the difference between any direction in a square of [`SMALL_EXTENT`] sub-pixels and the
    /// direction in the middle of the square.
    pub spread: f32,
}

impl Sight {
    /// The direction at a point, in sub-pixels from the middle of the picture.
    pub fn at(&self, [x, y]: [i32; 2]) -> [f32; 3] {
        let [x, y] = [x as f32, y as f32];
        [0, 1, 2].map(|k| (self.base[k] + self.right[k] * x) + self.down[k] * y)
    }
}

/// The scale factor of a linear map, if it scales all directions alike.
fn similarity(linear: DMat3) -> Option<f64> {
    let gram = linear.transpose() * linear;
    let square = (gram.x_axis.x + gram.y_axis.y + gram.z_axis.z) / 3.0;
    let error = (gram - DMat3::from_diagonal(DVec3::splat(square))).to_cols_array();
    error.into_iter().all(|e| e.abs() <= 1e-9 * square).then(|| square.sqrt())
}

/// The rows of the matrix to clip space, not rounded to `f32`.
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
    /// The point that positions are taken relative to, in mesh coordinates.
    pub pivot: [f32; 3],
    /// Matrix row for x times w. As all rows, it takes positions relative to the pivot.
    pub x: [f32; 4],
    /// Matrix row for y times w.
    pub y: [f32; 4],
    /// Matrix row for w (perspective), in [`View::unit`].
    pub w: [f32; 4],
    /// Matrix row for the depth (orthographic).
    pub d: [f32; 4],
    /// Distance of the near plane, in [`View::unit`].
    pub near: f32,
    /// Factor from the depth of a corner to its weight in perspective interpolation: the weight is then 1 / w, or less
    /// for all corners alike if the near plane is very near; 1 for an orthographic camera.
    pub weight: f32,
    /// [`View::middle`].
    pub offset: [i32; 2],
    /// The same rows in `f64` for positions in mesh coordinates, not relative to the pivot: for clipping and for
    /// cluster tests.
    pub exact: ClipRows,
    /// The eye in local coordinates relative to the pivot; for an orthographic camera the direction towards the viewer.
    pub viewer: [f32; 3],
    /// Linear part of the map from local coordinates to world axes, in [`View::unit`].
    pub eye_from_local: [[f32; 3]; 3],
    /// Position of the pivot relative to the eye, in world axes and [`View::unit`].
    pub eye_from_pivot: [f32; 3],
    /// Normals from object space to world space; lengths change. Negated in a mirror image, whose front faces appear
    /// clockwise: a normal times an area that is positive where the triangle appears counter-clockwise points to the
    /// visible side.
    pub normal_matrix: [[f32; 3]; 3],
    /// Whether the instance is a mirror image: its front faces appear clockwise.
    pub mirrored: bool,
    /// World units per unit of mesh coordinates, if it is the same in all directions.
    pub similarity: Option<f64>,
    /// Scales edges to at most 2^20, so that their products neither underflow nor overflow.
    pub edge_scale: f32,
}

/// A projected vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenVertex {
    /// Screen coordinate, sub-pixels from the left.
    pub x: i32,
    /// Screen coordinate, sub-pixels from the top.
    pub y: i32,
    /// Depth.
    pub d: f32,
    /// False if the vertex is before the near plane or outside the guard band: `x`, `y` and `d` are then not valid.
    pub inside: bool,
}

impl ObjectView {
    /// A position relative to the pivot. The kernels do the same lane by lane.
    #[inline]
    pub fn relative(&self, p: [f32; 3]) -> [f32; 3] {
        [p[0] - self.pivot[0], p[1] - self.pivot[1], p[2] - self.pivot[2]]
    }

    /// Homogeneous coordinates of a position, in sub-pixels from the middle of the picture: x times w, y times w, and w, which is 1 for an
    /// orthographic camera. The kernels execute the same sequence lane by lane.
    #[inline]
    pub fn homogeneous(&self, p: [f32; 3]) -> [f32; 3] {
        let p = self.relative(p);
        let row = |r: &[f32; 4]| ((p[0] * r[0] + p[1] * r[1]) + p[2] * r[2]) + r[3];
        [row(&self.x), row(&self.y), if self.perspective { row(&self.w) } else { 1.0 }]
    }

    /// Projects one position. The kernels execute the same sequence lane by lane.
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
