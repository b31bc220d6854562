//! Executable content (SCXML 4).

use std::sync::Arc;

use miette::SourceSpan;

use super::macrostep::Macrostep;
use super::{Event, EventKind, Note, no_room};
use crate::Datum;
use crate::chart::{Action, ActionKind, AssignTarget, Branch, Condition, Content, Foreach, Payload};
use crate::datum::EvaluationError;
use crate::expression::{BinaryOp, Expr, Location, Statement, binary};
use crate::ids::DataId;

/// An action failed: the rest of its block is skipped (SCXML 3.12.2). The error event is in the queue already.
pub(super) struct Aborted;

impl Macrostep<'_, '_> {
    /// Executes a block. If an action fails, the following ones are skipped.
    pub(super) fn execute(&mut self, block: &[Action]) {
        self.steps.begin();
        let _ = self.actions(block);
    }

    fn actions(&mut self, block: &[Action]) -> Result<(), Aborted> {
        block.iter().try_for_each(|action| self.action(action))
    }

    fn action(&mut self, action: &Action) -> Result<(), Aborted> {
        self.count(1, action.span)?;
        match &action.kind {
            ActionKind::Raise { event, class } => {
                if !self.machine.has_room() {
                    return self.abort(no_room(), action.span);
                }
                self.raise(Event::new(Arc::clone(event), EventKind::Internal), *class);
                Ok(())
            }
            ActionKind::Send(send) => self.send(send),
            ActionKind::Cancel(id) => self.cancel(id, action.span),
            ActionKind::Assign(location, value) => {
                let value = self.value(value, action.span)?;
                self.assign(location, value, action.span)
            }
            ActionKind::If(branches) => self.choose(branches),
            ActionKind::Foreach(foreach) => self.foreach(foreach, action.span),
            ActionKind::Log { label, value } => self.log(label, value.as_ref(), action.span),
            ActionKind::Foreign(code) => match self.run_code(code, None) {
                Ok(_) => Ok(()),
                Err(error) => self.abort(error.to_string(), action.span),
            },
            ActionKind::Script(statements) => {
                statements.iter().try_for_each(|statement| self.statement(statement, action.span))
            }
            ActionKind::Fail(reason) => self.abort(reason.to_string(), action.span),
        }
    }

    /// Counts steps, and ends the block if none are left.
    fn count(&mut self, steps: u64, span: SourceSpan) -> Result<(), Aborted> {
        self.steps.take(steps).or_else(|error| self.abort(error.to_string(), span))
    }

    /// Reports an error, and ends the block.
    pub(super) fn abort<T>(&mut self, reason: String, span: SourceSpan) -> Result<T, Aborted> {
        self.fail(reason, span, None);
        Err(Aborted)
    }

    pub(super) fn value(&mut self, expr: &Expr, span: SourceSpan) -> Result<Datum, Aborted> {
        match self.evaluate(expr) {
            Ok(value) => Ok(value),
            Err(error) => self.abort(error.to_string(), span),
        }
    }

    /// Whether a condition holds. If it cannot be evaluated, it does not hold, and an error is raised (SCXML 5.9.1).
    pub(super) fn holds(&mut self, condition: &Condition) -> bool {
        let truth = match &condition.test {
            Expr::Foreign(code) => self.run_code(code, None).map(|value| value.truthy()),
            test => test.truth(&self.scope()),
        };
        truth.unwrap_or_else(|error| {
            self.fail(error.to_string(), condition.span, None);
            false
        })
    }

    pub(super) fn assign(&mut self, target: &AssignTarget, value: Datum, span: SourceSpan) -> Result<(), Aborted> {
        let outcome = match target {
            AssignTarget::Compiled(location) => self.try_assign(location, value),
            AssignTarget::Foreign(code) => self.run_code(code, Some(&value)).map(|_| ()),
        };
        outcome.or_else(|error| self.abort(error.to_string(), span))
    }

    fn assign_here(&mut self, location: &Location, value: Datum, span: SourceSpan) -> Result<(), Aborted> {
        self.try_assign(location, value).or_else(|error| self.abort(error.to_string(), span))
    }

    fn try_assign(&mut self, location: &Location, value: Datum) -> Result<(), EvaluationError> {
        let keys = location.keys(&self.scope())?;
        if !keys.is_empty() {
            // All data may have to be searched for the object that changes.
            self.steps.take_size(self.machine.data.iter().map(Datum::size).sum())?;
        }
        self.machine.data.put(location.data, &keys, value)
    }

    fn choose(&mut self, branches: &[Branch]) -> Result<(), Aborted> {
        for branch in branches {
            if branch.condition.as_ref().is_none_or(|condition| self.holds(condition)) {
                return self.actions(&branch.content);
            }
        }
        Ok(())
    }

    fn foreach(&mut self, foreach: &Foreach, span: SourceSpan) -> Result<(), Aborted> {
        let Datum::Array(array) = self.value(&foreach.array, span)? else {
            return self.abort("<foreach> needs an array, and this is not one".to_owned(), span);
        };
        for (position, item) in array.items().iter().enumerate() {
            self.count(1, span)?;
            self.set(foreach.item, item.clone());
            if let Some(index) = foreach.index {
                self.set(index, Datum::Number(position as f64));
            }
            self.actions(&foreach.content)?;
        }
        Ok(())
    }

    fn set(&mut self, data: DataId, value: Datum) {
        self.machine.data.set(data, value);
    }

    fn log(&mut self, label: &Arc<str>, value: Option<&Expr>, span: SourceSpan) -> Result<(), Aborted> {
        let text = match value {
            None => String::new(),
            Some(expr) => match self.value(expr, span)? {
                composite @ (Datum::Array(_) | Datum::Object(_)) => composite.to_string(),
                simple => simple.to_text().to_string(),
            },
        };
        self.count(text.len() as u64 / 64, span)?;
        self.host.note(Note::Log { label: Arc::clone(label), text });
        Ok(())
    }

    fn statement(&mut self, statement: &Statement, span: SourceSpan) -> Result<(), Aborted> {
        match statement {
            Statement::Assign(location, value) => {
                let value = self.value(value, span)?;
                self.assign_here(location, value, span)
            }
            Statement::Update(location, op, operand) => {
                let value =
                    self.updated(location, *op, operand).or_else(|error| self.abort(error.to_string(), span))?;
                self.assign_here(location, value, span)
            }
            Statement::Evaluate(expr) => self.value(expr, span).map(|_| ()),
        }
    }

    fn updated(&self, location: &Location, op: BinaryOp, operand: &Expr) -> Result<Datum, EvaluationError> {
        let scope = self.scope();
        binary(op, &location.to_expr().evaluate(&scope)?, &operand.evaluate(&scope)?)
    }

    /// The data of an event, from parameters or content. A parameter that cannot be evaluated raises an error and is
    /// left out (SCXML 5.7). Content that cannot be evaluated raises an error and is empty (SCXML 5.6).
    pub(super) fn payload(&mut self, payload: &Payload) -> Datum {
        match &payload.content {
            Some(Content::Literal(value)) => return value.clone(),
            Some(Content::Computed(expr, span)) => return self.value(expr, *span).unwrap_or_default(),
            None => {}
        }
        let members = self.params(payload);
        self.object(members)
    }

    /// The parameters that can be evaluated.
    pub(super) fn params(&mut self, payload: &Payload) -> Vec<(Arc<str>, Datum)> {
        let mut members = Vec::new();
        for param in &payload.params {
            if let Ok(value) = self.value(&param.value, param.span) {
                members.push((Arc::clone(&param.name), value));
            }
        }
        members
    }

    /// An object, or `undefined` if it would be empty or too large.
    pub(super) fn object(&mut self, members: Vec<(Arc<str>, Datum)>) -> Datum {
        if members.is_empty() { Datum::Undefined } else { Datum::object(members).unwrap_or_default() }
    }
}
