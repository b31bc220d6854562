//! Turns an SCXML file into a [`Chart`], with all problems of the file.

mod check;
mod compile;
mod content;
mod dialect;
mod expression;
mod files;
mod invoke;
mod layout;
mod origin;
mod outline;
mod reach;
mod rules;
mod send;
mod targets;
mod transition;
mod value;
mod xml;

pub use layout::layout;
pub(crate) use reach::{can_be_done, constant};
pub use rules::{attributes_of, elements_in};
pub(crate) use send::INTERNAL_TARGET;
pub(crate) use xml::{Written, name_span, own_elements};

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use diagnostics::{Disk, Problem, Source};
use roxmltree::{Document, ParsingOptions};

use files::MAX_BYTES;
use origin::Origin;

use crate::chart::Chart;
use crate::folder::Folder;
use crate::{SkillError, Strictness};

/// The maximum number of elements, attributes and texts in a file.
const MAX_NODES: u32 = 100_000;

/// The maximum number of attributes of an element.
const MAX_ATTRIBUTES: usize = 1000;

impl Chart {
    /// Compiles a machine. `file` names the text in messages. Without folder and extension, it also names a machine
    /// that has no name.
    ///
    /// # Errors
    /// [`SkillError::Load`] with all problems of the file.
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

    /// Compiles a machine with the given strictness.
    ///
    /// # Errors
    /// [`SkillError::Load`] with all problems of the file.
    pub fn load_with(file: &str, text: &str, strictness: Strictness) -> Result<Arc<Self>, SkillError> {
        Self::load_from(file, text, strictness, None, false)
    }

    /// Compiles a machine that was translated from another language. `text` is the original text, and `plain` its
    /// translation to SCXML, in which a transition may also have the attribute `chance` of the namespace
    /// `urn:steward:chance`: the probability that it counts as enabled when its event and its condition allow it, drawn
    /// from the sequence of [`Machine::set_seed`](crate::Machine::set_seed). `place` maps ranges of `plain` to `text`,
    /// so that all messages point to what the author wrote.
    ///
    /// # Errors
    /// [`SkillError::Load`] with all problems of the file.
    pub fn load_translated(
        file: &str,
        text: &str,
        plain: &str,
        place: &dyn Fn(Range<usize>) -> Range<usize>,
    ) -> Result<Arc<Self>, SkillError> {
        let source = Source::new(file, text);
        match Self::compile(file, plain, Strictness::Strict, None, false) {
            Ok(mut chart) => {
                chart.relocate(source, place);
                Ok(Arc::new(chart))
            }
            Err(error) => Err(error.moved(source, place)),
        }
    }

    /// Reads and compiles a machine's file. Its attributes `src` and `srcexpr` name files in the same folder.
    ///
    /// # Errors
    /// [`SkillError::Read`] if the file cannot be read, [`SkillError::Load`] with all its problems.
    pub fn open(path: &Path, strictness: Strictness) -> Result<Arc<Self>, SkillError> {
        Self::open_on(&Disk::default(), path, strictness)
    }

    /// Reads and compiles a machine's file like [`open`](Self::open), from this disk.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub fn open_on(disk: &Disk, path: &Path, strictness: Strictness) -> Result<Arc<Self>, SkillError> {
        Self::open_with(path, disk, strictness, true)
    }

    pub(crate) fn open_with(
        path: &Path,
        disk: &Disk,
        strictness: Strictness,
        looks_further: bool,
    ) -> Result<Arc<Self>, SkillError> {
        let text = files::read(path, disk).map_err(|reason| SkillError::Read { reason })?;
        let folder = Folder::of(path, disk);
        Self::load_from(&path.to_string_lossy(), &text, strictness, Some(folder), looks_further)
    }

    /// The machine in a file beside this one's, as named by `srcexpr`.
    pub(crate) fn beside(&self, address: &str) -> Result<Arc<Self>, String> {
        let (path, folder) = files::path(address, self.folder.as_ref())?;
        Self::open_with(&path, &folder.disk, self.strictness, false).map_err(|error| error.to_string())
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
        folder: Option<Folder>,
        looks_further: bool,
    ) -> Result<Arc<Self>, SkillError> {
        Self::compile(file, text, strictness, folder, looks_further).map(Arc::new)
    }

    fn compile(
        file: &str,
        text: &str,
        strictness: Strictness,
        folder: Option<Folder>,
        looks_further: bool,
    ) -> Result<Self, SkillError> {
        let named = Source::new(file, text);
        let refuse = |mut problems: Vec<Problem>, forgivable: usize| {
            problems.sort_by_key(Problem::offset);
            Err(SkillError::load(named.clone(), problems, forgivable))
        };
        let document = match parse_xml(text) {
            Ok(document) => document,
            Err(problem) => return refuse(vec![problem], 0),
        };
        let root = document.root_element();
        if let Some(problem) = dialect::foreign(root) {
            return refuse(vec![problem], 0);
        }
        // A wrong structure does not prevent the rest from being compiled, for its own problems; a wrong root does.
        let mut problems = Vec::new();
        check::structure(root, &mut problems);
        if !check::is_machine(&root) {
            return refuse(problems, 0);
        }
        let stem = Path::new(file).file_stem().map_or(file.into(), |stem| stem.to_string_lossy());
        let origin = Origin { file: named.clone(), stem: &stem, strictness, folder, looks_further };
        let (mut chart, forgivable) = compile::chart(root, &origin, &mut problems);
        if problems.iter().any(Problem::is_error) {
            return refuse(problems, forgivable);
        }
        problems.sort_by_key(Problem::offset);
        chart.warnings = problems;
        Ok(chart)
    }
}

/// Reads the file as XML.
pub(crate) fn parse_xml(text: &str) -> Result<Document<'_>, Problem> {
    if text.len() > MAX_BYTES {
        let problem = Problem::new(format!("a machine may have at most {MAX_BYTES} bytes"));
        return Err(problem.at(0..0, format!("this one has {}", text.len())));
    }
    diagnostics::xml::check_attributes(text, MAX_ATTRIBUTES)?;
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| match error {
        roxmltree::Error::NodesLimitReached => {
            Problem::new(format!("this is too large: more than {MAX_NODES} nodes")).at(0..0, "here")
        }
        error => diagnostics::xml::problem(text, &error, |name| rules::Rule::of(name).is_some()),
    })?;
    match check::depth(&document) {
        Some(problem) => Err(problem),
        None => Ok(document),
    }
}
