//! Mutants: scenarios with one mistake in a skill or in the tree.

use std::sync::Arc;

use bt::Tree;
use scenarios::scenario::{Behavior, ProofOutcome};
use scenarios::{Complaints, Error};
use skills::{Chart, SkillProcess, mutate, mutations};

use super::{Answer, Proof, Question, Subject, thresholds};

/// One mistake in a skill or in the tree.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// The mistake, in words.
    pub words: String,
    part: MutatedPart,
}

#[derive(Clone, Debug)]
enum MutatedPart {
    Skill(String, Arc<Chart>),
    Tree(Arc<Tree>),
}

impl Mutant {
    /// The skill with the mistake; `None` if it is in the tree.
    #[must_use]
    pub fn skill(&self) -> Option<&str> {
        match &self.part {
            MutatedPart::Skill(name, _) => Some(name),
            MutatedPart::Tree(_) => None,
        }
    }
}

impl Proof {
    /// All single mistakes in the tree and in the skills; the latter are those of the fault `skill_mutant`.
    ///
    /// # Errors
    /// [`Error::BadInput`] if a machine of a skill cannot be changed.
    pub fn mutants(&self) -> Result<Vec<Mutant>, Error> {
        let mut mutants = Vec::new();
        for (name, skill) in &self.scenario.skills {
            let file = skill.machine.file();
            for mistake in mutations(file.name(), file.text()).map_err(Error::bad_input)? {
                let text = mutate(file.name(), file.text(), &mistake).map_err(Error::bad_input)?;
                let chart = Chart::load(&format!("{} ({mistake})", file.name()), &text).map_err(Error::bad_input)?;
                mutants.push(Mutant { words: mistake.to_string(), part: MutatedPart::Skill(name.clone(), chart) });
            }
        }
        let of_tree = self.scenario.tree().into_iter().flat_map(|tree| bt::mutants(tree));
        let mutant = |bt::Mutant { words, tree }| Mutant { words, part: MutatedPart::Tree(Arc::new(tree)) };
        mutants.extend(of_tree.map(mutant));
        Ok(mutants)
    }

    /// The properties that a mutant may violate. One that is violated anyway shows nothing about mutants, nor does one
    /// about what is never reached.
    pub fn mutant_questions(&self) -> impl Iterator<Item = &Question> {
        let may = |it: &&Question| it.expected == ProofOutcome::Proved && it.subject != Subject::AllReached;
        self.questions.iter().filter(may)
    }

    /// The proof of the same properties for a mutant.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the mutant does not fit into the scenario, which is noticed before anything runs.
    pub fn about(&self, mutant: &Mutant) -> Result<Self, Error> {
        match &mutant.part {
            MutatedPart::Skill(name, chart) => self.with_machine(name, chart),
            MutatedPart::Tree(tree) => self.with_tree(tree),
        }
    }

    /// The channels stay as they are, so the prepared system is used again.
    fn with_machine(&self, name: &str, chart: &Arc<Chart>) -> Result<Self, Error> {
        let mut scenario = (*self.scenario).clone();
        let skill = scenario.skills.get_mut(name).expect("it is a skill of the scenario");
        skill.machine = Arc::clone(chart);
        let topology = self.system.topology();
        let process = SkillProcess::new(name, chart, topology, skill.data_of(chart)).map_err(Error::bad_input)?;
        let id = topology.find_process(name).expect("every skill is a process");
        let mut system = self.system.fork();
        system.replace(id, Box::new(process)).map_err(|error| Error::refused(error.to_string(), "report it"))?;
        let mut complaints = Complaints::default();
        let thresholds = if self.thresholds.is_empty() {
            self.thresholds.clone()
        } else {
            thresholds::of_machines(&scenario, &mut complaints)
        };
        complaints.check()?;
        Ok(Self {
            scenario: Arc::new(scenario),
            system,
            ids: self.ids,
            monitoring: Arc::clone(&self.monitoring),
            thresholds,
            damaged: self.damaged.clone(),
            faults: self.faults.clone(),
            truths: self.truths.clone(),
            left_out: self.left_out.clone(),
            questions: self.questions.clone(),
        })
    }

    /// The tree may lack leaves, and with them channels: everything is prepared anew.
    fn with_tree(&self, tree: &Arc<Tree>) -> Result<Self, Error> {
        let mut scenario = (*self.scenario).clone();
        scenario.skills.retain(|name, _| tree.leaves().any(|leaf| leaf.process() == name));
        scenario.behavior = Behavior::Tree(Arc::clone(tree));
        let only: Vec<String> = self.questions.iter().map(|question| question.property.clone()).collect();
        Self::new(Arc::new(scenario), &only)
    }

    /// Whether this proof, which is about a mutant, has the same answer as the original: nothing that was explored for
    /// the original reaches the mistake, or shows its effect. Only mistakes in skills are compared.
    #[must_use]
    pub fn is_like(&self, original: &Self, mutant: &Mutant, answer: &mut Answer) -> bool {
        let MutatedPart::Skill(name, _) = &mutant.part else { return false };
        let id = self.system.topology().find_process(name);
        let process = id.and_then(|id| Some((id, self.system.clone_process(id)?)));
        self.thresholds == original.thresholds
            && process.is_some_and(|(id, process)| answer.exploration.allows(id, process))
    }
}
