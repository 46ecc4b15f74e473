//! Cameras that move: round what they look at, and along keyframes.
//!
//! Points of a path are interpolated by cubic Hermite polynomials whose tangents are those of the parabola through a
//! keyframe and its neighbours (Catmull-Rom splines for keyframes that need not be equally far from each other in time).
//! So the path passes through every keyframe without a jump of speed, and is straight between two keyframes alone.

use glam::DVec3;
use tercio_mesh::trig::sin_cos_degrees;

use crate::Camera;

impl Camera {
    /// This camera after a turn by so many degrees round the line through its target along `axis`, a unit vector:
    /// counter-clockwise, seen from the end of the axis. Exact at quarter turns.
    pub fn turned(&self, axis: DVec3, degrees: f64) -> Self {
        let (sin, cos) = sin_cos_degrees(degrees);
        if (sin, cos) == (0.0, 1.0) {
            return *self;
        }
        let turn = |v: DVec3| {
            let along = axis * v.dot(axis);
            let across = v - along;
            along + across * cos + axis.cross(across) * sin
        };
        Self { eye: self.target + turn(self.eye - self.target), up: turn(self.up), ..*self }
    }
}

/// A camera at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// When, in seconds.
    pub time: f64,
    /// Position of the camera, world space.
    pub eye: DVec3,
    /// What it looks at, world space.
    pub target: DVec3,
    /// The direction that points upwards in the picture.
    pub up: DVec3,
    /// Full vertical angle of view, degrees.
    pub fov_y: f64,
}

impl Keyframe {
    /// All numbers but the time.
    fn values(&self) -> [f64; 10] {
        let [eye, target, up] = [self.eye, self.target, self.up].map(|v| v.to_array());
        [eye[0], eye[1], eye[2], target[0], target[1], target[2], up[0], up[1], up[2], self.fov_y]
    }

    fn from_values(time: f64, v: [f64; 10]) -> Self {
        let point = |first: usize| DVec3::new(v[first], v[first + 1], v[first + 2]);
        Self { time, eye: point(0), target: point(3), up: point(6), fov_y: v[9] }
    }
}

/// Why keyframes make no path.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// There are fewer than two.
    #[error("a path needs two keyframes or more, found {0}")]
    TooFew(usize),
    /// A number is not finite.
    #[error("keyframe {0} has a number that is not finite")]
    NotFinite(usize),
    /// Times do not increase.
    #[error("keyframe {number} is at {time} s, which is not after {before} s, the one before it")]
    NotAfter {
        /// The keyframe, counted from 1.
        number: usize,
        /// Its time.
        time: f64,
        /// The time of the keyframe before it.
        before: f64,
    },
}

/// A smooth path through keyframes. If the last keyframe has the camera of the first one, the path is closed: it goes on from
/// its end to its beginning without a jump of speed.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    keys: Vec<Keyframe>,
    is_closed: bool,
}

impl CameraPath {
    /// The path through these keyframes.
    ///
    /// # Errors
    /// [`PathError`].
    pub fn new(keys: Vec<Keyframe>) -> Result<Self, PathError> {
        let count = keys.len();
        let [first, .., last] = &keys[..] else { return Err(PathError::TooFew(count)) };
        let is_finite = |key: &Keyframe| key.time.is_finite() && key.values().iter().all(|v| v.is_finite());
        if let Some(number) = keys.iter().position(|key| !is_finite(key)) {
            return Err(PathError::NotFinite(number + 1));
        }
        if let Some(number) = (1..count).find(|&n| !(keys[n].time > keys[n - 1].time)) {
            let (time, before) = (keys[number].time, keys[number - 1].time);
            return Err(PathError::NotAfter { number: number + 1, time, before });
        }
        let is_closed = count > 2 && first.values() == last.values();
        Ok(Self { keys, is_closed })
    }

    /// Whether the path ends where it begins.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// The keyframes.
    pub fn keyframes(&self) -> &[Keyframe] {
        &self.keys
    }

    /// Seconds from the first keyframe to the last one.
    pub fn duration(&self) -> f64 {
        self.keys[self.keys.len() - 1].time - self.keys[0].time
    }

    /// The moments of so many frames, equally far from each other. The first one is at the first keyframe; the last one is at
    /// the last keyframe, except that a closed path ends one frame before it, so that it can be repeated.
    pub fn times(&self, frames: usize) -> impl Iterator<Item = f64> + '_ {
        let steps = if self.is_closed { frames } else { frames.saturating_sub(1) }.max(1);
        let (first, last) = (self.keys[0].time, self.keys[self.keys.len() - 1].time);
        let time = move |frame: usize| {
            let share = frame as f64 / steps as f64;
            // Exactly the last keyframe at its end.
            if frame == steps { last } else { first + (last - first) * share }
        };
        (0..frames).map(time)
    }

    /// The camera at a moment; at the first or last keyframe if it is before or after all of them. Angles of view stay
    /// between those of the keyframes beside the moment.
    pub fn at(&self, time: f64) -> Keyframe {
        let after = self.keys.partition_point(|key| key.time <= time);
        let (Some(a), Some(b)) = (after.checked_sub(1).map(|n| self.keys[n]), self.keys.get(after)) else {
            return if after == 0 { self.keys[0] } else { self.keys[after - 1] };
        };
        if a.time == time {
            return a;
        }
        let (span, t) = (b.time - a.time, (time - a.time) / (b.time - a.time));
        let (p, q) = (a.values(), b.values());
        let (m, n) = (self.tangent(after - 1), self.tangent(after));
        let s = 1.0 - t;
        let mut values: [f64; 10] = std::array::from_fn(|k| {
            let bend = m[k] * span * s - n[k] * span * t + (q[k] - p[k]) * (t - s);
            p[k] * s + q[k] * t + bend * s * t
        });
        values[9] = values[9].clamp(p[9].min(q[9]), p[9].max(q[9]));
        Keyframe::from_values(time, values)
    }

    /// How fast the numbers change at a keyframe, per second.
    fn tangent(&self, number: usize) -> [f64; 10] {
        let last = self.keys.len() - 1;
        match number {
            _ if self.is_closed && (number == 0 || number == last) => {
                mean_slope(self.slope(last - 1), self.slope(0))
            }
            _ if last == 1 => self.slope(0).1,
            0 => end_slope(self.slope(0), self.slope(1)),
            _ if number == last => end_slope(self.slope(last - 1), self.slope(last - 2)),
            _ => mean_slope(self.slope(number - 1), self.slope(number)),
        }
    }

    /// The length of the piece after a keyframe in seconds, and the mean speed in it.
    fn slope(&self, number: usize) -> (f64, [f64; 10]) {
        let (a, b) = (&self.keys[number], &self.keys[number + 1]);
        let (span, p, q) = (b.time - a.time, a.values(), b.values());
        (span, std::array::from_fn(|k| (q[k] - p[k]) / span))
    }
}

/// The slope of a parabola between two pieces, of which it has these mean slopes.
fn mean_slope(before: (f64, [f64; 10]), after: (f64, [f64; 10])) -> [f64; 10] {
    let all = before.0 + after.0;
    std::array::from_fn(|k| (before.1[k] * after.0 + after.1[k] * before.0) / all)
}

/// The slope of a parabola at its end, next to a piece and the one beside that.
fn end_slope(near: (f64, [f64; 10]), far: (f64, [f64; 10])) -> [f64; 10] {
    let middle = mean_slope(near, far);
    std::array::from_fn(|k| 2.0 * near.1[k] - middle[k])
}

#[cfg(test)]
mod tests;
