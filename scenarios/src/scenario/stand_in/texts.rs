//! The texts with which a component that may answer anything is tried: those with which anything compares what it
//! answers, the empty text, and as many others as can be told apart.
//!
//! A text that it answers is followed from process to process, through data, blackboard and messages, until nothing new
//! is found. What is done with it beyond comparing it is refused where it is done.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use bt::Tree;
use channels::{Choice, Comparisons, FieldKind, Possible, Shape};
use components::{Operation, operations};
use diagnostics::Problem;
use interfaces::Interface;
use maps::Places;
use monitors::syntax::{
    Condition, ConditionKind, Field, FieldName, Item, Literal, Operand, PropertyItem, Term, parse_file,
};
use recording::TREE;
use skills::{Datum, ReceivedEvent, TextSources};

use crate::scenario::skill::Skill;

/// Where a text that a component chooses may be in a message.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Carrier {
    /// The sender.
    pub from: String,
    /// The receiver; any, if it is not known.
    pub to: Option<String>,
    /// The field; any, if it is not known.
    pub field: Option<String>,
}

/// The texts of a field, as they are tried.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Tried {
    /// The empty text, and those that are compared with the field.
    pub(super) texts: BTreeSet<Arc<str>>,
    /// How many others stand for all that nothing mentions.
    pub(super) others: usize,
}

/// All texts that components choose.
#[derive(Clone, Debug, Default)]
pub(super) struct Chosen {
    /// How they are tried, by component and field.
    pub(super) tried: BTreeMap<(String, String), Tried>,
    pub(super) carriers: Vec<Carrier>,
    /// The properties that compare chosen texts with one that is not known, with these in words.
    pub(super) unfollowed: BTreeMap<String, String>,
}

/// Everything that may do something with a text.
pub(super) struct System<'a> {
    pub(super) tree: Option<&'a Tree>,
    pub(super) machines: Vec<(&'a String, &'a Skill)>,
    /// The interfaces of all components that the scenario describes.
    pub(super) interfaces: &'a BTreeMap<&'a str, Interface>,
    /// Those that answer anything.
    pub(super) anything: &'a BTreeSet<&'a str>,
    pub(super) places: Option<&'a Places>,
    pub(super) properties: &'a [(String, String)],
    pub(super) repeated: usize,
}

/// A field of a message, and what it may hold.
#[derive(Clone, Debug, PartialEq)]
struct Cell {
    from: String,
    to: Option<String>,
    head: Option<String>,
    field: Option<String>,
    value: Possible,
}

impl System<'_> {
    /// # Errors
    /// Everything that is done with a chosen text beyond comparing it with others.
    pub(super) fn chosen(&self) -> Result<Chosen, Vec<Problem>> {
        let names = self.names();
        if names.is_empty() {
            return Ok(Chosen::default());
        }
        let words: Vec<String> = names.iter().map(|(component, field)| format!("`{field}` of {component}")).collect();
        let mut flow = Flow { words, cells: self.given(&names), ..Flow::of(self) };
        flow.settle();
        flow.properties();
        if flow.problems.is_empty() { Ok(flow.chosen(&names)) } else { Err(flow.problems) }
    }

    /// The fields whose texts components choose.
    fn names(&self) -> Vec<(String, String)> {
        let mut names = BTreeSet::new();
        for (name, interface) in self.interfaces.iter().filter(|(name, _)| self.anything.contains(**name)) {
            for shape in spoken(interface) {
                let texts = shape.fields().iter().skip(1).filter(|(_, kind)| is_text(kind));
                names.extend(texts.map(|(field, _)| ((*name).to_owned(), field.clone())));
            }
        }
        names.into_iter().collect()
    }

    fn builtin(&self) -> Vec<Operation> {
        let all = self.places.map(operations).unwrap_or_default();
        all.into_iter().filter(|operation| !self.interfaces.contains_key(operation.component)).collect()
    }

    /// What components answer that have no machine, or may answer anything.
    fn given(&self, names: &[(String, String)]) -> Vec<Cell> {
        let mut cells = Vec::new();
        let mut add = |from: &str, shape: &Shape| {
            for head in shape.heads() {
                for (field, kind) in shape.fields().iter().skip(1) {
                    let choice = names.iter().position(|(of, name)| of == from && name == field);
                    let value = match choice.filter(|_| is_text(kind)) {
                        Some(choice) => Possible::choice(choice),
                        None => Possible::of_kind(kind),
                    };
                    let head = Some(head.name().to_owned());
                    cells.push(Cell { from: from.to_owned(), to: None, head, field: Some(field.clone()), value });
                }
            }
        };
        let has_machine = |name: &str| self.machines.iter().any(|(process, _)| *process == name);
        for (name, interface) in self.interfaces.iter().filter(|(name, _)| !has_machine(name)) {
            spoken(interface).iter().for_each(|shape| add(name, shape));
        }
        for Operation { component, replies, .. } in self.builtin() {
            replies.iter().for_each(|shape| add(component, shape));
        }
        cells
    }

    fn kinds(&self, cell: &Cell) -> Vec<FieldKind> {
        let mut shapes = Vec::new();
        shapes.extend(self.interfaces.get(cell.from.as_str()).into_iter().flat_map(spoken));
        let receivers = self.interfaces.iter().filter(|(name, _)| cell.to.as_deref().is_none_or(|to| to == **name));
        shapes.extend(receivers.flat_map(|(_, interface)| interface.requests()));
        let builtin = self.builtin().into_iter();
        let builtin = builtin.filter(|operation| cell.to.as_deref().is_none_or(|to| to == operation.component));
        shapes.extend(builtin.map(|operation| operation.request));
        let is_of = |shape: &&Shape| {
            cell.head.as_ref().is_none_or(|head| shape.heads().iter().any(|known| known.name() == head))
        };
        let fields = shapes.iter().filter(is_of).flat_map(|shape| shape.fields().iter().skip(1));
        let named = fields.filter(|(name, _)| cell.field.as_ref().is_none_or(|field| field == name));
        named.map(|(_, kind)| kind.clone()).collect()
    }
}

/// The messages that a component may send.
fn spoken(interface: &Interface) -> Vec<Shape> {
    let replies = interface.services.iter().flat_map(|service| service.replies());
    let answers = interface.actions.iter().flat_map(|action| action.answers());
    replies.chain(answers).chain(interface.topics.iter().map(|topic| topic.message())).collect()
}

fn is_text(kind: &FieldKind) -> bool {
    *kind.present() == FieldKind::Text
}

/// The symbols that a field of this kind can be.
fn symbols(kind: &FieldKind) -> Vec<Arc<str>> {
    match kind {
        FieldKind::Symbol(symbols) => symbols.iter().map(|symbol| symbol.name().into()).collect(),
        FieldKind::Optional(kind) | FieldKind::List(kind) => symbols(kind),
        _ => Vec::new(),
    }
}

/// The texts on their way through the system.
struct Flow<'a> {
    system: &'a System<'a>,
    /// The chosen texts in words.
    words: Vec<String>,
    cells: Vec<Cell>,
    /// What the tree gives to ports, by process and port.
    inputs: BTreeMap<(String, String), Possible>,
    comparisons: Comparisons,
    /// The places that keep chosen texts.
    kept: Vec<BTreeSet<Choice>>,
    /// Those that lists and objects keep.
    in_structures: BTreeSet<Choice>,
    questions: Vec<Question>,
    unfollowed: BTreeMap<String, String>,
    problems: Vec<Problem>,
}

impl<'a> Flow<'a> {
    fn of(system: &'a System<'a>) -> Self {
        Self {
            system,
            words: Vec::new(),
            cells: Vec::new(),
            inputs: BTreeMap::new(),
            comparisons: Comparisons::default(),
            kept: Vec::new(),
            in_structures: BTreeSet::new(),
            questions: Vec::new(),
            unfollowed: BTreeMap::new(),
            problems: Vec::new(),
        }
    }

    /// Follows the texts until nothing is new.
    fn settle(&mut self) {
        loop {
            let before = (self.cells.clone(), self.inputs.clone());
            self.kept.clear();
            self.problems.clear();
            for (name, skill) in &self.system.machines {
                self.machine(name, skill);
            }
            self.tree();
            if before == (self.cells.clone(), self.inputs.clone()) {
                break;
            }
        }
        // Several leaves may have the same entry.
        let mut known = BTreeSet::new();
        self.problems.retain(|problem| known.insert(problem.one_line()));
        // Nothing bounds how many texts a list or an object keeps.
        let among = self.comparisons.among.iter().flat_map(|(one, other)| [*one, *other]);
        let many: BTreeSet<Choice> = among.filter(|choice| self.in_structures.contains(choice)).collect();
        for choice in many {
            let message =
                format!("a list or an object keeps {}, which is compared with such texts", self.words[choice]);
            self.problems.push(Problem::new(message).with_help("keep each text in a datum of its own"));
        }
        // A text in a field of symbols is compared with all of them.
        for cell in &self.cells {
            let names: Vec<Arc<str>> = self.system.kinds(cell).iter().flat_map(symbols).collect();
            for choice in cell.value.choices() {
                self.comparisons.with.entry(choice).or_default().extend(names.iter().cloned());
            }
        }
    }

    fn machine(&mut self, name: &str, skill: &Skill) {
        let reaches = |cell: &&Cell| cell.from != *name && cell.to.as_deref().is_none_or(|to| to == name);
        let received: Vec<ReceivedEvent> = self.cells.iter().filter(reaches).map(received).collect();
        let mine = self.inputs.iter().filter(|((process, _), _)| process == name);
        let ports: BTreeMap<String, Possible> = mine.map(|((_, port), value)| (port.clone(), value.clone())).collect();
        let of_tree =
            ReceivedEvent { names: vec![format!("{TREE}.tick")], fields: ports.clone(), others: Possible::default() };
        let received: Vec<ReceivedEvent> = received.into_iter().chain([of_tree]).collect();
        let given: Vec<(&str, Datum)> = skill.data_of(&skill.machine).collect();
        let sources = TextSources { given: &given, ports: &ports, received: &received, choices: &self.words };
        let found = skill.machine.text_use(sources);
        for passed in found.passed {
            let text = |text: Option<Arc<str>>| text.map(|text| text.to_string());
            let (to, head, field) = (text(passed.target), text(passed.head), text(passed.field));
            let same =
                |cell: &&mut Cell| cell.from == name && (&cell.to, &cell.head, &cell.field) == (&to, &head, &field);
            match self.cells.iter_mut().find(same) {
                Some(cell) => _ = cell.value.join(&passed.value),
                None => self.cells.push(Cell { from: name.to_owned(), to, head, field, value: passed.value }),
            }
        }
        self.comparisons.join(found.comparisons);
        self.kept.extend(found.kept);
        self.in_structures.extend(found.in_structures);
        self.problems.extend(found.problems.into_iter().map(|problem| skill.at_its_place(problem)));
    }

    fn tree(&mut self) {
        let Some(tree) = self.system.tree else { return };
        let mut outputs: BTreeMap<(String, String), Possible> = BTreeMap::new();
        for leaf in tree.leaves() {
            for port in tree.ports(leaf.id()) {
                let is_mine = |cell: &&Cell| {
                    cell.from == leaf.process()
                        && cell.to.as_deref().is_none_or(|to| to == TREE)
                        && cell.field.as_deref().is_none_or(|field| field == port.name)
                };
                let output = outputs.entry((leaf.process().to_owned(), port.name.to_owned())).or_default();
                self.cells.iter().filter(is_mine).for_each(|cell| _ = output.join(&cell.value));
            }
        }
        let found = tree.texts(&outputs, &self.words);
        for (port, value) in found.inputs {
            self.inputs.entry(port).or_default().join(&value);
        }
        self.comparisons.join(found.comparisons);
        self.kept.extend(found.kept);
        self.problems.extend(found.problems);
    }

    /// What properties compare with each other.
    fn properties(&mut self) {
        let carried = |field: &Field| self.carried(field);
        self.questions = self.system.properties.iter().flat_map(|(_, text)| questions(text, &carried)).collect();
        for Question { property, related, .. } in &self.questions {
            if related.chosen.is_empty() {
                continue;
            }
            if related.is_open {
                let words: Vec<&str> = related.chosen.iter().map(|choice| self.words[*choice].as_str()).collect();
                self.unfollowed.insert(property.clone(), words.join(" or "));
            }
            for choice in &related.chosen {
                self.comparisons.with.entry(*choice).or_default().extend(related.texts.iter().cloned());
            }
        }
    }

    /// How each field is tried.
    fn chosen(self, names: &[(String, String)]) -> Chosen {
        let questions = &self.questions;
        let mut groups = Groups::of(names.len());
        for (one, other) in &self.comparisons.among {
            groups.unite(*one, *other);
        }
        for Question { related, .. } in questions {
            let choices = || related.chosen.iter();
            choices().zip(choices().skip(1)).for_each(|(one, other)| groups.unite(*one, *other));
        }
        let literals = self.system.properties.iter().flat_map(|(_, text)| texts(text));
        let everywhere: BTreeSet<Arc<str>> = literals.chain([Arc::from("")]).collect();
        let mut tried = BTreeMap::new();
        for (choice, name) in names.iter().enumerate() {
            let group = groups.group(choice);
            let with = group.iter().filter_map(|choice| self.comparisons.with.get(choice)).flatten();
            let texts = everywhere.iter().chain(with).cloned().collect();
            let remembered = questions.iter().filter(|question| !question.related.chosen.is_disjoint(&group));
            let remembered = remembered.map(|question| question.remembers).max().unwrap_or_default();
            tried.insert(name.clone(), Tried { texts, others: self.at_once(&group) + remembered });
        }
        let carriers = self.cells.iter().filter(|cell| cell.value.has_choice());
        let carriers: BTreeSet<Carrier> = carriers
            .map(|Cell { from, to, field, .. }| Carrier { from: from.clone(), to: to.clone(), field: field.clone() })
            .collect();
        let ports = self.inputs.iter().filter(|(_, value)| value.has_choice()).map(|((process, port), _)| Carrier {
            from: TREE.to_owned(),
            to: Some(process.clone()),
            field: Some(port.clone()),
        });
        let carriers = carriers.into_iter().chain(ports).collect();
        Chosen { tried, carriers, unfollowed: self.unfollowed }
    }

    /// How many different texts of these choices may be told from each other at once: those that are kept, those that
    /// are passed on, and those in the message that is handled. In a message that has not been received yet, a text can
    /// still be any of them.
    fn at_once(&self, group: &BTreeSet<Choice>) -> usize {
        let is_mine = |choices: &BTreeSet<Choice>| !choices.is_disjoint(group);
        let is_direct = |cell: &Cell| self.system.anything.contains(cell.from.as_str());
        let cells = || self.cells.iter().filter(|cell| cell.value.choices().any(|choice| group.contains(&choice)));
        let mut in_message: BTreeMap<(&String, &Option<String>), usize> = BTreeMap::new();
        cells().for_each(|cell| *in_message.entry((&cell.from, &cell.head)).or_default() += 1);
        let in_message = in_message.into_values().max().unwrap_or(1);
        if !self.comparisons.among.iter().any(|(one, other)| group.contains(one) || group.contains(other)) {
            return in_message.max(1);
        }
        let kept = self.kept.iter().filter(|choices| is_mine(choices)).count();
        // One waits to be sent, and one to be received.
        let passed = 2 * cells().filter(|cell| !is_direct(cell)).count();
        let ports =
            2 * self.inputs.values().filter(|value| value.choices().any(|choice| group.contains(&choice))).count();
        // A message with several receivers, or one that is delivered twice, is still on its way to one of them.
        let copies: usize =
            cells().filter(|cell| is_direct(cell)).map(|cell| self.receivers(cell).saturating_sub(1)).sum();
        kept + passed + ports + in_message + copies + self.system.repeated
    }

    /// How many machines read a topic.
    fn receivers(&self, Cell { from, head, .. }: &Cell) -> usize {
        let Some(event) = head.as_ref().map(|head| format!("{from}.{head}")) else { return 0 };
        self.system.machines.iter().filter(|(_, skill)| skill.machine.names(&event)).count()
    }

    /// What may be in a field with this name; in any, if the field is given by its number.
    fn carried(&self, field: &Field) -> Possible {
        let named = |name: &str| match &field.name {
            FieldName::Named(known) => known == name,
            FieldName::Number(_) => true,
        };
        let cells = self.cells.iter().filter(|cell| cell.field.as_deref().is_none_or(named));
        let ports = self.inputs.iter().filter(|((_, port), _)| named(port)).map(|(_, value)| value);
        let mut all = Possible::default();
        cells.map(|cell| &cell.value).chain(ports).for_each(|value| _ = all.join(value));
        all.part()
    }
}

/// The event that a message is.
fn received(Cell { from, head, field, value, .. }: &Cell) -> ReceivedEvent {
    let names = head.iter().flat_map(|head| [head.clone(), format!("{from}.{head}")]).collect();
    let mut event = ReceivedEvent { names, fields: BTreeMap::new(), others: Possible::default() };
    match field {
        Some(field) => _ = event.fields.insert(field.clone(), value.clone()),
        None => event.others = value.clone(),
    }
    event
}

fn texts(file: &str) -> Vec<Arc<str>> {
    let parsed = parse_file(file);
    let texts = parsed.file.literals().into_iter().filter_map(|literal| match literal {
        Literal::Text(text) => Some(Arc::from(text.as_str())),
        _ => None,
    });
    texts.collect()
}

/// What a property compares with each other.
struct Question {
    property: String,
    /// What may be in fields that are remembered, or compared with each other or with what is remembered.
    related: Possible,
    /// How many texts it remembers.
    remembers: usize,
}

/// What the properties of a file compare with each other; `carried` is what may be in a field.
fn questions(file: &str, carried: &dyn Fn(&Field) -> Possible) -> Vec<Question> {
    let parsed = parse_file(file);
    let properties = parsed.file.items.iter().filter_map(|item| match item {
        Item::Property(property) => Some(property),
        Item::Constant(_) => None,
    });
    let question = |property: &PropertyItem| {
        let property_name = property.name.text.clone();
        let mut question = Question { property: property_name, related: Possible::default(), remembers: 0 };
        property.constraint.events(&mut |event| relate(&event.condition, carried, &mut question));
        question
    };
    properties.map(|property| question(property)).collect()
}

fn relate(condition: &Condition, carried: &dyn Fn(&Field) -> Possible, question: &mut Question) {
    match &condition.kind {
        ConditionKind::Compare { left, right, .. } => {
            let is_literal = |term: &Term| matches!(term, Term::Operand(Operand::Literal(..)));
            if !is_literal(left) && !is_literal(right) {
                for term in [left, right] {
                    if let Term::Field(field) = term {
                        question.related.join(&carried(field));
                    }
                }
            }
        }
        ConditionKind::Remember { field, .. } => {
            let value = carried(field);
            question.remembers += usize::from(value.has_choice());
            question.related.join(&value);
        }
        _ => condition.operands().into_iter().for_each(|part| relate(part, carried, question)),
    }
}

/// Choices that are compared with each other, or with one that is, are tried with the same texts.
struct Groups(Vec<usize>);

impl Groups {
    fn of(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn unite(&mut self, one: Choice, other: Choice) {
        let (this, that) = (self.0[one], self.0[other]);
        self.0.iter_mut().filter(|group| **group == that).for_each(|group| *group = this);
    }

    fn group(&self, choice: Choice) -> BTreeSet<Choice> {
        (0..self.0.len()).filter(|other| self.0[*other] == self.0[choice]).collect()
    }
}
