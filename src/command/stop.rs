//! What ends a run early: Ctrl-C, SIGTERM, the clock.

use super::Failure;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Listens for signals, and looks at the clock.
pub struct Stop {
    signal: Arc<AtomicUsize>,
    deadline: Option<Instant>,
}

impl Stop {
    /// From now on the first Ctrl-C or SIGTERM is noted here; the second ends the process at once.
    pub fn listen(max_time: Option<Duration>) -> Result<Stop, Failure> {
        use signal_hook::{consts, flag};
        let (signal, armed) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        for number in [consts::SIGINT, consts::SIGTERM] {
            // In this order: the first signal finds `armed` false and sets it.
            flag::register_conditional_shutdown(number, 128 + number, armed.clone())
                .and_then(|_| flag::register(number, armed.clone()))
                .and_then(|_| flag::register_usize(number, signal.clone(), number as usize))
                .map_err(|e| Failure::Internal(format!("signals: {e}")))?;
        }
        Ok(Stop { signal, deadline: max_time.and_then(|t| Instant::now().checked_add(t)) })
    }

    /// Number of the signal that came, if any.
    pub fn signal(&self) -> Option<u8> {
        u8::try_from(self.signal.load(Ordering::Relaxed)).ok().filter(|&s| s != 0)
    }

    /// A signal came, or the time is over.
    pub fn asked(&self) -> bool {
        self.signal().is_some() || self.deadline.is_some_and(|d| Instant::now() >= d)
    }
}
