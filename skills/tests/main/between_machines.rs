//! Services, actions and topics between machines, whatever the schedule.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Capacity, Chance, ChannelSystem, Disturbance, Domain, Effect, Event, EventKind, FieldKind, NoNormalForm, Process,
    Random, Role, Scheduler, Shape, Topology,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use skills::{Chart, SkillProcess};

use crate::lockstep::Lockstep;
use crate::stage::file;

fn shape(first: &str, head: &str, field: Option<(&str, FieldKind)>, role: Role) -> Shape {
    let head = (first, FieldKind::symbols([head]));
    Shape::new(std::iter::once(head).chain(field)).with_role(role)
}

/// The messages between a client and the arm.
fn lines() -> (Domain, Domain) {
    let text = || Some(("text", FieldKind::Text));
    let number = || Some(("n", FieldKind::Int));
    let requests = [
        shape("request", "say", text(), Role::Request),
        shape("request", "pick.goal", number(), Role::Goal),
        shape("request", "pick.cancel", None, Role::Cancel),
    ];
    let answers = [
        shape("status", "ok", text(), Role::Reply),
        shape("status", "pick.accepted", None, Role::Feedback),
        shape("status", "pick.feedback", number(), Role::Feedback),
        shape("status", "pick.succeeded", number(), Role::Result),
        shape("status", "pick.canceled", None, Role::Result),
        height(),
    ];
    (Domain::new(requests), Domain::new(answers))
}

fn height() -> Shape {
    shape("topic", "height", Some(("n", FieldKind::Int)), Role::Topic)
}

/// Two clients and an arm.
fn system([one, two, arm]: [&str; 3]) -> ChannelSystem {
    let mut topology = Topology::default();
    let names = ["One", "Two", "Arm"];
    let [a, b, server] = names.map(|name| topology.process(name).unwrap());
    let (requests, answers) = lines();
    for client in [a, b] {
        topology.channel(client, server, Capacity::One, requests.clone()).unwrap();
        topology.channel(server, client, Capacity::One, answers.clone()).unwrap();
    }
    topology.publish(server, height());
    let machine = |(name, content): (&str, &str)| {
        let chart = Chart::load(&format!("{name}.scxml"), &file("", content)).unwrap();
        let process = SkillProcess::new(name, &chart, &topology, [])
            .unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)));
        (topology.find_process(name).unwrap(), Box::new(process) as Box<dyn Process>)
    };
    let processes: Vec<_> = names.into_iter().zip([one, two, arm]).map(machine).collect();
    ChannelSystem::new(Arc::new(topology), processes).unwrap()
}

/// The events of a run, with the names of sender and receiver, under a random schedule.
fn run(machines: [&str; 3], seed: u64) -> (Vec<(String, Event)>, ChannelSystem) {
    let mut system = system(machines);
    let topology = Arc::clone(system.topology());
    let mut scheduler: Box<dyn Scheduler> = Box::new(Random::new(ChaCha8Rng::seed_from_u64(seed)));
    let mut events = Vec::new();
    for step in 0..40 {
        system.advance(Duration::from_millis(100 * step));
        for event in system.run(scheduler.as_mut(), 10_000) {
            let event = event.unwrap();
            let EventKind::Received { channel, ref message } = event.kind else { continue };
            let (from, to) = topology.ends(channel);
            events.push((format!("{from} {} {to}", message.head().unwrap()), event));
        }
    }
    (events, system)
}

/// The second field of the message.
fn field(event: &Event) -> &channels::Value {
    match &event.kind {
        EventKind::Received { message, .. } => message.field(2).unwrap(),
        EventKind::Tick => panic!("there is no tick"),
    }
}

fn count(events: &[(String, Event)], what: &str) -> usize {
    events.iter().filter(|(event, _)| event == what).count()
}

const SILENT: &str = "<state id='silent'/>";

/// Asks three times at once, and then after each answer.
const TALKER: &str = "<state id='asks'>
    <onentry>
        <send type='channel' target='Arm' event='say'><param name='text' expr=\"'a'\"/></send>
        <send type='channel' target='Arm' event='say'><param name='text' expr=\"'b'\"/></send>
        <send type='channel' target='Arm' event='say'><param name='text' expr=\"'c'\"/></send>
    </onentry>
    <transition event='Arm.ok' cond=\"_event.data.text == 'c'\" target='asks'/>
</state>";

/// Answers after a time, with what it received; asks nothing itself.
const LISTENER: &str = "<datamodel><data id='who'/><data id='text'/></datamodel>
<state id='idle'>
    <transition event='say' target='busy'>
        <assign location='who' expr='_event.origin'/><assign location='text' expr='_event.data.text'/>
    </transition>
</state>
<state id='busy'>
    <onentry><send event='done' delay='250ms'/></onentry>
    <transition event='done' target='idle'>
        <send type='channel' targetexpr='who' event='ok'><param name='text' expr='text'/></send>
    </transition>
</state>";

#[test]
fn a_service_answers_each_request_of_a_client_before_it_takes_the_next() {
    for seed in 0..50 {
        let (events, _) = run([TALKER, SILENT, LISTENER], seed);
        let words = |what: &str| -> Vec<String> {
            let these = events.iter().filter(|(event, _)| event == what);
            these.map(|(_, event)| field(event).to_string()).collect()
        };
        let (asked, answered) = (words("One say Arm"), words("Arm ok One"));
        assert!(asked.len() >= 12, "seed {seed}: {asked:?}");
        assert!(asked.len() - answered.len() <= 1, "seed {seed}");
        assert!(asked.starts_with(&answered), "seed {seed}: {asked:?} {answered:?}");
    }
}

/// Begins to pick, gives up after a time that is sometimes too late, and begins again.
fn picker(patience_ms: u32) -> String {
    format!(
        "<datamodel><data id='n' expr='0'/></datamodel>
        <state id='picks'>
            <onentry>
                <assign location='n' expr='n + 1'/>
                <send type='channel' target='Arm' event='pick.goal'><param name='n' expr='n'/></send>
                <send id='patience' event='patience' delay='{patience_ms}ms'/>
            </onentry>
            <onexit><cancel sendid='patience'/></onexit>
            <transition event='patience'><send type='channel' target='Arm' event='pick.cancel'/></transition>
            <transition event='Arm.pick.succeeded Arm.pick.canceled' target='picks'/>
            <transition event='Arm.pick.accepted Arm.pick.feedback Arm.height'/>
        </state>"
    )
}

/// Pursues one goal at a time; the goals of others wait.
const ARM: &str = "<datamodel><data id='who'/><data id='n'/></datamodel>
<state id='idle'>
    <transition event='pick.goal' target='picking'>
        <assign location='who' expr='_event.origin'/><assign location='n' expr='_event.data.n'/>
        <send type='channel' targetexpr='who' event='pick.accepted'/>
    </transition>
</state>
<state id='picking'>
    <onentry>
        <send id='half' event='half' delay='200ms'/><send id='done' event='done' delay='400ms'/>
    </onentry>
    <onexit><cancel sendid='half'/><cancel sendid='done'/></onexit>
    <transition event='half'>
        <send type='channel' targetexpr='who' event='pick.feedback'><param name='n' expr='n'/></send>
    </transition>
    <transition event='done' target='idle'>
        <send type='channel' targetexpr='who' event='pick.succeeded'><param name='n' expr='n'/></send>
    </transition>
    <transition event='pick.cancel' target='idle'>
        <send type='channel' targetexpr='who' event='pick.canceled'/>
    </transition>
</state>";

#[test]
fn a_goal_ends_once_and_a_cancel_is_answered_once() {
    for (patience, canceled) in [(100, true), (300, true), (400, false), (1_000, false)] {
        for seed in 0..50 {
            let (events, _) = run([&picker(patience), SILENT, ARM], seed);
            let (goals, cancels) = (count(&events, "One pick.goal Arm"), count(&events, "One pick.cancel Arm"));
            let (reached, given_up) =
                (count(&events, "Arm pick.succeeded One"), count(&events, "Arm pick.canceled One"));
            assert!(goals >= 9, "{patience} ms, seed {seed}: {goals} goals");
            assert!(
                goals - reached - given_up <= 1,
                "{patience} ms, seed {seed}: a goal has ended twice or not at all"
            );
            assert!(given_up <= cancels, "{patience} ms, seed {seed}");
            if patience != 400 {
                assert_eq!(given_up > 0, canceled, "{patience} ms, seed {seed}");
                assert_eq!(reached > 0, !canceled, "{patience} ms, seed {seed}");
            }
            // No message of another goal comes between a goal and its end.
            let mut open = false;
            for (what, _) in events.iter().filter(|(what, _)| what.contains("pick.")) {
                match what.as_str() {
                    "One pick.goal Arm" => assert!(!std::mem::replace(&mut open, true), "{patience} ms, seed {seed}"),
                    "Arm pick.succeeded One" | "Arm pick.canceled One" => open = false,
                    _ => {}
                }
            }
        }
    }
}

/// Publishes three values at a time.
const PUBLISHER: &str = "<datamodel><data id='n' expr='0'/></datamodel>
<state id='publishes'>
    <onentry>
        <send type='channel' event='height'><param name='n' expr='n + 1'/></send>
        <send type='channel' event='height'><param name='n' expr='n + 2'/></send>
        <send type='channel' event='height'><param name='n' expr='n + 3'/></send>
        <assign location='n' expr='n + 3'/>
        <send event='again' delay='100ms'/>
    </onentry>
    <transition event='again' target='publishes'/>
</state>";

const READER: &str = "<state id='reads'><transition event='Arm.height'/></state>";

#[test]
fn the_newest_value_of_a_topic_reaches_every_subscriber() {
    for seed in 0..50 {
        let (events, _) = run([READER, READER, PUBLISHER], seed);
        let mut last: BTreeMap<&str, i64> = BTreeMap::new();
        let mut per_round: BTreeMap<(&str, Duration), i64> = BTreeMap::new();
        for (what, event) in &events {
            let value = match field(event) {
                channels::Value::Int(value) => *value,
                other => panic!("{other}"),
            };
            let previous = last.insert(what, value);
            assert!(previous.is_none_or(|previous| previous < value), "seed {seed}: values come in order");
            per_round.insert((what, event.time), value);
        }
        assert_eq!(last, BTreeMap::from([("Arm height One", 120), ("Arm height Two", 120)]), "seed {seed}");
        assert!(per_round.values().all(|value| value % 3 == 0), "seed {seed}: the newest of each round arrives");
    }
}

#[test]
fn unpublished_topics_and_messages_that_no_channel_carries_are_refused() {
    let refused = |content: &str| {
        let mut topology = Topology::default();
        let [client, server] = ["One", "Arm"].map(|name| topology.process(name).unwrap());
        let (requests, answers) = lines();
        topology.channel(client, server, Capacity::One, requests).unwrap();
        topology.channel(server, client, Capacity::One, answers).unwrap();
        topology.publish(server, height());
        let chart = Chart::load("Arm.scxml", &file("", content)).unwrap();
        match SkillProcess::new("Arm", &chart, &topology, []) {
            Err(skills::SkillError::Wiring { problems, .. }) => problems[0].to_string(),
            other => panic!("{other:?}"),
        }
    };
    let send = |attributes: &str| {
        format!("<state id='s'><transition event='say'><send type='channel' {attributes}/></transition></state>")
    };
    assert_eq!(refused(&send("event='heigth'")), "Arm does not publish <heigth>, and the message has no target");
    assert_eq!(refused(&send("targetexpr='_event.origin' event='okay'")), "no channel from Arm carries <okay>");
}

#[test]
fn a_request_that_nobody_sends_may_have_a_transition() {
    let mut topology = Topology::default();
    let [client, server] = ["One", "Arm"].map(|name| topology.process(name).unwrap());
    let (requests, answers) = lines();
    topology.channel(client, server, Capacity::One, requests).unwrap();
    topology.channel(server, client, Capacity::One, answers).unwrap();
    topology.understand(server, shape("request", "fold", None, Role::Request));
    let sent = |event: &str| {
        let content =
            format!("<state id='s'><onentry><raise event='begin'/></onentry><transition event='{event}'/></state>");
        let chart = Chart::load("Arm.scxml", &file("", &content)).unwrap();
        match SkillProcess::new("Arm", &chart, &topology, []) {
            Err(skills::SkillError::Wiring { problems, .. }) => {
                problems.iter().map(|problem| format!("{problem}: {}", problem.help_text().unwrap())).collect()
            }
            fits => fits.map(|_| String::new()).unwrap(),
        }
    };
    assert_eq!(sent("fold"), "");
    let events = sent("unfold");
    assert!(events.starts_with("the event `unfold` never occurs"), "{events}");
    for occurs in ["say", "begin"] {
        assert!(events.contains(occurs), "{events}");
    }
}

/// Such a field is undefined, so a condition about it is always false, or always true.
#[test]
fn a_field_that_no_message_of_an_event_has_and_a_value_that_it_never_has_are_refused() {
    let mut topology = Topology::default();
    let [client, server] = ["One", "Arm"].map(|name| topology.process(name).unwrap());
    let state = Some(("state", FieldKind::symbols(["open", "closed"])));
    let optional = Some(("n", FieldKind::Optional(Box::new(FieldKind::Int))));
    let requests = [
        shape("request", "say", Some(("text", FieldKind::Text)), Role::Request),
        shape("request", "count", optional, Role::Request),
        shape("request", "see", state, Role::Request),
    ];
    topology.channel(client, server, Capacity::One, Domain::new(requests)).unwrap();
    topology.channel(server, client, Capacity::One, lines().1).unwrap();
    topology.understand(server, shape("request", "fold", Some(("at", FieldKind::Text)), Role::Request));
    let problems = |transition: &str| {
        let data = "<datamodel><data id='kept'/></datamodel>";
        let content = format!("{data}<state id='s'><onentry><raise event='own'/></onentry>{transition}</state>");
        let chart = Chart::load("Arm.scxml", &file("", &content)).unwrap();
        match SkillProcess::new("Arm", &chart, &topology, []) {
            Ok(_) => Vec::new(),
            Err(skills::SkillError::Wiring { problems, .. }) => {
                problems.iter().map(|problem| format!("{problem}; {}", problem.help_text().unwrap())).collect()
            }
            Err(other) => panic!("{other}"),
        }
    };
    let on = |event: &str, cond: &str| problems(&format!("<transition event='{event}' cond=\"{cond}\"/>"));
    for (event, cond) in [
        ("say", "_event.data.text != 'broken' &amp;&amp; _event.data.request == 'say'"),
        ("say see", "_event.data.text == 'a' || _event.data.state == 'open'"),
        ("count", "_event.data.n === undefined || _event.data.n > 0.5"),
        ("count", "_event.data.n == '3'"),
        ("see", "_event.data.state != null"),
        ("fold", "_event.data.at == 'home'"),
        // What comes with these is not known.
        ("own say", "_event.data.mod == 3"),
        ("*", "_event.data.mod == 3"),
    ] {
        assert_eq!(on(event, cond), Vec::<String>::new(), "{event} {cond}");
    }
    let say = "`say` has no field `txt`; did you mean `text`?";
    assert_eq!(on("say", "_event.data.txt != 'broken'"), [say]);
    assert_eq!(on("say", "_event.data['txt'] != 'broken'"), [say]);
    let assigned = "<assign location='kept' expr='_event.data.txt'/>";
    assert_eq!(problems(&format!("<transition event='say'>{assigned}</transition>")), [say]);
    let asked = "<if cond='kept == _event.data.txt'><log expr='kept'/></if>";
    assert_eq!(problems(&format!("<transition event='say'>{asked}</transition>")), [say]);
    let either = on("say see", "!_event.data.speed");
    assert!(either[0].starts_with("`say` or `see` has no field `speed`; "), "{either:?}");
    let [stage] = &on("see", "_event.data.state == 'opeen'")[..] else { panic!("one problem") };
    assert_eq!(stage, "the field `state` is never `opeen`; it is <open> | <closed>");
    assert_eq!(on("say", "5 &lt; _event.data.text"), ["the field `text` cannot be compared with 5; it is text"]);
    assert_eq!(on("count", "_event.data.n == 'no'").len(), 1);
}

#[test]
fn a_component_without_clients_may_answer_requests() {
    let mut topology = Topology::default();
    let server = topology.process("Arm").unwrap();
    topology.understand(server, shape("request", "fold", None, Role::Request));
    let content = "<state id='s'><transition event='fold'>
        <send type='channel' targetexpr='_event.origin' event='ok'/></transition></state>";
    let chart = Chart::load("Arm.scxml", &file("", content)).unwrap();
    assert!(SkillProcess::new("Arm", &chart, &topology, []).is_ok());
}

/// Invokes a separate machine for each request, which is canceled if it takes too long.
const FOREMAN: &str = "<datamodel><data id='who'/><data id='text'/></datamodel>
<state id='idle'>
    <transition event='say' target='busy'>
        <assign location='who' expr='_event.origin'/><assign location='text' expr='_event.data.text'/>
    </transition>
</state>
<state id='busy'>
    <onentry><send id='late' event='late' delay='300ms'/></onentry>
    <onexit><cancel sendid='late'/></onexit>
    <invoke autoforward='true'>
        <param name='text' expr='text'/>
        <content><scxml version='1.0' initial='works'>
            <datamodel><data id='text'/></datamodel>
            <state id='works'>
                <onentry><send event='step' delay='100ms'/></onentry>
                <onexit>
                    <send type='channel' event='height'><param name='n' expr=\"_event.name == 'step' ? 1 : 2\"/></send>
                </onexit>
                <transition event='step' cond=\"text == 'a'\" target='works'/>
                <transition event='step' target='done'/>
            </state>
            <final id='done'/>
        </scxml></content>
    </invoke>
    <transition event='done.invoke late' target='idle'>
        <send type='channel' targetexpr='who' event='ok'><param name='text' expr='text'/></send>
    </transition>
</state>";

/// Has a condition about the last event, which cannot be evaluated without one.
const WATCHER: &str = "<datamodel><data id='count' expr='0'/></datamodel>
<state id='watches'>
    <transition cond=\"_event.name == 'say' &amp;&amp; count == 2\" target='watches'>
        <assign location='count' expr='0'/>
        <send type='channel' target='One' event='ok'><param name='text' expr=\"'c'\"/></send>
    </transition>
    <transition event='say'><assign location='count' expr='count + 1'/></transition>
    <transition event='error.execution'>
        <send type='channel' event='height'><param name='n' expr='count'/></send>
    </transition>
</state>";

#[test]
fn machines_and_their_normal_forms_are_indistinguishable() {
    let (patient, hasty) = (picker(300), picker(100));
    let clients = [TALKER, &patient, &hasty, READER, SILENT];
    let arms = [LISTENER, ARM, PUBLISHER, FOREMAN, WATCHER];
    let mut steps = 0;
    for seed in 0..400 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut one_of = |count: usize| random.next_u64() as usize % count;
        let machines = [clients[one_of(5)], clients[one_of(5)], arms[one_of(5)]];
        let mut pair = Lockstep::new(&system(machines), Duration::ZERO);
        let effects = [Effect::Lose, Effect::Repeat, Effect::Hold(Duration::from_millis(70))];
        for (effect, channel) in effects.into_iter().zip(pair.plain.topology().channels()).take(one_of(4)) {
            let stream = ChaCha8Rng::seed_from_u64(seed);
            let probability = Some(Chance { probability: 0.3, stream });
            let disturbance = Disturbance { probability, ..Disturbance::all(channel, effect) };
            pair.with(|system| {
                system.disturb(disturbance.clone());
            });
        }
        let mut scheduler = Random::new(ChaCha8Rng::seed_from_u64(seed));
        for _ in 0..40 {
            steps += pair.run(&mut scheduler);
            let until = pair.next_timer().unwrap_or_default();
            let passes = until + Duration::from_millis(one_of(3) as u64 * 40);
            pair.advance(if one_of(4) == 0 { until / 2 } else { passes });
        }
    }
    assert!(steps > 20_000, "{steps} steps");
}

#[test]
fn a_machine_without_a_normal_form_says_why() {
    let refusal = |arm: &str| {
        let mut system = system([TALKER, SILENT, arm]);
        let mut scheduler = Random::new(ChaCha8Rng::seed_from_u64(0));
        for event in system.run(&mut scheduler, 1_000) {
            event.unwrap();
        }
        match system.normalize() {
            Err((id, NoNormalForm::Unsupported { reason, help: Some(_) })) => {
                format!("{}: {reason}", system.topology().name(id))
            }
            other => panic!("{other:?}"),
        }
    };
    let keeps = |what: &str| {
        format!(
            "<datamodel><data id='kept'/></datamodel><state id='s'>
            <transition event='say'><send event='later' delay='1s' {what}/></transition></state>"
        )
    };
    let ids = "Arm: it reads ids that are generated whenever a machine is invoked or an event is sent";
    assert_eq!(refusal(&keeps("idlocation='kept'")), ids);
    let greets = "<datamodel><data id='kept'/></datamodel><state id='s'>
        <invoke><content><scxml version='1.0'>
            <state id='t'><onentry><send target='#_parent' event='here'/></onentry></state>
        </scxml></content></invoke>
        <transition event='here'><assign location='kept' expr='_event.origin'/></transition>
    </state>";
    assert_eq!(refusal(greets), ids);
    #[cfg(feature = "ecmascript")]
    for (expression, reason) in [
        ("Math.random() &lt; 2", "it draws random numbers"),
        ("Date.now() >= 0", "it reads the time of the run, which never repeats"),
    ] {
        let arm = format!("<state id='s'><transition event='say' cond='{expression}'/></state>");
        assert_eq!(refusal(&arm), format!("Arm: {reason}"));
    }
    let talks = "<state id='s'><onentry><send event='more'/></onentry><transition event='say' target='s'>
        <foreach array='[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17]' item='n'>
            <send event='later' delay='1s'/><send event='later' delay='1s'/></foreach></transition></state>";
    let mut system = system([TALKER, SILENT, talks]);
    system.run(&mut Random::new(ChaCha8Rng::seed_from_u64(0)), 1_000).for_each(|event| drop(event.unwrap()));
    let endless = NoNormalForm::Endless { what: "more than 32 delayed events are waiting in Arm".to_owned() };
    assert_eq!(system.normalize().map_err(|(_, why)| why), Err(endless));
}

/// The mistakes of the arm, with the states in which it makes them, and the events of the run.
fn mistakes(client: &str, arm: &str) -> (Vec<String>, Vec<(String, Event)>) {
    let (events, system) = run([client, SILENT, arm], 1);
    let of = |process: &str| {
        let process = system.topology().find_process(process).unwrap();
        system.process::<SkillProcess>(process).unwrap().mishaps()
    };
    assert_eq!(of("One"), []);
    let words = of("Arm").iter().map(|mishap| format!("{}: {}", mishap.place("Arm"), mishap.message));
    (words.collect(), events)
}

/// Nothing tells the client, and properties see no message: the run must say that the machine has made a mistake.
#[test]
fn an_answer_that_does_not_fit_or_that_nobody_awaits_is_a_mistake_of_the_machine() {
    let arm = |answers: &str| {
        format!(
            "<datamodel><data id='n' expr='9007199254740992'/></datamodel>
            <state id='idle'><transition event='say'>{answers}</transition></state>"
        )
    };
    let answer = |expr: &str| {
        let param = format!("<param name='text' expr=\"{expr}\"/>");
        format!("<send type='channel' targetexpr='_event.origin' event='ok'>{param}</send>")
    };
    let mistakes = |answers: &str| {
        let (words, events) = mistakes(TALKER, &arm(answers));
        (words, count(&events, "Arm ok One"))
    };
    let unfit = "Arm, state idle: <ok> cannot be sent to One: the field text is text, and 9007199254740992 is not";
    assert_eq!(mistakes(&answer("n")), (vec![unfit.to_owned()], 0));
    let (twice, answered) = mistakes(&(answer("'a'") + &answer("'b'")));
    assert_eq!(twice, ["Arm, state idle: <ok> answers nothing: One is not waiting for an answer"]);
    assert!(answered > 0);
    let (once, answered_once) = mistakes(&answer("'a'"));
    assert_eq!((once, answered_once), (vec![], answered), "the client gets the first answer alone");
    let unasked =
        "<onentry><send type='channel' target='Two' event='ok'><param name='text' expr=\"''\"/></send></onentry>";
    let (unasked, _) = self::mistakes(SILENT, &format!("<state id='s'>{unasked}<transition event='say'/></state>"));
    assert_eq!(unasked, ["Arm, state s: <ok> answers nothing: Two is not waiting for an answer"]);
}

#[test]
fn a_goal_that_is_not_accepted_first_or_goes_on_after_its_end_is_a_mistake_of_the_machine() {
    let client = "<state id='s'><transition event='Arm'/><onentry>
        <send type='channel' target='Arm' event='pick.goal'><param name='n' expr='1'/></send></onentry></state>";
    let answers = |parts: &[&str]| {
        let sends = parts.iter().map(|part| {
            let param = if ["accepted", "canceled"].contains(part) { "" } else { "<param name='n' expr='1'/>" };
            format!("<send type='channel' targetexpr='_event.origin' event='pick.{part}'>{param}</send>")
        });
        let sends: String = sends.collect();
        let arm = format!("<state id='s'><transition event='pick.goal'>{sends}</transition></state>");
        let (mistakes, events) = mistakes(client, &arm);
        let ends = ["succeeded", "canceled"].map(|end| count(&events, &format!("Arm pick.{end} One")));
        let start = "Arm, state s: <pick.";
        let mistakes = mistakes.iter().map(|words| words.strip_prefix(start).unwrap_or(words).to_owned());
        (mistakes.collect::<Vec<_>>(), ends.iter().sum::<usize>() > 0)
    };
    let none = Vec::<String>::new();
    assert_eq!(answers(&["accepted", "feedback", "feedback", "succeeded"]), (none.clone(), true));
    assert_eq!(answers(&["accepted", "canceled"]), (none, true));
    let is_not = |part: &str| vec![format!("{part}> does not fit: the goal of One is not accepted")];
    assert_eq!(answers(&["succeeded"]), (is_not("succeeded"), false));
    assert_eq!(answers(&["canceled"]), (is_not("canceled"), false));
    assert_eq!(answers(&["feedback", "accepted", "succeeded"]), (is_not("feedback"), true));
    let again = vec!["accepted> does not fit: the goal of One is already accepted".to_owned()];
    assert_eq!(answers(&["accepted", "accepted", "succeeded"]), (again, true));
    let after = |part: &str| vec![format!("{part}> answers nothing: One is not waiting for an answer")];
    for part in ["feedback", "succeeded", "canceled"] {
        assert_eq!(answers(&["accepted", "succeeded", part]), (after(part), true));
    }
}

/// It may have ended just before.
#[test]
fn to_cancel_a_goal_that_has_ended_is_no_mistake() {
    for seed in 0..50 {
        let (_, system) = run([&picker(400), SILENT, ARM], seed);
        for name in ["One", "Arm"] {
            let process = system.topology().find_process(name).unwrap();
            assert_eq!(system.process::<SkillProcess>(process).unwrap().mishaps(), [], "{name}, seed {seed}");
        }
    }
}
