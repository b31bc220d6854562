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
    /// `_event.sendid`: the id of the `<send>` that sent it, if it had one.
    pub send_id: Option<Arc<str>>,
    /// `_event.origin`: where an answer should go.
    pub origin: Option<Arc<str>>,
    /// `_event.origintype`: the event I/O processor that would deliver it there.
    pub origin_type: Option<Arc<str>>,
    /// `_event.invokeid`: the id of the invoked machine that sent it, if one did.
    pub invoke_id: Option<Arc<str>>,
    /// `_event.data`
    pub data: Datum,
    /// All parameters in order, if two of them have the same name; `data` has only the last of these.
    pub(crate) repeated: Option<Params>,
}

/// Parameters in the order they were sent.
pub type Params = Arc<[(Arc<str>, Datum)]>;

/// The origin of an event.
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
    /// An event with this name from outside, without data.
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

    /// The same event with this origin and event I/O processor.
    #[must_use]
    pub fn with_origin(mut self, origin: impl Into<Arc<str>>, origin_type: impl Into<Arc<str>>) -> Self {
        self.origin = Some(origin.into());
        self.origin_type = Some(origin_type.into());
        self
    }
}

/// An event that a machine sends to another process.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Outgoing {
    /// The event I/O processor, as named by the `type` of `<send>`: `channel`.
    pub processor: Arc<str>,
    /// Its target.
    pub target: Option<Arc<str>>,
    /// The event's name; `None` if only content is sent.
    pub event: Option<Arc<str>>,
    /// The id of the `<send>`.
    pub send_id: Option<Arc<str>>,
    /// An object with one member per parameter, or the content.
    pub data: Datum,
    /// All parameters in order, if two of them have the same name; `data` has only the last of these.
    pub repeated: Option<Params>,
}
