//! Prints the messages of a bag as JSON, one per line, with all their fields: `print_messages BAG [FOLDER…]`. The
//! folders contain definitions that the bag lacks.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bags::{Bag, Definitions, Source as _};
use ros_messages::{Base, Decoder, Layout, Value, Want};
use serde_json::{Map, json};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let bag = Bag::open(&arguments.next().ok_or("which bag?")?)?;
    let folders: Vec<PathBuf> = arguments.collect();
    let topics = &bag.survey().topics;
    let definitions =
        Definitions { survey: bag.survey(), folders: &folders, read: &|path: &Path| diagnostics::from_disk(path) };
    let mut layouts = BTreeMap::new();
    for (index, topic) in topics.iter().enumerate() {
        match definitions.layout(topic) {
            Ok(layout) => drop(layouts.insert(index, (Decoder::new(&layout, &Want::All), layout))),
            Err(undefined) => eprintln!("{}: {undefined}", topic.name),
        }
    }
    let wanted: Vec<usize> = layouts.keys().copied().collect();
    let (mut messages, mut body) = (bag.messages(&wanted), Vec::new());
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    while let Some(head) = messages.next_into(&mut body) {
        let (decoder, layout) = &layouts[&head.topic];
        let message = match decoder.decode(&body) {
            Ok(message) => of_message(&message, layout),
            Err(mismatch) => json!({ "mismatch": mismatch.to_string() }),
        };
        let (topic, kind) = (&topics[head.topic].name, &topics[head.topic].kind);
        writeln!(out, "{}", json!({ "topic": topic, "type": kind, "log_ns": head.log_ns, "message": message }))?;
    }
    out.flush()?;
    let missing = messages.survey().missing.iter().map(|(_, missing)| missing);
    bag.survey().lost.iter().chain(messages.lost()).chain(missing).for_each(|lost| eprintln!("{lost}"));
    Ok(())
}

fn of_message(message: &Value, layout: &Layout) -> serde_json::Value {
    let Value::Message(values) = message else { return json!(null) };
    let fields = layout.fields.iter().zip(values).map(|(field, value)| {
        let json = match value {
            Value::List(items) => items.iter().map(|item| of_item(item, &field.kind.base)).collect(),
            single => of_item(single, &field.kind.base),
        };
        (field.name.clone(), json)
    });
    fields.collect::<Map<_, _>>().into()
}

fn of_item(value: &Value, base: &Base<Arc<Layout>>) -> serde_json::Value {
    match (value, base) {
        (Value::Bool(truth), _) => json!(truth),
        // JSON has neither infinity nor NaN.
        (Value::Real(number), _) if !number.is_finite() => json!(number.to_string()),
        (Value::Real(number), _) => json!(number),
        (Value::Int(number), _) => {
            i64::try_from(*number).map_or_else(|_| json!(*number as u64), |number| json!(number))
        }
        (Value::Text(text), _) => json!(text),
        (message, Base::Message(layout)) => of_message(message, layout),
        _ => json!(null),
    }
}
