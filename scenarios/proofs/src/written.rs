//! A run that was found, as files: a schedule, and a scenario that follows the schedule.

use std::path::{Component, Path, PathBuf};
use std::time::Duration;

use channels::ChannelSystem;
use diagnostics::Staging;
use diagnostics::document::Document;
use explorer::{Path as Run, PathStep};
use monitors::Outcome;
use runs::Switched;
use scenarios::Error;
use scenarios::scenario::SomeProperties;
use scenarios::scenario::schedule::DriverData;
use scenarios::scenario::schedule::{FaultChange, Schedule, quoted};

use super::coverage;
use super::faults::{self, Switching};
use super::physics::duration;
use super::{Answer, Physical, Proof, Question};

/// The name of the file with the schedule.
pub const SCHEDULE: &str = "schedule.toml";
/// The name of the file with the scenario that also violates the property in the simulation.
pub const PHYSICS: &str = "physics.toml";
/// The name of the file with the scenario.
pub const COUNTEREXAMPLE: &str = "counterexample.toml";

impl Proof {
    /// Writes a run that was found as a schedule and a scenario that follows it. Returns the scenario's path.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write_run(&self, question: &Question, answer: &Answer, run: &Run, folder: &Path) -> Result<PathBuf, Error> {
        let data = self.driver_data(answer, run)?;
        let name = &self.scenario.name;
        let mut about = format!("A run of {name} against {}, found by steward prove", question.property);
        let rests_on = self.replay(question, answer)?.map(|run| run.rests_on).unwrap_or_default();
        if !rests_on.is_empty() {
            let words: Vec<&str> = rests_on.iter().map(|assumption| assumption.words.as_str()).collect();
            about += &format!(". It rests on what is assumed: {}", words.join(" "));
        }
        let hold = self.scenario.file.prove.messages.hold;
        let changes = faults::changes(run, &self.faults).into_iter().map(|change| {
            let Switching { index, begins } = change?;
            let Switched { kind, name, .. } = &self.faults[index];
            Some(FaultChange { begins, kind: *kind, name: name.clone() })
        });
        let steps = run.steps().iter().zip(data).zip(changes);
        let steps = steps.map(|((step, data), change)| (step, data.unwrap_or_default(), change));
        let schedule = Schedule::text(&about, steps, hold, &self.system);
        let staging = Staging::begin(folder)?;
        staging.write(SCHEDULE, schedule)?;
        staging.write(COUNTEREXAMPLE, self.counterexample(&about, answer, run, folder)?)?;
        staging.publish(&[SCHEDULE, COUNTEREXAMPLE])?;
        Ok(folder.join(COUNTEREXAMPLE))
    }

    /// The data that the components have received after each step of the environment.
    pub(super) fn driver_data(&self, answer: &Answer, run: &Run) -> Result<Vec<Option<DriverData>>, Error> {
        let steps = run.steps();
        let mut data = vec![None; steps.len()];
        self.replayed(answer, run, |step, system| {
            if let PathStep::Environment { .. } = steps[step] {
                data[step] = Some(DriverData::inside(system, faults::inside));
            }
        })?;
        Ok(data)
    }

    /// Replays the run; `look` sees the system after each step.
    pub(super) fn replayed(
        &self,
        answer: &Answer,
        run: &Run,
        look: impl FnMut(usize, &ChannelSystem),
    ) -> Result<(), Error> {
        let replayed = run.replay_and_look(&answer.model, None, look);
        let help = "this is a bug in steward: please report it, with the scenario";
        let failed =
            |error| Error::refused(format!("a run of {} cannot be replayed: {error}", self.scenario.name), help);
        replayed.map(|_| ()).map_err(failed)
    }

    fn counterexample(&self, about: &str, answer: &Answer, run: &Run, folder: &Path) -> Result<String, Error> {
        let mut text = format!("# It follows {SCHEDULE}, without physics: see `steward help prove`.\n");
        let more = self.long_enough(duration(run) + self.scenario.file.execution.tick);
        text += &self.based_on_it(about, &more, folder);
        text += &format!("faults = []\nexecution.schedule = {}\n", quoted(SCHEDULE));
        // It ends with its schedule, and no sooner because of another property.
        let stop = &self.scenario.file.stop;
        for (key, properties) in [("on_violation", &stop.on_violation), ("when_settled", &stop.when_settled)] {
            if !matches!(properties, SomeProperties::None) {
                text += &format!("stop.{key} = false\n");
            }
        }
        // A schedule replaces the world, which some properties are about.
        let all = self.monitoring.monitors().iter();
        for (watched, monitor) in all.filter(|(_, monitor)| self.truths_for(Some(monitor.as_ref())).is_none()) {
            let Some(monitor) = run.replay(&answer.model, Some(monitor.as_ref())).ok().and_then(|it| it.monitor) else {
                continue;
            };
            let outcome = Outcome::of(monitor.as_ref());
            text += &format!("expect.{} = {}\n", quoted(&watched.name), quoted(outcome.name()));
        }
        // An error of the tree is known only until its next tick.
        let mut errors = coverage::failed(self.scenario.tree(), &self.system);
        self.replayed(answer, run, |_, system| errors.extend(coverage::failed(self.scenario.tree(), system)))?;
        let errors: Vec<String> = errors.iter().map(|name| quoted(name)).collect();
        text += &format!("expect.errors = [{}]\n", errors.join(", "));
        Ok(text)
    }

    /// What must be set so that a run may take this long.
    pub(super) fn long_enough(&self, time: Duration) -> Vec<String> {
        let is_longer = time > self.scenario.file.execution.max_time;
        is_longer.then(|| format!("execution.max_time_s = {}", diagnostics::seconds(time))).into_iter().collect()
    }

    /// Writes the scenario that also violates a property in the simulation.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write_physical(&self, question: &Question, physical: &Physical, folder: &Path) -> Result<(), Error> {
        let about = format!("{} is also violated in the simulation", question.property);
        let text = "# The levels and the lost messages of the run that was found, as faults.\n".to_owned();
        let mut text = text + &self.based_on_it(&about, &physical.overrides, folder);
        text += &format!("stop.on_violation = [{}]\nstop.after_s = 0\n", quoted(&question.property));
        for (name, outcome) in &physical.outcomes {
            text += &format!("expect.{} = {}\n", quoted(name), quoted(outcome.name()));
        }
        Ok(diagnostics::write_whole(&folder.join(PHYSICS), text)?)
    }

    /// The beginning of a scenario in the folder `in_folder` that extends this one with further assignments and expects
    /// nothing of the world.
    fn based_on_it(&self, about: &str, more: &[String], in_folder: &Path) -> String {
        let origin = &self.scenario.origin;
        let argument = Path::new(&origin.argument);
        let on_disk = argument.is_file().then(|| here(argument));
        // A path on the command line is relative to the current folder, one in a file to the file's folder.
        let folder = match &on_disk {
            Some(file) => file.parent().map(Path::to_owned),
            None => (!origin.overrides.is_empty()).then(|| here(Path::new("."))),
        };
        let from = here(in_folder);
        let written = |path: &Path| relative(&from, path).display().to_string();
        let in_tables = |path: &Path| relative(folder.as_deref().unwrap_or(&from), path).display().to_string();
        let base = on_disk.as_deref().map_or(origin.argument.clone(), written);
        let mut text = format!("about = {}\nbase = {}\n", quoted(about), quoted(&base));
        if let Some(folder) = &folder {
            text += &format!("folder = {}\n", quoted(&written(folder)));
        }
        let given: Vec<String> = origin.overrides.iter().map(|assignment| anchored(assignment, &in_tables)).collect();
        text += &overridden(&given, more);
        if self.scenario.premises.is_some() {
            text += "expect.reached = []\nexpect.not_reached = []\nexpect.min_battery_pct = 0\n";
        }
        text
    }
}

/// An absolute path without links, as far as the file exists.
fn here(path: &Path) -> PathBuf {
    path.canonicalize().or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_owned())
}

/// The way from one folder to a file, both absolute. What lies together stays together when it is moved or sent, so
/// only files that have nothing but the root in common keep their absolute path.
fn relative(from: &Path, to: &Path) -> PathBuf {
    let shared = from.components().zip(to.components()).take_while(|(one, other)| one == other).count();
    if shared < 2 {
        return to.to_owned();
    }
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    let way: PathBuf = up.chain(to.components().skip(shared)).collect();
    if way.as_os_str().is_empty() { PathBuf::from(".") } else { way }
}

/// An assignment whose paths are `written` as in the file, if these files exist: they were relative to the current
/// folder, and in a file they are relative to the one that it names, or its own.
fn anchored(assignment: &str, written: &dyn Fn(&Path) -> String) -> String {
    /// The keys whose values are paths, and the last parts of such keys in tables.
    const PATHS: [&str; 8] = ["map", "places", "tree", "skills", "model", "properties", "machine", "interface"];
    let Some((key, value)) = assignment.split_once('=') else { return assignment.to_owned() };
    if !PATHS.contains(&key.trim().rsplit('.').next().unwrap_or_default()) || key.trim() == "execution.tree" {
        return assignment.to_owned();
    }
    let found = |path: &str| Some(here(Path::new(path))).filter(|path| path.exists());
    let place = |path: &str| found(path).map_or_else(|| path.to_owned(), |path| written(&path));
    let value = value.trim();
    let parsed = Document::parse_toml("", &format!("value = {value}")).ok();
    let Some(parsed) = parsed.and_then(|document| document.value("value")) else {
        return format!("{key}={}", quoted(&place(value)));
    };
    let items = parsed.as_array().map(|items| items.iter().filter_map(|item| Some(quoted(&place(item.as_str()?)))));
    let items = items.map(|items| format!("[{}]", items.collect::<Vec<_>>().join(", ")));
    let value = items.or_else(|| Some(quoted(&place(parsed.as_str()?)))).unwrap_or_else(|| value.to_owned());
    format!("{key}={value}")
}

/// The assignments of the command line as lines of a file, followed by `more`. Each key occurs once, and assignments to
/// keys that the file sets itself are left out.
fn overridden(overrides: &[String], more: &[String]) -> String {
    let mut lines: Vec<(&str, String)> = Vec::new();
    let all = overrides.iter().map(|text| (text, true)).chain(more.iter().map(|text| (text, false)));
    for ((key, value), is_given) in all.filter_map(|(text, is_given)| Some((text.split_once('=')?, is_given))) {
        let (key, value) = (key.trim(), value.trim());
        let first = key.split('.').next().unwrap_or_default();
        if is_given && ["about", "base", "faults", "expect", "stop"].contains(&first) || key == "execution.schedule" {
            continue;
        }
        lines.retain(|(other, _)| *other != key);
        let is_toml = Document::parse_toml("", &format!("value = {value}")).is_ok();
        let value = if is_toml { value.to_owned() } else { quoted(value) };
        let is_item = key.split('.').any(|part| part.parse::<usize>().is_ok());
        let mark = if is_item { "# not here: " } else { "" };
        lines.push((key, format!("{mark}{key} = {value}\n")));
    }
    lines.into_iter().map(|(_, line)| line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_lie_together_are_named_from_each_other() {
        for (from, to, way) in [
            ("/home/a/out/p", "/home/a/s.toml", "../../s.toml"),
            ("/home/a", "/home/a/tasks/s.toml", "tasks/s.toml"),
            ("/home/a", "/home/a", "."),
            ("/tmp/out", "/home/a/s.toml", "/home/a/s.toml"),
        ] {
            assert_eq!(relative(Path::new(from), Path::new(to)), Path::new(way), "{from} {to}");
        }
    }
}
