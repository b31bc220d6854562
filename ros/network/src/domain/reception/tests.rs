//! What is returned of the messages that are received.

use proptest::prelude::*;

use super::discovery::{MOST_GONE, MOST_TOPICS};
use super::sequence_gaps::SETTLING_NS;
use super::*;
use crate::domain::exchange::{Sample, Writer, participant};
use crate::domain::nodes::encode_nodes;

const SECOND_NS: i64 = 1_000_000_000;

fn writer(id: u8, topic: &str, is_latched: bool) -> Writer {
    let (guid, kind) = ([id; 16], "std_msgs::msg::dds_::Bool_".to_owned());
    Writer { guid, topic: topic.to_owned(), kind, hash: None, is_reliable: true, is_latched, unfit: None }
}

fn sample(id: u8, topic: &str, number: i64, received_ns: i64) -> ListenerMessage {
    let (topic, sent_ns, body) = (topic.into(), Some(received_ns - 1000), number.to_le_bytes().to_vec());
    let (by_ns, stalled_ns) = (None, None);
    ListenerMessage::Sample(Sample { topic, writer: [id; 16], number, received_ns, sent_ns, by_ns, stalled_ns, body })
}

fn writers(writers: &[Writer], goodbyes: &[u8]) -> ListenerMessage {
    let goodbyes = goodbyes.iter().map(|id| [*id; 16]).collect();
    ListenerMessage::Discovered { offers: Offers { writers: writers.to_vec(), ..Offers::default() }, goodbyes }
}

/// What is returned in turn: the numbers of messages, and what is missing.
fn returned(reception: &mut Reception) -> Vec<String> {
    let (mut body, mut all) = (Vec::new(), Vec::new());
    while let Some(received) = reception.next(&mut body) {
        match received {
            Received::Message(_) => all.push(i64::from_le_bytes(body[..].try_into().expect("a number")).to_string()),
            Received::Resumed { .. } => all.push("+".to_owned()),
            Received::Late { since_ns, .. } => all.push(format!("late since {}", since_ns / 1_000_000)),
            Received::Lost { count, .. } => all.push(count.map_or("?".to_owned(), |count| format!("-{count}"))),
            _ => {}
        }
    }
    all
}

/// Watches `/a` and `/b`, with these writers, from the first second on.
fn watching(known: &[Writer]) -> Reception {
    let mut reception = Reception::new(Some(["/a", "/b"].map(str::to_owned).into()));
    reception.receive(writers(known, &[]));
    reception.begin();
    reception.receive(ListenerMessage::ClockAdvanced(SETTLING_NS));
    reception.receive(ListenerMessage::ClockAdvanced(SECOND_NS));
    assert!(returned(&mut reception).is_empty());
    reception
}

#[test]
fn messages_count_once_their_publishers_have_discovered_the_subscription() {
    let mut reception = Reception::new(Some(["/a", "/b"].map(str::to_owned).into()));
    reception.receive(writers(&[writer(1, "rt/a", false), writer(2, "rt/b", true)], &[]));
    reception.receive(sample(1, "rt/a", 6, 1));
    reception.begin();
    reception.receive(ListenerMessage::ClockAdvanced(2));
    reception.receive(sample(1, "rt/a", 7, 3));
    reception.receive(sample(2, "rt/b", 9, 3));
    assert!(returned(&mut reception).is_empty());
    reception.receive(ListenerMessage::ClockAdvanced(SECOND_NS));
    // The latched message is the first that counts.
    assert_eq!(returned(&mut reception), ["9"]);
    reception.receive(sample(1, "rt/a", 10, SECOND_NS + 1));
    assert_eq!(returned(&mut reception), ["-2", "10"]);
}

#[test]
fn all_messages_of_a_publisher_that_appears_later_count() {
    let mut reception = watching(&[]);
    reception.receive(writers(&[writer(1, "rt/a", false)], &[]));
    reception.receive(sample(1, "rt/a", 4, 2 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["?", "4"]);
    reception.receive(sample(1, "rt/a", 7, 2 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["-2", "7"]);
    reception.receive(ListenerMessage::ClockAdvanced(9 * SECOND_NS));
    assert!(
        reception.remarks.notes[0].starts_with("a participant without a node publishes on /a since 1.000 s"),
        "{:?}",
        reception.remarks.notes
    );
}

#[test]
fn participants_that_have_not_listed_their_nodes_are_counted() {
    let mut reception = Reception::new(None);
    let known = [writer(1, NODES, true), writer(2, NODES, true), writer(3, "rt/a", false)];
    reception.receive(writers(&known, &[]));
    assert_eq!(reception.discovery.robot.unnamed, 2);
    let ListenerMessage::Sample(sample) = sample(1, NODES, 1, 1) else { unreachable!() };
    let body = encode_nodes::<16>(&[1; 16], &[("/base", [vec![], vec![]])]);
    reception.receive(ListenerMessage::Sample(Sample { body, ..sample }));
    assert_eq!(
        (reception.discovery.robot.unnamed, &reception.discovery.robot.nodes),
        (1, &["/base".to_owned()].into())
    );
    reception.receive(writers(&known[..1], &[]));
    assert_eq!((reception.discovery.robot.unnamed, reception.discovery.robot.nodes.len()), (0, 1));
}

#[test]
fn the_first_message_with_best_effort_may_not_be_the_first() {
    let mut reception = watching(&[Writer { is_reliable: false, ..writer(1, "rt/a", false) }]);
    reception.receive(sample(1, "rt/a", 4, 2 * SECOND_NS));
    reception.receive(sample(1, "rt/a", 6, 2 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["?", "4", "-1", "6"]);
}

#[test]
fn a_publisher_that_is_given_up_may_go_on_publishing() {
    let mut reception = watching(&[writer(1, "rt/a", false), writer(2, "rt/b", false)]);
    reception.receive(sample(1, "rt/a", 1, 2 * SECOND_NS));
    reception.receive(writers(&[], &[2]));
    assert_eq!(returned(&mut reception), ["1", "?"]);
    assert!(
        reception.remarks.notes[0].contains("on /a, was given up")
            && reception.remarks.notes[1].contains("stopped publishing on /b")
    );
    // Its earlier messages still count, and its numbers show what is missing until it is back.
    reception.receive(sample(2, "rt/b", 1, 2 * SECOND_NS + 1));
    reception.receive(writers(&[writer(1, "rt/a", false)], &[]));
    reception.receive(sample(1, "rt/a", 4, 3 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["1", "-2", "4"]);
    assert!(reception.remarks.lost.is_empty());
    // With two publishers, the messages of one do not prove that the other is back.
    reception.receive(writers(&[writer(1, "rt/a", false), writer(3, "rt/a", false)], &[]));
    reception.receive(writers(&[writer(3, "rt/a", false)], &[]));
    reception.receive(sample(3, "rt/a", 1, 4 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["?", "1", "?"]);
    reception.receive(writers(&[writer(1, "rt/a", false), writer(3, "rt/a", false)], &[]));
    reception.receive(ListenerMessage::ClockAdvanced(5 * SECOND_NS));
    assert!(returned(&mut reception).is_empty());
    reception.receive(ListenerMessage::ClockAdvanced(6 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["+"]);
    assert!(reception.remarks.lost.is_empty(), "{:?}", reception.remarks.lost);
}

/// Lists these nodes of participants, each with its writer.
fn nodes(reception: &mut Reception, of: &[(u8, &str)]) {
    for (id, name) in of {
        let ListenerMessage::Sample(sample) = sample(*id, NODES, 1, 1) else { unreachable!() };
        let body = encode_nodes::<16>(&[*id; 16], &[(name, [vec![], vec![[*id; 16]]])]);
        reception.receive(ListenerMessage::Sample(Sample { body, ..sample }));
    }
}

#[test]
fn a_node_that_is_killed_is_replaced_by_the_next_of_its_name() {
    for (name, is_replaced) in [("/base", true), ("/other", false)] {
        let names = |id: u8| Writer {
            guid: [[id; 15].as_slice(), &[0]].concat().try_into().expect("16"),
            ..writer(id, NODES, true)
        };
        let old = [names(1), names(2), writer(1, "rt/a", false)];
        let mut reception = watching(&old[..1]);
        reception.receive(writers(&old, &[]));
        nodes(&mut reception, &[(1, "/base")]);
        reception.receive(sample(1, "rt/a", 1, 2 * SECOND_NS));
        reception.receive(ListenerMessage::ClockAdvanced(3 * SECOND_NS));
        // The new one is discovered before the old one is given up.
        reception.receive(writers(&[&old[..], &[writer(2, "rt/a", false)]].concat(), &[]));
        nodes(&mut reception, &[(2, name)]);
        reception.receive(sample(2, "rt/a", 1, 4 * SECOND_NS));
        reception.receive(ListenerMessage::ClockAdvanced(20 * SECOND_NS));
        assert_eq!(returned(&mut reception), ["1", "1"]);
        reception.receive(writers(&[names(2), writer(2, "rt/a", false)], &[]));
        reception.receive(sample(2, "rt/a", 2, 21 * SECOND_NS));
        let expected: &[&str] = if is_replaced { &["?", "+", "2"] } else { &["?", "2", "?"] };
        assert_eq!(
            (returned(&mut reception), reception.remarks.lost.len()),
            (expected.iter().map(|&of| of.to_owned()).collect(), 0)
        );
    }
}

#[test]
fn a_later_participant_without_nodes_replaces_one_that_was_given_up() {
    let mut reception = watching(&[writer(1, "rt/a", false)]);
    reception.receive(sample(1, "rt/a", 1, 2 * SECOND_NS));
    reception.receive(writers(&[], &[]));
    reception.receive(writers(&[writer(2, "rt/a", false)], &[]));
    reception.receive(sample(2, "rt/a", 1, 3 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["1", "?", "1", "?"]);
    // For a while, it may still list its nodes.
    reception.receive(ListenerMessage::ClockAdvanced(9 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["+"]);
}

#[test]
fn after_dds_fails_every_topic_has_a_gap_until_each_publisher_is_received_again() {
    let known = [writer(1, "rt/a", false), writer(2, "rt/b", false), writer(3, "rt/b", false)];
    let mut reception = watching(&known);
    reception.receive(sample(1, "rt/a", 1, 2 * SECOND_NS));
    reception.receive(sample(2, "rt/b", 1, 2 * SECOND_NS + 1));
    reception.receive(ListenerMessage::Alive(3 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["1", "1"]);
    reception.receive(ListenerMessage::Failed("why".to_owned()));
    // The gap begins at the time until which messages could be received.
    let since = |reception: &Reception| {
        let lost = reception.gaps.ready.iter().filter_map(|(received, _)| match received {
            Received::Lost { since_ns, .. } => Some(*since_ns),
            _ => None,
        });
        lost.collect::<Vec<_>>()
    };
    assert_eq!(since(&reception), [3 * SECOND_NS, 3 * SECOND_NS]);
    assert_eq!(returned(&mut reception), ["?", "?"]);
    // Publishers are found one by one, and the messages that they have published meanwhile are counted.
    reception.receive(writers(&[], &[]));
    reception.receive(writers(&known[..2], &[]));
    reception.receive(sample(1, "rt/a", 5, 60 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["-3", "5"]);
    // The next message of one publisher does not prove that the other is received again.
    reception.receive(sample(2, "rt/b", 4, 60 * SECOND_NS + 1));
    assert_eq!(returned(&mut reception), ["-2", "4", "?"]);
    reception.receive(ListenerMessage::ClockAdvanced(61 * SECOND_NS));
    reception.receive(writers(&known, &[]));
    reception.receive(ListenerMessage::ClockAdvanced(62 * SECOND_NS));
    assert!(returned(&mut reception).is_empty());
    reception.receive(ListenerMessage::ClockAdvanced(62 * SECOND_NS + SETTLING_NS));
    assert_eq!(returned(&mut reception), ["+"]);
    assert!(
        reception.remarks.lost.is_empty() && reception.remarks.notes[0].contains("DDS failed"),
        "{:?}",
        reception.remarks.notes
    );
    // A publisher that does not come back in time is given up.
    reception.receive(ListenerMessage::Failed("why".to_owned()));
    reception.receive(writers(&known[..2], &[]));
    [63, 64, 65, 66, 67].into_iter().for_each(|at| reception.receive(ListenerMessage::ClockAdvanced(at * SECOND_NS)));
    assert_eq!(returned(&mut reception), ["?", "?", "+", "?"]);
    assert!(
        reception.remarks.notes.last().is_some_and(|note| note.contains("/b, was given up")),
        "{:?}",
        reception.remarks.notes
    );
}

#[test]
fn a_topic_without_publishers_when_dds_failed_may_have_had_messages() {
    let mut reception = watching(&[writer(1, "rt/a", false)]);
    reception.receive(ListenerMessage::Failed("why".to_owned()));
    reception.receive(writers(&[writer(1, "rt/a", false)], &[]));
    reception.receive(ListenerMessage::ClockAdvanced(2 * SECOND_NS));
    reception.receive(ListenerMessage::ClockAdvanced(4 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["?", "+"]);
    reception.receive(writers(&[writer(1, "rt/a", false), writer(2, "rt/b", false)], &[]));
    reception.receive(sample(2, "rt/b", 1, 9 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["?", "1"]);
}

#[test]
fn a_writer_that_restarts_begins_with_new_numbers() {
    let again = |reception: &mut Reception| {
        reception.receive(sample(1, "rt/a", 1, 3 * SECOND_NS));
        reception.receive(sample(1, "rt/a", 3, 4 * SECOND_NS));
        returned(reception)
    };
    let watched = || {
        let mut reception = watching(&[writer(1, "rt/a", false)]);
        reception.receive(sample(1, "rt/a", 300, 2 * SECOND_NS));
        assert_eq!(returned(&mut reception), ["300"]);
        reception
    };
    // It has announced its departure.
    let mut reception = watched();
    reception.receive(writers(&[], &[1]));
    reception.receive(writers(&[writer(1, "rt/a", false)], &[]));
    assert_eq!(again(&mut reception), ["?", "1", "-1", "3"]);
    // Its participant, or the writer itself, is announced again.
    for guid in [participant(&[1; 16]), [1; 16]] {
        let mut reception = watched();
        reception.receive(ListenerMessage::WriterRestarted(guid));
        assert_eq!(again(&mut reception), ["?", "1", "-1", "3"]);
        assert!(reception.remarks.notes[0].contains("has begun anew"), "{:?}", reception.remarks.notes);
    }
    // Its numbers fall while its stamps increase; or, without stamps, they fall by much.
    let mut reception = watched();
    assert_eq!(again(&mut reception), ["?", "1", "-1", "3"]);
    let without_stamp = |number| {
        let ListenerMessage::Sample(sample) = sample(1, "rt/a", number, 3 * SECOND_NS) else { unreachable!() };
        ListenerMessage::Sample(Sample { sent_ns: None, ..sample })
    };
    let mut reception = watching(&[writer(1, "rt/a", false)]);
    [5000, 4990, 2].into_iter().for_each(|number| reception.receive(without_stamp(number)));
    assert_eq!(returned(&mut reception), ["5000", "?", "2"]);
}

#[test]
fn messages_that_cannot_be_read_are_missing() {
    let other = Writer { kind: "std_msgs::msg::dds_::Int32_".to_owned(), ..writer(2, "rt/a", false) };
    let unfit = Writer { unfit: Some("Ownership".to_owned()), ..writer(3, "rt/b", false) };
    let known = [writer(1, "rt/a", false), other, unfit];
    // They are there from the beginning, or appear later.
    for begun in [0, 3] {
        let mut reception = watching(&known[..begun]);
        reception.receive(writers(&known, &[]));
        reception.receive(sample(2, "rt/a", 1, 2 * SECOND_NS));
        assert!(returned(&mut reception).is_empty());
        let lost = reception.remarks.lost.join("\n");
        assert!(
            lost.contains("of another type on /a, std_msgs/msg/Int32") && lost.contains("on /b with a Ownership"),
            "{lost}"
        );
    }
    let mut reception = watching(&[writer(2, "rt/a", false)]);
    reception.receive(writers(&[writer(1, "rt/a", true), writer(2, "rt/a", false)], &[]));
    reception.receive(sample(2, "rt/a", 1, 2 * SECOND_NS));
    reception.receive(ListenerMessage::Unreadable("rt/a".into(), "an encoding".to_owned()));
    assert_eq!(returned(&mut reception), ["?", "1", "?"]);
    assert!(reception.remarks.notes[0].contains("what was latched is not received"), "{:?}", reception.remarks.notes);
}

#[test]
fn a_message_that_arrives_after_the_clock_has_passed_it_is_late() {
    let mut reception = watching(&[writer(1, "rt/a", false)]);
    reception.receive(sample(1, "rt/a", 1, 2 * SECOND_NS));
    reception.receive(ListenerMessage::ClockAdvanced(4 * SECOND_NS));
    // It was held back.
    reception.receive(sample(1, "rt/a", 2, 3 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["1", "2", "late since 3000"]);
    // It had to be sent again. It is returned before the next one, which was received earlier.
    let ListenerMessage::Sample(again) = sample(1, "rt/a", 3, 4 * SECOND_NS + 500_000_000) else { unreachable!() };
    reception.receive(ListenerMessage::Sample(Sample {
        sent_ns: None,
        by_ns: Some(4 * SECOND_NS + 100_000_000),
        ..again
    }));
    reception.receive(sample(1, "rt/a", 4, 4 * SECOND_NS + 100_000_000));
    assert_eq!(returned(&mut reception), ["3", "late since 3000", "4", "late since 4100"]);
    let no_room = sample(1, "rt/a", 5, 5 * SECOND_NS);
    let ListenerMessage::Sample(no_room) = no_room else { unreachable!() };
    reception.receive(ListenerMessage::Dropped(no_room));
    reception.receive(sample(1, "rt/a", 6, 5 * SECOND_NS));
    reception.receive(sample(9, "rt/a", 1, 5 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["-1", "6", "?"]);
}

#[test]
fn a_message_that_took_longer_than_others_was_due_earlier() {
    let mut reception = watching(&[writer(1, "rt/a", false)]);
    reception.receive(sample(1, "rt/a", 1, 2 * SECOND_NS));
    reception.receive(sample(1, "rt/a", 2, 3 * SECOND_NS));
    let ListenerMessage::Sample(again) = sample(1, "rt/a", 3, 4 * SECOND_NS) else { unreachable!() };
    reception.receive(ListenerMessage::Sample(Sample { sent_ns: Some(4 * SECOND_NS - 300_000_000), ..again }));
    assert_eq!(returned(&mut reception), ["1", "2", "3", "late since 3650"]);
    reception.receive(sample(1, "rt/a", 5, 5 * SECOND_NS));
    assert!(
        matches!(reception.gaps.ready[0].0, Received::Lost { since_ns, .. } if since_ns / 1_000_000 == 3650),
        "{:?}",
        reception.gaps.ready
    );
}

#[test]
fn a_message_that_was_held_back_for_a_moment_may_have_preceded_others() {
    let mut reception = watching(&[writer(1, "rt/a", false), writer(2, "rt/b", false)]);
    reception.receive(sample(1, "rt/a", 1, 2 * SECOND_NS));
    reception.receive(sample(2, "rt/b", 1, 2 * SECOND_NS + 2_000_000));
    // It was sent again within 5 ms, and the next one had to wait for it.
    let ListenerMessage::Sample(again) = sample(1, "rt/a", 2, 2 * SECOND_NS + 7_000_000) else { unreachable!() };
    reception.receive(ListenerMessage::Sample(Sample { by_ns: Some(2 * SECOND_NS + 4_000_000), ..again }));
    reception.receive(sample(1, "rt/a", 3, 2 * SECOND_NS + 4_000_000));
    assert_eq!(returned(&mut reception), ["1", "1", "2", "late since 2000", "3", "late since 2004"]);
    // These came in one datagram.
    reception.receive(sample(1, "rt/a", 4, 2 * SECOND_NS + 9_000_000));
    reception.receive(sample(2, "rt/b", 2, 2 * SECOND_NS + 9_000_000));
    assert_eq!(returned(&mut reception), ["4", "2", "late since 2008"]);
}

#[test]
fn a_new_participant_finds_the_publishers_again() {
    let mut reception = watching(&[writer(1, "rt/a", false)]);
    reception.receive(sample(1, "rt/a", 1, 2 * SECOND_NS));
    reception.receive(ListenerMessage::Failed("a defect".to_owned()));
    reception.receive(writers(&[], &[]));
    reception.receive(writers(&[writer(1, "rt/a", false)], &[]));
    reception.receive(sample(1, "rt/a", 3, 3 * SECOND_NS));
    assert_eq!(returned(&mut reception), ["1", "?", "-1", "3"]);
    assert!(
        reception.remarks.lost.is_empty() && reception.remarks.notes[0].contains("a defect"),
        "{:?}",
        reception.remarks.notes
    );
}

/// A hostile participant may send messages with any numbers in the name of another.
#[test]
fn every_gap_between_two_numbers_is_counted_however_large() {
    for number in [2, 3, 1 << 32, 1 << 61, i64::MAX - 1] {
        let mut reception = watching(&[writer(1, "rt/a", false)]);
        reception.receive(sample(1, "rt/a", 1, 2 * SECOND_NS));
        reception.receive(sample(1, "rt/a", number, 3 * SECOND_NS));
        let gap = (number > 2).then(|| format!("-{}", number - 2));
        let expected: Vec<String> = ["1".to_owned()].into_iter().chain(gap).chain([number.to_string()]).collect();
        assert_eq!(returned(&mut reception), expected);
        // With its next message, the publisher seems to have restarted.
        reception.receive(sample(1, "rt/a", 2, 4 * SECOND_NS));
        assert_eq!(returned(&mut reception), ["?", "2"], "after {number}");
    }
}

#[test]
fn a_message_without_a_valid_number_is_missing() {
    for number in [0, -1, -(1 << 32), -(1 << 61), i64::MIN, i64::MAX] {
        let mut reception = watching(&[writer(1, "rt/a", false)]);
        reception.receive(writers(&[writer(1, "rt/a", false), writer(2, "rt/b", false)], &[]));
        for topic in ["rt/a", "rt/b"] {
            let (id, start_ns) = if topic == "rt/a" { (1, 0) } else { (2, 10 * SECOND_NS) };
            // It is the first of a publisher, or follows others.
            reception.receive(sample(id, topic, number, start_ns + 2 * SECOND_NS));
            assert_eq!(returned(&mut reception), ["?"], "{number}");
            reception.receive(sample(id, topic, 1, start_ns + 3 * SECOND_NS));
            returned(&mut reception);
            reception.receive(sample(id, topic, number, start_ns + 4 * SECOND_NS));
            reception.receive(sample(id, topic, number, start_ns + 5 * SECOND_NS));
            reception.receive(sample(id, topic, 2, start_ns + 6 * SECOND_NS));
            assert_eq!(returned(&mut reception), ["?", "?", "2"], "{number}");
        }
    }
}

#[test]
fn memory_is_bounded() {
    let mut reception = Reception::new(None);
    let many = |from: u32| -> Vec<Writer> {
        let writer = |number: u32| {
            let mut guid = [0; 16];
            guid[..4].copy_from_slice(&number.to_le_bytes());
            Writer { guid, ..writer(0, &format!("rt/t{number}"), false) }
        };
        (from..from + 20_000).map(writer).collect()
    };
    for from in [0, 20_000, 40_000] {
        reception.receive(writers(&many(from), &[]));
    }
    assert_eq!((reception.discovery.survey.topics.len(), reception.discovery.writers.len()), (MOST_TOPICS, 20_000));
    assert!(reception.discovery.gone.len() <= MOST_GONE && reception.discovery.robot.publishers.len() <= MOST_TOPICS);
}

proptest! {
    #[test]
    fn exactly_the_messages_between_two_numbers_are_missing(
        arriving in prop::collection::vec((1..3_u8, 1..40_i64, prop::bool::weighted(0.1)), 0..80),
    ) {
        let mut reception = watching(&[writer(1, "rt/a", false), writer(2, "rt/a", false)]);
        let (mut last, mut lives, mut expected) = ([0; 3], [0_i64; 3], Vec::new());
        for (place, (id, number, restarts)) in (0_i64..).zip(arriving) {
            let of = usize::from(id);
            // Some publishers restart: their stamps increase all the same.
            lives[of] += i64::from(restarts);
            let ListenerMessage::Sample(sample) = sample(id, "rt/a", number, SECOND_NS + place) else { unreachable!() };
            reception.receive(ListenerMessage::Sample(Sample { sent_ns: Some(1000 * lives[of] + number), ..sample }));
            let last = &mut last[of];
            if restarts && number <= *last {
                expected.push("?".to_owned());
                expected.push(number.to_string());
                *last = number;
            }
            // Repeated and late messages do not count.
            if number > *last {
                if *last > 0 && number > *last + 1 {
                    expected.push(format!("-{}", number - *last - 1));
                }
                expected.push(number.to_string());
                *last = number;
            }
        }
        prop_assert_eq!(returned(&mut reception), expected);
    }
}
