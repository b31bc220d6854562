//! The canonical layout of machine files.

use std::path::Path;

use diagnostics::{Disk, LineEnds, Problem, xml};
use roxmltree::Node;

use super::check::is_machine;
use super::meaning::meaning;
use super::origin::Origin;
use super::parse_xml;
use super::rules::Rule;
use super::xml::AS_READ;
use crate::chart::Chart;
use crate::folder::Folder;
use crate::{SkillError, Strictness};

/// The text of a machine file in its canonical layout: comments and everything unknown are kept. Only white space
/// between tags and attributes, quotes, and the form of empty elements change. Scripts, values between tags, and
/// elements of other languages stay as they are. The layout of the result is the result.
///
/// `file` names the text in messages; `folder` is that of the files that the machine names, if they are accessible.
/// What follows from the text does not change: both texts are equal machines, except for the lines after which states
/// without an id are named, or are refused with equally many problems.
///
/// ```
/// let text = "<scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'><state id = 'on' /></scxml>";
/// let laid_out = skills::layout("Lamp.scxml", text, None)?;
/// assert_eq!(laid_out, r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0">
///   <state id="on"/>
/// </scxml>
/// "#);
/// # Ok::<(), skills::SkillError>(())
/// ```
///
/// # Errors
/// [`SkillError::Load`] if the text is not well-formed XML, or its outermost element is not `<scxml>`.
pub fn layout(file: &str, text: &str, folder: Option<&Path>) -> Result<String, SkillError> {
    let folder = folder.map(|path| Folder { path: path.to_owned(), disk: Disk::default() });
    let origin = Origin { folder, ..Origin::of(file, text, Strictness::Standard) };
    let refused = |problem| SkillError::load(origin.file.clone(), vec![problem], 0);
    if xml::root_name(text).is_none_or(|name| name.rsplit(':').next() != Some("scxml")) {
        // The loader reports what else it may be.
        Chart::compile(text, AS_READ, &origin)?;
    }
    parse_xml(text).map_err(refused)?;
    let plain = LineEnds::plain(text);
    let before = parse_xml(&plain).map_err(refused)?;
    let laid_out = xml::layout(&before, &has_value).map_err(refused)?;
    let after = parse_xml(&laid_out).map_err(refused)?;
    let is_alike = match (meaning(&plain, &origin), meaning(&laid_out, &origin)) {
        (Ok(old), Ok(new)) => old == new,
        (Err(SkillError::Load { problems: old, .. }), Err(SkillError::Load { problems: new, .. })) => {
            old.len() == new.len()
        }
        _ => false,
    };
    if xml::is_same(&before, &after, &has_value) && is_alike {
        Ok(LineEnds::of(text).write(laid_out))
    } else {
        Err(refused(Problem::of_layout()))
    }
}

/// Whether the contents of an element are a value, in which white space may count: a script, or data. Those of an
/// element in another language may be one. A machine in the `<content>` of an `<invoke>` is a machine.
fn has_value(element: Node<'_, '_>) -> bool {
    let name = element.tag_name();
    let is_foreign = name.namespace() != element.document().root_element().tag_name().namespace();
    is_foreign
        || Rule::of(name.name()).is_some_and(|rule| rule.text) && !element.children().any(|child| is_invoked(&child))
}

/// Whether an element is the machine that an `<invoke>` contains.
fn is_invoked(element: &Node<'_, '_>) -> bool {
    let above = element.parent().and_then(|content| content.parent());
    is_machine(element) && above.is_some_and(|invoke| invoke.has_tag_name((super::xml::NAMESPACE, "invoke")))
}
