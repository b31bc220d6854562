//! The robot of a scenario: its `[robot]`, `[battery]` and `[noise]`.

use std::sync::Arc;
use std::time::Duration;

use diagnostics::Spanned;
use diagnostics::document::Table;
use maps::pose;
use robot::{LaserSpec, RobotModel};
use sim::{DockingConfig, DriftNoise, DriveConfig, SimConfig};

use crate::error::Complaints;
use crate::faults::Fault;
use crate::names::unknown;

/// Time between the steps of a run.
pub const STEP: Duration = Duration::from_millis(20);

/// Reads the settings of the simulated robot.
pub(super) fn read_sim(root: Table<'_>) -> SimConfig {
    let mut sim = SimConfig { dt: STEP, ..SimConfig::default() };
    if let Some(robot) = root.table("robot").optional() {
        sim.model = read_model(robot);
        sim.drive = DriveConfig::of(&sim.model);
        sim.docking = robot.table("docking").optional().map_or(sim.docking, read_docking);
    }
    if let Some(battery) = root.table("battery").optional() {
        let defaults = sim.battery;
        let rate = |key, default| battery.number(key).within(0.0..=100.0).or(default);
        sim.battery.initial_pct = rate("initial_pct", defaults.initial_pct);
        sim.battery.drain_pct_per_s = rate("drain_pct_per_s", defaults.drain_pct_per_s);
        sim.battery.standstill_drain_pct_per_s =
            rate("standstill_drain_pct_per_s", defaults.standstill_drain_pct_per_s);
        sim.battery.charge_pct_per_s = rate("charge_pct_per_s", defaults.charge_pct_per_s);
    }
    if let Some(noise) = root.table("noise").optional() {
        sim.lasers.range_sigma_m = noise.number("laser_sigma_m").within(0.0..=1.0).or(0.0);
        sim.odometry.noise = noise.table("odometry").optional().map_or(DriftNoise::NONE, read_drift);
        sim.drive.noise = noise.table("motion").optional().map_or(DriftNoise::NONE, read_drift);
    }
    sim
}

fn read_drift(table: Table<'_>) -> DriftNoise {
    let sigma = |key| table.number(key).within(0.0..=1.0).or(0.0);
    DriftNoise {
        angle_per_sqrt_rad: sigma("angle_per_sqrt_rad"),
        angle_per_sqrt_m: sigma("angle_per_sqrt_m"),
        distance_per_sqrt_m: sigma("distance_per_sqrt_m"),
        distance_per_sqrt_rad: sigma("distance_per_sqrt_rad"),
    }
}

fn read_model(table: Table<'_>) -> RobotModel {
    let radius_m = table.number("radius_m").within(0.05..=2.0).or(RobotModel::default().radius_m);
    let defaults = RobotModel::with_radius(radius_m);
    let limit = |key, range, default| table.number(key).within(range).or(default);
    RobotModel {
        radius_m,
        max_linear_mps: limit("max_linear_mps", 0.05..=3.0, defaults.max_linear_mps),
        max_angular_radps: limit("max_angular_radps", 0.1..=4.0, defaults.max_angular_radps),
        max_linear_acceleration_mps2: limit(
            "max_linear_acceleration_mps2",
            0.05..=10.0,
            defaults.max_linear_acceleration_mps2,
        ),
        max_angular_acceleration_radps2: limit(
            "max_angular_acceleration_radps2",
            0.1..=50.0,
            defaults.max_angular_acceleration_radps2,
        ),
        lasers: read_lasers(table, radius_m).unwrap_or(defaults.lasers),
    }
}

/// The lasers of a robot with this radius, if the file names any.
fn read_lasers(table: Table<'_>, radius_m: f64) -> Option<Vec<LaserSpec>> {
    let lasers = table.tables("lasers").check(|lasers| !lasers.is_empty(), "not be empty: a robot needs a laser");
    let lasers = lasers.each(|laser| read_laser(laser, radius_m)).optional()?;
    for (index, laser) in lasers.iter().enumerate() {
        if lasers[..index].iter().any(|other| other.value.name == laser.value.name) {
            let problem = laser.span.problem(format!("there are two lasers named `{}`", laser.value.name));
            table.report(problem.with_label("the second one").with_help("lasers need different names"));
        }
    }
    Some(lasers.into_iter().map(|laser| laser.value).collect())
}

fn read_laser(table: Table<'_>, radius_m: f64) -> Option<Spanned<LaserSpec>> {
    let name =
        table.text("name").check(|name| !name.is_empty() && name != "all", "be a name other than `all`").required();
    let at = table.get::<[f64; 3]>("at").spanned().optional();
    let [x, y, heading_deg] = at.as_ref().map_or([0.0; 3], |at| at.value);
    let distance_m = (x * x + y * y).sqrt();
    if let Some(at) = at.filter(|_| distance_m > radius_m) {
        let problem = at.span.problem(format!(
            "this laser is {distance_m} m from the robot's center, outside the body, whose radius is {radius_m} m"
        ));
        let help = "x and y are in meters, in the frame of the robot: x points ahead, y to the left";
        table.report(problem.with_label("outside the body").with_help(help));
    }
    let field_deg = table.number("field_of_view_deg").within(1.0..=360.0).or(270.0);
    let beams = table.get::<u64>("beams").within(2..=5000).or(360);
    let range_max_m = table.number("range_m").within(0.5..=100.0).or(10.0);
    let range_min_m = table.number("min_range_m").within(0.0..=0.4).or(0.1);
    let rate_hz = table.number("rate_hz").within(1.0..=50.0).or(10.0);
    // With a field of view all around, the last beam is not the first one again.
    let gaps = if field_deg < 360.0 { beams - 1 } else { beams };
    let spec = LaserSpec {
        name: name?,
        mount: pose(x, y, heading_deg.to_radians()),
        angle_min_rad: (-0.5 * field_deg).to_radians(),
        angle_increment_rad: (field_deg / gaps as f64).to_radians(),
        beams: usize::try_from(beams).expect("a small number"),
        period: Duration::from_secs_f64(1.0 / rate_hz),
        range_min_m,
        range_max_m,
    };
    Some(Spanned { value: spec, span: table.span().clone() })
}

/// Checks that the lasers that faults name exist.
pub(super) fn check_lasers(faults: &[Arc<Fault>], model: &RobotModel, complaints: &mut Complaints) {
    let names = || model.lasers.iter().map(|laser| laser.name.as_str());
    let named = faults.iter().filter_map(|fault| fault.laser());
    for laser in named.filter(|laser| !names().any(|name| name == laser.value)) {
        complaints.push(unknown("laser", &laser, names()));
    }
}

fn read_docking(table: Table<'_>) -> DockingConfig {
    let defaults = DockingConfig::default();
    let angle_deg = table.number("angle_deg").within(0.1..=180.0).optional();
    DockingConfig {
        distance_m: table.number("distance_m").within(0.01..=10.0).or(defaults.distance_m),
        angle_rad: angle_deg.map_or(defaults.angle_rad, f64::to_radians),
        rest: table.seconds("rest_s").or(defaults.rest),
    }
}
