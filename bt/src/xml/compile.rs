//! Compiles a node's attributes into its settings.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use diagnostics::Problem;
use miette::SourceSpan;

use super::elements::span;
use super::ports::{Port, is_port_name, ports};
use super::problems::{
    Problems, missing_port, not_supported, partly_read, port_value, types_differ, unbraced_output,
    unseparated_statement,
};
use crate::blackboard::{Clash, ScopeId, Slot, Type, braced_key, pointed_key};
use crate::hooks::Hooks;
use crate::library::{Attribute, Model};
use crate::program::LeafPort;
use crate::script::{Names, Script};
use crate::settings::{
    Constants, DetourGuard, DistanceLimit, Goals, Index, Input, Loop, Nav2, Setting, SpeedLimit, Update, period,
};
use crate::{Direction, Item, Kind};

/// Resolves names.
pub(super) trait Surroundings: Names {
    fn scope(&self) -> ScopeId;

    /// The entry of a key to which a port of this type refers, and its existing type if the two do not agree.
    fn port(&mut self, key: &str, of: &Type) -> (Slot, Option<Clash>);

    /// The entry of a key to which a port of the type `BT::Any` refers.
    fn any_port(&mut self, key: &str) -> Slot;

    /// Whether a key is of the node's own tree or of the main tree (`@key`), and not remapped.
    fn is_own(&self, key: &str) -> bool;

    /// The number of a new memo on the blackboard.
    fn next_memo(&mut self) -> usize;

    /// The number of an entry that a node watches.
    fn watch(&mut self, slot: Slot) -> usize;

    /// The entry of a key to which a port of an unknown type refers.
    fn unknown_port(&mut self, key: &str) -> Slot;

    fn constants(&self) -> Arc<Constants>;

    /// Whether attributes are only checked: each once, wherever the node is used.
    fn only_checks(&self) -> bool {
        false
    }
}

/// Surroundings in which all names refer to the same entry, for checking attributes.
pub(super) struct Nowhere(pub(super) Arc<Constants>);

impl Names for Nowhere {
    fn constant(&self, name: &str) -> Option<i64> {
        self.0.get(name).copied()
    }

    fn slot(&mut self, _: &str) -> Slot {
        Slot(0)
    }
}

impl Surroundings for Nowhere {
    fn scope(&self) -> ScopeId {
        ScopeId(0)
    }

    fn port(&mut self, _: &str, _: &Type) -> (Slot, Option<Clash>) {
        (Slot(0), None)
    }

    fn any_port(&mut self, _: &str) -> Slot {
        Slot(0)
    }

    fn is_own(&self, _: &str) -> bool {
        true
    }

    fn next_memo(&mut self) -> usize {
        0
    }

    fn watch(&mut self, _: Slot) -> usize {
        0
    }

    fn unknown_port(&mut self, _: &str) -> Slot {
        Slot(0)
    }

    fn constants(&self) -> Arc<Constants> {
        self.0.clone()
    }

    fn only_checks(&self) -> bool {
        true
    }
}

/// Compiles one node.
pub(super) struct Compiler<'a> {
    pub(super) kind: Kind,
    /// The name of the node in messages.
    pub(super) name: &'a str,
    pub(super) attributes: &'a [Attribute],
    /// The position of the node's start tag.
    pub(super) span: SourceSpan,
    pub(super) names: &'a mut dyn Surroundings,
    pub(super) problems: &'a mut Problems,
}

impl Compiler<'_> {
    /// The values that the node reads. Errors are reported as problems.
    pub(super) fn setting(&mut self) -> Setting {
        self.compile().unwrap_or(Setting::Nothing)
    }

    fn compile(&mut self) -> Option<Setting> {
        let [first, second, third] = [0, 1, 2].map(|place| ports(self.kind).get(place));
        Some(match self.kind {
            Kind::Switch(_) => {
                let variable = self.input(first?);
                let cases = ports(self.kind)[1..].iter().map(|port| self.input(port)).collect();
                Setting::Switch { variable, cases, constants: self.names.constants() }
            }
            // BehaviorTree.CPP compares a script with its last one before it reads it, which is none.
            Kind::Script if self.attribute("code").is_some_and(|code| code.value.is_empty()) => {
                Setting::Script(Script { statements: Vec::new() })
            }
            Kind::Script => Setting::Script(self.code(first?)?),
            Kind::ScriptCondition => Setting::Condition(self.code(first?)?),
            Kind::Precondition => {
                let (script, otherwise) = (self.code(first?), self.input(second?));
                Setting::Precondition { script: script?, otherwise: otherwise? }
            }
            Kind::Loop(item) => self.a_loop(item, [first?, second?, third?])?,
            Kind::SkipUnlessUpdated | Kind::WaitValueUpdate | Kind::WasEntryUpdated => {
                let entry = self.entry(first?)?;
                Setting::Watched(self.names.watch(entry))
            }
            Kind::SetBlackboard => {
                let (value, key) = (self.copied(first?), self.input(second?));
                Setting::SetBlackboard { key: key?, value: value?, scope: self.names.scope() }
            }
            Kind::UnsetBlackboard => Setting::UnsetBlackboard { key: self.input(first?)?, scope: self.names.scope() },
            Kind::RateController => match self.rate(first?)? {
                Input::Constant(hz) => Setting::Constant([period(hz.to_real().ok()?).ok()?, 0]),
                hz => Setting::Nav2(Box::new(Nav2::Rate(hz))),
            },
            Kind::RecoveryNode | Kind::RoundRobin => self.numbers(first, second)?,
            kind if kind.is_of_nav2() => self.nav2()?.map_or(Setting::Nothing, |nav2| Setting::Nav2(Box::new(nav2))),
            // The ports of all other nodes, if they have any, are numbers and Booleans.
            _ if first.is_some() => self.numbers(first, second)?,
            _ => Setting::Nothing,
        })
    }

    /// Values that one of Nav2's nodes reads, `Some(None)` if it reads nothing.
    fn nav2(&mut self) -> Option<Option<Nav2>> {
        Some(Some(match (self.kind, ports(self.kind)) {
            (Kind::PersistentSequence, [index]) => Nav2::Index(self.index(index)?),
            (Kind::PauseResumeController, [pause, resume]) => {
                let [pause, resume] = [self.request(pause), self.request(resume)];
                Nav2::Requests([pause?, resume?].map(|entry| self.names.watch(entry)))
            }
            (Kind::DistanceController, [distance, ..]) => {
                let distance = self.input(distance)?;
                Nav2::Distance(DistanceLimit {
                    distance,
                    pose: self.names.slot("@robot_pose"),
                    memo: self.names.next_memo(),
                })
            }
            (Kind::SpeedController, [min_rate, max_rate, min_speed, max_speed, goal, goals]) => {
                // All are read before any missing one ends this, so that every problem is reported.
                let rates = [self.rate(min_rate), self.rate(max_rate)];
                let speeds = [self.input(min_speed), self.input(max_speed)];
                let goals = self.goals([goal, goals])?;
                let ([min_rate, max_rate], [min_speed, max_speed]) = (rates, speeds);
                let (rates, speeds) = ([min_rate?, max_rate?], [min_speed?, max_speed?]);
                Nav2::Speed(SpeedLimit { rates, speeds, speed: self.names.slot("@robot_speed"), goals })
            }
            (Kind::GoalUpdatedController, [goal, goals]) => Nav2::Goals(self.goals([goal, goals])?),
            (Kind::GoalUpdater, [goal, goals, new_goal, new_goals]) => {
                let mut update = |input: &Port, output: &Port, key: &str| Update {
                    input: self.input(input),
                    update: self.names.slot(key),
                    output: self.input(output).and_then(|output| output.entry()),
                };
                Nav2::Updates([update(goal, new_goal, "@goal_update"), update(goals, new_goals, "@goals_update")])
            }
            (Kind::PathLongerOnApproach, [path, near, factor]) => {
                let (path, near, factor) = (self.input(path), self.input(near), self.input(factor));
                Nav2::Path(DetourGuard { path, near: near?, factor: factor?, memo: self.names.next_memo() })
            }
            _ => return Some(None),
        }))
    }

    /// The entry with the index of a PersistentSequence's child.
    fn index(&mut self, port: &Port) -> Option<Index> {
        let attribute = self.required(port)?;
        let Some(key) = pointed_key(&attribute.name, &attribute.value).map(str::to_owned) else {
            let help = format!("write {}=\"{{{}}}\"", port.name, attribute.value);
            self.wrong_value(&attribute, "it must be an entry of the blackboard", Some(help));
            return None;
        };
        let slot = self.value(&attribute, &port.of.type_of(), Direction::InOut)?.entry()?;
        // The assembly counts the children.
        Some(Index { slot, key: key.into(), children: 0, memo: self.names.next_memo() })
    }

    /// The entry that stands for a service.
    fn request(&mut self, port: &Port) -> Option<Slot> {
        let service = self.required(port)?.value;
        Some(self.names.slot(&format!("@{}", service.trim_start_matches('/'))))
    }

    fn goals(&mut self, [goal, goals]: [&Port; 2]) -> Option<Goals> {
        let (goal, goals) = (self.input(goal), self.input(goals));
        Some(Goals { goals: [goal?, goals?], memo: self.names.next_memo() })
    }

    /// A rate; if it is a constant, it must be greater than 0.
    fn rate(&mut self, port: &Port) -> Option<Input> {
        let hz = self.input(port)?;
        if let Input::Constant(value) = &hz
            && let Err(error) = period(value.to_real().ok()?)
        {
            let attribute = self.attribute(port.name)?;
            self.wrong_value(&attribute, &error.to_string(), None);
            return None;
        }
        Some(hz)
    }

    /// One or two numbers; constants are read now.
    fn numbers(&mut self, first: Option<&Port>, second: Option<&Port>) -> Option<Setting> {
        let mut inputs = [None, None];
        for (input, port) in inputs.iter_mut().zip([first, second]) {
            if let Some(port) = port {
                *input = Some((self.input(port)?, port.of.type_of()));
            }
        }
        let mut numbers = [0; 2];
        for (number, input) in numbers.iter_mut().zip(&inputs) {
            match input {
                Some((Input::Constant(value), _)) => *number = value.to_int().ok()?,
                Some((Input::Entry(..), _)) => return Some(Setting::Numbers(inputs)),
                None => {}
            }
        }
        Some(Setting::Constant(numbers))
    }

    fn a_loop(&mut self, item: Item, [queue, if_empty, value]: [&Port; 3]) -> Option<Setting> {
        let (queue, if_empty, value) = (self.input(queue), self.input(if_empty), self.input(value));
        let value = match value {
            Some(Input::Entry(slot, _)) => Some(slot),
            _ => None,
        };
        let memo = self.names.next_memo();
        Some(Setting::Loop(Loop { queue: self.queue(queue?, item), value, if_empty: if_empty?, item, memo }))
    }

    /// The entry named by a port, with or without braces.
    fn entry(&mut self, port: &Port) -> Option<Slot> {
        let attribute = self.required(port)?;
        match pointed_key(port.name, &attribute.value) {
            Some(key) => Some(self.names.any_port(key)),
            None => Some(self.names.slot(&attribute.value)),
        }
    }

    /// What SetBlackboard writes: it looks for the key itself, so `=` has no meaning.
    fn copied(&mut self, port: &Port) -> Option<Input> {
        let attribute = self.required(port)?;
        match braced_key(&attribute.value) {
            // While it loads the tree, BehaviorTree.CPP sees the port's own name here.
            Some("=") => Some(Input::Entry(self.names.slot("="), "=".into())),
            Some(key) => Some(Input::Entry(self.names.port(key, &Type::Any).0, key.into())),
            None => Some(Input::Constant(attribute.value.as_str().into())),
        }
    }

    /// A constant queue is read once.
    fn queue(&mut self, queue: Input, item: Item) -> Input {
        let Input::Constant(value) = &queue else { return queue };
        match Type::List(Box::new(item.type_of())).convert(value) {
            Ok(list) => Input::Constant(list),
            Err(error) => {
                let attribute = self.attribute("queue").expect("a queue that is a constant is an attribute");
                self.wrong_value(&attribute, &error.to_string(), None);
                queue
            }
        }
    }

    fn attribute(&self, name: &str) -> Option<Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name).cloned()
    }

    fn required(&mut self, port: &Port) -> Option<Attribute> {
        let found = self.attribute(port.name);
        if found.is_none() {
            let near = self.meant_to_be(port.name);
            let help = near.map(|near| format!("did you mean `{}` instead of `{near}`?", port.name));
            self.problems.push(missing_port(self.name, port.name, self.span, help));
        }
        found
    }

    /// The source of a port's value; `None` if it is missing or wrong.
    fn input(&mut self, port: &Port) -> Option<Input> {
        match (self.attribute(port.name), port.default) {
            (Some(attribute), _) => self.value(&attribute, &port.of.type_of(), Direction::Input),
            (None, Some(default)) => Some(match pointed_key(port.name, default) {
                Some(key) => Input::Entry(self.names.slot(key), key.into()),
                None => Input::Constant(port.of.type_of().parse(default).expect("a default has its port's type")),
            }),
            (None, None) if port.optional => None,
            (None, None) => {
                self.required(port);
                None
            }
        }
    }

    fn value(&mut self, attribute: &Attribute, of: &Type, direction: Direction) -> Option<Input> {
        if let Some(key) = pointed_key(&attribute.name, &attribute.value) {
            let (slot, clash) = self.names.port(key, of);
            if let Some(clash) = clash {
                let problem = types_differ(key, &clash, of, direction);
                self.problems.push(problem.at(attribute.value_span, format!("used as {of} here")));
            }
            return Some(Input::Entry(slot, key.into()));
        }
        match of.parse(&attribute.value) {
            Ok(value) => Some(Input::Constant(value)),
            Err(error) => {
                let help = (*of == Type::Status).then(|| "write SUCCESS, FAILURE, RUNNING or SKIPPED".to_owned());
                self.wrong_value(attribute, &error.to_string(), help);
                None
            }
        }
    }

    fn wrong_value(&mut self, attribute: &Attribute, message: &str, help: Option<String>) {
        self.problems.push(port_value(&attribute.written, message, attribute.value_span, help));
    }

    fn code(&mut self, port: &Port) -> Option<Script> {
        let attribute = self.required(port)?;
        if pointed_key(&attribute.name, &attribute.value).is_some() {
            let (what, help) = ("a script that is on the blackboard", "write the script in the file");
            self.problems.push(not_supported(what, attribute.value_span, help));
            return None;
        }
        self.script(&attribute)
    }

    fn script(&mut self, attribute: &Attribute) -> Option<Script> {
        let whole = attribute.value_span;
        let place = |range: Range<usize>| {
            // At the end of the file there is nothing to mark except the text before it.
            if attribute.is_plain { span(whole.offset() + range.start..whole.offset() + range.end) } else { whole }
        };
        match Script::parse(&attribute.value, self.names) {
            Ok((script, unseparated)) => {
                if let Some(range) = unseparated.filter(|_| self.names.only_checks()) {
                    self.problems.push(unseparated_statement(place(range)));
                }
                Some(script)
            }
            Err(error) => {
                let problem = Problem::new(format!("cannot parse this script: {}", error.message));
                self.problems.push(problem.at(place(error.range), "here"));
                None
            }
        }
    }

    /// The scripts in attributes.
    pub(super) fn hooks(&mut self) -> Option<Hooks> {
        let mut hooks = Hooks::default();
        let mut has_any = false;
        for attribute in self.attributes.iter().filter(|attribute| attribute.name.starts_with('_')) {
            if let Some(place) = hooks.script(&attribute.name) {
                *place = self.script(attribute);
                has_any = true;
            }
        }
        has_any.then_some(hooks)
    }

    /// Warns of numbers that are read only up to where they stop being numbers, and of output ports that name no entry.
    pub(super) fn check_values(&mut self, model: Option<&Model>) {
        let builtin = |name: &str| ports(self.kind).iter().find(|port| port.name == name).map(|port| port.of.type_of());
        for Attribute { name, written, value, value_span, .. } in self.attributes {
            let port = model.and_then(|model| model.port(name));
            let of = builtin(name).or_else(|| port.map(|port| port.of.clone()));
            if pointed_key(name, value).is_some() || !is_port_name(name) {
                continue;
            }
            if let Some((text, read)) = of.and_then(|of| of.reads_only_part(value)) {
                self.problems.push(partly_read(written, &text, &read, *value_span));
            }
            if port.is_some_and(|port| port.direction == Direction::Output) && !value.is_empty() {
                self.problems.push(unbraced_output(written, value, *value_span));
            }
        }
    }

    /// Warns of a key that BehaviorTree.CPP does not see as one while it loads the tree, because of what is around it.
    pub(super) fn check_braces(&mut self, model: Option<&Model>) {
        let builtin = |name: &str| ports(self.kind).iter().find(|port| port.name == name).map(|port| port.of.type_of());
        let of_model = |name: &str| model.and_then(|model| model.port(name)).map(|port| port.of.clone());
        for Attribute { name, written, value, value_span, .. } in self.attributes {
            let is_braced = value.starts_with('{') && value.ends_with('}');
            let is_key = !is_braced && pointed_key(name, value).is_some();
            let Some(of) = builtin(name).or_else(|| of_model(name)).filter(|_| is_key) else { continue };
            if of.parse(value).is_err() {
                let problem = Problem::new(format!("the port `{written}` is not an entry of the blackboard"));
                let problem = problem.as_warning().at(*value_span, "write {key}, without spaces around it");
                self.problems.push(problem.with_help(format!(
                    "BehaviorTree.CPP refuses to load this tree: \"The port with name \"{written}\" and value \
                     \"{value}\" can not be converted to {of}\""
                )));
            }
        }
    }

    /// The ports of a leaf outside the tree: those given as attributes, and those that its model declares.
    pub(super) fn leaf_ports(&mut self, model: Option<&Model>) -> BTreeMap<String, LeafPort> {
        let mut leaf_ports = self.given_ports(model);
        for port in model.iter().flat_map(|model| &model.ports) {
            if leaf_ports.contains_key(&port.name) {
                continue;
            }
            let input = port.default.as_ref().and_then(|default| match pointed_key(&port.name, default) {
                // BehaviorTree.CPP creates entries for the ports in the file only.
                Some(key) => Some(Input::Entry(self.names.slot(key), key.into())),
                None => port.of.parse(default).ok().map(Input::Constant),
            });
            let (direction, of) = (port.direction, port.of.clone());
            let is_own = self.is_own(input.as_ref());
            leaf_ports.insert(port.name.clone(), LeafPort { direction, of, input, is_declared: true, is_own });
        }
        leaf_ports
    }

    /// Whether a port's entry is of the node's own tree.
    fn is_own(&self, input: Option<&Input>) -> bool {
        matches!(input, Some(Input::Entry(_, key)) if self.names.is_own(key))
    }

    pub(super) fn given_ports(&mut self, model: Option<&Model>) -> BTreeMap<String, LeafPort> {
        let mut given = BTreeMap::new();
        for attribute in self.attributes.iter().filter(|attribute| is_port_name(&attribute.name)) {
            let port = model.and_then(|model| model.port(&attribute.name));
            let (direction, of) = port.map_or((Direction::InOut, Type::Any), |port| (port.direction, port.of.clone()));
            let is_typed = port.is_some_and(|port| port.type_name.is_some());
            let input = match pointed_key(&attribute.name, &attribute.value).filter(|_| !is_typed) {
                Some(key) => Some(Input::Entry(self.names.unknown_port(key), key.into())),
                None => self.value(attribute, &of, direction),
            };
            let is_declared = port.is_some();
            let is_own = self.is_own(input.as_ref());
            given.insert(attribute.name.clone(), LeafPort { direction, of, input, is_declared, is_own });
        }
        given
    }
}
