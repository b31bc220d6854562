//! Random definitions and interface files.

use std::io;
use std::path::Path;

use channels::{FieldKind, Symbol};
use interfaces::Interface;
use proptest::collection::{btree_map, btree_set, vec};
use proptest::prelude::*;
use ros_messages::{Count, Decoder, Message, Value, Want, WideWidth};

/// A definition with fields of any type, constants and annotations.
fn message() -> impl Strategy<Value = Message> {
    let primitive = "bool|byte|char|u?int(8|16|32|64)|float(32|64)|w?string(<=[1-8])?";
    let kind = format!(
        "(@optional )?(@key )?({primitive}|[A-Z][A-Za-z0-9]{{0,5}}|[a-z](_?[a-z0-9]){{0,3}}/[A-Z][a-z]{{0,5}})"
    );
    let kind = kind + "(|\\[\\]|\\[(<=)?[1-3]\\])";
    let kind = proptest::string::string_regex(&kind).expect("an expression");
    let constants = btree_set("[A-Z](_?[A-Z0-9]){0,4}", 0..4);
    let fields = btree_map("[a-z](_?[a-z0-9]){0,4}", kind, 0..5);
    (constants, fields).prop_map(|(constants, fields)| {
        let constants = constants.iter().map(|name| format!("int8 {name}=1\n"));
        let fields = fields.iter().map(|(name, kind)| format!("{kind} {name}\n"));
        Message::parse("a definition", &constants.chain(fields).collect::<String>()).expect("a definition")
    })
}

/// A value that is not what a message has without it.
fn value(kind: &FieldKind) -> Value {
    match kind {
        FieldKind::Bool => Value::Bool(true),
        FieldKind::Int => Value::Int(7),
        FieldKind::Real => Value::Real(0.5),
        FieldKind::Optional(kind) => value(kind),
        FieldKind::List(kind) => Value::List(vec![value(kind); 2]),
        _ => Value::Text("x".to_owned()),
    }
}

proptest! {
    #[test]
    fn any_definition_gives_fields_or_problems(
        message in message(),
        paths in vec("[a-z](_?[a-z0-9]){0,2}(\\[[0-9]\\])?(\\.[a-z]){0,1}", 0..3),
        all in any::<bool>(),
    ) {
        let fields = if all { String::new() } else { format!("fields = {paths:?}\n") };
        let file = format!("[topics.t]\nros = 'a/msg/T.msg'\n{fields}");
        let read = |path: &Path| match path.to_str() {
            Some("i.toml") => Ok(file.clone().into_bytes()),
            Some("a/msg/T.msg") => Ok(message.to_string().into_bytes()),
            Some(other) if other.strip_prefix("a/msg/").is_some_and(|name| !name.contains('/')) => {
                Ok(b"int8 inner".to_vec())
            }
            _ => Err(io::ErrorKind::NotFound.into()),
        };
        if let Ok(interface) = Interface::load(Path::new("i.toml"), &[], &read) {
            let count = interface.topics[0].fields.len();
            prop_assert!(!all || count >= message.fields.iter().filter(|field| field.kind.count != Count::Any).count());
            // What is put into a message of ROS 2 is what comes out of it.
            let topic = &interface.topics[0];
            if let Ok(wire) = &topic.wire {
                let part = &wire.parts[0];
                let values: Vec<Value> = topic.fields.iter().map(|field| value(&field.kind)).collect();
                let sent = part.message(values.clone()).expect("each has a place");
                let bytes = part.layout.encode(&sent).expect("it is of that type");
                let decoder = Decoder::new(&part.layout, &Want::All).with_width(Some(WideWidth::default()));
                let came = decoder.decode(&bytes).expect("it was encoded");
                prop_assert_eq!(part.fields(&came), values);
            }
        }
    }

    #[test]
    fn any_interface_file_is_either_read_or_refused(lines in vec(line(), 0..12)) {
        let text = lines.concat();
        let read = |path: &Path| match path.to_str() {
            Some("i.toml") => Ok(text.clone().into_bytes()),
            _ => Err(io::ErrorKind::NotFound.into()),
        };
        if let Ok(interface) = Interface::load(Path::new("i.toml"), &[Symbol::new("Dock")], &read) {
            let heads = interface.requests().len();
            prop_assert_eq!(heads, interface.services.len() + 2 * interface.actions.len());
            if let Ok(replies) = interface.replies() {
                // Every message of the component can be read in only one way.
                for (index, shape) in replies.iter().enumerate() {
                    prop_assert!(!replies[..index].contains(shape));
                }
            }
        }
    }
}

/// A line of an interface file, possibly with mistakes.
fn line() -> impl Strategy<Value = String> {
    let header = "\\[(services|topics|actions)\\.[a-d]\\]\\n";
    let part = "(request|reply|fields|goal|feedback|result|ros) = ";
    let kind = "(\"(int|real\\?|text|place|bool|boole)\"|\\[\"x\", \"y\"\\]|\\[\\]|3)";
    let fields = format!("{part}\\{{ (a = {kind}, )?(status = {kind}, )?b = {kind} \\}}\\n");
    prop_oneof![header, proptest::string::string_regex(&fields).expect("an expression")]
}
