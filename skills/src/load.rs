//! Turns an SCXML file into a [`Chart`], with all problems of the file.

mod check;
mod compile;
mod content;
mod dialect;
mod expression;
mod files;
mod invoke;
mod layout;
mod meaning;
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
pub(crate) use xml::{AS_READ, Element, Written, name_span, own_elements};

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use diagnostics::{Disk, Problem};
use roxmltree::{Document, ParsingOptions};

use files::MAX_BYTES;
use origin::Origin;
use xml::RangeMap;

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
        Self::compile(text, AS_READ, &Origin::of(file, text, strictness))
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
        Self::compile(plain, place, &Origin::of(file, text, Strictness::Strict))
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
        let of_text = Origin::of(&path.to_string_lossy(), &text, strictness);
        Self::compile(&text, AS_READ, &Origin { folder: Some(Folder::of(path, disk)), looks_further, ..of_text })
    }

    /// The machine in a file beside this one's, as named by `srcexpr`.
    pub(crate) fn beside(&self, address: &str) -> Result<Arc<Self>, String> {
        let (path, folder) = files::path(address, self.folder.as_ref())?;
        Self::open_with(&path, &folder.disk, self.strictness, false).map_err(|error| error.to_string())
    }

    /// A machine that was computed.
    pub(crate) fn computed(&self, text: &str) -> Result<Arc<Self>, String> {
        let of_text = Origin::of(&format!("{} (computed)", self.file.name()), text, self.strictness);
        let origin = Origin { folder: self.folder.clone(), ..of_text };
        Self::compile(text, AS_READ, &origin).map_err(|error| error.to_string())
    }

    /// Compiles the machine in `text`. `map` gives its ranges in the file of the origin.
    fn compile(text: &str, map: RangeMap<'_>, origin: &Origin) -> Result<Arc<Self>, SkillError> {
        let refuse = |mut problems: Vec<Problem>, forgivable: usize| {
            problems.sort_by_key(Problem::offset);
            Err(SkillError::load(origin.file.clone(), problems, forgivable))
        };
        let document = match parse_xml(text) {
            Ok(document) => document,
            Err(problem) => return refuse(vec![problem.moved(map)], 0),
        };
        let root = Element::new(document.root_element(), map);
        if let Some(problem) = dialect::foreign(root) {
            return refuse(vec![problem], 0);
        }
        // A wrong structure does not prevent the rest from being compiled, for its own problems; a wrong root does.
        let mut problems = Vec::new();
        check::structure(root, &mut problems);
        if !check::is_machine(&root) {
            return refuse(problems, 0);
        }
        let (mut chart, forgivable) = compile::chart(root, origin, &mut problems);
        if problems.iter().any(Problem::is_error) {
            return refuse(problems, forgivable);
        }
        problems.sort_by_key(Problem::offset);
        chart.warnings = problems;
        Ok(Arc::new(chart))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ORIGINAL, SHIPPED};

    /// A machine with every kind of content.
    const WHOLE: &str = "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0' initial='a'>
        <datamodel><data id='x' expr='1'/><data id='list'>[1, 2]</data><data id='id'/></datamodel>
        <script><![CDATA[x = 1 < 2]]></script>
        <state id='a'>
          <initial><transition target='b'><log label='in' expr='x'/></transition></initial>
          <onentry><raise event='own'/><assign location='x' expr='x + 1'/><cancel sendid='timer'/>
            <if cond='x &gt; 1'><log expr='1'/><elseif cond='x &lt; 0'/><log/><else/><log expr='list'/></if>
            <foreach array='list' item='it' index='at'><log expr='it'/></foreach></onentry>
          <onexit><send event='go' id='timer' delay='1s' namelist='x  list'><param name='y' location='x'/></send>
            <send type='channel' targetexpr='_event.origin' eventexpr='&quot;ok&quot;' idlocation='id'/>
            <send event='go'><content expr='x'/></send></onexit>
          <state id='b'><transition event='own go.*  *' cond='x &gt; 0 &amp;&amp; !false' target='p' type='internal'/></state>
          <final id='c'><donedata><param name='z' expr='x'/></donedata></final>
        </state>
        <parallel id='p'><history id='h' type='deep'><transition target='q'/></history>
          <invoke idlocation='id' namelist='x'><param name='x' location='x'/><finalize><assign location='x' expr='2'/></finalize>
            <content><scxml version='1.0'><state id='s'><transition event='gone' target='s'/></state></scxml></content></invoke>
          <state id='q'><transition event='own' target='h'/></state><state id='r'><transition cond='false'/></state>
        </parallel>
      </scxml>";

    /// Machines that are refused.
    const BROKEN: [&str; 6] = [
        "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'><state id='a'></scxml>",
        "<scxml version='1.0'><state id='a'/></scxml>",
        "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.1' binding='x'>text<stat/><state id='a' idd='b'/></scxml>",
        "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'><datamodel><data id='x'/><data id='x'/></datamodel>
           <state id='a'><transition event='e  a..b' cond='&quot;&amp;&quot; == lvl' target='b  a c'/></state><state id='a'/></scxml>",
        "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'><state id='a'><onentry>
           <send event='e' delay='soon' namelist='x  y'/><script> 1 + </script><foreach array='a' item='1'/></onentry>
           <transition/><transition event='e' x:chance='2' xmlns:x='urn:steward:chance'/></state></scxml>",
        "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'><state id='a'><onentry><ros_publish/></onentry></state></scxml>",
    ];

    /// A machine with all ranges in it, or what is wrong with it.
    fn ranges(loaded: Result<Arc<Chart>, SkillError>) -> String {
        fn of(Chart { span, states, transitions, data, scripts, warnings, .. }: &Chart) -> String {
            format!("{:?}", (span, states, transitions, data, scripts, warnings))
        }
        match loaded {
            Ok(chart) => of(&chart) + &chart.inner().map(|inner| of(inner)).collect::<String>(),
            Err(SkillError::Load { problems, .. }) => format!("{problems:?}"),
            Err(error) => panic!("{error}"),
        }
    }

    #[test]
    fn ranges_in_a_translation_are_those_in_the_text_of_its_author() {
        let before = "<!-- only its author wrote this -->";
        let shipped = SHIPPED.into_iter().chain(ORIGINAL).map(|(_, text)| &text[text.find("<scxml").unwrap_or(0)..]);
        for plain in shipped.chain([WHOLE]).chain(BROKEN) {
            let text = format!("{before}{plain}");
            let place = |range: Range<usize>| range.start + before.len()..range.end + before.len();
            let written = Chart::load("m.scxml", &text);
            assert_eq!(written.is_err(), BROKEN.contains(&plain), "{written:?}");
            let translated = Chart::load_translated("m.scxml", &text, plain, &place);
            assert_eq!(ranges(translated), ranges(written));
        }
    }
}
