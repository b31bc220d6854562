//! Whether a tree and its skills fit together: what can be known before anything runs.

use std::sync::Arc;

use channels::{ProcessId, Topology};

use super::{CLIENT, SkillProcess};
use crate::chart::Chart;
use crate::problem::Problem;
use crate::suggest::nearest_or_all;
use crate::{Datum, SkillError};

/// A skill of a system: its name, the machine that it runs, and its parameters.
pub type SkillOfSystem<'a> = (&'a str, &'a Arc<Chart>, &'a [(&'a str, Datum)]);

/// Checks the skills of a whole system: that every leaf of the tree has a skill which hears all that the tree asks and
/// answers on its own channel, that whatever a skill asks exists and takes the question ([`SkillProcess::new`]), and that
/// the answers are read. Everything that is wrong is returned; nothing, if it fits.
#[must_use]
pub fn check_system(leaves: &[&str], skills: &[SkillOfSystem<'_>], topology: &Topology) -> Vec<SkillError> {
    let names: Vec<&str> = skills.iter().map(|(name, ..)| *name).collect();
    let mut errors = Vec::new();
    for leaf in leaves.iter().filter(|leaf| !names.contains(leaf)) {
        errors.push(SkillError::NoSkill { leaf: (*leaf).to_owned(), help: nearest_or_all(leaf, "skills", &names) });
    }
    for (name, chart, parameters) in skills {
        if let Err(error) = SkillProcess::new(name, chart, topology, parameters.iter().cloned()) {
            errors.push(error);
        }
        let problems = conversation(name, chart, topology, leaves.contains(name));
        if !problems.is_empty() {
            let text = chart.file().clone();
            errors.push(SkillError::Wiring { process: (*name).to_owned(), text, problems });
        }
    }
    errors
}

/// What a skill does not hear or say that it should.
fn conversation(name: &str, chart: &Chart, topology: &Topology, is_leaf: bool) -> Vec<Problem> {
    let Some(skill) = topology.find_process(name) else {
        return Vec::new();
    };
    let complain = |message: String, label: &str| Problem::new(message).at(chart.span, label);
    let mut problems = Vec::new();
    let client = topology.find_process(CLIENT);
    let to_client = client.is_some_and(|client| has_channel(topology, skill, client));
    if is_leaf && !to_client {
        problems.push(complain(format!("there is no channel {name} → {CLIENT} to answer on"), "cannot answer"));
    }
    if is_leaf && to_client && !chart.channel_messages().iter().any(|(target, _)| *target == CLIENT) {
        let help = format!("<send type=\"channel\" target=\"{CLIENT}\" event=\"success\"/>");
        problems.push(complain(format!("{name} never answers {CLIENT}"), "says nothing to it").help(help));
    }
    let wiring = super::wiring::Wiring::new(topology, skill);
    for incoming in &wiring.incoming {
        let mut unheard: Vec<&str> = incoming.event_names().filter(|event| !chart.hears(event)).collect();
        // Of a component's answers some may be of no interest; of the tree's requests none.
        if !incoming.is_client && unheard.len() < incoming.event_names().count() {
            unheard.clear();
        }
        for event in unheard {
            problems.push(complain(format!("nobody reads `{event}`"), "no transition takes it"));
        }
    }
    problems
}

fn has_channel(topology: &Topology, source: ProcessId, target: ProcessId) -> bool {
    topology.channels().any(|channel| topology.get(channel).source == source && topology.get(channel).target == target)
}
