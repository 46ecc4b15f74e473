//! Progress of long work: a bar on a terminal, lines elsewhere.

use std::fmt::Write;
use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
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

/// Shows the progress until it is dropped; nothing if it would not be seen.
#[derive(Debug)]
pub struct Display {
    /// Updated by the work.
    pub progress: Arc<Progress>,
    /// Whether pictures are counted, and stages inside of them are not shown.
    counts_pictures: AtomicBool,
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
            _ if can_draw => Some(draw as fn(&Progress, &Receiver<()>)),
            ProgressMode::Always => Some(write_lines as fn(&Progress, &Receiver<()>)),
            ProgressMode::Auto => None,
        };
        let shower = show.and_then(|show| {
            let (stop, stopped) = mpsc::channel();
            let watched = Arc::clone(&progress);
            let work = move || {
                if waits(&stopped, SHOW_AFTER) {
                    show(&watched, &stopped);
                }
            };
            // If no thread can be started, there is no display, but the work goes on.
            Some((stop, thread::Builder::new().spawn(work).ok()?))
        });
        Self { progress, counts_pictures: AtomicBool::new(false), shower }
    }

    /// Names the current stage, for work whose amount is unknown.
    pub fn stage(&self, name: &'static str) {
        if !self.counts_pictures.load(Relaxed) {
            self.progress.begin(name, 0);
        }
    }

    /// From now on so many finished pictures are counted, and nothing else.
    pub fn pictures(&self, count: u64) {
        self.progress.begin(PICTURES, count);
        self.counts_pictures.store(true, Relaxed);
    }
}

/// Waits for a while; false if the work is done.
fn waits(stopped: &Receiver<()>, time: Duration) -> bool {
    stopped.recv_timeout(time) == Err(RecvTimeoutError::Timeout)
}

/// A bar that is redrawn in place.
fn draw(progress: &Progress, stopped: &Receiver<()>) {
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
fn write_lines(progress: &Progress, stopped: &Receiver<()>) {
    loop {
        messages::note(&line(progress.state()));
        if !waits(stopped, NEXT_LINE) {
            break;
        }
    }
}

fn line((stage, done, total): (&'static str, u64, u64)) -> String {
    match total {
        0 => format!("progress: {stage}"),
        _ if stage == PICTURES => format!("progress: {stage}, {done} of {total}"),
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
    use super::{line, rate};

    #[test]
    fn lines_show_the_share_that_is_done_if_it_is_known() {
        assert_eq!(line(("reading", 7, 0)), "progress: reading");
        assert_eq!(line(("parsing", 2, 3)), "progress: parsing, 66 %");
        assert_eq!(line(("parsing", u64::MAX, 3)), "progress: parsing, 100 %");
    }

    #[test]
    fn rates_have_two_digits() {
        assert_eq!(
            [100.4673, 9.96, 9.94, 1.0, 0.994, 0.25].map(rate),
            ["100/s", "10/s", "9.9/s", "1.0/s", "0.99/s", "0.25/s"]
        );
    }
}
