//! Batches on all threads, added up in a fixed order.
//!
//! Batch after batch goes round the wavelength groups, and sums are taken over whole rounds only: at
//! any moment every group has the same number of histories, the first ones of the run.

use super::batch::Batches;
use super::sums::Sums;
use crate::stats::Fold;
use std::collections::BTreeMap;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A worker panicked: the program's fault, never the input's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Wavelength group.
    pub group: u64,
    /// Batch.
    pub batch: u64,
    /// History under way.
    pub history: u64,
    /// What the panic said.
    pub message: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "history {} (wavelength group {}, batch {}) panicked: {}",
            self.history, self.group, self.batch, self.message
        )
    }
}

/// Hears of the run, and may stop it.
pub struct Watch<'a> {
    /// Asked before each batch, on every thread: true stops once the batches under way are finished.
    pub stop: &'a (dyn Fn() -> bool + Sync),
    /// Called after each round with the sums so far; false stops here.
    pub round: &'a mut (dyn FnMut(&[Fold<Sums>]) -> bool + Send),
}

struct Shared<'a, 'b> {
    /// Finished batches that wait for the rest of their round, by place in the order of the run.
    waiting: BTreeMap<u64, Sums>,
    state: &'a mut [Fold<Sums>],
    round: &'a mut (dyn FnMut(&[Fold<Sums>]) -> bool + Send + 'b),
    taken: u64,
    fault: Option<Fault>,
}

fn lock<'a, T>(shared: &'a Mutex<T>) -> MutexGuard<'a, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs every group from the batch that its fold expects next up to `end` (exclusive) on the threads of
/// rayon's present pool. All groups must expect the same batch.
///
/// # Errors
/// The first panic of a worker; the sums of the rounds before it stay in `state`.
pub fn work(
    groups: &[&dyn Batches],
    state: &mut [Fold<Sums>],
    end: u64,
    watch: Watch<'_>,
) -> Result<(), Fault> {
    let count = groups.len() as u64;
    let Some(start) = state.first().map(Fold::next) else { return Ok(()) };
    let total = end.saturating_sub(start) * count;
    let (next, halt) = (AtomicU64::new(0), AtomicBool::new(false));
    let Watch { stop, round } = watch;
    let shared = Mutex::new(Shared { waiting: BTreeMap::new(), state, round, taken: 0, fault: None });
    let worker = || {
        while !halt.load(Ordering::Relaxed) && !stop() {
            let place = next.fetch_add(1, Ordering::Relaxed);
            if place >= total {
                break;
            }
            let (group, batch) = (place % count, start + place / count);
            let now = AtomicU64::new(0);
            match catch_unwind(AssertUnwindSafe(|| groups[group as usize].batch(batch, &now))) {
                Ok(sums) => finished(&mut lock(&shared), place, sums, count, &halt),
                Err(payload) => {
                    halt.store(true, Ordering::Relaxed);
                    let message = said(payload.as_ref());
                    let fault = Fault { group, batch, history: now.into_inner(), message };
                    let known = &mut lock(&shared).fault;
                    // Several at once: the first in the order of the run.
                    let place_of = |f: &Fault| (f.batch, f.group);
                    if known.as_ref().is_none_or(|k| place_of(&fault) < place_of(k)) {
                        *known = Some(fault);
                    }
                }
            }
        }
    };
    // A single batch needs no other thread: waiting for one inside work that is spread itself would pile
    // pieces of that on the stack.
    if total > 1 {
        rayon::broadcast(|_| worker());
    } else {
        worker();
    }
    let fault = lock(&shared).fault.take();
    fault.map_or(Ok(()), Err)
}

/// Takes a finished batch, and the rounds that it completes; where the last look says so, `halt` is set, here,
/// while the other threads wait. After that nothing more is taken: where a run ends must not depend on its threads.
fn finished(shared: &mut Shared<'_, '_>, place: u64, sums: Sums, count: u64, halt: &AtomicBool) {
    shared.waiting.insert(place, sums);
    while !halt.load(Ordering::Relaxed) {
        let places = shared.taken..shared.taken + count;
        if !places.clone().all(|p| shared.waiting.contains_key(&p)) {
            return;
        }
        for (fold, p) in shared.state.iter_mut().zip(places) {
            if let Some(sums) = shared.waiting.remove(&p) {
                fold.push(sums);
            }
        }
        shared.taken += count;
        if !(shared.round)(shared.state) {
            halt.store(true, Ordering::Relaxed);
        }
    }
}

/// Text of a panic.
fn said(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tally::Node;

    /// Sums that tell their batches apart.
    struct Plain {
        panics: Option<u64>,
    }
    impl Batches for Plain {
        fn batch(&self, index: u64, now: &AtomicU64) -> Sums {
            now.store(index * 4096 + 17, Ordering::Relaxed);
            assert!(self.panics != Some(index), "planted in batch {index}");
            let sums = vec![[1.0 / (index as f64 + 3.0); 4]];
            Sums { node: Node::batch((index % 32) as u8, sums, 4096), troubled: Vec::new() }
        }
    }

    fn run(threads: usize, groups: &[Plain], end: u64, until: u64) -> (Vec<Fold<Sums>>, Result<(), Fault>) {
        let mut state = vec![Fold::<Sums>::default(); groups.len()];
        let list: Vec<&dyn Batches> = groups.iter().map(|g| g as &dyn Batches).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut round = |s: &[Fold<Sums>]| s[0].next() < until;
        let done =
            pool.install(|| work(&list, &mut state, end, Watch { stop: &|| false, round: &mut round }));
        (state, done)
    }

    #[test]
    fn a_stopped_run_is_a_prefix_for_any_number_of_threads() {
        let groups = [Plain { panics: None }, Plain { panics: None }, Plain { panics: None }];
        let sum = |s: &[Fold<Sums>]| s.iter().map(|f| f.peek().unwrap().node.sums[0][0]).collect::<Vec<_>>();
        for threads in [1, 2, 7] {
            let (stopped, _) = run(threads, &groups, 100, 23);
            let (whole, _) = run(1, &groups, 23, u64::MAX);
            assert!(stopped.iter().all(|f| f.next() == 23));
            assert_eq!(sum(&stopped), sum(&whole));
        }
    }

    /// Batches that are done at once: threads stand in line for the sums when one of them stops the run.
    #[test]
    fn a_stop_is_seen_by_those_that_stand_in_line() {
        for _ in 0..2000 {
            let (stopped, _) = run(3, &[Plain { panics: None }], 1000, 23);
            assert_eq!(stopped[0].next(), 23);
        }
    }

    /// Fault of the design's table: panic in a worker.
    #[test]
    fn a_panic_in_a_worker_is_caught_with_its_history() {
        for threads in [1, 2, 7] {
            let groups = [Plain { panics: None }, Plain { panics: Some(40) }];
            let (state, done) = run(threads, &groups, 100, u64::MAX);
            let fault = done.unwrap_err();
            assert_eq!((fault.group, fault.batch, fault.history), (1, 40, 40 * 4096 + 17));
            assert!(fault.message.contains("planted in batch 40"), "{fault}");
            assert!(state.iter().all(|f| f.next() <= 40), "sums before the panic only");
        }
    }
}
