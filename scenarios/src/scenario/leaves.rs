//! The settings for a tree's leaves in a scenario: its table `leaves`.

use diagnostics::document::{Item, Table};
use diagnostics::{Span, Spanned};
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
pub(super) fn read_leaves(table: Table<'_>) -> Vec<LeafEntry> {
    let entry = |(name, span): (&str, &Span)| {
        let entry = table.table(name).optional()?;
        let leaf = Spanned { value: name.to_owned(), span: span.clone() };
        let machine = entry.text("machine").spanned().optional();
        let data = entry.table("data").optional().map_or_else(Vec::new, read_data);
        Some(LeafEntry { leaf, machine, data })
    };
    table.keys().filter_map(entry).collect()
}

pub(super) fn read_data(table: Table<'_>) -> Data {
    let value = |(name, span): (&str, &Span)| {
        let item = table.get::<Item<'_>>(name).optional()?;
        let value = datum(&item);
        if value.is_none() {
            // The numbers of machines are those of ECMAScript.
            let wanted = if item.as_integer().is_some() {
                "an integer that a machine's numbers represent exactly, such as 9007199254740992"
            } else {
                "a string, a number, true or false"
            };
            table.report(item.wrong(wanted));
        }
        Some((Spanned { value: name.to_owned(), span: span.clone() }, value?))
    };
    table.keys().filter_map(value).collect()
}

/// A text, a number, true or false. An integer that would be rounded is none of them.
pub(super) fn datum(item: &Item<'_>) -> Option<Datum> {
    let is_exact = |number: &f64| item.as_integer().is_none_or(|integer| *number as i128 == i128::from(integer));
    let number = || item.as_number().filter(|number| number.is_finite()).filter(is_exact).map(Datum::from);
    item.as_text().map(Datum::from).or_else(|| item.as_boolean().map(Datum::from)).or_else(number)
}
