//! The messages that a device sends.

use skills::{Adapter as _, ChannelAdapter, Datum};

/// How a device answers and publishes.
pub(crate) struct Lines<'a>(&'a mut ChannelAdapter);

impl<'a> Lines<'a> {
    pub(crate) fn new(adapter: &'a mut ChannelAdapter) -> Self {
        Self(adapter)
    }

    /// Answers a request with these fields.
    pub(crate) fn answer<const N: usize>(&mut self, client: &str, fields: [(&str, Datum); N]) {
        self.send(Some(client), "ok", fields);
    }

    /// Answers that a request cannot be fulfilled.
    pub(crate) fn refuse(&mut self, client: &str, reason: &str) {
        self.send(Some(client), "error", [("reason", Datum::text(reason))]);
    }

    pub(crate) fn publish<const N: usize>(&mut self, topic: &str, fields: [(&str, Datum); N]) {
        self.send(None, topic, fields);
    }

    fn send<const N: usize>(&mut self, target: Option<&str>, head: &str, fields: [(&str, Datum); N]) {
        let data = Datum::object(fields).expect("a few fields");
        self.0.send(target, head, &data).expect("a device answers each request once, as its interface requires");
    }
}
