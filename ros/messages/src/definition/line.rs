//! A line of a definition: a field or a constant.

use diagnostics::{Problem, Span, did_you_mean};

use super::names::{is_constant_name, is_field_name};
use super::span_parts::{part, split, trimmed};
use super::{Base, Constant, Count, Field, Primitive, Type, TypeName, literal};

/// The maximum size: CDR stores it in 32 bits.
const LARGEST: usize = u32::MAX as usize;

/// The definition in a line, and the position of its name.
#[derive(Debug)]
pub(super) enum Element {
    Constant(Constant, Span),
    Field(Field, Span),
}

impl Element {
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Constant(constant, _) => &constant.name,
            Self::Field(field, _) => &field.name,
        }
    }

    pub(super) fn place(&self) -> &Span {
        match self {
            Self::Constant(_, place) | Self::Field(_, place) => place,
        }
    }
}

/// Reads a line that is neither empty nor a separator, without its comment.
pub(super) fn parse(line: &Span) -> Result<Element, Problem> {
    let (kind, rest) = split(line, |letter| letter.is_whitespace());
    let rest = trimmed(&rest);
    if rest.text().is_empty() {
        let problem = line.problem("a line consists of a type and a name").with_label("this is only one word");
        return Err(problem.with_help("for example `float64 x`; a comment begins with `#`"));
    }
    let (name, rest) = split(&rest, |letter| letter.is_whitespace() || letter == '=');
    let rest = trimmed(&rest);
    if let Some(value) = rest.text().strip_prefix('=') {
        let value = trimmed(&part(&rest, rest.text().len() - value.len(), rest.text().len()));
        return constant(&kind, &name, &value).map(|constant| Element::Constant(constant, name));
    }
    field(&kind, &name, &rest).map(|field| Element::Field(field, name))
}

fn field(kind: &Span, name: &Span, default: &Span) -> Result<Field, Problem> {
    let typed = read_type(kind)?;
    if !is_field_name(name.text()) {
        let problem = name.problem(format!("`{}` cannot be the name of a field", name.text())).with_label("this name");
        return Err(problem.with_help(
            "a name consists of lower-case letters, digits and single underscores; it begins with a letter and does \
             not end with an underscore",
        ));
    }
    let default = (!default.text().is_empty()).then(|| literal::of_type(default, &typed)).transpose()?;
    Ok(Field { default, ..Field::new(name.text(), typed) })
}

fn constant(kind: &Span, name: &Span, value: &Span) -> Result<Constant, Problem> {
    let kind = match read_type(kind)? {
        Type { base: Base::Primitive(Primitive::String(Some(_)) | Primitive::WString(Some(_))), .. } => None,
        Type { base: Base::Primitive(primitive), count: Count::One } => Some(primitive),
        _ => None,
    }
    .ok_or_else(|| {
        let problem = kind.problem(format!("a constant cannot be {}", kind.text())).with_label("this type");
        problem.with_help("constants are Booleans, numbers, and strings without a bound")
    })?;
    if !is_constant_name(name.text()) {
        let problem = name.problem(format!("`{}` cannot be the name of a constant", name.text()));
        return Err(problem.with_label("this name").with_help(
            "a name consists of upper-case letters, digits and single underscores; it begins with a letter and does \
             not end with an underscore",
        ));
    }
    Ok(Constant { name: name.text().to_owned(), kind, value: literal::of_primitive(value, kind)? })
}

fn read_type(kind: &Span) -> Result<Type, Problem> {
    let text = kind.text();
    let Some(array) = text.strip_suffix(']') else { return Ok(Type { base: read_base(kind)?, count: Count::One }) };
    let Some((base, size)) = array.rsplit_once('[') else {
        return Err(kind.problem(format!("`{text}` ends with `]`, but has no `[`")).with_label("this type"));
    };
    let size_place = part(kind, base.len() + 1, base.len() + 1 + size.len());
    let count = match size.strip_prefix("<=") {
        None if size.is_empty() => Count::Any,
        None => Count::Exactly(positive(size, &size_place)?),
        Some(bound) => Count::UpTo(positive(bound, &size_place)?),
    };
    Ok(Type { base: read_base(&part(kind, 0, base.len()))?, count })
}

fn positive(text: &str, place: &Span) -> Result<usize, Problem> {
    let is_number = text.bytes().all(|digit| digit.is_ascii_digit());
    let number = text.parse().ok().filter(|number| is_number && (1..=LARGEST).contains(number));
    number.ok_or_else(|| {
        let problem = place.problem(format!("`{}` is not a size", place.text())).with_label("this size");
        problem.with_help(
            "`[3]`: three items; `[<=3]`: at most three; `[]`: any number; `string<=3`: at most three letters",
        )
    })
}

fn read_base(kind: &Span) -> Result<Base, Problem> {
    let text = kind.text();
    if let Some((_, primitive)) = Primitive::NAMES.iter().find(|(name, _)| *name == text) {
        return Ok(Base::Primitive(*primitive));
    }
    if let Some((name, bound)) = text.split_once("<=") {
        let bound = positive(bound, &part(kind, name.len(), text.len()));
        match name {
            "string" => return Ok(Base::Primitive(Primitive::String(Some(bound?)))),
            "wstring" => return Ok(Base::Primitive(Primitive::WString(Some(bound?)))),
            _ => {}
        }
    }
    match text {
        "time" => return Ok(Base::Message(TypeName::new(Some("builtin_interfaces"), "Time"))),
        "duration" => return Ok(Base::Message(TypeName::new(Some("builtin_interfaces"), "Duration"))),
        _ => {}
    }
    TypeName::parse(text).map(Base::Message).ok_or_else(|| no_type(kind))
}

fn no_type(kind: &Span) -> Problem {
    let problem = kind.problem(format!("`{}` is not a type", kind.text())).with_label("here");
    let names = Primitive::NAMES.map(|(name, _)| name);
    problem.with_help(did_you_mean(kind.text(), names).unwrap_or_else(|| {
        format!("a type is one of {}, or a message: `Pose`, `geometry_msgs/Pose`", names.join(", "))
    }))
}
