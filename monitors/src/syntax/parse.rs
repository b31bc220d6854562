//! Parses a property file into its tree and collects all its problems.
//!
//! ```text
//! file       = { "const" name ":=" literal [";"] | [ "timed" ] "property" name ":=" constraint [";"] }
//! constraint = disjunction [ "implies" constraint ]
//! disjunction = conjunction { "or" conjunction }          conjunction = chain { "and" chain }
//! chain      = prefixed [ ( "until" | "since" [ ago ] ) chain ]
//! prefixed   = ( "not" | "next" | "always" | "eventually" ) prefixed
//!            | ( "once" | "historically" | "previous" ) [ ago ] prefixed | "becomes" prefixed | primary
//! ago        = "[" relation bound "]"
//! primary    = "true" | "false" | "(" constraint ")" | event
//!            | "time_until" ( "(" event ")" | event ) relation bound
//!            | "at" ( "most" | "least" ) count event "in" bound
//! event      = "(" ( name | "*" ) "," ( name | "*" ) "," condition ")"
//! ```

use channels::Relation;
use diagnostics::{Problem, nearest, nearest_or_all};

use super::ast::{ByteRange, Constant, File, Item, Literal, Name, Operand, PropertyItem};
use super::quantity::{UNITS, in_si, plain};
use super::real::Unfit;
use super::token::{Keyword, Token, TokenKind, tokens};
use crate::formula::{Arithmetic, Unit};

/// A tree deeper than this is refused, so that no text can exhaust the stack. Chosen, not measured.
const MAX_DEPTH: usize = 100;

/// A comparison has at most this many operators on numbers, for the same reason: a term is a tree as deep as it has
/// operators in a row. Chosen, not measured.
pub(super) const MAX_OPERATORS: usize = 200;

/// The result of parsing.
#[derive(Clone, Debug)]
pub struct Parsed {
    /// The tree; parts that could not be read are `ConstraintKind::Unreadable`.
    pub file: File,
    /// All problems of the text, including warnings, in order.
    pub problems: Vec<Problem>,
}

/// Parses the text of a property file. It always terminates, and collects all problems on the way.
#[must_use]
pub fn parse_file(text: &str) -> Parsed {
    if let Some(problem) = foreign(text) {
        return Parsed { file: File::default(), problems: vec![problem] };
    }
    let mut problems = Vec::new();
    let tokens = tokens(text, &mut problems);
    let mut parser = Parser { tokens, at: 0, problems, depth: 0, operators: 0, closed_for_you: false };
    let items = parser.items();
    let mut problems = parser.problems;
    problems.sort_by_key(Problem::offset);
    Parsed { file: File { items }, problems }
}

/// The problem of a text that is written in another language altogether.
fn foreign(text: &str) -> Option<Problem> {
    let start = text.len() - text.trim_start_matches(|c: char| c.is_whitespace() || c == '\u{FEFF}').len();
    let language = match text[start..].chars().next()? {
        '{' | '[' if text.contains("\"jani-version\"") => "a JANI model",
        '{' | '[' => "JSON",
        '<' if text.contains("<scxml") => "an SCXML machine",
        '<' => "XML",
        _ => return None,
    };
    let problem = Problem::new(format!("this is {language}, not a file of SCOPE properties"));
    let help = "write each requirement as `property NAME := always (sender, receiver, condition)`";
    Some(problem.at(start..start + 1, "begins here").with_help(help))
}

pub(super) struct Parser {
    pub(super) tokens: Vec<Token>,
    pub(super) at: usize,
    pub(super) problems: Vec<Problem>,
    depth: usize,
    /// The number of operators on numbers in the current comparison.
    pub(super) operators: usize,
    /// Whether a parenthesis of this property was closed at its end, as for the paper's φ2.
    pub(super) closed_for_you: bool,
}

/// A problem has been reported; parsing continues around it.
pub(super) struct Stumbled;

pub(super) type ParseResult<T> = Result<T, Stumbled>;

impl Parser {
    pub(super) fn peek(&self) -> &TokenKind {
        &self.tokens[self.at].kind
    }

    pub(super) fn peek_second(&self) -> &TokenKind {
        &self.tokens[(self.at + 1).min(self.tokens.len() - 1)].kind
    }

    pub(super) fn span(&self) -> ByteRange {
        self.tokens[self.at].span
    }

    /// The span of the last token taken.
    pub(super) fn last_span(&self) -> ByteRange {
        self.tokens[self.at.saturating_sub(1)].span
    }

    pub(super) fn advance(&mut self) {
        self.at = (self.at + 1).min(self.tokens.len() - 1);
    }

    pub(super) fn take(&mut self, kind: &TokenKind) -> bool {
        let found = self.peek() == kind;
        if found {
            self.advance();
        }
        found
    }

    pub(super) fn take_keyword(&mut self, keyword: Keyword) -> bool {
        self.take(&TokenKind::Keyword(keyword))
    }

    /// Reports that something else was expected here, with advice; at the end of an item, directly after its last
    /// token.
    pub(super) fn expected(&mut self, what: &str, help: &str) -> Stumbled {
        let (found, span) = if self.at > 0 && self.at_item_end() {
            let end = self.last_span().end;
            ("the end".to_owned(), ByteRange { start: end, end })
        } else {
            (self.peek().describe(), self.span())
        };
        let problem = Problem::new(format!("expected {what}, found {found}"));
        self.problems.push(problem.at(span, format!("expected {what}")).with_help(help));
        Stumbled
    }

    /// Reports that a binary operator was expected here: suggests the nearest one, or lists all of them.
    fn expected_operator(&mut self, what: &str) {
        let name = if let TokenKind::Name(name) = self.peek() { name } else { "" };
        let help = nearest_or_all(name, "the binary operators", &["and", "or", "implies", "until", "since"]);
        self.expected(what, &help);
    }

    pub(super) fn at_item_end(&self) -> bool {
        match self.peek() {
            TokenKind::Keyword(Keyword::Timed) => *self.peek_second() == TokenKind::Keyword(Keyword::Property),
            TokenKind::Keyword(Keyword::Const | Keyword::Property) => true,
            other => matches!(other, TokenKind::End | TokenKind::Semicolon),
        }
    }

    /// Parses one level deeper in the tree.
    pub(super) fn deeper<T>(&mut self, read: impl FnOnce(&mut Self) -> ParseResult<T>) -> ParseResult<T> {
        if self.depth >= MAX_DEPTH {
            let problem =
                Problem::new("this is nested too deeply").at(self.span(), format!("deeper than {MAX_DEPTH} levels"));
            self.problems.push(problem.with_help("split it into several properties"));
            return Err(Stumbled);
        }
        self.depth += 1;
        let result = read(self);
        self.depth -= 1;
        result
    }

    fn items(&mut self) -> Vec<Item> {
        let mut items = Vec::new();
        while *self.peek() != TokenKind::End {
            let start = self.span();
            let is_timed = self.at_item_end() && self.take_keyword(Keyword::Timed);
            let keyword = match self.peek() {
                TokenKind::Keyword(keyword @ (Keyword::Const | Keyword::Property)) => Some(*keyword),
                TokenKind::Semicolon => {
                    self.advance();
                    continue;
                }
                _ => self.misspelt_item(),
            };
            self.closed_for_you = false;
            match keyword {
                Some(keyword) => {
                    self.advance();
                    if let Ok(item) = self.item(keyword, is_timed, start) {
                        items.push(item);
                    }
                }
                // What follows up to the next item is skipped, so one mistake is one problem.
                None => {
                    self.expected("`const` or `property`", "a requirement is written `property NAME := …`");
                    self.advance();
                }
            }
            self.skip_to_item_end();
        }
        items
    }

    /// `propery phi1 := …`: reports the misspelling and continues as if it were spelled correctly.
    fn misspelt_item(&mut self) -> Option<Keyword> {
        let TokenKind::Name(name) = self.peek() else { return None };
        let is_definition = matches!(self.peek_second(), TokenKind::Name(_));
        let word = nearest(name, ["const", "property"]).filter(|_| is_definition)?;
        self.expected("`const` or `property`", &format!("did you mean `{word}`?"));
        Some(if word == "const" { Keyword::Const } else { Keyword::Property })
    }

    fn item(&mut self, keyword: Keyword, is_timed: bool, start: ByteRange) -> ParseResult<Item> {
        let is_constant = keyword == Keyword::Const;
        let (what, form) = match is_constant {
            true => ("the name of a constant", "a constant is written `const NAME := VALUE`"),
            false => ("the name of a property", "a property is written `property NAME := always …`"),
        };
        let name = self.name(what, form)?;
        self.define(form)?;
        let item = if is_constant {
            let start = self.span();
            let value = self.literal()?;
            Item::Constant(Constant { name, value, value_span: start.to(self.last_span()) })
        } else {
            let constraint = self.constraint()?;
            let span = start.to(self.last_span());
            Item::Property(Box::new(PropertyItem { name, is_timed, constraint, span }))
        };
        self.end_of_item();
        Ok(item)
    }

    fn define(&mut self, form: &str) -> ParseResult<()> {
        if self.take(&TokenKind::Define) {
            return Ok(());
        }
        if *self.peek() == TokenKind::Relation(Relation::Equal) {
            self.expected("`:=`", "define a name with `:=`; `=` compares");
            self.advance();
            return Ok(());
        }
        Err(self.expected("`:=`", form))
    }

    fn end_of_item(&mut self) {
        if self.at_item_end() {
            return;
        }
        if *self.peek() == TokenKind::Close {
            self.problems
                .push(Problem::new("unmatched closing parenthesis").at(self.span(), "no parenthesis is open here"));
        } else if self.misspelt_item().is_none() {
            self.expected_operator("an operator, or the next `const` or `property`");
        } else {
            // The next item's own parsing would report the misspelling again.
            self.problems.pop();
        }
    }

    fn skip_to_item_end(&mut self) {
        let is_misspelt = |parser: &mut Self| {
            let noted = parser.problems.len();
            let misspelt = parser.misspelt_item().is_some()
                && parser.tokens.get(parser.at + 2).map(|token| &token.kind) == Some(&TokenKind::Define);
            parser.problems.truncate(noted);
            misspelt
        };
        while !self.at_item_end() && !is_misspelt(self) {
            self.advance();
        }
    }

    pub(super) fn name(&mut self, what: &str, help: &str) -> ParseResult<Name> {
        let text = match self.peek() {
            TokenKind::Text(text) => Some(text.as_str()),
            token => token.as_name(),
        };
        let Some(text) = text else {
            let is_keyword = matches!(self.peek(), TokenKind::Keyword(_)) && !self.at_item_end();
            let keyword = "this is a keyword; to use it as a name, put it in quotes";
            return Err(self.expected(what, if is_keyword { keyword } else { help }));
        };
        let name = Name { text: text.to_owned(), span: self.span() };
        self.advance();
        Ok(name)
    }

    /// A literal: number, duration, symbol, truth value or text.
    pub(super) fn literal(&mut self) -> ParseResult<Literal> {
        let literal = match self.peek() {
            TokenKind::Symbol(symbol) => Literal::Symbol(symbol.clone()),
            TokenKind::Text(text) => Literal::Text(text.clone()),
            TokenKind::Keyword(Keyword::True) => Literal::Bool(true),
            TokenKind::Keyword(Keyword::False) => Literal::Bool(false),
            TokenKind::Number(number) => {
                let number = number.clone();
                return self.number(&number);
            }
            _ => {
                let help = "a number may have a unit, as in `30 s`; a symbol is written `<ok>`, a string `\"ok\"`";
                return Err(self.expected("a number, a symbol, a string, `true` or `false`", help));
            }
        };
        self.advance();
        Ok(literal)
    }

    fn number(&mut self, number: &str) -> ParseResult<Literal> {
        let span = self.span();
        self.advance();
        let Some((unit, length)) = self.unit() else { return self.fitting(span, plain(number)) };
        let begin = self.span();
        (0..length).for_each(|_| self.advance());
        self.quantity(number, span, &unit, begin.to(self.last_span()))
    }

    /// The unit here, and its length in tokens: `m/s` has three, without blanks.
    fn unit(&self) -> Option<(String, usize)> {
        let word = |place: usize| self.tokens.get(self.at + place).map(|token| (&token.kind, token.span));
        Some(match (word(0)?, word(1), word(2)) {
            ((TokenKind::Percent, _), ..) => ("%".to_owned(), 1),
            (
                (TokenKind::Name(of), first),
                Some((TokenKind::Arithmetic(Arithmetic::Divide), by)),
                Some((TokenKind::Name(per), last)),
            ) if first.end == by.start && by.end == last.start => (format!("{of}/{per}"), 3),
            // Two names in a row begin a misspelled item: the first is not a unit.
            ((TokenKind::Name(_), _), Some((TokenKind::Name(_) | TokenKind::Define, _)), _) => return None,
            ((TokenKind::Name(of), _), ..) => (of.clone(), 1),
            _ => return None,
        })
    }

    /// The literal, or the problem that it has.
    fn fitting(&mut self, span: ByteRange, literal: Result<Literal, Unfit>) -> ParseResult<Literal> {
        literal.map_err(|unfit| {
            self.problems.push(match unfit {
                Unfit::TooLarge => Problem::new("this number is too large").at(span, "does not fit"),
                Unfit::Rounded(rounded) => {
                    let rounded = Literal::Real(rounded);
                    let problem = Problem::new(format!("this number would be rounded to {rounded}"));
                    let help = format!("write `{rounded}`, or an integer, which is exact");
                    problem.at(span, "not exact").with_help(help)
                }
            });
            Stumbled
        })
    }

    fn quantity(&mut self, number: &str, span: ByteRange, unit: &str, unit_span: ByteRange) -> ParseResult<Literal> {
        if matches!(unit, "tick" | "ticks") {
            return number.parse().map(Literal::Int).map_err(|_| {
                let problem = Problem::new("the number of ticks must be whole").at(span, "not a whole number");
                self.problems.push(problem);
                Stumbled
            });
        }
        if let Some((_, scale)) = UNITS.into_iter().find(|(known, _)| *known == unit) {
            return self.fitting(span, in_si(number, scale));
        }
        let Some(known) = Unit::ALL.into_iter().find(|known| known.name() == unit) else {
            let problem = Problem::new(format!("unknown unit `{unit}`")).at(unit_span, "not a unit");
            let others = UNITS.map(|(unit, _)| unit).join(", ");
            self.problems.push(problem.with_help(format!("the units are ticks, ms, s, min and h, and {others}")));
            return Err(Stumbled);
        };
        let nanos = nanos(number, known).ok_or_else(|| {
            let problem = Problem::new("this is not a valid duration")
                .at(span.to(unit_span), "negative, too long or too precise");
            self.problems.push(problem.with_help("a duration is a whole number of nanoseconds, at most 500 years"));
            Stumbled
        })?;
        Ok(Literal::Duration { nanos, unit: known })
    }

    /// Takes the parenthesis that closes the one at `open`, or reports that it is missing and searches for it.
    pub(super) fn close(&mut self, open: ByteRange) {
        if self.take(&TokenKind::Close) {
            return;
        }
        if self.at_item_end() {
            let problem = Problem::new("this parenthesis is never closed").at(open, "opened here");
            self.problems.push(problem.with_help("the property ends before its `)`"));
        } else {
            self.expected_operator("an operator or `)`");
            self.recover(open);
        }
    }

    /// Recovers from a problem inside parentheses: skips to the closing one and takes it.
    pub(super) fn recover(&mut self, open: ByteRange) {
        let opened = self.tokens.partition_point(|token| token.span.start < open.start).min(self.at);
        let mut depth = 0_usize;
        for token in &self.tokens[opened..self.at] {
            match token.kind {
                TokenKind::Open => depth += 1,
                TokenKind::Close => depth = depth.saturating_sub(1),
                _ => {}
            }
        }
        while depth > 0 && !self.at_item_end() {
            match self.peek() {
                TokenKind::Open => depth += 1,
                TokenKind::Close => depth -= 1,
                _ => {}
            }
            self.advance();
        }
    }

    /// A literal or the name of a constant.
    pub(super) fn operand(&mut self) -> ParseResult<Operand> {
        if let Some(text) = self.peek().as_name() {
            let name = Name { text: text.to_owned(), span: self.span() };
            self.advance();
            return Ok(Operand::Constant(name));
        }
        let start = self.span();
        let literal = self.literal()?;
        Ok(Operand::Literal(literal, start.to(self.last_span())))
    }
}

/// A decimal number of units in nanoseconds, if that is a whole number.
fn nanos(number: &str, unit: Unit) -> Option<u64> {
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    let fraction = fraction.trim_end_matches('0');
    let scale = 10_u128.checked_pow(u32::try_from(fraction.len()).ok()?)?;
    let digits: u128 = format!("{whole}{fraction}").parse().ok()?;
    let scaled = digits.checked_mul(u128::from(unit.nanos()))?;
    (scaled % scale == 0).then_some(scaled / scale)?.try_into().ok()
}
