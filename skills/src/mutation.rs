//! Mutations: machines with one additional mistake.
//!
//! A mutation is a small change of a machine's file, of the kind that people make by accident: a moved threshold, a
//! negated guard, a swapped target. It is addressed by names in the file: a state's id, the events of a transition, a
//! datum's id. [`mutate`] changes the text and keeps every line where it is, so messages about the mutant point to the
//! right line of the original. [`mutations`] lists all that are worth trying, for a campaign that finds those which no
//! property detects.

mod description;
mod edit;
mod place;
mod several;
mod survey;

use crate::SkillError;

pub use description::{Mutation, SendPlace, TransitionPlace};
pub use several::mutate_all;
pub use survey::{find_mutation, mutations};

/// Applies the mutation to a machine's text and changes nothing else; every line stays where it is. `file` names the
/// text in messages.
///
/// # Errors
/// [`SkillError::Load`] if the machine cannot be loaded, before or after the change; [`SkillError::Mutation`] if the
/// part to be changed does not exist, or the mutation changes nothing.
///
/// ```
/// use skills::{Mutation, mutate, shipped};
///
/// let text = shipped("BatteryLevel").ok_or("not shipped")?;
/// let bug = Mutation::Data { id: "threshold".into(), expr: "20".into() };
/// let mutant = mutate("BatteryLevel.scxml", text, &bug)?;
/// assert_eq!(mutant, text.replace(r#"id="threshold" expr="30""#, r#"id="threshold" expr="20""#));
/// assert_eq!(bug.to_string(), "the datum `threshold` starts with 20");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn mutate(file: &str, text: &str, mutation: &Mutation) -> Result<String, SkillError> {
    mutate_all(file, text, [mutation])
}
