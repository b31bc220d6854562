//! Localization, planning and path following for mobile robots with a map.
//!
//! It has two independent parts:
//!
//! - [`Localization`] estimates the robot's pose. It takes odometry and laser scans and maintains a set of particles,
//!   weighted by how well the scans fit the map from there (adaptive Monte Carlo localization).
//! - [`Navigator`] drives to a [`Goal`]. It takes scans and estimates of the pose, maintains a [`Costmap`] of the
//!   obstacles on the map and those seen by lasers, [plans](plan()) a path, follows it, stops for obstacles, tries
//!   other paths, and gives up with a reason. [`NavigationStatus`] is what it is doing.
//!
//! The robot may be real or simulated. No clock is read: times come with the readings, as
//! [`Duration`](std::time::Duration) since the start of the run. Random numbers come from the one stream given to
//! [`Localization::new`]; the same readings and the same stream give the same results on every machine of a target.
//! Lengths are in meters, angles in radians, poses in the map's frame unless a name states otherwise.
//!
//! Distances on grids are exact. Those of localization run between cell centers, and a surface lies half a cell before
//! the center of the cell behind it; clearances run to the nearest point of an obstacle's cell.
//!
//! # A robot's control loop
//!
//! ```
//! use std::time::Duration;
//!
//! use maps::{Cell, CellIndex, OccupancyGrid, Point, pose};
//! use nav::{Goal, InitialPose, Localization, LocalizationParameters};
//! use nav::{NavigationParameters, NavigationStatus, Navigator};
//! use robot::{LaserScan, Odometry, RobotModel, Streams};
//!
//! // An empty hall of 10 m × 10 m.
//! let mut map = OccupancyGrid::new(200, 200, 0.05, pose(0.0, 0.0, 0.0));
//! for row in 0..200 {
//!     for column in 0..200 {
//!         map.set(CellIndex { column, row }, Cell::Free);
//!     }
//! }
//! let model = RobotModel::default();
//! let start = InitialPose::at(pose(2.0, 2.0, 0.0));
//! let rng = Streams::new(1).stream("localization");
//! let mut localization = Localization::new(&map, &model, LocalizationParameters::default(), &start, rng)?;
//! let mut navigator = Navigator::new(&map, &model, NavigationParameters::of(&model))?;
//!
//! navigator.start(Goal::at(Point::new(8.0, 2.0), None));
//! for step in 0..20 {
//!     // What the robot senses:
//!     let time = Duration::from_millis(20 * step);
//!     let odometry = Odometry { time, pose: pose(0.0, 0.0, 0.0), linear_mps: 0.0, angular_radps: 0.0 };
//!     let scan = LaserScan { time, laser: 0, ranges_m: vec![f32::INFINITY; 360] };
//!     // What the software makes of it:
//!     localization.odometry(&odometry);
//!     localization.scan(&scan);
//!     navigator.scan(&scan, &localization.estimate());
//!     let command = navigator.update(time, &localization.estimate(), &odometry);
//!     // The command to the robot:
//!     assert!(command.linear_mps <= model.max_linear_mps);
//! }
//! assert_eq!(navigator.status(), NavigationStatus::Moving);
//! # Ok::<(), nav::Error>(())
//! ```
//!
//! What to read next: [`Localization`] and [`LocalizationParameters`] for the filter, [`NavigationStatus`] for the
//! states of a navigator, [`NavigationParameters`] for its timeouts and distances.
//!
//! # Inside
//! It sees scans, odometry and a map, never the truth. Everything that is computed once per map is its `Atlas`, which
//! all runs on that map share.

mod atlas;
mod beams;
mod costmap;
mod distance_transform;
mod error;
mod following;
mod grid_frame;
mod localization;
mod navigation;
mod particle;
mod planning;

pub use atlas::{Atlas, LocalizationParameters, closed_map};
pub use costmap::{Costmap, CostmapParameters, INSCRIBED_COST, LETHAL_COST, UNKNOWN_COST};
pub use error::Error;
pub use following::FollowingParameters;
pub use localization::{Hypothesis, InitialPose, Localization, PoseEstimate};
pub use navigation::{GiveUpReason, NavigationParameters, NavigationStatus, Navigator, Recovery};
pub use planning::{Goal, PlanError, Reach, largest_part, plan, plan_into};
