//! Many jobs at once, on all cores, with results in the order of the jobs.

mod order;

use std::convert::Infallible;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread::Builder;

pub use order::InOrder;

/// How far jobs may run ahead of the earliest unfinished one: bounds the number of waiting results. Much less would let
/// the other cores wait for one long run among short ones. (Chosen, not measured.)
const AHEAD: u64 = 4096;

/// The stack size of each thread: that of a main thread on most systems, so that all threads behave alike.
const STACK_BYTES: usize = 8 << 20;

/// More threads per core than this only get in each other's way.
const MOST_PER_CORE: usize = 16;

/// The number of threads: one per core, or the number in the environment variable `RAYON_NUM_THREADS`, as is common.
#[must_use]
pub fn threads() -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    threads_of(std::env::var("RAYON_NUM_THREADS").ok().as_deref(), cores)
}

fn threads_of(asked: Option<&str>, cores: usize) -> usize {
    let asked = asked.and_then(|asked| asked.parse().ok()).filter(|asked| *asked > 0);
    asked.unwrap_or(cores).min(MOST_PER_CORE * cores)
}

/// Runs all jobs and returns their results in the order of the jobs, for any number of cores. `progress` is called with
/// the number of finished jobs, on the thread that finished one.
pub fn run<J: Sync, R: Send>(jobs: &[J], work: impl Fn(&J) -> R + Sync, progress: impl Fn(usize) + Sync) -> Vec<R> {
    let (done, never) = (AtomicUsize::new(0), AtomicBool::new(false));
    let one = |place: u64| {
        let result = work(&jobs[place as usize]);
        progress(done.fetch_add(1, Ordering::Relaxed) + 1);
        result
    };
    let mut results = Vec::with_capacity(jobs.len());
    let Ok(()) = in_order(0..jobs.len() as u64, threads(), &never, one, |_, result| {
        results.push(result);
        Ok::<bool, Infallible>(true)
    });
    results
}

/// Runs the jobs with these numbers on `threads` threads, and passes the results to `take` in order, on this thread.
/// `take` decides whether to continue. Once `interrupted` is set, no further job begins; the results of those that have
/// begun are still taken.
///
/// If the operating system provides fewer threads, these do all the work; if it provides none, this thread does.
pub fn in_order<T: Send, E>(
    places: Range<u64>,
    threads: usize,
    interrupted: &AtomicBool,
    work: impl Fn(u64) -> T + Sync,
    take: impl FnMut(u64, T) -> Result<bool, E>,
) -> Result<(), E> {
    let first = places.start;
    let threads = threads.min(usize::try_from(places.end.saturating_sub(places.start)).unwrap_or(usize::MAX));
    let gate = Gate::new(places);
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        let start = |_: &usize| {
            let (send, gate, work) = (send.clone(), &gate, &work);
            let worker = move || {
                let _closing = CloseOnPanic(gate);
                while let Some(place) = gate.enter(interrupted) {
                    if send.send((place, work(place))).is_err() {
                        break;
                    }
                }
            };
            Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, worker).is_ok()
        };
        let started = (0..threads).take_while(start).count();
        // Only the workers still send, so receiving ends when the last of them does.
        drop(send);
        if started == 0 {
            return work_alone(&gate, interrupted, &work, take);
        }
        take_in_order(&gate, InOrder::from(first), receive, take)
    })
}

/// Does all the work on this thread.
fn work_alone<T, E>(
    gate: &Gate,
    interrupted: &AtomicBool,
    work: impl Fn(u64) -> T,
    mut take: impl FnMut(u64, T) -> Result<bool, E>,
) -> Result<(), E> {
    while let Some(place) = gate.enter(interrupted) {
        if !take(place, work(place))? {
            break;
        }
        gate.took(place);
    }
    Ok(())
}

/// Passes the results of the workers to `take` in order, until it ends the work.
fn take_in_order<T, E>(
    gate: &Gate,
    mut order: InOrder<T>,
    receive: mpsc::Receiver<(u64, T)>,
    mut take: impl FnMut(u64, T) -> Result<bool, E>,
) -> Result<(), E> {
    for (place, result) in receive {
        order.put(place, result);
        while let Some((place, result)) = order.take() {
            match take(place, result) {
                Ok(true) => gate.took(place),
                over => {
                    gate.close();
                    return over.map(drop);
                }
            }
        }
    }
    Ok(())
}

/// Lets threads begin the next job, but not too far ahead of the results taken.
struct Gate {
    state: Mutex<Places>,
    moved: Condvar,
}

struct Places {
    next: u64,
    taken: u64,
    end: u64,
}

impl Gate {
    fn new(places: Range<u64>) -> Self {
        let state = Places { next: places.start, taken: places.start, end: places.end };
        Self { state: Mutex::new(state), moved: Condvar::new() }
    }

    /// The next job, as soon as it may begin; `None` after the last, or when the gate is closed.
    fn enter(&self, interrupted: &AtomicBool) -> Option<u64> {
        let too_far = |places: &mut Places| places.next < places.end && places.next >= places.taken + AHEAD;
        let mut places = self.moved.wait_while(self.lock(), too_far).unwrap_or_else(PoisonError::into_inner);
        if places.next >= places.end || interrupted.load(Ordering::Relaxed) {
            return None;
        }
        places.next += 1;
        Some(places.next - 1)
    }

    fn took(&self, place: u64) {
        self.lock().taken = place + 1;
        self.moved.notify_all();
    }

    /// No further job begins.
    fn close(&self) {
        self.lock().end = 0;
        self.moved.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Places> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Prevents waiting for the result of a thread that has panicked.
struct CloseOnPanic<'g>(&'g Gate);

impl Drop for CloseOnPanic<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.close();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    static NOT: AtomicBool = AtomicBool::new(false);

    fn slow_first(place: u64) -> u64 {
        std::hint::black_box((0..(300 - place) * 50).fold(place, |sum, step| sum.wrapping_mul(31) ^ step));
        place * place
    }

    fn collected(threads: usize, stop_at: u64) -> Vec<(u64, u64)> {
        let mut taken = Vec::new();
        in_order(5..300, threads, &NOT, slow_first, |place, result| {
            taken.push((place, result));
            Ok::<bool, Infallible>(place < stop_at)
        })
        .unwrap();
        taken
    }

    #[test]
    fn results_are_taken_in_order_on_any_number_of_threads() {
        let all: Vec<(u64, u64)> = (5..300).map(|place| (place, place * place)).collect();
        for threads in [0, 1, 2, 7] {
            assert_eq!(collected(threads, 300), all);
            assert_eq!(collected(threads, 100), all[..96], "it stops where `take` ends the work");
        }
    }

    #[test]
    fn a_failure_to_accept_a_result_ends_the_work() {
        let full = || "full";
        let take = |place, _| if place == 9 { Err(full()) } else { Ok(true) };
        let result = in_order(0..100, 3, &NOT, |place| place, take);
        assert_eq!(result, Err("full"));
    }

    #[test]
    fn an_interruption_keeps_the_results_of_jobs_that_have_begun() {
        for threads in [0, 1, 2, 7] {
            let (interrupted, begun) = (AtomicBool::new(false), Mutex::new(0));
            let work = |place| {
                *begun.lock().unwrap() += 1;
                interrupted.fetch_or(place >= 20, Ordering::Relaxed);
                slow_first(place)
            };
            let mut taken = Vec::new();
            in_order(0..300, threads, &interrupted, work, |place, _| {
                taken.push(place);
                Ok::<bool, Infallible>(true)
            })
            .unwrap();
            // Each thread may already be busy when the first reports a result.
            assert!((21..=20 + threads.max(1)).contains(&taken.len()), "{} on {threads} threads", taken.len());
            assert_eq!(taken, (0..*begun.lock().unwrap()).collect::<Vec<u64>>());
        }
    }

    #[test]
    fn no_thread_gets_too_far_ahead() {
        let gate = Gate::new(0..3 * AHEAD);
        let begun = (0..AHEAD).filter_map(|_| gate.enter(&NOT)).count() as u64;
        assert_eq!(begun, AHEAD);
        gate.took(0);
        assert_eq!(gate.enter(&NOT), Some(AHEAD));
        gate.close();
        assert_eq!(gate.enter(&NOT), None);
    }

    #[test]
    fn a_panic_is_passed_on_and_nothing_waits_for_its_result() {
        let work = |place| assert!(place != 3, "place 3");
        let all = || in_order(0..3 * AHEAD, 2, &NOT, work, |_, ()| Ok::<bool, Infallible>(true));
        assert!(std::panic::catch_unwind(all).is_err());
    }

    #[test]
    fn the_number_of_threads_is_limited() {
        let asked = [None, Some("3"), Some("100000"), Some("0"), Some("many")].map(|asked| threads_of(asked, 2));
        assert_eq!(asked, [2, 3, 32, 2, 2]);
    }

    #[test]
    fn results_come_in_order_and_progress_counts_every_job() {
        let jobs: Vec<u64> = (0..200).collect();
        let seen = Mutex::new(Vec::new());
        let slow_first = |job: &u64| {
            let steps = (200 - job) * 100;
            std::hint::black_box((0..steps).fold(*job, |sum, step| sum.wrapping_mul(31) ^ step));
            *job
        };
        let results = run(&jobs, slow_first, |done| seen.lock().expect("no thread panics").push(done));
        assert_eq!(results, jobs);
        let mut seen = seen.into_inner().expect("no thread panics");
        seen.sort_unstable();
        assert_eq!(seen, (1..=200).collect::<Vec<_>>());
    }
}
