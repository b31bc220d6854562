//! Compares a mapping with a bag: which bytes become which events.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use channels::{Capacity, ChannelId, Domain, FieldKind, Ground, Role, Shape, Symbol, Topology, Value};
use diagnostics::{FileProblems, Problem, ReadFile, Spanned, nearest, nearest_or_all};
use ros_messages::{Decoder, Layout, Want, WideWidth, messages_on_board};

use super::{FieldSource, Mapped, Mapping};
use crate::definitions::Definitions;
use crate::path::{End, ItemsPath, Path};
use crate::storage::{Survey, Topic};

/// A mapping that fits a bag.
#[derive(Debug)]
pub struct Compiled {
    /// The processes and channels.
    pub topology: Arc<Topology>,
    /// The entries for each topic of the source, by its index; or why its messages are left out.
    pub(crate) entries: Vec<Vec<(ChannelId, Result<CompiledEntry, String>)>>,
    /// The topics whose types only the mapping names.
    pub(crate) promised: BTreeSet<String>,
    /// Which types are defined on board, in words.
    pub(crate) on_board: BTreeSet<String>,
}

/// How a message becomes an event.
#[derive(Debug)]
pub(crate) struct CompiledEntry {
    pub(crate) decoder: Decoder,
    pub(crate) clock: MessageTime,
    /// The items that become events, and their path as written, if it is not the message that does.
    pub(crate) each: Option<(ItemsPath, String)>,
    pub(crate) is_lossy: bool,
    pub(crate) tests: Vec<Test>,
    pub(crate) fields: Vec<FieldRule>,
}

/// The source of a message's time.
#[derive(Clone, Debug)]
pub(crate) enum MessageTime {
    Log,
    Publish,
    /// The latest time on [`CLOCK`](super::CLOCK).
    Clock,
    Field(Path),
}

/// A path that must have one of these values.
#[derive(Debug)]
pub(crate) struct Test {
    pub(crate) path: Path,
    pub(crate) text: String,
    pub(crate) values: Vec<Value>,
}

/// How a field gets its value.
#[derive(Debug)]
pub(crate) enum FieldRule {
    Constant(Value),
    Path { path: Path, text: String, number: Number },
    Symbols { path: Path, text: String, symbols: Vec<(String, Symbol)> },
}

/// What becomes of a number.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Number {
    /// An integer remains one.
    Plain,
    /// The channel has real numbers.
    Real,
    /// The mapping has a scale, so the number is real, and rounded.
    Scaled(f64),
}

impl Number {
    /// The value of an integer; none if it does not fit.
    pub(crate) fn of_integer(self, integer: i128) -> Option<Value> {
        match self {
            Self::Plain => i64::try_from(integer).ok().map(Value::Int),
            Self::Real => i64::try_from(integer).ok().and_then(Value::exact_real),
            Self::Scaled(scale) => Some(Value::Real(integer as f64 * scale)),
        }
    }

    pub(crate) fn scale(self) -> f64 {
        if let Self::Scaled(scale) = self { scale } else { 1.0 }
    }
}

impl CompiledEntry {
    /// Turns integers into real numbers where the channel has real numbers.
    ///
    /// # Errors
    /// A constant that would be rounded.
    fn suit(&mut self, mapped: &Mapped, shape: &Shape, domain: &Domain) -> Result<(), Problem> {
        let Some(theirs) = domain.shapes().iter().find(|theirs| fits(shape, theirs)) else { return Ok(()) };
        for (rule, (_, kind)) in self.fields.iter_mut().zip(theirs.fields()) {
            let kind = of_values(kind);
            match rule {
                FieldRule::Path { number: number @ Number::Plain, .. } if *kind == FieldKind::Real => {
                    *number = Number::Real
                }
                FieldRule::Constant(Value::Int(integer)) if *kind == FieldKind::Real => {
                    match Value::exact_real(*integer) {
                        Some(real) => *rule = FieldRule::Constant(real),
                        None => return Err(rounded(mapped, *integer)),
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// What is known of a mapping without a bag or a robot.
#[derive(Debug)]
pub struct Described {
    /// The processes and channels of the messages whose types are known.
    pub topology: Arc<Topology>,
    /// The topics of the others: the mapping names no type, or one that neither it nor this program defines.
    pub open: BTreeSet<String>,
    /// A warning for each of their types that is probably misspelled: it has the package or the name of one that comes
    /// with the program, and the rest is nearly the same, or its package has no such type.
    pub misspelled: Vec<Problem>,
}

/// The warning of a type that nothing defines here, if one that comes with the program is meant.
fn misspelled(kind: &Spanned<String>) -> Option<Problem> {
    let known = messages_on_board();
    let (package, name) = kind.value.split_once('/')?;
    let of_package: Vec<&str> =
        known.iter().filter_map(|known| known.strip_prefix(package)?.strip_prefix('/')).collect();
    let meant = if of_package.is_empty() {
        let packages = known.iter().filter_map(|known| known.strip_suffix(name)?.strip_suffix('/'));
        format!("did you mean `{}/{name}`?", nearest(package, packages)?)
    } else {
        match nearest(name, of_package) {
            Some(name) => format!("did you mean `{package}/{name}`?"),
            None => "only a bag or a robot that has it contains its definition".to_owned(),
        }
    };
    let problem =
        kind.span.problem(format!("there is no `{}` among the types of ROS 2 that are known here", kind.value));
    Some(problem.as_warning().with_label("this type").with_help(meant))
}

impl Compiled {
    /// Adds the topics that a source has had only since the mapping was compiled. The channels remain as they are: what
    /// does not fit them is left out.
    pub(crate) fn add_topics(&mut self, mapping: &Mapping, survey: &Survey, read: ReadFile<'_>) {
        let definitions = Definitions { survey, folders: &mapping.folders, read };
        for topic in &survey.topics[self.entries.len()..] {
            let entries = mapping.messages.iter().filter(|mapped| mapped.topic.value == topic.name);
            let entries = entries.filter_map(|mapped| {
                let channel = self.topology.find_channel(&mapped.from.value, &mapped.to.value)?;
                let mut problems = Vec::new();
                let made = mapping.entry_for(mapped, topic, &definitions, &mut self.on_board, &mut problems);
                let fitting = made.and_then(|(mut entry, shape)| {
                    channel_of(mapped, &shape, &self.topology, &mut problems)?;
                    problems.extend(entry.suit(mapped, &shape, &self.topology.get(channel).domain).err());
                    Some(entry)
                });
                let why = || problems.iter().map(Problem::message).collect::<Vec<_>>().join("; ");
                Some((channel, fitting.filter(|_| problems.is_empty()).ok_or_else(why)))
            });
            let entries = entries.collect();
            self.entries.push(entries);
        }
    }

    /// What vouches for the messages of a channel: the weakest ground of the topics that they come from.
    pub(crate) fn ground(&self, channel: ChannelId, mapping: &Mapping, survey: &Survey) -> Ground {
        let (from, to) = self.topology.ends(channel);
        let mapped = || mapping.messages.iter().filter(|mapped| mapped.from.value == from && mapped.to.value == to);
        if mapped().next().is_none() {
            return Ground::Missing("the mapping has no topic for them".to_owned());
        }
        let is_absent = |mapped: &&Mapped| survey.topics.iter().all(|topic| topic.name != mapped.topic.value);
        if let Some(absent) = mapped().find(is_absent) {
            return Ground::Missing(format!("there is no topic {}", absent.topic.value));
        }
        let entries =
            self.entries.iter().zip(0..).flat_map(|(entries, topic)| entries.iter().zip(std::iter::repeat(topic)));
        let of_topic = |((_, entry), topic): (&(ChannelId, Result<CompiledEntry, String>), usize)| match entry {
            Ok(entry) if entry.is_lossy => Ground::Assumed("only those messages matter that arrive".to_owned()),
            _ => survey.ground(topic).clone(),
        };
        let grounds = entries.filter(|((of, _), _)| *of == channel).map(of_topic);
        grounds.reduce(Ground::weaker).unwrap_or_default()
    }
}

/// An entry for the messages on a topic, or why they are left out.
type FoundEntry = Result<CompiledEntry, String>;

/// Of which type the messages on a topic are, in words.
fn of_type(topic: &Topic) -> String {
    format!("the messages on {} are of {}", topic.name, topic.kind)
}

impl Mapped {
    /// The topic as the mapping describes it.
    fn promised(&self) -> Option<Topic> {
        let kind = self.kind.as_ref()?.value.clone();
        Some(Topic { name: self.topic.value.clone(), kind, encoding: "cdr".to_owned(), definition: None, hash: None })
    }
}

impl Mapping {
    /// Compares the mapping with the contents of a bag. The channels are those of `topology`, or else those that the
    /// mapping itself declares.
    ///
    /// # Errors
    /// Everything that does not fit, with its location in the mapping.
    pub fn compile(
        &self,
        survey: &Survey,
        topology: Option<&Arc<Topology>>,
        read: ReadFile<'_>,
    ) -> Result<Compiled, FileProblems> {
        let definitions = Definitions { survey, folders: &self.folders, read };
        let mut problems = Vec::new();
        let mut shapes: Shapes = BTreeMap::new();
        let (mut found, mut on_board) = (Vec::new(), BTreeSet::new());
        for mapped in &self.messages {
            match self.entries_of(mapped, &definitions, &mut on_board, &mut problems) {
                Some((entries, shape)) => {
                    let channel = (mapped.from.value.clone(), mapped.to.value.clone());
                    shapes.entry(channel).or_default().push(shape.clone());
                    found.push((mapped, entries, shape));
                }
                None => continue,
            }
        }
        // These problems come first: channels declared without the shapes of all entries would cause others.
        FileProblems::none_of(std::mem::take(&mut problems))?;
        let topology = match topology {
            Some(topology) => Arc::clone(topology),
            None => Arc::new(declared(found.iter().map(|(mapped, ..)| *mapped), shapes)?),
        };
        let mut entries: Vec<_> = survey.topics.iter().map(|_| Vec::new()).collect();
        for (mapped, made, shape) in found {
            let Some(channel) = channel_of(mapped, &shape, &topology, &mut problems) else { continue };
            for (topic, mut entry) in made {
                let domain = &topology.get(channel).domain;
                problems.extend(entry.as_mut().ok().and_then(|entry| entry.suit(mapped, &shape, domain).err()));
                entries[topic].push((channel, entry));
            }
        }
        FileProblems::none_of(problems)?;
        let is_absent = |name: &str| survey.topics.iter().all(|topic| topic.name != name);
        let promised = self.topics().filter(|name| is_absent(name)).map(str::to_owned).collect();
        Ok(Compiled { topology, entries, promised, on_board })
    }

    /// Compares the mapping with the types that it names, as far as their definitions are here.
    ///
    /// # Errors
    /// Everything that does not fit, with its location in the mapping.
    pub fn describe(&self, read: ReadFile<'_>) -> Result<Described, FileProblems> {
        let survey = Survey::default();
        let definitions = Definitions { survey: &survey, folders: &self.folders, read };
        let is_known = |mapped: &Mapped| mapped.promised().is_some_and(|topic| definitions.defined(&topic).is_ok());
        let (messages, open): (Vec<_>, Vec<_>) = self.messages.iter().cloned().partition(is_known);
        let known = Self { messages, ..self.clone() };
        let misspelled = open.iter().filter_map(|mapped| misspelled(mapped.kind.as_ref()?)).collect();
        let open = open.into_iter().map(|mapped| mapped.topic.value).collect();
        Ok(Described { topology: known.compile(&survey, None, read)?.topology, open, misspelled })
    }

    /// An entry and the shape of its messages, for each topic of that name: in a bag, one name may have several types.
    /// A topic that does not exist only has the shape, if the mapping names its type.
    fn entries_of(
        &self,
        mapped: &Mapped,
        definitions: &Definitions<'_>,
        on_board: &mut BTreeSet<String>,
        problems: &mut Vec<Problem>,
    ) -> Option<(Vec<(usize, FoundEntry)>, Shape)> {
        let all = &definitions.survey.topics;
        let topics = all.iter().enumerate().filter(|(_, topic)| topic.name == mapped.topic.value);
        let is_of = |mapped: &Mapped, topic: &Topic| mapped.kind.as_ref().is_none_or(|kind| kind.value == topic.kind);
        let has_type = topics.clone().any(|(_, topic)| is_of(mapped, topic));
        // The last type decides the shape; messages of another one that do not fit are left out when they are read.
        let (mut entries, mut shape) = (Vec::new(), None);
        for (index, topic) in topics {
            // Messages of another type than that which is named are left out, unless another entry is for them.
            if has_type && !is_of(mapped, topic) {
                let is_mapped = self.messages.iter().any(|of| of.topic.value == topic.name && is_of(of, topic));
                entries.extend((!is_mapped).then(|| (index, Err(of_type(topic)))));
                continue;
            }
            let (entry, of_entry) = self.entry_for(mapped, topic, definitions, on_board, problems)?;
            entries.push((index, Ok(entry)));
            shape = Some(of_entry);
        }
        if shape.is_none()
            && let Some(promised) = mapped.promised()
        {
            // Whatever defines it here need not define its messages.
            let (_, of_entry) = self.entry_for(mapped, &promised, definitions, &mut BTreeSet::new(), problems)?;
            shape = Some(of_entry);
        }
        if shape.is_none() {
            let mut names: Vec<&str> = all.iter().map(|topic| topic.name.as_str()).collect();
            names.sort_unstable();
            let problem = mapped.topic.span.problem(format!("there is no topic `{}`", mapped.topic.value));
            problems.push(problem.with_label("this topic").with_help(nearest_or_all(
                &mapped.topic.value,
                "topics",
                &names,
            )));
        }
        Some((entries, shape?))
    }

    /// An entry for one of its topics.
    fn entry_for(
        &self,
        mapped: &Mapped,
        topic: &Topic,
        definitions: &Definitions<'_>,
        on_board: &mut BTreeSet<String>,
        problems: &mut Vec<Problem>,
    ) -> Option<(CompiledEntry, Shape)> {
        if let Some(kind) = mapped.kind.as_ref().filter(|kind| kind.value != topic.kind) {
            let problem = kind.span.problem(of_type(topic));
            problems.push(problem.with_label("another type"));
            return None;
        }
        let layout = match definitions.defined(topic) {
            Ok(defined) => {
                let note = |how| format!("{} is decoded with the {} on board, {how}", topic.name, topic.kind);
                on_board.extend(defined.on_board.map(note));
                defined.layout
            }
            Err(undefined) => {
                let (place, label) = match &mapped.kind {
                    Some(kind) => (&kind.span, "this type"),
                    None => (&mapped.topic.span, "this topic"),
                };
                let problem = place.problem(undefined.why).with_label(label);
                problems.push(problem.with_help(undefined.help));
                return None;
            }
        };
        // Of the programs that write messages, those of ROS state their distribution.
        let width = (!definitions.survey.distributions.is_empty()).then(WideWidth::default);
        let before = problems.len();
        let made = self.entry(mapped, layout, width, problems);
        made.filter(|_| problems.len() == before)
    }

    fn entry(
        &self,
        mapped: &Mapped,
        layout: Arc<Layout>,
        width: Option<WideWidth>,
        problems: &mut Vec<Problem>,
    ) -> Option<(CompiledEntry, Shape)> {
        let mut fields = FieldCompiler { layout: &layout, items: None, want: Want::Nothing, problems };
        let clock = fields.time(mapped.time.as_ref().unwrap_or(&self.time));
        let each = match &mapped.each {
            // Without the items, no other path has a meaning.
            Some(each) => Some((fields.items(each)?, each.value.clone())),
            None => None,
        };
        fields.items = each.as_ref().map(|(items, _)| items);
        let tests: Vec<Test> = mapped.tests.iter().filter_map(|(path, values)| fields.test(path, values)).collect();
        let compiled = mapped.fields.iter().filter_map(|(name, source)| {
            let (rule, kind) = fields.rule(source)?;
            Some((rule, (name.clone(), kind)))
        });
        let (rules, kinds): (Vec<FieldRule>, Vec<(String, FieldKind)>) = compiled.unzip();
        let decoder = Decoder::new(&layout, &fields.want).with_width(width);
        let entry = CompiledEntry { decoder, clock: clock?, each, is_lossy: mapped.is_lossy, tests, fields: rules };
        Some((entry, Shape::new(kinds).with_role(Role::Topic)))
    }
}

/// Compares the fields that an entry names with the type of its messages.
struct FieldCompiler<'c> {
    layout: &'c Layout,
    /// The items in which paths are, if they become events.
    items: Option<&'c ItemsPath>,
    /// Every path that was resolved, so that the decoder skips the rest of a message.
    want: Want,
    problems: &'c mut Vec<Problem>,
}

impl FieldCompiler<'_> {
    fn resolve(&mut self, text: &Spanned<String>) -> Option<Path> {
        match Path::resolve(&text.value, self.layout, self.items) {
            Ok(path) => {
                path.want(self.layout, self.items, &mut self.want);
                Some(path)
            }
            Err(why) => {
                self.refuse(text, why);
                None
            }
        }
    }

    /// The items that become events.
    fn items(&mut self, text: &Spanned<String>) -> Option<ItemsPath> {
        match ItemsPath::resolve(&text.value, self.layout) {
            Ok(items) => {
                items.want(self.layout, &mut self.want);
                Some(items)
            }
            Err(why) => {
                self.refuse(text, why);
                None
            }
        }
    }

    fn refuse(&mut self, path: &Spanned<String>, why: String) {
        let problem = path.span.problem(why);
        self.problems.push(problem.with_label(format!("in messages of {}", self.layout.name)));
    }

    /// The path, if it does not lead to a list.
    fn resolve_one(&mut self, text: &Spanned<String>) -> Option<Path> {
        let path = self.resolve(text)?;
        if path.is_list() {
            let problem = text.span.problem(format!("`{}` is a list", text.value)).with_label("one value is needed");
            self.problems.push(problem.with_help("name an item of the array, such as `[0]`, or `[-1]` for the last"));
            return None;
        }
        Some(path)
    }

    /// The condition that a path has one of these values.
    fn test(&mut self, text: &Spanned<String>, values: &[Spanned<Value>]) -> Option<Test> {
        let path = self.resolve_one(text)?;
        if values.is_empty() {
            let problem = text.span.problem(format!("`{}` is none of an empty list of values", text.value));
            self.problems.push(problem.with_label("this list").with_help("name the values, or leave this out"));
        }
        for Spanned { value, span } in values {
            if let Some(accepted) = path.excludes(value) {
                let value = if let Value::Text(text) = value { format!("{text:?}") } else { value.to_string() };
                let problem = span.problem(format!("`{}` is never {value}", text.value)).with_label("this value");
                self.problems.push(problem.with_help(format!("it is {accepted}")));
            }
        }
        let values = values.iter().map(|value| value.value.clone()).collect();
        Some(Test { path, text: text.value.clone(), values })
    }

    fn time(&mut self, time: &Spanned<String>) -> Option<MessageTime> {
        match time.value.as_str() {
            "log" => Some(MessageTime::Log),
            "publish" => Some(MessageTime::Publish),
            "clock" => Some(MessageTime::Clock),
            _ => {
                let path = self.resolve_one(time)?;
                if path.end == End::Time {
                    return Some(MessageTime::Field(path));
                }
                let problem = time.span.problem(format!("`{}` is not a stamp", time.value)).with_label("this time");
                self.problems
                    .push(problem.with_help("`log`, `publish`, `clock`, or a field of type builtin_interfaces/Time"));
                None
            }
        }
    }

    /// How a field gets its value, and the values that it may get.
    fn rule(&mut self, source: &FieldSource) -> Option<(FieldRule, FieldKind)> {
        match source {
            FieldSource::Constant(value) => Some((FieldRule::Constant(value.clone()), kind_of(value))),
            FieldSource::Path { path: text, symbols: Some(symbols), .. } => {
                let path = self.resolve(text)?;
                let mut names: Vec<Symbol> = symbols.iter().map(|(_, symbol)| symbol.clone()).collect();
                names.dedup();
                let kind = FieldKind::Symbol(names);
                let kind = if path.may_be_missing() { optional(kind) } else { kind };
                let kind = if path.is_list() { FieldKind::List(Box::new(kind)) } else { kind };
                Some((FieldRule::Symbols { path, text: text.value.clone(), symbols: symbols.clone() }, kind))
            }
            FieldSource::Path { path: text, symbols: None, scale } => {
                let path = self.resolve(text)?;
                let is_number = matches!(path.end, End::Int | End::Real);
                if let Some(scale) = scale.as_ref().filter(|_| !is_number) {
                    let problem = scale.span.problem(format!("`{}` is not a number, so it has no scale", text.value));
                    self.problems.push(problem.with_label("leave this out"));
                    return None;
                }
                let kind = match path.end {
                    End::Int if scale.is_none() => FieldKind::Int,
                    End::Int | End::Real | End::Time => FieldKind::Real,
                    End::Bool => FieldKind::Bool,
                    End::Text | End::Bytes => FieldKind::Text,
                };
                let number = scale.as_ref().map_or(Number::Plain, |scale| Number::Scaled(scale.value));
                // NaN and a missing item become `<none>`.
                let kind = optional(kind);
                let kind = if path.is_list() { FieldKind::List(Box::new(kind)) } else { kind };
                Some((FieldRule::Path { path, text: text.value.clone(), number }, kind))
            }
        }
    }
}

fn kind_of(value: &Value) -> FieldKind {
    match value {
        Value::Symbol(symbol) => FieldKind::Symbol(vec![symbol.clone()]),
        Value::Bool(_) => FieldKind::Bool,
        Value::Int(_) => FieldKind::Int,
        Value::Real(_) => FieldKind::Real,
        Value::Text(_) => FieldKind::Text,
        Value::List(items) => FieldKind::List(Box::new(items.first().map_or(FieldKind::Real, kind_of))),
    }
}

/// The kind of a field's values: of its items, if it is a list.
fn of_values(kind: &FieldKind) -> &FieldKind {
    match kind {
        FieldKind::Optional(kind) | FieldKind::List(kind) => of_values(kind),
        kind => kind,
    }
}

fn optional(kind: FieldKind) -> FieldKind {
    FieldKind::Optional(Box::new(kind))
}

/// The shapes of the messages between two processes.
type Shapes = BTreeMap<(String, String), Vec<Shape>>;

/// The processes and channels that a mapping declares, in the order of the file.
fn declared<'m>(messages: impl Iterator<Item = &'m Mapped>, mut shapes: Shapes) -> Result<Topology, Problem> {
    let mut topology = Topology::default();
    for mapped in messages {
        let [from, to] = [&mapped.from, &mapped.to].map(|end| match topology.find_process(&end.value) {
            Some(process) => Ok(process),
            None => topology.process(&end.value).map_err(|error| end.span.problem(error.to_string())),
        });
        let (from, to) = (from?, to?);
        if topology.find_channel(&mapped.from.value, &mapped.to.value).is_none() {
            let channel = (mapped.from.value.clone(), mapped.to.value.clone());
            let domain = Domain::new(shapes.remove(&channel).unwrap_or_default()).in_role(Role::Topic);
            let made = topology.channel(from, to, Capacity::One, domain);
            made.map_err(|error| mapped.from.span.problem(error.to_string()))?;
        }
    }
    Ok(topology)
}

fn rounded(mapped: &Mapped, integer: i64) -> Problem {
    let problem = mapped.span.problem(format!("{integer} would be rounded: the channel has real numbers"));
    problem.with_label("these messages").with_help("choose a constant below 2^53")
}

/// The channel of an entry, if it can carry its messages.
fn channel_of(mapped: &Mapped, shape: &Shape, topology: &Topology, problems: &mut Vec<Problem>) -> Option<ChannelId> {
    let Some(channel) = topology.find_channel(&mapped.from.value, &mapped.to.value) else {
        let outer = topology.channels().filter(|channel| !topology.is_internal(*channel));
        let names: Vec<String> = outer.map(|channel| topology.describe(channel)).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let wanted = format!("{} → {}", mapped.from.value, mapped.to.value);
        let problem =
            mapped.from.span.problem(format!("the scenario has no channel {wanted}")).with_label("this process");
        problems.push(problem.with_help(nearest_or_all(&wanted, "channels", &names)));
        return None;
    };
    let domain = &topology.get(channel).domain;
    if !domain.shapes().iter().any(|other| fits(shape, other)) {
        let shapes: Vec<String> = domain.shapes().iter().map(ToString::to_string).collect();
        let problem = mapped.span.problem(format!("{} does not carry {shape}", topology.describe(channel)));
        problems.push(problem.with_label("these messages").with_help(format!("it carries {}", shapes.join(", "))));
        return None;
    }
    Some(channel)
}

/// Whether messages of one shape fit the other.
fn fits(ours: &Shape, theirs: &Shape) -> bool {
    let mut fields = ours.fields().iter().zip(theirs.fields());
    ours.fields().len() == theirs.fields().len() && fields.all(|((_, ours), (_, theirs))| may_be(ours, theirs))
}

/// Whether a value of one kind fits the other.
fn may_be(ours: &FieldKind, theirs: &FieldKind) -> bool {
    match (ours, theirs) {
        (FieldKind::Optional(ours), theirs) => may_be(ours, theirs),
        (ours, FieldKind::Optional(theirs)) => may_be(ours, theirs),
        (FieldKind::Symbol(ours), FieldKind::Symbol(theirs)) => ours.iter().all(|symbol| theirs.contains(symbol)),
        (FieldKind::Int | FieldKind::Real, FieldKind::Real) => true,
        (FieldKind::List(ours), FieldKind::List(theirs)) => may_be(ours, theirs),
        (ours, theirs) => ours == theirs,
    }
}
