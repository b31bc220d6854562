//! `steward monitor check|explain|export FILE`: property files and the monitors that they become.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use campaigns::Error;
use channels::{Monitor as _, Topology};
use clap::{Args, Subcommand, ValueEnum};
use monitors::{Format, Method, Property, PropertyFile, ScopeMonitor, explain};
use reports::file_name;
use scenarios::scenario::{Scenario, find};
use scenarios::wiring;

use crate::output::print;

/// Property files: check them, have them explained, write their monitors out.
#[derive(Debug, Subcommand)]
pub(crate) enum MonitorCommand {
    /// Says everything that is wrong with a property file, and how its properties are monitored
    Check(Source),
    /// Says in plain English what each property asks for
    Explain(Source),
    /// Writes the monitors as program graphs
    Export {
        #[command(flatten)]
        source: Source,
        /// How to write them
        #[arg(long, value_enum, default_value_t = ExportFormat::Text)]
        format: ExportFormat,
        /// Only the property of that name
        #[arg(long, value_name = "NAME")]
        property: Option<String>,
        /// Where to write to, a file a property; to stdout if not given
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

/// A property file and the system that it speaks of.
#[derive(Debug, Args)]
pub(crate) struct Source {
    /// The property file, or the name of one that comes with the program
    file: PathBuf,
    /// The scenario whose processes and channels it speaks of
    #[arg(long, value_name = "NAME|FILE", default_value = "nominal")]
    scenario: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExportFormat {
    /// One line a location, one a transition
    Text,
    /// Graphviz
    Dot,
    /// A picture
    Svg,
    /// An SCXML machine with the ECMAScript data model
    Scxml,
}

pub(crate) fn run(command: &MonitorCommand) -> Result<(), Error> {
    match command {
        MonitorCommand::Check(source) => {
            let file = source.load()?;
            print(
                &file
                    .properties
                    .iter()
                    .map(|property| format!("{}: {}\n", property.name, method(property)))
                    .collect::<String>(),
            )
        }
        MonitorCommand::Explain(source) => {
            let file = source.load()?;
            print(&file.properties.iter().map(explained).collect::<String>())
        }
        MonitorCommand::Export { source, format, property, out } => {
            let file = source.load()?;
            let wanted = |name: &str| property.as_deref().is_none_or(|wanted| wanted == name);
            let chosen: Vec<&Property> = file.properties.iter().filter(|property| wanted(&property.name)).collect();
            if chosen.is_empty() {
                let names: Vec<&str> = file.properties.iter().map(|property| property.name.as_str()).collect();
                let message = format!("there is no property `{}`", property.as_deref().unwrap_or_default());
                return Err(Error::refused(message, format!("there are {}", names.join(", "))));
            }
            // One that has no such picture does not keep the others from theirs.
            let mut refused = Vec::new();
            for property in chosen {
                match export(property, *format, out.as_deref()) {
                    Err(Error::Scenario(scenarios::Error::BadInput(diagnostics))) => refused.extend(diagnostics),
                    done => done?,
                }
            }
            if refused.is_empty() { Ok(()) } else { Err(scenarios::Error::BadInput(refused).into()) }
        }
    }
}

impl Source {
    fn load(&self) -> Result<PropertyFile, Error> {
        let system = System::of(&self.scenario)?;
        let file = system.load(&self.file)?;
        if !file.warnings.is_empty() {
            crate::output::complain(&Error::bad_input(file.warnings.clone()));
        }
        Ok(file)
    }
}

/// What properties speak of: the processes and channels of a scenario, and how often it ticks.
pub(crate) struct System {
    pub(crate) topology: Arc<Topology>,
    pub(crate) tick: Duration,
}

impl System {
    /// The system of the scenario of that name or path.
    pub(crate) fn of(scenario: &str) -> Result<Self, Error> {
        let scenario = Scenario::load(&find::find(scenario)?, &[])?;
        Ok(Self { topology: wiring::topology(&scenario)?, tick: scenario.file.execution.tick })
    }

    /// Reads a property file, or one that comes with the program, by its name.
    pub(crate) fn load(&self, path: &Path) -> Result<PropertyFile, Error> {
        let name = path.display().to_string();
        let text = text(path).map_err(|error| {
            let names: Vec<&str> = monitors::SHIPPED.iter().map(|(name, _)| *name).collect();
            let help = format!("give the path of a .scope file, or one of {}", names.join(", "));
            Error::refused(format!("cannot read the properties {name}: {error}"), help)
        })?;
        monitors::load(&name, &text, &self.topology, self.tick).map_err(Error::bad_input)
    }
}

fn text(path: &Path) -> io::Result<String> {
    let shipped = monitors::SHIPPED.iter().find(|(name, _)| Path::new(name) == path);
    match (diagnostics::text_from_disk(path), shipped) {
        (Ok(text), _) => Ok(text),
        (Err(_), Some((_, text))) => Ok((*text).to_owned()),
        (Err(error), None) => Err(error),
    }
}

/// What a property asks for: in the words of its file, and as the formula has it.
fn explained(property: &Property) -> String {
    let formula = property.scope_monitor().map(|monitor| explain(monitor.formula(), monitor.topology()));
    match formula {
        Some(formula) if formula != property.summary => {
            let indent = " ".repeat(property.name.chars().count());
            format!("{}: {}\n{indent}  {formula}\n", property.name, property.summary)
        }
        _ => format!("{}: {}\n", property.name, property.summary),
    }
}

/// How a property is monitored, in words.
fn method(property: &Property) -> String {
    match property.scope_monitor().map(ScopeMonitor::method) {
        None | Some(Method::Graph) => "a program graph".to_owned(),
        Some(Method::Automaton { states }) => format!("an automaton of {states} states"),
        Some(Method::Graphs) => "program graphs side by side; verdicts may come late".to_owned(),
        Some(_) => "progression; verdicts may come late".to_owned(),
    }
}

fn export(property: &Property, format: ExportFormat, out: Option<&Path>) -> Result<(), Error> {
    let monitor = property.scope_monitor();
    let (text, ending) = match format {
        ExportFormat::Text => (monitor.and_then(|monitor| monitor.export(Format::Text)), "txt"),
        ExportFormat::Dot => (monitor.and_then(|monitor| monitor.export(Format::Dot)), "dot"),
        ExportFormat::Scxml => (monitor.and_then(|monitor| monitor.export(Format::Scxml)), "scxml"),
        ExportFormat::Svg => (monitor.and_then(svg), "svg"),
    };
    let text = text.ok_or_else(|| {
        let message =
            format!("`{}` is no program graph of that size: it is monitored by {}", property.name, method(property));
        Error::refused(message, "a picture has room for a dozen states; text, dot and scxml for all of an automaton")
    })?;
    let Some(folder) = out else { return print(&text) };
    Ok(diagnostics::write_whole(&folder.join(format!("{}.{ending}", file_name(&property.name))), text)?)
}

/// The monitor as a picture.
fn svg(monitor: &ScopeMonitor) -> Option<String> {
    let (graph, active) = monitor.graph()?;
    let is_failure = |index: usize| monitor.failures().iter().any(|failure| failure.index() == index);
    let locations = graph.locations().iter().enumerate();
    let transition = |transition: &channels::GraphTransition| drawing::Transition {
        from: transition.from.index(),
        to: transition.to.index(),
        label: graph.caption(transition, monitor.topology()),
    };
    let diagram = drawing::Diagram {
        locations: locations
            .map(|(index, name)| drawing::Location { name: name.clone(), error: is_failure(index) })
            .collect(),
        initial: graph.initial_locations().first().map_or(0, |initial| initial.index()),
        active: active.index(),
        transitions: graph.transitions().iter().map(transition).collect(),
    };
    Some(drawing::diagram_svg(&diagram))
}
