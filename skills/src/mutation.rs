//! Mutations: machines with one mistake more than their author made.
//!
//! A mutation is a small change of a machine's file, of the kind that people make by accident: a threshold moved, a guard
//! negated, a target swapped. It is addressed by what stands in the file: a state's id, the events of a transition, a
//! datum's id. [`mutate`] changes the text and leaves every line where it is, so that whatever is said about the mutant
//! points at the right line of the original; [`mutations`] lists all that are worth trying, for a campaign that asks which
//! of them no property notices.

mod description;
mod edit;
mod place;
mod several;
mod survey;

use crate::SkillError;

pub use description::{Mutation, SendPlace, TransitionPlace};
pub use several::mutate_all;
pub use survey::mutations;

/// Changes a machine's text as the mutation says, and nothing else; every line stays where it is. `file` names the text in
/// messages.
///
/// # Errors
/// [`SkillError::Load`] if the machine cannot be loaded, before or after the change; [`SkillError::Mutation`] if it does not
/// have what is to be changed, or has it so already.
///
/// ```
/// use skills::{Mutation, mutate, shipped};
///
/// let text = shipped("BatteryLevel").ok_or("not shipped")?;
/// let bug = Mutation::Data { id: "threshold".into(), expr: "20".into() };
/// let mutant = mutate("BatteryLevel.scxml", text, &bug)?;
/// assert_eq!(mutant, text.replace(r#"id="threshold" expr="30""#, r#"id="threshold" expr="20""#));
/// assert_eq!(bug.to_string(), "the datum `threshold` begins with 20");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn mutate(file: &str, text: &str, mutation: &Mutation) -> Result<String, SkillError> {
    mutate_all(file, text, [mutation])
}
