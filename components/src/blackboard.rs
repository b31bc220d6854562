//! Blackboard: lets only one skill navigate at a time, as in the paper's published system.

use std::collections::BTreeSet;
use std::sync::Arc;

use channels::{Message, Value};

use crate::service::{Handler, Service};

/// The process Blackboard: an integer that a skill must lock before it may write it.
///
/// The published component (`BlackboardComponent.cpp`) holds any number of entries. The only one in use counts how many
/// skills may navigate, initially 1. Each request names its skill and the entry:
///
/// - `[<lock>, skill, <navigation>]` and `[<unlock>, …]` are answered with `[<ok>, true]`;
/// - `[<read_data>, …]` is answered with `[<ok>, value]`;
/// - `[<write_data>, …, value]` is answered with `[<ok>, true]`.
///
/// A request takes effect when it is answered. A skill that may not read, write or unlock gets the answer `[<error>,
/// "unauthorized client"]`.
///
/// The published component refuses a lock that it cannot grant, and the client requests it again until it succeeds.
/// This one answers once it can grant the lock: to one client at a time, and to a client that has read 0 only after the
/// value has changed.
pub type Blackboard = Service<LockedValue>;

/// How many skills may navigate, and which one may change that.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct LockedValue {
    holder: Option<Arc<str>>,
    value: i64,
    /// The skills that have read 0 since the last write.
    found_zero: BTreeSet<Arc<str>>,
}

impl LockedValue {
    /// The answer to a request, if it is available yet, and the entry afterwards.
    fn serve(&self, request: &Message) -> Option<(Message, Self)> {
        let refused = || Some((Message::new([Value::symbol("error"), "unauthorized client".into()]), self.clone()));
        let (Some(head), Some(Value::Text(skill))) = (request.head(), request.field(2)) else { return refused() };
        let is_holder = self.holder.as_ref() == Some(skill);
        let is_open = is_holder || self.holder.is_none();
        let mut after = self.clone();
        let answer: Value = match (head, request.field(4)) {
            ("lock", _) => {
                // Granted later. A skill that found 0 would only find it again, so it waits for another value.
                if !is_open || self.found_zero.contains(skill) {
                    return None;
                }
                after.holder = Some(Arc::clone(skill));
                true.into()
            }
            ("unlock", _) if is_holder => {
                after.holder = None;
                true.into()
            }
            ("read_data", _) if is_open => {
                if self.value == 0 {
                    after.found_zero.insert(Arc::clone(skill));
                }
                Value::Int(self.value)
            }
            ("write_data", Some(&Value::Int(value))) if is_holder => {
                (after.value, after.found_zero) = (value, BTreeSet::new());
                true.into()
            }
            _ => return refused(),
        };
        Some((Message::new([Value::symbol("ok"), answer]), after))
    }
}

impl Default for LockedValue {
    fn default() -> Self {
        Self { holder: None, value: 1, found_zero: BTreeSet::new() }
    }
}

impl Handler for LockedValue {
    fn answer(&self, request: &Message) -> Option<Message> {
        Some(self.serve(request)?.0)
    }

    fn answered(&mut self, request: &Message) {
        if let Some((_, after)) = self.serve(request) {
            *self = after;
        }
    }

    fn location(&self, _: bool) -> String {
        let Self { holder, value, .. } = self;
        holder.as_ref().map_or_else(|| format!("navigation: {value}"), |skill| format!("navigation: {value}, {skill}"))
    }
}
