//! Where the types of a bag's messages are defined: in the bag itself, in folders, or on board.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use diagnostics::ReadFile;
use ros_messages::{Bundle, EDITIONS, Folders, Layout, Message, TypeName, Undefined, on_board};

use crate::storage::{Definition, Survey, Topic};

/// Where to find the definitions that a topic lacks.
pub struct Definitions<'r> {
    /// The bag: one of its topics may use what another defines.
    pub survey: &'r Survey,
    /// Folders with packages or with definitions.
    pub folders: &'r [PathBuf],
    /// Reads their files.
    pub read: ReadFile<'r>,
}

/// A type, and where it is defined.
#[derive(Clone, Debug)]
pub struct Defined {
    /// The type.
    pub layout: Arc<Layout>,
    /// How its definition was chosen among those on board, in words; `None` if the bag or a folder defines it.
    pub on_board: Option<String>,
}

/// What the bag and the folders define of the types searched for so far; `None` is what neither of them does.
type Found = BTreeMap<TypeName, Option<Message>>;

impl Definitions<'_> {
    /// The type of a topic, as [`defined`](Self::defined).
    ///
    /// # Errors
    /// The same.
    pub fn layout(&self, topic: &Topic) -> Result<Arc<Layout>, Undefined> {
        Ok(self.defined(topic)?.layout)
    }

    /// The type of a topic: from the definition in the bag, or else from one in the folders, or else from those
    /// [on board](ros_messages::on_board). The latter differ between distributions of ROS 2: the bag has to name its
    /// distribution or the hash of the type, unless all that have the type have it alike.
    ///
    /// # Errors
    /// [`Undefined`] if there is no definition, if it is wrong, or if it is not known which of several is meant.
    pub fn defined(&self, topic: &Topic) -> Result<Defined, Undefined> {
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
        let recorded = match &topic.definition {
            Some(definition) => recorded(&name, topic, definition, &folders)?,
            None => BTreeMap::new(),
        };
        let mut types = recorded.into_iter().map(|(name, message)| (name, Some(message))).collect::<Found>();
        let (mut variants, mut refused): (Vec<Variant>, _) = (Vec::new(), None);
        for edition in self.editions(topic) {
            let mut is_on_board = false;
            let resolved = Layout::resolve(&name, &mut |name| {
                if let Some(message) = self.search(name, &folders, &mut types)? {
                    return Ok(message);
                }
                is_on_board = true;
                Message::known(name, Some(edition))
                    .ok_or_else(|| Undefined::new(format!("there is no definition of {name}"), &folder_with(name)))
            });
            match resolved {
                Ok(layout) if !is_on_board => return defined_elsewhere(topic, &name, layout),
                Ok(layout) => Variant::add(&mut variants, layout, edition),
                Err(undefined) => refused = Some(undefined),
            }
        }
        if let Some(undefined) = refused.filter(|_| variants.is_empty()) {
            return Err(undefined);
        }
        let (layout, how) = self.choose(topic, &name, variants)?;
        let is_on_board = !matches!(types.get(&name), Some(Some(_)));
        Ok(Defined { layout, on_board: is_on_board.then_some(how) })
    }

    /// The definition in the bag or a folder, if one of them has it.
    fn search(&self, name: &TypeName, folders: &Folders<'_>, types: &mut Found) -> Result<Option<Message>, Undefined> {
        if let Some(known) = types.get(name) {
            return Ok(known.clone());
        }
        let found = match self.elsewhere(name) {
            Some(message) => BTreeMap::from([(name.clone(), message)]),
            // An action's messages are defined together, and are used one after the other.
            None => folders.messages(name)?,
        };
        types.extend(found.into_iter().map(|(name, message)| (name, Some(message))));
        Ok(types.entry(name.clone()).or_default().clone())
    }

    /// The editions of ROS 2 in which the bag may have been recorded, oldest first.
    fn editions(&self, topic: &Topic) -> Vec<&'static str> {
        // A hash is more precise. A distribution that is not on board, such as Rolling, may have any of the variants.
        let named = &self.survey.distributions;
        let is_any = topic.hash.is_some() || !named.iter().all(|name| EDITIONS.contains(&name.as_str()));
        let of_named = |edition: &&str| edition.split('-').next().is_some_and(|name| named.contains(name));
        EDITIONS.into_iter().filter(|edition| is_any || named.is_empty() || of_named(edition)).collect()
    }

    /// The variant that the bag was recorded with, and how it is known, in words.
    fn choose(
        &self,
        topic: &Topic,
        name: &TypeName,
        variants: Vec<Variant>,
    ) -> Result<(Arc<Layout>, String), Undefined> {
        if let Some(hash) = &topic.hash {
            let variant = variants.into_iter().find(|variant| variant.hash == *hash).ok_or_else(|| {
                Undefined::new(format!("the bag's {name} is none of those on board: its hash is {hash}"), FOLDER)
            })?;
            return Ok((variant.layout, "by its hash".to_owned()));
        }
        match <[Variant; 1]>::try_from(variants) {
            Ok([variant]) => Ok((variant.layout, format!("as in {}", span(&variant.editions)))),
            Err(variants) => {
                let spans: Vec<String> = variants.iter().map(|variant| span(&variant.editions)).collect();
                let why = format!(
                    "{name} differs between distributions ({}), and the bag does not state which of them it is from",
                    spans.join("; ")
                );
                Err(Undefined::new(why, FOLDER))
            }
        }
    }

    /// The definition of a type, from the definitions of the other topics.
    fn elsewhere(&self, name: &TypeName) -> Option<Message> {
        self.survey.topics.iter().find_map(|topic| {
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

/// A type that the bag or a folder defines. Where the topic itself has no definition, what defines it has to agree with
/// the topic's hash. The topic's own is not held against it: not all programs that write bags compute the same hashes.
fn defined_elsewhere(topic: &Topic, name: &TypeName, layout: Arc<Layout>) -> Result<Defined, Undefined> {
    let is_recorded = topic.definition.as_ref().is_some_and(|definition| !definition.text.trim().is_empty());
    let own = layout.type_hash();
    match &topic.hash {
        Some(hash) if !is_recorded && *hash != own => {
            let why = format!("the definition of {name} is not the recorded one: its hash is {own}, the bag's {hash}");
            Err(Undefined::new(why, FOLDER))
        }
        _ => Ok(Defined { layout, on_board: None }),
    }
}

/// A variant of a type on board.
struct Variant {
    layout: Arc<Layout>,
    hash: String,
    /// The editions of ROS 2 that have it.
    editions: Vec<&'static str>,
}

impl Variant {
    /// Adds the variant that an edition has. Constants do not distinguish variants; those of the newest edition are
    /// kept.
    fn add(variants: &mut Vec<Self>, layout: Arc<Layout>, edition: &'static str) {
        let hash = layout.type_hash();
        match variants.iter_mut().find(|variant| variant.hash == hash) {
            Some(variant) => {
                variant.layout = layout;
                variant.editions.push(edition);
            }
            None => variants.push(Self { layout, hash, editions: vec![edition] }),
        }
    }
}

/// Editions that follow one another, in words.
fn span(editions: &[&str]) -> String {
    match editions {
        [first, .., last] if !last.starts_with(first) => format!("{first} to {last}"),
        [first, ..] => (*first).to_owned(),
        [] => String::new(),
    }
}

/// Advice where the choice of a folder decides the meaning of the bytes.
const FOLDER: &str = "name the definitions that the robot uses: `definitions = [\"/opt/ros/DISTRIBUTION/share\"]`";

/// Advice to name a folder that defines a type.
fn folder_with(name: &TypeName) -> String {
    let package = name.package.as_deref().unwrap_or_default();
    format!("name a folder that contains the package {package}: `definitions = [\"/opt/ros/jazzy/share\"]`")
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
    let is_empty = text.trim().is_empty();
    if is_empty {
        types.extend(folders.messages(name)?);
    }
    if !is_empty || topic.kind.contains("/msg/") && on_board(name, EDITIONS.last().copied()).is_none() {
        types.entry(name.clone()).or_insert(bundle.message);
    }
    Ok(types)
}

/// A type such as `geometry_msgs/msg/Twist`, or one that ROS generates:
/// `nav2_msgs/action/NavigateToPose_FeedbackMessage`.
fn type_name(kind: &str) -> Option<TypeName> {
    TypeName::parse(kind).filter(|name| name.package.is_some())
}
