//! Parses the text of a definition into its parts.

use std::collections::BTreeMap;
use std::ops::Range;

use diagnostics::{FileProblems, Problem, Source, Span};

use super::annotations::Annotations;
use super::line::{self, Element};
use super::print::SEPARATOR;
use super::{Action, Field, Message, Service};

impl Message {
    /// Reads a `.msg` file. `name` stands for it in diagnostics.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn parse(name: &str, text: &str) -> Result<Self, FileProblems> {
        let [message] = parse(name, text, ["a message"])?;
        Ok(message)
    }
}

impl Service {
    /// Reads a `.srv` file. `name` stands for it in diagnostics.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn parse(name: &str, text: &str) -> Result<Self, FileProblems> {
        let [request, response] = parse(name, text, ["a request", "a response"])?;
        Ok(Self { request, response })
    }
}

impl Action {
    /// Reads an `.action` file. `name` stands for it in diagnostics.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn parse(name: &str, text: &str) -> Result<Self, FileProblems> {
        let [goal, result, feedback] = parse(name, text, ["a goal", "a result", "a feedback"])?;
        Ok(Self { goal, result, feedback })
    }
}

/// Reads the parts of a definition, separated by lines `---`.
fn parse<const N: usize>(name: &str, text: &str, parts: [&str; N]) -> Result<[Message; N], FileProblems> {
    let source = Source::new(name, text);
    let mut problems = Vec::new();
    let mut read = parts.map(|_| PartReader::default());
    let mut at = 0;
    for (range, line) in lines(text) {
        let span = source.span(range);
        if line == SEPARATOR {
            at += 1;
            if at == N {
                problems.push(superfluous(&span, parts));
            }
        } else if let Some(part) = read.get_mut(at) {
            part.read(&span, &mut problems);
        }
    }
    if at + 1 < N {
        let end = source.span(text.len()..text.len());
        let problem =
            end.problem(format!("{} is missing", parts[at + 1..].join(" and "))).with_label("the file ends here");
        problems.push(
            problem.with_help(format!(
                "the parts are {}, in this order, with a line `---` between them",
                parts.join(", ")
            )),
        );
    }
    let messages = read.map(|part| part.end(&mut problems));
    FileProblems::none_of(problems)?;
    Ok(messages)
}

fn superfluous<const N: usize>(separator: &Span, parts: [&str; N]) -> Problem {
    let problem = separator.problem("nothing follows this separator").with_label("one too many");
    problem.with_help(match N {
        1 => "a `.msg` file has one part; a `.srv` file has two, an `.action` file three".to_owned(),
        _ => format!("the parts are {}", parts.join(", ")),
    })
}

/// The lines with content, without comments and surrounding spaces, each with its location.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (Range<usize>, &str)> {
    let mut next = 0;
    let lines = text.split('\n').map(move |line| {
        let start = next;
        next += line.len() + 1;
        let content = line.split_once('#').map_or(line, |(content, _)| content);
        let indent = content.len() - content.trim_start().len();
        let content = content.trim();
        (start + indent..start + indent + content.len(), content)
    });
    lines.filter(|(_, content)| !content.is_empty())
}

/// A part of a definition while it is read.
#[derive(Debug, Default)]
pub(super) struct PartReader {
    message: Message,
    /// The location of each name.
    names: BTreeMap<String, Span>,
    /// What precedes the next field.
    annotations: Annotations,
}

impl PartReader {
    /// Reads a line. A mistake in it does not end the part: all mistakes are reported.
    pub(super) fn read(&mut self, line: &Span, problems: &mut Vec<Problem>) {
        let read = self.annotations.take(line).and_then(|line| {
            let is_annotation = line.text().is_empty();
            (!is_annotation).then(|| line::parse(&line)).transpose()
        });
        let element = match read {
            Ok(Some(element)) => element,
            Ok(None) => return,
            // The annotations above a wrong line must not apply to the next one.
            Err(problem) => {
                self.annotations = Annotations::default();
                return problems.push(problem);
            }
        };
        let (name, place) = (element.name().to_owned(), element.place().clone());
        if let Some(first) = self.names.get(&name) {
            let problem = place.problem(format!("`{name}` is defined twice")).with_label("again");
            return problems.push(problem.at(first.range(), "first here"));
        }
        self.names.insert(name, place);
        let annotations = std::mem::take(&mut self.annotations);
        match element {
            Element::Constant(constant, _) => {
                problems.extend(annotations.without_field());
                self.message.constants.push(constant);
            }
            Element::Field(field, _) => {
                let Annotations { is_optional, is_key, .. } = annotations;
                self.message.fields.push(Field { is_optional, is_key, ..field });
            }
        }
    }

    /// The message, once all lines are read.
    pub(super) fn end(self, problems: &mut Vec<Problem>) -> Message {
        problems.extend(self.annotations.without_field());
        self.message
    }
}
