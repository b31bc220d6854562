//! The last record of a run that came to its end.

use std::fmt;
use std::time::Duration;

use monitors::{OpenObligation, Vacuity};
use serde::{Deserialize, Serialize};

use crate::{MonitorState, Scene};

/// What is known of a run once it has ended.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct End {
    /// Why it ended.
    pub ended: Ended,
    /// BLAKE3 hash of the trace, in hexadecimal.
    pub trace_hash: String,
    /// What each monitor says in the end, in the order of the [header](crate::Header::monitors).
    pub monitors: Vec<MonitorEnd>,
    /// What went wrong in the skills' machines, each thing once, in the order of its first time.
    pub skill_errors: Vec<SkillError>,
    /// How many messages each fault has damaged, in the order of the [header](crate::Header::faults); none for a fault
    /// that damages none.
    pub messages_hit: Vec<Option<u64>>,
    /// What can be seen in the last step, if pictures may be taken.
    pub scene: Option<Scene>,
}

/// Why a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ended {
    /// The robot came to rest at this place, where the scenario stops.
    Arrival(String),
    /// This property was violated, and the scenario stops at that.
    Violation(String),
    /// Every property had its verdict, and the scenario stops at that.
    Settled,
    /// The scenario's limit of simulated time was reached.
    TimeLimit(Duration),
}

impl Ended {
    /// The reason's name in results.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Arrival(_) => "arrival",
            Self::Violation(_) => "violation",
            Self::Settled => "settled",
            Self::TimeLimit(_) => "time_limit",
        }
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Arrival(place) => write!(f, "the robot came to rest at {place}"),
            Self::Violation(property) => write!(f, "{property} was violated"),
            Self::Settled => f.write_str("every property had its verdict"),
            Self::TimeLimit(limit) => write!(f, "the limit of {} s was reached", limit.as_secs_f64()),
        }
    }
}

/// What a monitor says in the end.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct MonitorEnd {
    /// How it stands.
    pub state: MonitorState,
    /// What is still owed.
    pub open: Vec<OpenObligation>,
    /// The clauses whose antecedent never held.
    pub vacuous: Vec<Vacuity>,
    /// What went wrong in the scripts of a monitor that is a machine, each thing once.
    pub errors: Vec<String>,
    /// How often each location of the monitor's graph was entered, where the monitor counts that.
    pub visits: Vec<u64>,
}

/// Something that went wrong in a skill's machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SkillError {
    /// The skill.
    pub skill: String,
    /// The state in which the machine's file has what failed; none for what stands outside of states.
    pub state: Option<String>,
    /// What went wrong, in words.
    pub message: String,
    /// When it did for the first time.
    pub time: Duration,
    /// How often it did.
    pub times: u64,
}
