//! The machine of a component that may send anything, written as SCXML.

use channels::{FieldKind, Value};
use interfaces::{
    ABORTED, ACCEPTED, Action, CANCEL, CANCELED, ERROR, FEEDBACK, Field, GOAL, Interface, OK, REASON, REJECTED,
    SUCCEEDED, Service,
};

use crate::scenario::scxml_text::Text;

/// The values of a field that anything distinguishes, or why they cannot be listed.
type Samples<'s> = dyn Fn(&Field) -> Result<Vec<Value>, String> + 's;

/// The client of the last request.
const CLIENT: &str = "client";

/// With more different messages of one kind than this, a proof would take too long. Chosen, not measured.
const MOST: usize = 200;

/// A message: what it begins with, and its fields.
type Answer = (String, Vec<(String, Value)>);

/// Something that happens by itself, at most once per tick: the publication of a topic, or progress of an action.
struct Turn<'i> {
    /// The action, if it is one.
    action: Option<&'i Action>,
    messages: Vec<Answer>,
}

/// Everything that a component may send, from its interface.
pub(super) struct Repertoire<'i> {
    turns: Vec<Turn<'i>>,
    services: Vec<(&'i Service, Vec<Answer>)>,
    actions: Vec<Course<'i>>,
}

/// What becomes of the goals of an action.
struct Course<'i> {
    action: &'i Action,
    rejected: Vec<Answer>,
    /// Its ends once it is canceled.
    ends: Vec<Answer>,
}

impl<'i> Repertoire<'i> {
    /// Everything that a component with this interface may send. `samples` gives the values of a field that anything
    /// distinguishes.
    ///
    /// # Errors
    /// Why it cannot be listed, in words.
    pub(super) fn of(interface: &'i Interface, samples: &Samples<'_>) -> Result<Self, String> {
        let messages = |head: &str, fields: &[Field]| all(head, fields, samples);
        let refusals = |head: &str| messages(head, &[Field { name: REASON.to_owned(), kind: FieldKind::Text }]);
        let (mut turns, mut services, mut actions) = (Vec::new(), Vec::new(), Vec::new());
        for topic in &interface.topics {
            turns.push(Turn { action: None, messages: messages(&topic.name, &topic.fields)? });
        }
        for service in &interface.services {
            services.push((service, [messages(OK, &service.reply)?, refusals(ERROR)?].concat()));
        }
        for action in &interface.actions {
            let of = |part: &str| format!("{}.{part}", action.name);
            let feedback = messages(&of(FEEDBACK), &action.feedback)?;
            let own_ends = [messages(&of(SUCCEEDED), &action.result)?, refusals(&of(ABORTED))?].concat();
            let ends = [messages(&of(CANCELED), &[])?, own_ends.clone()].concat();
            turns.push(Turn { action: Some(action), messages: [feedback, own_ends].concat() });
            actions.push(Course { action, rejected: refusals(&of(REJECTED))?, ends });
        }
        Ok(Self { turns, services, actions })
    }

    /// The machine of a component that answers every request at once, with anything, publishes anything or nothing once
    /// per tick, and pursues one goal of each action at a time. It ignores the `received` events.
    pub(super) fn scxml(&self, name: &str, received: &[String], tick_s: f64) -> String {
        let pursued = self.actions.iter().map(|course| pursued(course.action));
        let data = [CLIENT.to_owned()].into_iter().chain(pursued);
        Text::machine(name, |text| {
            text.element("datamodel", &[], |text| {
                data.for_each(|datum| text.empty("data", &[("id", &datum), ("expr", "''")]));
            });
            text.state("any", |text| {
                self.take_turns(tick_s, text);
                for (service, answers) in &self.services {
                    let choice = format!("choice.{}", service.name);
                    answer(text, &choice, answers, |_| {});
                    ask(text, &service.name, None, |text| choose(text, &choice, answers));
                }
                self.actions.iter().for_each(|course| course.write(text));
                received.iter().for_each(|event| text.transition(event, None, None, |_| {}));
            });
        })
    }

    /// Begins with the first turn once per tick.
    fn take_turns(&self, tick_s: f64, text: &mut Text) {
        let again = |text: &mut Text| text.empty("send", &[("event", "again"), ("delay", &format!("{tick_s}s"))]);
        if !self.turns.is_empty() {
            text.element("onentry", &[], again);
            text.transition("again", None, None, |text| {
                again(text);
                begin_turn(text, 0);
            });
        }
        for (number, turn) in self.turns.iter().enumerate() {
            turn.write(number, (number + 1 < self.turns.len()).then_some(number + 1), text);
        }
    }
}

/// All messages that begin with this symbol.
fn all(head: &str, fields: &[Field], samples: &Samples<'_>) -> Result<Vec<Answer>, String> {
    let mut messages: Vec<Answer> = vec![(head.to_owned(), Vec::new())];
    for field in fields {
        let values = samples(field)?;
        let with = |(head, before): &Answer, value: &Value| {
            let field = (field.name.clone(), value.clone());
            (head.clone(), before.iter().cloned().chain([field]).collect())
        };
        messages = messages.iter().flat_map(|message| values.iter().map(move |value| with(message, value))).collect();
        if messages.len() > MOST {
            return Err(format!("there are more than {MOST} different messages `{head}`"));
        }
    }
    Ok(messages)
}

/// The datum that holds the client whose goal of this action is pursued.
fn pursued(action: &Action) -> String {
    let word: String = action.name.chars().map(|sign| if sign.is_alphanumeric() { sign } else { '_' }).collect();
    format!("{word}__")
}

fn begin_turn(text: &mut Text, number: usize) {
    text.empty("raise", &[("event", &format!("turn.{number}"))]);
}

/// The transition of a request, which notes the client.
fn ask(text: &mut Text, event: &str, cond: Option<&str>, then: impl FnOnce(&mut Text)) {
    text.transition(event, cond, None, |text| {
        text.assign(CLIENT, "_event.origin");
        then(text);
    });
}

/// The names of the events that stand for these messages. They begin with the choice's name and a number, and end with
/// words for people.
fn names<'a>(choice: &'a str, messages: &'a [Answer]) -> impl Iterator<Item = String> + 'a {
    messages.iter().enumerate().map(move |(number, (head, fields))| {
        let values = fields.iter().map(|(_, value)| (value.to_string(), value.is_number()));
        let words = std::iter::once((head.clone(), true)).chain(values).map(|(word, has_dots)| {
            // A name is a list of words with dots between them, which a text would tear apart.
            let is_plain = |sign: char| sign.is_ascii_alphanumeric() || sign == '-' || has_dots && sign == '.';
            let plain = word.chars().map(|sign| if is_plain(sign) { sign } else { '_' });
            plain.take(20).collect::<String>().trim_matches('_').to_owned()
        });
        format!("{choice}.{number}.{}", words.collect::<Vec<_>>().join("_"))
    })
}

/// Chooses among these messages.
fn choose(text: &mut Text, choice: &str, messages: &[Answer]) {
    names(choice, messages).for_each(|event| text.empty("send", &[("type", "choice"), ("event", &event)]));
}

/// The transition of each choice of a message to the client, and what follows it.
fn answer(text: &mut Text, choice: &str, answers: &[Answer], then: impl Fn(&mut Text)) {
    for (event, message) in names(choice, answers).zip(answers) {
        text.transition(&event, None, None, |text| {
            send(text, Some(CLIENT), message);
            then(text);
        });
    }
}

/// Sends a message to a process that this datum names, or publishes it.
fn send(text: &mut Text, to: Option<&str>, (head, fields): &Answer) {
    let to = to.map(|to| ("targetexpr", to));
    let attributes: Vec<_> = [("type", "channel")].into_iter().chain(to).chain([("event", &**head)]).collect();
    let there = fields.iter().filter(|(_, value)| !value.is_symbol(FieldKind::NONE));
    text.send(&attributes, there.map(|(name, value)| (&**name, literal(value))));
}

/// A value in ECMAScript.
fn literal(value: &Value) -> String {
    match value {
        Value::Symbol(symbol) => serde_json::Value::from(symbol.name()).to_string(),
        Value::Text(text) => serde_json::Value::from(&**text).to_string(),
        Value::Real(number) if number.is_infinite() => format!("{}Infinity", if *number < 0.0 { "-" } else { "" }),
        other => other.to_string(),
    }
}

impl Turn<'_> {
    /// What may happen in this turn, or nothing; then it is the `next` one's turn, if there is one.
    fn write(&self, number: usize, next: Option<usize>, text: &mut Text) {
        let (turn, choice) = (format!("turn.{number}"), format!("choice.turn.{number}"));
        let go_on = |text: &mut Text| next.into_iter().for_each(|next| begin_turn(text, next));
        let client = self.action.map(pursued);
        for (event, message) in names(&choice, &self.messages).zip(&self.messages) {
            text.transition(&event, None, None, |text| {
                send(text, client.as_deref(), message);
                let ends = self.action.is_some_and(|action| message.0 != format!("{}.{FEEDBACK}", action.name));
                if let Some(client) = client.as_ref().filter(|_| ends) {
                    text.assign(client, "''");
                }
                go_on(text);
            });
        }
        let nothing = format!("{choice}.nothing");
        text.transition(&nothing, None, None, go_on);
        let cond = client.map(|client| format!("{client} != ''"));
        text.transition(&turn, cond.as_deref(), None, |text| {
            // First, so that a shortest run prefers it.
            text.empty("send", &[("type", "choice"), ("event", &nothing)]);
            choose(text, &choice, &self.messages);
        });
        if self.action.is_some() {
            text.transition(&turn, None, None, go_on);
        }
    }
}

impl Course<'_> {
    /// Goals, and requests to cancel one, which is then at an end.
    fn write(&self, text: &mut Text) {
        let Self { action, rejected, ends } = self;
        let (name, pursued) = (&action.name, pursued(action));
        let part = |part: &str| format!("{name}.{part}");
        let forget = |text: &mut Text| text.assign(&pursued, "''");
        let (goal, cancel) = (format!("choice.{name}.{GOAL}"), format!("choice.{name}.{CANCEL}"));
        // A client that sends a goal again has given up its last one.
        answer(text, &format!("{goal}.no"), rejected, forget);
        let accepted = [(part(ACCEPTED), Vec::new())];
        answer(text, &format!("{goal}.yes"), &accepted, |text| text.assign(&pursued, CLIENT));
        answer(text, &format!("{goal}.other"), rejected, |_| {});
        answer(text, &cancel, ends, forget);
        ask(text, &part(GOAL), Some(&format!("{pursued} == '' || {pursued} == _event.origin")), |text| {
            choose(text, &format!("{goal}.yes"), &accepted);
            choose(text, &format!("{goal}.no"), rejected);
        });
        ask(text, &part(GOAL), None, |text| choose(text, &format!("{goal}.other"), rejected));
        ask(text, &part(CANCEL), Some(&format!("{pursued} == _event.origin")), |text| choose(text, &cancel, ends));
    }
}
