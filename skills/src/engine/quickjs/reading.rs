//! Checks whether the engine can parse a source.

use rquickjs::{Error, Value};

use super::runtime::{STEPS_PER_TURN, Turns, engine};
use crate::expression::ExpressionProblem;
use crate::expression::Form;

pub(in crate::engine) fn check(source: &str, form: Form) -> Result<(), ExpressionProblem> {
    // Code that escapes from one pair of brackets does not fit into the other. Nothing is called. Code that escapes
    // from the function may run, in an engine whose results are discarded.
    let around = match form {
        Form::Expression => [("return (\n", "\n)"), ("return [\n", "\n]")],
        Form::Location => [("(\n", "\n) = 0"), ("[(\n", "\n) = 0]")],
        Form::Script => [("{\n", "\n}"), ("(function () {\n", "\n})")],
    };
    let read =
        |(before, after): &(&str, &str)| readable(&format!("(function(){{'use strict';{before}{source}{after}}})"));
    around.iter().try_for_each(read).map_err(|complaint| complaint.about(source))
}

/// The engine's error about a text that it cannot parse.
pub(super) struct Complaint {
    message: String,
    /// Line and column, from 1.
    place: Option<(usize, usize)>,
}

impl Complaint {
    /// The problem of a source, which was parsed with a line before it.
    fn about(&self, source: &str) -> ExpressionProblem {
        let place = self.place.and_then(|(line, column)| {
            let before: usize = source.split_inclusive('\n').take(line.checked_sub(2)?).map(str::len).sum();
            let line = source.get(before..)?.lines().next().unwrap_or_default();
            let (offset, letter) = line.char_indices().nth(column.checked_sub(1)?)?;
            Some(before + offset..before + offset + letter.len_utf8())
        });
        let what = self.message.strip_prefix("SyntaxError: ").unwrap_or(&self.message);
        ExpressionProblem::new(format!("this is not ECMAScript: {what}"), place.unwrap_or(0..source.len()), "here")
    }
}

pub(super) fn readable(program: &str) -> Result<(), Complaint> {
    let turns = Turns::new(STEPS_PER_TURN);
    let complaint = |message: &str| Complaint { message: message.to_owned(), place: None };
    let context = engine(&turns).map_err(|error| complaint(&error.to_string()))?;
    context.with(|ctx| match ctx.eval::<Value<'_>, _>(program) {
        Ok(_) => Ok(()),
        Err(Error::Exception) => {
            let thrown = ctx.catch();
            let Some(error) = thrown.as_object() else {
                return Err(complaint("it is too large"));
            };
            let number = |name: &str| error.get::<_, usize>(name).ok();
            let place = number("lineNumber").zip(number("columnNumber"));
            let message = error.get::<_, String>("message").unwrap_or_default();
            Err(Complaint { message, place })
        }
        Err(error) => Err(complaint(&error.to_string())),
    })
}
