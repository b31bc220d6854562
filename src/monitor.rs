//! `steward monitor check|explain|export FILE`: property files, and the monitors built from them; and `new`, to write
//! one.

mod new;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use campaigns::Error;
use channels::Monitor as _;
use checks::System;
use clap::{Args, Subcommand, ValueEnum};
use monitors::{Format, Method, Property, ScopeMonitor, explain};
use reports::file_name;
use reports::pictures::diagram;
use scenarios::Complaints;

use new::NewProperty;

use crate::output::{print, print_wrapped, warn};

/// Property files: checks them, explains them, exports their monitors.
#[derive(Debug, Subcommand)]
pub(crate) enum MonitorCommand {
    /// Reports everything that is wrong with property files, and how each property is monitored
    Check(PropertySource),
    /// Explains in plain English what each property requires
    Explain(PropertySource),
    /// Prints a property after one of the usual patterns
    New(NewProperty),
    /// Writes the monitors as program graphs
    Export {
        #[command(flatten)]
        source: PropertySource,
        /// How to write them
        #[arg(long, value_enum, default_value_t = ExportFormat::Text)]
        format: ExportFormat,
        /// Only the property with this name
        #[arg(long, value_name = "NAME")]
        property: Option<String>,
        /// Where to write to, one file per property; to stdout if not given
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

/// Property files, and the system to which they refer.
#[derive(Debug, Args)]
pub(crate) struct PropertySource {
    /// Property files, or names of shipped ones
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// The scenario whose processes and channels they mention
    #[arg(long, value_name = "NAME|FILE", default_value = "nominal")]
    scenario: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExportFormat {
    /// One line per location and per transition
    Text,
    /// Graphviz
    Dot,
    /// A picture
    Svg,
    /// An SCXML machine with the ECMAScript data model
    Scxml,
}

impl ExportFormat {
    fn file(self, folder: &Path, property: &Property) -> PathBuf {
        let ending = match self {
            Self::Text => "txt",
            Self::Dot => "dot",
            Self::Svg => "svg",
            Self::Scxml => "scxml",
        };
        folder.join(format!("{}.{ending}", file_name(&property.name)))
    }
}

pub(crate) fn run(command: &MonitorCommand) -> Result<ExitCode, Error> {
    match command {
        MonitorCommand::Check(source) => {
            let method = |property: &Property| format!("{}: {}\n", property.name, method(property));
            print_wrapped(source.load()?.iter().map(method).collect::<String>())?;
        }
        MonitorCommand::Explain(source) => print_wrapped(source.load()?.iter().map(explained).collect::<String>())?,
        MonitorCommand::New(args) => {
            let text = new::text(args)?;
            // Only what loads is printed.
            System::of(&args.scenario)?.read("new.scope", &text)?;
            print(&text)?;
        }
        MonitorCommand::Export { source, format, property, out } => {
            let properties = source.load()?;
            let wanted = |name: &str| property.as_deref().is_none_or(|wanted| wanted == name);
            let chosen: Vec<&Property> = properties.iter().filter(|property| wanted(&property.name)).collect();
            if chosen.is_empty() {
                let names: Vec<&str> = properties.iter().map(|property| property.name.as_str()).collect();
                return Err(match (property, names.as_slice()) {
                    (Some(property), [_, ..]) => Error::refused(
                        format!("there is no property `{property}`"),
                        format!("known: {}", names.join(", ")),
                    ),
                    _ => Error::refused("there is no property in these files", "write one: property NAME := …"),
                });
            }
            if let Some(folder) = out {
                chosen.iter().try_for_each(|property| diagnostics::check_unread(&format.file(folder, property)))?;
            }
            // A property without such a picture does not prevent the others from being written.
            let mut complaints = Complaints::default();
            for property in chosen {
                match export(property, *format, out.as_deref()) {
                    Err(Error::Scenario(error @ scenarios::Error::BadInput(_))) => {
                        let _ = complaints.take::<()>(Err(error));
                    }
                    done => done?,
                }
            }
            complaints.check()?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

impl PropertySource {
    /// The properties of all files.
    fn load(&self) -> Result<Vec<Property>, Error> {
        let system = System::of(&self.scenario)?;
        let (mut complaints, mut properties) = (Complaints::default(), Vec::new());
        for file in self.files.iter().filter_map(|file| complaints.take(system.load(file))) {
            if !file.warnings.is_empty() {
                warn(&file.warnings);
            }
            properties.extend(file.properties);
        }
        complaints.check()?;
        Ok(properties)
    }
}

/// A property's requirement: in the words of its file, and in those of its formula.
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
        Some(Method::Rules) => "rules, which have no graph; violations come as early as possible".to_owned(),
        Some(Method::Graphs) => "program graphs side by side; verdicts may come late".to_owned(),
        Some(_) => "progression; verdicts may come late".to_owned(),
    }
}

fn export(property: &Property, format: ExportFormat, out: Option<&Path>) -> Result<(), Error> {
    let monitor = property.scope_monitor();
    let text = match format {
        ExportFormat::Text => monitor.and_then(|monitor| monitor.export(Format::Text)),
        ExportFormat::Dot => monitor.and_then(|monitor| monitor.export(Format::Dot)),
        ExportFormat::Scxml => monitor.and_then(|monitor| monitor.export(Format::Scxml)),
        ExportFormat::Svg => monitor.and_then(svg),
    };
    let text = text.ok_or_else(|| {
        let message =
            format!("`{}` is not a program graph of that size: it is monitored by {}", property.name, method(property));
        Error::refused(message, "a picture shows at most a dozen states; text, dot and scxml show all of an automaton")
    })?;
    let Some(folder) = out else { return print(&text) };
    Ok(diagnostics::write_whole(&format.file(folder, property), text)?)
}

/// The monitor as a picture, with all transitions as they are written.
fn svg(monitor: &ScopeMonitor) -> Option<String> {
    let (graph, active) = monitor.graph()?;
    let transition = |transition: &channels::GraphTransition| recording::Transition {
        from: transition.from.index(),
        to: transition.to.index(),
        label: graph.caption(transition, monitor.topology()),
    };
    let transitions = graph.transitions().iter().map(transition).collect();
    let whole = recording::Graph { transitions, ..recording::Graph::of(monitor, monitor.topology())? };
    Some(drawing::diagram_svg(&diagram(&whole, active.index())))
}
