//! Verdicts as they are reached, while the log is still being written.

use diagnostics::seconds;
use std::io::{Write as _, stderr};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use campaigns::Error;
use channels::Verdict;
use judging::{LogContext, VerdictObserver};
use monitors::Property;
use network::{Level, PropertyStatus, Publish};
use recording::Doubts;
use serde_json::{Value, json};

use crate::moment::moment;
use crate::output::{note, print_json_line, print_wrapped};
use crate::progress::FollowProgress;

/// What is done with a violation, of this property, with this verdict. It returns a note about it.
pub(crate) type Alarm = Box<dyn FnMut(&str, &Value) -> Option<String>>;

/// What is done with verdicts, besides being reported.
#[derive(Default)]
pub(crate) struct Reactions {
    /// The command that is started with each violation.
    pub(crate) hook: Option<String>,
    /// What else is to be done with each.
    pub(crate) alarm: Option<Alarm>,
    /// What publishes how all properties stand.
    pub(crate) publish: Option<Publish>,
}

/// How often all properties are published, and how often at most if some change.
const OFTEN: Duration = Duration::from_secs(1);
const MOST_OFTEN: Duration = Duration::from_millis(100);

/// Reports each verdict as soon as it is reached, with its delay; shows undecided properties on a terminal.
pub(crate) struct Announcer {
    is_json: bool,
    reactions: Reactions,
    /// The commands that were started and may not have ended.
    hooked: Vec<Child>,
    /// When all properties were published, and whether some have changed since.
    published: Option<Instant>,
    has_changed: bool,
    line: FollowProgress,
    reported: Vec<Reported>,
    /// The time of the last event.
    time: Duration,
    /// Whether everything that had been written has been read once: what lies before is not behind, but old.
    has_caught_up: bool,
}

/// What is reported of a property.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Announcement {
    Violated,
    /// What would have undone the violation has not been lost.
    ViolatedForSure,
    HoldsAgain,
    Satisfied,
    Unsure,
    SureAgain,
}

impl Announcement {
    fn words(self) -> &'static str {
        match self {
            Self::Violated => "violated",
            Self::ViolatedForSure => "violated for sure",
            Self::HoldsAgain => "holds again",
            Self::Satisfied => "satisfied",
            Self::Unsure => "unsure",
            Self::SureAgain => "sure again",
        }
    }
}

/// What has been reported of a property.
#[derive(Default)]
struct Reported {
    verdict: Option<Announcement>,
    /// The number of its violations.
    violations: u64,
    /// Since when something is due.
    waiting_since: Option<Duration>,
    /// Whether it has been reported as violated.
    has_been_violated: bool,
    /// Why it is unsure.
    why: Option<String>,
    /// What would have undone the violation that was reported last, as far as is known.
    unless: Option<String>,
}

impl Reported {
    fn in_words(&self) -> String {
        match (self.verdict, self.waiting_since) {
            (Some(Announcement::Violated), _) if self.unless.is_some() => {
                "violated, unless a message was lost".to_owned()
            }
            (Some(verdict), _) => verdict.words().to_owned(),
            (None, Some(since)) => format!("waiting since {:.3} s", since.as_secs_f64()),
            (None, None) => "undecided".to_owned(),
        }
    }

    /// As it is published.
    fn status(&self, property: &Property) -> PropertyStatus {
        let level = match self.verdict {
            Some(Announcement::Violated) => Level::Error,
            Some(Announcement::Unsure | Announcement::HoldsAgain) => Level::Warn,
            _ => Level::Ok,
        };
        let witness = property.scope_monitor().and_then(|monitor| monitor.witness());
        let witness = witness.filter(|_| level == Level::Error).map(ToString::to_string);
        let mut values = vec![("violations", self.violations.to_string())];
        values.extend(self.why.clone().map(|why| ("unsure", why)));
        values.extend(self.unless.clone().map(|unless| ("unless", unless)));
        values.extend(witness.map(|witness| ("witness", witness)));
        PropertyStatus { property: property.name.clone(), level, message: self.in_words(), values }
    }
}

impl Announcer {
    pub(crate) fn boxed(is_json: bool, reactions: Reactions) -> Box<dyn VerdictObserver> {
        let (line, reported, hooked) = (FollowProgress::new(), Vec::new(), Vec::new());
        let (published, has_changed, has_caught_up) = (None, false, false);
        let time = Duration::ZERO;
        Box::new(Self { is_json, reactions, hooked, published, has_changed, line, reported, time, has_caught_up })
    }

    /// Publishes how the properties stand, if some have changed, and now and then.
    fn publish(&mut self, properties: &[Property]) {
        let Some(publish) = &mut self.reactions.publish else { return };
        let patience = if self.has_changed { MOST_OFTEN } else { OFTEN };
        if self.published.is_some_and(|published| published.elapsed() < patience) {
            return;
        }
        (self.published, self.has_changed) = (Some(moment()), false);
        self.reported.resize_with(properties.len(), Reported::default);
        let statuses: Vec<PropertyStatus> =
            properties.iter().zip(&self.reported).map(|(property, reported)| reported.status(property)).collect();
        publish(&statuses);
    }

    fn report(
        &mut self,
        property: &Property,
        verdict: Announcement,
        unsure: Option<&str>,
        context: &LogContext,
    ) -> Result<(), Error> {
        let witness = property.scope_monitor().and_then(|monitor| monitor.witness());
        // That of the first violation is not about a later one.
        let is_violated = verdict == Announcement::Violated;
        let witness = witness.filter(|witness| is_violated && witness.settled.time == self.time);
        let at_ns = context.start_ns.get().map(|start_ns| start_ns.saturating_add(nanoseconds(self.time)));
        let behind_s = self.has_caught_up.then_some(at_ns).flatten().and_then(behind_s);
        let knows_ticks = !context.lacks_ticks;
        let line = json!({
            "property": property.name,
            "verdict": verdict.words(),
            "time_s": seconds(self.time),
            "at_s": at_ns.map(bags::seconds),
            "behind_s": behind_s,
            "witness": witness.map(|witness| reports::witness(witness, knows_ticks)),
            "unsure": unsure,
        });
        if is_violated {
            self.call(&line);
            if let Some(text) = self.reactions.alarm.as_mut().and_then(|alarm| alarm(&property.name, &line)) {
                self.line.pause(|| note(&text));
            }
        }
        if self.is_json {
            return self.line.pause(|| print_json_line(&line));
        }
        let at = at_ns.map_or_else(String::new, |at_ns| format!("  at {}", bags::moment(at_ns)));
        let behind = behind_s.map_or_else(String::new, |behind_s| format!(", reported {behind_s:.1} s later"));
        let (time_s, verdict) = (self.time.as_secs_f64(), verdict.words());
        let mut text = format!("{time_s:>9.3} s  {}  {verdict}{at}{behind}\n", property.name);
        text.extend(unsure.map(|why| format!("  {why}\n")));
        text.extend(witness.map(|witness| reports::witness_in_words(witness, knows_ticks)));
        self.line.pause(|| print_wrapped(text))
    }

    /// Starts the command of a violation, which reads the verdict from its standard input. Its end is not awaited.
    fn call(&mut self, verdict: &Value) {
        self.hooked.retain_mut(|child| matches!(child.try_wait(), Ok(None)));
        let Some(hook) = &self.reactions.hook else { return };
        let (shell, option) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
        // Its output is none of ours.
        let started = Command::new(shell).args([option, hook]).stdin(Stdio::piped()).stdout(stderr()).spawn();
        match started {
            Ok(mut child) => {
                let (input, line) = (child.stdin.take(), format!("{verdict}\n"));
                // It may read late, or never.
                std::thread::spawn(move || input.map(|mut input| input.write_all(line.as_bytes())));
                self.hooked.push(child);
            }
            Err(error) => self.line.pause(|| note(&format!("`{hook}` could not be called: {error}"))),
        }
    }

    /// Shows a line per property on a terminal.
    fn show(&self, properties: &[Property], context: &LogContext) {
        self.line.show(|| {
            let newest = context.newest_log_ns.get().filter(|_| self.has_caught_up).and_then(behind_s);
            let newest = newest.map_or_else(String::new, |age_s| format!(", the newest message {age_s:.1} s ago"));
            let widest = properties.iter().map(|property| property.name.chars().count()).max().unwrap_or(0);
            let states = properties
                .iter()
                .zip(&self.reported)
                .map(|(property, reported)| format!("\n{:<widest$}  {}", property.name, reported.in_words()));
            format!("{:.1} s{newest}{}", self.time.as_secs_f64(), states.collect::<String>())
        });
    }
}

impl VerdictObserver for Announcer {
    /// Reports what is new after an event, or since messages are missing.
    fn follow(
        &mut self,
        time: Duration,
        properties: &[Property],
        doubts: &Doubts,
        context: &LogContext,
    ) -> Result<(), Error> {
        self.time = time;
        self.reported.resize_with(properties.len(), Reported::default);
        for (index, property) in properties.iter().enumerate() {
            let reported = &mut self.reported[index];
            // One that rests on what channels can carry is no verdict yet: a message that they cannot may be left out.
            let settled = doubts.verdict(index, property);
            let (why, later) = (doubts.why(index), doubts.why_later(index));
            let waits = property.monitor.verdict() == Verdict::Inconclusive && property.monitor.is_open();
            reported.waiting_since = if waits { reported.waiting_since.or(Some(time)) } else { None };
            // Nothing has been lost on the channel whose next message has come.
            if why.is_none() && reported.unless.is_some() && doubts.unless(index, property).is_none() {
                reported.unless = None;
                self.has_changed = true;
                self.report(property, Announcement::ViolatedForSure, None, context)?;
            }
            let reported = &mut self.reported[index];
            let violations = property.scope_monitor().and_then(|monitor| monitor.violations());
            let count = violations.map_or(0, |violations| violations.count);
            let verdict = match (settled, why) {
                (_, Some(_)) => Some(Announcement::Unsure),
                // Whether it was violated again is unsure, so that is not reported.
                (Verdict::False, None) if later.is_some() && reported.has_been_violated => reported.verdict,
                (Verdict::False, None) if violations.is_some_and(|all| all.goes_on && all.since.is_none()) => {
                    Some(Announcement::HoldsAgain)
                }
                (Verdict::False, None) => Some(Announcement::Violated),
                (Verdict::True, None) => Some(Announcement::Satisfied),
                (Verdict::Inconclusive, None) => {
                    (reported.verdict == Some(Announcement::Unsure)).then_some(Announcement::SureAgain)
                }
            };
            let is_violated = verdict == Some(Announcement::Violated);
            let is_again = is_violated && count > reported.violations && later.is_none();
            let is_new = verdict != reported.verdict || is_again;
            reported.has_been_violated |= is_violated;
            self.has_changed |= is_new;
            (reported.verdict, reported.violations) = (verdict, count);
            if reported.why.as_deref() != why {
                reported.why = why.map(str::to_owned);
            }
            if verdict == Some(Announcement::Unsure) {
                reported.unless = None;
            } else if is_new && is_violated {
                reported.unless = doubts.unless(index, property);
            }
            if let Some(verdict) = verdict.filter(|_| is_new) {
                let unless = reported.unless.clone().filter(|_| is_violated).map(|unless| format!("unless {unless}"));
                self.report(property, verdict, unless.as_deref().or(why), context)?;
            }
        }
        self.show(properties, context);
        self.publish(properties);
        Ok(())
    }

    /// Nothing more has been written.
    fn idle(&mut self, properties: &[Property], context: &LogContext) {
        self.has_caught_up = true;
        self.show(properties, context);
        self.publish(properties);
    }

    /// Prints what is to be known of the messages, once there have been some: what is known from the start is printed
    /// at the end.
    fn note(&self, text: &str) {
        if self.time > Duration::ZERO && !self.is_json {
            self.line.pause(|| note(text));
        }
    }
}

/// How long ago a moment was, in seconds, if its clock counts from 1970.
#[expect(clippy::disallowed_methods, reason = "the delay of verdicts is in real time")]
fn behind_s(ns: i64) -> Option<f64> {
    bags::date(ns)?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH).ok()?;
    Some(nanoseconds(now).saturating_sub(ns) as f64 * 1e-9)
}

fn nanoseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)
}
