//! What a system has for its properties alone: what is true in the simulated world, as the fields of the message that
//! the world shows to monitors, `(World, Monitors, level_pct < 20)`, which no process of the system receives, so it
//! changes no run; and topics that no other process reads, which the process Subscriber then reads.

use std::collections::BTreeSet;
use std::sync::Arc;

use channels::{Capacity, ChannelId, Domain, FieldKind, ProcessId, Shape, Topology, WiringError};
use diagnostics::Spanned;
use maps::Zone;
use monitors::{EventAtom, MONITORS, MessageField, WORLD};
use sim::ObstacleMotion;

use super::ready_made::ReadyMadeKind;
use super::{Premises, Scenario};
use crate::faults::Trigger;
use crate::processes::SUBSCRIBER;

#[derive(Clone, Debug, PartialEq)]
struct TruthField {
    /// Its name in properties.
    name: String,
    fact: Fact,
}

/// Something that is true of the world, at the end of a step of its physics.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fact {
    /// The charge of the battery, in percent.
    Level,
    /// Whether the battery is being charged.
    Charging,
    /// The robot's x in the `map` frame, in meters.
    X,
    /// The robot's y in the `map` frame, in meters.
    Y,
    /// The robot's heading in the `map` frame, in radians, from −π to π.
    Heading,
    /// The robot's forward speed, in m/s; negative backwards.
    Speed,
    /// The robot's turning rate, in rad/s; positive counter-clockwise.
    Turning,
    /// Whether the robot touches anything.
    Touching,
    /// The distance from the robot's edge to the nearest wall or body, in meters; 0 where they touch.
    Clearance,
    /// The distance from the robot's edge to the nearest person, in meters; infinite without people.
    Person,
    /// Whether the robot's center is at this place, with any heading.
    At(String),
    /// How far this door is open, from 0 to 1.
    Open(String),
    /// The x of the center of this person or box in the `map` frame, in meters; the robot's while it carries the box.
    BodyX(String),
    /// The y of the center of this person or box in the `map` frame, in meters; the robot's while it carries the box.
    BodyY(String),
    /// Whether the robot carries this box.
    Carried(String),
}

impl Fact {
    /// The facts of every scenario with a map, with their names in properties.
    pub const OF_ROBOT: [(&str, Self); 10] = [
        ("level_pct", Self::Level),
        ("charging", Self::Charging),
        ("x_m", Self::X),
        ("y_m", Self::Y),
        ("yaw_rad", Self::Heading),
        ("speed_mps", Self::Speed),
        ("turn_radps", Self::Turning),
        ("touching", Self::Touching),
        ("clearance_m", Self::Clearance),
        ("person_m", Self::Person),
    ];

    fn kind(&self) -> FieldKind {
        match self {
            Self::Charging | Self::Touching | Self::At(_) | Self::Carried(_) => FieldKind::Bool,
            _ => FieldKind::Real,
        }
    }
}

/// The message with which the world shows monitors what is true.
#[derive(Clone, Debug, PartialEq)]
pub struct Truths {
    /// Its channel.
    pub channel: ChannelId,
    /// What its fields mean, in order.
    pub facts: Arc<[Fact]>,
}

impl Premises {
    /// All fields that the world's message can have. Places, doors, people and boxes whose names differ only in signs
    /// that a field's name cannot have are numbered from the second one.
    fn truths(&self) -> Vec<TruthField> {
        let mut fields: Vec<TruthField> = Vec::new();
        let mut add = |name: String, fact: Fact| {
            let is_new = |name: &String| fields.iter().all(|field| field.name != *name);
            let numbered = (2..).map(|number| format!("{name}_{number}"));
            let name = std::iter::once(name.clone()).chain(numbered).find(is_new).expect("numbers do not end");
            fields.push(TruthField { name, fact });
        };
        for (name, fact) in Fact::OF_ROBOT {
            add(name.to_owned(), fact);
        }
        for (place, _) in self.places.iter() {
            add(format!("at_{}", as_word(place)), Fact::At(place.to_owned()));
        }
        for body in self.entry.world.iter().map(|body| &body.value) {
            let (word, name) = (as_word(&body.name), || body.name.clone());
            if let ObstacleMotion::Door(_) = body.motion {
                add(format!("{word}_open"), Fact::Open(name()));
                continue;
            }
            add(format!("{word}_x_m"), Fact::BodyX(name()));
            add(format!("{word}_y_m"), Fact::BodyY(name()));
            if let ObstacleMotion::Movable { .. } = body.motion {
                add(format!("{word}_carried"), Fact::Carried(name()));
            }
        }
        fields
    }

    /// That a zone is respected: a sentence, and the formula. `None` if there is no such zone.
    pub(super) fn respects(&self, zone: &str) -> Option<(String, String)> {
        let Zone { keep_out, speed_mps, .. } = self.places.zones().iter().find(|known| known.name == zone)?;
        let here = self.truths().into_iter().find(|field| field.fact == Fact::At(zone.to_owned()))?.name;
        let keeps_out = keep_out.then(|| format!("{here} = false"));
        // Driving at the limit exactly, the simulated robot is faster now and then by the last bit of a number.
        let is_slow = speed_mps
            .map(|limit| limit + SLACK_MPS)
            .map(|limit| format!("({here} = true implies speed_mps <= {limit:?} and speed_mps >= -{limit:?})"));
        let rules: Vec<String> = keeps_out.into_iter().chain(is_slow).collect();
        let limit = speed_mps.map(|limit| format!("is not faster than {limit} m/s in"));
        let duties: Vec<String> = keep_out.then(|| "stays out of".to_owned()).into_iter().chain(limit).collect();
        let about = format!("The robot {} {}", duties.join(" and "), zone.escape_debug());
        Some((about, format!("always ({WORLD}, {MONITORS}, {})", rules.join(" and "))))
    }
}

/// A robot counts as slow enough in a zone up to this much more than the zone's limit. Chosen, not measured.
const SLACK_MPS: f64 = 0.001;

/// A name with which a field's name can begin or end.
fn as_word(name: &str) -> String {
    let word: String = name.chars().map(|sign| if sign.is_alphanumeric() { sign } else { '_' }).collect();
    if word.starts_with(|first: char| first.is_alphabetic() || first == '_') { word } else { format!("_{word}") }
}

impl Scenario {
    /// Declares what the system has for monitors alone, if a property, monitor or fault is about it: the topics that no
    /// other process reads, and the world's message with the fields that are mentioned. After all processes and
    /// channels of the system.
    ///
    /// # Errors
    /// [`WiringError`] if a process has one of the names.
    pub fn declare_observed(&self, topology: &mut Topology) -> Result<Option<Truths>, WiringError> {
        let mention = |what: &str| self.texts().any(|text| text.contains(what));
        let (of_topics, of_world) = (mention("*") || mention(SUBSCRIBER), mention(WORLD));
        if !of_topics && !of_world {
            return Ok(None);
        }
        let mut all = topology.clone();
        if of_topics {
            declare_unread(&mut all, |_| true)?;
        }
        let truths = if of_world { self.declare_fields(&mut all, |_| true)? } else { None };
        let mentioned = self.mentioned(&all);
        if of_topics {
            let is_read = |from: ProcessId| {
                let channel = all.find_channel(all.name(from), SUBSCRIBER);
                let is_on = |event: &EventAtom| Some(event.channel) == channel;
                mentioned.as_ref().is_none_or(|events| events.iter().any(is_on))
            };
            declare_unread(topology, is_read)?;
        }
        let Some(Truths { channel, .. }) = truths else { return Ok(None) };
        let used = mentioned.and_then(|events| fields(&events, channel));
        self.declare_fields(topology, |number| used.as_ref().is_none_or(|used| used.contains(&number)))
    }

    /// Declares everything that the system can have for monitors, whether or not anything is about it.
    ///
    /// # Errors
    /// [`WiringError`] if a process has one of the names.
    pub fn declare_observable(&self, topology: &mut Topology) -> Result<Option<Truths>, WiringError> {
        declare_unread(topology, |_| true)?;
        self.declare_fields(topology, |_| true)
    }

    /// Declares the world's message, with the fields that have these numbers.
    fn declare_fields(
        &self,
        topology: &mut Topology,
        is_used: impl Fn(usize) -> bool,
    ) -> Result<Option<Truths>, WiringError> {
        // A schedule takes the place of the world.
        let Some(premises) = self.premises.as_ref().filter(|_| self.schedule.is_none()) else { return Ok(None) };
        let fields = (1..).zip(premises.truths()).filter(|(number, _)| is_used(*number)).map(|(_, field)| field);
        let fields: Vec<TruthField> = fields.collect();
        let (world, monitors) = (topology.outside(WORLD)?, topology.outside(MONITORS)?);
        let shape = Shape::new(fields.iter().map(|field| (field.name.as_str(), field.fact.kind())));
        let channel = topology.channel(world, monitors, Capacity::Zero, Domain::new([shape]))?;
        Ok(Some(Truths { channel, facts: fields.into_iter().map(|field| field.fact).collect() }))
    }

    /// The texts in the SCOPE language.
    fn texts(&self) -> impl Iterator<Item = &str> {
        let properties = self.properties.iter().map(|(_, text)| text.as_str());
        properties.chain(self.events().map(|text| text.value.as_str()))
    }

    /// The events for which faults and monitors wait.
    fn events(&self) -> impl Iterator<Item = &Spanned<String>> {
        let faults = self.file.faults.iter().filter_map(|fault| match &fault.timing.trigger {
            Trigger::Message(when) => Some(when),
            _ => None,
        });
        let rules = self.file.monitors.iter().flat_map(|monitor| match &monitor.kind {
            ReadyMadeKind::Machine(machine) => machine.events.as_slice(),
            ReadyMadeKind::Figure(_) | ReadyMadeKind::Zone(_) => &[],
        });
        faults.chain(rules.map(|rule| &rule.when))
    }

    /// The events that are mentioned. `None` because a text is wrong, and its problems name what there is.
    fn mentioned(&self, topology: &Topology) -> Option<Vec<EventAtom>> {
        let mut mentioned = Vec::new();
        for (name, text) in &self.properties {
            let formulas = monitors::formulas(name, text, topology, self.file.execution.tick).ok()?;
            formulas.iter().for_each(|(_, formula)| formula.events(&mut |event| mentioned.push(event.clone())));
        }
        for text in self.events() {
            mentioned.extend(monitors::occurrences("event", &text.value, topology).ok()?);
        }
        Some(mentioned)
    }
}

/// The numbers of the fields that are mentioned on a channel. `None` if all are needed, because one is called by its
/// number.
fn fields(events: &[EventAtom], channel: ChannelId) -> Option<BTreeSet<usize>> {
    let mut used = BTreeSet::new();
    let mut by_number = false;
    for event in events.iter().filter(|event| event.channel == channel) {
        event.condition.fields(&mut |MessageField { number, name, .. }: &MessageField| {
            used.insert(*number);
            by_number |= name.is_none();
        });
    }
    (!used.is_empty() && !by_number).then_some(used)
}

/// Declares the process that reads the topics that nothing reads, of the processes that are meant, if they have some.
/// It takes each message as it is published, so that none takes the place of another.
fn declare_unread(topology: &mut Topology, is_meant: impl Fn(ProcessId) -> bool) -> Result<(), WiringError> {
    let unread = |process| (process, topology.unread_topics(process).cloned().collect::<Vec<_>>());
    let unread = topology.processes().map(unread).filter(|(process, topics)| !topics.is_empty() && is_meant(*process));
    let unread: Vec<_> = unread.collect();
    if unread.is_empty() {
        return Ok(());
    }
    let subscriber = topology.process(SUBSCRIBER)?;
    for (publisher, topics) in unread {
        topology.channel(publisher, subscriber, Capacity::Zero, Domain::new(topics))?;
    }
    Ok(())
}
