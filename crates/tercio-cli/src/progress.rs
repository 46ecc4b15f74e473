//! A progress bar for work that takes its time.

use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tercio::mesh::Progress;

use crate::args::ProgressMode;

/// Work that ends sooner shows nothing.
const PATIENCE: Duration = Duration::from_millis(500);
const REDRAW: Duration = Duration::from_millis(100);

/// Shows how far the work is until it is dropped. Quiet where nobody looks.
#[derive(Debug)]
pub struct Display {
    /// For the work to write to.
    pub progress: Arc<Progress>,
    shower: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Display {
    /// Begins to watch.
    pub fn new(mode: ProgressMode) -> Self {
        let progress = Arc::new(Progress::default());
        crate::ending::watch(&progress);
        let shown = match mode {
            ProgressMode::Auto => io::stderr().is_terminal(),
            ProgressMode::Always => true,
            ProgressMode::Never => false,
        };
        let shower = shown.then_some(()).and_then(|()| {
            let (stop, stopped) = mpsc::channel();
            let watched = Arc::clone(&progress);
            let show = move || {
                let waits = |time| stopped.recv_timeout(time) == Err(RecvTimeoutError::Timeout);
                if !waits(PATIENCE) {
                    return;
                }
                let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
                loop {
                    draw(&bar, watched.state());
                    if !waits(REDRAW) {
                        break;
                    }
                }
                bar.finish_and_clear();
            };
            // Where there is no room for a thread, there is for the work.
            Some((stop, thread::Builder::new().spawn(show).ok()?))
        });
        Self { progress, shower }
    }

    /// Names what is being done now, for work that cannot say how far it is.
    pub fn stage(&self, name: &'static str) {
        self.progress.begin(name, 0);
    }
}

fn draw(bar: &ProgressBar, (stage, done, total): (&'static str, u64, u64)) {
    let template = if total > 0 { "{msg} {bar:40} {percent:>3}% {eta}" } else { "{msg} {spinner}" };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.set_message(stage);
    match total {
        0 => bar.unset_length(),
        _ => bar.set_length(total),
    }
    bar.set_position(done.min(total));
    bar.tick();
}

impl Drop for Display {
    fn drop(&mut self) {
        if let Some((stop, shower)) = self.shower.take() {
            drop(stop);
            // A bar that could not be drawn must not end the work.
            let _ = shower.join();
        }
    }
}
