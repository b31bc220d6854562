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
    Both(Box<Self>, &'static str, Box<Self>),
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
        let mut lexemes = lexemes(text)?;
        let root = sum(&mut lexemes, 0)?;
        match lexemes.next() {
            None => Ok(Self { text: text.to_owned(), root }),
            Some(lexeme) => Err(FormulaError::Superfluous(lexeme.to_owned())),
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
                match *sign {
                    "+" => left + right,
                    "-" => left - right,
                    "*" => left * right,
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

/// The greatest length of a formula, in bytes.
const LONGEST: usize = 1000;
/// The greatest nesting depth of parentheses.
const DEEPEST: usize = 100;

/// The lexemes that are still to be parsed: numbers, names and signs, as written.
type Lexemes<'t> = Peekable<std::vec::IntoIter<&'t str>>;

fn is_of_number(letter: char) -> bool {
    letter.is_ascii_digit() || letter == '.'
}

fn is_of_name(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

fn lexemes(text: &str) -> Result<Lexemes<'_>, FormulaError> {
    let (mut lexemes, mut rest) = (Vec::new(), text.trim_start());
    while let Some(first) = rest.chars().next() {
        let end = |part: fn(char) -> bool| rest.find(|letter| !part(letter)).unwrap_or(rest.len());
        let length = match first {
            _ if is_of_number(first) => end(is_of_number),
            _ if is_of_name(first) => end(is_of_name),
            '+' | '-' | '*' | '/' | '(' | ')' => 1,
            _ => return Err(FormulaError::Meaningless(first)),
        };
        lexemes.push(&rest[..length]);
        rest = rest[length..].trim_start();
    }
    Ok(lexemes.into_iter().peekable())
}

fn sum(lexemes: &mut Lexemes<'_>, depth: usize) -> Result<Arithmetic, FormulaError> {
    chain(lexemes, ["+", "-"], |lexemes| product(lexemes, depth))
}

fn product(lexemes: &mut Lexemes<'_>, depth: usize) -> Result<Arithmetic, FormulaError> {
    chain(lexemes, ["*", "/"], |lexemes| single(lexemes, depth))
}

/// Parses operands with operators of one kind between them, from left to right.
fn chain(
    lexemes: &mut Lexemes<'_>,
    signs: [&'static str; 2],
    part: impl Fn(&mut Lexemes<'_>) -> Result<Arithmetic, FormulaError>,
) -> Result<Arithmetic, FormulaError> {
    let mut left = part(lexemes)?;
    while let Some(sign) = signs.into_iter().find(|sign| lexemes.next_if_eq(sign).is_some()) {
        left = Arithmetic::Both(Box::new(left), sign, Box::new(part(lexemes)?));
    }
    Ok(left)
}

fn single(lexemes: &mut Lexemes<'_>, depth: usize) -> Result<Arithmetic, FormulaError> {
    match lexemes.next() {
        _ if depth > DEEPEST => Err(FormulaError::TooDeep),
        Some("-") => Ok(Arithmetic::Negative(Box::new(single(lexemes, depth + 1)?))),
        Some("(") => {
            let inside = sum(lexemes, depth + 1)?;
            if lexemes.next() == Some(")") { Ok(inside) } else { Err(FormulaError::Unclosed) }
        }
        Some(number) if number.starts_with(is_of_number) => {
            number.parse().map(Arithmetic::Number).map_err(|_| FormulaError::NotANumber(number.to_owned()))
        }
        Some(name) if name.starts_with(is_of_name) => Ok(Arithmetic::Name(name.to_owned())),
        Some(sign) => Err(FormulaError::Misplaced(sign.to_owned())),
        None => Err(FormulaError::Unfinished),
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
