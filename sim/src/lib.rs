//! The simulated robot and its world.
//!
//! A [`Simulation`] is a world in the plane: the walls of an occupancy grid, a round robot with two driven wheels,
//! lasers, odometry and a battery, a charging station, and other bodies. Each [`step`](Simulation::step) advances it by
//! the fixed [`SimConfig::dt`]. It is a [`robot::Robot`]: the robot's software reads measurements and sends velocity
//! commands, and cannot distinguish it from a real robot.
//!
//! ```
//! use maps::{Cell, CellIndex, OccupancyGrid, pose};
//! use robot::{Reading, Robot, Streams, VelocityCommand};
//! use sim::{SimConfig, Simulation};
//!
//! // A floor of 6 m × 4 m without any wall.
//! let mut floor = OccupancyGrid::new(120, 80, 0.05, pose(0.0, 0.0, 0.0));
//! let cells = (0..80).flat_map(|row| (0..120).map(move |column| CellIndex { column, row }));
//! cells.for_each(|cell| floor.set(cell, Cell::Free));
//!
//! let station = pose(5.0, 2.0, 0.0);
//! let mut sim = Simulation::new(&SimConfig::default(), &floor, pose(1.0, 2.0, 0.0), station, &Streams::new(1))?;
//! sim.drive(VelocityCommand { linear_mps: 0.4, angular_radps: 0.0 });
//! (0..100).for_each(|_| sim.step());
//!
//! let mut readings = Vec::new();
//! sim.read(&mut readings);
//! assert!(matches!(readings[0], Reading::Odometry(first) if first.time.is_zero()));
//! assert!(sim.truth().pose().translation.x > 1.6);
//! # Ok::<(), sim::SimError>(())
//! ```
//!
//! # Structure
//! Entities and systems use bevy_ecs, bodies and contacts rapier2d, rays against moving bodies parry2d. Whole scans are
//! swept against the [`Walls`]; single rays are cast through their [`RayGrid`]. `simulation.rs` lists the systems in
//! the order of a step; each system is in the module of the part that it moves: `bodies`, `obstacles`, `people`,
//! `doors`, `drive`, `contacts`, `battery`, `odometer`, `lasers`. [`Truth`] is only for reports, pictures and trace
//! hashes.
//!
//! # Faults
//! Every fault of the robot or its world is a field of [`Faults`] (drained batteries, blind or displaced lasers,
//! slipping wheels, a joypad, doors and people in the way, a station that has been moved), whose documentation states
//! where in a step each acts. Instantaneous faults are methods ([`Simulation::kidnap`],
//! [`Simulation::set_battery_charge`]).
//!
//! # Devices
//! The actions of devices on the world are methods as well: [`Simulation::command_door`], [`Simulation::pick_up`],
//! [`Simulation::put_down`]. Their measurements come from [`Truth`]: [`Truth::door_opening`], [`Truth::sees`].
//!
//! # Determinism
//! The same configuration, map, poses, root seed, commands and faults give the same bits in every build and on every
//! machine of a target. Noise is off by default. Each consumer of randomness draws from its own stream (`sim/motion`,
//! `sim/odometry`, `sim/laser_<name>`, and `fault/…` for faults), so enabling one does not change the numbers of
//! another. Nothing reads a clock.
//!
//! # Inside
//! `Truth` is for reports and pictures only. `Faults` is a plain value with the current faults; its docs list the point
//! in a step at which each fault acts. The experiment sets it, never the simulation.

mod arc;
mod battery;
mod beams;
mod bodies;
mod boxes;
mod building;
mod check;
mod clock;
mod command_delay;
mod config;
mod contacts;
mod convert;
mod docking;
mod doors;
mod drive;
mod error;
mod faults;
mod floor;
mod kidnapping;
mod lasers;
mod motion;
mod noise;
mod obstacles;
mod odometer;
mod people;
mod physics;
mod ray_grid;
mod readings;
mod rectangles;
mod room;
mod route;
mod simulation;
mod spawning;
mod sweep;
mod truth;
mod walls;
mod wheels;

pub use beams::Beams;
pub use building::Building;
pub use config::{
    BatteryConfig, BodyConfig, DockingConfig, Door, DriftNoise, DriveConfig, Follow, LaserConfig, Manners,
    ObstacleConfig, ObstacleMotion, OdometryConfig, Opening, Pauses, RouteEnd, SimConfig, Walk,
};
pub use contacts::Contact;
pub use error::{BadSetting, BoxError, Obstruction, Placement, SimError};
pub use faults::{BaseFaults, BatteryFaults, BatteryReport, Faults, LaserFault, LaserTrouble, OdometryFaults};
pub use ray_grid::{RayGrid, RayHit};
pub use simulation::Simulation;
pub use truth::{ObstacleTruth, Truth};
pub use walls::{ScanMemory, Walls};
