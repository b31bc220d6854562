//! The events to which a machine reacts.

use crate::chart::Descriptor;

/// The events that may be `_event`.
pub(super) struct Trigger<'c>(Option<&'c [Descriptor]>);

impl<'c> Trigger<'c> {
    /// Any event.
    pub(super) fn any() -> Self {
        Self(None)
    }

    /// Those that these descriptors match. Without any, it is the last event.
    pub(super) fn of(descriptors: &'c [Descriptor]) -> Self {
        Self((!descriptors.is_empty()).then_some(descriptors))
    }

    pub(super) fn is_one_of(&self, names: &[String]) -> bool {
        names.is_empty() || names.iter().any(|name| self.may_be(Some(name)))
    }

    /// Whether it may be the event with this name, if that is known.
    pub(super) fn may_be(&self, event: Option<&str>) -> bool {
        let (Some(descriptors), Some(event)) = (self.0, event) else { return true };
        descriptors.iter().any(|descriptor| {
            let prefix = descriptor.text.trim_end_matches('*').trim_end_matches('.');
            prefix.is_empty() || event.strip_prefix(prefix).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        })
    }
}
