//! The declarations of a machine: its interfaces, timers, ports and data.

use std::collections::BTreeMap;

use diagnostics::xml::name_span;
use diagnostics::{Problem, did_you_mean, nearest_or_all};
use roxmltree::Node;
use skills::Datum;

use super::kind::DataKind;
use super::port::input_datum;
use super::vocabulary::{Role, sanitized};
use super::xml::{is, value_span};

/// A ROS interface or a timer that a machine declares.
#[derive(Clone, Debug)]
pub(crate) struct Interface {
    pub(crate) role: Role,
    /// The name by which the machine refers to it.
    pub(crate) alias: String,
    /// The name that is the same in all machines; for a timer, its own name.
    pub(crate) name: String,
    /// The type, such as `std_msgs/Bool`.
    pub(crate) of: String,
    /// The period of a timer, in nanoseconds.
    pub(crate) period_ns: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PortDirection {
    /// The machine reads it.
    In,
    /// The machine writes it.
    Out,
}

#[derive(Clone, Debug)]
pub(super) struct Port {
    pub(super) key: String,
    pub(super) direction: PortDirection,
    pub(super) kind: DataKind,
    /// Its constant value.
    pub(super) value: Option<Datum>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Declarations {
    pub(super) interfaces: Vec<Interface>,
    pub(super) ports: Vec<Port>,
    /// The kinds of data, by name, including those of input ports.
    pub(super) data: BTreeMap<String, DataKind>,
}

impl Declarations {
    pub(super) fn of(
        root: Node<'_, '_>,
        ports: &BTreeMap<String, String>,
        structures: &[String],
        problems: &mut Vec<Problem>,
    ) -> Self {
        let mut declared = Self::default();
        // Ports come first: an interface may have its name from a port.
        for node in root.children().filter(Node::is_element) {
            let direction = match node.tag_name().name() {
                "bt_declare_port_in" => PortDirection::In,
                "bt_declare_port_out" => PortDirection::Out,
                _ => continue,
            };
            declared.port(node, direction, ports, structures, problems);
        }
        for node in root.children().filter(Node::is_element) {
            match Role::declared_by(node.tag_name().name()) {
                Some(Role::Timer) => declared.timer(node, problems),
                Some(role) => declared.interface(node, role, problems),
                None => {}
            }
        }
        for data in root.descendants().filter(|node| is(node, "data")) {
            declared.datum(data, structures, problems);
        }
        declared
    }

    pub(super) fn ports(&self) -> BTreeMap<String, (PortDirection, DataKind)> {
        self.ports.iter().map(|port| (port.key.clone(), (port.direction, port.kind))).collect()
    }

    fn port(
        &mut self,
        node: Node<'_, '_>,
        direction: PortDirection,
        values: &BTreeMap<String, String>,
        structures: &[String],
        problems: &mut Vec<Problem>,
    ) {
        let Some(key) = required(node, "key", problems) else { return };
        let Some(of) = required(node, "type", problems) else { return };
        let Some(kind) = DataKind::of_type(of, structures) else {
            problems.push(unknown_type(node, of, structures));
            return;
        };
        // A port that is an entry of the blackboard has no value here: it arrives with each tick.
        let mut value = None;
        if let Some(text) = values.get(key).filter(|_| direction == PortDirection::In) {
            value = kind.parse(text);
            if value.is_none() {
                let problem = Problem::new(format!("the tree gives the port `{key}` the value `{text}`"));
                problems.push(problem.at(value_span(node, "type"), format!("this is not `{of}`")));
            }
        }
        if direction == PortDirection::In {
            self.data.insert(input_datum(key), kind);
        }
        self.ports.push(Port { key: key.to_owned(), direction, kind, value });
    }

    fn timer(&mut self, node: Node<'_, '_>, problems: &mut Vec<Problem>) {
        let Some(name) = required(node, "name", problems) else { return };
        let Some(rate) = required(node, "rate_hz", problems) else { return };
        let Some(rate) = rate.parse().ok().filter(|rate: &f64| *rate > 0.0 && *rate <= 1e9) else {
            let problem = Problem::new("the rate of a timer must be a number greater than 0, in Hz");
            problems.push(problem.at(value_span(node, "rate_hz"), "not a rate"));
            return;
        };
        let (name, period_ns) = (name.to_owned(), (1e9 / rate).round() as u64);
        self.interfaces.push(Interface { role: Role::Timer, alias: name.clone(), name, of: String::new(), period_ns });
    }

    fn interface(&mut self, node: Node<'_, '_>, role: Role, problems: &mut Vec<Problem>) {
        let Some(of) = required(node, "type", problems) else { return };
        let attribute = role.attribute();
        let name = match node.attribute(attribute) {
            Some(name) => Some(name.to_owned()),
            None => self.configured(node, attribute, problems),
        };
        let Some(name) = name else { return };
        if sanitized(&name).is_empty() {
            let problem = Problem::new(format!("`{name}` cannot be the name of an interface"));
            problems.push(problem.at(value_span(node, attribute), "not a name"));
            return;
        }
        let alias = node.attribute("name").unwrap_or(&name).to_owned();
        if self.interfaces.iter().any(|known| known.alias == alias && known.role == role) {
            let problem = Problem::new(format!("`{alias}` is declared twice")).at(name_span(node), "here again");
            problems.push(problem);
            return;
        }
        self.interfaces.push(Interface { role, alias, name, of: of.to_owned(), period_ns: 0 });
    }

    /// The name of an interface that is determined by a port.
    fn configured(&self, node: Node<'_, '_>, attribute: &str, problems: &mut Vec<Problem>) -> Option<String> {
        let child = node.children().find(|child| is(child, attribute));
        let input = child.and_then(|child| child.descendants().find(|inner| is(inner, "bt_get_input")));
        let Some(input) = input else {
            let problem = Problem::new(format!("<{}> needs the attribute `{attribute}`", node.tag_name().name()));
            problems.push(problem.at(name_span(node), format!("`{attribute}` is missing")));
            return None;
        };
        let key = required(input, "key", problems)?;
        if !self.ports.iter().any(|port| port.key == key) {
            problems.push(self.unknown_port(input, key));
            return None;
        }
        let value = self.ports.iter().find(|port| port.key == key).and_then(|port| port.value.as_ref());
        // Without a leaf, the machine can only be checked.
        Some(value.map_or_else(
            || format!("port_{key}"),
            |value| match value {
                Datum::Text(text) => text.to_string(),
                other => other.to_string(),
            },
        ))
    }

    fn datum(&mut self, node: Node<'_, '_>, structures: &[String], problems: &mut Vec<Problem>) {
        let Some(id) = node.attribute("id") else { return };
        let Some(of) = node.attribute("type") else { return };
        match DataKind::of_type(of, structures) {
            Some(kind) => {
                self.data.insert(id.to_owned(), kind);
            }
            None => problems.push(unknown_type(node, of, structures)),
        }
    }

    pub(super) fn find(&self, role: Role, alias: &str) -> Option<&Interface> {
        self.interfaces.iter().find(|known| known.role == role && known.alias == alias)
    }

    pub(super) fn undeclared(&self, node: Node<'_, '_>, role: Role, alias: &str) -> Problem {
        let known = self.interfaces.iter().filter(|known| known.role == role).map(|known| known.alias.as_str());
        let element = role.element();
        let help = did_you_mean(alias, known);
        let help = help.unwrap_or_else(|| format!("declare it with <{element} …/> directly inside the machine"));
        let problem = Problem::new(format!("no <{element}> is named `{alias}`"));
        problem.at(value_span(node, "name"), "not declared").with_help(help)
    }

    pub(super) fn unknown_port(&self, node: Node<'_, '_>, key: &str) -> Problem {
        if let Some(port) = self.ports.iter().find(|port| port.key == key) {
            let (is, not) = match port.direction {
                PortDirection::In => ("an input", "written"),
                PortDirection::Out => ("an output", "read"),
            };
            let problem = Problem::new(format!("the port `{key}` is {is} and cannot be {not}"));
            let help = "declare two ports with different keys, and connect both in the tree";
            return problem.at(value_span(node, "key"), "this port").with_help(help);
        }
        let known: Vec<&str> = self.ports.iter().map(|port| port.key.as_str()).collect();
        let problem =
            Problem::new(format!("the port `{key}` is not declared")).at(value_span(node, "key"), "no such port");
        problem.with_help(nearest_or_all(key, "ports", &known))
    }
}

/// The value of a required attribute.
pub(super) fn required<'a>(node: Node<'a, '_>, name: &str, problems: &mut Vec<Problem>) -> Option<&'a str> {
    let value = node.attribute(name);
    if value.is_none() {
        let problem = Problem::new(format!("<{}> needs the attribute `{name}`", node.tag_name().name()));
        problems.push(problem.at(name_span(node), format!("`{name}` is missing")));
    }
    value
}

fn unknown_type(node: Node<'_, '_>, of: &str, structures: &[String]) -> Problem {
    let element = of.split('[').next().unwrap_or_default();
    let own = structures.iter().map(String::as_str);
    let known: Vec<&str> = own.chain(DataKind::type_names().map(|name| -> &str { name })).collect();
    let problem = Problem::new(format!("unknown type `{element}`")).at(value_span(node, "type"), "unknown type");
    problem.with_help(nearest_or_all(element, "types", &known))
}
