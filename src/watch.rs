//! `steward watch`: checks a running robot against properties.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::rc::Rc;
use std::time::{Duration, Instant};

use bags::{BagWriter, Recorder, Source};
use campaigns::Error;
use clap::Args;
use network::{Bridge, Robot};
use reports::html::quoted;
use serde_json::json;

use crate::interrupt;
use crate::live::BoardArgs;
use crate::output::{note, print, print_json, print_json_line, print_wrapped};
use crate::verify::announcer::Announcer;
use crate::verify::bag::contents;
use crate::verify::growing::pause;
use crate::verify::mapped::{Mapped, await_topics, load_mapping};
use crate::verify::{self, bag};

/// How long a robot is listened to for a list: long enough for what comes once a second.
const LISTEN: Duration = Duration::from_secs(2);

/// What verdicts leave open that rest on a bridge's word.
const AS_TOLD: &str = "as the bridge told it: a bridge that is too slow drops messages, and may not report it";

/// A running robot, and the properties to check.
#[derive(Debug, Args)]
pub(crate) struct WatchArgs {
    /// Listens to the robot's Foxglove bridge: `ws://HOST:8765`
    #[arg(long, value_name = "URL")]
    foxglove: String,
    /// A property file, or the name of a shipped one; may be given more than once
    #[arg(long = "property", value_name = "FILE")]
    properties: Vec<PathBuf>,
    /// The scenario whose processes and channels they mention [default: those of the mapping]
    #[arg(long, value_name = "NAME|FILE")]
    scenario: Option<String>,
    /// Maps the robot's messages to channels: a TOML file, which `--list` proposes
    #[arg(long, value_name = "FILE")]
    map_channels: Option<PathBuf>,
    /// Ends after so many seconds [default: at Ctrl-C]
    #[arg(long, value_name = "SECONDS")]
    seconds: Option<f64>,
    /// Writes the report with its page to DIR
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Writes the messages to FILE, an MCAP file: `steward verify` judges them again, with the same verdicts
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Starts CMD with each violation, in a shell; it reads the verdict from its standard input, as JSON
    #[arg(long, value_name = "CMD")]
    on_violation: Option<String>,
    #[command(flatten)]
    board: BoardArgs,
    /// Lists what the robot tells instead, and proposes a mapping
    #[arg(long, conflicts_with_all = ["properties", "scenario", "map_channels", "seconds", "out", "record", "on_violation", "live"])]
    list: bool,
    /// Prints lines of JSON instead of text, or the list as JSON
    #[arg(long)]
    json: bool,
}

/// Watches until Ctrl-C, or for as long as asked. Status 1 if a property is violated, or its verdict is unsure.
pub(crate) fn watch(args: &WatchArgs) -> Result<ExitCode, Error> {
    interrupt::listen();
    let path = Path::new(&args.foxglove);
    if args.list {
        return list(args);
    }
    let Some(mapping) = &args.map_channels else {
        let message = "there is no mapping from the robot's messages to channels";
        let help = format!(
            "add `--map-channels FILE`; `steward watch --foxglove {} --list` proposes such a file",
            quoted(&args.foxglove)
        );
        return Err(Error::refused(message, help));
    };
    let (mapping, text) = load_mapping(mapping)?;
    let topics: BTreeSet<String> = mapping.topics().map(str::to_owned).collect();
    let mut bridge = connect(args, Some(topics.clone()))?;
    note(&format!("listening to {}", bridge.name()));
    let is_to_end = ends_after(args.seconds)?;
    if await_topics(&mut bridge, &mapping, &is_to_end) {
        // What is latched comes again.
        bridge.end();
        bridge = connect(args, Some(topics))?;
    }
    let survey = bridge.survey().clone();
    let recorded = args.record.as_deref().map(record).transpose()?;
    let source: Box<dyn Source> = match &recorded {
        Some(file) => Box::new(Recorder::new(bridge, Rc::clone(file))),
        None => Box::new(bridge),
    };
    let mapped = Mapped {
        name: args.foxglove.clone(),
        about: format!("A robot, as the bridge at {} told it", args.foxglove),
        mapping: &mapping,
        text,
        properties: &args.properties,
        scenario: args.scenario.as_deref(),
        folder: args.out.as_deref(),
        command: args.command(),
        way: None,
        announcer: Some(Announcer::new(args.json, args.on_violation.clone())),
        board: Some(&args.board).filter(|board| board.is_live()),
    };
    let mut verified = mapped.judge(&survey, source, &is_to_end)?;
    let written = recorded
        .zip(args.record.as_ref())
        .map_or(Ok(()), |(file, path)| file.borrow_mut().finish().map_err(|source| unwritten(path, source)));
    verified.notes.push(AS_TOLD.to_owned());
    verified.notes.iter().for_each(|text| note(text));
    if args.json {
        let mut report = verify::as_json(&verified, path);
        report["loss"] = json!("unknown");
        print_json_line(&report)?;
    } else {
        print_wrapped(verify::in_words(&verified))?;
    }
    written?;
    if args.board.is_live() && interrupt::flow().is_continue() {
        note("Ctrl-C ends the page");
        while interrupt::flow().is_continue() {
            pause();
        }
    }
    Ok(ExitCode::from(u8::from(verified.is_bad())))
}

impl WatchArgs {
    /// The command that judges the messages again, if they were recorded, or otherwise watches again.
    fn command(&self) -> String {
        let mut words = match &self.record {
            Some(file) => vec!["steward verify".to_owned(), quoted(&file.to_string_lossy())],
            None => vec!["steward watch --foxglove".to_owned(), quoted(&self.foxglove)],
        };
        let files = |name: &str, file: &Path| [name.to_owned(), quoted(&file.to_string_lossy())];
        words.extend(self.properties.iter().flat_map(|file| files("--property", file)));
        words.extend(self.map_channels.iter().flat_map(|file| files("--map-channels", file)));
        words.extend(self.scenario.iter().flat_map(|name| files("--scenario", Path::new(name))));
        words.join(" ")
    }
}

fn connect(args: &WatchArgs, topics: Option<BTreeSet<String>>) -> Result<Bridge, Error> {
    Bridge::connect(&args.foxglove, topics).map_err(|error| Error::refused(error.to_string(), error.help()))
}

/// Prints what a robot tells of itself within a short time.
fn list(args: &WatchArgs) -> Result<ExitCode, Error> {
    let mut bridge = connect(args, None)?;
    let (is_to_end, mut body) = (ends_after(Some(LISTEN.as_secs_f64()))?, Vec::new());
    while !is_to_end() {
        bridge.receive(&mut body);
    }
    bridge.end();
    let mut survey = bridge.survey().clone();
    survey.lost.extend(bridge.lost().iter().cloned());
    let (contents, Robot { nodes, actions, services }) = (contents(&survey), bridge.robot());
    if args.json {
        let mut listed = bag::as_json(&contents, Path::new(&args.foxglove));
        listed["nodes"] = json!(nodes);
        listed["actions"] = json!(actions);
        let of = |(name, kind): (&String, &Option<String>)| json!({ "name": name, "type": kind });
        listed["services"] = services.iter().map(of).collect();
        print_json(&listed)?;
    } else {
        let nodes = nodes.iter().map(|name| format!("# node     {name}\n"));
        let actions = actions.iter().map(|name| format!("# action   {name}\n"));
        let of = |(name, kind): (&String, &Option<String>)| {
            format!("# service  {name}  {}", kind.as_deref().unwrap_or_default()).trim_end().to_owned() + "\n"
        };
        let text: String = nodes.chain(actions).chain(services.iter().map(of)).collect();
        print(&(text + &bag::in_words(&contents)))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Whether to end: once the time is over, or when the program is asked to.
#[expect(clippy::disallowed_methods, reason = "a robot is watched in real time")]
fn ends_after(seconds: Option<f64>) -> Result<impl Fn() -> bool, Error> {
    let time = seconds.map(Duration::try_from_secs_f64).transpose();
    let time = time.map_err(|_| Error::refused("`--seconds` is a number from 0 up", "for example `--seconds 60`"))?;
    let begun = Instant::now();
    Ok(move || interrupt::flow().is_break() || time.is_some_and(|time| begun.elapsed() >= time))
}

fn record(path: &Path) -> Result<Rc<RefCell<BagWriter<BufWriter<File>>>>, Error> {
    let begun = File::create(path).and_then(|file| BagWriter::begin(BufWriter::new(file)));
    Ok(Rc::new(RefCell::new(begun.map_err(|source| unwritten(path, source))?)))
}

fn unwritten(path: &Path, source: std::io::Error) -> Error {
    diagnostics::Error::Write { path: path.to_owned(), source }.into()
}
