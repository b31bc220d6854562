//! Interface files.

use std::path::Path;

use channels::{FieldKind, Symbol};
use diagnostics::document::{Document, Item, Key, Referent, Table};
use diagnostics::{Problem, ReadFile, Span, Spanned, read_text};
use ros_messages::{Message, is_name};
use serde_json::{Map, Value, json};

use crate::flatten::{FlatField, Flattening};
use crate::interface::{Action, Field, Interface, MAX_FIELDS, REQUEST, RESERVED, STATUS, Service, TOPIC, Topic};
use crate::kind;
use crate::name::is_symbol;
use crate::packages::{Definition, DefinitionKind, Packages};
use crate::wire::Wire;

impl Interface {
    /// Loads the interface file at `path` through `read`, with these places for fields of the kind `place`. The ROS
    /// definitions that it names are read in the same way, relative to its folder.
    ///
    /// - Fields keep the order of the file: `m[2]`, `m[3]`, … A kind is one of [`KINDS`](crate::KINDS), or a list of
    ///   symbols. If the field may be missing, a kind is followed by `?`, and a list ends with `"?"`.
    /// - With `ros = "my_msgs/srv/SetMode.srv"`, the fields come from the definition. Nested fields are flattened:
    ///   `pose.position.x` is the field `pose_position_x`, the items of `float64[3] point` are `point_0` to `point_2`.
    ///   Items of a bounded array may be missing. An unbounded array is refused.
    /// - `fields = ["pose.position", "ranges[0]"]` selects fields, and `fields = { nearest = "ranges[0]" }` also
    ///   renames them. The keys `request`, `reply`, `goal`, `feedback` and `result` do the same. With
    ///   `fields = { state = { path = "data", symbols = ["open", "closed"] } }`, a text of the definition is one of
    ///   these symbols.
    /// - A type `geometry_msgs/Pose` is looked up as `geometry_msgs/msg/Pose.msg`: beside the package that uses it, in
    ///   each parent folder up to that of the file, and in `packages`. Otherwise it is the one
    ///   [on board](ros_messages::on_board), if all distributions of ROS 2 have it alike.
    /// - No message has more than [`MAX_FIELDS`] fields.
    ///
    /// # Errors
    /// [`Error::Read`](diagnostics::Error::Read) if the file cannot be read;
    /// [`Error::Problems`](diagnostics::Error::Problems) with everything that is wrong with it and with the definitions
    /// that it uses.
    ///
    /// # Example
    /// ```
    /// use std::path::Path;
    ///
    /// use channels::{FieldKind, Symbol};
    /// use interfaces::Interface;
    ///
    /// let text = "[services.say]\nrequest = { text = 'text', at = 'place?' }\nreply = { seconds = 'real' }\n";
    /// let read = |_: &Path| Ok(text.as_bytes().to_vec());
    /// let speaker = Interface::load(Path::new("speaker.toml"), &[Symbol::new("Kitchen")], &read)?;
    /// assert_eq!(
    ///     speaker.requests()[0].to_string(),
    ///     "[request: <say>, text: text, at: <Kitchen> | <none>]"
    /// );
    /// # Ok::<(), diagnostics::Error>(())
    /// ```
    pub fn load(path: &Path, places: &[Symbol], read: ReadFile<'_>) -> Result<Self, diagnostics::Error> {
        let document = Document::parse_toml(&path.display().to_string(), &read_text(path, read)?)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Ok(document.read(|root| read_file(root, folder, places, read))?)
    }

    /// All keys of an interface file.
    #[must_use]
    pub fn keys() -> Vec<Key> {
        Key::all(|root| read_file(root, Path::new(""), &[], &|_| Err(std::io::ErrorKind::NotFound.into())))
    }

    /// The JSON schema of an interface file.
    #[must_use]
    pub fn schema() -> Value {
        Key::json_schema("An interface of steward", json!({}), &Self::keys())
    }
}

struct InterfaceReader<'r> {
    packages: Packages<'r>,
    places: &'r [Symbol],
}

fn read_file(root: Table<'_>, folder: &Path, places: &[Symbol], read: ReadFile<'_>) -> Option<Interface> {
    let packages = root
        .get::<Vec<String>>("packages")
        .words("an array of strings, relative to this file")
        .about("Folders with ROS packages, such as `/opt/ros/jazzy/share`. They are searched last.");
    InterfaceReader { packages: Packages::new(folder, packages.or(Vec::new()), read), places }.interface(root)
}

/// A part of an operation: the key of its fields, the names of the fields before them, and the key's meaning.
type PartKey = (&'static str, &'static [&'static str], &'static str);

/// The fields of each part of an operation, and what it is in ROS 2.
type Parts<const N: usize> = ([Vec<Field>; N], Result<Wire, String>);

const REQUEST_PART: PartKey = ("request", &[REQUEST], "The fields of the request.");
const REPLY_PART: PartKey = ("reply", &[STATUS], "The fields of the reply if the service did what was requested.");
const TOPIC_PART: PartKey = ("fields", &[TOPIC], "The fields of the message.");
const GOAL_PART: PartKey = ("goal", &[REQUEST], "The fields of a goal.");
const FEEDBACK_PART: PartKey = ("feedback", &[STATUS], "The fields of feedback.");
const RESULT_PART: PartKey = ("result", &[STATUS], "The fields of the result if the goal was reached.");

/// The fields of these parts are a selection from a ROS definition if there is one, and otherwise have kinds.
fn fields_of<const N: usize>(parts: [PartKey; N]) -> Value {
    let names: Vec<String> =
        kind::KINDS.iter().flat_map(|(kind, _)| ["", "?", "[]"].map(|suffix| format!("{kind}{suffix}"))).collect();
    let text = json!({ "type": "string" });
    let symbols = json!({ "type": "array", "items": text, "minItems": 1 });
    let kinds = json!({ "type": "object", "additionalProperties": { "anyOf": [{ "enum": names }, symbols] } });
    let one_of = json!({
        "type": "object", "additionalProperties": false, "required": ["path", "symbols"],
        "properties": { "path": text, "symbols": symbols },
    });
    let named = json!({ "type": "object", "additionalProperties": { "anyOf": [text, one_of] } });
    let selection = json!({ "anyOf": [{ "type": "array", "items": text }, named] });
    let all = |takes: Value| {
        let parts: Map<String, Value> = parts.iter().map(|(key, ..)| ((*key).to_owned(), takes.clone())).collect();
        json!({ "properties": parts })
    };
    json!({ "if": { "required": ["ros"] }, "then": all(selection), "else": all(kinds) })
}

impl InterfaceReader<'_> {
    fn interface(&self, root: Table<'_>) -> Option<Interface> {
        let about = ["The services, topics and actions of the component.", "A service: a request, and one reply."];
        let parts = [REQUEST_PART, REPLY_PART];
        let services = each(
            root,
            "services",
            about,
            || fields_of(parts),
            |name, table| {
                let ([request, reply], wire) = self.parts(table, DefinitionKind::Service, parts)?;
                Some(Service { name, request, reply, wire })
            },
        );
        let about = ["The topics that the component publishes.", "A topic: messages to all that read it."];
        let topics = each(
            root,
            "topics",
            about,
            || fields_of([TOPIC_PART]),
            |name, table| {
                let ([fields], wire) = self.parts(table, DefinitionKind::Message, [TOPIC_PART])?;
                Some(Topic { name, fields, wire })
            },
        );
        let about = ["The actions of the component.", "An action: a goal, feedback on the way, and a result."];
        let parts = [GOAL_PART, FEEDBACK_PART, RESULT_PART];
        let actions = each(
            root,
            "actions",
            about,
            || fields_of(parts),
            |name, table| {
                let ([goal, feedback, result], wire) = self.parts(table, DefinitionKind::Action, parts)?;
                Some(Action { name, goal, feedback, result, wire })
            },
        );
        Some(Interface { services: services?, topics: topics?, actions: actions? })
    }

    /// The fields of each part of an operation, and what it is in ROS 2.
    fn parts<const N: usize>(&self, table: Table<'_>, kind: DefinitionKind, parts: [PartKey; N]) -> Option<Parts<N>> {
        let takes = "a table: the name of each field with its kind; with `ros`, a selection";
        for (key, _, about) in parts {
            let fields = table.get::<Item<'_>>(key).about(about).words(takes);
            let _ = fields.rules(|| json!({ "type": ["object", "array"] })).optional();
        }
        let (definition, referent) = match kind {
            DefinitionKind::Message => ("a `.msg` file, relative to this file", Referent::File(&["msg"])),
            DefinitionKind::Service => ("a `.srv` file, relative to this file", Referent::File(&["srv"])),
            DefinitionKind::Action => ("an `.action` file, relative to this file", Referent::File(&["action"])),
        };
        let ros =
            table.text("ros").about("The definition with the fields.").words(definition).refers_to(referent).spanned();
        match ros.map(Some).or(None) {
            _ if !table.has("ros") => {
                let fields = parts.map(|part| self.written(table, part));
                Some((all_of(fields)?, Err("its fields are not those of a definition of ROS 2".to_owned())))
            }
            named => self.defined(table, kind, &named?, parts),
        }
    }

    /// Fields that the file itself lists, with their kinds.
    fn written(&self, table: Table<'_>, (key, taken, _): PartKey) -> Option<Vec<Field>> {
        if !table.has(key) {
            return Some(Vec::new());
        }
        let fields = table.table(key).optional()?;
        let names = fields.keys_as_written();
        let is_sound = names_are_sound(&names, taken, table, "choose another name");
        let read = names.into_iter().map(|(name, _)| {
            let item = fields.get::<Item<'_>>(name).required()?;
            let kind = kind::read(&item, self.places);
            let kind = kind.map_err(|problems| problems.into_iter().for_each(|problem| table.report(problem))).ok();
            Some(Field { name: name.to_owned(), kind: kind? })
        });
        all(read).filter(|_| is_sound)
    }

    /// Fields from a ROS definition: all of them, or those that the file selects.
    fn defined<const N: usize>(
        &self,
        table: Table<'_>,
        kind: DefinitionKind,
        named: &Spanned<String>,
        parts: [PartKey; N],
    ) -> Option<Parts<N>> {
        let selections = parts.map(|(key, ..)| selection(table, key));
        let (definition, folders) = self.packages.definition(named, kind, table)?;
        let mut paths = Vec::new();
        let mut numbers = 0..N;
        let mut selections = selections.into_iter();
        let fields = parts.map(|(key, taken, _)| {
            let part = &definition.parts[numbers.next()?];
            let flattening = Flattening { packages: &self.packages, folders: &folders, named, key, table };
            let selected = selected(&flattening, &definition, part, selections.next()??)?;
            let names: Vec<(&str, &Span)> = selected.iter().map(|one| (one.field.name.as_str(), &one.place)).collect();
            let rename = "list the fields that you want, and rename this one: `fields = { theirs = \"path.in.ros\" }`";
            let are_sound = names_are_sound(&names, taken, table, rename);
            paths.push(selected.iter().map(|one| one.path.clone()).collect::<Vec<String>>());
            are_sound.then(|| selected.into_iter().map(|one| one.field).collect())
        });
        Some((all_of(fields)?, self.packages.wire(&definition, &folders, kind, &paths)))
    }
}

/// Which fields of a part of a definition are selected.
enum Selection {
    All,
    Some(Vec<SelectedPath>),
}

/// A path in a definition that a file selects.
struct SelectedPath {
    /// The name of its field, if the file chooses one.
    name: Option<String>,
    path: Spanned<String>,
    /// The symbols that the text there can be.
    symbols: Option<FieldKind>,
}

fn selection(table: Table<'_>, key: &str) -> Option<Selection> {
    if !table.has(key) {
        return Some(Selection::All);
    }
    let item = table.get::<Item<'_>>(key).required()?;
    if let Some(fields) = item.as_table() {
        let read = |(name, _): (&str, _)| named_path(fields, name);
        return Some(Selection::Some(all(fields.keys_as_written().into_iter().map(read))?));
    }
    match item.get::<Vec<Spanned<String>>>() {
        Ok(paths) => {
            let plain = |path| SelectedPath { name: None, path, symbols: None };
            Some(Selection::Some(paths.into_iter().map(plain).collect()))
        }
        Err(_) => {
            let wanted =
                "an array of paths in the definition, such as [\"pose.position.x\"], or a table of names and paths";
            table.report(item.wrong(wanted));
            None
        }
    }
}

/// The path that a file selects under a name: a text, or a table with the symbols that the text there can be.
fn named_path(fields: Table<'_>, name: &str) -> Option<SelectedPath> {
    let item = fields.get::<Item<'_>>(name).required()?;
    let Some(table) = item.as_table() else {
        let path = fields.text(name).spanned().required()?;
        return Some(SelectedPath { name: Some(name.to_owned()), path, symbols: None });
    };
    let path = table.text("path").spanned().required();
    let symbols = table.get::<Item<'_>>("symbols").words("a list of symbols").required()?;
    let symbols = kind::read_symbols(&symbols);
    let symbols = symbols.map_err(|problems| problems.into_iter().for_each(|problem| table.report(problem))).ok()?;
    Some(SelectedPath { name: Some(name.to_owned()), path: path?, symbols: Some(symbols) })
}

/// A field of a definition.
struct Selected {
    field: Field,
    /// Its path in the definition.
    path: String,
    /// Where it was selected.
    place: Span,
}

fn selected(
    flattening: &Flattening<'_, '_, '_>,
    definition: &Definition,
    part: &Message,
    selection: Selection,
) -> Option<Vec<Selected>> {
    let field = |name: String, FlatField { path, kind }, span: &Span| Selected {
        field: Field { name, kind },
        path,
        place: span.clone(),
    };
    let Selection::Some(paths) = selection else {
        let leaves = flattening.all(definition, part)?.into_iter();
        return Some(leaves.map(|leaf| field(plain(&leaf.path), leaf, &flattening.named.span)).collect());
    };
    let read = paths.into_iter().map(|SelectedPath { name, path: selected, symbols }| {
        let mut leaves = flattening.at(definition, part, &selected)?;
        if let Some(symbols) = symbols {
            let [FlatField { kind, .. }] = &mut leaves[..] else { return not_a_text(flattening, &selected) };
            match kind {
                FieldKind::Text => *kind = symbols,
                FieldKind::Optional(inner) if **inner == FieldKind::Text => **inner = symbols,
                _ => return not_a_text(flattening, &selected),
            }
        }
        // A name that the file chooses stands for the path that it selects.
        let named = |path: &str| match (&name, path.strip_prefix(&selected.value)) {
            (Some(name), Some(below)) => format!("{name}{}", plain(below)),
            _ => plain(path),
        };
        Some(leaves.into_iter().map(|leaf| field(named(&leaf.path), leaf, &selected.span)).collect::<Vec<_>>())
    });
    Some(all(read)?.into_iter().flatten().collect())
}

/// Reports a path whose symbols could not be there.
fn not_a_text<T>(flattening: &Flattening<'_, '_, '_>, path: &Spanned<String>) -> Option<T> {
    let problem = path.span.problem(format!("`{}` is not a string, so it cannot be one of these symbols", path.value));
    flattening.table.report(problem.with_label("this path").with_help("leave out `symbols`"));
    None
}

/// The name of a field of a channel: `pose_position_x` for `pose.position.x`, `covariance_3` for `covariance[3]`.
fn plain(path: &str) -> String {
    path.replace("[]", "").replace(['.', '['], "_").replace(']', "")
}

/// Checks that fields with these names can follow those in `taken`: all must be valid and different from each other.
fn names_are_sound(names: &[(&str, &Span)], taken: &[&str], table: Table<'_>, rename: &str) -> bool {
    let mut problems: Vec<Problem> = Vec::new();
    for (index, (name, place)) in names.iter().enumerate() {
        let problem = if !is_name(name) {
            let problem = place.problem(format!("`{name}` cannot be the name of a field"));
            problem.with_help("a name consists of letters, digits and `_`, and does not begin with a digit")
        } else if taken.contains(name) {
            place.problem(format!("every message of this kind already has a field `{name}`")).with_help(rename)
        } else if names[..index].iter().any(|(earlier, _)| earlier == name) {
            place.problem(format!("there are two fields `{name}`")).with_help(rename)
        } else {
            continue;
        };
        problems.push(problem.with_label("this field"));
    }
    if let Some((_, place)) = names.get(MAX_FIELDS) {
        let message = format!("a message has at most {MAX_FIELDS} fields, and this one has {}", names.len());
        problems.push(place.problem(message).with_label("one too many"));
    }
    let is_sound = problems.is_empty();
    problems.into_iter().for_each(|problem| table.report(problem));
    is_sound
}

/// All parts if each was read.
fn all_of<T, const N: usize>(parts: [Option<T>; N]) -> Option<[T; N]> {
    parts.into_iter().collect::<Option<Vec<T>>>()?.try_into().ok()
}

/// All values if each was read. After a failure, the others are still read.
fn all<T>(read: impl Iterator<Item = Option<T>>) -> Option<Vec<T>> {
    read.collect::<Vec<_>>().into_iter().collect()
}

/// Reads each table in the table `key`, in the order of the file, even if others fail. `about` has the meaning of the
/// table and of the tables in it, which obey `rules`.
fn each<'d, T>(
    root: Table<'d>,
    key: &str,
    about: [&str; 2],
    rules: impl Fn() -> Value,
    mut read: impl FnMut(String, Table<'d>) -> Option<T>,
) -> Option<Vec<T>> {
    let Some(tables) = root.table(key).about(about[0]).optional() else {
        return if root.has(key) { None } else { Some(Vec::new()) };
    };
    let read = tables.names_as_written("NAME").into_iter().map(|(name, place)| {
        let is_sound = name_is_sound(name, key == "topics", place, root);
        let value = read(name.to_owned(), tables.table(name).about(about[1]).rules(&rules).optional()?);
        value.filter(|_| is_sound)
    });
    all(read)
}

/// Whether an operation may have this name. Messages may begin with the name of a service or topic.
fn name_is_sound(name: &str, begins: bool, place: &Span, root: Table<'_>) -> bool {
    let problem = if !is_symbol(name) {
        let problem = place.problem(format!("`{name}` is not a symbol"));
        problem.with_help("a name consists of letters, digits, `_` and `-`")
    } else if begins && RESERVED.contains(&name) {
        let problem = place.problem(format!("every interface has messages that begin with `{name}`"));
        problem.with_help(format!("choose a name other than {}", RESERVED.join(", ")))
    } else {
        return true;
    };
    root.report(problem.with_label("this name"));
    false
}
