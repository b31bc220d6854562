//! The names of the scenarios to which a file belongs.

use std::collections::BTreeMap;
use std::sync::Arc;

use bt::Tree;
use channels::{FieldKind, Topology};
use runs::topology_for_properties;
use scenarios::scenario::Scenario;

use crate::project::FileContext;
use crate::proposal::ProposalKind;
use crate::system::System;

/// What the scenarios of a file define.
#[derive(Clone, Debug, Default)]
pub(crate) struct Knowledge {
    /// The scenarios.
    pub(crate) scenarios: Vec<Arc<Scenario>>,
    /// Their systems, and those of mappings.
    pub(crate) systems: Vec<System>,
}

/// A field of the messages between two processes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct KnownField {
    pub(crate) name: String,
    /// Its number, from 1.
    pub(crate) number: usize,
    /// The symbols that it may have.
    pub(crate) symbols: Vec<String>,
}

impl Knowledge {
    pub(crate) fn of(FileContext { scenarios, mapped, .. }: &FileContext) -> Self {
        let of_scenario = |scenario: &Arc<Scenario>| {
            Some(System::new(topology_for_properties(scenario).ok()?, scenario.file.execution.tick))
        };
        let systems = scenarios.iter().filter_map(of_scenario).chain(mapped.iter().cloned()).collect();
        Self { scenarios: scenarios.clone(), systems }
    }

    fn topologies(&self) -> impl Iterator<Item = &Topology> {
        self.systems.iter().map(|system| &*system.topology)
    }

    /// The trees.
    pub(crate) fn trees(&self) -> impl Iterator<Item = &Tree> {
        self.scenarios.iter().filter_map(|scenario| scenario.tree().map(AsRef::as_ref))
    }

    /// Each process, with what it is.
    pub(crate) fn processes(&self) -> BTreeMap<String, String> {
        let mut found = BTreeMap::new();
        for topology in self.topologies() {
            let outside = |process| if topology.is_outside(process) { "outside the scenario" } else { "a process" };
            found.extend(
                topology.processes().map(|process| (topology.name(process).to_owned(), outside(process).to_owned())),
            );
        }
        for scenario in &self.scenarios {
            found.extend(scenario.component_names().map(|name| (name.to_owned(), "a component".to_owned())));
        }
        found.extend(self.trees().flat_map(Tree::leaves).map(|leaf| (leaf.process().to_owned(), "a leaf".to_owned())));
        found
    }

    /// The processes to which one sends; all of them for `*` and for one that is not known.
    pub(crate) fn receivers(&self, sender: &str) -> BTreeMap<String, String> {
        let mut processes = self.processes();
        let ends: Vec<_> = self.ends().collect();
        if ends.iter().any(|(source, _)| *source == sender) {
            processes.retain(|name, _| ends.contains(&(sender, name.as_str())));
        }
        processes
    }

    fn ends(&self) -> impl Iterator<Item = (&str, &str)> {
        self.topologies().flat_map(|topology| topology.channels().map(|channel| topology.ends(channel)))
    }

    /// The fields of the messages between two processes, `*` for any.
    pub(crate) fn fields(&self, sender: &str, receiver: &str) -> Vec<KnownField> {
        let is = |wanted: &str, name: &str| wanted == "*" || wanted == name;
        let mut fields: Vec<KnownField> = Vec::new();
        for topology in self.topologies() {
            let channels = topology.channels().filter(|channel| {
                let (source, target) = topology.ends(*channel);
                is(sender, source) && is(receiver, target)
            });
            let shapes = channels.flat_map(|channel| topology.get(channel).domain.shapes());
            for (place, (name, kind)) in shapes.flat_map(|shape| shape.fields().iter().enumerate()) {
                let symbols = if let FieldKind::Symbol(symbols) = kind { symbols.as_slice() } else { &[] };
                let symbols = symbols.iter().map(|symbol| symbol.name().to_owned());
                match fields.iter_mut().find(|field| field.name == *name && field.number == place + 1) {
                    Some(known) => known.symbols.extend(symbols),
                    None => {
                        fields.push(KnownField { name: name.clone(), number: place + 1, symbols: symbols.collect() })
                    }
                }
            }
        }
        for field in &mut fields {
            field.symbols.sort();
            field.symbols.dedup();
        }
        fields
    }

    /// The places.
    pub(crate) fn places(&self) -> impl Iterator<Item = &str> {
        let premises = self.scenarios.iter().filter_map(|scenario| scenario.premises.as_ref());
        premises.flat_map(|premises| premises.places.iter().map(|(name, _)| name))
    }

    /// All names, each with what it is.
    pub(crate) fn names(&self) -> Vec<(String, ProposalKind, String)> {
        let processes = self.processes().into_iter();
        let mut names: Vec<_> = processes.map(|(name, what)| (name, ProposalKind::Name, what)).collect();
        names.extend(self.places().map(|name| (name.to_owned(), ProposalKind::Name, "a place".to_owned())));
        for (file, text) in self.scenarios.iter().flat_map(|scenario| &scenario.properties) {
            names.push((file.clone(), ProposalKind::File, "a property file".to_owned()));
            let items = monitors::syntax::parse_file(text).file.items.into_iter();
            names.extend(items.filter_map(|item| match item {
                monitors::syntax::Item::Property(property) => {
                    Some((property.name.text, ProposalKind::Name, "a property".to_owned()))
                }
                monitors::syntax::Item::Constant(_) => None,
            }));
        }
        names.sort_by(|one, other| one.0.cmp(&other.0));
        names.dedup_by(|one, other| one.0 == other.0);
        names
    }
}
