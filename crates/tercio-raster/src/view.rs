//! From world space to the picture: what the camera means for one frame and one instance.
//!
//! Matrices are made in `f64` and rounded to `f32` once; a vertex then passes through [`ObjectView::project`],
//! the one sequence of operations by which every path of the renderer reaches the screen.

use glam::{DMat3, DVec3};
use tercio_mesh::Aabb;
use tercio_scene::camera::{CameraBasis, CameraError};
use tercio_scene::{Camera, Instance, Projection};

use crate::conventions::{GUARD, SUBPIXELS};

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
    /// Distance of the near plane along the line of sight.
    pub near: f64,
    /// A distance beyond everything (orthographic depth only).
    pub far: f64,
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
        // A perspective camera may stand inside the model: the plane is then as near as the precision of
        // positions allows. In front of the model its place does not matter, depth being relative to it.
        let size = bounds.radius().max(f64::MIN_POSITIVE.sqrt());
        let automatic =
            if perspective { (1e-4 * size).max(0.5 * nearest) } else { nearest.max(0.0) - 1e-3 * size };
        let near = camera.near.unwrap_or(if perspective { automatic } else { automatic.max(0.0) });
        let far = farthest.max(near) + 1e-2 * size;
        Ok(Self { width, height, eye: camera.eye, basis, perspective, scale, near, far })
    }

    /// Distance along the line of sight, in world units, of a depth above 0.
    pub fn distance(&self, depth: f32) -> f32 {
        let d = f64::from(depth);
        let distance = if self.perspective { self.near / d } else { self.far - d * (self.far - self.near) };
        distance as f32
    }

    /// The view of one instance.
    pub fn object(&self, instance: &Instance) -> ObjectView {
        let linear = instance.world_from_object.matrix3;
        let shift = instance.world_from_object.transform_point3(instance.mesh.origin) - self.eye;
        // A row of the combined matrix: `axis . (linear * p + shift) * scale + add`.
        let row = |axis: DVec3, scale: f64, add: f64| {
            let r = linear.transpose() * axis * scale;
            [r.x, r.y, r.z, axis.dot(shift) * scale + add]
        };
        let b = &self.basis;
        let x = row(b.right, self.scale, 0.0);
        let y = row(b.up, -self.scale, 0.0);
        let (w, d) = if self.perspective {
            (row(b.forward, 1.0, 0.0), [0.0, 0.0, 0.0, self.near])
        } else {
            let k = 1.0 / (self.far - self.near);
            ([0.0, 0.0, 0.0, 1.0], row(b.forward, -k, self.far * k))
        };
        let inverse = linear.inverse();
        let mirrored = linear.determinant() < 0.0;
        // It keeps the side of a plane on which a normal stands, of mirror images too. Its scale is taken out, so that
        // normals times areas neither vanish nor overflow.
        let normal_matrix = inverse.transpose();
        let largest = normal_matrix.to_cols_array().into_iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let scale = if largest > 0.0 && largest.is_finite() { 1.0 / largest } else { 1.0 };
        let normal_matrix = normal_matrix * if mirrored { -scale } else { scale };
        // Towards the viewer in object space: the eye itself, or the direction of all rays.
        let viewer = if self.perspective { inverse * -shift } else { inverse * -b.forward };
        let f = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32];
        let rows = |m: DMat3| [f(m.row(0)), f(m.row(1)), f(m.row(2))];
        let single = |r: [f64; 4]| r.map(|v| v as f32);
        let size = instance.mesh.bounds.size().max_element();
        ObjectView {
            perspective: self.perspective,
            x: single(x),
            y: single(y),
            w: single(w),
            d: single(d),
            near: self.near as f32,
            offset: [self.width as i32 * SUBPIXELS / 2, self.height as i32 * SUBPIXELS / 2],
            exact: ClipRows { x, y, w, d },
            viewer: f(viewer),
            world_from_local: rows(linear),
            eye_from_local: f(shift),
            normal_matrix: rows(normal_matrix),
            mirrored,
            similarity: similarity(linear),
            inverse_size: if size > 0.0 { (1.0 / size) as f32 } else { 1.0 },
        }
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
    /// Distance along the line of sight; 1 for an orthographic camera.
    pub w: [f64; 4],
    /// Depth times w.
    pub d: [f64; 4],
}

/// A camera's view of one instance: from positions as the mesh stores them to the screen.
#[derive(Clone, Debug)]
pub struct ObjectView {
    /// False for an orthographic camera.
    pub perspective: bool,
    /// Row of the matrix that gives x times w.
    pub x: [f32; 4],
    /// Row that gives y times w.
    pub y: [f32; 4],
    /// Row that gives w (perspective).
    pub w: [f32; 4],
    /// Row that gives the depth (orthographic).
    pub d: [f32; 4],
    /// Distance of the near plane.
    pub near: f32,
    /// Screen coordinates of the middle of the picture.
    pub offset: [i32; 2],
    /// The same rows in `f64`, for clipping and for cluster tests.
    pub exact: ClipRows,
    /// The eye in local coordinates; for an orthographic camera the direction towards the viewer.
    pub viewer: [f32; 3],
    /// Linear part of the map from local coordinates to world space.
    pub world_from_local: [[f32; 3]; 3],
    /// What is added to it to be relative to the eye, in world axes.
    pub eye_from_local: [f32; 3],
    /// Normals from object space to world space, length not kept. Negated in a mirror image, whose fronts appear
    /// clockwise: times an area that is positive where a triangle appears counter-clockwise, a normal points to the side
    /// that is seen.
    pub normal_matrix: [[f32; 3]; 3],
    /// The instance is a mirror image: its fronts are clockwise.
    pub mirrored: bool,
    /// World units an object unit, if it is the same in all directions.
    pub similarity: Option<f64>,
    /// Brings edges to a size at which their products neither vanish nor overflow.
    pub inverse_size: f32,
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
    /// Projects one position. The kernels repeat this sequence lane by lane.
    #[inline]
    pub fn project(&self, p: [f32; 3]) -> ScreenVertex {
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
