//! Pictures.

use std::ffi::{c_char, c_int};
use std::ptr;

use tercio::parallel::Communicator as _;
use tercio::raster::sampling::{SamplePattern, Sampling};
use tercio::scene::Background;
use tercio::{Picture, Settings};

use crate::session::{run, tercio_session, with};
use crate::values::{text, unit, values};

/// The colour (sRGB) and alpha of the background, all 0 to 1.
///
/// # Safety
/// `rgba` points to four numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_set_background(session: *mut tercio_session, rgba: *const f64) -> c_int {
    let set = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        let rgba = unit(unsafe { values::<f64, 4>(rgba, "the background") }?)?;
        *with!(&mut session.ranks, s => s.background_mut()) = Background::Solid(rgba.map(|c| c as f32));
        Ok(())
    };
    // SAFETY: likewise.
    unsafe { run(session, set) }
}

/// Width and height of the pictures in pixels, 1024 x 768 if they are not set, and the samples of each pixel: 1, 2, 4, 8 or 16; 0 for the
/// default.
///
/// # Safety
/// As [`tercio_set_timeout`](crate::tercio_set_timeout).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_set_picture(
    session: *mut tercio_session,
    width: u32,
    height: u32,
    samples: u32,
) -> c_int {
    let set = |session: &mut tercio_session| {
        let mut settings = Settings::new(width, height);
        if samples > 0 {
            let pattern = match samples {
                1 => SamplePattern::Center,
                2 => SamplePattern::Sparse2,
                4 => SamplePattern::Sparse4,
                8 => SamplePattern::Sparse8,
                16 => SamplePattern::Sparse16,
                _ => return Err(format!("samples must be 1, 2, 4, 8 or 16, found {samples}").into()),
            };
            settings.sampling = Sampling::of(pattern);
        }
        settings.check()?;
        session.settings = settings;
        Ok(())
    };
    // SAFETY: as required from the caller.
    unsafe { run(session, set) }
}

/// Draws a picture of all parts, and of what is shown. Collective. Rank 0 of the communicator gets it.
///
/// # Safety
/// As [`tercio_set_timeout`](crate::tercio_set_timeout).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_render(session: *mut tercio_session) -> c_int {
    let render = |session: &mut tercio_session| {
        let framing = session.framing();
        let tercio_session { ranks, settings, camera, .. } = session;
        with!(ranks, s => {
            let camera = match *camera {
                Some(camera) => camera,
                None => *camera.insert(s.camera(&framing)?),
            };
            s.render(&camera, settings)?;
        });
        Ok(())
    };
    // SAFETY: as required from the caller.
    unsafe { run(session, render) }
}

/// Stores where the pixels of the last picture are: four bytes each (sRGB and alpha, not premultiplied), row by row, the upper left one
/// first, and width and height. They are valid until the next call with this session. On other ranks than rank 0, and before the
/// first picture, NULL and zeros are stored.
///
/// # Safety
/// `pixels`, `width` and `height` may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_pixels(
    session: *mut tercio_session,
    pixels: *mut *const u8,
    width: *mut u32,
    height: *mut u32,
) -> c_int {
    let store = |session: &mut tercio_session| {
        let frame = with!(&session.ranks, s => s.frame());
        let found =
            frame.map_or((ptr::null(), 0, 0), |f| (f.planes.color.as_ptr().cast::<u8>(), f.width, f.height));
        // SAFETY: as required from the caller.
        let (pixels, width, height) = unsafe { (pixels.as_mut(), width.as_mut(), height.as_mut()) };
        if let Some(pixels) = pixels {
            *pixels = found.0;
        }
        if let Some(width) = width {
            *width = found.1;
        }
        if let Some(height) = height {
            *height = found.2;
        }
        Ok(())
    };
    // SAFETY: as required from the caller.
    unsafe { run(session, store) }
}

/// Writes the last picture, as PNG, PPM, WebP or JPEG by its extension; a file is replaced only when the new one is complete. On other ranks
/// than rank 0 nothing is done.
///
/// # Safety
/// `path` is a C string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_save(session: *mut tercio_session, path: *const c_char) -> c_int {
    let save = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        let path = unsafe { text(path) }?;
        let rank = with!(&mut session.ranks, s => s.comm_mut().rank());
        match with!(&session.ranks, s => s.frame()) {
            Some(frame) => Ok(Picture::from_frame(frame).save(path)?),
            None if rank > 0 => Ok(()),
            None => Err(format!("{path}: no picture was drawn yet").into()),
        }
    };
    // SAFETY: likewise.
    unsafe { run(session, save) }
}
