//! What components do for others.

use channels::Shape;
use components::Operation;
use interfaces::Interface;

/// What somebody can ask, begin or wait for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Subject {
    Request,
    Action,
    Topic,
}

impl Subject {
    pub(super) const ALL: [Self; 3] = [Self::Request, Self::Action, Self::Topic];

    /// The key of an entry of the table `leaves`.
    pub(super) const fn key(self) -> &'static str {
        match self {
            Self::Request => "request",
            Self::Action => "action",
            Self::Topic => "topic",
        }
    }

    /// What a component offers.
    pub(super) const fn noun(self) -> &'static str {
        match self {
            Self::Request => "service",
            Self::Action => "action",
            Self::Topic => "topic",
        }
    }
}

/// Something that a component does for others: the messages that they send and receive.
#[derive(Clone, Debug)]
pub(super) struct Offer {
    pub(super) of: Subject,
    pub(super) name: String,
    /// Of an action, first the goal; of a topic, none.
    pub(super) requests: Vec<Shape>,
    pub(super) replies: Vec<Shape>,
}

impl From<&Operation> for Offer {
    fn from(operation: &Operation) -> Self {
        let (requests, replies) = (vec![operation.request.clone()], operation.replies.clone());
        Self { of: Subject::Request, name: operation.name.to_owned(), requests, replies }
    }
}

impl Offer {
    /// All that a component with this interface does.
    pub(super) fn all(interface: &Interface) -> Vec<Self> {
        let services = interface.services.iter().map(|service| {
            let (requests, replies) = (vec![service.request()], service.replies().to_vec());
            Self { of: Subject::Request, name: service.name.clone(), requests, replies }
        });
        let actions = interface.actions.iter().map(|action| {
            let (requests, replies) = (action.requests().to_vec(), action.answers().to_vec());
            Self { of: Subject::Action, name: action.name.clone(), requests, replies }
        });
        let topics = interface.topics.iter().map(|topic| {
            let (requests, replies) = (Vec::new(), vec![topic.message()]);
            Self { of: Subject::Topic, name: topic.name.clone(), requests, replies }
        });
        services.chain(actions).chain(topics).collect()
    }

    /// Whether one of these messages begins with the symbol.
    pub(super) fn has(shapes: &[Shape], head: &str) -> bool {
        shapes.iter().flat_map(Shape::heads).any(|symbol| symbol.name() == head)
    }
}
