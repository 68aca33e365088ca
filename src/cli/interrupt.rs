//! Ctrl-C as a wish that a long work looks at between two steps.

use signal_hook::{
    consts::{SIGINT, SIGTERM},
    flag,
};
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// Exit status of a process that a second Ctrl-C ends on the spot, as shells have it: 128 and the signal's number.
const ENDED_BY_SIGINT: i32 = 130;

/// Set by the first Ctrl-C (or SIGTERM); the next one ends the process.
pub struct Interrupt {
    is_set: Arc<AtomicBool>,
}

impl Interrupt {
    /// From now on the signals only set the flag. Where that can't be arranged, they end the process as always.
    pub fn watched() -> Self {
        let is_set = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order: the flag that the first signal sets is seen by the second.
            let shutdown =
                flag::register_conditional_shutdown(signal, ENDED_BY_SIGINT, Arc::clone(&is_set));
            if shutdown.is_ok() {
                let _ = flag::register(signal, Arc::clone(&is_set));
            }
        }
        Self { is_set }
    }

    /// Has a signal come?
    pub fn is_set(&self) -> bool {
        self.is_set.load(Ordering::Relaxed)
    }
}

impl Drop for Interrupt {
    /// Nobody looks at the flag any more: the next signal ends the process.
    fn drop(&mut self) {
        self.is_set.store(true, Ordering::Relaxed);
    }
}
