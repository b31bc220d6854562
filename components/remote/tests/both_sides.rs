//! Both sides of a component over ROS 2: a client's request on one side reaches the other, and the reply comes back.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Capacity, ChannelId, Domain, Envelope, Message, Process, RequestNumber, Topology, TransitionId, Value,
};
use interfaces::Interface;
use remote::{NodeMessage, RemoteClients, RemoteComponent, RemoteProcess, ServiceRequest, action};

const INTERFACE: &str = "
[services.open]
ros = 'std_srvs/srv/Trigger.srv'
reply = []

[services.get_state]
ros = 'std_srvs/srv/Trigger.srv'
reply = { state = { path = 'message', symbols = ['open', 'closed'] } }

[services.lock]
ros = 'std_srvs/srv/SetBool.srv'

[services.reset]
ros = 'std_srvs/srv/Empty.srv'

[topics.moved]
ros = 'std_msgs/msg/String.msg'
fields = { state = { path = 'data', symbols = ['open', 'closed'] } }

[actions.turn]
ros = 'my_msgs/action/Turn.action'
";

const TURN: &str = "float64 by_rad\n---\nint32 turns\nfloat64 turned_rad\n---\nfloat32 left_rad\n";

fn interface() -> Interface {
    let read = |path: &Path| match path.to_str() {
        Some("i.toml") => Ok(INTERFACE.as_bytes().to_vec()),
        Some("my_msgs/action/Turn.action") => Ok(TURN.as_bytes().to_vec()),
        _ => Err(io::ErrorKind::NotFound.into()),
    };
    Interface::load(Path::new("i.toml"), &[], &read).expect("an interface")
}

/// Two systems: in one, `Skill` is a client of the remote component `Door`; in the other, `ROS` is a client of `Door`.
struct Sides {
    component: RemoteProcess,
    clients: RemoteClients,
    topology: Topology,
    now: Duration,
}

impl Sides {
    fn new() -> Self {
        let (interface, mut topology) = (interface(), Topology::default());
        let [door, skill, ros] = ["Door", "Skill", "ROS"].map(|name| topology.process(name).expect("a name"));
        for client in [skill, ros] {
            topology.channel(client, door, Capacity::One, Domain::new(interface.requests())).expect("a channel");
            let replies = Domain::new(interface.replies().expect("clear"));
            topology.channel(door, client, Capacity::One, replies).expect("a channel");
        }
        topology.publish(door, interface.topics[0].message());
        let known = RemoteComponent::new("/Door", &interface).expect("types");
        let offered = [("Door".to_owned(), known.clone())];
        let mut component = RemoteProcess::new(&topology, door, Arc::new(known));
        component.begin(1);
        let mut clients = RemoteClients::new(&topology, ros, offered.into());
        // The action has no goals yet.
        assert!(matches!(&clients.take_outbox()[..], [NodeMessage::Message { .. }]));
        Self { component, clients, topology, now: Duration::from_secs(3) }
    }

    /// The messages that a process sends on a channel.
    fn sent(process: &mut dyn Process, on: ChannelId) -> Vec<Envelope> {
        let mut sent = Vec::new();
        loop {
            let mut offers = Vec::new();
            process.offers(&mut offers);
            let next = offers.into_iter().find_map(|offer| match offer.action {
                Action::Send(channel, envelope) => Some((offer.transition, channel, envelope)),
                _ => None,
            });
            let Some((transition, channel, envelope)) = next else { return sent };
            process.take(transition, None, Duration::ZERO);
            sent.extend((channel == on).then_some(envelope));
        }
    }

    fn channel(&self, from: &str, to: &str) -> ChannelId {
        self.topology.find_channel(from, to).expect("a channel")
    }

    /// The skill sends its request with this number. Returns the requests that reach the component.
    fn ask(&mut self, request: u64, fields: impl IntoIterator<Item = Value>) -> Vec<Envelope> {
        let envelope = Envelope { message: Message::new(fields), request: RequestNumber(request) };
        // The skill's channel comes first.
        self.component.take(TransitionId(0), Some(envelope), self.now);
        self.carry();
        self.sent_to_door()
    }

    /// The requests that reach the component.
    fn sent_to_door(&mut self) -> Vec<Envelope> {
        let channel = self.channel("ROS", "Door");
        Self::sent(&mut self.clients, channel)
    }

    /// Carries requests and messages between the sides until there are none.
    fn carry(&mut self) {
        loop {
            let requests = self.component.take_requests();
            requests.iter().for_each(|request| self.clients.receive(request));
            let sent = self.clients.take_outbox();
            let is_quiet = requests.is_empty() && sent.is_empty();
            sent.iter().for_each(|message| self.component.receive(message));
            self.component.act();
            if is_quiet {
                return;
            }
        }
    }

    /// The component replies to the request with this number. Returns what the skill receives.
    fn answer(&mut self, request: RequestNumber, fields: impl IntoIterator<Item = Value>) -> Vec<String> {
        let envelope = Envelope { message: Message::new(fields), request };
        self.clients.take(TransitionId(0), Some(envelope), self.now);
        self.carry();
        let channel = self.channel("Door", "Skill");
        let received = Self::sent(&mut self.component, channel);
        received.iter().map(|envelope| envelope.message.to_string()).collect()
    }
}

fn messages(sent: &[Envelope]) -> Vec<String> {
    sent.iter().map(|envelope| envelope.message.to_string()).collect()
}

fn symbol(name: &str) -> Value {
    Value::symbol(name)
}

#[test]
fn requests_reach_the_other_side_and_replies_come_back() {
    let mut sides = Sides::new();
    for (number, asked, answered) in [
        (1, vec![symbol("open")], vec![symbol("ok")]),
        (2, vec![symbol("open")], vec![symbol("error"), "stuck".into()]),
        (3, vec![symbol("get_state")], vec![symbol("ok"), symbol("closed")]),
        (4, vec![symbol("get_state")], vec![symbol("error"), "blind".into()]),
        (5, vec![symbol("lock"), true.into()], vec![symbol("ok"), false.into(), "no key".into()]),
        (6, vec![symbol("reset")], vec![symbol("ok")]),
    ] {
        let sent = sides.ask(number, asked.clone());
        assert_eq!(messages(&sent), [Message::new(asked).to_string()]);
        assert_eq!(sides.answer(sent[0].request, answered.clone()), [Message::new(answered).to_string()]);
    }
    let moved = [symbol("moved"), symbol("open")];
    assert_eq!(sides.answer(RequestNumber::default(), moved.clone()), [Message::new(moved).to_string()]);
    assert!(sides.clients.take_notes().is_empty() && sides.component.mishaps().is_empty());
}

#[test]
fn a_failure_that_a_response_cannot_express_is_noted_and_gets_no_response() {
    let mut sides = Sides::new();
    let sent = sides.ask(1, [symbol("reset")]);
    assert!(sides.answer(sent[0].request, [symbol("error"), "locked".into()]).is_empty());
    let note = "a request to /Door/reset failed, and is not answered: a std_srvs/srv/Empty cannot express that";
    assert_eq!(sides.clients.take_notes(), [note]);
    // If the outcome is a field of the reply, there is a response all the same.
    let sent = sides.ask(2, [symbol("lock"), true.into()]);
    let received = sides.answer(sent[0].request, [symbol("error"), "locked".into()]);
    assert_eq!(received, [r#"[<ok>, false, "locked"]"#]);
    assert!(sides.clients.take_notes().is_empty());
}

#[test]
fn several_requests_wait_for_a_component_and_each_gets_its_response() {
    let mut sides = Sides::new();
    let request = |number: u64, service: &str, body: &[u8]| ServiceRequest {
        service: format!("/Door/{service}"),
        kind: String::new(),
        number,
        body: [&[0, 1, 0, 0], body].concat(),
    };
    sides.clients.receive(&request(7, "open", &[0]));
    sides.clients.receive(&request(8, "open", &[0]));
    sides.clients.receive(&request(9, "lock", &[]));
    sides.clients.receive(&request(10, "other", &[0]));
    let sent = sides.sent_to_door();
    assert_eq!(messages(&sent), ["[<open>]", "[<open>]"]);
    // A request that cannot be read is refused at once.
    let [NodeMessage::Response { number: 9, body }] = &sides.clients.take_outbox()[..] else { panic!("a response") };
    assert_eq!((body[4], sides.clients.location().as_str()), (0, "asks"));
    // The first request has no reply yet, as if the component had lost it.
    let reply = |request| Some(Envelope { message: Message::new([symbol("ok")]), request });
    sides.clients.take(TransitionId(0), reply(sent[1].request), Duration::ZERO);
    let [NodeMessage::Response { number: 8, body }] = &sides.clients.take_outbox()[..] else { panic!("a response") };
    assert_eq!(body[4], 1);
    sides.clients.take(TransitionId(0), reply(sent[1].request), Duration::ZERO);
    assert!(sides.clients.take_outbox().is_empty());
    sides.clients.take(TransitionId(0), reply(sent[0].request), Duration::ZERO);
    assert!(matches!(sides.clients.take_outbox()[..], [NodeMessage::Response { number: 7, .. }]));
    assert_eq!(sides.clients.location(), "idle");
}

#[test]
fn a_goal_on_one_side_is_one_on_the_other_until_it_ends() {
    let goal = |by_rad: f64| [symbol("turn.goal"), by_rad.into()];
    for (end, received) in [
        (vec![symbol("turn.succeeded"), Value::Int(2), 1.5.into()], "[<turn.succeeded>, 2, 1.5]"),
        (vec![symbol("turn.aborted"), "stuck".into()], r#"[<turn.aborted>, "the server aborted the goal"]"#),
        (vec![symbol("turn.canceled")], "[<turn.canceled>]"),
    ] {
        let mut sides = Sides::new();
        let sent = sides.ask(1, goal(3.0));
        assert_eq!(messages(&sent), ["[<turn.goal>, 3.0]"]);
        let request = sent[0].request;
        assert_eq!(sides.answer(request, [symbol("turn.accepted")]), ["[<turn.accepted>]"]);
        let feedback = [symbol("turn.feedback"), 0.5.into()];
        assert_eq!(sides.answer(request, feedback), ["[<turn.feedback>, 0.5]"]);
        assert_eq!(sides.answer(request, end), [received]);
    }
    let mut sides = Sides::new();
    let sent = sides.ask(1, goal(3.0));
    let received = sides.answer(sent[0].request, [symbol("turn.rejected"), "no".into()]);
    assert_eq!(received, [r#"[<turn.rejected>, "the server rejected the goal"]"#]);
    // Feedback and results that cannot be sent are sent without their fields.
    let sent = sides.ask(2, goal(4.0));
    sides.answer(sent[0].request, [symbol("turn.accepted")]);
    let large = [symbol("turn.succeeded"), Value::Int(1 << 40), 1.5.into()];
    assert_eq!(sides.answer(sent[0].request, large), ["[<turn.succeeded>, 0, 0.0]"]);
    let [note] = &sides.clients.take_notes()[..] else { panic!("a note") };
    assert!(note.starts_with("fields of <turn.succeeded> are left out: "), "{note}");
}

#[test]
fn a_goal_is_canceled_by_its_client_or_by_the_next_one() {
    let mut sides = Sides::new();
    let first = sides.ask(1, [symbol("turn.goal"), 3.0.into()]);
    sides.answer(first[0].request, [symbol("turn.accepted")]);
    let canceled = sides.ask(1, [symbol("turn.cancel")]);
    assert_eq!((messages(&canceled), canceled[0].request), (vec!["[<turn.cancel>]".to_owned()], first[0].request));
    assert_eq!(sides.answer(first[0].request, [symbol("turn.canceled")]), ["[<turn.canceled>]"]);

    // Another node sends goals while the last one is pursued.
    let second = sides.ask(2, [symbol("turn.goal"), 4.0.into()]);
    sides.answer(second[0].request, [symbol("turn.accepted")]);
    let other = |id: u8| ServiceRequest {
        service: action::service("/Door/turn", action::SEND_GOAL),
        kind: String::new(),
        number: id.into(),
        body: [&[0, 1, 0, 0], &[id; 16][..], &5.0_f64.to_le_bytes()].concat(),
    };
    sides.clients.receive(&other(90));
    sides.clients.receive(&other(91));
    let sent = sides.sent_to_door();
    let expected = ["[<turn.cancel>]", "[<turn.goal>, 5.0]", "[<turn.cancel>]", "[<turn.goal>, 5.0]"];
    assert_eq!(messages(&sent), expected);
    let numbers: Vec<u64> = sent.iter().map(|envelope| envelope.request.0).collect();
    assert_eq!(numbers[..3], [second[0].request.0, numbers[1], numbers[1]]);
    // The component has lost the first of them and pursues the second.
    let received = sides.answer(sent[3].request, [symbol("turn.accepted")]);
    assert_eq!(received, [r#"[<turn.aborted>, "the server aborted the goal"]"#]);
    assert!(sides.answer(second[0].request, [symbol("turn.canceled")]).is_empty());
    assert_eq!(sides.clients.location(), "asks");
    sides.answer(sent[3].request, [symbol("turn.succeeded"), Value::Int(0), 5.0.into()]);
    assert_eq!(sides.clients.location(), "idle");
}
