//! What is told of what is heard.

use proptest::prelude::*;

use super::*;
use crate::domain::heard;

const SECOND_NS: i64 = 1_000_000_000;

fn writer(id: u8, topic: &str, is_latched: bool) -> Writer {
    let (guid, kind) = ([id; 16], "std_msgs::msg::dds_::Bool_".to_owned());
    Writer { guid, topic: topic.to_owned(), kind, hash: None, is_reliable: true, is_latched, unfit: None }
}

fn sample(id: u8, topic: &str, number: i64, received_ns: i64) -> Heard {
    let (topic, sent_ns, body) = (topic.into(), Some(received_ns - 1000), number.to_le_bytes().to_vec());
    let (by_ns, stalled_ns) = (None, None);
    Heard::Sample(Sample { topic, writer: [id; 16], number, received_ns, sent_ns, by_ns, stalled_ns, body })
}

fn writers(writers: &[Writer], goodbyes: &[u8]) -> Heard {
    let goodbyes = goodbyes.iter().map(|id| [*id; 16]).collect();
    Heard::Others { offers: Offers { writers: writers.to_vec(), ..Offers::default() }, goodbyes }
}

/// What is told in turn: numbers of messages, and what is missing.
fn told(hearing: &mut Hearing) -> Vec<String> {
    let (mut body, mut told) = (Vec::new(), Vec::new());
    while let Some(received) = hearing.next(&mut body) {
        match received {
            Received::Message(_) => told.push(i64::from_le_bytes(body[..].try_into().expect("a number")).to_string()),
            Received::Resumed { .. } => told.push("+".to_owned()),
            Received::Late { since_ns, .. } => told.push(format!("late since {}", since_ns / 1_000_000)),
            Received::Lost { count, .. } => told.push(count.map_or("?".to_owned(), |count| format!("-{count}"))),
            _ => {}
        }
    }
    told
}

/// Watches `/a` and `/b`, with these writers, from the first second on.
fn watching(known: &[Writer]) -> Hearing {
    let mut hearing = Hearing::new(Some(["/a", "/b"].map(str::to_owned).into()));
    hearing.hear(writers(known, &[]));
    hearing.begin();
    hearing.hear(Heard::Quiet(SETTLING_NS));
    hearing.hear(Heard::Quiet(SECOND_NS));
    assert!(told(&mut hearing).is_empty());
    hearing
}

#[test]
fn messages_count_once_their_publishers_know_of_the_subscription() {
    let mut hearing = Hearing::new(Some(["/a", "/b"].map(str::to_owned).into()));
    hearing.hear(writers(&[writer(1, "rt/a", false), writer(2, "rt/b", true)], &[]));
    hearing.hear(sample(1, "rt/a", 6, 1));
    hearing.begin();
    hearing.hear(Heard::Quiet(2));
    hearing.hear(sample(1, "rt/a", 7, 3));
    hearing.hear(sample(2, "rt/b", 9, 3));
    assert!(told(&mut hearing).is_empty());
    hearing.hear(Heard::Quiet(SECOND_NS));
    // What is latched was not said before.
    assert_eq!(told(&mut hearing), ["9"]);
    hearing.hear(sample(1, "rt/a", 10, SECOND_NS + 1));
    assert_eq!(told(&mut hearing), ["-2", "10"]);
}

#[test]
fn a_publisher_that_comes_later_has_said_all_that_it_has_numbered() {
    let mut hearing = watching(&[]);
    hearing.hear(writers(&[writer(1, "rt/a", false)], &[]));
    hearing.hear(sample(1, "rt/a", 4, 2 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["?", "4"]);
    hearing.hear(sample(1, "rt/a", 7, 2 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["-2", "7"]);
    hearing.hear(Heard::Quiet(9 * SECOND_NS));
    assert!(
        hearing.notes[0].starts_with("a participant without a node publishes on /a since 1.000 s"),
        "{:?}",
        hearing.notes
    );
}

#[test]
fn a_participant_that_has_not_said_which_nodes_it_has_is_counted() {
    let mut hearing = Hearing::new(None);
    let known = [writer(1, NODES, true), writer(2, NODES, true), writer(3, "rt/a", false)];
    hearing.hear(writers(&known, &[]));
    assert_eq!(hearing.robot.unnamed, 2);
    let Heard::Sample(said) = sample(1, NODES, 1, 1) else { unreachable!() };
    let body = heard::introduction::<16>(&[1; 16], &[("/base", [vec![], vec![]])]);
    hearing.hear(Heard::Sample(Sample { body, ..said }));
    assert_eq!((hearing.robot.unnamed, &hearing.robot.nodes), (1, &["/base".to_owned()].into()));
    hearing.hear(writers(&known[..1], &[]));
    assert_eq!((hearing.robot.unnamed, hearing.robot.nodes.len()), (0, 1));
}

#[test]
fn the_first_message_with_best_effort_may_not_be_the_first() {
    let mut hearing = watching(&[Writer { is_reliable: false, ..writer(1, "rt/a", false) }]);
    hearing.hear(sample(1, "rt/a", 4, 2 * SECOND_NS));
    hearing.hear(sample(1, "rt/a", 6, 2 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["?", "4", "-1", "6"]);
}

#[test]
fn a_publisher_that_is_given_up_may_have_gone_on() {
    let mut hearing = watching(&[writer(1, "rt/a", false), writer(2, "rt/b", false)]);
    hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
    hearing.hear(writers(&[], &[2]));
    assert_eq!(told(&mut hearing), ["1", "?"]);
    assert!(hearing.notes[0].contains("on /a, was given up") && hearing.notes[1].contains("stopped publishing on /b"));
    // What it had said is heard, and its numbers tell what it says until it is back.
    hearing.hear(sample(2, "rt/b", 1, 2 * SECOND_NS + 1));
    hearing.hear(writers(&[writer(1, "rt/a", false)], &[]));
    hearing.hear(sample(1, "rt/a", 4, 3 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["1", "-2", "4"]);
    assert!(hearing.lost.is_empty());
    // Beside another publisher, its messages do not tell that the one is back.
    hearing.hear(writers(&[writer(1, "rt/a", false), writer(3, "rt/a", false)], &[]));
    hearing.hear(writers(&[writer(3, "rt/a", false)], &[]));
    hearing.hear(sample(3, "rt/a", 1, 4 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["?", "1", "?"]);
    hearing.hear(writers(&[writer(1, "rt/a", false), writer(3, "rt/a", false)], &[]));
    hearing.hear(Heard::Quiet(5 * SECOND_NS));
    assert!(told(&mut hearing).is_empty());
    hearing.hear(Heard::Quiet(6 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["+"]);
    assert!(hearing.lost.is_empty(), "{:?}", hearing.lost);
}

/// That participants have these nodes, each with its writer.
fn nodes(hearing: &mut Hearing, of: &[(u8, &str)]) {
    for (id, name) in of {
        let Heard::Sample(said) = sample(*id, NODES, 1, 1) else { unreachable!() };
        let body = heard::introduction::<16>(&[*id; 16], &[(name, [vec![], vec![[*id; 16]]])]);
        hearing.hear(Heard::Sample(Sample { body, ..said }));
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
        let mut hearing = watching(&old[..1]);
        hearing.hear(writers(&old, &[]));
        nodes(&mut hearing, &[(1, "/base")]);
        hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
        hearing.hear(Heard::Quiet(3 * SECOND_NS));
        // The next is there before the one is given up.
        hearing.hear(writers(&[&old[..], &[writer(2, "rt/a", false)]].concat(), &[]));
        nodes(&mut hearing, &[(2, name)]);
        hearing.hear(sample(2, "rt/a", 1, 4 * SECOND_NS));
        hearing.hear(Heard::Quiet(20 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["1", "1"]);
        hearing.hear(writers(&[names(2), writer(2, "rt/a", false)], &[]));
        hearing.hear(sample(2, "rt/a", 2, 21 * SECOND_NS));
        let expected: &[&str] = if is_replaced { &["?", "+", "2"] } else { &["?", "2", "?"] };
        assert_eq!((told(&mut hearing), hearing.lost.len()), (expected.iter().map(|&of| of.to_owned()).collect(), 0));
    }
}

#[test]
fn a_later_participant_without_nodes_takes_the_place_of_one_that_was_given_up() {
    let mut hearing = watching(&[writer(1, "rt/a", false)]);
    hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
    hearing.hear(writers(&[], &[]));
    hearing.hear(writers(&[writer(2, "rt/a", false)], &[]));
    hearing.hear(sample(2, "rt/a", 1, 3 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["1", "?", "1", "?"]);
    // It may still say which nodes it has.
    hearing.hear(Heard::Quiet(9 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["+"]);
}

#[test]
fn when_dds_fails_every_topic_has_a_gap_until_each_publisher_is_heard_again() {
    let known = [writer(1, "rt/a", false), writer(2, "rt/b", false), writer(3, "rt/b", false)];
    let mut hearing = watching(&known);
    hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
    hearing.hear(sample(2, "rt/b", 1, 2 * SECOND_NS + 1));
    hearing.hear(Heard::Alive(3 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["1", "1"]);
    hearing.hear(Heard::Died("why".to_owned()));
    // It begins when it was last known that messages could be received.
    let since = |hearing: &Hearing| {
        let lost = hearing.ready.iter().filter_map(|(received, _)| match received {
            Received::Lost { since_ns, .. } => Some(*since_ns),
            _ => None,
        });
        lost.collect::<Vec<_>>()
    };
    assert_eq!(since(&hearing), [3 * SECOND_NS, 3 * SECOND_NS]);
    assert_eq!(told(&mut hearing), ["?", "?"]);
    // Publishers are found one by one, and what they have said meanwhile is counted.
    hearing.hear(writers(&[], &[]));
    hearing.hear(writers(&known[..2], &[]));
    hearing.hear(sample(1, "rt/a", 5, 60 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["-3", "5"]);
    // The next message of one does not tell that all are heard again.
    hearing.hear(sample(2, "rt/b", 4, 60 * SECOND_NS + 1));
    assert_eq!(told(&mut hearing), ["-2", "4", "?"]);
    hearing.hear(Heard::Quiet(61 * SECOND_NS));
    hearing.hear(writers(&known, &[]));
    hearing.hear(Heard::Quiet(62 * SECOND_NS));
    assert!(told(&mut hearing).is_empty());
    hearing.hear(Heard::Quiet(62 * SECOND_NS + SETTLING_NS));
    assert_eq!(told(&mut hearing), ["+"]);
    assert!(hearing.lost.is_empty() && hearing.notes[0].contains("DDS failed"), "{:?}", hearing.notes);
    // A publisher that does not come back in time is given up.
    hearing.hear(Heard::Died("why".to_owned()));
    hearing.hear(writers(&known[..2], &[]));
    [63, 64, 65, 66, 67].into_iter().for_each(|at| hearing.hear(Heard::Quiet(at * SECOND_NS)));
    assert_eq!(told(&mut hearing), ["?", "?", "+", "?"]);
    assert!(hearing.notes.last().is_some_and(|note| note.contains("/b, was given up")), "{:?}", hearing.notes);
}

#[test]
fn a_topic_without_publishers_when_dds_failed_may_have_had_messages() {
    let mut hearing = watching(&[writer(1, "rt/a", false)]);
    hearing.hear(Heard::Died("why".to_owned()));
    hearing.hear(writers(&[writer(1, "rt/a", false)], &[]));
    hearing.hear(Heard::Quiet(2 * SECOND_NS));
    hearing.hear(Heard::Quiet(4 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["?", "+"]);
    hearing.hear(writers(&[writer(1, "rt/a", false), writer(2, "rt/b", false)], &[]));
    hearing.hear(sample(2, "rt/b", 1, 9 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["?", "1"]);
}

#[test]
fn a_writer_that_begins_anew_has_numbers_of_its_own() {
    let again = |hearing: &mut Hearing| {
        hearing.hear(sample(1, "rt/a", 1, 3 * SECOND_NS));
        hearing.hear(sample(1, "rt/a", 3, 4 * SECOND_NS));
        told(hearing)
    };
    let watched = || {
        let mut hearing = watching(&[writer(1, "rt/a", false)]);
        hearing.hear(sample(1, "rt/a", 300, 2 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["300"]);
        hearing
    };
    // After a goodbye.
    let mut hearing = watched();
    hearing.hear(writers(&[], &[1]));
    hearing.hear(writers(&[writer(1, "rt/a", false)], &[]));
    assert_eq!(again(&mut hearing), ["?", "1", "-1", "3"]);
    // As its participant, or it, is announced anew.
    for guid in [participant(&[1; 16]), [1; 16]] {
        let mut hearing = watched();
        hearing.hear(Heard::Anew(guid));
        assert_eq!(again(&mut hearing), ["?", "1", "-1", "3"]);
        assert!(hearing.notes[0].contains("has begun anew"), "{:?}", hearing.notes);
    }
    // As its stamps go on where its numbers fall, or as they fall far, and it has no clock.
    let mut hearing = watched();
    assert_eq!(again(&mut hearing), ["?", "1", "-1", "3"]);
    let without_stamp = |number| {
        let Heard::Sample(said) = sample(1, "rt/a", number, 3 * SECOND_NS) else { unreachable!() };
        Heard::Sample(Sample { sent_ns: None, ..said })
    };
    let mut hearing = watching(&[writer(1, "rt/a", false)]);
    [5000, 4990, 2].into_iter().for_each(|number| hearing.hear(without_stamp(number)));
    assert_eq!(told(&mut hearing), ["5000", "?", "2"]);
}

#[test]
fn what_cannot_be_read_is_missing() {
    let other = Writer { kind: "std_msgs::msg::dds_::Int32_".to_owned(), ..writer(2, "rt/a", false) };
    let unfit = Writer { unfit: Some("Ownership".to_owned()), ..writer(3, "rt/b", false) };
    let known = [writer(1, "rt/a", false), other, unfit];
    // Whether it was there from the beginning or not.
    for begun in [0, 3] {
        let mut hearing = watching(&known[..begun]);
        hearing.hear(writers(&known, &[]));
        hearing.hear(sample(2, "rt/a", 1, 2 * SECOND_NS));
        assert!(told(&mut hearing).is_empty());
        let lost = hearing.lost.join("\n");
        assert!(
            lost.contains("of another type on /a, std_msgs/msg/Int32") && lost.contains("on /b with a Ownership"),
            "{lost}"
        );
    }
    let mut hearing = watching(&[writer(2, "rt/a", false)]);
    hearing.hear(writers(&[writer(1, "rt/a", true), writer(2, "rt/a", false)], &[]));
    hearing.hear(sample(2, "rt/a", 1, 2 * SECOND_NS));
    hearing.hear(Heard::Unreadable("rt/a".into(), "an encoding".to_owned()));
    assert_eq!(told(&mut hearing), ["?", "1", "?"]);
    assert!(hearing.notes[0].contains("what was latched is not heard"), "{:?}", hearing.notes);
}

#[test]
fn time_that_passed_without_a_message_passed_without_it() {
    let mut hearing = watching(&[writer(1, "rt/a", false)]);
    hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
    hearing.hear(Heard::Quiet(4 * SECOND_NS));
    // It was held back until another had come.
    hearing.hear(sample(1, "rt/a", 2, 3 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["1", "2", "late since 3000"]);
    // One that had to be sent again, at any time after the one before it, comes before the next, which had been there.
    let Heard::Sample(again) = sample(1, "rt/a", 3, 4 * SECOND_NS + 500_000_000) else { unreachable!() };
    hearing.hear(Heard::Sample(Sample { sent_ns: None, by_ns: Some(4 * SECOND_NS + 100_000_000), ..again }));
    hearing.hear(sample(1, "rt/a", 4, 4 * SECOND_NS + 100_000_000));
    assert_eq!(told(&mut hearing), ["3", "late since 3000", "4", "late since 4100"]);
    let no_room = sample(1, "rt/a", 5, 5 * SECOND_NS);
    let Heard::Sample(no_room) = no_room else { unreachable!() };
    hearing.hear(Heard::Dropped(no_room));
    hearing.hear(sample(1, "rt/a", 6, 5 * SECOND_NS));
    hearing.hear(sample(9, "rt/a", 1, 5 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["-1", "6", "?"]);
}

#[test]
fn a_message_that_took_longer_than_others_was_due_before_and_so_may_others_that_were_lost_before_it() {
    let mut hearing = watching(&[writer(1, "rt/a", false)]);
    hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
    hearing.hear(sample(1, "rt/a", 2, 3 * SECOND_NS));
    let Heard::Sample(again) = sample(1, "rt/a", 3, 4 * SECOND_NS) else { unreachable!() };
    hearing.hear(Heard::Sample(Sample { sent_ns: Some(4 * SECOND_NS - 300_000_000), ..again }));
    assert_eq!(told(&mut hearing), ["1", "2", "3", "late since 3650"]);
    hearing.hear(sample(1, "rt/a", 5, 5 * SECOND_NS));
    assert!(
        matches!(hearing.ready[0].0, Received::Lost { since_ns, .. } if since_ns / 1_000_000 == 3650),
        "{:?}",
        hearing.ready
    );
}

#[test]
fn however_shortly_a_message_was_held_back_it_may_come_after_others_that_it_preceded() {
    let mut hearing = watching(&[writer(1, "rt/a", false), writer(2, "rt/b", false)]);
    hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
    hearing.hear(sample(2, "rt/b", 1, 2 * SECOND_NS + 2_000_000));
    // It was sent again within 5 ms, and the next one had to wait for it.
    let Heard::Sample(again) = sample(1, "rt/a", 2, 2 * SECOND_NS + 7_000_000) else { unreachable!() };
    hearing.hear(Heard::Sample(Sample { by_ns: Some(2 * SECOND_NS + 4_000_000), ..again }));
    hearing.hear(sample(1, "rt/a", 3, 2 * SECOND_NS + 4_000_000));
    assert_eq!(told(&mut hearing), ["1", "1", "2", "late since 2000", "3", "late since 2004"]);
    // These came in one datagram.
    hearing.hear(sample(1, "rt/a", 4, 2 * SECOND_NS + 9_000_000));
    hearing.hear(sample(2, "rt/b", 2, 2 * SECOND_NS + 9_000_000));
    assert_eq!(told(&mut hearing), ["4", "2", "late since 2008"]);
}

#[test]
fn another_participant_finds_the_publishers_again() {
    let mut hearing = watching(&[writer(1, "rt/a", false)]);
    hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
    hearing.hear(Heard::Died("a defect".to_owned()));
    hearing.hear(writers(&[], &[]));
    hearing.hear(writers(&[writer(1, "rt/a", false)], &[]));
    hearing.hear(sample(1, "rt/a", 3, 3 * SECOND_NS));
    assert_eq!(told(&mut hearing), ["1", "?", "-1", "3"]);
    assert!(hearing.lost.is_empty() && hearing.notes[0].contains("a defect"), "{:?}", hearing.notes);
}

/// As from a participant that sends in the name of another: the numbers of its messages may be anything.
#[test]
fn every_gap_between_two_numbers_is_counted_however_large() {
    for number in [2, 3, 1 << 32, 1 << 61, i64::MAX - 1] {
        let mut hearing = watching(&[writer(1, "rt/a", false)]);
        hearing.hear(sample(1, "rt/a", 1, 2 * SECOND_NS));
        hearing.hear(sample(1, "rt/a", number, 3 * SECOND_NS));
        let gap = (number > 2).then(|| format!("-{}", number - 2));
        let expected: Vec<String> = ["1".to_owned()].into_iter().chain(gap).chain([number.to_string()]).collect();
        assert_eq!(told(&mut hearing), expected);
        // What the publisher says next seems to begin anew.
        hearing.hear(sample(1, "rt/a", 2, 4 * SECOND_NS));
        assert_eq!(told(&mut hearing), ["?", "2"], "after {number}");
    }
}

#[test]
fn a_message_without_a_valid_number_is_missing() {
    for number in [0, -1, -(1 << 32), -(1 << 61), i64::MIN, i64::MAX] {
        let mut hearing = watching(&[writer(1, "rt/a", false)]);
        hearing.hear(writers(&[writer(1, "rt/a", false), writer(2, "rt/b", false)], &[]));
        for topic in ["rt/a", "rt/b"] {
            let (id, start_ns) = if topic == "rt/a" { (1, 0) } else { (2, 10 * SECOND_NS) };
            // As the first of a publisher, and later.
            hearing.hear(sample(id, topic, number, start_ns + 2 * SECOND_NS));
            assert_eq!(told(&mut hearing), ["?"], "{number}");
            hearing.hear(sample(id, topic, 1, start_ns + 3 * SECOND_NS));
            told(&mut hearing);
            hearing.hear(sample(id, topic, number, start_ns + 4 * SECOND_NS));
            hearing.hear(sample(id, topic, number, start_ns + 5 * SECOND_NS));
            hearing.hear(sample(id, topic, 2, start_ns + 6 * SECOND_NS));
            assert_eq!(told(&mut hearing), ["?", "?", "2"], "{number}");
        }
    }
}

#[test]
fn there_is_a_limit_to_what_is_remembered() {
    let mut hearing = Hearing::new(None);
    let many = |from: u32| -> Vec<Writer> {
        let writer = |number: u32| {
            let mut guid = [0; 16];
            guid[..4].copy_from_slice(&number.to_le_bytes());
            Writer { guid, ..writer(0, &format!("rt/t{number}"), false) }
        };
        (from..from + 20_000).map(writer).collect()
    };
    for from in [0, 20_000, 40_000] {
        hearing.hear(writers(&many(from), &[]));
    }
    assert_eq!((hearing.survey.topics.len(), hearing.writers.len()), (MOST_TOPICS, 20_000));
    assert!(hearing.gone.len() <= MOST_GONE && hearing.robot.publishers.len() <= MOST_TOPICS);
}

proptest! {
    #[test]
    fn exactly_the_messages_between_two_numbers_are_missing(
        arriving in prop::collection::vec((1..3_u8, 1..40_i64, prop::bool::weighted(0.1)), 0..80),
    ) {
        let mut hearing = watching(&[writer(1, "rt/a", false), writer(2, "rt/a", false)]);
        let (mut last, mut lives, mut expected) = ([0; 3], [0_i64; 3], Vec::new());
        for (place, (id, number, is_anew)) in (0_i64..).zip(arriving) {
            let of = usize::from(id);
            // Some begin anew: then stamps go on.
            lives[of] += i64::from(is_anew);
            let Heard::Sample(said) = sample(id, "rt/a", number, SECOND_NS + place) else { unreachable!() };
            hearing.hear(Heard::Sample(Sample { sent_ns: Some(1000 * lives[of] + number), ..said }));
            let last = &mut last[of];
            if is_anew && number <= *last {
                expected.push("?".to_owned());
                expected.push(number.to_string());
                *last = number;
            }
            // What comes again, or too late, counts no more.
            if number > *last {
                if *last > 0 && number > *last + 1 {
                    expected.push(format!("-{}", number - *last - 1));
                }
                expected.push(number.to_string());
                *last = number;
            }
        }
        prop_assert_eq!(told(&mut hearing), expected);
    }
}
