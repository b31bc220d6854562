//! What components do for others.

use channels::{FieldKind, Shape};
use components::Operation;
use interfaces::Interface;

/// What a leaf can ask, begin or wait for.
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

    /// The word by which `success_when` calls the message whose fields it compares.
    pub(super) const fn answer(self) -> &'static str {
        match self {
            Self::Request => "reply",
            Self::Action => "result",
            Self::Topic => "message",
        }
    }
}

/// A message between a leaf and what it asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OfferMessage {
    /// The request or the goal.
    Request,
    /// That with which it succeeds: the reply, the result or the message of a topic.
    Answer,
    /// An action's feedback.
    Feedback,
}

/// Something that a component does for others: the messages that they send and receive.
#[derive(Clone, Debug)]
pub struct Offer {
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

    /// Whether it is a service, an action or a topic.
    #[must_use]
    pub const fn noun(&self) -> &'static str {
        self.of.noun()
    }

    /// The key with which a leaf's entry names it.
    #[must_use]
    pub const fn key(&self) -> &'static str {
        self.of.key()
    }

    /// The word by which `success_when` calls the answer.
    #[must_use]
    pub const fn answer(&self) -> &'static str {
        self.of.answer()
    }

    /// The symbol with which a message to the leaf begins; none for one from it.
    pub(super) fn head(&self, of: OfferMessage) -> Option<String> {
        match (of, self.of) {
            (OfferMessage::Request, _) => None,
            (OfferMessage::Answer, Subject::Request) => Some("ok".to_owned()),
            (OfferMessage::Answer, Subject::Action) => Some(format!("{}.succeeded", self.name)),
            (OfferMessage::Answer, Subject::Topic) => Some(self.name.clone()),
            (OfferMessage::Feedback, _) => Some(format!("{}.feedback", self.name)),
        }
    }

    /// The fields of a message.
    pub fn fields(&self, of: OfferMessage) -> impl Iterator<Item = &(String, FieldKind)> {
        let head = self.head(of);
        let (asked, answers) =
            if head.is_none() { (self.requests.first(), &[][..]) } else { (None, &self.replies[..]) };
        let is_meant = move |shape: &&Shape| shape.heads().iter().any(|symbol| Some(symbol.name()) == head.as_deref());
        let shapes = asked.into_iter().chain(answers.iter().filter(is_meant));
        shapes.flat_map(|shape| shape.fields().iter().skip(1))
    }

    /// Whether one of these messages begins with the symbol.
    pub(super) fn has(shapes: &[Shape], head: &str) -> bool {
        shapes.iter().flat_map(Shape::heads).any(|symbol| symbol.name() == head)
    }
}
