//! YAML as a tree of nodes.

use saphyr::{LoadableYamlNode, MarkedYaml, Marker, Scalar, YamlData};

use super::node::{Entries, Entry, Kind, MAX_DEPTH, Node};
use crate::{FileProblems, Problem, Source, Span};

/// Limits, together with [`too_deep`], how deeply a text can nest: the parser itself recurses without a limit.
const MAX_BYTES: usize = 16 * 1024;

/// Parses a whole file. Its top level must be a mapping; an empty file is an empty mapping.
pub(super) fn document(source: &Source) -> Result<Node, FileProblems> {
    if source.text().len() > MAX_BYTES {
        let problem = source.span(0..0).problem(format!("the file is longer than {} KiB", MAX_BYTES / 1024));
        return Err(problem.with_help("is this a map's YAML file, and not its image?").into());
    }
    if let Some(line) = too_deep(source) {
        return Err(line.problem(format!("nested more than {MAX_DEPTH} levels deep")).with_label("too deep").into());
    }
    let places = Places::new(source);
    let mut documents = MarkedYaml::load_from_str(source.text()).map_err(|error| {
        let at = places.byte(error.marker());
        // saphyr notices only at the next line that a line without a colon is not a key.
        let reported = if error.info().contains("expect ':'") { "no `:` in the line before" } else { error.info() };
        source.span(at..at + 1).problem(reported).with_label("not YAML").with_help("a line is `KEY: VALUE`")
    })?;
    if let Some(second) = documents.get(1) {
        return Err(places.span(second).problem("a second YAML document").with_label("begins here").into());
    }
    let whole = source.span(0..0);
    let Some(root) = documents.pop() else { return Ok(Node { span: whole, kind: Kind::Table(Entries::default()) }) };
    let root = convert(&root, &places, 0)?;
    match root.kind {
        Kind::Table(_) => Ok(Node { span: whole, ..root }),
        Kind::Nothing | Kind::Unreadable => Ok(Node { span: whole, kind: Kind::Table(Entries::default()) }),
        kind => {
            let problem = root.span.problem("the file must be a mapping: lines of the form `key: value`");
            Err(problem.with_label(format!("this is {}", kind.name())).into())
        }
    }
}

/// A line that may be nested too deeply, judging by markers such as `- - ? -`. The parser itself limits brackets, and a
/// short text cannot nest deeply over several lines, because each level is indented further.
fn too_deep(source: &Source) -> Option<Span> {
    let marks = |line: &str| {
        let blank = |byte: Option<&u8>| byte.is_none_or(u8::is_ascii_whitespace);
        let bytes = line.as_bytes();
        let is_mark = |place: &usize| matches!(bytes[*place], b'-' | b'?' | b':') && blank(bytes.get(place + 1));
        (0..bytes.len()).filter(is_mark).count()
    };
    let mut start = 0;
    for line in source.text().split_inclusive('\n') {
        if !line.trim_start().starts_with('#') && marks(line) > MAX_DEPTH {
            return Some(source.span(start..start + line.trim_end().len()));
        }
        start += line.len();
    }
    None
}

fn convert(yaml: &MarkedYaml, places: &Places, depth: usize) -> Result<Node, Problem> {
    let span = places.span(yaml);
    if depth > MAX_DEPTH {
        return Err(span.problem(format!("nested more than {MAX_DEPTH} levels deep")).with_label("too deep"));
    }
    let kind = match &yaml.data {
        YamlData::Value(scalar) => convert_scalar(scalar),
        YamlData::Sequence(items) => {
            let items: Result<_, _> = items.iter().map(|item| convert(item, places, depth + 1)).collect();
            Kind::Array(items?)
        }
        YamlData::Mapping(entries) => {
            let entry = |(key, value): (&MarkedYaml, _)| {
                let span = places.span(key);
                let name = key.data.as_str().unwrap_or_else(|| span.text()).to_owned();
                Ok((name, Entry { key: span, value: convert(value, places, depth + 1)? }))
            };
            let by_key: Result<_, Problem> = entries.iter().map(entry).collect();
            Kind::Table(Entries { by_key: by_key?, ..Entries::default() })
        }
        YamlData::Tagged(_, inner) => return convert(inner, places, depth + 1),
        YamlData::Representation(..) | YamlData::Alias(_) | YamlData::BadValue => Kind::Unreadable,
    };
    Ok(Node { span, kind })
}

fn convert_scalar(scalar: &Scalar) -> Kind {
    match scalar {
        Scalar::Null => Kind::Nothing,
        Scalar::Boolean(value) => Kind::Boolean(*value),
        Scalar::Integer(number) => Kind::Integer((*number).into()),
        Scalar::FloatingPoint(number) => Kind::Real(number.into_inner()),
        Scalar::String(text) => Kind::Text(text.clone().into_owned()),
    }
}

/// Converts the parser's locations, which count characters, to spans.
struct Places<'s> {
    source: &'s Source,
    byte_of_character: Vec<usize>,
}

impl<'s> Places<'s> {
    fn new(source: &'s Source) -> Self {
        Self { source, byte_of_character: source.text().char_indices().map(|(byte, _)| byte).collect() }
    }

    fn byte(&self, marker: &Marker) -> usize {
        self.byte_of_character.get(marker.index()).copied().unwrap_or(self.source.text().len())
    }

    /// The location of a node, without the blank lines and comments at the end of a block.
    fn span(&self, yaml: &MarkedYaml) -> Span {
        let (start, end) = (self.byte(&yaml.span.start), self.byte(&yaml.span.end));
        let text = self.source.text().get(start..end).unwrap_or_default();
        self.source.span(start..start + text.trim_end().len())
    }
}
