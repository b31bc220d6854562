//! The names of the processes that every scenario has, besides the leaves of its tree.

use components::{BATTERY_READER, BLACKBOARD, LOCALIZATION, NAVIGATION};
use monitors::{MONITORS, WORLD};
use recording::TREE;

/// The name of the process that generates ticks.
pub const TICK_GENERATOR: &str = "TickGenerator";

/// The name of the process that stands for all nodes of ROS 2 that ask components, if there are some.
pub const ROS: &str = "ROS";

/// The name of the process that reads the topics which properties are about and nothing else reads.
pub const SUBSCRIBER: &str = "Subscriber";

/// The names of the components of every scenario with a map, unless it describes others with these names.
pub const BUILTIN: [&str; 3] = [BATTERY_READER, LOCALIZATION, NAVIGATION];

/// The names of the processes other than leaves.
pub const RESERVED: [&str; 9] =
    [TICK_GENERATOR, TREE, BATTERY_READER, LOCALIZATION, NAVIGATION, BLACKBOARD, SUBSCRIBER, WORLD, MONITORS];

/// The processes to which a skill may send.
pub const RECEIVERS: [&str; 5] = [TREE, BATTERY_READER, LOCALIZATION, NAVIGATION, BLACKBOARD];
