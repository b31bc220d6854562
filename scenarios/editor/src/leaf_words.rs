//! Names in the table of a leaf or a component: of its machine's data, of its ports, and of the fields of its requests.

use std::collections::BTreeMap;

use bt::Direction;
use channels::FieldKind;
use diagnostics::document::Own;
use scenarios::scenario::{Offer, OfferMessage};

use crate::expressions::{compared, is_in_text, symbols, word_in};
use crate::knowledge::Knowledge;
use crate::proposal::{Proposal, ProposalKind};
use crate::toml_keys::Blank;
use crate::toml_place::contents;

/// What may be written in a blank of the table of a leaf or a component.
pub(crate) fn proposals(own: Own, blank: Blank<'_>, text: &str, known: &Knowledge) -> Vec<Proposal> {
    let [table, name, ..] = blank.path else { return Vec::new() };
    let offers = || asked([table, name], text, known);
    let fields = |of| listed(offers().iter().flat_map(|offer| offer.fields(of)));
    let names = match own {
        Own::Datum => {
            let scenarios = known.scenarios.iter();
            let machines = scenarios.flat_map(|scenario| scenario.machine_processes());
            let machines = machines.filter(|(process, _)| process == name);
            machines
                .flat_map(|(_, skill)| skill.machine.parameters())
                .map(|id| (id.to_owned(), "a datum".to_owned()))
                .collect()
        }
        Own::InputPort => {
            let ports = ports(name, Direction::Output, known).into_iter();
            ports.map(|(port, what)| (format!("{{{port}}}"), what)).collect()
        }
        Own::OutputPort => ports(name, Direction::Input, known),
        Own::Argument => fields(OfferMessage::Request),
        Own::AnswerField => fields(OfferMessage::Answer),
        Own::FeedbackField => fields(OfferMessage::Feedback),
        Own::AnswerCondition => return condition(blank, name, &offers(), known),
    };
    let whole = 0..blank.written.len();
    names.into_iter().map(|(name, what)| Proposal::new(name, ProposalKind::Name, what, &whole)).collect()
}

/// The services, actions and topics that a leaf uses.
fn asked([table, leaf]: [&String; 2], text: &str, known: &Knowledge) -> Vec<Offer> {
    let texts = contents(text).1;
    let offers = known.scenarios.iter().flat_map(|scenario| scenario.offers());
    let is_asked = |(name, offer): &(String, Offer)| {
        let key = [table.as_str(), leaf, offer.key()];
        texts.iter().any(|text| text.value == *name && text.key == key)
    };
    offers.filter(is_asked).map(|(_, offer)| offer).collect()
}

/// The ports of the leaves with this name or ID, except those of a direction.
fn ports(leaf: &str, unfit: Direction, known: &Knowledge) -> BTreeMap<String, String> {
    let of_tree = |tree: &bt::Tree| {
        let leaves = tree.leaves().filter(|node| node.process() == leaf || node.type_id() == leaf);
        let ports = leaves.flat_map(|leaf| tree.ports(leaf.id())).filter(|port| port.direction != unfit);
        ports.map(|port| (port.name.to_owned(), port.direction.element().to_owned())).collect::<Vec<_>>()
    };
    known.trees().flat_map(of_tree).collect()
}

fn listed<'f>(fields: impl Iterator<Item = &'f (String, FieldKind)>) -> BTreeMap<String, String> {
    fields.map(|(name, kind)| (name.clone(), kind.to_string())).collect()
}

/// What may be written in a condition on an answer.
fn condition(blank: Blank<'_>, leaf: &str, offers: &[Offer], known: &Knowledge) -> Vec<Proposal> {
    let Blank { written, at, .. } = blank;
    let word = word_in(written, &(0..written.len()), at, |c| c.is_alphanumeric() || c == '_');
    let before = &written[..word.start];
    let fields = || offers.iter().flat_map(|offer| offer.fields(OfferMessage::Answer));
    let answers = || offers.iter().map(Offer::answer);
    let names = match answers().find_map(|answer| compared(before, answer)) {
        Some(field) => symbols(fields(), field).map(|symbol| (symbol.name().to_owned(), field.to_owned())).collect(),
        None if is_in_text(before) => BTreeMap::new(),
        None if before.ends_with('{') => ports(leaf, Direction::Output, known),
        None if answers().any(|answer| before.strip_suffix('.').is_some_and(|before| before.ends_with(answer))) => {
            listed(fields())
        }
        None if before.ends_with('.') => BTreeMap::new(),
        None => answers().map(|answer| (answer.to_owned(), "the answer".to_owned())).collect(),
    };
    names.into_iter().map(|(name, what)| Proposal::new(name, ProposalKind::Name, what, &word)).collect()
}
