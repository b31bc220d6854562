//! Words and names of property files, and what their properties mean.

use std::collections::BTreeMap;
use std::ops::Range;

use monitors::syntax::{Constant, Item, parse_file};
use monitors::{OPERATORS, Operator, explain};

use crate::knowledge::{Knowledge, KnownField};
use crate::proposal::{Explanation, Proposal, ProposalKind};
use crate::scope_place::{ScopePlace, place};

/// What may be written at a place of a property file.
pub(crate) fn proposals(text: &str, at: usize, known: &Knowledge) -> Vec<Proposal> {
    let Some((place, word)) = place(text, at) else { return Vec::new() };
    let of_names = |names: BTreeMap<String, String>| {
        names.into_iter().map(|(name, what)| Proposal::new(name, ProposalKind::Name, what, &word)).collect::<Vec<_>>()
    };
    match place {
        ScopePlace::Word { is_first } => {
            let mut found = if is_first { of_names(known.processes()) } else { Vec::new() };
            found.extend(words(&word));
            found
        }
        ScopePlace::Receiver { sender } => of_names(known.receivers(&sender)),
        ScopePlace::Condition { sender, receiver, is_field } => {
            let field = |field: KnownField| {
                Proposal::new(field.name, ProposalKind::Name, format!("m[{}]", field.number), &word)
            };
            let mut found: Vec<_> = known.fields(&sender, &receiver).into_iter().map(field).collect();
            if is_field {
                return found;
            }
            found.extend(of_names(constants(text)));
            found.extend(words(&word));
            found
        }
        ScopePlace::Symbol { sender, receiver } => {
            let fields = known.fields(&sender, &receiver).into_iter();
            let symbols =
                fields.flat_map(|field| field.symbols.into_iter().map(move |symbol| (symbol, field.name.clone())));
            of_names(symbols.collect())
        }
    }
}

/// The constants of a file, as far as it can be read, with their values.
fn constants(text: &str) -> BTreeMap<String, String> {
    let constant = |item: Item| match item {
        Item::Constant(Constant { name, value_span, .. }) => {
            Some((name.text, text.get(value_span.start..value_span.end)?.to_owned()))
        }
        Item::Property(_) => None,
    };
    parse_file(text).file.items.into_iter().filter_map(constant).collect()
}

/// The words of the language.
fn words(replaces: &Range<usize>) -> impl Iterator<Item = Proposal> {
    let is_word = |operator: &&Operator| operator.written.starts_with(char::is_alphabetic);
    OPERATORS.iter().filter(is_word).map(|operator| {
        let word = operator.written.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default();
        let about = format!("{}\n\n```\n{}\n```", operator.about, operator.example);
        Proposal { about, ..Proposal::new(word, ProposalKind::Keyword, operator.signs, replaces) }
    })
}

/// What the property, the operator or the process at a place means.
pub(crate) fn explanation(text: &str, at: usize, known: &Knowledge) -> Option<Explanation> {
    let (_, range) = place(text, at)?;
    let word = text.get(range.clone()).filter(|word| !word.is_empty())?;
    let is_property = |item: &Item| matches!(item, Item::Property(property) if property.name.span.start <= at && at <= property.name.span.end);
    if parse_file(text).file.items.iter().any(is_property) {
        let explained = known.systems.iter().find_map(|system| {
            let file = system.read("", text).ok()?;
            let property = file.properties.into_iter().find(|property| property.name == word)?;
            let monitor = property.scope_monitor()?;
            Some(explain(monitor.formula(), monitor.topology()))
        })?;
        return Some(Explanation { range, text: explained });
    }
    let operator = OPERATORS
        .iter()
        .find(|operator| operator.written.split(|c: char| !c.is_alphanumeric() && c != '_').any(|part| part == word));
    let about = operator.map(|operator| format!("{}\n\n```\n{}\n```", operator.about, operator.example));
    let named = || constants(text).remove(word).or_else(|| known.processes().remove(word));
    let text = about.or_else(|| Some(format!("`{word}`: {}", named()?)))?;
    Some(Explanation { range, text })
}
