//! The settings of components in a scenario: its table `components`.

use std::path::PathBuf;

use diagnostics::Spanned;
use diagnostics::document::Table;

use super::leaves::{Data, read_data};

/// The settings of a component from files: an entry of the table `components`.
#[derive(Clone, Debug)]
pub struct ComponentEntry {
    /// The name of its process.
    pub name: Spanned<String>,
    /// The file of its machine.
    pub machine: Spanned<PathBuf>,
    /// The initial values of the machine's data.
    pub data: Data,
    /// The file with its interface, if others ask it or read its topics.
    pub interface: Option<Spanned<PathBuf>>,
}

/// Reads the table `components`.
pub(super) fn read_components(table: Table<'_>) -> Vec<ComponentEntry> {
    let mut entries = Vec::new();
    for (name, span) in table.keys() {
        let Some(entry) = table.table(name).required() else { continue };
        let machine = entry.text("machine").map(PathBuf::from).spanned().required();
        let data = entry.table("data").optional().map_or_else(Vec::new, read_data);
        let interface = entry.text("interface").map(PathBuf::from).spanned().optional();
        let name = Spanned { value: name.to_owned(), span: span.clone() };
        entries.extend(machine.map(|machine| ComponentEntry { name, machine, data, interface }));
    }
    entries
}

/// Whether two scenarios have the same components.
pub(super) fn same_components(these: &[ComponentEntry], those: &[ComponentEntry]) -> bool {
    let said = |entry: &ComponentEntry| {
        let data: Vec<_> = entry.data.iter().map(|(id, value)| (id.value.clone(), value.clone())).collect();
        let interface = entry.interface.as_ref().map(|interface| interface.value.clone());
        (entry.name.value.clone(), entry.machine.value.clone(), data, interface)
    };
    these.iter().map(said).eq(those.iter().map(said))
}
