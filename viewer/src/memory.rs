//! What the program has allocated: every allocation is counted, so that tables can say what a solve took at most.

use peakmem_alloc::{INSTRUMENTED_SYSTEM, PeakMemAlloc, PeakMemAllocTrait};
use std::alloc::System;

#[global_allocator]
static GLOBAL: &PeakMemAlloc<System> = &INSTRUMENTED_SYSTEM;

/// The largest number of bytes that were allocated at once during `work`, beyond those that were before. Other threads
/// count too.
pub fn peak_during<T>(work: impl FnOnce() -> T) -> (T, u64) {
    GLOBAL.reset_peak_memory();
    let done = work();
    (done, GLOBAL.get_peak_memory() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_freed_again_counts() {
        let (held, peak) = peak_during(|| {
            drop(std::hint::black_box(vec![0u8; 3 << 20]));
            std::hint::black_box(vec![0u8; 1 << 20])
        });
        // Other tests run beside this one.
        assert!((3 << 20..1 << 30).contains(&peak), "{peak}");
        assert_eq!(held.len(), 1 << 20);
    }
}
