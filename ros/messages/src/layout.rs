//! Message types with all nested types resolved, as CDR needs them.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::definition::{Base, Constant, Field, Message, Primitive, Type, TypeName};

/// A message type: a [`Message`] whose fields have the types themselves in place of their names.
#[derive(Debug, PartialEq)]
pub struct Layout {
    /// Its name, with the package.
    pub name: TypeName,
    /// Its constants.
    pub constants: Vec<Constant>,
    /// Its fields, in the order in which they are sent.
    pub fields: Vec<Field<Arc<Self>>>,
}

/// Why the messages of a type cannot be decoded.
#[derive(Debug, thiserror::Error)]
#[error("{why}")]
pub struct Undefined {
    /// The problem, in words.
    pub why: String,
    /// How to fix it.
    pub help: String,
}

impl Undefined {
    /// A problem, and how to fix it.
    #[must_use]
    pub fn new(why: String, help: &str) -> Self {
        Self { why, help: help.to_owned() }
    }
}

/// Messages nested deeper are rejected: they must contain themselves.
const DEEPEST: usize = 50;

impl Layout {
    /// The type `name`, with the definitions that `find` finds. It is called once for each type, by name and package.
    ///
    /// # Errors
    /// [`Undefined`] if a definition is not found, or a type contains itself.
    pub fn resolve(
        name: &TypeName,
        find: &mut dyn FnMut(&TypeName) -> Result<Message, Undefined>,
    ) -> Result<Arc<Self>, Undefined> {
        resolve(name, find, &mut BTreeMap::new(), 0)
    }

    /// Whether its messages have wide strings.
    #[must_use]
    pub fn has_wide_strings(&self) -> bool {
        // A type may be used many times: each is looked into once.
        let (mut seen, mut open) = (BTreeSet::new(), vec![self]);
        while let Some(layout) = open.pop() {
            for field in &layout.fields {
                match &field.kind.base {
                    Base::Primitive(Primitive::WString(_)) => return true,
                    Base::Primitive(_) => {}
                    Base::Message(inner) if seen.insert(&inner.name) => open.push(inner),
                    Base::Message(_) => {}
                }
            }
        }
        false
    }
}

fn resolve(
    name: &TypeName,
    find: &mut dyn FnMut(&TypeName) -> Result<Message, Undefined>,
    made: &mut BTreeMap<TypeName, Arc<Layout>>,
    depth: usize,
) -> Result<Arc<Layout>, Undefined> {
    if let Some(layout) = made.get(name) {
        return Ok(Arc::clone(layout));
    }
    if depth > DEEPEST {
        return Err(Undefined::new(format!("{name} contains itself"), "a ROS message cannot contain itself"));
    }
    let package = name.package.as_deref().unwrap_or_default();
    let Message { constants, fields } = find(name)?;
    let resolved = fields.into_iter().map(|Field { name, kind, default, is_optional, is_key }| {
        let base = match kind.base {
            Base::Primitive(primitive) => Base::Primitive(primitive),
            Base::Message(used) => {
                // In ROS 1, this name needed no package.
                let is_header = used.package.is_none() && used.name == "Header" && package != "std_msgs";
                let used = used.within(if is_header { "std_msgs" } else { package });
                Base::Message(resolve(&used, find, made, depth + 1)?)
            }
        };
        Ok(Field { name, kind: Type { base, count: kind.count }, default, is_optional, is_key })
    });
    let fields = resolved.collect::<Result<_, Undefined>>()?;
    let layout = Arc::new(Layout { name: name.clone(), constants, fields });
    made.insert(name.clone(), Arc::clone(&layout));
    Ok(layout)
}
