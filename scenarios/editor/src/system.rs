//! The subject of properties.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use channels::Topology;
use diagnostics::Disk;
use monitors::PropertyFile;
use runs::{topology, topology_for_properties};
use scenarios::Error;
use scenarios::files::Kind;
use scenarios::scenario::{Scenario, find};

use crate::named_files;

/// The subject of properties: the processes and channels of a scenario, and how often it ticks.
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

    /// The system of the scenario with this name or path, for properties that it does not have yet.
    ///
    /// # Errors
    /// Everything that is wrong with the scenario.
    pub fn of(scenario: &str) -> Result<Self, Error> {
        Self::on(&Disk::default(), scenario)
    }

    /// The same, with the scenario and the properties on this disk.
    ///
    /// # Errors
    /// Everything that is wrong with the scenario.
    pub fn on(disk: &Disk, scenario: &str) -> Result<Self, Error> {
        Self::with(disk, scenario, topology_for_properties)
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

    /// Reads a property file.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn load(&self, path: &Path) -> Result<PropertyFile, Error> {
        let (path, text) = named_files::read(&self.disk, Kind::Properties, path)?;
        self.read(&path.display().to_string(), &text)
    }

    /// Reads the text of a property file with this name.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn read(&self, name: &str, text: &str) -> Result<PropertyFile, Error> {
        monitors::load(name, text, &self.topology, self.tick).map_err(Error::bad_input)
    }
}
