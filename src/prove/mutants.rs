//! `steward prove --mutants`: which property detects which mistake in a skill or in the tree.

use std::collections::BTreeMap;

use anstyle::Style;
use campaigns::Error;
use explorer::Limits;
use proofs::{Fate, Mutant, OpenProperty, Proof};
use reports::results::{Case, CaseResult, Suite};
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

/// Its column in the table, after the name and the number of all.
fn column(fate: &Fate) -> usize {
    match fate {
        Fate::Killed(..) | Fate::Misfit(_) => 1,
        Fate::ChangesNothing => 2,
        Fate::Survives => 3,
        Fate::Undecided(_) => 4,
    }
}

impl Mutants {
    /// Proves the properties about each mutant, on all cores, until it is stopped. Also returns the error that has left
    /// the mutants out, if there is one.
    pub(super) fn of(proof: Proof, limits: &Limits, silent: bool) -> (Self, Option<Error>) {
        let bar = CountProgress::new(silent, "mutants").or_lines(silent);
        match proof.fates(limits, |done, all| bar.show(done, all)) {
            Ok(mutants) => (Self { proof, mutants, unsearched: None }, None),
            Err(error) => (Self::none(proof, error.reasons()), Some(error.into())),
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
            row[column(fate)] += 1;
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
        let such: Vec<&(Mutant, Fate)> = self.mutants.iter().filter(|(_, of)| of.name() == fate).collect();
        if such.is_empty() {
            return;
        }
        *text += "\n";
        text.paint(style, fate, 0);
        *text += "\n";
        for (mutant, fate) in such {
            *text += format!("  {}\n", in_words(mutant));
            for OpenProperty { property, reason, .. } in fate.open() {
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
                "result": fate.name(),
                "killed_by": killed_by,
                "not_decided": undecided,
                "reason": reason,
            })
        };
        let properties = self.proof.mutant_questions().map(|question| &question.property);
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
            found: fate.name().to_owned(),
            result: match fate {
                Fate::Killed(..) | Fate::Misfit(_) => CaseResult::Passed,
                Fate::Survives | Fate::ChangesNothing | Fate::Undecided(_) => {
                    CaseResult::Skipped(fate.name().to_owned())
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

fn place(mutant: &Mutant) -> &str {
    mutant.skill().unwrap_or("the tree")
}

/// The mistake as the fault `skill_mutant` names it.
fn in_words(mutant: &Mutant) -> String {
    format!("{}: {}", place(mutant), mutant.words)
}
