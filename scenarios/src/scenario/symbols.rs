//! What the tree expects of fields that hold one of several symbols.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use bt::{Direction, Tree};
use channels::{FieldKind, Possible, Symbol};
use diagnostics::Problem;

use super::component::Component;
use super::leaves::{LeafEntry, entry_of};
use super::offer::Offer;

/// Warns of scripts and Switches of the tree that compare such a field, which an entry has written to a port, with
/// texts that are none of its symbols.
pub(super) fn never_equal(tree: &Tree, leaves: &[LeafEntry], components: &BTreeMap<String, Component>) -> Vec<Problem> {
    let offers = components.iter().map(|(name, component)| (name.as_str(), Offer::all(&component.interface)));
    let offers: Vec<_> = offers.collect();
    let (mut outputs, mut words, mut symbols) = (BTreeMap::new(), Vec::new(), Vec::new());
    for leaf in tree.leaves() {
        let asking = entry_of(leaves, leaf).and_then(|entry| entry.asking.as_ref());
        for port in tree.ports(leaf.id()).filter(|port| port.direction != Direction::Input) {
            let mut value = Possible::anything();
            let written = asking.and_then(|asking| asking.written_to(port.name, &offers));
            if let Some((field, FieldKind::Symbol(all))) = written {
                value = Possible::choice(symbols.len());
                words.push(field);
                symbols.push(all.iter().map(Symbol::name).map(Arc::from).collect::<BTreeSet<Arc<str>>>());
            }
            outputs.insert((leaf.process().to_owned(), port.name.to_owned()), value);
        }
    }
    if symbols.is_empty() { Vec::new() } else { tree.never_equal(&outputs, &words, &symbols) }
}
