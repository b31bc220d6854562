//! Localization: reports whether the robot is at a place.

use std::collections::BTreeMap;
use std::sync::Arc;

use channels::{Message, Value};
use maps::{Places, Pose};

use crate::service::{Handler, Service};

/// The process Localization. It answers `[<is_at>, <Place>]` with `[<ok>, there]` according to its latest pose
/// estimate, or with `[<error>, reason]` if it does not know the place. Requests before the first estimate wait.
pub type Localization = Service<AtPlaces>;

/// Whether the robot is at each place; empty before the first estimate.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct AtPlaces(Arc<BTreeMap<String, bool>>);

impl Localization {
    /// Receives the latest estimate of the robot's pose, in the `map` frame, and the known places, from its driver.
    pub fn update(&mut self, places: &Places, pose: &Pose) {
        self.handler.0 = Arc::new(places.iter().map(|(name, place)| (name.to_owned(), place.contains(pose))).collect());
    }

    /// Whether an update with this pose would change nothing.
    pub(crate) fn is_up_to_date(&self, places: &Places, pose: &Pose) -> bool {
        places.iter().all(|(name, place)| self.handler.0.get(name) == Some(&place.contains(pose)))
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
