//! A program graph as an SCXML machine with the ECMAScript data model.
//!
//! A message from P to Q is the event `message.P.Q` with the message as an array in `_event.data`: symbols are `{ sym:
//! "ok" }`, as in event logs. A tick is the event `tick` with its number in `_event.data`. A location that means
//! violation is a state with the same name that raises the event `violated` and is never left.

use channels::{
    Assignment, Condition, Content, GraphTransition, Label, LocationId, Message, ProgramGraph, Relation, Slot, Term,
    Topology, Value, VariableId,
};
use diagnostics::markup::attribute;

/// The meaning of comparisons and fields, in ECMAScript.
const SCRIPT: &str = r#"
      function field(m, k) { return Array.isArray(m) && k <= m.length ? m[k - 1] : undefined; }
      function same(a, b) {
        if (a === undefined || b === undefined) return false;
        if (Array.isArray(a)) return a === b;
        if (typeof a === "object" || typeof b === "object")
          return typeof a === "object" && typeof b === "object" && a.sym === b.sym;
        return a === b;
      }
      function less(a, b) { return typeof a === "number" && typeof b === "number" && a < b; }
      function most(a, b) { return typeof a === "number" && typeof b === "number" && a <= b; }
    "#;

pub(crate) fn scxml(graph: &ProgramGraph, failures: &[LocationId], topology: &Topology) -> String {
    let initial = graph.initial_locations().first().map_or("", |initial| &graph.locations()[initial.index()]);
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" \
         datamodel=\"ecmascript\" name=\"{}\" initial=\"{}\">\n  <script><![CDATA[{SCRIPT}]]></script>\n  <datamodel>\n",
        attribute(graph.name()),
        id(initial)
    );
    let names: Vec<String> = graph.variables().iter().map(|name| id(name)).collect();
    for (name, content) in names.iter().zip(graph.initial_contents()) {
        text += &format!("    <data id=\"{name}\" expr=\"{}\"/>\n", attribute(&content_expression(content)));
    }
    text.push_str("  </datamodel>\n");
    for (index, location) in graph.locations().iter().enumerate() {
        text += &format!("  <state id=\"{}\">\n", id(location));
        if failures.iter().any(|failure| failure.index() == index) {
            text.push_str("    <onentry><raise event=\"violated\"/></onentry>\n");
        }
        let leaving = graph.transitions().iter().filter(|transition| transition.from.index() == index);
        leaving.for_each(|transition| write_transition(&mut text, transition, (graph, &names), topology));
        text.push_str("  </state>\n");
    }
    text.push_str("</scxml>\n");
    text
}

fn write_transition(
    text: &mut String,
    transition: &GraphTransition,
    (graph, names): (&ProgramGraph, &[String]),
    topology: &Topology,
) {
    let Some((event, given, assignments)) = labelled(&transition.label, names, topology) else { return };
    let mut conditions = given;
    if transition.guard != Condition::True {
        conditions.push(condition_expression(&transition.guard, names));
    }
    text.push_str("    <transition");
    if let Some(event) = event {
        *text += &format!(" event=\"{event}\"");
    }
    if !conditions.is_empty() {
        *text += &format!(" cond=\"{}\"", attribute(&conditions.join(" && ")));
    }
    *text += &format!(" target=\"{}\"", id(&graph.locations()[transition.to.index()]));
    if assignments.is_empty() {
        text.push_str("/>\n");
        return;
    }
    text.push('>');
    for (name, expression) in assignments {
        *text += &format!("<assign location=\"{name}\" expr=\"{}\"/>", attribute(&expression));
    }
    text.push_str("</transition>\n");
}

/// The requirements of a label: an event, conditions on it, and assignments of expressions to variables. `None` for a
/// label that sends, which monitors do not have.
type Labelled = (Option<String>, Vec<String>, Vec<(String, String)>);

fn labelled(label: &Label, names: &[String], topology: &Topology) -> Option<Labelled> {
    let name = |variable: &VariableId| names[variable.index()].clone();
    match label {
        Label::Internal(effect) => {
            let assign = |Assignment { variable, term }: &Assignment| (name(variable), term_expression(term, names));
            Some((None, Vec::new(), effect.iter().map(assign).collect()))
        }
        Label::Tick(variable) => {
            let message = "[{sym: \"tick\"}, _event.data]".to_owned();
            Some((Some("tick".to_owned()), Vec::new(), vec![(name(variable), message)]))
        }
        Label::Receive(channel, slot) => {
            let (source, target) = topology.ends(*channel);
            let event = Some(format!("message.{}.{}", id(source), id(target)));
            match slot {
                Slot::Variable(variable) => Some((event, Vec::new(), vec![(name(variable), "_event.data".to_owned())])),
                Slot::Given(message) => Some((event, equalities(message), Vec::new())),
            }
        }
        Label::Send(..) => None,
    }
}

/// The conditions that the event's data equals this message.
fn equalities(message: &Message) -> Vec<String> {
    let length = format!("_event.data.length === {}", message.fields().len());
    let same = |(index, value): (usize, &Value)| format!("same(_event.data[{index}], {})", value_expression(value));
    std::iter::once(length).chain(message.fields().iter().enumerate().map(same)).collect()
}

fn condition_expression(condition: &Condition, names: &[String]) -> String {
    let join = |parts: &[Condition], operator: &str, empty: &str| {
        let parts: Vec<String> = parts.iter().map(|part| condition_expression(part, names)).collect();
        if parts.is_empty() { empty.to_owned() } else { format!("({})", parts.join(operator)) }
    };
    match condition {
        Condition::True => "true".to_owned(),
        Condition::Not(part) => format!("!({})", condition_expression(part, names)),
        Condition::And(parts) => join(parts, " && ", "true"),
        Condition::Or(parts) => join(parts, " || ", "false"),
        Condition::Compare(a, relation, b) => {
            let (a, b) = (term_expression(a, names), term_expression(b, names));
            match relation {
                Relation::Equal => format!("same({a}, {b})"),
                Relation::NotEqual => format!("!same({a}, {b})"),
                Relation::Less => format!("less({a}, {b})"),
                Relation::LessOrEqual => format!("most({a}, {b})"),
                Relation::Greater => format!("less({b}, {a})"),
                Relation::GreaterOrEqual => format!("most({b}, {a})"),
            }
        }
    }
}

fn term_expression(term: &Term, names: &[String]) -> String {
    match term {
        Term::Constant(value) => value_expression(value),
        Term::Variable(variable) => names[variable.index()].clone(),
        Term::Field(variable, number) => format!("field({}, {number})", names[variable.index()]),
        Term::Sum(a, b) => format!("({} + {})", term_expression(a, names), term_expression(b, names)),
        Term::Difference(a, b) => format!("({} - {})", term_expression(a, names), term_expression(b, names)),
        Term::Tuple(terms) => {
            let terms: Vec<String> = terms.iter().map(|term| term_expression(term, names)).collect();
            format!("[{}]", terms.join(", "))
        }
    }
}

fn content_expression(content: &Content) -> String {
    match content {
        Content::Nothing => "undefined".to_owned(),
        Content::Value(value) => value_expression(value),
        Content::Message(message) => {
            let fields: Vec<String> = message.fields().iter().map(value_expression).collect();
            format!("[{}]", fields.join(", "))
        }
    }
}

fn value_expression(value: &Value) -> String {
    match value {
        Value::Symbol(symbol) => format!("{{sym: {}}}", quoted(symbol.name())),
        Value::Text(text) => quoted(text),
        other => other.to_string(),
    }
}

fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for char in text.chars() {
        match char {
            '"' | '\\' => quoted.extend(['\\', char]),
            char if char.is_control() => {
                quoted += &format!("\\u{:04x}", u32::from(char));
            }
            char => quoted.push(char),
        }
    }
    quoted.push('"');
    quoted
}

/// A name as an identifier of the document.
fn id(name: &str) -> String {
    name.chars().map(|char| if char.is_alphanumeric() { char } else { '_' }).collect()
}
