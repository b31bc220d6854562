//! Conditions on a message: the third part of an event.

use diagnostics::Problem;

use super::ast::{Condition, ConditionKind, Field, FieldName};
use super::parse::{Parser, Reading, Stumbled};
use super::token::{Keyword, TokenKind};

const CONDITION: &str = "a condition compares a field of the message with a value: `m[1] = <ok>`";
const FIELD_NUMBER: &str = "fields are counted from 1: `m[1]`";

impl Parser {
    /// `c implies d`, right-associative.
    pub(super) fn condition(&mut self) -> Reading<Condition> {
        let left = self.joined_conditions(Keyword::Or)?;
        if !self.take_keyword(Keyword::Implies) {
            return Ok(left);
        }
        let right = self.deeper(Self::condition)?;
        let span = left.span.to(right.span);
        Ok(Condition { kind: ConditionKind::Implies(Box::new(left), Box::new(right)), span })
    }

    fn joined_conditions(&mut self, word: Keyword) -> Reading<Condition> {
        let operand = |parser: &mut Self| match word {
            Keyword::Or => parser.joined_conditions(Keyword::And),
            _ => parser.negated_condition(),
        };
        let first = operand(self)?;
        let mut operands = vec![first];
        while self.take_keyword(word) {
            operands.push(operand(self)?);
        }
        let span = operands[0].span.to(self.last_span());
        Ok(match (operands.len(), word) {
            (1, _) => operands.remove(0),
            (_, Keyword::Or) => Condition { kind: ConditionKind::Or(operands), span },
            _ => Condition { kind: ConditionKind::And(operands), span },
        })
    }

    fn negated_condition(&mut self) -> Reading<Condition> {
        let start = self.span();
        if self.take_keyword(Keyword::Not) {
            let operand = self.deeper(Self::negated_condition)?;
            let span = start.to(operand.span);
            return Ok(Condition { kind: ConditionKind::Not(Box::new(operand)), span });
        }
        if self.take(&TokenKind::Open) {
            let inside = self.deeper(Self::condition)?;
            if !self.take(&TokenKind::Close) {
                return Err(self.expected("an operator or `)`", "the operators of conditions: and, or, implies"));
            }
            return Ok(Condition { kind: inside.kind, span: start.to(self.last_span()) });
        }
        for (keyword, kind) in [(Keyword::True, ConditionKind::True), (Keyword::False, ConditionKind::False)] {
            if self.take_keyword(keyword) {
                return Ok(Condition { kind, span: start });
            }
        }
        self.comparison()
    }

    fn comparison(&mut self) -> Reading<Condition> {
        let start = self.span();
        if let TokenKind::Keyword(
            temporal @ (Keyword::Always | Keyword::Eventually | Keyword::Next | Keyword::TimeUntil),
        ) = self.peek()
        {
            let problem = Problem::new(format!("`{}` is not allowed inside an event", temporal.text()));
            self.problems
                .push(problem.at(start, "this refers to more than one message").with_help("close the event before it"));
            return Err(Stumbled);
        }
        let field = self.field()?;
        let TokenKind::Relation(relation) = *self.peek() else {
            return Err(self.expected("`=`, `!=`, `<`, `<=`, `>` or `>=`", CONDITION));
        };
        self.advance();
        let value = self.operand()?;
        let span = start.to(self.last_span());
        Ok(Condition { kind: ConditionKind::Compare { field, relation, value }, span })
    }

    /// `m[2]`, `m.level` or `level`.
    fn field(&mut self) -> Reading<Field> {
        let start = self.span();
        let TokenKind::Name(name) = self.peek().clone() else {
            return Err(self.expected("a field of the message such as `m[1]`", CONDITION));
        };
        self.advance();
        let name = if name == "m" && self.take(&TokenKind::OpenIndex) {
            self.field_number()?
        } else if name == "m" && self.take(&TokenKind::Dot) {
            FieldName::Named(self.name("the name of a field", "fields have numbers and names: `m[1]`, `m.level`")?.text)
        } else {
            FieldName::Named(name)
        };
        Ok(Field { name, span: start.to(self.last_span()) })
    }

    fn field_number(&mut self) -> Reading<FieldName> {
        let number = match self.peek() {
            TokenKind::Number(number) => number.parse().ok().filter(|number| *number > 0),
            _ => None,
        };
        let Some(number) = number else {
            return Err(self.expected("the number of a field", FIELD_NUMBER));
        };
        self.advance();
        if !self.take(&TokenKind::CloseIndex) {
            return Err(self.expected("`]`", FIELD_NUMBER));
        }
        Ok(FieldName::Number(number))
    }
}
