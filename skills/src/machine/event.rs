//! Events (SCXML 5.10.1).

use std::sync::Arc;

use crate::Datum;

/// An event, as a machine sees it in `_event`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Event {
    /// `_event.name`: tokens joined by dots.
    pub name: Arc<str>,
    /// `_event.type`
    pub kind: EventKind,
    /// `_event.sendid`: the id of the `<send>` that sent it, if that gave one.
    pub send_id: Option<Arc<str>>,
    /// `_event.origin`: where an answer should go.
    pub origin: Option<Arc<str>>,
    /// `_event.origintype`: the event I/O processor that would bring it there.
    pub origin_type: Option<Arc<str>>,
    /// `_event.invokeid`: the id by which the machine knows the one that sent it, if it has invoked that one.
    pub invoke_id: Option<Arc<str>>,
    /// `_event.data`
    pub data: Datum,
    /// All parameters in order, if two of them have one name; `data` has the last of them alone.
    pub(crate) repeated: Option<Params>,
}

/// Parameters in the order they were sent.
pub type Params = Arc<[(Arc<str>, Datum)]>;

/// Where an event comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// From the processor: errors and `done` events.
    Platform,
    /// Raised by the machine itself.
    Internal,
    /// From outside, or sent by the machine to itself.
    External,
}

impl EventKind {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Platform => "platform",
            Self::Internal => "internal",
            Self::External => "external",
        }
    }
}

impl Event {
    /// An event of that name from outside, without data.
    #[must_use]
    pub fn external(name: impl Into<Arc<str>>) -> Self {
        Self::new(name.into(), EventKind::External)
    }

    pub(crate) fn new(name: Arc<str>, kind: EventKind) -> Self {
        Self {
            name,
            kind,
            send_id: None,
            origin: None,
            origin_type: None,
            invoke_id: None,
            data: Datum::Undefined,
            repeated: None,
        }
    }

    /// `_event.raw`: the event as text, every parameter included.
    pub(crate) fn raw(&self) -> String {
        let mut fields = vec![format!("\"name\": {:?}, \"type\": {:?}", self.name, self.kind.name())];
        let optional = [
            ("sendid", &self.send_id),
            ("origin", &self.origin),
            ("origintype", &self.origin_type),
            ("invokeid", &self.invoke_id),
        ];
        fields.extend(optional.iter().filter_map(|(name, value)| Some(format!("\"{name}\": {:?}", value.as_ref()?))));
        fields.push(match &self.repeated {
            None => format!("\"data\": {}", self.data),
            Some(params) => {
                let params: Vec<String> = params.iter().map(|(name, value)| format!("{name:?}: {value}")).collect();
                format!("\"data\": {{{}}}", params.join(", "))
            }
        });
        format!("{{{}}}", fields.join(", "))
    }

    /// The same event with these data.
    #[must_use]
    pub fn with_data(mut self, data: Datum) -> Self {
        self.data = data;
        self
    }

    /// The same event from there, by that event I/O processor.
    #[must_use]
    pub fn with_origin(mut self, origin: impl Into<Arc<str>>, origin_type: impl Into<Arc<str>>) -> Self {
        self.origin = Some(origin.into());
        self.origin_type = Some(origin_type.into());
        self
    }
}

/// What a machine sends to somebody else.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Outgoing {
    /// The event I/O processor, as the `type` of `<send>` names it: `channel`.
    pub processor: Arc<str>,
    /// Where it goes.
    pub target: Option<Arc<str>>,
    /// The event's name; none if only content is sent.
    pub event: Option<Arc<str>>,
    /// The id that the `<send>` gave it.
    pub send_id: Option<Arc<str>>,
    /// An object with a member per parameter, or the content.
    pub data: Datum,
    /// All parameters in order, if two of them have one name; `data` has the last of them alone.
    pub repeated: Option<Params>,
}
