//! `steward watch`: checks a running robot against properties.

mod presence;
mod target;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Duration;

use bags::{BagWriter, Mapping, Recorder, Source, Through};
use campaigns::Error;
use clap::Args;
use judging::{BlackBox, Mapped, ShowRun, Wanted, await_topics, check_no_metadata, load_mapping};
use network::{Live, Robot};
use reports::html::quoted;
use serde_json::{Value, json};

use crate::interrupt::{self, HOST};
use crate::live::BoardArgs;
use crate::moment::moment;
use crate::out_file::OutFile;
use crate::output::{note, print, print_json, print_json_line, print_wrapped};
use crate::verify::announcer::{Alarm, Announcer, Reactions};
use crate::verify::args::RobotsArgs;
use crate::verify::bag::contents;
use crate::verify::inputs::inputs;
use crate::verify::{self, bag};
use presence::Presence;
use target::{TargetArgs, refused};

/// How long a list takes: long enough to receive what comes once a second.
const LISTEN: Duration = Duration::from_millis(2500);

/// How long it takes at most: until there is something, and all participants have announced their nodes, which they may
/// do only when requested again.
const LONGEST_LISTEN: Duration = Duration::from_secs(6);

/// A running robot, and the properties to check.
#[derive(Debug, Args)]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    target: TargetArgs,
    /// A property file, or the name of a shipped one; may be given more than once
    #[arg(long = "property", value_name = "FILE")]
    properties: Vec<PathBuf>,
    /// The scenario whose processes and channels they mention [default: those of the mapping]
    #[arg(long, value_name = "NAME|FILE")]
    scenario: Option<String>,
    /// Maps the robot's messages to channels: a TOML file, which `--list` proposes
    #[arg(long, value_name = "FILE")]
    map_channels: Option<PathBuf>,
    #[command(flatten)]
    robots: RobotsArgs,
    /// Ends after so many seconds [default: at Ctrl-C]
    #[arg(long, value_name = "SECONDS")]
    seconds: Option<f64>,
    /// Writes the report with its page to DIR
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Writes the messages to FILE, an MCAP file: `steward verify` judges them again, with the same verdicts
    #[arg(long, value_name = "FILE")]
    record: Option<OutFile>,
    /// Starts CMD with each violation, in a shell; it reads the verdict from its standard input, as JSON
    #[arg(long, value_name = "CMD")]
    on_violation: Option<String>,
    /// Writes the last moments before each violation, such as `60s`, to a file of its own: an MCAP file beside the
    /// report, or here
    #[arg(long, value_name = "SPAN", value_parser = span)]
    black_box: Option<f64>,
    /// Publishes how the properties stand: all on `/diagnostics`, and each on `/steward/properties/NAME`. Without this,
    /// nothing is published
    #[arg(long, conflicts_with = "foxglove")]
    diagnostics: bool,
    #[command(flatten)]
    board: BoardArgs,
    /// Lists what the robot sends instead, and proposes a mapping
    #[arg(long, conflicts_with_all = ["properties", "scenario", "map_channels", "seconds", "out", "record", "on_violation", "black_box", "diagnostics", "live"])]
    list: bool,
    /// Prints lines of JSON instead of text, or the list as JSON
    #[arg(long)]
    json: bool,
}

/// Watches until Ctrl-C, or for the requested time. Status 2 if a property has no verdict, otherwise 1 if one is
/// violated, or its verdict is unsure.
///
/// # Errors
/// Also if nothing was ever known of a robot.
pub(crate) fn watch(args: &WatchArgs) -> Result<ExitCode, Error> {
    interrupt::listen();
    if args.list {
        return list(args);
    }
    let Some(mapping) = &args.map_channels else {
        let message = "there is no mapping from the robot's messages to channels";
        let help = format!("add `--map-channels FILE`; `{} --list` proposes such a file", args.target.command());
        return Err(Error::refused(message, help));
    };
    args.out.as_deref().map_or(Ok(()), check_no_metadata)?;
    let robots = args.robots.robots()?;
    let (mapping, text) = load_mapping(mapping, robots)?;
    let mapping = args.without_images(mapping);
    let judged: BTreeSet<String> = mapping.topics().map(str::to_owned).collect();
    let shown = mapping.robot().filter(|_| args.board.is_live());
    let shown: BTreeSet<String> = shown.iter().flat_map(|robot| robot.names()).map(str::to_owned).collect();
    let connected = args.target.connect(Some(&judged | &shown))?;
    let presence = Presence::new(connected, args.target.absence());
    let is_there = presence.is_there();
    let mut robot: Box<dyn Live> = Box::new(presence);
    robot.only_show(&shown - &judged);
    note(&format!("listening to {}", robot.name()));
    let is_to_end = ends_after(args.seconds)?;
    refuse_unknown_calls(&mapping, robot.as_ref())?;
    await_topics(robot.as_mut(), &mapping, &is_to_end, note);
    robot.begin().map_err(refused)?;
    let publish = args.diagnostics.then(|| robot.status_publisher()).flatten();
    if publish.is_some() {
        note("publishing how the properties stand on /diagnostics and /steward/properties/…");
    }
    let (survey, counts_losses) = (robot.survey().clone(), robot.counts_losses());
    let recorded = args.record.as_deref().map(record).transpose()?;
    let source: Box<dyn Source> = match &recorded {
        Some(file) => Box::new(Recorder::new(robot, Rc::clone(file))),
        None => robot,
    };
    let kept = args.black_box.map(|span_s| Rc::new(RefCell::new(BlackBox::new((span_s * 1e9) as i64, counts_losses))));
    let source: Box<dyn Source> = match &kept {
        Some(kept) => {
            let kept = Rc::clone(kept);
            Box::new(Through::new(source, move |source: &mut Box<dyn Source>, body: &mut Vec<u8>| {
                let received = source.receive(body);
                kept.borrow_mut().keep(received, body, source.survey(), source.lost());
                received
            }))
        }
        None => source,
    };
    let reactions = Reactions { hook: args.on_violation.clone(), alarm: kept.map(|kept| args.alarm(kept)), publish };
    let page: ShowRun<'_> = &|view| args.board.feed(view);
    let wanted = Wanted {
        command: args.command(),
        folder: args.out.as_deref(),
        stories: false,
        inputs: &|| inputs(&args.properties, &[]),
        observer: Some(Announcer::boxed(args.json, reactions)),
        record: None,
        page: args.board.is_live().then_some(page),
        host: HOST,
    };
    let mapped = Mapped {
        name: args.target.name(),
        about: args.target.about(),
        mapping: &mapping,
        text,
        properties: &args.properties,
        robots: robots.spaces,
        scenario: args.scenario.as_deref(),
        trajectory: None,
        is_robot: true,
    };
    let verified = mapped.judge(&survey, source, &is_to_end, wanted)?;
    let written = recorded
        .zip(args.record.as_ref())
        .map_or(Ok(()), |(file, path)| file.borrow_mut().finish().map_err(|source| unwritten(path, source)));
    if !is_there.get() {
        let [what, why] = args.target.absence();
        return Err(Error::refused(what, why));
    }
    verified.notes.iter().for_each(|text| note(text));
    if args.json {
        let mut report = verify::as_json(&verified, Path::new(&args.target.name()));
        report["loss"] = json!(if counts_losses { "counted" } else { "unknown" });
        print_json_line(&report)?;
    } else {
        print_wrapped(verify::in_words(&verified))?;
    }
    written?;
    args.board.stay();
    Ok(ExitCode::from(verified.status()))
}

impl WatchArgs {
    /// The alarm that writes the black box at each violation.
    fn alarm(&self, kept: Rc<RefCell<BlackBox>>) -> Alarm {
        let folder = self.out.clone().unwrap_or_default();
        Box::new(move |property, verdict| {
            let written = std::fs::create_dir_all(folder.join("."))
                .and_then(|()| kept.borrow_mut().write(&folder, property, &verdict.to_string()));
            match written {
                Ok(path) => path.map(|path| format!("what led to it is in {}", path.display())),
                Err(error) => Some(format!("what led to it could not be written: {error}")),
            }
        })
    }

    /// The mapping without images that no property needs, unless all messages are recorded or shown.
    fn without_images(&self, mapping: Mapping) -> Mapping {
        let texts = self.properties.iter().map(|path| diagnostics::text_from_disk(path));
        // Properties that come with the program have no file. A file that cannot be read is refused later.
        let Ok(texts) = texts.collect::<Result<Vec<String>, _>>() else { return mapping };
        if self.record.is_some() || self.black_box.is_some() || self.board.is_live() {
            return mapping;
        }
        let (mapping, left_out) = mapping.without_large(|sender| texts.iter().any(|text| text.contains(sender)));
        if !left_out.is_empty() {
            let topics = left_out.join(", ");
            note(&format!("no property mentions the messages on {topics}: these are not subscribed to"));
        }
        mapping
    }

    /// The command that judges the messages again, if they were recorded; otherwise, the one that watches again.
    fn command(&self) -> String {
        let mut words = match &self.record {
            Some(file) => vec!["steward verify".to_owned(), quoted(&file.to_string_lossy())],
            None => vec![self.target.command()],
        };
        words.extend(self.robots.words(&self.properties, self.map_channels.as_deref(), self.scenario.as_deref()));
        words.join(" ")
    }
}

/// Refuses a mapping of a service's calls without introspection: subscribing to the requests themselves would do harm.
fn refuse_unknown_calls(mapping: &Mapping, robot: &dyn Live) -> Result<(), Error> {
    let service = mapping.awaited(robot.survey()).and_then(|topic| topic.strip_suffix("/_service_event"));
    let Some(service) = service.filter(|service| robot.robot().services.contains_key(*service)) else { return Ok(()) };
    let message = format!("the calls of the service {service} are unknown: its node does not publish them");
    let help = "turn on its introspection in the node that offers it, `service.configure_introspection(…)`, or in the one that \
                calls it; or give the topic a `type`: then the watch begins without it";
    Err(Error::refused(message, help))
}

/// Prints the nodes, actions, services and topics of a robot that are discovered within a short time.
fn list(args: &WatchArgs) -> Result<ExitCode, Error> {
    let mut live = args.target.connect(None)?;
    let is_over = |time: Duration| ends_after(Some(time.as_secs_f64()));
    let (is_listed, is_to_end, mut body) = (is_over(LISTEN)?, is_over(LONGEST_LISTEN)?, Vec::new());
    let is_open = |live: &dyn Live| live.robot().unnamed > 0 || !presence::is_there(live);
    while !is_listed() || is_open(live.as_ref()) && !is_to_end() {
        live.receive(&mut body);
    }
    if !presence::is_there(live.as_ref()) {
        live.end();
        let [what, why] = args.target.absence();
        return Err(Error::refused(what, why));
    }
    let Robot { nodes, unnamed, actions, services, publishers } = live.robot().clone();
    live.end();
    let mut survey = live.survey().clone();
    survey.lost.extend(live.lost().iter().cloned());
    survey.lost.extend((unnamed > 0).then(|| match unnamed {
        1 => "a process of the robot has not announced its nodes".to_owned(),
        more => format!("{more} processes of the robot have not announced their nodes"),
    }));
    let contents = contents(&survey);
    let typed = |all: &BTreeMap<String, Option<String>>| -> Value {
        all.iter().map(|(name, kind)| json!({ "name": name, "type": kind })).collect()
    };
    let is_introspected = |service: &str| {
        let is_event = |topic: &str| topic.strip_suffix("/_service_event") == Some(service);
        survey.topics.iter().any(|topic| is_event(&topic.name))
    };
    if args.json {
        let mut listed = bag::as_json(&contents, Path::new(&args.target.name()));
        listed["nodes"] = json!(nodes);
        (listed["actions"], listed["services"]) = (typed(&actions), typed(&services));
        for service in listed["services"].as_array_mut().into_iter().flatten() {
            let is_introspected = service["name"].as_str().is_some_and(is_introspected);
            service["introspected"] = is_introspected.into();
        }
        listed["publishers"] = json!(publishers);
        print_json(&listed)?;
    } else {
        let nodes = nodes.iter().map(|name| format!("# node     {name}\n"));
        let of = |what: &'static str| {
            move |(name, kind): (&String, &Option<String>)| {
                format!("# {what:8} {name}  {}", kind.as_deref().unwrap_or_default()).trim_end().to_owned() + "\n"
            }
        };
        let hidden = |(name, kind): (&String, &Option<String>)| {
            let why = if is_introspected(name) { "" } else { "  without introspection: its calls cannot be mapped" };
            of("service")((name, kind)).trim_end().to_owned() + why + "\n"
        };
        let text: String = nodes.chain(actions.iter().map(of("action"))).chain(services.iter().map(hidden)).collect();
        print(&(text + &bag::in_words(&contents, &publishers)))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Whether to end: once the time is over, or when the program is interrupted.
fn ends_after(seconds: Option<f64>) -> Result<impl Fn() -> bool, Error> {
    let time = seconds.map(Duration::try_from_secs_f64).transpose();
    let time = time.map_err(|_| Error::refused("`--seconds` is a number from 0 up", "for example `--seconds 60`"))?;
    let begun = moment();
    Ok(move || interrupt::flow().is_break() || time.is_some_and(|time| begun.elapsed() >= time))
}

/// A span of time as it is written: `60s`, `90` or `2min`, in seconds.
fn span(text: &str) -> Result<f64, String> {
    let (number, unit_s) = match text.strip_suffix("min") {
        Some(number) => (number, 60.0),
        None => (text.strip_suffix('s').unwrap_or(text), 1.0),
    };
    let span_s = number.trim().parse::<f64>().ok().map(|number| number * unit_s);
    span_s.filter(|span_s| (0.1..=3600.0).contains(span_s)).ok_or_else(|| "from 0.1s to 60min".to_owned())
}

fn record(path: &Path) -> Result<Rc<RefCell<BagWriter<BufWriter<File>>>>, Error> {
    diagnostics::writing(path)?;
    let begun = File::create(path).and_then(|file| BagWriter::begin(BufWriter::new(file)));
    Ok(Rc::new(RefCell::new(begun.map_err(|source| unwritten(path, source))?)))
}

fn unwritten(path: &Path, source: std::io::Error) -> Error {
    diagnostics::Error::Write { path: path.to_owned(), source }.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_have_units() {
        assert_eq!(["60s", "90", "2min", "0.5 s"].map(span), [60.0, 90.0, 120.0, 0.5].map(Ok));
        for wrong in ["", "s", "0", "-1", "61min", "NaN", "1h"] {
            assert!(span(wrong).is_err(), "{wrong}");
        }
    }
}
