//! Bounds on what code may take, and what the engine says about code that it cannot read.

use std::pin::pin;
use std::task::{self, Poll, Waker};

use boa_engine::context::Context;
use boa_engine::{JsValue, Script};

use super::Failure;
use crate::expression::ExpressionProblem;

/// What the engine may spend before it is looked at.
const SLICE: u32 = 100_000;
/// So often is it allowed to go on: some tenths of a second.
const MAX_SLICES: u32 = 200;
/// A loop of one call may go round so often.
pub(super) const MAX_ITERATIONS: u64 = 1_000_000;
/// Calls may lie in each other so deeply.
pub(super) const MAX_RECURSION: usize = 200;

pub(super) const TOO_LONG: &str = "the code does not come to an end";

/// Runs a program until it ends or has taken too long.
pub(super) fn evaluate(script: &Script, context: &mut Context) -> Result<JsValue, Failure> {
    let mut evaluation = pin!(script.evaluate_async_with_budget(context, SLICE));
    let mut task = task::Context::from_waker(Waker::noop());
    for _ in 0..MAX_SLICES {
        if let Poll::Ready(outcome) = evaluation.as_mut().poll(&mut task) {
            return Ok(outcome?);
        }
    }
    Err(Failure::Interrupted)
}

/// What is wrong with a source, which was read with a line before it.
pub(super) fn syntax_problem(source: &str, message: &str) -> ExpressionProblem {
    let number_behind = |word: &str| {
        let (_, rest) = message.rsplit_once(word)?;
        let digits = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        rest[..digits].parse::<usize>().ok()
    };
    let place = number_behind("line ").zip(number_behind("col ")).and_then(|(line, column)| {
        let before: usize = source.split_inclusive('\n').take(line.checked_sub(2)?).map(str::len).sum();
        let line = source.get(before..)?.lines().next().unwrap_or_default();
        let (offset, letter) = line.char_indices().nth(column.checked_sub(1)?)?;
        Some(before + offset..before + offset + letter.len_utf8())
    });
    let what = message.strip_prefix("SyntaxError: ").unwrap_or(message);
    let what = what.split(" at line ").next().unwrap_or(what);
    ExpressionProblem::new(format!("this is not ECMAScript: {what}"), place.unwrap_or(0..source.len()), "here")
}
