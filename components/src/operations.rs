//! The messages on the components' channels: requests and answers.

use channels::{FieldKind, Role, Shape, Symbol};
use maps::Places;

/// The name of the process that reads the battery.
pub const BATTERY_READER: &str = "BatteryReader";
/// The name of the process that determines where the robot is.
pub const LOCALIZATION: &str = "Localization";
/// The name of the process that drives the robot to places.
pub const NAVIGATION: &str = "Navigation";
/// The name of the process that lets one skill navigate at a time, in systems that use it.
pub const BLACKBOARD: &str = "Blackboard";

/// A request that a component understands, with its replies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Operation {
    /// The component.
    pub component: &'static str,
    /// `m[1]` of the request.
    pub name: &'static str,
    /// The request.
    pub request: Shape,
    /// The possible replies.
    pub replies: Vec<Shape>,
}

/// All requests that the components understand, for these places.
#[must_use]
pub fn operations(places: &Places) -> Vec<Operation> {
    let places: Vec<Symbol> = places.iter().map(|(name, _)| Symbol::new(name)).collect();
    let simple = |name| Shape::new([("request", FieldKind::symbols([name]))]);
    let at_place =
        |name| Shape::new([("request", FieldKind::symbols([name])), ("place", FieldKind::Symbol(places.clone()))]);
    let reply = |fields: [(&str, FieldKind); 2]| Shape::new(fields).with_role(Role::Reply);
    let ok = |field, kind| reply([("status", FieldKind::symbols(["ok"])), (field, kind)]);
    let error = || reply([("status", FieldKind::symbols(["error"])), ("reason", FieldKind::Text)]);
    let on_board = |name| {
        [
            ("request", FieldKind::symbols([name])),
            ("skill", FieldKind::Text),
            ("key", FieldKind::symbols(["navigation"])),
        ]
    };
    let write = |[request, skill, key]: [_; 3]| Shape::new([request, skill, key, ("value", FieldKind::Int)]);
    let done = || ok("done", FieldKind::Bool);
    let state = || FieldKind::symbols(["running", "success", "failure", "stopped", "idle"]);

    let operation =
        |component, name, request, reply| Operation { component, name, request, replies: vec![reply, error()] };
    vec![
        operation(BATTERY_READER, "get_level", simple("get_level"), ok("level", FieldKind::Real)),
        operation(BATTERY_READER, "get_charging", simple("get_charging"), ok("charging", FieldKind::Bool)),
        operation(LOCALIZATION, "is_at", at_place("is_at"), ok("at", FieldKind::Bool)),
        operation(NAVIGATION, "start_navigation", at_place("start_navigation"), ok("state", state())),
        operation(NAVIGATION, "get_status", at_place("get_status"), ok("state", state())),
        operation(NAVIGATION, "stop_navigation", at_place("stop_navigation"), ok("state", state())),
        operation(BLACKBOARD, "lock", Shape::new(on_board("lock")), done()),
        operation(BLACKBOARD, "unlock", Shape::new(on_board("unlock")), done()),
        operation(BLACKBOARD, "read_data", Shape::new(on_board("read_data")), ok("value", FieldKind::Int)),
        operation(BLACKBOARD, "write_data", write(on_board("write_data")), done()),
    ]
}
