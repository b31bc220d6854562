//! The events of a bag, in order.

mod gaps;
mod grounds;
mod omissions;
mod reordering;
mod times;

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use channels::{ChannelId, Event, FieldKind, Flaw, Gap, Ground, Message, Value};
use diagnostics::ReadFile;
use ros_messages::RosType as _;
use ros_messages::standard::Clock;

use crate::mapping::{CLOCK, Compiled, CompiledEntry, FieldRule, Mapping, MessageTime, Number};
use crate::path::{End, Part, Path};
use crate::storage::{Head, Received, Source};
use gaps::Gaps;
use grounds::KnownGrounds;
use omissions::{Omissions, Reason, items, missing};
use reordering::{Reordering, Waiting};
use times::EventTimes;

/// The time of a message before the first time of the clock; how many such messages are kept until then.
const BEFORE_CLOCK: i64 = i64::MIN;
const MOST_EARLY: usize = 10_000;

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
    order: Reordering,
    times: EventTimes,
    /// The latest time on the topic of the clock; none if no message takes its time from there.
    clock_ns: Option<i64>,
    /// What came before that.
    early: Vec<(Head, usize, Message)>,
    /// When the message read last was recorded.
    newest_log_ns: Option<i64>,
    /// The time of the last message of each entry of a topic.
    last_ns: BTreeMap<(usize, usize), i64>,
    omissions: Omissions,
    gaps: Gaps,
    grounds: KnownGrounds,
    /// What ended the events early.
    ended: Option<String>,
    /// How many of the source's notes have been returned.
    noted: usize,
    /// Whether there may be gaps, grounds or notes that have not been returned.
    has_news: bool,
    /// What comes before everything else.
    next: VecDeque<Found>,
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
            order: Reordering::within(ns(mapping.reorder)),
            times: EventTimes::of(ns(mapping.tick).max(1)),
            clock_ns: None,
            early: Vec::new(),
            newest_log_ns: None,
            last_ns: BTreeMap::new(),
            omissions: Omissions::default(),
            gaps: Gaps::default(),
            grounds: KnownGrounds::none(),
            ended: None,
            noted: 0,
            has_news: true,
            next: VecDeque::new(),
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
        self.times.start_ns
    }

    /// What is missing from the events so far, in words: damage, and which messages did not become events and why.
    /// Also which definitions come from neither the bag nor a folder.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let topics = &self.source.survey().topics;
        let absent = self.compiled.promised.iter().filter(|name| topics.iter().all(|topic| topic.name != **name));
        let absent = absent.map(|name| format!("there is no topic {name}, so none of its messages is judged"));
        let is_read = |topic: usize| self.compiled.entries.get(topic).is_some_and(|entries| !entries.is_empty());
        let counted = self.source.survey().missing.iter().filter(|(topic, _)| is_read(*topic));
        let counted = counted.map(|(_, what)| what).filter(|what| !self.source.lost().contains(what));
        let counted: BTreeSet<&String> = counted.collect();
        let lost = self.source.lost().iter().chain(self.source.notes()).chain(&self.compiled.on_board).cloned();
        lost.chain(counted.into_iter().cloned())
            .chain(absent)
            .chain(self.omissions.notes(|topic| self.topic(topic)))
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
        self.grounds.may_be_new |= !matches!(received, Received::Message(_));
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
                // Stamps do not depend on receive times.
                if self.mapping.is_received() {
                    (0..self.compiled.entries[topic].len()).for_each(|index| self.end_gaps((topic, index), at_ns));
                }
                return true;
            }
            Received::ClockAdvanced(passed_ns) => {
                // The stamps in messages are of another clock.
                if self.mapping.is_received() && !self.is_far_off(passed_ns) {
                    self.order.pass(passed_ns);
                }
                return false;
            }
            Received::Over => {
                for (head, index, _) in std::mem::take(&mut self.early) {
                    self.leave_out(head.topic, index, Reason::Clock, crate::moment(head.log_ns));
                }
                self.leave_out_odd();
                self.order.is_over = true;
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
            self.grounds.may_be_new = true;
        }
    }

    /// Takes the event that an entry of the topic makes of the message just read, or of one of its items.
    fn take(&mut self, head: Head, index: usize, item: usize) {
        match self.convert(head, index, item) {
            // Whether or not it is wanted.
            Ok(None) if self.mapping.is_received() => self.end_gaps((head.topic, index), head.log_ns),
            Ok(None) => {}
            Ok(Some((BEFORE_CLOCK, message))) if self.early.len() < MOST_EARLY => {
                self.early.push((head, index, message))
            }
            Ok(Some((BEFORE_CLOCK, _))) => self.leave_out(head.topic, index, Reason::Clock, crate::moment(head.log_ns)),
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
            self.order.is_over = true;
            return;
        }
        // Whatever follows is later.
        self.order.pass(clock_ns);
        for (head, index, message) in std::mem::take(&mut self.early) {
            self.order.put(clock_ns, Waiting::Message((head.topic, index), message));
        }
    }

    /// The message may have set the clock to another time, which every message since then would have.
    fn leave_out_clock(&mut self, head: Head, reason: Reason) {
        let first = crate::after_first(head.log_ns, self.source.survey().first_ns());
        self.gaps.leave_out(None, || format!("messages on {CLOCK} are left out: {reason}; the first: {first}"));
        self.omissions.leave_out(head.topic, None, reason, first);
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
        let is_first = time_ns == BEFORE_CLOCK && !matches!(entry.clock, MessageTime::Clock);
        if is_first || time_ns == i64::MAX {
            return Err((Reason::Time, crate::moment(time_ns)));
        }
        if !self.compiled.topology.carries(*channel, &message) {
            return Err((Reason::Channel, message.to_string()));
        }
        Ok(Some((time_ns, message)))
    }

    fn is_far_off(&self, time_ns: i64) -> bool {
        self.times.is_far_off(time_ns, self.order.front_ns())
    }

    fn accept(&mut self, time_ns: i64, entry: (usize, usize), message: Message) {
        self.last_ns.insert(entry, time_ns);
        self.end_gaps(entry, time_ns);
        self.order.put(time_ns, Waiting::Message(entry, message));
    }

    /// The time of a message is far from those that wait. Once the first event has been returned, it is left out.
    /// Before that, the times with which fewer messages agree are wrong.
    fn oppose(&mut self, time_ns: i64, entry: (usize, usize), message: Message) {
        self.order.odd.push((time_ns, entry, message));
        let mut right = Vec::new();
        if self.times.start_ns.is_none() {
            let Some(turned) = self.order.turn(time_ns) else { return };
            right = turned;
        }
        self.leave_out_odd();
        for (time_ns, entry, message) in right {
            self.accept(time_ns, entry, message);
        }
    }

    /// Leaves out the messages whose times are far from those that wait.
    fn leave_out_odd(&mut self) {
        for (time_ns, (topic, index), _) in std::mem::take(&mut self.order.odd) {
            self.leave_out(topic, index, Reason::Stamp, crate::moment(time_ns));
        }
    }

    /// Messages on a topic are missing, from here to the next.
    fn interrupt(&mut self, topic: usize, count: Option<u64>, since_ns: i64) {
        let after = format!("after {}", crate::moment(since_ns));
        let why = format!("{} {after}", missing(count, self.topic(topic)));
        self.omissions.miss(topic, count, after);
        if self.mapping.has_clock() && self.topic(topic) == CLOCK {
            // Every message since then may have another time.
            self.gaps.left_out.entry(None).or_insert(why);
            return;
        }
        // Stamps do not depend on receive times; and without the message that is missing, other times may pass.
        let is_received = self.mapping.is_received();
        for index in 0..self.compiled.entries[topic].len() {
            let (channel, entry) = &self.compiled.entries[topic][index];
            let is_lossy = entry.as_ref().is_ok_and(|entry| entry.is_lossy);
            // One that has begun later is part of it.
            if is_lossy || !self.gaps.interrupt((topic, index), since_ns) {
                continue;
            }
            let last_ns = self.last_ns.get(&(topic, index)).copied().unwrap_or(i64::MIN);
            let since_ns = if is_received { since_ns } else { last_ns };
            let (why, channel) = (why.clone(), Some(*channel));
            let gap = Gap { flaw: Flaw::Missing, why, channel, since: None, ends: is_received };
            self.gaps.ending.extend(self.order.put_gap(gap, since_ns, &self.times));
        }
    }

    /// The last message on a topic may have been due at any time since then.
    fn delay(&mut self, topic: usize, since_ns: i64) {
        // Its stamp is the time at which it was sent, wherever it was meanwhile.
        if !self.mapping.is_received() {
            return;
        }
        for index in 0..self.compiled.entries.get(topic).map_or(0, Vec::len) {
            let Some(last_ns) = self.last_ns.get(&(topic, index)).copied().filter(|last_ns| *last_ns > since_ns) else {
                continue;
            };
            let (channel, why) =
                (self.channel(topic, index), format!("a message on {} was delayed", self.topic(topic)));
            let why = format!("{why}, which came at {}", crate::moment(last_ns));
            let since = Some(self.times.since_start(since_ns));
            let gap = Gap { flaw: Flaw::Late, why, channel: Some(channel), since, ends: true };
            self.order.put(last_ns, Waiting::Gap(Box::new(gap)));
            self.order.put(last_ns, Waiting::Resumed(channel));
        }
    }

    /// A message of an entry of a topic ends what was missing before it.
    fn end_gaps(&mut self, entry: (usize, usize), time_ns: i64) {
        for _ in 0..self.gaps.end(entry) {
            self.order.put(time_ns, Waiting::Resumed(self.channel(entry.0, entry.1)));
        }
    }

    /// A message comes too late to be put in order: it gets the time of what has come before it, which has been judged
    /// without it. If it belongs before all that has come, the run began earlier, and no tick is where it should be.
    fn displace(&mut self, channel: ChannelId, time_ns: i64, now_ns: i64) {
        let delay_ns = now_ns.saturating_sub(time_ns);
        self.omissions.delay(delay_ns);
        let (what, delay_s) = (self.compiled.topology.describe(channel), delay_ns as f64 * 1e-9);
        let why = format!("a message {what} comes {delay_s:.3} s too late to be put in order");
        let is_within = self.times.start_ns.is_some_and(|start_ns| start_ns <= time_ns);
        // What has the same time was recorded before it.
        let since = if is_within { self.times.since_start(time_ns + 1) } else { Duration::ZERO };
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
        // It is unknown how many items bytes that do not fit should have been.
        let each = entry.as_ref().ok().and_then(|entry| entry.each.as_ref().map(|(_, each)| each.clone()));
        let each = each.filter(|_| !matches!(reason, Reason::Mismatch(_)));
        let name = &self.source.survey().topics[topic].name;
        self.gaps.leave_out(Some(*channel), || {
            format!("{} on {name} are left out: {reason}; the first: {first}", items(each.as_deref(), false))
        });
        self.omissions.leave_out(topic, each, reason, first);
    }

    /// The next gap, ground or note. New ones come only with what is read, or left out.
    fn news(&mut self) -> Option<Found> {
        if !self.has_news {
            return None;
        }
        if let Some(gap) = self.gaps.next(&*self.source, &self.mapping, &self.compiled) {
            return Some(Found::LeftOut(gap));
        }
        if let Some((channel, ground)) = self.grounds.next(self.source.survey(), &self.mapping, &self.compiled) {
            return Some(Found::Vouched(channel, ground));
        }
        let note = self.source.notes().get(self.noted).cloned();
        self.noted += usize::from(note.is_some());
        self.has_news = note.is_some();
        note.map(Found::Noted)
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
            // The earliest message that waits is next once no earlier one can come. Ticks that are due before it come
            // first; its time is at least that of what has been returned. Time begins with the first message that
            // becomes an event.
            if let Some((time_ns, is_message)) = self.order.due() {
                if is_message && self.times.start_ns.is_none() {
                    self.times.start_ns = Some(time_ns);
                    if !self.order.odd.is_empty() {
                        self.leave_out_odd();
                        continue;
                    }
                }
                let now_ns = self.times.in_order(time_ns);
                if let Some(tick) = self.times.tick(now_ns) {
                    return Some(Found::Event(tick));
                }
                let (channel, message) = match self.order.pop()? {
                    Waiting::Message((topic, index), message) => (self.channel(topic, index), message),
                    Waiting::Gap(gap) => return Some(Found::LeftOut(*gap)),
                    Waiting::Resumed(channel) => return Some(Found::Resumed(channel)),
                };
                if time_ns < now_ns {
                    self.displace(channel, time_ns, now_ns);
                }
                let event = Found::Event(self.times.message(now_ns, channel, message));
                if self.next.is_empty() {
                    return Some(event);
                }
                self.next.insert(1, event);
            } else {
                // Time that passes without messages also makes ticks.
                match self.times.tick(self.order.settled_ns()) {
                    Some(tick) => return Some(Found::Event(tick)),
                    None if self.order.is_over => return None,
                    None if self.fill() => {}
                    None => return Some(Found::Idle),
                }
            }
        }
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
        MessageTime::Clock => clock_ns.unwrap_or(BEFORE_CLOCK),
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
