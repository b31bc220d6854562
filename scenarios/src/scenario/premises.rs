//! The premises of a scenario: the map on which its robot drives. A scenario without a map has no robot; tree, skills
//! and components run alone.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::path::PathBuf;
use std::sync::Arc;

use diagnostics::document::{FromItem, Item, Key, Referent, Table};
use diagnostics::{Memo, Problem, Same, Span, Spanned};
use maps::{OccupancyGrid, Places, PlacesFile, Pose, pose};
use nav::{Atlas, LocalizationParameters, Reach};
use robot::RobotModel;
use serde_json::{Value, json};
use sim::{Building, SimConfig};

use super::world::{self, MAP, WorldBody};
use crate::coordinates::POSE;
use crate::faults::{Fault, Trigger};

/// The contents of a scenario file that concern its map and the robot on it.
#[derive(Clone, Debug)]
pub struct PremisesEntry {
    /// The map's YAML file.
    pub map: Spanned<PathBuf>,
    /// The places file; without one, there are no places.
    pub places: Option<Spanned<PathBuf>>,
    /// The places that the scenario needs.
    pub sites: Sites,
    /// The simulated robot and its world.
    pub sim: SimConfig,
    /// People, doors and boxes: the bodies in `sim.obstacles`, with their locations in the file.
    pub world: Vec<WorldBody>,
}

/// The names of the places that a scenario requires.
#[derive(Clone, Debug)]
pub struct Sites {
    /// The start of the robot.
    pub start: Spanned<Start>,
    /// The charging station, a point, if there is one.
    pub station: Option<Spanned<String>>,
    /// The robot's destination, for pictures.
    pub destination: Option<Spanned<String>>,
}

/// The start of a robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// The point with this name.
    Named(String),
    /// This pose, in the `map` frame.
    At(Pose),
}

impl FromItem<'_> for Start {
    fn wanted() -> String {
        "the name of a point, or [x, y, heading] in meters and degrees".into()
    }

    fn takes() -> Value {
        let mut pose = <[f64; 3]>::takes();
        pose["title"] = json!(POSE);
        json!({ "title": Self::wanted(), "anyOf": [String::takes(), pose] })
    }

    fn from_item(item: &Item<'_>) -> Result<Self, Vec<Problem>> {
        let named = item.as_text().map(|name| Self::Named(name.to_owned()));
        let at = || item.get::<[f64; 3]>().ok().map(|[x, y, degrees]| Self::At(pose(x, y, degrees.to_radians())));
        named.or_else(at).ok_or_else(|| vec![item.wrong(&Self::wanted())])
    }
}

impl PremisesEntry {
    /// The names of the doors.
    pub fn doors(&self) -> impl Iterator<Item = &str> {
        world::doors(&self.world)
    }

    /// The names of the people.
    pub fn people(&self) -> impl Iterator<Item = &str> {
        world::people(&self.world)
    }
}

impl Sites {
    /// Reads the places that a scenario on a map needs.
    pub(super) fn read(root: Table<'_>) -> Option<Self> {
        let sites = root.table("sites").about("The places that the scenario needs. Required if there is a map.");
        let sites = sites.needs(MAP);
        let table = if root.has(MAP) { sites.required() } else { sites.optional() }?;
        let site = |key, about| table.text(key).about(about).spanned();
        let start = table.get("start").about("Where the robot starts. Required if there is a map.");
        let start = start.refers_to(Referent::Point).spanned();
        let start = if root.has(MAP) { start.required() } else { start.optional() };
        let station = site(
            "station",
            "The point at which the charging station stands. Without it, the battery is never charged.",
        );
        let station = station.refers_to(Referent::Point).optional();
        let destination = site("destination", "The place to which the robot is sent, for pictures.");
        let destination = destination.refers_to(Referent::Place).optional();
        Some(Self { start: start?, station, destination })
    }
}

/// Reports every part of a file without a map that concerns a map or the robot on it, each at its location: those of
/// these `keys` that need the map, and those that are found only in their values.
pub(super) fn report_missing_map(root: Table<'_>, keys: &[Key], faults: &[Arc<Fault>]) {
    let report = |span: &Span, what: &str| {
        let problem = span.problem(format!("{what} needs a map, and this scenario has none"));
        let help = "name the map, `map = \"FILE.yaml\"`, and where the robot starts, `sites.start`; without a map, \
                    tree and skills run alone";
        root.report_missing(MAP, problem.with_label("this needs a map").with_help(help));
    };
    for key in keys.iter().filter(|key| key.needs.as_deref() == Some(MAP)) {
        let path = key.path.trim_end_matches("[]");
        if let Some(span) = root.find(path) {
            report(span, &format!("`{path}`"));
        }
    }
    let snapshots = root.table("snapshots").optional();
    let moments = snapshots.and_then(|table| table.get::<Vec<Spanned<String>>>("at").optional());
    for moment in moments.into_iter().flatten().filter(|moment| moment.value == "arrival") {
        report(&moment.span, "a picture of an arrival");
    }
    for fault in faults {
        if fault.needs_robot() {
            report(fault.arguments().span(), &format!("a fault `{}`", fault.kind().name));
        } else if let Trigger::Near { place, .. } = &fault.timing.trigger {
            report(&place.span, "the trigger `near`");
        }
    }
}

/// The map on which a scenario's robot drives, with its places and everything computed from it.
#[derive(Clone, Debug)]
pub struct Premises {
    /// The contents of the scenario's file.
    pub entry: PremisesEntry,
    /// The map.
    pub map: Arc<OccupancyGrid>,
    /// The places on the map.
    pub places: Places,
    /// The software's map, if a fault gives it a map other than the world's.
    pub wrong_map: Option<Arc<OccupancyGrid>>,
    /// The start pose of the robot, in the `map` frame.
    pub start: Pose,
    /// The pose of a robot docked at the charging station, in the `map` frame, if there is a station.
    pub station: Option<Pose>,
    /// The places to which skills always drive, each with one such skill.
    pub(super) driven_to: BTreeMap<String, String>,
    pub(super) written: Arc<PlacesFile>,
    pub(super) map_concerns: Vec<Problem>,
    pub(super) reach: Arc<Reach>,
    /// What is computed from the map on first use, and then shared by all runs.
    pub(super) memo: Arc<Memo>,
}

impl Premises {
    /// The data of the map for localization and navigation of the scenario's robot: computed on first use, and then
    /// shared by all runs.
    ///
    /// # Errors
    /// [`nav::Error`] if localization is impossible on the map.
    pub fn atlas(&self) -> Result<Arc<Atlas>, nav::Error> {
        let model: &RobotModel = &self.entry.sim.model;
        let map = self.wrong_map.as_ref().unwrap_or(&self.map);
        let zones = self.places.zones();
        let inputs = (Same(Arc::clone(map)), model.clone(), zones.to_vec());
        self.memo.get(&self.entry.map.value, inputs, || {
            let atlas = Atlas::new(Arc::clone(map), model, LocalizationParameters::default())?;
            Ok(Arc::new(atlas.with_zones(zones)))
        })
    }

    /// The walls of the simulated world: computed on first use, and then shared by all runs.
    #[must_use]
    pub fn building(&self) -> Building {
        let map = Same(Arc::clone(&self.map));
        let make = || Ok::<_, Infallible>(Building::new(&self.map));
        let Ok(building) = self.memo.get(&self.entry.map.value, map, make);
        building
    }
}
