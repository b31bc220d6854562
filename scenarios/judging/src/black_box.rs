//! The last moments before each violation, as a recording.

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use bags::{Account, BagWriter, Head, Received, Recorder, Source, Survey};

/// The most bytes of messages that are kept.
const MOST: usize = 1 << 28;

/// What was received from a source, with the bytes of a message.
type ReceivedBytes = (Received, Vec<u8>);

/// The records of a source within a span of time.
#[derive(Default)]
pub struct BlackBox {
    span_ns: i64,
    /// Whether the source reports which messages are missing.
    counts_losses: bool,
    records: VecDeque<ReceivedBytes>,
    /// The losses from before the first record that have not ended, by topic: how many messages, and after which time.
    open: BTreeMap<usize, (Option<u64>, i64)>,
    bytes: usize,
    /// Whether older messages had no room.
    is_cut: bool,
    newest_ns: i64,
    survey: Survey,
    lost: Vec<String>,
    /// When the last file of each property was written.
    written: BTreeMap<String, i64>,
}

impl BlackBox {
    /// Keeps a span of this many nanoseconds of a source that may report which messages are missing.
    #[must_use]
    pub fn new(span_ns: i64, counts_losses: bool) -> Self {
        Self { span_ns, counts_losses, ..Self::default() }
    }

    /// Keeps a record, and forgets those that are too old.
    pub fn keep(&mut self, received: Received, body: &[u8], survey: &Survey, lost: &[String]) {
        if lost.len() > self.lost.len() {
            self.lost = lost.to_vec();
        }
        if (&self.survey.ground, &self.survey.grounds) != (&survey.ground, &survey.grounds) {
            self.survey.ground.clone_from(&survey.ground);
            self.survey.grounds.clone_from(&survey.grounds);
        }
        let (ns, body) = match received {
            Received::Message(head) => (head.log_ns, body.to_vec()),
            Received::ClockAdvanced(ns) => (ns, Vec::new()),
            Received::Lost { .. } | Received::Late { .. } | Received::Resumed { .. } => (self.newest_ns, Vec::new()),
            Received::Idle | Received::Over => return,
        };
        self.newest_ns = self.newest_ns.max(ns);
        if survey.topics.len() > self.survey.topics.len() {
            self.survey.topics.clone_from(&survey.topics);
            self.survey.counts = vec![0; survey.topics.len()];
        }
        self.bytes += size(&body);
        // Of consecutive records of passed time, only the last matters.
        if let (Received::ClockAdvanced(_), Some((Received::ClockAdvanced(_), last))) = (received, self.records.back())
        {
            self.bytes -= size(last);
            self.records.pop_back();
        }
        self.records.push_back((received, body));
        let since_ns = self.newest_ns.saturating_sub(self.span_ns);
        while let Some((first, body)) = self.records.front() {
            let is_old = match first {
                Received::Message(Head { log_ns: ns, .. }) | Received::ClockAdvanced(ns) => *ns < since_ns,
                _ => true,
            };
            self.is_cut |= !is_old && self.bytes > MOST;
            if !is_old && self.bytes <= MOST {
                break;
            }
            self.bytes -= size(body);
            let first = *first;
            self.records.pop_front();
            self.forget(first);
        }
    }

    /// Updates the open losses with a record that is forgotten. A loss ends with the next message on its topic, or when
    /// the topic is resumed.
    fn forget(&mut self, record: Received) {
        match record {
            Received::Message(Head { topic, .. }) | Received::Resumed { topic, .. } => _ = self.open.remove(&topic),
            Received::Lost { topic, count, since_ns } => {
                self.open.entry(topic).and_modify(|(count, _)| *count = None).or_insert((count, since_ns));
            }
            Received::Late { .. } | Received::ClockAdvanced(_) | Received::Idle | Received::Over => {}
        }
    }

    /// Writes the records to a file, unless they contain the property's last violation, which has a file. Returns the
    /// path of the file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&mut self, folder: &Path, property: &str, verdict: &str) -> io::Result<Option<PathBuf>> {
        let last = self.written.get(property).copied();
        if last.is_some_and(|last| last > self.newest_ns.saturating_sub(self.span_ns)) {
            return Ok(None);
        }
        self.written.insert(property.to_owned(), self.newest_ns);
        let number = (1..).find(|number| !folder.join(name(property, *number)).exists()).unwrap_or(u64::MAX);
        let path = folder.join(name(property, number));
        let writer = Rc::new(RefCell::new(BagWriter::begin(BufWriter::new(File::create_new(&path)?))?));
        let notes: Vec<String> =
            self.is_cut.then(|| "the messages before these had no room".to_owned()).into_iter().collect();
        let (survey, lost, counts_losses) = (&self.survey, &self.lost, self.counts_losses);
        let open: Vec<ReceivedBytes> = self
            .open
            .iter()
            .map(|(topic, (count, since_ns))| {
                (Received::Lost { topic: *topic, count: *count, since_ns: *since_ns }, Vec::new())
            })
            .collect();
        let records = open.iter().chain(&self.records);
        let source = KeptSource { records, account: Account { survey, lost, notes: &notes, counts_losses } };
        let mut recorder = Recorder::new(source, Rc::clone(&writer));
        let mut body = Vec::new();
        while recorder.receive(&mut body) != Received::Over {}
        recorder.end();
        let mut writer = writer.borrow_mut();
        writer.violation(self.newest_ns, verdict);
        writer.finish()?;
        Ok(Some(path))
    }
}

/// The bytes that a record takes in memory.
fn size(body: &[u8]) -> usize {
    size_of::<ReceivedBytes>() + body.len()
}

fn name(property: &str, number: u64) -> String {
    format!("black-box-{}-{number}.mcap", property.replace('/', "-"))
}

/// A source of the records that were kept.
struct KeptSource<'k, T> {
    records: T,
    account: Account<'k>,
}

impl<'k, T: Iterator<Item = &'k ReceivedBytes>> Source for KeptSource<'k, T> {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        let Some((received, kept)) = self.records.next() else { return Received::Over };
        body.clone_from(kept);
        *received
    }

    fn account(&self) -> Account<'_> {
        self.account
    }
}

#[cfg(test)]
mod tests {
    use bags::{Bag, Definition, Ground, Topic};

    use super::*;

    const SECOND_NS: i64 = 1_000_000_000;

    /// A black box of ten seconds with this many messages, one per second.
    fn kept(messages: i64) -> BlackBox {
        let mut survey = Survey::default();
        let definition = Definition { language: "ros2msg".to_owned(), text: "int64 x\n".to_owned() };
        let [name, kind, encoding] = ["/a", "p/msg/P", "cdr"].map(str::to_owned);
        let topic = survey.add(Topic { name, kind, encoding, definition: Some(definition), hash: None });
        survey.vouch(topic, Ground::Numbered);
        let mut kept = BlackBox::new(10 * SECOND_NS, true);
        for index in 0..messages {
            let ns = (1_700_000_000 + index) * SECOND_NS;
            kept.keep(Received::Message(Head { topic: 0, log_ns: ns, publish_ns: ns }), &[0, 1, 0, 0, 7], &survey, &[]);
            kept.keep(Received::ClockAdvanced(ns + 1), &[], &survey, &[]);
        }
        kept
    }

    #[test]
    fn the_last_moments_are_written_once_for_each_violation() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut kept = kept(30);
        let path = kept.write(folder.path(), "low", "{}").expect("room for a file").expect("a file");
        let bag = Bag::open(&path).expect("a bag");
        let topic = bag.survey().topics.iter().position(|topic| topic.name == "/a").expect("the topic");
        // The messages of the last ten seconds.
        assert_eq!(bag.survey().counts[topic], 10);
        assert!(bag.survey().topics.iter().any(|topic| topic.name == "/steward/violation"));
        // The file has the same ground for them.
        let mut messages = bag.messages_on(["/a"]);
        assert!(messages.counts_losses());
        while messages.receive(&mut Vec::new()) != Received::Over {}
        assert_eq!(*messages.survey().ground(topic), Ground::Numbered);
        assert_eq!(kept.write(folder.path(), "low", "{}").expect("no file"), None);
        let other = kept.write(folder.path(), "high", "{}").expect("room for a file");
        assert_eq!(other, Some(folder.path().join("black-box-high-1.mcap")));
    }

    #[test]
    fn a_loss_that_began_before_the_last_moments_is_part_of_them() {
        let folder = tempfile::tempdir().expect("a folder");
        let survey = kept(1).survey;
        let at = |seconds: i64| (1_700_000_000 + seconds) * SECOND_NS;
        let lost = Received::Lost { topic: 0, count: Some(2), since_ns: at(0) };
        let found = |later: Received| {
            let mut kept = kept(1);
            for record in [lost, later, Received::ClockAdvanced(at(50))] {
                kept.keep(record, &[0, 1, 0, 0, 7], &survey, &[]);
            }
            let path = kept.write(folder.path(), "low", "{}").expect("room for a file").expect("a file");
            let mut messages = Bag::open(&path).expect("a bag").messages_on(["/a"]);
            let all = std::iter::repeat_with(|| messages.receive(&mut Vec::new()));
            all.take_while(|received| *received != Received::Over).collect::<Vec<_>>()
        };
        let lacks = |received: &Received| matches!(received, Received::Lost { count: Some(2), .. });
        assert!(found(Received::ClockAdvanced(at(1))).iter().any(lacks));
        for end in [
            Received::Resumed { topic: 0, at_ns: at(2) },
            Received::Message(Head { topic: 0, log_ns: at(2), publish_ns: at(2) }),
        ] {
            assert!(!found(end).iter().any(lacks), "{end:?}");
        }
    }

    #[test]
    fn memory_is_bounded() {
        let mut kept = kept(0);
        let (head, body) = (Head { topic: 0, log_ns: SECOND_NS, publish_ns: 0 }, vec![0; MOST / 4]);
        for _ in 0..8 {
            kept.keep(Received::Message(head), &body, &Survey::default(), &[]);
        }
        assert!(kept.is_cut && kept.bytes <= MOST, "{}", kept.bytes);
    }
}
