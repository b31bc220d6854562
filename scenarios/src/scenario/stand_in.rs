//! The machine that stands for a component in a proof, if the component may answer anything that its interface allows.

mod machine;
mod texts;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use bt::Tree;
use channels::{FieldKind, Value};
use diagnostics::{Problem, Spanned};
use interfaces::{Field, Interface};
use maps::Places;
use monitors::syntax::{Literal, parse_file};
use skills::{Chart, Datum};

use self::machine::Repertoire;
pub use self::texts::Carrier;
use self::texts::{Chosen, System, Tried};
use super::skill::Skill;

/// Everything that may receive messages of a component, and distinguish them.
pub(super) struct Listeners<'a> {
    pub(super) tree: Option<&'a Tree>,
    pub(super) skills: Option<&'a BTreeMap<String, Skill>>,
    /// The names and texts of property files.
    pub(super) properties: &'a [(String, String)],
    /// The places of the map, if there is one.
    pub(super) places: Option<&'a Places>,
    /// How many messages may be delivered twice.
    pub(super) repeated: usize,
}

/// The components that may answer anything, and everything around them.
pub(super) struct StandIns<'a> {
    properties: Vec<Value>,
    interfaces: &'a BTreeMap<&'a str, Interface>,
    tree: Option<&'a Tree>,
    machines: Vec<(&'a String, &'a Skill)>,
    texts: Chosen,
}

/// What is tried of the answers of components that may answer anything.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// The values of each field that has too many to try all, by component and field.
    pub tried: BTreeMap<(String, String), Vec<Value>>,
    /// How many of the texts of a field stand for all texts that nothing mentions.
    pub others: BTreeMap<(String, String), usize>,
    /// Where in messages a text may be that such a component has chosen.
    pub carriers: Vec<Carrier>,
    /// The properties that compare such texts with one that is not known, with these in words.
    pub unfollowed: BTreeMap<String, String>,
}

impl<'a> StandIns<'a> {
    /// The components with these names, beside the machines of other components.
    ///
    /// # Errors
    /// Everything that is done with a text that they answer beyond comparing it with others.
    pub(super) fn new(
        listeners: &Listeners<'a>,
        interfaces: &'a BTreeMap<&'a str, Interface>,
        names: &BTreeSet<&str>,
        of_components: Vec<(&'a String, &'a Skill)>,
    ) -> Result<Self, Vec<Problem>> {
        let Listeners { tree, skills, properties, places, repeated } = *listeners;
        let machines: Vec<(&String, &Skill)> = skills.into_iter().flatten().chain(of_components).collect();
        let machines_of_system = machines.clone();
        let system =
            System { tree, machines: machines_of_system, interfaces, anything: names, places, properties, repeated };
        let texts = system.chosen()?;
        Ok(Self { properties: literals(properties), interfaces, tree, machines, texts })
    }

    /// The machine of a component that may answer anything and reads the topics of some others.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub(super) fn machine(
        &self,
        (name, asks): (&str, &[Spanned<String>]),
        tick_s: f64,
        tried: &mut Samples,
    ) -> Result<Skill, String> {
        let Some(interface) = self.interfaces.get(name) else { return Err("its interface is wrong".to_owned()) };
        // A program that receives them might distinguish anything, but is refused in a proof.
        let receives = |skill: &Skill| {
            skill.machine.channel_messages().iter().any(|(to, _)| *to == name)
                || interface.topics.iter().any(|topic| skill.machine.names(&format!("{name}.{}", topic.name)))
                || skill.data.values().any(|value| matches!(value, Datum::Text(text) if **text == *name))
        };
        let receivers: Vec<(&String, &Skill)> =
            self.machines.iter().filter(|(_, skill)| receives(skill)).copied().collect();
        let found: RefCell<BTreeMap<String, Vec<Value>>> = RefCell::default();
        let samples = |field: &Field| {
            let values = self.samples(name, field, &receivers)?;
            // There are too many values of these to try all.
            if let FieldKind::Int | FieldKind::Real | FieldKind::Text = field.kind.present() {
                found.borrow_mut().insert(field.name.clone(), values.clone());
            }
            Ok(values)
        };
        let read = asks.iter().filter_map(|asked| Some((&asked.value, self.interfaces.get(asked.value.as_str())?)));
        let received = read
            .flat_map(|(from, interface)| interface.topics.iter().map(move |topic| format!("{from}.{}", topic.name)));
        let text = Repertoire::of(interface, &samples)?.scxml(name, &received.collect::<Vec<_>>(), tick_s);
        let file = format!("prove.components.{name}");
        let machine = Chart::load(&file, &text).map_err(|error| error.to_string())?;
        for (field, values) in found.into_inner() {
            let key = (name.to_owned(), field);
            if let Some(texts) = self.texts.tried.get(&key) {
                tried.others.insert(key.clone(), texts.others);
            }
            tried.tried.insert(key, values);
        }
        tried.carriers.clone_from(&self.texts.carriers);
        tried.unfollowed.clone_from(&self.texts.unfollowed);
        Ok(Skill { path: PathBuf::from(file), machine, place: None, data: BTreeMap::new() })
    }

    /// The values of a field, one for each case that anything distinguishes.
    fn samples(&self, of: &str, field: &Field, receivers: &[(&String, &Skill)]) -> Result<Vec<Value>, String> {
        let (kind, optional) = match &field.kind {
            FieldKind::Optional(kind) => (&**kind, Some(Value::symbol(FieldKind::NONE))),
            kind => (kind, None),
        };
        let constants: Vec<Value> = match kind {
            FieldKind::Symbol(symbols) => symbols.iter().cloned().map(Value::Symbol).collect(),
            FieldKind::Bool => vec![true.into()],
            FieldKind::Text => return Ok(optional.into_iter().chain(self.texts(of, field)).collect()),
            FieldKind::Int | FieldKind::Real => self.numbers(field, receivers)?,
            FieldKind::Optional(_) | FieldKind::List(_) => {
                return Err(format!("its field `{}` is a {}, of which there are too many", field.name, field.kind));
            }
        };
        Ok(monitors::samples(&field.kind, &constants.iter().collect::<Vec<_>>()))
    }

    /// The numbers with which machines or properties compare a field.
    fn numbers(&self, field: &Field, receivers: &[(&String, &Skill)]) -> Result<Vec<Value>, String> {
        // As a condition, a number is false if it is 0.
        let mut numbers = vec![Value::Int(0)];
        numbers.extend(self.properties.iter().filter(|value| value.is_number()).cloned());
        for (process, skill) in receivers {
            let compared = skill.thresholds(process, self.tree, &field.name).map_err(|problems| {
                let what = problems.first().map_or_else(String::new, |problem| problem.message().to_owned());
                format!("of its field `{}`, {what} ({process})", field.name)
            })?;
            numbers.extend(compared.into_iter().map(Value::Real));
        }
        Ok(numbers)
    }

    /// The texts with which anything compares a field, and others.
    fn texts(&self, of: &str, field: &Field) -> Vec<Value> {
        let Some(Tried { texts, others }) = self.texts.tried.get(&(of.to_owned(), field.name.clone())) else {
            return Vec::new();
        };
        let mut all: Vec<Value> = texts.iter().map(|text| Value::Text(Arc::clone(text))).collect();
        let mut name = "unmentioned".to_owned();
        while all.len() < texts.len() + others {
            if !texts.contains(name.as_str()) {
                all.push(Value::from(name.as_str()));
            }
            name.push('\'');
        }
        all
    }
}

/// The numbers and texts with which properties, by name and text, compare anything, as they are written there. A
/// stand-in that answers anything distinguishes values by them.
#[must_use]
pub fn literals(properties: &[(String, String)]) -> Vec<Value> {
    let mut values = Vec::new();
    for (_, text) in properties {
        values.extend(parse_file(text).file.literals().into_iter().filter_map(|literal| match literal {
            Literal::Int(number) => Some(Value::Int(*number)),
            Literal::Real(number) => Some(Value::Real(*number)),
            Literal::Text(text) => Some(Value::from(text.as_str())),
            Literal::Symbol(_) | Literal::Bool(_) | Literal::Duration { .. } => None,
        }));
    }
    values
}
