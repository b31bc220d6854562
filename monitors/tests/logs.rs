//! Recorded logs.

use std::time::Duration;

use channels::{Event, EventKind, Flaw, Gap, Message, Monitor, Value};
use monitors::{Channels, EventLog, GapMark, LogError, SHIPPED, topology_of_log, verify};

use crate::robot::topology;

const LOG: &str = r#"{"scenario":"battery_fault","seed":1,"channels":[["a","b"],{"c":null}]}
{"step":0,"tick":0,"time_s":0.0,"generated":"tick"}
{"step":1,"tick":0,"time_s":0.0,"from":"TickGenerator","to":"BT","message":[{"sym":"tick"},0]}
{"tick":0,"time_s":0.0,"tree":[{"node":"a \"quoted\" name","status":"running"}]}
{"step":2,"tick":0,"time_s":0.02,"from":"Navigation","to":"GoToDestination","message":[{"sym":"ok"},{"sym":"running"}]}
{ "message" : [ {"sym":"ok"} , 25.5 ] , "to":"BatteryLevel", "from":"BatteryReader", "time_s":0.040000001, "tick":0, "step":3 }

{"step":4,"tick":11,"time_s":11.0,"generated":"tick"}
{"step":5,"tick":11,"time_s":11.02,"from":"BatteryReader","to":"BatteryLevel","message":[{"sym":"error"},"no \u0073ensor"]}
"#;

#[test]
fn a_log_is_verified_like_a_run() {
    let topology = topology();
    let text: String = SHIPPED.into_iter().take(2).map(|(_, text)| text).collect();
    let mut properties =
        monitors::load("both", &text, &topology, std::time::Duration::from_secs(1)).unwrap().properties;
    let mut log = EventLog::new(LOG.as_bytes(), &topology, Channels::All);
    let monitors = properties.iter_mut().map(|property| property.monitor.as_mut() as &mut dyn Monitor);
    let end = verify(&mut log, monitors).unwrap();
    assert_eq!((end.messages, end.ticks, end.last.map(|last| last.step)), (4, 2, Some(5)));
    let outcomes: Vec<_> = properties.iter().map(|property| monitors::Outcome::of(property.monitor.as_ref())).collect();
    assert_eq!(outcomes, [monitors::Outcome::Satisfied, monitors::Outcome::Violated]);
}

#[test]
fn events_are_read_to_the_nanosecond_and_texts_without_escapes() {
    let mut log = EventLog::new(LOG.as_bytes(), &topology(), Channels::All);
    let mut events = Vec::new();
    while let Some(event) = log.next_event().unwrap() {
        events.push(event);
    }
    assert_eq!(events[3].time.as_nanos(), 40_000_001);
    let EventKind::Received { message, .. } = &events[5].kind else { panic!("a message") };
    assert_eq!(message.to_string(), r#"[<error>, "no sensor"]"#);
    let EventKind::Received { message, .. } = &events[3].kind else { panic!("a message") };
    assert_eq!(message.to_string(), "[<ok>, 25.5]");
}

#[test]
fn infinite_numbers_are_read() {
    let line = r#"{"step":3,"tick":0,"time_s":0.0,"from":"BatteryReader","to":"BatteryLevel","message":[{"sym":"ok"},{"real":"-inf"}]}"#;
    let event = EventLog::new(line.as_bytes(), &topology(), Channels::All).next_event().unwrap();
    let EventKind::Received { message, .. } = event.expect("an event").kind else { panic!("a message") };
    assert_eq!(message.to_string(), "[<ok>, -inf]");
    let wrong = line.replace("-inf", "much");
    assert!(EventLog::new(wrong.as_bytes(), &topology(), Channels::All).next_event().is_err());
}

#[test]
fn unknown_channels_are_errors_or_skipped() {
    let mut empty = channels::Topology::default();
    let error = EventLog::new(LOG.as_bytes(), &empty, Channels::All).next_event();
    assert!(matches!(error, Ok(Some(_))), "a tick needs no channel");
    let count = |which, topology: &channels::Topology| {
        let mut log = EventLog::new(LOG.as_bytes(), topology, which);
        std::iter::from_fn(|| log.next_event().transpose()).collect::<Result<Vec<_>, _>>().map(|events| events.len())
    };
    assert!(matches!(count(Channels::Known, &empty), Ok(2)));
    let error = count(Channels::All, &empty).unwrap_err();
    assert_eq!(error.to_string(), "line 3 of the log: there is no channel from TickGenerator to BT");
    empty.process("Navigation").unwrap();
    let topology = topology_of_log(LOG.as_bytes()).unwrap();
    assert_eq!(topology.channels().count(), 3);
    assert!(matches!(count(Channels::All, &topology), Ok(6)));
}

#[test]
fn an_invalid_line_is_reported_with_its_location() {
    let read = |line: &str| {
        let mut log = EventLog::new(line.as_bytes(), &topology(), Channels::All);
        match log.next_event() {
            Err(LogError::Line { line, column, problem }) => format!("{line}:{column} {problem}"),
            other => format!("{other:?}"),
        }
    };
    assert_eq!(read("{\"a\":1}\nno\n"), "2:1 expected `{`");
    assert_eq!(read("{\"step\":x}"), "1:9 expected a number");
    assert_eq!(read("{\"step\":1.5}"), "1:12 expected a whole number");
    assert_eq!(read("{\"step\":1 \"tick\":2}"), "1:11 expected `,` or `}`");
    assert_eq!(read("{\"step\":1} x"), "1:12 expected the end of the line");
    let event = |rest: &str| read(&format!("{{\"step\":1,\"tick\":0,\"time_s\":0{rest}}}"));
    assert_eq!(event(",\"from\":\"a\",\"message\":[1]"), "1:1 this message has no `to`");
    assert_eq!(event(",\"to\":\"a\",\"message\":[1]"), "1:1 this message has no `from`");
    assert_eq!(event(",\"from\":\"a\",\"to\":\"b\""), "1:1 this message has no `message`");
    assert_eq!(read("{\"step\":1,\"time_s\":0,\"generated\":\"tick\"}"), "1:1 this event has no `tick`");
    assert_eq!(event(",\"tree\":[]"), "Ok(None)");
    assert_eq!(
        read("{\"message\":[{\"symbol\":1}]}"),
        "1:22 a value must be a number, a string, true, false or {\"sym\": …}"
    );
    assert_eq!(read(&format!("{{\"a\":\"{}\"}}", "x".repeat(1 << 20))), "1:1048577 this line is longer than 1 MiB");
}

/// Monitors foresee what may come from the domains of the channels, so such a message must not reach them unnoticed.
#[test]
fn a_message_that_its_channel_cannot_carry_is_refused_with_what_it_carries() {
    let read = |message: &str| {
        let line = format!(
            r#"{{"step":1,"tick":0,"time_s":0,"from":"BatteryReader","to":"BatteryLevel","message":{message}}}"#
        );
        match EventLog::new(line.as_bytes(), &topology(), Channels::All).next_event() {
            Ok(Some(Event { kind: EventKind::Received { message, .. }, .. })) => message.to_string(),
            Ok(other) => panic!("{other:?}"),
            Err(error) => error.to_string(),
        }
    };
    let carries = "[status: <ok>, level: real] or [status: <error>, reason: text]";
    for (outside, shown) in [
        (r#"[{"sym":"ok"},"15"]"#, r#"[<ok>, "15"]"#),
        (r#"[{"sym":"low"},5.0]"#, "[<low>, 5.0]"),
        (r#"[{"sym":"ok"}]"#, "[<ok>]"),
        (r#"[{"sym":"ok"},1.0,2.0]"#, "[<ok>, 1.0, 2.0]"),
        ("[]", "[]"),
    ] {
        let expected = format!("line 1 of the log: BatteryReader → BatteryLevel does not carry {shown}, but {carries}");
        assert_eq!(read(outside), expected);
    }
    // JSON does not tell 30 from 30.0.
    assert_eq!(read(r#"[{"sym":"ok"},30]"#), "[<ok>, 30.0]");
    assert_eq!(read(r#"[{"sym":"ok"},9007199254740992]"#), "[<ok>, 9007199254740992.0]");
    let expected = "[<ok>, 9007199254740993] (as a real number, level = 9007199254740993 would be rounded), but";
    let refused = read(r#"[{"sym":"ok"},9007199254740993]"#);
    assert!(refused.contains(expected), "{refused}");
}

/// Monitors also process messages outside their channels' domains.
#[test]
fn a_message_outside_its_domain_is_monitored_nevertheless() {
    let topology = topology();
    let text = "property p := always (BatteryReader, BatteryLevel, m[2] > 3)
        or always (BatteryReader, BatteryLevel, m[1] = <error>)";
    let file = monitors::load("p", text, &topology, std::time::Duration::from_secs(1)).unwrap();
    let mut property = file.properties.into_iter().next().unwrap();
    let channel = topology.find_channel("BatteryReader", "BatteryLevel").unwrap();
    // An error with a number, or a level that is not ok, is outside the domain.
    let outside = [("error", 7.0), ("other", 8.0), ("other", 2.0)];
    for (step, (head, level)) in (1..).zip(outside) {
        let kind = EventKind::Received { channel, message: Message::new([Value::symbol(head), level.into()]) };
        property.monitor.observe(&Event { step, tick: 0, time: std::time::Duration::ZERO, kind });
    }
    assert_eq!(property.monitor.verdict(), channels::Verdict::False);
}

/// The next gap, which begins.
fn next_gap(log: &mut EventLog<&[u8]>) -> Option<Gap> {
    log.next_gap_mark().map(|mark| match mark {
        GapMark::Begins(gap) => gap,
        GapMark::Ends(_) => panic!("{mark:?}"),
    })
}

#[test]
fn a_log_names_the_channel_of_a_gap_and_where_it_ends() {
    let text = r#"{"missing":"one","flaw":"missing","since_s":1.5,"channel":["TickGenerator","BT"],"ends":true}
{"missing":"of another system","flaw":"missing","channel":["TickGenerator","Unknown"],"ends":true}
{"resumed":["TickGenerator","Unknown"]}
{"missing":"of any","flaw":"mixed","channel":["TickGenerator","Unknown"]}
{"resumed":["TickGenerator","BT"]}
{"step":1,"tick":0,"time_s":2,"from":"TickGenerator","to":"BT","message":[{"sym":"tick"},0]}
"#;
    let topology = topology();
    let mut log = EventLog::new(text.as_bytes(), &topology, Channels::Known);
    assert!(log.next_event().unwrap().is_some() && log.skipped() == 0);
    let channel = topology.channels().find(|channel| topology.ends(*channel) == ("TickGenerator", "BT"));
    let since = Some(Duration::from_millis(1500));
    let one = Gap { channel, since, ends: true, ..Gap::of_anything("one") };
    let any = Gap { flaw: Flaw::Mixed, ..Gap::of_anything("of any") };
    let marks = [GapMark::Begins(one), GapMark::Begins(any), GapMark::Ends(channel.unwrap())];
    assert_eq!(std::iter::from_fn(|| log.next_gap_mark()).collect::<Vec<_>>(), marks);
    let wrong = text.replace(r#"["TickGenerator","BT"],"ends""#, r#""BT","ends""#);
    let refused = EventLog::new(wrong.as_bytes(), &topology, Channels::Known).next_event().unwrap_err().to_string();
    assert!(refused.contains("line 1 of the log") && refused.contains("expected `[`"), "{refused}");
}

#[test]
fn missing_lines_are_noticed_by_the_steps_and_ticks_that_are_skipped() {
    let lines = [
        r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#,
        r#"{"step":1,"tick":0,"time_s":0,"from":"TickGenerator","to":"BT","message":[{"sym":"tick"},0]}"#,
        r#"{"step":2,"tick":0,"time_s":0,"from":"Unknown","to":"Unheard","message":[]}"#,
        r#"{"tick":0,"time_s":0,"tree":[]}"#,
        r#"{"step":2,"tick":1,"time_s":1,"generated":"tick"}"#,
        r#"{"step":3,"tick":1,"time_s":1,"from":"TickGenerator","to":"BT","message":[{"sym":"tick"},1]}"#,
    ];
    let missing = |without: &[usize]| {
        let kept = lines.iter().enumerate().filter(|(index, _)| !without.contains(index));
        let text: String = kept.map(|(_, line)| format!("{line}\n")).collect();
        let topology = topology();
        let mut log = EventLog::new(text.as_bytes(), &topology, Channels::Known);
        while log.next_event().unwrap().is_some() {}
        let gap = next_gap(&mut log);
        assert_eq!(log.next_gap_mark(), None);
        gap.map(|gap| gap.why.strip_prefix("lines are missing before line ").unwrap().to_owned())
    };
    assert_eq!((missing(&[]), missing(&[3]), missing(&[5]), missing(&[3, 4, 5])), (None, None, None, None));
    for (without, expected) in [
        (&[1][..], "2 of the log: step 2 comes where 1 should"),
        (&[2], "4 of the log: step 2 comes where 1 should"),
        (&[1, 2, 4], "3 of the log: step 3 comes where 1 should"),
        (&[0], "4 of the log: tick 1 comes where 0 should"),
        (&[4], "5 of the log: tick 1 comes where 0 should"),
        (&[0, 1, 2, 3], "1 of the log: step 2 comes where 0 should"),
    ] {
        assert_eq!(missing(without).as_deref(), Some(expected), "{without:?}");
    }
}

#[test]
fn lines_that_come_again_and_lost_lines_of_the_world_are_noticed() {
    let world = |pct: f64| {
        format!(
            r#"{{"step":1,"tick":0,"time_s":0,"from":"World","to":"Monitors","message":[{{"sym":"world"}},{pct}]}}"#
        )
    };
    let lines = [
        r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#.to_owned(),
        r#"{"step":1,"tick":0,"time_s":0,"from":"TickGenerator","to":"BT","message":[{"sym":"tick"},0]}"#.to_owned(),
        world(9.0),
        world(8.0),
        r#"{"step":1,"tick":1,"time_s":1,"generated":"tick","world":2}"#.to_owned(),
    ];
    let gaps = |kept: &[usize]| {
        let text: String = kept.iter().map(|index| lines[*index].clone() + "\n").collect();
        let topology = topology();
        let mut log = EventLog::new(text.as_bytes(), &topology, Channels::Known);
        while log.next_event().unwrap().is_some() {}
        std::iter::from_fn(|| next_gap(&mut log)).map(|gap| (gap.flaw, gap.why)).collect::<Vec<_>>()
    };
    assert_eq!(gaps(&[0, 1, 2, 3, 4]), []);
    let again =
        |line: usize, what: &str| (Flaw::Mixed, format!("lines come again at line {line} of the log: {what} should"));
    assert_eq!(gaps(&[0, 0, 1, 2, 3, 4]), [again(2, "tick 0 comes where 1")]);
    assert_eq!(gaps(&[0, 1, 1, 2, 3, 4]), [again(3, "step 1 comes where 2")]);
    assert_eq!(gaps(&[0, 1, 2, 3, 3, 4]), [again(6, "the world's message 2 comes where 3")]);
    let missing = "lines are missing before line 4 of the log: the world's message 2 comes where 1 should".to_owned();
    assert_eq!(gaps(&[0, 1, 3, 4]), [(Flaw::Displaced, missing)]);
}

#[test]
fn a_log_can_say_itself_what_is_missing_from_it() {
    let text = r#"{"scenario":"nominal"}
{"missing":"all \"before\"","flaw":"mixed"}
{"step":1,"tick":0,"time_s":2,"from":"TickGenerator","to":"BT","message":[{"sym":"tick"},0]}
{"missing":"the end","flaw":"late","since_s":1.5}
"#;
    let topology = topology();
    let mut log = EventLog::new(text.as_bytes(), &topology, Channels::All);
    let mixed = Gap { flaw: Flaw::Mixed, ..Gap::of_anything("all \"before\"") };
    let late = Gap { flaw: Flaw::Late, since: Some(Duration::from_millis(1500)), ..Gap::of_anything("the end") };
    assert!(log.next_event().unwrap().is_some());
    assert_eq!((next_gap(&mut log), log.next_gap_mark()), (Some(mixed), None));
    assert_eq!((log.next_event().unwrap(), next_gap(&mut log)), (None, Some(late)));
    let wrong = text.replace("late", "lost");
    let mut log = EventLog::new(wrong.as_bytes(), &topology, Channels::All);
    assert!(log.next_event().unwrap().is_some());
    let refused = log.next_event().unwrap_err().to_string();
    assert!(refused.starts_with("line 4 of the log, byte ") && refused.contains("a flaw is"), "{refused}");
}

#[test]
fn a_log_with_lines_out_of_order_is_refused_at_the_line() {
    let tick = |step: u64, tick: u64, time_s: f64| {
        format!(r#"{{"step":{step},"tick":{tick},"time_s":{time_s},"generated":"tick"}}"#)
    };
    for wrong in [tick(4, 3, 3.0), tick(5, 1, 3.0), tick(5, 3, 1.5)] {
        let text = [tick(4, 2, 2.0), tick(5, 2, 2.0), wrong].join("\n");
        let topology = topology();
        let mut log = EventLog::new(text.as_bytes(), &topology, Channels::All);
        assert!(log.next_event().unwrap().is_some() && log.next_event().unwrap().is_some());
        let reported = log.next_event().unwrap_err().to_string();
        assert!(reported.starts_with("line 3 of the log goes back"), "{reported}");
    }
}

#[test]
fn a_log_that_has_an_end_breaks_off_without_it_and_has_nothing_after_it() {
    let lines = [
        r#"{"scenario":"nominal","has_end":true}"#,
        r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#,
        r#"{"end":"arrival","time_s":0.5}"#,
        r#"{"step":0,"tick":1,"time_s":1,"generated":"tick"}"#,
    ];
    let topology = topology();
    let read = |kept: &[usize]| {
        let text: String = kept.iter().map(|index| format!("{}\n", lines[*index])).collect();
        let mut log = EventLog::new(text.as_bytes(), &topology, Channels::Known);
        loop {
            match log.next_event() {
                Ok(Some(_)) => {}
                Ok(None) => return Ok(log.lacks_end()),
                Err(error) => return Err(error.to_string()),
            }
        }
    };
    assert_eq!(read(&[0, 1, 2]), Ok(false));
    assert_eq!((read(&[0]), read(&[0, 1]), read(&[0, 1, 3])), (Ok(true), Ok(true), Ok(true)));
    // Other programs write none, or mean something else by it.
    assert_eq!((read(&[1, 3]), read(&[1, 2, 3])), (Ok(false), Ok(false)));
    assert_eq!(read(&[0, 1, 2, 3]), Err("line 4 of the log comes after the end of its run".to_owned()));
}

/// The gaps of a log over the channels of the paper, and when its run ended.
fn gaps_and_end(text: &str) -> (Vec<Gap>, Option<Duration>) {
    let topology = topology();
    let mut log = EventLog::new(text.as_bytes(), &topology, Channels::Known);
    while log.next_event().expect("a readable log").is_some() {}
    (std::iter::from_fn(|| next_gap(&mut log)).collect(), log.end())
}

#[test]
fn the_last_line_tells_whether_lines_before_it_are_missing() {
    let lines = [
        r#"{"scenario":"nominal","has_end":true}"#,
        r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#,
        r#"{"step":1,"tick":0,"time_s":0,"from":"TickGenerator","to":"BT","message":[{"sym":"tick"},0]}"#,
        r#"{"step":1,"tick":1,"time_s":1,"generated":"tick"}"#,
        r#"{"step":1,"tick":1,"time_s":1,"from":"World","to":"Monitors","message":[{"sym":"world"},9.0]}"#,
        r#"{"end":"arrival","step":1,"tick":1,"time_s":1.5,"world":1}"#,
    ];
    let read = |without: &[usize]| {
        let kept = lines.iter().enumerate().filter(|(index, _)| !without.contains(index));
        let (gaps, end) = gaps_and_end(&kept.map(|(_, line)| format!("{line}\n")).collect::<String>());
        assert_eq!(end, Some(Duration::from_millis(1500)));
        gaps.into_iter().map(|gap| gap.why).collect::<Vec<_>>()
    };
    let missing =
        |line: u64, what: &str| vec![format!("lines are missing before line {line} of the log: {what} should")];
    assert_eq!(read(&[]), Vec::<String>::new());
    assert_eq!(read(&[4]), missing(5, "the world's message 1 comes where 0"));
    let of_world = "the world's message 1 comes where 0";
    assert_eq!(read(&[3, 4]), [missing(4, "tick 1 comes where 0"), missing(4, of_world)].concat());
    assert_eq!(read(&[2, 3, 4]), [missing(3, "step 1 comes where 0"), missing(3, of_world)].concat());
    assert_eq!(read(&[1, 2, 3, 4]), missing(2, "step 1 comes where 0"));
}

#[test]
fn a_line_with_a_gap_that_is_missing_is_noticed_at_the_end() {
    let log = |gap: &str, end: &str| {
        let tick = r#"{"step":0,"tick":0,"time_s":1,"generated":"tick"}"#;
        let end = format!(r#"{{"end":"arrival","step":0,"tick":0,"time_s":1.5{end}}}"#);
        gaps_and_end(&format!("{{\"has_end\":true}}\n{tick}\n{gap}{end}\n")).0
    };
    let told = "{\"missing\":\"2 messages\"}\n";
    assert_eq!(log(told, r#","gaps":1"#), [Gap::of_anything("2 messages")]);
    // As in a log of an earlier version.
    assert_eq!(log(told, ""), [Gap::of_anything("2 messages")]);
    let why = "lines are missing before line 3 of the log: gap 1 comes where 0 should";
    let anything = Gap { flaw: Flaw::Displaced, since: Some(Duration::ZERO), ..Gap::of_anything(why) };
    assert_eq!(log("", r#","gaps":1"#), [anything]);
}

#[test]
fn what_other_programs_call_gaps_world_or_time_between_ticks_may_be_anything() {
    let tick = r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#;
    for value in ["null", "[1,2]", r#"{"a":1.5}"#, r#""a.sdf""#, "1.5", "true"] {
        let first = format!(r#"{{"gaps":{value},"world":{value},"tick_s":{value}}}"#);
        assert_eq!(gaps_and_end(&format!("{first}\n{tick}\n")), (vec![], None), "{value}");
    }
}

/// A verdict may have been reached before the next tick shows that one is missing.
#[test]
fn a_log_without_its_first_tick_is_doubted_from_its_start() {
    let message = r#"{"step":1,"tick":0,"time_s":0.5,"from":"TickGenerator","to":"BT","message":[{"sym":"tick"},0]}"#;
    let tick = r#"{"step":1,"tick":1,"time_s":1,"generated":"tick"}"#;
    let flaws = |text: &str| {
        let (gaps, _) = gaps_and_end(text);
        gaps.into_iter().map(|gap| (gap.flaw, gap.since, gap.why)).collect::<Vec<_>>()
    };
    let wrong = |line: u64, what: &str| {
        let why = format!("lines are missing before line {line} of the log: {what}");
        (Flaw::Displaced, Some(Duration::ZERO), why)
    };
    assert_eq!(flaws(&format!("{message}\n{tick}\n")), [wrong(2, "tick 1 comes where 0 should")]);
    let end = r#"{"end":"arrival","step":1,"tick":0,"time_s":1}"#;
    assert_eq!(flaws(&format!("{{\"has_end\":true}}\n{message}\n{end}\n")), [wrong(3, "tick 0 is missing")]);
}

/// A verdict that was reached after it may rest on what the world was before.
#[test]
fn a_lost_message_of_the_world_is_doubted_since_the_last_tick_that_counts_them() {
    let tick = |tick: u64, step: u64, world: &str| {
        format!(r#"{{"step":{step},"tick":{tick},"time_s":{tick},"generated":"tick"{world}}}"#) + "\n"
    };
    let world = r#"{"step":0,"tick":1,"time_s":1.5,"from":"World","to":"Monitors","message":[{"sym":"world"},9.0]}"#;
    // A message is missing, too: that is noticed by itself, and concerns only what comes after it.
    for (step, more) in [(0, &[][..]), (1, &[(Flaw::Missing, None)])] {
        let lines = [tick(0, 0, ""), tick(1, 0, ""), format!("{world}\n"), tick(2, step, r#","world":2"#)];
        let (gaps, _) = gaps_and_end(&lines.concat());
        let since = gaps.iter().map(|gap| (gap.flaw, gap.since)).collect::<Vec<_>>();
        assert_eq!(since, [more, &[(Flaw::Displaced, Some(Duration::from_secs(1)))]].concat());
    }
}

#[test]
fn a_log_that_is_cut_off_in_a_line_breaks_off_there() {
    let tick = r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#;
    let message = r#"{"step":1,"tick":0,"time_s":0.5,"from":"TickGenerator","to":"BT","message":[{"sym":"a\"]}"},0]}"#;
    for end in 1..message.len() {
        let (gaps, _) = gaps_and_end(&format!("{tick}\n{}", &message[..end]));
        assert_eq!(gaps, [Gap::of_anything("the log breaks off in line 2")], "{end} bytes");
    }
}
