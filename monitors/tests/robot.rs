//! The robot's channels that the paper's properties mention, with their domains.

use std::sync::Arc;

use channels::{Capacity, Domain, FieldKind, Shape, Topology};

/// The processes and channels that φ1, φ2 and its variant mention, and the ticks.
pub(crate) fn topology() -> Arc<Topology> {
    let mut topology = Topology::default();
    let status = |names: &[&str]| FieldKind::Symbol(names.iter().map(|name| channels::Symbol::new(name)).collect());
    let error = || Shape::new([("status", status(&["error"])), ("reason", FieldKind::Text)]);
    let places = || status(&["RechargingStation", "Destination"]);
    let navigation = || {
        let requests = status(&["start_navigation", "get_status", "stop_navigation"]);
        Domain::new([Shape::new([("request", requests), ("place", places())])])
    };
    let reply = || {
        let states = status(&["running", "success", "failure", "stopped", "idle"]);
        Domain::new([Shape::new([("status", status(&["ok"])), ("state", states)]), error()])
    };
    let answer = |name, kind| Domain::new([Shape::new([("status", status(&["ok"])), (name, kind)]), error()]);
    let channels = [
        ("TickGenerator", "BT", Domain::new([Shape::new([("tick", status(&["tick"])), ("number", FieldKind::Int)])])),
        ("BatteryReader", "BatteryLevel", answer("level", FieldKind::Real)),
        ("BatteryLevel", "BatteryReader", Domain::new([Shape::new([("request", status(&["get_level"]))])])),
        ("Localization", "AtRechargingStation", answer("there", FieldKind::Bool)),
        ("Navigation", "GoToDestination", reply()),
        ("GoToDestination", "Navigation", navigation()),
        ("Navigation", "GotoRechargingStation", reply()),
        ("GotoRechargingStation", "Navigation", navigation()),
    ];
    for (source, target, domain) in channels {
        let ends = [source, target]
            .map(|name| topology.find_process(name).unwrap_or_else(|| topology.process(name).expect("a new process")));
        topology.channel(ends[0], ends[1], Capacity::One, domain).expect("a new channel");
    }
    Arc::new(topology)
}
