//! What the tree expects of fields that hold one of several symbols.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use bt::{Direction, Tree};
use channels::{FieldKind, Possible, Symbol};
use diagnostics::Problem;

use super::Asking;
use crate::scenario::component::Component;
use crate::scenario::leaves::{LeafEntry, entry_of};
use crate::scenario::offer::{Offer, OfferMessage};

/// Warns of scripts and Switches of the tree that compare such a field, which an entry has written to a port, with
/// texts that are none of its symbols.
pub(in crate::scenario) fn never_equal(
    tree: &Tree,
    leaves: &[LeafEntry],
    components: &BTreeMap<String, Component>,
) -> Vec<Problem> {
    let (mut outputs, mut words, mut symbols) = (BTreeMap::new(), Vec::new(), Vec::new());
    for leaf in tree.leaves() {
        let asking = entry_of(leaves, leaf).and_then(|entry| entry.asking.as_ref());
        for port in tree.ports(leaf.id()).filter(|port| port.direction != Direction::Input) {
            let mut value = Possible::anything();
            if let Some((field, all)) = asking.and_then(|asking| asking.symbols_of(port.name, components)) {
                value = Possible::choice(symbols.len());
                words.push(field);
                symbols.push(all);
            }
            outputs.insert((leaf.process().to_owned(), port.name.to_owned()), value);
        }
    }
    if symbols.is_empty() { Vec::new() } else { tree.never_equal(&outputs, &words, &symbols) }
}

impl Asking {
    /// The field that is written to this port, in words, and its symbols, if it holds one.
    fn symbols_of(&self, port: &str, components: &BTreeMap<String, Component>) -> Option<(String, BTreeSet<Arc<str>>)> {
        let component = &self.asked.component.value;
        let offers = Offer::all(&components.get(component)?.interface);
        let offer = offers.iter().find(|offer| offer.of == self.of && offer.name == self.asked.name.value)?;
        let answers = self.outputs.iter().map(|written| (OfferMessage::Answer, written));
        let mut written = answers.chain(self.feedback.iter().map(|written| (OfferMessage::Feedback, written)));
        let (of, written) = written.find(|(_, written)| written.port.value == port)?;
        let (name, kind) = offer.fields(of).find(|(name, _)| *name == written.field.value)?;
        let kind = if let FieldKind::Optional(kind) = kind { kind } else { kind };
        let FieldKind::Symbol(symbols) = kind else { return None };
        let symbols = symbols.iter().map(Symbol::name).map(Arc::from);
        Some((format!("`{name}` of {component}"), symbols.collect()))
    }
}
