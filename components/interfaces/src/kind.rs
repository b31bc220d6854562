//! The values that a field may hold, as written in a file.

use channels::{FieldKind, Symbol};
use diagnostics::document::Item;
use diagnostics::{Problem, did_you_mean};

use crate::name::is_symbol;

/// The kinds that have names, each with its meaning.
pub const KINDS: [(&str, &str); 5] = [
    ("bool", "`true` or `false`"),
    ("int", "a 64-bit integer"),
    ("real", "a number"),
    ("text", "a string"),
    ("place", "one of the scenario's places, as a symbol"),
];

/// Makes a kind optional: follows its name, or is the last item of a list.
const OPTIONAL: &str = "?";

/// Makes a kind that of the items of a list: follows its name.
const LIST: &str = "[]";

/// The kind that an item of a file names.
pub(crate) fn read(item: &Item<'_>, places: &[Symbol]) -> Result<FieldKind, Vec<Problem>> {
    if let Some(name) = item.as_text() {
        return named(name, item, places).map_err(|problem| vec![problem]);
    }
    let Some(items) = item.as_array() else {
        return Err(vec![item.wrong("a kind, such as \"real\", or a list of symbols, such as [\"open\", \"closed\"]")]);
    };
    listed(item, &items)
}

fn named(text: &str, item: &Item<'_>, places: &[Symbol]) -> Result<FieldKind, Problem> {
    let (suffix, wrap): (_, fn(Box<FieldKind>) -> FieldKind) =
        if text.ends_with(LIST) { (LIST, FieldKind::List) } else { (OPTIONAL, FieldKind::Optional) };
    let wrapped = text.strip_suffix(suffix);
    let name = wrapped.unwrap_or(text);
    let kind = match name {
        "bool" => FieldKind::Bool,
        "int" => FieldKind::Int,
        "real" => FieldKind::Real,
        "text" => FieldKind::Text,
        "place" if places.is_empty() => {
            let problem = item.span().problem("`place` is one of the scenario's places, but the scenario has none");
            return Err(problem
                .with_label("this kind")
                .with_help("give the scenario a file of `places`, or list the symbols: `[\"Kitchen\", \"Dock\"]`"));
        }
        "place" => FieldKind::Symbol(places.to_vec()),
        _ => {
            let names = KINDS.map(|(name, _)| name);
            let problem = item.span().problem(format!("unknown kind `{name}`")).with_label("not a kind");
            let all = "bool, int, real, text, place; with `?` at the end if it may be missing, with `[]` for a list of \
                       them; or symbols, such as [\"open\", \"closed\"]";
            return Err(problem.with_help(did_you_mean(name, names).unwrap_or_else(|| all.to_owned())));
        }
    };
    Ok(if wrapped.is_some() { wrap(Box::new(kind)) } else { kind })
}

/// The symbols that an item of a file lists: what a text of a ROS definition can be.
pub(crate) fn read_symbols(item: &Item<'_>) -> Result<FieldKind, Vec<Problem>> {
    let Some(items) = item.as_array() else {
        return Err(vec![item.wrong("a list of symbols, such as [\"open\", \"closed\"]")]);
    };
    match listed(item, &items)? {
        FieldKind::Optional(_) => {
            Err(vec![item.wrong("a list of symbols without \"?\": the definition determines what may be missing")])
        }
        symbols => Ok(symbols),
    }
}

/// An item of a list of symbols, if it may follow the items before it.
fn symbol(item: &Item<'_>, before: &[Symbol], is_optional: bool) -> Result<Symbol, Problem> {
    let name = item.as_text().ok_or_else(|| item.wrong("a symbol, as a string"))?;
    if !is_symbol(name) {
        let problem = item.span().problem(format!("`{name}` is not a symbol")).with_label("here");
        return Err(problem.with_help("a symbol consists of letters, digits, `_` and `-`"));
    }
    if before.iter().any(|symbol| symbol.name() == name) {
        return Err(item.span().problem(format!("`{name}` is already in the list")).with_label("again"));
    }
    if name == FieldKind::NONE && is_optional {
        let problem = item.span().problem("an optional field without a value holds `none`");
        return Err(problem.with_label("here").with_help("leave out `none`, or the `?`"));
    }
    Ok(Symbol::new(name))
}

fn listed(list: &Item<'_>, items: &[Item<'_>]) -> Result<FieldKind, Vec<Problem>> {
    let (items, is_optional) = match items.split_last() {
        Some((last, others)) if last.as_text() == Some(OPTIONAL) => (others, true),
        _ => (items, false),
    };
    let (mut symbols, mut problems) = (Vec::new(), Vec::new());
    for item in items {
        match symbol(item, &symbols, is_optional) {
            Ok(symbol) => symbols.push(symbol),
            Err(problem) => problems.push(problem),
        }
    }
    if items.is_empty() {
        problems.push(list.span().problem("a list of symbols needs at least one item").with_label("this has none"));
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let kind = FieldKind::Symbol(symbols);
    Ok(if is_optional { FieldKind::Optional(Box::new(kind)) } else { kind })
}
