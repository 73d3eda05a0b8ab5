//! Progress of a solve on the terminal, and what ends it early: Ctrl-C, or a request to terminate.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use sheen_solver::{Observer, Progress};
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Resolution of the bar.
const STEPS: u64 = 1000;
/// Without a terminal, a line at most this often.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// Exit status after a request that ends the process: 128 + SIGINT.
const INTERRUPTED: i32 = 130;

static INTERRUPTS: AtomicU32 = AtomicU32::new(0);

/// Observers that will end what they watch.
static WATCHERS: AtomicU32 = AtomicU32::new(0);

/// From now on the first Ctrl-C or request to terminate (SIGTERM, SIGHUP) ends a solve early and keeps what it has; the
/// second, or the first where nothing is watched, such as in a window, ends the process.
pub(super) fn catch_interrupts() {
    // A handler that cannot be set leaves signals as they were: they end the process.
    let _ = ctrlc::set_handler(|| {
        let is_first = INTERRUPTS.fetch_add(1, Ordering::Relaxed) == 0;
        if !is_first || WATCHERS.load(Ordering::Relaxed) == 0 {
            std::process::exit(INTERRUPTED);
        }
    });
}

/// True after such a request.
pub(super) fn is_interrupted() -> bool {
    INTERRUPTS.load(Ordering::Relaxed) > 0
}

/// Shows a bar, or a line now and then where stderr is no terminal.
pub(super) struct TerminalObserver {
    bar: Option<ProgressBar>,
    started: Instant,
    /// When what is reported began: a program that solves several times starts again.
    began: Instant,
    done: f32,
    last_line: Instant,
    phase: &'static str,
    /// It ends what it watches.
    is_watching: bool,
}

impl TerminalObserver {
    /// Ends what it watches after a request.
    pub(super) fn new() -> Self {
        WATCHERS.fetch_add(1, Ordering::Relaxed);
        let mut watching = Self::showing();
        watching.is_watching = true;
        watching
    }

    /// Shows progress and ends nothing: a picture that is half done is of no use, and a request ends the process.
    pub(super) fn showing() -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar =
                ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr_with_hz(10));
            if let Ok(style) =
                ProgressStyle::with_template("{msg:14} [{bar:40}] {percent:>3} %  {prefix}")
            {
                bar.set_style(style.progress_chars("=> "));
            }
            bar
        });
        Self {
            bar,
            started: Instant::now(),
            began: Instant::now(),
            done: 0.0,
            last_line: Instant::now(),
            phase: "",
            is_watching: false,
        }
    }

    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    /// Elapsed and estimated time, from the part done.
    fn clock(&self, done: f32) -> String {
        let elapsed = self.started.elapsed().as_secs_f64();
        let done = f64::from(done.clamp(0.0, 1.0));
        let spent = self.began.elapsed().as_secs_f64();
        // An estimate from the first per cent would only mislead.
        if done > 0.01 {
            format!("{elapsed:.0} s, {:.0} s left", spent / done - spent)
        } else {
            format!("{elapsed:.0} s")
        }
    }
}

impl Drop for TerminalObserver {
    fn drop(&mut self) {
        if self.is_watching {
            WATCHERS.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

impl Observer for TerminalObserver {
    fn report(&mut self, progress: &Progress) -> ControlFlow<()> {
        if progress.done < self.done {
            self.began = Instant::now();
        }
        self.done = progress.done;
        if let Some(bar) = &self.bar {
            bar.set_message(progress.phase);
            bar.set_prefix(self.clock(progress.done));
            bar.set_position((f64::from(progress.done.clamp(0.0, 1.0)) * STEPS as f64) as u64);
        } else if self.last_line.elapsed() >= LINE_INTERVAL {
            let percent = progress.done.clamp(0.0, 1.0) * 100.0;
            super::note(&format!(
                "{}: {percent:.0} %, {}",
                progress.phase,
                self.clock(progress.done)
            ));
            self.last_line = Instant::now();
        }
        self.phase = progress.phase;
        if self.is_watching && is_interrupted() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}
