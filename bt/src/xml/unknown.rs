//! Attributes that are none of a node's.

use super::compile::{Attribute, Compiler};
use super::model::Model;
use super::ports::{is_port_name, ports};
use super::{MAX_HINTS, listed, nearest};
use crate::Problem;
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
            let near = nearest(name, known, self.problems.len()).map(|near| format!("did you mean `{near}`?"));
            let help = near.or_else(|| self.all("its scripts may be", &Hooks::NAMES));
            let (attribute, span) = (name.to_owned(), attribute.span);
            self.problems.push(Problem::UnknownAttribute { attribute, span, help });
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
            let near = nearest(&attribute.name, candidates, self.problems.len());
            let near = near.map(|near| format!("did you mean `{near}`?"));
            let help = near.or_else(|| self.all("its ports are", &known));
            self.unknown_port(attribute, help);
        }
    }

    /// Attributes of a leaf that its model does not declare as ports: a mistake if they are nearly called like one that is
    /// not given, else perhaps one.
    pub(super) fn check_leaf_ports(&mut self, model: Option<&Model>) {
        let known: Vec<&str> = model.iter().flat_map(|model| &model.ports).map(|port| &*port.name).collect();
        if known.is_empty() {
            return;
        }
        let open: Vec<&str> = known.iter().copied().filter(|port| !self.is_given(port)).collect();
        for attribute in self.strangers(&known) {
            if let Some(near) = nearest(&attribute.name, open.iter().copied(), self.problems.len()) {
                self.unknown_port(attribute, Some(format!("did you mean `{near}`?")));
            } else {
                let (node, port, span) = (self.name.to_owned(), attribute.name.clone(), attribute.span);
                let help = self.all("the ports in its model are", &known);
                self.problems.push(Problem::UndeclaredPort { node, port, span, help });
            }
        }
    }

    /// The attribute that was probably meant to be a port that is missing.
    pub(super) fn meant_to_be(&self, port: &str) -> Option<&'a str> {
        let names = self.attributes.iter().map(|attribute| attribute.name.as_str()).filter(|name| is_port_name(name));
        nearest(port, names, self.problems.len())
    }

    fn is_given(&self, port: &str) -> bool {
        self.attributes.iter().any(|attribute| attribute.name == port)
    }

    /// The attributes that could be ports, and are not among the known ones.
    fn strangers(&self, known: &[&str]) -> Vec<&'a Attribute> {
        let ports = self.attributes.iter().filter(|attribute| is_port_name(&attribute.name));
        ports.filter(|attribute| !known.contains(&attribute.name.as_str())).collect()
    }

    fn unknown_port(&mut self, attribute: &Attribute, help: Option<String>) {
        let (node, port, span) = (self.name.to_owned(), attribute.name.clone(), attribute.span);
        self.problems.push(Problem::UnknownPort { node, port, span, help });
    }

    /// All names that there are, unless so much has been said already.
    fn all(&self, what: &str, names: &[&str]) -> Option<String> {
        let all = || match names {
            [] => "it has none".to_owned(),
            names => format!("{what} {}", listed(names.iter().copied())),
        };
        (self.problems.len() < MAX_HINTS).then(all)
    }
}
