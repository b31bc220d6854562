//! The condition under which an answer means success.

use diagnostics::{Span, Spanned};

/// The data of an event, in a machine.
pub(super) const DATA: &str = "_event.data";

/// A condition on the fields of an answer.
#[derive(Clone, Debug)]
pub(super) struct SuccessWhen {
    /// The expression, about the data of the event.
    pub(super) expression: String,
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
        let mut condition = Self { expression: String::new(), fields: Vec::new(), ports: Vec::new(), span };
        let (mut quote, mut word, mut is_port) = (None, String::new(), false);
        for sign in text.value.chars().chain([' ']) {
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
        condition
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
