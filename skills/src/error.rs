//! Why a skill cannot be run.

use diagnostics::{Problem, Source};
use miette::Diagnostic;

/// Why a machine cannot be loaded or run.
#[derive(Clone, Debug, thiserror::Error, Diagnostic)]
#[non_exhaustive]
pub enum SkillError {
    /// The file cannot be read.
    #[error("{reason}")]
    Read {
        /// The file, and the reason.
        reason: String,
    },
    /// The file is not a machine that can run; or it would run into errors, which
    /// [`Strictness::Strict`](crate::Strictness::Strict) refuses.
    #[error("the skill {} {}: {}", .text.name(), verdict(.help.is_some()), count(.problems))]
    Load {
        /// The file with its text.
        #[source_code]
        text: Source,
        /// All problems, in the order of the file.
        #[related]
        problems: Vec<Problem>,
        /// What a standard SCXML processor would do with it.
        #[help]
        help: Option<&'static str>,
    },
    /// The events for a machine cannot be read.
    #[error("the events in {file} cannot be read: {}", count(.problems))]
    Events {
        /// The file's name.
        file: String,
        /// The file with its text.
        #[source_code]
        text: Source,
        /// The problems, line by line.
        #[related]
        problems: Vec<Problem>,
    },
    /// The machine does not fit the processes and channels around it.
    #[error("the machine of {process} does not fit its system: {}", count(.problems))]
    Wiring {
        /// The process that would run the machine.
        process: String,
        /// The machine's file with its text.
        #[source_code]
        text: Source,
        /// The problems, in the order of the file.
        #[related]
        problems: Vec<Problem>,
    },
    /// A machine does not have the part that a mutation changes.
    #[error("the skill {} cannot be changed so that {mutation}: {}", .text.name(), count(.problems))]
    Mutation {
        /// The mutation in words.
        mutation: String,
        /// The machine's file with its text.
        #[source_code]
        text: Source,
        /// What is missing.
        #[related]
        problems: Vec<Problem>,
    },
    /// The system has no process with the skill's name.
    #[error("there is no process named {name} to run the skill {file}")]
    UnknownProcess {
        /// The name.
        name: String,
        /// The machine's file.
        file: String,
        /// A suggestion.
        #[help]
        help: String,
    },
    /// A leaf of the tree has no skill.
    #[error("there is no skill for the leaf {leaf}")]
    NoSkill {
        /// The leaf.
        leaf: String,
        /// A suggestion.
        #[help]
        help: String,
    },
    /// A value is given for an unknown datum.
    #[error("the skill {file} has no parameter named {name}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// The machine's file.
        file: String,
        /// A suggestion.
        #[help]
        help: String,
    },
}

/// Warnings about a machine that can run; to be rendered, not an error.
#[derive(Clone, Debug, thiserror::Error, Diagnostic)]
#[error("the skill {} can run, with warnings: {}", .text.name(), count(.problems))]
#[diagnostic(severity(Warning))]
pub struct Concerns {
    #[source_code]
    text: Source,
    #[related]
    problems: Vec<Problem>,
}

impl Concerns {
    /// `None` if there are no problems.
    pub(crate) fn of(text: &Source, problems: Vec<Problem>) -> Option<Self> {
        (!problems.is_empty()).then(|| Self { text: text.clone(), problems })
    }
}

impl SkillError {
    /// The error of a machine's file with these problems; `forgivable` of them are not errors in standard SCXML.
    pub(crate) fn load(text: Source, problems: Vec<Problem>, forgivable: usize) -> Self {
        let errors = problems.iter().filter(|problem| problem.is_error()).count();
        let help = (errors == forgivable)
            .then_some("standard SCXML would raise `error.execution` when the machine gets there");
        Self::Load { text, problems, help }
    }
}

fn verdict(could_run: bool) -> &'static str {
    if could_run { "is refused, although standard SCXML would run it" } else { "cannot be loaded" }
}

fn count(problems: &[Problem]) -> String {
    match problems {
        [one] => one.to_string(),
        more => format!("{} problems", more.len()),
    }
}
