//! A model: the main file, and everything that it names.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use bt::{Loader, Tree};
use channels::Topology;
use diagnostics::xml::name_span;
use diagnostics::{FileProblems, Problem, Source, nearest_or_all};
use roxmltree::Node;

use crate::instance::{Instance, RESERVED, events, machine_processes};
use crate::machine::{Machine, is, parse, value_span};
use crate::property::{Property, PropertyMonitor};

/// The parameters of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// When a run ends.
    pub max_time: Duration,
    /// Time between two ticks of the tree.
    pub tick: Duration,
    /// Whether ticks continue after the tree has succeeded or failed.
    pub tick_if_not_running: bool,
}

/// A model: a tree, machines and properties, loaded and checked.
#[derive(Clone, Debug)]
pub struct Model {
    /// The name of its folder, or else of its file.
    pub name: String,
    /// Its parameters.
    pub parameters: Parameters,
    /// The behavior tree, if it has one.
    pub tree: Option<Arc<Tree>>,
    /// The ROS nodes, then the leaves of the tree.
    pub(crate) machines: Vec<Instance>,
    /// The properties.
    pub properties: Vec<Property>,
    /// Warnings about files that are accepted nevertheless.
    pub warnings: Vec<Problem>,
}

/// A process of a model that runs a machine.
#[derive(Debug)]
pub struct ModelProcess<'m> {
    /// Its name.
    pub name: String,
    /// Whether it is a leaf of the tree.
    pub is_leaf: bool,
    /// Its machine.
    pub machine: &'m Machine,
}

/// Whether a text is the main file of a model.
#[must_use]
pub fn is_model(text: &str) -> bool {
    parse(text).is_ok_and(|document| ROOTS.contains(&document.root_element().tag_name().name()))
}

/// The names of the root element; the second is AS2FM's older name.
const ROOTS: [&str; 2] = ["roaml", "convince_mc_tc"];

impl Model {
    /// Loads a model from its main file. `read` reads this file and the files that it names.
    ///
    /// # Errors
    /// Everything that is wrong with the file and the files that it names, with locations.
    pub fn load(path: &Path, read: &dyn Fn(&Path) -> io::Result<String>) -> Result<Self, FileProblems> {
        let name = path.display().to_string();
        let text = read(path)
            .map_err(|error| FileProblems::from(Problem::new(format!("cannot read the model {name}: {error}"))))?;
        let source = Source::new(&name, text.as_str());
        let folder = path.parent().unwrap_or_else(|| Path::new("")).to_owned();
        let mut loader = ModelLoader { folder, read, source: source.clone(), problems: Vec::new() };
        let model = match parse(&text) {
            Ok(document) => loader.model(path, document.root_element()),
            Err(problem) => {
                loader.problems.push(problem.of(&source));
                None
            }
        };
        let (errors, warnings) = loader.problems.into_iter().partition(Problem::is_error);
        FileProblems::none_of(errors)?;
        Ok(Self { warnings, ..model.expect("a file that could not be loaded was reported") })
    }

    /// The processes that run a machine, with their names: first those of ROS nodes, then those of the tree's leaves.
    pub fn processes(&self) -> impl Iterator<Item = ModelProcess<'_>> {
        machine_processes(&self.machines).into_iter().map(|process| ModelProcess {
            name: process.name,
            is_leaf: process.instance.leaf.is_some() && process.thread.is_none(),
            machine: process.machine,
        })
    }

    /// The monitors of the properties, in order, for a system with this topology.
    pub fn monitors(&self, topology: &Topology) -> impl Iterator<Item = PropertyMonitor> {
        let events = events(&self.machines);
        self.properties.iter().map(move |property| PropertyMonitor::new(property, &events, topology))
    }

    /// The events that properties are about.
    pub(crate) fn recorded(&self) -> impl Iterator<Item = &str> {
        self.properties.iter().flat_map(Property::events)
    }
}

/// A file that the main file names.
struct Named<'t> {
    path: PathBuf,
    text: String,
    node: Node<'t, 't>,
}

/// The parts of a model; two have an older name.
const PARTS: [&str; 6] =
    ["parameters", "mc_parameters", "behavior_tree", "node_models", "data_declarations", "properties"];

/// A model that is being loaded. Each part is read even if others are wrong, for its own problems.
struct ModelLoader<'r> {
    folder: PathBuf,
    read: &'r dyn Fn(&Path) -> io::Result<String>,
    source: Source,
    problems: Vec<Problem>,
}

impl ModelLoader<'_> {
    /// Whether there are only warnings so far.
    fn is_sound(&self) -> bool {
        !self.problems.iter().any(Problem::is_error)
    }

    fn report(&mut self, problem: Problem) {
        self.problems.push(problem.of(&self.source));
    }

    fn model(&mut self, path: &Path, root: Node<'_, '_>) -> Option<Model> {
        if !ROOTS.contains(&root.tag_name().name()) {
            let problem = Problem::new("this is not a RoAML model").at(name_span(root), "the first element");
            self.report(problem.with_help("a model begins with <roaml>"));
            return None;
        }
        self.check_parts(root);
        let section = |names: &[&str]| root.children().find(|child| names.iter().any(|name| is(child, name)));
        let parameters = match section(&["parameters", "mc_parameters"]) {
            Some(section) => self.parameters(section),
            None => {
                let problem =
                    Problem::new("the model has no parameters").at(name_span(root), "<parameters> is missing");
                self.report(problem.with_help("add <parameters> <max_time value=\"100\" unit=\"s\"/> </parameters>"));
                None
            }
        };
        let structures = section(&["data_declarations"]).map_or_else(Vec::new, |section| self.structures(section));
        let mut machines = section(&["node_models"]).map_or_else(Vec::new, |section| self.nodes(section, &structures));
        let tree = section(&["behavior_tree"]).and_then(|section| self.tree(section, &structures, &mut machines));
        if section(&["behavior_tree"]).is_some() && tree.is_none() && self.is_sound() {
            self.report(Problem::new("the model's tree cannot be loaded").at(name_span(root), "in here"));
        }
        self.check_names(root, &machines);
        // Without all machines, it would be unknown which events exist.
        let properties = section(&["properties"]).filter(|_| self.is_sound());
        let properties = properties.map_or_else(Vec::new, |section| self.properties(section, &machines));
        let name = path.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy()).into_owned();
        Some(Model { name, parameters: parameters?, tree, machines, properties, warnings: Vec::new() })
    }

    fn check_parts(&mut self, root: Node<'_, '_>) {
        for child in root.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            if !PARTS.contains(&name) {
                let problem = Problem::new(format!("<{}> has no part <{name}>", root.tag_name().name()));
                let help = nearest_or_all(name, "its parts", &PARTS);
                self.report(problem.at(name_span(child), "unknown").with_help(help));
            }
        }
    }

    /// Checks that all processes have different names.
    fn check_names(&mut self, root: Node<'_, '_>, machines: &[Instance]) {
        let mut seen: Vec<&str> = RESERVED.to_vec();
        for Instance { name, .. } in machines {
            if seen.contains(&name.as_str()) {
                let problem = Problem::new(format!("two processes are named `{name}`"));
                let problem = problem.at(name_span(root), "in this model");
                self.report(problem.with_help("machines and leaves need different names"));
            }
            seen.push(name);
        }
    }

    fn properties(&mut self, section: Node<'_, '_>, machines: &[Instance]) -> Vec<Property> {
        let events = events(machines);
        let mut properties = Vec::new();
        for Named { path, text, .. } in self.inputs(section, &["jani"]) {
            let source = Source::new(&path.display().to_string(), text.as_str());
            match Property::read(&source, &events) {
                Ok(more) => properties.extend(more),
                Err(problems) => self.problems.extend(problems.into_iter().map(|problem| problem.of(&source))),
            }
        }
        properties
    }

    fn parameters(&mut self, section: Node<'_, '_>) -> Option<Parameters> {
        let (mut max_time, mut tick, mut tick_if_not_running) = (None, Duration::from_secs(1), false);
        for node in section.children().filter(Node::is_element) {
            let name = node.tag_name().name();
            let Some(value) = node.attribute("value") else {
                self.report(
                    Problem::new(format!("<{name}> needs the attribute `value`")).at(name_span(node), "missing"),
                );
                continue;
            };
            match name {
                "max_time" => max_time = self.time(node, value).or(max_time),
                "bt_tick_rate" => match value.trim().parse::<f64>().ok().filter(|rate| *rate > 0.0 && *rate <= 1e6) {
                    Some(rate) => tick = Duration::from_nanos((1e9 / rate).round() as u64),
                    None => self.report(wrong_value(node, value, "a rate in Hz")),
                },
                "bt_tick_if_not_running" => match value.trim() {
                    "true" | "True" | "1" => tick_if_not_running = true,
                    "false" | "False" | "0" => tick_if_not_running = false,
                    _ => self.report(wrong_value(node, value, "`true` or `false`")),
                },
                // Arrays grow as needed.
                "max_array_size" => {}
                _ => {
                    let known = ["max_time", "max_array_size", "bt_tick_rate", "bt_tick_if_not_running"];
                    let problem = Problem::new(format!("unknown parameter <{name}>")).at(name_span(node), "unknown");
                    self.report(problem.with_help(nearest_or_all(name, "parameters", &known)));
                }
            }
        }
        if max_time.is_none() && self.is_sound() {
            let problem = Problem::new("the model does not say how long it may run").at(name_span(section), "in here");
            self.report(problem.with_help("add <max_time value=\"100\" unit=\"s\"/>"));
        }
        max_time.map(|max_time| Parameters { max_time, tick, tick_if_not_running })
    }

    /// The time in an element with a value and a unit.
    fn time(&mut self, node: Node<'_, '_>, value: &str) -> Option<Duration> {
        let unit = node.attribute("unit").unwrap_or("s");
        let units = [("s", 1_000_000_000), ("ms", 1_000_000), ("us", 1_000), ("ns", 1)];
        let Some((_, unit_ns)) = units.into_iter().find(|(name, _)| *name == unit) else {
            let problem = Problem::new(format!("unknown unit `{unit}`"));
            let problem = problem.at(value_span(node, "unit"), "unknown unit");
            self.report(problem.with_help(nearest_or_all(unit, "units", &units.map(|(name, _)| name))));
            return None;
        };
        let time_ns = value.trim().parse::<u64>().ok().and_then(|value| value.checked_mul(unit_ns));
        if time_ns.is_none() {
            self.report(wrong_value(node, value, "a whole number in this unit"));
        }
        time_ns.map(Duration::from_nanos)
    }

    /// The files of a section that can be read. `types` are the types that it accepts.
    fn inputs<'t>(&mut self, section: Node<'t, 't>, types: &[&str]) -> Vec<Named<'t>> {
        section.children().filter(Node::is_element).filter_map(|node| self.input(node, section, types)).collect()
    }

    fn input<'t>(&mut self, node: Node<'t, 't>, section: Node<'_, '_>, types: &[&str]) -> Option<Named<'t>> {
        let name = node.tag_name().name();
        if name != "input" {
            let problem = Problem::new(format!("<{}> contains only <input>", section.tag_name().name()));
            self.report(problem.at(name_span(node), format!("not <{name}>")));
            return None;
        }
        let (Some(of), Some(src)) = (node.attribute("type"), node.attribute("src")) else {
            let problem = Problem::new("<input> needs the attributes `type` and `src`");
            self.report(problem.at(name_span(node), "one is missing"));
            return None;
        };
        if !types.contains(&of) {
            let problem = Problem::new(format!("`{of}` is not a supported type of input"));
            let problem = problem.at(value_span(node, "type"), "unknown type");
            self.report(problem.with_help(nearest_or_all(of, "types", types)));
            return None;
        }
        let path = self.folder.join(src);
        let read = (self.read)(&path).map_err(|error| {
            let problem = Problem::new(format!("cannot read {}: {error}", path.display()));
            self.report(problem.at(value_span(node, "src"), "this file"));
        });
        Some(Named { text: read.ok()?, path, node })
    }

    /// The names of the model's own types.
    fn structures(&mut self, section: Node<'_, '_>) -> Vec<String> {
        let mut names = Vec::new();
        for Named { path, text, node } in self.inputs(section, &["xml", "json"]) {
            let found =
                if node.attribute("type") == Some("xml") { xml_structures(&text) } else { json_structures(&text) };
            match found {
                Ok(found) => names.extend(found),
                Err(problem) => {
                    let source = Source::new(&path.display().to_string(), text.as_str());
                    self.problems.push(problem.of(&source));
                }
            }
        }
        names
    }

    fn nodes(&mut self, section: Node<'_, '_>, structures: &[String]) -> Vec<Instance> {
        let files = self.inputs(section, &["node-ascxml", "ros-scxml"]);
        let machines = files.iter().filter_map(|file| self.machine(file, &BTreeMap::new(), structures));
        machines.map(|machine| Instance { name: machine.chart.name().to_owned(), leaf: None, machine }).collect()
    }

    /// The machine in a file; `ports` are the constant values of a leaf's input ports.
    fn machine(
        &mut self,
        file: &Named<'_>,
        ports: &BTreeMap<String, String>,
        structures: &[String],
    ) -> Option<Machine> {
        let machine = Machine::load(&file.path.display().to_string(), &file.text, ports, structures);
        let machine = machine.map_err(|problems| self.problems.extend(problems)).ok()?;
        self.problems.extend(machine.warnings.iter().cloned());
        Some(machine)
    }

    /// Loads the tree, and adds the machines of its leaves to the others.
    fn tree(
        &mut self,
        section: Node<'_, '_>,
        structures: &[String],
        machines: &mut Vec<Instance>,
    ) -> Option<Arc<Tree>> {
        let files = self.inputs(section, &["bt.cpp-xml", "bt-plugin-ascxml", "bt-plugin-ros-scxml"]);
        let (trees, files): (Vec<_>, Vec<_>) =
            files.into_iter().partition(|file| file.node.attribute("type") == Some("bt.cpp-xml"));
        let [tree] = trees.as_slice() else {
            if self.problems.is_empty() {
                let problem = Problem::new(format!("a model has one tree, not {}", trees.len()));
                self.report(
                    problem.at(name_span(section), "in here").with_help("<input type=\"bt.cpp-xml\" src=\"…\"/>"),
                );
            }
            return None;
        };
        // A plugin is loaded once without a leaf, for its name and for its problems, even if no leaf uses it.
        let mut plugins: Plugins<'_> = BTreeMap::new();
        for file in &files {
            let machine = self.machine(file, &BTreeMap::new(), structures);
            plugins.extend(machine.map(|machine| (machine.chart.name().to_owned(), file)));
        }
        if !self.problems.is_empty() {
            return None;
        }
        let loader = Loader::default().leaves(plugins.keys().map(String::as_str));
        match loader.load(&tree.path, &tree.text) {
            Ok(tree) => {
                machines.extend(tree.leaves().filter_map(|leaf| self.leaf(&tree, leaf, &plugins, structures)));
                Some(Arc::new(tree))
            }
            Err(error) => {
                let source = Source::new(error.file(), tree.text.as_str());
                self.problems.extend(error.problems().iter().map(|problem| problem.clone().of(&source)));
                None
            }
        }
    }

    /// The machine of a leaf, with the values that the tree's file gives to its ports.
    fn leaf(&mut self, tree: &Tree, leaf: &bt::Node, plugins: &Plugins<'_>, structures: &[String]) -> Option<Instance> {
        let Some(plugin) = plugins.get(leaf.type_id()) else {
            let known: Vec<&str> = plugins.keys().map(String::as_str).collect();
            let message = format!("no plugin implements the leaf `{}`", leaf.type_id());
            let help = nearest_or_all(leaf.type_id(), "plugins", &known);
            self.problems.push(tree.problem_at(leaf.id(), message, "this leaf", help));
            return None;
        };
        let constants = tree.ports(leaf.id()).filter_map(|port| match port.source {
            bt::Source::Constant(value) => Some((port.name.to_owned(), value.to_text().to_string())),
            _ => None,
        });
        let machine = self.machine(plugin, &constants.collect(), structures)?;
        Some(Instance { name: leaf.process().to_owned(), leaf: Some(leaf.id()), machine })
    }
}

/// The files of plugins, by the names of their machines: the IDs of the leaves that they implement.
type Plugins<'t> = BTreeMap<String, &'t Named<'t>>;

fn wrong_value(node: Node<'_, '_>, value: &str, expected: &str) -> Problem {
    Problem::new(format!("`{value}` is not {expected}")).at(value_span(node, "value"), "here")
}

fn xml_structures(text: &str) -> Result<Vec<String>, Problem> {
    let document = parse(text)?;
    let structures = document.root_element().children().filter(|node| is(node, "struct"));
    Ok(structures.filter_map(|node| node.attribute("id")).map(str::to_owned).collect())
}

/// The title of a JSON schema, and the names of its definitions.
fn json_structures(text: &str) -> Result<Vec<String>, Problem> {
    let schema: serde_json::Value = serde_json::from_str(text)
        .map_err(|error| Problem::new(format!("this is not JSON: {error}")).at(0..0, "in this file"))?;
    let title = schema.get("title").and_then(|title| title.as_str()).map(str::to_owned);
    let definitions = schema.get("$defs").and_then(|defs| defs.as_object());
    Ok(title.into_iter().chain(definitions.into_iter().flat_map(|defs| defs.keys().cloned())).collect())
}
