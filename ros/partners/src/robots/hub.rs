//! The robots of one process in a DDS domain: distributes messages and requests to the robots, and keeps their steps
//! together.

use std::collections::{BTreeSet, VecDeque};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use bags::{Received, Source as _};
use network::{Domain, IncomingRequest, Live as _, Publisher};

/// The longest wait for a message in one call.
const PATIENCE: Duration = Duration::from_millis(10);

/// The most messages that wait for a robot, and the most requests. Beyond that, the oldest are left out.
const MOST: usize = 2000;

/// The most bytes of a message or a request: those for a robot are short.
const LARGEST: usize = 1 << 16;

/// A robot's connection to a domain, which is left with the last of its stations.
pub(super) struct Station {
    shared: Arc<Shared>,
    place: usize,
    has_left: bool,
    pub(super) publisher: Publisher,
}

/// A message for a robot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Incoming {
    pub(super) topic: String,
    pub(super) kind: String,
    pub(super) body: Vec<u8>,
}

struct Shared {
    /// How many robots are left.
    left: AtomicUsize,
    /// The thread that receives, until no robot is left.
    thread: Mutex<Option<JoinHandle<()>>>,
    state: Mutex<Traffic>,
    /// For each robot: a message has come.
    arrivals: Vec<Condvar>,
    /// The last robot has completed a step.
    steps: Condvar,
    /// Called with what a user should know.
    note: fn(&str),
}

#[derive(Default)]
struct Traffic {
    robots: Vec<Robot>,
    /// The time that has been published.
    clock: Duration,
    /// The topics and services with something left out, each of which has been noted.
    left_out: BTreeSet<String>,
    /// The topics of the robots that have subscribers.
    read: BTreeSet<String>,
    /// The topics that have publishers.
    published: BTreeSet<String>,
}

struct Robot {
    /// The topics to which it subscribes, and its services.
    topics: BTreeSet<String>,
    services: BTreeSet<String>,
    messages: VecDeque<Incoming>,
    requests: VecDeque<IncomingRequest>,
    /// Its time; `None` once it has left.
    time: Option<Duration>,
}

/// The topics to which a robot subscribes, and its services.
pub(super) struct Wanted {
    pub(super) topics: BTreeSet<String>,
    pub(super) services: BTreeSet<String>,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, Traffic> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A station for each robot, in this order, in a domain that has begun. `None` if the domain has been left. `note` is
/// called with what a user should know.
pub(super) fn stations(mut node: Domain, wanted: Vec<Wanted>, note: fn(&str)) -> Option<Vec<Station>> {
    let publishers = wanted.iter().map(|_| node.publisher()).collect::<Option<Vec<Publisher>>>()?;
    let robot = |Wanted { topics, services }| {
        let (messages, requests) = (VecDeque::new(), VecDeque::new());
        Robot { topics, services, messages, requests, time: Some(Duration::ZERO) }
    };
    let robots: Vec<Robot> = wanted.into_iter().map(robot).collect();
    let count = robots.len();
    let state = Mutex::new(Traffic { robots, ..Traffic::default() });
    let arrivals = (0..count).map(|_| Condvar::new()).collect();
    let (left, thread) = (AtomicUsize::new(count), Mutex::new(None));
    let shared = Arc::new(Shared { left, thread, state, arrivals, steps: Condvar::new(), note });
    let thread = std::thread::spawn({
        let shared = Arc::clone(&shared);
        move || {
            node.patience = PATIENCE;
            let (mut body, mut notes, mut lost) = (Vec::new(), 0, 0);
            while shared.left.load(Ordering::Relaxed) > 0 {
                let received = node.receive(&mut body);
                shared.take(&mut node, received, &mut body);
                node.notes().iter().skip(notes).chain(node.lost().iter().skip(lost)).for_each(|text| note(text));
                (notes, lost) = (node.notes().len(), node.lost().len());
            }
            node.end();
        }
    });
    *shared.thread.lock().unwrap_or_else(PoisonError::into_inner) = Some(thread);
    let station = |(place, publisher)| Station { shared: Arc::clone(&shared), place, has_left: false, publisher };
    Some(publishers.into_iter().enumerate().map(station).collect())
}

impl Shared {
    /// Distributes what has come.
    fn take(&self, node: &mut Domain, received: Received, body: &mut Vec<u8>) {
        let mut state = self.state();
        if let Received::Message(head) = received {
            let topic = &node.survey().topics[head.topic];
            if let Some(place) = state.robots.iter().position(|robot| robot.topics.contains(&topic.name)) {
                let (topic, kind) = (topic.name.clone(), topic.kind.clone());
                let (name, size) = (topic.clone(), body.len());
                let incoming = Incoming { topic, kind, body: std::mem::take(body) };
                let Traffic { robots, left_out, .. } = &mut *state;
                if let Some(text) = keep(&mut robots[place].messages, incoming, &name, size, left_out) {
                    (self.note)(&text);
                }
                self.arrivals[place].notify_one();
            }
        }
        while let Some(request) = node.request() {
            let place = state.robots.iter().position(|robot| robot.services.contains(&request.service));
            if let Some(place) = place {
                let (name, size) = (request.service.clone(), request.body.len());
                let Traffic { robots, left_out, .. } = &mut *state;
                if let Some(text) = keep(&mut robots[place].requests, request, &name, size, left_out) {
                    (self.note)(&text);
                }
            }
        }
        if state.read != *node.read() {
            state.read.clone_from(node.read());
        }
        let publishers = &node.robot().publishers;
        if !publishers.keys().eq(state.published.iter()) {
            state.published = publishers.keys().cloned().collect();
        }
    }

    /// See [`Station::keep_step`].
    fn keep_step(&self, place: usize, now: Duration) -> Option<bool> {
        let mut state = self.state();
        let is_behind = |state: &mut Traffic| state.robots.iter().any(|of| of.time.is_some_and(|time| time < now));
        let has_come = state.robots[place].time.replace(now) != Some(now);
        if !is_behind(&mut state) {
            if has_come {
                self.steps.notify_all();
            }
        } else {
            let waited = self.steps.wait_timeout_while(state, PATIENCE, is_behind);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        (!is_behind(&mut state)).then(|| {
            let is_first = state.clock < now;
            state.clock = now;
            is_first
        })
    }

    fn leave(&self, place: usize) {
        self.state().robots[place].time = None;
        self.steps.notify_all();
        if self.left.fetch_sub(1, Ordering::Relaxed) == 1 {
            // The domain is left before the program ends.
            let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
            let _ = thread.map(JoinHandle::join);
        }
    }
}

/// Queues what has come under a name, unless it is too large. The oldest is left out if there is too much. Returns
/// either in words, once per name, which `left_out` remembers.
fn keep<T>(
    waiting: &mut VecDeque<T>,
    new: T,
    name: &str,
    size: usize,
    left_out: &mut BTreeSet<String>,
) -> Option<String> {
    let why = if size > LARGEST {
        format!("{size} bytes are too many")
    } else {
        let is_full = waiting.len() == MOST;
        if is_full {
            waiting.pop_front();
        }
        waiting.push_back(new);
        if !is_full {
            return None;
        }
        "more comes than is taken".to_owned()
    };
    left_out.insert(name.to_owned()).then(|| format!("some of what comes on {name} is left out: {why}"))
}

impl Station {
    /// The next message, if one comes soon enough.
    pub(super) fn receive(&self, patience: Duration) -> Option<Incoming> {
        let mut state = self.shared.state();
        if state.robots[self.place].messages.is_empty() && !patience.is_zero() {
            let is_empty = |state: &mut Traffic| state.robots[self.place].messages.is_empty();
            let waited = self.shared.arrivals[self.place].wait_timeout_while(state, patience, is_empty);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        state.robots[self.place].messages.pop_front()
    }

    /// The next request to a service of the robot for which `is_meant` is true, if one has come.
    pub(super) fn request(&self, is_meant: impl Fn(&str) -> bool) -> Option<IncomingRequest> {
        let requests = &mut self.shared.state().robots[self.place].requests;
        let place = requests.iter().position(|request| is_meant(&request.service))?;
        requests.remove(place)
    }

    /// Whether a topic of the robot has subscribers.
    pub(super) fn is_read(&self, topic: &str) -> bool {
        self.shared.state().read.contains(topic)
    }

    /// Whether a topic to which the robot subscribes has publishers.
    pub(super) fn is_published(&self, topic: &str) -> bool {
        self.shared.state().published.contains(topic)
    }

    /// The robot has completed its step to this time: waits for a moment until all robots have. Returns whether it is
    /// the first to notice, which is to publish the time; `None` if a robot is still behind.
    pub(super) fn keep_step(&self, now: Duration) -> Option<bool> {
        self.shared.keep_step(self.place, now)
    }

    /// Reports what a user should know.
    pub(super) fn note(&self, text: &str) {
        (self.shared.note)(text);
    }

    /// Leaves the other robots. The last one leaves the domain.
    pub(super) fn leave(&mut self) {
        if !std::mem::replace(&mut self.has_left, true) {
            self.shared.leave(self.place);
        }
    }
}

impl Drop for Station {
    fn drop(&mut self) {
        self.leave();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    const STEP: Duration = Duration::from_millis(20);

    fn shared(count: usize) -> Arc<Shared> {
        let robot = || Robot {
            topics: BTreeSet::new(),
            services: BTreeSet::new(),
            messages: VecDeque::new(),
            requests: VecDeque::new(),
            time: Some(Duration::ZERO),
        };
        let state = Traffic { robots: (0..count).map(|_| robot()).collect(), ..Traffic::default() };
        Arc::new(Shared {
            left: AtomicUsize::new(count),
            thread: Mutex::new(None),
            state: Mutex::new(state),
            arrivals: (0..count).map(|_| Condvar::new()).collect(),
            steps: Condvar::new(),
            note: |_| {},
        })
    }

    #[test]
    fn no_robot_goes_on_before_all_have_completed_a_step_and_one_publishes_the_time() {
        let shared = shared(3);
        let (sender, passed) = channel();
        std::thread::scope(|scope| {
            for place in 0..3 {
                let (shared, sender) = (Arc::clone(&shared), sender.clone());
                scope.spawn(move || {
                    // The first one ends earlier than the others.
                    for step in 1..=if place == 0 { 50 } else { 100_u32 } {
                        let first = loop {
                            if let Some(first) = shared.keep_step(place, STEP * step) {
                                break first;
                            }
                        };
                        sender.send((step, place, first)).expect("the receiver lives");
                    }
                    shared.leave(place);
                });
            }
        });
        drop(sender);
        let passed: Vec<(u32, usize, bool)> = passed.iter().collect();
        assert_eq!(passed.len(), 250);
        let (mut last, mut published) = ([0; 3], Vec::new());
        for (step, place, is_first) in passed {
            last[place] = step;
            let slowest =
                last.iter().enumerate().filter(|(place, _)| *place > 0 || step <= 50).map(|(_, step)| *step).min();
            assert!(slowest.is_some_and(|slowest| slowest + 1 >= step), "{last:?}");
            published.extend(is_first.then_some(step));
        }
    }

    #[test]
    fn a_single_robot_does_not_wait_and_one_of_two_waits_only_for_a_moment() {
        assert_eq!(shared(1).keep_step(0, STEP), Some(true));
        assert_eq!(shared(2).keep_step(0, STEP), None);
    }

    #[test]
    fn the_oldest_makes_room_for_the_newest_and_nothing_long_is_kept() {
        let (mut waiting, mut left_out) = (VecDeque::new(), BTreeSet::new());
        for number in 0..MOST + 5 {
            keep(&mut waiting, number, "/a", 4, &mut left_out);
            keep(&mut waiting, number, "/b", LARGEST + 1, &mut left_out);
        }
        assert_eq!((waiting.len(), waiting[0]), (MOST, 5));
        assert_eq!(left_out, ["/a", "/b"].map(str::to_owned).into());
    }
}
