//! Flattens a ROS message, which may contain others, into the fields of a message of a channel.

use std::path::PathBuf;

use channels::FieldKind;
use diagnostics::document::Table;
use diagnostics::{Problem, Spanned, nearest_or_all};
use ros_messages::{Base, Count, Field, Message, Primitive, TypeName};

use crate::field_path::{FieldStep, Part, steps};
use crate::interface::MAX_FIELDS;
use crate::packages::{Definition, Missing, Packages, what_to_add};

/// Beyond this many items of arrays and messages, nothing is examined: their contents would be too large.
const MAX_VISITS: usize = 10_000;

/// A field of a channel's message, by its path in the definition: `pose.position.x`, `covariance[3]`, `ranges[]`.
#[derive(Clone, Debug)]
pub(crate) struct FlatField {
    pub(crate) path: String,
    pub(crate) kind: FieldKind,
}

/// Where a field is.
#[derive(Clone, Copy, Default)]
struct Inside {
    /// In something that a message may lack.
    optional: bool,
    /// In an array whose items become lists.
    list: bool,
}

/// The context for flattening the messages of one definition.
pub(crate) struct Flattening<'f, 'r, 'd> {
    pub(crate) packages: &'f Packages<'r>,
    /// The folders in which types are looked up.
    pub(crate) folders: &'f [PathBuf],
    /// The definition, and the place in the interface that names it.
    pub(crate) named: &'f Spanned<String>,
    /// The key with which an interface selects fields of this part: `fields`, `reply`, …
    pub(crate) key: &'f str,
    /// Where problems are reported.
    pub(crate) table: Table<'d>,
}

/// One walk through a message.
struct Walk<'w, 'f, 'r, 'd> {
    of: &'w Flattening<'f, 'r, 'd>,
    /// The subject of problems: the definition, or the path that selects from it.
    about: &'w Spanned<String>,
    leaves: Vec<FlatField>,
    visits: usize,
    problems: Vec<Problem>,
    /// The arrays of unbounded length in a list: their paths and types.
    endless: Vec<(String, String)>,
    /// The types around the one being visited.
    around: Vec<PathBuf>,
}

/// Whether to continue.
type Going = Option<()>;

impl Flattening<'_, '_, '_> {
    /// All fields of a part of the definition.
    pub(crate) fn all(&self, definition: &Definition, part: &Message) -> Option<Vec<FlatField>> {
        self.walk(definition, part, self.named, &[])
    }

    /// The field at a path, or the fields below it.
    pub(crate) fn at(&self, definition: &Definition, part: &Message, path: &Spanned<String>) -> Option<Vec<FlatField>> {
        let Some(steps) = steps(&path.value) else {
            let problem = path.span.problem(format!("`{}` is not a path in a definition", path.value));
            let problem = problem.with_label("here");
            self.table.report(problem.with_help("for example `pose.position.x`, `covariance[0]` or `ranges[]`"));
            return None;
        };
        self.walk(definition, part, path, &steps)
    }

    fn walk(
        &self,
        definition: &Definition,
        part: &Message,
        about: &Spanned<String>,
        steps: &[FieldStep],
    ) -> Option<Vec<FlatField>> {
        let around = vec![definition.path.clone()];
        let mut walk =
            Walk { of: self, about, leaves: Vec::new(), visits: 0, problems: Vec::new(), endless: Vec::new(), around };
        let went = walk.message(definition, part, "", steps, Inside::default());
        let endless = walk.endless();
        walk.problems.extend(endless);
        let Walk { leaves, problems, .. } = walk;
        if went.is_some() && problems.is_empty() {
            return Some(leaves);
        }
        problems.into_iter().for_each(|problem| self.table.report(problem));
        None
    }
}

impl Walk<'_, '_, '_, '_> {
    /// Visits all fields of a message, or the one to which the first step leads.
    fn message(
        &mut self,
        definition: &Definition,
        message: &Message,
        path: &str,
        steps: &[FieldStep],
        inside: Inside,
    ) -> Going {
        let Some((step, rest)) = steps.split_first() else {
            return message
                .fields
                .iter()
                .try_for_each(|field| self.field(definition, field, &join(path, &field.name), None, &[], inside));
        };
        let Some(field) = message.fields.iter().find(|field| field.name == step.name) else {
            let names: Vec<&str> = message.fields.iter().map(|field| field.name.as_str()).collect();
            let problem = self.problem(format!("there is no field `{}`", join(path, &step.name)));
            self.problems.push(problem.with_help(nearest_or_all(&step.name, "fields", &names)));
            return Some(());
        };
        self.field(definition, field, &join(path, &step.name), step.part, rest, inside)
    }

    /// Visits a field: one item of it, all items one by one, or all as a list. A channel's messages always have the
    /// same fields, so an item that an array may lack is optional, and an array of any length is a list.
    fn field(
        &mut self,
        definition: &Definition,
        field: &Field,
        path: &str,
        part: Option<Part>,
        rest: &[FieldStep],
        inside: Inside,
    ) -> Going {
        let may_lack = field.is_optional || matches!(field.kind.count, Count::UpTo(_) | Count::Any);
        let one = Inside { optional: inside.optional || may_lack, ..inside };
        let base = &field.kind.base;
        match (field.kind.count, part) {
            (Count::One, None) => self.item(definition, base, path, rest, one),
            (Count::One, Some(_)) => {
                self.problems.push(self.problem(format!("`{path}` is not an array")));
                Some(())
            }
            (Count::Exactly(count) | Count::UpTo(count), Some(Part::Item(item))) if item >= count => {
                let problem = self.problem(format!("`{path}` has no item {item}"));
                self.problems.push(problem.with_help(format!("its items are 0 to {}", count - 1)));
                Some(())
            }
            (_, Some(Part::Item(item))) => self.item(definition, base, &format!("{path}[{item}]"), rest, one),
            // Reported together at the end of the walk: one definition may have many such arrays, and each needs the
            // same remedy.
            (Count::Any, None) | (_, Some(Part::Every)) if inside.list => {
                self.endless.push((path.to_owned(), field.kind.to_string()));
                Some(())
            }
            // Where the array may be missing, the list is empty.
            (Count::Any, None) | (_, Some(Part::Every)) => {
                let items = Inside { optional: false, list: true };
                self.item(definition, base, &format!("{path}[]"), rest, items)
            }
            (Count::Exactly(count) | Count::UpTo(count), None) => {
                (0..count).try_for_each(|item| self.item(definition, base, &format!("{path}[{item}]"), rest, one))
            }
        }
    }

    fn item(&mut self, definition: &Definition, base: &Base, path: &str, rest: &[FieldStep], inside: Inside) -> Going {
        self.visits += 1;
        if self.leaves.len() == MAX_FIELDS || self.visits > MAX_VISITS {
            self.problems.push(self.too_many());
            return None;
        }
        let kind = match base {
            Base::Message(name) => return self.nested(definition, name, path, rest, inside),
            Base::Primitive(Primitive::Bool) => FieldKind::Bool,
            Base::Primitive(Primitive::Float32 | Primitive::Float64) => FieldKind::Real,
            Base::Primitive(Primitive::String(_) | Primitive::WString(_)) => FieldKind::Text,
            Base::Primitive(_) => FieldKind::Int,
        };
        if let Some(step) = rest.first() {
            self.problems.push(self.problem(format!("`{path}` is {base} and has no field `{}`", step.name)));
            return Some(());
        }
        let kind = if inside.optional { FieldKind::Optional(Box::new(kind)) } else { kind };
        let kind = if inside.list { FieldKind::List(Box::new(kind)) } else { kind };
        self.leaves.push(FlatField { path: path.to_owned(), kind });
        Some(())
    }

    fn nested(&mut self, user: &Definition, name: &TypeName, path: &str, rest: &[FieldStep], inside: Inside) -> Going {
        let Flattening { packages, folders, named, table, .. } = *self.of;
        match packages.message(name, user, folders, named, table) {
            Ok(definition) if self.around.contains(&definition.path) => {
                self.problems.push(self.problem(format!("{name}, the type of `{path}`, contains itself")));
                None
            }
            Ok(definition) => {
                self.around.push(definition.path.clone());
                let going =
                    definition.parts.iter().try_for_each(|part| self.message(&definition, part, path, rest, inside));
                self.around.pop();
                going
            }
            Err(Missing::Refused) => None,
            Err(Missing::Nowhere) => {
                let problem = self.problem(format!("`{path}` is {name}, which has no definition"));
                self.problems.push(problem.with_help(what_to_add(name, folders)));
                Some(())
            }
        }
    }

    fn problem(&self, message: String) -> Problem {
        self.about.span.problem(message).with_label("here")
    }

    /// The problem to report for lists of lists, if there are any.
    fn endless(&self) -> Option<Problem> {
        let (first, _) = self.endless.first()?;
        let names: Vec<String> = self.endless.iter().map(|(path, kind)| format!("`{path}` ({kind})")).collect();
        let (names, are) = match names.split_last()? {
            (name, []) => (name.clone(), "would be a list of lists"),
            (last, others) => (format!("{} and {last}", others.join(", ")), "would be lists of lists"),
        };
        Some(self.problem(format!("{names} {are}")).with_help(self.select(&format!("{first}[0]"))))
    }

    fn too_many(&self) -> Problem {
        self.problem(format!("these are more than the {MAX_FIELDS} fields that a message may have"))
            .with_help(self.select("…"))
    }

    /// How to name the selected fields.
    fn select(&self, another: &str) -> String {
        let plain = self.leaves.iter().find(|leaf| !leaf.path.contains(['.', '[']));
        let example = plain.or(self.leaves.first()).map_or_else(String::new, |leaf| format!("\"{}\", ", leaf.path));
        format!("name the fields that you want, such as `{} = [{example}\"{another}\"]`", self.of.key)
    }
}

fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}
