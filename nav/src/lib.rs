//! Localization, planning and path following.

mod beams;
mod costmap;
mod distance_transform;
mod error;
mod following;
mod grid_frame;
mod localization;
mod navigation;
mod planning;

pub use costmap::{Costmap, CostmapParameters, INSCRIBED_COST, LETHAL_COST, UNKNOWN_COST};
pub use error::Error;
pub use following::FollowingParameters;
pub use localization::{InitialPose, Localization, LocalizationParameters, PoseEstimate};
pub use navigation::{GiveUpReason, Goal, NavigationParameters, NavigationStatus, Navigator};
pub use planning::{PlanError, plan, plan_into};
