//! Properties: those of JANI that ask for the probability of a formula about the latest messages.

mod formula;
mod read;

use std::collections::BTreeMap;

use diagnostics::Problem;

pub(crate) use formula::State;
use formula::{Path, Variable};

use crate::instance::Fields;

/// A property of a model: in a run it becomes true or false, and over many runs it has a probability.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// Its name.
    pub name: String,
    /// Its formula, in signs.
    pub formula: String,
    path: Path,
}

impl Property {
    /// Reads the properties of a file.
    ///
    /// # Errors
    /// Everything that is wrong with the file, and what of JANI does not fit.
    pub(crate) fn read(text: &str, events: &BTreeMap<String, Fields>) -> Result<Vec<Self>, Vec<Problem>> {
        let read = read::properties(text, events)?;
        Ok(read.into_iter().map(|(name, path)| Self { name, formula: path.to_string(), path }).collect())
    }

    /// The events that it is about.
    pub(crate) fn events(&self) -> impl Iterator<Item = &str> {
        let mut found = Vec::new();
        for expression in [&self.path.left, &self.path.right] {
            expression.visit(&mut |variable| {
                if let Variable::Valid(event) | Variable::Field(event, ..) = variable {
                    found.push(event.as_str());
                }
            });
        }
        found.into_iter()
    }
}

/// The verdict of a property while a run continues.
#[derive(Clone, Debug)]
pub(crate) struct Watch<'p> {
    property: &'p Property,
    verdict: Option<bool>,
}

impl<'p> Watch<'p> {
    pub(crate) fn new(property: &'p Property) -> Self {
        Self { property, verdict: None }
    }

    /// Takes the next state, after `step` communications.
    pub(crate) fn observe(&mut self, state: &State, step: u64) {
        if self.verdict.is_none() {
            self.verdict = self.property.path.verdict(state, step);
        }
    }

    /// The verdict, if it is final.
    pub(crate) fn verdict(&self) -> Option<bool> {
        self.verdict
    }

    /// The verdict of a run that ends here.
    pub(crate) fn conclude(&self) -> bool {
        self.verdict.unwrap_or(self.property.path.at_end)
    }
}
