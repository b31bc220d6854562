//! A machine of a model: an `.ascxml` file, for a ROS node or as the plugin for a leaf of the tree.

mod declarations;
mod expression;
mod kind;
mod plain;
mod port;
mod translate;
mod vocabulary;
mod xml;

use std::collections::BTreeMap;
use std::sync::Arc;

use diagnostics::{Problem, Source};
use roxmltree::Node;
use skills::{Chart, SkillError};

pub(crate) use declarations::{Interface, PortDirection};
pub(crate) use kind::{DataKind, nested};
pub(crate) use port::{TREE, input_datum, output_datum};
pub(crate) use translate::Sent;
pub(crate) use vocabulary::{Role, Way};
pub(crate) use xml::{is, parse, value_span};

use declarations::Declarations;
use translate::Translator;

/// A compiled machine of a model, and what it exchanges with others.
#[derive(Clone, Debug)]
pub struct Machine {
    pub(crate) chart: Arc<Chart>,
    scxml: Arc<str>,
    /// The constant values of a leaf's input ports, and the names of the model's own types.
    given: (BTreeMap<String, String>, Vec<String>),
    pub(crate) interfaces: Vec<Interface>,
    pub(crate) ports: BTreeMap<String, (PortDirection, DataKind)>,
    /// Its outgoing messages, by event.
    pub(crate) sends: BTreeMap<String, Sent>,
    pub(crate) threads: Vec<Thread>,
    /// What is strange about the file, but no error, with locations.
    pub(crate) warnings: Vec<Problem>,
}

/// The machine that several threads of an action server run.
#[derive(Clone, Debug)]
pub(crate) struct Thread {
    pub(crate) count: usize,
    pub(crate) machine: Machine,
}

impl Machine {
    /// The machine.
    #[must_use]
    pub fn chart(&self) -> &Arc<Chart> {
        &self.chart
    }

    /// The machine as SCXML, from which the chart was compiled.
    #[must_use]
    pub fn scxml(&self) -> &str {
        &self.scxml
    }

    /// Reads a machine that can replace this one.
    ///
    /// # Errors
    /// As for [`load`](Self::load).
    pub fn load_instead(&self, file: &str, text: &str) -> Result<Self, Vec<Problem>> {
        let (ports, structures) = &self.given;
        Self::load(file, text, ports, structures)
    }

    /// Reads a machine. `ports` are the constant values of a leaf's input ports, as written in the tree's file, and
    /// `structures` the names of the model's own types.
    ///
    /// # Errors
    /// Everything that is wrong with the file, with locations.
    pub fn load(
        file: &str,
        text: &str,
        ports: &BTreeMap<String, String>,
        structures: &[String],
    ) -> Result<Self, Vec<Problem>> {
        let source = Source::new(file, text);
        let of = |problems: Vec<Problem>| -> Vec<Problem> {
            problems.into_iter().map(|problem| problem.of(&source)).collect()
        };
        let document = parse(text).map_err(|problem| of(vec![problem]))?;
        let root = document.root_element();
        if !["ascxml", "scxml"].contains(&root.tag_name().name()) {
            let problem = Problem::new("this is not a RoAML machine").at(diagnostics::xml::name_span(root), "here");
            return Err(of(vec![problem.with_help("a machine begins with <ascxml name=\"…\" initial=\"…\">")]));
        }
        // Everything is translated even if some of it is wrong, so that all problems are reported at once.
        let mut problems = Vec::new();
        let declarations = Declarations::of(root, ports, structures, &mut problems);
        let whole = build(file, text, root, &declarations, &mut problems);
        let mut threads = Vec::new();
        for thread in root.children().filter(|node| is(node, "ros_action_thread")) {
            let count = thread.attribute("n_threads").and_then(|count| count.parse().ok());
            let count = count.filter(|count| (1..=64).contains(count)).unwrap_or_else(|| {
                let problem = Problem::new("<ros_action_thread> needs `n_threads`, a number from 1 to 64");
                problems.push(problem.at(diagnostics::xml::name_span(thread), "here"));
                1
            });
            let machine = build(file, text, thread, &declarations, &mut problems);
            threads.extend(machine.map(|machine| Thread { count, machine }));
        }
        match whole {
            Some(machine) if !problems.iter().any(Problem::is_error) => {
                Ok(Self { threads, given: (ports.clone(), structures.to_vec()), warnings: of(problems), ..machine })
            }
            _ => {
                problems.sort_by_key(Problem::offset);
                Err(of(problems))
            }
        }
    }
}

/// Translates and compiles one machine: that of the whole file, or that of a thread.
fn build(
    file: &str,
    text: &str,
    root: Node<'_, '_>,
    declarations: &Declarations,
    problems: &mut Vec<Problem>,
) -> Option<Machine> {
    let known = problems.len();
    let translated = Translator::new(text, declarations, problems).machine(root);
    // In an incomplete translation, the compiler would find more problems that are not in the file.
    if problems[known..].iter().any(Problem::is_error) {
        return None;
    }
    match Chart::load_translated(file, text, translated.plain.text(), &|range| translated.plain.place(range)) {
        Ok(chart) => Some(Machine {
            chart,
            scxml: translated.plain.text().into(),
            given: Default::default(),
            interfaces: declarations.interfaces.clone(),
            ports: declarations.ports(),
            sends: translated.sends,
            threads: Vec::new(),
            warnings: Vec::new(),
        }),
        Err(SkillError::Load { problems: more, .. }) => {
            problems.extend(more.into_iter().filter(Problem::is_error));
            None
        }
        Err(error) => {
            problems.push(Problem::new(error.to_string()).at(diagnostics::xml::name_span(root), "this machine"));
            None
        }
    }
}
