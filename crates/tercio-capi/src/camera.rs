//! Cameras.

use std::ffi::{c_char, c_int};

use tercio::glam::DVec3;
use tercio::scene::{Projection, UpAxis};
use tercio::{Camera, Framing};

use crate::session::{run, tercio_session, with};
use crate::values::values;

/// Which axis points upwards for [`tercio_fit_camera`]: 'x', 'y', which is the default, or 'z'.
///
/// # Safety
/// As [`tercio_set_timeout`](crate::tercio_set_timeout).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_set_up_axis(session: *mut tercio_session, axis: c_char) -> c_int {
    let set = |session: &mut tercio_session| {
        session.up_axis = match axis as u8 {
            b'x' => UpAxis::X,
            b'y' => UpAxis::Y,
            b'z' => UpAxis::Z,
            other => return Err(format!("expected 'x', 'y' or 'z', found {:?}", char::from(other)).into()),
        };
        Ok(())
    };
    // SAFETY: as required from the caller.
    unsafe { run(session, set) }
}

/// Places the camera so that it sees all parts: degrees to the right of the front and above the horizon, and a zoom, 1 to fill the
/// picture. Collective. The camera stays until it is placed again; without a camera the first picture gets one that fits.
///
/// # Safety
/// As [`tercio_set_timeout`](crate::tercio_set_timeout).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_fit_camera(
    session: *mut tercio_session,
    azimuth: f64,
    elevation: f64,
    zoom: f64,
) -> c_int {
    let fit = |session: &mut tercio_session| {
        if !(azimuth.is_finite() && elevation.is_finite() && zoom.is_finite() && zoom > 0.0) {
            return Err("angles must be finite, and the zoom above 0".into());
        }
        let framing = Framing { azimuth, elevation, zoom, ..session.framing() };
        session.camera = Some(with!(&mut session.ranks, s => s.camera(&framing))?);
        Ok(())
    };
    // SAFETY: as required from the caller.
    unsafe { run(session, fit) }
}

/// Places the camera: its position, the point in the middle of the picture, the direction that points upwards, and the full vertical
/// angle of view in degrees.
///
/// # Safety
/// `eye`, `target` and `up` point to three numbers each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_set_camera(
    session: *mut tercio_session,
    eye: *const f64,
    target: *const f64,
    up: *const f64,
    fov_degrees: f64,
) -> c_int {
    let set = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        let point = |at, what| unsafe { values::<f64, 3>(at, what) }.map(DVec3::from);
        let camera = Camera {
            eye: point(eye, "the eye")?,
            target: point(target, "the target")?,
            up: point(up, "the up vector")?,
            projection: Projection::Perspective { fov_y: fov_degrees.to_radians() },
            near: None,
            shift: [0.0; 2],
        };
        camera.basis()?;
        session.camera = Some(camera);
        Ok(())
    };
    // SAFETY: likewise.
    unsafe { run(session, set) }
}
