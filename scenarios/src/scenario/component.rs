//! Components from files, loaded.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use channels::Symbol;
use devices::{DeviceKind, DeviceSettings};
use diagnostics::{Problem, Span, Spanned};
use interfaces::Interface;
use maps::Places;
use monitors::{MONITORS, WORLD};
use programs::{Limits, Program, Word};
use recording::TREE;
use remote::RemoteComponent;
use skills::Datum;

use super::component_entry::{ComponentEntry, RunsEntry};
use super::data::Data;
use super::file_reader::{FileReader, FileRole, unreadable};
use super::stand_in::{Listeners, Samples, StandIns};
use super::world::{doors, people};
use super::{ScenarioFile, Skill};
use crate::files::{Kind, named};
use crate::names::unknown;
use crate::processes::{BUILTIN, SUBSCRIBER, TICK_GENERATOR};

/// A component from files, ready to be run.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Its services, topics and actions.
    pub interface: Interface,
    /// What it runs.
    pub runs: Runs,
}

/// What a component runs.
#[derive(Clone, Debug, PartialEq)]
pub enum Runs {
    /// A machine.
    Machine(Skill),
    /// A program.
    Program {
        /// The program.
        program: Arc<Program>,
        /// The data that it receives when it starts.
        data: Datum,
        /// The components that it asks, or whose topics it reads.
        asks: Vec<String>,
    },
    /// Nodes of ROS 2.
    Remote(Arc<RemoteComponent>),
    /// A device of the world.
    Device(DeviceSettings),
}

impl Component {
    /// Its machine, if it runs one.
    #[must_use]
    pub fn machine(&self) -> Option<&Skill> {
        match &self.runs {
            Runs::Machine(machine) => Some(machine),
            Runs::Program { .. } | Runs::Remote(_) | Runs::Device(_) => None,
        }
    }
}

impl FileReader<'_> {
    /// The components that the scenario describes, by name; `None` after reporting problems. These places are the
    /// values of fields of the kind `place`, and `listeners` may receive their messages.
    pub(super) fn components(
        &mut self,
        file: &ScenarioFile,
        places: &Places,
        listeners: &Listeners<'_>,
    ) -> Option<(BTreeMap<String, Component>, Samples)> {
        let places: Vec<Symbol> = places.iter().map(|(name, _)| Symbol::new(name)).collect();
        let mut interfaces: BTreeMap<&str, Interface> = BTreeMap::new();
        for entry in &file.components {
            if let Some(interface) = self.interface(entry, &places) {
                interfaces.insert(&entry.name.value, interface);
            }
        }
        let mut components: BTreeMap<String, Component> = BTreeMap::new();
        // What answers anything answers what the others distinguish, so it comes last.
        let answers_anything = |entry: &&ComponentEntry| matches!(entry.runs, RunsEntry::Anything { .. });
        let (last, first): (Vec<_>, Vec<_>) = file.components.iter().partition(answers_anything);
        for entry in first {
            let name = &entry.name.value;
            let runs = match &entry.runs {
                RunsEntry::Anything { .. } => None,
                RunsEntry::Machine(path) => self.component_machine(path, &entry.data).map(Runs::Machine),
                RunsEntry::Program { command, limits, asks } => {
                    self.check_asked(file, asks);
                    self.program(command, *limits, &entry.data, asks)
                }
                RunsEntry::Remote { namespace } => {
                    let interface = interfaces.get(name.as_str());
                    interface.and_then(|interface| self.remote(namespace, interface)).map(Runs::Remote)
                }
                RunsEntry::Device { settings, names } => {
                    self.check_device(file, settings, names);
                    Some(Runs::Device(settings.value.clone()))
                }
            };
            if let (Some(interface), Some(runs)) = (interfaces.get(name.as_str()), runs) {
                components.insert(name.clone(), Component { interface: interface.clone(), runs });
            }
        }
        let samples = self.stand_ins(&last, &interfaces, listeners, file.execution.tick, &mut components);
        self.check_names(file, &components);
        // If some are missing, others would seem not to fit together.
        (components.len() == file.components.len()).then_some((components, samples))
    }

    /// Adds the components that answer anything, which are these entries.
    fn stand_ins(
        &mut self,
        entries: &[&ComponentEntry],
        interfaces: &BTreeMap<&str, Interface>,
        listeners: &Listeners<'_>,
        tick: Duration,
        components: &mut BTreeMap<String, Component>,
    ) -> Samples {
        let mut samples = Samples::default();
        if entries.is_empty() {
            return samples;
        }
        let names: BTreeSet<&str> = entries.iter().map(|entry| entry.name.value.as_str()).collect();
        let mut made = Vec::new();
        let machines = components.iter().filter_map(|(name, component)| Some((name, component.machine()?)));
        match StandIns::new(listeners, interfaces, &names, machines.collect()) {
            Ok(stand_ins) => {
                for entry in entries {
                    let RunsEntry::Anything { place, asks } = &entry.runs else { continue };
                    let name = &entry.name.value;
                    match stand_ins.machine((name, asks), tick.as_secs_f64(), &mut samples) {
                        Ok(machine) => made.push((name, Runs::Machine(machine))),
                        Err(why) => self.complaints.push(not_anything(name, place, why)),
                    }
                }
            }
            Err(problems) => problems.into_iter().for_each(|problem| self.complaints.push(problem)),
        }
        for (name, runs) in made {
            if let Some(interface) = interfaces.get(name.as_str()) {
                components.insert(name.clone(), Component { interface: interface.clone(), runs });
            }
        }
        samples
    }

    /// The interface of a component, if the component may have its name.
    fn interface(&mut self, entry: &ComponentEntry, places: &[Symbol]) -> Option<Interface> {
        let name = &entry.name;
        // Unlike these, the built-in components can be replaced: their names are free.
        if [TICK_GENERATOR, TREE, SUBSCRIBER, WORLD, MONITORS].contains(&name.value.as_str()) {
            let problem = name.span.problem(format!("a component cannot be named `{}`", name.value));
            let help = "that is the name of another process";
            self.complaints.push(problem.with_label("this component").with_help(help));
            return None;
        }
        match (&entry.interface, &entry.runs) {
            (_, RunsEntry::Device { settings, .. }) => Some(settings.value.kind().interface()),
            (None, _) => Some(entry.stands_for.map_or_else(Interface::default, DeviceKind::interface)),
            (Some(file), _) => {
                let interface =
                    self.files.load(&file.value, places.to_vec(), |read| Interface::load(&file.value, places, read));
                self.loaded(file, FileRole::Interface, interface)
            }
        }
    }

    /// A program. Files that it names and that come with steward are written to disk when it starts.
    fn program(
        &mut self,
        command: &Spanned<Vec<String>>,
        limits: Limits,
        data: &Data,
        asks: &[Spanned<String>],
    ) -> Option<Runs> {
        let word = |text: &String| {
            let path = named(text, &command.span);
            // Reading a file makes it one of the scenario's files, so that it counts in their fingerprint.
            match self.files.read(&path) {
                Err(error) if diagnostics::would_be_overwritten(&error) => {
                    self.complaints.push(unreadable(&command.span, FileRole::Program, &path, &error));
                    Word::Text(text.clone())
                }
                Ok(contents) if !path.is_absolute() && self.files.on_disk(&path).is_none() => {
                    Word::File { name: text.clone(), contents: contents.into() }
                }
                _ => Word::Text(text.clone()),
            }
        };
        let folder = self.files.working_folder(&command.span);
        let program = Program::new(command.value.iter().map(word).collect(), folder.as_deref(), limits);
        let placed =
            program.map_err(|problem| problem.of(command.span.source()).at(command.span.range(), "this command"));
        let data = Datum::object(data.iter().map(|(id, value)| (id.value.as_str(), value.clone())));
        Some(Runs::Program {
            program: self.complaints.note(placed)?.into(),
            // The values are numbers, strings and Booleans, as many as fit into the file.
            data: data.unwrap_or_default(),
            asks: asks.iter().map(|name| name.value.clone()).collect(),
        })
    }

    /// Nodes of ROS 2, of which everything must have a type there.
    fn remote(&mut self, namespace: &Spanned<String>, interface: &Interface) -> Option<Arc<RemoteComponent>> {
        let untyped = match RemoteComponent::new(&namespace.value, interface) {
            Ok(component) => return Some(Arc::new(component)),
            Err(untyped) => untyped,
        };
        for why in untyped {
            let problem = namespace.span.problem(why);
            let help =
                "give it a definition in a folder of its package: `ros = \"nav2_msgs/action/NavigateToPose.action\"`";
            self.complaints.push(problem.with_label("this component consists of nodes of ROS 2").with_help(help));
        }
        None
    }

    /// Reports components that would have one service or topic of ROS 2 with different types.
    fn check_names(&mut self, file: &ScenarioFile, components: &BTreeMap<String, Component>) {
        let mut known: BTreeMap<(bool, String), String> = BTreeMap::new();
        for entry in &file.components {
            let (RunsEntry::Remote { namespace }, Some(component)) = (&entry.runs, components.get(&entry.name.value))
            else {
                continue;
            };
            let Runs::Remote(remote) = &component.runs else { continue };
            let services = remote.services().map(|(name, kind)| ((true, name), kind));
            for ((is_service, name), kind) in services.chain(remote.topics().map(|(name, kind)| ((false, name), kind)))
            {
                let other = known.entry((is_service, name.clone())).or_insert_with(|| kind.clone());
                if *other != kind {
                    let problem = namespace.span.problem(format!("{name} would be both {other} and {kind}"));
                    let help = "give the components different namespaces, or the same definition";
                    self.complaints.push(problem.with_label("in this namespace").with_help(help));
                }
            }
        }
    }

    /// Reports a device that the scenario's world cannot have.
    fn check_device(&mut self, file: &ScenarioFile, device: &Spanned<DeviceSettings>, names: &[Spanned<String>]) {
        let kind = device.value.kind();
        let mut complain = |message: String, help: &str| {
            self.complaints.push(device.span.problem(message).with_label("this device").with_help(help));
        };
        let Some(premises) = &file.premises else {
            if kind.needs_robot() {
                complain(format!("a {} needs a world with a robot", kind.noun()), "give the scenario a `map`");
            }
            return;
        };
        if kind == DeviceKind::Door && names.is_empty() {
            complain("`door` is missing".to_owned(), "name one of the world's `[[doors]]`");
        }
        let (what, known): (_, Vec<&str>) = match kind {
            DeviceKind::Door => ("door", doors(&premises.world).collect()),
            _ => ("person", people(&premises.world).collect()),
        };
        for name in names.iter().filter(|name| !known.contains(&name.value.as_str())) {
            self.complaints.push(unknown(what, name, known.iter().copied()));
        }
    }

    /// Reports unknown components that a program asks.
    fn check_asked(&mut self, file: &ScenarioFile, asks: &[Spanned<String>]) {
        let own = || file.components.iter().map(|component| component.name.value.as_str());
        let known = || BUILTIN.into_iter().filter(|_| file.premises.is_some()).chain(own());
        for name in asks.iter().filter(|name| !known().any(|known| known == name.value)) {
            self.complaints.push(unknown("component", name, known()));
        }
    }

    fn component_machine(&mut self, path: &Spanned<PathBuf>, data: &Data) -> Option<Skill> {
        let text = self.text(&path.span, FileRole::Of(Kind::Skill), &path.value)?;
        let machine = self.chart(&path.value, &text)?;
        let mut skill = Skill { path: path.value.clone(), machine, place: None, data: BTreeMap::new() };
        skill.set_data(data).into_iter().for_each(|problem| self.complaints.push(problem));
        Some(skill)
    }
}

/// The problem of a component that cannot answer anything in a proof.
fn not_anything(name: &str, place: &Span, why: String) -> Problem {
    let problem = place.problem(format!("{name} cannot answer anything: {why}")).with_label("in a proof");
    let help =
        format!("write a machine that may do what it may do: `prove.components.{name}.machine = \"FILE.scxml\"`");
    problem.with_help(help)
}
