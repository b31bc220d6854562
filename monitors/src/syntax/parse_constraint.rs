//! Constraints: what a property requires.

use diagnostics::{Problem, nearest};

use super::ast::{ByteRange, Constraint, ConstraintKind, Event, Interval, Party};
use super::boolean::Boolean;
use super::parse::{ParseResult, Parser, Stumbled};
use super::token::{Keyword, TokenKind};
use crate::formula::Arithmetic;
use crate::operator::{Infix, Prefix};

const EVENT: &str = "an event is written `(sender, receiver, condition)`; `*` stands for any sender or receiver";
const TIME_UNTIL: &str = "a deadline is written `time_until (sender, receiver, condition) < 10`";
/// `*`, in the place of a process.
const ANY: TokenKind = TokenKind::Arithmetic(Arithmetic::Multiply);
const FRESH: &str = "`fresh` is about one message: `fresh (sender, receiver, condition)`";
const AGO: &str = "how long ago is written `[<= 10]` or `[<= 5 s]`";
const COUNT: &str = "a number of messages is written `at most 3 (sender, receiver, condition) in 10 s`";

const BOOLEAN: Boolean<Constraint, ConstraintKind> = Boolean {
    operand: Parser::chain,
    implies: |left, right| ConstraintKind::Infix(Infix::Implies, None, left, right),
    or: ConstraintKind::Or,
    and: ConstraintKind::And,
    tree: |kind, span| Constraint { kind, span },
};

impl Parser {
    pub(super) fn constraint(&mut self) -> ParseResult<Constraint> {
        self.implication(&BOOLEAN)
    }

    /// `α until β` and `α since β`, right-associative.
    fn chain(&mut self) -> ParseResult<Constraint> {
        let left = self.prefixed()?;
        let TokenKind::Keyword(Keyword::Infix(operator @ (Infix::Until | Infix::Since))) = *self.peek() else {
            return Ok(left);
        };
        self.advance();
        let ago = if operator.takes_bound() { self.ago()? } else { None };
        let right = self.deeper(Self::chain)?;
        let span = left.span.to(right.span);
        Ok(Constraint { kind: ConstraintKind::Infix(operator, ago, Box::new(left), Box::new(right)), span })
    }

    /// `[⋈ bound]`, if present.
    fn ago(&mut self) -> ParseResult<Option<Interval>> {
        if !self.take(&TokenKind::OpenIndex) {
            return Ok(None);
        }
        let TokenKind::Relation(relation) = *self.peek() else {
            return Err(self.expected("`<`, `<=`, `=`, `!=`, `>=` or `>` and a number of ticks", AGO));
        };
        self.advance();
        let bound = self.operand()?;
        if !self.take(&TokenKind::CloseIndex) {
            return Err(self.expected("`]`", AGO));
        }
        Ok(Some(Interval { relation, bound }))
    }

    fn prefixed(&mut self) -> ParseResult<Constraint> {
        let start = self.span();
        let TokenKind::Keyword(Keyword::Prefix(operator)) = *self.peek() else { return self.primary() };
        self.advance();
        let ago = if operator.takes_bound() { self.ago()? } else { None };
        let operand = self.deeper(Self::prefixed)?;
        let span = start.to(operand.span);
        Ok(Constraint { kind: ConstraintKind::Prefix(operator, ago, Box::new(operand)), span })
    }

    fn primary(&mut self) -> ParseResult<Constraint> {
        let start = self.span();
        let kind = match self.peek().clone() {
            TokenKind::Keyword(Keyword::True) => ConstraintKind::True,
            TokenKind::Keyword(Keyword::False) => ConstraintKind::False,
            TokenKind::Keyword(Keyword::TimeUntil) => return self.time_until(),
            TokenKind::Keyword(Keyword::At) => return self.count(),
            TokenKind::Keyword(Keyword::Fresh) => return self.fresh(),
            TokenKind::Open => {
                if !self.at_event() {
                    return self.parenthesised();
                }
                let kind = self.event().map_or(ConstraintKind::Unreadable, ConstraintKind::Event);
                return Ok(Constraint { kind, span: start.to(self.last_span()) });
            }
            TokenKind::Name(name) => return self.stray_name(&name),
            _ => return Err(self.no_constraint()),
        };
        self.advance();
        Ok(Constraint { kind, span: start })
    }

    /// Reports that a constraint is missing.
    fn no_constraint(&mut self) -> Stumbled {
        let words = first_words().collect::<Vec<_>>().join(", ");
        let help = format!("a constraint begins with {words}, or is an event `(sender, receiver, condition)`");
        self.expected("a constraint", &help)
    }

    /// Whether the parenthesis here opens an event: a name follows that is not an operator, a misspelled operator, or
    /// one of another logic.
    fn at_event(&self) -> bool {
        match self.peek_second() {
            TokenKind::Text(_) | TokenKind::Arithmetic(Arithmetic::Multiply) => true,
            second => {
                let third = self.tokens.get(self.at + 2).map(|token| &token.kind);
                let is_name = |name: &str| third != Some(&TokenKind::Open) && nearest(name, first_words()).is_none();
                third == Some(&TokenKind::Comma) && second.as_name().is_some()
                    || matches!(second, TokenKind::Name(name) if is_name(name))
            }
        }
    }

    /// A name in the place of a constraint: perhaps a misspelled operator.
    fn stray_name(&mut self, name: &str) -> ParseResult<Constraint> {
        let Some(word) = nearest(name, first_words()) else { return Err(self.no_constraint()) };
        self.expected("a constraint", &format!("did you mean `{word}`?"));
        self.tokens[self.at].kind = TokenKind::Keyword(Keyword::of(word).unwrap_or(Keyword::True));
        self.deeper(Self::prefixed)
    }

    fn parenthesised(&mut self) -> ParseResult<Constraint> {
        let open = self.span();
        let before = self.at.checked_sub(1).map(|before| &self.tokens[before].kind);
        let after_prefix =
            matches!(before, Some(TokenKind::Keyword(Keyword::Prefix(operator))) if operator.is_of_the_paper());
        self.advance();
        let inside = match self.deeper(Self::constraint) {
            Ok(inside) => inside,
            Err(Stumbled) => {
                self.recover(open);
                return Ok(Constraint { kind: ConstraintKind::Unreadable, span: open.to(self.last_span()) });
            }
        };
        // The paper's φ2 lacks its last parenthesis, so it is read with a warning; only one is added to a property.
        if self.at_item_end() && after_prefix && !self.closed_for_you {
            self.closed_for_you = true;
            let problem = Problem::new("this parenthesis is never closed").at(open, "opened here").as_warning();
            self.problems
                .push(problem.with_help("it is read as closed at the end of the property; write the `)` there"));
        } else {
            self.close(open);
        }
        Ok(Constraint { kind: inside.kind, span: open.to(self.last_span()) })
    }

    /// `(sender, receiver, condition)`; after a problem inside it, the rest is skipped.
    fn event(&mut self) -> ParseResult<Event> {
        let open = self.span();
        let event = self.event_parts(open);
        if event.is_err() {
            self.recover(open);
        }
        event
    }

    fn event_parts(&mut self, open: ByteRange) -> ParseResult<Event> {
        self.advance();
        let source = self.party("the name of the sender")?;
        self.comma("`,` and the name of the receiver")?;
        let target = self.party("the name of the receiver")?;
        self.comma("`,` and a condition on the message")?;
        let condition = self.condition()?;
        self.close(open);
        Ok(Event { source, target, condition, span: open.to(self.last_span()) })
    }

    fn party(&mut self, what: &str) -> ParseResult<Party> {
        let span = self.span();
        if self.take(&ANY) { Ok(Party::Any(span)) } else { self.name(what, EVENT).map(Party::Named) }
    }

    /// `fresh (event)`.
    fn fresh(&mut self) -> ParseResult<Constraint> {
        let start = self.span();
        self.advance();
        if *self.peek() != TokenKind::Open || !self.at_event() {
            return Err(self.expected("an event", FRESH));
        }
        let kind = self.event().map_or(ConstraintKind::Unreadable, ConstraintKind::Fresh);
        Ok(Constraint { kind, span: start.to(self.last_span()) })
    }

    /// `at most n (event) in bound`, or `at least`.
    fn count(&mut self) -> ParseResult<Constraint> {
        let start = self.span();
        self.advance();
        let is_at_most = self.take_keyword(Keyword::Most);
        if !is_at_most && !self.take_keyword(Keyword::Least) {
            return Err(self.expected("`most` or `least`", COUNT));
        }
        let count = self.operand()?;
        if *self.peek() != TokenKind::Open {
            return Err(self.expected("`(` and an event", COUNT));
        }
        let event = self.event();
        if !self.take_keyword(Keyword::In) {
            return Err(self.expected("`in` and a number of ticks or a duration", COUNT));
        }
        let bound = self.operand()?;
        let kind =
            event.map_or(ConstraintKind::Unreadable, |event| ConstraintKind::Count { is_at_most, count, event, bound });
        Ok(Constraint { kind, span: start.to(self.last_span()) })
    }

    fn comma(&mut self, what: &str) -> ParseResult<()> {
        if self.take(&TokenKind::Comma) { Ok(()) } else { Err(self.expected(what, EVENT)) }
    }

    fn time_until(&mut self) -> ParseResult<Constraint> {
        let start = self.span();
        self.advance();
        let open = self.span();
        if *self.peek() != TokenKind::Open {
            return Err(self.expected("`(` and an event", TIME_UNTIL));
        }
        let event = if *self.peek_second() == TokenKind::Open {
            self.advance();
            let event = self.event();
            self.close(open);
            event
        } else {
            self.event()
        };
        let TokenKind::Relation(relation) = *self.peek() else {
            return Err(self.expected("`<`, `<=`, `=`, `!=`, `>=` or `>` and a number of ticks", TIME_UNTIL));
        };
        self.advance();
        let bound = self.operand()?;
        let span = start.to(self.last_span());
        let kind =
            event.map_or(ConstraintKind::Unreadable, |event| ConstraintKind::TimeUntil { event, relation, bound });
        Ok(Constraint { kind, span })
    }
}

/// The keywords that can begin a constraint.
fn first_words() -> impl Iterator<Item = &'static str> + Clone {
    let others = ["fresh", "true", "false", "time_until"];
    Prefix::ALL.into_iter().map(Prefix::word).chain(others)
}
