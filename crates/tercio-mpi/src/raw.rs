//! The calls of the MPI library that messages need, with their errors: `mpi` (rsmpi) has safe ones, but these drop
//! the library's error codes and cannot send memory that they take ownership of.

use std::ffi::{c_char, c_int, c_void};
use std::marker::PhantomData;
use std::mem::MaybeUninit;

use mpi::ffi;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{AsRaw as _, Communicator as _, FromRaw as _};

/// A communicator of this program alone: it gets no messages of other libraries, and its errors are returned.
pub struct Link {
    comm: SimpleCommunicator,
    /// MPI is initialized with [`mpi::Threading::Funneled`]: its calls stay on the thread that initialized it.
    on_this_thread: PhantomData<*const ()>,
}

/// What is known of a message before it is received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Envelope {
    /// The sender.
    pub from: usize,
    /// The tag.
    pub tag: i32,
}

/// The library's description of a failed call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failed(pub String);

fn check(call: &str, code: c_int) -> Result<(), Failed> {
    if code == ffi::MPI_SUCCESS as c_int {
        return Ok(());
    }
    let mut text = [0u8; ffi::MPI_MAX_ERROR_STRING as usize];
    let mut length: c_int = 0;
    // SAFETY: the text has room for the longest string that the library writes, and both destinations are ours.
    let status = unsafe { ffi::MPI_Error_string(code, text.as_mut_ptr().cast::<c_char>(), &mut length) };
    let length = if status == ffi::MPI_SUCCESS as c_int { usize::try_from(length).unwrap_or(0) } else { 0 };
    let text = String::from_utf8_lossy(&text[..length.min(text.len())]);
    Err(Failed(format!("{call}: {} (code {code})", text.trim_end_matches('\0'))))
}

impl Link {
    /// A duplicate of a communicator; all its ranks have to make one.
    pub fn new(of: &SimpleCommunicator) -> Result<Self, Failed> {
        Self::own(of.duplicate())
    }

    /// The same of a communicator of the program that this library is part of.
    ///
    /// # Safety
    /// The handle is that of a live communicator of processes, and this thread may call MPI.
    pub unsafe fn of_handle(of: ffi::MPI_Comm) -> Result<Self, Failed> {
        // SAFETY: the handle is a constant of the library.
        let mut comm = unsafe { ffi::RSMPI_COMM_NULL };
        // SAFETY: the caller guarantees the handle, and the destination is ours.
        check("MPI_Comm_dup", unsafe { ffi::MPI_Comm_dup(of, &mut comm) })?;
        // SAFETY: the communicator was just made, and nobody else has its handle.
        Self::own(unsafe { SimpleCommunicator::from_raw(comm) })
    }

    /// A communicator that nobody else uses.
    fn own(comm: SimpleCommunicator) -> Result<Self, Failed> {
        // SAFETY: the communicator was just made, and the handler is one of the library's own.
        let code = unsafe { ffi::MPI_Comm_set_errhandler(comm.as_raw(), ffi::RSMPI_ERRORS_RETURN) };
        check("MPI_Comm_set_errhandler", code)?;
        Ok(Self { comm, on_this_thread: PhantomData })
    }

    /// This rank's number.
    pub fn rank(&self) -> usize {
        usize::try_from(self.comm.rank()).unwrap_or(0)
    }

    /// Number of ranks.
    pub fn size(&self) -> usize {
        usize::try_from(self.comm.size()).unwrap_or(1)
    }

    /// Ends all processes of the job with an exit code.
    pub fn abort(&self, code: i32) -> ! {
        self.comm.abort(code)
    }

    /// Begins to send a message in parts of at most `part` bytes, the last one with the tag `last`, those before it
    /// with the tag `before`. An empty message is one empty part.
    pub fn send(
        &self,
        to: usize,
        (before, last): (i32, i32),
        bytes: Vec<u8>,
        part: usize,
    ) -> Result<Outgoing, Failed> {
        let to_rank = c_int::try_from(to).map_err(|e| Failed(e.to_string()))?;
        let part = part.clamp(1, c_int::MAX as usize);
        let parts = bytes.len().div_ceil(part).max(1);
        let mut outgoing = Outgoing { requests: Vec::with_capacity(parts), bytes, to };
        for number in 0..parts {
            let first = number * part;
            let count = part.min(outgoing.bytes.len() - first);
            let tag = if number + 1 == parts { last } else { before };
            // SAFETY: the handle is a constant of the library.
            let mut request = unsafe { ffi::RSMPI_REQUEST_NULL };
            // SAFETY: the `count` bytes from `first` on are inside the message, whose memory does not move with its
            // `Vec`, is not written to, and is kept by `Outgoing` until the library is done with it. `count` fits a C
            // int.
            let code = unsafe {
                ffi::MPI_Isend(
                    outgoing.bytes.as_ptr().add(first).cast::<c_void>(),
                    count as c_int,
                    ffi::RSMPI_UINT8_T,
                    to_rank,
                    tag,
                    self.comm.as_raw(),
                    &mut request,
                )
            };
            check("MPI_Isend", code)?;
            outgoing.requests.push(request);
        }
        Ok(outgoing)
    }

    /// Receives the next message of a rank, or of any, if one has arrived: its bytes are appended to the `Vec` that
    /// `place` returns for its envelope and length.
    pub fn take<'a>(
        &self,
        from: Option<usize>,
        place: impl FnOnce(Envelope, usize) -> &'a mut Vec<u8>,
    ) -> Result<Option<Envelope>, Failed> {
        let Some((envelope, count, mut message)) = self.probe(from)? else { return Ok(None) };
        let bytes = place(envelope, count);
        bytes.reserve_exact(count);
        // SAFETY: there is room for `count` bytes, which is what the matched message holds; the message is received
        // once.
        let code = unsafe {
            ffi::MPI_Mrecv(
                bytes.spare_capacity_mut().as_mut_ptr().cast::<c_void>(),
                count as c_int,
                ffi::RSMPI_UINT8_T,
                &mut message,
                ffi::RSMPI_STATUS_IGNORE,
            )
        };
        check("MPI_Mrecv", code)?;
        // SAFETY: the library wrote `count` bytes after those that were there.
        unsafe { bytes.set_len(bytes.len() + count) };
        Ok(Some(envelope))
    }

    /// Matches the next message, if one has arrived: no other call can receive it then.
    fn probe(&self, from: Option<usize>) -> Result<Option<(Envelope, usize, ffi::MPI_Message)>, Failed> {
        // SAFETY: the handles are constants of the library.
        let (any_rank, any_tag, mut message) =
            unsafe { (ffi::RSMPI_ANY_SOURCE, ffi::RSMPI_ANY_TAG, ffi::RSMPI_MESSAGE_NULL) };
        let from = match from {
            Some(from) => c_int::try_from(from).map_err(|e| Failed(e.to_string()))?,
            None => any_rank,
        };
        let (mut found, mut count): (c_int, c_int) = (0, 0);
        let mut status = MaybeUninit::<ffi::MPI_Status>::zeroed();
        // SAFETY: all destinations that are written to are ours and live as long as the call.
        let code = unsafe {
            ffi::MPI_Improbe(from, any_tag, self.comm.as_raw(), &mut found, &mut message, status.as_mut_ptr())
        };
        check("MPI_Improbe", code)?;
        if found == 0 {
            return Ok(None);
        }
        // SAFETY: a status consists of integers, for which zeros are valid; the library has filled it in.
        let status = unsafe { status.assume_init() };
        // SAFETY: as above.
        let code = unsafe { ffi::MPI_Get_count(&status, ffi::RSMPI_UINT8_T, &mut count) };
        check("MPI_Get_count", code)?;
        let wrong = |_| Failed(format!("a message of {count} bytes from rank {}", status.MPI_SOURCE));
        let from = usize::try_from(status.MPI_SOURCE).map_err(wrong)?;
        Ok(Some((Envelope { from, tag: status.MPI_TAG }, usize::try_from(count).map_err(wrong)?, message)))
    }
}

/// A message in transit: its bytes belong to the library until it is done.
pub struct Outgoing {
    requests: Vec<ffi::MPI_Request>,
    bytes: Vec<u8>,
    /// The receiver.
    pub to: usize,
}

impl Outgoing {
    /// Whether the library no longer needs the bytes; also lets it make progress with the transfer.
    pub fn is_done(&mut self) -> Result<bool, Failed> {
        let mut done: c_int = 0;
        // SAFETY: the requests are those that the library gave us and keeps up to date, and their number is right.
        let code = unsafe {
            ffi::MPI_Testall(
                c_int::try_from(self.requests.len()).map_err(|e| Failed(e.to_string()))?,
                self.requests.as_mut_ptr(),
                &mut done,
                ffi::RSMPI_STATUSES_IGNORE,
            )
        };
        check("MPI_Testall", code)?;
        if done != 0 {
            self.requests.clear();
        }
        Ok(done != 0)
    }

    /// The memory of the message, once the library is done with it.
    pub fn into_bytes(mut self) -> Vec<u8> {
        if self.requests.is_empty() { std::mem::take(&mut self.bytes) } else { Vec::new() }
    }
}

impl Drop for Outgoing {
    fn drop(&mut self) {
        // The library may still read bytes that it is not done with: leak the memory rather than reuse it.
        if !self.requests.is_empty() {
            std::mem::forget(std::mem::take(&mut self.bytes));
        }
    }
}
