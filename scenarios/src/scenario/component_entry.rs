//! The settings of components in a scenario: its table `components`.

use std::path::PathBuf;

use diagnostics::Spanned;
use diagnostics::document::Table;
use programs::Limits;

use super::leaves::{Data, read_data};
use crate::files::named;

/// The settings of a component from files: an entry of the table `components`.
#[derive(Clone, Debug)]
pub struct ComponentEntry {
    /// The name of its process.
    pub name: Spanned<String>,
    /// What it runs.
    pub runs: RunsEntry,
    /// The initial values of its data.
    pub data: Data,
    /// The file with its interface, if others ask it or read its topics.
    pub interface: Option<Spanned<PathBuf>>,
}

/// What the entry of a component says that it runs.
#[derive(Clone, Debug)]
pub enum RunsEntry {
    /// The machine in this file.
    Machine(Spanned<PathBuf>),
    /// A program.
    Program {
        /// Its command.
        command: Spanned<Vec<String>>,
        /// What it may take.
        limits: Limits,
        /// The components that it asks, and whose topics it reads.
        asks: Vec<Spanned<String>>,
    },
    /// Neither, or both: it is refused.
    Unclear,
}

/// Reads the table `components`.
pub(super) fn read_components(table: Table<'_>) -> Vec<ComponentEntry> {
    let mut entries = Vec::new();
    for (name, span) in table.keys() {
        let Some(entry) = table.table(name).required() else { continue };
        let runs = read_runs(&entry);
        let data = entry.table("data").optional().map_or_else(Vec::new, read_data);
        let interface = entry.text("interface").try_map(|path, span| Ok(named(path, span))).spanned().optional();
        let name = Spanned { value: name.to_owned(), span: span.clone() };
        entries.push(ComponentEntry { name, runs, data, interface });
    }
    entries
}

fn read_runs(entry: &Table<'_>) -> RunsEntry {
    let machine = entry.text("machine").try_map(|path, span| Ok(named(path, span))).spanned().optional();
    let command = entry.get("program").spanned().optional();
    let default = Limits::default();
    let answer_within = entry.seconds("answer_within_s").check(|time| !time.is_zero(), "be above 0");
    let memory_mb = entry.get::<u64>("memory_mb").within(1..=1 << 20).or(default.memory_bytes >> 20);
    let limits = Limits { answer_within: answer_within.or(default.answer_within), memory_bytes: memory_mb << 20 };
    let asks = entry.get("asks").or(Vec::new());
    match (machine, command) {
        (Some(machine), None) => RunsEntry::Machine(machine),
        (None, Some(command)) => RunsEntry::Program { command, limits, asks },
        _ => RunsEntry::Unclear,
    }
}

/// Whether two scenarios have the same components.
pub(super) fn same_components(these: &[ComponentEntry], those: &[ComponentEntry]) -> bool {
    let said = |entry: &ComponentEntry| {
        let data: Vec<_> = entry.data.iter().map(|(id, value)| (id.value.clone(), value.clone())).collect();
        let interface = entry.interface.as_ref().map(|interface| interface.value.clone());
        let runs = match &entry.runs {
            RunsEntry::Unclear => (None, None),
            RunsEntry::Machine(machine) => (Some(machine.value.clone()), None),
            RunsEntry::Program { command, limits, asks } => {
                let asks: Vec<String> = asks.iter().map(|name| name.value.clone()).collect();
                (None, Some((command.value.clone(), *limits, asks)))
            }
        };
        (entry.name.value.clone(), runs, data, interface)
    };
    these.iter().map(said).eq(those.iter().map(said))
}
