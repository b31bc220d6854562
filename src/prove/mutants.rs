//! `steward prove --mutants`: which property notices which mistake in a skill or in the tree.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use campaigns::Error;
use explorer::{Limits, Order, Outcome, Progress, Reduction};
use reports::junit::{Case, CaseResult, Suite};
use scenarios::prove::{Answer, Mutant, Proof, Question, Subject};
use scenarios::scenario::ProofOutcome;
use serde_json::{Value, json};

use crate::output::{BAD, GOOD, HEAD, OPEN, Text};
use crate::progress::Bar;

/// The results for the mutants of a scenario.
pub(super) struct Mutants {
    proof: Proof,
    mutants: Vec<(Mutant, Fate)>,
}

/// The result for a mutant.
enum Fate {
    /// These properties are violated.
    Killed(Vec<String>),
    /// It does not fit into the scenario, for this reason.
    Misfit(String),
    /// It acts differently, but no property notices.
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
}

impl Fate {
    fn word(&self) -> &'static str {
        match self {
            Self::Killed(_) => "killed",
            Self::Misfit(_) => "does not fit",
            Self::Survives => "survives",
            Self::ChangesNothing => "changes nothing",
            Self::Undecided(_) => "not decided",
        }
    }
}

/// Whether a mutant can violate it. A property that is violated anyway says nothing about mutants, nor does one about
/// what is never reached.
fn counts(question: &&Question) -> bool {
    question.expected == ProofOutcome::Proved && question.subject != Subject::AllReached
}

impl Mutants {
    /// Proves the properties about each mutant, on all cores, until it is stopped.
    pub(super) fn of(proof: Proof, limits: &Limits, silent: bool, stop: &AtomicBool) -> Result<Self, Error> {
        let mutants = proof.mutants()?;
        let threads = limits.threads;
        // There are many mutants, so those that are not decided within these limits are left open. Nobody looks at
        // their runs.
        let memory = limits.memory / threads.max(4);
        let limits = Limits { threads: 1, memory, reduction: Reduction::Off, ..limits.clone() };
        // The answers about the scenario as it is, which hold for each mutant that never acts differently.
        let sound = |question| {
            let answer = proof.prove(question, &limits, &mut |_| ())?;
            let is_proved = answer.outcome() == Some(ProofOutcome::Proved);
            Ok(is_proved.then(|| Mutex::new(answer)))
        };
        let sound = proof.questions().iter().filter(counts).map(sound).collect::<Result<Vec<_>, Error>>()?;
        let bar = Bar::new(silent, "mutants");
        let mut fates = Vec::with_capacity(mutants.len());
        batch::in_order(
            0..mutants.len() as u64,
            threads,
            stop,
            |index| fate(&proof, &sound, &mutants[index as usize], &limits),
            |_, fate| {
                fates.push(fate);
                bar.show(fates.len(), mutants.len());
                Ok::<bool, Error>(true)
            },
        )?;
        bar.finish();
        Ok(Self { proof, mutants: mutants.into_iter().zip(fates).collect() })
    }

    /// A table, and the mutants that survive.
    pub(super) fn in_words(&self) -> Text {
        // Writing to a string cannot fail.
        let mut text = Text::from("\n  ");
        let mut rows: BTreeMap<(bool, &str), [usize; 5]> = BTreeMap::new();
        let mut killers: BTreeMap<&str, usize> = BTreeMap::new();
        for (mutant, fate) in &self.mutants {
            let row = rows.entry((mutant.skill().is_none(), place(mutant))).or_default();
            row[0] += 1;
            match fate {
                Fate::Killed(by) => {
                    row[1] += 1;
                    by.iter().for_each(|property| *killers.entry(property).or_default() += 1);
                }
                Fate::Misfit(_) => row[1] += 1,
                Fate::ChangesNothing => row[2] += 1,
                Fate::Survives => row[3] += 1,
                Fate::Undecided(_) => row[4] += 1,
            }
        }
        let width = rows.keys().map(|(_, name)| name.chars().count()).fold(10, usize::max);
        let line = |name: &str, [all, killed, same, survive, open]: [&str; 5]| {
            format!("{name:<width$}  {all:>5}  {killed:>6}  {same:>14}  {survive:>7}  {open:>11}")
        };
        let titles = line("mutants of", ["all", "killed", "change nothing", "survive", "not decided"]);
        text.paint(HEAD, &titles, 0);
        let _ = writeln!(text);
        let counts = |row: [usize; 5]| row.map(|count| count.to_string());
        let mut sum = [0; 5];
        for ((_, name), row) in rows {
            let _ = writeln!(text, "  {}", line(name, counts(row).each_ref().map(String::as_str)));
            sum.iter_mut().zip(row).for_each(|(sum, count)| *sum += count);
        }
        let _ = writeln!(text, "  {}\n", line("all", counts(sum).each_ref().map(String::as_str)));
        let misfits = self.mutants.iter().filter(|(_, fate)| matches!(fate, Fate::Misfit(_))).count();
        let mut killers: Vec<String> = killers.iter().map(|(name, count)| format!("{name} {count}")).collect();
        killers.extend((misfits > 0).then(|| format!("before anything runs {misfits}")));
        let _ = writeln!(text, "killed by: {}", killers.join(", "));
        for (title, style, wanted) in [("survives", BAD, "survives"), ("not decided", OPEN, "not decided")] {
            let such: Vec<&(Mutant, Fate)> = self.mutants.iter().filter(|(_, fate)| fate.word() == wanted).collect();
            if such.is_empty() {
                continue;
            }
            let _ = writeln!(text);
            text.paint(style, title, 0);
            let _ = writeln!(text);
            for (mutant, fate) in such {
                let _ = writeln!(text, "  {}", in_words(mutant));
                let open = if let Fate::Undecided(open) = fate { open.as_slice() } else { &[] };
                for Open { property, reason } in open {
                    let _ = writeln!(text, "    {property}: {reason}");
                }
            }
        }
        if sum[3] + sum[4] == 0 {
            text.paint(GOOD, "no mutant survives", 0);
            let _ = writeln!(text);
        }
        text
    }

    pub(super) fn as_json(&self) -> Value {
        let of = |(mutant, fate): &(Mutant, Fate)| {
            let killed_by: &[String] = if let Fate::Killed(by) = fate { by } else { &[] };
            let open = if let Fate::Undecided(open) = fate { open.as_slice() } else { &[] };
            let undecided: Vec<&str> = open.iter().map(|open| open.property.as_str()).collect();
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
            "assumptions": self.proof.assumptions(),
            "properties": properties.collect::<Vec<_>>(),
            "mutants": self.mutants.iter().map(of).collect::<Vec<_>>(),
        })
    }

    /// One test case per mutant. Mutants that survive are left out: their mistakes may change nothing.
    pub(super) fn suite(&self) -> Suite {
        let case = |(mutant, fate): &(Mutant, Fate)| Case {
            group: "mutants",
            name: in_words(mutant),
            result: match fate {
                Fate::Killed(_) | Fate::Misfit(_) => CaseResult::Passed,
                Fate::Survives | Fate::ChangesNothing | Fate::Undecided(_) => {
                    CaseResult::Skipped(fate.word().to_owned())
                }
            },
        };
        let facts = vec![
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("assumptions", self.proof.assumptions().join(" ")),
        ];
        Suite::new(&self.proof.scenario().name, facts, self.mutants.iter().map(case).collect())
    }
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
    let (mut killed_by, mut undecided) = (Vec::new(), Vec::new());
    let mut changes_nothing = true;
    for (question, sound) in about.questions().iter().filter(counts).zip(sound) {
        let mut sound = sound.as_ref().map(|answer| answer.lock().unwrap_or_else(PoisonError::into_inner));
        if sound.as_mut().is_some_and(|answer| about.is_like(proof, mutant, answer)) {
            continue;
        }
        drop(sound);
        changes_nothing = false;
        match outcome(&about, question, limits) {
            Ok(ProofOutcome::Proved) => {}
            Ok(ProofOutcome::Violated) => killed_by.push(question.property.clone()),
            Err(reason) => undecided.push(Open { property: question.property.clone(), reason }),
        }
    }
    match (killed_by.as_slice(), undecided.as_slice()) {
        ([], []) if changes_nothing => Fate::ChangesNothing,
        ([], []) => Fate::Survives,
        ([], _) => Fate::Undecided(undecided),
        _ => Fate::Killed(killed_by),
    }
}

/// Whether a mutant violates a property, or why this is not decided.
///
/// Violations that take many steps, such as missed deadlines, are soon found depth first; most of the others are
/// decided within the first states. But a depth-first search finds long runs: if no battery can have the levels of such
/// a run, or messages pile up in it, that says nothing about shorter runs.
fn outcome(about: &Proof, question: &Question, limits: &Limits) -> Result<ProofOutcome, String> {
    let search = |order, share| Limits { order, memory: limits.memory / share, ..limits.clone() };
    let mut reason = String::new();
    for (limits, is_last) in [
        (search(Order::Depth, 16), (|_| false) as fn(bool) -> bool),
        (search(Order::Breadth, 16), |is_full| !is_full),
        (search(Order::Depth, 1), |is_full| is_full),
        (search(Order::Breadth, 1), |_| true),
    ] {
        let answer = about.prove(question, &limits, &mut |_| ()).map_err(|error| error.reasons())?;
        if let Some(outcome) = answer.outcome() {
            return Ok(outcome);
        }
        reason = undecided(&answer);
        if is_last(matches!(answer.exploration.outcome, Outcome::Undecided)) {
            break;
        }
    }
    Err(reason)
}

fn undecided(answer: &Answer) -> String {
    let Progress { states, depth, .. } = answer.exploration.progress;
    match answer.exploration.outcome {
        _ if answer.is_spurious => "no battery can have the levels of the run".to_owned(),
        Outcome::Endless(_) => "messages pile up without end".to_owned(),
        _ => format!("explored {states} states to depth {depth}"),
    }
}
