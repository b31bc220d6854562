//! Properties checked against recorded events, and the report of the results.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bags::Found;
use campaigns::{Error, refuse_campaign};
use channels::Topology;
use editor::System;
use monitors::{LogEnd, Outcome, Property, ScopeMonitor};
use recording::{
    Certainty, Doubts, Evidence, Follower, Header, InputFile, Judge, Monitor, Origin, Provenance, Recording, RunView,
};
use reports::file_place::FilePlace;
use reports::{Outputs, Presentation};
use runs::FITS;
use trials::replay::sight::Sight;

use super::announcer::Announcer;
use super::around::{Around, Looking};
use super::live_page::LivePage;
use crate::live::BoardArgs;
use crate::output::{note, warn};

/// How long a page waits for the map, the robot on it and its laser: what is latched may take as long as the period of
/// a publisher's heartbeats.
const LONGEST_WAIT: Duration = Duration::from_secs(4);

/// Why a recording's property is not judged again.
pub(super) const NO_FORMULA: &str = "no formula describes it";

/// A log that was checked.
pub(crate) struct Verified {
    pub(crate) properties: Vec<Property>,
    pub(crate) end: LogEnd,
    /// The names of a recording's properties that cannot be judged again: no formula describes them.
    pub(crate) unjudged: Vec<String>,
    /// For each property what its verdict rests on.
    pub(crate) evidence: Vec<Evidence>,
    /// For each property that a recording satisfies although the true level fell below what it requires: that no
    /// message told so.
    pub(crate) unheard: Vec<Option<String>>,
    /// For each property the story of its violation, as its page tells it; empty if nothing tells it.
    pub(crate) stories: Vec<Vec<String>>,
    /// What is known of its run: of an event log only the argument of its scenario, and of others not even that.
    pub(crate) header: Header,
    /// Where the processes of a bag's tree are written, if the command line names it.
    pub(crate) processes: BTreeMap<String, FilePlace>,
    /// When a bag begins, in nanoseconds since 1970.
    pub(crate) start_ns: Option<i64>,
    /// Whether it is known when the tree was ticked.
    pub(crate) knows_ticks: bool,
    /// What is missing from the log or was not judged, in words.
    pub(crate) notes: Vec<String>,
    /// The files that it was judged by, if results are wanted.
    pub(crate) inputs: Vec<InputFile>,
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
        properties.push(Property { name, formula, summary, place: None, monitor: Box::new(monitor) });
    }
    Ok((properties, others))
}

impl Verified {
    /// What was judged until `end`; the notes say what its verdicts leave open.
    pub(crate) fn of(properties: Vec<Property>, end: LogEnd, doubts: &Doubts, left_open: String) -> Self {
        let judgment = Judgment::of(end, doubts, &properties);
        let notes = judgment.notes(&properties).into_iter().chain([left_open]).collect();
        Self::judged(properties, judgment, notes)
    }

    /// The same of a log about which nothing else is known.
    pub(super) fn judged(properties: Vec<Property>, judgment: Judgment, notes: Vec<String>) -> Self {
        let Judgment { end, evidence, stories, inputs, .. } = judgment;
        Self {
            unheard: vec![None; properties.len()],
            properties,
            unjudged: Vec::new(),
            end,
            evidence,
            stories,
            header: Header::default(),
            processes: BTreeMap::new(),
            start_ns: None,
            knows_ticks: false,
            notes,
            inputs,
        }
    }

    /// What a monitor still waits for, in words.
    pub(super) fn open(&self, monitor: &ScopeMonitor) -> Vec<String> {
        let open = monitor.open_obligations().into_iter();
        open.map(|owed| if self.knows_ticks { owed.to_string() } else { format!("{owed:#}") }).collect()
    }

    /// When the log ends.
    pub(super) fn end_time(&self) -> Duration {
        self.end.time()
    }

    /// The verdict of a property: satisfied, violated, inconclusive, unsure, or none.
    pub(super) fn verdict(&self, index: usize) -> &'static str {
        self.evidence[index].verdict(self.outcome(index))
    }

    /// Whether a property has a verdict, so that something can be said about it.
    pub(super) fn has_verdict(&self, index: usize) -> bool {
        self.evidence[index].has_verdict()
    }

    /// What is assumed of the messages, each once.
    pub(super) fn assumptions(&self) -> BTreeSet<&str> {
        self.evidence.iter().flat_map(Evidence::assumptions).map(String::as_str).collect()
    }

    /// The outcome of a property if nothing is missing.
    pub(super) fn outcome(&self, index: usize) -> Outcome {
        Outcome::of(self.properties[index].monitor.as_ref())
    }

    /// What the verdicts must not hide: that there was nothing to judge, or nothing to judge it by.
    pub(super) fn nothing(&self) -> impl Iterator<Item = &'static str> {
        let no_events = (self.end.messages + self.end.ticks == 0).then_some("the log contains no events");
        let no_property = self.properties.is_empty().then_some("there is no property to check the log against");
        no_events.into_iter().chain(no_property)
    }

    /// What the verdicts were made from.
    pub(super) fn provenance(&self) -> Provenance {
        let scenario = self.header.origin.argument.clone();
        Provenance { scenario, ..Provenance::of_files(self.inputs.clone()) }
    }

    /// The exit status: 2 if a property has no verdict, 1 if one is violated, or its verdict is unsure.
    pub(crate) fn status(&self) -> u8 {
        let of = |(index, evidence): (usize, &Evidence)| match evidence.certainty() {
            Certainty::Groundless(_) => 2,
            Certainty::Unsure(_) => 1,
            Certainty::Sure | Certainty::Unless(_) => u8::from(self.outcome(index) == Outcome::Violated),
        };
        self.evidence.iter().enumerate().map(of).max().unwrap_or(0)
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

/// How far a log goes, and what the verdicts rest on; also which violations after the first, and which numbers and
/// lengths of violations, are unsure, and why.
pub(super) struct Judgment {
    pub(super) end: LogEnd,
    pub(super) evidence: Vec<Evidence>,
    /// The stories of violations, if they are told.
    pub(super) stories: Vec<Vec<String>>,
    inputs: Vec<InputFile>,
    later: Vec<Option<String>>,
    extents: Vec<Option<String>>,
}

impl Judgment {
    fn of(end: LogEnd, doubts: &Doubts, properties: &[Property]) -> Self {
        let evidence = properties.iter().enumerate().map(|(index, property)| doubts.evidence(index, property));
        let owned = |why: Option<&str>| why.map(str::to_owned);
        Self {
            end,
            evidence: evidence.collect(),
            stories: vec![Vec::new(); properties.len()],
            inputs: Vec::new(),
            later: doubts.later().map(owned).collect(),
            extents: doubts.extents().map(owned).collect(),
        }
    }

    /// What is unsure of violations although the first is sure, in words.
    pub(super) fn notes(&self, properties: &[Property]) -> Vec<String> {
        let of = |(Property { name, .. }, (later, extent)): (&Property, (&Option<String>, &Option<String>))| {
            let again = later.as_ref().map(|why| format!("whether {name} was violated again is unsure: {why}"));
            let extent = extent.as_ref();
            again.or(extent.map(|why| format!("how often and how long {name} was violated is unsure: {why}")))
        };
        properties.iter().zip(self.later.iter().zip(&self.extents)).filter_map(of).collect()
    }
}

/// The requested properties.
pub(crate) fn load(files: &[PathBuf], system: &System) -> Result<Vec<Property>, Error> {
    if files.is_empty() {
        let help = "name a file with properties: `--property FILE`; only recordings by steward have properties of \
                    their own";
        return Err(Error::refused("no property to check the log against is given".to_owned(), help));
    }
    let mut properties: Vec<Property> = Vec::new();
    for path in files {
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

/// The name of a log.
pub(super) fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// A log that is to be judged.
pub(super) struct Judged<'l> {
    /// The command that judges it again.
    pub(super) command: String,
    pub(super) name: String,
    /// The folder of its report, if there is one.
    pub(super) folder: Option<&'l Path>,
    /// Whether the stories of violations are wanted even without one.
    pub(super) stories: bool,
    /// What it is, in words.
    pub(super) about: String,
    /// The text of its mapping.
    pub(super) mapping: String,
    /// The files that it is judged by, if results are wanted.
    pub(super) inputs: Vec<InputFile>,
    pub(super) system: &'l System,
    pub(super) around: &'l Around,
    /// Reports verdicts as they are reached, if that is wanted.
    pub(super) announcer: Option<Announcer>,
    /// Shows everything on a page meanwhile, if that is wanted.
    pub(super) board: Option<&'l BoardArgs>,
}

impl Judged<'_> {
    /// Makes the monitors judge the events; also writes the report to the folder, if there is one. `doubts` says what
    /// may be missing.
    pub(super) fn judge(
        mut self,
        events: impl Iterator<Item = Result<Found, Error>>,
        properties: &mut [Property],
        doubts: Doubts,
    ) -> Result<Judgment, Error> {
        let announcer = self.announcer.take();
        let judgment = match (self.folder, self.board) {
            (None, None) if !self.stories => judge_in_words(events, properties, doubts, self.around, announcer),
            _ => self.show(events, properties, doubts, announcer),
        }?;
        Ok(Judgment { inputs: self.inputs, ..judgment })
    }

    /// The same with all records, for those who look at them.
    fn show(
        &self,
        mut events: impl Iterator<Item = Result<Found, Error>>,
        properties: &mut [Property],
        doubts: Doubts,
        mut announcer: Option<Announcer>,
    ) -> Result<Judgment, Error> {
        let Self { around, system, .. } = self;
        let mut idle = || announcer.iter_mut().for_each(|announcer| announcer.idle(properties, around));
        let first = around.sight.iter().flat_map(|sight| await_sight(sight, &mut events, &mut idle));
        let first: Vec<_> = first.collect();
        let events = first.into_iter().chain(events);
        let folder = self.folder.map(Path::to_owned);
        let outputs = Outputs { folder, stories: self.stories, ..Outputs::default() };
        refuse_campaign(&outputs)?;
        let (text, recorded) = (self.mapping.clone(), Some(self.command.clone()));
        let origin = Origin { text, recorded, inputs: self.inputs.clone(), ..Origin::default() };
        let about = [self.name.clone(), self.about.clone()];
        let (mut judge, mut header, start) =
            Judge::begin(about, origin, &system.topology, system.tick, properties, doubts);
        around.describe(&mut header);
        let mut looking = Looking::begin(around, &header);
        let mut places = around.way.iter().flat_map(|way| &way.places).peekable();
        let mut view = RunView::new(header, start).expect(FITS);
        let mut presentation = Presentation::begin(&view, &outputs)?;
        let mut page = self.board.map(|_| LivePage::begin(&view)).transpose()?;
        if let (Some(board), Some(page)) = (self.board, &page) {
            board.follow(&page.recording())?;
        }
        let mut events = events.peekable();
        while let Some(event) = events.next() {
            match event? {
                Found::Event(event) => {
                    while let Some(place) = places.next_if(|place| around.time(place) <= event.time) {
                        let time = around.time(place).max(view.time());
                        view.apply(judge.place(time, place.pose, None)).expect(FITS);
                        presentation.follow(&view)?;
                    }
                    if let Some((pose, scene)) = looking.as_mut().and_then(|looking| looking.look(event.time, around)) {
                        let time = event.time.max(view.time());
                        view.apply(judge.place(time, pose, scene)).expect(FITS);
                        presentation.follow(&view)?;
                        page.iter_mut().try_for_each(|page| page.follow(&view))?;
                    }
                    let number = event.step;
                    let mut step = judge.step(event, properties);
                    around.answers.iter().for_each(|answers| answers.add(number, &mut step));
                    view.apply(step).expect(FITS);
                    if let Some(page) = &mut page {
                        page.follow(&view)?;
                    }
                }
                Found::LeftOut(gap) => judge.miss(&gap, properties),
                Found::Resumed(channel) => judge.resume(channel, properties),
                Found::Ended(time) => view.apply(judge.end_at(time)).expect(FITS),
                Found::Vouched(channel, ground) => judge.vouch(channel, ground),
                Found::Noted(note) => announcer.iter().for_each(|announcer| announcer.note(&note)),
                Found::Idle => {
                    announcer.iter_mut().for_each(|announcer| announcer.idle(properties, around));
                    page.iter_mut().try_for_each(LivePage::show)?;
                    continue;
                }
            }
            if let Some(announcer) = &mut announcer {
                announcer.follow(view.time(), properties, judge.doubts(), around)?;
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
        let report = presentation.finish(&view)?;
        if let Some(page) = page {
            page.finish(&view)?;
        }
        let stories = report.monitors.into_iter().map(|monitor| monitor.story).collect();
        Ok(Judgment { stories, ..Judgment::of(judge.end(), judge.doubts(), properties) })
    }
}

/// Waits until a robot can be shown, but not for long. Returns what has been found meanwhile.
#[expect(clippy::disallowed_methods, reason = "a robot is waited for in real time")]
fn await_sight(
    sight: &RefCell<Sight>,
    events: &mut impl Iterator<Item = Result<Found, Error>>,
    idle: &mut impl FnMut(),
) -> Vec<Result<Found, Error>> {
    let (mut found, asked) = (Vec::new(), Instant::now());
    while sight.borrow_mut().missing().is_some() && asked.elapsed() < LONGEST_WAIT {
        match events.next() {
            Some(Ok(Found::Idle)) => idle(),
            Some(next) => found.push(next),
            None => break,
        }
    }
    let mut sight = sight.borrow_mut();
    sight.unread().for_each(note);
    sight.missing().into_iter().for_each(note);
    found
}

/// The same without a report, which is faster.
pub(super) fn judge_in_words(
    events: impl Iterator<Item = Result<Found, Error>>,
    properties: &mut [Property],
    mut doubts: Doubts,
    around: &Around,
    mut announcer: Option<Announcer>,
) -> Result<Judgment, Error> {
    let mut end = LogEnd::default();
    for found in events {
        match found? {
            Found::Event(event) => {
                end.count(&event);
                properties.iter_mut().for_each(|property| property.monitor.observe(&event));
                doubts.observe(&event, properties);
            }
            Found::LeftOut(gap) => doubts.miss(&gap, properties),
            Found::Resumed(channel) => doubts.resume(channel, properties),
            Found::Ended(time) => end.ended = Some(time),
            Found::Vouched(channel, ground) => doubts.vouch(channel, ground),
            Found::Noted(note) => announcer.iter().for_each(|announcer| announcer.note(&note)),
            Found::Idle => {
                announcer.iter_mut().for_each(|announcer| announcer.idle(properties, around));
                continue;
            }
        }
        if let Some(announcer) = &mut announcer {
            announcer.follow(end.time(), properties, &doubts, around)?;
        }
    }
    Ok(Judgment::of(end, &doubts, properties))
}
