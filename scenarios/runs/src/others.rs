//! Who else takes part in a run, in other programs.

use remote::FromNode;

use crate::outside::Outside;
use crate::pilot::Pilot;

/// Who else takes part in a run, in other programs. They set its pace: a step waits for them.
pub enum Others {
    /// The run is alone, and the same every time.
    Nobody,
    /// Who drives the robot.
    Pilot(Box<dyn Pilot>),
    /// The components that are nodes of ROS 2.
    Components(Box<dyn Outside>),
}

impl Others {
    /// Who drives the robot, if somebody does.
    pub(crate) fn pilot(&mut self) -> Option<&mut dyn Pilot> {
        if let Self::Pilot(pilot) = self { Some(pilot.as_mut()) } else { None }
    }

    /// Where the components are that are nodes of ROS 2, if there are any.
    pub(crate) fn outside(&mut self) -> Option<&mut dyn Outside> {
        if let Self::Components(outside) = self { Some(outside.as_mut()) } else { None }
    }

    /// Time has stood still since a step last waited for them.
    pub(crate) fn resume(&mut self) {
        match self {
            Self::Nobody => {}
            Self::Pilot(pilot) => pilot.resume(),
            Self::Components(outside) => outside.resume(),
        }
    }

    /// They take part no longer. This is the last that components have said to them.
    pub(crate) fn leave(&mut self, said: &[FromNode]) {
        match self {
            Self::Nobody => {}
            Self::Pilot(pilot) => pilot.leave(said),
            Self::Components(outside) => outside.leave(),
        }
    }
}
