//! Mapping files: which messages of a bag become which messages on channels.

mod compile;

use std::path::{Path, PathBuf};
use std::time::Duration;

use channels::{Symbol, Value};
use diagnostics::document::{Document, Item, Key, Referent, Table};
use diagnostics::{Problem, ReadFile, Span, Spanned, read_text};
use ros_messages::{EDITIONS, Message, TypeName, is_name};
use serde_json::json;

use crate::storage::Survey;

pub use compile::{Compiled, Described};
pub(crate) use compile::{CompiledEntry, FieldRule, MessageTime, Number};

/// Types whose messages are so large that it costs a robot something to send them.
const LARGE: [&str; 3] = ["sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/PointCloud2"];

/// A mapping file that has been read but not yet compared with a bag.
#[derive(Clone, Debug)]
pub struct Mapping {
    /// Time between ticks.
    pub tick: Duration,
    /// How late messages may come and still be put in order.
    pub(crate) reorder: Duration,
    time: Spanned<String>,
    /// Folders with definitions.
    folders: Vec<PathBuf>,
    messages: Vec<Mapped>,
    robot: Option<RobotTopics>,
}

/// The topics with the position of a robot, for pictures of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotTopics {
    /// The map: `nav_msgs/msg/OccupancyGrid`.
    pub map: String,
    /// Where localization sees the robot on it; without one, the transforms have it.
    pub pose: Option<String>,
    /// Its odometry: `nav_msgs/msg/Odometry`. Without such a topic, the transforms have it.
    pub odometry: Option<String>,
    /// Its scans: `sensor_msgs/msg/LaserScan`.
    pub scan: Option<String>,
    /// The path that it follows: `nav_msgs/msg/Path`.
    pub path: Option<String>,
    /// Its transforms: `/tf` and `/tf_static`, and the same within its namespace if it has one.
    pub transforms: Vec<String>,
}

impl RobotTopics {
    /// All of them.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let named = [&self.pose, &self.odometry, &self.scan, &self.path].into_iter().flatten();
        std::iter::once(&self.map).chain(named).chain(&self.transforms).map(String::as_str)
    }

    fn renamed(self, space: &str, mut name: impl FnMut(&str) -> String) -> Self {
        let mut name = |topic: String| name(&topic);
        let Self { map, pose, odometry, scan, path, mut transforms } = self;
        let [pose, odometry, scan, path] = [pose, odometry, scan, path].map(|topic| topic.map(&mut name));
        if !space.is_empty() {
            transforms.extend(transforms.clone().iter().map(|topic| format!("{space}{topic}")));
        }
        transforms = transforms.into_iter().map(&mut name).collect();
        Self { map: name(map), pose, odometry, scan, path, transforms }
    }
}

/// The name of a topic in a namespace, if it does not begin with `/`.
fn within(space: &str, name: &str) -> String {
    if name.starts_with('/') { name.to_owned() } else { format!("{space}/{name}") }
}

/// Another name for a topic, as `FROM:=TO` of ROS 2: both names are within a namespace if they do not begin with `/`.
/// The topics of a service or an action go by its name.
#[derive(Clone, Debug)]
pub struct Remapping {
    /// The name in the mapping.
    pub from: String,
    /// The one that is read.
    pub to: String,
}

impl Remapping {
    /// The other name of a topic whose name is within its namespace, if this is about it.
    fn apply(&self, space: &str, name: &str) -> Option<String> {
        let rest = name.strip_prefix(&within(space, &self.from))?;
        let is_about = rest.is_empty() || rest == "/_service_event" || rest.starts_with("/_action/");
        is_about.then(|| within(space, &self.to) + rest)
    }
}

/// The name of a topic in a namespace, and which remapping has given it, if one is about it: the first.
#[must_use]
pub fn resolve(space: &str, name: &str, remapped: &[Remapping]) -> (String, Option<usize>) {
    let name = within(space, name);
    let other = remapped.iter().enumerate().find_map(|(rule, of)| Some((of.apply(space, &name)?, Some(rule))));
    other.unwrap_or((name, None))
}

/// An entry of `[[messages]]`.
#[derive(Clone, Debug)]
struct Mapped {
    topic: Spanned<String>,
    /// The type of the messages, if the mapping names it.
    kind: Option<Spanned<String>>,
    from: Spanned<String>,
    to: Spanned<String>,
    time: Option<Spanned<String>>,
    /// The array whose items become messages, if it is not the topic's message that does.
    each: Option<Spanned<String>>,
    /// Whether it does not matter which messages are missing.
    is_lossy: bool,
    tests: Tests,
    fields: Vec<(String, FieldSource)>,
    span: Span,
}

/// Paths that must have one of some values.
type Tests = Vec<(Spanned<String>, Vec<Spanned<Value>>)>;

/// Where the value of a field comes from.
#[derive(Clone, Debug)]
enum FieldSource {
    Constant(Value),
    Path { path: Spanned<String>, symbols: Option<Vec<(String, Symbol)>>, scale: Option<Spanned<f64>> },
}

impl Mapping {
    /// Reads a mapping file.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn load(path: &Path, read: ReadFile<'_>) -> Result<Self, diagnostics::Error> {
        let document = Document::parse_toml(&path.display().to_string(), &read_text(path, read)?)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Ok(document.read(|root| read_file(root, folder))?)
    }

    /// The mapping for each of several robots, by their namespaces, such as `/fleet/r1`. Names of topics that do not
    /// begin with `/` are within the namespace, and each robot has its own processes: `fleet/r1/battery`. Without
    /// robots, such topics are those of the root. Of several robots, there is no picture. The first remapping that is
    /// about a topic gives it another name.
    ///
    /// # Errors
    /// The first remapping that is about no topic.
    pub fn of_robots<'r>(self, robots: &[String], remapped: &'r [Remapping]) -> Result<Self, &'r Remapping> {
        let mut is_used = vec![false; remapped.len()];
        let mut name = |space: &str, topic: &str| {
            let (name, rule) = resolve(space, topic, remapped);
            rule.into_iter().for_each(|rule| is_used[rule] = true);
            name
        };
        let only = match robots {
            [] => Some(""),
            [space] => Some(space.as_str()),
            _ => None,
        };
        let robot = only.and_then(|space| Some(self.robot?.renamed(space, |topic| name(space, topic))));
        let root = [String::new()];
        let mut messages = Vec::new();
        for space in if robots.is_empty() { &root } else { robots } {
            for mut mapped in self.messages.iter().cloned() {
                mapped.topic.value = name(space, &mapped.topic.value);
                if !robots.is_empty() {
                    let ends = [&mut mapped.from, &mut mapped.to];
                    ends.into_iter().for_each(|end| end.value.insert_str(0, &prefix(space)));
                }
                messages.push(mapped);
            }
        }
        match remapped.iter().zip(is_used).find(|(_, is_used)| !is_used) {
            Some((unused, _)) => Err(unused),
            None => Ok(Self { messages, robot, ..self }),
        }
    }

    /// The mapping without topics of images and point clouds whose senders, by their own names, are not needed, and
    /// these topics. Without any other topic, all remain.
    #[must_use]
    pub fn without_large(mut self, needs: impl Fn(&str) -> bool) -> (Self, Vec<String>) {
        let is_large = |mapped: &Mapped| {
            let sender = mapped.from.value.rsplit('/').next().unwrap_or_default();
            mapped.kind.as_ref().is_some_and(|kind| LARGE.contains(&kind.value.as_str())) && !needs(sender)
        };
        if self.messages.iter().all(is_large) {
            return (self, Vec::new());
        }
        let left_out = self.messages.extract_if(.., |mapped| is_large(mapped));
        let mut topics: Vec<String> = left_out.map(|mapped| mapped.topic.value).collect();
        topics.retain(|topic| !self.messages.iter().any(|mapped| mapped.topic.value == *topic));
        topics.sort_unstable();
        topics.dedup();
        (self, topics)
    }

    /// The topics with the position of the robot, if the mapping names them.
    #[must_use]
    pub fn robot(&self) -> Option<&RobotTopics> {
        self.robot.as_ref()
    }

    /// Whether messages have the times at which they were recorded, unless an entry has its own time, and not stamps.
    #[must_use]
    pub fn is_by_log(&self) -> bool {
        matches!(self.time.value.as_str(), "log" | "publish")
    }

    /// Whether every message has the time at which it was recorded, or received: only then is it known without one how
    /// much time has passed.
    #[must_use]
    pub fn is_received(&self) -> bool {
        self.times().all(|time| time == "log")
    }

    /// Whether messages have the latest time on the topic [`CLOCK`].
    pub(crate) fn has_clock(&self) -> bool {
        self.times().any(|time| time == "clock")
    }

    fn times(&self) -> impl Iterator<Item = &str> {
        self.messages.iter().map(|mapped| mapped.time.as_ref().unwrap_or(&self.time).value.as_str())
    }

    /// The names of the topics that are read.
    pub fn topics(&self) -> impl Iterator<Item = &str> {
        let clock = self.has_clock().then_some(CLOCK);
        self.messages.iter().map(|mapped| mapped.topic.value.as_str()).chain(clock)
    }

    /// The first mapped topic that a source lacks and whose type the mapping does not name, or only the source defines:
    /// until it appears, the fields of its channel are unknown.
    #[must_use]
    pub fn awaited(&self, survey: &Survey) -> Option<&str> {
        let is_known = |name: &str| survey.topics.iter().any(|topic| topic.name == name);
        // Whether folders define a type shows when the mapping is compiled.
        let is_from_source = survey.has_definitions && self.folders.is_empty();
        let is_on_board = |kind: &str| {
            TypeName::parse(kind).is_none_or(|name| Message::known(&name, EDITIONS.last().copied()).is_some())
        };
        let is_defined = |kind: &Spanned<String>| !is_from_source || is_on_board(&kind.value);
        let awaited = self
            .messages
            .iter()
            .find(|mapped| !is_known(&mapped.topic.value) && !mapped.kind.as_ref().is_some_and(is_defined));
        let clock = (self.has_clock() && !is_known(CLOCK)).then_some(CLOCK);
        awaited.map(|mapped| mapped.topic.value.as_str()).or(clock)
    }

    /// All keys of a mapping file.
    #[must_use]
    pub fn keys() -> Vec<Key> {
        Key::all(|root| read_file(root, Path::new("")))
    }

    /// The JSON schema of a mapping file.
    #[must_use]
    pub fn schema() -> serde_json::Value {
        Key::json_schema("A mapping of a bag for steward", json!({}), &Self::keys())
    }
}

/// What the names of a robot's processes begin with, and those of its properties.
#[must_use]
pub fn prefix(space: &str) -> String {
    format!("{}/", space.trim_start_matches('/'))
}

/// The topic on which a simulation publishes its time, as `rosgraph_msgs/msg/Clock`.
pub(crate) const CLOCK: &str = "/clock";

/// The sources of time, in words.
const TIME: &str = "`log`, `publish`, `clock`, or the path of a stamp in the message, such as `header.stamp`";

fn read_file(root: Table<'_>, folder: &Path) -> Option<Mapping> {
    let about = "Time between ticks, in seconds. The first tick comes with the first mapped message.";
    let tick = root.seconds("tick_s").about(about).above_0().default(Duration::from_secs(1));
    let log = Spanned { value: "log".to_owned(), span: root.span().clone() };
    let about = "The time of a message: when it was recorded or received, when it was sent, the latest time on `/clock`, or the value \
                 of a field.";
    let time = root.text("time").about(about).words(TIME).spanned().default(log);
    let reorder = root.seconds("reorder_s").about(
        "How long to wait for messages that arrive late, in seconds. Messages that arrive even later get the time \
         of the message before them, and what they could change is unsure.",
    );
    let reorder = reorder.default(Duration::from_secs(1));
    let folders = root
        .get::<Vec<String>>("definitions")
        .words("an array of strings, relative to this file")
        .about("Folders with ROS packages, such as `/opt/ros/jazzy/share`, for types that the bag does not define.");
    let folders = folders.or(Vec::new());
    let messages = root.tables("messages").about("The messages that travel on a channel.");
    let messages = messages.required_or("add a table `[[messages]]`; `steward verify --list BAG` proposes some")?;
    let about = "Topics that show the robot on its map: on the page of `watch --live`, and in the report of a bag, which \
                 otherwise takes the only topic of each kind.";
    let robot = root.table("robot").about(about).optional().and_then(robot);
    let messages: Vec<Option<Mapped>> = messages.into_iter().map(mapped).collect();
    Some(Mapping {
        tick,
        reorder,
        time,
        folders: folders.into_iter().map(|name| folder.join(name)).collect(),
        messages: messages.into_iter().collect::<Option<_>>()?,
        robot,
    })
}

fn robot(table: Table<'_>) -> Option<RobotTopics> {
    let topic = |key, about| table.text(key).about(about);
    let map = topic("map", "The map, `nav_msgs/msg/OccupancyGrid`.").required();
    let about = "Where localization sees the robot, such as `/amcl_pose`. Without it, `/tf` has its pose.";
    let pose = topic("pose", about).optional();
    let odometry = topic("odometry", "Its odometry, `nav_msgs/msg/Odometry`. Without it, `/tf` has it.").optional();
    let scan = topic("scan", "Its scans, `sensor_msgs/msg/LaserScan`.").optional();
    let path = topic("path", "The path that it follows, `nav_msgs/msg/Path`.").optional();
    let transforms = ["/tf", "/tf_static"].map(str::to_owned).into();
    Some(RobotTopics { map: map?, pose, odometry, scan, path, transforms })
}

fn mapped(table: Table<'_>) -> Option<Mapped> {
    let text = |key, about| table.text(key).about(about).spanned();
    let topic = text("topic", "The topic, also of a service or an action: `/go/_action/status`. Without `/` at its beginning, it is within the \
                         namespace of each robot that `--robot` names.").required();
    let about = "The type of the messages. With it, `watch` need not wait until the topic exists, nor `--follow` for its first message. Of a topic with several types, messages of the others are left out.";
    let kind = text("type", about).refers_to(Referent::MessageType).optional();
    let from = text("from", "The process that sends.").refers_to(Referent::Process).required();
    let to = text("to", "The process that receives.").refers_to(Referent::Process).required();
    let fields = fields(table);
    let tests = tests(table);
    let time = table.text("time").about("Like `time`, for these messages.").words(TIME).spanned().optional();
    let about = "An array of messages in the topic's message, such as `event_log` or `transforms`: each of its items becomes a message of its own. \
                 The paths of `fields` and `where` are then within the item, or begin with `/` at the topic's message.";
    let each = text("each", about).optional();
    let about = "Whether lost messages leave no verdict unsure: the properties are about those that arrive.";
    let is_lossy = table.boolean("lossy").about(about).default(false);
    let _ = text("about", "A description of the messages. The program does not use it.").optional();
    let (from, to) = (from?, to?);
    if from.value == to.value {
        let problem = to.span.problem("a process cannot send to itself").with_label("the same as `from`");
        table.report(problem.with_help("choose two names: the publisher and the listener"));
        return None;
    }
    Some(Mapped {
        topic: topic?,
        kind,
        from,
        to,
        time,
        each,
        is_lossy,
        tests: tests?,
        fields: fields?,
        span: table.span().clone(),
    })
}

/// A value without parts, as JSON Schema.
fn scalar() -> serde_json::Value {
    json!({ "title": "a string, a number, true or false", "type": ["string", "number", "boolean"] })
}

/// The sources of fields, as JSON Schema.
fn sources() -> serde_json::Value {
    let text = json!({ "type": "string" });
    let symbols = json!({ "type": "object", "additionalProperties": text });
    let scale = json!({ "type": "number", "minimum": -1e300, "maximum": 1e300 });
    let form = |required: &str, properties: serde_json::Value| {
        json!({
            "type": "object", "additionalProperties": false, "required": [required], "properties": properties,
        })
    };
    let forms = [
        text.clone(),
        form("path", json!({ "path": text, "symbols": symbols, "scale": scale })),
        form("symbol", json!({ "symbol": text })),
        form("value", json!({ "value": scalar() })),
    ];
    let words = "a table: each field with the path of a field in the topic's message, or with a table that has `path` \
                 and, if need be, `symbols` or `scale`, or that has `symbol` or `value` for a constant";
    json!({ "title": words, "type": ["object"], "additionalProperties": { "anyOf": forms } })
}

fn tests(table: Table<'_>) -> Option<Tests> {
    let about = "Only messages in which each of these paths has this value, or one of these values.";
    let one_or_several = || json!({ "anyOf": [scalar(), { "type": "array", "items": scalar() }] });
    let tests = table.table("where").about(about).rules(|| {
        let words = "a table: each path with a string, a number, true or false, or with an array of these";
        json!({ "title": words, "type": ["object"], "additionalProperties": one_or_several() })
    });
    let Some(tests) = tests.optional() else { return if table.has("where") { None } else { Some(Vec::new()) } };
    let read = tests.keys_as_written().into_iter().map(|(path, place)| {
        let item = tests.get::<Item<'_>>(path).required()?;
        let items = item.as_array().unwrap_or_else(|| vec![item.clone()]);
        let spanned = |item: &Item<'_>| Some(Spanned { value: constant(item)?, span: item.span().clone() });
        let values: Option<Vec<Spanned<Value>>> = items.iter().map(spanned).collect();
        if values.is_none() {
            let problem = item.wrong("a number, a string, true or false, or an array of these");
            table.report(problem.with_help("write a path with dots in quotes: `where = { \"goal.status\" = 4 }`"));
        }
        Some((Spanned { value: path.to_owned(), span: place.clone() }, values?))
    });
    read.collect::<Vec<_>>().into_iter().collect()
}

fn fields(table: Table<'_>) -> Option<Vec<(String, FieldSource)>> {
    let about = "The fields of the channel's message, in order, each with its source.";
    let fields = table.table("fields").about(about).rules(sources).required()?;
    let read = fields.keys_as_written().into_iter().map(|(name, place)| {
        if !is_name(name) {
            let problem = place.problem(format!("`{name}` cannot be the name of a field")).with_label("this field");
            table.report(
                problem.with_help("a name consists of letters, digits and `_`, and does not begin with a digit"),
            );
        }
        let item = fields.get::<Item<'_>>(name).required()?;
        if let Some(path) = item.as_text() {
            let path = Spanned { value: path.to_owned(), span: item.span().clone() };
            return Some((name.to_owned(), FieldSource::Path { path, symbols: None, scale: None }));
        }
        let Some(source) = item.as_table() else {
            table.report(item.wrong("the path of a field, or a table with `path`, `symbol` or `value`"));
            return None;
        };
        Some((name.to_owned(), from_table(source)?)).filter(|_| is_name(name))
    });
    read.collect::<Vec<_>>().into_iter().collect()
}

/// A field's table.
fn from_table(table: Table<'_>) -> Option<FieldSource> {
    if table.has("symbol") {
        return Some(FieldSource::Constant(Value::symbol(&table.text("symbol").required()?)));
    }
    if table.has("value") {
        let item = table.get::<Item<'_>>("value").required()?;
        let value = constant(&item);
        if value.is_none() {
            table.report(item.wrong("a number, a string, true or false"));
        }
        return value.map(FieldSource::Constant);
    }
    let path = table.text("path").spanned().required_or("add `path`, or `symbol` or `value` for a constant");
    let scale = table.number("scale").spanned().optional();
    // Not `optional()`: a table of symbols that is wrong is not the same as none.
    let symbols = if table.has("symbols") {
        symbols(table).map(Some)
    } else {
        table.know("symbols");
        Some(None)
    };
    let symbols = symbols?;
    if let (Some(_), Some(scale)) = (&symbols, &scale) {
        table.report(scale.span.problem("a symbol has no scale").with_label("leave this out"));
        return None;
    }
    Some(FieldSource::Path { path: path?, symbols, scale })
}

/// The symbols of values: numbers, strings or Booleans as they are written.
fn symbols(table: Table<'_>) -> Option<Vec<(String, Symbol)>> {
    let symbols = table.table("symbols").required()?;
    let read = symbols.keys_as_written().into_iter().map(|(value, _)| {
        let name = symbols.text(value).spanned().required()?;
        let is_symbol = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
        if name.value.is_empty() || !name.value.chars().all(is_symbol) {
            let problem: Problem =
                name.span.problem(format!("`{}` is not a symbol", name.value)).with_label("this name");
            table.report(problem.with_help("a name consists of letters, digits, `_` and `-`"));
            return None;
        }
        Some((value.to_owned(), Symbol::new(&name.value)))
    });
    read.collect::<Vec<_>>().into_iter().collect()
}

fn constant(item: &Item<'_>) -> Option<Value> {
    let number = || item.as_number().filter(|number| number.is_finite()).map(Value::Real);
    let plain = item.as_boolean().map(Value::Bool).or_else(|| item.as_integer().map(Value::Int)).or_else(number);
    plain.or_else(|| item.as_text().map(Value::from))
}
