//! Why a skill cannot be run.

use diagnostics::{Problem, Source};
use miette::Diagnostic;

/// Why a machine cannot be loaded or put to work.
#[derive(Clone, Debug, thiserror::Error, Diagnostic)]
#[non_exhaustive]
pub enum SkillError {
    /// The file cannot be read.
    #[error("{reason}")]
    Read {
        /// Which file, and why not.
        reason: String,
    },
    /// The file is not a machine that can run, or one that would run into errors, where that is not accepted
    /// ([`Strictness::Strict`](crate::Strictness::Strict)).
    #[error("the skill {} {}: {}", .text.name(), verdict(.help.is_some()), count(.problems))]
    Load {
        /// The file with its text.
        #[source_code]
        text: Source,
        /// Everything that is wrong with it, in the order of the file.
        #[related]
        problems: Vec<Problem>,
        /// What would become of it elsewhere.
        #[help]
        help: Option<&'static str>,
    },
    /// The events that a machine is to be given cannot be read.
    #[error("the events in {file} cannot be read: {}", count(.problems))]
    Events {
        /// The file's name.
        file: String,
        /// The file with its text.
        #[source_code]
        text: Source,
        /// Every line that is wrong.
        #[related]
        problems: Vec<Problem>,
    },
    /// The machine does not fit the processes and channels around it.
    #[error("the skill {process} does not fit the system it is part of: {}", count(.problems))]
    Wiring {
        /// The process that would run the machine.
        process: String,
        /// The machine's file with its text.
        #[source_code]
        text: Source,
        /// Everything that does not fit, in the order of the file.
        #[related]
        problems: Vec<Problem>,
    },
    /// A machine does not have what a mutation is to change.
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
    /// The system has no process of the skill's name.
    #[error("there is no process named {name} to run the skill {file}")]
    UnknownProcess {
        /// The name.
        name: String,
        /// The machine's file.
        file: String,
        /// What may have been meant.
        #[help]
        help: String,
    },
    /// A leaf of the tree has nobody to carry it out.
    #[error("there is no skill for the leaf {leaf}")]
    NoSkill {
        /// The leaf.
        leaf: String,
        /// What may have been meant.
        #[help]
        help: String,
    },
    /// A value is given for a datum that the machine does not have.
    #[error("the skill {file} has no parameter named {name}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// The machine's file.
        file: String,
        /// What may have been meant.
        #[help]
        help: String,
    },
}

/// What looks odd in a machine that can run nevertheless: something to render, not an error.
#[derive(Clone, Debug, thiserror::Error, Diagnostic)]
#[error("the skill {file} can run, but: {}", count(.problems))]
#[diagnostic(severity(Warning))]
pub struct Concerns {
    file: String,
    #[source_code]
    text: Source,
    #[related]
    problems: Vec<Problem>,
}

impl Concerns {
    pub(crate) fn new(text: Source, problems: Vec<Problem>) -> Self {
        Self { file: text.name().to_owned(), text, problems }
    }
}

impl SkillError {
    /// The error of a machine's file with these problems; SCXML itself would forgive `forgivable` of them.
    pub(crate) fn load(text: Source, problems: Vec<Problem>, forgivable: usize) -> Self {
        let errors = problems.iter().filter(|problem| problem.is_error()).count();
        let help = (errors == forgivable).then_some(
            "where this is an error, SCXML makes it the event `error.execution` when the machine gets there",
        );
        Self::Load { text, problems, help }
    }
}

fn verdict(could_run: bool) -> &'static str {
    if could_run { "is refused, though SCXML would have it run" } else { "cannot be loaded" }
}

fn count(problems: &[Problem]) -> String {
    match problems {
        [one] => one.to_string(),
        more => format!("{} problems", more.len()),
    }
}
