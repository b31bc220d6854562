//! The machines of a model, with the names of their processes.

use std::collections::BTreeMap;

use bt::NodeId;

use crate::machine::{DataKind, Machine, TREE};

pub(crate) type Fields = Vec<(String, DataKind)>;

/// The event of the topic `clock`, a `builtin_interfaces/Time`.
pub(crate) const CLOCK_EVENT: &str = "topic_clock_msg";

/// The names of processes that every model has.
const TICK_GENERATOR: &str = "TickGenerator";
pub(crate) const CLOCK: &str = "Clock";
pub(crate) const RECORDER: &str = "Recorder";
/// Names that no machine may have.
pub(crate) const RESERVED: [&str; 4] = [TREE, TICK_GENERATOR, CLOCK, RECORDER];

#[derive(Clone, Debug)]
pub(crate) struct Instance {
    pub(crate) name: String,
    pub(crate) leaf: Option<NodeId>,
    pub(crate) machine: Machine,
}

/// The fields of every event that the machines of a model send, with their kinds.
pub(crate) fn events(machines: &[Instance]) -> BTreeMap<String, Fields> {
    let mut events: BTreeMap<String, Fields> = BTreeMap::new();
    let time = [("sec", DataKind::Int), ("nanosec", DataKind::Int)];
    events.insert(CLOCK_EVENT.to_owned(), time.map(|(name, kind)| (name.to_owned(), kind)).to_vec());
    for (event, sent) in machine_processes(machines).into_iter().flat_map(|process| &process.machine.sends) {
        let fields = events.entry(event.clone()).or_default();
        for (name, kind) in &sent.fields {
            match fields.iter_mut().find(|(known, _)| known == name) {
                Some((_, known)) => *known = known.or(*kind),
                None => fields.push((name.clone(), *kind)),
            }
        }
    }
    events
}

/// A machine that becomes a process: an instance of the model, or one of its threads.
#[derive(Debug)]
pub(crate) struct MachineProcess<'m> {
    pub(crate) name: String,
    pub(crate) machine: &'m Machine,
    pub(crate) instance: &'m Instance,
    /// The index of the instance's own process, and the thread's number.
    pub(crate) thread: Option<(usize, usize)>,
}

pub(crate) fn machine_processes(machines: &[Instance]) -> Vec<MachineProcess<'_>> {
    let mut processes = Vec::new();
    for instance in machines {
        let own = processes.len();
        let name = instance.name.clone();
        processes.push(MachineProcess { name, machine: &instance.machine, instance, thread: None });
        for thread in &instance.machine.threads {
            for number in 0..thread.count {
                let name = format!("{} thread {number}", instance.name);
                processes.push(MachineProcess {
                    name,
                    machine: &thread.machine,
                    instance,
                    thread: Some((own, number)),
                });
            }
        }
    }
    processes
}
