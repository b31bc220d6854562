//! The standing of properties, as messages of ROS 2.

use ros_messages::CdrWriter;

use super::heard::Publication;
use crate::clock::system_ns;
use crate::robot::Standing;

/// Publishes standings: all of them on `/diagnostics`, and each that has changed on a latched topic of its own.
pub(super) struct Standings {
    pub(super) last: Vec<Standing>,
}

impl Standings {
    /// What is to be published now.
    pub(super) fn publications(&mut self, standings: &[Standing]) -> Vec<Publication> {
        let changed = standings.iter().filter(|standing| !self.last.contains(standing));
        let mut publications: Vec<Publication> = changed.map(alone).collect();
        publications.push(together(standings, system_ns()));
        self.last = standings.to_vec();
        publications
    }
}

/// On a topic of its own, whose name has no other letters than ROS allows.
fn alone(standing: &Standing) -> Publication {
    let mut body = CdrWriter::reusing(Vec::new());
    write(standing, &mut body);
    Publication {
        topic: format!("/steward/properties/{}", standing.property.replace(|letter: char| !letter.is_ascii(), "_")),
        kind: "diagnostic_msgs/msg/DiagnosticStatus".to_owned(),
        is_latched: true,
        body: body.bytes(),
    }
}

/// `diagnostic_msgs/msg/DiagnosticArray`
fn together(standings: &[Standing], now_ns: i64) -> Publication {
    let mut body = CdrWriter::reusing(Vec::new());
    let (s, ns) = (now_ns.div_euclid(1_000_000_000), now_ns.rem_euclid(1_000_000_000));
    body.number(i32::try_from(s).unwrap_or(i32::MAX).to_le_bytes());
    body.number((ns as u32).to_le_bytes());
    body.text("");
    body.length(standings.len());
    standings.iter().for_each(|standing| write(standing, &mut body));
    Publication {
        topic: "/diagnostics".to_owned(),
        kind: "diagnostic_msgs/msg/DiagnosticArray".to_owned(),
        is_latched: false,
        body: body.bytes(),
    }
}

/// `diagnostic_msgs/msg/DiagnosticStatus`
fn write(Standing { property, level, message, values }: &Standing, body: &mut CdrWriter) {
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
