//! Devices among others that ask and one that listens, in surroundings that are only numbers.

use std::cell::RefCell;
use std::time::Duration;

use channels::{Action, Capacity, Domain, Envelope, Message, Offer, Process, RequestNumber, Topology, Value};
use interfaces::Operation;

use super::*;

/// What a device may sense and move.
#[derive(Default)]
struct FakeSurroundings {
    door_opening: Option<f64>,
    doors_moved: Vec<(String, bool)>,
    people_m: Vec<f64>,
    people_asked_for: RefCell<Vec<String>>,
    /// The box on the floor, and its distance from the robot's edge.
    floor: Option<(&'static str, f64)>,
    has_no_room: bool,
    dropped: Vec<String>,
}

impl Surroundings for FakeSurroundings {
    fn door_opening(&self, _: &str) -> Option<f64> {
        self.door_opening
    }

    fn move_door(&mut self, door: &str, open: bool) {
        self.doors_moved.push((door.to_owned(), open));
    }

    fn people_in_view(&self, names: &[String]) -> Vec<f64> {
        self.people_asked_for.replace(names.to_vec());
        self.people_m.clone()
    }

    fn take_box(&mut self, reach_m: f64) -> Option<String> {
        let (name, _) = self.floor.take_if(|(_, distance_m)| *distance_m <= reach_m)?;
        Some(name.to_owned())
    }

    fn put_down(&mut self, _: &str) -> bool {
        !self.has_no_room
    }

    fn drop_box(&mut self, name: &str) -> bool {
        self.dropped.extend((!self.has_no_room).then(|| name.to_owned()));
        !self.has_no_room
    }
}

/// A device, a skill and a host that use its services, and a log that subscribes to its topics.
struct Scene {
    topology: Topology,
    device: DeviceProcess,
    world: FakeSurroundings,
    requests: u64,
    now: Duration,
}

impl Scene {
    fn new(settings: &DeviceSettings, world: FakeSurroundings) -> Self {
        let interface = settings.kind().interface();
        let mut topology = Topology::default();
        let [device, skill, host, log] =
            ["Device", "Skill", "Host", "Log"].map(|name| topology.process(name).expect("a new name"));
        interface.topics.iter().for_each(|topic| topology.publish(device, topic.message()));
        let is_topic = |operation: Operation<'_>| matches!(operation, Operation::Topic(_));
        for (client, part) in [
            (skill, interface.restricted_to(|operation| !is_topic(operation))),
            (host, interface.restricted_to(|operation| !is_topic(operation))),
            (log, interface.restricted_to(is_topic)),
        ] {
            let (requests, replies) = (part.requests(), part.replies().expect("replies can be told apart"));
            for (from, to, shapes) in [(client, device, requests), (device, client, replies)] {
                if !shapes.is_empty() {
                    topology.channel(from, to, Capacity::One, Domain::new(shapes)).expect("a new channel");
                }
            }
        }
        let device = DeviceProcess::new(&topology, device, settings);
        Self { topology, device, world, requests: 0, now: Duration::ZERO }
    }

    fn offers(&self) -> Vec<Offer> {
        let mut offers = Vec::new();
        self.device.offers(&mut offers);
        offers
    }

    /// Takes everything that the device sends, each as the receiver with the message.
    fn sent(&mut self) -> Vec<String> {
        let mut sent = Vec::new();
        loop {
            let next = self.offers().into_iter().find_map(|offer| match offer.action {
                Action::Send(channel, envelope) => Some((offer.transition, channel, envelope)),
                _ => None,
            });
            let Some((transition, channel, envelope)) = next else { return sent };
            self.device.take(transition, None, self.now);
            sent.push(format!("{}: {}", self.topology.ends(channel).1, envelope.message));
        }
    }

    /// Lets a client send a request.
    fn request(&mut self, client: &str, request: &str, text: Option<&str>) {
        self.requests += 1;
        let fields = std::iter::once(Value::symbol(request)).chain(text.map(Value::from));
        let envelope = Envelope { message: Message::new(fields), request: RequestNumber(self.requests) };
        let receives = |offer: &Offer| match offer.action {
            Action::Receive(channel, _) => self.topology.ends(channel).0 == client,
            _ => false,
        };
        let transition = self.offers().into_iter().find(receives).expect("a device always listens").transition;
        self.device.take(transition, Some(envelope), self.now);
    }

    /// Lets the skill send a request; returns what the device sends at once.
    fn ask(&mut self, request: &str) -> Vec<String> {
        self.request("Skill", request, None);
        self.sent()
    }

    /// Lets the device act once; returns what it sends.
    fn act(&mut self) -> Vec<String> {
        self.device.act(&mut self.world);
        self.sent()
    }

    /// Advances to this time; returns what the device sends.
    fn at(&mut self, s: f64) -> Vec<String> {
        self.now = Duration::from_secs_f64(s);
        if self.device.next_timer().is_some_and(|due| due <= self.now) {
            self.device.fire_timers(self.now);
        }
        self.sent()
    }

    fn restart(&mut self) {
        self.device.restart(self.now);
    }

    fn impair(&mut self, is_impaired: bool) {
        self.device.impair(is_impaired, self.now);
    }
}

const NOTHING: [&str; 0] = [];

#[test]
fn a_door_answers_at_once_moves_at_the_next_step_and_publishes_changes() {
    let closed = FakeSurroundings { door_opening: Some(0.0), ..FakeSurroundings::default() };
    let mut scene = Scene::new(&DeviceSettings::Door { door: "gate".to_owned() }, closed);
    assert_eq!(scene.act(), NOTHING, "its first state is not a change");
    assert_eq!(scene.ask("open"), ["Skill: [<ok>]"]);
    assert_eq!(scene.world.doors_moved, []);
    scene.act();
    scene.act();
    assert_eq!(scene.world.doors_moved, [("gate".to_owned(), true)], "once");
    for (opening, state) in [(0.5, "moving"), (1.0, "open"), (0.1, "moving"), (0.0, "closed")] {
        scene.world.door_opening = Some(opening);
        assert_eq!(scene.act(), [format!("Log: [<moved>, <{state}>]")]);
        assert_eq!(scene.act(), NOTHING);
        assert_eq!(scene.ask("get_state"), [format!("Skill: [<ok>, <{state}>]")]);
        assert_eq!(scene.device.location(), state);
    }
    scene.ask("close");
    scene.restart();
    scene.act();
    assert_eq!(scene.world.doors_moved.len(), 1, "a restart forgets what was requested");
}

#[test]
fn a_people_sensor_counts_those_in_range_and_is_blind_when_impaired() {
    let settings = DeviceSettings::People { within_m: 3.0, only: vec!["Ann".to_owned()] };
    let mut scene = Scene::new(&settings, FakeSurroundings::default());
    assert_eq!(scene.act(), NOTHING);
    assert_eq!(*scene.world.people_asked_for.borrow(), ["Ann"]);
    assert_eq!(scene.ask("get_people"), ["Skill: [<ok>, 0, 3.0]"], "nobody: its range");
    scene.world.people_m = vec![2.0, 0.9, 3.0, 3.1];
    assert_eq!(scene.act(), ["Log: [<counted>, 3]"]);
    assert_eq!(scene.ask("get_people"), ["Skill: [<ok>, 3, 0.9]"]);
    scene.world.people_m = vec![2.5, 1.5, 1.0];
    assert_eq!(scene.act(), NOTHING, "their number is the same");
    scene.impair(true);
    assert_eq!(scene.act(), ["Log: [<counted>, 0]"]);
    scene.impair(false);
    assert_eq!(scene.act(), ["Log: [<counted>, 3]"]);
    scene.restart();
    assert_eq!(scene.ask("get_people"), ["Skill: [<ok>, 0, 3.0]"]);
}

#[test]
fn a_speaker_answers_when_it_has_spoken_the_text_and_speaks_one_at_a_time() {
    let mut scene = Scene::new(&DeviceSettings::Speaker { letters_per_s: 10.0 }, FakeSurroundings::default());
    scene.at(1.0);
    scene.request("Skill", "say", Some("hello"));
    assert_eq!((scene.sent(), scene.device.location().as_str()), (vec![], "speaking"));
    assert_eq!(scene.device.speech(), Some((Duration::from_secs(1), "hello")));
    scene.request("Host", "say", Some("bye"));
    assert_eq!(scene.sent(), ["Host: [<error>, \"busy\"]"]);
    assert_eq!(scene.device.next_timer(), Some(Duration::from_millis(1500)));
    assert_eq!(scene.at(1.5), ["Skill: [<ok>]", "Log: [<spoken>, \"hello\"]"]);
    assert_eq!((scene.device.speech(), scene.device.location().as_str()), (None, "silent"));

    scene.impair(true);
    scene.request("Skill", "say", Some("hello"));
    assert_eq!(scene.device.speech(), None, "a mute speaker cannot be heard");
    assert_eq!(scene.at(2.0), ["Skill: [<ok>]"], "but reports success");

    scene.impair(false);
    scene.request("Skill", "say", Some("hello"));
    scene.restart();
    assert_eq!((scene.device.next_timer(), scene.at(9.0)), (None, vec![]), "a restart forgets the text");
}

#[test]
fn a_button_was_pressed_or_not_since_the_last_request() {
    let pressed = [4.5, 2.0, 2.1].map(Duration::from_secs_f64).to_vec();
    let mut scene = Scene::new(&DeviceSettings::Button { pressed }, FakeSurroundings::default());
    assert_eq!(scene.ask("get_press"), ["Skill: [<ok>, false]"]);
    assert_eq!(scene.at(2.0), ["Log: [<pressed>]"]);
    assert_eq!(scene.at(2.1), ["Log: [<pressed>]"]);
    assert_eq!(scene.ask("get_press"), ["Skill: [<ok>, true]"]);
    assert_eq!(scene.ask("get_press"), ["Skill: [<ok>, false]"]);
    scene.at(4.5);
    scene.restart();
    assert_eq!(scene.ask("get_press"), ["Skill: [<ok>, false]"], "a restart forgets it");
}

#[test]
fn a_microphone_returns_one_request_after_the_other() {
    let hears = [(2.0, "hello"), (8.5, "to the exit")].map(|(s, text)| (Duration::from_secs_f64(s), text.to_owned()));
    let mut scene = Scene::new(&DeviceSettings::Microphone { hears: hears.to_vec() }, FakeSurroundings::default());
    assert_eq!(scene.ask("get_request"), ["Skill: [<ok>, \"\"]"]);
    assert_eq!(scene.at(9.0), ["Log: [<heard>, \"to the exit\"]"], "a topic keeps only its latest message");
    assert_eq!(scene.ask("get_request"), ["Skill: [<ok>, \"hello\"]"]);
    assert_eq!(scene.device.location(), "heard: to the exit");
    assert_eq!(scene.ask("get_request"), ["Skill: [<ok>, \"to the exit\"]"]);
    assert_eq!(scene.ask("get_request"), ["Skill: [<ok>, \"\"]"]);
}

#[test]
fn a_deaf_device_never_notices_what_came_meanwhile() {
    let pressed = |s: f64| DeviceSettings::Button { pressed: vec![Duration::from_secs_f64(s)] };
    let hears = |s: f64| DeviceSettings::Microphone { hears: vec![(Duration::from_secs_f64(s), "hello".to_owned())] };
    for (settings, request, is_noticed) in [
        (pressed(2.0), "get_press", "Skill: [<ok>, false]"),
        (pressed(4.5), "get_press", "Skill: [<ok>, true]"),
        (hears(2.0), "get_request", "Skill: [<ok>, \"\"]"),
        (hears(4.5), "get_request", "Skill: [<ok>, \"hello\"]"),
    ] {
        // The second time it also hangs, so that its timers fire only when it detects again.
        for hangs in [false, true] {
            let mut scene = Scene::new(&settings, FakeSurroundings::default());
            scene.at(1.0);
            scene.impair(true);
            if hangs {
                scene.now = Duration::from_secs(3);
            } else {
                scene.at(3.0);
            }
            scene.impair(false);
            scene.at(5.0);
            assert_eq!(scene.ask(request), [is_noticed], "{settings:?}, {hangs}");
        }
    }
    let mut scene = Scene::new(&pressed(2.0), FakeSurroundings::default());
    scene.now = Duration::from_secs(3);
    scene.restart();
    assert_eq!(scene.device.next_timer(), None, "what came while it was down is lost");
}

#[test]
fn a_tray_carries_one_box() {
    let world = FakeSurroundings { floor: Some(("parcel", 0.3)), ..FakeSurroundings::default() };
    let mut scene = Scene::new(&DeviceSettings::Tray { reach_m: 0.5 }, world);
    assert_eq!(scene.ask("get_load"), ["Skill: [<ok>, \"\"]"]);
    assert_eq!(scene.ask("take"), NOTHING, "at the next step");
    assert_eq!(scene.act(), ["Skill: [<ok>, \"parcel\"]"]);
    assert_eq!(scene.ask("get_load"), ["Skill: [<ok>, \"parcel\"]"]);
    assert_eq!(scene.device.location(), "carries parcel");
    scene.ask("take");
    assert_eq!(scene.act(), ["Skill: [<error>, \"there is already a box on the tray\"]"]);
    scene.restart();
    scene.world.has_no_room = true;
    scene.ask("put");
    assert_eq!(scene.act(), ["Skill: [<error>, \"there is no room for the box\"]"]);
    scene.world.has_no_room = false;
    scene.ask("put");
    assert_eq!(scene.act(), ["Skill: [<ok>, \"parcel\"]"], "a restart leaves the box on the tray");
    scene.ask("put");
    assert_eq!(scene.act(), ["Skill: [<error>, \"there is no box\"]"]);
    scene.world.floor = Some(("parcel", 0.6));
    scene.ask("take");
    assert_eq!(scene.act(), ["Skill: [<error>, \"there is no box in reach\"]"]);
    scene.ask("take");
    scene.restart();
    scene.world.floor = Some(("parcel", 0.1));
    assert_eq!(scene.act(), NOTHING, "a restart forgets what was requested");
}

#[test]
fn a_box_that_falls_from_a_tray_is_missed_when_it_is_to_be_put_down() {
    let world = FakeSurroundings { floor: Some(("parcel", 0.3)), ..FakeSurroundings::default() };
    let mut scene = Scene::new(&DeviceSettings::Tray { reach_m: 0.5 }, world);
    assert_eq!(scene.device.drop_box(&mut scene.world), Err("there is no box on the tray"));
    scene.ask("take");
    scene.act();
    scene.world.has_no_room = true;
    assert_eq!(scene.device.drop_box(&mut scene.world), Err("there is no room for the box"));
    scene.world.has_no_room = false;
    assert_eq!(scene.device.drop_box(&mut scene.world), Ok(()));
    assert_eq!(scene.world.dropped, ["parcel"]);
    assert_eq!(scene.device.drop_box(&mut scene.world), Err("there is no box on the tray"));
    assert_eq!(scene.ask("get_load"), ["Skill: [<ok>, \"parcel\"]"], "it does not notice");
    scene.ask("put");
    assert_eq!(scene.act(), ["Skill: [<error>, \"the box is gone\"]"]);
    assert_eq!(scene.ask("get_load"), ["Skill: [<ok>, \"\"]"]);
    let mut button = Scene::new(&DeviceSettings::Button { pressed: Vec::new() }, FakeSurroundings::default());
    assert_eq!(button.device.drop_box(&mut button.world), Err("it is not a tray"));
}

#[test]
fn interfaces_of_all_kinds_can_be_read() {
    for kind in DeviceKind::ALL {
        let interface = kind.interface();
        assert!(!interface.services.is_empty() && interface.replies().is_ok(), "{}", kind.name());
        let wires = interface.services.iter().map(|of| &of.wire).chain(interface.topics.iter().map(|of| &of.wire));
        assert!(wires.clone().all(Result::is_ok), "{:?}", wires.collect::<Vec<_>>());
    }
}
