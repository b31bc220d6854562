//! `steward faults`: what can go wrong on purpose.

use std::fmt::Write;

use campaigns::Error;
use clap::Args;
use scenarios::faults::{ArgumentDefault, FaultKind, KINDS, Parameter, kind};
use serde_json::json;

use crate::output::print;

/// Which faults to list, and how.
#[derive(Debug, Args)]
pub(crate) struct FaultsArgs {
    /// Only this kind, with its parameters and an example
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
        return print(&(serde_json::to_string_pretty(&list).expect("a list is always JSON") + "\n"));
    }
    print(&chosen.map_or_else(overview, details))
}

fn find(name: &str) -> Result<&'static FaultKind, Error> {
    kind(name).ok_or_else(|| {
        let meant = diagnostics::did_you_mean(name, KINDS.iter().map(|kind| kind.name));
        let meant = meant.map_or_else(String::new, |meant| meant + " ");
        Error::refused(format!("there is no fault `{name}`"), format!("{meant}`steward faults` lists all"))
    })
}

/// A line for each kind, by place.
fn overview() -> String {
    let mut text = String::new();
    let mut place = None;
    for kind in KINDS {
        if place != Some(kind.place) {
            let gap = if place.is_some() { "\n" } else { "" };
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{gap}{}", kind.place.name());
            place = Some(kind.place);
        }
        let _ = writeln!(text, "  {:<24} {}", kind.name, kind.about);
    }
    let _ = write!(
        text,
        "\n{} kinds. `steward faults KIND` tells parameters and gives an example; every kind has a scenario: \
         `steward --scenario faults/KIND`.\n",
        KINDS.len()
    );
    text
}

/// All about a kind.
fn details(kind: &FaultKind) -> String {
    let mut text = format!("{}: {} ({})\n\n", kind.name, kind.about, kind.place.name());
    for parameter in kind.parameters {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {:<14} {}{}", parameter.name, parameter.about, accepted(parameter));
    }
    let timing = [
        ("at_s", "the fault takes hold at this time, or"),
        ("at_tick", "when this tick has been generated, or"),
        ("near", "when the robot comes within `within_m` of this place, or"),
        ("when", "when such a message has passed: \"(BatteryReader, BatteryLevel, m[2] < 30)\", or"),
        ("in_state", "when a skill has come to a state: \"GoToDestination.running\""),
        ("probability", "how likely it takes hold then; 1"),
        ("lasts_s", "how long it holds; to the end of the run"),
        ("every_s", "with `at_s`: after how long it comes again"),
        ("times", "how often it takes hold at most; 1"),
    ];
    text.push('\n');
    for (key, about) in timing.iter().filter(|(key, _)| !(kind.momentary && *key == "lasts_s")) {
        let _ = writeln!(text, "  {key:<14} {about}");
    }
    let _ = write!(text, "\nExample:\n\n[[faults]]\nkind = \"{}\"\n{}\n", kind.name, kind.example);
    text
}

/// What a parameter accepts, and what it is if it is not given.
fn accepted(parameter: &Parameter) -> String {
    let default = match parameter.default {
        ArgumentDefault::Required => String::new(),
        ArgumentDefault::Absent => "; may be left out".to_owned(),
        ArgumentDefault::Number(number) => format!("; {number} if not given"),
        ArgumentDefault::Whole(number) => format!("; {number} if not given"),
        ArgumentDefault::Text(text) => format!("; \"{text}\" if not given"),
        ArgumentDefault::Flag(flag) => format!("; {flag} if not given"),
    };
    format!(": {}{default}", parameter.domain.describe())
}

fn as_json(kind: &FaultKind) -> serde_json::Value {
    let parameters = kind.parameters.iter().map(|parameter| {
        let default = match parameter.default {
            ArgumentDefault::Required | ArgumentDefault::Absent => serde_json::Value::Null,
            ArgumentDefault::Number(number) => number.into(),
            ArgumentDefault::Whole(number) => number.into(),
            ArgumentDefault::Text(text) => text.into(),
            ArgumentDefault::Flag(flag) => flag.into(),
        };
        json!({
            "name": parameter.name,
            "about": parameter.about,
            "unit": parameter.unit(),
            "accepts": parameter.domain.describe(),
            "required": parameter.default == ArgumentDefault::Required,
            "default": default,
        })
    });
    json!({
        "kind": kind.name,
        "place": kind.place.name(),
        "about": kind.about,
        "momentary": kind.momentary,
        "parameters": parameters.collect::<Vec<_>>(),
        "example": format!("[[faults]]\nkind = \"{}\"\n{}\n", kind.name, kind.example),
        "scenario": format!("faults/{}", kind.name),
    })
}
