//! Places a camera so that the model fills the picture.
//!
//! The solver only needs the model's support function (its extent in a direction), so the same one serves boxes,
//! which are fast and steady from frame to frame, and exact vertices, which fill the picture best.

use glam::DVec3;

mod extent;
mod outline;
mod turntable;

pub use extent::{Cells, Extent};
pub use outline::Outline;

use crate::camera::CameraBasis;
use crate::{Camera, Projection, Scene};
use tercio_mesh::{Aabb, trig};

/// Which world axis points upwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum UpAxis {
    /// +x up; the front is seen from +z, with -y to the right.
    X,
    /// +y up; the front is seen from +z, with +x to the right.
    #[default]
    Y,
    /// +z up; the front is seen from -y, with +x to the right, as in CAD.
    Z,
    /// -x up: the front of [`UpAxis::X`], upside down.
    NegX,
    /// -y up: the front of [`UpAxis::Y`], upside down.
    NegY,
    /// -z up: the front of [`UpAxis::Z`], upside down.
    NegZ,
}

impl UpAxis {
    /// The axes of the front view.
    pub fn front(self) -> CameraBasis {
        let (right, up) = match self {
            Self::X => (DVec3::NEG_Y, DVec3::X),
            Self::Y => (DVec3::X, DVec3::Y),
            Self::Z => (DVec3::X, DVec3::Z),
            Self::NegX => (DVec3::Y, DVec3::NEG_X),
            Self::NegY => (DVec3::NEG_X, DVec3::NEG_Y),
            Self::NegZ => (DVec3::NEG_X, DVec3::NEG_Z),
        };
        CameraBasis { right, up, forward: up.cross(right) }
    }
}

/// Position of the camera relative to the model. Left and right are those of the picture in the front view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum View {
    /// Looks at the front of the model.
    Front,
    /// From behind.
    Back,
    /// From the left border of the front view.
    Left,
    /// From the right border of the front view.
    Right,
    /// From above; the front is at the lower border of the picture.
    Top,
    /// From below; the front is at the upper border of the picture.
    Bottom,
    /// From above, front and right, with equal angles to the three axes.
    Iso,
}

impl View {
    /// Azimuth and elevation in degrees, as in [`Framing`].
    pub fn angles(self) -> (f64, f64) {
        match self {
            Self::Front => (0.0, 0.0),
            Self::Back => (180.0, 0.0),
            Self::Left => (-90.0, 0.0),
            Self::Right => (90.0, 0.0),
            Self::Top => (0.0, 90.0),
            Self::Bottom => (0.0, -90.0),
            Self::Iso => (45.0, std::f64::consts::FRAC_1_SQRT_2.atan().to_degrees()),
        }
    }
}

/// Parameters of the camera that the user chooses; everything else follows from the model's extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framing {
    /// Which axis points upwards.
    pub up_axis: UpAxis,
    /// Degrees around the up axis; 0 is the front, positive turns the camera to the right of the front view.
    pub azimuth: f64,
    /// Degrees above the horizon.
    pub elevation: f64,
    /// Degrees around the line of sight; positive turns the camera counter-clockwise, the picture clockwise.
    pub roll: f64,
    /// Above 1 shows the model larger. A perspective camera keeps its position and narrows its angle of view, so that
    /// zooming never moves it into the model nor changes occlusion.
    pub zoom: f64,
    /// Width by height of the picture.
    pub aspect: f64,
    /// Full vertical angle of view in degrees at zoom 1; `None` for an orthographic camera.
    pub fov_y: Option<f64>,
    /// The part of the picture's width or height, whichever is tighter, that the model fills at zoom 1.
    pub fill: f64,
    /// Whether the model also has to be inside that part after the camera was [turned](Camera::turned) round the up axis by
    /// any angle. The camera then looks at a point on the axis through the middle of the model.
    pub all_round: bool,
}

impl Default for Framing {
    /// From above, front and a little right, as one looks at an object on a table, through a short telephoto lens.
    fn default() -> Self {
        Self {
            up_axis: UpAxis::Y,
            azimuth: 15.0,
            elevation: 18.0,
            roll: 0.0,
            zoom: 1.0,
            aspect: 4.0 / 3.0,
            fov_y: Some(Self::FOV_Y),
            fill: 0.9,
            all_round: false,
        }
    }
}

impl Framing {
    /// The default vertical angle of view, degrees.
    pub const FOV_Y: f64 = 30.0;

    /// The default framing for a picture of this size in pixels. If the settings of the picture exist already,
    /// `Settings::framing` of `tercio-raster` takes the size from there.
    pub fn new(width: u32, height: u32) -> Self {
        Self { aspect: f64::from(width.max(1)) / f64::from(height.max(1)), ..Self::default() }
    }

    /// The same framing from a named view.
    pub fn with_view(self, view: View) -> Self {
        let (azimuth, elevation) = view.angles();
        Self { azimuth, elevation, ..self }
    }

    /// The axes of the camera. They stay orthogonal at the poles, where "up" becomes "away from the front" (from
    /// above) or "towards the front" (from below).
    pub fn basis(&self) -> CameraBasis {
        let front = self.up_axis.front();
        let (sin_a, cos_a) = trig::sin_cos_degrees(self.azimuth);
        let (sin_e, cos_e) = trig::sin_cos_degrees(self.elevation);
        let towards_eye = front.right * sin_a - front.forward * cos_a;
        let back = towards_eye * cos_e + front.up * sin_e;
        let level = CameraBasis {
            right: front.right * cos_a + front.forward * sin_a,
            up: front.up * cos_e - towards_eye * sin_e,
            forward: -back,
        };
        rolled(level, self.roll)
    }

    /// The camera for a model with these bounds: all eight corners are inside the part `fill` of the picture, centred
    /// in it.
    ///
    /// Bounds that are empty or a single point are framed like an object of size 1.
    pub fn camera(&self, bounds: &Aabb) -> Camera {
        let bounds = drawable(bounds);
        let half = bounds.size() * 0.5;
        let camera = self.fit(&bounds, |direction| self.reach_of_seen(direction, |d| d.abs().dot(half)));
        self.aimed(camera, bounds.center())
    }

    /// The camera that frames the vertices of a scene, which fills the picture better than their box does.
    ///
    /// The camera is the same however the meshes are split into clusters.
    pub fn camera_for_scene(&self, scene: &Scene) -> Camera {
        self.camera_for_reach(&scene.bounds(), |direction, from| scene.reach(direction, from))
    }

    /// The camera of [`Framing::camera_for_scene`] for vertices that need not be in one place: they have these world-space
    /// bounds, and `reach(direction, from)` is the largest `direction . (p - from)` of all vertices `p`. The directions in
    /// which it is called, and how often, depend on nothing but the framing, the bounds and what it returns.
    pub fn camera_for_reach(&self, bounds: &Aabb, reach: impl Fn(DVec3, DVec3) -> f64) -> Camera {
        let framed = drawable(bounds);
        if *bounds != framed {
            return self.camera(&framed);
        }
        let center = framed.center();
        let camera = self.fit(&framed, |direction| self.reach_of_seen(direction, |d| reach(d, center)));
        self.aimed(camera, center)
    }

    /// The camera of [`Framing::camera_for_scene`] for a scene of one mesh at the position given by its file, of which
    /// only the extent is known.
    pub fn camera_for_extent(&self, extent: &Extent) -> Camera {
        self.camera_for_reach(&extent.bounds(), |direction, from| extent.reach(direction, from))
    }

    /// A camera at `eye` that looks at `target`, with the roll, zoom and projection of this framing.
    /// Without `up`, the up axis points upwards, or the back of the front view if the line of sight is parallel to
    /// the up axis. The height of an orthographic camera's picture is what a perspective one with the default angle
    /// of view sees at the target.
    pub fn camera_at(&self, eye: DVec3, target: DVec3, up: Option<DVec3>) -> Camera {
        let front = self.up_axis.front();
        let distance = eye.distance(target);
        let up = up.unwrap_or_else(|| {
            let across = (target - eye).cross(front.up).length();
            if across > 1e-6 * distance { front.up } else { front.forward }
        });
        let tangent = half_tangent(self.fov_y.unwrap_or(Self::FOV_Y));
        let projection = match self.fov_y {
            Some(_) => Projection::Perspective { fov_y: self.zoomed_fov(tangent) },
            None => Projection::Orthographic { height: 2.0 * distance * tangent / self.zoom },
        };
        let mut camera = Camera { eye, target, up, projection, near: None, shift: [0.0; 2] };
        if self.roll != 0.0
            && let Ok(basis) = camera.basis()
        {
            camera.up = rolled(basis, self.roll).up;
        }
        camera
    }

    fn zoomed_fov(&self, tangent: f64) -> f64 {
        match self.fov_y {
            // The given value, exactly.
            Some(fov_y) if self.zoom == 1.0 => fov_y.to_radians(),
            _ => 2.0 * trig::atan2(tangent, self.zoom),
        }
    }

    /// `reach(d)` is the largest `d . (p - center)` of all points `p` of the model.
    fn fit(&self, bounds: &Aabb, reach: impl Fn(DVec3) -> f64) -> Camera {
        let CameraBasis { right, up, forward } = self.basis();
        let (back, center, radius) = (-forward, bounds.center(), bounds.radius());
        let nearest = reach(back);
        let place = |x: f64, y: f64, distance: f64, projection| {
            let target = center + right * x + up * y;
            Camera { eye: target + back * distance, target, up, projection, near: None, shift: [0.0; 2] }
        };
        let Some(fov_y) = self.fov_y else {
            let (width, x) = extent(reach(right), reach(-right));
            let (height, y) = extent(reach(up), reach(-up));
            // Along a line, or a flat model seen edge-on, the extent may be zero.
            let height = height.max(width / self.aspect).max(radius * 1e-6) / (self.fill * self.zoom);
            return place(x, y, nearest + radius, Projection::Orthographic { height });
        };
        let tangent = half_tangent(fov_y);
        let (tan_x, tan_y) = (tangent * self.aspect * self.fill, tangent * self.fill);
        let distance_x = Axis { across: right, back, reach: &reach }.nearest_eye(tan_x);
        let distance_y = Axis { across: up, back, reach: &reach }.nearest_eye(tan_y);
        // The nearest point of the model must not touch the eye.
        let distance = distance_x.max(distance_y).max(nearest + radius * 1e-3);
        let x = Axis { across: right, back, reach: &reach }.middle(distance, tan_x);
        let y = Axis { across: up, back, reach: &reach }.middle(distance, tan_y);
        place(x, y, distance, Projection::Perspective { fov_y: self.zoomed_fov(tangent) })
    }
}

/// One direction of the picture under perspective. An eye at `x` along `across` and `d` along `back` sees a
/// point `p` at the tangent `(p.across - x) / (d - p.back)`; all of them are at most `t` if
/// `reach(across + t back) <= t d + x` and `reach(-across + t back) <= t d - x`.
struct Axis<'a, F> {
    across: DVec3,
    back: DVec3,
    reach: &'a F,
}

impl<F: Fn(DVec3) -> f64> Axis<'_, F> {
    fn reaches(&self, t: f64) -> (f64, f64) {
        ((self.reach)(self.across + self.back * t), (self.reach)(self.back * t - self.across))
    }

    /// The smallest distance from which everything is seen at tangents up to `t`, for a suitable `x`.
    fn nearest_eye(&self, t: f64) -> f64 {
        let (plus, minus) = self.reaches(t);
        (plus + minus) / (2.0 * t)
    }

    /// The `x` at which the model is centred in the picture, seen from `distance`; `t` is a tangent at which all of
    /// it can be seen from there.
    ///
    /// Solves for the smallest tangent that still contains the model: the root of the slack `2 t d - plus - minus`,
    /// which increases with t and is minus the model's width at 0. Found by the Illinois method: the secant method,
    /// where the weight of an end that does not move is halved.
    fn middle(&self, distance: f64, t: f64) -> f64 {
        let slack = |t: f64| {
            let (plus, minus) = self.reaches(t);
            (2.0 * t * distance - plus - minus, (plus - minus) * 0.5)
        };
        let (mut high_slack, mut x) = slack(t);
        let (mut low, mut high, mut low_slack) = (0.0, t, slack(0.0).0);
        let mut was_low = None;
        for _ in 0..64 {
            if high_slack <= 0.0 || high - low <= 1e-4 * high {
                break;
            }
            let next = high - high_slack * (high - low) / (high_slack - low_slack);
            let (next_slack, next_x) = slack(next);
            let is_low = next_slack < 0.0;
            x = next_x;
            if next_slack == 0.0 || next == low || next == high {
                break;
            } else if is_low {
                (low, low_slack) = (next, next_slack);
                high_slack *= if was_low == Some(true) { 0.5 } else { 1.0 };
            } else {
                (high, high_slack) = (next, next_slack);
                low_slack *= if was_low == Some(false) { 0.5 } else { 1.0 };
            }
            was_low = Some(is_low);
        }
        x
    }
}

/// Width and centre, from the extent to both sides.
fn extent(plus: f64, minus: f64) -> (f64, f64) {
    (plus + minus, (plus - minus) * 0.5)
}

/// Bounds with an extent that `f64` can resolve at their distance from zero.
fn drawable(bounds: &Aabb) -> Aabb {
    if bounds.is_empty() || !bounds.min.is_finite() || !bounds.max.is_finite() {
        return Aabb { min: DVec3::splat(-0.5), max: DVec3::splat(0.5) };
    }
    let far = bounds.min.abs().max(bounds.max.abs()).max_element();
    let size = bounds.size().max_element();
    if size > far * 1e-13 {
        return *bounds;
    }
    let half = DVec3::splat((far * 1e-6).max(0.5));
    Aabb { min: bounds.center() - half, max: bounds.center() + half }
}

fn half_tangent(degrees: f64) -> f64 {
    let (sin, cos) = trig::sin_cos(degrees.to_radians() * 0.5);
    sin / cos
}

fn rolled(basis: CameraBasis, roll: f64) -> CameraBasis {
    let (sin, cos) = trig::sin_cos_degrees(roll);
    CameraBasis {
        right: basis.right * cos + basis.up * sin,
        up: basis.up * cos - basis.right * sin,
        forward: basis.forward,
    }
}

#[cfg(test)]
mod tests;
