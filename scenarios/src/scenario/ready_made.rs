//! Ready-made monitors, which a scenario attaches in addition to those made from properties: its `[[monitors]]`.

use std::fmt;
use std::path::PathBuf;

use channels::{Topology, WiringError};
use diagnostics::document::{FromItem, Item, Table};
use diagnostics::{Problem, Span, Spanned};
use monitors::{PhiTwo, Property};
use skills::Datum;

use super::leaves::datum;
use super::stop::Names;
use crate::files::named;

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
    pub(super) fn read(table: Table<'_>) -> Option<Self> {
        let name = table.text("name").spanned().optional();
        let kind = if table.has("figure") {
            let figures = [("5 (a)", Figure::Safety), ("5 (b)", Figure::Response)];
            table.one_of("figure", &figures).required().map(ReadyMadeKind::Figure)
        } else {
            table.know("figure");
            WatchingMachine::read(table).map(ReadyMadeKind::Machine)
        };
        Some(Self { name, kind: kind?, span: table.span().clone() })
    }
}

impl WatchingMachine {
    fn read(table: Table<'_>) -> Option<Self> {
        let machine = table.text("machine").try_map(|path, span| Ok(named(path, span))).spanned();
        let machine = machine.required_or("`machine` names an SCXML file, `figure` a monitor of the paper");
        let violated_in = table.get::<Names>("violated_in").required();
        let Names(pending_in) = table.get("pending_in").or(Names(Vec::new()));
        let events = table.tables("events").each(EventRule::read).required();
        let Names(violated_in) = violated_in?;
        Some(Self { machine: machine?, violated_in, pending_in, events: events? })
    }
}

impl EventRule {
    fn read(table: Table<'_>) -> Option<Self> {
        let (event, when) = (table.text("event").spanned().required(), table.text("when").spanned().required());
        let data = table.table("data").optional().map_or_else(Vec::new, |data| {
            let members = data.keys().map(|(name, _)| (name.to_owned(), data.get::<Content>(name).required()));
            members.filter_map(|(name, content)| Some((name, content?))).collect()
        });
        Some(Self { event: event?, when: when?, data })
    }
}
