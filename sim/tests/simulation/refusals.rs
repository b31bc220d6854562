//! Invalid simulations.

use maps::{OccupancyGrid, Pose, Shape, pose};
use robot::Streams;
use sim::{ObstacleConfig, ObstacleMotion, Placement, SimConfig, SimError, Simulation};

use crate::room;

fn refusal(config: &SimConfig, grid: &OccupancyGrid, start: Pose, station: Pose) -> SimError {
    Simulation::new(config, grid, start, station, &Streams::new(1)).expect_err("refused")
}

#[test]
fn a_start_in_a_wall_is_refused_with_the_numbers() {
    let error = refusal(&SimConfig::default(), &room(8.0, 6.0), pose(7.8, 3.0, 0.0), pose(1.0, 1.0, 0.0));
    let message = error.to_string();
    assert!(message.starts_with("the start (7.8, 3) is 0.200 m from the wall at (8.025, 2.9"), "{message}");
    assert!(message.ends_with("but the robot's radius is 0.3 m"), "{message}");
}

#[test]
fn a_start_or_station_outside_the_map_is_refused() {
    let (grid, inside) = (room(8.0, 6.0), pose(1.0, 1.0, 0.0));
    let error = refusal(&SimConfig::default(), &grid, pose(-3.0, 2.0, 0.0), inside);
    assert_eq!(error.to_string(), "the start (-3, 2) is outside the map, which is 8.20 m × 6.20 m");
    let error = refusal(&SimConfig::default(), &grid, inside, pose(2.0, f64::NAN, 0.0));
    assert!(matches!(error, SimError::OutsideMap { what: Placement::Station, .. }), "{error}");
}

#[test]
fn a_start_in_unknown_space_needs_the_same_room() {
    let mut grid = OccupancyGrid::new(100, 100, 0.05, pose(0.0, 0.0, 0.0));
    assert!(
        Simulation::new(&SimConfig::default(), &grid, pose(2.0, 2.0, 0.0), pose(2.0, 2.0, 0.0), &Streams::new(1))
            .is_ok()
    );
    grid.set(maps::CellIndex { column: 45, row: 40 }, maps::Cell::Occupied);
    let error = refusal(&SimConfig::default(), &grid, pose(2.0, 2.0, 0.0), pose(2.0, 2.0, 0.0));
    assert!(matches!(error, SimError::InWall { what: Placement::Start, .. }), "{error}");
}

#[test]
fn a_start_inside_an_obstacle_is_refused() {
    let table = ObstacleConfig {
        name: "table".to_owned(),
        shape: Shape::Box { length_m: 2.0, width_m: 1.0 },
        pose: pose(4.0, 3.0, 0.5),
        motion: ObstacleMotion::Fixed,
    };
    let config = SimConfig { obstacles: vec![table], ..SimConfig::default() };
    let error = refusal(&config, &room(8.0, 6.0), pose(3.0, 3.0, 0.0), pose(1.0, 1.0, 0.0));
    assert!(error.to_string().contains("from the obstacle 'table'"), "{error}");
}

#[test]
fn invalid_settings_are_all_reported_at_once() {
    let mut config = SimConfig { dt: std::time::Duration::ZERO, ..SimConfig::default() };
    config.model.radius_m = -0.3;
    let error = refusal(&config, &room(8.0, 6.0), pose(4.0, 3.0, 0.0), pose(1.0, 1.0, 0.0));
    assert_eq!(
        error.to_string(),
        "invalid settings of the simulation: model.radius_m is -0.3, must be greater than 0; \
         dt is 0, must be longer than 0 s"
    );
}
