//! Writes what a source delivers, so that it can be read again with the same verdicts.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, Seek, Write};
use std::rc::Rc;

use channels::Ground;
use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use ros_messages::standard::Text;
use ros_messages::{RosMessage as _, RosType as _};

use super::source::{
    Account, CLOCK_ADVANCED, GROUND, LOST, MISSING, Missing, NOTE, Received, Source, VIOLATION, Vouched,
};
use super::survey::{Head, Topic};

/// An MCAP file of the messages of a source, of what it has lost, and of the time that has passed without messages.
///
/// Each message is a record of its own: the file can be [followed](super::Following), and a program that is killed
/// loses only what it had not flushed.
pub struct BagWriter<W: Write + Seek> {
    writer: Writer<W>,
    /// The channels of topics, by their indices, and of notes, by their names.
    topics: BTreeMap<usize, u16>,
    notes: BTreeMap<&'static str, u16>,
    /// The latest time of a record: readers of files without an index expect that none is earlier than the one before.
    newest_ns: i64,
    /// What could not be written; after it, nothing is.
    failed: Option<io::Error>,
}

impl<W: Write + Seek> BagWriter<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin(output: W) -> io::Result<Self> {
        let options = WriteOptions::new().use_chunks(false).profile("ros2").library("steward");
        let writer = options.create(output).map_err(io::Error::other)?;
        Ok(Self { writer, topics: BTreeMap::new(), notes: BTreeMap::new(), newest_ns: 0, failed: None })
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If anything could not be written.
    pub fn finish(&mut self) -> io::Result<()> {
        self.failed.take().map_or(Ok(()), Err)?;
        self.writer.finish().map(drop).map_err(io::Error::other)
    }

    /// Writes a violation, as JSON: for people and their tools, as readers of messages pass over it.
    pub fn violation(&mut self, at_ns: i64, verdict: &str) {
        self.note(VIOLATION, at_ns, verdict);
    }

    /// Lets readers see what has been written.
    fn flush(&mut self) {
        if let Some(error) = self.writer.flush().err().filter(|_| self.failed.is_none()) {
            self.failed = Some(io::Error::other(error));
        }
    }

    fn know(&mut self, index: usize, topic: &Topic) {
        if let Err(error) = self.topic(index, topic) {
            self.failed.get_or_insert(io::Error::other(error));
        }
    }

    fn message(&mut self, head: Head, body: &[u8]) {
        if let Some(channel) = self.topics.get(&head.topic) {
            self.write(Ok(*channel), head.log_ns, head.publish_ns, body);
        }
    }

    fn topic(&mut self, index: usize, topic: &Topic) -> Result<u16, mcap::McapError> {
        let schema = match &topic.definition {
            Some(definition) => {
                self.writer.add_schema(&topic.kind, &definition.language, definition.text.as_bytes())?
            }
            None => self.writer.add_schema(&topic.kind, "ros2msg", b"")?,
        };
        let hash = topic.hash.iter().map(|hash| ("topic_type_hash".to_owned(), hash.clone())).collect();
        let channel = self.writer.add_channel(schema, &topic.name, &topic.encoding, &hash)?;
        self.topics.insert(index, channel);
        Ok(channel)
    }

    /// Such notes may come.
    fn announce(&mut self, name: &'static str) {
        if let Err(error) = self.topic_of_notes(name) {
            self.failed.get_or_insert(io::Error::other(error));
        }
    }

    /// What a source reports beside its messages.
    fn note(&mut self, name: &'static str, at_ns: i64, text: &str) {
        let channel = self.topic_of_notes(name);
        let at_ns = at_ns.max(self.newest_ns);
        self.write(channel, at_ns, at_ns, &Text { data: text.to_owned() }.encode());
    }

    fn topic_of_notes(&mut self, name: &'static str) -> Result<u16, mcap::McapError> {
        if let Some(channel) = self.notes.get(name) {
            return Ok(*channel);
        }
        let definition = Text::definition().to_string();
        let schema = self.writer.add_schema(&Text::name().full(), "ros2msg", definition.as_bytes())?;
        let channel = self.writer.add_channel(schema, name, "cdr", &BTreeMap::new())?;
        self.notes.insert(name, channel);
        Ok(channel)
    }

    fn write(&mut self, channel: Result<u16, mcap::McapError>, log_ns: i64, publish_ns: i64, body: &[u8]) {
        if self.failed.is_some() {
            return;
        }
        self.newest_ns = self.newest_ns.max(log_ns);
        let time = |ns: i64| u64::try_from(ns).unwrap_or_default();
        let written = channel.and_then(|channel_id| {
            let (log_time, publish_time) = (time(log_ns), time(publish_ns));
            let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time };
            self.writer.write_to_known_channel(&header, body)
        });
        self.failed = written.err().map(io::Error::other);
    }
}

/// A source whose messages are also written to a file.
pub struct Recorder<S, W: Write + Seek> {
    source: S,
    writer: Rc<RefCell<BagWriter<W>>>,
    /// Until when time has passed without a message, if that is not written yet.
    clock_ns: Option<i64>,
    /// What the source has reported beside its messages, and is not written yet: each with the topic of such notes.
    aside: Vec<(&'static str, String)>,
    /// How much of what is lost, and of what else is to be known, has been collected.
    lost: usize,
    notes: usize,
    newest_ns: i64,
    has_begun: bool,
    /// How many topics have been written, and what vouches for their messages.
    topics: usize,
    grounds: Vec<Ground>,
}

impl<S: Source, W: Write + Seek> Recorder<S, W> {
    /// Writes the messages of a source. The file is ended by [`BagWriter::finish`].
    pub fn new(source: S, writer: Rc<RefCell<BagWriter<W>>>) -> Self {
        if source.counts_losses() {
            // The file counts them, too, even if it has none.
            writer.borrow_mut().announce(MISSING);
        }
        Self {
            source,
            writer,
            clock_ns: None,
            aside: Vec::new(),
            lost: 0,
            notes: 0,
            newest_ns: 0,
            has_begun: false,
            topics: 0,
            grounds: Vec::new(),
        }
    }

    /// Collects what the source has reported beside its messages since the last call.
    fn collect_aside(&mut self) {
        for (name, reported, collected) in
            [(NOTE, self.source.notes(), &mut self.notes), (LOST, self.source.lost(), &mut self.lost)]
        {
            self.aside.extend(reported.iter().skip(*collected).map(|text| (name, text.clone())));
            *collected = reported.len().max(*collected);
        }
        let survey = self.source.survey();
        for (index, topic) in survey.topics.iter().enumerate() {
            let ground = survey.ground(index);
            if self.grounds.get(index) == Some(ground) {
                continue;
            }
            self.grounds.resize(self.grounds.len().max(index + 1), Ground::default());
            self.grounds[index].clone_from(ground);
            let vouched = Vouched { topic: topic.name.as_str().into(), ground: ground.clone() };
            self.aside.push((GROUND, serde_json::to_string(&vouched).expect("names and texts")));
        }
    }

    fn write_aside(&mut self, at_ns: i64) {
        if self.aside.iter().any(|(name, _)| ![NOTE, GROUND].contains(name)) {
            // What had come before it became known is judged without it.
            self.write_clock();
        }
        let aside = self.aside.drain(..);
        aside.for_each(|(name, text)| self.writer.borrow_mut().note(name, at_ns, &text));
    }

    fn write_clock(&mut self) {
        // Before the first message, no time passes.
        if let Some(clock_ns) = self.clock_ns.take().filter(|_| self.has_begun) {
            self.writer.borrow_mut().note(CLOCK_ADVANCED, clock_ns, "");
        }
    }
}

impl<S: Source, W: Write + Seek> Source for Recorder<S, W> {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        let received = self.source.receive(body);
        // Topics without messages are part of what is known, too.
        for (index, topic) in self.source.survey().topics.iter().enumerate().skip(self.topics) {
            self.writer.borrow_mut().know(index, topic);
        }
        self.topics = self.source.survey().topics.len();
        self.collect_aside();
        let missing = match received {
            Received::Lost { topic, count, since_ns } => Some((topic, count, since_ns, None, false)),
            Received::Late { topic, since_ns } => Some((topic, None, since_ns, None, true)),
            Received::Resumed { topic, at_ns } => Some((topic, None, at_ns, Some(at_ns), false)),
            _ => None,
        };
        if let Some((topic, count, since_ns, until_ns, is_late)) = missing {
            let topic = self.source.survey().topics[topic].name.as_str().into();
            let missing = serde_json::to_string(&Missing { topic, count, since_ns, until_ns, is_late });
            self.aside.push((MISSING, missing.expect("a name and numbers")));
        }
        match received {
            // A file begins with its first message.
            Received::Message(head) if !self.has_begun => self.write_aside(head.log_ns),
            _ if self.has_begun => self.write_aside(self.newest_ns),
            _ => {}
        }
        match received {
            Received::Message(head) => {
                self.newest_ns = self.newest_ns.max(head.log_ns);
                // The time before the message makes ticks, even if the message does not become an event.
                self.write_clock();
                self.has_begun = true;
                self.writer.borrow_mut().message(head, body);
            }
            Received::ClockAdvanced(clock_ns) => {
                self.writer.borrow_mut().flush();
                self.newest_ns = self.newest_ns.max(clock_ns);
                self.clock_ns = Some(clock_ns);
            }
            Received::Lost { .. }
            | Received::Late { .. }
            | Received::Resumed { .. }
            | Received::Idle
            | Received::Over => {}
        }
        received
    }

    fn end(&mut self) {
        self.source.end();
        self.collect_aside();
        self.write_aside(self.newest_ns);
        self.write_clock();
    }

    fn account(&self) -> Account<'_> {
        self.source.account()
    }
}
