//! The robot of a scenario: its `[robot]`, `[battery]` and `[noise]`.

use std::sync::Arc;
use std::time::Duration;

use diagnostics::Spanned;
use diagnostics::document::Table;
use maps::pose;
use robot::{LaserSpec, RobotModel};
use sim::{BatteryConfig, DockingConfig, DriftNoise, DriveConfig, SimConfig};

use super::world::MAP;
use crate::coordinates::POSE;
use crate::error::Complaints;
use crate::faults::Fault;
use crate::names::unknown;

/// Time between the steps of a run whose ticks are not more frequent.
pub const STEP: Duration = Duration::from_millis(20);

pub(super) fn read_sim(root: Table<'_>) -> SimConfig {
    let mut sim = SimConfig { dt: STEP, ..SimConfig::default() };
    if let Some(robot) =
        root.table("robot").about("The robot: a round body on two driven wheels.").needs(MAP).optional()
    {
        sim.model = read_model(robot);
        sim.drive = DriveConfig::of(&sim.model);
        let docking = robot.table("docking").about("When the robot is docked at its station, and charges.");
        sim.docking = docking.optional().map_or(sim.docking, read_docking);
    }
    let battery = root.table("battery").about("The battery.").needs(MAP).optional();
    sim.battery = battery.map_or(sim.battery, |battery| read_battery(battery, sim.battery));
    if let Some(noise) = root.table("noise").about("The noise of sensors and wheels.").needs(MAP).optional() {
        sim.lasers.range_sigma_m = sigma(noise, "laser_sigma_m", "Standard deviation of a range, in meters.");
        let odometry = noise.table("odometry").about("The noise of the motion that the odometry reports.");
        sim.odometry.noise = odometry.optional().map(read_drift).unwrap_or_default();
        let motion = noise.table("motion").about("The noise of the motion that the wheels carry out.");
        sim.drive.noise = motion.optional().map(read_drift).unwrap_or_default();
    }
    sim
}

fn read_battery(table: Table<'_>, defaults: BatteryConfig) -> BatteryConfig {
    let rate = |key, about, default| table.number(key).about(about).within(0.0..=100.0).default(default);
    BatteryConfig {
        initial_pct: rate("initial_pct", "Charge at the start, in percent.", defaults.initial_pct),
        drain_pct_per_s: rate(
            "drain_pct_per_s",
            "Drain while driving, in percent per second.",
            defaults.drain_pct_per_s,
        ),
        standstill_drain_pct_per_s: rate(
            "standstill_drain_pct_per_s",
            "Drain while standing, in percent per second.",
            defaults.standstill_drain_pct_per_s,
        ),
        charge_pct_per_s: rate(
            "charge_pct_per_s",
            "Gain while charging, in percent per second.",
            defaults.charge_pct_per_s,
        ),
        ..defaults
    }
}

fn sigma(table: Table<'_>, key: &str, about: &str) -> f64 {
    table.number(key).about(about).within(0.0..=1.0).default(0.0)
}

fn read_drift(table: Table<'_>) -> DriftNoise {
    let sigma = |key, about| sigma(table, key, about);
    DriftNoise {
        angle_per_sqrt_rad: sigma("angle_per_sqrt_rad", "Standard deviation of the angle, in radians, after 1 rad."),
        angle_per_sqrt_m: sigma("angle_per_sqrt_m", "Standard deviation of the angle, in radians, after 1 m."),
        distance_per_sqrt_m: sigma("distance_per_sqrt_m", "Standard deviation of the distance, in meters, after 1 m."),
        distance_per_sqrt_rad: sigma(
            "distance_per_sqrt_rad",
            "Standard deviation of the distance, in meters, after 1 rad.",
        ),
    }
}

fn read_model(table: Table<'_>) -> RobotModel {
    let radius_m = table
        .number("radius_m")
        .about("Radius of the body, in meters. The footprint is a disc; other shapes are not supported.")
        .within(0.05..=2.0)
        .default(RobotModel::default().radius_m);
    let defaults = RobotModel::with_radius(radius_m);
    let limit = |key, about, range, default| table.number(key).about(about).within(range).default(default);
    RobotModel {
        radius_m,
        max_linear_mps: limit(
            "max_linear_mps",
            "Maximum forward speed, in meters per second.",
            0.05..=3.0,
            defaults.max_linear_mps,
        ),
        max_angular_radps: limit(
            "max_angular_radps",
            "Maximum turning rate, in radians per second.",
            0.1..=4.0,
            defaults.max_angular_radps,
        ),
        max_linear_acceleration_mps2: limit(
            "max_linear_acceleration_mps2",
            "Maximum acceleration, in meters per second squared.",
            0.05..=10.0,
            defaults.max_linear_acceleration_mps2,
        ),
        max_angular_acceleration_radps2: limit(
            "max_angular_acceleration_radps2",
            "Maximum angular acceleration, in radians per second squared.",
            0.1..=50.0,
            defaults.max_angular_acceleration_radps2,
        ),
        lasers: read_lasers(table, radius_m).unwrap_or(defaults.lasers),
    }
}

/// The lasers of a robot with this radius, if the file names any.
fn read_lasers(table: Table<'_>, radius_m: f64) -> Option<Vec<LaserSpec>> {
    let about = "A laser scanner. If none is given, there are two, `front` and `back`, with the defaults below.";
    let lasers = table.tables("lasers").about(about);
    let lasers = lasers.check(|lasers| !lasers.is_empty(), "not be empty: a robot needs a laser");
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
    let must = "be a name other than `all`";
    let name = table.text("name").about("The laser's name, for faults and reports.");
    let name = name.filled(must).check(|name| name != "all", must).required();
    let [x, y, heading_deg] = read_mount(table, radius_m);
    let number = |key, about, range, default| table.number(key).about(about).within(range).default(default);
    let field_deg = number("field_of_view_deg", "Its field of view, in degrees.", 1.0..=360.0, 270.0);
    let beams = table.get::<u64>("beams").about("The number of beams.").within(2..=5000).default(360);
    let range_max_m = number("range_m", "The maximum distance that it measures, in meters.", 0.5..=100.0, 10.0);
    let range_min_m = number("min_range_m", "The minimum distance that it measures, in meters.", 0.0..=0.4, 0.1);
    let rate_hz = number("rate_hz", "Scans per second.", 1.0..=50.0, 10.0);
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

/// Where a laser is mounted: x and y in meters, and the direction in degrees.
fn read_mount(table: Table<'_>, radius_m: f64) -> [f64; 3] {
    let at = table.get::<[f64; 3]>("at").words(POSE).about(
        "Its position on the robot, x ahead and y to the left of the center, and the direction of the middle of its \
         field of view.",
    );
    let at = at.spanned().default(Spanned { value: [0.0; 3], span: table.span().clone() });
    let [x, y, _] = at.value;
    let distance_m = (x * x + y * y).sqrt();
    if distance_m > radius_m {
        let problem = at.span.problem(format!(
            "this laser is {distance_m} m from the robot's center, outside the body, whose radius is {radius_m} m"
        ));
        let help = "x and y are in meters, in the frame of the robot: x points ahead, y to the left";
        table.report(problem.with_label("outside the body").with_help(help));
    }
    at.value
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
    let distance_m = table.number("distance_m").about("Maximum distance from the station, in meters.");
    let angle_deg = table
        .number("angle_deg")
        .about("Maximum difference between its heading and the station's, in degrees.")
        .within(0.1..=180.0);
    let rest = table.seconds("rest_s").about("How long the robot must be at rest, in seconds.");
    DockingConfig {
        distance_m: distance_m.within(0.01..=10.0).default(defaults.distance_m),
        angle_rad: angle_deg.default(defaults.angle_rad.to_degrees()).to_radians(),
        rest: rest.default(defaults.rest),
    }
}
