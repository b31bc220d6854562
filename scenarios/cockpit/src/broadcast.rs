//! What is sent to browsers, and what a browser that joins later receives.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde_json::{Map, Value, json};
use tokio::sync::broadcast;

use crate::frame::HAPPENINGS;

/// How many frames a browser may be behind before it misses some.
const BACKLOG: usize = 50;

/// A text for browsers.
pub(crate) type Frame = Arc<str>;

/// What a browser receives when it joins or has missed frames.
#[derive(Default)]
struct Present {
    /// What does not change.
    greeting: Option<Frame>,
    /// The latest value of everything else, by its key.
    latest: BTreeMap<String, Value>,
}

impl Present {
    fn take(&mut self, frame: &Map<String, Value>) {
        let anew = frame.contains_key("anew");
        for (key, value) in frame {
            match (key.as_str(), value, self.latest.get_mut(key)) {
                ("messages" | "happenings", Value::Array(new), Some(Value::Array(known))) if !anew => {
                    known.extend(new.iter().cloned());
                    known.drain(..known.len().saturating_sub(HAPPENINGS));
                }
                _ => drop(self.latest.insert(key.clone(), value.clone())),
            }
        }
    }
}

/// Sends frames to browsers.
#[derive(Clone)]
pub(crate) struct Broadcast {
    frames: broadcast::Sender<Frame>,
    present: Arc<Mutex<Present>>,
}

impl Broadcast {
    pub(crate) fn new() -> Self {
        Self { frames: broadcast::channel(BACKLOG).0, present: Arc::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Present> {
        self.present.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins with what does not change.
    pub(crate) fn greet(&self, greeting: &Value) {
        let text: Frame = greeting.to_string().into();
        *self.lock() = Present { greeting: Some(text.clone()), latest: BTreeMap::new() };
        let _ = self.frames.send(text);
    }

    /// Sends what has changed.
    pub(crate) fn send(&self, frame: Map<String, Value>) {
        let mut present = self.lock();
        present.take(&frame);
        // Without a browser, this is not an error.
        let _ = self.frames.send(Value::Object(frame).to_string().into());
    }

    /// Announces that there will be no more frames: the last one is empty.
    pub(crate) fn close(&self) {
        let _ = self.frames.send("".into());
    }

    /// All frames from now on.
    pub(crate) fn listen(&self) -> broadcast::Receiver<Frame> {
        self.frames.subscribe()
    }

    /// The greeting, and a frame with everything else.
    pub(crate) fn present(&self) -> (Option<Frame>, Frame) {
        let present = self.lock();
        let mut all = json!(present.latest);
        all["anew"] = true.into();
        (present.greeting.clone(), all.to_string().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(value: Value) -> Map<String, Value> {
        if let Value::Object(frame) = value { frame } else { panic!("{value}") }
    }

    fn present(broadcast: &Broadcast) -> Value {
        serde_json::from_str(&broadcast.present().1).unwrap()
    }

    #[test]
    fn a_browser_that_joins_late_gets_the_latest_of_everything() {
        let broadcast = Broadcast::new();
        broadcast.greet(&json!({ "greeting": {} }));
        broadcast.send(frame(json!({ "time": 1, "messages": [1, 2], "tree": "<svg/>" })));
        broadcast.send(frame(json!({ "time": 2, "messages": [3] })));
        let all = json!({ "time": 2, "messages": [1, 2, 3], "tree": "<svg/>", "anew": true });
        assert_eq!(present(&broadcast), all);
        assert!(broadcast.present().0.is_some());
        // After a jump, earlier messages belong to another time.
        broadcast.send(frame(json!({ "anew": true, "time": 0, "messages": [9] })));
        assert_eq!(present(&broadcast)["messages"], json!([9]));
    }

    #[test]
    fn only_the_latest_messages_are_kept() {
        let broadcast = Broadcast::new();
        broadcast.send(frame(json!({ "messages": [0] })));
        for number in 1..=HAPPENINGS + 10 {
            broadcast.send(frame(json!({ "messages": [number] })));
        }
        let messages = present(&broadcast)["messages"].take();
        assert_eq!((messages.as_array().unwrap().len(), &messages[0]), (HAPPENINGS, &json!(11)));
    }
}
