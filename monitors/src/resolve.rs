//! From the tree of a file to formulas: resolves names, checks types, converts durations to ticks.

mod channel;
mod condition;
mod duration;
mod pointless;
mod unit;

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use channels::{Capacity, Domain, Relation, Shape, Topology};
use diagnostics::{Problem, nearest_or_all};

use crate::formula::{Bound, EventAtom, Formula, MessageCondition};
use crate::operator::{Prefix, Tense};
use crate::syntax::{
    ByteRange, Condition, Constant, Constraint, ConstraintKind, Event, File, Interval, Item, Literal, Name, Operand,
    PropertyItem,
};

/// A property of a file with resolved names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Definition {
    pub(crate) name: Name,
    pub(crate) constraint: Constraint,
    pub(crate) formula: Formula,
    /// The span of the property.
    pub(crate) span: ByteRange,
}

/// The properties of a file with this text, and everything that is wrong with it.
pub(crate) fn resolve(
    text: &str,
    file: &File,
    topology: &Topology,
    tick_period: Duration,
) -> (Vec<Definition>, Vec<Problem>) {
    let mut resolver = Resolver { text, ..Resolver::new(topology, tick_period) };
    resolver.declare(file);
    let properties = file.items.iter().filter_map(|item| match item {
        Item::Property(property) => Some(property),
        Item::Constant(_) => None,
    });
    let definitions = properties.filter_map(|property| resolver.definition(property)).collect();
    (definitions, resolver.problems)
}

/// What a condition means for messages of these shapes, if it is right; these names are of remembered values.
pub(crate) fn meaning(condition: &Condition, remembered: &[&str], shapes: &[Shape]) -> Option<MessageCondition> {
    let mut topology = Topology::default();
    let [source, target] = ["P", "Q"].map(|name| topology.process(name).ok());
    let domain = Domain::new(shapes.iter().cloned());
    let channel = topology.channel(source?, target?, Capacity::One, domain).ok()?;
    let mut resolver = Resolver::new(&topology, Duration::ZERO);
    resolver.remembered = remembered.iter().map(ToString::to_string).collect();
    let meant = resolver.condition(condition, Some(channel));
    meant.filter(|_| !resolver.problems.iter().any(Problem::is_error))
}

/// Where a constraint is.
#[derive(Clone, Copy, Default)]
struct Inside {
    /// Inside an operator that looks ahead, which determines when it is checked.
    temporal: bool,
    /// Inside an operator that looks back.
    past: bool,
}

impl Inside {
    fn operator(self, tense: Tense) -> Self {
        Self { temporal: self.temporal || tense == Tense::Future, past: self.past || tense == Tense::Past }
    }
}

struct Resolver<'a> {
    /// The text of the file, for what numbers lose: their units.
    text: &'a str,
    topology: &'a Topology,
    tick_period: Duration,
    /// Whether the current property measures durations in time.
    is_timed: bool,
    constants: BTreeMap<&'a str, &'a Constant>,
    /// The names of values that the current property remembers.
    remembered: BTreeSet<String>,
    /// Whether the current condition is about items of lists.
    of_items: bool,
    /// Whether the current property has a part that could not be read.
    unreadable: bool,
    problems: Vec<Problem>,
}

impl<'a> Resolver<'a> {
    fn new(topology: &'a Topology, tick_period: Duration) -> Self {
        Self {
            text: "",
            topology,
            tick_period,
            is_timed: false,
            constants: BTreeMap::new(),
            remembered: BTreeSet::new(),
            of_items: false,
            unreadable: false,
            problems: Vec::new(),
        }
    }

    /// Collects the file's constants, and reports names that are defined twice.
    fn declare(&mut self, file: &'a File) {
        self.problems.extend(defined_twice(file));
        for item in &file.items {
            if let Item::Constant(constant) = item {
                self.constants.insert(&constant.name.text, constant);
            }
        }
    }

    fn definition(&mut self, property: &PropertyItem) -> Option<Definition> {
        let noted = self.problems.len();
        (self.unreadable, self.is_timed) = (false, property.is_timed);
        self.remembered = BTreeSet::new();
        remembered_in(&property.constraint, &mut |name| self.remember(name));
        let formula = self.formula(&property.constraint, Inside::default());
        let formula = formula.map(|formula| if self.is_timed { Formula::Timed(Box::new(formula)) } else { formula });
        let sound = !self.problems[noted..].iter().any(Problem::is_error) && !self.unreadable;
        let PropertyItem { name, constraint, span, .. } = property;
        let definition =
            |formula| Definition { name: name.clone(), constraint: constraint.clone(), formula, span: *span };
        formula.filter(|_| sound).map(definition)
    }

    /// Notes the name of a remembered value.
    fn remember(&mut self, name: &Name) {
        if self.constants.contains_key(name.text.as_str()) {
            let problem =
                Problem::new(format!("`{}` is already a constant", name.text)).at(name.span, "a different name");
            self.problems.push(problem.with_help("rename the remembered value"));
        }
        self.remembered.insert(name.text.clone());
    }

    /// The formula of a constraint; `None` after its problems have been reported. All of its parts are checked.
    fn formula(&mut self, constraint: &Constraint, inside: Inside) -> Option<Formula> {
        if inside.past && self.refuses_to_look_ahead(constraint) {
            return None;
        }
        Some(match &constraint.kind {
            ConstraintKind::True => Formula::True,
            ConstraintKind::False => Formula::False,
            ConstraintKind::Unreadable => {
                self.unreadable = true;
                return None;
            }
            ConstraintKind::Prefix(operator, ago, part) => {
                if *operator == Prefix::Becomes {
                    let mut names = Vec::new();
                    remembered_in(part, &mut |name| names.push(name.clone()));
                    self.remembers_nothing(names);
                }
                let (bound, part) = (self.ago(ago.as_ref()), self.formula(part, inside.operator(operator.tense())));
                operator.of(bound?, part?)
            }
            ConstraintKind::Infix(operator, ago, left, right) => {
                let within = inside.operator(operator.tense());
                // Not one after the other: the problems of all are reported.
                let bound = self.ago(ago.as_ref());
                let (left, right) = (self.formula(left, within), self.formula(right, within));
                operator.of(bound?, left?, right?)
            }
            ConstraintKind::Count { is_at_most, count, event, bound } => {
                self.is_asked(inside, event.span);
                self.counted(*is_at_most, count, event, bound)?
            }
            ConstraintKind::And(parts) => Formula::And(self.formulas(parts, inside)?),
            ConstraintKind::Or(parts) => Formula::Or(self.formulas(parts, inside)?),
            ConstraintKind::Event(event) => {
                self.is_asked(inside, event.span);
                one_of(self.events(event)?, Formula::Event)
            }
            ConstraintKind::Fresh(event) => {
                self.is_asked(inside, event.span);
                one_of(self.events(event)?, Formula::Fresh)
            }
            ConstraintKind::TimeUntil { event, relation, bound } => self.awaited(event, *relation, bound)?,
        })
    }

    /// Reports an operator that looks ahead, and returns whether it is one.
    fn refuses_to_look_ahead(&mut self, constraint: &Constraint) -> bool {
        let Some(ahead) = looks_ahead(&constraint.kind) else { return false };
        let problem = Problem::new(format!("`{ahead}` looks ahead, but it is inside an operator that looks back"));
        let problem = problem.at(constraint.span, "not known yet when it is needed");
        let help = "`once`, `historically`, `previous`, `becomes` and `since` are about the past";
        self.problems.push(problem.with_help(help));
        true
    }

    fn counted(&mut self, is_at_most: bool, count: &Operand, event: &Event, bound: &Operand) -> Option<Formula> {
        let span = count.span();
        self.remembers_nothing(event.condition.remembered().into_iter().cloned());
        let (events, count, bound) = (self.events(event), self.count(count), self.bound(Relation::Less, bound));
        if !is_at_most && count == Some(0) {
            let problem = Problem::new("`at least 0` always holds").at(span, "whatever passes");
            let help = "it counts as `true`, and is checked when `true` is; at least 1?";
            self.problems.push(problem.with_help(help).as_warning());
        }
        let mut events = events?;
        if events.len() > 1 {
            let problem = Problem::new("messages can be counted on one channel only");
            let several = format!("this stands for {} channels", events.len());
            self.problems.push(problem.at(event.span, several).with_help("name the sender and the receiver"));
            return None;
        }
        Some(Formula::Count { event: events.remove(0), is_at_most, count: count?, bound: bound? })
    }

    fn awaited(&mut self, event: &Event, relation: Relation, bound: &Operand) -> Option<Formula> {
        self.remembers_nothing(event.condition.remembered().into_iter().cloned());
        let (events, bound) = (self.events(event), self.bound(relation, bound));
        let (events, bound) = (events?, bound?);
        Some(one_of(events, |event| Formula::TimeUntil { event, bound }))
    }

    /// Reports values that are remembered where no message is certain: in what is awaited, counted, or becomes true.
    fn remembers_nothing(&mut self, names: impl IntoIterator<Item = Name>) {
        for name in names {
            let problem =
                Problem::new(format!("`{}` cannot be remembered here", name.text)).at(name.span, "which message?");
            let help = "the event is awaited, counted or becomes true; remember values in an event that is checked at \
                        once, as before `implies`";
            self.problems.push(problem.with_help(help));
            self.remembered.insert(name.text);
        }
    }

    /// Reports an event outside every operator that determines when it is checked.
    fn is_asked(&mut self, inside: Inside, event: ByteRange) {
        if !inside.temporal {
            let problem = Problem::new("this event is outside every temporal operator");
            let problem = problem.at(event, "checked only in the first state, before any message");
            self.problems.push(problem.with_help("did you mean `always`?"));
        }
    }

    fn ago(&mut self, interval: Option<&Interval>) -> Option<Bound> {
        let Some(Interval { relation, bound }) = interval else { return Some(Bound::NONE) };
        self.bound(*relation, bound)
    }

    /// A number of messages.
    fn count(&mut self, operand: &Operand) -> Option<u64> {
        let literal = match operand {
            Operand::Literal(literal, _) => literal.clone(),
            Operand::Constant(name) => self.constant(name)?.clone(),
        };
        if let Literal::Int(number) = literal
            && let Ok(number) = u64::try_from(number)
        {
            return Some(number);
        }
        let problem =
            Problem::new("expected a number of messages").at(operand.span(), "not a whole number of at least 0");
        self.problems.push(problem.with_help("`at most 3 (sender, receiver, condition) in 10 s`"));
        None
    }

    fn formulas(&mut self, parts: &[Constraint], inside: Inside) -> Option<Vec<Formula>> {
        let formulas: Vec<Option<Formula>> = parts.iter().map(|part| self.formula(part, inside)).collect();
        formulas.into_iter().collect()
    }

    /// The value of a constant; `None` after reporting that it is unknown.
    fn constant(&mut self, name: &Name) -> Option<&'a Literal> {
        let found = self.constants.get(name.text.as_str()).map(|constant| &constant.value);
        if found.is_none() {
            let known: Vec<&str> = self.constants.keys().copied().collect();
            let problem = Problem::new(format!("unknown constant `{}`", name.text)).at(name.span, "not defined");
            self.problems.push(problem.with_help(nearest_or_all(&name.text, "constants", &known)));
        }
        found
    }
}

pub(crate) fn defined_twice(file: &File) -> Vec<Problem> {
    let mut known: BTreeMap<&str, ByteRange> = BTreeMap::new();
    let names = file.items.iter().map(|item| match item {
        Item::Constant(constant) => &constant.name,
        Item::Property(property) => &property.name,
    });
    let again = names.filter_map(|name| Some((name, known.insert(&name.text, name.span)?)));
    let problem = |(name, first): (&Name, ByteRange)| {
        let problem = Problem::new(format!("`{}` is defined twice", name.text)).at(name.span, "defined again");
        problem.at(first, "first defined here")
    };
    again.map(problem).collect()
}

/// One of these events, of which there is at least one.
fn one_of(mut events: Vec<EventAtom>, formula: impl Fn(EventAtom) -> Formula) -> Formula {
    match events.len() {
        1 => formula(events.remove(0)),
        _ => Formula::Or(events.into_iter().map(formula).collect()),
    }
}

/// The name of an operator that looks ahead.
fn looks_ahead(kind: &ConstraintKind) -> Option<&'static str> {
    match kind {
        ConstraintKind::Prefix(operator, ..) if operator.tense() == Tense::Future => Some(operator.word()),
        ConstraintKind::Infix(operator, ..) if operator.tense() == Tense::Future => Some(operator.word()),
        ConstraintKind::TimeUntil { .. } => Some("time_until"),
        _ => None,
    }
}

/// Calls `visit` with each name that a constraint gives to a value.
fn remembered_in(constraint: &Constraint, visit: &mut impl FnMut(&Name)) {
    if let ConstraintKind::Event(event) | ConstraintKind::Fresh(event) = &constraint.kind {
        event.condition.remembered().into_iter().for_each(&mut *visit);
    }
    constraint.operands().into_iter().for_each(|operand| remembered_in(operand, visit));
}
