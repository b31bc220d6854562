//! Outputs made from a run's records: pictures at the named moments, an animation, the report and its page.

use diagnostics::seconds;
use std::cell::LazyCell;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use diagnostics::{Staging, Unfinished};
use drawing::{GifWriter, Renderer};
use monitors::Outcome;
use recording::{
    Decision, Detail, Follower, Happening, MonitorView, Recording, RunView, SceneClock, SnapshotOccasion, conduct,
};

use crate::file_name;
use crate::pictures::{self, Camera};
use crate::report::{Report, SnapshotReport};
use crate::timeline::Timeline;
use crate::{Error, html, reporting};

/// The outputs that show a run.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// The folder for the report and the pictures; nothing is written without one.
    pub folder: Option<PathBuf>,
    /// Whether the report contains the stories of violations even if it has no folder with a page.
    pub stories: bool,
    /// Whether pictures are taken.
    pub snapshots: bool,
    /// Whether the sequence charts of violations are also separate pictures.
    pub charts: bool,
    /// The file for an animation, if one is wanted.
    pub gif: Option<PathBuf>,
}

impl Outputs {
    /// Whether only a report is wanted, without stories, and not in a file.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.folder.is_none() && self.gif.is_none() && !self.stories
    }

    /// Checks before anything runs that no input is overwritten.
    ///
    /// # Errors
    /// [`Error::File`] if one would be.
    pub fn check(&self) -> Result<(), Error> {
        let Some(folder) = &self.folder else { return Ok(()) };
        Ok(diagnostics::check_unread_in(folder, |name| self.may_write(name))?)
    }

    /// Whether the run may write a file of this name into the folder. Which pictures it has is known only at its end.
    fn may_write(&self, name: &str) -> bool {
        let is_numbered = name.starts_with(|first: char| first.is_ascii_digit()) && name.ends_with(".png");
        [REPORT, html::FILE].contains(&name)
            || self.snapshots && is_numbered
            || self.charts && name.starts_with(html::CHART)
    }
}

/// The name of the report's file.
pub const REPORT: &str = "report.json";
/// How long an animation shows each picture.
const GIF_FRAME: Duration = Duration::from_millis(100);

/// Makes the outputs of a run while it goes on.
pub struct Presentation {
    began: Instant,
    staging: Option<Staging>,
    pictures: RunPictures,
    /// None if neither a page nor stories are requested.
    timeline: Option<Timeline>,
    charts: bool,
}

impl Presentation {
    /// Begins with a run at its start.
    ///
    /// # Errors
    /// [`Error`] if something cannot be written.
    pub fn begin(view: &RunView, outputs: &Outputs) -> Result<Self, Error> {
        #[expect(clippy::disallowed_methods, reason = "the computer's own time is not part of the run")]
        let began = Instant::now();
        outputs.check()?;
        let staging = outputs.folder.as_deref().map(Staging::begin).transpose()?;
        let snapshots = outputs.snapshots && staging.is_some();
        let pictures = RunPictures::begin(view, snapshots, outputs.gif.as_deref())?;
        let timeline = (staging.is_some() || outputs.stories).then(|| Timeline::new(view));
        Ok(Self { began, staging, pictures, timeline, charts: outputs.charts })
    }

    /// Writes the report of a run that has ended, with its page, and returns it. The pictures of an earlier report in
    /// the folder are removed.
    ///
    /// # Errors
    /// [`Error`] if something cannot be written.
    ///
    /// # Panics
    /// If the run has not ended.
    pub fn finish(self, view: &RunView) -> Result<Report, Error> {
        let snapshots = self.pictures.finish()?;
        let end = view.end().expect("a report is about a run that has ended");
        let mut report = reporting::report(view, end, snapshots, self.began.elapsed());
        for (property, story) in self.timeline.iter().flat_map(|timeline| html::stories(view, timeline)) {
            report.monitors[property].story = story;
        }
        if let (Some(mut staging), Some(timeline)) = (self.staging, &self.timeline) {
            staging.replace(stale_pictures(&staging));
            staging.write(REPORT, serde_json::to_string_pretty(&report).expect("a report is always JSON") + "\n")?;
            html::write(&staging, view, timeline, &report)?;
            if self.charts {
                html::write_charts(&staging, view, timeline)?;
            }
            staging.publish(&[REPORT, html::FILE])?;
        }
        Ok(report)
    }
}

impl Follower for Presentation {
    type Error = Error;

    fn follow(&mut self, view: &RunView) -> Result<(), Error> {
        self.pictures.take(view, self.staging.as_ref())?;
        let Ok(()) = self.timeline.follow(view);
        Ok(())
    }
}

/// The pictures that the present report in a folder names: those of an earlier run.
fn stale_pictures(staging: &Staging) -> Vec<String> {
    let text = staging.earlier(REPORT).unwrap_or_default();
    let report: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let files = report["snapshots"].as_array().into_iter().flatten().filter_map(|picture| picture["file"].as_str());
    files.filter(|file| file.ends_with(".png") && !file.contains(['/', '\\'])).map(str::to_owned).collect()
}

/// Makes the report of a recorded run, with its page and pictures, as the run itself did. If `record` is given, writes
/// the run to that file, as an [`Archive`](recording::Archive) does.
///
/// # Errors
/// [`Error`] if the recording cannot be read, or something cannot be written.
pub fn report_recording(recording: Recording, outputs: &Outputs, record: Option<&Path>) -> Result<Report, Error> {
    let begin = |view: &RunView| Presentation::begin(view, outputs);
    let goes_on = |_: &RunView| ControlFlow::Continue(());
    let (presentation, view) = conduct(recording, Detail::Full, record, begin, goes_on)?;
    presentation.finish(&view)
}

struct RunPictures {
    /// None if no pictures are wanted.
    camera: Option<Camera>,
    /// Made for the first picture, since making it takes longer than a short run.
    renderer: LazyCell<Renderer>,
    /// Whether snapshots are taken.
    snapshots: bool,
    clock: SceneClock,
    taken: Vec<SnapshotReport>,
    animation: Option<Animation>,
}

/// Why a picture is taken.
struct Occasion {
    /// A word for the file's name.
    word: String,
    /// A sentence for the picture.
    caption: String,
    /// Whether only the time is the reason.
    by_clock: bool,
    /// The property that has just been violated, if this is the reason.
    violated: Option<String>,
}

impl Occasion {
    fn happened(word: impl Into<String>, caption: impl Into<String>) -> Self {
        Self { word: word.into(), caption: caption.into(), by_clock: false, violated: None }
    }
}

/// An animation that is being written.
struct Animation {
    path: PathBuf,
    writer: GifWriter<Unfinished>,
    clock: SceneClock,
}

impl RunPictures {
    fn begin(view: &RunView, snapshots: bool, gif: Option<&Path>) -> Result<Self, Error> {
        let clock = SceneClock::new(&view.header().snapshots);
        let animation = gif.map(|path| Animation::begin(path, clock.clone())).transpose()?;
        Ok(Self {
            camera: (snapshots || animation.is_some()).then(|| Camera::new(view)),
            renderer: LazyCell::new(Renderer::new),
            snapshots,
            clock,
            taken: Vec::new(),
            animation,
        })
    }

    /// Takes the pictures that are due at the last step.
    fn take(&mut self, view: &RunView, folder: Option<&Staging>) -> Result<(), Error> {
        let Some(mut camera) = self.camera.take() else { return Ok(()) };
        let Ok(()) = camera.follow(view);
        if let Some(folder) = folder.filter(|_| self.snapshots) {
            for occasion in self.occasions(view) {
                self.shoot(&camera, view, occasion, folder)?;
            }
        }
        if let Some(animation) = &mut self.animation {
            let is_frame = animation.clock.is_frame(view.time(), view.robot().is_charging());
            if is_frame || view.end().is_some() {
                animation.add(&self.renderer, &camera.frame(view, &view.doing()))?;
            }
        }
        self.camera = Some(camera);
        Ok(())
    }

    /// The occasions for a picture at this step.
    fn occasions(&mut self, view: &RunView) -> Vec<Occasion> {
        let header = view.header();
        let wanted = |moment| header.snapshots.at.contains(&moment);
        let mut occasions = Vec::new();
        if view.time() <= header.dt && wanted(SnapshotOccasion::Start) {
            occasions.push(Occasion::happened("start", &header.about));
        }
        for happening in view.happenings() {
            match happening {
                Happening::FaultBegan { fault, time, .. } if wanted(SnapshotOccasion::Fault) => {
                    let mut records = view.faults().iter().filter(|record| record.index == *fault);
                    if records.next().is_some_and(|first| first.time == *time) {
                        let kind = &header.faults[*fault].kind;
                        let caption = format!("Fault: {}", happening.words(view));
                        occasions.push(Occasion::happened(format!("fault-{kind}"), caption));
                    }
                }
                Happening::Verdict { monitor, decision } => {
                    let monitor = view.monitor(*monitor);
                    // A violation always has a picture.
                    let violated = (monitor.outcome() == Outcome::Violated).then(|| monitor.name().to_owned());
                    if violated.is_some() || wanted(SnapshotOccasion::Verdict) {
                        let (word, caption) = verdict_occasion(monitor, decision, view);
                        occasions.push(Occasion { word, caption, by_clock: false, violated });
                    }
                }
                Happening::Arrival { place } if wanted(SnapshotOccasion::Arrival) && view.is_arrival(view.time()) => {
                    let place = &header.places()[*place].name;
                    let caption = format!("The robot has come to rest at {place}");
                    occasions.push(Occasion::happened(format!("arrival-{place}"), caption));
                }
                _ => {}
            }
        }
        if view.end().is_some() && wanted(SnapshotOccasion::End) {
            occasions.push(Occasion::happened("end", "The run has ended"));
        }
        let by_clock = |word| Occasion { by_clock: true, ..Occasion::happened(word, view.doing()) };
        let (named, regular) = (self.clock.is_named(view.time()), self.clock.is_regular(view.time()));
        occasions.extend(named.then(|| by_clock("moment")));
        // One picture per moment is enough.
        occasions.extend((regular && occasions.is_empty()).then(|| by_clock("regular")));
        occasions
    }

    fn shoot(
        &mut self,
        camera: &Camera,
        view: &RunView,
        Occasion { word, caption, by_clock, violated }: Occasion,
        folder: &Staging,
    ) -> Result<(), Error> {
        let file = format!("{:02}-{}.png", self.taken.len() + 1, file_name(&word));
        let svg = drawing::svg(&camera.frame(view, &caption));
        let png = self.renderer.png(&svg)?;
        folder.write(&file, png)?;
        let time_s = seconds(view.time());
        self.taken.push(SnapshotReport { file, time_s, why: caption, by_clock, violated });
        Ok(())
    }

    fn finish(self) -> Result<Vec<SnapshotReport>, Error> {
        if let Some(animation) = self.animation {
            animation.finish()?;
        }
        Ok(self.taken)
    }
}

impl Animation {
    fn begin(path: &Path, clock: SceneClock) -> Result<Self, Error> {
        let writer = GifWriter::new(Unfinished::create(path)?, GIF_FRAME);
        Ok(Self { path: path.to_owned(), writer, clock })
    }

    fn add(&mut self, renderer: &Renderer, frame: &drawing::Frame) -> Result<(), Error> {
        self.writer.push(renderer, frame).map_err(|error| failed(&self.path, error))
    }

    fn finish(self) -> Result<(), Error> {
        let Self { path, writer, .. } = self;
        Ok(writer.finish().map_err(|error| failed(&path, error))?.finish()?)
    }
}

fn failed(path: &Path, error: drawing::Error) -> Error {
    match error {
        drawing::Error::Write(source) => diagnostics::Error::Write { path: path.to_owned(), source }.into(),
        error => error.into(),
    }
}

fn verdict_occasion(monitor: MonitorView<'_>, decision: &Decision, view: &RunView) -> (String, String) {
    let (name, outcome) = (monitor.name(), monitor.outcome());
    let (when, summary) = (pictures::when(decision, view), &monitor.about.summary);
    (format!("{name}-{outcome}"), format!("At {when}, {name} is {outcome}: {summary}"))
}
