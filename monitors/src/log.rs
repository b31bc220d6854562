//! Recorded event logs: JSON Lines with one message or tick per line, read as a stream.
//!
//! The first line describes the run. The events follow in the order in which they happened.
//! `{"step":812,"tick":67,"time_s":67.02,"from":"BatteryReader","to":"BatteryLevel", "message":[{"sym":"ok"},83.2]}` is
//! a received message, `{"step":9,"tick":67,"time_s":67.0,"generated": "tick"}` is a tick. Lines with neither `from`,
//! `to` or `message` nor `generated` are of other kinds and are skipped. `{"missing":"3 messages","flaw":"missing",
//! "since_s":66.5}` is a gap: from here on messages may be missing, or `late`, or `mixed` with others. With
//! `"channel":["Robot","BatteryReader"]`, they are those of a channel; and if it `ends`, until a line with `resumed`
//! names this channel. Messages are numbered by their steps, from 1, and ticks from 0; a tick has the step of the
//! message before it. So has a message of the world, which is no step: instead, each line from the first of these on
//! gives their number so far, `"world":7`. If the first line has `"has_end":true`, the last one has the cause and
//! time of the end, and repeats the last numbers: `{"end":"arrival","step":812,"tick":67,"time_s":67.5}`. With
//! `"gaps":2`, two lines before it begin or end gaps.
//!
//! Monitors foresee from the domains of the channels what may come. So a message that its channel cannot carry never
//! reaches them: it is an error.

mod continuity;
mod found;
mod scan;
mod values;

use std::io::BufRead;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Domain, Event, EventKind, FieldKind, Flaw, Gap, Message, Monitor, Topology, Value};

use crate::WORLD;
use crate::monitor::EventTime;
use continuity::Continuity;
use found::Found;
pub use found::GapMark;
use scan::{JsonToken, Scanner, Unreadable};
use values::MessageReader;

/// Why an event log cannot be read further.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The operating system could not read it.
    #[error("the log cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// A line is not a valid line of a log.
    #[error("line {line} of the log, byte {column}: {problem}")]
    Line {
        /// The number of the line, counted from 1.
        line: u64,
        /// The number of the byte in the line, counted from 1.
        column: usize,
        /// Its problem.
        problem: String,
    },
    /// A message between processes that are not connected by a channel.
    #[error("line {line} of the log: there is no channel from {from} to {to}")]
    UnknownChannel {
        /// The number of the line, counted from 1.
        line: u64,
        /// The process that sent it.
        from: String,
        /// The process that received it.
        to: String,
    },
    /// A message that its channel cannot carry.
    #[error("line {line} of the log: {message}")]
    Foreign {
        /// The number of the line, counted from 1.
        line: u64,
        /// The message.
        message: ForeignMessage,
    },
    /// An event after the line with the end of the run.
    #[error("line {line} of the log comes after the end of its run")]
    AfterEnd {
        /// The number of the line, counted from 1.
        line: u64,
    },
    /// Lines are not in chronological order.
    #[error("line {line} of the log goes back in time: step {step}, tick {tick}, {} s", time.as_secs_f64())]
    Backwards {
        /// The number of the line, counted from 1.
        line: u64,
        /// The line's step. It, the tick or the time is less than that of a previous line.
        step: u64,
        /// The line's tick.
        tick: u64,
        /// The line's time.
        time: Duration,
    },
}

/// A message that its channel cannot carry.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{channel} does not carry {message}{}, but {domain}", rounded(message, domain))]
pub struct ForeignMessage {
    /// The channel, in words.
    channel: String,
    message: Message,
    /// What the channel carries.
    domain: Domain,
}

/// A recorded message as a channel between these processes carries it. As for monitors, a domain without shapes
/// contains every message.
///
/// # Errors
/// [`ForeignMessage`] if the channel cannot carry it.
pub fn admit(message: Message, (from, to): (&str, &str), domain: &Domain) -> Result<Message, ForeignMessage> {
    // Nearly every message fits as it is, and is passed on without a copy.
    if domain.shapes().is_empty() || domain.contains(&message) {
        return Ok(message);
    }
    let foreign = |message| ForeignMessage { channel: format!("{from} → {to}"), message, domain: domain.clone() };
    domain.admit(&message).ok_or_else(|| foreign(message))
}

/// That an integer of the message would be rounded, if nothing else keeps it out of the domain.
fn rounded(message: &Message, domain: &Domain) -> String {
    let is_real = |kind: &FieldKind| kind.contains(&Value::Real(0.0));
    let inexact = domain.shapes().iter().find_map(|shape| {
        let (fields, values) = (shape.fields(), message.fields());
        let mut outside = fields.iter().zip(values).filter(|((_, kind), value)| !kind.contains(value));
        let is_integer =
            |((_, kind), value): &(&(String, FieldKind), &Value)| is_real(kind) && matches!(value, Value::Int(_));
        let fits = fields.len() == values.len() && outside.clone().all(|field| is_integer(&field));
        outside
            .find(|(_, value)| matches!(value, Value::Int(integer) if Value::exact_real(*integer).is_none()))
            .filter(|_| fits)
    });
    inexact.map_or_else(String::new, |((field, _), value)| {
        format!(" (as a real number, {field} = {value} would be rounded)")
    })
}

/// Which messages of a log are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Channels {
    /// Messages on channels that the topology does not have are an error.
    #[default]
    All,
    /// Messages on channels that the topology does not have are skipped.
    Known,
}

/// Reads the events of a log one after the other, in constant memory.
///
/// ```
/// use channels::{Capacity, Domain, Topology};
/// use monitors::{Channels, EventLog};
///
/// let mut topology = Topology::default();
/// let [reader, skill] = [topology.process("BatteryReader")?, topology.process("BatteryLevel")?];
/// topology.channel(reader, skill, Capacity::One, Domain::new([]))?;
/// let text = r#"{"scenario":"nominal"}
/// {"step":0,"tick":0,"time_s":0.0,"generated":"tick"}
/// {"step":1,"tick":0,"time_s":0.5,"from":"BatteryReader","to":"BatteryLevel","message":[{"sym":"ok"},83.2]}
/// "#;
/// let mut log = EventLog::new(text.as_bytes(), &topology, Channels::All);
/// assert_eq!(log.next_event()?.map(|event| event.tick), Some(0));
/// assert_eq!(log.next_event()?.map(|event| event.step), Some(1));
/// assert!(log.next_event()?.is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct EventLog<R> {
    input: R,
    line: Vec<u8>,
    channels: Vec<NamedChannel>,
    /// The place of the last message's channel: the next one often has the same.
    recent: usize,
    which: Channels,
    continuity: Continuity,
    values: MessageReader,
    /// Whether the log announces a line with the end of the run, whether this has come, and whether nothing is
    /// read after it.
    has_end: bool,
    is_ended: bool,
    stops_at_end: bool,
    /// When the run ended.
    end: Option<Duration>,
    /// The number of messages skipped because their channels are unknown.
    skipped: u64,
    is_foreign: bool,
}

/// A channel by the names of its ends.
#[derive(Debug)]
struct NamedChannel {
    from: String,
    to: String,
    channel: ChannelId,
    domain: Domain,
}

/// Whether a line is only the beginning of one, as the last line of a file that was cut off: it never closes what it
/// opens.
fn breaks_off(line: &[u8]) -> bool {
    let (mut open, mut is_quoted, mut is_escaped) = (0, false, false);
    for byte in line {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' => is_escaped = is_quoted,
            b'"' => is_quoted = !is_quoted,
            b'{' | b'[' if !is_quoted => open += 1,
            b'}' | b']' if !is_quoted => open -= 1,
            _ => {}
        }
    }
    !line.ends_with(b"\n") && (is_quoted || open > 0)
}

/// The longest line allowed. A line is held in memory, and a log without line breaks could be of any size.
const MAX_LINE: usize = 1 << 20;

impl<R: BufRead> EventLog<R> {
    /// A log over the channels of a topology.
    pub fn new(input: R, topology: &Topology, which: Channels) -> Self {
        let outer = topology.channels().filter(|channel| !topology.is_internal(*channel));
        let channels = outer.map(|channel| {
            let (from, to) = topology.ends(channel);
            let domain = topology.get(channel).domain.clone();
            NamedChannel { from: from.to_owned(), to: to.to_owned(), channel, domain }
        });
        Self {
            input,
            line: Vec::new(),
            channels: channels.collect(),
            recent: 0,
            which,
            continuity: Continuity::start(),
            values: MessageReader::default(),
            has_end: false,
            is_ended: false,
            stops_at_end: false,
            end: None,
            skipped: 0,
            is_foreign: false,
        }
    }

    /// Reads nothing after the line with the end of the run, as where a reader would wait for more. What follows is not
    /// refused then.
    #[must_use]
    pub fn until_end(self) -> Self {
        Self { stops_at_end: true, ..self }
    }

    /// The next event; `None` at the end of the log.
    ///
    /// # Errors
    /// [`LogError`] if the log cannot be read, or a line is invalid.
    pub fn next_event(&mut self) -> Result<Option<Event>, LogError> {
        while !(self.stops_at_end && self.is_ended) {
            self.line.clear();
            let mut limited = std::io::Read::take(&mut self.input, MAX_LINE as u64);
            if limited.read_until(b'\n', &mut self.line)? == 0 {
                return Ok(None);
            }
            self.continuity.line += 1;
            if self.line.len() >= MAX_LINE {
                return Err(self.complaint(MAX_LINE, "this line is longer than 1 MiB"));
            }
            let line = std::mem::take(&mut self.line);
            let mut event = self.event(&line);
            if let Err(LogError::Line { .. }) = event
                && breaks_off(&line)
            {
                let why = format!("the log breaks off in line {}", self.continuity.line);
                self.continuity.gaps.push_back(GapMark::Begins(self.rest(why)));
                (self.is_ended, event) = (true, Ok(None));
            }
            self.line = line;
            if let Some(event) = event? {
                return Ok(Some(event));
            }
        }
        Ok(None)
    }

    /// The number of messages skipped because the topology does not have their channels.
    #[must_use]
    pub fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Whether one of these shows that the log is of another system. What is true in the world is in a log if a
    /// property of its run asked for it.
    #[must_use]
    pub fn is_foreign(&self) -> bool {
        self.is_foreign
    }

    /// Where the next gap before the last event, or at the end, begins or ends: one that the log names, or that lines
    /// are missing or come twice, where steps or ticks are not consecutive for the first time. A missing end of the log
    /// is not among them: see [`lacks_end`](Self::lacks_end).
    pub fn next_gap_mark(&mut self) -> Option<GapMark> {
        self.continuity.gaps.pop_front()
    }

    /// The gap from the last event to the end of the run, in a log that breaks off. Without its first tick, anything
    /// may be missing from its start.
    #[must_use]
    pub fn rest(&self, why: impl Into<String>) -> Gap {
        // A log that does not announce an end may have no ticks either.
        let since = self.continuity.doubted_since().filter(|_| self.has_end);
        let flaw = if since.is_some() { Flaw::Displaced } else { Flaw::Missing };
        Gap { flaw, since, ..Gap::of_anything(why) }
    }

    /// Whether the line with the end of the run has not come, although the log announces it.
    #[must_use]
    pub fn lacks_end(&self) -> bool {
        self.has_end && !self.is_ended
    }

    /// When the run ended, if the line with its end has come and has the time.
    #[must_use]
    pub fn end(&self) -> Option<Duration> {
        self.end
    }

    fn complaint(&self, at: usize, problem: &str) -> LogError {
        LogError::Line { line: self.continuity.line, column: at + 1, problem: problem.to_owned() }
    }

    fn event(&mut self, line: &[u8]) -> Result<Option<Event>, LogError> {
        let number = self.continuity.line;
        let unreadable =
            |Unreadable { at, problem }| LogError::Line { line: number, column: at + 1, problem: problem.to_owned() };
        let mut scanner = Scanner::new(line);
        if scanner.at_end() {
            return Ok(None);
        }
        let mut found = self.object(&mut scanner).map_err(unreadable)?;
        if let Some(mut gap) = found.gap.take() {
            let marked = gap.mark(|from, to| {
                let place = self.channel(from, to)?;
                Some(self.channels[place].channel)
            });
            self.continuity.mark(marked);
        }
        if found.is_end {
            return self.finish(&found).map(|()| None);
        }
        if !found.generated && found.from.is_none() && found.to.is_none() && found.message.is_none() {
            return Ok(None);
        }
        if self.is_ended {
            return Err(LogError::AfterEnd { line: number });
        }
        let missing = |key: &str| self.complaint(0, &format!("this event has no `{key}`"));
        let step = found.step.ok_or_else(|| missing("step"))?;
        let tick = found.tick.ok_or_else(|| missing("tick"))?;
        let time = found.time.ok_or_else(|| missing("time_s"))?;
        if !self.continuity.note((step, tick, time), &found) {
            return Err(LogError::Backwards { line: number, step, tick, time });
        }
        let kind = if found.generated { Some(EventKind::Tick) } else { self.received(found)? };
        Ok(kind.map(|kind| Event { step, tick, time, kind }))
    }

    /// The line with the end of the run: the numbers that it repeats are those of the last events, or lines are
    /// missing.
    fn finish(&mut self, found: &Found<'_>) -> Result<(), LogError> {
        let (step, tick, last) = self.continuity.last;
        if std::mem::replace(&mut self.is_ended, true) {
            return Err(LogError::AfterEnd { line: self.continuity.line });
        }
        if let Some(time) = found.time.filter(|time| *time < last) {
            return Err(LogError::Backwards { line: self.continuity.line, step, tick, time });
        }
        self.end = found.time;
        self.continuity.finish(found);
        Ok(())
    }

    /// The message of a line; `None` if it is skipped.
    fn received(&mut self, found: Found<'_>) -> Result<Option<EventKind>, LogError> {
        let missing = |key: &str| self.complaint(0, &format!("this message has no `{key}`"));
        let from = found.from.ok_or_else(|| missing("from"))?;
        let to = found.to.ok_or_else(|| missing("to"))?;
        let message = found.message.ok_or_else(|| missing("message"))?;
        match (self.channel(from, to), self.which) {
            (Some(place), _) => {
                let NamedChannel { from, to, channel, domain } = &self.channels[place];
                let admitted = admit(message, (from, to), domain);
                let admitted = admitted.map_err(|message| LogError::Foreign { line: self.continuity.line, message })?;
                Ok(Some(EventKind::Received { channel: *channel, message: admitted }))
            }
            (None, Channels::Known) => {
                self.skipped += 1;
                self.is_foreign |= from != WORLD.as_bytes();
                Ok(None)
            }
            (None, Channels::All) => {
                let [from, to] = [from, to].map(|name| String::from_utf8_lossy(name).into_owned());
                Err(LogError::UnknownChannel { line: self.continuity.line, from, to })
            }
        }
    }

    fn object<'a>(&mut self, scanner: &mut Scanner<'a>) -> Result<Found<'a>, Unreadable> {
        let mut found = Found::default();
        scanner.expect(b'{')?;
        if scanner.take(b'}') {
            return Ok(found);
        }
        loop {
            let key = scanner.string()?;
            scanner.expect(b':')?;
            match key {
                b"step" => found.step = Some(scanner.whole()?),
                b"tick" => found.tick = Some(scanner.whole()?),
                b"time_s" => found.time = Some(scanner.seconds()?),
                b"from" => found.from = Some(scanner.string()?),
                b"to" => found.to = Some(scanner.string()?),
                b"generated" => found.generated = scanner.string()? == b"tick",
                b"message" => found.message = Some(self.values.message(scanner)?),
                b"missing" => match scanner.token()? {
                    JsonToken::Text(why) => found.gap().missing = Some(why.into_owned()),
                    _ => return Err(scanner.unreadable("what is missing must be a string")),
                },
                b"flaw" => {
                    found.gap().flaw = match scanner.string()? {
                        b"displaced" => Flaw::Displaced,
                        b"late" => Flaw::Late,
                        b"mixed" => Flaw::Mixed,
                        b"missing" => Flaw::Missing,
                        b"ticks" => Flaw::Ticks,
                        _ => {
                            return Err(scanner
                                .unreadable("a flaw is \"missing\", \"late\", \"displaced\", \"mixed\" or \"ticks\""));
                        }
                    }
                }
                // In a log of another program, these may be anything.
                b"world" => found.world = scanner.value()?.parse().ok(),
                b"tick_s" => self.continuity.has_ticks = scanner.value()?.parse() != Ok(0.0),
                b"gaps" => found.marks = scanner.value()?.parse().ok().filter(|_| self.has_end),
                b"has_end" => self.has_end |= scanner.token()? == JsonToken::Bool(true),
                b"end" => {
                    scanner.skip()?;
                    // In a log of another program, it may mean anything.
                    found.is_end = self.has_end;
                }
                b"since_s" => found.gap().since = Some(scanner.seconds()?),
                b"channel" => found.gap().on = Some(scanner.pair()?),
                b"ends" => found.gap().ends = scanner.token()? == JsonToken::Bool(true),
                b"resumed" => found.gap().resumed = Some(scanner.pair()?),
                _ => scanner.skip()?,
            }
            if !scanner.take(b',') {
                break;
            }
        }
        scanner.expect(b'}')?;
        if scanner.at_end() { Ok(found) } else { Err(scanner.unreadable("expected the end of the line")) }
    }

    /// The place of the channel between these processes.
    fn channel(&mut self, from: &[u8], to: &[u8]) -> Option<usize> {
        let is = |named: &NamedChannel| named.from.as_bytes() == from && named.to.as_bytes() == to;
        if !self.channels.get(self.recent).is_some_and(is) {
            self.recent = self.channels.iter().position(is)?;
        }
        Some(self.recent)
    }
}

/// The processes and channels that occur in a log, with unrestricted messages: for logs whose system is not available.
///
/// Reads the whole log once.
///
/// # Errors
/// [`LogError`] if the log cannot be read.
pub fn topology_of_log<R: BufRead>(input: R) -> Result<Arc<Topology>, LogError> {
    let mut log = EventLog::new(input, &Topology::default(), Channels::All);
    let mut topology = Topology::default();
    loop {
        match log.next_event() {
            Ok(None) => return Ok(Arc::new(topology)),
            Ok(Some(_)) => {}
            Err(LogError::UnknownChannel { line, from, to }) => {
                let complaint = |problem: String| LogError::Line { line, column: 1, problem };
                let mut process = |name: &str| match topology.find_process(name) {
                    Some(process) => Ok(process),
                    None => topology.process(name).map_err(|error| complaint(error.to_string())),
                };
                let (source, target) = (process(&from)?, process(&to)?);
                let domain = Domain::new([]);
                let channel = topology
                    .channel(source, target, channels::Capacity::One, domain.clone())
                    .map_err(|error| complaint(error.to_string()))?;
                log.channels.push(NamedChannel { from, to, channel, domain });
            }
            Err(error) => return Err(error),
        }
    }
}

/// The extent of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct LogEnd {
    /// The number of messages read.
    pub messages: u64,
    /// The number of ticks generated.
    pub ticks: u64,
    /// The time of the last event.
    pub last: Option<EventTime>,
    /// When the run ended, if the log has that.
    pub ended: Option<Duration>,
}

impl LogEnd {
    /// When the log ends: with its run, or with the last event.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.ended.or(self.last.map(|last| last.time)).unwrap_or_default()
    }

    /// Counts an event, which is the last so far.
    pub fn count(&mut self, event: &Event) {
        match event.kind {
            EventKind::Tick => self.ticks += 1,
            EventKind::Received { .. } => self.messages += 1,
        }
        self.last = Some(EventTime::of(event));
    }
}

impl<R: BufRead> Iterator for EventLog<R> {
    type Item = Result<Event, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_event().transpose()
    }
}

/// Feeds recorded events to monitors, one by one, until they end. It ignores whether some are missing from a log: see
/// [`EventLog::next_gap_mark`] and [`EventLog::lacks_end`].
///
/// # Errors
/// Those of the events themselves, such as [`LogError`] if a log cannot be read.
pub fn verify<'a, E>(
    events: impl IntoIterator<Item = Result<Event, E>>,
    monitors: impl IntoIterator<Item = &'a mut dyn Monitor>,
) -> Result<LogEnd, E> {
    let mut monitors: Vec<&mut dyn Monitor> = monitors.into_iter().collect();
    let mut end = LogEnd::default();
    for event in events {
        let event = event?;
        end.count(&event);
        monitors.iter_mut().for_each(|monitor| monitor.observe(&event));
    }
    Ok(end)
}
