//! Definitions in OMG IDL, limited to the part of it that ROS uses: modules, structs, constants, enumerations and type
//! aliases.
//!
//! rosbag2 records a package's definitions in the language in which it is written, and there are packages written in
//! IDL, such as Autoware's `autoware_auto_msgs`. Without a reader of IDL, their messages could not be decoded.

use std::collections::BTreeMap;
use std::ops::Range;

use diagnostics::{FileProblems, Problem, Source, Span};

use super::span_parts::part;
use super::{Base, Constant, Count, Field, Message, Primitive, Type, TypeName, literal};
use crate::value::Value;

/// All structs of a text, which may consist of several definitions with titles: `IDL: package/msg/Name`.
pub(super) fn types(source: &Source) -> Result<BTreeMap<TypeName, Message>, FileProblems> {
    let mut reader =
        IdlReader { source, tokens: tokens(source)?, next: 0, types: BTreeMap::new(), names: BTreeMap::new() };
    while reader.next < reader.tokens.len() {
        reader.declaration(&mut Vec::new())?;
    }
    Ok(reader.types)
}

/// The words, numbers, strings and signs of a text, without comments, titles and directives.
fn tokens(source: &Source) -> Result<Vec<Range<usize>>, Problem> {
    let text = source.text();
    let (mut tokens, mut at) = (Vec::new(), 0);
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let line = rest.find('\n').unwrap_or(rest.len());
        let unfinished = || source.span(at..at + 1).problem("this has no end").with_label("begins here");
        let is_word = |letter: char| letter.is_alphanumeric() || letter == '_';
        let length = if first.is_whitespace() {
            first.len_utf8()
            // Bags separate the IDL of several types by lines of `=` and titles such as `IDL: std_msgs/msg/Header`.
        } else if rest.starts_with("//") || first == '#' || rest.starts_with("===") || rest.starts_with("IDL:") {
            line
        } else if rest.starts_with("/*") {
            rest.find("*/").ok_or_else(unfinished)? + 2
        } else {
            let length = if first == '"' || first == '\'' {
                quoted(rest, first).ok_or_else(unfinished)?
            } else if first.is_ascii_digit() || first == '-' || first == '.' {
                rest.find(|letter: char| !is_word(letter) && !"+-.".contains(letter)).unwrap_or(rest.len())
            } else if rest.starts_with("::") {
                2
            } else if is_word(first) {
                rest.find(|letter: char| !is_word(letter)).unwrap_or(rest.len())
            } else {
                first.len_utf8()
            };
            tokens.push(at..at + length);
            length
        };
        at += length;
    }
    Ok(tokens)
}

/// The length of a text with its quotes, if it ends.
fn quoted(text: &str, quote: char) -> Option<usize> {
    let mut is_escaped = false;
    let ends = |letter: char| {
        let ends = letter == quote && !is_escaped;
        is_escaped = letter == '\\' && !is_escaped;
        ends
    };
    Some(text[1..].find(ends)? + 2)
}

struct IdlReader<'s> {
    source: &'s Source,
    tokens: Vec<Range<usize>>,
    next: usize,
    types: BTreeMap<TypeName, Message>,
    /// The names defined by `typedef` and `enum`.
    names: BTreeMap<String, Type>,
}

impl<'s> IdlReader<'s> {
    fn peek(&self) -> &'s str {
        self.tokens.get(self.next).map_or("", |range| &self.source.text()[range.clone()])
    }

    fn take(&mut self) -> &'s str {
        let token = self.peek();
        self.next += 1;
        token
    }

    /// The location of the last token.
    fn span(&self) -> Span {
        self.source.span(self.tokens.get(self.next.saturating_sub(1)).cloned().unwrap_or_default())
    }

    fn problem(&self, message: String) -> Problem {
        self.span().problem(message).with_label("here")
    }

    fn expect(&mut self, wanted: &str) -> Result<(), Problem> {
        let found = self.take();
        if found == wanted { Ok(()) } else { Err(self.problem(format!("expected `{wanted}`, found `{found}`"))) }
    }

    fn name(&mut self) -> Result<&'s str, Problem> {
        let name = self.take();
        let is_name = name.starts_with(|letter: char| letter.is_alphabetic() || letter == '_');
        is_name.then_some(name).ok_or_else(|| self.problem(format!("expected a name, found `{name}`")))
    }

    /// The contents of a file or a module; `scope` has the modules around it.
    fn declaration(&mut self, scope: &mut Vec<&'s str>) -> Result<(), Problem> {
        self.annotations()?;
        match self.take() {
            ";" => return Ok(()),
            "module" => {
                scope.push(self.name()?);
                self.expect("{")?;
                while self.peek() != "}" {
                    self.declaration(scope)?;
                }
                self.next += 1;
                scope.pop();
            }
            "struct" => {
                // The package is the outermost module; the next one, `msg` or `srv`, is not part of a type's name.
                let name = TypeName::new(scope.first().copied(), self.name()?);
                let fields = self.fields()?;
                self.types.entry(name).or_default().fields = fields;
            }
            "enum" => self.enumeration()?,
            "typedef" => {
                let kind = self.kind()?;
                let (name, kind) = self.declarator(kind)?;
                self.names.insert(name, kind);
            }
            "const" => self.constant(scope)?,
            other => {
                return Err(self.problem(format!("`{other}` is not supported here")).with_help(
                    "a ROS definition consists of modules, structs, constants, enumerations and type aliases",
                ));
            }
        }
        self.expect(";")
    }

    /// An enumeration after its keyword. Its values are sent as numbers, and their names are not needed.
    fn enumeration(&mut self) -> Result<(), Problem> {
        let name = self.name()?.to_owned();
        while self.take() != "}" {
            if self.next > self.tokens.len() {
                return Err(self.problem(format!("`{name}` has no end")));
            }
        }
        self.names.insert(name, primitive(Primitive::Uint32));
        Ok(())
    }

    /// A constant after its keyword.
    fn constant(&mut self, scope: &[&'s str]) -> Result<(), Problem> {
        let kind = self.kind()?;
        let name = self.name()?.to_owned();
        self.expect("=")?;
        // The text may define the type's name further below. Constants are not sent, so its size does not matter.
        let kind = if let Base::Primitive(kind) = kind.base { kind } else { Primitive::Int64 };
        let value = self.value(kind)?;
        // The constants of `Name` are in the module `Name_Constants`.
        let owner = scope.last().and_then(|module| module.strip_suffix("_Constants"));
        if let Some(owner) = owner {
            let owner = TypeName::new(scope.first().copied(), owner);
            self.types.entry(owner).or_default().constants.push(Constant { name, kind, value });
        }
        Ok(())
    }

    /// Skips the annotations of the next declaration: `@verbatim (language="comment", text="…")`.
    fn annotations(&mut self) -> Result<(), Problem> {
        while self.peek() == "@" {
            self.next += 1;
            self.name()?;
            if self.peek() == "(" {
                let mut depth = 0;
                loop {
                    match self.take() {
                        "(" => depth += 1,
                        ")" => depth -= 1,
                        "" => return Err(self.problem("this annotation has no end".to_owned())),
                        _ => {}
                    }
                    if depth == 0 {
                        break;
                    }
                }
            }
        }
        Ok(())
    }

    fn fields(&mut self) -> Result<Vec<Field>, Problem> {
        self.expect("{")?;
        let mut fields = Vec::new();
        loop {
            self.annotations()?;
            if self.peek() == "}" {
                self.next += 1;
                return Ok(fields);
            }
            let kind = self.kind()?;
            loop {
                let (name, kind) = self.declarator(kind.clone())?;
                fields.push(Field::new(&name, kind));
                match self.take() {
                    ";" => break,
                    "," => {}
                    other => return Err(self.problem(format!("expected `;`, found `{other}`"))),
                }
            }
        }
    }

    /// A name, which may end with how many there are of the type: `covariance[36]`.
    fn declarator(&mut self, kind: Type) -> Result<(String, Type), Problem> {
        let name = self.name()?.to_owned();
        if self.peek() != "[" {
            return Ok((name, kind));
        }
        self.next += 1;
        let count = Count::Exactly(self.size()?);
        self.expect("]")?;
        Ok((name, self.several(kind, count)?))
    }

    fn several(&self, Type { base, count: inner }: Type, count: Count) -> Result<Type, Problem> {
        let is_single = inner == Count::One;
        is_single.then_some(Type { base, count }).ok_or_else(|| {
            self.problem("an array of arrays is not supported".to_owned()).with_help("ROS has none of them")
        })
    }

    fn size(&mut self) -> Result<usize, Problem> {
        let size = self.take();
        size.parse().map_err(|_| self.problem(format!("`{size}` is not a size")))
    }

    fn kind(&mut self) -> Result<Type, Problem> {
        let first = self.take();
        let kind = match first {
            "sequence" => return self.sequence(),
            "string" => Primitive::String(self.bound()?),
            "wstring" => Primitive::WString(self.bound()?),
            "unsigned" => match (self.take(), self.peek()) {
                ("short", _) => Primitive::Uint16,
                ("long", "long") => self.and_then_next(Primitive::Uint64),
                ("long", _) => Primitive::Uint32,
                (other, _) => return Err(self.problem(format!("`unsigned {other}` is not a type"))),
            },
            "long" => match self.peek() {
                "long" => self.and_then_next(Primitive::Int64),
                "double" => return Err(self.problem("`long double` is not supported".to_owned())),
                _ => Primitive::Int32,
            },
            "boolean" => Primitive::Bool,
            "octet" => Primitive::Byte,
            "char" => Primitive::Char,
            "short" => Primitive::Int16,
            "float" => Primitive::Float32,
            "double" => Primitive::Float64,
            "wchar" | "map" | "any" => return Err(self.problem(format!("the type `{first}` is not supported"))),
            // Integers with their size in the name are called as in `.msg` files.
            _ => match Primitive::NAMES.iter().find(|(name, _)| *name == first && name.contains("int")) {
                Some((_, integer)) => *integer,
                None => {
                    self.next -= 1;
                    return self.named();
                }
            },
        };
        Ok(primitive(kind))
    }

    /// A sequence after its keyword: `<double>`, `<double, 4>`.
    fn sequence(&mut self) -> Result<Type, Problem> {
        self.expect("<")?;
        let kind = self.kind()?;
        let count = if self.peek() == "," {
            self.next += 1;
            Count::UpTo(self.size()?)
        } else {
            Count::Any
        };
        self.expect(">")?;
        self.several(kind, count)
    }

    fn and_then_next(&mut self, kind: Primitive) -> Primitive {
        self.next += 1;
        kind
    }

    /// `<10>`, if it is there.
    fn bound(&mut self) -> Result<Option<usize>, Problem> {
        if self.peek() != "<" {
            return Ok(None);
        }
        self.next += 1;
        let size = self.size()?;
        self.expect(">")?;
        Ok(Some(size))
    }

    /// A type with a name: `geometry_msgs::msg::Pose`, or one that this text has named.
    fn named(&mut self) -> Result<Type, Problem> {
        let mut path = vec![self.name()?];
        while self.peek() == "::" {
            self.next += 1;
            path.push(self.name()?);
        }
        let last = path[path.len() - 1];
        if let Some(kind) = self.names.get(last) {
            return Ok(kind.clone());
        }
        let package = path[..path.len() - 1].first().copied();
        Ok(Type { base: Base::Message(TypeName::new(package, last)), count: Count::One })
    }

    fn value(&mut self, kind: Primitive) -> Result<Value, Problem> {
        let text = self.take();
        if let Primitive::String(_) | Primitive::WString(_) = kind {
            let mut inside = text.trim_matches('"').to_owned();
            // Texts side by side are one.
            while self.peek().starts_with('"') {
                inside += self.take().trim_matches('"');
            }
            return Ok(Value::Text(inside));
        }
        // Unlike in `.msg` files, the type of a number may follow it.
        let is_real = matches!(kind, Primitive::Float32 | Primitive::Float64);
        let digits = if is_real { text.trim_end_matches(['f', 'd']) } else { text };
        literal::of_primitive(&part(&self.span(), 0, digits.len()), kind)
    }
}

fn primitive(kind: Primitive) -> Type {
    Type { base: Base::Primitive(kind), count: Count::One }
}
