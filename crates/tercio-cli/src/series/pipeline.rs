//! Draws the next pictures while those before it are encoded, and writes them in order.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use anyhow::{Error, Result};
use rayon::Yield;

/// How long the drawing thread sleeps when nothing is to be done until a picture is encoded.
const PAUSE: Duration = Duration::from_micros(100);

/// What is done with pictures after they are drawn.
pub trait Stages<D, E>: Sync {
    /// The work of one picture: several threads do that for several pictures at a time.
    ///
    /// # Errors
    /// The first one ends the series.
    fn encode(&self, number: usize, drawn: D) -> Result<E>;

    /// Called with one picture after the other, in order.
    ///
    /// # Errors
    /// The first one ends the series.
    fn append(&self, number: usize, encoded: E) -> Result<()>;
}

struct State<E> {
    /// Pictures that are drawn and not appended.
    in_work: usize,
    encoded: BTreeMap<usize, E>,
    next: usize,
    is_appending: bool,
    failed: Option<Error>,
}

/// Draws pictures 0, 1, ... with `draw` on this thread until it returns `None`, and encodes them on the other threads of the pool
/// (and on this one, when it waits), at most `room` at a time.
///
/// # Errors
/// The first error.
pub fn run<D: Send, E: Send>(
    room: usize,
    stages: &impl Stages<D, E>,
    mut draw: impl FnMut(usize) -> Result<Option<D>>,
) -> Result<()> {
    let state = Mutex::new(State {
        in_work: 0,
        encoded: BTreeMap::new(),
        next: 0,
        is_appending: false,
        failed: None,
    });
    let drawn = rayon::in_place_scope(|scope| {
        let mut number = 0;
        while wait_for_room(&state, room) {
            let Some(drawn) = draw(number)? else { break };
            lock(&state).in_work += 1;
            let state = &state;
            scope.spawn(move |_| {
                let done = stages.encode(number, drawn).and_then(|e| append(state, stages, number, e));
                if let Err(error) = done {
                    lock(state).failed.get_or_insert(error);
                }
            });
            number += 1;
        }
        Ok(())
    });
    let failed = state.into_inner().unwrap_or_else(PoisonError::into_inner).failed;
    failed.map_or(drawn, Err)
}

fn lock<T>(state: &Mutex<T>) -> MutexGuard<'_, T> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Helps until there is room for one more picture; false if one has failed.
fn wait_for_room<E>(state: &Mutex<State<E>>, room: usize) -> bool {
    loop {
        {
            let state = lock(state);
            if state.failed.is_some() {
                return false;
            }
            if state.in_work < room.max(1) {
                return true;
            }
        }
        if !matches!(rayon::yield_now(), Some(Yield::Executed)) {
            thread::sleep(PAUSE);
        }
    }
}

/// Appends the picture, and those after it that were waiting for it.
fn append<D, E>(
    state: &Mutex<State<E>>,
    stages: &impl Stages<D, E>,
    number: usize,
    encoded: E,
) -> Result<()> {
    let mut own = lock(state);
    own.encoded.insert(number, encoded);
    if own.is_appending {
        // The thread that appends looks for it.
        return Ok(());
    }
    own.is_appending = true;
    while own.failed.is_none() {
        let next = own.next;
        let Some(encoded) = own.encoded.remove(&next) else { break };
        drop(own);
        let appended = stages.append(next, encoded);
        own = lock(state);
        if let Err(error) = appended {
            own.failed.get_or_insert(error);
        }
        own.next += 1;
        own.in_work -= 1;
    }
    own.is_appending = false;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

    use anyhow::bail;

    use super::*;

    /// Encodes slowly and out of order.
    struct Slow {
        in_work: AtomicUsize,
        most: AtomicUsize,
        written: Mutex<Vec<usize>>,
        bad: Option<usize>,
    }

    impl Stages<usize, usize> for Slow {
        fn encode(&self, number: usize, drawn: usize) -> Result<usize> {
            thread::sleep(Duration::from_millis(if number.is_multiple_of(3) { 6 } else { 1 }));
            if self.bad == Some(number) {
                bail!("picture {number} is bad");
            }
            Ok(drawn * 10)
        }

        fn append(&self, number: usize, encoded: usize) -> Result<()> {
            assert_eq!(encoded, number * 10);
            self.written.lock().unwrap().push(number);
            self.in_work.fetch_sub(1, SeqCst);
            Ok(())
        }
    }

    fn run_slow(threads: usize, room: usize, bad: Option<usize>) -> (Result<()>, Slow, usize) {
        let slow = Slow { in_work: 0.into(), most: 0.into(), written: Mutex::default(), bad };
        let drawn = AtomicUsize::new(0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let result = pool.install(|| {
            let draw = |number| {
                drawn.fetch_add(1, SeqCst);
                slow.most.fetch_max(slow.in_work.fetch_add(1, SeqCst) + 1, SeqCst);
                Ok((number < 40).then_some(number))
            };
            run(room, &slow, draw)
        });
        let drawn = drawn.into_inner();
        (result, slow, drawn)
    }

    #[test]
    fn pictures_are_appended_in_order_and_few_are_in_memory() {
        for (threads, room) in [(1, 1), (1, 4), (3, 2), (4, 9)] {
            let (result, slow, _) = run_slow(threads, room, None);
            result.unwrap();
            assert_eq!(slow.written.into_inner().unwrap(), (0..40).collect::<Vec<_>>());
            assert!(slow.most.into_inner() <= room + 1, "{threads} threads, room for {room}");
        }
    }

    #[test]
    fn the_first_error_ends_the_series() {
        let (result, slow, drawn) = run_slow(3, 2, Some(7));
        assert_eq!(result.unwrap_err().to_string(), "picture 7 is bad");
        assert!(drawn < 15, "{drawn}");
        assert!(slow.written.into_inner().unwrap().iter().all(|&n| n < 7));
    }
}
