//! `implies`, `or` and `and`, which join constraints and conditions in the same way.

use super::ast::ByteRange;
use super::parse::{ParseResult, Parser};
use super::token::Keyword;
use crate::operator::Infix;

/// What Boolean operators join: trees `T` with roots `K`.
pub(super) struct Boolean<T, K> {
    /// Parses an operand of `and`.
    pub(super) operand: fn(&mut Parser) -> ParseResult<T>,
    pub(super) implies: fn(Box<T>, Box<T>) -> K,
    pub(super) or: fn(Vec<T>) -> K,
    pub(super) and: fn(Vec<T>) -> K,
    pub(super) tree: fn(K, ByteRange) -> T,
}

impl Parser {
    /// `α implies β`, right-associative.
    pub(super) fn implication<T, K>(&mut self, of: &Boolean<T, K>) -> ParseResult<T> {
        let start = self.span();
        let left = self.joined(of, Keyword::Or)?;
        if !self.take_keyword(Keyword::Infix(Infix::Implies)) {
            return Ok(left);
        }
        let right = self.deeper(|parser| parser.implication(of))?;
        Ok((of.tree)((of.implies)(Box::new(left), Box::new(right)), start.to(self.last_span())))
    }

    /// Operands joined by `or`, or by `and`.
    fn joined<T, K>(&mut self, of: &Boolean<T, K>, word: Keyword) -> ParseResult<T> {
        let operand = |parser: &mut Self| match word {
            Keyword::Or => parser.joined(of, Keyword::And),
            _ => (of.operand)(parser),
        };
        let start = self.span();
        let mut operands = vec![operand(self)?];
        while self.take_keyword(word) {
            operands.push(operand(self)?);
        }
        if operands.len() == 1 {
            return Ok(operands.remove(0));
        }
        let join = if word == Keyword::Or { of.or } else { of.and };
        Ok((of.tree)(join(operands), start.to(self.last_span())))
    }
}
