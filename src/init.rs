//! `steward init`: creates an application to start from and edit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use campaigns::Error;
use checks::Toml;
use clap::{Args, ValueEnum};
use diagnostics::Staging;
use scenarios::application::Application;
use scenarios::scenario::{ScenarioFile, find};

use crate::names;
use crate::output::print_wrapped;

/// The template, and where to write it.
#[derive(Debug, Args)]
pub(crate) struct InitArgs {
    /// The folder to write to; it must be new or empty
    dir: PathBuf,
    /// The application to start from; `recharge` by default
    #[arg(long, value_name = "NAME", default_value = "recharge", hide_default_value = true)]
    template: Template,
    /// Copies this scenario instead, with all files that it names: a name (see `steward list`) or a file
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "template", value_parser = names::SCENARIOS,
          hide_possible_values = true)]
    scenario: Option<String>,
}

/// An application to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Template {
    /// The paper's robot, which recharges on its way through a house
    Recharge,
    /// A robot that guides visitors through a museum; one of its components is a Python program
    Guide,
    /// The minimum that runs: one leaf, its machine and a property, without a map
    Empty,
    /// A minute of a recorded robot driven by Nav2, with a mapping and properties, to check with `steward verify`
    Recording,
}

/// The files of the empty application; the first one is its scenario.
const EMPTY: [(&str, &str); 4] = [
    ("scenario.toml", include_str!("init/empty/scenario.toml")),
    ("tree.xml", include_str!("init/empty/tree.xml")),
    ("skills/Greet.scxml", include_str!("init/empty/skills/Greet.scxml")),
    ("properties.scope", include_str!("init/empty/properties.scope")),
];

/// The files around a recording.
const RECORDING: [(&str, &[u8]); 5] = [
    ("nav2.mcap", include_bytes!("init/recording/nav2.mcap")),
    ("mapping.toml", include_bytes!("init/recording/mapping.toml")),
    ("nav2.scope", include_bytes!("init/recording/nav2.scope")),
    ("make_bag.py", include_bytes!("init/recording/make_bag.py")),
    (
        "definitions/nav2_msgs/action/NavigateToPose.action",
        include_bytes!("init/recording/definitions/nav2_msgs/action/NavigateToPose.action"),
    ),
];

/// The kind of a file in an application, by the ending of its name.
const KINDS: &[(&str, &str)] = &[
    (".schema.json", "the keys of a scenario: editors that know `#:schema` complete and check keys with it"),
    (".yaml", "the map: its image, resolution and origin"),
    (".pgm", "the map's image: dark is a wall"),
    (".png", "the map's image: dark is a wall"),
    (".xml", "the behavior tree"),
    (".scxml", "a state machine: the skill of a leaf, a component or a monitor"),
    (".scope", "properties that are monitored"),
    (".py", "a component: a program"),
];

/// The schema of scenario files, which the scenario names in its first line.
const SCHEMA: &str = "scenario.schema.json";

/// The file that describes the folder.
const README: &str = "README.md";

/// Writes an application to its folder, relative to which the paths in its files hold.
pub(crate) fn init(InitArgs { dir, template, scenario }: &InitArgs) -> Result<(), Error> {
    let mut application = match (scenario, template) {
        (None, Template::Recording) => {
            copy(dir, RECORDING.map(|(name, bytes)| (PathBuf::from(name), bytes.to_vec())).into(), RECORDING[0].0)?;
            let folder = dir.display();
            return print_wrapped(format!(
                "wrote {folder}/nav2.mcap; check it with: steward verify {folder}/nav2.mcap --property {folder}/nav2.scope \
                 --map-channels {folder}/mapping.toml\n"
            ));
        }
        (Some(scenario), _) => Application::of(find::find(scenario)?)?,
        (None, Template::Recharge) => Application::of(find::find("battery_fault")?)?,
        (None, Template::Guide) => Application::with_variants("guide")?,
        (None, Template::Empty) => empty(),
    };
    describe(&mut application);
    copy(dir, application.files, &application.start)?;
    print_wrapped(format!("wrote {0}; run it with: steward run {0}\n", dir.join(&application.start).display()))
}

/// Writes files into a new folder; the one to look at first comes last.
fn copy(dir: &Path, files: BTreeMap<PathBuf, Vec<u8>>, start: &str) -> Result<(), Error> {
    let copies = Staging::begin(dir)?;
    if !copies.is_alone()? {
        let message = format!("{} is not empty", dir.display());
        return Err(Error::refused(message, "name a new folder: nothing is overwritten"));
    }
    for (path, contents) in &files {
        copies.write(path, contents)?;
    }
    Ok(copies.publish(&[start])?)
}

/// The empty application.
fn empty() -> Application {
    let files = EMPTY.iter().map(|(name, text)| (PathBuf::from(name), text.as_bytes().to_vec()));
    Application { start: EMPTY[0].0.to_owned(), has_robot: false, files: files.collect() }
}

/// Adds the schema of scenarios, and a README unless there is one.
fn describe(application: &mut Application) {
    let Application { start: name, has_robot, files } = application;
    files.entry(SCHEMA.into()).or_insert_with(|| format!("{:#}\n", ScenarioFile::schema()).into());
    let start = files.entry(PathBuf::from(&*name)).or_default();
    if !start.starts_with(b"#:schema") {
        start.splice(..0, format!("#:schema {SCHEMA}\n").into_bytes());
    }
    let readme = readme(name, files, *has_robot);
    files.entry(README.into()).or_insert_with(|| readme.into());
}

fn readme(name: &str, files: &BTreeMap<PathBuf, Vec<u8>>, has_robot: bool) -> String {
    let mut text = format!(
        "# {name}\n\nA scenario for `steward`, with its files. Change them and run it again.\n\n\
         | file | what it is |\n|---|---|\n| `{name}` | the scenario: start here |\n"
    );
    for (path, contents) in files.iter().filter(|(path, _)| *path != Path::new(name)) {
        text += &format!("| `{}` | {} |\n", path.display(), kind(path, contents));
    }
    let some = |ending: &str| files.keys().find(|path| path.extension().is_some_and(|is| is == ending));
    let value = if has_robot { "battery.initial_pct=50" } else { "execution.tick_s=0.5" };
    let mut commands = vec![
        (format!("steward check {name}"), "check it without running it"),
        (format!("steward run {name} --open"), "run it and open its report"),
        (format!("steward run {name} --set {value}"), "run it with another value"),
    ];
    let show = |path: &PathBuf, what: &str| format!("steward {what} {}", path.display());
    let other = |is: Toml| {
        let beside = files.iter().filter(|(path, _)| path.components().count() == 1 && *path != Path::new(name));
        let mut of_toml = beside.filter(|(path, _)| path.extension().is_some_and(|ending| ending == "toml"));
        of_toml.find(|(_, contents)| Toml::of(&String::from_utf8_lossy(contents)) == Some(is)).map(|(path, _)| path)
    };
    commands.extend(other(Toml::Scenario).map(|_| ("steward run .".to_owned(), "run all scenarios of the folder")));
    let campaign = |path| format!("{} --runs 8", show(path, "campaign"));
    commands.extend(other(Toml::Campaign).map(|path| (campaign(path), "run it many times, with varied values")));
    commands.extend(some("xml").map(|tree| (show(tree, "tree show"), "the behavior tree as an outline")));
    commands.extend(some("scxml").map(|skill| (show(skill, "skill show"), "a machine's states and transitions")));
    let explain = |property: &PathBuf| format!("{} --scenario {name}", show(property, "monitor explain"));
    commands.extend(some("scope").map(|property| (explain(property), "a property in words")));
    let widest = commands.iter().map(|(command, _)| command.chars().count()).max().unwrap_or(0);
    text += "\n```sh\n";
    for (command, about) in commands {
        text += &format!("{command:<widest$}  # {about}\n");
    }
    text + "```\n\nKeys of a scenario: `steward help scenario`. Kinds of faults: `steward faults`.\n"
}

/// The meaning of a file.
fn kind(path: &Path, contents: &[u8]) -> String {
    let name = path.to_string_lossy();
    if let Some((_, kind)) = KINDS.iter().find(|(ending, _)| name.ends_with(ending)) {
        return (*kind).to_owned();
    }
    let text = String::from_utf8_lossy(contents);
    let table: toml::Table = text.parse().unwrap_or_default();
    let about = table.get("about").and_then(|about| about.as_str()).unwrap_or_default();
    match Toml::of(&text).unwrap_or(Toml::Scenario) {
        Toml::Campaign => format!("a campaign: {about}"),
        Toml::Scenario => format!("a scenario: {about}"),
        Toml::Interface => "the interface of a component: its services, topics and actions".to_owned(),
        Toml::Places => "the places on the map, in meters and degrees".to_owned(),
        Toml::Mapping => "a mapping of a robot's messages to channels".to_owned(),
    }
}
