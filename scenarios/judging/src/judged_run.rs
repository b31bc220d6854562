//! The records of a run that was recorded elsewhere, or goes on, from its events, which monitors judge.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

use bags::Found;
use campaigns::Error;
use channels::Event;
use maps::Pose;
use monitors::Property;
use recording::{Detail, Header, Judge, Next, RecordSource, RunView, Scene, Step, fitting};
use replay::live_pose::LivePose;
use replay::trajectory::TrajectoryPoint;

use crate::log_context::LogContext;
use crate::scene_sampler::SceneSampler;
use crate::wanted::VerdictObserver;

/// How long a page waits for the map, the pose of the robot and its laser: a latched message may take as long as the
/// period of the publisher's heartbeats.
const LONGEST_WAIT: Duration = Duration::from_secs(4);

/// Events that monitors judge, with the robot's way between them.
pub(crate) struct JudgedRun<'l, I: Iterator<Item = Result<Found, Error>>> {
    events: I,
    properties: &'l mut [Property],
    judge: Judge,
    /// The first two records, until they are requested.
    start: Option<(Header, Step)>,
    context: &'l LogContext,
    sampler: Option<SceneSampler>,
    /// The rest of the robot's trajectory.
    points: std::slice::Iter<'l, TrajectoryPoint>,
    observer: Option<Box<dyn VerdictObserver>>,
    /// Where the robot was before the next event, and the event.
    places: VecDeque<(Duration, Pose, Option<Scene>)>,
    event: Option<Event>,
}

impl<'l, I: Iterator<Item = Result<Found, Error>>> JudgedRun<'l, I> {
    /// Begins with what [`Judge::begin`] has made.
    pub(crate) fn new(
        events: I,
        properties: &'l mut [Property],
        (judge, mut header, start): (Judge, Header, Step),
        context: &'l LogContext,
        observer: Option<Box<dyn VerdictObserver>>,
    ) -> Self {
        context.describe(&mut header);
        Self {
            events,
            properties,
            judge,
            sampler: SceneSampler::begin(context, &header),
            start: Some((header, start)),
            context,
            points: context.trajectory.as_ref().map_or(&[][..], |trajectory| &trajectory.points).iter(),
            observer,
            places: VecDeque::new(),
            event: None,
        }
    }

    /// What has been found.
    pub(crate) fn finish(self) -> (Judge, &'l [Property]) {
        (self.judge, self.properties)
    }

    /// Takes an event with the places before it.
    fn take(&mut self, event: Event) {
        let Self { points, context, .. } = self;
        while let Some(point) = points.as_slice().first().filter(|point| context.time(point) <= event.time) {
            self.places.push_back((context.time(point), point.pose, None));
            points.next();
        }
        let sample = self.sampler.as_mut().and_then(|sampler| sampler.sample(event.time, context));
        self.places.extend(sample.map(|(pose, scene)| (event.time, pose, scene)));
        self.event = Some(event);
    }

    /// The record of the next place, or of the event after it.
    fn ready(&mut self, now: Duration) -> Option<Step> {
        if let Some((time, pose, scene)) = self.places.pop_front() {
            return Some(self.judge.place(time.max(now), pose, scene));
        }
        let mut step = self.judge.step(self.event.take()?, self.properties);
        self.context.tree.iter().for_each(|tree| tree.add(&mut step));
        Some(step)
    }

    fn observe(&mut self, view: &RunView) -> Result<(), Error> {
        self.observer
            .as_mut()
            .map_or(Ok(()), |observer| observer.follow(view.time(), self.properties, self.judge.doubts(), self.context))
    }
}

impl<I: Iterator<Item = Result<Found, Error>>> RecordSource for JudgedRun<'_, I> {
    type Error = Error;

    fn start(&mut self, _: Detail) -> Result<RunView, Error> {
        let (header, start) = self.start.take().expect("a run is started once");
        Ok(fitting(RunView::new(header, start)))
    }

    /// The end comes with a step of its own: whether an event is the last is known only after it, and a page shows each
    /// event at once.
    fn next(&mut self, view: &mut RunView, _: Detail, _: bool) -> Result<Next<Error>, Error> {
        loop {
            let is_place = !self.places.is_empty();
            if let Some(step) = self.ready(view.time()) {
                fitting(view.apply(step));
                if !is_place {
                    self.observe(view)?;
                }
                return Ok(Next::Step);
            }
            match self.events.next().transpose()? {
                Some(Found::Event(event)) => {
                    self.take(event);
                    continue;
                }
                Some(Found::LeftOut(gap)) => self.judge.miss(&gap, self.properties),
                Some(Found::Resumed(channel)) => self.judge.resume(channel, self.properties),
                Some(Found::Vouched(channel, ground)) => self.judge.vouch(channel, ground),
                Some(Found::Noted(note)) => self.observer.iter().for_each(|observer| observer.note(&note)),
                Some(Found::Idle) => {
                    self.observer.iter_mut().for_each(|observer| observer.idle(self.properties, self.context));
                    return Ok(Next::Idle);
                }
                Some(Found::Ended(time)) => {
                    fitting(view.apply(self.judge.end_at(time)));
                    self.observe(view)?;
                    return Ok(Next::Step);
                }
                None => {
                    fitting(view.apply(self.judge.quiet(view.time())));
                    fitting(view.finish(self.judge.finish(self.properties)));
                    return Ok(Next::Step);
                }
            }
            self.observe(view)?;
        }
    }
}

/// Waits a limited time until the robot can be shown. Returns the events that are found in the meantime.
#[expect(clippy::disallowed_methods, reason = "a robot is awaited in real time")]
pub(crate) fn await_live_pose(
    live_pose: &RefCell<LivePose>,
    events: &mut impl Iterator<Item = Result<Found, Error>>,
    idle: &mut impl FnMut(),
    note: fn(&str),
) -> Vec<Result<Found, Error>> {
    let (mut found, start) = (Vec::new(), Instant::now());
    while live_pose.borrow_mut().missing().is_some() && start.elapsed() < LONGEST_WAIT {
        match events.next() {
            Some(Ok(Found::Idle)) => idle(),
            Some(next) => found.push(next),
            None => break,
        }
    }
    let mut live_pose = live_pose.borrow_mut();
    live_pose.unread().for_each(note);
    live_pose.missing().into_iter().for_each(note);
    found
}
