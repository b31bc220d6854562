//! Formulas over the parameters of a campaign: numbers, names, `+ - * /` and parentheses.

use std::fmt;
use std::iter::Peekable;

/// A formula, such as `drain * (distance / 0.45 + lost + 2)`.
///
/// ```
/// use campaigns::Formula;
///
/// let formula = Formula::parse("2 * (a + 1) - a / 4")?;
/// assert_eq!(formula.value(&|name| (name == "a").then_some(8.0)), Some(16.0));
/// # Ok::<(), campaigns::FormulaError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    text: String,
    root: Arithmetic,
}

/// Why a text is not a formula.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FormulaError {
    /// It is longer than this, in bytes.
    #[error("a formula may have at most {0} characters")]
    TooLong(usize),
    /// Its parentheses are nested too deeply.
    #[error("the parentheses are nested too deeply")]
    TooDeep,
    /// It ends before it is complete.
    #[error("the formula is incomplete")]
    Unfinished,
    /// A parenthesis is not closed.
    #[error("a `)` is missing")]
    Unclosed,
    /// It is complete before this.
    #[error("unexpected `{0}` after the end of the formula")]
    Superfluous(String),
    /// There should be a number, a name or a parenthesis instead of this.
    #[error("unexpected `{0}`")]
    Misplaced(String),
    /// This looks like a number but is not one.
    #[error("`{0}` is not a number")]
    NotANumber(String),
    /// Formulas do not contain this character.
    #[error("unknown character `{0}`")]
    Meaningless(char),
}

/// A part of a formula.
#[derive(Clone, Debug, PartialEq)]
enum Arithmetic {
    Number(f64),
    Name(String),
    Negative(Box<Self>),
    Both(Box<Self>, char, Box<Self>),
}

impl Formula {
    /// Reads a formula.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, FormulaError> {
        if text.len() > LONGEST {
            return Err(FormulaError::TooLong(LONGEST));
        }
        let mut parser = Parser { lexemes: lexemes(text)?.into_iter().peekable() };
        let root = parser.sum(0)?;
        match parser.lexemes.next() {
            None => Ok(Self { text: text.to_owned(), root }),
            Some(lexeme) => Err(FormulaError::Superfluous(lexeme.to_string())),
        }
    }

    /// Its value; `value` looks up the names. None if a name has no value or the result is not finite.
    #[must_use]
    pub fn value(&self, value: &impl Fn(&str) -> Option<f64>) -> Option<f64> {
        self.root.value(value).filter(|value| value.is_finite())
    }

    /// The names in it, in order of first appearance.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        let mut names = Vec::new();
        self.root.collect(&mut names);
        names
    }
}

/// As written.
impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Arithmetic {
    fn value(&self, of: &impl Fn(&str) -> Option<f64>) -> Option<f64> {
        Some(match self {
            Self::Number(number) => *number,
            Self::Name(name) => of(name)?,
            Self::Negative(node) => -node.value(of)?,
            Self::Both(left, sign, right) => {
                let (left, right) = (left.value(of)?, right.value(of)?);
                match sign {
                    '+' => left + right,
                    '-' => left - right,
                    '*' => left * right,
                    _ => left / right,
                }
            }
        })
    }

    fn collect<'n>(&'n self, names: &mut Vec<&'n str>) {
        match self {
            Self::Number(_) => {}
            Self::Name(name) if names.contains(&name.as_str()) => {}
            Self::Name(name) => names.push(name),
            Self::Negative(node) => node.collect(names),
            Self::Both(left, _, right) => {
                left.collect(names);
                right.collect(names);
            }
        }
    }
}

/// A lexeme of a formula's text.
#[derive(Clone, Debug, PartialEq)]
enum Lexeme {
    Number(f64),
    Name(String),
    Sign(char),
}

impl fmt::Display for Lexeme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Name(name) => f.write_str(name),
            Self::Sign(sign) => sign.fmt(f),
        }
    }
}

fn lexemes(text: &str) -> Result<Vec<Lexeme>, FormulaError> {
    let (mut lexemes, mut rest) = (Vec::new(), text.trim_start());
    while let Some(first) = rest.chars().next() {
        let of_name = |letter: char| letter.is_alphanumeric() || letter == '_';
        let of_number = |letter: char| letter.is_ascii_digit() || letter == '.';
        let end = |part: fn(char) -> bool| rest.find(|letter| !part(letter)).unwrap_or(rest.len());
        let (lexeme, taken) = if of_number(first) {
            let number = &rest[..end(of_number)];
            let parsed = number.parse().map_err(|_| FormulaError::NotANumber(number.to_owned()))?;
            (Lexeme::Number(parsed), number.len())
        } else if of_name(first) {
            let name = &rest[..end(of_name)];
            (Lexeme::Name(name.to_owned()), name.len())
        } else if "+-*/()".contains(first) {
            (Lexeme::Sign(first), 1)
        } else {
            return Err(FormulaError::Meaningless(first));
        };
        lexemes.push(lexeme);
        rest = rest[taken..].trim_start();
    }
    Ok(lexemes)
}

/// The greatest length of a formula, in bytes.
const LONGEST: usize = 1000;
/// The greatest nesting depth of parentheses.
const DEEPEST: usize = 100;

struct Parser<I: Iterator<Item = Lexeme>> {
    lexemes: Peekable<I>,
}

impl<I: Iterator<Item = Lexeme>> Parser<I> {
    fn sum(&mut self, depth: usize) -> Result<Arithmetic, FormulaError> {
        self.chain(['+', '-'], |parser| parser.product(depth))
    }

    fn product(&mut self, depth: usize) -> Result<Arithmetic, FormulaError> {
        self.chain(['*', '/'], |parser| parser.single(depth))
    }

    /// Parses operands with operators of one kind between them, from left to right.
    fn chain(
        &mut self,
        signs: [char; 2],
        part: impl Fn(&mut Self) -> Result<Arithmetic, FormulaError>,
    ) -> Result<Arithmetic, FormulaError> {
        let mut left = part(self)?;
        let is_sign = |lexeme: &Lexeme| matches!(lexeme, Lexeme::Sign(sign) if signs.contains(sign));
        while let Some(Lexeme::Sign(sign)) = self.lexemes.next_if(is_sign) {
            left = Arithmetic::Both(Box::new(left), sign, Box::new(part(self)?));
        }
        Ok(left)
    }

    fn single(&mut self, depth: usize) -> Result<Arithmetic, FormulaError> {
        match self.lexemes.next() {
            _ if depth > DEEPEST => Err(FormulaError::TooDeep),
            Some(Lexeme::Number(number)) => Ok(Arithmetic::Number(number)),
            Some(Lexeme::Name(name)) => Ok(Arithmetic::Name(name)),
            Some(Lexeme::Sign('-')) => Ok(Arithmetic::Negative(Box::new(self.single(depth + 1)?))),
            Some(Lexeme::Sign('(')) => {
                let inside = self.sum(depth + 1)?;
                let closes = self.lexemes.next() == Some(Lexeme::Sign(')'));
                if closes { Ok(inside) } else { Err(FormulaError::Unclosed) }
            }
            Some(lexeme) => Err(FormulaError::Misplaced(lexeme.to_string())),
            None => Err(FormulaError::Unfinished),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Option<f64> {
        Formula::parse(text).unwrap().value(&|name| match name {
            "a" => Some(3.0),
            "zero" => Some(0.0),
            _ => None,
        })
    }

    #[test]
    fn multiplication_binds_tighter_and_operators_are_left_associative() {
        assert_eq!(value("1 + 2 * a"), Some(7.0));
        assert_eq!(value("(1 + 2) * a"), Some(9.0));
        assert_eq!(value("10 - 3 - 2"), Some(5.0));
        assert_eq!(value("12 / 2 / a"), Some(2.0));
        assert_eq!(value("-a * -(2 - 1.5)"), Some(1.5));
        assert_eq!(value("a / zero"), None);
        assert_eq!(value("b"), None);
        assert_eq!(Formula::parse("a*b + a").unwrap().names(), ["a", "b"]);
    }

    #[test]
    fn errors_are_reported() {
        for (text, wanted) in [
            ("1 +", FormulaError::Unfinished),
            ("(1", FormulaError::Unclosed),
            ("1 2", FormulaError::Superfluous("2".to_owned())),
            ("a ^ 2", FormulaError::Meaningless('^')),
            ("1.2.3", FormulaError::NotANumber("1.2.3".to_owned())),
            ("* 2", FormulaError::Misplaced("*".to_owned())),
            (&"(".repeat(500), FormulaError::TooDeep),
            (&"1".repeat(1001), FormulaError::TooLong(1000)),
        ] {
            assert_eq!(Formula::parse(text), Err(wanted));
        }
    }
}
