//! The events of a bag, in order.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;
use std::time::Duration;

use channels::{ChannelId, Event, EventKind, FieldKind, Flaw, Gap, Ground, Message, Value};
use diagnostics::ReadFile;
use ros_messages::standard::Clock;
use ros_messages::{Mismatch, RosType as _};

use crate::mapping::{CLOCK, Compiled, CompiledEntry, FieldRule, Mapping, MessageTime, Number};
use crate::path::{End, Part, Path};
use crate::storage::{Head, Received, Source};

/// The time of a message before the clock has told any; how many such messages are kept until it does.
const UNTOLD: i64 = i64::MIN;
const MOST_EARLY: usize = 10_000;

/// A stamp that is more ticks away than this is considered wrong.
const LONGEST_PAUSE: i64 = 10_000_000;

/// The ticks and messages of a [source](Source), one after the other, as a mapping makes them from the source's
/// messages.
///
/// The first mapped message and the first tick are at time 0. Messages that do not become events are
/// [counted](Self::notes), and the first of each channel comes as [`Found::LeftOut`].
pub struct Events<'r> {
    source: Box<dyn Source + 'r>,
    mapping: Mapping,
    read: ReadFile<'r>,
    compiled: Compiled,
    body: Vec<u8>,
    /// The last decoded message of each topic, whose memory is reused.
    decoded: Vec<ros_messages::Value>,
    /// What has been read but not returned, by time and order in the bag.
    waiting: VecDeque<(i64, Waiting)>,
    /// Before the first event: messages whose times are far from those that wait, until more agree with one than with
    /// the other.
    odd: Vec<(i64, (usize, usize), Message)>,
    /// The latest time read.
    newest_ns: i64,
    /// Until when time has passed, if messages have the times at which they were received: no earlier message follows.
    passed_ns: i64,
    is_over: bool,
    /// What the topic of the clock told last; none if it tells the time of no message.
    clock_ns: Option<i64>,
    /// What came before that.
    early: Vec<(Head, usize, Message)>,
    /// What ended the events early.
    ended: Option<String>,
    tick_ns: i64,
    reorder_ns: i64,
    /// When the message read last was recorded.
    newest_log_ns: Option<i64>,
    start_ns: Option<i64>,
    last_ns: i64,
    ticks: u64,
    steps: u64,
    /// How many messages of which topic did not become events, or items of which array in them, and the first of them.
    left_out: BTreeMap<(usize, Option<String>, Reason), (u64, String)>,
    /// The channels of messages that were left out, or `None` for anything; those that the caller knows.
    gaps: BTreeMap<Option<ChannelId>, String>,
    known_gaps: BTreeSet<Option<ChannelId>>,
    /// Gaps that end; the topics, and their entries, whose next message ends some, with when those began; what was
    /// missing in all of them.
    ending: VecDeque<Gap>,
    interrupted: BTreeMap<(usize, usize), Vec<i64>>,
    /// The time of the last message of each entry of a topic.
    told: BTreeMap<(usize, usize), i64>,
    missing: BTreeMap<usize, Missing>,
    /// On what grounds the messages of channels are known, whether these may be new, and which are.
    grounds: BTreeMap<ChannelId, Ground>,
    may_be_new: bool,
    new_grounds: VecDeque<(ChannelId, Ground)>,
    /// How many of the source's notes have been returned, and of what it says to be missing on topics.
    noted: usize,
    told_missing: usize,
    /// Whether there may be gaps, grounds or notes that have not been returned.
    has_news: bool,
    /// What comes before everything else.
    next: VecDeque<Found>,
    /// How many messages came too late, and the greatest delay.
    late: (u64, i64),
}

/// What a log contains next.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// A tick or a message.
    Event(Event),
    /// From here on, any number of messages may be missing. This comes once for each channel, if the gap does not end.
    LeftOut(Gap),
    /// A gap in the messages of this channel is over.
    Resumed(ChannelId),
    /// The source vouches for the messages of this channel, or does not any more.
    Vouched(ChannelId, Ground),
    /// What is to be known of the messages, in words.
    Noted(String),
    /// The run ended at this time, after its last event.
    Ended(Duration),
    /// Nothing yet: more may come later.
    Idle,
}

/// What waits for what may have to come before it.
enum Waiting {
    /// A message that an entry of a topic has made.
    Message((usize, usize), Message),
    /// In a box, so that a message takes little memory: nearly everything that waits is one.
    Gap(Box<Gap>),
    Resumed(ChannelId),
}

fn is_message(waiting: &Waiting) -> bool {
    matches!(waiting, Waiting::Message(..))
}

/// How many messages on a topic are missing.
struct Missing {
    count: u64,
    /// Whether there may be more.
    is_unknown: bool,
    /// After what the first of them are missing.
    first: String,
}

/// Why a message does not become an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Reason {
    /// The mapping does not fit its topic, which appeared only later.
    Topic,
    /// It is not a message of its type.
    Mismatch(Mismatch),
    /// It has no stamp, or one that is far from the others.
    Stamp,
    /// The clock has told no time.
    Clock,
    /// Its time is the first or the last that there is, which also stand for others.
    Time,
    /// A value has no symbol.
    Symbol,
    /// An integer that no value can be without being rounded.
    Range,
    /// The channel does not carry it.
    Channel,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Topic => f.write_str("the mapping does not fit the topic"),
            Self::Mismatch(mismatch) => write!(f, "the bytes do not fit the definition: {mismatch}"),
            Self::Stamp => f.write_str("the stamp is 0, or far from those of other messages"),
            Self::Clock => write!(f, "{CLOCK} has told no time yet"),
            Self::Time => f.write_str("the time is the first or the last that fits into 64 bits, or later"),
            Self::Symbol => f.write_str("the mapping has no symbol for the value"),
            Self::Range => f.write_str("the integer does not fit into 64 bits, or not exactly into a real number"),
            Self::Channel => f.write_str("the channel does not carry such a message"),
        }
    }
}

impl<'r> Events<'r> {
    /// The events of a source. The mapping was compiled for its first topics, or for all; `read` reads the files that
    /// define the types of topics which appear later.
    #[must_use]
    pub fn new(source: Box<dyn Source + 'r>, mapping: &Mapping, compiled: Compiled, read: ReadFile<'r>) -> Self {
        let ns = |duration: Duration| i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX);
        let mut events = Self {
            source,
            mapping: mapping.clone(),
            read,
            body: Vec::new(),
            decoded: vec![ros_messages::Value::Passed; compiled.entries.len()],
            compiled,
            waiting: VecDeque::new(),
            odd: Vec::new(),
            newest_ns: i64::MIN,
            passed_ns: i64::MIN,
            is_over: false,
            clock_ns: None,
            early: Vec::new(),
            ended: None,
            tick_ns: ns(mapping.tick).max(1),
            reorder_ns: ns(mapping.reorder),
            newest_log_ns: None,
            start_ns: None,
            last_ns: 0,
            ticks: 0,
            steps: 0,
            left_out: BTreeMap::new(),
            gaps: BTreeMap::new(),
            known_gaps: BTreeSet::new(),
            ending: VecDeque::new(),
            interrupted: BTreeMap::new(),
            told: BTreeMap::new(),
            missing: BTreeMap::new(),
            grounds: BTreeMap::new(),
            may_be_new: true,
            new_grounds: VecDeque::new(),
            noted: 0,
            told_missing: 0,
            has_news: true,
            next: VecDeque::new(),
            late: (0, 0),
        };
        events.add_topics();
        events
    }

    /// When the message read last was recorded, in nanoseconds since 1970.
    #[must_use]
    pub fn newest_log_ns(&self) -> Option<i64> {
        self.newest_log_ns
    }

    /// The time of the first event, if there was one: in nanoseconds since 1970 if the stamps are.
    #[must_use]
    pub fn start_ns(&self) -> Option<i64> {
        self.start_ns
    }

    /// What is missing from the events so far, in words: damage, and which messages did not become events and why.
    /// Also which definitions come from neither the bag nor a folder.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let left_out = self.left_out.iter().map(|((topic, each, reason), (count, first))| {
            let one = *count == 1;
            let (what, are) = (items(each.as_deref(), one), if one { "is" } else { "are" });
            format!("{count} {what} on {} {are} left out: {reason}; the first: {first}", self.topic(*topic))
        });
        let late = (self.late.0 > 0).then(|| {
            format!(
                "{} up to {:.3} s too late and {} the time of what has come before; what this could change is unsure; \
                 `reorder_s` sets how long to wait",
                if self.late.0 == 1 { "1 message comes".to_owned() } else { format!("{} messages come", self.late.0) },
                self.late.1 as f64 * 1e-9,
                if self.late.0 == 1 { "gets" } else { "get" }
            )
        });
        let topics = &self.source.survey().topics;
        let absent = self.compiled.promised.iter().filter(|name| topics.iter().all(|topic| topic.name != **name));
        let absent = absent.map(|name| format!("there is no topic {name}, so none of its messages is judged"));
        let is_read = |topic: usize| self.compiled.entries.get(topic).is_some_and(|entries| !entries.is_empty());
        let counted = self.source.survey().missing.iter().filter(|(topic, _)| is_read(*topic));
        let counted = counted.map(|(_, what)| what).filter(|what| !self.source.lost().contains(what));
        let counted: BTreeSet<&String> = counted.collect();
        let missing = self.missing.iter().map(|(topic, Missing { count, is_unknown, first })| {
            let count = (!is_unknown).then_some(*count);
            format!("{}, the first {first}", missing(count, self.topic(*topic)))
        });
        let lost = self.source.lost().iter().chain(self.source.notes()).chain(&self.compiled.on_board).cloned();
        lost.chain(counted.into_iter().cloned())
            .chain(absent)
            .chain(missing)
            .chain(left_out)
            .chain(late)
            .chain(self.ended.clone())
            .collect()
    }

    fn topic(&self, index: usize) -> &str {
        &self.source.survey().topics[index].name
    }

    /// Reads the next message, and puts what it becomes in order. Returns whether there was one.
    fn fill(&mut self) -> bool {
        let received = self.source.receive(&mut self.body);
        self.has_news = true;
        self.may_be_new |= !matches!(received, Received::Message(_));
        self.add_topics();
        let head = match received {
            Received::Message(head) => head,
            Received::Idle => return false,
            Received::Lost { topic, count, since_ns } => {
                self.interrupt(topic, count, since_ns);
                return true;
            }
            Received::Late { topic, since_ns } => {
                self.delay(topic, since_ns);
                return true;
            }
            Received::Resumed { topic, at_ns } => {
                // Stamps say nothing of receive times.
                if self.mapping.is_received() {
                    (0..self.compiled.entries[topic].len()).for_each(|index| self.end_gaps((topic, index), at_ns));
                }
                return true;
            }
            Received::ClockAdvanced(passed_ns) => {
                // The stamps in messages are of another clock.
                if self.mapping.is_received() && !self.is_far_off(passed_ns) {
                    self.passed_ns = passed_ns;
                    self.newest_ns = self.newest_ns.max(passed_ns);
                }
                return false;
            }
            Received::Over => {
                for (head, index, _) in std::mem::take(&mut self.early) {
                    self.leave_out(head.topic, index, Reason::Clock, crate::moment(head.log_ns));
                }
                self.leave_out_odd();
                self.is_over = true;
                return true;
            }
        };
        self.newest_log_ns = Some(head.log_ns);
        if self.mapping.has_clock() && self.topic(head.topic) == CLOCK {
            self.set_clock(head);
        }
        for index in 0..self.compiled.entries[head.topic].len() {
            match self.decode(head, index) {
                // What is missing was before it, even if no event comes of it.
                Ok(0) if self.mapping.is_received() => self.end_gaps((head.topic, index), head.log_ns),
                Ok(events) => (0..events).for_each(|item| self.take(head, index, item)),
                Err((reason, first)) => self.leave_out(head.topic, index, reason, first),
            }
        }
        true
    }

    /// Adds the topics that are new in the source. A topic may be new although no message of it has been read: all of
    /// them are missing.
    fn add_topics(&mut self) {
        let survey = self.source.survey();
        if self.compiled.entries.len() < survey.topics.len() {
            self.compiled.add_topics(&self.mapping, survey, self.read);
            self.decoded.resize(self.compiled.entries.len(), ros_messages::Value::Passed);
            self.may_be_new = true;
        }
    }

    /// Takes the event that an entry of the topic makes of the message just read, or of one of its items.
    fn take(&mut self, head: Head, index: usize, item: usize) {
        match self.convert(head, index, item) {
            // Whether or not it is wanted.
            Ok(None) if self.mapping.is_received() => self.end_gaps((head.topic, index), head.log_ns),
            Ok(None) => {}
            Ok(Some((UNTOLD, message))) if self.early.len() < MOST_EARLY => self.early.push((head, index, message)),
            Ok(Some((UNTOLD, _))) => self.leave_out(head.topic, index, Reason::Clock, crate::moment(head.log_ns)),
            Ok(Some((time_ns, message))) if self.is_far_off(time_ns) => {
                self.oppose(time_ns, (head.topic, index), message);
            }
            Ok(Some((time_ns, message))) => self.accept(time_ns, (head.topic, index), message),
            Err((reason, first)) => self.leave_out(head.topic, index, reason, first),
        }
    }

    /// The channel of an entry of a topic.
    fn channel(&self, topic: usize, index: usize) -> ChannelId {
        self.compiled.entries[topic][index].0
    }

    /// Takes the time from the message just read, `rosgraph_msgs/msg/Clock`.
    fn set_clock(&mut self, head: Head) {
        let clock_ns = match Clock::decode(&self.body) {
            Ok(Clock { clock }) => clock.ns(),
            Err(mismatch) => return self.leave_out_clock(head, Reason::Mismatch(mismatch)),
        };
        let before_ns = self.clock_ns.replace(clock_ns);
        if let Some(before_ns) = before_ns.filter(|before_ns| clock_ns < *before_ns || self.is_far_off(clock_ns)) {
            let [before, now] = [before_ns, clock_ns].map(crate::seconds);
            self.ended = Some(format!("{CLOCK} jumped from {before} s to {now} s, which ends the run"));
            self.source.end();
            self.add_topics();
            self.is_over = true;
            return;
        }
        // Whatever follows is later.
        self.passed_ns = clock_ns;
        self.newest_ns = self.newest_ns.max(clock_ns);
        for (head, index, message) in std::mem::take(&mut self.early) {
            self.put_in_order(clock_ns, Waiting::Message((head.topic, index), message));
        }
    }

    /// The clock may have told another time, which every message since then would have.
    fn leave_out_clock(&mut self, head: Head, reason: Reason) {
        let first = crate::after_first(head.log_ns, self.source.survey().first_ns());
        if !self.known_gaps.contains(&None) {
            let why = format!("messages on {CLOCK} are left out: {reason}; the first: {first}");
            self.gaps.entry(None).or_insert(why);
        }
        self.left_out.entry((head.topic, None, reason)).or_insert_with(|| (0, first)).0 += 1;
    }

    /// Decodes the message just read for an entry of the topic, and counts what may become an event: the message, or
    /// its items.
    fn decode(&mut self, head: Head, index: usize) -> Result<usize, (Reason, String)> {
        let entry = &self.compiled.entries[head.topic][index].1;
        let entry = entry.as_ref().map_err(|why| (Reason::Topic, why.clone()))?;
        let decoded = &mut self.decoded[head.topic];
        entry.decoder.decode_into(&self.body, decoded).map_err(|mismatch| {
            let when = crate::after_first(head.log_ns, self.source.survey().first_ns());
            (Reason::Mismatch(mismatch), when)
        })?;
        Ok(entry.each.as_ref().map_or(1, |(items, _)| items.find(decoded).len()))
    }

    /// The time and the message of the event that an entry of the topic makes of the decoded message or of an item of
    /// it, if any.
    fn convert(&self, head: Head, index: usize, item: usize) -> Result<Option<(i64, Message)>, (Reason, String)> {
        let (channel, entry) = &self.compiled.entries[head.topic][index];
        let entry = entry.as_ref().map_err(|why| (Reason::Topic, why.clone()))?;
        let message = &self.decoded[head.topic];
        let item = entry.each.as_ref().map_or(message, |(items, _)| &items.find(message)[item]);
        let Some((time_ns, message)) = event(entry, head, self.clock_ns, Part { message, item })? else {
            return Ok(None);
        };
        if time_ns == 0 && matches!(entry.clock, MessageTime::Field(_)) {
            return Err((Reason::Stamp, crate::moment(time_ns)));
        }
        // How long before or after others it came is not known, and the first time stands for none.
        let is_first = time_ns == UNTOLD && !matches!(entry.clock, MessageTime::Clock);
        if is_first || time_ns == i64::MAX {
            return Err((Reason::Time, crate::moment(time_ns)));
        }
        if !self.compiled.topology.carries(*channel, &message) {
            return Err((Reason::Channel, message.to_string()));
        }
        Ok(Some((time_ns, message)))
    }

    /// Whether a time is wrong: it must not open a pause of millions of ticks, nor make all other messages late.
    fn is_far_off(&self, time_ns: i64) -> bool {
        let reference = self.waiting.front().map_or(self.last_ns, |(time_ns, ..)| *time_ns);
        let is_first = self.start_ns.is_none() && self.waiting.is_empty();
        let pause_ns = time_ns.saturating_sub(reference).saturating_abs();
        !is_first && pause_ns > self.tick_ns.saturating_mul(LONGEST_PAUSE)
    }

    fn accept(&mut self, time_ns: i64, entry: (usize, usize), message: Message) {
        self.told.insert(entry, time_ns);
        self.end_gaps(entry, time_ns);
        self.put_in_order(time_ns, Waiting::Message(entry, message));
    }

    /// The time of a message is far from those that wait. Once the first event has been returned, it is left out.
    /// Before that, the times with which fewer messages agree are wrong.
    fn oppose(&mut self, time_ns: i64, entry: (usize, usize), message: Message) {
        self.odd.push((time_ns, entry, message));
        if self.start_ns.is_some() {
            return self.leave_out_odd();
        }
        if self.odd.len() <= self.messages_waiting() {
            return;
        }
        self.newest_ns = i64::MIN;
        let odd = std::mem::take(&mut self.odd);
        for (wrong_ns, what) in std::mem::take(&mut self.waiting) {
            match what {
                Waiting::Message(entry, message) => self.odd.push((wrong_ns, entry, message)),
                // Its time was that of a message.
                other => self.put_in_order(time_ns, other),
            }
        }
        self.leave_out_odd();
        for (time_ns, entry, message) in odd {
            self.accept(time_ns, entry, message);
        }
    }

    /// How many messages wait.
    fn messages_waiting(&self) -> usize {
        self.waiting.iter().filter(|(_, what)| is_message(what)).count()
    }

    /// Leaves out the messages whose times are far from those that wait.
    fn leave_out_odd(&mut self) {
        for (time_ns, (topic, index), _) in std::mem::take(&mut self.odd) {
            self.leave_out(topic, index, Reason::Stamp, crate::moment(time_ns));
        }
    }

    /// Messages on a topic are missing, from here to the next.
    fn interrupt(&mut self, topic: usize, count: Option<u64>, since_ns: i64) {
        let after = format!("after {}", crate::moment(since_ns));
        let why = format!("{} {after}", missing(count, self.topic(topic)));
        let all = self.missing.entry(topic).or_insert(Missing { count: 0, is_unknown: false, first: after });
        all.count = all.count.saturating_add(count.unwrap_or_default());
        all.is_unknown |= count.is_none();
        if self.mapping.has_clock() && self.topic(topic) == CLOCK {
            // Every message since then may have another time.
            self.gaps.entry(None).or_insert(why);
            return;
        }
        // Stamps say nothing of receive times; and without the message that is missing, other times may pass.
        let is_received = self.mapping.is_received();
        for index in 0..self.compiled.entries[topic].len() {
            let (channel, entry) = &self.compiled.entries[topic][index];
            let is_lossy = entry.as_ref().is_ok_and(|entry| entry.is_lossy);
            let begun = self.interrupted.entry((topic, index)).or_default();
            // One that has begun later is part of it.
            if is_lossy || begun.iter().any(|begun_ns| *begun_ns <= since_ns) {
                continue;
            }
            begun.push(since_ns);
            let told_ns = self.told.get(&(topic, index)).copied().unwrap_or(i64::MIN);
            let since_ns = if is_received { since_ns } else { told_ns };
            let mut gap =
                Gap { flaw: Flaw::Missing, why: why.clone(), channel: Some(*channel), since: None, ends: is_received };
            // What waits after the last message before the gap has not been judged yet. An earlier gap of the channel
            // may end only after some of it, which is judged before this gap is told.
            let is_end = |what: &Waiting| matches!(what, Waiting::Resumed(of) if of == channel);
            let place_after = |place: Option<usize>| place.map_or(0, |place| place + 1);
            let begins = place_after(self.waiting.iter().rposition(|(time_ns, _)| *time_ns <= since_ns));
            let told = begins.max(place_after(self.waiting.iter().rposition(|(_, what)| is_end(what))));
            let mut judged = self.waiting.range(begins..told);
            if judged.any(|(_, what)| is_message(what)) || told == 0 && self.start_ns.is_some() {
                gap.since = Some(self.since_start(since_ns));
            }
            match told.checked_sub(1) {
                Some(last) => {
                    self.waiting.insert(told, (since_ns.max(self.waiting[last].0), Waiting::Gap(Box::new(gap))))
                }
                None => self.ending.push_back(gap),
            }
        }
    }

    /// The last message on a topic may have been due at any time since then.
    fn delay(&mut self, topic: usize, since_ns: i64) {
        // Stamps say when it was sent, wherever it was meanwhile.
        if !self.mapping.is_received() {
            return;
        }
        for index in 0..self.compiled.entries.get(topic).map_or(0, Vec::len) {
            let Some(told_ns) = self.told.get(&(topic, index)).copied().filter(|told_ns| *told_ns > since_ns) else {
                continue;
            };
            let (channel, why) =
                (self.channel(topic, index), format!("a message on {} was delayed", self.topic(topic)));
            let why = format!("{why}, which came at {}", crate::moment(told_ns));
            let since = Some(self.since_start(since_ns));
            let gap = Gap { flaw: Flaw::Late, why, channel: Some(channel), since, ends: true };
            self.put_in_order(told_ns, Waiting::Gap(Box::new(gap)));
            self.put_in_order(told_ns, Waiting::Resumed(channel));
        }
    }

    /// A message of an entry of a topic ends what was missing before it.
    fn end_gaps(&mut self, entry: (usize, usize), time_ns: i64) {
        let Some(begun) = self.interrupted.remove(&entry) else { return };
        let channel = self.channel(entry.0, entry.1);
        for _ in begun {
            self.put_in_order(time_ns, Waiting::Resumed(channel));
        }
    }

    fn put_in_order(&mut self, time_ns: i64, what: Waiting) {
        self.newest_ns = self.newest_ns.max(time_ns);
        // Messages are recorded nearly in the order of their times, so the place is searched from the end. It nearly
        // always is the end, where `insert` takes 40 instructions more than `push_back`.
        match self.waiting.iter().rev().take_while(|(later_ns, ..)| *later_ns > time_ns).count() {
            0 => self.waiting.push_back((time_ns, what)),
            later => self.waiting.insert(self.waiting.len() - later, (time_ns, what)),
        }
    }

    /// A message comes too late to be put in order: it gets the time of what has come before it, which has been judged
    /// without it. If it belongs before all that has come, the run began earlier, and no tick is where it should be.
    fn displace(&mut self, channel: ChannelId, time_ns: i64, now_ns: i64) {
        let delay_ns = now_ns.saturating_sub(time_ns);
        self.late = (self.late.0 + 1, self.late.1.max(delay_ns));
        let (what, delay_s) = (self.compiled.topology.describe(channel), delay_ns as f64 * 1e-9);
        let why = format!("a message {what} comes {delay_s:.3} s too late to be put in order");
        let is_within = self.start_ns.is_some_and(|start_ns| start_ns <= time_ns);
        // What has the same time was recorded before it.
        let since = if is_within { self.since_start(time_ns + 1) } else { Duration::ZERO };
        let channel = is_within.then_some(channel);
        self.next.push_back(Found::LeftOut(Gap {
            flaw: Flaw::Displaced,
            why,
            channel,
            since: Some(since),
            ends: is_within,
        }));
        self.next.extend(channel.map(Found::Resumed));
    }

    fn leave_out(&mut self, topic: usize, index: usize, reason: Reason, first: String) {
        self.has_news = true;
        let (channel, entry) = &self.compiled.entries[topic][index];
        // Of bytes that do not fit, nobody knows how many items they should have been.
        let each = entry.as_ref().ok().and_then(|entry| entry.each.as_ref().map(|(_, each)| each.clone()));
        let each = each.filter(|_| !matches!(reason, Reason::Mismatch(_)));
        if !self.known_gaps.contains(&Some(*channel)) {
            let what = items(each.as_deref(), false);
            let why = format!("{what} on {} are left out: {reason}; the first: {first}", self.topic(topic));
            self.gaps.entry(Some(*channel)).or_insert(why);
        }
        self.left_out.entry((topic, each, reason)).or_insert_with(|| (0, first)).0 += 1;
    }

    /// The next gap that the caller does not know. A message that does not become an event is noticed when it is read,
    /// which is before any event that it could precede.
    fn new_gap(&mut self) -> Option<Gap> {
        // Files that are missing may have had messages of any time.
        let lost = self.source.survey().lost.first().or(self.source.lost().first());
        let (channel, why) = match lost.filter(|_| !self.known_gaps.contains(&None)) {
            Some(lost) => (None, lost.clone()),
            None => match self.gaps.pop_first() {
                Some(gap) => gap,
                None => {
                    self.find_missing();
                    return self.ending.pop_front();
                }
            },
        };
        self.known_gaps.insert(channel);
        Some(Gap { flaw: Flaw::Missing, why, channel, since: None, ends: false })
    }

    /// Where files count other messages than they have, any verdict that has been reached may lack one of them.
    fn find_missing(&mut self) {
        for (topic, why) in self.source.survey().missing.iter().skip(self.told_missing) {
            self.told_missing += 1;
            let is_clock = self.mapping.has_clock() && self.source.survey().topics[*topic].name == CLOCK;
            let entries = self.compiled.entries.get(*topic).into_iter().flatten();
            let entries = entries.filter(|(_, entry)| !entry.as_ref().is_ok_and(|entry| entry.is_lossy));
            let channels = entries.map(|(channel, _)| Some(*channel)).chain(is_clock.then_some(None));
            // One that is missing may belong before all that has come.
            self.ending.extend(channels.map(|channel| Gap {
                flaw: Flaw::Displaced,
                why: why.clone(),
                channel,
                since: Some(Duration::ZERO),
                ends: false,
            }));
        }
    }

    /// The next channel of which the source vouches on another ground than before.
    fn new_ground(&mut self) -> Option<(ChannelId, Ground)> {
        if std::mem::take(&mut self.may_be_new) {
            for channel in self.compiled.topology.channels() {
                let ground = self.compiled.ground(channel, &self.mapping, self.source.survey());
                if self.grounds.get(&channel) != Some(&ground) {
                    self.grounds.insert(channel, ground.clone());
                    self.new_grounds.push_back((channel, ground));
                }
            }
        }
        self.new_grounds.pop_front()
    }

    /// The next gap, ground or note. New ones come only with what is read, or left out.
    fn news(&mut self) -> Option<Found> {
        if !self.has_news {
            return None;
        }
        if let Some(gap) = self.new_gap() {
            return Some(Found::LeftOut(gap));
        }
        if let Some((channel, ground)) = self.new_ground() {
            return Some(Found::Vouched(channel, ground));
        }
        let note = self.source.notes().get(self.noted).cloned();
        self.noted += usize::from(note.is_some());
        self.has_news = note.is_some();
        note.map(Found::Noted)
    }

    /// The next tick, if it is due by this time: never, if it would come after the last time that there is.
    fn tick(&mut self, by_ns: i64) -> Option<Found> {
        let tick_ns = i128::from(self.start_ns?) + i128::from(self.ticks) * i128::from(self.tick_ns);
        let tick_ns = i64::try_from(tick_ns).ok().filter(|tick_ns| *tick_ns <= by_ns)?;
        let event =
            Event { step: self.steps, tick: self.ticks, time: self.since_start(tick_ns), kind: EventKind::Tick };
        self.ticks += 1;
        self.last_ns = tick_ns;
        Some(Found::Event(event))
    }

    fn since_start(&self, time_ns: i64) -> Duration {
        let start_ns = self.start_ns.unwrap_or(time_ns);
        Duration::from_nanos(time_ns.max(start_ns).abs_diff(start_ns))
    }
}

impl Iterator for Events<'_> {
    type Item = Found;

    fn next(&mut self) -> Option<Found> {
        loop {
            if let Some(found) = self.next.pop_front() {
                return Some(found);
            }
            if let Some(news) = self.news() {
                return Some(news);
            }
            // The earliest message that waits is next once no earlier one can come: `reorder_ns` after it, or at the
            // end. Ticks that are due before it come first; its time is at least that of what has been returned.
            // Time begins with the first message that becomes an event.
            let front = self.waiting.front();
            let is_message = matches!(front, Some((_, Waiting::Message(..))));
            match front.map(|(time_ns, ..)| *time_ns) {
                Some(time_ns) if self.is_over || time_ns.saturating_add(self.reorder_ns) <= self.newest_ns => {
                    if is_message && self.start_ns.is_none() {
                        self.start_ns = Some(time_ns);
                        if !self.odd.is_empty() {
                            self.leave_out_odd();
                            continue;
                        }
                    }
                    let begun = if self.ticks == 0 { time_ns } else { self.last_ns };
                    let now_ns = time_ns.max(begun);
                    if let Some(tick) = self.tick(now_ns) {
                        return Some(tick);
                    }
                    let (_, what) = self.waiting.pop_front()?;
                    let (channel, message) = match what {
                        Waiting::Message((topic, index), message) => (self.channel(topic, index), message),
                        Waiting::Gap(gap) => return Some(Found::LeftOut(*gap)),
                        Waiting::Resumed(channel) => return Some(Found::Resumed(channel)),
                    };
                    if time_ns < now_ns {
                        self.displace(channel, time_ns, now_ns);
                    }
                    self.last_ns = now_ns;
                    self.steps += 1;
                    let kind = EventKind::Received { channel, message };
                    let time = self.since_start(now_ns);
                    let event = Found::Event(Event { step: self.steps, tick: self.ticks - 1, time, kind });
                    if self.next.is_empty() {
                        return Some(event);
                    }
                    self.next.insert(1, event);
                }
                // Time that passes without messages also makes ticks.
                _ => {
                    let reorder_ns = if self.is_over { 0 } else { self.reorder_ns };
                    match self.tick(self.passed_ns.saturating_sub(reorder_ns)) {
                        Some(tick) => return Some(tick),
                        None if self.is_over => return None,
                        None if self.fill() => {}
                        None => return Some(Found::Idle),
                    }
                }
            }
        }
    }
}

/// What may become an event, in words: a message, or an item of this array in it; or several.
fn items(each: Option<&str>, one: bool) -> String {
    match (each, one) {
        (None, true) => "message".to_owned(),
        (None, false) => "messages".to_owned(),
        (Some(each), true) => format!("item of `{each}` in messages"),
        (Some(each), false) => format!("items of `{each}` in messages"),
    }
}

/// That messages on a topic are missing, in words.
fn missing(count: Option<u64>, topic: &str) -> String {
    match count {
        Some(1) => format!("1 message on {topic} is missing"),
        Some(count) => format!("{count} messages on {topic} are missing"),
        None => format!("messages on {topic} may be missing"),
    }
}

/// The time and the message of an event; none if the mapping's conditions exclude it.
fn event(
    entry: &CompiledEntry,
    head: Head,
    clock_ns: Option<i64>,
    part: Part<'_>,
) -> Result<Option<(i64, Message)>, (Reason, String)> {
    for test in &entry.tests {
        let value = value_at(test.path.find(part), test.path.end, &test.text, Number::Plain)?;
        if !test.values.iter().any(|wanted| is_same(wanted, &value)) {
            return Ok(None);
        }
    }
    let time_ns = match &entry.clock {
        MessageTime::Log => head.log_ns,
        MessageTime::Publish => head.publish_ns,
        MessageTime::Clock => clock_ns.unwrap_or(UNTOLD),
        // The array item with the stamp may be missing.
        MessageTime::Field(path) => path.find(part).and_then(stamp_ns).unwrap_or(0),
    };
    // Collecting the values directly needs no memory besides that of the message.
    let mut refused = None;
    let message = Message::new(entry.fields.iter().map(|rule| {
        field(rule, part).unwrap_or_else(|why| {
            refused.get_or_insert(why);
            none()
        })
    }));
    refused.map_or(Ok(Some((time_ns, message))), Err)
}

/// A value, or why its message is left out.
type Fitting = Result<Value, (Reason, String)>;

/// The value of a field.
fn field(rule: &FieldRule, part: Part<'_>) -> Fitting {
    match rule {
        FieldRule::Constant(value) => Ok(value.clone()),
        FieldRule::Path { path, text, number } => each(path, part, |found| value_at(found, path.end, text, *number)),
        FieldRule::Symbols { path, text, symbols } => each(path, part, |found| {
            let value = value_at(found, path.end, text, Number::Plain)?;
            let written = as_written(&value);
            match symbols.iter().find(|(known, _)| *known == written) {
                Some((_, symbol)) => Ok(Value::Symbol(symbol.clone())),
                // An item that the array does not have is not an unknown value.
                None if found.is_none() => Ok(none()),
                None => Err((Reason::Symbol, format!("`{text}` is {written}"))),
            }
        }),
    }
}

/// The value that is made of what the path leads to, or the list of them if it leads to every item.
fn each(path: &Path, part: Part<'_>, make: impl Fn(Option<&ros_messages::Value>) -> Fitting) -> Fitting {
    if path.is_list() {
        path.find_all(part).map(make).collect::<Result<_, _>>().map(Value::List)
    } else {
        make(path.find(part))
    }
}

/// The value that was found at a path; `<none>` if the array does not have the item, and for NaN.
fn value_at(found: Option<&ros_messages::Value>, end: End, text: &str, number: Number) -> Fitting {
    let value = match (found, end) {
        (Some(ros_messages::Value::Bool(truth)), _) => Some(Value::Bool(*truth)),
        (Some(ros_messages::Value::Int(integer)), _) => {
            // `<none>` is neither less nor greater than any number, so it cannot stand for a large integer.
            let value = number.of_integer(*integer);
            Some(value.ok_or_else(|| (Reason::Range, format!("`{text}` is {integer}")))?)
        }
        (Some(ros_messages::Value::Real(real)), _) => {
            Some(real * number.scale()).filter(|number| !number.is_nan()).map(Value::Real)
        }
        (Some(ros_messages::Value::Text(text)), _) => Some(Value::from(text.as_str())),
        (Some(ros_messages::Value::List(bytes)), End::Bytes) => {
            let digits = bytes.iter().map(|byte| {
                if let ros_messages::Value::Int(byte) = byte { format!("{byte:02x}") } else { String::new() }
            });
            Some(Value::from(digits.collect::<String>().as_str()))
        }
        (Some(time), End::Time) => stamp_ns(time).map(|ns| Value::Real(ns as f64 * 1e-9)),
        _ => None,
    };
    Ok(value.unwrap_or_else(none))
}

fn none() -> Value {
    Value::symbol(FieldKind::NONE)
}

fn stamp_ns(stamp: &ros_messages::Value) -> Option<i64> {
    let ros_messages::Value::Message(fields) = stamp else { return None };
    let [ros_messages::Value::Int(seconds), ros_messages::Value::Int(ns)] = fields.as_slice() else { return None };
    i64::try_from(seconds * 1_000_000_000 + ns).ok()
}

fn is_same(wanted: &Value, value: &Value) -> bool {
    wanted.order(value).map_or(wanted == value, Ordering::is_eq)
}

/// A value as written in a table's key.
fn as_written(value: &Value) -> String {
    match value {
        Value::Text(text) => text.to_string(),
        Value::Symbol(symbol) => symbol.name().to_owned(),
        other => other.to_string(),
    }
}
