//! A run in which a person intervenes, and the scenario that repeats it.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use diagnostics::FileProblems;
use recording::{Detail, Ended, Record, RecordSource as _, RunView};
use scenarios::Error;
use scenarios::faults::Fault;
use scenarios::scenario::{Found, FoundKind, Scenario, ScenarioFile};
use toml::{Table, Value};

use crate::partners::Partners;
use crate::run::Run;

/// How much more than the largest error of localization a saved scenario allows, in meters. Chosen, not measured: the
/// run is the same, so that any margin is enough.
const MARGIN_M: f64 = 0.01;

/// The comment at the start of a saved scenario of a session with partners.
const APART: &str = "\
# The faults of a session in which others took part from outside the program. What they did is not in this file: a run
# of it need not be the same, and is expected to be only what the scenario on which it is based expects.
";

/// A run in which a person intervenes.
///
/// Each act is a fault at the present moment; a lasting one lasts until it is [released](Self::release). The session is
/// always a scenario, as it could be in a file, with all acts so far. So an act is checked like a fault in a file, and
/// the [saved](Self::saved) scenario gives the same run, unless [partners](Self::has_partners) took part.
pub struct Session {
    found: Found,
    run: Run,
    view: RunView,
    /// The scenario without its faults.
    written: Table,
    /// The faults of the scenario, followed by the acts.
    faults: Vec<Value>,
    /// The number of faults that are not acts.
    given: usize,
    /// The records since they were last requested.
    records: Vec<Record>,
    audience: Option<Audience>,
}

/// Receives the view of a session at its start and after each step.
type Audience = Box<dyn FnMut(&RunView) + Send>;

impl Session {
    /// A session with a scenario at its start, changed by `overrides` as for `--set`. Without `seed`, the scenario's
    /// own seed is used.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that is wrong with the scenario.
    pub fn new(found: &Found, overrides: &[String], seed: Option<u64>) -> Result<Self, Error> {
        Self::with_partners(found, overrides, seed, |_| Ok(Partners::None))
    }

    /// The same, with the partners that `join` finds for the scenario.
    ///
    /// # Errors
    /// As for [`new`](Self::new); if the partners cannot take part in the scenario; and those of `join`.
    pub fn with_partners(
        found: &Found,
        overrides: &[String],
        seed: Option<u64>,
        join: impl FnOnce(&Scenario) -> Result<Partners, Error>,
    ) -> Result<Self, Error> {
        // Whatever becomes of the files meanwhile, the session continues with what they contain now.
        let found = Found { files: found.files.clone().remembering(), ..found.clone() };
        let base = Scenario::load(&found, overrides)?;
        let seed = seed.unwrap_or(base.file.seed);
        let (written, faults) = without_faults(&found, overrides, seed).map_err(Error::bad_input)?;
        let given = faults.len();
        let scenario = load(&found, &written, &faults)?;
        let partners = join(&scenario)?;
        let mut run = Run::with_partners(Arc::new(scenario), seed, true, partners)?;
        let view = run.start(Detail::Scenes)?;
        Ok(Self { found, run, view, written, faults, given, records: Vec::new(), audience: None })
    }

    /// The same session, with an audience that receives its view: at once, and after each step.
    #[must_use]
    pub fn with_audience(mut self, mut audience: impl FnMut(&RunView) + Send + 'static) -> Self {
        audience(self.view());
        self.audience = Some(Box::new(audience));
        self
    }

    /// The scenario, with all acts so far.
    #[must_use]
    pub fn scenario(&self) -> &Scenario {
        self.run.scenario()
    }

    /// The time between steps.
    #[must_use]
    pub fn step_length(&self) -> Duration {
        self.scenario().file.execution.step()
    }

    /// The run so far.
    #[must_use]
    pub fn view(&self) -> &RunView {
        &self.view
    }

    /// Whether partners take part, which set its pace.
    #[must_use]
    pub fn has_partners(&self) -> bool {
        self.view().header().has_partners()
    }

    /// Performs one step; does nothing if the run has ended. The scenario ends the run as it would without acts.
    /// Returns whether the step is done: if partners take part, it may still wait for them after a moment, and
    /// continues with the next call.
    ///
    /// # Errors
    /// The reason why the run cannot continue.
    pub fn step(&mut self, detail: Detail) -> Result<bool, Error> {
        if self.view().end().is_some() {
            return Ok(true);
        }
        self.go_on(detail, false)
    }

    /// Continues after a pause, in which the time of the run stood still: its partners are notified.
    pub fn resume(&mut self) {
        self.run.resume();
    }

    /// Ends the run here, if it has not ended. A step that has begun no longer waits for partners, and these leave.
    pub fn end(&mut self) {
        if self.view().end().is_none() && self.run.is_waiting() {
            // If it fails, that is the end as well.
            let _ = self.go_on(Detail::Full, true);
        }
        if self.view().end().is_none() {
            self.run.end_in(&mut self.view, Ended::Interrupted, Detail::Full);
            self.record_end();
        }
    }

    fn go_on(&mut self, detail: Detail, is_stopped: bool) -> Result<bool, Error> {
        let stepped = self.run.go_on(&mut self.view, detail, is_stopped);
        if !matches!(stepped, Ok(false)) {
            self.records.push(Record::Step(self.view().step().clone()));
            if let Some(audience) = &mut self.audience {
                audience(&self.view);
            }
            self.record_end();
        }
        stepped
    }

    fn record_end(&mut self) {
        let end = self.view().end().cloned();
        self.records.extend(end.map(|end| Record::End(Box::new(end))));
    }

    /// The records since the start, or since the last call. They stay in memory until they are taken.
    pub fn take_records(&mut self) -> Vec<Record> {
        std::mem::take(&mut self.records)
    }

    /// The lasting faults that were caused by acts during the run and are still active, each with its index.
    pub fn lasting(&self) -> impl Iterator<Item = (usize, &Fault)> {
        let acts = self.run.scenario().file.faults.iter().map(Arc::as_ref).enumerate().skip(self.given);
        acts.filter(|(_, act)| !act.kind().is_momentary() && act.timing.lasts.is_none())
    }

    /// Does something now: `fault` is an entry of `[[faults]]` without a trigger. Returns the index of the fault in the
    /// run. After an error, nothing has changed.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the fault is wrong or does not fit the run.
    pub fn act(&mut self, fault: Table) -> Result<usize, Error> {
        let faults = self.faults.clone();
        self.act_after(faults, fault)
    }

    /// Replaces a lasting act: it ends, and `fault` begins now. After an error, nothing has changed.
    ///
    /// # Errors
    /// As for [`release`](Self::release) and [`act`](Self::act).
    pub fn replace(&mut self, act: usize, fault: Table) -> Result<usize, Error> {
        let faults = self.released(act)?;
        self.act_after(faults, fault)
    }

    fn act_after(&mut self, mut faults: Vec<Value>, mut fault: Table) -> Result<usize, Error> {
        if self.view().end().is_some() {
            return Err(Error::refused("the run has ended", "start the session again"));
        }
        fault.insert("at_s".to_owned(), seconds(self.run.time()));
        faults.push(Value::Table(fault));
        self.adopt(faults)?;
        Ok(self.faults.len() - 1)
    }

    /// Ends a lasting act: now, or after the next step if it has only just begun.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the fault with this index is no act, or already has an end.
    pub fn release(&mut self, act: usize) -> Result<(), Error> {
        let faults = self.released(act)?;
        self.adopt(faults)
    }

    /// The faults after this act has been given an end.
    fn released(&self, act: usize) -> Result<Vec<Value>, Error> {
        let mut faults = self.faults.clone();
        let fault = faults.get_mut(act).filter(|_| act >= self.given).and_then(Value::as_table_mut);
        let Some(fault) = fault.filter(|fault| !fault.contains_key("lasts_s")) else {
            let help = "only a lasting act of this session that is still in effect can be ended";
            return Err(Error::refused(format!("fault {act} cannot be ended"), help));
        };
        let begun = fault.get("at_s").and_then(Value::as_float).map_or(Duration::ZERO, Duration::from_secs_f64);
        fault.insert("lasts_s".to_owned(), seconds(self.run.time().saturating_sub(begun).max(self.step_length())));
        Ok(faults)
    }

    fn adopt(&mut self, faults: Vec<Value>) -> Result<(), Error> {
        let known = self.found.files.remembered();
        // A file that was refused may be corrected.
        let scenario = load(&self.found, &self.written, &faults).inspect_err(|_| self.found.files.retain(&known))?;
        if scenario.file.faults[self.faults.len()..].iter().any(|new| !new.kind().can_begin_later()) {
            let help = "write this fault into the scenario, with `at_s = 0`";
            return Err(Error::refused("the software's map can be wrong only from the start of a run", help));
        }
        self.run.adopt(Arc::new(scenario))?;
        self.faults = faults;
        Ok(())
    }

    /// The text of a scenario that repeats the session up to now, and expects its results. It names the scenario on
    /// which it is based: one that is shipped by its name, so that it can be stored anywhere, and a user's own by the
    /// name of its file, so that it belongs into the same folder. What partners did cannot be repeated: a session
    /// with them is saved without its end and its results, and a comment in the text explains that.
    #[must_use]
    pub fn saved(&self) -> String {
        let mut written = self.written.clone();
        if !self.has_partners() {
            self.expect_results(&mut written);
        }
        if let Some(Value::String(model)) = written.get_mut("model") {
            *model = file_name(model);
        }
        let about = if self.has_partners() { APART } else { "" };
        about.to_owned() + &text(&written, &self.faults)
    }

    /// Lets a scenario end where the session is now, and expect its results.
    fn expect_results(&self, written: &mut Table) {
        let view = self.view();
        let mut set = |table: &str, key: &str, value: Value| {
            let table = written.entry(table).or_insert_with(|| Value::Table(Table::new()));
            table.as_table_mut().map(|table| table.insert(key.to_owned(), value));
        };
        if view.end().is_none_or(|end| end.ended == Ended::Interrupted) {
            set("execution", "max_time_s", seconds(view.time().max(self.step_length())));
        }
        for monitor in view.monitors() {
            set("expect", monitor.name(), monitor.outcome().name().into());
        }
        let expect = &self.run.scenario().file.expect;
        let reached: Vec<Value> = view.arrivals().map(|(name, _)| name.into()).collect();
        let collisions = view.robot().truth.map_or(0, |truth| truth.collisions);
        let lowest_pct = view.tally().battery().map_or(0.0, |battery| battery.minimum_pct);
        let error_m = view.tally().localization_error().map_or(0.0, |error| error.max_m);
        // What the base expects would be expected of this run as well: it is replaced by what has happened. What the
        // base does not expect is left out, so that the scenario states no more than it did.
        for (key, value, matters) in [
            ("reached", reached.into(), !expect.reached.is_empty()),
            ("not_reached", Value::Array(Vec::new()), !expect.not_reached.is_empty()),
            (
                "max_collisions",
                Value::Integer(i64::try_from(collisions).unwrap_or(i64::MAX)),
                expect.max_collisions.is_some(),
            ),
            ("min_battery_pct", lowest_pct.floor().into(), expect.min_battery_pct.is_some()),
            ("max_localization_m", (error_m + MARGIN_M).into(), expect.max_localization_m.is_some()),
        ] {
            if matters {
                set("expect", key, value);
            }
        }
    }
}

/// The text of a session's scenario apart from its faults, and these faults.
fn without_faults(found: &Found, overrides: &[String], seed: u64) -> Result<(Table, Vec<Value>), FileProblems> {
    let overridden = overrides.iter().filter_map(|one| one.split(['.', '=']).next()).map(str::trim);
    let mut written = ScenarioFile::values(found, overrides, overridden.chain(["about", "faults"]))?;
    let faults = match written.remove("faults") {
        Some(Value::Array(faults)) => faults,
        _ => Vec::new(),
    };
    let mut set = |key: &str, value: Value| written.insert(key.to_owned(), value);
    set("seed", Value::Integer(i64::try_from(seed).unwrap_or(i64::MAX)));
    // A model's path is relative to the working directory, a base's to the scenario.
    match found.kind {
        FoundKind::Shipped => set("base", found.argument.clone().into()),
        FoundKind::OnDisk => set("base", file_name(&found.path).into()),
        FoundKind::Model => set("model", found.path.clone().into()),
    };
    Ok((written, faults))
}

/// The name of a path's file. A whole path would be wrong on another computer, and elsewhere on this one.
fn file_name(path: &str) -> String {
    Path::new(path).file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn load(found: &Found, written: &Table, faults: &[Value]) -> Result<Scenario, Error> {
    Scenario::load(&Found { text: text(written, faults), ..found.clone() }, &[])
}

/// The text of a scenario with these faults, even if there are none: its base may have others.
fn text(written: &Table, faults: &[Value]) -> String {
    let mut written = written.clone();
    written.insert("faults".to_owned(), faults.to_vec().into());
    written.to_string()
}

/// A time in seconds, as scenarios write it.
fn seconds(time: Duration) -> Value {
    diagnostics::seconds(time).into()
}

#[cfg(test)]
mod tests;
