//! Localization: reports whether the robot is at a place.

use std::collections::BTreeMap;
use std::sync::Arc;

use channels::{ChannelSystem, Message, ProcessId, Topology, Value, WiringError};
use maps::{Places, Pose};

use crate::service::{Handler, Service};

/// The process Localization. It answers `[<is_at>, <Place>]` with `[<ok>, there]` according to its latest pose
/// estimate, or with `[<error>, reason]` if it does not know the place. Requests before the first estimate wait.
pub type Localization = Service<AtPlaces>;

/// Whether the robot is at each place; empty before the first estimate.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct AtPlaces(Arc<BTreeMap<String, bool>>);

impl Localization {
    /// The localization that serves every process with a channel to `process`.
    ///
    /// # Errors
    /// [`WiringError::MissingChannel`] if a client cannot be answered.
    pub fn new(topology: &Topology, process: ProcessId) -> Result<Self, WiringError> {
        Self::with_handler(topology, process, AtPlaces::default())
    }

    /// Returns it to its initial state.
    pub(crate) fn restart(&mut self) {
        self.forget();
        self.handler = AtPlaces::default();
    }

    /// Receives the latest estimate of the robot's pose, in the `map` frame, and the known places, from its driver.
    pub fn update(&mut self, places: &Places, pose: &Pose) {
        self.handler.0 = Arc::new(places.iter().map(|(name, place)| (name.to_owned(), place.contains(pose))).collect());
    }

    /// Receives the place at which the robot is: one of the known places, or none.
    pub fn set_place<'p>(&mut self, places: impl IntoIterator<Item = &'p str>, place: Option<&str>) {
        let there = self.handler.0.iter().filter(|(_, there)| **there).map(|(name, _)| name.as_str());
        if self.handler.0.is_empty() || there.ne(place) {
            let places = places.into_iter().map(|known| (known.to_owned(), Some(known) == place));
            self.handler.0 = Arc::new(places.collect());
        }
    }

    /// The place at which the robot is, if it is a known one.
    #[must_use]
    pub fn place(&self) -> Option<&str> {
        self.handler.0.iter().find(|(_, there)| **there).map(|(name, _)| name.as_str())
    }
}

impl Handler for AtPlaces {
    fn answer(&self, request: &Message) -> Option<Message> {
        let Some(Value::Symbol(place)) = request.field(2) else {
            return Some(error("the request names no place"));
        };
        if self.0.is_empty() {
            return None;
        }
        Some(match self.0.get(place.name()) {
            Some(&there) => Message::new([Value::symbol("ok"), there.into()]),
            None => error(&format!("there is no place {}", place.name())),
        })
    }

    fn location(&self, is_asked: bool) -> String {
        match (self.0.is_empty(), is_asked) {
            (true, _) => "no estimate yet",
            (_, true) => "asked",
            (_, false) => "idle",
        }
        .to_owned()
    }
}

fn error(reason: &str) -> Message {
    Message::new([Value::symbol("error"), reason.into()])
}

/// Tells Localization which places contain the estimated pose.
#[derive(Clone, Debug)]
pub(crate) struct LocalizationDriver {
    pub(crate) process: ProcessId,
    pub(crate) places: Places,
}

impl LocalizationDriver {
    pub(crate) fn estimate(&self, pose: &Pose, system: &mut ChannelSystem) {
        let changed = system.process::<Localization>(self.process).is_some_and(|process| {
            self.places.iter().any(|(name, place)| process.handler.0.get(name) != Some(&place.contains(pose)))
        });
        if changed && let Some(process) = system.process_mut::<Localization>(self.process) {
            process.update(&self.places, pose);
        }
    }
}
