//! The arguments of `steward verify`.

use std::path::{Path, PathBuf};

use bags::Remapping;
use campaigns::Error;
use clap::Args;
use diagnostics::Disk;
use judging::{LogRequest, Robots};
use recording::{BagTree, InputFile};
use reports::html::quoted;
use scenarios::files::Kind;

use super::inputs::inputs;
use crate::bag_tree::BagTreeArgs;
use crate::live::BoardArgs;
use crate::results::{self, ResultsArgs};
use crate::ros_names::{namespace, remapping};

/// Whose messages they are.
#[derive(Debug, Default, Args)]
pub(crate) struct RobotsArgs {
    /// Checks each of several robots, by its namespace, such as `/r1`: topics of the mapping without `/` at the
    /// beginning are within it, and there is a property `r1/NAME` for each; may be given more than once
    #[arg(long = "robot", value_name = "NAMESPACE", value_parser = namespace, requires = "map_channels")]
    #[arg(conflicts_with = "scenario")]
    robots: Vec<String>,
    /// Reads the topic TO, or the topics of that service or action, where the mapping names FROM, as in ROS 2; may be
    /// given more than once
    #[arg(long = "remap", value_name = "FROM:=TO", value_parser = remapping, requires = "map_channels")]
    remapped: Vec<Remapping>,
}

impl RobotsArgs {
    /// The robots.
    pub(crate) fn robots(&self) -> Result<Robots<'_>, Error> {
        match self.robots.iter().enumerate().find(|(index, space)| self.robots[..*index].contains(space)) {
            Some((_, space)) => {
                Err(Error::refused(format!("the robot {space} is named twice"), "name each robot once"))
            }
            None => Ok(Robots { spaces: &self.robots, remapped: &self.remapped }),
        }
    }

    /// What the robots' messages are judged by, as words of a command.
    pub(crate) fn words(&self, properties: &[PathBuf], mapping: Option<&Path>, scenario: Option<&str>) -> Vec<String> {
        let file = |file: &Path| quoted(&file.to_string_lossy());
        let remapped = self.remapped.iter().map(|Remapping { from, to }| quoted(&format!("{from}:={to}")));
        let properties = properties.iter().map(|path| ("--property", file(path)));
        let mapping = mapping.map(|path| ("--map-channels", file(path)));
        let robots = self.robots.iter().map(|space| ("--robot", quoted(space)));
        let robots = robots.chain(remapped.map(|rule| ("--remap", rule)));
        let all = properties.chain(mapping).chain(robots).chain(scenario.map(|name| ("--scenario", quoted(name))));
        all.flat_map(|(option, value)| [option.to_owned(), value]).collect()
    }
}

/// Recorded runs and robots, and the properties to check.
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Event logs and recordings, as `--record FILE` writes them, and ROS 2 bags; `-` reads a log from standard
    /// input
    #[arg(value_name = "LOG", required = true)]
    pub(crate) logs: Vec<PathBuf>,
    /// A property file, or the name of a shipped one; may be given more than once [default: for a recording, the
    /// properties that its run watched]
    #[arg(long = "property", value_name = "FILE")]
    pub(crate) properties: Vec<PathBuf>,
    /// The scenario whose processes and channels they mention [default: the log's own; for a bag, those of its mapping]
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "tree")]
    pub(crate) scenario: Option<String>,
    /// Maps the messages of a bag to channels: a TOML file, which `--list` proposes
    #[arg(long, value_name = "FILE", conflicts_with = "tree")]
    pub(crate) map_channels: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) tree: BagTreeArgs,
    #[command(flatten)]
    pub(crate) robots: RobotsArgs,
    /// Writes the report of each log with its page to DIR; for several logs, to folders in it, with a page that leads
    /// to them
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) results: ResultsArgs,
    /// Follows a log that is still being written, an event log or a bag in MCAP files, until its end or Ctrl-C, and
    /// prints verdicts as they are reached
    #[arg(long, conflicts_with = "tree")]
    pub(crate) follow: bool,
    #[command(flatten)]
    pub(crate) board: BoardArgs,
    /// Lists the contents of bags instead, and proposes a mapping
    #[arg(long, conflicts_with_all = ["properties", "scenario", "map_channels", "tree", "out", "follow", "live"])]
    #[arg(conflicts_with_all = ["results", "junit"])]
    pub(crate) list: bool,
    /// Prints the verdicts, or the list, as JSON instead of text; for several logs, an array; with `--follow`, lines of
    /// JSON
    #[arg(long)]
    pub(crate) json: bool,
}

impl VerifyArgs {
    /// A log and what it is judged by.
    pub(super) fn request<'r>(&'r self, path: &'r Path, tree: Option<&'r BagTree>) -> Result<LogRequest<'r>, Error> {
        Ok(LogRequest {
            path,
            properties: &self.properties,
            scenario: self.scenario.as_deref(),
            mapping: self.map_channels.as_deref(),
            robots: self.robots.robots()?,
            tree,
            is_followed: self.follow,
        })
    }

    /// Finds the files with which the logs are judged by their names in diagnostics. Shipped properties and trees are
    /// not found, even if a file beside the scenario has the same name.
    pub(super) fn on_disk(&self) -> impl Fn(&str) -> Option<String> {
        let disk = Disk::default();
        let properties = self.properties.iter().map(|file| (Kind::Properties, file.as_path()));
        let named = properties.chain(self.tree.file().map(|file| (Kind::Tree, file)));
        let (shipped, on_disk): (Vec<_>, Vec<_>) = named.partition(|(kind, file)| kind.is_shipped(file, &disk));
        let [shipped, on_disk] =
            [shipped, on_disk].map(|named| named.iter().map(|(kind, file)| kind.path(file, &disk)).collect::<Vec<_>>());
        let scenario = self.scenario.iter().map(Path::new);
        let files = on_disk.iter().chain(&self.map_channels).map(PathBuf::as_path).chain(scenario);
        let on_disk = results::on_disk(&files.map(|file| file.display().to_string()).collect::<Vec<_>>());
        move |name| if shipped.iter().any(|file| file == Path::new(name)) { None } else { on_disk(name) }
    }

    /// The files with which a log is judged, if they are shown. They must have been read before.
    pub(super) fn inputs(&self, log: &Path) -> Vec<InputFile> {
        if !self.json && self.out.is_none() && !self.results.are_wanted() {
            return Vec::new();
        }
        let others = self.logs.iter().map(PathBuf::as_path).filter(|other| self.follow || *other != log);
        inputs(&self.properties, &others.collect::<Vec<_>>())
    }

    /// The command line that checks one of the logs.
    pub(crate) fn command(&self, log: &Path) -> String {
        let mut words = vec!["steward verify".to_owned(), quoted(&log.to_string_lossy())];
        words.extend(self.robots.words(&self.properties, self.map_channels.as_deref(), self.scenario.as_deref()));
        words.extend(self.tree.words());
        words.join(" ")
    }
}
