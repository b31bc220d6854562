//! What the page shows about things that are clicked, as JSON.

use std::collections::BTreeMap;

use recording::{Header, Machine, Node, RunView};
use reports::html::live;
use runs::Session;
use serde_json::{Map, Value, json};

/// The places, including the start and the station; corners in meters.
pub(crate) fn places(header: &Header) -> Value {
    let Some(premises) = &header.premises else { return json!([]) };
    let place = |name: &str, corners: Vec<[f64; 2]>| json!({ "name": name, "corners": corners });
    let named = premises.places.iter().map(|known| {
        let corners = known.corners.iter().map(|corner| [corner.x, corner.y]).collect();
        place(&known.name, corners)
    });
    let sites = [("start", Some(premises.start)), ("charging station", premises.station)];
    let sites = sites.into_iter().filter_map(|(name, at)| Some(place(name, vec![at?.translation.vector.into()])));
    named.chain(sites).collect()
}

/// The machines: their processes, their pictures, and facts about their states.
pub(crate) fn machines(header: &Header) -> Value {
    let machine = |machine: &Machine| {
        let states = machine
            .states
            .iter()
            .map(|state| json!({ "name": state.name, "parent": state.parent, "transitions": state.transitions }));
        json!({
            "process": machine.process, "svg": live::machine(machine), "states": states.collect::<Vec<_>>(),
        })
    };
    header.machines.iter().map(machine).collect()
}

pub(crate) fn nodes(header: &Header) -> Value {
    let kind = |node: &Node| match (&node.symbol, node.is_leaf) {
        (_, true) => "leaf",
        (Some(symbol), false) => live::meaning(symbol).unwrap_or_default(),
        (None, false) => "",
    };
    let node = |node: &Node| json!({ "name": node.process, "kind": kind(node), "parent": node.parent });
    header.tree.iter().map(node).collect()
}

/// The last outcome of each node of the tree, in words.
pub(crate) fn outcomes(view: &RunView) -> Value {
    let nothing = if view.header().knows_ticks() { "not ticked yet" } else { "no change yet" };
    view.outcomes().iter().map(|outcome| outcome.map_or(nothing, |outcome| outcome.name())).collect()
}

/// The lasting acts: the page's names for them, what they are, and the names of the bodies that they put on the floor.
pub(crate) fn lasting(session: &Session, acts: &BTreeMap<String, usize>) -> Value {
    let lasting = session.lasting().map(|(index, act)| {
        let name = acts.iter().find(|(_, known)| **known == index).map(|(name, _)| name);
        let record = act.record();
        let arguments = record.arguments.into_iter().map(|(key, value)| (key, value.to_json()));
        let fault: Map<String, Value> = arguments.chain([("kind".to_owned(), record.kind.into())]).collect();
        json!({ "name": name, "words": record.words, "fault": fault, "bodies": act.bodies() })
    });
    lasting.collect()
}
