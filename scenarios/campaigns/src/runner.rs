//! Runs a campaign on all cores, with results in the order of the runs.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Once};
use std::time::Instant;

use scenarios::scenario::Scenario;

use super::file::{Goal, Question};
use super::journal::{Header, Journal};
use super::shard::Shard;
use super::statistics::Count;
use super::summary::{GoalReport, Summary};
use super::{Plan, PlannedRun, RunRecord, results};
use crate::Error;
use crate::report_of;

/// The progress of a campaign, after one more of its runs.
#[derive(Clone, Debug)]
pub struct Progress<'p> {
    /// How many runs are done, including those of earlier sessions.
    pub done: u64,
    /// The maximum number of runs.
    pub all: u64,
    /// The names of the properties.
    pub properties: &'p [String],
    /// How often each property was violated.
    pub violated: &'p [Count],
    /// How often a run was not as expected.
    pub unexpected: Count,
    /// The run that has just finished; none at the beginning.
    pub run: Option<&'p RunRecord>,
}

/// The result of running a campaign.
#[derive(Debug)]
pub struct Ran {
    /// How many runs are done.
    pub done: u64,
    /// The maximum number of runs.
    pub all: u64,
    /// Whether no runs are left: all are done, or the campaign's goal has been reached.
    pub complete: bool,
    /// The result of the campaign's goal, if it has one.
    pub goal: Option<GoalReport>,
    /// While it is open, no other program can write to the folder.
    journal: Journal,
}

impl Ran {
    /// Makes dataset, summary and page from the journal, which must have all runs of the campaign.
    ///
    /// # Errors
    /// [`Error::Scenario`] if they cannot be written; existing results then stay unchanged.
    pub fn finish(self) -> Result<Summary, Error> {
        results::finish(&self.journal, self.goal)
    }
}

/// Runs a shard of a campaign, or the rest of it, on this many `threads`, and writes the journal in `folder`. Once
/// `interrupted` is set, no new run starts; those that have started finish and are recorded. `progress` is called after
/// each run. A run that fails is a result; see [`RunRecord::failure`].
///
/// # Errors
/// [`Error::Scenario`] if the folder has another campaign's results, if the shard is of a campaign with a goal, or if
/// the journal cannot be written.
pub fn run(
    plan: &Plan,
    shard: Shard,
    folder: &Path,
    threads: usize,
    interrupted: &AtomicBool,
    progress: impl FnMut(&Progress<'_>),
) -> Result<Ran, Error> {
    run_each(plan, shard, folder, threads, interrupted, progress, |run| conducted(plan, run))
}

/// Runs the rest of a shard, each run with `conduct`.
fn run_each(
    plan: &Plan,
    shard: Shard,
    folder: &Path,
    threads: usize,
    interrupted: &AtomicBool,
    mut progress: impl FnMut(&Progress<'_>),
    conduct: impl Fn(&PlannedRun) -> Result<RunRecord, String> + Sync,
) -> Result<Ran, Error> {
    plan.check_shard(shard)?;
    let (mut watch, mut done) = (Watch::new(plan), 0);
    let mut journal = Journal::open(folder, &Header::of(plan, shard), |record| {
        done += 1;
        watch.take(&record);
        Ok(())
    })?;
    let all = shard.len(plan.runs());
    progress(&watch.progress(done, all, None));
    let end = if watch.enough() { done } else { all };
    let work = |place: u64| timed(|| run_one(plan, shard.run(place), &conduct));
    silence_caught_panics();
    batch::in_order(done..end, threads, interrupted, work, |place, (record, wall_time_s)| {
        journal.append(&record, wall_time_s)?;
        done = place + 1;
        watch.take(&record);
        progress(&watch.progress(done, all, Some(&record)));
        Ok::<bool, Error>(!watch.enough())
    })?;
    // If the folder has been removed in the meantime, the results are gone.
    journal.reader()?;
    Ok(Ran { done, all, complete: done == all || watch.enough(), goal: watch.report(), journal })
}

/// Counts events in the runs, in order, and decides whether the campaign's goal is reached.
struct Watch<'p> {
    plan: &'p Plan,
    /// For each property, its violations.
    violated: Vec<Count>,
    unexpected: Count,
}

impl<'p> Watch<'p> {
    fn new(plan: &'p Plan) -> Self {
        Self { plan, violated: vec![Count::default(); plan.properties().len()], unexpected: Count::default() }
    }

    fn take(&mut self, record: &RunRecord) {
        self.unexpected.push(record.unexpected());
        for (property, count) in self.violated.iter_mut().enumerate() {
            if let Some(violated) = record.violated(property) {
                count.push(violated);
            }
        }
    }

    fn progress<'s>(&'s self, done: u64, all: u64, run: Option<&'s RunRecord>) -> Progress<'s> {
        let Self { plan, violated, unexpected } = self;
        Progress { done, all, properties: plan.properties(), violated, unexpected: *unexpected, run }
    }

    /// The campaign's goal, with the count of its event.
    fn goal(&self) -> Option<(&'p Goal, Count)> {
        let goal = self.plan.file().goal.as_ref()?;
        // A plan is checked: a name that is none of a property is `expectation`.
        let place = self.plan.properties().iter().position(|name| *name == goal.of.value);
        Some((goal, place.map_or(self.unexpected, |place| self.violated[place])))
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

/// The result, and the wall time in seconds.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    #[expect(clippy::disallowed_methods, reason = "the computer's own time is not part of the results")]
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
    let scenario = Scenario::load(plan.scenario(), &run.overrides(plan));
    let scenario = Arc::new(scenario.map_err(|error| error.reasons())?);
    let report = report_of(Arc::clone(&scenario), run.seed);
    let report = report.map_err(|error| error.reasons())?;
    let stops: Vec<&str> = scenario.file.stop.at.iter().map(|place| place.value.as_str()).collect();
    Ok(RunRecord::of(run.clone(), &report, &stops))
}

thread_local! {
    /// Whether panics in this thread are caught and become results.
    static CATCHING: Cell<bool> = const { Cell::new(false) };
}

/// The result of `work`; a panic is a failure like any other.
fn caught<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let message = |panic: Box<dyn Any + Send>| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        format!("panicked: {}", text.unwrap_or("without a message"))
    };
    CATCHING.set(true);
    // Unfinished work is local to the run and is dropped with it.
    let result = catch_unwind(AssertUnwindSafe(work));
    CATCHING.set(false);
    result.unwrap_or_else(|panic| Err(message(panic)))
}

/// Silences panics that are [caught]: they are part of the results. `--only` shows where a panic happened.
fn silence_caught_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !CATCHING.get() {
                hook(panic);
            }
        }));
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RunOutcome;

    static NOT: AtomicBool = AtomicBool::new(false);

    #[test]
    fn a_panic_is_a_failure_with_a_message() {
        let panics = || -> Result<(), String> { panic!("run {}", 3) };
        assert_eq!(caught(panics), Err("panicked: run 3".to_owned()));
        assert_eq!(caught(|| Ok(1)), Ok(1));
    }

    /// However a run ends, it becomes a record, and the campaign continues.
    #[test]
    fn runs_that_panic_or_are_rejected_are_recorded_with_their_command() {
        let text = "scenario = \"errand\"\nruns = 4\nset = [\"execution.max_time_s=0.1\"]\n";
        let plan = Plan::parse("two words.toml", text).unwrap().with_runs(3).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let work = |run: &PlannedRun| match run.k {
            0 => panic!("a wheel came off"),
            1 => Err("refused".to_owned()),
            _ => conducted(&plan, run),
        };
        let mut seen = Vec::new();
        let see = |progress: &Progress<'_>| seen.push((progress.done, progress.violated.to_vec(), progress.unexpected));
        let ran = run_each(&plan, Shard::ALL, folder.path(), 2, &NOT, see, work).unwrap();
        assert_eq!((ran.done, ran.complete), (3, true));
        let again = || Journal::open(folder.path(), &Header::of(&plan, Shard::ALL), |_| Ok(()));
        assert!(
            again().unwrap_err().to_string().contains("another program is writing"),
            "until the results are written"
        );
        let summary = ran.finish().unwrap();
        again().unwrap();
        assert_eq!((summary.outcomes.failed, summary.failures.len()), (2, 2));
        assert_eq!(summary.failures[0].why.as_deref(), Some("panicked: a wheel came off"));
        assert_eq!(summary.failures[0].command, "steward campaign 'two words.toml' --runs 3 --only 0");
        // Failed runs do not count for a property, either in the summary or in the progress.
        let (_, violated, unexpected) = seen.last().unwrap();
        assert_eq!(violated[0].runs(), 1);
        assert_eq!((unexpected.happened(), unexpected.runs()), (3, 3), "the third ends before it arrives");
        assert_eq!(summary.properties[0].count, violated[0]);
        assert_eq!(summary.expectation.count, *unexpected);
        assert_eq!(seen.iter().map(|(done, ..)| *done).collect::<Vec<_>>(), [0, 1, 2, 3]);
        assert_eq!(RunRecord::failed(plan.run(0), String::new()).outcome, RunOutcome::Failed);
    }
}
