//! `steward help`: for a command, or on a topic.

use bags::Mapping;
use campaigns::{CampaignFile, Error};
use clap::{Args, Command, ValueEnum};
use diagnostics::document::Key;
use interfaces::Interface;
use maps::PlacesFile;
use monitors::{GRAMMAR, OPERATORS};
use scenarios::scenario::ScenarioFile;

use crate::entry::{column, entry};
use crate::output::{explain, print};

/// Help topics besides commands.
const TOPICS: [&str; 6] = ["scenario", "campaign", "faults", "scope", "mapping", "places"];

/// What to explain.
#[derive(Debug, Args)]
pub(crate) struct HelpArgs {
    /// A command, or one of the topics: scenario, campaign, faults, scope, mapping, places
    topic: Vec<String>,
}

/// A kind of file that has a JSON schema.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum SchemaFile {
    /// Scenario files
    Scenario,
    /// Campaign files
    Campaign,
    /// Interface files
    Interface,
    /// Mappings of bags
    Mapping,
    /// Places on a map
    Places,
}

/// Prints the help for a command of `cli`, or on a topic.
pub(crate) fn help(args: &HelpArgs, mut cli: Command) -> Result<(), Error> {
    let topic: Vec<&str> = args.topic.iter().map(String::as_str).collect();
    match topic.as_slice() {
        ["scenario"] => return explain(format!("{SCENARIO}{}", listed(ScenarioFile::keys()))),
        ["faults"] => return explain(crate::faults::overview()),
        ["scope"] => return explain(scope()),
        ["mapping"] => return explain(format!("{MAPPING}{}", listed(&Mapping::keys()))),
        ["places"] => return explain(format!("{PLACES}{}", listed(&PlacesFile::keys()))),
        _ => {}
    }
    cli.build();
    let mut command = &mut cli;
    let mut topics = &TOPICS[..];
    for name in &topic {
        let known: Vec<String> = command.get_subcommands().map(|command| command.get_name().to_owned()).collect();
        let Some(found) = command.find_subcommand_mut(name) else {
            let names = known.iter().map(String::as_str).chain(topics.iter().copied());
            let meant = diagnostics::did_you_mean(name, names).unwrap_or_default();
            return Err(Error::refused(format!("there is no help on `{}`", topic.join(" ")), meant));
        };
        (command, topics) = (found, &[]);
    }
    print(&command.render_long_help().to_string())?;
    if topic == ["campaign"] { explain(format!("\n{CAMPAIGN}{}", listed(&CampaignFile::keys()))) } else { Ok(()) }
}

/// Prints the JSON schema of one kind of file.
pub(crate) fn schema(file: SchemaFile) -> Result<(), Error> {
    let schema = match file {
        SchemaFile::Scenario => ScenarioFile::schema(),
        SchemaFile::Campaign => CampaignFile::schema(),
        SchemaFile::Interface => Interface::schema(),
        SchemaFile::Mapping => Mapping::schema(),
        SchemaFile::Places => PlacesFile::schema(),
    };
    print(&format!("{schema:#}\n"))
}

const SCENARIO: &str = "\
A scenario is one TOML file. The files that it names are looked up beside it, then among those that come with the \
program. `steward init DIR` writes a scenario to start from, `steward check FILE` says what is wrong with one, and \
`steward schema scenario` prints its JSON schema, for editors.
";

const CAMPAIGN: &str = "\
A campaign is one TOML file. `steward check FILE` says what is wrong with one, and `steward schema campaign` prints \
its JSON schema, for editors.
";

const MAPPING: &str = "\
A mapping turns the messages of a ROS 2 bag into messages of channels; it is one TOML file. `steward verify --list \
BAG` proposes one, and `steward schema mapping` prints its JSON schema, for editors.
";

const PLACES: &str = "\
A places file names points and areas of a map; it is one TOML file, with a table for each place. `steward schema \
places` prints its JSON schema, for editors.
";

/// All keys, table by table.
fn listed(keys: &[Key]) -> String {
    let beside = |key: &Key| {
        let of_table = keys.iter().filter(|other| other.split().0 == key.split().0 && !other.is_table());
        column(of_table.map(|other| other.split().1))
    };
    let mut text = String::new();
    let mut table = "";
    for key in keys {
        let (inside, name) = key.split();
        if key.is_table() {
            let heading = match key.path.strip_suffix("[]") {
                Some(path) => format!("\n[[{}]]", path.replace("[]", "")),
                None => format!("\n[{}]", key.path.replace("[]", "")),
            };
            text += &format!("{heading}\n{}\n", key.about);
        } else {
            if table != inside || text.is_empty() {
                text.push('\n');
            }
            text += &entry(beside(key), name, &key.meaning());
        }
        table = if key.is_table() { &key.path } else { inside };
    }
    text
}

/// The language of properties.
fn scope() -> String {
    let column = column(OPERATORS.iter().map(|operator| operator.written));
    let operators = OPERATORS.iter().map(|operator| {
        let signs = if operator.signs.is_empty() {
            String::new()
        } else {
            format!(" Also {}.", operator.signs.replace(' ', ", "))
        };
        let about = entry(column, operator.written, &format!("{}{signs}", operator.about));
        about + &format!("{:column$}{}\n", "", operator.example)
    });
    format!(
        "Properties are written in the SCOPE language, in files `NAME.scope`:\n\n{GRAMMAR}\n{}\n`steward monitor check \
         FILE` says what is wrong with such a file, and `steward monitor explain FILE` explains it in English.\n",
        operators.collect::<String>()
    )
}
