//! The parameters of robot, world and execution, with their values.

use std::time::Duration;

use components::StopRule;
use maps::{Point, Pose, Shape};
use recording::{SettingGroup, decimals};
use robot::{LaserSpec, RobotModel};
use sim::{
    BatteryConfig, BodyConfig, DockingConfig, Door, DriftNoise, DriveConfig, Follow, LaserConfig, Manners,
    ObstacleConfig, ObstacleMotion, OdometryConfig, Opening, Pauses, SimConfig, Walk,
};

use super::{Execution, Order, Policy, STEP, TreeForm};

fn group<const N: usize>(title: &str, rows: [(&str, String); N]) -> SettingGroup {
    SettingGroup { title: title.to_owned(), rows: rows.map(|(name, value)| (name.to_owned(), value)).to_vec() }
}

fn with_unit(number: f64, unit: &str) -> String {
    format!("{} {unit}", decimals(number, 4))
}

fn duration(time: Duration) -> String {
    with_unit(time.as_secs_f64(), "s")
}

/// All parameters of robot, world and execution. Every field is listed here explicitly, so that a new one cannot be
/// forgotten.
pub fn in_effect(sim: Option<&SimConfig>, has_model: bool, execution: &Execution) -> Vec<SettingGroup> {
    let mut groups = vec![self::execution(execution, sim.is_some(), has_model)];
    groups.extend(sim.into_iter().flat_map(simulation));
    groups.retain(|group| !group.rows.is_empty());
    groups
}

fn simulation(sim: &SimConfig) -> Vec<SettingGroup> {
    // Every step of the run is a step of the simulation.
    let SimConfig { model, dt: _, body, drive, odometry, lasers, battery, docking, obstacles } = sim;
    vec![
        self::battery(battery),
        self::docking(docking),
        robot(model),
        self::body(body),
        wheels(drive),
        self::odometry(odometry),
        self::lasers(model, lasers),
        SettingGroup {
            title: "Other bodies".to_owned(),
            rows: obstacles.iter().map(|obstacle| (obstacle.name.clone(), obstacle_in_words(obstacle))).collect(),
        },
    ]
}

fn execution(execution: &Execution, has_robot: bool, has_model: bool) -> SettingGroup {
    let Execution {
        tick,
        schedule,
        policy,
        starved,
        orders,
        stops,
        tree,
        leaf_timeout,
        max_time,
        step_budget,
        run_budget,
    } = execution;
    let policy = match policy {
        Policy::Random => "random",
        Policy::RoundRobin => "round-robin",
    };
    let policy = match (schedule, starved) {
        (Some(schedule), _) => format!("as {} says", schedule.value.display()),
        (None, Some(victim)) => format!("{policy}, starve {}", victim.value),
        (None, None) => policy.to_owned(),
    };
    let stops = match stops {
        StopRule::OwnTrip => "ends the trip to its place, with a confirmation",
        StopRule::AnyTrip => "ends any trip, with a confirmation",
    };
    let tree = match tree {
        TreeForm::Whole => "one process",
        TreeForm::Nodes => "one process per node",
    };
    let mut group = self::group(
        "Execution",
        [
            ("step of the simulation", duration(STEP)),
            ("time between ticks", duration(*tick)),
            ("scheduler", policy),
            ("behavior tree", tree.to_owned()),
            ("timeout for a leaf", duration(*leaf_timeout)),
            ("a stop of navigation", stops.to_owned()),
            ("longest run", duration(*max_time)),
            ("maximum transitions per step", step_budget.to_string()),
            ("maximum communications per run", run_budget.to_string()),
        ],
    );
    group.rows.retain(|(name, _)| match &**name {
        "a stop of navigation" => has_robot,
        // The steps of a model follow its events.
        "step of the simulation" => !has_model,
        _ => true,
    });
    let in_words = |order: &Order| format!("{} before {}", order.first.value, order.then.value);
    group.rows.extend(orders.iter().map(|order| ("received in this order".to_owned(), in_words(order))));
    group
}

fn battery(battery: &BatteryConfig) -> SettingGroup {
    let BatteryConfig {
        initial_pct,
        drain_pct_per_s,
        standstill_drain_pct_per_s,
        charge_pct_per_s,
        full_pct,
        recharge_below_pct,
        period,
    } = battery;
    self::group(
        "Battery",
        [
            ("initial charge", with_unit(*initial_pct, "%")),
            ("driving costs", with_unit(*drain_pct_per_s, "%/s")),
            ("standing costs", with_unit(*standstill_drain_pct_per_s, "%/s")),
            ("charging gives", with_unit(*charge_pct_per_s, "%/s")),
            ("charging ends at", with_unit(*full_pct, "%")),
            ("charging resumes below", with_unit(*recharge_below_pct, "%")),
            ("time between readings", duration(*period)),
        ],
    )
}

fn docking(docking: &DockingConfig) -> SettingGroup {
    let DockingConfig { distance_m, angle_rad, rest } = docking;
    self::group(
        "A robot is docked",
        [
            ("within", with_unit(*distance_m, "m")),
            ("facing within", with_unit(angle_rad.to_degrees(), "°")),
            ("at rest for", duration(*rest)),
        ],
    )
}

fn robot(model: &RobotModel) -> SettingGroup {
    let RobotModel {
        radius_m,
        max_linear_mps,
        max_angular_radps,
        max_linear_acceleration_mps2,
        max_angular_acceleration_radps2,
        lasers: _,
    } = model;
    self::group(
        "Robot",
        [
            ("radius", with_unit(*radius_m, "m")),
            ("largest speed", with_unit(*max_linear_mps, "m/s")),
            ("largest turning rate", with_unit(*max_angular_radps, "rad/s")),
            ("largest acceleration", with_unit(*max_linear_acceleration_mps2, "m/s²")),
            ("largest angular acceleration", with_unit(*max_angular_acceleration_radps2, "rad/s²")),
        ],
    )
}

fn body(body: &BodyConfig) -> SettingGroup {
    let BodyConfig { mass_kg, friction } = body;
    let friction = decimals(*friction, 4);
    self::group("Body", [("mass", with_unit(*mass_kg, "kg")), ("friction of its side", friction)])
}

fn wheels(drive: &DriveConfig) -> SettingGroup {
    let DriveConfig { wheel_separation_m, max_wheel_mps, noise } = drive;
    let mut group = self::group(
        "Wheels",
        [
            ("distance between the wheels", with_unit(*wheel_separation_m, "m")),
            ("maximum speed of a wheel", with_unit(*max_wheel_mps, "m/s")),
        ],
    );
    group.rows.extend(drift(noise));
    group
}

fn odometry(odometry: &OdometryConfig) -> SettingGroup {
    let OdometryConfig { period, noise, distance_bias, angle_bias, angle_bias_rad_per_m } = odometry;
    let mut group = self::group(
        "Odometry",
        [
            ("time between readings", duration(*period)),
            ("excess distance", with_unit(distance_bias * 100.0, "%")),
            ("excess angle", with_unit(angle_bias * 100.0, "%")),
            ("excess angle per meter", with_unit(*angle_bias_rad_per_m, "rad/m")),
        ],
    );
    group.rows.extend(drift(noise));
    group
}

fn drift(noise: &DriftNoise) -> [(String, String); 4] {
    let DriftNoise { angle_per_sqrt_rad, angle_per_sqrt_m, distance_per_sqrt_m, distance_per_sqrt_rad } = noise;
    [
        ("noise of the angle after 1 rad", with_unit(*angle_per_sqrt_rad, "rad")),
        ("noise of the angle after 1 m", with_unit(*angle_per_sqrt_m, "rad")),
        ("noise of the distance after 1 m", with_unit(*distance_per_sqrt_m, "m")),
        ("noise of the distance after 1 rad", with_unit(*distance_per_sqrt_rad, "m")),
    ]
    .map(|(name, value)| (name.to_owned(), value))
}

fn lasers(model: &RobotModel, lasers: &LaserConfig) -> SettingGroup {
    let LaserConfig { range_sigma_m } = lasers;
    let mut group = self::group("Lasers", [("noise of a range", with_unit(*range_sigma_m, "m"))]);
    group.rows.extend(model.lasers.iter().map(|laser| (laser.name.clone(), laser_in_words(laser))));
    group
}

fn laser_in_words(laser: &LaserSpec) -> String {
    let LaserSpec { name: _, mount, angle_min_rad, angle_increment_rad, beams, period, range_min_m, range_max_m } =
        laser;
    format!(
        "{beams} beams from {}°, {}° apart, {} to {}, every {}, mounted at {}",
        decimals(angle_min_rad.to_degrees(), 1),
        decimals(angle_increment_rad.to_degrees(), 2),
        decimals(*range_min_m, 2),
        with_unit(*range_max_m, "m"),
        duration(*period),
        pose(mount),
    )
}

fn obstacle_in_words(obstacle: &ObstacleConfig) -> String {
    let ObstacleConfig { name: _, shape, pose, motion } = obstacle;
    let shape = match shape {
        Shape::Disc { radius_m } => format!("a disc of radius {}", with_unit(*radius_m, "m")),
        Shape::Box { length_m, width_m } => {
            format!("a box of {} by {}", with_unit(*length_m, "m"), with_unit(*width_m, "m"))
        }
    };
    let motion = match motion {
        ObstacleMotion::Fixed => "fixed".to_owned(),
        ObstacleMotion::Person(walk) => walk_in_words(walk),
        ObstacleMotion::Follower(follow) => follow_in_words(follow),
        ObstacleMotion::Door(door) => door_in_words(door),
        ObstacleMotion::Movable { mass_kg } => format!("can be pushed, {}", with_unit(*mass_kg, "kg")),
        ObstacleMotion::Route { waypoints, speed_mps, end } => {
            format!("moves at {} by {}, then: {end:?}", with_unit(*speed_mps, "m/s"), positions(waypoints))
        }
    };
    format!("{shape} at {}, {motion}", self::pose(pose))
}

fn walk_in_words(walk: &Walk) -> String {
    let Walk { waypoints, speed_mps, end, sets_out, pause, pauses, manners } = walk;
    if waypoints.is_empty() {
        return "stands still".to_owned();
    }
    let pauses = match pauses {
        _ if pause.is_zero() => String::new(),
        Pauses::Waypoints => format!(" and pauses {} at each", duration(*pause)),
        Pauses::Ends => format!(" and pauses {} at the ends", duration(*pause)),
    };
    let manners =
        manners.map_or("yields to nothing".to_owned(), |Manners { slow_within_m, stop_within_m, patience }| {
            format!(
                "slows down {} before the robot, stops at {}, steps aside after {}",
                with_unit(slow_within_m, "m"),
                with_unit(stop_within_m, "m"),
                duration(patience),
            )
        });
    format!(
        "starts after {}, walks at {} by {}{pauses}, then: {end:?}; {manners}",
        duration(*sets_out),
        with_unit(*speed_mps, "m/s"),
        positions(waypoints),
    )
}

fn follow_in_words(follow: &Follow) -> String {
    let Follow { distance_m, meets_within_m, speed_mps, stands } = follow;
    let stands = if stands.is_empty() { String::new() } else { format!(", stands {}", intervals(stands)) };
    format!(
        "follows the robot once it is within {}, at a distance of {} and at most {}{stands}",
        with_unit(*meets_within_m, "m"),
        with_unit(*distance_m, "m"),
        with_unit(*speed_mps, "m/s"),
    )
}

fn door_in_words(door: &Door) -> String {
    let Door { opening, moving, closed, every } = door;
    let opening = match opening {
        Opening::Slide => "slides",
        Opening::Left => "opens to the left",
        Opening::Right => "opens to the right",
    };
    let times = if closed.is_empty() { "never closed".to_owned() } else { format!("closed {}", intervals(closed)) };
    let every = every.map_or_else(String::new, |every| format!(", every {}", duration(every)));
    format!("a door that {opening} within {}, {times}{every}", duration(*moving))
}

/// Times that have a beginning and an end: `from 1 s to 2 s, from 5 s to the end`.
fn intervals(times: &[(Duration, Duration)]) -> String {
    let each = times.iter().map(|(from, to)| format!("from {} to {}", duration(*from), until(*to)));
    each.collect::<Vec<_>>().join(", ")
}

fn until(time: Duration) -> String {
    if time == Duration::MAX { "the end".to_owned() } else { duration(time) }
}

fn positions(points: &[Point]) -> String {
    points.iter().map(|corner| position(corner.x, corner.y)).collect::<Vec<_>>().join(", ")
}

fn position(x: f64, y: f64) -> String {
    format!("({}, {}) m", decimals(x, 2), decimals(y, 2))
}

fn pose(pose: &Pose) -> String {
    let heading = decimals(maps::heading(pose).to_degrees(), 1);
    format!("{} facing {heading}°", position(pose.translation.x, pose.translation.y))
}
