//! What a run exchanges with its partners.

use channels::{ChannelSystem, ProcessId};
use remote::{NodeMessage, RemoteClients, RemoteProcess, ServiceRequest};

use super::losses::Losses;
use crate::partners::Partners;

/// The partners of a run, and the processes that represent them.
pub(super) struct Partnership {
    pub(super) partners: Partners,
    /// The processes of components that are nodes of ROS 2.
    pub(super) remote: Vec<ProcessId>,
    /// The process of nodes of ROS 2 that are clients of components.
    clients: Option<ProcessId>,
    /// The components' responses and messages for nodes of ROS 2 in the last step.
    pub(super) outbox: Vec<NodeMessage>,
    /// Whether a step has begun that waits for partners.
    pub(super) is_waiting: bool,
    /// What nodes of ROS 2 have sent and was lost.
    pub(super) losses: Losses,
}

impl Partnership {
    /// Without partners yet.
    pub(super) fn of(system: &ChannelSystem, clients: Option<ProcessId>) -> Self {
        let processes = system.topology().processes();
        let remote = processes.filter(|id| system.process::<RemoteProcess>(*id).is_some()).collect();
        let (outbox, losses) = (Vec::new(), Losses::default());
        Self { partners: Partners::None, remote, clients, outbox, is_waiting: false, losses }
    }

    pub(super) fn has_controller(&self) -> bool {
        matches!(self.partners, Partners::Controller(_))
    }

    pub(super) fn clients<'s>(&self, system: &'s mut ChannelSystem) -> Option<&'s mut RemoteClients> {
        system.process_mut(self.clients?)
    }

    /// Sends the requests of this step to the components that are nodes of ROS 2, and collects what other components
    /// send to such nodes.
    pub(super) fn send(&mut self, system: &mut ChannelSystem) {
        if let Some(clients) = self.clients(system) {
            self.outbox.extend(clients.take_outbox());
        }
        let Some(components) = self.partners.components() else { return };
        let remote = self.remote.iter();
        let requests = remote.filter_map(|id| Some(system.process_mut::<RemoteProcess>(*id)?.take_requests()));
        let requests: Vec<ServiceRequest> = requests.flatten().collect();
        if !requests.is_empty() {
            components.send(requests);
        }
    }

    /// Cancels the goals that nodes of ROS 2 pursue for this run, ends those that they have sent, and disconnects them.
    pub(super) fn leave(&mut self, system: &mut ChannelSystem) {
        self.clients(system).into_iter().for_each(RemoteClients::conclude);
        for id in &self.remote {
            system.process_mut::<RemoteProcess>(*id).into_iter().for_each(RemoteProcess::conclude);
        }
        self.send(system);
        self.partners.leave(&self.outbox);
    }
}
