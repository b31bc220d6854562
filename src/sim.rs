//! `steward sim SCENARIO`: the simulated robot as a robot of ROS 2, which nodes outside the program drive.

mod args;
#[cfg(feature = "dds")]
mod ros;

pub(crate) use args::SimArgs;
#[cfg(feature = "dds")]
pub(crate) use ros::sim;

#[cfg(not(feature = "dds"))]
pub(crate) fn sim(_: &SimArgs) -> Result<std::process::ExitCode, campaigns::Error> {
    Err(campaigns::Error::refused(crate::domain::WITHOUT, crate::domain::HOW))
}
