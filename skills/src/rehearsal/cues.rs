//! The events for a machine that runs alone: a file with one event per line.

use std::sync::Arc;
use std::time::Duration;

use diagnostics::{Problem, Source, did_you_mean};

use crate::chart::is_event_name;
use crate::event::Event;
use crate::expression::literal;
use crate::{Datum, SkillError};

/// An event and its time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cue {
    /// Since the start of the run.
    pub at: Duration,
    /// The event.
    pub event: Event,
}

/// Events in chronological order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cues(Vec<Cue>);

const MEMBERS: [&str; 6] = ["event", "time_s", "data", "origin", "origintype", "sendid"];

impl Cues {
    /// Reads events, one JSON object per line: `{"event": "BatteryReader.ok", "time_s": 1.5, "data": {"level": 83.2}}`.
    /// Only `event` is required. Without `time_s`, in seconds since the start, an event follows directly after the
    /// previous one. `origin`, `origintype` and `sendid` are those of `_event`. Empty lines and lines that begin with
    /// `#` or `//` are ignored.
    ///
    /// # Errors
    /// [`SkillError::Events`] with every line that is not a valid event, or that is earlier than the previous one.
    pub fn parse(file: &str, text: &str) -> Result<Self, SkillError> {
        let (mut cues, mut problems) = (Vec::new(), Vec::new());
        let (mut start, mut last) = (0, Duration::ZERO);
        for line in text.split_inclusive('\n') {
            let trimmed = line.trim();
            let span = start..start + line.trim_end().len();
            start += line.len();
            if trimmed.is_empty() || trimmed.starts_with('#') || trimmed.starts_with("//") {
                continue;
            }
            match cue(trimmed, last) {
                Ok(cue) => {
                    last = cue.at;
                    cues.push(cue);
                }
                Err((message, help)) => problems.push(Problem::new(message).at(span, "this line").with_help_if(help)),
            }
        }
        if problems.is_empty() {
            return Ok(Self(cues));
        }
        let text = Source::new(file, text);
        Err(SkillError::Events { file: file.to_owned(), text, problems })
    }

    /// The events in chronological order.
    pub fn iter(&self) -> impl Iterator<Item = &Cue> {
        self.0.iter()
    }
}

type Complaint = (String, Option<String>);

fn cue(line: &str, last: Duration) -> Result<Cue, Complaint> {
    let example = || Some(r#"{"event": "BT.tick", "time_s": 1.5, "data": {}}"#.to_owned());
    // JSON is a part of ECMAScript (ECMA-262, since 2019), so the parser of expressions reads it.
    let Some(Datum::Object(object)) = literal(line) else {
        return Err(("this is not a JSON object".to_owned(), example()));
    };
    if let Some((name, _)) = object.members().find(|(name, _)| !MEMBERS.contains(name)) {
        return Err((format!("an event has no `{name}`"), did_you_mean(name, MEMBERS).or_else(example)));
    }
    let text = |name: &str| match object.get(name) {
        None | Some(Datum::Null) => Ok(None),
        Some(Datum::Text(text)) => Ok(Some(Arc::clone(text))),
        Some(other) => Err((format!("`{name}` must be a string, not {other}"), None)),
    };
    let Some(name) = text("event")? else {
        return Err(("the event has no name".to_owned(), example()));
    };
    if !is_event_name(&name) {
        let help = "use words joined by dots: `door.opened`".to_owned();
        return Err((format!("`{name}` cannot be the name of an event"), Some(help)));
    }
    let at = match object.get("time_s") {
        None => last,
        Some(Datum::Number(seconds)) => Duration::try_from_secs_f64(*seconds)
            .map_err(|_| (format!("{seconds} s is not a time since the start"), None))?,
        Some(other) => return Err((format!("`time_s` must be a number of seconds, not {other}"), None)),
    };
    if at < last {
        let help = format!("the previous event is at {} s", last.as_secs_f64());
        return Err(("events must be in chronological order".to_owned(), Some(help)));
    }
    let mut event = Event::external(name).with_data(object.get("data").cloned().unwrap_or_default());
    (event.origin, event.origin_type, event.send_id) = (text("origin")?, text("origintype")?, text("sendid")?);
    Ok(Cue { at, event })
}

#[cfg(test)]
mod tests {
    use miette::Diagnostic;

    use super::*;

    #[test]
    fn an_event_has_a_name_that_a_machine_can_match() {
        let text = "{\"event\": \"a.b\"}\n{\"event\": \"\"}\n# none\n{\"event\": \"a b\"}\n{\"event\": \"a..b\"}\n{\"event\": \"*\"}\n";
        let error = Cues::parse("events.jsonl", text).unwrap_err();
        let related = error.related().unwrap();
        let reported: Vec<(String, usize)> = related
            .map(|problem| {
                let offset = problem.labels().unwrap().next().unwrap().offset();
                (problem.to_string(), 1 + text[..offset].matches('\n').count())
            })
            .collect();
        let unfit = |name: &str, line| (format!("`{name}` cannot be the name of an event"), line);
        assert_eq!(reported, [unfit("", 2), unfit("a b", 4), unfit("a..b", 5), unfit("*", 6)]);
        assert!(Cues::parse("events.jsonl", "{\"event\": \"done.invoke.x\"}").is_ok());
    }
}
