//! The arguments of `steward sim`.

use bags::Remapping;
use clap::Args;

use crate::domain::DomainArgs;
use crate::live::BoardArgs;
use crate::names;
use crate::ros_names::{namespace, remapping, renaming};
use crate::run::RunOptions;

/// The topics, at the end of the help.
const TOPICS: &str = "\
Topics that it publishes, reliably:
  /clock, /tf, scan, odom       the time, where the robot is, scans of all lasers
  /tf_static                    where the lasers are, latched
  map                           the map, latched, unless there is --no-map
  battery_state, contacts       the charge, and what the robot begins to touch
  doors                         how far the world's doors are open: latched
  amcl_pose                     with --localize: its estimated pose, latched
  particle_cloud                with --localize: the particles of the estimate
  plan                          with --navigate: the way that is left

Topics that it reads:
  cmd_vel                       what it obeys: Twist or TwistStamped
  initialpose                   with --localize: a pose for localization

Action that it serves:
  navigate_to_pose              with --navigate: as Nav2's

Services that it serves, as Nav2's nodes with a lifecycle, active once the run has begun:
  amcl/get_state                with --localize
  bt_navigator/get_state        with --navigate

Doors, devices and other components whose interfaces have types of ROS 2 offer their
services, topics and actions, each under its name: /Door/open, /Door/moved

Frames: map, odom, base_footprint, base_link, and laser_NAME for each laser";

/// The options for the results of a run, which conflict with a page.
const WITHOUT_A_PAGE: [&str; 10] =
    ["out", "gif", "record", "results", "junit", "open", "no_snapshots", "no_monitors", "json", "quiet"];

/// What `--live` does here.
const PAGE: &str = "Shows the run on a page in the browser, on which a person can intervene";

/// The robot, and how it may be driven.
#[derive(Clone, Debug, Args)]
#[command(after_help = TOPICS)]
#[command(mut_arg("live", |live| live.help(PAGE).conflicts_with_all(WITHOUT_A_PAGE)))]
pub(crate) struct SimArgs {
    /// A scenario with a map: a name (see `steward list`) or a file. Its tree stands still; its world, its faults and
    /// its properties are as in a run
    #[arg(value_name = "NAME|FILE", value_parser = names::SCENARIOS, hide_possible_values = true)]
    pub(super) scenario: String,
    #[command(flatten)]
    pub(super) options: RunOptions,
    #[command(flatten)]
    pub(super) board: BoardArgs,
    #[command(flatten)]
    pub(super) domain: DomainArgs,
    /// The namespace of its node and of its topics, such as `/r1`; given more than once, there is a robot in each, in a
    /// world of its own
    #[arg(long = "namespace", value_name = "NAMESPACE", value_parser = namespace)]
    pub(super) namespaces: Vec<String>,
    /// Gives a topic, a service or an action another name, as in ROS 2; may be given more than once
    #[arg(long = "remap", value_name = "FROM:=TO", value_parser = remapping)]
    pub(super) remapped: Vec<Remapping>,
    /// Localizes the robot: publishes `amcl_pose`, `particle_cloud` and the transform from `map` to `odom`, and listens
    /// to `initialpose`
    #[arg(long)]
    pub(super) localize: bool,
    /// Serves Nav2's action `navigate_to_pose`: the robot's own navigation drives, and while it does, commands on
    /// `cmd_vel` have no effect
    #[arg(long, requires = "localize", conflicts_with = "lock_step")]
    pub(super) navigate: bool,
    /// Does not publish the map on `map`, for nodes that make one from scans, such as slam_toolbox: with two
    /// publishers, subscribers would get both maps in turn
    #[arg(long)]
    pub(super) no_map: bool,
    /// Gives a frame another name, such as `odom:=r1/odom`; may be given more than once
    #[arg(long = "frame", value_name = "FROM:=TO", value_parser = renaming)]
    pub(super) frames: Vec<(String, String)>,
    /// How many simulated seconds pass in a second; `inf` for as many as possible
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, conflicts_with = "lock_step", value_parser = above_0)]
    pub(super) speed: f64,
    /// Waits in each period for its command, and then goes on at once: a run is the same every time if its driver is
    #[arg(long)]
    pub(super) lock_step: bool,
    /// The time between two commands in lock step, in simulated seconds: a multiple of the step, 0.02 s
    #[arg(long, value_name = "SECONDS", default_value_t = 0.1, requires = "lock_step", value_parser = above_0)]
    pub(super) period: f64,
    /// How long to wait for a command in lock step, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0, requires = "lock_step", value_parser = above_0)]
    pub(super) deadline: f64,
}

fn above_0(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0);
    number.ok_or_else(|| "a number above 0".to_owned())
}
