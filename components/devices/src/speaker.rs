//! A speaker that says texts.

use std::time::Duration;

use channels::NormalForm;
use skills::Datum;

use crate::lines::Lines;

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Speaker {
    per_letter: Duration,
    speech: Option<Speech>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Speech {
    client: String,
    text: String,
    since: Duration,
    until: Duration,
}

impl Speaker {
    pub(crate) fn new(letters_per_s: f64) -> Self {
        Self { per_letter: Duration::from_secs_f64(1.0 / letters_per_s), speech: None }
    }

    pub(crate) fn restart(&mut self) {
        self.speech = None;
    }

    pub(crate) fn handle(&mut self, client: &str, data: &Datum, now: Duration, lines: &mut Lines<'_>) {
        if self.speech.is_some() {
            lines.refuse(client, "busy");
            return;
        }
        let Some(Datum::Text(text)) = data.member("text") else { return };
        let letters = u32::try_from(text.chars().count()).unwrap_or(u32::MAX);
        let until = now.saturating_add(self.per_letter.saturating_mul(letters));
        self.speech = Some(Speech { client: client.to_owned(), text: text.to_string(), since: now, until });
    }

    pub(crate) fn finishes(&self) -> Option<Duration> {
        self.speech.as_ref().map(|speech| speech.until)
    }

    pub(crate) fn finish(&mut self, now: Duration, is_mute: bool, lines: &mut Lines<'_>) {
        if let Some(Speech { client, text, .. }) = self.speech.take_if(|speech| speech.until <= now) {
            lines.answer(&client, []);
            if !is_mute {
                lines.publish("spoken", [("text", Datum::text(&text))]);
            }
        }
    }

    /// The time at which it began to speak serves only for reports.
    pub(crate) fn normalize(&mut self, form: &NormalForm<'_>) {
        if let Some(speech) = &mut self.speech {
            form.time(&mut speech.until);
            speech.since = NormalForm::NOW;
        }
    }

    pub(crate) fn speech(&self) -> Option<(Duration, &str)> {
        self.speech.as_ref().map(|speech| (speech.since, speech.text.as_str()))
    }

    pub(crate) fn location(&self) -> &'static str {
        if self.speech.is_some() { "speaking" } else { "silent" }
    }
}
