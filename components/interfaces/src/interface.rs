//! Services, topics and actions, and the messages that carry their requests and answers.

use channels::{FieldKind, Role, Shape};
use diagnostics::Problem;

use crate::wire::Wire;

/// `m[1]` of a goal, after the name of its action and a dot.
pub const GOAL: &str = "goal";
/// `m[1]` of a cancel request, likewise.
pub const CANCEL: &str = "cancel";
/// `m[1]` of the reply of a service that did what was requested.
pub const OK: &str = "ok";
/// `m[1]` of the answer to a request that could not be carried out.
pub const ERROR: &str = "error";
/// `m[1]` of the answer to a goal that will be pursued.
pub const ACCEPTED: &str = "accepted";
/// `m[1]` of the answer to a goal that will not be pursued.
pub const REJECTED: &str = "rejected";
/// `m[1]` of the feedback on a goal.
pub const FEEDBACK: &str = "feedback";
/// `m[1]` of the end of an action that reached its goal.
pub const SUCCEEDED: &str = "succeeded";
/// `m[1]` of the end of an action that could not reach its goal.
pub const ABORTED: &str = "aborted";
/// `m[1]` of the end of an action that was canceled.
pub const CANCELED: &str = "canceled";

/// No topic may have one of these names: replies of services begin with them.
pub const RESERVED: [&str; 2] = [OK, ERROR];

/// The name of `m[1]` in messages to a component.
pub const REQUEST: &str = "request";
/// The name of `m[1]` in messages from a component.
pub const STATUS: &str = "status";
/// The name of `m[1]` in the messages of a topic.
pub const TOPIC: &str = "topic";
/// The name of the field with the reason of a failure.
pub const REASON: &str = "reason";

/// A message has at most this many fields after the symbols with which it begins.
pub const MAX_FIELDS: usize = 64;

/// The services, topics and actions of a component.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Interface {
    /// Requests with one reply each.
    pub services: Vec<Service>,
    /// The topics that it publishes to any number of subscribers.
    pub topics: Vec<Topic>,
    /// Its actions, which take time: a goal, feedback on the way, and a result.
    pub actions: Vec<Action>,
}

/// A field of a message: `m[2]`, `m[3]`, … in the order of the fields, after the symbols that name the message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// The name under which state machines read it: `_event.data.NAME`.
    pub name: String,
    /// What it may hold.
    pub kind: FieldKind,
}

/// A request with one reply: `[<NAME>, request…]` is answered by `[<ok>, reply…]` or `[<error>, reason]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Service {
    /// `m[1]` of the request.
    pub name: String,
    /// The fields of the request.
    pub request: Vec<Field>,
    /// The fields of the reply if the service did what was requested.
    pub reply: Vec<Field>,
    /// What it is in ROS 2, or why that is not known.
    pub wire: Result<Wire, String>,
}

/// A topic that a component publishes. Each subscriber gets `[<NAME>, fields…]`, and a newer message replaces one that
/// waits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// `m[1]` of the message.
    pub name: String,
    /// The other fields.
    pub fields: Vec<Field>,
    /// What it is in ROS 2, or why that is not known.
    pub wire: Result<Wire, String>,
}

/// An action of a component, which takes time.
///
/// The goal `[<NAME.goal>, goal…]` is answered by `[<NAME.accepted>]` or `[<NAME.rejected>, reason]`. If it is
/// accepted, any number of `[<NAME.feedback>, feedback…]` follow, and then one of `[<NAME.succeeded>, result…]`,
/// `[<NAME.aborted>, reason]` and `[<NAME.canceled>]`. `[<NAME.cancel>]` requests the last of these.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Action {
    /// `m[1]` of each of its messages, up to the dot.
    pub name: String,
    /// The fields of a goal.
    pub goal: Vec<Field>,
    /// The fields of feedback.
    pub feedback: Vec<Field>,
    /// The fields of the result.
    pub result: Vec<Field>,
    /// What it is in ROS 2, or why that is not known.
    pub wire: Result<Wire, String>,
}

/// A part of an interface.
#[derive(Clone, Copy, Debug)]
pub enum Operation<'i> {
    /// A service.
    Service(&'i Service),
    /// A topic.
    Topic(&'i Topic),
    /// An action.
    Action(&'i Action),
}

impl Interface {
    /// The interface reduced to the operations for which `uses` holds: the part that concerns one client.
    #[must_use]
    pub fn restricted_to(&self, uses: impl Fn(Operation<'_>) -> bool) -> Self {
        let mut part = self.clone();
        part.services.retain(|service| uses(Operation::Service(service)));
        part.topics.retain(|topic| uses(Operation::Topic(topic)));
        part.actions.retain(|action| uses(Operation::Action(action)));
        part
    }

    /// The shapes of the messages that a client using all of this may send to the component: requests of services,
    /// goals and cancel requests. A client that only subscribes sends nothing.
    #[must_use]
    pub fn requests(&self) -> Vec<Shape> {
        let actions = self.actions.iter().flat_map(Action::requests);
        self.services.iter().map(Service::request).chain(actions).collect()
    }

    /// The shapes of the messages that the component may send to a client using all of this, each once: replies of
    /// services, the answers of actions, and topics.
    ///
    /// # Errors
    /// If the replies of two services cannot be distinguished by the kinds of their fields, but the fields have
    /// different names: a reader would not know which names are meant. The problem has no location.
    ///
    /// ```
    /// use channels::FieldKind;
    /// use interfaces::{Field, Interface, Service};
    ///
    /// let real = |name: &str| vec![Field { name: name.to_owned(), kind: FieldKind::Real }];
    /// let service = |name: &str, reply| {
    ///     let wire = Err("it is not in ROS".to_owned());
    ///     Service { name: name.to_owned(), request: Vec::new(), reply, wire }
    /// };
    /// let services = vec![service("get_level", real("level")), service("get_current", real("amperes"))];
    /// let mut interface = Interface { services, ..Interface::default() };
    /// let problem = interface.replies().unwrap_err();
    /// assert_eq!(
    ///     problem.to_string(),
    ///     "a reply of `get_level`, with `level`, looks like one of `get_current`, with `amperes`"
    /// );
    /// interface.services[1].reply = real("level");
    /// assert!(interface.replies().is_ok());
    /// ```
    pub fn replies(&self) -> Result<Vec<Shape>, Problem> {
        for (index, service) in self.services.iter().enumerate() {
            let alike = self.services[..index].iter().find(|earlier| earlier.is_confused_with(service));
            if let Some(earlier) = alike {
                return Err(confusion(earlier, service));
            }
        }
        let mut shapes: Vec<Shape> = Vec::new();
        let replies = self.services.iter().flat_map(Service::replies);
        let answers = self.actions.iter().flat_map(Action::answers);
        for shape in replies.chain(answers).chain(self.topics.iter().map(Topic::message)) {
            if !shapes.contains(&shape) {
                shapes.push(shape);
            }
        }
        Ok(shapes)
    }
}

impl Service {
    /// The request.
    #[must_use]
    pub fn request(&self) -> Shape {
        shape(REQUEST, &self.name, &self.request, Role::Request)
    }

    /// The replies: success and failure.
    #[must_use]
    pub fn replies(&self) -> [Shape; 2] {
        [shape(STATUS, OK, &self.reply, Role::Reply), shape(STATUS, ERROR, &[reason()], Role::Reply)]
    }

    /// Whether a message can be a reply of both, with different names for its fields.
    fn is_confused_with(&self, other: &Self) -> bool {
        let fields = || self.reply.iter().zip(&other.reply);
        self.reply.len() == other.reply.len()
            && fields().any(|(one, other)| one.name != other.name)
            && fields().all(|(one, other)| intersect(&one.kind, &other.kind))
    }
}

impl Topic {
    /// The message to a subscriber.
    #[must_use]
    pub fn message(&self) -> Shape {
        shape(TOPIC, &self.name, &self.fields, Role::Topic)
    }
}

impl Action {
    /// The requests to the component: a goal, and a request to cancel it.
    #[must_use]
    pub fn requests(&self) -> [Shape; 2] {
        let request = |part, fields: &[Field], role| shape(REQUEST, &format!("{}.{part}", self.name), fields, role);
        [request(GOAL, &self.goal, Role::Goal), request(CANCEL, &[], Role::Cancel)]
    }

    /// The component's answers: accepted, rejected, feedback, succeeded, aborted, canceled.
    #[must_use]
    pub fn answers(&self) -> [Shape; 6] {
        let answer = |part, fields: &[Field], role| shape(STATUS, &format!("{}.{part}", self.name), fields, role);
        [
            answer(ACCEPTED, &[], Role::Feedback),
            answer(REJECTED, &[reason()], Role::Result),
            answer(FEEDBACK, &self.feedback, Role::Feedback),
            answer(SUCCEEDED, &self.result, Role::Result),
            answer(ABORTED, &[reason()], Role::Result),
            answer(CANCELED, &[], Role::Result),
        ]
    }
}

fn shape(first: &str, head: &str, fields: &[Field], role: Role) -> Shape {
    let head = (first.to_owned(), FieldKind::symbols([head]));
    let fields = fields.iter().map(|field| (field.name.clone(), field.kind.clone()));
    Shape::new(std::iter::once(head).chain(fields)).with_role(role)
}

fn reason() -> Field {
    Field { name: REASON.to_owned(), kind: FieldKind::Text }
}

/// Whether both kinds have a value in common.
fn intersect(one: &FieldKind, other: &FieldKind) -> bool {
    use FieldKind::{Optional, Symbol};
    match (one, other) {
        (Optional(_), Optional(_)) => true,
        (Optional(kind), other) | (other, Optional(kind)) => {
            intersect(kind, other) || other.contains(&channels::Value::symbol(FieldKind::NONE))
        }
        (Symbol(one), Symbol(other)) => one.iter().any(|symbol| other.contains(symbol)),
        (one, other) => one == other,
    }
}

fn confusion(earlier: &Service, service: &Service) -> Problem {
    let names = |service: &Service| {
        let names: Vec<String> = service.reply.iter().map(|field| format!("`{}`", field.name)).collect();
        names.join(", ")
    };
    let problem = Problem::new(format!(
        "a reply of `{}`, with {}, looks like one of `{}`, with {}",
        earlier.name,
        names(earlier),
        service.name,
        names(service)
    ));
    problem.with_help("give the fields the same names in both, such as `value`, or let no client use both services")
}
