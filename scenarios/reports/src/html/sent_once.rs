//! Messages that occurred only once in a part of a run: if all others repeat at every tick, these made the difference.

use std::time::Duration;

use channels::{Event, EventKind, Message, Topology, Value};
use diagnostics::counted;

use super::evidence::Seen;

/// More messages than this are only counted.
const MOST: usize = 6;

/// A sentence about the messages between skills and components that were received only once between two moments,
/// ignoring numbers; none if there are no such messages.
pub(super) fn sentence(events: &[Event], (from, to): (Duration, Duration), topology: &Topology) -> Option<String> {
    let inside: Vec<&Event> = events.iter().filter(|event| (from..=to).contains(&event.time)).collect();
    let is_new = |event: &&&Event| inside.iter().filter(|other| is_alike(event, other)).count() == 1;
    let once = inside.iter().filter(is_new).filter_map(|event| Seen::of(event, topology));
    let once: Vec<Seen> = once.filter(|seen| ![&seen.from, &seen.to].contains(&&recording::TREE.to_owned())).collect();
    let sent = |seen: &Seen| format!("{} told {} `{}` at tick {}", seen.from, seen.to, seen.message, seen.at.tick);
    let mut all: Vec<String> = once.iter().take(MOST).map(sent).collect();
    if once.len() > MOST {
        all.push(counted(once.len() - MOST, "more message"));
    }
    (!all.is_empty())
        .then(|| format!("These messages were sent only once in that time, in this order: {}.", all.join("; ")))
}

fn is_alike(a: &Event, b: &Event) -> bool {
    match (&a.kind, &b.kind) {
        (EventKind::Received { channel: a, message: this }, EventKind::Received { channel: b, message: that }) => {
            a == b && symbols(this).eq(symbols(that))
        }
        _ => false,
    }
}

fn symbols(message: &Message) -> impl Iterator<Item = &Value> {
    message.fields().iter().filter(|value| matches!(value, Value::Symbol(_)))
}

#[cfg(test)]
mod tests {
    use channels::{Capacity, Domain, FieldKind, Shape};

    use super::*;

    #[test]
    fn a_message_repeated_with_another_number_does_not_count_as_unique() {
        let mut topology = Topology::default();
        let ids = ["Reader", "Skill", "BT"].map(|name| topology.process(name).unwrap());
        let domain = || Domain::new([Shape::new([("what", FieldKind::Symbol(Vec::new()))])]);
        let levels = topology.channel(ids[0], ids[1], Capacity::One, domain()).unwrap();
        let answers = topology.channel(ids[1], ids[2], Capacity::One, domain()).unwrap();
        let event = |second, channel, message| Event {
            step: second,
            tick: second,
            time: Duration::from_secs(second),
            kind: EventKind::Received { channel, message },
        };
        let level = |level: f64| Message::new([Value::symbol("ok"), level.into()]);
        let events = [
            event(1, levels, level(31.0)),
            event(2, levels, Message::symbols(["error"])),
            event(3, levels, level(30.0)),
            event(4, answers, Message::symbols(["success"])),
        ];
        let sent = |to| sentence(&events, (Duration::ZERO, Duration::from_secs(to)), &topology);
        assert_eq!(
            sent(4).unwrap(),
            "These messages were sent only once in that time, in this order: Reader told Skill `[<error>]` at tick 2."
        );
        assert!(sent(1).unwrap().contains("[<ok>, 31]"), "{:?}", sent(1));
        assert_eq!(sent(0), None);
    }
}
