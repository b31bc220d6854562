//! Running a campaign: on all cores, with results in the order of the runs.

use std::any::Any;
use std::cell::Cell;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, Once, PoisonError, mpsc};
use std::time::Instant;

use serde::Serialize;

use super::file::{Goal, Question};
use super::journal::{Header, Journal, Shard};
use super::statistics::{Count, InOrder, Interval, Side};
use super::{Plan, PlannedRun, RunRecord};
use crate::Error;
use crate::conduct::{Outputs, conduct};
use crate::scenario::Scenario;

/// How many runs may begin before the earliest that has not ended: bounds the results that wait for it.
const AHEAD: u64 = 4096;

/// How far a campaign has come, after one more of its runs.
#[derive(Clone, Debug)]
pub struct Progress<'p> {
    /// How many runs are done, those of earlier sittings included.
    pub done: u64,
    /// How many there are at most.
    pub all: u64,
    /// What is asked of the runs: each property by its name, and `expectation`.
    pub asked: &'p [String],
    /// In how many of how many runs each of them happened: the property was violated, the run was not as expected.
    pub counts: &'p [Count],
}

/// What came of running a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Ran {
    /// How many runs are done.
    pub done: u64,
    /// How many there are at most.
    pub all: u64,
    /// Whether nothing is left to be run: all runs are done, or the campaign's goal is reached.
    pub complete: bool,
    /// What came of the campaign's goal, if it has one.
    pub goal: Option<GoalReport>,
}

/// Runs a shard of a campaign, or what is left of it, and writes the journal in `folder`. Once `interrupted` is set, no run
/// begins any more; those that have begun end and are written down. `progress` is told after each run. A run that fails
/// is a result; see [`RunRecord::failure`].
///
/// # Errors
/// [`Error::BadInput`] if the folder has another campaign's results, or if a campaign with a goal is to be sharded;
/// [`Error::Write`] if the journal cannot be written.
pub fn run(
    plan: &Plan,
    shard: Shard,
    folder: &Path,
    interrupted: &AtomicBool,
    progress: impl FnMut(&Progress<'_>),
) -> Result<Ran, Error> {
    run_each(plan, shard, folder, interrupted, progress, |run| conducted(plan, run))
}

/// Runs what is left of a shard, each run by `conduct`.
fn run_each(
    plan: &Plan,
    shard: Shard,
    folder: &Path,
    interrupted: &AtomicBool,
    mut progress: impl FnMut(&Progress<'_>),
    conduct: impl Fn(&PlannedRun) -> Result<RunRecord, String> + Sync,
) -> Result<Ran, Error> {
    if shard != Shard::ALL && plan.file().goal.is_some() {
        let help = "shards do not know of each other's results: leave out the `[goal]` and say `runs`";
        return Err(Error::refused("a campaign that stops at a goal cannot be sharded", help));
    }
    let (mut watch, mut done) = (Watch::new(plan), 0);
    let mut journal = Journal::open(folder, &Header::of(plan, shard), |record| {
        done += 1;
        watch.take(&record);
        Ok(())
    })?;
    let all = shard.len(plan.runs());
    progress(&watch.progress(done, all));
    let end = if watch.enough() { done } else { all };
    let work = |place: u64| timed(|| run_one(plan, shard.run(place), &conduct));
    hush_caught_panics();
    in_order(done..end, rayon::current_num_threads(), interrupted, work, |place, (record, wall_time_s)| {
        journal.append(&record, wall_time_s)?;
        done = place + 1;
        watch.take(&record);
        progress(&watch.progress(done, all));
        Ok(!watch.enough())
    })?;
    Ok(Ran { done, all, complete: done == all || watch.enough(), goal: watch.report() })
}

/// What came of a campaign's goal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GoalReport {
    /// Of what the probability is asked.
    pub of: String,
    /// In how many of how many runs it happened. Runs that failed count for no property.
    pub count: Count,
    /// Whether the goal was reached with these runs.
    pub reached: bool,
    /// The interval of an estimate, which keeps the goal's confidence though it was looked at on the way.
    pub interval: Option<Interval>,
    /// The decision of a test.
    pub side: Option<Side>,
}

/// Counts what happens in the runs, in their order, and says whether the campaign's goal is reached.
struct Watch<'p> {
    plan: &'p Plan,
    asked: Vec<String>,
    counts: Vec<Count>,
}

impl<'p> Watch<'p> {
    fn new(plan: &'p Plan) -> Self {
        let asked: Vec<String> = plan.properties().iter().cloned().chain(["expectation".to_owned()]).collect();
        Self { plan, counts: vec![Count::default(); asked.len()], asked }
    }

    fn take(&mut self, record: &RunRecord) {
        let (expectation, properties) = self.counts.split_last_mut().expect("the expectation is always counted");
        expectation.push(record.unexpected());
        for (property, count) in properties.iter_mut().enumerate() {
            if let Some(violated) = record.violated(property) {
                count.push(violated);
            }
        }
    }

    fn progress(&self, done: u64, all: u64) -> Progress<'_> {
        Progress { done, all, asked: &self.asked, counts: &self.counts }
    }

    /// The campaign's goal, with the count that it asks for.
    fn goal(&self) -> Option<(&'p Goal, Count)> {
        let goal = self.plan.file().goal.as_ref()?;
        let place = self.asked.iter().position(|asked| *asked == goal.of.value);
        Some((goal, self.counts[place.expect("a plan's goal was checked to ask of something that there is")]))
    }

    fn enough(&self) -> bool {
        self.goal().is_some_and(|(goal, count)| match &goal.question {
            Question::Estimate(precision) => precision.reached(count).is_some(),
            Question::Test(test) => test.decision(count).is_some(),
        })
    }

    fn report(&self) -> Option<GoalReport> {
        let (goal, count) = self.goal()?;
        let (interval, side) = match &goal.question {
            Question::Estimate(precision) => (Some(precision.interval(count)), None),
            Question::Test(test) => (None, test.decision(count)),
        };
        Some(GoalReport { of: goal.of.value.clone(), count, reached: self.enough(), interval, side })
    }
}

/// The result, and how long the computer took for it, in seconds.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    #[expect(clippy::disallowed_methods, reason = "how long the computer took is no part of the results")]
    let began = Instant::now();
    let result = work();
    (result, began.elapsed().as_secs_f64())
}

/// Run `k` from start to end.
fn run_one(plan: &Plan, k: u64, conduct: impl Fn(&PlannedRun) -> Result<RunRecord, String>) -> RunRecord {
    let run = plan.run(k);
    caught(|| conduct(&run)).unwrap_or_else(|why| RunRecord::failed(run, why))
}

fn conducted(plan: &Plan, run: &PlannedRun) -> Result<RunRecord, String> {
    let scenario = Scenario::load_like(plan.base(), plan.scenario(), &run.overrides(plan));
    let scenario = Arc::new(scenario.map_err(|error| super::plan::reasons(&error))?);
    let report = conduct(Arc::clone(&scenario), run.seed, true, &Outputs::default(), |_| {});
    let report = report.map_err(|error| super::plan::reasons(&error))?;
    let stops: Vec<&str> = scenario.file.stop.at.iter().map(|place| place.value.as_str()).collect();
    Ok(RunRecord::of(run.clone(), &report, &stops))
}

thread_local! {
    /// Whether a panic of this thread is caught and becomes a result.
    static CATCHING: Cell<bool> = const { Cell::new(false) };
}

/// What `work` gives; a panic is a failure like any other.
fn caught<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let message = |panic: Box<dyn Any + Send>| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        format!("panicked: {}", text.unwrap_or("without a message"))
    };
    CATCHING.set(true);
    // What the work leaves half done is its own and goes with it.
    let result = catch_unwind(AssertUnwindSafe(work));
    CATCHING.set(false);
    result.unwrap_or_else(|panic| Err(message(panic)))
}

/// Lets panics that are [caught] pass in silence: they are told among the results. `--only` tells where it was.
fn hush_caught_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let told = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !CATCHING.get() {
                told(panic);
            }
        }));
    });
}

/// Does the work of these places on so many threads, and hands the results to `take` in the order of the places, on this
/// thread. `take` says whether to go on. Once `interrupted` is set no work begins, and what has begun is taken.
fn in_order<T: Send>(
    places: Range<u64>,
    threads: usize,
    interrupted: &AtomicBool,
    work: impl Fn(u64) -> T + Sync,
    mut take: impl FnMut(u64, T) -> Result<bool, Error>,
) -> Result<(), Error> {
    let first = places.start;
    let gate = Gate::new(places);
    std::thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        for _ in 0..threads {
            let (send, gate, work) = (send.clone(), &gate, &work);
            scope.spawn(move || {
                while let Some(place) = gate.enter(interrupted) {
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
    fn new(places: Range<u64>) -> Self {
        let state = Places { next: places.start, taken: places.start, end: places.end };
        Self { state: Mutex::new(state), moved: Condvar::new() }
    }

    /// The next place, when it may begin; none after the last, or when it is over.
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
    use crate::campaign::{RunOutcome, finish};

    static NOT: AtomicBool = AtomicBool::new(false);

    fn slow_first(place: u64) -> u64 {
        std::hint::black_box((0..(300 - place) * 50).fold(place, |sum, step| sum.wrapping_mul(31) ^ step));
        place * place
    }

    fn collected(threads: usize, stop_at: u64) -> Vec<(u64, u64)> {
        let mut taken = Vec::new();
        in_order(5..300, threads, &NOT, slow_first, |place, result| {
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
        let take = |place, _| if place == 9 { Err(full()) } else { Ok(true) };
        let result = in_order(0..100, 3, &NOT, |place| place, take);
        assert_eq!(result.unwrap_err().to_string(), "full");
    }

    #[test]
    fn an_interruption_lets_end_what_has_begun_and_loses_none_of_it() {
        for threads in [1, 2, 7] {
            let (interrupted, begun) = (AtomicBool::new(false), Mutex::new(0));
            let work = |place| {
                *begun.lock().unwrap() += 1;
                interrupted.fetch_or(place >= 20, Ordering::Relaxed);
                slow_first(place)
            };
            let mut taken = Vec::new();
            in_order(0..300, threads, &interrupted, work, |place, _| {
                taken.push(place);
                Ok(true)
            })
            .unwrap();
            // Each thread may be at work already when the first says it.
            assert!((21..=20 + threads).contains(&taken.len()), "{} on {threads} threads", taken.len());
            assert_eq!(taken, (0..*begun.lock().unwrap()).collect::<Vec<u64>>());
        }
    }

    #[test]
    fn no_thread_runs_too_far_ahead() {
        let gate = Gate::new(0..3 * AHEAD);
        let begun = (0..AHEAD).filter_map(|_| gate.enter(&NOT)).count() as u64;
        assert_eq!(begun, AHEAD);
        gate.took(0);
        assert_eq!(gate.enter(&NOT), Some(AHEAD));
        gate.close();
        assert_eq!(gate.enter(&NOT), None);
    }

    #[test]
    fn a_panic_is_a_failure_in_words() {
        let panics = || -> Result<(), String> { panic!("run {}", 3) };
        assert_eq!(caught(panics), Err("panicked: run 3".to_owned()));
        assert_eq!(caught(|| Ok(1)), Ok(1));
    }

    /// Whatever a run does, it is a record, and the campaign goes on.
    #[test]
    fn runs_that_panic_or_are_refused_are_records_with_their_command() {
        let text = "scenario = \"errand\"\nruns = 4\nset = [\"execution.max_time_s=0.1\"]\n";
        let plan = Plan::parse("two words.toml", text).unwrap().with_runs(3).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let work = |run: &PlannedRun| match run.k {
            0 => panic!("a wheel came off"),
            1 => Err("refused".to_owned()),
            _ => conducted(&plan, run),
        };
        let mut seen = Vec::new();
        let see = |progress: &Progress<'_>| seen.push((progress.done, progress.counts.to_vec()));
        let ran = run_each(&plan, Shard::ALL, folder.path(), &NOT, see, work).unwrap();
        assert_eq!((ran.done, ran.complete), (3, true));
        let summary = finish(folder.path(), ran.goal).unwrap();
        assert_eq!((summary.outcomes.failed, summary.failures.len()), (2, 2));
        assert_eq!(summary.failures[0].why.as_deref(), Some("panicked: a wheel came off"));
        assert_eq!(summary.failures[0].command, "steward campaign 'two words.toml' --runs 3 --only 0");
        // Failed runs say nothing of a property, in the summary as on the way.
        let (_, counts) = seen.last().unwrap();
        assert_eq!(counts[0].runs(), 1);
        assert_eq!((counts[3].happened(), counts[3].runs()), (3, 3), "the third ends before it arrives");
        assert_eq!(summary.properties[0].count, counts[0]);
        assert_eq!(summary.expectation.count, counts[3]);
        assert_eq!(seen.iter().map(|(done, _)| *done).collect::<Vec<_>>(), [0, 1, 2, 3]);
        assert_eq!(RunRecord::failed(plan.run(0), String::new()).outcome, RunOutcome::Failed);
    }
}
