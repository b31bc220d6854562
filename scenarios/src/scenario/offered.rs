//! Which components of a scenario can be offered to nodes of ROS 2.

use std::sync::Arc;

use interfaces::Interface;
use remote::{Offered, RemoteComponent, is_name};

use super::{Behavior, Runs, Scenario};

/// The components of a scenario that nodes of ROS 2 can ask.
#[derive(Clone, Debug)]
pub struct OfferedComponents {
    /// Each in the namespace of its name.
    pub offered: Arc<[Offered]>,
    /// Why others are not offered, in words.
    pub left_out: Vec<String>,
}

impl Scenario {
    /// The devices, machines and programs among the components that have an interface: in the namespace `/Door` if they
    /// are called `Door`, with the names and types that a component in `ros = "/Door"` with the same interface has.
    #[must_use]
    pub fn offered(&self) -> OfferedComponents {
        let (mut offered, mut left_out) = (Vec::new(), Vec::new());
        let components = self.components.iter().filter(|_| matches!(self.behavior, Behavior::Tree(_)));
        for (name, component) in components {
            let Interface { services, topics, actions } = &component.interface;
            let is_silent = services.is_empty() && topics.is_empty() && actions.is_empty();
            if is_silent || matches!(component.runs, Runs::Remote(_)) {
                continue;
            }
            match in_ros(name, &component.interface) {
                Ok(component) => offered.push((name.clone(), component)),
                Err(why) => left_out.push(format!("the component {name} is not offered to nodes of ROS 2: {why}")),
            }
        }
        OfferedComponents { offered: offered.into(), left_out }
    }
}

fn in_ros(name: &str, interface: &Interface) -> Result<RemoteComponent, String> {
    if !is_name(name) {
        return Err(format!("`{name}` cannot be a name there"));
    }
    // A client that uses everything must be able to tell all replies apart.
    interface.replies().map_err(|problem| problem.to_string())?;
    RemoteComponent::new(&format!("/{name}"), interface).map_err(|whys| whys.join("; "))
}
