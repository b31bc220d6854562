//! The frames of the simulated robot.

use std::time::Duration;

use recording::ros;
use robot::LaserSpec;
use scenarios::Error;

/// The names of the frames: those of a TurtleBot under Nav2, unless they are renamed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Frames {
    pub(super) map: String,
    pub(super) odom: String,
    /// The projection of the base onto the floor.
    pub(super) footprint: String,
    pub(super) base: String,
    pub(super) lasers: Vec<String>,
}

impl Frames {
    /// The frames of a robot with these lasers, renamed.
    ///
    /// # Errors
    /// If there is no such frame, or two would have one name.
    pub(super) fn of(lasers: &[LaserSpec], renamed: &[(String, String)]) -> Result<Self, Error> {
        let mut frames = Self {
            map: ros::MAP.to_owned(),
            odom: ros::ODOM.to_owned(),
            footprint: "base_footprint".to_owned(),
            base: ros::BASE.to_owned(),
            lasers: lasers.iter().map(ros::laser_frame).collect(),
        };
        let known: Vec<String> = frames.all().map(|frame| frame.clone()).collect();
        for (place, frame) in frames.all().enumerate() {
            if let Some((_, to)) = renamed.iter().find(|(from, _)| *from == known[place]) {
                frame.clone_from(to);
            }
        }
        for (place, (from, _)) in renamed.iter().enumerate() {
            if !known.contains(from) || renamed[..place].iter().any(|(other, _)| other == from) {
                let message = format!("`--frame`: there is no frame `{from}`, or it has been renamed already");
                return Err(Error::refused(message, format!("the frames are {}", known.join(", "))));
            }
        }
        let now: Vec<String> = frames.all().map(|frame| frame.clone()).collect();
        match now.iter().enumerate().find(|(place, frame)| now[..*place].contains(frame)) {
            Some((_, twice)) => {
                Err(Error::refused(format!("`--frame`: two frames would have the name {twice}"), "give each its own"))
            }
            None => Ok(frames),
        }
    }

    fn all(&mut self) -> impl Iterator<Item = &mut String> {
        let Self { map, odom, footprint, base, lasers } = self;
        [map, odom, footprint, base].into_iter().chain(lasers)
    }

    /// The transforms of the robot's fixed parts.
    pub(super) fn fixed(&self, lasers: &[LaserSpec]) -> ros::Transforms {
        let at = |of: &str, frame: &str, pose: &maps::Pose| {
            ros::transform(Duration::ZERO, of.to_owned(), frame.to_owned(), pose)
        };
        let base = at(&self.footprint, &self.base, &maps::pose(0.0, 0.0, 0.0));
        let lasers = lasers.iter().zip(&self.lasers).map(|(laser, frame)| at(&self.base, frame, &laser.mount));
        ros::Transforms { transforms: std::iter::once(base).chain(lasers).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(renamed: &[[&str; 2]]) -> Result<Frames, Error> {
        let renamed: Vec<(String, String)> = renamed.iter().map(|pair| pair.map(str::to_owned).into()).collect();
        Frames::of(&robot::RobotModel::default().lasers, &renamed)
    }

    #[test]
    fn frames_can_be_renamed() {
        let default = frames(&[]).expect("the defaults");
        assert_eq!((default.footprint.as_str(), default.lasers[0].as_str()), ("base_footprint", "laser_front"));
        let renamed = frames(&[["laser_front", "base_scan"], ["odom", "r1/odom"]]).expect("known frames");
        assert_eq!(renamed, Frames { odom: "r1/odom".to_owned(), lasers: renamed.lasers.clone(), ..default });
        assert_eq!(renamed.lasers[0], "base_scan");
        // They may change places.
        assert!(frames(&[["odom", "map"], ["map", "odom"]]).is_ok());
        for wrong in [&[["laser", "scan"]][..], &[["odom", "map"]], &[["odom", "a"], ["odom", "b"]]] {
            assert!(frames(wrong).is_err(), "{wrong:?}");
        }
    }
}
