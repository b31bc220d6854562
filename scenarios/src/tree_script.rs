//! The answers of a tree's leaves at each of their ticks: the file of `steward tree run --leaves`.
//!
//! ```toml
//! ticks = 5                     # by default as long as the longest part
//! period_s = 0.5                # the time between ticks; by default 1
//! halt_after = [3]              # the tree is halted after these ticks
//! otherwise = "success"         # the answer of leaves that are not listed; by default, all must be listed
//!
//! [leaves]                      # by the name of a leaf's process, its own name, or its ID
//! BatteryLevel = ["success", "success", "failure"]     # the last answer applies to all later ticks, too
//! AtDestination = "failure"
//! GoToDestination = "running running success"
//! Look = { answers = ["success", "failure"], repeat = true }
//! Find = [{ answer = "success", outputs = { pose = "1;2;0" } }]
//!
//! [constants]                   # names for numbers in scripts, like enumerators that a program registers
//! RED = 1
//!
//! [blackboard]                  # the entries before the first tick
//! goal = "home"
//!
//! [[writes]]                    # entries written later, from outside
//! before_tick = 3
//! entries = { goal = "kitchen" }
//! ```

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use bt::{Cue, LeafBehavior, Rehearsal, RehearsedTick, Status, Tree, Value};
use diagnostics::Problem;
use diagnostics::document::{Document, Item, Table};

use crate::Error;

/// The maximum number of ticks: the result of every tick is kept in memory.
pub const MOST_TICKS: u64 = 1_000_000;

/// A rehearsal, as its file describes it.
#[derive(Clone, Debug)]
pub struct TreeScript {
    /// For each leaf of the tree.
    behaviors: Vec<LeafBehavior>,
    ticks: u64,
    /// The time between ticks.
    period: Duration,
    /// The tree is halted after these ticks.
    halts: BTreeSet<u64>,
    /// The values written to the blackboard before a tick, from the first on.
    writes: Vec<(u64, Vec<(String, Value)>)>,
}

/// The file of a rehearsal, as it is written.
#[derive(Debug)]
pub struct WrittenScript(Document);

impl WrittenScript {
    /// The names of the leaves. They need not be declared in the tree's file.
    #[must_use]
    pub fn leaves(&self) -> Vec<String> {
        let leaves = self.0.value("leaves");
        leaves.iter().filter_map(|leaves| leaves.as_table()).flatten().map(|(name, _)| name.clone()).collect()
    }

    /// The names for numbers in scripts, with which the tree is to be loaded.
    ///
    /// # Errors
    /// Everything that is wrong with them.
    pub fn constants(&self) -> Result<Vec<(String, i64)>, Error> {
        let read = |table: Table<'_>| {
            table.allow_other_keys();
            constants(&table)
        };
        self.0.read(read).map_err(Error::bad_input)
    }

    /// The rehearsal of this tree: the file must have a behavior for every leaf.
    ///
    /// # Errors
    /// Everything that is wrong in the file, and every leaf without a behavior.
    pub fn read(&self, tree: &Tree) -> Result<TreeScript, Error> {
        self.0.read(|table| TreeScript::read(&table, tree)).map_err(Error::bad_input)
    }
}

impl TreeScript {
    /// Reads the file.
    ///
    /// # Errors
    /// If it cannot be read, or is not TOML.
    pub fn open(file: &Path) -> Result<WrittenScript, Error> {
        let name = file.display().to_string();
        let text = diagnostics::text_from_disk(file).map_err(|error| {
            Error::refused(format!("cannot read {name}: {error}"), "a TOML file with a table `leaves`")
        })?;
        Document::parse_toml(&name, &text).map(WrittenScript).map_err(Error::bad_input)
    }

    fn read(table: &Table<'_>, tree: &Tree) -> Option<Self> {
        let ticks = table.get::<u64>("ticks").within(0..=MOST_TICKS).optional();
        let period = table.seconds("period_s").or(Duration::from_secs(1));
        let halts = table.get::<Vec<u64>>("halt_after").or(Vec::new()).into_iter().collect();
        constants(table);
        let blackboard = table.table("blackboard").optional().map_or(Some(Vec::new()), |entries| values(&entries));
        let mut writes = Vec::new();
        for write in table.tables("writes").optional().unwrap_or_default() {
            let tick = write.get::<u64>("before_tick").within(1..=MOST_TICKS).required();
            let entries = write.table("entries").required().and_then(|entries| values(&entries));
            writes.extend(tick.zip(entries));
        }
        let otherwise = table.get::<Item<'_>>("otherwise").optional().map(|item| cues(&item).map(LeafBehavior::new));
        let otherwise = otherwise.and_then(|behavior| behavior.map_err(|problem| table.report(problem)).ok());
        let behaviors = behaviors(&table.table("leaves").required()?, tree, otherwise.as_ref())?;
        writes.insert(0, (1, blackboard?));
        let longest = behaviors.iter().map(LeafBehavior::length).max().unwrap_or(1);
        let ticks = ticks.unwrap_or(u64::try_from(longest).unwrap_or(u64::MAX));
        Some(Self { behaviors, ticks, period, halts, writes })
    }

    /// Ticks the tree according to the script; `see` receives every tick and every halt.
    ///
    /// # Errors
    /// If a value does not fit the port that has its blackboard entry.
    pub fn rehearse(
        &self,
        tree: &Arc<Tree>,
        ticks: Option<u64>,
        mut see: impl FnMut(&Rehearsal, RehearsedTick),
    ) -> Result<(), Error> {
        let mut rehearsal = Rehearsal::new(Arc::clone(tree), self.behaviors.iter().cloned());
        for tick in 0..ticks.unwrap_or(self.ticks) {
            let now = self.period.saturating_mul(u32::try_from(tick).unwrap_or(u32::MAX));
            let writes = self.writes.iter().filter(|(before, _)| *before == tick + 1);
            for (key, value) in writes.flat_map(|(_, entries)| entries) {
                let board = rehearsal.execution_mut().blackboard_mut();
                board.set(key, value.clone()).map_err(|error| {
                    let what = format!("`{key}` on the blackboard: {error}");
                    Error::refused(what, "the entry is used as a port of that type")
                })?;
            }
            let moment = rehearsal.tick(now);
            see(&rehearsal, moment);
            if self.halts.contains(&(tick + 1)) {
                let moment = rehearsal.halt(now);
                see(&rehearsal, moment);
            }
        }
        Ok(())
    }
}

fn constants(table: &Table<'_>) -> Option<Vec<(String, i64)>> {
    let Some(constants) = table.table("constants").optional() else { return Some(Vec::new()) };
    let names: Vec<&str> = constants.keys().map(|(name, _)| name).collect();
    let numbers: Vec<_> =
        names.into_iter().map(|name| Some((name.to_owned(), constants.get::<i64>(name).optional()?))).collect();
    numbers.into_iter().collect()
}

/// The behaviors of all leaves: by their names, or otherwise by their IDs, or otherwise the one for all others.
fn behaviors(leaves: &Table<'_>, tree: &Tree, otherwise: Option<&LeafBehavior>) -> Option<Vec<LeafBehavior>> {
    let mut behaviors = Vec::new();
    let mut missing = BTreeSet::new();
    for leaf in tree.leaves() {
        let key = [leaf.process(), leaf.label(), leaf.type_id()].into_iter().find(|key| leaves.has(key));
        match key {
            Some(key) => behaviors.push(behavior(leaves, key)),
            None if otherwise.is_some() => behaviors.push(otherwise.cloned()),
            None => {
                missing.insert(leaf.label());
            }
        }
    }
    for key in missing.into_iter().map(bt::one_line) {
        let problem = leaves.span().problem(format!("there is no answer for the leaf `{key}`")).with_label("here");
        let help = format!("add `{key} = \"success\"`, or another answer; `otherwise`, at the top, is for all others");
        leaves.report(problem.with_help(help));
        behaviors.push(None);
    }
    behaviors.into_iter().collect()
}

fn behavior(leaves: &Table<'_>, key: &str) -> Option<LeafBehavior> {
    let item = leaves.get::<Item<'_>>(key).optional()?;
    let read = if let Some(table) = item.as_table().filter(|table| table.has("answers")) {
        let answers = table.get::<Item<'_>>("answers").required()?;
        let repeats = table.boolean("repeat").or(false);
        cues(&answers).map(|cues| if repeats { LeafBehavior::new(cues).repeating() } else { LeafBehavior::new(cues) })
    } else {
        cues(&item).map(LeafBehavior::new)
    };
    read.map_err(|problem| leaves.report(problem)).ok()
}

/// One or more cues; a text may name several.
fn cues(item: &Item<'_>) -> Result<Vec<Cue>, Problem> {
    let cues = match (item.as_array(), item.as_text()) {
        (Some(items), _) => items.iter().map(cues).collect::<Result<Vec<_>, _>>()?.concat(),
        (_, Some(text)) => {
            let statuses = text.split_whitespace().map(|word| status(word).map(Cue::from));
            statuses.collect::<Option<_>>().ok_or_else(|| wrong(item))?
        }
        _ => vec![cue(&item.as_table().ok_or_else(|| wrong(item))?, item)?],
    };
    if cues.is_empty() { Err(wrong(item)) } else { Ok(cues) }
}

/// An answer with the values written to the leaf's ports.
fn cue(table: &Table<'_>, item: &Item<'_>) -> Result<Cue, Problem> {
    let answer = table.text("answer").optional().and_then(|word| status(&word)).ok_or_else(|| wrong(item))?;
    let outputs = table.table("outputs").optional().map_or(Some(Vec::new()), |outputs| values(&outputs));
    Ok(Cue { status: answer, outputs: outputs.unwrap_or_default() })
}

fn wrong(item: &Item<'_>) -> Problem {
    item.wrong("an answer or several").with_help("\"success\", \"failure\", \"running\" or \"skipped\"")
}

fn status(word: &str) -> Option<Status> {
    let statuses = [Status::Running, Status::Success, Status::Failure, Status::Skipped];
    statuses.into_iter().find(|status| word.eq_ignore_ascii_case(status.name()))
}

/// The entries of a table, as the blackboard holds them.
fn values(table: &Table<'_>) -> Option<Vec<(String, Value)>> {
    let keys: Vec<&str> = table.keys().map(|(key, _)| key).collect();
    let values = keys.into_iter().map(|key| {
        let item = table.get::<Item<'_>>(key).optional()?;
        match value(&item) {
            Some(value) => Some((key.to_owned(), value)),
            None => {
                table.report(item.wrong("a number, a string, true or false, or an array of these"));
                None
            }
        }
    });
    // All of them are read, to report the problems of each.
    let values: Vec<_> = values.collect();
    values.into_iter().collect()
}

fn value(item: &Item<'_>) -> Option<Value> {
    if let Some(items) = item.as_array() {
        return items.iter().map(value).collect();
    }
    let number = item.as_integer().map(Value::Int).or_else(|| item.as_number().map(Value::Real));
    number.or_else(|| item.as_text().map(Value::from)).or_else(|| item.as_boolean().map(Value::from))
}
