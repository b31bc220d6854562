//! Elements, attributes, events and data of machines.

use std::collections::BTreeSet;
use std::ops::Range;

use skills::{MessageForm, Vocabulary};

use crate::expressions::{compared, is_in_text, symbols, word_in};
use crate::knowledge::Knowledge;
use crate::proposal::{Explanation, Proposal, ProposalKind};
use crate::xml_place::{Tag, XmlCursor, XmlPlace, elements, inside, place};

/// The elements with states.
pub(crate) const STATES: [&str; 4] = ["state", "parallel", "final", "history"];

/// The members of `_event` (SCXML 5.10.1).
const OF_EVENT: [&str; 7] = ["data", "name", "origin", "origintype", "sendid", "invokeid", "type"];

/// What may be written at a place of a machine with these messages.
pub(crate) fn proposals(text: &str, at: usize, known: &Knowledge, messages: &Vocabulary) -> Vec<Proposal> {
    let Some(XmlCursor { place, around, word }) = place(text, at) else { return Vec::new() };
    let contents = |before: &str| {
        let contents = skills::elements_in(around.last().map(|tag| tag.name.as_str()));
        contents.into_iter().map(|name| Proposal::element(name, "SCXML", before, &word)).collect()
    };
    match place {
        XmlPlace::Element => contents(""),
        XmlPlace::Content => contents("<"),
        XmlPlace::Attribute(tag) => {
            let missing = skills::attributes_of(&tag.name).filter(|(name, _)| tag.get(name).is_none());
            let what = |is_required| if is_required { "required" } else { "" };
            missing.map(|(name, is_required)| Proposal::attribute(name, what(is_required), &word)).collect()
        }
        XmlPlace::Value(tag, attribute) => {
            Value { text, at, around: &around, tag: &tag, known, messages, word: &word }.proposals(&attribute)
        }
    }
}

/// What the element, the message or the process at a place of a machine is.
pub(crate) fn explanation(text: &str, at: usize, known: &Knowledge, messages: &Vocabulary) -> Option<Explanation> {
    let XmlCursor { place, word: range, .. } = place(text, at)?;
    let list = |names: Vec<String>| if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
    match place {
        XmlPlace::Element => {
            let word = text.get(range.clone()).filter(|word| !word.is_empty())?;
            let attributes = skills::attributes_of(word).map(|(name, is_required)| {
                if is_required { format!("`{name}` (required)") } else { format!("`{name}`") }
            });
            let contents = skills::elements_in(Some(word)).into_iter().map(|name| format!("`<{name}>`"));
            let (attributes, contents) = (list(attributes.collect()), list(contents.collect()));
            let text = format!("`<{word}>` of SCXML\n\nattributes: {attributes}\n\ncontains: {contents}");
            Some(Explanation { range, text })
        }
        XmlPlace::Value(tag, attribute) => {
            let range = word_in(text, &range, at, |c| !c.is_whitespace());
            let word = text.get(range.clone()).filter(|word| !word.is_empty())?;
            let text = match (tag.name.as_str(), attribute.as_str()) {
                ("transition", "event") => {
                    let meant = messages.received.iter().filter(|message| is_matched(word, &message.event));
                    let meant: Vec<String> = meant.map(|message| format!("- {}", received(message))).collect();
                    (!meant.is_empty()).then(|| format!("`{word}`\n\n{}", meant.join("\n")))?
                }
                ("send", "event") => {
                    let meant = sent(&tag, messages).find(|message| message.event == word)?;
                    format!("`{word}`: {}", describe(meant))
                }
                _ => format!("`{word}`: {}", known.processes().get(word)?),
            };
            Some(Explanation { range, text })
        }
        _ => None,
    }
}

/// The value of an attribute.
struct Value<'v> {
    text: &'v str,
    at: usize,
    around: &'v [Tag],
    tag: &'v Tag,
    known: &'v Knowledge,
    messages: &'v Vocabulary,
    word: &'v Range<usize>,
}

impl Value<'_> {
    fn proposals(&self, attribute: &str) -> Vec<Proposal> {
        let name = |name: &str, what: &str| Proposal::new(name, ProposalKind::Name, what, self.word);
        match (self.tag.name.as_str(), attribute) {
            ("send", "target") => {
                let peers = self.messages.sent.iter().filter_map(|message| message.peer.as_ref());
                let what = self.known.processes();
                let what = |peer| what.get(peer).map_or("a process", String::as_str);
                once(peers.map(|peer| name(peer, what(peer))))
            }
            ("send", "type") => vec![name(skills::CHANNEL_PROCESSOR, "to another process")],
            ("send", "event") => {
                let own = self.own_events().filter(|_| is_to_itself(self.tag));
                let to_others = sent(self.tag, self.messages).map(|message| name(&message.event, &describe(message)));
                once(to_others.chain(own.map(|event| name(&event, "an event of this machine"))))
            }
            ("assign", "location") => ids(self.text, &["data"]).iter().map(|id| name(id, "a datum")).collect(),
            ("raise", "event") => self.own_events().map(|event| name(&event, "an event of this machine")).collect(),
            ("transition", "event") => self.awaited(),
            ("param", "name") => {
                let send = self.around.iter().rev().find(|tag| tag.name == "send");
                let event = send.and_then(|send| send.get("event"));
                let meant = send.into_iter().flat_map(|send| sent(send, self.messages));
                let fields = meant.filter(|message| event == Some(&message.event)).flat_map(|message| &message.fields);
                once(fields.map(|(field, kind)| name(field, &kind.to_string())))
            }
            ("cancel", "sendid") => ids(self.text, &["send"]).iter().map(|id| name(id, "a delayed event")).collect(),
            ("transition", "target") | (_, "initial") => {
                let word = word_in(self.text, self.word, self.at, |c| !c.is_whitespace());
                let state = |id: &String| Proposal::new(id, ProposalKind::Name, "a state", &word);
                let states = match attribute {
                    "initial" => ids_of(inside(self.text, self.word.end), &STATES),
                    _ => ids(self.text, &STATES),
                };
                states.iter().map(state).collect()
            }
            (_, "cond" | "location") => self.in_expression(),
            (_, attribute) if attribute.ends_with("expr") => self.in_expression(),
            _ => Vec::new(),
        }
    }

    /// The events that this machine sends to itself.
    fn own_events(&self) -> impl Iterator<Item = String> {
        let own = elements(self.text).filter(|tag| tag.name == "raise" || tag.name == "send" && is_to_itself(tag));
        let events: BTreeSet<String> = own.filter_map(|tag| tag.get("event").map(str::to_owned)).collect();
        events.into_iter().filter(|event| !event.is_empty())
    }

    /// Events for which a transition may wait.
    fn awaited(&self) -> Vec<Proposal> {
        let word = word_in(self.text, self.word, self.at, |c| !c.is_whitespace());
        let name = |name: &str, what: &str| Proposal::new(name, ProposalKind::Name, what, &word);
        let messages = self.messages.received.iter().map(|message| name(&message.event, &received(message)));
        let own = self.own_events().map(|event| name(&event, "an event of this machine"));
        let errors = ["error.communication", "error.execution"].map(|error| name(error, "an error of this machine"));
        once(messages.chain(own).chain(errors))
    }

    /// Data and members of the event.
    fn in_expression(&self) -> Vec<Proposal> {
        let word = word_in(self.text, self.word, self.at, |c| c.is_alphanumeric() || c == '_');
        let name = |name: &str, what: &str| Proposal::new(name, ProposalKind::Name, what, &word);
        let before = &self.text[self.word.start..word.start];
        let event = self.around.iter().chain([self.tag]).rev().find(|tag| tag.name == "transition");
        let event = event.and_then(|tag| tag.get("event"));
        let is_meant = |message: &&MessageForm| {
            event.is_none_or(|event| event.split_whitespace().any(|word| is_matched(word, &message.event)))
        };
        let fields = || self.messages.received.iter().filter(is_meant).flat_map(|message| &message.fields);
        if before.ends_with("_event.data.") {
            return once(fields().map(|(field, kind)| name(field, &kind.to_string())));
        }
        if let Some(field) = compared(before, "_event.data") {
            return once(symbols(fields(), field).map(|symbol| name(symbol.name(), field)));
        }
        if before.ends_with("_event.") {
            return OF_EVENT.iter().map(|member| name(member, "")).collect();
        }
        let call = before.trim_end_matches([' ', '\'', '"']).strip_suffix('(').map(str::trim_end);
        if before.ends_with(['\'', '"']) && call.is_some_and(|call| call.ends_with("In")) {
            return ids(self.text, &STATES).iter().map(|id| name(id, "a state")).collect();
        }
        if before.ends_with('.') || is_in_text(before) {
            return Vec::new();
        }
        let data = ids(self.text, &["data"]);
        let data = data.iter().map(|id| name(id, "a datum"));
        data.chain([name("_event", "the event that is handled")]).collect()
    }
}

/// The messages that a `<send>` may be: those to its target, or to any process if that is computed.
fn sent<'v>(send: &Tag, messages: &'v Vocabulary) -> impl Iterator<Item = &'v MessageForm> + use<'v> {
    let (target, is_computed) = (send.get("target").map(str::to_owned), send.get("targetexpr").is_some());
    let is_published = send.get("type") == Some(skills::CHANNEL_PROCESSOR);
    messages.sent.iter().filter(move |message| match &target {
        Some(target) => message.peer.as_ref() == Some(target),
        None if is_computed => message.peer.is_some(),
        None => is_published && message.peer.is_none(),
    })
}

/// Whether a `<send>` is an event of the machine itself.
fn is_to_itself(send: &Tag) -> bool {
    ["target", "targetexpr", "type", "typeexpr"].iter().all(|key| send.get(key).is_none())
}

/// Whether a descriptor matches an event (SCXML 3.12.1).
fn is_matched(descriptor: &str, event: &str) -> bool {
    let prefix = descriptor.strip_suffix('*').unwrap_or(descriptor);
    let prefix = prefix.strip_suffix('.').unwrap_or(prefix);
    prefix.is_empty() || event.strip_prefix(prefix).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

fn received(message: &MessageForm) -> String {
    let of = message.peer.as_ref().map_or_else(String::new, |peer| format!(" of {peer}"));
    format!("{}{of}", describe(message))
}

fn describe(message: &MessageForm) -> String {
    let fields: Vec<String> = message.fields.iter().map(|(name, kind)| format!("{name}: {kind}")).collect();
    if fields.is_empty() { "a message".to_owned() } else { format!("a message with {}", fields.join(", ")) }
}

/// The ids of elements with these names.
fn ids(text: &str, names: &[&str]) -> BTreeSet<String> {
    ids_of(elements(text), names)
}

fn ids_of(elements: impl Iterator<Item = Tag>, names: &[&str]) -> BTreeSet<String> {
    let elements = elements.filter(|tag| names.contains(&tag.name.as_str()));
    elements.filter_map(|tag| tag.get("id").map(str::to_owned)).filter(|id| !id.is_empty()).collect()
}

/// Each name once.
fn once(proposals: impl Iterator<Item = Proposal>) -> Vec<Proposal> {
    let mut known = BTreeSet::new();
    proposals.filter(|proposal| known.insert(proposal.name.clone())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptors_match_whole_tokens() {
        let matched = |descriptor| ["a.b", "a.bc", "a"].map(|event| is_matched(descriptor, event));
        assert_eq!(matched("a.b"), [true, false, false]);
        assert_eq!(matched("a"), [true, true, true]);
        assert_eq!(matched("a.*"), [true, true, true]);
        assert_eq!(matched("*"), [true, true, true]);
    }
}
