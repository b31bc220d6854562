//! The names of the scenarios to which a file belongs.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use bt::Tree;
use channels::{FieldKind, Topology};
use checks::System;
use diagnostics::document::Referent;
use maps::Place;
use monitors::syntax::{Item, parse_file};
use runs::topology_for_properties;
use scenarios::faults::Parameter;
use scenarios::scenario::{BehaviorEntry, Scenario, ScenarioFile, Skill};
use skills::Vocabulary;

use crate::project::FileContext;
use crate::toml_keys::is_chosen;

/// What the scenarios of a file define.
#[derive(Clone, Debug, Default)]
pub(crate) struct Knowledge {
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

    pub(crate) fn places(&self) -> impl Iterator<Item = &str> {
        let premises = self.scenarios.iter().filter_map(|scenario| scenario.premises.as_ref());
        premises.flat_map(|premises| premises.places.iter().map(|(name, _)| name))
    }

    /// The messages of the machine in this file: of the processes that run it or, if there are none, of any leaf.
    pub(crate) fn vocabulary(&self, file: &Path) -> Vocabulary {
        let of = |is_wanted: &dyn Fn(&Scenario, &str, &Skill) -> bool| {
            let mut all = Vocabulary::default();
            for scenario in &self.scenarios {
                let Some(topology) = scenario.possible_channels() else { continue };
                let machines =
                    scenario.machine_processes().filter(|(process, skill)| is_wanted(scenario, process, skill));
                for process in machines.filter_map(|(process, _)| topology.find_process(process)) {
                    let Vocabulary { received, sent } = Vocabulary::of(&topology, process);
                    all.received.extend(received);
                    all.sent.extend(sent);
                }
            }
            all
        };
        // Its path may be relative to the folder of the scenario, or to that of a base.
        let is_down = |part: &Component<'_>| !matches!(part, Component::ParentDir | Component::CurDir);
        let own = of(&|_, _, skill| file.ends_with(skill.path.components().filter(is_down).collect::<PathBuf>()));
        if own == Vocabulary::default() {
            of(&|scenario, process, _| scenario.skills.contains_key(process))
        } else {
            own
        }
    }

    /// The folders of the leaves' machines, as a scenario in this folder names them.
    pub(crate) fn skill_folders(&self, beside: &Path) -> BTreeSet<PathBuf> {
        let files = self.scenarios.iter().filter_map(|scenario| match &scenario.file.behavior {
            BehaviorEntry::Files(files) => Some(files),
            BehaviorEntry::Model(_) => None,
        });
        files.map(|files| beside.join(&files.skills.value)).collect()
    }

    /// What a text may stand for, each name with what it is.
    pub(crate) fn named(&self, what: Referent) -> BTreeMap<String, String> {
        let scenarios = || self.scenarios.iter();
        let premises = || scenarios().filter_map(|scenario| scenario.premises.as_ref());
        let all = |names: &mut dyn Iterator<Item = &str>, what: &str| {
            names.map(|name| (name.to_owned(), what.to_owned())).collect::<BTreeMap<_, _>>()
        };
        match what {
            Referent::Process => self.processes(),
            Referent::Component => all(&mut scenarios().flat_map(|scenario| scenario.component_names()), "a component"),
            Referent::Leaf => all(&mut self.trees().flat_map(Tree::leaves).map(|leaf| leaf.process()), "a leaf"),
            Referent::LeafState => self.leaves(|name, skill| {
                let ids = skill.machine.states().map(|state| skill.machine.state(state).id());
                ids.map(|id| (format!("{name}.{id}"), "a state".to_owned())).collect()
            }),
            Referent::Mutant => self.leaves(|name, skill| {
                let text = skill.machine.file().text();
                let mistakes = skills::mutations(name, text).unwrap_or_default().into_iter();
                mistakes.map(|mistake| (format!("{name}: {mistake}"), String::new())).collect()
            }),
            Referent::Offer(wanted) => {
                let offers = scenarios().flat_map(|scenario| scenario.offers());
                let offers = offers.filter(|(_, offer)| offer.noun() == wanted);
                offers.map(|(name, offer)| (name, format!("a {}", offer.noun()))).collect()
            }
            Referent::Property => self.properties(),
            Referent::Place => all(&mut self.places(), "a place"),
            Referent::Point => {
                let places = premises().flat_map(|premises| premises.places.iter());
                let points = places.filter(|(_, place)| matches!(place, Place::Point { .. }));
                all(&mut points.map(|(name, _)| name), "a point")
            }
            Referent::Zone => {
                let zones = premises().flat_map(|premises| premises.places.zones());
                all(&mut zones.map(|zone| zone.name.as_str()), "a zone")
            }
            Referent::Door => all(&mut premises().flat_map(|premises| premises.entry.doors()), "a door"),
            Referent::Person => all(&mut premises().flat_map(|premises| premises.entry.people()), "a person"),
            Referent::Laser => {
                let lasers = premises().flat_map(|premises| &premises.entry.sim.model.lasers);
                all(&mut lasers.map(|laser| laser.name.as_str()), "a laser")
            }
            Referent::Setting => {
                let keys = ScenarioFile::keys().iter().filter(|key| !key.path.split('.').any(is_chosen));
                let keys = keys.map(|key| (key.path.replace("[]", ".0"), key.accepts()));
                keys.chain(scenarios().flat_map(|scenario| settings_of(scenario))).collect()
            }
            Referent::MessageType => {
                bags::messages_on_board().into_iter().map(|name| (name, "a message of ROS 2".to_owned())).collect()
            }
            // These are more than names, or depend on their place.
            Referent::Scenario
            | Referent::File(_)
            | Referent::Places
            | Referent::Interface
            | Referent::Machine
            | Referent::Event
            | Referent::Own(_) => BTreeMap::new(),
        }
    }

    fn leaves(&self, of: impl Fn(&str, &Skill) -> Vec<(String, String)>) -> BTreeMap<String, String> {
        self.scenarios.iter().flat_map(|scenario| &scenario.skills).flat_map(|(name, skill)| of(name, skill)).collect()
    }

    fn properties(&self) -> BTreeMap<String, String> {
        let of_text = |text: &str| {
            let items = parse_file(text).file.items.into_iter();
            items.filter_map(|item| match item {
                Item::Property(property) => Some((property.name.text, "a property".to_owned())),
                Item::Constant(_) => None,
            })
        };
        let texts = self.scenarios.iter().flat_map(|scenario| &scenario.properties).map(|(_, text)| text);
        texts.flat_map(|text| of_text(text)).collect()
    }
}

/// The keys that a scenario has because of what it contains: those of each fault, and the data of its machines.
fn settings_of(scenario: &Scenario) -> impl Iterator<Item = (String, String)> {
    let faults = scenario.file.faults.iter().enumerate().flat_map(|(place, fault)| {
        let every = ScenarioFile::keys().iter();
        let every = every.filter_map(|key| Some((key.path.strip_prefix("faults[].")?.to_owned(), key.accepts())));
        let own = fault.kind().parameters.iter().map(Parameter::key).map(|key| (key.path.clone(), key.accepts()));
        every.chain(own).map(move |(path, takes)| (format!("faults.{place}.{path}"), takes))
    });
    let data = scenario.machine_processes().flat_map(|(name, skill)| {
        let table = if scenario.skills.contains_key(name) { "leaves" } else { "components" };
        let ids = skill.machine.parameters();
        ids.map(move |id| (format!("{table}.{name}.data.{id}"), "an initial value".to_owned()))
    });
    faults.chain(data)
}
