//! When a run is over, and why.

use std::fmt;
use std::time::Duration;

use channels::Verdict;

use crate::live::{Live, News};

/// Why a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
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

/// Watches for the end of a run.
#[derive(Debug, Default)]
pub(crate) struct Ending {
    /// What the scenario stops at, once it has happened, and when the run ends for it.
    met: Option<(Ended, Duration)>,
}

impl Ending {
    /// Why the run ends now, if it does.
    pub(crate) fn reached(&mut self, live: &Live, news: &[News]) -> Option<Ended> {
        let file = &live.scenario().file;
        if self.met.is_none() {
            self.met = reason(live, news).map(|why| (why, live.time() + file.stop.after));
        }
        let limit = file.execution.max_time;
        let over = self.met.take_if(|(_, at)| live.time() >= *at).map(|(why, _)| why);
        over.or_else(|| (live.time() >= limit).then_some(Ended::TimeLimit(limit)))
    }
}

/// What has happened in this step that the scenario stops at: a violation before an arrival.
fn reason(live: &Live, news: &[News]) -> Option<Ended> {
    let stop = &live.scenario().file.stop;
    let verdict = |place: usize| live.system().monitors()[place].monitor.verdict();
    let violation = news.iter().find_map(|news| match news {
        News::Verdict(place) if verdict(*place) == Verdict::False => {
            let name = &live.watched()[*place].name;
            stop.on_violation.concerns(name).then(|| Ended::Violation(name.clone()))
        }
        _ => None,
    });
    let arrival = || {
        news.iter().find_map(|news| match news {
            News::Arrival(place) if stop.at.iter().any(|at| at.value == *place) => Some(Ended::Arrival(place.clone())),
            _ => None,
        })
    };
    let settled = || {
        let count = live.watched().len();
        let all = stop.when_settled && count > 0 && (0..count).all(|place| verdict(place) != Verdict::Inconclusive);
        all.then_some(Ended::Settled)
    };
    violation.or_else(arrival).or_else(settled)
}
