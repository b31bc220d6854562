//! The numbers of a run, computed from its event log alone, as slowly and simply as possible.

use serde_json::Value;

/// A message: who sent it, to whom, and its first field.
pub(crate) type Word = (String, String, String);

/// A property whose meaning is obvious.
pub(crate) struct Property {
    pub(crate) name: String,
    pub(crate) text: String,
    pub(crate) kind: Kind,
}

/// What it demands.
pub(crate) enum Kind {
    /// Always not this: every message of the channel is checked.
    Ban(Word),
    /// The same, in other words.
    Never(Word),
    /// Eventually this.
    Eventually(Word),
    /// After each of the first, some time, the second.
    Answered(Word, Word),
    /// After each of the first, some time the second, or the third within fewer than so many ticks.
    Either(Word, Word, Word, u64),
    /// This in time from the first state on.
    Within(Word, Limit),
    /// This in time from the first state on, if the first ever comes.
    Provided(Word, Word, Limit),
    /// The second in time after each of the first, until the third.
    Guarded(Word, Word, Word, Limit),
}

/// A limit of a timed property: `<`, `<=` or `=` so many milliseconds.
#[derive(Clone, Copy)]
pub(crate) struct Limit {
    pub(crate) relation: &'static str,
    pub(crate) ms: u64,
}

impl Limit {
    fn is_kept(self, elapsed: u64) -> bool {
        elapsed == self.due() && self.relation != "<" || elapsed < self.due() && self.relation != "="
    }

    /// Whether it is too late.
    fn is_over(self, elapsed: u64) -> bool {
        elapsed > self.due() || elapsed == self.due() && self.relation == "<"
    }

    fn due(self) -> u64 {
        self.ms * 1_000_000
    }
}

/// What became of an answer that is due.
enum Due {
    Met,
    Open,
    /// The time and the tick at which it was missed.
    Missed((u64, u64)),
}

impl Kind {
    pub(crate) fn is_timed(&self) -> bool {
        matches!(self, Self::Within(..) | Self::Provided(..) | Self::Guarded(..))
    }

    pub(crate) fn formula(&self) -> String {
        let event = |(from, to, word): &Word| format!("({from}, {to}, m[1] = <{word}>)");
        let in_time =
            |word: &Word, Limit { relation, ms }: &Limit| format!("time_until {} {relation} {ms} ms", event(word));
        match self {
            Self::Ban(word) => format!("always not {}", event(word)),
            Self::Never(word) => format!("not eventually {}", event(word)),
            Self::Eventually(word) => format!("eventually {}", event(word)),
            Self::Answered(asked, answer) => format!("always ({} implies eventually {})", event(asked), event(answer)),
            Self::Either(asked, answer, soon, ticks) => format!(
                "always ({} implies eventually {} or time_until {} < {ticks})",
                event(asked),
                event(answer),
                event(soon)
            ),
            Self::Within(answer, limit) => in_time(answer, limit),
            Self::Provided(condition, answer, limit) => {
                format!("eventually {} implies {}", event(condition), in_time(answer, limit))
            }
            Self::Guarded(asked, answer, goal, limit) => {
                format!("({} implies {}) until {}", event(asked), in_time(answer, limit), event(goal))
            }
        }
    }
}

/// What is counted of a property in a run.
#[derive(Debug, PartialEq)]
pub(crate) struct Found {
    pub(crate) verdict: &'static str,
    /// The time of the first violation, in nanoseconds, and its tick.
    pub(crate) at: Option<(u64, u64)>,
    pub(crate) violations: u64,
    /// How long they lasted, in nanoseconds, if it can be violated again.
    pub(crate) lasted: Option<u64>,
}

/// A line of the event log.
struct Line {
    time: u64,
    tick: u64,
    /// None for a tick.
    word: Option<Word>,
}

fn is(line: &Line, word: &Word) -> bool {
    line.word.as_ref() == Some(word)
}

/// The event log of a run.
pub(crate) struct Log {
    lines: Vec<Line>,
    /// Whether the root of the tree ever failed.
    pub(crate) has_failed: bool,
    pub(crate) end: u64,
}

/// A number of seconds in nanoseconds.
pub(crate) fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

impl Log {
    pub(crate) fn read(text: &str, end_s: f64) -> Self {
        let mut log = Self { lines: Vec::new(), has_failed: false, end: nanoseconds(end_s) };
        for line in text.lines().skip(1).map(|line| serde_json::from_str::<Value>(line).unwrap()) {
            if let Some(tree) = line["tree"].as_object() {
                log.has_failed |= tree.iter().any(|(node, status)| node.starts_with("0 ") && status == "failure");
                continue;
            }
            if line.get("end").is_some() {
                assert_eq!(nanoseconds(line["time_s"].as_f64().unwrap()), log.end);
                continue;
            }
            let words = ["from", "to"].map(|key| line[key].as_str().map(str::to_owned));
            let word = match words {
                [Some(from), Some(to)] => Some((from, to, line["message"][0]["sym"].as_str().unwrap().to_owned())),
                _ => None,
            };
            let (time, tick) = (nanoseconds(line["time_s"].as_f64().unwrap()), line["tick"].as_u64().unwrap());
            log.lines.push(Line { time, tick, word });
        }
        log
    }

    pub(crate) fn ticks(&self) -> u64 {
        self.lines.iter().filter(|line| line.word.is_none()).count() as u64
    }

    fn all<'l>(&'l self, word: &'l Word) -> impl Iterator<Item = &'l Line> {
        self.lines.iter().filter(move |line| is(line, word))
    }

    /// The leaves that did not answer a request within the two seconds that a tree waits for them.
    pub(crate) fn silent(&self, leaves: impl Iterator<Item = String>) -> Vec<String> {
        let is_silent = |leaf: &String| {
            let requests = self
                .lines
                .iter()
                .enumerate()
                .filter(|(_, line)| line.word.as_ref().is_some_and(|(from, to, _)| from == "BT" && to == leaf));
            requests.into_iter().any(|(place, asked)| {
                let (_, _, request) = asked.word.as_ref().unwrap();
                let answers = |line: &&Line| match &line.word {
                    Some((from, _, answer)) => from == leaf && (answer == "halted") == (request == "halt"),
                    None => false,
                };
                let answer = self.lines[place + 1..].iter().find(answers).map_or(u64::MAX, |line| line.time);
                let deadline = asked.time + 2_000_000_000;
                // What is answered at the deadline comes after the tree has given up.
                answer >= deadline && deadline <= self.end
            })
        };
        leaves.filter(is_silent).collect()
    }

    /// The ticks, and the messages on the channels of these words.
    fn states(&self, words: &[&Word]) -> Vec<&Line> {
        let is_on = |(from, to, _): &Word| words.iter().any(|word| (from, to) == (&word.0, &word.1));
        self.lines.iter().filter(|line| line.word.as_ref().is_none_or(is_on)).collect()
    }

    /// What is counted of a property.
    pub(crate) fn count(&self, property: &Property, is_final: bool) -> Found {
        let satisfied = Found { verdict: "satisfied", at: None, violations: 0, lasted: None };
        let last_tick = self.ticks().saturating_sub(1);
        let open = |is_final| match is_final {
            true => Found { verdict: "violated", at: Some((self.end, last_tick)), violations: 1, lasted: None },
            false => Found { verdict: "inconclusive", at: None, violations: 0, lasted: None },
        };
        let missed = |at| Found { verdict: "violated", at: Some(at), violations: 1, lasted: None };
        match &property.kind {
            Kind::Ban(word) | Kind::Never(word) => self.stretches(word).unwrap_or(satisfied),
            Kind::Eventually(word) if self.all(word).next().is_some() => satisfied,
            Kind::Eventually(_) => open(is_final),
            Kind::Answered(asked, answer) => {
                let place = |word: &Word| self.lines.iter().rposition(|line| line.word.as_ref() == Some(word));
                if place(asked) > place(answer) { open(is_final) } else { satisfied }
            }
            Kind::Either(asked, answer, soon, ticks) => {
                let after = |place: usize, word| self.lines[place..].iter().filter(move |line| is(line, word));
                let owed = (0..self.lines.len()).filter(|place| is(&self.lines[*place], asked));
                let owed = owed.filter(|place| {
                    let due = self.lines[*place].tick + ticks;
                    after(*place, answer).next().is_none() && !after(*place, soon).any(|line| line.tick < due)
                });
                let owed: Vec<u64> = owed.map(|place| self.lines[place].tick).collect();
                let is_late = owed.iter().any(|tick| tick + ticks <= last_tick);
                if owed.is_empty() { satisfied } else { open(is_final && is_late) }
            }
            Kind::Within(answer, limit) => match due(&self.states(&[answer]), answer, *limit) {
                Due::Met => satisfied,
                Due::Open => open(false),
                Due::Missed(at) => missed(at),
            },
            Kind::Provided(condition, answer, limit) => {
                let condition_at = self.all(condition).next().map(|line| (line.time, line.tick));
                match (condition_at, due(&self.states(&[condition, answer]), answer, *limit)) {
                    (None, _) | (_, Due::Met) => satisfied,
                    (Some(_), Due::Open) => open(false),
                    (Some(condition_at), Due::Missed(at)) => missed(at.max(condition_at)),
                }
            }
            Kind::Guarded(asked, answer, goal, limit) => {
                let states = self.states(&[asked, answer, goal]);
                let end = states.iter().position(|line| is(line, goal));
                let asked = (0..end.unwrap_or(states.len())).filter(|place| is(states[*place], asked));
                let dues: Vec<Due> = asked.map(|place| due(&states[place..], answer, *limit)).collect();
                let first =
                    dues.iter().filter_map(|due| if let Due::Missed(at) = due { Some(*at) } else { None }).min();
                match first {
                    Some(at) => missed(at),
                    None if end.is_none() => open(is_final),
                    None if dues.iter().any(|due| matches!(due, Due::Open)) => open(false),
                    None => satisfied,
                }
            }
        }
    }

    /// Each stretch from a forbidden message to the next of its channel that is not forbidden.
    fn stretches(&self, word: &Word) -> Option<Found> {
        let mut found: Option<Found> = None;
        let mut since: Option<u64> = None;
        for line in &self.lines {
            let Some(said) = line.word.as_ref().filter(|said| (&said.0, &said.1) == (&word.0, &word.1)) else {
                continue;
            };
            if said == word && since.is_none() {
                since = Some(line.time);
                let at = Some((line.time, line.tick));
                let found = found.get_or_insert(Found { verdict: "violated", at, violations: 0, lasted: Some(0) });
                found.violations += 1;
            } else if said != word
                && let (Some(from), Some(found)) = (since.take(), &mut found)
            {
                *found.lasted.as_mut().unwrap() += line.time - from;
            }
        }
        if let (Some(from), Some(found)) = (since, &mut found) {
            *found.lasted.as_mut().unwrap() += self.end - from;
        }
        found
    }

    /// Whether a satisfied property demanded nothing.
    pub(crate) fn is_vacuous(&self, property: &Property, verdict: &str) -> bool {
        match &property.kind {
            Kind::Answered(asked, _) | Kind::Either(asked, ..) => {
                verdict == "satisfied" && self.all(asked).next().is_none()
            }
            Kind::Provided(condition, ..) => verdict == "satisfied" && self.all(condition).next().is_none(),
            Kind::Ban(_) | Kind::Never(_) | Kind::Eventually(_) | Kind::Within(..) | Kind::Guarded(..) => false,
        }
    }
}

/// Whether the answer comes in time from the first of these states on. That it does not is noticed at the first state
/// for which it is too late; the tick of the deadline is the one that began before it.
fn due(states: &[&Line], answer: &Word, limit: Limit) -> Due {
    let start = states[0].time;
    if states.iter().any(|line| is(line, answer) && limit.is_kept(line.time - start)) {
        return Due::Met;
    }
    let Some(noticed) = states.iter().position(|line| limit.is_over(line.time - start)) else { return Due::Open };
    let at = start + limit.due();
    let mut before = states[..=noticed].iter().rev().filter(|line| line.word.is_some() || line.time <= at);
    Due::Missed((at, before.next().unwrap().tick))
}

/// The exact interval of Clopper and Pearson, by bisection on sums of binomial terms.
pub(crate) fn interval(happened: u64, runs: u64) -> [f64; 2] {
    let power = |p: f64, times: u64| (0..times).fold(1.0, |all, _| all * p);
    let term = |k: u64, p: f64| {
        (0..k).fold(1.0, |all, i| all * (runs - i) as f64 / (i + 1) as f64) * power(p, k) * power(1.0 - p, runs - k)
    };
    let at_most = |k: u64, p: f64| (0..=k).map(|k| term(k, p)).sum::<f64>();
    let root = |is_low: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..200 {
            let middle = (low + high) / 2.0;
            if is_low(middle) { low = middle } else { high = middle }
        }
        low
    };
    let low = if happened == 0 { 0.0 } else { root(&|p| 1.0 - at_most(happened - 1, p) < 0.025) };
    let high = if happened == runs { 1.0 } else { root(&|p| at_most(happened, p) > 0.025) };
    [low, high]
}
