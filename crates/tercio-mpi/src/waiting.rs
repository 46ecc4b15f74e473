//! Waiting for other processes without occupying a processor.

use std::time::{Duration, Instant};

/// How long to poll without sleeping: an answer in transit arrives in this time, and a sleep would delay it.
const AWAKE: Duration = Duration::from_micros(200);
/// The longest sleep. A wait this long does not affect the speed of a frame.
const LONGEST: Duration = Duration::from_millis(2);

/// Polls, with the time that it has waited, until there is an answer: without a pause at first, only yielding to threads that are ready to run, as there
/// are if there are more ranks than processors; then with sleeps of a sixteenth of the time waited so far, so that an
/// answer is noticed soon after it came, and a rank that waits for long takes little processor time.
pub fn until<T, E>(mut poll: impl FnMut(Duration) -> Result<Option<T>, E>) -> Result<T, E> {
    let (mut begin, mut waited) = (None, Duration::ZERO);
    loop {
        if let Some(answer) = poll(waited)? {
            return Ok(answer);
        }
        waited = begin.get_or_insert_with(Instant::now).elapsed();
        if waited < AWAKE {
            std::thread::yield_now();
        } else {
            std::thread::sleep((waited / 16).min(LONGEST));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_is_returned_and_so_is_an_error() {
        let mut polls = 0;
        let answer = until(|_| {
            polls += 1;
            Ok::<_, ()>((polls == 3).then_some("here"))
        });
        assert_eq!((answer, polls), (Ok("here"), 3));
        assert_eq!(until(|_| Err::<Option<()>, _>("gone")), Err("gone"));
    }

    #[test]
    fn a_long_wait_polls_rarely() {
        let (begin, mut polls) = (Instant::now(), 0u32);
        let long = Duration::from_millis(300);
        let result = until(|waited| {
            assert!(waited <= begin.elapsed());
            polls += u32::from(waited > long / 2);
            Ok::<_, ()>((waited > long).then_some(()))
        });
        assert_eq!(result, Ok(()));
        // Half of the time in sleeps of 2 ms and more.
        assert!(polls <= 76, "{polls} polls in {:?}", long / 2);
    }
}
