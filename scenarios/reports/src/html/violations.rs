//! Each violation with its witness: in words, and as a sequence chart.

use std::time::Duration;

use channels::{Event, EventKind, Topology};
use diagnostics::counted;
use drawing::canvas::Canvas;
use maps::Point;
use maud::{Markup, html};
use monitors::{Violations, WORLD};
use recording::{FaultCourse, FaultRecord, Place, RunView};

use super::evidence::{Evidence, Missing, Seen};
use super::figure::figure;
use super::markup::{self, prose, text};
use super::sent_once;
use super::sequence::{self, Row, Sequence, Weight};
use super::words;
use crate::timeline::Timeline;

/// The section with all violations; empty if there are none.
pub(super) fn section(stories: &[Story], picture: impl Fn(&Story) -> Markup) -> Markup {
    let content = html! {
        @for story in stories {
            article.panel id=(story.id) {
                h3 { code { (story.name) } " is violated" }
                (story.facts)
                div.beside { div { (story.words) } (picture(story)) }
                // The first thing to read about several violations is which ones.
                details open[stories.len() == 1] { summary { "The messages that led to it" } (story.messages) }
            }
        }
    };
    markup::section("violations", "What went wrong", content)
}

/// The stories of all violations, in the order in which they happened.
pub(super) fn stories(view: &RunView, timeline: &Timeline) -> Vec<Story> {
    timeline.episodes().iter().map(|episode| Story::of(&Evidence::of(episode, view), view, timeline)).collect()
}

/// The same in sentences only, each with the number of its property.
pub(super) fn in_sentences(view: &RunView, timeline: &Timeline) -> impl Iterator<Item = (usize, Vec<String>)> {
    timeline.episodes().iter().map(move |episode| {
        let evidence = Evidence::of(episode, view);
        let mut sentences = vec![format!("Required: {}", words::sentence(evidence.summary))];
        sentences.extend(story_sentences(&evidence, view, timeline));
        (episode.property, sentences)
    })
}

#[derive(Clone, Debug)]
pub(super) struct Story {
    /// The property's name.
    pub(super) name: String,
    id: String,
    /// When and where.
    facts: Markup,
    /// What is required, and how it was violated.
    words: Markup,
    messages: Markup,
}

impl Story {
    fn of(evidence: &Evidence<'_>, view: &RunView, timeline: &Timeline) -> Self {
        let sequence = Sequence::of(evidence, view.topology(), view.faults(), view.moves());
        let label = format!("Sequence chart of the messages that led to the violation of {}", evidence.name);
        let words = html! {
            p { "Required: " (text(&words::sentence(evidence.summary))) }
            ol.story { @for sentence in story_sentences(evidence, view, timeline) { li { (prose(&sentence)) } } }
        };
        let messages = html! {
            figure {
                (figure(&label, |layout| sequence::draw(&sequence, layout)))
                figcaption {
                    "Time runs from top to bottom; each arrow is a message, numbered by its step in the run. "
                    @if sequence.has(Weight::Cause) { "Orange: the messages that caused it. " }
                    "Red: where the property was violated"
                    @if !evidence.missing.is_empty() { ", and the message that did not come" }
                    "."
                }
            }
            details.again { summary { "The same messages as text" } (transcript(&sequence)) }
        };
        let name = evidence.name.to_owned();
        Self { id: anchor(evidence.name), facts: facts(evidence, view), words, messages, name }
    }

    /// How many bytes of the page it takes.
    pub(super) fn len(&self) -> usize {
        [&self.facts, &self.words, &self.messages].iter().map(|part| part.0.len()).sum()
    }
}

/// When and where it happened, and how often.
fn facts(evidence: &Evidence<'_>, view: &RunView) -> Markup {
    let decided = &evidence.episode.decided;
    let moment = words::moment(view, decided.time);
    let moment = if evidence.knows_ticks { format!("tick {}, {moment}", decided.tick) } else { moment };
    let mut facts = vec![("when", moment)];
    if let Some(position) = &evidence.episode.position {
        facts.push(("where", whereabouts(position, view.header().places())));
    }
    if let Some(charge_pct) = evidence.episode.charge_pct {
        facts.push(("battery", words::level(charge_pct)));
    }
    let ending = view.monitor(evidence.episode.property).ending();
    if let Some(words) = ending.violations.and_then(|all| all.in_words(view.time())) {
        facts.push(("how often", words));
    }
    html! {
        dl.facts.inline {
            @for (name, value) in facts {
                div {
                    dt { (name) }
                    dd { @if name == "when" { (markup::moment(decided.time, &text(&value))) } @else { (text(&value)) } }
                }
            }
        }
    }
}

/// A position in words: the place where the robot is, or the nearest one.
fn whereabouts(position: &Point, places: &[Place]) -> String {
    let at = format!("({:.2} m, {:.2} m)", position.x, position.y);
    let there: Vec<&str> = places.iter().filter(|place| place.covers(position)).map(|place| &*place.name).collect();
    if !there.is_empty() {
        return format!("{at}, at {}", there.join(", "));
    }
    let away = |place: &Place| maps::distance_to_area_m(&place.corners, position);
    let nearest = places.iter().map(|place| (away(place), place)).min_by(|(a, _), (b, _)| a.total_cmp(b));
    nearest.map_or(at.clone(), |(away, place)| format!("{at}, {} from {}", words::length(away), place.name))
}

/// The sequence charts of all violations as separate pictures, each with the property's name, as SVG for browsers and
/// for the renderer.
pub(super) fn pictures(view: &RunView, timeline: &Timeline) -> Vec<(String, [String; 2])> {
    let of = |episode| {
        let evidence = Evidence::of(episode, view);
        let sequence = Sequence::of(&evidence, view.topology(), view.faults(), view.moves());
        let pictures = [Canvas::for_browsers(), Canvas::new()].map(|canvas| sequence::picture(canvas, &sequence));
        (evidence.name.to_owned(), pictures)
    };
    timeline.episodes().iter().map(of).collect()
}

/// The story, in a few sentences.
pub(super) fn in_short(evidence: &Evidence<'_>, view: &RunView) -> Markup {
    let mut sentences = cause_sentences(evidence, view.faults());
    sentences.extend(owed_sentence(evidence));
    if !evidence.missing.is_empty() {
        sentences.push("It did not.".to_owned());
    }
    sentences.extend(pending_sentence(evidence));
    html! { (prose(&sentences.join(" "))) " " a href={ "#" (anchor(evidence.name)) } { "How it happened" } }
}

/// What the end of the run has violated.
fn pending_sentence(evidence: &Evidence<'_>) -> Option<String> {
    let pending = evidence.pending.as_ref()?;
    Some(format!("The run ended, and nothing comes after its end: `{pending}` was still pending."))
}

/// The id of the story of a property's violation on the page.
pub(super) fn anchor(property: &str) -> String {
    let name: String = property.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect();
    format!("violation-{name}")
}

/// The story, one sentence per step.
fn story_sentences(evidence: &Evidence<'_>, view: &RunView, timeline: &Timeline) -> Vec<String> {
    let topology = view.topology();
    let decided = &evidence.episode.decided;
    let violations = view.monitor(evidence.episode.property).ending().violations;
    let mut sentences = cause_sentences(evidence, view.faults());
    if let Some(pending) = pending_sentence(evidence) {
        sentences.push(pending);
    } else if evidence.missing.is_empty() {
        let goes_on = violations.as_ref().is_some_and(|violations| violations.goes_on);
        let for_good = if goes_on { "" } else { ": it is now violated for good" };
        sentences.push(format!("This is what `{}` forbids{for_good}.", evidence.name));
    }
    sentences.extend(owed_sentence(evidence));
    sentences.extend(channel_sentences(evidence, topology));
    sentences.extend(going_on_sentence(evidence, topology));
    sentences.extend(answer_sentence(evidence, topology, view));
    sentences.extend(activity_sentence(evidence, timeline));
    sentences.extend(component_sentence(evidence, topology, timeline));
    if !evidence.missing.is_empty() {
        let (from, to) = window(evidence);
        // Facts sent once count from the last answer on: what the other side knew when it did not answer.
        let earlier = evidence.missing.iter().filter_map(|missing| last_before(evidence, missing, topology));
        let from = earlier.map(|seen| seen.at.time).fold(from, Duration::min);
        sentences.extend(sent_once::sentence(&evidence.episode.events, (from, to), topology));
    }
    if !evidence.missing.is_empty() {
        let at = words::tick_and_time(evidence.knows_ticks, &evidence.decided());
        sentences.push(format!("At {at} it was too late: `{}` is violated.", evidence.name));
    }
    sentences.extend(afterwards_sentence(evidence, timeline));
    let given_up = view.given_up().iter().find(|given_up| given_up.time > decided.time);
    sentences
        .extend(given_up.map(|trip| format!("Navigation gave up at {}: {}.", words::time(trip.time), trip.reason)));
    sentences.extend(violations.and_then(again_sentence));
    sentences
}

/// When the property was violated again.
fn again_sentence(violations: Violations) -> Option<String> {
    /// More times than this would not make a story.
    const MOST: usize = 3;
    let again = violations.first.iter().skip(1).map(|violation| words::time(violation.from.time));
    let times: Vec<String> = again.take(MOST).collect();
    let more = violations.count.saturating_sub(1 + times.len() as u64);
    let more = if more == 0 { String::new() } else { format!(", and {} more", counted(more, "time")) };
    (!times.is_empty()).then(|| format!("It was violated again at {}{more}.", words::list(&times)))
}

/// What the tree did next.
fn afterwards_sentence(evidence: &Evidence<'_>, timeline: &Timeline) -> Option<String> {
    let decided = evidence.episode.decided.time;
    let stages = timeline.trail().stages(timeline.end());
    let next = stages.iter().find(|stage| stage.from > decided && !stage.doing.is_empty());
    Some(match next {
        Some(next) => format!("Next, at {}, the tree began to run {}.", words::time(next.from), next.doing),
        None => {
            let now = stages.last().filter(|now| now.from <= decided && !now.doing.is_empty())?;
            format!("The tree went on running {} until the end, at {}.", now.doing, words::time(timeline.end()))
        }
    })
}

/// The faults, and what the monitor saw, in the order in which they happened.
fn cause_sentences(evidence: &Evidence<'_>, faults: &[FaultRecord]) -> Vec<String> {
    let seen = evidence.causes.last().map_or(evidence.episode.decided.time, |seen| seen.at.time);
    let mut sentences = fault_sentences(evidence, faults);
    sentences.push((seen, cause_sentence(evidence)));
    sentences.sort_by_key(|(time, _)| *time);
    sentences.into_iter().map(|(_, sentence)| sentence).collect()
}

/// What the monitor saw.
fn cause_sentence(evidence: &Evidence<'_>) -> String {
    let knows_ticks = evidence.knows_ticks;
    let Some((last, before)) = evidence.causes.split_last() else {
        return format!("It was violated at {}.", words::tick_and_time(knows_ticks, &evidence.decided()));
    };
    let earlier = |seen: &Seen| {
        let at = words::tick(knows_ticks, &seen.at);
        format!("{} had {} {} `{}` at {at}", seen.from, told(seen).1, seen.to, seen.message)
    };
    let before: Vec<String> = before.iter().map(earlier).collect();
    let after = if before.is_empty() { String::new() } else { format!(", after {}", words::list(&before)) };
    let Seen { at, from, to, message } = last;
    format!("At {} {from} {} {to} `{message}`{after}.", words::tick_and_time(knows_ticks, at), told(last).0)
}

/// The verb for a message, as a simple past and as a participle.
fn told(seen: &Seen) -> (&'static str, &'static str) {
    if seen.from == WORLD { ("showed", "shown") } else { ("told", "told") }
}

/// The event that had to follow.
fn owed_sentence(evidence: &Evidence<'_>) -> Option<String> {
    let wanted = |missing: &Missing| format!("{} had to tell {} `{}`", missing.from, missing.to, missing.message);
    let wanted: Vec<String> = evidence.missing.iter().map(wanted).collect();
    let deadline = evidence.deadline_tick.map_or(String::new(), |tick| format!(" by tick {tick}"));
    (!wanted.is_empty()).then(|| format!("So {}{deadline}.", wanted.join(", or ")))
}

/// The faults that took effect shortly before the story or during it.
fn fault_sentences(evidence: &Evidence<'_>, faults: &[FaultRecord]) -> Vec<(Duration, String)> {
    /// More faults than this would not make a story.
    const MOST: usize = 3;
    let decided = evidence.episode.decided.time;
    let mut latest = FaultCourse::of(faults);
    latest.retain(|course| course.first().time <= decided);
    latest.sort_by_key(|course| course.records.iter().rfind(|record| record.time <= decided).map(|record| record.time));
    latest.drain(..latest.len().saturating_sub(MOST));
    latest
        .iter()
        .map(|course| {
            let again = match course.records.len() {
                1 => String::new(),
                times => format!(", for the first of {times} times"),
            };
            let time = course.first().time;
            (time, format!("At {} a fault took effect{again}: {}.", words::time(time), course.fault.words))
        })
        .collect()
}

/// The part of the run that the story covers.
fn window(evidence: &Evidence<'_>) -> (Duration, Duration) {
    let from_tick = evidence.since.map_or(evidence.first_tick(), |since| since.tick);
    let from_step = evidence.since.filter(|_| !evidence.knows_ticks).map_or(0, |since| since.step);
    let first = evidence.episode.events.iter().find(|event| event.tick >= from_tick && event.step >= from_step);
    let decided = evidence.episode.decided.time;
    (first.map_or(decided, |event| event.time), decided)
}

/// The activities of the tree and navigation in the meantime, or before and after a violation that took no time.
fn activity_sentence(evidence: &Evidence<'_>, timeline: &Timeline) -> Option<String> {
    let (from, to) = window(evidence);
    if evidence.missing.is_empty() {
        return turn_sentence(to, timeline);
    }
    let stages = timeline.trail().stages(timeline.end());
    let mut doing: Vec<&str> = Vec::new();
    for stage in stages.iter().filter(|stage| stage.from < to && stage.to > from && !stage.doing.is_empty()) {
        if doing.last() != Some(&stage.doing.as_str()) {
            doing.push(&stage.doing);
        }
    }
    let mut statuses: Vec<String> = Vec::new();
    for span in timeline.navigation().spans(timeline.end()).filter(|span| span.from < to && span.to > from) {
        let name = span.state.status.words();
        if !statuses.contains(&name) {
            statuses.push(name);
        }
    }
    let doing = if doing.is_empty() { return None } else { doing.join(", then ") };
    let navigation = match statuses.as_slice() {
        [] => String::new(),
        statuses => format!(", and navigation was {}", statuses.join(", then ")),
    };
    Some(format!("Meanwhile the tree was running {doing}{navigation}."))
}

/// What the tree was running at a moment, and what it was running before if it had just switched, or had ended.
fn turn_sentence(moment: Duration, timeline: &Timeline) -> Option<String> {
    let stages = timeline.trail().stages(timeline.end());
    let place = stages.iter().rposition(|stage| stage.from <= moment)?;
    let (now, turned) = (&stages[place].doing, stages[place].from == moment);
    let before = place.checked_sub(1).map(|before| &stages[before].doing).filter(|before| !before.is_empty());
    match before {
        Some(before) if now.is_empty() => {
            let until = if turned { "this moment".to_owned() } else { words::time(stages[place].from) };
            Some(format!("No leaf of the tree was running; until {until} it had been {before}."))
        }
        Some(before) if turned => {
            Some(format!("Until then the tree was running {before}; at this moment it switched to {now}."))
        }
        _ => (!now.is_empty()).then(|| format!("The tree was running {now}.")),
    }
}

/// Messages from components to the leaf that the tree was running last, while an answer was pending.
fn component_sentence(evidence: &Evidence<'_>, topology: &Topology, timeline: &Timeline) -> Option<String> {
    let (from, to) = window(evidence);
    let stages = timeline.trail().stages(timeline.end());
    let doing = &stages.iter().rfind(|stage| stage.from < to && stage.to > from && !stage.doing.is_empty())?.doing;
    let events = evidence.episode.events.iter().filter(|event| (from..=to).contains(&event.time));
    let heard = events.filter_map(|event| Seen::of(event, topology));
    let heard: Vec<Seen> = heard.filter(|seen| seen.to == *doing && seen.from != recording::TREE).collect();
    let sender = heard.last().filter(|_| !evidence.missing.is_empty())?.from.clone();
    let mut counts: Vec<(String, usize)> = Vec::new();
    for seen in heard.into_iter().filter(|seen| seen.from == sender) {
        count(&mut counts, seen.message);
    }
    let messages: Vec<String> =
        counts.iter().map(|(message, count)| format!("`{message}` {}", times(*count))).collect();
    (messages.len() <= 4).then(|| format!("{sender} told {doing} {}.", words::list(&messages)))
}

fn count(counts: &mut Vec<(String, usize)>, message: String) {
    match counts.iter_mut().find(|(known, _)| *known == message) {
        Some((_, count)) => *count += 1,
        None => counts.push((message, 1)),
    }
}

/// The last message on an answer's channel before the answer was due.
fn last_before(evidence: &Evidence<'_>, missing: &Missing, topology: &Topology) -> Option<Seen> {
    let (from, _) = window(evidence);
    let is_there = |event: &&Event| {
        event.time < from && matches!(&event.kind, EventKind::Received { channel, .. } if *channel == missing.channel)
    };
    evidence.episode.events.iter().rfind(is_there).and_then(|event| Seen::of(event, topology))
}

/// Messages on the channels on which an answer was pending.
fn channel_sentences(evidence: &Evidence<'_>, topology: &Topology) -> Vec<String> {
    let (from, _) = window(evidence);
    let decided = evidence.episode.decided.step;
    let at = |seen: &Seen| words::tick(evidence.knows_ticks, &seen.at);
    let sentence = |missing: &Missing| {
        let passed = evidence.episode.events.iter().filter(|event| {
            event.time >= from
                && event.step <= decided
                && matches!(&event.kind, EventKind::Received { channel, .. } if *channel == missing.channel)
        });
        let passed: Vec<Seen> = passed.filter_map(|event| Seen::of(event, topology)).collect();
        // An earlier message matters only if it differs: a level from before the condition may have been the right one.
        let before = last_before(evidence, missing, topology)
            .filter(|seen| passed.last().is_none_or(|last| last.message != seen.message))
            .map(|seen| format!("; the last message before that was `{}`, at {}", seen.message, at(&seen)))
            .unwrap_or_default();
        match passed.last() {
            None => format!("But {} sent {} nothing at all in that time{before}.", missing.from, missing.to),
            Some(last) => format!(
                "But {} sent {} only {} in that time, the last of them `{}` at {}{before}.",
                missing.from,
                missing.to,
                counted(passed.len(), "other message"),
                last.message,
                at(last)
            ),
        }
    };
    evidence.missing.iter().map(sentence).collect()
}

/// How the story continued after its beginning.
fn going_on_sentence(evidence: &Evidence<'_>, topology: &Topology) -> Option<String> {
    let cause = evidence.causes.last().filter(|_| !evidence.missing.is_empty())?;
    let later = evidence.episode.events.iter().filter(|event| event.step > cause.at.step);
    let later = later.filter(|event| event.step <= evidence.episode.decided.step);
    let mut later = later.filter_map(|event| Seen::of(event, topology));
    let last = later.rfind(|seen| seen.from == cause.from && seen.to == cause.to)?;
    let Seen { at, from, to, message } = &last;
    let at = words::tick(evidence.knows_ticks, at);
    Some(format!("{from} continued to send messages to {to}: the last, at {at}, was `{message}`."))
}

/// The answers to the tree from the leaves that the property concerns.
fn answer_sentence(evidence: &Evidence<'_>, topology: &Topology, view: &RunView) -> Option<String> {
    if evidence.missing.is_empty() {
        return None;
    }
    let (from, _) = window(evidence);
    let decided = evidence.episode.decided.step;
    let asked = evidence.concerned.iter().filter(|name| view.header().skills.contains(name));
    let answers = |name: &String| {
        let mut counts: Vec<(String, usize)> = Vec::new();
        let messages = evidence.episode.events.iter().filter(|event| event.time >= from && event.step <= decided);
        for seen in messages.filter_map(|event| Seen::of(event, topology)) {
            // A leaf answers the tree; its requests to components go to processes that the property concerns.
            if seen.from == *name && !evidence.concerned.contains(&seen.to) {
                count(&mut counts, seen.message);
            }
        }
        let answers: Vec<String> =
            counts.iter().map(|(message, count)| format!("`{message}` {}", times(*count))).collect();
        match answers.is_empty() {
            true => format!("{name} was not asked by the tree"),
            false => format!("{name} answered the tree {}", words::list(&answers)),
        }
    };
    let answers: Vec<String> = asked.map(answers).collect();
    (!answers.is_empty()).then(|| words::sentence(&answers.join("; ")))
}

fn times(count: usize) -> String {
    match count {
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        count => format!("{count} times"),
    }
}

/// The chart as a list, for those who cannot see it.
fn transcript(sequence: &Sequence) -> Markup {
    let name = |lifeline: usize| sequence.lifelines.get(lifeline).map_or("", String::as_str);
    let class = |weight| match weight {
        Weight::Cause => Some("cause"),
        Weight::Decisive => Some("decisive"),
        Weight::Plain | Weight::Afterwards => None,
    };
    let line = |row: &Row| match row {
        Row::Tick { tick, time } => {
            let tick = tick.map_or_else(String::new, |tick| format!("Tick {tick}, "));
            html! { li.tick { (markup::moment(*time, &(tick + &words::time(*time)))) } }
        }
        Row::Message { seen: Seen { at, from, to, message }, weight, .. } => {
            html! { li class=[class(*weight)] { "step " (at.step) ": " (from) " → " (to) " " code { (message) } } }
        }
        Row::Ticks { first, last, words } if first == last => html! { li { "Tick " (first) ": " (words) } },
        Row::Ticks { first, last, words } => html! { li { "Ticks " (first) " to " (last) ": " (words) } },
        Row::Fault { words, time } => {
            html! { li { "Fault at " (markup::moment(*time, &words::time(*time))) ": " (words) } }
        }
        Row::Moved { words } => html! { li { (words) } },
        Row::Missing { from, to, message, words } => {
            html! { li.decisive { (words) ": " (name(*from)) " → " (name(*to)) " " code { (message) } } }
        }
        Row::Verdict { words, time } => {
            html! { li.decisive { (words) " at " (markup::moment(*time, &words::time(*time))) } }
        }
    };
    html! { ul.transcript { @for row in &sequence.rows { (line(row)) } } }
}
