//! Compiling expressions: here, or else for the engine.

use std::ops::Range;
use std::sync::Arc;

use diagnostics::Problem;

use super::compile::Compiler;
use super::xml::Written;
use crate::chart::Condition;
use crate::expression::{self, Expr, ExpressionProblem, Parsed, ProblemKind};
use crate::expression::{Code, Form};

impl Compiler<'_> {
    pub(super) fn condition(&mut self, written: &Written<'_>) -> Condition {
        Condition { test: self.expression(written), text: written.value.into(), span: written.span().into() }
    }

    /// Compiles an expression. One that cannot be compiled is reported, and is an error whenever it is evaluated.
    pub(super) fn expression(&mut self, written: &Written<'_>) -> Expr {
        let parsed = expression::expression(written.value, &self.names);
        match self.compiled(written, parsed, Form::Expression, |expr| expr, Expr::Foreign) {
            Ok(expr) if self.null_model && !matches!(expr, Expr::In(_)) => {
                let problem =
                    Problem::new("the null data model has no expressions").at(written.span(), "an expression");
                Expr::Broken(self.defer(problem.with_help("use `In('state')`, or set datamodel=\"ecmascript\"")))
            }
            Ok(expr) => expr,
            Err(reason) => Expr::Broken(reason),
        }
    }

    /// The compiled result or, if that is impossible and there is an engine that can do it, code for the engine.
    /// Otherwise the problem is reported, and `Err` describes it.
    pub(super) fn compiled<T, C>(
        &mut self,
        written: &Written<'_>,
        parsed: Parsed<T>,
        form: Form,
        here: impl FnOnce(T) -> C,
        there: impl FnOnce(Arc<Code>) -> C,
    ) -> Result<C, Arc<str>> {
        self.mentions.note(written.value);
        // A name that is unknown here is unknown to the engine as well.
        let for_engine = match &parsed.outcome {
            Err(problem) if problem.kind != ProblemKind::Name && !self.null_model => {
                Code::new(written.value, form, &self.names).map(|code| (code, problem.clone()))
            }
            _ => None,
        };
        match for_engine {
            Some((Ok(code), problem)) => {
                if problem.kind == ProblemKind::Suspicious {
                    self.problems.push(in_file(written, problem).as_warning());
                }
                let dates = expression::kept_dates(written.value, form);
                self.problems.extend(dates.into_iter().map(|date| in_file(written, date).as_warning()));
                self.foreign.extend(&code.mentions);
                self.mentions.note_code(written.value);
                Ok(there(Arc::new(code)))
            }
            // It is not ECMAScript either: the engine's message is about that, and ours only about the subset.
            Some((Err(worse), problem)) if problem.kind == ProblemKind::Beyond => {
                Err(self.defer(in_file(written, worse)))
            }
            _ => self.report(written, parsed).map(here),
        }
    }

    pub(super) fn report<T>(&mut self, written: &Written<'_>, parsed: Parsed<T>) -> Result<T, Arc<str>> {
        let fatal = parsed.outcome.as_ref().err().map(|problem| problem.span.clone());
        let overlaps =
            |span: &Range<usize>| fatal.as_ref().is_some_and(|fatal| span.start < fatal.end && fatal.start < span.end);
        let mut meant = None;
        for problem in parsed.unknown {
            if overlaps(&problem.span) {
                meant = problem.help;
            } else {
                self.defer(in_file(written, problem));
            }
        }
        parsed.outcome.map_err(|problem| {
            let help = problem.help.clone().or(meant);
            self.defer(in_file(written, ExpressionProblem { help, ..problem }))
        })
    }
}

fn in_file(written: &Written<'_>, problem: ExpressionProblem) -> Problem {
    let span = written.span_of(problem.span);
    Problem::new(problem.message).at(span, problem.label).with_help_if(problem.help)
}
