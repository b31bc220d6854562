//! The bound of an operator, in ticks.

use channels::Relation;
use diagnostics::Problem;

use super::Resolver;
use crate::formula::Bound;
use crate::syntax::{Literal, Operand};

impl Resolver<'_> {
    /// The bound in ticks, in nanoseconds for a timed property; `None` after problems have been reported.
    ///
    /// A duration d is converted to ticks of period p: an event n ticks away is n·p away, so n·p < d means n < ⌈d/p⌉.
    pub(super) fn bound(&mut self, relation: Relation, bound: &Operand) -> Option<Bound> {
        let literal = match bound {
            Operand::Literal(literal, _) => literal.clone(),
            Operand::Constant(name) => self.constant(name)?.clone(),
        };
        let problem = match literal {
            Literal::Duration { nanos, unit } if self.is_timed => {
                return Some(Bound { relation, ticks: nanos, written: Some((nanos, unit)) });
            }
            _ if self.is_timed => Problem::new("the bounds of a timed property are durations")
                .at(bound.span(), "no duration")
                .with_help("give it a unit, as in `300 ms`; without `timed`, ticks are counted"),
            Literal::Int(ticks) if ticks >= 0 => return Some(Bound::new(relation, ticks.unsigned_abs())),
            Literal::Int(_) => Problem::new("a bound must not be negative").at(bound.span(), "negative"),
            Literal::Duration { nanos, unit } => match self.round(relation, nanos) {
                Ok(ticks) => {
                    self.doubt_duration(relation, nanos, bound);
                    return Some(Bound { relation, ticks, written: Some((nanos, unit)) });
                }
                Err(problem) => problem.at(bound.span(), "not a whole number of ticks"),
            },
            Literal::Real(_) => Problem::new("a bound is a whole number of ticks or a duration")
                .at(bound.span(), "neither")
                .with_help("a duration has a unit of time: `2.5 s`, with ms, s, min or h"),
            _ => Problem::new("expected a number of ticks or a duration")
                .at(bound.span(), "no duration")
                .with_help("`10`, `10 ticks` or `30 s`"),
        };
        self.problems.push(problem);
        None
    }

    /// Warns of a limit that is shorter than the time between two ticks: it is kept by whatever comes before the next
    /// tick, however late.
    fn doubt_duration(&mut self, relation: Relation, nanos: u64, bound: &Operand) {
        let is_limit = matches!(relation, Relation::Less | Relation::LessOrEqual);
        if !is_limit || u128::from(nanos) >= self.tick_period.as_nanos() {
            return;
        }
        let problem = Problem::new(format!("this is less than a tick, and there is one every {:?}", self.tick_period));
        let problem = problem.at(bound.span(), "means: before the next tick");
        self.problems.push(problem.with_help("to measure time, write `timed property`").as_warning());
    }

    fn round(&self, relation: Relation, nanos: u64) -> Result<u64, Problem> {
        if self.tick_period.is_zero() {
            let problem = Problem::new("a duration cannot be counted in ticks that take no time");
            return Err(problem.with_help("give the bound as a number of ticks, or measure it: `timed property`"));
        }
        let period = u64::try_from(self.tick_period.as_nanos()).unwrap_or(u64::MAX);
        match relation {
            Relation::Less | Relation::GreaterOrEqual => Ok(nanos.div_ceil(period)),
            Relation::LessOrEqual | Relation::Greater => Ok(nanos / period),
            Relation::Equal | Relation::NotEqual if nanos.is_multiple_of(period) => Ok(nanos / period),
            Relation::Equal | Relation::NotEqual => {
                let problem =
                    Problem::new(format!("no tick is this far away: there is one every {:?}", self.tick_period));
                Err(problem.with_help("with `=` and `!=`, a duration must be a whole number of ticks"))
            }
        }
    }
}
