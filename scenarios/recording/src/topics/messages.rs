//! The messages of a channel as messages of a ROS type that is made for it.

use std::collections::BTreeSet;

use channels::{Domain, Event, FieldKind, Message, Symbol, Value};
use ros_messages::{Base, Bundle, CdrWriter, Count, Field, Primitive, RosType, Type};

use crate::ros::Moment;

/// The type of a channel's messages: the time of receipt, and the fields of all shapes.
///
/// A field that some messages do not have is a sequence of at most one element.
pub(super) struct MessageType {
    domain: Domain,
    fields: Vec<TypeField>,
    /// By shape and field, where the shape has the field.
    places: Vec<Vec<Option<usize>>>,
}

struct TypeField {
    /// Its name in the domain, and the ROS type of its values.
    of: (String, FieldType),
    /// Its name in ROS.
    name: String,
    /// Whether a message may lack it.
    is_optional: bool,
}

/// The ROS type for values of a kind, and whether there may be no value.
fn ros_type(kind: &FieldKind) -> (FieldType, bool) {
    let one = |primitive| ((primitive, Count::One), false);
    match kind {
        FieldKind::Bool => one(Primitive::Bool),
        FieldKind::Int => one(Primitive::Int64),
        FieldKind::Real => one(Primitive::Float64),
        FieldKind::Symbol(_) | FieldKind::Text => one(Primitive::String(None)),
        FieldKind::Optional(kind) => (ros_type(kind).0, true),
        // ROS has no sequences of sequences, and no channel has lists of lists. An item that may be missing is left
        // out.
        FieldKind::List(kind) => ((ros_type(kind).0.0, Count::Any), false),
    }
}

/// A primitive type, alone or in a sequence.
type FieldType = (Primitive, Count);

/// The name of the field with the time of receipt.
const MOMENT: &str = "event";

impl MessageType {
    /// Shapes that share a field, by name and kind, share it in ROS. It can be missing unless every shape has it.
    pub(super) fn new(domain: &Domain) -> Self {
        let mut fields: Vec<TypeField> = Vec::new();
        let mut taken = BTreeSet::from([MOMENT.to_owned()]);
        for shape in domain.shapes() {
            for (name, kind) in shape.fields() {
                let of = (name.clone(), ros_type(kind).0);
                if !fields.iter().any(|field| field.of == of) {
                    fields.push(TypeField { name: ros_name(name, &mut taken), of, is_optional: false });
                }
            }
        }
        // ROS has no unions: a field that some shapes lack is a sequence of at most one value.
        for field in &mut fields {
            let always =
                |(name, kind): &(String, FieldKind)| (name, ros_type(kind)) == (&field.of.0, (field.of.1, false));
            field.is_optional = !domain.shapes().iter().all(|shape| shape.fields().iter().any(always));
        }
        let places = domain.shapes().iter().map(|shape| {
            let place = |field: &TypeField| {
                let is_it = |(name, kind): &(String, FieldKind)| (name, ros_type(kind).0) == (&field.of.0, field.of.1);
                shape.fields().iter().position(is_it)
            };
            fields.iter().map(place).collect()
        });
        Self { places: places.collect(), domain: domain.clone(), fields }
    }

    pub(super) fn definition(&self) -> Bundle {
        let fields = self.fields.iter().map(|field| {
            let (primitive, count) = field.of.1;
            // A list that a message lacks is an empty sequence.
            let count = if field.is_optional && count == Count::One { Count::UpTo(1) } else { count };
            Field::new(&field.name, Type { base: Base::Primitive(primitive), count })
        });
        let fields = std::iter::once(Field::new(MOMENT, Moment::kind())).chain(fields).collect();
        let mut types = Vec::new();
        Moment::define(&mut types);
        Bundle { message: ros_messages::Message { fields, ..Default::default() }, types }
    }

    pub(super) fn write(&self, event: &Event, message: &Message, cdr: &mut CdrWriter) {
        Moment { step: event.step, tick: event.tick }.write(cdr);
        // A message has one of the shapes: if none of the others, the last.
        let mut shapes = self.domain.shapes().iter().zip(&self.places);
        let last = shapes.next_back();
        let shape = shapes.find(|(shape, _)| shape.contains(message)).or(last);
        for (index, field) in self.fields.iter().enumerate() {
            let place = shape.and_then(|(shape, places)| Some((shape, places[index]?)));
            let value = place.and_then(|(shape, at)| Some((&shape.fields()[at].1, message.fields().get(at)?)));
            let is_none = |kind: &FieldKind, value: &Value| {
                matches!(kind, FieldKind::Optional(_)) && value.is_symbol(FieldKind::NONE)
            };
            let value = value.filter(|(kind, value)| !is_none(kind, value)).map(|(_, value)| value);
            let is_list = field.of.1.1 == Count::Any;
            if is_list && value.is_none() || field.is_optional && !is_list {
                cdr.length(usize::from(value.is_some()));
            }
            value.into_iter().for_each(|value| write_value(value, cdr));
        }
    }
}

fn write_value(value: &Value, cdr: &mut CdrWriter) {
    match value {
        Value::Symbol(symbol) => cdr.text(Symbol::name(symbol)),
        Value::Bool(truth) => truth.write(cdr),
        Value::Int(number) => number.write(cdr),
        Value::Real(number) => number.write(cdr),
        Value::Text(text) => cdr.text(text),
        Value::List(items) => {
            let items: Vec<&Value> = items.iter().filter(|item| !item.is_symbol(FieldKind::NONE)).collect();
            cdr.length(items.len());
            items.into_iter().for_each(|item| write_value(item, cdr));
        }
    }
}

/// A name for a field that ROS allows and that is not taken yet: lowercase letters, digits and single underscores.
fn ros_name(name: &str, taken: &mut BTreeSet<String>) -> String {
    let small = name.to_ascii_lowercase();
    let words = small.split(|letter: char| !letter.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let mut joined = words.collect::<Vec<_>>().join("_");
    if !joined.starts_with(|letter: char| letter.is_ascii_lowercase()) {
        joined.insert_str(0, "field_");
    }
    unique(joined.trim_end_matches('_'), taken)
}

/// The name, with a number if it is taken.
pub(super) fn unique(name: &str, taken: &mut BTreeSet<String>) -> String {
    let numbered = (2_u64..).map(|number| format!("{name}{number}"));
    let free = std::iter::once(name.to_owned()).chain(numbered).find(|name| !taken.contains(name)).unwrap_or_default();
    taken.insert(free.clone());
    free
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use channels::{EventKind, Shape};

    use super::*;

    #[test]
    fn a_field_that_messages_may_lack_is_a_sequence() {
        let optional = FieldKind::Optional(Box::new(FieldKind::Int));
        let domain = Domain::new([
            Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real), ("Event", optional)]),
            Shape::new([("status", FieldKind::symbols(["error"])), ("the reason!", FieldKind::Text)]),
        ]);
        let channel = MessageType::new(&domain);
        let fields = "steward_msgs/Event event\nstring status\nfloat64[<=1] level\nint64[<=1] event2\n\
                      string[<=1] the_reason\n";
        assert!(channel.definition().to_string().starts_with(fields), "{}", channel.definition());
        let encoded = |values: Vec<Value>| {
            let message = Message::new(values);
            let event = Event { step: 5, tick: 2, time: Duration::ZERO, kind: EventKind::Tick };
            let mut cdr = CdrWriter::reusing(Vec::new());
            channel.write(&event, &message, &mut cdr);
            cdr.bytes()
        };
        let start = [&[0, 1, 0, 0][..], &5_u64.to_le_bytes(), &2_u64.to_le_bytes()].concat();
        let failed = encoded(vec![Value::symbol("error"), "no".into()]);
        let error = [6, 0, 0, 0, b'e', b'r', b'r', b'o', b'r', 0, 0, 0];
        let rest = [1, 0, 0, 0, 3, 0, 0, 0, b'n', b'o', 0];
        assert_eq!(failed, [&start[..], &error, &[0; 8], &rest].concat());
        let fine = encoded(vec![Value::symbol("ok"), 0.5.into(), Value::symbol("none")]);
        let ok = [3, 0, 0, 0, b'o', b'k', 0, 0, 1, 0, 0, 0, 0, 0, 0, 0];
        let level = 0.5_f64.to_le_bytes();
        assert_eq!(fine[20..], [&ok[..], &level, &[0; 8]].concat()[..]);
    }

    #[test]
    fn names_are_made_valid_in_ros() {
        let mut taken = BTreeSet::new();
        let names = ["m[2]", "1st", "Ü", "a__b_", "a b"].map(|name| ros_name(name, &mut taken));
        assert_eq!(names, ["m_2", "field_1st", "field", "a_b", "a_b2"]);
    }
}
