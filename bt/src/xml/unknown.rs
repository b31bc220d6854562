//! Unknown attributes of nodes.

use std::collections::BTreeSet;

use diagnostics::{MAX_HINTS, Problem};

use super::compile::Compiler;
use super::ports::{is_port_name, ports};
use super::problems::{listed, near, unknown_port};
use crate::hooks::Hooks;
use crate::library::{Attribute, Model};

/// Attributes that begin with `_` but are not scripts: other annotations of BehaviorTree.CPP and Groot.
const NOTES: [&str; 7] =
    ["_description", "_autoremap", "_fullpath", "_fullPath", "_uid", "__autoremap", "__shared_blackboard"];

impl<'a> Compiler<'a> {
    /// Unknown attributes that begin with `_`. BehaviorTree.CPP reserves them for the node itself, so a misspelled
    /// script would never run.
    pub(super) fn check_scripts(&mut self) {
        for attribute in self.attributes.iter().filter(|attribute| attribute.name.starts_with('_')) {
            let name = attribute.name.as_str();
            if Hooks::NAMES.contains(&name) || NOTES.contains(&name) {
                continue;
            }
            let known = Hooks::NAMES.into_iter().chain(NOTES.into_iter().take(2));
            let near = near(name, known, self.problems.len()).map(|near| format!("did you mean `{near}`?"));
            let help = near.or_else(|| self.all("the scripts are", Hooks::NAMES.into_iter()));
            let problem = Problem::new(format!("unknown attribute `{name}`")).as_warning();
            self.problems.push(problem.at(attribute.span, "has no effect").with_help_if(help));
        }
    }

    /// Attributes of a built-in node that are not its ports. Refused as in BehaviorTree.CPP.
    pub(super) fn check_builtin_ports(&mut self) {
        let known: Vec<&str> = ports(self.kind).iter().map(|port| port.name).collect();
        let missing: Vec<&str> =
            ports(self.kind).iter().filter(|port| port.is_required()).map(|port| port.name).collect();
        let missing: Vec<&str> = missing.into_iter().filter(|port| !self.is_given(port)).collect();
        // If a port is missing, that problem also names the attribute that was probably meant.
        let reported: Vec<&str> = missing.iter().filter_map(|port| self.meant_to_be(port)).collect();
        let open: Vec<&str> = known.iter().copied().filter(|port| !self.is_given(port)).collect();
        for attribute in self.strangers(&known) {
            if reported.contains(&attribute.name.as_str()) {
                continue;
            }
            let candidates = open.iter().copied().chain(Hooks::NAMES);
            let near = near(&attribute.name, candidates, self.problems.len());
            let near = near.map(|near| format!("did you mean `{near}`?"));
            let help = near.or_else(|| self.all("the ports are", known.iter().copied()));
            self.problems.push(unknown_port(self.name, &attribute.name, attribute.span, help));
        }
    }

    /// Attributes of a leaf that its model does not declare as ports. BehaviorTree.CPP refuses them. In files of
    /// version 3, models are only Groot's annotations: there it is a warning, unless the name is similar to that of a
    /// missing port.
    pub(super) fn check_leaf_ports(&mut self, model: Option<&Model>, format: u8) {
        let lists_ports = |model: &&Model| model.is_declared && (format == 4 || !model.ports.is_empty());
        let Some(model) = model.filter(lists_ports) else { return };
        let ports = self.attributes.iter().filter(|attribute| is_port_name(&attribute.name));
        let strangers: Vec<&Attribute> = ports.filter(|attribute| model.port(&attribute.name).is_none()).collect();
        // Most leaves have no such attribute, and then the others need not be collected.
        let given: BTreeSet<&str> = match strangers.as_slice() {
            [] => return,
            _ => self.attributes.iter().map(|attribute| attribute.name.as_str()).collect(),
        };
        for attribute in strangers {
            let words =
                if model.is_of_nav2() { "in Nav2's model, its ports are" } else { "the ports in its model are" };
            let ports = model.ports.iter().map(|port| port.name.as_str());
            let near = near(&attribute.name, ports.clone().filter(|port| !given.contains(port)), self.problems.len());
            let help = near.map(|near| format!("did you mean `{near}`?"));
            let help = help.or_else(|| self.all(words, ports));
            let (node, port) = (self.name, &attribute.name);
            self.problems.push(if near.is_none() && format == 3 {
                let problem = Problem::new(format!("{node} declares no port `{port}`")).as_warning();
                problem.at(attribute.span, "not declared").with_help_if(help)
            } else {
                unknown_port(node, port, attribute.span, help)
            });
        }
    }

    /// The attribute that was probably meant to be a missing port.
    pub(super) fn meant_to_be(&self, port: &str) -> Option<&'a str> {
        let names = self.attributes.iter().map(|attribute| attribute.name.as_str()).filter(|name| is_port_name(name));
        near(port, names, self.problems.len())
    }

    fn is_given(&self, port: &str) -> bool {
        self.attributes.iter().any(|attribute| attribute.name == port)
    }

    /// The attributes that could be ports but are not known.
    fn strangers(&self, known: &[&str]) -> Vec<&'a Attribute> {
        let ports = self.attributes.iter().filter(|attribute| is_port_name(&attribute.name));
        ports.filter(|attribute| !known.contains(&attribute.name.as_str())).collect()
    }

    /// All known names, unless very many problems have been reported.
    fn all<'b>(&self, what: &str, names: impl Iterator<Item = &'b str>) -> Option<String> {
        if self.problems.len() >= MAX_HINTS {
            return None;
        }
        let names = listed(names);
        Some(if names.is_empty() { "it has none".to_owned() } else { format!("{what} {names}") })
    }
}
