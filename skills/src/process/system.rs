//! Checks whether a tree and its skills fit together, before anything runs.

use std::sync::Arc;

use channels::{ProcessId, Topology};
use diagnostics::{Problem, nearest_or_all};

use super::wiring::{Wiring, has_channel};
use super::{CLIENT, SkillProcess};
use crate::chart::{Attribute, CHANNEL_PROCESSOR, Chart, InvokeSource};
use crate::{Datum, SkillError};

/// A leaf of the tree, as its skill sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafOfSystem<'a> {
    /// The name of the leaf's process, and of its skill.
    pub name: &'a str,
    /// Whether the tree ever halts it; a condition, for example, answers at once and is never halted.
    pub is_halted: bool,
}

/// A skill of a system: its name, the machine that it runs, and its parameters.
pub type SkillOfSystem<'a> = (&'a str, &'a Arc<Chart>, &'a [(&'a str, Datum)]);

/// Checks the skills of a whole system: every leaf of the tree has a skill that accepts all requests of the tree and
/// answers on its own channel; every process to which a skill sends exists and understands the request
/// ([`SkillProcess::new`]); and the answers are read. Returns one error per skill with problems.
#[must_use]
pub fn check_system(leaves: &[LeafOfSystem<'_>], skills: &[SkillOfSystem<'_>], topology: &Topology) -> Vec<SkillError> {
    let names: Vec<&str> = skills.iter().map(|(name, ..)| *name).collect();
    let without_skill = leaves.iter().filter(|leaf| !names.contains(&leaf.name)).map(|leaf| SkillError::NoSkill {
        leaf: leaf.name.to_owned(),
        help: nearest_or_all(leaf.name, "skills", &names),
    });
    let unfit = skills.iter().filter_map(|skill| {
        let leaf = leaves.iter().find(|leaf| leaf.name == skill.0);
        check_skill(skill, leaf, topology).err()
    });
    without_skill.chain(unfit).collect()
}

/// Checks one skill, and the leaf for which it works, if any.
fn check_skill(
    (name, chart, parameters): &SkillOfSystem<'_>,
    leaf: Option<&LeafOfSystem<'_>>,
    topology: &Topology,
) -> Result<(), SkillError> {
    let mut problems = match SkillProcess::new(name, chart, topology, parameters.iter().cloned()) {
        Ok(_) => Vec::new(),
        Err(SkillError::Wiring { problems, .. }) => problems,
        Err(other) => return Err(other),
    };
    problems.extend(conversation(name, chart, leaf, topology));
    if problems.is_empty() {
        return Ok(());
    }
    problems.sort_by_key(Problem::offset);
    Err(SkillError::Wiring { process: (*name).to_owned(), text: chart.file().clone(), problems })
}

/// Requests that a skill does not accept, and answers that it does not give.
fn conversation(name: &str, chart: &Chart, leaf: Option<&LeafOfSystem<'_>>, topology: &Topology) -> Vec<Problem> {
    let Some(skill) = topology.find_process(name) else {
        return Vec::new();
    };
    let mut problems: Vec<Problem> = leaf.and_then(|_| silence(name, chart, skill, topology)).into_iter().collect();
    if chart.invokes().any(|invoke| invoke.auto_forward) {
        // An invoked machine may accept them.
        return problems;
    }
    let halts_nobody = leaf.is_some_and(|leaf| !leaf.is_halted);
    for incoming in &Wiring::new(topology, skill).incoming {
        let asked: Vec<&str> = incoming.asked().collect();
        let (mut unheard, all): (Vec<&str>, usize) =
            (incoming.event_names().filter(|event| !chart.handles(event)).collect(), incoming.event_names().count());
        // Some answers of a component may be ignored, but no requests.
        if unheard.len() < all {
            unheard.retain(|event| asked.contains(event));
        }
        unheard.retain(|event| !(incoming.is_client && halts_nobody && event.ends_with(".halt")));
        let complain =
            |event| Problem::new(format!("no transition reads `{event}`")).at(chart.span, "no transition handles it");
        problems.extend(unheard.into_iter().map(complain));
    }
    problems
}

/// A skill that cannot answer the tree, or never does.
fn silence(name: &str, chart: &Chart, skill: ProcessId, topology: &Topology) -> Option<Problem> {
    let client = topology.find_process(CLIENT);
    if !client.is_some_and(|client| has_channel(topology, skill, client)) {
        let problem = Problem::new(format!("there is no channel {name} → {CLIENT} to answer on"));
        return Some(problem.at(chart.span, "cannot answer"));
    }
    let problem = Problem::new(format!("{name} never answers {CLIENT}")).at(chart.span, "sends nothing to it");
    let problem = problem.with_help(format!("add <send type=\"channel\" target=\"{CLIENT}\" event=\"success\"/>"));
    (!may_send_to(CLIENT, chart)).then_some(problem)
}

/// Whether a machine, or one that it invokes, may send to this process by channel; computed targets count.
fn may_send_to(process: &str, chart: &Chart) -> bool {
    let may_be = |attribute: &Option<Attribute>, wanted: &str| {
        attribute.as_ref().is_some_and(|attribute| attribute.literal().is_none_or(|literal| &**literal == wanted))
    };
    let mut sends = false;
    chart.visit_sends(&mut |send| sends |= may_be(&send.processor, CHANNEL_PROCESSOR) && may_be(&send.target, process));
    sends
        || chart.invokes().any(|invoke| match &invoke.source {
            InvokeSource::Inline(inner) => may_send_to(process, inner),
            InvokeSource::File(_) | InvokeSource::Computed(_) => true,
            InvokeSource::Broken(_) => false,
        })
}
