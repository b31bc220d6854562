//! Answers each request exactly once, when the answer is known.

use channels::{
    Action, ChannelId, Envelope, Message, NormalForm, Offer, Pattern, ProcessId, Topology, TransitionId, Use,
    WiringError,
};

/// The clients of a component: for each, the channel of its requests and the channel of its answers.
///
/// A client's next request is received only after the previous one has been answered. The reply carries the request's
/// number. Each client has two transitions: receive and reply.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Service {
    clients: Vec<Client>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Client {
    requests: ChannelId,
    replies: ChannelId,
    /// The request that waits for an answer.
    pending: Option<Envelope>,
}

impl Service {
    /// The service of this process to every process with a channel to it.
    ///
    /// # Errors
    /// [`WiringError::MissingChannel`] if a client has no channel back.
    pub(crate) fn new(topology: &Topology, process: ProcessId) -> Result<Self, WiringError> {
        let asked = topology.channels().filter(|&channel| topology.get(channel).target == process);
        let clients = asked.map(|requests| {
            let (client, component) = topology.ends(requests);
            let replies = topology.find_channel(component, client).ok_or_else(|| WiringError::MissingChannel {
                process: component.to_owned(),
                channel: format!("{component} → {client}"),
            })?;
            Ok(Client { requests, replies, pending: None })
        });
        Ok(Self { clients: clients.collect::<Result<_, _>>()? })
    }

    /// Offers to receive a request from each client without a pending one, and to send each answer that is known.
    pub(crate) fn offers(&self, answer: impl Fn(&Message) -> Option<Message>, offers: &mut Vec<Offer>) {
        for (index, client) in self.clients.iter().enumerate() {
            let number = 2 * index as u32;
            offers.extend(match &client.pending {
                None => {
                    let action = Action::Receive(client.requests, Pattern::Any);
                    Some(Offer { transition: TransitionId(number), action })
                }
                Some(request) => answer(&request.message).map(|message| {
                    let action = Action::Send(client.replies, Envelope { message, request: request.request });
                    Offer { transition: TransitionId(number + 1), action }
                }),
            });
        }
    }

    /// Takes one of the transitions. Returns the request if it received one.
    pub(crate) fn take(&mut self, transition: TransitionId, received: Option<Envelope>) -> Option<&Message> {
        let client = &mut self.clients[transition.0 as usize / 2];
        client.pending = received;
        client.pending.as_ref().map(|request| &request.message)
    }

    /// The request that a transition answers.
    pub(crate) fn pending(&self, transition: TransitionId) -> Option<&Message> {
        self.clients[transition.0 as usize / 2].pending.as_ref().map(|request| &request.message)
    }

    /// Forgets all pending requests, which are never answered.
    pub(crate) fn forget(&mut self) {
        for client in &mut self.clients {
            client.pending = None;
        }
    }

    /// Brings the numbers of the clients' requests into normal form.
    pub(crate) fn normalize(&mut self, form: &NormalForm<'_>) {
        for client in &mut self.clients {
            client.pending.iter_mut().for_each(|request| form.number(client.requests, &mut request.request));
        }
    }

    /// Everything the service receives and sends.
    pub(crate) fn uses(&self) -> Vec<Use> {
        self.clients
            .iter()
            .flat_map(|client| [Use::Receives(client.requests, None), Use::Sends(client.replies, None)])
            .collect()
    }

    /// Whether a client waits for an answer.
    pub(crate) fn is_asked(&self) -> bool {
        self.clients.iter().any(|client| client.pending.is_some())
    }
}
