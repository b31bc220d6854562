//! Message types with all nested types resolved, as CDR needs them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use diagnostics::{Error, ReadFile, read_text};
use interfaces::ros::{Action, Base, Bundle, Constant, Count, Message, Service, TypeName};

use crate::storage::Topic;

/// A message type.
#[derive(Debug, PartialEq)]
pub struct Layout {
    /// Its name.
    pub name: TypeName,
    /// Its constants.
    pub constants: Vec<Constant>,
    /// Its fields, in the order in which they are sent.
    pub fields: Vec<Slot>,
}

/// A field of a message type.
#[derive(Debug, PartialEq)]
pub struct Slot {
    /// Its name.
    pub name: String,
    /// The type of one item.
    pub item: Item,
    /// How many items there are.
    pub count: Count,
}

/// The type of one item.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A number, a string or a Boolean.
    Plain(Base),
    /// A message.
    Message(Arc<Layout>),
}

/// Why a topic's messages cannot be decoded.
#[derive(Debug, thiserror::Error)]
#[error("{why}")]
pub struct Undefined {
    /// The problem, in words.
    pub why: String,
    /// How to fix it.
    pub help: String,
}

/// Messages nested deeper are rejected: they must contain themselves.
const DEEPEST: usize = 50;

/// Where to find the definitions that a topic lacks.
pub struct Definitions<'r> {
    /// The topics of the bag: one may use what another defines.
    pub topics: &'r [Topic],
    /// Folders with packages or with definitions.
    pub folders: &'r [PathBuf],
    /// Reads their files.
    pub read: ReadFile<'r>,
}

impl Definitions<'_> {
    /// The type of a topic: from the definition in the bag, or from one in the folders.
    ///
    /// # Errors
    /// [`Undefined`] if neither has a definition, or the definition is wrong.
    pub fn layout(&self, topic: &Topic) -> Result<Arc<Layout>, Undefined> {
        let undefined = |why: String, help: &str| Undefined { why, help: help.to_owned() };
        if topic.encoding != "cdr" {
            let why = format!("the messages of {} are encoded as `{}`, not as CDR", topic.name, topic.encoding);
            return Err(undefined(why, "only ROS 2 recordings can be read"));
        }
        let name = type_name(&topic.kind).ok_or_else(|| {
            undefined(format!("`{}` is not the name of a type", topic.kind), "for example `geometry_msgs/msg/Twist`")
        })?;
        let mut types = BTreeMap::new();
        if let Some(definition) = &topic.definition {
            let (title, text) = (format!("the definition of {}", topic.kind), &definition.text);
            let bundle = match definition.language.as_str() {
                "ros2msg" => Bundle::parse(&title, text),
                "ros2idl" => Bundle::parse_idl(&name, text),
                other => {
                    let why = format!("{title} is in `{other}`");
                    return Err(undefined(why, "only definitions in `ros2msg` and `ros2idl` can be read"));
                }
            };
            let bundle = bundle.map_err(|problems| {
                undefined(problems.plain().trim_end().to_owned(), "the definition in the bag is wrong")
            })?;
            types = bundle.types;
            // If rosbag2 finds no definition, it writes an empty one. But there are also messages without fields.
            if text.trim().is_empty() {
                let package = name.package.as_deref().unwrap_or_default();
                types.extend(self.on_disk(package, &name.name)?);
            }
            if !text.trim().is_empty() || topic.kind.contains("/msg/") {
                types.entry(name.clone()).or_insert(bundle.message);
            }
        }
        let mut made = BTreeMap::new();
        self.resolve(&name, &mut types, &mut made, 0)
    }

    fn resolve(
        &self,
        name: &TypeName,
        types: &mut BTreeMap<TypeName, Message>,
        made: &mut BTreeMap<TypeName, Arc<Layout>>,
        depth: usize,
    ) -> Result<Arc<Layout>, Undefined> {
        if let Some(layout) = made.get(name) {
            return Ok(Arc::clone(layout));
        }
        if depth > DEEPEST {
            let help = "a ROS message cannot contain itself".to_owned();
            return Err(Undefined { why: format!("{name} contains itself"), help });
        }
        let package = name.package.clone().unwrap_or_default();
        let known = types.get(name).cloned().or_else(|| Message::known(name)).or_else(|| self.elsewhere(name));
        let message = match known {
            Some(message) => message,
            None => {
                types.extend(self.on_disk(&package, &name.name)?);
                types.get(name).cloned().ok_or_else(|| Undefined {
                    why: format!("there is no definition of {name}"),
                    help: format!(
                        "name a folder that contains the package {package}: `definitions = [\"/opt/ros/jazzy/share\"]`"
                    ),
                })?
            }
        };
        let mut fields = Vec::new();
        for field in message.fields {
            let item = match field.kind.base {
                Base::Message(used) => {
                    // In ROS 1, this name needed no package.
                    let is_header = used.package.is_none() && used.name == "Header" && package != "std_msgs";
                    let used = used.within(if is_header { "std_msgs" } else { &package });
                    Item::Message(self.resolve(&used, types, made, depth + 1)?)
                }
                plain => Item::Plain(plain),
            };
            fields.push(Slot { name: field.name, item, count: field.kind.count });
        }
        let layout = Arc::new(Layout { name: name.clone(), constants: message.constants, fields });
        made.insert(name.clone(), Arc::clone(&layout));
        Ok(layout)
    }

    /// The definition of a type, from the definitions of the other topics.
    fn elsewhere(&self, name: &TypeName) -> Option<Message> {
        self.topics.iter().find_map(|topic| {
            let definition = topic.definition.as_ref().filter(|definition| definition.language == "ros2msg")?;
            if definition.text.trim().is_empty() {
                return None;
            }
            let Bundle { message, mut types } = Bundle::parse("", &definition.text).ok()?;
            if type_name(&topic.kind).as_ref() == Some(name) { Some(message) } else { types.remove(name) }
        })
    }

    /// The definitions with this name in the folders. A service or an action defines several messages.
    fn on_disk(&self, package: &str, name: &str) -> Result<Vec<(TypeName, Message)>, Undefined> {
        let whole = name.split_once('_').map_or(name, |(whole, _)| whole);
        for (kind, name) in [("msg", name), ("srv", whole), ("action", whole)] {
            let file = format!("{name}.{kind}");
            let folders = self.folders.iter().flat_map(|folder| {
                let own = folder.file_name().is_some_and(|last| last == package);
                std::iter::once(folder.join(package)).chain(own.then(|| folder.clone()))
            });
            for path in folders.map(|folder| folder.join(kind).join(&file)) {
                let Some(text) = self.text(&path)? else { continue };
                let title = path.display().to_string();
                let messages = match kind {
                    "msg" => Message::parse(&title, &text).map(|message| vec![(name.to_owned(), message)]),
                    "srv" => Service::parse(&title, &text).map(|service| service.messages(name).to_vec()),
                    _ => Action::parse(&title, &text).map(|action| action.messages(name)),
                };
                let messages = messages.map_err(|problems| Undefined {
                    why: problems.plain().trim_end().to_owned(),
                    help: "the definition in the folder is wrong".to_owned(),
                })?;
                let named = |(name, message): (String, Message)| (TypeName::new(Some(package), &name), message);
                return Ok(messages.into_iter().map(named).collect());
            }
        }
        Ok(Vec::new())
    }

    fn text(&self, path: &Path) -> Result<Option<String>, Undefined> {
        match read_text(path, self.read) {
            Ok(text) => Ok(Some(text)),
            Err(Error::Read { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Undefined { why: error.to_string(), help: "the folder must be readable".to_owned() }),
        }
    }
}

/// A type such as `geometry_msgs/msg/Twist`, or one that ROS generates:
/// `nav2_msgs/action/NavigateToPose_FeedbackMessage`.
fn type_name(kind: &str) -> Option<TypeName> {
    match *kind.split('/').collect::<Vec<_>>() {
        [package, "msg" | "srv" | "action", name] | [package, name] if !package.is_empty() && !name.is_empty() => {
            Some(TypeName::new(Some(package), name))
        }
        _ => None,
    }
}
