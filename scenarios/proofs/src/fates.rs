//! Which property detects which mutant.

use std::convert::Infallible;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use diagnostics::counted;
use explorer::{Limits, Order, Outcome, Progress, Reduction};
use scenarios::Error;
use scenarios::scenario::ProofOutcome;

use super::{Answer, Mutant, Proof, Question};

/// The result for a mutant.
#[derive(Clone, Debug)]
pub enum Fate {
    /// These properties are violated; those that were not decided soon are not examined any further.
    Killed(Vec<String>, Vec<OpenProperty>),
    /// It does not fit into the scenario, for this reason.
    Misfit(String),
    /// It acts differently, but no property detects it.
    Survives,
    /// Under the assumptions, it never acts differently.
    ChangesNothing,
    /// These properties are not decided, and none is violated.
    Undecided(Vec<OpenProperty>),
}

/// A property that is not decided.
#[derive(Clone, Debug)]
pub struct OpenProperty {
    /// Its name.
    pub property: String,
    /// How many states were explored, and to what depth; or why none were.
    pub reason: String,
    /// Whether more memory may decide it.
    is_full: bool,
}

impl Fate {
    /// It in a word or two.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Killed(..) => "killed",
            Self::Misfit(_) => "does not fit",
            Self::Survives => "survives",
            Self::ChangesNothing => "changes nothing",
            Self::Undecided(_) => "not decided",
        }
    }

    /// The properties that are not decided.
    #[must_use]
    pub fn open(&self) -> &[OpenProperty] {
        match self {
            Self::Killed(_, open) | Self::Undecided(open) => open,
            Self::Misfit(_) | Self::Survives | Self::ChangesNothing => &[],
        }
    }
}

impl Proof {
    /// Proves the properties about each mutant, on all threads, until it is stopped. `progress` gets the number of
    /// mutants whose fate is known, and that of all.
    ///
    /// # Errors
    /// As [`prove`](Self::prove), about the scenario as it is, and as [`mutants`](Self::mutants).
    pub fn fates(&self, limits: &Limits, mut progress: impl FnMut(usize, usize)) -> Result<Vec<(Mutant, Fate)>, Error> {
        let mutants = self.mutants()?;
        let threads = limits.threads;
        // There are many mutants, so those that are not decided within these limits are left open.
        let memory = limits.memory / threads.max(4);
        let limits = Limits { threads: 1, memory, reduction: Reduction::Off, ..limits.clone() };
        // The answers about the scenario as it is, which hold for each mutant that never acts differently.
        let sound = |question| {
            let answer = self.prove(question, &limits, &mut |_| ())?;
            let is_proved = answer.outcome() == Some(ProofOutcome::Proved);
            Ok(is_proved.then(|| Mutex::new(answer)))
        };
        let sound = self.mutant_questions().map(sound).collect::<Result<Vec<_>, Error>>()?;
        let never = AtomicBool::new(false);
        let mut fates = Vec::with_capacity(mutants.len());
        let Ok(()) = batch::in_order(
            0..mutants.len() as u64,
            threads,
            limits.stop.unwrap_or(&never),
            |index| fate(self, &sound, &mutants[index as usize], &limits),
            |_, fate| {
                fates.push(fate);
                progress(fates.len(), mutants.len());
                Ok::<bool, Infallible>(true)
            },
        );
        Ok(mutants.into_iter().zip(fates).collect())
    }
}

fn fate(proof: &Proof, sound: &[Option<Mutex<Answer>>], mutant: &Mutant, limits: &Limits) -> Fate {
    let about = match proof.about(mutant) {
        Ok(about) => about,
        Err(error) => return Fate::Misfit(error.to_string()),
    };
    let differs = |(_, sound): &(&Question, &Option<Mutex<Answer>>)| {
        let mut sound = sound.as_ref().map(|answer| answer.lock().unwrap_or_else(PoisonError::into_inner));
        !sound.as_mut().is_some_and(|answer| about.is_like(proof, mutant, answer))
    };
    let questions = about.mutant_questions().zip(sound).filter(differs);
    let mut questions: Vec<&Question> = questions.map(|(question, _)| question).collect();
    if questions.is_empty() {
        return Fate::ChangesNothing;
    }
    let (mut killed_by, mut undecided) = (Vec::new(), Vec::new());
    // Only properties that had too little memory are tried again, and only if no other has killed the mutant.
    for effort in [Effort::Little, Effort::Full] {
        let mut full = Vec::new();
        for question in questions {
            match outcome(&about, question, effort, limits) {
                Ok(ProofOutcome::Proved) => {}
                Ok(ProofOutcome::Violated) => killed_by.push(question.property.clone()),
                Err(open) if open.is_full && effort == Effort::Little => full.push((question, open)),
                Err(open) => undecided.push(open),
            }
        }
        if !killed_by.is_empty() {
            undecided.extend(full.into_iter().map(|(_, open)| open));
            return Fate::Killed(killed_by, undecided);
        }
        questions = full.into_iter().map(|(question, _)| question).collect();
    }
    if undecided.is_empty() { Fate::Survives } else { Fate::Undecided(undecided) }
}

/// How much memory a proof about a mutant may take. A single property is enough to kill it, so all of them are tried
/// with little before any is tried with more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effort {
    Little,
    Full,
}

/// Whether a mutant violates a property, or why this is not decided.
///
/// Violations that take many steps, such as missed deadlines, are soon found depth first; most of the others are
/// decided within the first states. But a depth-first search finds long runs: if no battery can have the levels of such
/// a run, or messages pile up in it, that proves nothing about shorter runs.
fn outcome(about: &Proof, question: &Question, effort: Effort, limits: &Limits) -> Result<ProofOutcome, OpenProperty> {
    let memory = if effort == Effort::Little { limits.memory / 4 } else { limits.memory };
    let open = |reason, is_full| OpenProperty { property: question.property.clone(), reason, is_full };
    let search = |order| {
        let answer = about.prove(question, &Limits { order, memory, ..limits.clone() }, &mut |_| ());
        let answer = answer.map_err(|error| open(error.reasons(), false))?;
        let is_full = answer.limit().is_some();
        answer.outcome().ok_or_else(|| open(undecided(&answer), is_full))
    };
    match search(Order::Depth) {
        Err(open) if !open.is_full || effort == Effort::Little => search(Order::Breadth),
        outcome => outcome,
    }
}

fn undecided(answer: &Answer) -> String {
    let Progress { states, depth, .. } = answer.exploration.progress;
    match answer.exploration.outcome {
        _ if answer.is_spurious => "no battery can have the levels of the run".to_owned(),
        Outcome::Endless(_) => "messages pile up without end".to_owned(),
        _ => format!("explored {} to depth {depth}", counted(states, "state")),
    }
}
