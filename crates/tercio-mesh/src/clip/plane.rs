//! Planes that cut, in world space and in the coordinates of a mesh.

use glam::DVec3;

use crate::mesh::{exponent_of, power_of_two};
use crate::{Aabb, Mesh};

/// A plane and the side of it that is kept: that of the points `p` with `normal . p + offset >= 0`, in world space,
/// whose coordinates are those of the file.
///
/// So the normal points to what is kept, as in VTK (`vtkClipPolyData`, clipping planes of its mappers).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlane {
    normal: DVec3,
    offset: f64,
}

impl ClipPlane {
    /// The largest absolute value of a number of the plane, and the smallest of the largest component of its normal is
    /// the inverse of it: products with coordinates must not overflow.
    pub const LARGEST: f64 = 1e100;

    /// The plane `normal . p + offset = 0`. The normal may have any length; `None` if it is zero, or if a number is not
    /// finite or out of range ([`ClipPlane::LARGEST`]).
    pub fn new(normal: DVec3, offset: f64) -> Option<Self> {
        let largest = normal.abs().max_element();
        let good = (1.0 / Self::LARGEST..=Self::LARGEST).contains(&largest)
            && normal.is_finite()
            && offset.abs() <= Self::LARGEST;
        // Multiplied by a power of two, which is exact.
        let scale = power_of_two(-exponent_of(largest.max(f64::MIN_POSITIVE)));
        good.then(|| Self { normal: normal * scale, offset: offset * scale })
    }

    /// The direction of what is kept; its largest component is at least 1 and less than 2.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Distance from the plane times the length of the normal, positive on the side that is kept.
    pub fn distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point) + self.offset
    }
}

/// An axis of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

/// Where a model is clipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clip {
    /// At a plane in world space.
    Plane(ClipPlane),
    /// At a plane across an axis, placed relative to the bounds of the model.
    Fraction {
        /// The axis.
        axis: Axis,
        /// 0 for the lower bound along the axis, 1 for the upper one; finite.
        fraction: f64,
        /// Whether the side of the lower coordinates is kept, otherwise that of the higher ones.
        keeps_lower: bool,
    },
}

impl Clip {
    /// The plane for a model with these world-space bounds; `None` if the bounds are empty, or so large or so far away
    /// that [`ClipPlane::new`] refuses the plane.
    pub fn plane(&self, bounds: &Aabb) -> Option<ClipPlane> {
        match *self {
            Self::Plane(plane) => Some(plane),
            Self::Fraction { axis, fraction, keeps_lower } => {
                let axis = axis as usize;
                let at = bounds.min[axis] * (1.0 - fraction) + bounds.max[axis] * fraction;
                let direction = if keeps_lower { -1.0 } else { 1.0 };
                let mut normal = DVec3::ZERO;
                normal[axis] = direction;
                ClipPlane::new(normal, -direction * at)
            }
        }
    }
}

/// Where a vertex is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Removed,
    /// In the plane, as far as its coordinates can tell.
    On,
    Kept,
}

/// A plane in the coordinates of a mesh: relative to its origin, in its unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalPlane {
    pub normal: DVec3,
    pub offset: f64,
    /// What rounding may have added to `offset`.
    margin: f64,
}

/// Half of the distance between neighbouring `f32` numbers, relative to them, is at most this.
const HALF_STEP: f64 = 1.0 / (1 << 24) as f64;

/// The same for `f64`, with some room for sums.
const MARGIN: f64 = 1.0 / (1u64 << 50) as f64;

impl LocalPlane {
    pub fn new(plane: &ClipPlane, mesh: &Mesh) -> Self {
        let shift = plane.normal * mesh.origin;
        Self {
            normal: plane.normal * mesh.unit(),
            offset: shift.x + shift.y + shift.z + plane.offset,
            margin: MARGIN * (shift.abs().element_sum() + plane.offset.abs()),
        }
    }

    /// Distance times the length of the normal.
    pub fn distance(&self, p: [f32; 3]) -> f64 {
        let n = self.normal;
        n.x * f64::from(p[0]) + n.y * f64::from(p[1]) + n.z * f64::from(p[2]) + self.offset
    }

    /// A vertex is in the plane if it is nearer to it than its coordinates are exact. So the point at which an edge
    /// from one side to the other meets the plane differs from both its ends, also after it is rounded, and is itself
    /// in the plane; and no cut leaves slivers between a vertex and the plane through it.
    pub fn side(&self, p: [f32; 3]) -> Side {
        let terms = DVec3::new(p[0].into(), p[1].into(), p[2].into()) * self.normal;
        let exact = HALF_STEP * terms.abs().element_sum() + self.margin;
        let distance = self.distance(p);
        if distance > exact {
            Side::Kept
        } else if distance < -exact {
            Side::Removed
        } else {
            Side::On
        }
    }

    /// The axis along which the plane is projected: that of the largest component of its normal.
    pub fn main_axis(&self) -> usize {
        let n = self.normal.abs();
        if n.x >= n.y && n.x >= n.z {
            0
        } else if n.y >= n.z {
            1
        } else {
            2
        }
    }
}
