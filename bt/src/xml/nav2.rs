//! Nav2's model of its nodes, for trees that use them without declaring them.

use std::sync::OnceLock;

use roxmltree::{Document, Node as Element};

use super::model::declaration;
use super::problems::Problems;
use super::vocabulary;
use crate::library::{Model, Models};

const TEXT: &str = include_str!("../../models/nav2.xml");

/// The model of one of Nav2's nodes.
pub(super) fn nav2_model(id: &str) -> Option<&'static Model> {
    nav2_models().get(id)
}

pub(super) fn nav2_models() -> &'static Models {
    static MODELS: OnceLock<Models> = OnceLock::new();
    MODELS.get_or_init(|| read(&mut Problems::new()))
}

fn read(problems: &mut Problems) -> Models {
    let document = Document::parse(TEXT).expect("the model of Nav2 is XML");
    let elements = document.root_element().children().flat_map(|model| model.children());
    let model = |element: Element<'_, '_>| {
        let category = vocabulary::explicit(element.tag_name().name())?;
        Some((element.attribute("ID")?.to_owned(), declaration(element, category, None, problems)))
    };
    elements.filter(Element::is_element).filter_map(model).collect()
}

#[cfg(test)]
mod tests {
    use super::super::ports::ports;
    use super::*;
    use crate::{Category, Kind};

    #[test]
    fn the_model_is_itself_a_valid_model() {
        let mut problems = Problems::new();
        let models = read(&mut problems);
        assert!(problems.is_empty(), "{problems:?}");
        assert_eq!(models.len(), TEXT.matches(" ID=").count());
    }

    #[test]
    fn the_model_has_the_kinds_and_ports_of_all_built_in_nodes() {
        for kind in Kind::BUILTIN.into_iter().filter(|kind| kind.is_of_nav2()) {
            let model = nav2_model(kind.name()).unwrap_or_else(|| panic!("{kind} has no model"));
            assert_eq!(model.category, kind.category(), "{kind}");
            let mut declared: Vec<_> = model.ports.iter().map(|port| (&*port.name, port.default.as_deref())).collect();
            let mut known: Vec<_> = ports(kind).iter().map(|port| (port.name, port.default)).collect();
            declared.sort_unstable();
            known.sort_unstable();
            assert_eq!(declared, known, "{kind}");
        }
    }

    #[test]
    fn all_other_nodes_of_the_model_are_leaves() {
        for (id, model) in nav2_models() {
            let is_builtin = Kind::BUILTIN.iter().any(|kind| kind.name() == id);
            let is_leaf = matches!(model.category, Category::Action | Category::Condition);
            assert_ne!(is_builtin, is_leaf, "{id}");
        }
    }
}
