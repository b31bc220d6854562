//! Remote components, without ROS 2.

mod both_sides;

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Capacity, Domain, Envelope, Message, Process, RequestNumber, Topology, TransitionId, Value as Sent,
};
use interfaces::Interface;
use remote::{NodeMessage, RemoteComponent, RemoteProcess, ServiceRequest};
use ros_messages::CdrWriter;

const INTERFACE: &str = "
[services.mode]
ros = 'std_srvs/srv/SetBool.srv'
reply = ['success']

[topics.battery]
ros = 'sensor_msgs/msg/BatteryState.msg'
fields = { share = 'percentage' }

[actions.drive]
ros = 'my_msgs/action/Drive.action'
feedback = { left_m = 'left' }
";

const DRIVE: &str = "float64 x\nstring frame \"map\"\nuint8 gear\n---\nint32 code\n---\nfloat32 left\n";

fn interface() -> Interface {
    let read = |path: &Path| match path.to_str() {
        Some("i.toml") => Ok(INTERFACE.as_bytes().to_vec()),
        Some("my_msgs/action/Drive.action") => Ok(DRIVE.as_bytes().to_vec()),
        _ => Err(io::ErrorKind::NotFound.into()),
    };
    Interface::load(Path::new("i.toml"), &[], &read).expect("an interface")
}

/// The component `Base` in the namespace `/r1`, with the client `Skill`.
fn base() -> RemoteProcess {
    let interface = interface();
    let mut topology = Topology::default();
    let [base, skill] = ["Base", "Skill"].map(|name| topology.process(name).expect("a name"));
    topology.channel(skill, base, Capacity::One, Domain::new(interface.requests())).expect("a channel");
    topology.channel(base, skill, Capacity::One, Domain::new(interface.replies().expect("clear"))).expect("a channel");
    topology.publish(base, interface.topics[0].message());
    let component = RemoteComponent::new("/r1", &interface).expect("types");
    let mut process = RemoteProcess::new(&topology, base, Arc::new(component));
    process.begin(1);
    process
}

/// Sends a client's request to the process. Returns the service requests that it makes.
fn ask(process: &mut RemoteProcess, request: u64, fields: impl IntoIterator<Item = Sent>) -> Vec<ServiceRequest> {
    let envelope = Envelope { message: Message::new(fields), request: RequestNumber(request) };
    process.take(TransitionId(0), Some(envelope), Duration::ZERO);
    process.take_requests()
}

/// The process receives a response or message. Returns what it sends to its client then.
fn receive(process: &mut RemoteProcess, answer: NodeMessage) -> Vec<String> {
    process.receive(&answer);
    process.act();
    let mut replies = Vec::new();
    loop {
        let mut offers = Vec::new();
        process.offers(&mut offers);
        let next = offers.into_iter().find_map(|offer| match offer.action {
            Action::Send(_, envelope) => Some((offer.transition, envelope)),
            _ => None,
        });
        let Some((transition, envelope)) = next else { return replies };
        process.take(transition, None, Duration::ZERO);
        replies.push(envelope.message.to_string());
    }
}

fn mishaps(process: &RemoteProcess) -> Vec<&str> {
    process.mishaps().iter().map(|mishap| mishap.message.as_str()).collect()
}

fn message(write: impl FnOnce(&mut CdrWriter)) -> Vec<u8> {
    let mut body = CdrWriter::reusing(Vec::new());
    write(&mut body);
    body.bytes()
}

fn response(number: u64, write: impl FnOnce(&mut CdrWriter)) -> NodeMessage {
    NodeMessage::Response { number, body: message(write) }
}

fn goal(process: &mut RemoteProcess, request: u64) -> ServiceRequest {
    let fields = [Sent::symbol("drive.goal"), 2.5.into(), "odom".into(), Sent::Int(3)];
    ask(process, request, fields).pop().expect("it is sent")
}

#[test]
fn a_service_is_called_and_its_response_is_the_reply() {
    let mut process = base();
    assert_eq!(process.location(), "idle");
    let [request] = &ask(&mut process, 5, [Sent::symbol("mode"), true.into()])[..] else { panic!("one request") };
    assert_eq!((request.service.as_str(), request.kind.as_str()), ("/r1/mode", "std_srvs/srv/SetBool"));
    assert_eq!((request.body.as_slice(), process.location().as_str()), (&[0, 1, 0, 0, 1][..], "asked"));
    let answer = || {
        response(request.number, |body| {
            body.number([1]);
            body.text("done");
        })
    };
    assert_eq!(receive(&mut process, answer()), ["[<ok>, true]"]);
    // A second response is ignored, and so is one to a request of another process.
    assert!(receive(&mut process, answer()).is_empty());
    assert!(receive(&mut process, response(1 << 60, |_| {})).is_empty());
    assert!(mishaps(&process).is_empty());
    // A response of another type is an error.
    let request = &ask(&mut process, 6, [Sent::symbol("mode"), false.into()])[0];
    let replies = receive(&mut process, response(request.number, |body| body.number([2])));
    assert!(replies[0].starts_with("[<error>, \"the response cannot be read: "), "{replies:?}");
}

#[test]
fn a_goal_is_accepted_and_ends() {
    let mut process = base();
    let sent = goal(&mut process, 5);
    assert_eq!(sent.service, "/r1/drive/_action/send_goal");
    assert_eq!(sent.kind, "my_msgs/action/Drive_SendGoal");
    let id = &sent.body[4..20];
    assert_eq!(sent.body[20..28], 2.5_f64.to_le_bytes());
    let accepts = |body: &mut CdrWriter| {
        body.number([1]);
        body.numbers([[0; 4]; 2].into_iter());
    };
    assert_eq!(receive(&mut process, response(sent.number, accepts)), ["[<drive.accepted>]"]);
    let [asked] = &process.take_requests()[..] else { panic!("the result is requested") };
    assert_eq!((asked.service.as_str(), &asked.body[4..]), ("/r1/drive/_action/get_result", id));
    let mut feedback = |id: &[u8]| {
        let body = message(|body| {
            id.iter().for_each(|byte| body.number([*byte]));
            body.number(1.5_f32.to_le_bytes());
        });
        receive(&mut process, NodeMessage::Message { topic: "/r1/drive/_action/feedback".to_owned(), body })
    };
    assert_eq!(feedback(id), ["[<drive.feedback>, 1.5]"]);
    assert!(feedback(&[9; 16]).is_empty(), "another client's goal");
    let result = |status: i8| {
        move |body: &mut CdrWriter| {
            body.number(status.to_le_bytes());
            body.number(7_i32.to_le_bytes());
        }
    };
    assert_eq!(receive(&mut process, response(asked.number, result(4))), ["[<drive.succeeded>, 7]"]);

    for (status, reply) in [(5, "[<drive.canceled>]"), (6, "[<drive.aborted>, \"the server aborted the goal\"]")] {
        let sent = goal(&mut process, 6);
        assert_ne!(&sent.body[4..20], id, "each goal has an id of its own");
        receive(&mut process, response(sent.number, accepts));
        let asked = process.take_requests().pop().expect("the result is requested");
        assert_eq!(receive(&mut process, response(asked.number, result(status))), [reply]);
    }
    let sent = goal(&mut process, 7);
    let replies = receive(&mut process, response(sent.number, |body| body.number([0])));
    assert_eq!(replies, ["[<drive.rejected>, \"the server rejected the goal\"]"]);
    assert_eq!(process.location(), "idle");
}

#[test]
fn a_goal_is_canceled_once_it_has_been_accepted() {
    let mut process = base();
    let sent = goal(&mut process, 5);
    assert!(ask(&mut process, 5, [Sent::symbol("drive.cancel")]).is_empty(), "the server may not know it yet");
    receive(&mut process, response(sent.number, |body| body.number([1])));
    let requests = process.take_requests();
    let [canceled, asked] = &requests[..] else { panic!("two requests: {requests:?}") };
    assert_eq!((canceled.service.as_str(), canceled.body.len()), ("/r1/drive/_action/cancel_goal", 4 + 16 + 8));
    assert_eq!((canceled.kind.as_str(), &canceled.body[4..20]), ("action_msgs/srv/CancelGoal", &sent.body[4..20]));
    assert!(ask(&mut process, 5, [Sent::symbol("drive.cancel")]).is_empty(), "once is enough");
    receive(&mut process, response(canceled.number, |body| body.number([1])));
    assert_eq!(mishaps(&process), ["/r1/drive is not canceled: the server refused"]);
    // The client may cancel again. A restarted server has no goal.
    let again = &ask(&mut process, 5, [Sent::symbol("drive.cancel")])[0];
    let replies = receive(&mut process, response(again.number, |body| body.number([2])));
    assert_eq!(replies, ["[<drive.aborted>, \"the server does not know the goal\"]"]);
    process.restart();
    assert_eq!(process.location(), "idle");
    assert!(receive(&mut process, response(asked.number, |body| body.number([5]))).is_empty());
}

#[test]
fn a_client_that_sends_a_new_request_abandons_its_earlier_one() {
    let mut process = base();
    let first = ask(&mut process, 5, [Sent::symbol("mode"), true.into()]).remove(0);
    let second = ask(&mut process, 6, [Sent::symbol("mode"), false.into()]).remove(0);
    let yes = |body: &mut CdrWriter| {
        body.number([1]);
        body.text("");
    };
    assert!(receive(&mut process, response(first.number, yes)).is_empty());
    assert_eq!(receive(&mut process, response(second.number, yes)), ["[<ok>, true]"]);
    // An abandoned goal is canceled once the server has accepted it. The client does not receive how it ends.
    let first = goal(&mut process, 7);
    let second = goal(&mut process, 8);
    assert!(receive(&mut process, response(first.number, |body| body.number([1]))).is_empty());
    let services: Vec<String> = process.take_requests().into_iter().map(|request| request.service).collect();
    assert_eq!(services, ["/r1/drive/_action/cancel_goal", "/r1/drive/_action/get_result"]);
    assert_eq!(receive(&mut process, response(second.number, |body| body.number([1]))), ["[<drive.accepted>]"]);
    // At the end of a run, all goals are canceled.
    process.take_requests();
    process.conclude();
    assert_eq!(process.take_requests()[0].body[4..20], second.body[4..20]);
    // A goal whose acceptance was lost may be pursued. If it is not, the server does not know it.
    let sent = goal(&mut process, 9);
    assert!(!sent.is_repeatable());
    assert_eq!(receive(&mut process, sent.presumed()), ["[<drive.accepted>]"]);
    let asked = process.take_requests().pop().expect("the result is requested");
    let canceled = ask(&mut process, 9, [Sent::symbol("drive.cancel")]).pop().expect("it is canceled");
    assert!(asked.is_repeatable() && canceled.is_repeatable());
    let replies = receive(&mut process, response(asked.number, |body| body.number([0])));
    assert_eq!(replies, ["[<drive.aborted>, \"the server does not know the goal\"]"]);
    // Without a server, a goal fails.
    let request = goal(&mut process, 9);
    let no_response = NodeMessage::Response { number: request.number, body: Vec::new() };
    assert_eq!(receive(&mut process, no_response), ["[<drive.rejected>, \"nobody offers it\"]"]);
}

#[test]
fn values_that_do_not_fit_are_refused() {
    let mut process = base();
    let fields = [Sent::symbol("drive.goal"), 2.5.into(), "odom".into(), Sent::Int(300)];
    assert!(ask(&mut process, 5, fields).is_empty());
    let nothing = NodeMessage::Message { topic: "/elsewhere".to_owned(), body: Vec::new() };
    assert_eq!(
        receive(&mut process, nothing),
        ["[<drive.rejected>, \"it cannot be sent: a value does not fit its field\"]"]
    );
    let level = |share: f32| {
        let body = message(|body| {
            body.numbers([[0; 4]; 2].into_iter());
            body.text("");
            body.numbers([[0; 4]; 6].into_iter());
            body.number(share.to_le_bytes());
            body.numbers([[0], [0], [0], [1]].into_iter());
            (0..2).for_each(|_| body.length(0));
            (0..2).for_each(|_| body.text(""));
        });
        NodeMessage::Message { topic: "/r1/battery".to_owned(), body }
    };
    assert!(receive(&mut process, level(f32::NAN)).is_empty());
    assert!(mishaps(&process)[0].contains("`share` has a value that a machine cannot have"), "{:?}", mishaps(&process));
    assert!(receive(&mut process, level(f32::NAN)).is_empty());
    assert_eq!((process.mishaps().len(), process.mishaps()[0].times), (1, 2));
    // Of the queued messages on a topic, the newest counts.
    process.receive(&level(0.5));
    assert_eq!(receive(&mut process, level(0.25)), ["[<battery>, 0.25]"]);

    let text = "[services.say]\nrequest = { text = 'text' }\n";
    let read = |_: &Path| Ok(text.as_bytes().to_vec());
    let ours = Interface::load(Path::new("i.toml"), &[], &read).expect("an interface");
    let why = RemoteComponent::new("/", &ours).expect_err("it has no types");
    let unknown = "the type of `say` in ROS 2 is not known: its fields are not those of a definition of ROS 2";
    assert_eq!(why, [unknown]);
}
