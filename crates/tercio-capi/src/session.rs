//! Sessions.

use std::error::Error;
use std::ffi::{c_char, c_int, c_void};
use std::ptr;
use std::time::Duration;

use tercio::parallel::comm::threads::ThreadComm;
use tercio::parallel::{Communicator as _, Organisation};
use tercio::scene::UpAxis;
use tercio::{Camera, Framing, Session, Settings};

use crate::error::{attempt, status};
use crate::threads::start_default;
use crate::values::text;

/// Why a function failed.
pub type Failed = Box<dyn Error>;

/// What one process draws with, together with the other processes of its session. It is used by one thread at a time; with MPI, by the
/// thread that may call MPI.
#[derive(Debug)]
pub struct tercio_session {
    pub(crate) ranks: Ranks,
    pub(crate) settings: Settings,
    pub(crate) up_axis: UpAxis,
    /// Chosen by the program, or made for the first picture.
    pub(crate) camera: Option<Camera>,
}

/// The session of either kind of processes.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there are few sessions, and each is in a box")]
pub(crate) enum Ranks {
    Alone(Session<ThreadComm>),
    #[cfg(feature = "mpi")]
    Mpi(Session<tercio_mpi::MpiComm>),
}

/// Runs code with the session of either kind.
macro_rules! with {
    ($ranks:expr, $session:ident => $work:expr) => {
        match $ranks {
            $crate::session::Ranks::Alone($session) => $work,
            #[cfg(feature = "mpi")]
            $crate::session::Ranks::Mpi($session) => $work,
        }
    };
}
pub(crate) use with;

impl tercio_session {
    fn new(ranks: Ranks) -> *mut Self {
        let session =
            Self { ranks, settings: Settings::new(1024, 768), up_axis: UpAxis::default(), camera: None };
        Box::into_raw(Box::new(session))
    }

    pub(crate) fn framing(&self) -> Framing {
        Framing { up_axis: self.up_axis, ..self.settings.framing() }
    }
}

/// Runs work with a session that is not null.
///
/// # Safety
/// The session is null or was opened, and not closed yet, and nobody else uses it now.
pub(crate) unsafe fn run(
    session: *mut tercio_session,
    work: impl FnOnce(&mut tercio_session) -> Result<(), Failed>,
) -> c_int {
    // SAFETY: as required from the caller.
    status(|| match unsafe { session.as_mut() } {
        Some(session) => work(session),
        None => Err("the session is NULL".into()),
    })
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
/// of it, so that its messages and those of the program never meet; MPI is called by the thread that calls the functions of the
/// session, and by no other (`MPI_THREAD_FUNNELED`). NULL if it failed, also if the library was built without MPI.
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
        #[cfg(feature = "mpi")]
        {
            // First: what fails on one process only is then an error of the others, too.
            // SAFETY: as required from the caller.
            let comm = unsafe { tercio_mpi::MpiComm::duplicate(*comm.cast()) }?;
            start_default()?;
            Ok(tercio_session::new(Ranks::Mpi(Session::new(comm))))
        }
        #[cfg(not(feature = "mpi"))]
        Err::<*mut tercio_session, Failed>("this library was built without MPI (feature \"mpi\")".into())
    };
    attempt(open).unwrap_or(ptr::null_mut())
}

/// Ends a session, and frees it, also one of which a function failed. Collective: it waits for the other processes. Before
/// `MPI_Finalize`. Nothing is done with NULL.
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
        let wrong = |error| format!("expected seconds, 0 or more, found {seconds}: {error}");
        let duration = Duration::try_from_secs_f64(seconds).map_err(wrong)?;
        match &mut session.ranks {
            // Waits for nobody.
            Ranks::Alone(_) => _ = duration,
            #[cfg(feature = "mpi")]
            Ranks::Mpi(session) => {
                let timeout = (!duration.is_zero()).then_some(duration);
                let patience = tercio_mpi::Patience { timeout, ..tercio_mpi::Patience::default() };
                session.comm_mut().set_patience(patience);
            }
        }
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
                _ => {
                    let names = "sort-first, sort-middle, sort-last or sort-twice";
                    return Err(format!("expected {names}, found \"{name}\"").into());
                }
            };
        });
        Ok(())
    };
    // SAFETY: likewise.
    unsafe { run(session, set) }
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
