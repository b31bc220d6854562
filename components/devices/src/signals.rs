//! Buttons and microphones: presses and requests at set times.

use std::collections::VecDeque;
use std::time::Duration;

use channels::{NoNormalForm, NormalForm};
use skills::Datum;

use crate::lines::Lines;

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Signals {
    kind: SignalKind,
    /// Future signals and their times, in order.
    coming: VecDeque<(Duration, String)>,
    /// Signals that have arrived and have not been requested.
    noticed: VecDeque<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum SignalKind {
    Button,
    Microphone,
}

impl Signals {
    pub(crate) fn of_button(pressed: &[Duration]) -> Self {
        Self::new(SignalKind::Button, pressed.iter().map(|at| (*at, String::new())).collect())
    }

    pub(crate) fn of_microphone(hears: &[(Duration, String)]) -> Self {
        Self::new(SignalKind::Microphone, hears.to_vec())
    }

    fn new(kind: SignalKind, mut coming: Vec<(Duration, String)>) -> Self {
        coming.sort_by_key(|(at, _)| *at);
        Self { kind, coming: coming.into(), noticed: VecDeque::new() }
    }

    /// Signals that arrived while it was down are lost.
    pub(crate) fn restart(&mut self, now: Duration) {
        self.miss(now);
        self.noticed.clear();
    }

    /// Drops signals that have arrived by now and have not been noticed yet.
    pub(crate) fn miss(&mut self, now: Duration) {
        self.coming.retain(|(at, _)| *at > now);
    }

    pub(crate) fn next(&self) -> Option<Duration> {
        self.coming.front().map(|(at, _)| *at)
    }

    /// Notices signals that have arrived by now, unless it is deaf.
    pub(crate) fn notice(&mut self, now: Duration, is_deaf: bool, lines: &mut Lines<'_>) {
        while self.next().is_some_and(|at| at <= now) {
            let Some((_, text)) = self.coming.pop_front() else { return };
            if is_deaf {
                continue;
            }
            match self.kind {
                SignalKind::Button => lines.publish("pressed", []),
                SignalKind::Microphone => lines.publish("heard", [("text", Datum::text(&text))]),
            }
            self.noticed.push_back(text);
        }
    }

    pub(crate) fn handle(&mut self, client: &str, lines: &mut Lines<'_>) {
        match self.kind {
            SignalKind::Button => {
                lines.answer(client, [("pressed", Datum::from(!self.noticed.is_empty()))]);
                self.noticed.clear();
            }
            SignalKind::Microphone => {
                let text = self.noticed.pop_front().unwrap_or_default();
                lines.answer(client, [("text", Datum::text(&text))]);
            }
        }
    }

    pub(crate) fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        self.coming.iter_mut().for_each(|(at, _)| form.time(at));
        form.queue(self.noticed.len(), || format!("more than {} signals wait to be requested", NormalForm::QUEUE))
    }

    pub(crate) fn location(&self) -> String {
        match (self.kind, self.noticed.front()) {
            (SignalKind::Button, Some(_)) => "pressed".to_owned(),
            (SignalKind::Microphone, Some(text)) => format!("heard: {text}"),
            (_, None) => "idle".to_owned(),
        }
    }
}
