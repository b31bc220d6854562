//! Faults on channels: the affected channels and messages, and the damage.

use std::sync::Arc;

use channels::{
    Chance, ChannelId, ChannelSystem, Concern, Corruption, Disturbance, DisturbanceId, Effect as ChannelEffect,
    FieldKind, Message, Symbol, Topology, Value,
};
use diagnostics::Spanned;
use robot::Streams;
use scenarios::Complaints;
use scenarios::faults::{Damage, Effect, Which};
use scenarios::names::unknown;
use scenarios::occurrences::messages;

/// The disturbance of the messages on some channels by a fault.
#[derive(Debug)]
pub(super) struct Damages {
    /// One for each channel, with the channel's name.
    disturbances: Vec<(String, Disturbance)>,
    probability: f64,
    streams: Streams,
    /// The prefix of its streams of random numbers.
    stream: String,
    /// How often it has become active.
    times: u64,
    current: Vec<DisturbanceId>,
    /// The number of messages hit by earlier disturbances.
    hits: u64,
}

impl Damages {
    /// The damage of an effect; `None` for an effect on something else. Each activation has its own random numbers on
    /// each channel, from `streams` under a name that begins with `stream`.
    pub(super) fn prepare(
        effect: &Effect,
        topology: &Topology,
        streams: Streams,
        stream: String,
        complaints: &mut Complaints,
    ) -> Self {
        let probability = if let Effect::Channels { probability, .. } = effect { *probability } else { 1.0 };
        let disturbances = disturbances(effect, topology, complaints);
        let named = |disturbance: Disturbance| (topology.describe(disturbance.channel), disturbance);
        let disturbances = disturbances.into_iter().map(named).collect();
        Self { disturbances, probability, streams, stream, times: 0, current: Vec::new(), hits: 0 }
    }

    pub(super) fn begin(&mut self, system: &mut ChannelSystem) {
        let Self { disturbances, probability, streams, stream, times, current, .. } = self;
        for (channel, disturbance) in disturbances {
            let stream = || streams.stream(&format!("{stream}/{channel}/{times}"));
            let chance = (*probability < 1.0).then(|| Chance { probability: *probability, stream: stream() });
            current.push(system.disturb(Disturbance { probability: chance, ..disturbance.clone() }));
        }
        *times += 1;
    }

    pub(super) fn end(&mut self, system: &mut ChannelSystem) {
        self.hits += self.current.drain(..).filter_map(|id| system.calm(id)).sum::<u64>();
    }

    pub(super) fn hits(&self, system: &ChannelSystem) -> u64 {
        self.hits + self.current.iter().filter_map(|id| system.hits(*id)).sum::<u64>()
    }
}

/// The disturbances of an effect, one for each channel, which hit every message.
fn disturbances(effect: &Effect, topology: &Topology, complaints: &mut Complaints) -> Vec<Disturbance> {
    let Effect::Channels { channels, condition, damage, .. } = effect else { return Vec::new() };
    let mut disturbances = Vec::new();
    for channel in find(channels, topology, complaints) {
        let concerns = concern(channel, condition, topology, complaints);
        let effect = channel_effect(damage, channel, topology, complaints);
        let (Some(concerns), Some(effect)) = (concerns, effect) else { break };
        let disturbance = Disturbance { concerns, ..Disturbance::all(channel, effect) };
        match disturbance.check(topology) {
            Ok(()) => disturbances.push(disturbance),
            Err(error) => complaints.push(condition.span.problem(error.to_string()).with_label("this fault")),
        }
    }
    disturbances
}

fn find(which: &Which, topology: &Topology, complaints: &mut Complaints) -> Vec<ChannelId> {
    let all = |meant: &dyn Fn(&str, &str) -> bool| {
        let ends = |channel: &ChannelId| topology.ends(*channel);
        topology.channels().filter(|channel| meant(ends(channel).0, ends(channel).1)).collect()
    };
    match which {
        Which::From(component) => all(&|from, _| from == component.value),
        Which::To(component) => all(&|_, to| to == component.value),
        Which::Between(from, to) => between(from, to, topology, complaints).into_iter().collect(),
    }
}

/// The channel from one process to another; reports a problem if there is none.
fn between(
    from: &Spanned<String>,
    to: &Spanned<String>,
    topology: &Topology,
    complaints: &mut Complaints,
) -> Option<ChannelId> {
    let mut known = true;
    for name in [from, to] {
        if topology.find_process(&name.value).is_none() {
            complaints.push(unknown("process", name, topology.processes().map(|id| topology.name(id))));
            known = false;
        }
    }
    let found = topology.find_channel(&from.value, &to.value);
    if known && found.is_none() {
        let others =
            topology.channels().map(|channel| topology.ends(channel)).filter(|(other, _)| *other == from.value);
        let others: Vec<&str> = others.map(|(_, to)| to).collect();
        let problem = to.span.problem(format!("there is no channel from {} to {}", from.value, to.value));
        let help = match others.as_slice() {
            [] => format!("{} sends no messages", from.value),
            others => format!("{} sends to {}", from.value, others.join(", ")),
        };
        complaints.push(problem.with_label("it does not send to this process").with_help(help));
    }
    found
}

/// The messages of a channel that a fault affects.
fn concern(
    channel: ChannelId,
    condition: &Spanned<String>,
    topology: &Topology,
    complaints: &mut Complaints,
) -> Option<Concern> {
    if condition.value == "true" {
        return Some(Arc::new(|_| true));
    }
    let events = messages(condition, channel, topology, complaints)?;
    Some(Arc::new(move |message| events.iter().any(|event| event.condition.holds(message))))
}

/// The answer to a message of this channel that begins with this symbol and carries no values.
fn bare(answer: &str, channel: ChannelId, topology: &Topology) -> Message {
    let (source, target) = topology.ends(channel);
    let back = topology.find_channel(target, source);
    let shapes = back.into_iter().flat_map(|back| topology.get(back).domain.shapes());
    let shape = shapes.into_iter().find(|shape| shape.heads().iter().any(|head| head.name() == answer));
    let fields = shape.map_or(&[][..], |shape| shape.fields().get(1..).unwrap_or_default());
    Message::new(std::iter::once(answer).chain(fields.iter().map(|_| FieldKind::NONE)).map(Value::symbol))
}

fn channel_effect(
    damage: &Damage,
    channel: ChannelId,
    topology: &Topology,
    complaints: &mut Complaints,
) -> Option<ChannelEffect> {
    Some(match damage {
        Damage::Loss => ChannelEffect::Lose,
        Damage::Delay(by) => ChannelEffect::Hold(*by),
        Damage::Duplicate => ChannelEffect::Repeat,
        Damage::Pretence(answer) => ChannelEffect::Answer(bare(answer, channel, topology)),
        Damage::Opposite => ChannelEffect::Replace(opposite(topology, channel)),
        Damage::Corruption(text, field) => {
            ChannelEffect::Replace(corruption(text, *field, channel, topology, complaints)?)
        }
    })
}

/// The opposite of a message, if there is one that the channel can carry.
pub fn opposite(topology: &Topology, channel: ChannelId) -> Corruption {
    let domain = topology.get(channel).domain.clone();
    Arc::new(move |message| {
        let values = message.fields().iter().enumerate();
        let turned = Message::new(values.map(|(index, value)| match value {
            Value::Bool(so) => Value::Bool(!so),
            Value::Real(level) if index > 0 => (100.0 - level).into(),
            Value::Symbol(symbol) => Value::symbol(opposite_symbol(symbol)),
            other => other.clone(),
        }));
        if domain.contains(&turned) { turned } else { message.clone() }
    })
}

fn opposite_symbol(symbol: &Symbol) -> &str {
    match symbol.name() {
        "success" | "running" => "failure",
        "failure" => "success",
        other => other,
    }
}

/// The message with another value in one of its fields; a message without this field is unchanged.
fn corruption(
    text: &Spanned<String>,
    field: usize,
    channel: ChannelId,
    topology: &Topology,
    complaints: &mut Complaints,
) -> Option<Corruption> {
    let domain = topology.get(channel).domain.clone();
    let written = value(&text.value);
    // A value that no message of the channel can have there would change nothing, and is a mistake in the file.
    let kinds: Vec<&FieldKind> =
        domain.shapes().iter().filter_map(|shape| shape.fields().get(field - 1)).map(|f| &f.1).collect();
    let fits = written.as_ref().and_then(|written| kinds.iter().find_map(|kind| fitting(written, kind)));
    let Some(value) = fits else {
        let problem =
            text.span.problem(format!("`{}` is not a possible value of m[{field}] on this channel", text.value));
        let help = format!("the channel from {} carries {domain}", topology.describe(channel));
        complaints.push(problem.with_label("this value").with_help(help));
        return None;
    };
    Some(Arc::new(move |message| {
        let values = message.fields().iter().enumerate();
        let changed = values.map(|(index, old)| if index + 1 == field { value.clone() } else { old.clone() });
        let changed = Message::new(changed);
        if domain.contains(&changed) { changed } else { message.clone() }
    }))
}

/// A value in the SCOPE language.
fn value(text: &str) -> Option<Value> {
    let text = text.trim();
    if let Some(symbol) = text.strip_prefix('<').and_then(|rest| rest.strip_suffix('>')) {
        return Some(Value::symbol(symbol));
    }
    match text {
        "true" => Some(true.into()),
        "false" => Some(false.into()),
        _ => text
            .parse::<i64>()
            .map(Value::from)
            .ok()
            .or_else(|| text.parse::<f64>().ok().filter(|number| number.is_finite()).map(Value::from))
            .or_else(|| Some(text.strip_prefix('"')?.strip_suffix('"')?.into())),
    }
}

/// The value converted to a field's kind; an integer is a real number, too.
fn fitting(value: &Value, kind: &FieldKind) -> Option<Value> {
    if kind.contains(value) {
        return Some(value.clone());
    }
    let Value::Int(number) = value else { return None };
    Some(Value::from(*number as f64)).filter(|real| kind.contains(real))
}
