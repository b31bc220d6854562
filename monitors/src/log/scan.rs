//! Reads the JSON of a log's line without building a tree.

use std::borrow::Cow;
use std::time::Duration;

/// The problem, and the byte at which it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unreadable {
    pub(super) at: usize,
    pub(super) problem: &'static str,
}

/// A value, or the brace that opens one.
#[derive(Debug, PartialEq)]
pub(super) enum JsonToken<'a> {
    Bool(bool),
    Int(i64),
    Real(f64),
    Text(Cow<'a, str>),
    Open,
}

/// Goes through the bytes of a line.
#[derive(Debug)]
pub(super) struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// The maximum depth of nested values that are skipped: chosen, not measured.
const MAX_DEPTH: usize = 64;

impl<'a> Scanner<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    pub(super) fn unreadable(&self, problem: &'static str) -> Unreadable {
        Unreadable { at: self.at.min(self.bytes.len()), problem }
    }

    fn skip_blank(&mut self) {
        while matches!(self.bytes.get(self.at), Some(b' ' | b'\t' | b'\r' | b'\n')) {
            self.at += 1;
        }
    }

    /// Whether only white space remains.
    pub(super) fn at_end(&mut self) -> bool {
        self.skip_blank();
        self.at >= self.bytes.len()
    }

    pub(super) fn take(&mut self, byte: u8) -> bool {
        self.skip_blank();
        let found = self.bytes.get(self.at) == Some(&byte);
        self.at += usize::from(found);
        found
    }

    pub(super) fn expect(&mut self, byte: u8) -> Result<(), Unreadable> {
        if self.take(byte) {
            return Ok(());
        }
        Err(self.unreadable(match byte {
            b'{' => "expected `{`",
            b'}' => "expected `,` or `}`",
            b'[' => "expected `[`",
            b']' => "expected `,` or `]`",
            _ => "expected `:`",
        }))
    }

    /// A string as written, escapes included; the names in a log have none.
    pub(super) fn string(&mut self) -> Result<&'a [u8], Unreadable> {
        self.skip_blank();
        if self.bytes.get(self.at) != Some(&b'"') {
            return Err(self.unreadable("expected a string"));
        }
        let start = self.at + 1;
        let mut end = start;
        loop {
            match self.bytes.get(end) {
                None | Some(b'\n') => return Err(self.unreadable("this string never ends")),
                Some(b'"') => break,
                Some(b'\\') => end += 2,
                Some(_) => end += 1,
            }
        }
        self.at = end + 1;
        Ok(&self.bytes[start..end])
    }

    /// Two strings in brackets.
    pub(super) fn pair(&mut self) -> Result<[&'a [u8]; 2], Unreadable> {
        self.expect(b'[')?;
        let first = self.string()?;
        if !self.take(b',') {
            return Err(self.unreadable("expected two names"));
        }
        let second = self.string()?;
        self.expect(b']')?;
        Ok([first, second])
    }

    /// The bytes of a number.
    fn number(&mut self) -> Result<&'a str, Unreadable> {
        self.skip_blank();
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let is_part = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'+' | b'.' | b'e' | b'E');
        let length = rest.iter().take_while(|byte| is_part(byte)).count();
        let text = std::str::from_utf8(&rest[..length]).ok().filter(|text| !text.is_empty());
        let text = text.ok_or_else(|| self.unreadable("expected a number"))?;
        self.at += length;
        Ok(text)
    }

    pub(super) fn whole(&mut self) -> Result<u64, Unreadable> {
        let text = self.number()?;
        text.parse().map_err(|_| self.unreadable("expected a whole number"))
    }

    /// The text of the value that begins here, whatever it is; empty if it is not UTF-8.
    pub(super) fn value(&mut self) -> Result<&'a str, Unreadable> {
        self.skip_blank();
        let begin = self.at;
        self.skip()?;
        Ok(std::str::from_utf8(&self.bytes[begin..self.at]).unwrap_or_default().trim_ascii())
    }

    /// A time in seconds, exact to the nanosecond.
    pub(super) fn seconds(&mut self) -> Result<Duration, Unreadable> {
        let text = self.number()?;
        let seconds = || text.parse().ok().and_then(|seconds: f64| Duration::try_from_secs_f64(seconds).ok());
        let time = decimal_seconds(text).or_else(seconds);
        let time = time.ok_or_else(|| self.unreadable("expected a time in seconds"))?;
        // Monitors count nanoseconds in 64 bits: all later times would be one.
        match i64::try_from(time.as_nanos()) {
            Ok(_) => Ok(time),
            Err(_) => Err(self.unreadable("this time, in seconds, is beyond 292 years")),
        }
    }

    /// The value that begins here.
    pub(super) fn token(&mut self) -> Result<JsonToken<'a>, Unreadable> {
        self.skip_blank();
        match self.bytes.get(self.at) {
            Some(b'{') => {
                self.at += 1;
                Ok(JsonToken::Open)
            }
            Some(b'"') => {
                let raw = self.string()?;
                let text = unescaped(raw).ok_or_else(|| self.unreadable("this string is not valid text"))?;
                Ok(JsonToken::Text(text))
            }
            Some(b't') => self.word("true").map(|()| JsonToken::Bool(true)),
            Some(b'f') => self.word("false").map(|()| JsonToken::Bool(false)),
            _ => {
                let text = self.number()?;
                let integer = if text.contains(['.', 'e', 'E']) { None } else { text.parse().ok() };
                match (integer, text.parse::<f64>()) {
                    (Some(integer), _) => Ok(JsonToken::Int(integer)),
                    (None, Err(_)) => Err(self.unreadable("this is not a number")),
                    (None, Ok(number)) if !number.is_finite() => {
                        Err(self.unreadable("this number is beyond the largest real"))
                    }
                    (None, Ok(number)) if text.contains(['.', 'e', 'E']) => Ok(JsonToken::Real(number)),
                    (None, Ok(_)) => Err(self.unreadable("this integer does not fit into 64 bits")),
                }
            }
        }
    }

    fn word(&mut self, word: &'static str) -> Result<(), Unreadable> {
        if self.bytes[self.at..].starts_with(word.as_bytes()) {
            self.at += word.len();
            return Ok(());
        }
        Err(self.unreadable("expected a value"))
    }

    /// Skips a value of any kind: lines may have keys that are not read, and their values are not checked to be valid.
    pub(super) fn skip(&mut self) -> Result<(), Unreadable> {
        let mut depth = 0_usize;
        loop {
            self.skip_blank();
            match self.bytes.get(self.at) {
                Some(b'"') => {
                    self.string()?;
                }
                // Brackets are only counted. They are not matched: only the end of the value is of interest.
                Some(b'{' | b'[') => {
                    depth += 1;
                    self.at += 1;
                    if depth > MAX_DEPTH {
                        return Err(self.unreadable("nested too deeply"));
                    }
                    continue;
                }
                Some(b'}' | b']') if depth > 0 => {
                    depth -= 1;
                    self.at += 1;
                }
                Some(b',' | b':') if depth > 0 => {
                    self.at += 1;
                    continue;
                }
                Some(byte) if byte.is_ascii_alphanumeric() || *byte == b'-' => {
                    let is_part = |byte: &&u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'+' | b'.');
                    self.at += self.bytes[self.at..].iter().take_while(is_part).count();
                }
                _ => return Err(self.unreadable("expected a value")),
            }
            if depth == 0 {
                return Ok(());
            }
        }
    }
}

/// `67.02` as the exact number of nanoseconds, if it has at most nine digits after the point and no exponent.
fn decimal_seconds(text: &str) -> Option<Duration> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    if fraction.len() > 9 || !fraction.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let nanos: u32 = fraction.parse().ok()?;
    Some(Duration::new(whole.parse().ok()?, nanos * 10_u32.pow(9 - fraction.len() as u32)))
}

/// The text of a JSON string.
fn unescaped(raw: &[u8]) -> Option<Cow<'_, str>> {
    let text = std::str::from_utf8(raw).ok()?;
    if !text.contains('\\') {
        return Some(Cow::Borrowed(text));
    }
    let mut plain = String::new();
    let mut chars = text.chars();
    while let Some(char) = chars.next() {
        if char != '\\' {
            plain.push(char);
            continue;
        }
        plain.push(match chars.next()? {
            'n' => '\n',
            't' => '\t',
            'r' => '\r',
            'b' => '\u{8}',
            'f' => '\u{c}',
            'u' => unicode(&mut chars)?,
            other @ ('"' | '\\' | '/') => other,
            _ => return None,
        });
    }
    Some(Cow::Owned(plain))
}

/// The character of `\u0041`, or of a pair of surrogates.
fn unicode(chars: &mut std::str::Chars<'_>) -> Option<char> {
    let mut four = || u32::from_str_radix(&chars.by_ref().take(4).collect::<String>(), 16).ok();
    let first = four()?;
    if !(0xD800..0xDC00).contains(&first) {
        return char::from_u32(first);
    }
    let escape: String = chars.by_ref().take(2).collect();
    let second = u32::from_str_radix(&chars.by_ref().take(4).collect::<String>(), 16).ok()?;
    let low = second.checked_sub(0xDC00).filter(|low| *low < 0x400 && escape == "\\u")?;
    char::from_u32(0x10000 + ((first - 0xD800) << 10) + low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_read_to_the_nanosecond() {
        let read = |text: &str| Scanner::new(text.as_bytes()).seconds().ok();
        assert_eq!(read("67.02"), Some(Duration::new(67, 20_000_000)));
        assert_eq!(read("0.000000001"), Some(Duration::new(0, 1)));
        assert_eq!(read("3"), Some(Duration::from_secs(3)));
        assert_eq!(read("1e1"), Some(Duration::from_secs(10)));
        assert_eq!(read("-1.0"), None);
        assert_eq!(read("9223372036.8"), Some(Duration::new(9_223_372_036, 800_000_000)));
        // Such as a time in nanoseconds since 1970.
        for late in ["9223372036.9", "1700000000000000000", "1.7e18"] {
            let problem = Scanner::new(late.as_bytes()).seconds().map_err(|unreadable| unreadable.problem);
            assert_eq!(problem, Err("this time, in seconds, is beyond 292 years"), "{late}");
        }
    }

    #[test]
    fn values_are_read_as_json_defines_them() {
        let token = |text: &'static str| Scanner::new(text.as_bytes()).token().ok();
        assert_eq!(token("-12"), Some(JsonToken::Int(-12)));
        assert_eq!(token("8.5e1"), Some(JsonToken::Real(85.0)));
        assert_eq!(token("false"), Some(JsonToken::Bool(false)));
        assert_eq!(token(r#""a\"\u00e9\ud83d\ude00\n""#), Some(JsonToken::Text("a\"é😀\n".into())));
        for wrong in ["", "nul", "\"open", r#""\q""#, r#""\ud83d""#, "1e999", "tru"] {
            assert_eq!(token(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn numbers_out_of_range_are_told_from_what_is_no_number() {
        let problem =
            |text: &'static str| Scanner::new(text.as_bytes()).token().map_err(|unreadable| unreadable.problem);
        for integer in ["9223372036854775808", "-9223372036854775809"] {
            assert_eq!(problem(integer), Err("this integer does not fit into 64 bits"));
        }
        assert_eq!(problem("-1e309"), Err("this number is beyond the largest real"));
        assert_eq!(problem("1e308"), Ok(JsonToken::Real(1e308)));
        assert_eq!(problem("-9223372036854775808"), Ok(JsonToken::Int(i64::MIN)));
        for wrong in ["1-2", "1e", "--1"] {
            assert_eq!(problem(wrong), Err("this is not a number"), "{wrong}");
        }
    }

    #[test]
    fn a_skipped_value_ends_where_it_should() {
        for (text, rest) in [(r#"{"a":[1,{"b":null}],"c":"}"},7"#, ",7"), ("-1.5e3]", "]"), ("null}", "}"), ("[]", "")]
        {
            let mut scanner = Scanner::new(text.as_bytes());
            scanner.skip().unwrap();
            assert_eq!(&text[scanner.at..], rest);
        }
        for wrong in ["", "]", ",", "[1", "{\"a\""] {
            assert!(Scanner::new(wrong.as_bytes()).skip().is_err(), "{wrong}");
        }
        assert!(Scanner::new("[".repeat(100).as_bytes()).skip().is_err());
    }
}
