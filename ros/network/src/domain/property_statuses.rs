//! The statuses of properties, as messages of ROS 2.

use ros_messages::Byte;
use ros_messages::standard::{Header, KeyValue, Status, Statuses, Time};

use super::exchange::Publication;
use crate::clock::system_ns;
use crate::robot::PropertyStatus;

/// Makes messages of statuses: one on `/diagnostics` with all of them, and one on a latched topic of its own for each
/// status that has changed.
#[derive(Default)]
pub(super) struct PropertyStatuses {
    last: Vec<PropertyStatus>,
}

impl PropertyStatuses {
    /// The messages to publish now.
    pub(super) fn publications(&mut self, statuses: &[PropertyStatus]) -> Vec<Publication> {
        let changed = statuses.iter().filter(|status| !self.last.contains(status));
        let mut publications: Vec<Publication> = changed.map(alone).collect();
        publications.push(together(statuses, system_ns()));
        self.last = statuses.to_vec();
        publications
    }
}

/// A message on a topic of its own. The name of the topic contains only letters that ROS allows.
fn alone(status: &PropertyStatus) -> Publication {
    let name = status.property.replace(|letter: char| !letter.is_ascii(), "_");
    Publication::of(&format!("/steward/properties/{name}"), true, &diagnostic(status))
}

fn together(statuses: &[PropertyStatus], now_ns: i64) -> Publication {
    let header = Header { stamp: Time::of_ns(now_ns), ..Header::default() };
    let status = statuses.iter().map(diagnostic).collect();
    Publication::of("/diagnostics", false, &Statuses { header, status })
}

fn diagnostic(PropertyStatus { property, level, message, values }: &PropertyStatus) -> Status {
    let values = values.iter().map(|(key, value)| KeyValue { key: (*key).to_owned(), value: value.clone() });
    Status {
        level: Byte(*level as u8),
        name: format!("steward: {property}"),
        message: message.clone(),
        hardware_id: String::new(),
        values: values.collect(),
    }
}
