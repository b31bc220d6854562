//! The shipped system without a robot, with a program graph for Navigation's driver.

use std::sync::Arc;
use std::time::Duration;

use bt::{Loader, Tree, TreeProcess};
use channels::{
    Action, Capacity, ChannelId, ChannelSystem, Domain, Envelope, FieldKind, GraphProcess, Message, NoNormalForm,
    NormalForm, Offer, Pattern, Process, ProcessId, ProgramGraph, RequestNumber, Shape, TickGenerator, Topology,
    TransitionId, Use,
};
use components::{
    BATTERY_READER, BLACKBOARD, BatteryReader, Blackboard, LOCALIZATION, Localization, NAVIGATION, Navigation,
    Operation, Order, StopRule, TripStatus, operations,
};
use maps::{Place, Places, Point};
use robot::BatteryState;
use skills::{Chart, SkillProcess};

use super::exploration::{States, reachable};

const DRIVER: &str = "Driver";
const PLACES: [&str; 2] = ["Destination", "RechargingStation"];

/// The rules by which the skills communicate with the tree, and with Navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Protocol {
    Shipped,
    /// The protocol of the paper's published system.
    Original,
    /// The same, but Navigation ends a trip only at the request of the skill that started it.
    OwnTrips,
    /// The published protocol with a mistake: a skill that is stopped on the way releases the resource before it halts
    /// navigation.
    EarlyRelease,
}

impl Protocol {
    fn machine(self, leaf: &str, shipped: &str) -> String {
        let original = || skills::ORIGINAL.iter().find(|(other, _)| *other == leaf).map_or(shipped, |(_, text)| text);
        match self {
            Self::Shipped => shipped.to_owned(),
            Self::Original | Self::OwnTrips => original().to_owned(),
            // The first three are after starting a trip, asking about it and waiting; the states of a finished trip
            // come later.
            Self::EarlyRelease => original().replacen("target=\"halted\"", "target=\"internal_lockKey\"", 3),
        }
    }

    fn stops(self) -> StopRule {
        match self {
            Self::Shipped | Self::OwnTrips => StopRule::OwnTrip,
            Self::Original | Self::EarlyRelease => StopRule::AnyTrip,
        }
    }
}

/// The driver's possible reports on a trip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Trips {
    /// Nothing: the robot is on its way.
    Endless,
    /// At any moment, that the robot has arrived or will not arrive.
    Ending,
}

/// Whether the tree is one process or one process per node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum TreeForm {
    Whole,
    Nodes,
}

/// Tree, skills, components and driver.
pub(crate) struct Model {
    system: ChannelSystem,
}

impl Model {
    pub(crate) fn new(protocol: Protocol, form: TreeForm, trips: Trips) -> Self {
        let tree = Arc::new(
            Loader::default().load("recharge.xml", include_str!("../../../../bt/trees/recharge.xml")).unwrap(),
        );
        let charts = charts(protocol);
        let mut topology = Topology::default();
        let [ticks, bt] = ["TickGenerator", "BT"].map(|name| topology.process(name).unwrap());
        for (name, _) in &charts {
            topology.process(name).unwrap();
        }
        bt::declare_channels(&tree, &mut topology, bt, ticks).unwrap();
        let mut processes = components(protocol, trips, &charts, &mut topology);
        processes.extend(tree_processes(&tree, form, &mut topology, bt));
        let topology = Arc::new(topology);
        let tick_channel = topology.find_channel("TickGenerator", "BT").unwrap();
        processes.push((ticks, Box::new(TickGenerator::new(tick_channel))));
        for (name, chart) in &charts {
            let skill = SkillProcess::new(name, chart, &topology, []).unwrap();
            processes.push((topology.find_process(name).unwrap(), Box::new(skill)));
        }
        Self { system: ChannelSystem::new(topology, processes).unwrap() }
    }

    /// The states at the end of the first second, in which the robot sets out for the destination.
    pub(crate) fn first_second(&self) -> States {
        self.second(0, &States::from_iter([self.system.fork()]), 80.0)
    }

    /// The states a second after these in which only the driver can still move; the second begins with a tick and a
    /// battery of that level. As in a run, time passes when nothing else can move.
    pub(crate) fn second(&self, number: u64, before: &States, charge_pct: f64) -> States {
        let pass = |state: &ChannelSystem, tenth: u64| {
            let mut state = state.fork();
            state.advance(Duration::from_millis(1000 * number + 100 * tenth));
            state
        };
        let ticked = before.iter().map(|state| self.tick(pass(state, 0), charge_pct));
        let mut states = reachable(ticked);
        for tenth in 1..10 {
            states = reachable(states.iter().filter(|state| self.is_quiet(state)).map(|state| pass(state, tenth)));
        }
        states.iter().filter(|state| self.is_quiet(state)).map(ChannelSystem::fork).collect()
    }

    /// The system at the start, and its tick generator.
    pub(crate) fn start(&self) -> (ChannelSystem, ProcessId) {
        (self.system.fork(), self.id("TickGenerator"))
    }

    /// Gives the components the battery and the pose, which is at all places or at none.
    pub(crate) fn sense(&self, state: &mut ChannelSystem, charge_pct: f64, charging: bool, is_there: bool) {
        let battery = BatteryState { time: Duration::ZERO, charge_pct, charging };
        state.process_mut::<BatteryReader>(self.id(BATTERY_READER)).unwrap().update(&battery);
        let pose = if is_there { maps::pose(0.2, 0.2, 0.0) } else { maps::pose(50.0, 50.0, 0.0) };
        state.process_mut::<Localization>(self.id(LOCALIZATION)).unwrap().update(&places(), &pose);
    }

    /// Generates a tick; the robot is at no place.
    fn tick(&self, mut state: ChannelSystem, charge_pct: f64) -> ChannelSystem {
        self.sense(&mut state, charge_pct, false, false);
        let (_, delivered) = state.generate_tick(self.id("TickGenerator"));
        assert!(delivered, "the previous tick is finished");
        state
    }

    /// Whether only the driver can move.
    fn is_quiet(&self, state: &ChannelSystem) -> bool {
        let driver = self.id(DRIVER);
        state.fork().enabled().iter().all(|transition| transition.process == driver)
    }

    /// The location of a process.
    pub(crate) fn location(&self, state: &ChannelSystem, process: &str) -> String {
        state.location(self.id(process)).unwrap()
    }

    /// Whether the robot drives to a place.
    pub(crate) fn drives_to(&self, state: &ChannelSystem, place: &str) -> bool {
        self.location(state, DRIVER) == format!("to {place}")
    }

    /// Whether Navigation's trip leads to a place and the driver is busy with that very trip, or done with it.
    pub(crate) fn is_on_trip_to(&self, state: &ChannelSystem, place: &str) -> bool {
        let navigation = state.process::<Driven>(self.id(NAVIGATION)).unwrap();
        let trip = navigation.navigation.trip_place().map(|place| place.name());
        trip == Some(place) && self.location(state, DRIVER).ends_with(place)
    }

    /// The locations of the processes that matter here.
    pub(crate) fn describe(&self, state: &ChannelSystem) -> String {
        let names = ["GotoRechargingStation", "GoToDestination", NAVIGATION, DRIVER];
        names.map(|name| format!("{name}: {}", self.location(state, name))).join("; ")
    }

    fn id(&self, name: &str) -> ProcessId {
        self.system.topology().find_process(name).unwrap()
    }
}

fn places() -> Places {
    let mut places = Places::default();
    for name in PLACES {
        let corners = vec![Point::new(0.0, 0.0), Point::new(1.0, 0.0), Point::new(0.0, 1.0)];
        places.insert(name, Place::Area { corners });
    }
    places
}

fn charts(protocol: Protocol) -> Vec<(&'static str, Arc<Chart>)> {
    let load = |(name, shipped)| (name, Chart::load(name, &protocol.machine(name, shipped)).unwrap());
    skills::SHIPPED.map(load).to_vec()
}

type Player = (ProcessId, Box<dyn Process>);

fn tree_processes(tree: &Arc<Tree>, form: TreeForm, topology: &mut Topology, bt: ProcessId) -> Vec<Player> {
    match form {
        TreeForm::Whole => {
            let whole = TreeProcess::new(Arc::clone(tree), topology, "BT", "TickGenerator").unwrap();
            vec![(bt, Box::new(whole))]
        }
        TreeForm::Nodes => bt::node_processes(tree, topology, "BT", "TickGenerator", Duration::from_secs(1)).unwrap(),
    }
}

/// Declares the components with their channels and makes their processes.
fn components(protocol: Protocol, trips: Trips, charts: &[(&str, Arc<Chart>)], topology: &mut Topology) -> Vec<Player> {
    let mut names = vec![BATTERY_READER, LOCALIZATION, NAVIGATION];
    names.extend((protocol != Protocol::Shipped).then_some(BLACKBOARD));
    let operations = operations(&places());
    for &component in &names {
        let id = topology.process(component).unwrap();
        let own: Vec<&Operation> = operations.iter().filter(|operation| operation.component == component).collect();
        for (client, chart) in charts {
            if chart.channel_messages().iter().any(|(to, _)| *to == component) {
                serve(topology, topology.find_process(client).unwrap(), id, &own);
            }
        }
    }
    let id = |name| topology.find_process(name).unwrap();
    let mut players: Vec<Player> = vec![
        (id(BATTERY_READER), Box::new(BatteryReader::new(topology, id(BATTERY_READER)).unwrap())),
        (id(LOCALIZATION), Box::new(Localization::new(topology, id(LOCALIZATION)).unwrap())),
    ];
    if protocol != Protocol::Shipped {
        players.push((id(BLACKBOARD), Box::new(Blackboard::new(topology, id(BLACKBOARD)).unwrap())));
    }
    // Made before the driver has channels, so that Navigation does not take it for a client.
    let navigation = Navigation::new(topology, id(NAVIGATION)).unwrap().with_stops(protocol.stops());
    players.extend(navigation_with_driver(navigation, trips, topology));
    players
}

fn serve(topology: &mut Topology, client: ProcessId, component: ProcessId, operations: &[&Operation]) {
    let asked: Vec<Shape> = operations.iter().map(|operation| operation.request.clone()).collect();
    let mut answers: Vec<Shape> = Vec::new();
    for shape in operations.iter().flat_map(|operation| &operation.replies) {
        if !answers.contains(shape) {
            answers.push(shape.clone());
        }
    }
    topology.channel(client, component, Capacity::One, Domain::new(asked)).unwrap();
    topology.channel(component, client, Capacity::One, Domain::new(answers)).unwrap();
}

/// Navigation together with the exchange with its driver: it passes on requests, and otherwise takes reports.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Driven {
    navigation: Navigation,
    orders: ChannelId,
    reports: ChannelId,
}

const HAND_OVER: TransitionId = TransitionId(1000);
const TAKE_REPORT: TransitionId = TransitionId(1001);

fn order_message(order: &Order) -> Message {
    match order {
        Order::Start(place) => Message::symbols(["start", place.name()]),
        Order::Stop => Message::symbols(["stop"]),
    }
}

impl Process for Driven {
    fn offers(&self, offers: &mut Vec<Offer>) {
        self.navigation.offers(offers);
        // As between two steps, a report is about the driver's last command.
        offers.push(match self.navigation.clone().next_order() {
            Some(order) => {
                let envelope = Envelope { message: order_message(&order), request: RequestNumber(0) };
                Offer { transition: HAND_OVER, action: Action::Send(self.orders, envelope) }
            }
            None => Offer { transition: TAKE_REPORT, action: Action::Receive(self.reports, Pattern::Any) },
        });
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        match transition {
            HAND_OVER => drop(self.navigation.next_order()),
            TAKE_REPORT => {
                let arrived = received.is_some_and(|report| report.message.head() == Some("success"));
                self.navigation.set_trip_status(if arrived { TripStatus::Success } else { TripStatus::Failure });
            }
            _ => self.navigation.take(transition, received, now),
        }
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        self.navigation.normalize(form)
    }

    fn uses(&self) -> Vec<Use> {
        let mut uses = self.navigation.uses();
        uses.extend([Use::Sends(self.orders, None), Use::Receives(self.reports, None)]);
        uses
    }

    fn location(&self) -> String {
        self.navigation.location()
    }
}

/// The driver follows its last command, and makes its possible reports.
fn navigation_with_driver(navigation: Navigation, trips: Trips, topology: &mut Topology) -> [Player; 2] {
    let id = topology.find_process(NAVIGATION).unwrap();
    let driver = topology.process(DRIVER).unwrap();
    let orders = Domain::new([
        Shape::new([("order", FieldKind::symbols(["start"])), ("place", FieldKind::symbols(PLACES))]),
        Shape::new([("order", FieldKind::symbols(["stop"]))]),
    ]);
    let reports = Domain::new([Shape::new([("report", FieldKind::symbols(["success", "failure"]))])]);
    let orders = topology.channel(id, driver, Capacity::Zero, orders).unwrap();
    let reports = topology.channel(driver, id, Capacity::Zero, reports).unwrap();

    let mut graph = ProgramGraph::builder(DRIVER);
    let standing = graph.location("standing");
    let ways =
        PLACES.map(|place| [format!("to {place}"), format!("done with {place}")].map(|name| graph.location(&name)));
    for from in ways.into_iter().flatten().chain([standing]) {
        graph.receive(from, orders, Message::symbols(["stop"]), standing);
        for (place, [under_way, _]) in PLACES.iter().zip(ways) {
            graph.receive(from, orders, Message::symbols(["start", place]), under_way);
        }
    }
    for [under_way, done] in ways {
        let reports_made: &[&str] = if trips == Trips::Ending { &["success", "failure"] } else { &[] };
        for report in reports_made {
            graph.send(under_way, reports, Message::symbols([*report]), done);
        }
    }
    let graph = Arc::new(graph.initial(standing).build().unwrap());
    [(id, Box::new(Driven { navigation, orders, reports })), (driver, Box::new(GraphProcess::new(graph)))]
}
