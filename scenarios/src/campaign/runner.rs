//! Running a campaign: on all cores, with results in the order of the runs.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::Instant;

use serde::Serialize;

use super::file::Question;
use super::journal::{Header, Journal, Shard};
use super::statistics::{Count, InOrder, Interval, Side};
use super::{Plan, PlannedRun, RunRecord};
use crate::Error;
use crate::conduct::{Outputs, conduct};
use crate::scenario::Scenario;

/// How many runs may begin before the earliest that has not ended: bounds the results that wait for it.
const AHEAD: u64 = 4096;

/// Runs a shard of a campaign, or what is left of it, and writes the journal in `folder`. `progress` is told how many of
/// how many runs are done. A run that fails is a result; see [`RunRecord::failure`].
///
/// # Errors
/// [`Error::BadInput`] if the folder has another campaign's results, or if a campaign with a goal is to be sharded;
/// [`Error::Write`] if the journal cannot be written.
///
/// Gives what came of the campaign's goal, if it has one.
pub fn run(
    plan: &Plan,
    shard: Shard,
    folder: &Path,
    mut progress: impl FnMut(u64, u64),
) -> Result<Option<GoalReport>, Error> {
    if shard != Shard::ALL && plan.file().goal.is_some() {
        let help = "shards do not know of each other's results: leave out the `[goal]` and say `runs`";
        return Err(Error::refused("a campaign that stops at a goal cannot be sharded", help));
    }
    let (mut watch, mut first, mut enough) = (Watch { plan, count: Count::default() }, 0, false);
    let mut journal = Journal::open(folder, &Header::of(plan, shard), |record| {
        first += 1;
        enough = watch.enough(&record);
        Ok(())
    })?;
    let all = shard.len(plan.runs());
    progress(first, all);
    let end = if enough { first } else { all };
    let work = |place: u64| run_one(plan, shard.run(place));
    in_order(first, end, rayon::current_num_threads(), work, |place, (record, wall_time_s)| {
        journal.append(&record, wall_time_s)?;
        progress(place + 1, all);
        Ok(!watch.enough(&record))
    })?;
    Ok(watch.report())
}

/// What came of a campaign's goal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GoalReport {
    /// Of what the probability is asked.
    pub of: String,
    /// In how many of how many runs it happened.
    pub count: Count,
    /// Whether the goal was reached with these runs.
    pub reached: bool,
    /// The interval of an estimate, which keeps the goal's confidence though it was looked at on the way.
    pub interval: Option<Interval>,
    /// The decision of a test.
    pub side: Option<Side>,
}

/// Asks after each run whether the campaign's goal is reached.
struct Watch<'p> {
    plan: &'p Plan,
    count: Count,
}

impl Watch<'_> {
    fn enough(&mut self, record: &RunRecord) -> bool {
        let Some(goal) = &self.plan.file().goal else { return false };
        self.count.push(record.happened(&goal.of.value, self.plan));
        match &goal.question {
            Question::Estimate(precision) => precision.reached(self.count).is_some(),
            Question::Test(test) => test.decision(self.count).is_some(),
        }
    }

    fn report(&self) -> Option<GoalReport> {
        let goal = self.plan.file().goal.as_ref()?;
        let (reached, interval, side) = match &goal.question {
            Question::Estimate(precision) => {
                (precision.reached(self.count).is_some(), Some(precision.interval(self.count)), None)
            }
            Question::Test(test) => (test.decision(self.count).is_some(), None, test.decision(self.count)),
        };
        Some(GoalReport { of: goal.of.value.clone(), count: self.count, reached, interval, side })
    }
}

/// Run `k` from start to end, and how long the computer took, in seconds.
fn run_one(plan: &Plan, k: u64) -> (RunRecord, f64) {
    #[expect(clippy::disallowed_methods, reason = "how long the computer took is no part of the results")]
    let began = Instant::now();
    let run = plan.run(k);
    let record = match caught(|| conducted(plan, &run)) {
        Ok(record) => record,
        Err(why) => RunRecord::failed(run, why),
    };
    (record, began.elapsed().as_secs_f64())
}

fn conducted(plan: &Plan, run: &PlannedRun) -> Result<RunRecord, String> {
    let scenario = Scenario::load_like(plan.base(), plan.scenario(), &run.overrides(plan));
    let scenario = Arc::new(scenario.map_err(|error| super::plan::reasons(&error))?);
    let report = conduct(Arc::clone(&scenario), run.seed, true, &Outputs::default(), |_| {});
    let report = report.map_err(|error| super::plan::reasons(&error))?;
    let stops: Vec<&str> = scenario.file.stop.at.iter().map(|place| place.value.as_str()).collect();
    Ok(RunRecord::of(run.clone(), &report, &stops))
}

/// What `work` gives; a panic is a failure like any other.
fn caught<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let message = |panic: Box<dyn Any + Send>| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        format!("panicked: {}", text.unwrap_or("without a message"))
    };
    // What the work leaves half done is its own and goes with it.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(message(panic)))
}

/// Does the work of all places from `first` to before `end` on so many threads, and hands the results to `take` in the
/// order of the places, on this thread. `take` says whether to go on.
fn in_order<T: Send>(
    first: u64,
    end: u64,
    threads: usize,
    work: impl Fn(u64) -> T + Sync,
    mut take: impl FnMut(u64, T) -> Result<bool, Error>,
) -> Result<(), Error> {
    let gate = Gate { state: Mutex::new(Places { next: first, taken: first, end }), moved: Condvar::new() };
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        for _ in 0..threads {
            let (send, gate, work) = (send.clone(), &gate, &work);
            scope.spawn(move || {
                while let Some(place) = gate.enter() {
                    if send.send((place, work(place))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let mut order = InOrder::from(first);
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
    })
}

/// Lets threads begin the next place, but none too far ahead of the results that were taken.
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
    /// The next place, when it may begin; none after the last.
    fn enter(&self) -> Option<u64> {
        let too_far = |places: &mut Places| places.next < places.end && places.next >= places.taken + AHEAD;
        let mut places = self.moved.wait_while(self.lock(), too_far).unwrap_or_else(PoisonError::into_inner);
        if places.next >= places.end {
            return None;
        }
        places.next += 1;
        Some(places.next - 1)
    }

    fn took(&self, place: u64) {
        self.lock().taken = place + 1;
        self.moved.notify_all();
    }

    /// Nothing begins any more.
    fn close(&self) {
        self.lock().end = 0;
        self.moved.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Places> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn collected(threads: usize, stop_at: u64) -> Vec<(u64, u64)> {
        let slow_first = |place: u64| {
            std::hint::black_box((0..(300 - place) * 50).fold(place, |sum, step| sum.wrapping_mul(31) ^ step));
            place * place
        };
        let mut taken = Vec::new();
        in_order(5, 300, threads, slow_first, |place, result| {
            taken.push((place, result));
            Ok(place < stop_at)
        })
        .unwrap();
        taken
    }

    #[test]
    fn results_are_taken_in_order_on_any_number_of_threads() {
        let all: Vec<(u64, u64)> = (5..300).map(|place| (place, place * place)).collect();
        for threads in [1, 2, 7] {
            assert_eq!(collected(threads, 300), all);
            assert_eq!(collected(threads, 100), all[..96], "it stops where it is told to");
        }
    }

    #[test]
    fn what_cannot_be_taken_ends_it() {
        let full = || Error::refused("full", "");
        let result = in_order(0, 100, 3, |place| place, |place, _| if place == 9 { Err(full()) } else { Ok(true) });
        assert_eq!(result.unwrap_err().to_string(), "full");
    }

    #[test]
    fn no_thread_runs_too_far_ahead() {
        let gate = Gate { state: Mutex::new(Places { next: 0, taken: 0, end: 3 * AHEAD }), moved: Condvar::new() };
        let begun = (0..AHEAD).filter_map(|_| gate.enter()).count() as u64;
        assert_eq!(begun, AHEAD);
        gate.took(0);
        assert_eq!(gate.enter(), Some(AHEAD));
        gate.close();
        assert_eq!(gate.enter(), None);
    }

    #[test]
    fn a_panic_is_a_failure_in_words() {
        let panics = || -> Result<(), String> { panic!("run {}", 3) };
        assert_eq!(caught(panics), Err("panicked: run 3".to_owned()));
        assert_eq!(caught(|| Ok(1)), Ok(1));
    }
}
