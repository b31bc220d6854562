//! Tips for unknown commands.

use std::path::Path;

use clap::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use scenarios::files::{shipped_campaigns, shipped_scenarios};
use scenarios::scenario::find;

/// The error, with a tip if the unknown command is a scenario, a campaign or a file, or is similar to one.
pub(crate) fn with_hints(mut error: Error) -> Error {
    if let (ErrorKind::InvalidSubcommand, Some(ContextValue::String(name))) =
        (error.kind(), error.get(ContextKind::InvalidSubcommand))
        && std::env::args_os().nth(1).is_some_and(|first| first == name.as_str())
        && let Some(tip) = tip(name)
    {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

fn tip(name: &str) -> Option<String> {
    let campaigns = || shipped_campaigns().map(|(name, _)| name);
    if find::shipped(name).is_some() || Path::new(name).is_file() {
        return Some(format!("to run a scenario: steward run {name}"));
    }
    if campaigns().any(|campaign| campaign == name) {
        return Some(format!("to run a campaign: steward campaign {name}"));
    }
    let run = diagnostics::nearest(name, shipped_scenarios()).map(|meant| format!("steward run {meant}"));
    let meant =
        run.or_else(|| diagnostics::nearest(name, campaigns()).map(|meant| format!("steward campaign {meant}")));
    meant.map(|command| format!("a similar name exists: {command}"))
}
