//! Values of machines' data in a scenario.

use diagnostics::document::{Item, Own, Referent, Table};
use diagnostics::{Span, Spanned};
use serde_json::{Value, json};
use skills::Datum;

/// Initial values of a machine's data, by datum id.
pub(crate) type Data = Vec<(Spanned<String>, Datum)>;

/// Reads an entry's table `data`; `about` is the meaning of each of its keys.
pub(super) fn read_data(entry: Table<'_>, about: &str) -> Data {
    let table = entry.table("data").about("Initial values of the machine's data.").optional();
    let Some(table) = table else { return Vec::new() };
    let value = |(name, span): (&str, &Span)| {
        let item =
            table.get::<Item<'_>>(name).about(about).rules(scalar).named_after(Referent::Own(Own::Datum)).optional()?;
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
