//! A process that answers each request exactly once, when the answer is known.

use std::fmt::Debug;
use std::hash::Hash;
use std::time::Duration;

use channels::{
    Action, ChannelId, Envelope, Message, NoNormalForm, NormalForm, Offer, Pattern, Process, ProcessId, Topology,
    TransitionId, Use, WiringError,
};

/// The state of a service, apart from its clients. The default is the initial state.
pub trait Handler: Clone + Debug + Default + Eq + Hash + Send + Sync + 'static {
    /// The answer to a request; `None` if it is not known yet.
    fn answer(&self, request: &Message) -> Option<Message>;

    /// A request is received.
    fn received(&mut self, request: &Message) {
        let _ = request;
    }

    /// The answer to a request is sent.
    fn answered(&mut self, request: &Message) {
        let _ = request;
    }

    /// The state after a crash and restart.
    #[must_use]
    fn restarted(&self) -> Self {
        Self::default()
    }

    /// Brings the state into normal form ([`Process::normalize`]).
    fn normalize(&mut self) {}

    /// The current location in a word or two; `is_asked` if a client waits for an answer.
    fn location(&self, is_asked: bool) -> String;
}

/// The process that answers requests as its handler determines: for each client, the channel of its requests and the
/// channel of its answers.
///
/// A client's next request is received only after the previous one has been answered. The reply carries the request's
/// number. Each client has two transitions: receive and reply.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Service<H> {
    clients: Vec<Client>,
    pub(crate) handler: H,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Client {
    requests: ChannelId,
    replies: ChannelId,
    /// The request that waits for an answer.
    pending: Option<Envelope>,
}

impl<H: Handler> Service<H> {
    /// The service of this process, in its initial state, to every process with a channel to it.
    ///
    /// # Errors
    /// [`WiringError::MissingChannel`] if a client has no channel back.
    pub fn new(topology: &Topology, process: ProcessId) -> Result<Self, WiringError> {
        let incoming = topology.channels().filter(|&channel| topology.get(channel).target == process);
        let clients = incoming.map(|requests| {
            let (client, component) = topology.ends(requests);
            let replies = topology.find_channel(component, client).ok_or_else(|| WiringError::MissingChannel {
                process: component.to_owned(),
                channel: format!("{component} → {client}"),
            })?;
            Ok(Client { requests, replies, pending: None })
        });
        Ok(Self { clients: clients.collect::<Result<_, _>>()?, handler: H::default() })
    }

    /// Restarts it, after a crash. Requests that were pending are never answered.
    pub fn restart(&mut self) {
        for client in &mut self.clients {
            client.pending = None;
        }
        self.handler = self.handler.restarted();
    }

    /// Whether a client waits for an answer.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        self.clients.iter().any(|client| client.pending.is_some())
    }
}

impl<H: Handler> Process for Service<H> {
    /// Offers to receive a request from each client without a pending one, and to send each answer that is known.
    fn offers(&self, offers: &mut Vec<Offer>) {
        for (index, client) in self.clients.iter().enumerate() {
            let number = 2 * index as u32;
            offers.extend(match &client.pending {
                None => {
                    let action = Action::Receive(client.requests, Pattern::Any);
                    Some(Offer { transition: TransitionId(number), action })
                }
                Some(request) => self.handler.answer(&request.message).map(|message| {
                    let action = Action::Send(client.replies, Envelope { message, request: request.request });
                    Offer { transition: TransitionId(number + 1), action }
                }),
            });
        }
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        let pending = &mut self.clients[transition.0 as usize / 2].pending;
        if let Some(request) = pending.take() {
            self.handler.answered(&request.message);
        }
        *pending = received;
        if let Some(request) = pending {
            self.handler.received(&request.message);
        }
    }

    fn uses(&self) -> Vec<Use> {
        let uses = |client: &Client| [Use::Receives(client.requests, None), Use::Sends(client.replies, None)];
        self.clients.iter().flat_map(uses).collect()
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        for client in &mut self.clients {
            client.pending.iter_mut().for_each(|request| form.number(client.requests, &mut request.request));
        }
        self.handler.normalize();
        Ok(())
    }

    fn location(&self) -> String {
        self.handler.location(self.is_asked())
    }
}
