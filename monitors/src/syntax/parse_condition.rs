//! Conditions on a message: the third part of an event.

use diagnostics::{Problem, nearest_or_all};

use super::ast::{Condition, ConditionKind, Field, FieldName, Term};
use super::boolean::Boolean;
use super::parse::{MAX_OPERATORS, ParseResult, Parser, Stumbled};
use super::token::{Keyword, TokenKind};
use crate::formula::{Arithmetic, Function};
use crate::operator::{Prefix, Tense};

const CONDITION: &str = "a condition compares a field of the message with a value: `m[1] = <ok>`";
const REMEMBER: &str = "a value is remembered as `m.place as p`, and compared as `m.place = p`";
const FIELD_NUMBER: &str = "fields are counted from 1: `m[1]`";

const BOOLEAN: Boolean<Condition, ConditionKind> = Boolean {
    operand: Parser::negated_condition,
    implies: ConditionKind::Implies,
    or: ConditionKind::Or,
    and: ConditionKind::And,
    tree: |kind, span| Condition { kind, span },
};

impl Parser {
    pub(super) fn condition(&mut self) -> ParseResult<Condition> {
        self.implication(&BOOLEAN)
    }

    fn negated_condition(&mut self) -> ParseResult<Condition> {
        let start = self.span();
        if self.take_keyword(Keyword::Prefix(Prefix::Not)) {
            let operand = self.deeper(Self::negated_condition)?;
            let span = start.to(operand.span);
            return Ok(Condition { kind: ConditionKind::Not(Box::new(operand)), span });
        }
        if *self.peek() == TokenKind::Open && !self.at_term() {
            self.advance();
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
        for (word, every) in [("any", false), ("all", true)] {
            if self.at_call() && self.peek().as_name() == Some(word) {
                let condition = Box::new(self.of_items()?);
                return Ok(Condition {
                    kind: ConditionKind::Items { every, condition },
                    span: start.to(self.last_span()),
                });
            }
        }
        self.comparison()
    }

    /// Whether a name with parentheses follows: `count(…)`.
    fn at_call(&self) -> bool {
        self.peek().as_name().is_some() && *self.peek_second() == TokenKind::Open
    }

    /// The condition in parentheses after `any`, `all` or `count`.
    fn of_items(&mut self) -> ParseResult<Condition> {
        self.advance();
        self.advance();
        // The operators inside are those of other comparisons.
        let operators = self.operators;
        let condition = self.deeper(Self::condition)?;
        self.operators = operators;
        if !self.take(&TokenKind::Close) {
            return Err(self.expected("an operator or `)`", "the operators of conditions: and, or, implies"));
        }
        Ok(condition)
    }

    /// `count(c)`, `distance(x, y, u, v)`, or another function.
    fn call(&mut self) -> ParseResult<Term> {
        let start = self.span();
        let name = self.peek().as_name().unwrap_or_default().to_owned();
        if name == "count" {
            let condition = Box::new(self.of_items()?);
            return Ok(Term::Count(condition, start.to(self.last_span())));
        }
        let Some(function) = Function::ALL.into_iter().find(|function| function.signature().0 == name) else {
            let known: Vec<&str> = Function::ALL.map(|function| function.signature().0).into_iter().collect();
            let known = [&known[..], &["count", "any", "all"]].concat();
            let problem = Problem::new(format!("unknown function `{name}`")).at(start, "not a function");
            self.problems.push(problem.with_help(nearest_or_all(&name, "functions", &known)));
            return Err(Stumbled);
        };
        self.advance();
        self.advance();
        let mut terms = vec![self.deeper(Self::sum)?];
        while self.take(&TokenKind::Comma) {
            terms.push(self.deeper(Self::sum)?);
        }
        let (_, wanted) = function.signature();
        let usage = format!("it is written `{name}({})`", wanted.join(", "));
        if !self.take(&TokenKind::Close) {
            return Err(self.expected("an operator, `,` or `)`", &usage));
        }
        let span = start.to(self.last_span());
        if terms.len() != wanted.len() {
            let message = format!("`{name}` takes {} numbers, not {}", wanted.len(), terms.len());
            self.problems.push(Problem::new(message).at(span, "here").with_help(usage));
            return Err(Stumbled);
        }
        Ok(Term::Call(function, terms, span))
    }

    fn comparison(&mut self) -> ParseResult<Condition> {
        let start = self.span();
        if let TokenKind::Keyword(keyword) = self.peek()
            && (*keyword == Keyword::TimeUntil
                || matches!(keyword, Keyword::Prefix(operator) if operator.tense() == Tense::Future))
        {
            let problem = Problem::new(format!("`{}` is not allowed inside an event", keyword.text()));
            self.problems
                .push(problem.at(start, "this refers to more than one message").with_help("close the event before it"));
            return Err(Stumbled);
        }
        self.operators = 0;
        let left = self.left_term()?;
        if let Term::Field(field) = &left
            && self.take_keyword(Keyword::As)
        {
            let name = self.name("a name for the value", REMEMBER)?;
            let span = start.to(self.last_span());
            return Ok(Condition { kind: ConditionKind::Remember { field: field.clone(), name }, span });
        }
        let TokenKind::Relation(relation) = *self.peek() else {
            return Err(self.expected("`=`, `!=`, `<`, `<=`, `>` or `>=`", CONDITION));
        };
        self.advance();
        let right = self.sum()?;
        let span = start.to(self.last_span());
        Ok(Condition { kind: ConditionKind::Compare { left, relation, right }, span })
    }

    /// The left side of a comparison. A name that stands alone there is a field.
    fn left_term(&mut self) -> ParseResult<Term> {
        let after = self.tokens.get(self.at + 1).map(|token| &token.kind);
        let is_alone = !matches!(after, Some(TokenKind::Arithmetic(_) | TokenKind::Number(_) | TokenKind::Open));
        if is_alone && !matches!(self.peek(), TokenKind::Open | TokenKind::Number(_)) {
            let field = self.field()?;
            return self.sum_from(Term::Field(field));
        }
        self.sum()
    }

    /// Terms joined by `+` and `-`.
    fn sum(&mut self) -> ParseResult<Term> {
        let first = self.product()?;
        self.sum_from(first)
    }

    fn sum_from(&mut self, first: Term) -> ParseResult<Term> {
        let mut sum = self.product_from(first)?;
        loop {
            let operator = match self.peek().clone() {
                TokenKind::Arithmetic(operator) if !operator.is_factor() => {
                    self.advance();
                    operator
                }
                // `level -3`: the sign belongs to the sum.
                TokenKind::Number(number) if number.starts_with('-') => {
                    self.tokens[self.at].kind = TokenKind::Number(number[1..].to_owned());
                    Arithmetic::Subtract
                }
                _ => return Ok(sum),
            };
            let right = self.product()?;
            sum = self.arithmetic(sum, operator, right)?;
        }
    }

    /// The operation on two terms. A term is a tree as deep as it has operators in a row, so their number is limited.
    fn arithmetic(&mut self, left: Term, operator: Arithmetic, right: Term) -> ParseResult<Term> {
        self.operators += 1;
        if self.operators > MAX_OPERATORS {
            let label = format!("more than {MAX_OPERATORS} operators in one comparison");
            self.problems.push(Problem::new("this term is too long").at(self.last_span(), label));
            return Err(Stumbled);
        }
        Ok(Term::Arithmetic(Box::new(left), operator, Box::new(right)))
    }

    /// Terms joined by `*` and `/`.
    fn product(&mut self) -> ParseResult<Term> {
        let first = self.factor()?;
        self.product_from(first)
    }

    fn product_from(&mut self, mut product: Term) -> ParseResult<Term> {
        while let TokenKind::Arithmetic(operator) = *self.peek() {
            if !operator.is_factor() {
                break;
            }
            self.advance();
            let right = self.factor()?;
            product = self.arithmetic(product, operator, right)?;
        }
        Ok(product)
    }

    fn factor(&mut self) -> ParseResult<Term> {
        if self.take(&TokenKind::Open) {
            let inside = self.deeper(Self::sum)?;
            if !self.take(&TokenKind::Close) {
                return Err(self.expected("an operator or `)`", "the operators on numbers: +, -, *, /"));
            }
            return Ok(inside);
        }
        if self.at_call() {
            return self.call();
        }
        let is_field =
            self.peek().as_name() == Some("m") && matches!(self.peek_second(), TokenKind::OpenIndex | TokenKind::Dot);
        if is_field { Ok(Term::Field(self.field()?)) } else { Ok(Term::Operand(self.operand()?)) }
    }

    /// Whether the parenthesis here encloses a term, not a condition, which depends on what follows it.
    fn at_term(&self) -> bool {
        let mut depth = 0_usize;
        for (place, token) in self.tokens[self.at..].iter().enumerate() {
            match token.kind {
                TokenKind::Open => depth += 1,
                TokenKind::Close => depth = depth.saturating_sub(1),
                TokenKind::End => return false,
                // Deeper ones are those of a function.
                TokenKind::Relation(_) | TokenKind::Comma if depth == 1 => return false,
                _ => {}
            }
            if depth == 0 {
                let after = self.tokens.get(self.at + place + 1).map(|token| &token.kind);
                return matches!(after, Some(TokenKind::Relation(_) | TokenKind::Arithmetic(_)));
            }
        }
        false
    }

    /// `m[2]`, `m.level` or `level`.
    fn field(&mut self) -> ParseResult<Field> {
        let start = self.span();
        let Some(name) = self.peek().as_name().map(str::to_owned) else {
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

    fn field_number(&mut self) -> ParseResult<FieldName> {
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
