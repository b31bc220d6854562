//! `steward prove --mutants`: which property detects which mistake in a skill or in the tree.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use anstyle::Style;
use campaigns::Error;
use diagnostics::counted;
use explorer::{Limits, Order, Outcome, Progress, Reduction};
use proofs::{Answer, Mutant, Proof, Question, Subject};
use reports::results::{Case, CaseResult, Suite};
use scenarios::scenario::ProofOutcome;
use serde_json::{Value, json};

use super::violation::words;
use crate::output::{BAD, GOOD, HEAD, OPEN, Text};
use crate::progress::CountProgress;
use crate::results::{on_disk, places};

/// The results for the mutants of a scenario.
pub(super) struct Mutants {
    proof: Proof,
    mutants: Vec<(Mutant, Fate)>,
    /// Why there are none, if an error has left them out.
    unsearched: Option<String>,
}

/// The result for a mutant.
enum Fate {
    /// These properties are violated; those that were not decided soon are not examined any further.
    Killed(Vec<String>, Vec<Open>),
    /// It does not fit into the scenario, for this reason.
    Misfit(String),
    /// It acts differently, but no property detects it.
    Survives,
    /// Under the assumptions, it never acts differently.
    ChangesNothing,
    /// These properties are not decided, and none is violated.
    Undecided(Vec<Open>),
}

/// A property that is not decided.
struct Open {
    property: String,
    /// How many states were explored, and to what depth; or why none were.
    reason: String,
    /// Whether more memory may decide it.
    is_full: bool,
}

impl Fate {
    fn word(&self) -> &'static str {
        match self {
            Self::Killed(..) => "killed",
            Self::Misfit(_) => "does not fit",
            Self::Survives => "survives",
            Self::ChangesNothing => "changes nothing",
            Self::Undecided(_) => "not decided",
        }
    }

    /// Its column in the table, after the name and the number of all.
    fn column(&self) -> usize {
        match self {
            Self::Killed(..) | Self::Misfit(_) => 1,
            Self::ChangesNothing => 2,
            Self::Survives => 3,
            Self::Undecided(_) => 4,
        }
    }

    /// The properties that are not decided.
    fn open(&self) -> &[Open] {
        match self {
            Self::Killed(_, open) | Self::Undecided(open) => open,
            Self::Misfit(_) | Self::Survives | Self::ChangesNothing => &[],
        }
    }
}

/// Whether a mutant can violate it. A property that is violated anyway says nothing about mutants, nor does one about
/// what is never reached.
fn counts(question: &&Question) -> bool {
    question.expected == ProofOutcome::Proved && question.subject != Subject::AllReached
}

impl Mutants {
    /// Proves the properties about each mutant, on all cores, until it is stopped. Also returns the error that has left
    /// the mutants out, if there is one.
    pub(super) fn of(proof: Proof, limits: &Limits, silent: bool, stop: &AtomicBool) -> (Self, Option<Error>) {
        match search(&proof, limits, silent, stop) {
            Ok(mutants) => (Self { proof, mutants, unsearched: None }, None),
            Err(error) => (Self::none(proof, error.reasons()), Some(error)),
        }
    }

    /// Those of a scenario whose mutants were not searched, and why.
    pub(super) fn none(proof: Proof, why: String) -> Self {
        Self { proof, mutants: Vec::new(), unsearched: Some(why) }
    }

    /// A table, and the mutants that survive.
    pub(super) fn in_words(&self) -> Text {
        let mut text = Text::from("\n  ");
        self.write_table(&mut text);
        self.write_killers(&mut text);
        for (title, style) in [("survives", BAD), ("not decided", OPEN)] {
            self.write_list(&mut text, title, style);
        }
        if self.mutants.iter().all(|(_, fate)| !matches!(fate, Fate::Survives | Fate::Undecided(_))) {
            text.paint(GOOD, "no mutant survives", 0);
            text += "\n";
        }
        text
    }

    /// How many mutants of each skill and of the tree have which fate.
    fn write_table(&self, text: &mut Text) {
        let mut rows: BTreeMap<(bool, &str), [usize; 5]> = BTreeMap::new();
        for (mutant, fate) in &self.mutants {
            // The tree comes last.
            let row = rows.entry((mutant.skill().is_none(), place(mutant))).or_default();
            row[0] += 1;
            row[fate.column()] += 1;
        }
        let width = rows.keys().map(|(_, name)| name.chars().count()).fold(10, usize::max);
        let line = |name: &str, [all, killed, same, survive, open]: [&str; 5]| {
            format!("{name:<width$}  {all:>5}  {killed:>6}  {same:>14}  {survive:>7}  {open:>11}")
        };
        let titles = line("mutants of", ["all", "killed", "change nothing", "survive", "not decided"]);
        text.paint(HEAD, &titles, 0);
        *text += "\n";
        let counts = |row: [usize; 5]| row.map(|count| count.to_string());
        let mut sum = [0; 5];
        for ((_, name), row) in rows {
            *text += format!("  {}\n", line(name, counts(row).each_ref().map(String::as_str)));
            sum.iter_mut().zip(row).for_each(|(sum, count)| *sum += count);
        }
        *text += format!("  {}\n\n", line("all", counts(sum).each_ref().map(String::as_str)));
    }

    /// How many mutants each property detects. A mutant may be detected by several.
    fn write_killers(&self, text: &mut Text) {
        let mut killers: BTreeMap<&str, usize> = BTreeMap::new();
        let mut misfits = 0;
        for (_, fate) in &self.mutants {
            match fate {
                Fate::Killed(by, _) => by.iter().for_each(|property| *killers.entry(property).or_default() += 1),
                Fate::Misfit(_) => misfits += 1,
                Fate::Survives | Fate::ChangesNothing | Fate::Undecided(_) => {}
            }
        }
        let mut killers: Vec<String> = killers.iter().map(|(name, count)| format!("{name} {count}")).collect();
        killers.extend((misfits > 0).then(|| format!("before anything runs {misfits}")));
        *text += format!("killed by: {}\n", killers.join(", "));
    }

    /// The mutants of a fate, with what is open about each; nothing if there are none.
    fn write_list(&self, text: &mut Text, fate: &str, style: Style) {
        let such: Vec<&(Mutant, Fate)> = self.mutants.iter().filter(|(_, of)| of.word() == fate).collect();
        if such.is_empty() {
            return;
        }
        *text += "\n";
        text.paint(style, fate, 0);
        *text += "\n";
        for (mutant, fate) in such {
            *text += format!("  {}\n", in_words(mutant));
            for Open { property, reason, .. } in fate.open() {
                *text += format!("    {property}: {reason}\n");
            }
        }
    }

    pub(super) fn as_json(&self) -> Value {
        let of = |(mutant, fate): &(Mutant, Fate)| {
            let killed_by: &[String] = if let Fate::Killed(by, _) = fate { by } else { &[] };
            let undecided: Vec<&str> = fate.open().iter().map(|open| open.property.as_str()).collect();
            let reason = if let Fate::Misfit(reason) = fate { Some(reason) } else { None };
            json!({
                "skill": mutant.skill(),
                "mutant": mutant.words,
                "result": fate.word(),
                "killed_by": killed_by,
                "not_decided": undecided,
                "reason": reason,
            })
        };
        let properties = self.proof.questions().iter().filter(counts).map(|question| &question.property);
        json!({
            "scenario": self.proof.scenario().name,
            "version": env!("CARGO_PKG_VERSION"),
            "provenance": self.proof.scenario().origin.provenance(recording::commit()),
            "assumptions": words(&self.proof.assumptions()),
            "properties": properties.collect::<Vec<_>>(),
            "mutants": self.mutants.iter().map(of).collect::<Vec<_>>(),
            "not_searched": self.unsearched,
        })
    }

    /// One test case per mutant. Mutants that survive are left out: their mistakes may change nothing.
    pub(super) fn suite(&self) -> Suite {
        let case = |(mutant, fate): &(Mutant, Fate)| Case {
            group: "mutants",
            name: in_words(mutant),
            found: fate.word().to_owned(),
            result: match fate {
                Fate::Killed(..) | Fate::Misfit(_) => CaseResult::Passed,
                Fate::Survives | Fate::ChangesNothing | Fate::Undecided(_) => {
                    CaseResult::Skipped(fate.word().to_owned())
                }
            },
            ..Case::default()
        };
        let unsearched = self.unsearched.as_ref().map(|reason| Case {
            group: "mutants",
            name: "mutants are searched".to_owned(),
            found: "not searched".to_owned(),
            result: CaseResult::Error(reason.clone()),
            ..Case::default()
        });
        Suite {
            name: self.proof.scenario().name.clone(),
            provenance: Some(self.proof.scenario().origin.provenance(recording::commit())),
            notes: words(&self.proof.assumptions()),
            cases: self.mutants.iter().map(case).chain(unsearched).collect(),
            file: places(self.proof.scenario()).file,
            ..Suite::default()
        }
        .with_paths(on_disk(&[&self.proof.scenario().origin.argument]))
    }
}

/// The fate of each mutant, until it is stopped.
fn search(proof: &Proof, limits: &Limits, silent: bool, stop: &AtomicBool) -> Result<Vec<(Mutant, Fate)>, Error> {
    let mutants = proof.mutants()?;
    let threads = limits.threads;
    // There are many mutants, so those that are not decided within these limits are left open. Nobody looks at their
    // runs.
    let memory = limits.memory / threads.max(4);
    let limits = Limits { threads: 1, memory, reduction: Reduction::Off, ..limits.clone() };
    // The answers about the scenario as it is, which hold for each mutant that never acts differently.
    let sound = |question| {
        let answer = proof.prove(question, &limits, &mut |_| ())?;
        let is_proved = answer.outcome() == Some(ProofOutcome::Proved);
        Ok(is_proved.then(|| Mutex::new(answer)))
    };
    let sound = proof.questions().iter().filter(counts).map(sound).collect::<Result<Vec<_>, Error>>()?;
    let bar = CountProgress::new(silent, "mutants").or_lines(silent);
    let mut fates = Vec::with_capacity(mutants.len());
    batch::in_order(
        0..mutants.len() as u64,
        threads,
        stop,
        |index| fate(proof, &sound, &mutants[index as usize], &limits),
        |_, fate| {
            fates.push(fate);
            bar.show(fates.len(), mutants.len());
            Ok::<bool, Error>(true)
        },
    )?;
    Ok(mutants.into_iter().zip(fates).collect())
}

fn place(mutant: &Mutant) -> &str {
    mutant.skill().unwrap_or("the tree")
}

/// The mistake as the fault `skill_mutant` names it.
fn in_words(mutant: &Mutant) -> String {
    format!("{}: {}", place(mutant), mutant.words)
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
    let questions = about.questions().iter().filter(counts).zip(sound).filter(differs);
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
/// a run, or messages pile up in it, that says nothing about shorter runs.
fn outcome(about: &Proof, question: &Question, effort: Effort, limits: &Limits) -> Result<ProofOutcome, Open> {
    let memory = if effort == Effort::Little { limits.memory / 4 } else { limits.memory };
    let open = |reason, is_full| Open { property: question.property.clone(), reason, is_full };
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
