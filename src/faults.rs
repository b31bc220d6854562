//! `steward faults`: the kinds of faults.

use campaigns::Error;
use clap::Args;
use diagnostics::document::Key;
use scenarios::faults::{FaultKind, KINDS, Parameter, kind};
use scenarios::scenario::ScenarioFile;
use serde_json::json;

use crate::entry::{column, entry};
use crate::names;
use crate::output::{explain, print_json};

/// Which faults to list, and how.
#[derive(Debug, Args)]
pub(crate) struct FaultsArgs {
    /// Only this kind, with its parameters and an example
    #[arg(value_parser = names::FAULTS, hide_possible_values = true)]
    kind: Option<String>,
    /// Prints JSON
    #[arg(long)]
    json: bool,
}

/// Prints the kinds of faults.
pub(crate) fn faults(args: &FaultsArgs) -> Result<(), Error> {
    let chosen = args.kind.as_deref().map(find).transpose()?;
    let kinds: Vec<&FaultKind> = chosen.map_or_else(|| KINDS.to_vec(), |kind| vec![kind]);
    if args.json {
        let list: Vec<_> = kinds.iter().map(|kind| as_json(kind)).collect();
        return print_json(&list);
    }
    explain(chosen.map_or_else(overview, details))
}

fn find(name: &str) -> Result<&'static FaultKind, Error> {
    kind(name).ok_or_else(|| {
        let meant = diagnostics::did_you_mean(name, KINDS.iter().map(|kind| kind.name));
        let meant = meant.map_or_else(String::new, |meant| meant + " ");
        Error::refused(format!("there is no fault `{name}`"), format!("{meant}`steward faults` lists all"))
    })
}

/// One line per kind, by subsystem.
pub(crate) fn overview() -> String {
    let column = column(KINDS.iter().map(|kind| kind.name));
    let mut text = String::new();
    let mut subsystem = None;
    for kind in KINDS {
        if subsystem != Some(kind.subsystem) {
            let gap = if subsystem.is_some() { "\n" } else { "" };
            text += &format!("{gap}{}\n", kind.subsystem.name());
            subsystem = Some(kind.subsystem);
        }
        text += &entry(column, kind.name, kind.about);
    }
    text += &format!(
        "\n{} kinds. `steward faults KIND` prints the parameters of one and an example; `steward run faults/KIND` shows it.\n",
        KINDS.len()
    );
    text
}

/// Everything about one kind.
fn details(kind: &FaultKind) -> String {
    let parameters: Vec<Key> = kind.parameters.iter().map(Parameter::key).collect();
    let timing = ScenarioFile::keys().iter().filter(|key| key.split().0 == "faults[]" && key.split().1 != "kind");
    let timing = timing.filter(|key| !(kind.is_momentary() && key.split().1 == "lasts_s"));
    let timing: Vec<Key> = timing.cloned().collect();
    let column = column(parameters.iter().chain(&timing).map(|key| key.split().1));
    let list = |keys: &[Key]| keys.iter().map(|key| entry(column, key.split().1, &key.meaning())).collect::<String>();
    let mut text = format!("{}: {} ({})\n", kind.name, kind.about, kind.subsystem.name());
    for keys in [parameters, timing].iter().filter(|keys| !keys.is_empty()) {
        text += &format!("\n{}", list(keys));
    }
    text + &format!("\nExample:\n\n[[faults]]\nkind = \"{}\"\n{}\n", kind.name, kind.example)
}

fn as_json(kind: &FaultKind) -> serde_json::Value {
    let parameters = kind.parameters.iter().map(|parameter| {
        let key = parameter.key();
        json!({
            "name": parameter.name,
            "about": parameter.about,
            "unit": parameter.unit(),
            "accepts": key.accepts(),
            "required": key.required,
            "default": key.takes.get("default"),
        })
    });
    json!({
        "kind": kind.name,
        "place": kind.subsystem.name(),
        "about": kind.about,
        "momentary": kind.is_momentary(),
        "parameters": parameters.collect::<Vec<_>>(),
        "example": format!("[[faults]]\nkind = \"{}\"\n{}\n", kind.name, kind.example),
        "scenario": format!("faults/{}", kind.name),
    })
}
