//! What pictures are held against: path tracing.

use super::run::Case;
use crate::ways::path::{Budget, trace};
use sheen_formats::image::Image;
use sheen_solver::{Observer, PathTracer};

/// Traces what the camera of `case` shows.
pub(super) fn traced(case: &Case, samples: u32, observer: &mut dyn Observer) -> Image {
    let budget = Budget {
        samples,
        time_limit: None,
    };
    trace(
        &PathTracer::new(&case.scene),
        &case.view,
        budget,
        0,
        observer,
    )
    .image
}
