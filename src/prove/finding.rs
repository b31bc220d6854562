//! The findings: as text, as a test case, and as JSON.

use std::collections::BTreeSet;
use std::path::PathBuf;

use campaigns::Error;
use diagnostics::counted;
use explorer::{Limit, Outcome};
use proofs::{Answer, Mistake, Physical, Proof, Question, Round, Subject, Unreached};
use reports::file_place::FilePlace;
use reports::results::{Case, CaseResult, FileFinding, FindingKind, Suite, WrittenPlaces};
use scenarios::scenario::ProofOutcome;
use serde_json::json;

use super::result::ProofResult;
use super::violation::{Violation, words};
use crate::results::{on_disk, places, warnings};

/// A property that was explored.
pub(crate) struct Finding {
    pub(crate) question: Question,
    pub(crate) answer: Answer,
    pub(crate) seconds: f64,
    /// A run in which something goes wrong.
    pub(crate) violation: Option<Violation>,
    /// The result in the simulation, if that was requested.
    pub(crate) physical: Option<Physical>,
    /// The files with the run, if they were requested.
    pub(crate) written: Option<WrittenRun>,
}

/// A run in files.
pub(crate) struct WrittenRun {
    pub(crate) page: PathBuf,
    /// The picture of its sequence chart.
    pub(crate) chart: PathBuf,
    /// All its files, in words.
    pub(crate) files: String,
}

/// The findings for a scenario.
pub(crate) struct Findings {
    pub(crate) proof: Proof,
    pub(crate) findings: Vec<Finding>,
    /// The properties that an error has left without a finding.
    pub(crate) unsearched: Vec<Unsearched>,
    /// Why the runs that violate properties could not be written, if that is so.
    pub(crate) unwritten: Option<String>,
}

/// A question whose runs were not searched, and the reason.
pub(crate) struct Unsearched(Question, String);

impl Unsearched {
    /// The questions that an error has left open: the one that it is about, and those that come after.
    pub(crate) fn after(findings: &[Finding], questions: &[Question], error: Option<&Error>) -> Vec<Self> {
        let Some(error) = error else { return Vec::new() };
        let open = &questions[findings.len()..];
        let reason = |place: usize| match place {
            0 => error.reasons(),
            _ => format!("the proof ended with the error about {}", open[0].property),
        };
        open.iter().enumerate().map(|(place, question)| Self(question.clone(), reason(place))).collect()
    }

    fn as_json(&self) -> serde_json::Value {
        let Self(Question { property, expected, .. }, reason) = self;
        let result = ProofResult::Unsearched.to_string();
        json!({
            "property": property, "result": result, "reason": reason, "expected": expected.name(), "as_expected": false,
        })
    }

    fn as_case(&self, places: &WrittenPlaces) -> Case {
        let Self(Question { property, .. }, reason) = self;
        Case {
            group: "proofs",
            name: property.clone(),
            result: CaseResult::Error(reason.clone()),
            found: ProofResult::Unsearched.to_string(),
            place: places.properties.get(property).cloned(),
            ..Case::default()
        }
    }
}

impl Finding {
    pub(crate) fn is_as_expected(&self) -> bool {
        let is_replayed = self.violation.as_ref().is_none_or(|violation| violation.run.is_as_found);
        self.answer.outcome() == Some(self.question.expected) && is_replayed
    }

    /// The finding in a word or two.
    pub(crate) fn result(&self) -> ProofResult {
        match self.answer.exploration.outcome {
            _ if self.answer.is_spurious => ProofResult::Spurious,
            _ if self.question.subject == Subject::AllReached => match self.answer.outcome() {
                Some(ProofOutcome::Proved) => ProofResult::Proved,
                Some(ProofOutcome::Violated) => ProofResult::Violated,
                None => ProofResult::Undecided,
            },
            Outcome::Proved => ProofResult::Proved,
            Outcome::Violated(_) => ProofResult::Violated,
            Outcome::Endless(_) => ProofResult::Endless,
            Outcome::Deadlock(_) => ProofResult::Deadlock,
            Outcome::Livelock(_) => ProofResult::Livelock,
            Outcome::Undecided(Limit::Stop) => ProofResult::Interrupted,
            Outcome::Undecided(_) => ProofResult::Undecided,
        }
    }

    /// Why the result means little, if it does.
    pub(crate) fn vacuous(&self) -> Option<String> {
        let property = &self.question.property;
        let is_vacuous = self.answer.exploration.is_vacuous();
        is_vacuous.then(|| format!("{property} is proved vacuously: in no run is a tick delivered, so nothing happens"))
    }

    /// The expected finding, if there was one.
    pub(crate) fn difference(&self) -> Option<String> {
        let Question { property, expected, .. } = &self.question;
        if self.is_as_expected() {
            return None;
        }
        let is_endless = matches!(self.answer.exploration.outcome, Outcome::Endless(_));
        Some(match self.answer.limit() {
            _ if self.answer.is_spurious => {
                format!("{property} is not decided: no battery can have the levels of this run")
            }
            Some(limit) => format!("{property} is not decided: {}", open(&self.answer, limit)),
            None if is_endless && self.answer.outcome().is_none() => {
                format!("{property} is not decided: messages pile up without end, and what follows is not searched")
            }
            None => format!("{property} was expected to be {}, and is {}", expected.name(), self.result()),
        })
    }

    /// The result of following the run in the simulation, in words, if it was requested.
    pub(super) fn in_simulation(&self) -> Option<String> {
        let Physical { tick, difference, .. } = self.physical.as_ref()?;
        let difference = difference.as_ref().map_or(String::new(), |difference| format!("; {difference}"));
        Some(match tick {
            Some(tick) => format!("run in the simulation: also violated, at tick {tick}"),
            None => format!("run in the simulation: not violated{difference}"),
        })
    }

    fn as_case(&self, places: &WrittenPlaces) -> Case {
        let property = &self.question.property;
        let details = match &self.violation {
            Some(found) => found.in_words(property, false),
            None => unreached(&self.answer),
        };
        let failed = |message| CaseResult::Failed { message, details };
        let trail = self.violation.as_ref().map(|found| found.trail(property, places)).unwrap_or_default();
        // The details of a result that is not as expected contain more.
        let steps = trail.iter().filter(|_| self.is_as_expected());
        Case {
            group: "proofs",
            name: property.clone(),
            story: steps.map(|step| step.words.clone()).collect(),
            result: self.difference().map_or(CaseResult::Passed, failed),
            found: if self.vacuous().is_some() { "proved vacuously".to_owned() } else { self.result().to_string() },
            place: places.properties.get(property).cloned(),
            trail,
            page: self.written.as_ref().map(|run| run.page.clone()),
            picture: self.written.as_ref().map(|run| run.chart.clone()),
            ..Case::default()
        }
    }

    fn as_json(&self) -> serde_json::Value {
        let Answer { exploration, rounds, .. } = &self.answer;
        let explorer::Progress { states, quiet, depth, memory, .. } = exploration.progress;
        let round = |Round { levels, progress, .. }: &Round| {
            json!({
                "levels": levels,
                "reduced": progress.is_reduced,
                "states": progress.states,
                "visited_states": progress.visited,
                "depth": progress.depth,
            })
        };
        json!({
            "property": self.question.property,
            "result": self.result().to_string(),
            "expected": self.question.expected.name(),
            "as_expected": self.is_as_expected(),
            "vacuous": self.vacuous(),
            "limit": self.answer.limit().map(|limit| limit.to_string()),
            "rounds": rounds.iter().map(round).collect::<Vec<_>>(),
            "states": states,
            "quiet_states": quiet,
            "transitions": exploration.transitions,
            "depth": depth,
            "memory_bytes": memory,
            "time_s": self.seconds,
            "physics": self.physical.as_ref().map(|Physical { tick, difference, .. }| {
                json!({ "violated_at_tick": tick, "difference": difference })
            }),
            "run": self.violation.as_ref().map(Violation::as_json),
        })
    }
}

/// Why an answer is open: each of its rounds, and what would help.
fn open(answer: &Answer, limit: Limit) -> String {
    let round = |Round { levels, progress, .. }: &Round| {
        let levels = levels.filter(|_| answer.rounds.iter().any(|other| other.levels != *levels));
        let levels = levels.map_or_else(String::new, |levels| format!(", with {levels} classes of levels"));
        let reduced = if progress.is_reduced { ", storing only states with a choice" } else { "" };
        format!("{} to depth {}{levels}{reduced}", counted(progress.visited, "state"), progress.depth)
    };
    let rounds: Vec<String> = answer.rounds.iter().map(round).collect();
    let help = match limit {
        Limit::Stop => "",
        Limit::Memory => "; `--memory` allows more, narrower assumptions in `[prove]` need less",
        Limit::Visits => {
            "; `--states` allows more, narrower assumptions in `[prove]` need fewer, and `--order depth` \
                          may find a long violation sooner"
        }
    };
    format!("{limit}. It explored {}{help}", rounds.join("; then "))
}

/// Everything that never happens, one item per line, with its location.
pub(super) fn unreached(answer: &Answer) -> String {
    let line =
        |Unreached { words, place, .. }: &Unreached| format!("  {}:{}: {words}\n", place.source().name(), place.line());
    answer.unreached.iter().flatten().map(line).collect()
}

impl Findings {
    /// Those for a scenario that was not searched at all, and why.
    pub(crate) fn none(proof: Proof, why: &str) -> Self {
        let unsearched = proof.questions().iter().map(|it| Unsearched(it.clone(), why.to_owned())).collect();
        Self { proof, findings: Vec::new(), unsearched, unwritten: None }
    }

    /// The errors of the tree and of machines, each once.
    pub(super) fn mistakes(findings: &[Finding]) -> BTreeSet<&Mistake> {
        findings.iter().flat_map(|finding| &finding.answer.mistakes).collect()
    }

    /// The findings as test cases, and what the proofs found in files; what is never reached only if it is listed.
    pub(crate) fn suite(&self, lists_unreached: bool) -> Suite {
        let scenario = self.proof.scenario();
        let places = places(scenario);
        let unwritten = self.unwritten.as_ref().map(|reason| Case {
            group: "runs",
            name: "runs are written".to_owned(),
            result: CaseResult::Error(reason.clone()),
            ..Case::default()
        });
        let cases = self.findings.iter().map(|finding| finding.as_case(&places));
        let cases = cases.chain(self.unsearched.iter().map(|it| it.as_case(&places))).chain(unwritten);
        let unreached = self.findings.iter().find_map(|finding| finding.answer.unreached.as_ref());
        let never = |Unreached { words, place, .. }: &Unreached| FileFinding {
            kind: FindingKind::Unreached,
            message: words.clone(),
            help: None,
            place: FilePlace::of(place),
        };
        let wrong = |Mistake { place, message }: &Mistake| FileFinding {
            kind: FindingKind::Warning,
            message: format!("{place}: {message}"),
            help: None,
            place: None,
        };
        let mistakes = Self::mistakes(&self.findings).into_iter().map(wrong);
        let simulated =
            |finding: &Finding| Some(format!("{}: {}", finding.question.property, finding.in_simulation()?));
        let simulated = self.findings.iter().filter_map(simulated);
        let unreached = unreached.into_iter().flatten().filter(|_| lists_unreached).map(never);
        Suite {
            name: scenario.name.clone(),
            provenance: Some(scenario.origin.provenance(recording::commit())),
            notes: words(&self.proof.assumptions()).into_iter().chain(simulated).collect(),
            cases: cases.collect(),
            findings: warnings(scenario).into_iter().chain(mistakes).chain(unreached).collect(),
            file: places.file,
            ..Suite::default()
        }
        .with_paths(on_disk(&[&scenario.origin.argument]))
    }

    pub(crate) fn as_json(&self) -> serde_json::Value {
        let unreached = self.findings.iter().find_map(|finding| finding.answer.unreached.as_ref());
        let never = |Unreached { kind, words, place }: &Unreached| {
            let (file, line) = (place.source().name(), place.line());
            json!({ "kind": kind.name(), "words": words, "file": file, "line": line })
        };
        let properties = self.findings.iter().map(Finding::as_json);
        let wrong = |Mistake { place, message }: &Mistake| json!({ "place": place, "message": message });
        json!({
            "scenario": self.proof.scenario().name,
            "version": env!("CARGO_PKG_VERSION"),
            "provenance": self.proof.scenario().origin.provenance(recording::commit()),
            "assumptions": words(&self.proof.assumptions()),
            "properties": properties.chain(self.unsearched.iter().map(Unsearched::as_json)).collect::<Vec<_>>(),
            "errors": Self::mistakes(&self.findings).into_iter().map(wrong).collect::<Vec<_>>(),
            "unreached": unreached.map(|found| found.iter().map(never).collect::<Vec<_>>()),
        })
    }
}
