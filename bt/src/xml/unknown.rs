//! Attributes that are none of a node's.

use std::collections::BTreeSet;

use diagnostics::{MAX_HINTS, Problem};

use super::compile::Compiler;
use super::library::Attribute;
use super::model::Model;
use super::ports::{is_port_name, ports};
use super::problems::{listed, near, unknown_port};
use crate::hooks::Hooks;

/// Attributes that begin with `_` and are no scripts: what BehaviorTree.CPP and Groot write or read besides.
const NOTES: [&str; 7] =
    ["_description", "_autoremap", "_fullpath", "_fullPath", "_uid", "__autoremap", "__shared_blackboard"];

impl<'a> Compiler<'a> {
    /// Attributes that begin with `_` and that nobody knows. BehaviorTree.CPP keeps them for the node's own use, so that a
    /// misspelt script is never run.
    pub(super) fn check_scripts(&mut self) {
        for attribute in self.attributes.iter().filter(|attribute| attribute.name.starts_with('_')) {
            let name = attribute.name.as_str();
            if Hooks::NAMES.contains(&name) || NOTES.contains(&name) {
                continue;
            }
            let known = Hooks::NAMES.into_iter().chain(NOTES.into_iter().take(2));
            let near = near(name, known, self.problems.len()).map(|near| format!("did you mean `{near}`?"));
            let help = near.or_else(|| self.all("its scripts may be", Hooks::NAMES.into_iter()));
            let problem = Problem::new(format!("the attribute `{name}` means nothing")).as_warning();
            self.problems.push(problem.at(attribute.span, "has no effect").with_help_if(help));
        }
    }

    /// Attributes of one of BehaviorTree.CPP's own nodes that are none of its ports. It refuses them, and so do we.
    pub(super) fn check_builtin_ports(&mut self) {
        let known: Vec<&str> = ports(self.kind).iter().map(|port| port.name).collect();
        let missing: Vec<&str> =
            ports(self.kind).iter().filter(|port| port.is_required()).map(|port| port.name).collect();
        let missing: Vec<&str> = missing.into_iter().filter(|port| !self.is_given(port)).collect();
        // Where a port is missing, that is said with what was probably meant to be it.
        let said: Vec<&str> = missing.iter().filter_map(|port| self.meant_to_be(port)).collect();
        let open: Vec<&str> = known.iter().copied().filter(|port| !self.is_given(port)).collect();
        for attribute in self.strangers(&known) {
            if said.contains(&attribute.name.as_str()) {
                continue;
            }
            let candidates = open.iter().copied().chain(Hooks::NAMES);
            let near = near(&attribute.name, candidates, self.problems.len());
            let near = near.map(|near| format!("did you mean `{near}`?"));
            let help = near.or_else(|| self.all("its ports are", known.iter().copied()));
            self.problems.push(unknown_port(self.name, &attribute.name, attribute.span, help));
        }
    }

    /// Attributes of a leaf that its model does not declare as ports. BehaviorTree.CPP refuses them. The models that files
    /// of version 3 have are Groot's notes: there it is a warning, but for a name that is nearly that of a port which is
    /// not given.
    pub(super) fn check_leaf_ports(&mut self, model: Option<&Model>, format: u8) {
        let says_ports = |model: &&Model| model.is_declared && (format == 4 || !model.ports.is_empty());
        let Some(model) = model.filter(says_ports) else { return };
        let ports = self.attributes.iter().filter(|attribute| is_port_name(&attribute.name));
        let strangers: Vec<&Attribute> = ports.filter(|attribute| model.port(&attribute.name).is_none()).collect();
        let given: BTreeSet<&str> = match strangers.as_slice() {
            [] => return,
            _ => self.attributes.iter().map(|attribute| attribute.name.as_str()).collect(),
        };
        for attribute in strangers {
            let ports = model.ports.iter().map(|port| port.name.as_str());
            let near = near(&attribute.name, ports.clone().filter(|port| !given.contains(port)), self.problems.len());
            let help = near.map(|near| format!("did you mean `{near}`?"));
            let help = help.or_else(|| self.all("the ports in its model are", ports));
            let (node, port) = (self.name, &attribute.name);
            self.problems.push(if near.is_none() && format == 3 {
                let problem = Problem::new(format!("{node} declares no port `{port}`")).as_warning();
                problem.at(attribute.span, "not declared").with_help_if(help)
            } else {
                unknown_port(node, port, attribute.span, help)
            });
        }
    }

    /// The attribute that was probably meant to be a port that is missing.
    pub(super) fn meant_to_be(&self, port: &str) -> Option<&'a str> {
        let names = self.attributes.iter().map(|attribute| attribute.name.as_str()).filter(|name| is_port_name(name));
        near(port, names, self.problems.len())
    }

    fn is_given(&self, port: &str) -> bool {
        self.attributes.iter().any(|attribute| attribute.name == port)
    }

    /// The attributes that could be ports, and are not among the known ones.
    fn strangers(&self, known: &[&str]) -> Vec<&'a Attribute> {
        let ports = self.attributes.iter().filter(|attribute| is_port_name(&attribute.name));
        ports.filter(|attribute| !known.contains(&attribute.name.as_str())).collect()
    }

    /// All names that there are, unless so much has been said already.
    fn all<'b>(&self, what: &str, names: impl Iterator<Item = &'b str>) -> Option<String> {
        if self.problems.len() >= MAX_HINTS {
            return None;
        }
        let names = listed(names);
        Some(if names.is_empty() { "it has none".to_owned() } else { format!("{what} {names}") })
    }
}
