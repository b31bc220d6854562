//! From an SCXML file to a [`Chart`], with everything that is wrong with the file.

mod check;
mod compile;
mod content;
mod expression;
mod files;
mod invoke;
mod outline;
mod reach;
mod rules;
mod send;
mod targets;
mod transition;
mod value;
mod xml;

pub(crate) use send::INTERNAL_TARGET;
pub(crate) use xml::{Written, name_span, own_elements};

use std::path::Path;
use std::sync::Arc;

use miette::NamedSource;
use roxmltree::{Document, ParsingOptions};

use compile::Origin;
use files::MAX_BYTES;

use crate::chart::Chart;
use crate::problem::Problem;
use crate::suggest::did_you_mean;
use crate::{SkillError, Strictness};

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
        Self::load_from(file, text, strictness, None, false)
    }

    /// Reads and compiles a machine's file. Its attributes `src` and `srcexpr` name files in the same folder.
    ///
    /// # Errors
    /// [`SkillError::Read`] if the file cannot be read, [`SkillError::Load`] with everything that is wrong with it.
    pub fn open(path: &Path, strictness: Strictness) -> Result<Arc<Self>, SkillError> {
        Self::open_with(path, strictness, true)
    }

    pub(crate) fn open_with(path: &Path, strictness: Strictness, looks_further: bool) -> Result<Arc<Self>, SkillError> {
        let text = files::read(path).map_err(|reason| SkillError::Read { reason })?;
        let folder: Arc<Path> = path.parent().unwrap_or_else(|| Path::new("")).into();
        Self::load_from(&path.to_string_lossy(), &text, strictness, Some(folder), looks_further)
    }

    /// The machine in a file beside this one's, as `srcexpr` names it.
    pub(crate) fn beside(&self, address: &str) -> Result<Arc<Self>, String> {
        let path = files::path(address, self.folder.as_deref())?;
        Self::open_with(&path, self.strictness, false).map_err(|error| error.to_string())
    }

    /// A machine that was computed.
    pub(crate) fn computed(&self, text: &str) -> Result<Arc<Self>, String> {
        let (name, folder) = (format!("{} (computed)", self.file.name()), self.folder.clone());
        Self::load_from(&name, text, self.strictness, folder, false).map_err(|error| error.to_string())
    }

    fn load_from(
        file: &str,
        text: &str,
        strictness: Strictness,
        folder: Option<Arc<Path>>,
        looks_further: bool,
    ) -> Result<Arc<Self>, SkillError> {
        let named = NamedSource::new(file, Arc::from(text)).with_language("XML");
        let refuse = |mut problems: Vec<Problem>| {
            problems.sort_by_key(Problem::offset);
            Err(SkillError::load(named.clone(), problems))
        };
        let document = match parse_xml(text) {
            Ok(document) => document,
            Err(problem) => return refuse(vec![problem]),
        };
        let root = document.root_element();
        let mut problems = Vec::new();
        check::structure(root, &mut problems);
        if !check::is_machine(&root) {
            return refuse(problems);
        }
        let stem = Path::new(file).file_stem().map_or(file.into(), |stem| stem.to_string_lossy());
        let origin = Origin { file: named.clone(), stem: &stem, strictness, folder, looks_further };
        let mut chart = compile::chart(root, &origin, &mut problems);
        if problems.iter().any(Problem::is_error) {
            return refuse(problems);
        }
        problems.sort_by_key(Problem::offset);
        chart.warnings = problems;
        Ok(Arc::new(chart))
    }
}

/// Reads the file as XML.
pub(crate) fn parse_xml(text: &str) -> Result<Document<'_>, Problem> {
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
            roxmltree::Error::UnexpectedCloseTag(opened, closed, _) => problem.maybe_help(misspelt(&opened, &closed)),
            _ => problem,
        }
    })?;
    match check::depth(&document) {
        Some(problem) => Err(problem),
        None => Ok(document),
    }
}

/// What was meant by an element that begins with one name and ends with one much like it.
fn misspelt(opened: &str, closed: &str) -> Option<String> {
    did_you_mean(opened, [closed])?;
    let meant = [closed, opened].into_iter().find(|name| rules::Rule::of(name).is_some())?;
    Some(format!("<{opened}> ends as </{closed}>: did you mean <{meant}>?"))
}

/// The byte at a row and column.
fn offset_of(text: &str, position: roxmltree::TextPos) -> usize {
    let row = position.row.saturating_sub(1) as usize;
    let start: usize = text.split_inclusive('\n').take(row).map(str::len).sum();
    let line = text.get(start..).unwrap_or_default();
    let column = position.col.saturating_sub(1) as usize;
    start + line.char_indices().nth(column).map_or(line.trim_end().len(), |(offset, _)| offset)
}
