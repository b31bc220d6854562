//! The settings for a tree's leaves in a scenario: its table `leaves`.

use bt::Node;
use diagnostics::document::{Referent, Table};
use diagnostics::{Span, Spanned};

use super::asking::{Asking, FORMS, one_form};
use super::data::{Data, read_data};

/// The settings for a leaf, or for all with an ID: an entry of the table `leaves`.
#[derive(Clone, Debug, PartialEq)]
pub struct LeafEntry {
    /// The name of the leaf's process, or an ID.
    pub leaf: Spanned<String>,
    /// The file of its machine, in the folder of the skills.
    pub machine: Option<Spanned<String>>,
    /// What it asks, if its machine is written from that.
    pub asking: Option<Asking>,
    /// The initial values of the machine's data.
    pub data: Data,
}

/// The entry of a leaf: that with its name, or else that with its ID. Only this function determines it.
pub(super) fn entry_of<'e>(entries: &'e [LeafEntry], leaf: &Node) -> Option<&'e LeafEntry> {
    let named = |name: &str| entries.iter().find(|entry| entry.leaf.value == name);
    named(leaf.process()).or_else(|| named(leaf.type_id()))
}

pub(super) fn read_leaves(root: Table<'_>) -> Vec<LeafEntry> {
    let about = "Settings of the tree's leaves that differ from the defaults.";
    let Some(table) = root.table("leaves").about(about).optional() else { return Vec::new() };
    let entry = |(name, span): (&str, &Span)| {
        let about = "A leaf of the tree, by the name of its process; or all leaves with this ID that have no entry by their names.";
        let entry = table.table(name).about(about).rules(one_form).named_after(Referent::Leaf).optional()?;
        let leaf = Spanned { value: name.to_owned(), span: span.clone() };
        let machine = entry
            .text("machine")
            .about("The file of the leaf's machine, in the folder `skills`. If not given, `NAME.scxml` or `ID.scxml`.");
        let machine = machine.refers_to(Referent::Machine).spanned().optional();
        let asking = Asking::read(entry);
        report_two_forms(entry);
        let data = read_data(entry, "The initial value of `<data id=\"ID\">`.");
        Some(LeafEntry { leaf, machine, asking, data })
    };
    table.names("NAME").filter_map(entry).collect()
}

fn report_two_forms(entry: Table<'_>) {
    let mut given = entry.keys().filter(|(key, _)| FORMS.contains(key));
    if let (Some((first, _)), Some((second, span))) = (given.next(), given.next()) {
        let problem = span.problem(format!("a leaf has either `{first}` or `{second}`"));
        entry.report(problem.with_label("this is the second one").with_help("leave out one of them"));
    }
}
