//! From an SCXML file to a [`Chart`], with everything that is wrong with the file.

mod check;
mod compile;
mod content;
mod outline;
mod rules;
mod send;
mod targets;
mod xml;

pub(crate) use send::INTERNAL_TARGET;

use std::path::Path;
use std::sync::Arc;

use miette::NamedSource;
use roxmltree::{Document, ParsingOptions};

use crate::chart::Chart;
use crate::problem::Problem;
use crate::{SkillError, Strictness};

/// A file may be so long.
const MAX_BYTES: usize = 4 << 20;
/// A file may have so many elements, attributes and texts.
const MAX_NODES: u32 = 100_000;

impl Chart {
    /// Compiles a machine. `file` names the text in messages and, without folder and ending, the machine if it does not
    /// name itself.
    ///
    /// # Errors
    /// [`SkillError::Load`] with everything that is wrong with the file.
    ///
    /// ```
    /// use skills::Chart;
    ///
    /// let text = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0">
    ///   <state id="off"><transition event="press" target="on"/></state>
    ///   <state id="on"><transition event="press" target="off"/></state>
    /// </scxml>"#;
    /// let chart = Chart::load("Lamp.scxml", text)?;
    /// assert_eq!(chart.name(), "Lamp");
    /// # Ok::<(), skills::SkillError>(())
    /// ```
    pub fn load(file: &str, text: &str) -> Result<Arc<Self>, SkillError> {
        Self::load_with(file, text, Strictness::Strict)
    }

    /// Compiles a machine, as strict as asked for.
    ///
    /// # Errors
    /// [`SkillError::Load`] with everything that is wrong with the file.
    pub fn load_with(file: &str, text: &str, strictness: Strictness) -> Result<Arc<Self>, SkillError> {
        let named = NamedSource::new(file, Arc::from(text)).with_language("XML");
        let refuse = |mut problems: Vec<Problem>| {
            problems.sort_by_key(Problem::offset);
            Err(SkillError::Load { file: file.to_owned(), text: named.clone(), problems })
        };
        let document = match parse_xml(text) {
            Ok(document) => document,
            Err(problem) => return refuse(vec![problem]),
        };
        let mut problems = Vec::new();
        check::structure(document.root_element(), &mut problems);
        if document.root_element().tag_name().name() != "scxml" {
            return refuse(problems);
        }
        let stem = Path::new(file).file_stem().map_or(file.into(), |stem| stem.to_string_lossy());
        let mut chart = compile::chart(&document, named.clone(), &stem, strictness, &mut problems);
        if problems.iter().any(Problem::is_error) {
            return refuse(problems);
        }
        problems.sort_by_key(Problem::offset);
        chart.warnings = problems;
        Ok(Arc::new(chart))
    }
}

fn parse_xml(text: &str) -> Result<Document<'_>, Problem> {
    if text.len() > MAX_BYTES {
        let problem = Problem::new(format!("a machine may be {MAX_BYTES} bytes long at most"));
        return Err(problem.at(0..0, format!("this one has {}", text.len())));
    }
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let offset = offset_of(text, error.pos());
        let problem = Problem::new(format!("this is not XML: {error}")).at(offset..offset, "here");
        match error {
            roxmltree::Error::DtdDetected => problem.help("document types and entities of one's own are refused"),
            roxmltree::Error::NodesLimitReached => problem.help(format!("a file may have {MAX_NODES} nodes")),
            _ => problem,
        }
    })?;
    match check::depth(&document) {
        Some(problem) => Err(problem),
        None => Ok(document),
    }
}

/// The byte at a row and column.
fn offset_of(text: &str, position: roxmltree::TextPos) -> usize {
    let row = position.row.saturating_sub(1) as usize;
    let start: usize = text.split_inclusive('\n').take(row).map(str::len).sum();
    let line = text.get(start..).unwrap_or_default();
    let column = position.col.saturating_sub(1) as usize;
    start + line.char_indices().nth(column).map_or(line.trim_end().len(), |(offset, _)| offset)
}
