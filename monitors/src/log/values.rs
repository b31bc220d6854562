//! The messages in the lines of a log.

use channels::{Message, Symbol, Value};

use super::scan::{JsonToken, Scanner, Unreadable};

/// The most symbols that are kept: chosen, not measured.
const MAX_SYMBOLS: usize = 256;

/// Reads messages, with memory that is used again for the next one.
#[derive(Debug, Default)]
pub(super) struct MessageReader {
    symbols: Vec<Symbol>,
    fields: Vec<Value>,
}

impl MessageReader {
    pub(super) fn message(&mut self, scanner: &mut Scanner<'_>) -> Result<Message, Unreadable> {
        scanner.expect(b'[')?;
        self.fields.clear();
        if !scanner.take(b']') {
            loop {
                let value = if scanner.take(b'[') { self.list(scanner)? } else { self.value(scanner)? };
                self.fields.push(value);
                if !scanner.take(b',') {
                    break;
                }
            }
            scanner.expect(b']')?;
        }
        Ok(Message::new(self.fields.drain(..)))
    }

    /// The list after its bracket. Its items are no lists.
    fn list(&mut self, scanner: &mut Scanner<'_>) -> Result<Value, Unreadable> {
        let mut items = Vec::new();
        if scanner.take(b']') {
            return Ok(Value::List(items.into()));
        }
        loop {
            items.push(self.value(scanner)?);
            if !scanner.take(b',') {
                break;
            }
        }
        scanner.expect(b']')?;
        Ok(Value::List(items.into()))
    }

    fn value(&mut self, scanner: &mut Scanner<'_>) -> Result<Value, Unreadable> {
        Ok(match scanner.token()? {
            JsonToken::Bool(truth) => Value::Bool(truth),
            JsonToken::Int(number) => Value::Int(number),
            JsonToken::Real(number) => Value::Real(number),
            JsonToken::Text(text) => Value::Text(text.into()),
            JsonToken::Open => self.tagged(scanner)?,
        })
    }

    /// `{"sym": "ok"}` or `{"real": "inf"}`, after its first brace: what JSON has no values for.
    fn tagged(&mut self, scanner: &mut Scanner<'_>) -> Result<Value, Unreadable> {
        let kind = scanner.string()?;
        if !matches!(kind, b"sym" | b"real") {
            return Err(scanner.unreadable("a value must be a number, a string, true, false or {\"sym\": …}"));
        }
        scanner.expect(b':')?;
        let value = match (kind, scanner.string()?) {
            (b"sym", name) => {
                self.symbol(name).map(Value::Symbol).ok_or_else(|| scanner.unreadable("this is not UTF-8"))?
            }
            (_, b"inf") => Value::Real(f64::INFINITY),
            (_, b"-inf") => Value::Real(f64::NEG_INFINITY),
            _ => return Err(scanner.unreadable("a real that JSON has no number for is \"inf\" or \"-inf\"")),
        };
        scanner.expect(b'}')?;
        Ok(value)
    }

    /// The symbol with this name, allocated once for all its occurrences unless there are too many different ones.
    fn symbol(&mut self, name: &[u8]) -> Option<Symbol> {
        if let Some(known) = self.symbols.iter().find(|symbol| symbol.name().as_bytes() == name) {
            return Some(known.clone());
        }
        let symbol = Symbol::new(std::str::from_utf8(name).ok()?);
        // The search is linear. Beyond the limit, symbols are allocated again for each message.
        if self.symbols.len() < MAX_SYMBOLS {
            self.symbols.push(symbol.clone());
        }
        Some(symbol)
    }
}
