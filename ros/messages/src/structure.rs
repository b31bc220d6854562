//! Access to decoded messages by field name.

use std::sync::Arc;

use crate::definition::Base;
use crate::layout::Layout;
use crate::value::Value;

/// A decoded message with its type.
#[derive(Clone, Copy, Debug)]
pub struct Structure<'v> {
    layout: &'v Layout,
    fields: &'v [Value],
}

impl<'v> Structure<'v> {
    /// The value as a message, if it is one.
    #[must_use]
    pub fn of(layout: &'v Layout, value: &'v Value) -> Option<Self> {
        let Value::Message(fields) = value else { return None };
        Some(Self { layout, fields })
    }

    fn field(&self, name: &str) -> Option<(&'v Base<Arc<Layout>>, &'v Value)> {
        let index = self.layout.fields.iter().position(|field| field.name == name)?;
        Some((&self.layout.fields[index].kind.base, self.fields.get(index)?))
    }

    /// The message in a field; `path` may contain several names: `pose.pose`.
    #[must_use]
    pub fn part(&self, path: &str) -> Option<Self> {
        path.split('.').try_fold(*self, |at, name| match at.field(name)? {
            (Base::Message(layout), value) => Self::of(layout, value),
            (Base::Primitive(_), _) => None,
        })
    }

    /// The messages in an array.
    #[must_use]
    pub fn parts(&self, name: &str) -> Vec<Self> {
        match self.field(name) {
            Some((Base::Message(layout), Value::List(items))) => {
                items.iter().filter_map(|item| Self::of(layout, item)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// The number in a field.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<f64> {
        number(self.field(name)?.1)
    }

    /// The numbers in an array.
    #[must_use]
    pub fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let Value::List(items) = self.field(name)?.1 else { return None };
        items.iter().map(number).collect()
    }

    /// The text in a field.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<&'v str> {
        let Value::Text(text) = self.field(name)?.1 else { return None };
        Some(text)
    }
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Int(number) => Some(*number as f64),
        Value::Real(number) => Some(*number),
        _ => None,
    }
}
