//! Conducts a run from its start to its end: pictures at the named moments, the event log, and the report.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::Error;
use crate::draw::{GifWriter, Renderer};
use crate::ending::Ending;
use crate::live::{Live, News, StepError};
use crate::pictures::Camera;
use crate::report::{Report, SnapshotReport};
use crate::scenario::{Moment, Scenario};
use crate::timeline::Timeline;
use crate::trace::Recorder;
use crate::{draw, html, reporting};

/// What a run is to leave behind.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// The folder for the report and the pictures; nothing is written without one.
    pub folder: Option<PathBuf>,
    /// Whether pictures are taken.
    pub snapshots: bool,
    /// Where an animation goes.
    pub gif: Option<PathBuf>,
    /// Where the event log goes.
    pub record: Option<PathBuf>,
}

/// How long a picture of an animation stays.
const GIF_FRAME: Duration = Duration::from_millis(100);
/// Time between the pictures of an animation while the robot is under way, and while it is charged.
const GIF_PERIODS: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(30)];

/// Runs a scenario to its end. `watch` says whether with monitors; `progress` is called at the start and then after every
/// simulated second.
///
/// # Errors
/// What is wrong with the scenario; what could not be written.
pub fn conduct(
    scenario: Arc<Scenario>,
    seed: u64,
    watch: bool,
    outputs: &Outputs,
    mut progress: impl FnMut(&Live),
) -> Result<Report, Error> {
    #[expect(clippy::disallowed_methods, reason = "how long the computer took is no part of the run")]
    let began = Instant::now();
    let mut live = Live::new(Arc::clone(&scenario), seed, watch)?;
    let mut log = outputs.record.as_deref().map(|path| Log::begin(path, &scenario, seed)).transpose()?;
    let mut album = Album::begin(&live, seed, outputs)?;
    let mut ending = Ending::default();
    let mut timeline = outputs.folder.is_some().then(|| Timeline::new(&live));
    progress(&live);
    let mut next_progress = Duration::from_secs(1);
    let because = loop {
        let news = match live.step(log.as_mut().map(|log| &mut log.recorder)) {
            Ok(news) => news,
            Err(StepError::Run(error)) => {
                log.map_or(Ok(()), Log::finish)?;
                return Err(error.into());
            }
            Err(StepError::Budget(limit)) => {
                log.map_or(Ok(()), Log::finish)?;
                return Err(Error::Budget(limit));
            }
            Err(StepError::Record(source)) => {
                return Err(log.map_or(Error::Draw(source.to_string()), |log| log.failed(source)));
            }
        };
        let over = ending.reached(&live, &news);
        album.take(&live, &news, over.is_some())?;
        if let Some(timeline) = &mut timeline {
            timeline.follow(&live, &news);
        }
        if live.time() >= next_progress {
            progress(&live);
            next_progress += Duration::from_secs(1);
        }
        if let Some(because) = over {
            break because;
        }
    };
    if let Some(log) = log {
        log.finish()?;
    }
    let snapshots = album.finish()?;
    let report = reporting::report(&live, seed, &because, snapshots, began.elapsed());
    if let (Some(folder), Some(timeline)) = (&outputs.folder, &timeline) {
        write_report(folder, &report)?;
        html::write(folder, &live, timeline, &report)?;
    }
    Ok(report)
}

fn write_report(folder: &Path, report: &Report) -> Result<(), Error> {
    let path = folder.join("report.json");
    let text = serde_json::to_string_pretty(report).expect("a report is always JSON") + "\n";
    std::fs::write(&path, text).map_err(|source| Error::Write { path, source })
}

/// The event log on its way to a file.
struct Log {
    path: PathBuf,
    recorder: Recorder,
}

impl Log {
    fn begin(path: &Path, scenario: &Scenario, seed: u64) -> Result<Self, Error> {
        let failed = |source| Error::Write { path: path.to_owned(), source };
        let description = json!({
            "scenario": scenario.name,
            "seed": seed,
            "version": env!("CARGO_PKG_VERSION"),
            "tick_s": scenario.file.execution.tick.as_secs_f64(),
        });
        let file = BufWriter::new(create(path)?);
        let recorder = Recorder::new(file, &description).map_err(failed)?;
        Ok(Self { path: path.to_owned(), recorder })
    }

    fn failed(self, source: io::Error) -> Error {
        Error::Write { path: self.path, source }
    }

    fn finish(self) -> Result<(), Error> {
        let Self { path, recorder } = self;
        recorder.finish().map_err(|source| Error::Write { path, source })
    }
}

/// Creates a file, with the folders on the way.
fn create(path: &Path) -> Result<File, Error> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder
        .map_or(Ok(()), std::fs::create_dir_all)
        .and_then(|()| File::create(path))
        .map_err(|source| Error::Write { path: path.to_owned(), source })
}

/// The pictures of a run.
struct Album {
    seed: u64,
    /// None where no pictures are wanted.
    camera: Option<Camera>,
    renderer: Renderer,
    folder: Option<PathBuf>,
    taken: Vec<SnapshotReport>,
    next_regular: Option<Duration>,
    times: Vec<Duration>,
    animation: Option<Animation>,
}

/// An animation on its way to a file.
struct Animation {
    path: PathBuf,
    writer: GifWriter<File>,
    next: Duration,
}

impl Album {
    fn begin(live: &Live, seed: u64, outputs: &Outputs) -> Result<Self, Error> {
        if let Some(folder) = &outputs.folder {
            std::fs::create_dir_all(folder).map_err(|source| Error::Write { path: folder.clone(), source })?;
        }
        let folder = outputs.folder.clone().filter(|_| outputs.snapshots);
        let animation = outputs.gif.as_deref().map(Animation::begin).transpose()?;
        let moments = &live.scenario().file.snapshots;
        let mut times = moments.at_times.clone();
        times.sort_unstable_by(|a, b| b.cmp(a));
        Ok(Self {
            seed,
            camera: (folder.is_some() || animation.is_some()).then(|| Camera::new(live)),
            renderer: Renderer::new(),
            folder,
            taken: Vec::new(),
            next_regular: moments.every.map(|_| Duration::ZERO),
            times,
            animation,
        })
    }

    /// Takes the pictures that the step asks for.
    fn take(&mut self, live: &Live, news: &[News], over: bool) -> Result<(), Error> {
        let Some(mut camera) = self.camera.take() else { return Ok(()) };
        camera.follow(live);
        for (why, caption) in self.occasions(live, news, over) {
            self.shoot(&camera, live, &why, &caption, over)?;
        }
        if let Some(animation) = &mut self.animation
            && (live.time() >= animation.next || over)
        {
            animation.add(&self.renderer, &camera.frame(live, self.seed, &doing(live), over), live)?;
        }
        self.camera = Some(camera);
        Ok(())
    }

    /// The occasions for a picture that this step offers: a word for the file's name and a sentence for the picture.
    fn occasions(&mut self, live: &Live, news: &[News], over: bool) -> Vec<(String, String)> {
        let moments = &live.scenario().file.snapshots;
        let wanted = |moment| moments.at.contains(&moment);
        let mut occasions = Vec::new();
        let first = live.time() <= live.scenario().file.sim.dt;
        if first && wanted(Moment::Start) {
            occasions.push(("start".to_owned(), live.scenario().file.about.clone()));
        }
        for news in news {
            match news {
                News::Fault(index) if wanted(Moment::Fault) && live.is_first_time(*index) => {
                    let fault = &live.faults()[*index].fault;
                    occasions.push((format!("fault-{}", fault.kind().name), format!("Fault: {}", fault.words())));
                }
                News::Verdict(index) if wanted(Moment::Verdict) => {
                    occasions.push(verdict_occasion(live, *index));
                }
                News::Arrival(place) if wanted(Moment::Arrival) && !first => {
                    occasions.push((format!("arrival-{place}"), format!("The robot has come to rest at {place}")));
                }
                _ => {}
            }
        }
        if self.times.pop_if(|time| *time <= live.time()).is_some() {
            occasions.push(("moment".to_owned(), doing(live)));
        }
        if let (Some(next), Some(every)) = (&mut self.next_regular, moments.every)
            && live.time() >= *next
        {
            *next += every;
            occasions.push(("regular".to_owned(), doing(live)));
        }
        if over && wanted(Moment::End) {
            occasions.push(("end".to_owned(), "The run has ended".to_owned()));
        }
        occasions
    }

    fn shoot(&mut self, camera: &Camera, live: &Live, why: &str, caption: &str, over: bool) -> Result<(), Error> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let name: String = why.chars().map(|c| if c.is_alphanumeric() || "-_".contains(c) { c } else { '-' }).collect();
        let file = format!("{:02}-{name}.png", self.taken.len() + 1);
        let svg = draw::svg(&camera.frame(live, self.seed, caption, over));
        let png = self.renderer.png(&svg).map_err(|error| Error::Draw(error.to_string()))?;
        let path = folder.join(&file);
        std::fs::write(&path, png).map_err(|source| Error::Write { path, source })?;
        self.taken.push(SnapshotReport { file, time_s: live.time().as_secs_f64(), why: caption.to_owned() });
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
    fn begin(path: &Path) -> Result<Self, Error> {
        let writer = GifWriter::new(create(path)?, GIF_FRAME).map_err(|error| failed(path, error))?;
        Ok(Self { path: path.to_owned(), writer, next: Duration::ZERO })
    }

    fn add(&mut self, renderer: &Renderer, frame: &draw::Frame, live: &Live) -> Result<(), Error> {
        let stands = live.truth().battery().charging;
        self.next = live.time() + GIF_PERIODS[usize::from(stands)];
        self.writer.push(renderer, frame).map_err(|error| failed(&self.path, error))
    }

    fn finish(self) -> Result<(), Error> {
        let Self { path, writer, .. } = self;
        writer.finish().map(drop).map_err(|error| failed(&path, error))
    }
}

fn failed(path: &Path, error: draw::DrawError) -> Error {
    match error {
        draw::DrawError::Write(source) => Error::Write { path: path.to_owned(), source },
        error => Error::Draw(error.to_string()),
    }
}

fn verdict_occasion(live: &Live, index: usize) -> (String, String) {
    let watched = &live.watched()[index];
    let monitor = live.system().monitors()[index].monitor.as_ref();
    let outcome = monitors::Outcome::of(monitor);
    let tick = watched.decided.as_ref().map_or(0, |event| event.tick);
    (
        format!("{}-{outcome}", watched.name),
        format!("At tick {tick}, {} is {outcome}. It asks: {}", watched.name, watched.summary),
    )
}

/// What the tree is doing, in words: the leaf that is running.
pub(crate) fn doing(live: &Live) -> String {
    let states = live.tree_states();
    let running =
        live.scenario().tree.leaves().filter(|leaf| {
            matches!(states[leaf.id().index()].outcome, Some(bt::Outcome::Answered(bt::Status::Running)))
        });
    let names: Vec<&str> = running.map(bt::Node::label).collect();
    if names.is_empty() { "no leaf is running".to_owned() } else { format!("{} is running", names.join(", ")) }
}
