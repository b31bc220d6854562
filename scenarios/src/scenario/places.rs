//! Checks the places that a scenario names: they must exist, and the robot must be able to reach them.
//!
//! Only the map counts: people, doors, boxes and faults may be in the way, which is often the point of a scenario.

use std::sync::Arc;

use diagnostics::{Problem, Span, Spanned};
use maps::{OccupancyGrid, Place, Places, Point, Pose, Zone};
use nav::{Goal, PlanError, Reach};
use sim::DockingConfig;

use super::{Premises, PremisesEntry, Scenario, ScenarioFile, Sites, Start};
use crate::error::Complaints;
use crate::faults::{Effect, Fault};
use crate::names::unknown;

/// The poses of the start and of the station, if there is one. Every place that the scenario names must exist.
pub(super) fn check_places(
    file: &ScenarioFile,
    PremisesEntry { sites, .. }: &PremisesEntry,
    places: &Places,
    complaints: &mut Complaints,
) -> Option<(Pose, Option<Pose>)> {
    // All names are looked up, also those whose poses are not needed here: every unknown one is reported.
    let expect = &file.expect;
    let named = expect.reached.iter().chain(&expect.not_reached).chain(&file.stop.at).chain(&sites.destination);
    for name in named {
        let _ = place(name, places, complaints);
    }
    for name in &expect.not_reached {
        if expect.reached.iter().any(|reached| reached.value == name.value) {
            let problem = name.span.problem(format!(
                "the robot is expected both to come to rest at `{}` and never to be there",
                name.value
            ));
            complaints.push(problem.with_label("this place").with_help("no run can satisfy this"));
        }
    }
    check_zone_faults(&file.faults, places, complaints);
    let start = match &sites.start {
        Spanned { value: Start::Named(name), span } => {
            point(&Spanned { value: name.clone(), span: span.clone() }, places, complaints)
        }
        Spanned { value: Start::At(pose), .. } => Some(*pose),
    };
    let Some(name) = &sites.station else {
        check_station_faults(&file.faults, complaints);
        return Some((start?, None));
    };
    let station = point(name, places, complaints);
    Some((start?, Some(station?)))
}

/// Checks for faults that affect a missing station.
fn check_station_faults(faults: &[Arc<Fault>], complaints: &mut Complaints) {
    for fault in faults.iter().filter(|fault| ["station_dead", "station_slow"].contains(&fault.kind().name)) {
        let problem = fault.arguments().span().problem("there is no charging station");
        let help = "set the charging station with `sites.station`";
        complaints.push(problem.with_label("a fault of the charging station").with_help(help));
    }
}

/// Checks for faults that affect a missing zone.
fn check_zone_faults(faults: &[Arc<Fault>], places: &Places, complaints: &mut Complaints) {
    let names = || places.zones().iter().map(|zone| zone.name.as_str());
    for fault in faults {
        match &fault.effect() {
            Effect::Zones(Some(zone)) if !names().any(|name| name == zone.value) => {
                complaints.push(unknown("zone", zone, names()));
            }
            Effect::Zones(None) if places.zones().is_empty() => {
                let problem = fault.arguments().span().problem("there are no zones");
                let help = "an area of the places file with `keep_out` or `speed_mps` is a zone";
                complaints.push(problem.with_label("a fault of navigation in zones").with_help(help));
            }
            _ => {}
        }
    }
}

fn place<'p>(name: &Spanned<String>, places: &'p Places, complaints: &mut Complaints) -> Option<&'p Place> {
    let place = places.get(&name.value);
    if place.is_none() {
        let names = places.iter().map(|(name, _)| name);
        complaints.push(unknown("place", name, names));
    }
    place
}

fn point(name: &Spanned<String>, places: &Places, complaints: &mut Complaints) -> Option<Pose> {
    match place(name, places, complaints)? {
        Place::Point { pose, .. } => Some(*pose),
        Place::Area { .. } => {
            let problem = name.span.problem(format!("`{}` is an area, but a point is required", name.value));
            complaints.push(problem.with_label("this place").with_help("a point has a position and a heading"));
            None
        }
    }
}

/// Checks that the robot can drive away from its start and to every place that it must reach.
pub(super) fn check_reach(file: &ScenarioFile, premises: &Premises, complaints: &mut Complaints) {
    let Premises { entry: PremisesEntry { sites, .. }, map, written: places, reach, driven_to, start, .. } = premises;
    let start = Point::from(start.translation.vector);
    let at_start = match &sites.start.value {
        Start::Named(name) => places.span(name),
        Start::At(_) => None,
    };
    let at_start = at_start.unwrap_or(&sites.start.span);
    if let Some(zone) = premises.kept_out(&start) {
        let problem = at_start.problem(in_zone("the start", &start, zone));
        return complaints.push(problem.with_label("the start"));
    }
    let mut seen: Vec<&str> = Vec::new();
    let skills = driven_to.iter().map(|(name, skill)| (name, format!("the skill {skill} drives there")));
    for (name, why) in needed(file, sites).chain(skills) {
        let place = places.places().get(name).zip(places.span(name)).filter(|_| !seen.contains(&name.as_str()));
        let Some((place, span)) = place else { continue };
        seen.push(name);
        let goal = Goal::to(place);
        let Err(error) = reach.check(&start, &goal) else { continue };
        // From such a start, no place can be reached: reporting each of them would hide the reason.
        if matches!(error, PlanError::StartOutside | PlanError::StartInObstacle) {
            let problem = at_start.problem(bad_start(&start, error));
            let help = format!("the whole body of the robot must be on free floor at the start; {}", extent(map));
            return complaints.push(problem.with_label("the start").with_help(help));
        }
        let problem = unreachable(span, name, &goal, error, premises);
        let help = format!("{}; {why}", instead(map, reach, &start, &goal));
        complaints.push(problem.with_help(help));
    }
}

/// The places that the scenario itself requires the robot to reach, with the reasons.
fn needed<'f>(file: &'f ScenarioFile, sites: &'f Sites) -> impl Iterator<Item = (&'f String, String)> {
    let station = sites.station.iter().map(|name| (name, "sites.station"));
    let destination = sites.destination.iter().map(|name| (name, "sites.destination"));
    let stops = file.stop.at.iter().map(|name| (name, "stop.at"));
    let reached = file.expect.reached.iter().map(|name| (name, "expect.reached"));
    let needed = station.chain(destination).chain(stops).chain(reached);
    needed.map(|(name, key)| (&name.value, format!("the scenario requires it as `{key}`")))
}

fn bad_start(start: &Point, error: PlanError) -> String {
    let at = position(start);
    match error {
        PlanError::StartOutside => format!("the start {at} is outside the map"),
        _ => {
            format!("the robot cannot drive away from the start {at}: it is in a wall, or has no free floor around it")
        }
    }
}

impl Premises {
    /// An area to keep out of in which the robot's body would be, or in a cell of the map beside it.
    fn kept_out(&self, at: &Point) -> Option<&Zone> {
        let reach_m = self.entry.sim.model.radius_m + self.map.resolution_m();
        self.places.zones().iter().find(|zone| zone.keep_out && zone.distance_m(at) < reach_m)
    }
}

fn in_zone(what: &str, at: &Point, zone: &Zone) -> String {
    format!("at {what} {}, the robot would be in `{}`, which it must keep out of", position(at), zone.name)
}

fn unreachable(span: &Span, name: &str, goal: &Goal, error: PlanError, premises: &Premises) -> Problem {
    let at = position(&goal.position);
    let message = match error {
        _ if let Some(zone) = premises.kept_out(&goal.position) => in_zone(&format!("`{name}`"), &goal.position, zone),
        PlanError::GoalOutside => format!("`{name}` is outside the map, at {at}"),
        PlanError::NoPath => {
            let start = position(&premises.start.translation.vector.into());
            let is_closed = premises.places.zones().iter().any(|zone| zone.keep_out);
            let around = if is_closed { " around the areas to keep out of" } else { "" };
            format!("there is no path{around} from the start {start} to `{name}` at {at}")
        }
        _ if goal.area.is_some() => format!("there is no room for the robot in `{name}`, around {at}"),
        PlanError::GoalUnknown => format!("the robot cannot stand at `{name}`: the map is unknown at {at}"),
        PlanError::GoalInObstacle { clearance_m: 0.0, .. } => {
            format!("the robot cannot stand at `{name}`: {at} is in a wall")
        }
        PlanError::GoalInObstacle { clearance_m, needed_m } => format!(
            "the robot cannot stand at `{name}`: {at} is {clearance_m:.3} m from a wall, but it needs {needed_m:.3} m"
        ),
        error => format!("`{name}` at {at}: {error}"),
    };
    span.problem(message).with_label("this place")
}

fn instead(map: &OccupancyGrid, reach: &Reach, start: &Point, goal: &Goal) -> String {
    match reach.instead(start, goal) {
        Some(point) => format!("the nearest reachable place is {}", position(&point)),
        None => extent(map),
    }
}

fn extent(map: &OccupancyGrid) -> String {
    let (width, height) = (map.width() as f64, map.height() as f64);
    let corners = [(0.0, 0.0), (width, 0.0), (0.0, height), (width, height)];
    let corners = corners.map(|(x, y)| map.from_grid(&Point::new(x, y)));
    let (mut least, mut most) = (corners[0], corners[0]);
    for corner in corners {
        (least, most) = (least.inf(&corner), most.sup(&corner));
    }
    format!("the map extends from {} to {}", position(&least), position(&most))
}

/// A position for messages, in meters.
fn position(at: &Point) -> String {
    format!("({:.2}, {:.2})", at.x, at.y)
}

impl Scenario {
    /// Warnings about the map, which other programs may read differently, and about the places: unreachable ones, and a
    /// station whose tolerances are wider than those of docking.
    pub(super) fn place_concerns(&self) -> Vec<Problem> {
        let Some(premises) = &self.premises else { return Vec::new() };
        let Premises { entry, map, places, written, reach, start, map_concerns, .. } = premises;
        let start = Point::from(start.translation.vector);
        let mut concerns = map_concerns.clone();
        for (name, place) in places.iter() {
            let Some(span) = written.span(name) else { continue };
            let goal = Goal::to(place);
            let is_kept_out = places.zones().iter().any(|zone| zone.keep_out && zone.name == name);
            if let Err(error) = reach.check(&start, &goal)
                && !is_kept_out
            {
                let help = instead(map, reach, &start, &goal);
                let problem = unreachable(span, name, &goal, error, premises);
                concerns.push(problem.with_help(help).as_warning());
            }
            let is_station = entry.sites.station.as_ref().is_some_and(|station| station.value == name);
            concerns.extend(wide_tolerances(span, name, place, &entry.sim.docking).filter(|_| is_station));
        }
        concerns
    }
}

/// The robot may be reported at the station without being docked.
fn wide_tolerances(span: &Span, name: &str, place: &Place, docking: &DockingConfig) -> Option<Problem> {
    let Place::Point { position_tolerance_m, heading_tolerance_rad, .. } = place else { return None };
    if *position_tolerance_m <= docking.distance_m && *heading_tolerance_rad <= docking.angle_rad {
        return None;
    }
    let message = format!(
        "the robot counts as at `{name}` within {position_tolerance_m} m and {:.0}°, but docks only within {} m and {:.0}°",
        heading_tolerance_rad.to_degrees(),
        docking.distance_m,
        docking.angle_rad.to_degrees()
    );
    let problem = span.problem(message).with_label("this place").as_warning();
    Some(problem.with_help("a robot within these tolerances may be undocked and never charge: make them smaller"))
}
