//! The statuses of properties, as messages of ROS 2.

use ros_messages::CdrWriter;

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
    let mut body = CdrWriter::reusing(Vec::new());
    write(status, &mut body);
    Publication {
        topic: format!("/steward/properties/{}", status.property.replace(|letter: char| !letter.is_ascii(), "_")),
        kind: "diagnostic_msgs/msg/DiagnosticStatus".to_owned(),
        is_latched: true,
        body: body.bytes(),
    }
}

/// `diagnostic_msgs/msg/DiagnosticArray`
fn together(statuses: &[PropertyStatus], now_ns: i64) -> Publication {
    let mut body = CdrWriter::reusing(Vec::new());
    let (s, ns) = (now_ns.div_euclid(1_000_000_000), now_ns.rem_euclid(1_000_000_000));
    body.number(i32::try_from(s).unwrap_or(i32::MAX).to_le_bytes());
    body.number((ns as u32).to_le_bytes());
    body.text("");
    body.length(statuses.len());
    statuses.iter().for_each(|status| write(status, &mut body));
    Publication {
        topic: "/diagnostics".to_owned(),
        kind: "diagnostic_msgs/msg/DiagnosticArray".to_owned(),
        is_latched: false,
        body: body.bytes(),
    }
}

/// `diagnostic_msgs/msg/DiagnosticStatus`
fn write(PropertyStatus { property, level, message, values }: &PropertyStatus, body: &mut CdrWriter) {
    body.number([*level as u8]);
    body.text(&format!("steward: {property}"));
    body.text(message);
    body.text("");
    body.length(values.len());
    for (key, value) in values {
        body.text(key);
        body.text(value);
    }
}
