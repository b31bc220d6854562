//! Properties checked against recorded events, and the report of the results.

use std::cell::Cell;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use bags::{Found, Gap};
use campaigns::{Error, refuse_campaign};
use channels::Topology;
use monitors::{LogEnd, Outcome, Property, ScopeMonitor};
use recording::{Doubts, Follower, Header, Judge, Monitor, Origin, Premises, Recording, RobotBody, RunView};
use reports::{Outputs, Presentation};
use runs::FITS;
use trials::replay::way::{Way, WayPlace};

use super::args::VerifyArgs;
use crate::monitor::System;
use crate::output::warn;

/// A log that was checked.
pub(super) struct Verified {
    pub(super) properties: Vec<Property>,
    pub(super) end: LogEnd,
    /// For each property why its verdict is unsure, if it is: messages are missing that could change it.
    pub(super) unsure: Vec<Option<String>>,
    /// For each property that a recording satisfies although the true level fell below what it requires: that no
    /// message told so.
    pub(super) unheard: Vec<Option<String>>,
    /// When a bag begins, in nanoseconds since 1970.
    pub(super) start_ns: Option<i64>,
    /// What is missing from the log or was not judged, in words.
    pub(super) notes: Vec<String>,
}

/// The properties that the run of a recording watched, and the names of those that cannot be judged again, because no
/// formula describes them.
pub(super) fn recorded(header: &Header) -> Result<(Vec<Property>, Vec<String>), Error> {
    let (mut properties, mut others) = (Vec::new(), Vec::new());
    for Monitor { name, property, summary, formula, .. } in header.monitors.iter() {
        let Some(formula) = formula else {
            others.push(name.clone());
            continue;
        };
        let monitor = ScopeMonitor::new(name, formula.clone(), &header.topology).map_err(|error| {
            let help = "name a file with the properties: `--property FILE`";
            Error::refused(format!("the recording's property `{name}` cannot be monitored: {error}"), help)
        })?;
        let (name, formula, summary) = (name.clone(), property.clone(), summary.clone());
        properties.push(Property { name, formula, summary, monitor: Box::new(monitor) });
    }
    Ok((properties, others))
}

impl Verified {
    /// When the log ends.
    pub(super) fn end_time(&self) -> Duration {
        self.end.last.map_or(Duration::ZERO, |last| last.time)
    }

    /// The verdict of a property: satisfied, violated, inconclusive or unsure.
    pub(super) fn verdict(&self, index: usize) -> &'static str {
        if self.unsure[index].is_some() { "unsure" } else { self.outcome(index).name() }
    }

    /// The outcome of a property if nothing is missing.
    pub(super) fn outcome(&self, index: usize) -> Outcome {
        Outcome::of(self.properties[index].monitor.as_ref())
    }

    /// What the verdicts must not hide: that there was nothing to judge, or nothing to judge it by.
    pub(super) fn nothing(&self) -> impl Iterator<Item = &'static str> {
        let no_events = (self.end.messages + self.end.ticks == 0)
            .then_some("the log contains no events: every verdict is that of a run in which nothing happened");
        let no_property = self.properties.is_empty().then_some("there is no property to check the log against");
        no_events.into_iter().chain(no_property)
    }

    /// Whether a verdict is one that a log should not have: a violation, or no certainty.
    pub(super) fn is_bad(&self) -> bool {
        (0..self.properties.len()).any(|index| self.unsure[index].is_some() || self.outcome(index) == Outcome::Violated)
    }
}

/// For each property that is satisfied although, in this recording of a simulated run, the true level fell below what
/// it requires: that no message told so. A level in the rest of a truncated recording is unknown, like its messages.
pub(super) fn unheard(path: &Path, properties: &[Property], topology: &Topology) -> Vec<Option<String>> {
    let view = Recording::open(path).and_then(|mut recording| {
        let mut view = recording.begin()?;
        while view.end().is_none() && recording.advance(&mut view).is_ok() {}
        Ok(view)
    });
    let unheard = |property: &Property| {
        let outcome = Outcome::of(property.monitor.as_ref());
        reports::unheard_level(&Monitor::of(property, topology), outcome, view.as_ref().ok()?)
    };
    properties.iter().map(unheard).collect()
}

/// How far a log goes, and which verdicts are unsure, and why.
pub(super) type Judged = (LogEnd, Vec<Option<String>>);

/// The requested properties.
pub(super) fn load(args: &VerifyArgs, system: &System) -> Result<Vec<Property>, Error> {
    if args.properties.is_empty() {
        let help = "name a file with properties: `--property FILE`; only recordings by steward have properties of \
                    their own";
        return Err(Error::refused("no property to check the log against is given".to_owned(), help));
    }
    let mut properties: Vec<Property> = Vec::new();
    for path in &args.properties {
        let file = system.load(path)?;
        if !file.warnings.is_empty() {
            warn(&file.warnings);
        }
        let known = |name: &str| properties.iter().any(|property| property.name == name);
        if let Some(again) = file.properties.iter().find(|property| known(&property.name)) {
            let message = format!("there are two properties `{}`, one in {}", again.name, path.display());
            return Err(Error::refused(message, "give each property a different name"));
        }
        properties.extend(file.properties);
    }
    Ok(properties)
}

/// Makes the monitors judge the events; also writes the report to the folder, if there is one. It shows the texts
/// `about` and `mapping`. `doubts` says what may be missing.
pub(super) fn judge(
    args: &VerifyArgs,
    (path, folder): (&Path, Option<&Path>),
    [about, mapping]: [String; 2],
    system: &System,
    properties: &mut [Property],
    doubts: Doubts,
    (mut events, around): (impl Iterator<Item = Result<Found, Error>>, &Around),
) -> Result<Judged, Error> {
    let Some(folder) = folder else { return judge_in_words(&mut events, properties, doubts) };
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let outputs = Outputs { folder: Some(folder.to_owned()), ..Outputs::default() };
    refuse_campaign(&outputs)?;
    let origin = Origin { text: mapping, recorded: Some(args.command(path)), ..Origin::default() };
    let (mut judge, mut header, start) =
        Judge::begin([name, about], origin, &system.topology, system.tick, properties, doubts);
    around.describe(&mut header);
    let mut places = around.way.iter().flat_map(|way| &way.places).peekable();
    let mut view = RunView::new(header, start).expect(FITS);
    let mut presentation = Presentation::begin(&view, &outputs)?;
    let mut events = events.peekable();
    while let Some(event) = events.next() {
        match event? {
            Found::Event(event) => {
                while let Some(place) = places.next_if(|place| around.time(place) <= event.time) {
                    view.apply(judge.place(around.time(place).max(view.time()), place.pose)).expect(FITS);
                    presentation.follow(&view)?;
                }
                view.apply(judge.step(event, properties)).expect(FITS);
            }
            Found::LeftOut(Gap { why, channel }) => judge.miss(&why, channel, properties),
        }
        // The last step is recorded with the end.
        if events.peek().is_none() {
            view.finish(judge.finish(properties)).expect(FITS);
        }
        presentation.follow(&view)?;
    }
    if view.end().is_none() {
        view.finish(judge.finish(properties)).expect(FITS);
    }
    view.set_began(around.start_ns.get().and_then(bags::date));
    presentation.finish(&view)?;
    Ok((judge.end(), judge.unsure().to_vec()))
}

/// What is known of a log beyond its events.
#[derive(Default)]
pub(super) struct Around {
    /// When the events begin, once the first has been read: in nanoseconds since 1970 if their times are.
    pub(super) start_ns: Cell<Option<i64>>,
    /// Where the robot was, if there is a map.
    pub(super) way: Option<Way>,
    /// Whether the events have the times of the log, and not stamps.
    pub(super) is_by_log: bool,
}

impl Around {
    /// The time of a place, in that of the events.
    fn time(&self, place: &WayPlace) -> Duration {
        let ns = place.stamp_ns.filter(|_| !self.is_by_log).unwrap_or(place.log_ns);
        let since = ns.saturating_sub(self.start_ns.get().unwrap_or(ns));
        Duration::from_nanos(since.max(0).unsigned_abs())
    }

    fn describe(&self, header: &mut Header) {
        let Some(Way { map, places }) = &self.way else { return };
        let start = places[0].pose;
        header.premises =
            Some(Premises { map: Arc::new(map.clone()), places: Vec::new(), start, station: None, destination: None });
        // Its size is unknown: it is drawn as a sign.
        header.robot = Some(RobotBody { radius_m: 0.0, lasers: Vec::new() });
        let first = places.iter().find_map(|place| Some((place.pose, place.odometry?)));
        let Some((pose, odometry)) = first else { return };
        let onto_map = pose * odometry.inverse();
        let path = places.iter().filter_map(|place| Some((onto_map * place.odometry?).translation.vector.into()));
        header.origin.odometry = path.collect();
    }
}

/// The same without a report, which is faster.
pub(super) fn judge_in_words(
    events: &mut impl Iterator<Item = Result<Found, Error>>,
    properties: &mut [Property],
    mut doubts: Doubts,
) -> Result<Judged, Error> {
    let mut end = LogEnd::default();
    // `monitors::verify` reads events until there is none. So a gap ends a part of the log, after which properties
    // whose verdicts are settled keep them, and all others continue in doubt.
    loop {
        let mut gap = None;
        let present = std::iter::from_fn(|| match events.next()? {
            Ok(Found::Event(event)) => Some(Ok(event)),
            Ok(Found::LeftOut(found)) => {
                gap = Some(found);
                None
            }
            Err(error) => Some(Err(error)),
        });
        let part = monitors::verify(present, monitors_of(properties).chain(doubts.monitors()))?;
        end = LogEnd {
            messages: end.messages + part.messages,
            ticks: end.ticks + part.ticks,
            last: part.last.or(end.last),
        };
        doubts.settle(properties);
        let Some(Gap { why, channel }) = gap else { break };
        doubts.miss(&why, channel, properties);
    }
    Ok((end, doubts.all().to_vec()))
}

fn monitors_of(properties: &mut [Property]) -> impl Iterator<Item = &mut dyn channels::Monitor> {
    properties.iter_mut().map(|property| property.monitor.as_mut() as &mut dyn channels::Monitor)
}
