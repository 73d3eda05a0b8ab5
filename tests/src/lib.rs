//! Builders, tolerances and image differences that the integration tests share.
#![allow(
    clippy::print_stdout,
    reason = "figures of tests are read from their output"
)]

pub mod images;
pub mod measure;
pub mod program;
pub mod scenes;
pub mod shared;

use sheen_solver::{Observer, Progress};
use std::fmt::Display;
use std::ops::ControlFlow;

/// Stops a solve at a report of a phase: how many come before it, and the phase.
pub struct UntilReport(pub u32, pub &'static str);

impl UntilReport {
    /// When light transport is done: nothing is gathered at vertices.
    pub fn transport_is_done() -> Self {
        Self(0, "light at vertices")
    }
}

impl Observer for UntilReport {
    fn report(&mut self, progress: &Progress) -> ControlFlow<()> {
        if progress.phase != self.1 {
            return ControlFlow::Continue(());
        }
        if self.0 == 0 {
            return ControlFlow::Break(());
        }
        self.0 -= 1;
        ControlFlow::Continue(())
    }
}

/// Panics unless `found` is within `relative` of `expected`; the message holds both and the error.
///
/// Why a tolerance has its value stands with the caller.
#[track_caller]
pub fn assert_close(what: impl Display, found: f64, expected: f64, relative: f64) {
    let error = found / expected - 1.0;
    println!(
        "{what}: {found:.6}, expected {expected:.6}, error {:+.4} %",
        error * 100.0
    );
    assert!(
        error.abs() <= relative,
        "{what}: {found}, expected {expected} within {} %, error {:+.4} %",
        relative * 100.0,
        error * 100.0
    );
}
