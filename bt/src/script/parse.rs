//! Parses the tokens of a script by the binding power of operators.

use std::ops::Range;

use super::expression::{Assignment, Binary, Comparison, Expression, Script, Unary};
use super::reading::{Names, SyntaxError};
use super::token::{Token, TokenKind, tokens};
use crate::Value;

/// The maximum nesting of expressions, far from what a thread's stack allows. Chosen, not measured.
const MAX_DEPTH: usize = 100;
/// The maximum number of operators in a script, because a long chain of operators is also a deep tree. Chosen, not
/// measured.
const MAX_CHAIN: usize = 1000;

const CHOICE: u8 = 2;
const COMPARISON: u8 = 5;
const PREFIX: u8 = 10;

impl Script {
    /// Reads a script. Also gives the place of the first statement that no semicolon separates from the one before it.
    pub(crate) fn parse(text: &str, names: &mut dyn Names) -> Result<(Self, Option<Range<usize>>), SyntaxError> {
        let mut parser = Parser { tokens: tokens(text)?, next: 0, depth: 0, operators: 0, names };
        let (mut statements, mut unseparated) = (Vec::new(), None);
        while parser.peek() != TokenKind::End {
            statements.push(parser.expression(0)?);
            if !parser.accept(";") && parser.peek() != TokenKind::End {
                unseparated = unseparated.or_else(|| Some(parser.range()));
            }
            while parser.accept(";") {}
        }
        if statements.is_empty() {
            return Err(SyntaxError { message: "the script is empty".to_owned(), range: 0..text.len() });
        }
        Ok((Self { statements }, unseparated))
    }
}

struct Parser<'a, 'n> {
    tokens: Vec<Token<'a>>,
    next: usize,
    depth: usize,
    operators: usize,
    names: &'n mut dyn Names,
}

/// A binary operator.
#[derive(Clone, Copy)]
enum Infix {
    Assignment(Assignment),
    Choice,
    Comparison(Comparison),
    Binary(Binary),
}

/// The operator for a sign, and its binding power.
fn infix(sign: &str) -> Option<(Infix, u8)> {
    let binary = |operator, power| (Infix::Binary(operator), power);
    let comparison = |operator| (Infix::Comparison(operator), COMPARISON);
    let assignment = |operator| (Infix::Assignment(operator), 1);
    Some(match sign {
        ":=" => assignment(Assignment::Create),
        "=" => assignment(Assignment::Existing),
        "+=" => assignment(Assignment::With(Binary::Add)),
        "-=" => assignment(Assignment::With(Binary::Subtract)),
        "*=" => assignment(Assignment::With(Binary::Multiply)),
        "/=" => assignment(Assignment::With(Binary::Divide)),
        "?" => (Infix::Choice, CHOICE),
        "||" => binary(Binary::Or, 3),
        "&&" => binary(Binary::And, 4),
        "==" => comparison(Comparison::Equal),
        "!=" => comparison(Comparison::NotEqual),
        "<" => comparison(Comparison::Less),
        ">" => comparison(Comparison::Greater),
        "<=" => comparison(Comparison::LessEqual),
        ">=" => comparison(Comparison::GreaterEqual),
        // Unlike in C, bit operators bind tighter than comparisons.
        "|" => binary(Binary::BitOr, 6),
        "^" => binary(Binary::BitXor, 6),
        "&" => binary(Binary::BitAnd, 7),
        "+" => binary(Binary::Add, 8),
        "-" => binary(Binary::Subtract, 8),
        ".." => binary(Binary::Join, 8),
        "*" => binary(Binary::Multiply, 9),
        "/" => binary(Binary::Divide, 9),
        _ => return None,
    })
}

impl<'a> Parser<'a, '_> {
    fn peek(&self) -> TokenKind<'a> {
        self.tokens[self.next].kind
    }

    fn range(&self) -> Range<usize> {
        self.tokens[self.next].range.clone()
    }

    fn accept(&mut self, sign: &'static str) -> bool {
        let is_here = self.peek() == TokenKind::Sign(sign);
        self.next += usize::from(is_here);
        is_here
    }

    fn unexpected(&self, wanted: &str) -> SyntaxError {
        SyntaxError { message: format!("expected {wanted}"), range: self.range() }
    }

    /// An expression whose operators have at least this binding power.
    fn expression(&mut self, power: u8) -> Result<Expression, SyntaxError> {
        if self.depth == MAX_DEPTH {
            return Err(SyntaxError { message: "this is nested too deeply".to_owned(), range: self.range() });
        }
        self.depth += 1;
        let start = self.next;
        let mut left = self.operand()?;
        while let TokenKind::Sign(sign) = self.peek()
            && let Some((operator, binding)) = infix(sign)
            && binding >= power
        {
            self.operators += 1;
            if self.operators > MAX_CHAIN {
                return Err(SyntaxError { message: "this is too long".to_owned(), range: self.range() });
            }
            left = match operator {
                // An assignment and a choice take everything that follows, so no operator of this level is left.
                Infix::Assignment(assignment) => {
                    left = self.assignment(left, assignment, start)?;
                    break;
                }
                Infix::Choice => {
                    left = self.choice(left)?;
                    break;
                }
                Infix::Comparison(_) => self.comparison(left)?,
                Infix::Binary(operator) => {
                    self.next += 1;
                    let right = self.expression(binding + 1)?;
                    Expression::Binary(operator, Box::new(left), Box::new(right))
                }
            };
        }
        self.depth -= 1;
        Ok(left)
    }

    fn assignment(&mut self, left: Expression, operator: Assignment, start: usize) -> Result<Expression, SyntaxError> {
        let range = self.tokens[start].range.start..self.tokens[self.next - 1].range.end;
        let Expression::Name(slot, name) = left else {
            return Err(SyntaxError { message: "only blackboard entries can be assigned to".to_owned(), range });
        };
        self.next += 1;
        let right = self.expression(0)?;
        Ok(Expression::Assignment(operator, slot, name, Box::new(right)))
    }

    fn choice(&mut self, condition: Expression) -> Result<Expression, SyntaxError> {
        self.next += 1;
        let then = self.expression(0)?;
        if !self.accept(":") {
            return Err(self.unexpected("`:` and the other choice"));
        }
        let otherwise = self.expression(CHOICE)?;
        Ok(Expression::Choice(Box::new([condition, then, otherwise])))
    }

    fn comparison(&mut self, first: Expression) -> Result<Expression, SyntaxError> {
        let mut others = Vec::new();
        while let TokenKind::Sign(sign) = self.peek()
            && let Some((Infix::Comparison(comparison), _)) = infix(sign)
        {
            self.next += 1;
            others.push((comparison, self.expression(COMPARISON + 1)?));
        }
        Ok(Expression::Comparison(Box::new(first), others))
    }

    fn operand(&mut self) -> Result<Expression, SyntaxError> {
        let token = self.peek();
        let unary = match token {
            TokenKind::Sign("-") => Some(Unary::Negate),
            TokenKind::Sign("~") => Some(Unary::Complement),
            TokenKind::Sign("!") => Some(Unary::Not),
            _ => None,
        };
        if let Some(operator) = unary {
            self.next += 1;
            return Ok(Expression::Unary(operator, Box::new(self.expression(PREFIX)?)));
        }
        if self.accept("(") {
            let inside = self.expression(0)?;
            return if self.accept(")") { Ok(inside) } else { Err(self.unexpected("`)`")) };
        }
        let operand = match token {
            TokenKind::Int(number) => Expression::Literal(Value::Int(number)),
            TokenKind::Real(number) => Expression::Literal(Value::Real(number)),
            TokenKind::Text(text) => Expression::Literal(text.into()),
            // In BehaviorTree.CPP's scripts, truth values are numbers, and operators calculate with doubles.
            TokenKind::Name("true") => Expression::Literal(Value::Real(1.0)),
            TokenKind::Name("false") => Expression::Literal(Value::Real(0.0)),
            TokenKind::Name(name) => self.name(name),
            TokenKind::Sign(_) | TokenKind::End => return Err(self.unexpected("a number, a string or a name")),
        };
        self.next += 1;
        Ok(operand)
    }

    #[expect(clippy::cast_precision_loss, reason = "constants are small, and arithmetic is that of doubles")]
    fn name(&mut self, name: &str) -> Expression {
        match self.names.constant(name) {
            Some(number) => Expression::Literal(Value::Real(number as f64)),
            None => Expression::Name(self.names.slot(name), name.into()),
        }
    }
}
