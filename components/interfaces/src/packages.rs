//! Where ROS definitions are found: in the folders of packages, as `PACKAGE/msg/NAME.msg`.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use diagnostics::document::Table;
use diagnostics::{ReadFile, Spanned, read_text};
use ros_messages::{Action, Folders, Message, Service, TypeName, on_board};

use crate::wire::{Wire, WirePart};

/// The packages with the most common types, each with its repository.
const HOMES: [(&str, &[&str]); 4] = [
    (
        "ros2/common_interfaces",
        &[
            "actionlib_msgs",
            "diagnostic_msgs",
            "geometry_msgs",
            "nav_msgs",
            "sensor_msgs",
            "shape_msgs",
            "std_msgs",
            "std_srvs",
            "stereo_msgs",
            "trajectory_msgs",
            "visualization_msgs",
        ],
    ),
    (
        "ros2/rcl_interfaces",
        &[
            "action_msgs",
            "builtin_interfaces",
            "composition_interfaces",
            "lifecycle_msgs",
            "rcl_interfaces",
            "rosgraph_msgs",
            "service_msgs",
            "statistics_msgs",
            "type_description_interfaces",
        ],
    ),
    ("ros2/unique_identifier_msgs", &["unique_identifier_msgs"]),
    ("ros-navigation/navigation2", &["nav2_msgs"]),
];

/// A kind of definition, by its file extension.
#[derive(Clone, Copy, Debug)]
pub(crate) enum DefinitionKind {
    Message,
    Service,
    Action,
}

impl DefinitionKind {
    pub(crate) fn ending(self) -> &'static str {
        match self {
            Self::Message => "msg",
            Self::Service => "srv",
            Self::Action => "action",
        }
    }

    /// The messages of ROS 2 that carry the parts, in that order: what is added to the name of the definition, and the
    /// field in which the part is, if it is not the whole message.
    fn messages(self) -> &'static [(&'static str, Option<&'static str>)] {
        match self {
            Self::Message => &[("", None)],
            Self::Service => &[("_Request", None), ("_Response", None)],
            Self::Action => &[
                ("_SendGoal_Request", Some("goal")),
                ("_FeedbackMessage", Some("feedback")),
                ("_GetResult_Response", Some("result")),
            ],
        }
    }

    /// The parts of a definition, in the order that interfaces use.
    fn parse(self, name: &str, text: &str) -> Result<Vec<Message>, diagnostics::FileProblems> {
        Ok(match self {
            Self::Message => vec![Message::parse(name, text)?],
            Self::Service => {
                let Service { request, response } = Service::parse(name, text)?;
                vec![request, response]
            }
            Self::Action => {
                let Action { goal, result, feedback } = Action::parse(name, text)?;
                vec![goal, feedback, result]
            }
        })
    }
}

/// The parts of a definition, and its file, relative to which the types that it names are looked up.
#[derive(Clone, Debug)]
pub(crate) struct Definition {
    pub(crate) parts: Vec<Message>,
    pub(crate) path: PathBuf,
}

/// The definitions that one interface file uses.
pub(crate) struct Packages<'r> {
    read: ReadFile<'r>,
    /// The folder of the interface file.
    folder: PathBuf,
    /// Other folders with packages.
    others: Vec<PathBuf>,
    /// The definitions read so far; `None` for one that was refused, which has been reported.
    known: RefCell<BTreeMap<PathBuf, Option<Arc<Definition>>>>,
}

/// Definitions that were not found, or were refused.
pub(crate) enum Missing {
    /// No folder has it.
    Nowhere,
    /// It has an error, which has been reported.
    Refused,
}

impl<'r> Packages<'r> {
    pub(crate) fn new(folder: &Path, others: Vec<String>, read: ReadFile<'r>) -> Self {
        let others = others.into_iter().map(|other| folder.join(other)).collect();
        Self { read, folder: folder.to_owned(), others, known: RefCell::default() }
    }

    /// The definition that a file names by its path, and the folders that are searched for its types.
    pub(crate) fn definition(
        &self,
        named: &Spanned<String>,
        kind: DefinitionKind,
        table: Table<'_>,
    ) -> Option<(Arc<Definition>, Vec<PathBuf>)> {
        let path = Path::new(&named.value);
        if path.extension().and_then(|ending| ending.to_str()) != Some(kind.ending()) {
            let problem = named.span.problem(format!("`ros` must name a `.{}` file", kind.ending()));
            let problem = problem.with_label("this file");
            table.report(
                problem.with_help("a service is a `.srv` file, a topic a `.msg` file, an action an `.action` file"),
            );
            return None;
        }
        let bases = || std::iter::once(&self.folder).chain(&self.others);
        for base in bases() {
            match self.read(&base.join(path), kind, named, table) {
                Ok(definition) => {
                    let above = path.ancestors().skip(1).map(|above| base.join(above));
                    return Some((definition, above.chain(self.others.iter().cloned()).collect()));
                }
                // The file is there, but wrong. One of the same name in another folder would only hide that.
                Err(Missing::Refused) => return None,
                Err(Missing::Nowhere) => {}
            }
        }
        let name = path.to_str().and_then(|path| path.strip_suffix(kind.ending())?.strip_suffix('.'));
        let text = name.and_then(TypeName::parse).and_then(|name| on_board(&name, None));
        if let Some(parts) = text.and_then(|text| kind.parse(&named.value, &text).ok()) {
            let definition = Definition { parts, path: self.folder.join(path) };
            return Some((Arc::new(definition), bases().cloned().collect()));
        }
        let problem = named.span.problem("there is no such definition").with_label("this file");
        let place = self.folder.join(path);
        table.report(problem.with_help(format!("it is expected at {}, or in one of the `packages`", place.display())));
        None
    }

    /// What a definition is in ROS 2, if the fields of each part have these paths; or why that is not known.
    pub(crate) fn wire(
        &self,
        definition: &Definition,
        folders: &[PathBuf],
        kind: DefinitionKind,
        paths: &[Vec<String>],
    ) -> Result<Wire, String> {
        let package = package_of(&definition.path).and_then(Path::file_name).and_then(OsStr::to_str);
        let package = package.ok_or_else(|| "its definition is not in a folder of a package".to_owned())?;
        let name = definition.path.file_stem().and_then(OsStr::to_str).unwrap_or_default();
        let folders = Folders { paths: folders, read: self.read };
        let parts = kind.messages().iter().zip(paths).map(|((suffix, part), paths)| {
            let layout = folders.layout(&TypeName::new(Some(package), &format!("{name}{suffix}")));
            Ok(WirePart::new(layout.map_err(|undefined| undefined.why)?, *part, paths))
        });
        Ok(Wire { kind: format!("{package}/{}/{name}", kind.ending()), parts: parts.collect::<Result<_, String>>()? })
    }

    /// The definition of a type that another definition names.
    pub(crate) fn message(
        &self,
        name: &TypeName,
        user: &Definition,
        folders: &[PathBuf],
        named: &Spanned<String>,
        table: Table<'_>,
    ) -> Result<Arc<Definition>, Missing> {
        let file = format!("{}.msg", name.name);
        let candidates: Vec<PathBuf> = match &name.package {
            Some(package) => folders.iter().map(|folder| folder.join(package).join("msg").join(&file)).collect(),
            None => vec![
                package_of(&user.path)
                    .map_or_else(|| user.path.with_file_name(&file), |package| package.join("msg").join(&file)),
            ],
        };
        for candidate in candidates {
            match self.read(&candidate, DefinitionKind::Message, named, table) {
                Err(Missing::Nowhere) => {}
                found_or_refused => return found_or_refused,
            }
        }
        let package = package_of(&user.path).and_then(Path::file_name).and_then(OsStr::to_str);
        self.builtin(&name.within(package.unwrap_or_default())).ok_or(Missing::Nowhere)
    }

    /// A type on board that all distributions of ROS 2 have alike.
    fn builtin(&self, name: &TypeName) -> Option<Arc<Definition>> {
        let message = Message::known(name, None)?;
        let folder = self.folder.join(name.package.as_deref().unwrap_or_default());
        let path = folder.join("msg").join(format!("{}.msg", name.name));
        Some(Arc::new(Definition { parts: vec![message], path }))
    }

    fn read(
        &self,
        path: &Path,
        kind: DefinitionKind,
        named: &Spanned<String>,
        table: Table<'_>,
    ) -> Result<Arc<Definition>, Missing> {
        if let Some(known) = self.known.borrow().get(path) {
            return known.clone().ok_or(Missing::Refused);
        }
        let text = match read_text(path, self.read) {
            Err(diagnostics::Error::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                return Err(Missing::Nowhere);
            }
            read => read,
        };
        let parsed = text.and_then(|text| Ok(kind.parse(&path.display().to_string(), &text)?));
        let read = match parsed {
            Ok(parts) => Some(Arc::new(Definition { parts, path: path.to_owned() })),
            Err(error) => {
                report(error, named, table);
                None
            }
        };
        // A refused file is remembered, too: many types may use it, and its problems are reported once. A missing one
        // is not: it may be found in another folder, and the report depends on who needs it.
        self.known.borrow_mut().insert(path.to_owned(), read.clone());
        read.ok_or(Missing::Refused)
    }
}

/// Reports why a definition could not be read.
fn report(error: diagnostics::Error, named: &Spanned<String>, table: Table<'_>) {
    match error {
        diagnostics::Error::Problems(problems) => {
            problems.problems().iter().for_each(|problem| table.report(problem.clone()));
        }
        error => table.report(named.span.problem(error.to_string()).with_label("needed here")),
    }
}

/// The folder of the package to which a definition belongs, if it belongs to one.
fn package_of(path: &Path) -> Option<&Path> {
    let folder = path.parent()?;
    let kind = folder.file_name()?.to_str()?;
    ["msg", "srv", "action"].contains(&kind).then(|| folder.parent())?
}

/// How to add the definition of a type that is missing.
pub(crate) fn what_to_add(name: &TypeName, folders: &[PathBuf]) -> String {
    let Some(package) = &name.package else {
        let hint = if name.name == "Header" { "; ROS's own is `std_msgs/Header`" } else { "" };
        return format!("add {}.msg to the folder `msg` of the same package{hint}", name.name);
    };
    let home = HOMES.iter().find(|(_, packages)| packages.contains(&package.as_str()));
    let from = home.map_or_else(String::new, |(home, _)| format!(", from github.com/{home}"));
    let folder = folders.iter().rev().find(|folder| folder.is_relative()).map_or(Path::new(""), |folder| folder);
    let file = folder.join(package).join("msg").join(format!("{}.msg", name.name));
    format!(
        "add {}{from}; or name a folder that contains the package, such as ROS's own: `packages = [\"/opt/ros/jazzy/share\"]`",
        file.display()
    )
}
