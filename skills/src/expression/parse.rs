//! Parses text into a compiled expression: a Pratt parser over the tokens.

use std::ops::Range;
use std::sync::Arc;

use diagnostics::did_you_mean;

use super::token::{Token, TokenKind, tokens};
use super::vocabulary::{Infix, UNARY_POWER, infix, is_reserved, prefix, system_name};
use super::{EventField, Expr, ExpressionProblem, Location, Names, ProblemKind, Scope, UnaryOp};
use crate::Datum;

/// The maximum nesting of parentheses, brackets and prefix operators; more would use too much stack. Chosen, not
/// measured.
const MAX_NESTING: usize = 48;
/// The maximum number of operators in an expression: each may add a level to the tree. Chosen, not measured.
const MAX_OPERATORS: usize = 500;

type Result<T> = std::result::Result<T, ExpressionProblem>;

/// The result of compiling, and the unknown names in it.
///
/// Evaluating such a name is an error; the caller decides whether to report it earlier.
#[derive(Debug)]
pub(crate) struct Parsed<T> {
    pub(crate) outcome: Result<T>,
    pub(crate) unknown: Vec<ExpressionProblem>,
}

/// Compiles an expression.
pub(crate) fn expression(source: &str, names: &Names) -> Parsed<Expr> {
    parse_whole(source, names, |parser| parser.expression(0))
}

/// Compiles the location of an assignment.
pub(crate) fn location(source: &str, names: &Names) -> Parsed<Location> {
    parse_whole(source, names, |parser| {
        let expr = parser.expression(0)?;
        Location::from_expr(expr, 0..source.len())
    })
}

/// The value of a literal, including JSON; `None` if the text is anything else.
pub(crate) fn literal(source: &str) -> Option<Datum> {
    let expr = expression(source, &Names::default()).outcome.ok()?;
    if expr.is_literal() { expr.evaluate(&Scope::default()).ok() } else { None }
}

fn parse_whole<'s, T>(
    source: &'s str,
    names: &Names,
    parse: impl FnOnce(&mut Parser<'s, '_>) -> Result<T>,
) -> Parsed<T> {
    let mut unknown = Vec::new();
    let outcome = tokens(source).and_then(|tokens| {
        let mut parser = Parser::new(&tokens, names);
        let result = parse(&mut parser).and_then(|parsed| parser.end().map(|()| parsed));
        unknown = parser.unknown;
        result
    });
    Parsed { outcome, unknown }
}

pub(super) struct Parser<'s, 't> {
    tokens: &'t [Token<'s>],
    names: &'t Names,
    position: usize,
    nesting: usize,
    operators: usize,
    pub(super) unknown: Vec<ExpressionProblem>,
}

impl<'s, 't> Parser<'s, 't> {
    pub(super) fn new(tokens: &'t [Token<'s>], names: &'t Names) -> Self {
        Self { tokens, names, position: 0, nesting: 0, operators: 0, unknown: Vec::new() }
    }

    pub(super) fn peek(&self) -> &Token<'s> {
        &self.tokens[self.position]
    }

    pub(super) fn advance(&mut self) -> Token<'s> {
        let token = self.peek().clone();
        self.position = (self.position + 1).min(self.tokens.len() - 1);
        token
    }

    /// The end of the last token taken.
    pub(super) fn taken_end(&self) -> usize {
        self.position.checked_sub(1).map_or(0, |last| self.tokens[last].span.end)
    }

    pub(super) fn take_mark(&mut self, mark: &str) -> bool {
        let found = self.peek().kind == TokenKind::Mark(mark);
        if found {
            self.advance();
        }
        found
    }

    fn expect(&mut self, mark: &str, opened: &Range<usize>) -> Result<()> {
        if self.take_mark(mark) {
            return Ok(());
        }
        let message = format!("`{mark}` is missing");
        Err(self.unexpected(&message).with_help(format!("to close what was opened at character {}", opened.start + 1)))
    }

    pub(super) fn end(&mut self) -> Result<()> {
        match &self.peek().kind {
            TokenKind::End => Ok(()),
            TokenKind::Mark("=") => {
                let help = "use `==` or `===` to compare, or an <assign> element to assign";
                let problem = self.unexpected("`=` assigns; it does not compare").with_help(help);
                Err(problem.of_kind(ProblemKind::Suspicious))
            }
            TokenKind::Mark(mark @ ("++" | "--" | "+=" | "-=" | "*=" | "/=" | "%=")) => {
                let message = format!("`{mark}` assigns, which is not allowed in this expression");
                Err(self.unexpected(&message).with_help("use an <assign> element"))
            }
            TokenKind::Name("and") => {
                Err(self.unexpected("the expression should end here").with_help("`&&` means and"))
            }
            TokenKind::Name("or") => Err(self.unexpected("the expression should end here").with_help("`||` means or")),
            TokenKind::Name(name @ ("instanceof" | "in")) => {
                Err(ExpressionProblem::outside_subset(&format!("`{name}`"), self.peek().span.clone()))
            }
            _ => Err(self.unexpected("the expression should end here")),
        }
    }

    pub(super) fn unexpected(&self, message: &str) -> ExpressionProblem {
        let token = self.peek();
        let label = match &token.kind {
            TokenKind::End => "the expression ends here".to_owned(),
            TokenKind::Number(_) => "not this number".to_owned(),
            TokenKind::Text(_) => "not this string".to_owned(),
            TokenKind::Name(name) => format!("not `{name}`"),
            TokenKind::Mark(mark) => format!("not `{mark}`"),
        };
        ExpressionProblem::new(message, token.span.clone(), label)
    }

    fn count_operator(&mut self) -> Result<()> {
        self.operators += 1;
        if self.operators > MAX_OPERATORS {
            return Err(self.unexpected(&format!("an expression may have at most {MAX_OPERATORS} operators")));
        }
        Ok(())
    }

    /// An expression of operators that bind at least as tightly as `power`.
    pub(super) fn expression(&mut self, power: u8) -> Result<Expr> {
        self.nesting += 1;
        if self.nesting > MAX_NESTING {
            return Err(self.unexpected(&format!("an expression may be nested at most {MAX_NESTING} deep")));
        }
        let mut left = self.prefix()?;
        while let Some((infix_power, infix)) = infix(&self.peek().kind) {
            if infix_power < power {
                break;
            }
            let mark = self.advance();
            self.count_operator()?;
            left = self.infix(left, infix, infix_power, &mark.span)?;
        }
        self.nesting -= 1;
        Ok(left)
    }

    fn infix(&mut self, left: Expr, infix: Infix, power: u8, mark: &Range<usize>) -> Result<Expr> {
        Ok(match infix {
            Infix::Binary(op) => Expr::Binary(op, Box::new([left, self.expression(power + 1)?])),
            Infix::Logic(op) => Expr::Logic(op, Box::new([left, self.expression(power + 1)?])),
            Infix::Choice => {
                let then = self.expression(0)?;
                self.expect(":", mark)?;
                Expr::Choice(Box::new([left, then, self.expression(power)?]))
            }
        })
    }

    fn prefix(&mut self) -> Result<Expr> {
        let Some(op) = prefix(&self.peek().kind) else {
            let primary = self.primary()?;
            return self.postfix(primary);
        };
        self.advance();
        self.count_operator()?;
        let unknown_before = self.unknown.len();
        let operand = self.expression(UNARY_POWER)?;
        if op == UnaryOp::TypeOf && matches!(operand, Expr::Unknown(_)) {
            // `typeof nothing` is "undefined" and not an error: people write it to test for that.
            self.unknown.truncate(unknown_before);
            return Ok(Expr::Constant("undefined".into()));
        }
        Ok(Expr::Unary(op, Box::new(operand)))
    }

    fn postfix(&mut self, mut left: Expr) -> Result<Expr> {
        loop {
            let token = self.peek().clone();
            left = match token.kind {
                TokenKind::Mark(".") => {
                    self.advance();
                    let TokenKind::Name(name) = self.peek().kind else {
                        return Err(self.unexpected("expected the name of a member after `.`"));
                    };
                    self.advance();
                    member(left, name)
                }
                TokenKind::Mark("[") => {
                    self.advance();
                    let index = self.expression(0)?;
                    self.expect("]", &token.span)?;
                    match index {
                        Expr::Constant(Datum::Text(name)) => member(left, &name),
                        index => Expr::Index(Box::new([left, index])),
                    }
                }
                TokenKind::Mark("(") => {
                    if let Expr::Unknown(_) = left {
                        // The name of a called function is not a datum and need not be declared.
                        self.unknown.pop();
                    }
                    return Err(ExpressionProblem::outside_subset("a function call", token.span));
                }
                TokenKind::Mark("?.") => return Err(ExpressionProblem::outside_subset("`?.`", token.span)),
                _ => return Ok(left),
            };
            self.count_operator()?;
        }
    }

    fn primary(&mut self) -> Result<Expr> {
        let token = self.peek().clone();
        match token.kind {
            TokenKind::Number(number) => {
                self.advance();
                Ok(Expr::Constant(number.into()))
            }
            TokenKind::Text(text) => {
                self.advance();
                Ok(Expr::Constant(Datum::text(&text)))
            }
            TokenKind::Name(name) => self.name(name, token.span),
            TokenKind::Mark("(") => {
                self.advance();
                let inner = self.expression(0)?;
                self.expect(")", &token.span)?;
                Ok(inner)
            }
            TokenKind::Mark("[") => self.array(),
            TokenKind::Mark("{") => self.object(),
            TokenKind::Mark("++" | "--") => Err(self.unexpected("assignments are not allowed in this expression")),
            TokenKind::Mark("/") => Err(ExpressionProblem::outside_subset("a regular expression", token.span)),
            TokenKind::End => Err(self.unexpected("a value is missing")),
            TokenKind::Mark(_) => Err(self.unexpected("expected a value")),
        }
    }

    fn name(&mut self, name: &'s str, span: Range<usize>) -> Result<Expr> {
        self.advance();
        if let Some(known) = system_name(name) {
            return Ok(known);
        }
        if name == "In" {
            return self.in_state();
        }
        if let Some(id) = self.names.data.get(name) {
            return Ok(Expr::Data(*id));
        }
        if is_reserved(name) {
            return Err(ExpressionProblem::outside_subset(&format!("`{name}`"), span));
        }
        let known = self.names.data.keys().map(String::as_str).chain(["_event", "In", "undefined"]);
        let help = did_you_mean(name, known).unwrap_or_else(|| "declare it with <data> in a <datamodel>".to_owned());
        let problem = ExpressionProblem::new(format!("unknown name `{name}`"), span, "unknown name");
        self.unknown.push(problem.with_help(help));
        Ok(Expr::Unknown(name.into()))
    }

    fn in_state(&mut self) -> Result<Expr> {
        let opened = self.peek().span.clone();
        self.expect("(", &opened)?;
        let argument = self.peek().span.clone();
        let state = self.expression(0)?;
        self.expect(")", &opened)?;
        let Expr::Constant(Datum::Text(id)) = &state else {
            return Ok(Expr::InDynamic(Box::new(state)));
        };
        if let Some(state) = self.names.states.get(&**id) {
            return Ok(Expr::In(*state));
        }
        let help = did_you_mean(id, self.names.states.keys().map(String::as_str));
        let problem = ExpressionProblem::new(format!("unknown state `{id}`"), argument, "unknown state");
        self.unknown.push(ExpressionProblem { help, ..problem });
        Ok(Expr::Constant(false.into()))
    }

    fn array(&mut self) -> Result<Expr> {
        let opened = self.advance().span;
        let mut items = Vec::new();
        while !self.take_mark("]") {
            items.push(self.expression(0)?);
            if !self.take_mark(",") {
                self.expect("]", &opened)?;
                break;
            }
        }
        Ok(Expr::Array(items))
    }

    fn object(&mut self) -> Result<Expr> {
        let opened = self.advance().span;
        let mut members: Vec<(Arc<str>, Expr)> = Vec::new();
        while !self.take_mark("}") {
            let key: Arc<str> = match self.peek().kind.clone() {
                TokenKind::Name(name) => name.into(),
                TokenKind::Text(text) => text.into(),
                TokenKind::Number(number) => Datum::from(number).to_text(),
                _ => return Err(self.unexpected("expected the name of a member")),
            };
            self.advance();
            self.expect(":", &opened)?;
            members.push((key, self.expression(0)?));
            if !self.take_mark(",") {
                self.expect("}", &opened)?;
                break;
            }
        }
        Ok(Expr::Object(members))
    }
}

fn member(left: Expr, name: &str) -> Expr {
    if let Expr::Event = left
        && let Some((_, field)) = EventField::ALL.iter().find(|(known, _)| *known == name)
    {
        return Expr::EventField(*field);
    }
    Expr::Member(Box::new(left), name.into())
}
