//! Sessions.

use std::error::Error;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;
use std::slice;

use tercio::glam::{DAffine3, DMat4, DVec3};
use tercio::mesh::arrays::{Arrays, Positions};
use tercio::mesh::color::srgb_to_linear;
use tercio::parallel::comm::threads::ThreadComm;
use tercio::parallel::{Communicator as _, Organisation};
use tercio::raster::sampling::{SamplePattern, Sampling};
use tercio::scene::{Background, Projection, UpAxis};
use tercio::{Camera, Framing, PartId, Picture, Session, Settings};

use crate::error::{attempt, status};
use crate::tercio_arrays;
use crate::threads::start_default;

type Failed = Box<dyn Error>;

/// What one process draws with, together with the other processes of its session. It is used by one thread at a time; with MPI, by the
/// thread that may call MPI.
#[derive(Debug)]
pub struct tercio_session {
    ranks: Ranks,
    settings: Settings,
    up_axis: UpAxis,
    /// Chosen by the program, or made for the first picture.
    camera: Option<Camera>,
}

#[derive(Debug)]
enum Ranks {
    Alone(Session<ThreadComm>),
    #[cfg(feature = "mpi")]
    Mpi(Session<tercio_mpi::MpiComm>),
}

/// Runs code with the session of either kind.
macro_rules! with {
    ($ranks:expr, $session:ident => $work:expr) => {
        match $ranks {
            Ranks::Alone($session) => $work,
            #[cfg(feature = "mpi")]
            Ranks::Mpi($session) => $work,
        }
    };
}

impl tercio_session {
    fn new(ranks: Ranks) -> *mut Self {
        let session =
            Self { ranks, settings: Settings::new(1024, 768), up_axis: UpAxis::default(), camera: None };
        Box::into_raw(Box::new(session))
    }

    fn framing(&self) -> Framing {
        Framing { up_axis: self.up_axis, ..self.settings.framing() }
    }
}

/// Runs work with a session that is not null.
///
/// # Safety
/// The session is null or was opened, and not closed yet, and nobody else uses it now.
unsafe fn run(
    session: *mut tercio_session,
    work: impl FnOnce(&mut tercio_session) -> Result<(), Failed>,
) -> c_int {
    // SAFETY: as required from the caller.
    status(|| match unsafe { session.as_mut() } {
        Some(session) => work(session),
        None => Err("the session is NULL".into()),
    })
}

/// Makes something of arrays, on all ranks or on none: if those of this rank cannot be read, the others learn it.
///
/// # Safety
/// As [`tercio_arrays::read`], if the pointer is not null.
unsafe fn with_arrays<T>(
    arrays: *const tercio_arrays,
    make: impl FnOnce(&Arrays) -> Result<T, tercio::Error>,
) -> Result<T, Failed> {
    // SAFETY: as required from the caller.
    let read = match unsafe { arrays.as_ref() } {
        // SAFETY: likewise.
        Some(arrays) => unsafe { arrays.read() },
        None => Err("the arrays are NULL".into()),
    };
    match read {
        Ok(arrays) => Ok(make(&arrays)?),
        Err(error) => {
            let no_mesh = Arrays::new(Positions::F32(&[]), &[[0; 3]]);
            make(&no_mesh).map_or_else(|_| Err(error), |_| Err("arrays without vertices were a mesh".into()))
        }
    }
}

/// Opens a session of this process alone; NULL if it failed.
#[unsafe(no_mangle)]
pub extern "C" fn tercio_open() -> *mut tercio_session {
    let open = || {
        start_default()?;
        Ok(tercio_session::new(Ranks::Alone(Session::alone())))
    };
    attempt(open).unwrap_or(ptr::null_mut())
}

/// Opens a session of all processes of an MPI communicator; `comm` points to the `MPI_Comm`. Collective. The library uses a duplicate
/// of it, so that its messages and those of the program never meet; MPI is called by the threads that call the functions of the
/// session. NULL if it failed, also if the library was built without MPI.
///
/// # Safety
/// `comm` points to a valid communicator of the MPI library that this library was built with, MPI is initialized, and this thread may
/// call it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_open_mpi(comm: *const c_void) -> *mut tercio_session {
    let open = || {
        if comm.is_null() {
            return Err("the communicator is NULL".into());
        }
        start_default()?;
        #[cfg(feature = "mpi")]
        {
            // SAFETY: as required from the caller.
            let comm = unsafe { tercio_mpi::MpiComm::duplicate(*comm.cast()) }?;
            Ok(tercio_session::new(Ranks::Mpi(Session::new(comm))))
        }
        #[cfg(not(feature = "mpi"))]
        Err::<*mut tercio_session, Failed>("this library was built without MPI (feature \"mpi\")".into())
    };
    attempt(open).unwrap_or(ptr::null_mut())
}

/// Ends a session, and frees it. Collective. Before `MPI_Finalize`. Nothing is done with NULL.
///
/// # Safety
/// The session is NULL, or was opened and is not closed yet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_close(session: *mut tercio_session) -> c_int {
    status(|| {
        if session.is_null() {
            return Ok(());
        }
        // SAFETY: as required from the caller: it was made by `Box::into_raw`, and is not used any more.
        match unsafe { Box::from_raw(session) }.ranks {
            Ranks::Alone(_) => Ok(()),
            #[cfg(feature = "mpi")]
            Ranks::Mpi(session) => Ok(session.into_comm().close()?),
        }
    })
}

/// Seconds after which a process that waits for another one fails; 0 to wait for ever, which is the default.
///
/// # Safety
/// As for all functions: the session was opened and is not closed yet, and no other thread uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_set_timeout(session: *mut tercio_session, seconds: f64) -> c_int {
    let set = |session: &mut tercio_session| {
        let duration = std::time::Duration::try_from_secs_f64(seconds)?;
        match &mut session.ranks {
            Ranks::Alone(_) => {}
            #[cfg(feature = "mpi")]
            Ranks::Mpi(session) => {
                let timeout = (!duration.is_zero()).then_some(duration);
                let patience = tercio_mpi::Patience { timeout, ..tercio_mpi::Patience::default() };
                session.comm_mut().set_patience(patience);
            }
        }
        let _ = duration;
        Ok(())
    };
    // SAFETY: as required from the caller.
    unsafe { run(session, set) }
}

/// Adds a part that stays until it is removed, and stores its number, 0 for the first one. Collective; each process passes the triangles
/// that it has, which may be none. Surfaces of several processes are joined where they have vertices at the same position. All
/// processes that have vertices pass normals, or none does, and the same for colours.
///
/// # Safety
/// The arrays are as their documentation says; `part` may be NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_add(
    session: *mut tercio_session,
    arrays: *const tercio_arrays,
    part: *mut u32,
) -> c_int {
    let add = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        let id = with!(&mut session.ranks, s => unsafe { with_arrays(arrays, |arrays| s.add(arrays)) })?;
        // SAFETY: likewise.
        if let Some(part) = unsafe { part.as_mut() } {
            *part = id.number();
        }
        Ok(())
    };
    // SAFETY: likewise.
    unsafe { run(session, add) }
}

/// Replaces the arrays of a part; transform and surface stay. Collective.
///
/// # Safety
/// As [`tercio_add`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_update(
    session: *mut tercio_session,
    part: u32,
    arrays: *const tercio_arrays,
) -> c_int {
    let id = PartId::from_number(part);
    // SAFETY: as required from the caller.
    let update = |session: &mut tercio_session| with!(&mut session.ranks, s => unsafe { with_arrays(arrays, |arrays| s.update(id, arrays)) });
    // SAFETY: likewise.
    unsafe { run(session, update) }
}

/// Removes a part; its number is not used again.
///
/// # Safety
/// As [`tercio_set_timeout`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_remove(session: *mut tercio_session, part: u32) -> c_int {
    let id = PartId::from_number(part);
    // SAFETY: as required from the caller.
    unsafe { run(session, |session| Ok(with!(&mut session.ranks, s => s.remove(id))?)) }
}

/// Adds triangles for the next picture only. Collective.
///
/// # Safety
/// As [`tercio_add`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_show(session: *mut tercio_session, arrays: *const tercio_arrays) -> c_int {
    // SAFETY: as required from the caller.
    let show = |session: &mut tercio_session| with!(&mut session.ranks, s => unsafe { with_arrays(arrays, |arrays| s.show(arrays)) });
    // SAFETY: likewise.
    unsafe { run(session, show) }
}

/// Places a part: 16 numbers of an affine matrix in column-major order (as in OpenGL; the translation is numbers 12 to 14).
///
/// # Safety
/// `matrix` points to 16 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_set_transform(
    session: *mut tercio_session,
    part: u32,
    matrix: *const f64,
) -> c_int {
    let set = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        let columns = unsafe { values::<f64, 16>(matrix, "the matrix") }?;
        let matrix = DMat4::from_cols_array(&columns);
        if !matrix.is_finite() || matrix.row(3) != DMat4::IDENTITY.row(3) || matrix.determinant() == 0.0 {
            return Err("the matrix must be finite, with the last row 0 0 0 1, and invertible".into());
        }
        let id = PartId::from_number(part);
        *with!(&mut session.ranks, s => s.transform_mut(id))? = DAffine3::from_mat4(matrix);
        Ok(())
    };
    // SAFETY: likewise.
    unsafe { run(session, set) }
}

/// The colour (sRGB, 0 to 1) of a part that has no colours of its own, and its opacity, 0 to 1.
///
/// # Safety
/// `rgb` points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_set_surface(
    session: *mut tercio_session,
    part: u32,
    rgb: *const f64,
    opacity: f64,
) -> c_int {
    let set = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        let rgb = unit(unsafe { values::<f64, 3>(rgb, "the colour") }?)?;
        let [opacity] = unit([opacity])?;
        let id = PartId::from_number(part);
        let surface = with!(&mut session.ranks, s => s.surface_mut(id))?;
        surface.base_color = rgb.map(|c| srgb_to_linear(c) as f32);
        surface.opacity = opacity as f32;
        Ok(())
    };
    // SAFETY: likewise.
    unsafe { run(session, set) }
}

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
/// As [`tercio_set_timeout`].
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

/// How processes share a picture, which looks the same: "sort-last", the default, "sort-middle", "sort-first" or "sort-twice".
///
/// # Safety
/// `name` is a C string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_set_organisation(session: *mut tercio_session, name: *const c_char) -> c_int {
    let set = |session: &mut tercio_session| {
        // SAFETY: as required from the caller.
        let name = unsafe { text(name) }?;
        with!(&mut session.ranks, s => {
            let ranks = s.comm_mut().size();
            s.sharing_mut().organisation = match name {
                "sort-last" => Organisation::SortLast,
                "sort-middle" => Organisation::SortMiddle,
                "sort-first" => Organisation::SortFirst,
                "sort-twice" => Organisation::SortTwice { group: ranks.isqrt().max(1) },
                _ => return Err(format!("expected an organisation (sort-first, sort-middle, sort-last, sort-twice), found \"{name}\"").into()),
            };
        });
        Ok(())
    };
    // SAFETY: likewise.
    unsafe { run(session, set) }
}

/// Which axis points upwards for [`tercio_fit_camera`]: 'x', 'y', which is the default, or 'z'.
///
/// # Safety
/// As [`tercio_set_timeout`].
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
/// As [`tercio_set_timeout`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_fit_camera(
    session: *mut tercio_session,
    azimuth: f64,
    elevation: f64,
    zoom: f64,
) -> c_int {
    let fit = |session: &mut tercio_session| {
        if !azimuth.is_finite() || !elevation.is_finite() || !(zoom > 0.0 && zoom.is_finite()) {
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

/// Draws a picture of all parts, and of what is shown. Collective. Rank 0 of the communicator gets it.
///
/// # Safety
/// As [`tercio_set_timeout`].
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
        unsafe {
            pixels.as_mut().map(|pixels| *pixels = found.0);
            width.as_mut().map(|width| *width = found.1);
            height.as_mut().map(|height| *height = found.2);
        }
        Ok(())
    };
    // SAFETY: as required from the caller.
    unsafe { run(session, store) }
}

/// Writes the last picture, as PNG, PPM or WebP by its extension; a file is replaced only when the new one is complete. On other ranks
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

/// Seconds that this process has spent in collective functions of the session so far, waiting for other processes included; not
/// writing of files. Negative for NULL.
///
/// # Safety
/// As [`tercio_set_timeout`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tercio_seconds_spent(session: *const tercio_session) -> f64 {
    // SAFETY: as required from the caller.
    match unsafe { session.as_ref() } {
        Some(session) => with!(&session.ranks, s => s.spent()).as_secs_f64(),
        None => -1.0,
    }
}

/// Some values of a program.
///
/// # Safety
/// The pointer is null, or points to so many values.
unsafe fn values<T: Copy, const N: usize>(at: *const T, what: &str) -> Result<[T; N], Failed> {
    if at.is_null() {
        return Err(format!("{what} is NULL").into());
    }
    // SAFETY: as required from the caller.
    let values = unsafe { slice::from_raw_parts(at, N) };
    Ok(std::array::from_fn(|k| values[k]))
}

/// A string of a program.
///
/// # Safety
/// The pointer is null, or points to a C string, which lives long enough.
unsafe fn text<'a>(at: *const c_char) -> Result<&'a str, Failed> {
    if at.is_null() {
        return Err("a string is NULL".into());
    }
    // SAFETY: as required from the caller.
    let text = unsafe { CStr::from_ptr(at) };
    text.to_str().map_err(|_| format!("{text:?} is not UTF-8").into())
}

/// Numbers from 0 to 1.
fn unit<const N: usize>(values: [f64; N]) -> Result<[f64; N], Failed> {
    match values.iter().find(|value| !(0.0..=1.0).contains(*value)) {
        Some(value) => Err(format!("expected numbers from 0 to 1, found {value}").into()),
        None => Ok(values),
    }
}
