//! Whether another process, in place of one that was explored, would do the same in every run.

use std::collections::HashSet;

use channels::{NormalForm, Process, ProcessId, TickGenerator};

use crate::error::Refused;
use crate::local::{Local, REFUSED, Step, UNKNOWN, entry};
use crate::search::Exploration;
use crate::tables::{ENDLESS, Gap, Tables, same_number};

impl Exploration {
    /// Whether another process could take the place of this one: in every run that was explored, it offers the same
    /// communications at the same times. If everything was explored, the outcome is the same with it.
    ///
    /// Both processes take the same steps side by side, from their initial states through all states that were found of
    /// the one (a bisimulation, limited to what its surroundings ask of it). The answer is also no if this cannot
    /// be known, because the environment drives the process.
    pub fn allows(&mut self, id: ProcessId, substitute: Box<dyn Process>) -> bool {
        self.tables.allow(id.index(), substitute).unwrap_or(false)
    }
}

impl Tables {
    fn allow(&mut self, process: usize, substitute: Box<dyn Process>) -> Result<bool, Refused> {
        if self.driven.contains(&process) || substitute.as_any().is::<TickGenerator>() {
            return Ok(false);
        }
        self.onlooker = None;
        let known = self.locals[process].len();
        let answer = self.walk(process, substitute);
        self.locals[process].truncate(known);
        answer
    }

    fn walk(&mut self, process: usize, mut substitute: Box<dyn Process>) -> Result<bool, Refused> {
        let form = NormalForm::new(&self.topology, NormalForm::NOW, &same_number);
        substitute.normalize(&form).map_err(|why| self.refused(process, why))?;
        // The first state stored is the initial one.
        let mut open = vec![(0, self.local(process, substitute)?)];
        let mut seen: HashSet<(u32, u32)> = open.iter().copied().collect();
        while let Some((state, other)) = open.pop() {
            let [one, another] = [state, other].map(|state| self.locals[process].get(state));
            if !one.offers_the_same(another) {
                return Ok(false);
            }
            for (gap, step) in self.steps(process, state, other) {
                self.fill(&gap)?;
                let same = self.step(&gap);
                let [ends, also_ends] = [step, same].map(|step| [REFUSED, ENDLESS].contains(&step.next));
                if step.renaming != same.renaming || (ends || also_ends) && step != same {
                    return Ok(false);
                }
                if !ends && seen.insert((step.next, same.next)) {
                    open.push((step.next, same.next));
                }
            }
        }
        Ok(true)
    }

    /// The steps known from a state of a process, each with the same step from another of its states.
    fn steps(&self, process: usize, from: u32, state: u32) -> Vec<(Gap, Step)> {
        let local = self.locals[process].get(from);
        let own = local.own.iter().enumerate().map(|(own, it)| (Gap::Own { process, state, own }, it.step));
        let receives = local.receives.iter().enumerate().flat_map(|(receive, it)| {
            (0..).zip(&it.steps).map(move |(content, step)| (Gap::Receive { process, state, receive, content }, *step))
        });
        let later = (0..).zip(&local.later);
        let later = later.map(|(span, step)| (Gap::Later { process, state, span: *self.spans.get(span) }, *step));
        let renamed = (0..).zip(&local.renamed).map(|(renaming, next)| {
            (Gap::RenamedProcess { process, state, renaming }, Step { next: *next, renaming: 0 })
        });
        let all = own.chain(receives).chain(later).chain(renamed);
        all.filter(|(_, step)| step.next != UNKNOWN).collect()
    }

    /// A step that is known.
    fn step(&self, gap: &Gap) -> Step {
        let local = |process: usize, state| self.locals[process].get(state);
        match *gap {
            Gap::Own { process, state, own } => local(process, state).own[own].step,
            Gap::Receive { process, state, receive, content } => {
                entry(&local(process, state).receives[receive].steps, content, Step::UNKNOWN)
            }
            Gap::Later { process, state, span } => {
                let span = self.spans.find_value(&span);
                span.map_or(Step::UNKNOWN, |span| entry(&local(process, state).later, span, Step::UNKNOWN))
            }
            Gap::RenamedProcess { process, state, renaming } => {
                Step { next: entry(&local(process, state).renamed, renaming, UNKNOWN), renaming: 0 }
            }
            _ => Step::UNKNOWN,
        }
    }
}

impl Local {
    fn offers_the_same(&self, other: &Self) -> bool {
        let mut own = self.own.iter().zip(&other.own);
        let mut receives = self.receives.iter().zip(&other.receives);
        self.timer == other.timer
            && (!self.is_timeless || other.is_timeless)
            && self.own.len() == other.own.len()
            && own.all(|(one, other)| one.sends == other.sends)
            && self.receives.len() == other.receives.len()
            && receives.all(|(one, other)| (one.channel, &one.pattern) == (other.channel, &other.pattern))
    }
}
