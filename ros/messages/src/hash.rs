//! Type hashes, by which ROS 2 determines whether two programs mean the same by the name of a type.
//!
//! Source: REP-2011, and `rosidl_generator_type_description` for the form that is hashed.

use std::collections::BTreeMap;
use std::sync::Arc;

use sha2::{Digest as _, Sha256};

use crate::definition::{Base, Count, Field, Primitive, Type};
use crate::layout::Layout;

impl Layout {
    /// The type hash of the message, version 1: `RIHS01_` and the SHA-256 of its description, in 64 digits. It covers
    /// the names and types of all fields, in nested messages too; not constants, default values and comments.
    ///
    /// Services and actions as a whole also have hashes; this is that of one message, such as a request.
    #[must_use]
    pub fn type_hash(&self) -> String {
        let mut referenced = BTreeMap::new();
        self.add_referenced(&mut referenced);
        // ROS hashes this text byte for byte, so spaces and the order of keys matter. Names need no escapes.
        let types: Vec<String> = referenced.values().map(|layout| layout.description()).collect();
        let text = format!(
            r#"{{"type_description": {}, "referenced_type_descriptions": [{}]}}"#,
            self.description(),
            types.join(", ")
        );
        Sha256::digest(text).iter().fold("RIHS01_".to_owned(), |mut hash, byte| {
            hash += &format!("{byte:02x}");
            hash
        })
    }

    /// Adds the types in this one, which ROS sorts by their full names.
    fn add_referenced<'l>(&'l self, types: &mut BTreeMap<String, &'l Self>) {
        for field in &self.fields {
            if let Base::Message(layout) = &field.kind.base
                && types.insert(layout.name.full(), layout).is_none()
            {
                layout.add_referenced(types);
            }
        }
    }

    fn description(&self) -> String {
        // In IDL, for which the hash is defined, a struct has at least one member.
        let dummy = Type { base: Base::Primitive(Primitive::Uint8), count: Count::One };
        let dummy = self.fields.is_empty().then(|| Field::new("structure_needs_at_least_one_member", dummy));
        let fields: Vec<String> =
            self.fields.iter().chain(&dummy).map(|field| described(&field.name, &field.kind)).collect();
        format!(r#"{{"type_name": "{}", "fields": [{}]}}"#, self.name.full(), fields.join(", "))
    }
}

fn described(name: &str, kind: &Type<Arc<Layout>>) -> String {
    let (item, string_capacity, nested) = match &kind.base {
        Base::Primitive(primitive) => (number(*primitive), bound(*primitive), String::new()),
        Base::Message(layout) => (1, 0, layout.name.full()),
    };
    // Arrays, bounded and unbounded sequences have the numbers of their items, 48, 96 and 144 higher.
    let (array, capacity) = match kind.count {
        Count::One => (0, 0),
        Count::Exactly(count) => (48, count),
        Count::UpTo(bound) => (96, bound),
        Count::Any => (144, 0),
    };
    format!(
        r#"{{"name": "{name}", "type": {{"type_id": {}, "capacity": {capacity}, "string_capacity": {string_capacity}, "nested_type_name": "{nested}"}}}}"#,
        item + array
    )
}

/// The constants of `type_description_interfaces/FieldType`. A `char` of a `.msg` file is a `uint8` in IDL.
fn number(primitive: Primitive) -> u8 {
    match primitive {
        Primitive::Int8 => 2,
        Primitive::Uint8 | Primitive::Char => 3,
        Primitive::Int16 => 4,
        Primitive::Uint16 => 5,
        Primitive::Int32 => 6,
        Primitive::Uint32 => 7,
        Primitive::Int64 => 8,
        Primitive::Uint64 => 9,
        Primitive::Float32 => 10,
        Primitive::Float64 => 11,
        Primitive::Bool => 15,
        Primitive::Byte => 16,
        Primitive::String(None) => 17,
        Primitive::WString(None) => 18,
        Primitive::String(Some(_)) => 21,
        Primitive::WString(Some(_)) => 22,
    }
}

/// The longest string, if it is bounded.
fn bound(primitive: Primitive) -> usize {
    match primitive {
        Primitive::String(bound) | Primitive::WString(bound) => bound.unwrap_or(0),
        _ => 0,
    }
}
