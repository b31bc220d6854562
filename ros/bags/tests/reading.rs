//! Reads bags, with mappings and without.

use std::path::Path;

use bags::{Bag, Events, Following, Found, Mapping, Received, Source as _};
use channels::{Event, EventKind, Topology};

/// When the messages of a bag were recorded, in milliseconds, and what is lost.
pub(crate) fn times(bag: &Bag) -> (Vec<i64>, Vec<String>) {
    let all: Vec<usize> = (0..bag.survey().topics.len()).collect();
    let (mut messages, mut body, mut times) = (bag.messages(&all), Vec::new(), Vec::new());
    while let Some(head) = messages.next_into(&mut body) {
        times.push(head.log_ns / 1_000_000);
    }
    (times, messages.lost().to_vec())
}

pub(crate) fn mapping(text: &str) -> Mapping {
    match Mapping::load(Path::new("mapping.toml"), &|_| Ok(text.as_bytes().to_vec())) {
        Ok(mapping) => mapping,
        Err(diagnostics::Error::Problems(problems)) => panic!("{}", problems.plain()),
        Err(error) => panic!("{error}"),
    }
}

pub(crate) fn nothing(_: &Path) -> std::io::Result<Vec<u8>> {
    Err(std::io::ErrorKind::NotFound.into())
}

/// The events as lines, and the notes.
pub(crate) fn read_with(bag: &Bag, text: &str) -> (Vec<String>, Vec<String>) {
    let mapping = mapping(text);
    let compiled = mapping.compile(bag.survey(), None, &nothing);
    let compiled = compiled.unwrap_or_else(|problems| panic!("{}", problems.plain()));
    let topology = compiled.topology.clone();
    let mut events = Events::new(Box::new(bag.messages_on(mapping.topics())), &mapping, compiled, &nothing);
    let lines = lines(&mut events, &topology).collect();
    (lines, events.notes())
}

/// What is found, as lines, without what vouches for it.
pub(crate) fn lines(events: &mut Events<'_>, topology: &Topology) -> impl Iterator<Item = String> {
    events.filter(|found| !matches!(found, Found::Vouched(..))).map(|found| line(found, topology))
}

/// What has been found, as a line.
pub(crate) fn line(found: Found, topology: &Topology) -> String {
    match found {
        Found::Event(Event { step, tick, time, kind: EventKind::Tick }) => {
            format!("{} ms: {step}, tick {tick}", time.as_millis())
        }
        Found::Event(Event { step, tick, time, kind: EventKind::Received { channel, message } }) => {
            format!("{} ms: {step}, tick {tick}: {} {message}", time.as_millis(), topology.describe(channel))
        }
        Found::LeftOut(gap) if gap.ends => format!("{} since {:?}", gap.why, gap.since),
        Found::LeftOut(gap) => gap.why,
        Found::Resumed(channel) => format!("{} goes on", topology.describe(channel)),
        Found::Vouched(channel, ground) => format!("{}: {ground}", topology.describe(channel)),
        Found::Noted(note) => note,
        Found::Ended(time) => format!("{} ms: the end", time.as_millis()),
        Found::Idle => "idle".to_owned(),
    }
}

/// When the messages were recorded, in milliseconds, until there is none for now or it is over.
pub(crate) fn received(following: &mut Following) -> (Vec<i64>, Received) {
    let (mut times, mut body) = (Vec::new(), Vec::new());
    loop {
        match following.receive(&mut body) {
            Received::Message(head) => times.push(head.log_ns / 1_000_000),
            end => return (times, end),
        }
    }
}
