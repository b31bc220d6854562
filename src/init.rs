//! `steward init`: a copy of a scenario with everything it names, for editing.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

use campaigns::Error;
use clap::Args;
use diagnostics::Staging;
use scenarios::scenario::{Scenario, ScenarioFile, find, keys};

use crate::names::ScenarioName;
use crate::output::say;

/// What to copy, and where to.
#[derive(Debug, Args)]
pub(crate) struct InitArgs {
    /// The folder to write to; it must be new or empty
    dir: PathBuf,
    /// The scenario to copy: a name (see `steward list`) or a file
    #[arg(long, value_name = "NAME|FILE", default_value = "battery_fault", value_parser = ScenarioName,
          hide_possible_values = true)]
    scenario: String,
}

/// What a file of a scenario is, by how its name ends.
const KINDS: &[(&str, &str)] = &[
    (".places.toml", "the places on the map, in metres and degrees"),
    (".schema.json", "what may stand in a scenario: editors that know `#:schema` complete and check keys with it"),
    (".toml", "a scenario that the first one is based on"),
    (".yaml", "the map: its picture, resolution and origin"),
    (".pgm", "the map's picture: dark is a wall"),
    (".png", "the map's picture: dark is a wall"),
    (".xml", "the behavior tree"),
    (".scxml", "the skill of a leaf, or a monitor: a state machine"),
    (".scope", "a property that is monitored"),
];

/// Writes a scenario and all that it names to `dir`, so that the paths in the scenario hold there.
pub(crate) fn init(InitArgs { dir, scenario }: &InitArgs) -> Result<(), Error> {
    let mut found = find::find(scenario)?;
    let copies = Staging::begin(dir)?;
    if !copies.is_alone()? {
        let message = format!("{} is not empty", dir.display());
        return Err(Error::refused(message, "name a new folder: nothing is overwritten"));
    }
    found.files = found.files.remembering();
    let loaded = Scenario::load(&found, &[])?;
    let mut paths: BTreeSet<PathBuf> = ScenarioFile::bases(&found).map_err(Error::bad_input)?.into_iter().collect();
    paths.extend(found.files.remembered());
    let is_inside = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    if let Some(path) = paths.iter().find(|path| !path.components().all(is_inside)) {
        let message = format!("{} names {}, which lies outside its folder", found.path, path.display());
        return Err(Error::refused(message, "a copy has all files in its own folder: move the file there first"));
    }
    for path in &paths {
        let bytes = found.files.read(path).map_err(|source| diagnostics::Error::Read { path: path.clone(), source })?;
        copies.write(path, bytes)?;
    }
    let name = Path::new(&found.path).file_name().unwrap_or_default();
    let directive = format!("#:schema {SCHEMA}\n");
    let text = if found.text.starts_with("#:schema") { found.text } else { directive + &found.text };
    copies.write(name, text)?;
    copies.write(SCHEMA, format!("{:#}\n", keys::schema()))?;
    paths.insert(SCHEMA.into());
    let name = name.to_string_lossy();
    if !paths.contains(Path::new(README)) {
        copies.write(README, readme(&name, &paths, loaded.premises.is_some()))?;
    }
    copies.publish(&[&*name])?;
    say(format!("wrote {0}; run it with: steward run {0}\n", dir.join(&*name).display()))
}

/// The schema of scenario files, which the scenario names in its first line.
const SCHEMA: &str = "scenario.schema.json";

/// The file that describes the folder.
const README: &str = "README.md";

fn readme(name: &str, paths: &BTreeSet<PathBuf>, has_robot: bool) -> String {
    let mut text = format!(
        "# {name}\n\nA scenario for `steward`, with its files. Change them and run it again.\n\n\
         | file | what it is |\n|---|---|\n| `{name}` | the scenario: start here |\n"
    );
    for path in paths.iter().map(|path| path.display().to_string()) {
        let kind = KINDS.iter().find(|(ending, _)| path.ends_with(ending)).map_or("", |(_, kind)| kind);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| `{path}` | {kind} |");
    }
    let some = |ending: &str| paths.iter().find(|path| path.extension().is_some_and(|is| is == ending));
    let value = if has_robot { "battery.initial_pct=50" } else { "execution.tick_s=0.5" };
    let mut commands = vec![
        (format!("steward check {name}"), "what is wrong with it, without a run"),
        (format!("steward run {name} --open"), "run it and open its report"),
        (format!("steward run {name} --set {value}"), "run it with another value"),
    ];
    let show = |path: &PathBuf, what: &str| format!("steward {what} {}", path.display());
    commands.extend(some("xml").map(|tree| (show(tree, "tree show"), "the behavior tree as an outline")));
    commands.extend(some("scxml").map(|skill| (show(skill, "skill show"), "a skill's states and transitions")));
    commands.extend(some("scope").map(|property| (show(property, "monitor explain"), "a property in words")));
    let widest = commands.iter().map(|(command, _)| command.chars().count()).max().unwrap_or(0);
    text += "\n```sh\n";
    for (command, about) in commands {
        let _ = writeln!(text, "{command:<widest$}  # {about}");
    }
    text + "```\n\nKeys of a scenario: `steward help scenario`. Kinds of faults: `steward faults`.\n"
}
