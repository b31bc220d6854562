//! The last record of a run that ran to its end.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use channels::{GraphMonitor, Monitor, Verdict};
use monitors::{OpenObligation, ScopeMonitor, Vacuity, Violations, scope_monitor};
use serde::{Deserialize, Serialize};

use crate::{Evidence, MonitorState, Scene};

/// Facts about a run that are known once it has ended.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct End {
    /// Why it ended.
    pub ended: Ended,
    /// BLAKE3 hash of the trace, in hexadecimal.
    pub trace_hash: String,
    /// The final verdict of each monitor, in the order of the [header](crate::Header::monitors).
    pub monitors: Vec<MonitorEnd>,
    /// Errors in the skills' machines: each error once, in the order of first occurrence.
    pub skill_errors: Vec<SkillError>,
    /// How many messages each fault has damaged, in the order of the [header](crate::Header::faults); none for a fault
    /// that does not damage messages.
    pub messages_hit: Vec<Option<u64>>,
    /// The visible scene of the last step, if pictures may be taken.
    pub scene: Option<Arc<Scene>>,
}

/// Why a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ended {
    /// The robot came to rest at this place, and the scenario stops there.
    Arrival(String),
    /// This property was violated, and the scenario stops then.
    Violation(String),
    /// Every property had a verdict, and the scenario stops then.
    Settled,
    /// The scenario's limit of simulated time was reached.
    TimeLimit(Duration),
    /// The schedule that it followed was over.
    Scheduled,
    /// It was interrupted from outside.
    Interrupted,
    /// It was not a run of a simulation, and its recording ends here.
    Recorded,
    /// Likewise, and its recording was cut off here, in the middle of this.
    CutOff(String),
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
            Self::Scheduled => "schedule",
            Self::Interrupted => "interrupted",
            Self::Recorded => "recorded",
            Self::CutOff(_) => "cut_off",
        }
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Arrival(place) => write!(f, "the robot came to rest at {place}"),
            Self::Violation(property) => write!(f, "{property} was violated"),
            Self::Settled => f.write_str("every property had its verdict"),
            Self::TimeLimit(limit) => write!(f, "the limit of {} s was reached", diagnostics::seconds(*limit)),
            Self::Scheduled => f.write_str("the schedule ended"),
            Self::Interrupted => f.write_str("the run was interrupted"),
            Self::Recorded => f.write_str("the recording ends here"),
            Self::CutOff(what) => write!(f, "the recording was cut off here: {what}"),
        }
    }
}

/// The final state of a monitor.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct MonitorEnd {
    /// Its verdict.
    pub state: MonitorState,
    /// What the verdict rests on. The state of one that is unsure, or groundless, is inconclusive.
    pub evidence: Evidence,
    /// Every violation, if the monitor can distinguish them.
    pub violations: Option<Violations>,
    /// The obligations that are still pending.
    pub open: Vec<OpenObligation>,
    /// The clauses whose antecedent never held.
    pub vacuous: Vec<Vacuity>,
    /// Errors in the scripts, if the monitor is a machine; each error once.
    pub errors: Vec<String>,
    /// How often each location of the monitor's graph was entered, if the monitor counts visits.
    pub visits: Vec<u64>,
}

impl MonitorEnd {
    /// The final state of a monitor, without script errors.
    #[must_use]
    pub fn of(monitor: &dyn Monitor, evidence: Evidence) -> Self {
        let state = MonitorState { verdict: monitor.verdict_at_end(), ..MonitorState::of(monitor) };
        if !evidence.has_verdict() {
            // Neither its violations nor what is open or vacuous is known.
            let state = MonitorState { verdict: Verdict::Inconclusive, is_open: true, ..state };
            return Self { state, evidence, ..Self::default() };
        }
        let scope = scope_monitor(monitor);
        let graph = (monitor as &dyn std::any::Any).downcast_ref::<GraphMonitor>();
        let visits = |graph: &GraphMonitor| {
            let locations = monitor.graph().map_or(&[][..], |(graph, _)| graph.locations());
            locations.iter().map(|location| graph.visits(location)).collect()
        };
        Self {
            state,
            evidence,
            violations: scope.and_then(ScopeMonitor::violations).cloned(),
            open: scope.map(ScopeMonitor::open_obligations).unwrap_or_default(),
            vacuous: scope.map(ScopeMonitor::vacuous).unwrap_or_default(),
            errors: Vec::new(),
            visits: graph.map(visits).unwrap_or_default(),
        }
    }
}

/// An error in a skill's machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SkillError {
    /// The skill.
    pub skill: String,
    /// The state whose element in the machine's file failed; none for elements outside states.
    pub state: Option<String>,
    /// The error, in words.
    pub message: String,
    /// When it first happened.
    pub time: Duration,
    /// How often it happened.
    pub times: u64,
}
