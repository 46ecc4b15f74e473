//! Waiting for other processes without taking a processor from them.

use std::time::{Duration, Instant};

/// Time in which an answer that is on its way arrives; to sleep would make it late.
const AWAKE: Duration = Duration::from_micros(200);
/// The longest sleep. Who waits this long has nothing to do with the speed of a frame.
const LONGEST: Duration = Duration::from_millis(2);

/// Asks until there is an answer: without a pause at first, unless another thread is ready to have the processor, as
/// where there are more ranks than processors; then with sleeps of a sixteenth of the time waited so far,
/// so that no answer is found much later than it came, and a rank that waits for long takes little of its processor.
pub fn until<T, E>(mut ask: impl FnMut() -> Result<Option<T>, E>) -> Result<T, E> {
    let mut begin = None;
    loop {
        if let Some(answer) = ask()? {
            return Ok(answer);
        }
        let waited = begin.get_or_insert_with(Instant::now).elapsed();
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
        let mut asked = 0;
        let answer = until(|| {
            asked += 1;
            Ok::<_, ()>((asked == 3).then_some("here"))
        });
        assert_eq!((answer, asked), (Ok("here"), 3));
        assert_eq!(until(|| Err::<Option<()>, _>("gone")), Err("gone"));
    }

    #[test]
    fn who_waits_for_long_asks_seldom() {
        let (begin, mut asked) = (Instant::now(), 0u32);
        let long = Duration::from_millis(300);
        let asked_later = until(|| {
            asked += u32::from(begin.elapsed() > long / 2);
            Ok::<_, ()>((begin.elapsed() > long).then_some(()))
        });
        assert_eq!(asked_later, Ok(()));
        // Half of the time in sleeps of 2 ms and more.
        assert!(asked <= 76, "asked {asked} times in {:?}", long / 2);
    }
}
