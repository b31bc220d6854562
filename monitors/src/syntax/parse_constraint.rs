//! Constraints: what a property requires.

use diagnostics::{Problem, nearest};

use super::ast::{ByteRange, Constraint, ConstraintKind, Event, Interval, Party};
use super::boolean::Boolean;
use super::parse::{ParseResult, Parser, Stumbled};
use super::token::{Keyword, TokenKind};
use crate::formula::Arithmetic;

/// The keywords that can begin a constraint.
const PREFIXES: [&str; 12] = [
    "not",
    "next",
    "always",
    "eventually",
    "once",
    "historically",
    "previous",
    "becomes",
    "fresh",
    "true",
    "false",
    "time_until",
];
const EVENT: &str = "an event is written `(sender, receiver, condition)`; `*` stands for any sender or receiver";
const TIME_UNTIL: &str = "a deadline is written `time_until (sender, receiver, condition) < 10`";
/// `*`, in the place of a process.
const ANY: TokenKind = TokenKind::Arithmetic(Arithmetic::Multiply);
const FRESH: &str = "`fresh` is about one message: `fresh (sender, receiver, condition)`";
const AGO: &str = "how long ago is written `[<= 10]` or `[<= 5 s]`";
const COUNT: &str = "a number of messages is written `at most 3 (sender, receiver, condition) in 10 s`";

const BOOLEAN: Boolean<Constraint, ConstraintKind> = Boolean {
    operand: Parser::chain,
    implies: ConstraintKind::Implies,
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
        let ago = if self.take_keyword(Keyword::Since) {
            Some(self.ago()?)
        } else if self.take_keyword(Keyword::Until) {
            None
        } else {
            return Ok(left);
        };
        let right = self.deeper(Self::chain)?;
        let span = left.span.to(right.span);
        let (left, right) = (Box::new(left), Box::new(right));
        let kind = match ago {
            Some(ago) => ConstraintKind::Since(ago, left, right),
            None => ConstraintKind::Until(left, right),
        };
        Ok(Constraint { kind, span })
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
        let wrap: fn(Box<Constraint>) -> ConstraintKind = match self.peek() {
            TokenKind::Keyword(Keyword::Not) => ConstraintKind::Not,
            TokenKind::Keyword(Keyword::Next) => ConstraintKind::Next,
            TokenKind::Keyword(Keyword::Always) => ConstraintKind::Always,
            TokenKind::Keyword(Keyword::Eventually) => ConstraintKind::Eventually,
            TokenKind::Keyword(Keyword::Becomes) => ConstraintKind::Becomes,
            TokenKind::Keyword(Keyword::Once | Keyword::Historically | Keyword::Previous) => return self.past(),
            _ => return self.primary(),
        };
        self.advance();
        let operand = self.deeper(Self::prefixed)?;
        let span = start.to(operand.span);
        Ok(Constraint { kind: wrap(Box::new(operand)), span })
    }

    /// `once`, `historically` or `previous`, and its operand.
    fn past(&mut self) -> ParseResult<Constraint> {
        let start = self.span();
        let wrap: fn(Option<Interval>, Box<Constraint>) -> ConstraintKind = match self.peek() {
            TokenKind::Keyword(Keyword::Once) => ConstraintKind::Once,
            TokenKind::Keyword(Keyword::Historically) => ConstraintKind::Historically,
            _ => ConstraintKind::Previous,
        };
        self.advance();
        let ago = self.ago()?;
        let operand = self.deeper(Self::prefixed)?;
        let span = start.to(operand.span);
        Ok(Constraint { kind: wrap(ago, Box::new(operand)), span })
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
            _ => return Err(self.expected("a constraint", &first_words())),
        };
        self.advance();
        Ok(Constraint { kind, span: start })
    }

    /// Whether the parenthesis here opens an event: a name follows that is not an operator, a misspelled operator, or
    /// one of another logic.
    fn at_event(&self) -> bool {
        match self.peek_second() {
            TokenKind::Text(_) | TokenKind::Arithmetic(Arithmetic::Multiply) => true,
            second => {
                let third = self.tokens.get(self.at + 2).map(|token| &token.kind);
                let is_name = |name: &str| third != Some(&TokenKind::Open) && nearest(name, PREFIXES).is_none();
                third == Some(&TokenKind::Comma) && second.as_name().is_some()
                    || matches!(second, TokenKind::Name(name) if is_name(name))
            }
        }
    }

    /// A name in the place of a constraint: perhaps a misspelled operator.
    fn stray_name(&mut self, name: &str) -> ParseResult<Constraint> {
        let Some(word) = nearest(name, PREFIXES) else { return Err(self.expected("a constraint", &first_words())) };
        self.expected("a constraint", &format!("did you mean `{word}`?"));
        let keyword = Keyword::ALL.into_iter().find(|keyword| keyword.text() == word);
        self.tokens[self.at].kind = TokenKind::Keyword(keyword.unwrap_or(Keyword::True));
        self.deeper(Self::prefixed)
    }

    fn parenthesised(&mut self) -> ParseResult<Constraint> {
        let open = self.span();
        let after_prefix = self.at > 0
            && matches!(
                self.tokens[self.at - 1].kind,
                TokenKind::Keyword(Keyword::Always | Keyword::Eventually | Keyword::Next | Keyword::Not)
            );
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

/// Advice where a constraint is missing.
fn first_words() -> String {
    format!("a constraint begins with {}, or is an event `(sender, receiver, condition)`", PREFIXES.join(", "))
}
