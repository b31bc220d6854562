//! Other programs that take part in a run.

use remote::NodeMessage;

use crate::controller::Controller;
use crate::remote_components::RemoteComponents;

/// The other programs that take part in a run. They set its pace: a step waits for them.
pub enum Partners {
    /// None: the run is the same every time.
    None,
    /// A controller of the robot.
    Controller(Box<dyn Controller>),
    /// The components that are nodes of ROS 2.
    Components(Box<dyn RemoteComponents>),
}

impl Partners {
    pub(crate) fn controller(&mut self) -> Option<&mut dyn Controller> {
        if let Self::Controller(controller) = self { Some(controller.as_mut()) } else { None }
    }

    pub(crate) fn components(&mut self) -> Option<&mut dyn RemoteComponents> {
        if let Self::Components(components) = self { Some(components.as_mut()) } else { None }
    }

    /// Continues after a pause, in which simulated time stood still.
    pub(crate) fn resume(&mut self) {
        match self {
            Self::None => {}
            Self::Controller(controller) => controller.resume(),
            Self::Components(components) => components.resume(),
        }
    }

    /// Ends their part in the run. The outbox has the last responses and messages for nodes of ROS 2.
    pub(crate) fn leave(&mut self, outbox: &[NodeMessage]) {
        match self {
            Self::None => {}
            Self::Controller(controller) => controller.leave(outbox),
            Self::Components(components) => components.leave(),
        }
    }
}
