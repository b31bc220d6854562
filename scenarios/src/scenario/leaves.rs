//! The settings for a tree's leaves in a scenario: its table `leaves`.

use diagnostics::document::{Item, Table};
use diagnostics::{Span, Spanned};
use serde_json::{Value, json};
use skills::Datum;

/// Initial values of a machine's data, by datum id.
pub(crate) type Data = Vec<(Spanned<String>, Datum)>;

/// The settings for a leaf: an entry of the table `leaves`.
#[derive(Clone, Debug)]
pub struct LeafEntry {
    /// The name of the leaf's process.
    pub leaf: Spanned<String>,
    /// The file of its machine, in the folder of the skills.
    pub machine: Option<Spanned<String>>,
    /// The initial values of the machine's data.
    pub data: Data,
}

/// Whether two scenarios have the same settings for all leaves.
pub(super) fn same_entries(these: &[LeafEntry], those: &[LeafEntry]) -> bool {
    let settings = |entry: &LeafEntry| {
        let data: Vec<(String, Datum)> =
            entry.data.iter().map(|(id, value)| (id.value.clone(), value.clone())).collect();
        (entry.leaf.value.clone(), entry.machine.as_ref().map(|machine| machine.value.clone()), data)
    };
    these.iter().map(settings).eq(those.iter().map(settings))
}

/// Reads the table `leaves`.
pub(super) fn read_leaves(root: Table<'_>) -> Vec<LeafEntry> {
    let about = "Settings of the tree's leaves that differ from the defaults.";
    let Some(table) = root.table("leaves").about(about).optional() else { return Vec::new() };
    let entry = |(name, span): (&str, &Span)| {
        let entry = table.table(name).about("A leaf of the tree, by the name of its process.").optional()?;
        let leaf = Spanned { value: name.to_owned(), span: span.clone() };
        let machine = entry
            .text("machine")
            .about("The file of the leaf's machine, in the folder `skills`. If not given, `NAME.scxml` or `ID.scxml`.");
        let machine = machine.spanned().optional();
        let data = read_data(entry, "The initial value of `<data id=\"ID\">`.");
        Some(LeafEntry { leaf, machine, data })
    };
    table.names("NAME").filter_map(entry).collect()
}

/// Reads an entry's table `data`; `about` is the meaning of each of its keys.
pub(super) fn read_data(entry: Table<'_>, about: &str) -> Data {
    let table = entry.table("data").about("Initial values of the machine's data.").optional();
    let Some(table) = table else { return Vec::new() };
    let value = |(name, span): (&str, &Span)| {
        let item = table.get::<Item<'_>>(name).about(about).rules(scalar).optional()?;
        let value = datum(&item);
        if value.is_none() {
            // The numbers of machines are those of ECMAScript.
            let wanted = if item.as_integer().is_some() {
                "an integer that a machine's numbers represent exactly, such as 9007199254740991"
            } else {
                "a string, a number, true or false"
            };
            table.report(item.wrong(wanted));
        }
        Some((Spanned { value: name.to_owned(), span: span.clone() }, value?))
    };
    table.names("ID").filter_map(value).collect()
}

/// What [`datum`] reads, as JSON Schema.
pub(super) fn scalar() -> Value {
    json!({ "title": "a string, a number, true or false", "type": ["string", "number", "boolean"] })
}

/// A text, a number, true or false. An integer that would be rounded is none of them.
pub(super) fn datum(item: &Item<'_>) -> Option<Datum> {
    let is_exact = |number: &f64| item.as_integer().is_none_or(|integer| *number as i128 == i128::from(integer));
    let number = || item.as_number().filter(|number| number.is_finite()).filter(is_exact).map(Datum::from);
    item.as_text().map(Datum::from).or_else(|| item.as_boolean().map(Datum::from)).or_else(number)
}
