//! A model with which a campaign is compared: something happens as soon as a quantity exceeds a bound.

use diagnostics::Spanned;
use diagnostics::document::{Referent, Table};

use super::{Formula, Parameter, ParameterDomain, ParameterValue};

/// What a goal or a model is about, in words.
pub(super) const EVENT: &str = "the name of a property, or `expectation` for a run that is not as the scenario expects";

/// A campaign's `[model]`.
#[derive(Clone, Debug)]
pub struct Model {
    /// The event that it predicts: a property's violation by its name, or `expectation`.
    pub of: Spanned<String>,
    /// The model, in words.
    pub about: String,
    /// A formula over the names of parameters.
    pub quantity: Spanned<Formula>,
    /// The event happens if the quantity is greater than this.
    pub bound: f64,
}

impl Model {
    /// Reads a model. If something is wrong with it, reports that and returns `None`.
    pub(super) fn read(table: Table<'_>) -> Option<Self> {
        let of = table
            .text("of")
            .about(&format!("What happens: {EVENT}."))
            .refers_to(Referent::Property)
            .spanned()
            .required();
        let about = table.text("about").about("The model, in words.").default(String::new());
        let parse = |text: String, span: &diagnostics::Span| {
            Formula::parse(&text).map_err(|error| {
                let help = "numbers, names of parameters, `+ - * /` and parentheses";
                span.problem(error.to_string()).with_label("this formula").with_help(help)
            })
        };
        let quantity = table.text("quantity").try_map(parse).spanned();
        let quantity = quantity.about("A formula of parameter names, numbers, `+ - * /` and parentheses.").required();
        let bound = table.number("bound").about("The event happens if the quantity is greater than this.").required();
        Some(Self { of: of?, about, quantity: quantity?, bound: bound? })
    }

    /// Reports names in the formula that do not belong to a numeric parameter.
    pub(super) fn check(&self, root: Table<'_>, parameters: &[Parameter]) {
        let of_numbers = |domain: &ParameterDomain| match domain {
            ParameterDomain::Values(values) => {
                values.iter().all(|value| matches!(value, ParameterValue::Integer(_) | ParameterValue::Number(_)))
            }
            _ => true,
        };
        let numbers = parameters.iter().filter(|parameter| of_numbers(&parameter.domain));
        let known: Vec<&str> = numbers.filter_map(|parameter| parameter.name.as_deref()).collect();
        for name in self.quantity.value.names().into_iter().filter(|name| !known.contains(name)) {
            let problem = self.quantity.span.problem(format!("there is no numeric parameter with the name `{name}`"));
            let help = match known.as_slice() {
                [] => "give the parameters names: `name = \"drain\"`".to_owned(),
                [only] => format!("the only one is `{only}`"),
                known => format!("the known ones are `{}`", known.join("`, `")),
            };
            root.report(problem.with_label("this formula").with_help(help));
        }
    }
}
