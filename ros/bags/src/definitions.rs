//! Where the types of a bag's messages are defined: in the bag itself, or in folders.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use diagnostics::ReadFile;
use ros_messages::{Bundle, Folders, Layout, Message, TypeName, Undefined};

use crate::storage::{Definition, Topic};

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
        if topic.encoding != "cdr" {
            let why = format!("the messages of {} are encoded as `{}`, not as CDR", topic.name, topic.encoding);
            return Err(Undefined::new(why, "only ROS 2 recordings can be read"));
        }
        let name = type_name(&topic.kind).ok_or_else(|| {
            Undefined::new(
                format!("`{}` is not the name of a type", topic.kind),
                "for example `geometry_msgs/msg/Twist`",
            )
        })?;
        let folders = Folders { paths: self.folders, read: self.read };
        let mut types = match &topic.definition {
            Some(definition) => recorded(&name, topic, definition, &folders)?,
            None => BTreeMap::new(),
        };
        Layout::resolve(&name, &mut |name| {
            let known = types.get(name).cloned().or_else(|| Message::known(name, None)).or_else(|| self.elsewhere(name));
            if let Some(message) = known {
                return Ok(message);
            }
            // An action's messages are defined together, and are used one after the other.
            types.extend(folders.messages(name)?);
            types.get(name).cloned().ok_or_else(|| {
                let package = name.package.as_deref().unwrap_or_default();
                Undefined::new(
                    format!("there is no definition of {name}"),
                    &format!(
                        "name a folder that contains the package {package}: `definitions = [\"/opt/ros/jazzy/share\"]`"
                    ),
                )
            })
        })
    }

    /// The definition of a type, from the definitions of the other topics.
    fn elsewhere(&self, name: &TypeName) -> Option<Message> {
        self.topics.iter().find_map(|topic| {
            let definition = topic.definition.as_ref().filter(|definition| definition.language == "ros2msg")?;
            if definition.text.trim().is_empty() {
                return None;
            }
            let Bundle { message, types } = Bundle::parse("", &definition.text).ok()?;
            let own = type_name(&topic.kind).map(|own| (own, message));
            own.into_iter().chain(types).find_map(|(found, message)| (found == *name).then_some(message))
        })
    }
}

/// The types that the bag defines for a topic.
fn recorded(
    name: &TypeName,
    topic: &Topic,
    definition: &Definition,
    folders: &Folders<'_>,
) -> Result<BTreeMap<TypeName, Message>, Undefined> {
    let (title, text) = (format!("the definition of {}", topic.kind), &definition.text);
    let bundle = match definition.language.as_str() {
        "ros2msg" => Bundle::parse(&title, text),
        "ros2idl" => Bundle::parse_idl(name, text),
        other => {
            let why = format!("{title} is in `{other}`");
            return Err(Undefined::new(why, "only definitions in `ros2msg` and `ros2idl` can be read"));
        }
    };
    let bundle = bundle.map_err(|problems| {
        Undefined::new(problems.plain().trim_end().to_owned(), "the definition in the bag is wrong")
    })?;
    let mut types: BTreeMap<TypeName, Message> = bundle.types.into_iter().collect();
    // If rosbag2 finds no definition, it writes an empty one. But there are also messages without fields.
    if text.trim().is_empty() {
        types.extend(folders.messages(name)?);
    }
    if !text.trim().is_empty() || topic.kind.contains("/msg/") {
        types.entry(name.clone()).or_insert(bundle.message);
    }
    Ok(types)
}

/// A type such as `geometry_msgs/msg/Twist`, or one that ROS generates:
/// `nav2_msgs/action/NavigateToPose_FeedbackMessage`.
fn type_name(kind: &str) -> Option<TypeName> {
    TypeName::parse(kind).filter(|name| name.package.is_some())
}
