//! Finds the parts of a file to which a mutation refers.

use std::ops::Range;

use diagnostics::{Problem, nearest_or_all, xml};
use roxmltree::Document;

use super::{SendPlace, TransitionPlace};
use crate::chart::{Chart, Transition};
use crate::ids::{StateId, TransitionId};
use crate::load::{AS_READ, Element, Written, name_span, own_elements};

/// A machine and its elements.
pub(super) struct Site<'a> {
    pub(super) chart: &'a Chart,
    elements: Vec<Element<'a>>,
}

/// A `<send>` with a literal `event`.
#[derive(Clone)]
pub(super) struct WrittenSend<'a> {
    pub(super) node: Element<'a>,
    pub(super) state: StateId,
    pub(super) event: Written<'a>,
}

impl<'a> Site<'a> {
    pub(super) fn new(chart: &'a Chart, document: &'a Document<'a>) -> Self {
        Self { chart, elements: own_elements(Element::new(document.root_element(), AS_READ)) }
    }

    fn element(&self, name: &Range<usize>) -> Option<Element<'a>> {
        self.elements.iter().copied().find(|node| name_span(*node) == *name)
    }

    pub(super) fn node(&self, transition: &Transition) -> Element<'a> {
        self.element(&transition.span()).expect("the chart was made from this document")
    }

    pub(super) fn state(&self, id: &str) -> Result<StateId, Problem> {
        self.chart.find_state(id).ok_or_else(|| {
            let known: Vec<&str> = self.chart.states().map(|state| self.chart.state(state).id()).collect();
            Problem::new(format!("unknown state `{id}`")).with_help(nearest_or_all(id, "states", &known))
        })
    }

    pub(super) fn transition(&self, place: &TransitionPlace) -> Result<&'a Transition, Problem> {
        let state = self.chart.state(self.state(&place.state)?);
        let all = || state.transitions().iter().map(|id: &TransitionId| self.chart.transition(*id));
        let found: Vec<&Transition> = all().filter(|transition| reacts(transition, &place.event)).collect();
        let nth = place.nth.checked_sub(1).and_then(|index| found.get(index).copied());
        nth.ok_or_else(|| {
            let events: Vec<String> = all().map(events_of).collect();
            let events: Vec<&str> = events.iter().map(String::as_str).collect();
            missing(place, found.len(), "transition", nearest_or_all(&place.event, "its transitions take", &events))
                .at(state.span(), "in here")
        })
    }

    pub(super) fn send(&self, place: &SendPlace) -> Result<WrittenSend<'a>, Problem> {
        let id = self.state(&place.state)?;
        let all: Vec<WrittenSend<'_>> = self.sends().filter(|send| send.state == id).collect();
        let found: Vec<&WrittenSend<'_>> = all.iter().filter(|send| send.event.value == place.event).collect();
        let nth = place.nth.checked_sub(1).and_then(|index| found.get(index).copied().cloned());
        nth.ok_or_else(|| {
            let events: Vec<&str> = all.iter().map(|send| send.event.value).collect();
            missing(place, found.len(), "<send>", nearest_or_all(&place.event, "it sends", &events))
                .at(self.chart.state(id).span(), "in here")
        })
    }

    /// All `<send>`s with a literal event, in the order of the file.
    pub(super) fn sends(&self) -> impl Iterator<Item = WrittenSend<'a>> {
        let sends = self.elements.iter().filter(|node| node.tag_name().name() == "send");
        sends.filter_map(|node| {
            let event = Written::attribute(*node, "event")?;
            let mut around = node.ancestors().map(xml::name_span);
            let state =
                around.find_map(|span| self.chart.states().find(|state| self.chart.state(*state).span() == span))?;
            Some(WrittenSend { node: *node, state, event })
        })
    }

    /// All `<data>`, in the order of the file.
    pub(super) fn data(&self) -> impl Iterator<Item = (Element<'a>, Written<'a>)> {
        let data = self.elements.iter().filter(|node| node.tag_name().name() == "data");
        data.filter_map(|node| Some((*node, Written::attribute(*node, "id")?)))
    }
}

/// The events of a transition, as used to address it.
pub(super) fn events_of(transition: &Transition) -> String {
    transition.events().collect::<Vec<_>>().join(" ")
}

/// Whether the `event` of a place matches the transition.
pub(super) fn reacts(transition: &Transition, event: &str) -> bool {
    let event = event.split_whitespace().collect::<Vec<_>>().join(" ");
    events_of(transition) == event || transition.events().any(|word| word == event)
}

fn missing(place: &impl ToString, found: usize, what: &str, help: String) -> Problem {
    let help = match found {
        0 => help,
        1 => format!("there is only 1 such {what}"),
        more => format!("there are {more} such {what}s, counted from 1"),
    };
    Problem::new(format!("{} does not exist", place.to_string())).with_help(help)
}
