//! The machine that stands for a component in a proof, if the component may answer anything that its interface allows.

mod machine;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use bt::Tree;
use channels::{FieldKind, Value};
use diagnostics::Spanned;
use interfaces::{Field, Interface};
use monitors::syntax::{Literal, parse_file};
use skills::{Chart, Datum};

use self::machine::Repertoire;
use super::skill::Skill;

/// Everything that may hear a component, and distinguish what it says.
pub(super) struct Listeners<'a> {
    pub(super) tree: Option<&'a Tree>,
    pub(super) skills: Option<&'a BTreeMap<String, Skill>>,
    /// The names and texts of property files.
    pub(super) properties: &'a [(String, String)],
}

impl Listeners<'_> {
    /// The machine of a component that may answer anything and reads the topics of some others, beside the machines of
    /// other components.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub(super) fn stand_in(
        &self,
        (name, asks): (&str, &[Spanned<String>]),
        interfaces: &BTreeMap<&str, Interface>,
        of_components: Vec<(&String, &Skill)>,
        tick_s: f64,
    ) -> Result<Skill, String> {
        let machines = self.skills.into_iter().flatten().chain(of_components);
        // A program that hears it might distinguish anything, but is refused in a proof.
        let hears = |skill: &Skill| {
            skill.machine.file().text().contains(name)
                || skill.data.values().any(|value| matches!(value, Datum::Text(text) if **text == *name))
        };
        let machines: Vec<(&String, &Skill)> = machines.filter(|(_, skill)| hears(skill)).collect();
        let known = Known { literals: literals(self.properties), machines };
        let samples = |field: &Field| self.samples(field, &known);
        let Some(interface) = interfaces.get(name) else { return Err("its interface is wrong".to_owned()) };
        let read = asks.iter().filter_map(|asked| Some((&asked.value, interfaces.get(asked.value.as_str())?)));
        let heard = read
            .flat_map(|(from, interface)| interface.topics.iter().map(move |topic| format!("{from}.{}", topic.name)));
        let text = Repertoire::of(interface, &samples)?.scxml(name, &heard.collect::<Vec<_>>(), tick_s);
        let file = format!("prove.components.{name}");
        let machine = Chart::load(&file, &text).map_err(|error| error.to_string())?;
        Ok(Skill { path: PathBuf::from(file), machine, data: BTreeMap::new() })
    }

    /// The values of a field, one for each case that anything distinguishes.
    fn samples(&self, field: &Field, known: &Known<'_>) -> Result<Vec<Value>, String> {
        let kind = if let FieldKind::Optional(kind) = &field.kind { kind } else { &field.kind };
        let constants: Vec<Value> = match kind {
            FieldKind::Symbol(symbols) => symbols.iter().cloned().map(Value::Symbol).collect(),
            FieldKind::Bool => vec![true.into()],
            FieldKind::Text => self.texts(field, known).iter().map(|text| Value::from(text.as_str())).collect(),
            FieldKind::Int | FieldKind::Real => self.numbers(field, known)?,
            FieldKind::Optional(_) | FieldKind::List(_) => {
                return Err(format!("its field `{}` is a {}, of which there are too many", field.name, field.kind));
            }
        };
        Ok(monitors::samples(&field.kind, &constants.iter().collect::<Vec<_>>()))
    }

    /// The numbers with which machines or properties compare a field.
    fn numbers(&self, field: &Field, known: &Known<'_>) -> Result<Vec<Value>, String> {
        // As a condition, a number is false if it is 0.
        let mut numbers = vec![Value::Int(0)];
        numbers.extend(known.literals.iter().filter(|value| value.is_number()).cloned());
        for (process, skill) in &known.machines {
            let compared = skill.thresholds(process, self.tree, &field.name).map_err(|problems| {
                let what = problems.first().map_or_else(String::new, |problem| problem.message().to_owned());
                format!("of its field `{}`, {what} ({process})", field.name)
            })?;
            numbers.extend(compared.into_iter().map(Value::Real));
        }
        Ok(numbers)
    }

    /// The strings of properties, of the machines that name this field, and of the tree if they may pass it on:
    /// whatever the field is compared with is among them.
    fn texts(&self, field: &Field, known: &Known<'_>) -> BTreeSet<String> {
        let in_properties = known.literals.iter().filter_map(|value| match value {
            Value::Text(text) => Some(text.to_string()),
            _ => None,
        });
        let texts = known.machines.iter().map(|(_, skill)| skill.machine.file().text());
        let naming: Vec<&str> = texts.filter(|text| text.contains(&*field.name)).collect();
        let trees = self.tree.filter(|_| !naming.is_empty()).into_iter().flat_map(Tree::sources);
        let files = naming.into_iter().chain(trees.map(diagnostics::Source::text));
        in_properties.chain(files.flat_map(quoted)).collect()
    }
}

/// What is known of those who may hear a component.
struct Known<'a> {
    /// The numbers and texts of properties.
    literals: Vec<Value>,
    /// The machines that hear it, by process.
    machines: Vec<(&'a String, &'a Skill)>,
}

/// Everything between two quotes in an XML file, but for markup. Strings of expressions are in single quotes, unless
/// the attribute is.
fn quoted(xml: &str) -> Vec<String> {
    let plain = xml.replace("&quot;", "'").replace("&apos;", "'");
    let marks: &[char] = if plain.contains("='") { &['\'', '"'] } else { &['\''] };
    let pieces = plain.split(marks).filter(|piece| !piece.contains(['<', '\n']));
    pieces.map(str::to_owned).collect()
}

/// The numbers and texts with which properties, by name and text, compare anything, as they are written there. A
/// stand-in that answers anything tells values apart by them.
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
