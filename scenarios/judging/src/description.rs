//! The first line of an event log.

use std::time::Duration;

use campaigns::Error;
use channels::Ground;
use recording::{Carried, Header};
use scenarios::scenario::find;

use crate::host::Host;

/// The first line of a log, which describes the run.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Description {
    pub(crate) scenario: Option<String>,
    /// Whether the scenario was a file of the user, which may have the name of a shipped one.
    is_own: bool,
    version: Option<String>,
    /// The time between ticks.
    pub(crate) tick: Option<Duration>,
    pub(crate) lacks_ticks: bool,
    /// The messages that the channels of the run could carry.
    pub(crate) carried: Option<Carried>,
    /// The components that were nodes of ROS 2.
    pub(crate) remote: Vec<String>,
}

impl Description {
    /// Reads the first line of a log; a line that is not JSON describes nothing.
    pub(crate) fn of(line: &[u8]) -> Self {
        let described: serde_json::Value = serde_json::from_slice(line).unwrap_or_default();
        let text = |key: &str| match &described[key] {
            serde_json::Value::Null => None,
            serde_json::Value::String(text) => Some(text.clone()),
            other => Some(other.to_string()),
        };
        let argument = described["provenance"]["scenario"].as_str();
        let is_own = argument.is_some_and(|argument| find::shipped(argument).is_none());
        let tick = described["tick_s"].as_f64().and_then(|tick_s| Duration::try_from_secs_f64(tick_s).ok());
        let lacks_ticks = tick.is_some_and(|tick| tick.is_zero());
        let tick = tick.filter(|tick| !tick.is_zero());
        let carried = Carried::read(&described["channels"]).ok();
        let remote = described["remote"].as_array().into_iter().flatten();
        let remote = remote.filter_map(|name| Some(name.as_str()?.to_owned())).collect();
        Self { scenario: text("scenario"), is_own, version: text("version"), tick, lacks_ticks, carried, remote }
    }

    pub(crate) fn of_recording(header: &Header) -> Self {
        Self {
            scenario: Some(header.scenario.clone()),
            is_own: find::shipped(&header.origin.argument).is_none(),
            version: Some(header.version.clone()),
            tick: Some(header.tick).filter(|tick| !tick.is_zero()),
            lacks_ticks: !header.knows_ticks(),
            carried: Some(Carried::by(&header.topology)),
            remote: header.remote.clone(),
        }
    }

    /// Refuses a log of a newer version, whose format is unknown.
    pub(crate) fn check_version(&self) -> Result<(), Error> {
        const THIS: &str = env!("CARGO_PKG_VERSION");
        let Some(version) = self.version.as_deref().filter(|version| numbers(version) > numbers(THIS)) else {
            return Ok(());
        };
        let message = format!("the log was written by version {version} of steward, and this is {THIS}");
        Err(Error::refused(message, "use that version, or a newer one"))
    }

    /// The ground for the messages of the log: this program writes every message, and the messages that channels can
    /// carry.
    pub(crate) fn ground(&self) -> Ground {
        let what = "the log has every message of the scenario's channels";
        if self.version.is_some() && self.carried.is_some() {
            Ground::Complete
        } else {
            Ground::Assumed(what.to_owned())
        }
    }

    /// The scenario that is given, or else the one to which the log belongs.
    pub(crate) fn scenario<'a>(&'a self, given: Option<&'a str>, host: Host) -> Result<&'a str, Error> {
        match (given, self.scenario.as_deref()) {
            (Some(name), _) => Ok(name),
            (None, Some(name)) if find::shipped(name).is_some() && !self.is_own => Ok(name),
            (None, Some(name)) => {
                let message = format!("the log belongs to a scenario `{name}` that does not come with the program");
                Err(Error::refused(message, "name the scenario's file: `--scenario FILE`"))
            }
            (None, None) => {
                (host.note)(
                    "the log does not say which scenario it belongs to; its channels are assumed to be those of \
                     `nominal`",
                );
                Ok("nominal")
            }
        }
    }
}

/// The numbers of a version, so that versions can be compared; an invalid one is greater than all of them.
fn numbers(version: &str) -> Vec<u64> {
    version.split('.').map(|number| number.parse().unwrap_or(u64::MAX)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_log_names_its_scenario_and_its_tick_period() {
        let described = |line: &str| {
            let Description { scenario, tick, .. } = Description::of(line.as_bytes());
            (scenario, tick.map(|tick| tick.as_millis()))
        };
        let battery_fault = || Some("battery_fault".to_owned());
        assert_eq!(described(r#"{"scenario":"battery_fault","tick_s":0.5}"#), (battery_fault(), Some(500)));
        assert_eq!(described(r#"{"scenario":"battery_fault"}"#), (battery_fault(), None));
        assert_eq!(described(r#"{"scenario":"unheard of","tick_s":-1}"#), (Some("unheard of".to_owned()), None));
        assert_eq!(described("no JSON"), (None, None));
    }

    #[test]
    fn a_log_of_a_users_scenario_is_not_judged_by_the_shipped_one_with_the_same_name() {
        let of = |argument: &str| {
            let line = format!(r#"{{"scenario":"battery_fault","provenance":{{"scenario":"{argument}"}}}}"#);
            Description::of(line.as_bytes())
        };
        assert_eq!(of("battery_fault").scenario(None, Host::SILENT).expect("it is shipped"), "battery_fault");
        let own = of("app/battery_fault.toml");
        let refused = own.scenario(None, Host::SILENT).expect_err("it is not shipped").to_string();
        assert!(refused.contains("a scenario `battery_fault` that does not come with the program"), "{refused}");
        assert_eq!(own.scenario(Some("nominal"), Host::SILENT).expect("it is named"), "nominal");
    }
}
