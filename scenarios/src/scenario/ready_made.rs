//! Ready-made monitors, which a scenario attaches in addition to those made from properties: its `[[monitors]]`.

use std::fmt;
use std::path::PathBuf;

use channels::{Topology, WiringError};
use diagnostics::document::{FromItem, Item, Key, Referent, Table};
use diagnostics::{Problem, Span, Spanned};
use monitors::{PhiTwo, Property};
use serde_json::{Value, json};
use skills::Datum;

use super::data::{datum, scalar};
use super::stop::Names;
use super::world::MAP;
use crate::files::path;

/// A ready-made monitor.
#[derive(Clone, Debug)]
pub struct ReadyMade {
    /// Its name; by default, that of the machine or the figure.
    pub name: Option<Spanned<String>>,
    /// Its kind.
    pub kind: ReadyMadeKind,
    /// Its location in the scenario.
    pub span: Span,
}

/// The kind of a ready-made monitor.
#[derive(Clone, Debug)]
pub enum ReadyMadeKind {
    /// One of the paper's.
    Figure(Figure),
    /// An SCXML machine.
    Machine(WatchingMachine),
    /// That the robot respects the zone with this name: a [property](super::Scenario::properties).
    Zone(Spanned<String>),
}

/// A monitor of the paper's Figure 5.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// (a), of the safety property φ1.
    Safety,
    /// (b), of the response property φ2.
    Response,
}

impl Figure {
    /// The default name of the monitor.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Safety => "figure_5a",
            Self::Response => "figure_5b",
        }
    }

    /// The monitor, with the thresholds of the paper and the θ of its published code.
    ///
    /// # Errors
    /// [`WiringError::MissingChannel`] if the system lacks a channel that it monitors.
    pub fn monitor(self, topology: &Topology) -> Result<Property, WiringError> {
        match self {
            Self::Safety => monitors::phi1(topology, 20),
            Self::Response => monitors::phi2(topology, PhiTwo::default()),
        }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Safety => "Figure 5 (a)",
            Self::Response => "Figure 5 (b)",
        })
    }
}

/// An SCXML machine that monitors a run.
#[derive(Clone, Debug)]
pub struct WatchingMachine {
    /// Its file.
    pub machine: Spanned<PathBuf>,
    /// The states in which the property is violated for good.
    pub violated_in: Vec<Spanned<String>>,
    /// The states in which the property is inconclusive if the run ends.
    pub pending_in: Vec<Spanned<String>>,
    /// The rules that map messages to its events.
    pub events: Vec<EventRule>,
}

/// A rule that maps messages to an event of a machine.
#[derive(Clone, Debug)]
pub struct EventRule {
    /// The event's name.
    pub event: Spanned<String>,
    /// The messages: an event in the SCOPE language, or several joined by `or`.
    pub when: Spanned<String>,
    /// The members of `_event.data`.
    pub data: Vec<(String, Content)>,
}

/// The value of a member of an event's data.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// `m[k]`, a field of the message, counted from 1.
    Field(usize),
    /// This value.
    Value(Datum),
}

impl FromItem<'_> for Content {
    fn wanted() -> String {
        "`m[1]`, `m[2]`, … for a field of the message, or a string, a number, true or false".into()
    }

    fn takes() -> Value {
        scalar()
    }

    fn from_item(item: &Item<'_>) -> Result<Self, Vec<Problem>> {
        let content = match item.as_text().and_then(|text| text.strip_prefix("m[")) {
            Some(field) => {
                let field = field.strip_suffix(']').and_then(|field| field.trim().parse().ok());
                field.filter(|field| *field > 0).map(Self::Field)
            }
            None => datum(item).map(Self::Value),
        };
        content.ok_or_else(|| vec![item.wrong(&Self::wanted())])
    }
}

impl ReadyMade {
    /// The zone that must be respected, if it is about one.
    pub(super) fn zone(&self) -> Option<&Spanned<String>> {
        if let ReadyMadeKind::Zone(zone) = &self.kind { Some(zone) } else { None }
    }

    /// Reads `[[monitors]]`.
    pub(super) fn read_all(root: Table<'_>) -> Vec<Self> {
        let about = "A monitor that is not made from a property file: an SCXML machine; with `zone`, that a zone is respected; or, \
             with `figure`, one of the paper's.";
        let forms = || {
            let of_machine =
                Key::all(WatchingMachine::read).into_iter().filter(|key| key.required && key.split().0.is_empty());
            let required: Vec<String> = of_machine.map(|key| key.path.trim_end_matches("[]").to_owned()).collect();
            json!({
                "if": { "required": ["figure"] },
                "then": { "propertyNames": { "enum": ["name", "figure"] } },
                "else": {
                    "if": { "required": ["zone"] },
                    "then": { "propertyNames": { "enum": ["name", "zone"] } },
                    "else": { "required": required },
                },
            })
        };
        root.tables("monitors").about(about).rules(forms).each(Self::read).or(Vec::new())
    }

    fn read(table: Table<'_>) -> Option<Self> {
        let name = table.text("name").about("The monitor's name. If not given, that of the machine or figure.");
        let name = name.spanned().optional();
        let (has_figure, has_zone) = (table.has("figure"), table.has("zone") && !table.has("figure"));
        table.know("figure");
        if !has_figure {
            table.know("zone");
        }
        let figure = table.form(has_figure).and_then(|table| {
            let figures = [("5 (a)", Figure::Safety), ("5 (b)", Figure::Response)];
            table.one_of("figure", &figures).about("The monitor of the paper's Figure 5 (a) or (b).").required()
        });
        let zone = table.form(has_zone).and_then(|table| {
            let zone = table.text("zone").refers_to(Referent::Zone).spanned().needs(MAP);
            zone.about(
                "A zone of the places file: the robot's center is never in an area to keep out of, and the robot is not \
                 faster than the speed of an area while its center is there.",
            )
            .required()
        });
        let machine = table.form(!has_figure && !has_zone).and_then(WatchingMachine::read);
        let kind = figure.map(ReadyMadeKind::Figure).or(zone.map(ReadyMadeKind::Zone));
        let kind = kind.or(machine.map(ReadyMadeKind::Machine));
        Some(Self { name, kind: kind?, span: table.span().clone() })
    }
}

impl WatchingMachine {
    fn read(table: Table<'_>) -> Option<Self> {
        let machine = path(table, "machine", "The SCXML file. Required without `figure`.");
        let machine = machine
            .refers_to(Referent::File(&["scxml"]))
            .required_or("`machine` names an SCXML file, `figure` a monitor of the paper");
        let violated_in = table.get::<Names>("violated_in").about(
            "The states that indicate a violation, which is final even if the machine leaves them at once. Required \
             with `machine`.",
        );
        let violated_in = violated_in.required();
        let pending_in = table.get("pending_in");
        let pending_in = pending_in.about("The states in which the verdict is inconclusive if the run ends there.");
        let Names(pending_in) = pending_in.or(Names(Vec::new()));
        let events = table.tables("events");
        let events = events.about("The messages that become events of the machine. Required with `machine`.");
        let events = events.each(EventRule::read).required();
        let Names(violated_in) = violated_in?;
        Some(Self { machine: machine?, violated_in, pending_in, events: events? })
    }
}

impl EventRule {
    fn read(table: Table<'_>) -> Option<Self> {
        let text = |key, about| table.text(key).about(about);
        let event = text("event", "The event's name.").spanned().required();
        let when = text("when", "The messages: an event of the SCOPE language, or several joined by `or`.");
        let when = when.refers_to(Referent::Event).spanned().required();
        let data = table.table("data").about("The values of `_event.data`.").optional();
        let about = "The value of `_event.data.NAME`. `m[1]`, `m[2]`, … are fields of the message.";
        let member = |data: Table<'_>, name: &str| data.get::<Content>(name).about(about).optional();
        let data = data.into_iter().flat_map(|data| {
            data.names("NAME").filter_map(move |(name, _)| Some((name.to_owned(), member(data, name)?)))
        });
        let data = data.collect();
        Some(Self { event: event?, when: when?, data })
    }
}
