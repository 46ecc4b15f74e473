//! Progress of long work: a bar on a terminal, lines elsewhere.

use std::fmt::Write;
use std::io::{self, IsTerminal};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use tercio::mesh::Progress;

use crate::args::ProgressMode;
use crate::messages;

/// Shorter work shows nothing.
const SHOW_AFTER: Duration = Duration::from_millis(500);
const REDRAW: Duration = Duration::from_millis(100);
/// Time between lines.
const NEXT_LINE: Duration = Duration::from_secs(1);

/// The stage of a series of pictures.
const PICTURES: &str = "pictures";

/// Shows progress until the work is done; knows since when pictures are counted.
type Show = fn(&Progress, &OnceLock<Instant>, &Receiver<()>);

/// Shows the progress until it is dropped; nothing if it would not be seen.
#[derive(Debug)]
pub struct Display {
    /// Updated by the work.
    pub progress: Arc<Progress>,
    /// Since when pictures are counted, and stages inside of them are not shown.
    pictures_since: Arc<OnceLock<Instant>>,
    shower: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Display {
    /// Starts the display.
    pub fn new(mode: ProgressMode) -> Self {
        let progress = Arc::new(Progress::default());
        crate::ending::watch(&progress);
        // A terminal without control characters cannot redraw a bar.
        let is_dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        let can_draw = io::stderr().is_terminal() && !is_dumb;
        let show = match mode {
            ProgressMode::Never => None,
            _ if can_draw => Some(draw as Show),
            ProgressMode::Always => Some(write_lines as Show),
            ProgressMode::Auto => None,
        };
        let pictures_since = Arc::new(OnceLock::new());
        let shower = show.and_then(|show| {
            let (stop, stopped) = mpsc::channel();
            let (watched, since) = (Arc::clone(&progress), Arc::clone(&pictures_since));
            let work = move || {
                if waits(&stopped, SHOW_AFTER) {
                    show(&watched, &since, &stopped);
                }
            };
            // If no thread can be started, there is no display, but the work goes on.
            Some((stop, thread::Builder::new().spawn(work).ok()?))
        });
        Self { progress, pictures_since, shower }
    }

    /// Names the current stage, for work whose amount is unknown.
    pub fn stage(&self, name: &'static str) {
        if self.pictures_since.get().is_none() {
            self.progress.begin(name, 0);
        }
    }

    /// From now on so many finished pictures are counted, and nothing else.
    pub fn pictures(&self, count: u64) {
        self.pictures_since.get_or_init(Instant::now);
        self.progress.begin(PICTURES, count);
    }
}

/// Waits for a while; false if the work is done.
fn waits(stopped: &Receiver<()>, time: Duration) -> bool {
    stopped.recv_timeout(time) == Err(RecvTimeoutError::Timeout)
}

/// A bar that is redrawn in place.
fn draw(progress: &Progress, _: &OnceLock<Instant>, stopped: &Receiver<()>) {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    loop {
        draw_once(&bar, progress.state());
        if !waits(stopped, REDRAW) {
            break;
        }
    }
    bar.finish_and_clear();
}

/// Pictures a second, with two digits that count.
fn rate(per_second: f64) -> String {
    let decimals = if per_second >= 9.95 { 0 } else { 1 + usize::from(per_second < 0.995) };
    format!("{per_second:.decimals$}/s")
}

fn draw_once(bar: &ProgressBar, (stage, done, total): (&'static str, u64, u64)) {
    let template = match total {
        0 => "{msg} {spinner}",
        // There is no rate before the first one.
        _ if stage == PICTURES && done == 0 => "{msg} {bar:40} {pos}/{len}",
        _ if stage == PICTURES => "{msg} {bar:40} {pos}/{len}, {rate}, {eta} left",
        _ => "{msg} {bar:40} {percent:>3}% {eta}",
    };
    // Before the style and the message, which draw what they find.
    match total {
        0 => bar.unset_length(),
        _ => bar.set_length(total),
    }
    bar.set_position(done.min(total));
    if let Ok(style) = ProgressStyle::with_template(template) {
        let written = |state: &ProgressState, to: &mut dyn Write| {
            // Nothing can be done where the terminal does not take it.
            let _ = to.write_str(&rate(state.per_sec()));
        };
        bar.set_style(style.with_key("rate", written));
    }
    bar.set_message(stage);
    bar.tick();
}

/// One line a second, for files and pipes.
fn write_lines(progress: &Progress, pictures_since: &OnceLock<Instant>, stopped: &Receiver<()>) {
    loop {
        let time = pictures_since.get().map(Instant::elapsed).unwrap_or_default();
        messages::note(&line(progress.state(), time));
        if !waits(stopped, NEXT_LINE) {
            break;
        }
    }
}

/// One line; `time` is that since pictures are counted.
fn line((stage, done, total): (&'static str, u64, u64), time: Duration) -> String {
    match total {
        0 => format!("progress: {stage}"),
        // There is no rate before the first one.
        _ if stage == PICTURES && (done == 0 || time.is_zero()) => {
            format!("progress: {stage}, {done} of {total}")
        }
        _ if stage == PICTURES => {
            let each = time.as_secs_f64() / done as f64;
            let left = Duration::try_from_secs_f64(each * total.saturating_sub(done) as f64);
            let (rate, left) = (rate(1.0 / each), HumanDuration(left.unwrap_or(Duration::MAX)));
            format!("progress: {stage}, {done} of {total}, {rate}, {left:#} left")
        }
        _ => format!("progress: {stage}, {} %", u128::from(done.min(total)) * 100 / u128::from(total)),
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        if let Some((stop, shower)) = self.shower.take() {
            drop(stop);
            // A bar that could not be drawn must not fail the work.
            let _ = shower.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::{PICTURES, line, rate};

    #[test]
    fn lines_show_the_share_that_is_done_if_it_is_known() {
        let line = |state| line(state, Duration::ZERO);
        assert_eq!(line(("reading", 7, 0)), "progress: reading");
        assert_eq!(line(("parsing", 2, 3)), "progress: parsing, 66 %");
        assert_eq!(line(("parsing", u64::MAX, 3)), "progress: parsing, 100 %");
    }

    #[test]
    fn lines_of_pictures_have_their_rate_and_the_time_that_is_left() {
        let time = Duration::from_secs(8);
        assert_eq!(line((PICTURES, 0, 60), time), "progress: pictures, 0 of 60");
        assert_eq!(line((PICTURES, 40, 60), time), "progress: pictures, 40 of 60, 5.0/s, 4s left");
        assert_eq!(line((PICTURES, 1, 46), time), "progress: pictures, 1 of 46, 0.12/s, 6m left");
        assert_eq!(line((PICTURES, 60, 60), time), "progress: pictures, 60 of 60, 7.5/s, 0s left");
    }

    #[test]
    fn rates_have_two_digits() {
        assert_eq!(
            [100.4673, 9.96, 9.94, 1.0, 0.994, 0.25].map(rate),
            ["100/s", "10/s", "9.9/s", "1.0/s", "0.99/s", "0.25/s"]
        );
    }
}
