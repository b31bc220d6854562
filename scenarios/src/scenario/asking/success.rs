//! The condition under which an answer means success.

use std::collections::BTreeSet;

use channels::FieldKind;
use diagnostics::markup::attribute;
use diagnostics::{Problem, Span, Spanned};
use skills::{Chart, EventFields, SkillError};

use crate::scenario::scxml_text::Text;

/// The data of an event, in a machine.
pub(super) const DATA: &str = "_event.data";

/// The event of the answer, in the machine of a condition.
const ANSWER: &str = "answer";

/// A condition on the fields of an answer.
#[derive(Clone, Debug)]
pub(super) struct SuccessWhen {
    /// The expression, about the data of the event.
    pub(super) expression: String,
    /// The same as its author wrote it, with blanks for the braces around ports.
    written: String,
    /// The fields and the ports that it names.
    pub(super) fields: Vec<String>,
    pub(super) ports: Vec<String>,
    pub(super) span: Span,
}

impl PartialEq for SuccessWhen {
    fn eq(&self, other: &Self) -> bool {
        self.expression == other.expression
    }
}

impl SuccessWhen {
    /// The condition. Except inside texts, `answer` stands in it for the event's data, and `{PORT}` for a port's value.
    pub(super) fn new(text: &Spanned<String>, answer: &str) -> Self {
        let span = text.span.clone();
        let (expression, written) = (String::new(), String::new());
        let mut condition = Self { expression, written, fields: Vec::new(), ports: Vec::new(), span };
        let (mut quote, mut word, mut is_port) = (None, String::new(), false);
        for sign in text.value.chars().chain([' ']) {
            condition.written.push(if quote.is_none() && matches!(sign, '{' | '}') { ' ' } else { sign });
            if quote.is_none() && (sign.is_alphanumeric() || matches!(sign, '_' | '$')) {
                word.push(sign);
                continue;
            }
            if is_port {
                condition.ports.push(word.clone());
            }
            condition.push(&std::mem::take(&mut word), answer);
            is_port = quote.is_none() && sign == '{';
            if quote.is_some() || !matches!(sign, '{' | '}') {
                condition.expression.push(sign);
            }
            quote = match quote {
                Some(begun) if begun == sign => None,
                None if matches!(sign, '\'' | '"' | '`') => Some(sign),
                same => same,
            };
        }
        condition.expression.pop();
        condition.written.pop();
        condition
    }

    /// What is wrong with the expression, if it may use these names besides that of the answer. The machine of a leaf
    /// would have the same problems, in terms of SCXML that the author of the expression did not write.
    pub(super) fn problems(&self, answer: &str, mut names: BTreeSet<String>) -> Vec<Problem> {
        names.insert(answer.to_owned());
        let text = machine(&self.written, &names);
        let problems = match Chart::load("condition", &text) {
            Ok(chart) => chart.warnings().to_vec(),
            Err(SkillError::Load { problems, .. }) => problems,
            Err(_) => Vec::new(),
        };
        let start = text.find("cond=\"").map_or(0, |start| start + "cond=\"".len());
        let end = start + attribute(&self.written).len();
        let of_condition = problems.iter().filter(|found| (start..=end).contains(&found.offset()));
        let in_file = |found: &Problem| {
            let problem = self.span.problem(found.message()).with_label(found.label_text().unwrap_or("here"));
            let help = match (found.label_text(), found.help_text()) {
                (_, Some(help)) if help.starts_with("did you mean") => Some(help.to_owned()),
                (Some("unknown name"), _) => {
                    Some(format!("`{answer}` is the answer, and `{{PORT}}` the value of a port"))
                }
                (_, help) => help.map(str::to_owned),
            };
            problem.with_help_if(help)
        };
        of_condition.map(in_file).collect()
    }

    /// Comparisons of the answer's fields with values that they never have.
    pub(super) fn misreadings(&self, fields: &[(String, FieldKind)]) -> Vec<Problem> {
        let text = machine(&self.expression, &self.ports.iter().cloned().collect());
        let Ok(chart) = Chart::load("condition", &text) else { return Vec::new() };
        let answer = EventFields { event: ANSWER, fields };
        let found = chart.misreadings(&[answer]).into_iter();
        let in_file = |found: Problem| {
            let help = found.help_text().map(str::to_owned);
            self.span.problem(found.message()).with_label("in this condition").with_help_if(help)
        };
        found.map(in_file).collect()
    }

    fn push(&mut self, word: &str, answer: &str) {
        let before = self.expression.trim_end();
        if word == answer && !before.ends_with('.') {
            self.expression.push_str(DATA);
            return;
        }
        if !word.is_empty() && before.strip_suffix('.').is_some_and(|before| before.trim_end().ends_with(DATA)) {
            self.fields.push(word.to_owned());
        }
        self.expression.push_str(word);
    }
}

/// A machine with this condition alone, and data with these names.
fn machine(condition: &str, names: &BTreeSet<String>) -> String {
    Text::machine("condition", |text| {
        text.element("datamodel", &[], |text| names.iter().for_each(|name| text.empty("data", &[("id", name)])));
        text.state("asking", |text| text.transition(ANSWER, Some(condition), None, |_| {}));
    })
}
