//! The camera: position, direction and projection.

use glam::DVec3;

/// How view space is projected to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A perspective camera; `fov_y` is the full vertical angle in radians, above 0 and below pi.
    Perspective {
        /// Full vertical angle of view, radians.
        fov_y: f64,
    },
    /// An orthographic camera; the picture is `height` world units high.
    Orthographic {
        /// World units from the lower to the upper border of the picture.
        height: f64,
    },
}

/// A camera in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the camera.
    pub eye: DVec3,
    /// The point at the centre of the picture, unless there is a shift; must differ from `eye`.
    pub target: DVec3,
    /// The direction that points upwards in the picture; must not be parallel to the line of sight.
    pub up: DVec3,
    /// The projection.
    pub projection: Projection,
    /// Distance of the near plane along the line of sight, world units; `None` lets the renderer choose one that cuts
    /// off nothing visible: at 10^-12 of the scene's radius if the camera is inside the scene.
    pub near: Option<f64>,
    /// Where the line of sight meets the picture, to the right of its centre and above it, in heights of the picture:
    /// `[0.0; 2]` for an ordinary camera. Others have an off-axis view volume, as the eyes of a stereo pair do: the
    /// image plane is moved in itself, and the line of sight stays perpendicular to it. The renderer rounds a shift to
    /// whole sub-pixels.
    pub shift: [f64; 2],
}

/// The camera's axes in world space, orthonormal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraBasis {
    /// To the right in the picture.
    pub right: DVec3,
    /// Upwards in the picture.
    pub up: DVec3,
    /// Into the picture.
    pub forward: DVec3,
}

/// Why a camera cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// Eye and target are the same point, or a coordinate is not finite.
    #[error("the camera's eye and target must be two different finite points (eye {eye}, target {target})")]
    NoDirection {
        /// The eye.
        eye: DVec3,
        /// The target.
        target: DVec3,
    },
    /// The up vector is zero or parallel to the line of sight.
    #[error("the camera's up vector {up} must not be zero or along the line of sight {forward}")]
    NoUp {
        /// The up vector.
        up: DVec3,
        /// The line of sight.
        forward: DVec3,
    },
    /// A field of view or height out of range.
    #[error("the camera's {what} must be {range}, is {value}")]
    OutOfRange {
        /// Name of the parameter.
        what: &'static str,
        /// The valid range.
        range: &'static str,
        /// The value.
        value: f64,
    },
    /// A stereo pair of an orthographic camera: moved sideways, it sees the same.
    #[error(
        "stereo pictures need a camera with perspective: a parallel projection looks the same to both eyes"
    )]
    NoStereo,
}

impl Camera {
    /// The camera's axes.
    ///
    /// # Errors
    /// [`CameraError`] if the fields do not make a camera.
    pub fn basis(&self) -> Result<CameraBasis, CameraError> {
        let (what, range, value, good) = match self.projection {
            Projection::Perspective { fov_y } => {
                let range = "above 0 and below 180 degrees";
                ("field of view", range, fov_y.to_degrees(), fov_y > 0.0 && fov_y < std::f64::consts::PI)
            }
            Projection::Orthographic { height } => {
                ("height", "above 0 and finite", height, height > 0.0 && height.is_finite())
            }
        };
        if !good {
            return Err(CameraError::OutOfRange { what, range, value });
        }
        if let Some(near) = self.near.filter(|near| !(*near > 0.0 && near.is_finite())) {
            let range = "above 0 and finite";
            return Err(CameraError::OutOfRange { what: "near distance", range, value: near });
        }
        if let Some(&value) = self.shift.iter().find(|shift| !shift.is_finite()) {
            return Err(CameraError::OutOfRange { what: "shift", range: "finite", value });
        }
        let no_direction = CameraError::NoDirection { eye: self.eye, target: self.target };
        let forward = (self.target - self.eye).try_normalize().ok_or(no_direction)?;
        let no_up = CameraError::NoUp { up: self.up, forward };
        let up_hint = self.up.try_normalize().ok_or(no_up)?;
        let side = forward.cross(up_hint);
        if side.length() < 1e-9 {
            return Err(no_up);
        }
        let right = side.normalize();
        Ok(CameraBasis { right, up: right.cross(forward), forward })
    }
}
