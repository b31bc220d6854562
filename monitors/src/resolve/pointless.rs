//! Comparisons whose result no message can change.

use channels::{ChannelId, Shape};
use diagnostics::Problem;

use super::Resolver;
use crate::formula;
use crate::syntax::{ByteRange, Name, Operand, Term};

impl Resolver<'_> {
    /// Warns of a comparison without a field and of one of a value with itself. A constant that hides the field which
    /// seems to be meant is an error.
    pub(super) fn doubt_comparison(
        &mut self,
        whole: ByteRange,
        sides: [&Term; 2],
        terms: [&formula::Term; 2],
        channel: Option<ChannelId>,
    ) {
        let hidden = sides.into_iter().find_map(|side| self.hidden_field(side, channel).cloned());
        let has_field = !terms.iter().all(|term| matches!(term, formula::Term::Value(_)));
        match hidden {
            Some(name) if has_field => self.doubt_name(&name),
            Some(Name { text, span }) => {
                let problem = Problem::new(format!("`{text}` is a constant here, so no field is compared"));
                let help = format!("write `m.{text}` for the field, or give the constant a different name");
                self.problems.push(problem.at(span, "not the field").with_help(help));
            }
            None if !has_field => {
                let problem = Problem::new("no field is compared here").at(whole, "the same for every message");
                self.problems.push(problem.with_help("compare a field of the message").as_warning());
            }
            None if terms[0] == terms[1] => {
                let problem = Problem::new("a value is compared with itself").at(whole, "the same for every message");
                let help = "compare it with another field, a constant, or a value that was remembered";
                self.problems.push(problem.with_help(help).as_warning());
            }
            None => {}
        }
    }

    /// Warns of a constant that is called like a field of the message.
    pub(super) fn doubt_name(&mut self, Name { text, span }: &Name) {
        let problem = Problem::new(format!("`{text}` is a constant here, and not the field of this name"));
        let help = format!("give the constant a different name; `m.{text}` is the field");
        self.problems.push(problem.at(*span, "the constant").with_help(help).as_warning());
    }

    /// The name of a constant that is also the name of a field.
    pub(super) fn hidden_field<'t>(&self, side: &'t Term, channel: Option<ChannelId>) -> Option<&'t Name> {
        let Term::Operand(Operand::Constant(name)) = side else { return None };
        let is_constant = !self.remembered.contains(&name.text) && self.constants.contains_key(name.text.as_str());
        (is_constant && self.is_field(&name.text, channel)).then_some(name)
    }

    pub(super) fn is_field(&self, name: &str, channel: Option<ChannelId>) -> bool {
        let shapes = channel.map(|channel| self.topology.get(channel).domain.shapes()).unwrap_or_default();
        shapes.iter().flat_map(Shape::fields).any(|(field, _)| field == name)
    }
}
