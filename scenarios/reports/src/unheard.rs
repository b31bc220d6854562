//! Battery levels that no message reported to a satisfied property.
//!
//! A property is about messages. One that requires a level is satisfied if no message carries the level while it is too
//! low. That is its definition, but not what a reader expects of it, and a simulation has the true level.

use monitors::Outcome;
use recording::{HeardLevels, Monitor, RunView, decimals};

use crate::bounds::levels_of;

/// For a satisfied property that requires levels in messages: that the true level fell below them, in words.
#[must_use]
pub fn unheard_level(property: &Monitor, outcome: Outcome, view: &RunView) -> Option<String> {
    let truth = view.tally().battery()?;
    let is_satisfied = outcome == Outcome::Satisfied;
    let mut levels = levels_of(property, view.topology()).into_iter().filter(|_| is_satisfied);
    levels.find_map(|compared| {
        let required_pct = compared.value;
        let heard = view.heard(compared.channel)?;
        let is_unheard = heard.is_none_or(|heard| heard.lowest_pct >= required_pct);
        if !compared.is_required || !compared.is_lower || truth.minimum_pct >= required_pct || !is_unheard {
            return None;
        }
        let messages = match heard {
            None => "no message carries a level".to_owned(),
            Some(HeardLevels { last, .. }) => {
                let required = decimals(required_pct, 6);
                let last_s = last.as_secs_f64();
                format!("no message carries a level below {required} %, and none after {last_s:.1} s carries any")
            }
        };
        Some(format!("{messages}; the true level fell to {:.1} %", truth.minimum_pct))
    })
}
