//! What the page gets, as JSON: a greeting with what does not change, then one frame after another.

use diagnostics::seconds;
use std::collections::BTreeSet;
use std::time::Duration;

use channels::{Event, EventKind, Topology, Verdict};
use maps::{Point, Pose, Shape, heading};
use recording::{Body, Happening, RunView, Scene};
use reports::html::live;
use reports::timeline::Timeline;
use scenarios::faults::{ArgumentDefault, ArgumentDomain, FaultKind, KINDS};
use scenarios::scenario::Scenario;
use serde_json::{Value, json};

use crate::moment::Moment;
use crate::{suggestions, things};

/// More particles than this do not improve the picture.
const MAX_PARTICLES: usize = 200;
/// How many of the latest happenings are shown.
pub(crate) const HAPPENINGS: usize = 400;

/// What does not change in a run. `file` is the recording that it comes from, or `scenario` what a session plays.
pub(crate) fn greeting(view: &RunView, file: Option<&str>, scenario: Option<&Scenario>) -> Value {
    let header = view.header();
    let can_act = |kind: &FaultKind| {
        let devices = scenario.and_then(|scenario| scenario.devices_for(kind));
        kind.can_begin_later() && devices.is_none_or(|devices| !devices.is_empty())
    };
    let kinds = KINDS.iter().filter(|kind| can_act(kind));
    let floor = live::floor(view).map(|floor| json!({ "svg": floor.svg, "size": floor.size, "origin": floor.origin }));
    json!({
        "greeting": {
            "scenario": header.scenario,
            "file": file,
            "about": header.about,
            "seed": header.seed,
            "ticks": header.knows_ticks(),
            "paced": scenario.is_some() && header.has_partners(),
            "tick_s": seconds(header.tick),
            "floor": floor,
            "places": things::places(header),
            "machines": things::machines(header),
            "nodes": things::nodes(header),
            "robot_radius_m": header.robot.as_ref().map(|robot| robot.radius_m),
            "processes": header.skills.iter().chain(&header.components).collect::<Vec<_>>(),
            "kinds": kinds.map(|kind| fault_kind(kind, view, scenario)).collect::<Vec<_>>(),
        }
    })
}

/// A kind of fault, with the fields of its form.
fn fault_kind(kind: &FaultKind, view: &RunView, scenario: Option<&Scenario>) -> Value {
    let parameters = kind.parameters.iter().map(|parameter| {
        let (takes, range) = input(&parameter.domain);
        let required = parameter.default == ArgumentDefault::Required;
        json!({
            "name": parameter.name, "about": parameter.about, "takes": takes, "range": range,
            "default": default(&parameter.default), "required": required,
            "names": suggestions::names(kind, parameter, view, scenario),
            "places": suggestions::places(parameter, view),
        })
    });
    json!({
        "name": kind.name, "place": kind.subsystem.name(), "about": kind.about, "momentary": kind.is_momentary(),
        "parameters": parameters.collect::<Vec<_>>(), "example": suggestions::entries(kind, view, scenario),
    })
}

/// The form's input for a parameter, with its range or its choices.
fn input(domain: &ArgumentDomain) -> (&'static str, Value) {
    match domain {
        ArgumentDomain::Numbers(least, most) => ("number", json!([least, most])),
        ArgumentDomain::Whole(least, most) => ("whole", json!([least, most])),
        ArgumentDomain::Text | ArgumentDomain::Name(_) => ("text", Value::Null),
        ArgumentDomain::OneOf(names) => ("choice", json!(names)),
        ArgumentDomain::Flag => ("flag", Value::Null),
        ArgumentDomain::Point => ("point", Value::Null),
        ArgumentDomain::Pose => ("pose", Value::Null),
        ArgumentDomain::Points => ("points", Value::Null),
    }
}

fn default(default: &ArgumentDefault) -> Value {
    match default {
        ArgumentDefault::Required | ArgumentDefault::Absent => Value::Null,
        ArgumentDefault::Number(number) => json!(number),
        ArgumentDefault::Whole(number) => json!(number),
        ArgumentDefault::Text(text) => json!(text),
        ArgumentDefault::Flag(flag) => json!(flag),
    }
}

/// Something that happened.
pub(crate) struct Happened {
    pub(crate) time: Duration,
    kind: &'static str,
    words: String,
    /// Where the robot was.
    place: Option<Pose>,
}

impl Happened {
    /// A happening of the last step, if it is shown to people.
    pub(crate) fn of(happening: &Happening, view: &RunView) -> Option<Self> {
        let (kind, words) = (kind(happening)?, happening.words(view));
        Some(Self { time: view.time(), kind, words, place: view.robot().pose() })
    }

    fn value(&self) -> Value {
        let place = self.place.as_ref().map(pose);
        json!({ "at": seconds(self.time), "kind": self.kind, "words": self.words, "place": place })
    }
}

/// What has happened since the last frame.
#[derive(Default)]
pub(crate) struct Update {
    messages: Vec<Value>,
    happenings: Vec<Value>,
    /// Whether this replaces what the page has, instead of adding to it.
    anew: bool,
    /// Whether tree, blackboards, skills, components or monitors may have changed.
    stirred: bool,
    /// Whether a monitor has given its verdict.
    pub(crate) decided: bool,
}

impl Update {
    /// Everything that the page shows of a moment.
    pub(crate) fn anew(moment: &Moment, happened: &[Happened]) -> Self {
        let topology = moment.view.topology();
        let latest = &happened[happened.len().saturating_sub(HAPPENINGS)..];
        Self {
            messages: moment.messages.iter().filter_map(|event| message(event, topology)).collect(),
            happenings: latest.iter().map(Happened::value).collect(),
            anew: true,
            stirred: true,
            decided: true,
        }
    }

    /// Has tree, skills, components and monitors drawn again.
    pub(crate) fn stir(&mut self) {
        self.stirred = true;
    }

    /// Adds the last step.
    pub(crate) fn note(&mut self, view: &RunView) {
        self.stirred |= view.has_new_states();
        self.messages.extend(view.events().iter().filter_map(|event| message(event, view.topology())));
        for happening in view.happenings() {
            self.decided |= matches!(happening, Happening::Verdict { .. });
            self.happenings.extend(Happened::of(happening, view).map(|happened| happened.value()));
        }
    }
}

/// A message that a process received: step, tick, sender, receiver, and content.
fn message(event: &Event, topology: &Topology) -> Option<Value> {
    let EventKind::Received { channel, message } = &event.kind else { return None };
    if event.is_shown(topology) {
        return None;
    }
    let (from, to) = topology.ends(*channel);
    Some(json!([event.step, event.tick, from, to, message.to_string()]))
}

/// The kind of happening; none for what the page does not show.
fn kind(happening: &Happening) -> Option<&'static str> {
    Some(match happening {
        Happening::FaultAdded(_) | Happening::Resumed(_) => return None,
        Happening::FaultBegan { .. } => "fault",
        Happening::FaultEnded { .. } => "end",
        Happening::FaultLeftUndone { .. } => "undone",
        Happening::TreeError { .. } | Happening::GivenUp { .. } => "error",
        Happening::Verdict { decision, .. } if decision.verdict == Verdict::False => "violated",
        Happening::Verdict { .. } => "satisfied",
        Happening::Said { .. } => "said",
        Happening::Moved { .. } | Happening::Lost(_) => "environment",
        Happening::Arrival { .. } => "arrival",
    })
}

/// The state of the run: small, and part of every frame. `opened` are nodes of the tree, as in [`live::tree`].
pub(crate) fn state(view: &RunView, opened: &BTreeSet<usize>, update: Update) -> Value {
    let robot = view.robot();
    let truth = robot.truth.map(|truth| pose(&truth.pose));
    let battery = robot.battery.map(|battery| json!({ "pct": battery.charge_pct, "charging": battery.charging }));
    let mut state = json!({
        "time": seconds(view.time()),
        "ticks": view.ticks(),
        "pose": truth.or_else(|| robot.estimate.as_ref().map(pose)),
        "estimate": robot.estimate.as_ref().map(pose),
        "battery": battery,
        "scene": scene(view, view.scene()),
        "messages": update.messages,
        "happenings": update.happenings,
        "end": view.end().map(|end| json!({ "words": end.ended.to_string(), "trace_hash": end.trace_hash })),
    });
    if update.anew {
        state["anew"] = true.into();
    }
    // In most frames only the scene has changed, and the tree need not be drawn again.
    if update.stirred {
        state["doing"] = view.doing().into();
        state["navigation"] = view.navigation().map(recording::Navigation::words).into();
        let header = view.header();
        let names = header.skills.iter().chain(&header.components);
        state["locations"] = names.map(|name| (name.clone(), json!(view.location(name)))).collect();
        state["tree"] = live::tree(view, opened).into();
        state["outcomes"] = things::outcomes(view);
        let entries = view.entries().map(|(board, key, value)| (format!("{board}/{key}"), json!(value.to_string())));
        state["entries"] = entries.collect();
        state["running"] = view.running().collect();
    }
    state
}

/// The parts that take longer to draw.
pub(crate) fn parts(view: &RunView, timeline: &Timeline) -> Value {
    let stages = timeline.trail().stages(timeline.end());
    let trail = stages.iter().flat_map(|stage| stage.points.iter().map(|(_, point)| point));
    json!({
        "trail": flat(trail),
        "verdicts": live::verdicts(view, timeline),
        "stories": live::stories(view, timeline),
        "course": live::course(view, timeline),
    })
}

fn scene(view: &RunView, seen: &Scene) -> Value {
    let hits = || {
        let (robot, at) = (view.header().robot.as_ref()?, view.seen_from()?);
        Some(seen.scans.iter().flat_map(|scan| scan.hits(&robot.lasers[scan.laser], &at)).collect::<Vec<Point>>())
    };
    let gap = seen.particles.len().div_ceil(MAX_PARTICLES).max(1);
    json!({
        "hits": flat(hits().unwrap_or_default().iter()),
        "particles": flat(seen.particles.iter().step_by(gap)),
        "path": flat(seen.path.iter()),
        "bodies": seen.bodies.iter().map(body).collect::<Vec<_>>(),
        "speeches": seen.speeches,
    })
}

fn body(body: &Body) -> Value {
    let at = pose(&body.pose);
    match body.shape {
        Shape::Disc { radius_m } => json!({ "name": body.name, "at": at, "radius_m": radius_m }),
        Shape::Box { length_m, width_m } => json!({ "name": body.name, "at": at, "size_m": [length_m, width_m] }),
    }
}

/// x, y in meters and heading in radians.
fn pose(pose: &Pose) -> Value {
    json!([rounded(pose.translation.x), rounded(pose.translation.y), rounded(heading(pose))])
}

/// The coordinates of points one after the other, in meters.
fn flat<'p>(points: impl Iterator<Item = &'p Point>) -> Vec<f64> {
    points.flat_map(|point| [rounded(point.x), rounded(point.y)]).collect()
}

/// Rounds to millimeters: more cannot be seen.
fn rounded(number: f64) -> f64 {
    (number * 1000.0).round() / 1000.0
}
