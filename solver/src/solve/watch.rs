//! What a solve reports while it works, and who may stop it: an observer, a time limit, a memory limit.

use std::ops::ControlFlow;
use std::time::Instant;

/// How far a solve has come.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// What is being done now.
    pub phase: &'static str,
    /// Estimated part of the whole that is done, 0..=1, never falling.
    pub done: f32,
}

/// Is told of the progress of a solve after each bounded piece of work, and may stop it.
pub trait Observer: Send {
    /// `Break` stops the solve with what it has.
    fn report(&mut self, progress: &Progress) -> ControlFlow<()>;
}

impl Observer for () {
    fn report(&mut self, _: &Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Joins the caller's observer and the limits; remembers that one of them said stop.
pub(crate) struct Watch<'a> {
    observer: &'a mut dyn Observer,
    started: Instant,
    time_limit_s: Option<f64>,
    memory_limit: Option<u64>,
    /// Bytes held when they were more than the limit.
    exceeded: Option<u64>,
    stopped: bool,
    done: f32,
}

impl<'a> Watch<'a> {
    pub(crate) fn new(
        observer: &'a mut dyn Observer,
        time_limit_s: Option<f64>,
        memory_limit: Option<u64>,
    ) -> Self {
        Self {
            observer,
            started: Instant::now(),
            time_limit_s,
            memory_limit,
            exceeded: None,
            stopped: false,
            done: 0.0,
        }
    }

    /// Reports; `held`: bytes that the work holds now. `Break` once stopped, and ever after.
    pub(crate) fn report(
        &mut self,
        phase: &'static str,
        done: f32,
        held: usize,
    ) -> ControlFlow<()> {
        self.done = self.done.max(done.clamp(0.0, 1.0));
        let late = self
            .time_limit_s
            .is_some_and(|limit| self.seconds() > limit);
        let stop = self
            .observer
            .report(&Progress {
                phase,
                done: self.done,
            })
            .is_break();
        let held = held as u64;
        if self.memory_limit.is_some_and(|limit| held > limit) {
            self.exceeded = Some(held);
        }
        self.stopped |= late || stop || self.exceeded.is_some();
        if self.stopped {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    /// True when the rest is to be kept short.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Bytes that were held when that was too much, once: work that needs less may start after that.
    pub(super) fn take_exceeded(&mut self) -> Option<u64> {
        let exceeded = self.exceeded.take()?;
        self.stopped = false;
        Some(exceeded)
    }

    /// Time since the start [s].
    pub(super) fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}
