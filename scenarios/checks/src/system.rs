//! The subject of properties: a scenario, or a robot whose messages a mapping describes.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use bags::{Described, Mapping};
use channels::Topology;
use diagnostics::{Disk, Source, counted};
use monitors::PropertyFile;
use runs::{topology, topology_for_properties};
use scenarios::Error;
use scenarios::files::Kind;
use scenarios::scenario::{Scenario, find};

use crate::checked::Checked;
use crate::file_kind::FileKind;
use crate::named_files;
use crate::toml_subject::Toml;

/// The subject of properties: the processes and channels of a scenario or of a mapping, and how often it ticks.
#[derive(Clone, Debug)]
pub struct System {
    /// The processes and channels.
    pub topology: Arc<Topology>,
    /// How often it ticks.
    pub tick: Duration,
    disk: Disk,
}

impl System {
    /// The system with these processes and channels, which ticks this often.
    #[must_use]
    pub fn new(topology: Arc<Topology>, tick: Duration) -> Self {
        Self { topology, tick, disk: Disk::default() }
    }

    /// The system of the scenario with this name or path, for properties that it does not have yet, or of the mapping
    /// with this path.
    ///
    /// # Errors
    /// Everything that is wrong with it; if a mapping leaves its types open, which.
    pub fn of(subject: &str) -> Result<Self, Error> {
        Self::on(&Disk::default(), subject)
    }

    /// The same, with all files on this disk.
    ///
    /// # Errors
    /// The same.
    pub fn on(disk: &Disk, subject: &str) -> Result<Self, Error> {
        if FileKind::of(disk, Path::new(subject)) != Some(FileKind::Toml(Toml::Mapping)) {
            return Self::with(disk, subject, topology_for_properties);
        }
        let (mapping, Described { topology, open, .. }) = mapping(disk, Path::new(subject))?;
        if open.is_empty() {
            return Ok(Self { topology, tick: mapping.tick, disk: disk.clone() });
        }
        let open = open.into_iter().collect::<Vec<_>>().join(" and ");
        Err(Error::refused(
            format!("{subject} does not define what the messages of {open} consist of"),
            "name their types, `type = \"PACKAGE/msg/NAME\"`, and in `definitions` the folders of those that do not \
             come with ROS 2; `steward verify --list BAG` and `steward watch --list` show them",
        ))
    }

    /// The system of the scenario's runs.
    ///
    /// # Errors
    /// Everything that is wrong with the scenario.
    pub fn of_runs(scenario: &str) -> Result<Self, Error> {
        Self::with(&Disk::default(), scenario, topology)
    }

    fn with(
        disk: &Disk,
        scenario: &str,
        topology: fn(&Scenario) -> Result<Arc<Topology>, Error>,
    ) -> Result<Self, Error> {
        let scenario = Scenario::load(&find::find_on(disk, scenario)?, &[])?;
        Ok(Self { topology: topology(&scenario)?, tick: scenario.file.execution.tick, disk: disk.clone() })
    }

    /// Reads a property file, which has at least one property.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn load(&self, path: &Path) -> Result<PropertyFile, Error> {
        let (path, text) = named_files::read(&self.disk, Kind::Properties, path)?;
        let file = self.read(&path.display().to_string(), &text)?;
        if file.properties.is_empty() {
            let span = Source::new(&path.display().to_string(), text).span(0..0);
            let problem = span.problem("there is no property in this file").with_label("nothing to check");
            return Err(Error::bad_input(problem.with_help("write `property NAME := …`")));
        }
        Ok(file)
    }

    /// Reads the text of a property file with this name.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn read(&self, name: &str, text: &str) -> Result<PropertyFile, Error> {
        monitors::load(name, text, &self.topology, self.tick).map_err(Error::bad_input)
    }
}

/// Loads a mapping, and what is known of it without a bag or a robot.
fn mapping(disk: &Disk, path: &Path) -> Result<(Mapping, Described), Error> {
    let read = |path: &Path| named_files::files(disk).read(path);
    let mapping = Mapping::load(path, &read).map_err(Error::bad_input)?;
    let described = mapping.describe(&read).map_err(Error::bad_input)?;
    Ok((mapping, described))
}

/// Checks a mapping. With what it describes, unless it leaves types open.
pub(crate) fn check_mapping(disk: &Disk, file: &Path) -> (Result<Checked, Error>, Option<System>) {
    let (mapping, Described { topology, open, misspelled }) = match mapping(disk, file) {
        Ok(loaded) => loaded,
        Err(error) => return (Err(error), None),
    };
    let topics: BTreeSet<&str> = mapping.topics().collect();
    let mut summary = format!("a mapping of {}", counted(topics.len(), "topic"));
    let system = open.is_empty().then(|| System { topology, tick: mapping.tick, disk: disk.clone() });
    if !open.is_empty() {
        let open = open.into_iter().collect::<Vec<_>>().join(" and ");
        summary += &format!(", without the types of {open}, which are known only with a bag or a robot");
    }
    (Ok(Checked::of(summary, misspelled)), system)
}

/// Checks properties of a scenario or a mapping. With its system, if it was named.
pub(crate) fn check_properties(
    disk: &Disk,
    file: &Path,
    subject: Option<&str>,
) -> (Result<Checked, Error>, Option<System>) {
    let system = match System::on(disk, subject.unwrap_or("nominal")) {
        Ok(system) => system,
        Err(error) => return (Err(error), None),
    };
    let checked = system.load(file).map(|PropertyFile { properties, warnings }| {
        Checked::of(counted(properties.len(), "property"), (!warnings.is_empty()).then_some(warnings))
    });
    (checked, subject.map(|_| system))
}
