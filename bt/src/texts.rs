//! A tree's use of the texts that its leaves give it: what it compares them with, and which leaves get them.
//!
//! A proof tries only as many texts as can be told apart, so everything that a tree does with a text that something
//! outside the system chooses is followed here. The tree's own texts may be used in any way.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use channels::{Beyond, Choice, Comparisons, Possible};
use diagnostics::Problem;

use crate::blackboard::{Slot, Type, Value};
use crate::script::{Assignment, Binary, Comparison, Expression, Script};
use crate::settings::{Constants, Input, Loop, Nav2, Setting};
use crate::{Direction, Node, Tree};

/// How to fix a tree that does too much with a text.
const WAY_OUT: &str = "compare it with other texts by `==` and `!=`; a proof tells texts apart only by that";

/// What a tree does with texts.
#[derive(Clone, Debug, Default)]
pub struct TextsOfTree {
    /// What each port of a leaf may get from the blackboard, by the leaf's process and the port.
    pub inputs: BTreeMap<(String, String), Possible>,
    /// What it compares chosen texts with.
    pub comparisons: Comparisons,
    /// Each entry that keeps chosen texts, with these.
    pub kept: Vec<BTreeSet<Choice>>,
    /// Everything that it does with a chosen text that tells more texts apart, each at its node.
    pub problems: Vec<Problem>,
}

impl Tree {
    /// What the tree may do with texts in any run, if the leaves give it these outputs, by process and port. `choices`
    /// are the chosen texts in words, by number.
    #[must_use]
    pub fn texts(&self, outputs: &BTreeMap<(String, String), Possible>, choices: &[String]) -> TextsOfTree {
        let mut board = Board::new(self, outputs, choices, &[]);
        board.settle();
        board.finish()
    }

    /// Warns of each node that compares an output with texts that it never is. `choices` are the outputs in words, by
    /// number, and `symbols` are the texts of which each of them is one.
    #[must_use]
    pub fn never_equal(
        &self,
        outputs: &BTreeMap<(String, String), Possible>,
        choices: &[String],
        symbols: &[BTreeSet<Arc<str>>],
    ) -> Vec<Problem> {
        let mut board = Board::new(self, outputs, choices, symbols);
        board.settle();
        let mut problems = board.never_equal;
        // Several nodes may be the same one of the file.
        problems.sort_by_key(Problem::offset);
        problems.dedup_by_key(|problem| (problem.offset(), problem.to_string()));
        problems
    }
}

/// What the entries of the blackboard may hold.
struct Board<'a> {
    tree: &'a Tree,
    outputs: &'a BTreeMap<(String, String), Possible>,
    choices: &'a [String],
    /// The texts of which each choice is one; any text if there are none.
    symbols: &'a [BTreeSet<Arc<str>>],
    entries: BTreeMap<Slot, Possible>,
    used: TextsOfTree,
    never_equal: Vec<Problem>,
}

/// What a value in the file may be.
fn of_value(value: &Value) -> Possible {
    match value {
        Value::Int(_) | Value::Real(_) => Possible::number(),
        Value::Text(text) => Possible::texts([text.clone()]),
        Value::List(items) => items.iter().map(of_value).collect::<Possible>().around(),
    }
}

impl<'a> Board<'a> {
    fn new(
        tree: &'a Tree,
        outputs: &'a BTreeMap<(String, String), Possible>,
        choices: &'a [String],
        symbols: &'a [BTreeSet<Arc<str>>],
    ) -> Self {
        let (entries, used) = (BTreeMap::new(), TextsOfTree::default());
        Self { tree, outputs, choices, symbols, entries, used, never_equal: Vec::new() }
    }

    /// Visits all nodes until nothing is new.
    fn settle(&mut self) {
        self.begin();
        loop {
            let before = self.entries.clone();
            self.never_equal.clear();
            self.tree.nodes().iter().for_each(|node| self.node(node));
            if self.entries == before {
                break;
            }
        }
    }

    fn begin(&mut self) {
        for (slot, entry) in (0..).map(Slot).zip(&self.tree.program.entries) {
            entry.initial().1.into_iter().for_each(|value| self.write(slot, &of_value(value)));
        }
    }

    fn finish(mut self) -> TextsOfTree {
        self.used.kept =
            self.entries.values().filter(|held| held.has_choice()).map(|held| held.choices().collect()).collect();
        let problems = &mut self.used.problems;
        problems.sort_by_key(Problem::offset);
        problems.dedup_by_key(|problem| (problem.offset(), problem.to_string()));
        self.used
    }

    fn entry(&self, slot: Slot) -> Possible {
        self.entries.get(&slot).cloned().unwrap_or_default()
    }

    fn write(&mut self, slot: Slot, value: &Possible) {
        self.entries.entry(slot).or_default().join(value);
    }

    fn input(&self, input: &Input) -> Possible {
        match input {
            Input::Constant(value) => of_value(value),
            Input::Entry(slot, _) => self.entry(*slot),
        }
    }

    /// Reports what a node does with a chosen text, whose name goes where the brace is.
    fn refuse(&mut self, node: &Node, what: &str, value: &Possible) {
        let names: BTreeSet<&str> = value.choices().map(|choice| self.choices[choice].as_str()).collect();
        let what = what.replace("{}", &names.into_iter().collect::<Vec<_>>().join(" or "));
        let message = format!("`{}` {what}, which a proof cannot follow", node.label());
        let problem = self.tree.problem_at(node.id(), message, "this node", WAY_OUT);
        self.used.problems.push(problem);
    }

    fn keep_out(&mut self, node: &Node, value: &Possible, what: &str) {
        if value.has_choice() {
            self.refuse(node, what, value);
        }
    }

    fn node(&mut self, node: &Node) {
        let tree = self.tree;
        if node.kind().is_leaf() {
            self.leaf(node);
        } else {
            self.setting(node, tree.program.setting(node.id().0));
        }
        for script in tree.program.scripts_of(node.id().0) {
            self.script(node, script);
        }
    }

    fn leaf(&mut self, node: &Node) {
        let tree = self.tree;
        for (name, port) in tree.program.leaf_ports(node.id()) {
            let Some(slot) = port.entry() else { continue };
            let key = (node.process().to_owned(), name.clone());
            if port.direction != Direction::Input
                && let Some(value) = self.outputs.get(&key)
            {
                if !matches!(port.of, Type::Any | Type::Text | Type::Other(_)) {
                    self.keep_out(node, value, &format!("reads {{}} as a {}", port.of));
                }
                self.put(node, slot, value);
            }
            if port.direction != Direction::Output {
                let mut value = self.entry(slot);
                if !matches!(port.of, Type::Any | Type::Text | Type::Other(_)) {
                    self.keep_out(node, &value, &format!("reads {{}} as a {}", port.of));
                }
                // Anything but a text is written as one.
                if value.is_number || value.depth > 0 {
                    value.join(&Possible::open());
                }
                self.used.inputs.entry(key).or_default().join(&value);
            }
        }
    }

    /// Writes to an entry, which may parse the value as its own type.
    fn put(&mut self, node: &Node, slot: Slot, value: &Possible) {
        let of = self.tree.program.entries.get(slot.0 as usize).map_or(Type::Any, |entry| entry.initial().0.clone());
        if !matches!(of, Type::Any | Type::Text | Type::Other(_)) {
            self.keep_out(node, value, &format!("writes {{}} to an entry that is a {of}"));
        }
        self.write(slot, value);
        if self.entry(slot).is_number {
            let held = self.entry(slot);
            self.keep_out(node, &held, "writes {} to an entry that also holds numbers");
        }
    }

    fn setting(&mut self, node: &Node, setting: &Setting) {
        match setting {
            Setting::Switch { variable, cases, constants } => {
                let variable = variable.as_ref().map(|variable| self.input(variable)).unwrap_or_default();
                for case in cases.iter().flatten() {
                    let case = self.input(case);
                    self.choose(node, &variable, &case, constants);
                }
            }
            Setting::SetBlackboard { key, value, scope } => {
                let name = self.input(key);
                self.keep_out(node, &name, "takes the name of an entry from {}");
                let value = self.input(value);
                match key {
                    Input::Constant(Value::Text(key)) => {
                        if let Some(slot) = self.tree.program.scopes.find(*scope, key) {
                            self.put(node, slot, &value);
                        }
                    }
                    _ => self.keep_out(node, &value, "writes {} to an entry whose name is not known"),
                }
            }
            Setting::UnsetBlackboard { key, .. } => {
                let key = self.input(key);
                self.keep_out(node, &key, "takes the name of an entry from {}");
            }
            Setting::Numbers(inputs) => {
                for (input, of) in inputs.iter().flatten() {
                    let value = self.input(input);
                    self.keep_out(node, &value, &format!("reads {{}} as a {of}"));
                }
            }
            Setting::Precondition { otherwise, .. } => {
                let value = self.input(otherwise);
                self.keep_out(node, &value, "reads {} as a status");
            }
            Setting::Loop(Loop { queue, value, if_empty, .. }) => {
                for input in [queue, if_empty] {
                    let read = self.input(input);
                    self.keep_out(node, &read, "reads {} as a queue");
                }
                if let Some(slot) = value {
                    let mut items = self.input(queue).part();
                    items.join(&Possible::anything());
                    self.write(*slot, &items);
                }
            }
            Setting::Nav2(nav2) => self.nav2(node, nav2),
            Setting::Nothing | Setting::Constant(_) | Setting::Watched(_) => {}
            // Scripts are visited with the others of the node.
            Setting::Script(_) | Setting::Condition(_) => {}
        }
    }

    /// What Nav2's nodes read are goals, paths and numbers, never plain texts.
    fn nav2(&mut self, node: &Node, nav2: &Nav2) {
        let all: Possible = nav2.entries().into_iter().map(|slot| self.entry(slot)).collect();
        self.keep_out(node, &all, "looks into {}");
        for slot in nav2.outputs() {
            self.write(slot, &Possible::anything());
        }
    }

    /// A Switch compares its variable with a case: as texts, and as numbers if both are.
    fn choose(&mut self, node: &Node, variable: &Possible, case: &Possible, constants: &Constants) {
        let is_number = |text: &str| constants.contains_key(text) || text.parse::<f64>().is_ok();
        for (this, that) in [(variable, case), (case, variable)] {
            if this.has_choice() && (that.has_choice() || that.texts.iter().any(|text| is_number(text))) {
                return self.refuse(node, "compares {} with what may be a number", this);
            }
        }
        self.compare(node, variable, case);
    }

    fn compare(&mut self, node: &Node, left: &Possible, right: &Possible) {
        for (chosen, texts) in [(left, right), (right, left)] {
            self.doubt(node, chosen, texts);
        }
        if let Err(beyond) = self.used.comparisons.compare(left, right, true) {
            let what = match beyond {
                Beyond::Open => "compares {} with a text that is computed",
                Beyond::Number => "compares {} with a number",
                Beyond::Structure => "compares {} with a list",
            };
            let mut both = left.clone();
            both.join(right);
            self.refuse(node, what, &both);
        }
    }

    /// Warns of a comparison of nothing but choices with nothing but texts that none of them can be.
    fn doubt(&mut self, node: &Node, chosen: &Possible, texts: &Possible) {
        let none = Possible::default();
        let is_only_chosen = Possible { chosen: chosen.chosen.clone(), ..none.clone() } == *chosen;
        let is_only_texts = Possible { texts: texts.texts.clone(), ..none.clone() } == *texts;
        // A comparison with the empty text checks whether anything has been written.
        let asks_nothing = texts.texts.iter().all(|text| text.is_empty());
        if !is_only_chosen || !is_only_texts || *chosen == none || asks_nothing {
            return;
        }
        let Some(may_be) = chosen.choices().map(|choice| self.symbols.get(choice)).collect::<Option<Vec<_>>>() else {
            return;
        };
        if may_be.iter().any(|symbols| !symbols.is_disjoint(&texts.texts)) {
            return;
        }
        let list = |all: &mut dyn Iterator<Item = &Arc<str>>| {
            all.map(|text| format!("`{text}`")).collect::<Vec<_>>().join(" or ")
        };
        let words: BTreeSet<&str> = chosen.choices().map(|choice| self.choices[choice].as_str()).collect();
        let words = words.into_iter().collect::<Vec<_>>().join(" or ");
        let texts = list(&mut texts.texts.iter());
        let message = format!("`{}` compares {words} with {texts}, which it never is", node.label());
        let help = format!("it is {}", list(&mut may_be.into_iter().flatten()));
        self.never_equal.push(self.tree.problem_at(node.id(), message, "this node", help).as_warning());
    }

    fn script(&mut self, node: &Node, script: &Script) {
        for statement in &script.statements {
            self.value(node, statement);
        }
    }

    fn value(&mut self, node: &Node, expression: &Expression) -> Possible {
        match expression {
            Expression::Literal(value) => of_value(value),
            Expression::Name(slot, _) => self.entry(*slot),
            Expression::Unary(_, operand) => {
                let operand = self.value(node, operand);
                self.keep_out(node, &operand, "computes with {}");
                Possible::number()
            }
            Expression::Binary(operator, left, right) => {
                let (left, right) = (self.value(node, left), self.value(node, right));
                self.binary(node, *operator, &left, &right)
            }
            Expression::Comparison(first, others) => {
                let mut left = self.value(node, first);
                for (comparison, right) in others {
                    let right = self.value(node, right);
                    if matches!(comparison, Comparison::Equal | Comparison::NotEqual) {
                        self.compare(node, &left, &right);
                    } else {
                        let mut both = left.clone();
                        both.join(&right);
                        self.keep_out(node, &both, "compares {} by order");
                    }
                    left = right;
                }
                Possible::number()
            }
            Expression::Choice(parts) => {
                let condition = self.value(node, &parts[0]);
                self.keep_out(node, &condition, "takes {} as a condition");
                parts[1..].iter().map(|part| self.value(node, part)).collect()
            }
            Expression::Assignment(assignment, slot, _, right) => {
                let right = self.value(node, right);
                let new = match assignment {
                    Assignment::Create | Assignment::Existing => right,
                    Assignment::With(operator) => {
                        let left = self.entry(*slot);
                        self.binary(node, *operator, &left, &right)
                    }
                };
                self.put(node, *slot, &new);
                // What is assigned may be parsed as what the entry holds.
                self.entry(*slot)
            }
        }
    }

    fn binary(&mut self, node: &Node, operator: Binary, left: &Possible, right: &Possible) -> Possible {
        for side in [left, right] {
            self.keep_out(node, side, "computes with {}");
        }
        let is_text = |side: &Possible| side.is_open || !side.texts.is_empty();
        if matches!(operator, Binary::Add | Binary::Join) && (is_text(left) || is_text(right)) {
            Possible::anything()
        } else {
            Possible::number()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(body: &str) -> TextsOfTree {
        let outputs = BTreeMap::from([(("Ask".to_owned(), "answer".to_owned()), Possible::choice(0))]);
        tree(body).texts(&outputs, &["`v` of O".to_owned()])
    }

    fn tree(body: &str) -> Tree {
        let xml = format!(
            r#"<root BTCPP_format="4" main_tree_to_execute="T"><BehaviorTree ID="T"><Sequence><Action ID="Ask" answer="{{answer}}"/>{body}</Sequence></BehaviorTree>
            <BehaviorTree ID="Sub"><ScriptCondition code="given == 'from below'"/></BehaviorTree>
            <TreeNodesModel><Action ID="Ask"><output_port name="answer" type="std::string"/></Action>
            <Action ID="Tell"><input_port name="what" type="std::string"/></Action>
            <Action ID="Count"><input_port name="number" type="int"/></Action></TreeNodesModel></root>"#
        );
        Tree::from_xml("t.xml", &xml).expect("a sound tree")
    }

    #[test]
    fn a_text_is_followed_through_entries_scripts_and_ports() {
        for (body, compared) in [
            (r#"<ScriptCondition code="answer == 'R&amp;D'"/>"#, vec!["R&D"]),
            (r#"<AlwaysSuccess _skipIf="answer != 'no'"/>"#, vec!["no"]),
            (
                r#"<Switch2 variable="{answer}" case_1="hello" case_2="bye"><AlwaysSuccess/><AlwaysSuccess/><AlwaysSuccess/></Switch2>"#,
                vec!["bye", "hello"],
            ),
            (r#"<Script code="kept := answer; want := 'x'"/><ScriptCondition code="kept == want"/>"#, vec!["x"]),
            (r#"<SubTree ID="Sub" given="{answer}"/>"#, vec!["from below"]),
            (r#"<SetBlackboard output_key="copy" value="{answer}"/><ScriptCondition code="copy == 'y'"/>"#, vec!["y"]),
            (r#"<Tell what="{answer}"/>"#, vec![]),
        ] {
            let found = texts(body);
            let problems: Vec<&str> = found.problems.iter().map(Problem::message).collect();
            assert!(problems.is_empty(), "{body}: {problems:?}");
            let with = found.comparisons.with.get(&0).into_iter().flatten();
            assert_eq!(with.map(|text| &**text).collect::<Vec<_>>(), compared, "{body}");
            if body.starts_with("<Tell") {
                assert_eq!(found.inputs[&("Tell".to_owned(), "what".to_owned())], Possible::choice(0));
            }
        }
    }

    #[test]
    fn a_comparison_with_a_text_that_an_output_never_is_is_told_at_its_node() {
        let never = |body: &str| -> Vec<String> {
            let outputs = BTreeMap::from([(("Ask".to_owned(), "answer".to_owned()), Possible::choice(0))]);
            let symbols = [BTreeSet::from(["open".into(), "shut".into()])];
            let found = tree(body).never_equal(&outputs, &["`v` of O".to_owned()], &symbols);
            found
                .iter()
                .map(|problem| format!("{}; {}", problem.message(), problem.help_text().unwrap_or("")))
                .collect()
        };
        let told = "`ScriptCondition` compares `v` of O with `opeen`, which it never is; it is `open` or `shut`";
        assert_eq!(never(r#"<ScriptCondition code="answer == 'opeen' || answer == 'shut'"/>"#), [told]);
        assert_eq!(never(r#"<Script code="kept := answer"/><ScriptCondition code="'opeen' != kept"/>"#), [told]);
        assert_eq!(never(r#"<SubTree ID="Sub" given="{answer}"/>"#).len(), 1);
        let switch = r#"<Switch2 variable="{answer}" case_1="open" case_2="closed"><AlwaysSuccess/><AlwaysSuccess/><AlwaysSuccess/></Switch2>"#;
        assert_eq!(never(switch).len(), 1);
        for body in [
            r#"<ScriptCondition code="answer == 'open' || answer != 'shut' || answer != ''"/>"#,
            r#"<Script code="answer := 'unknown'"/><ScriptCondition code="answer == 'unknown'"/>"#,
            r#"<Script code="other := 'a'"/><ScriptCondition code="other == 'b' || answer == other .. 'c'"/>"#,
        ] {
            assert_eq!(never(body), [""; 0], "{body}");
        }
        assert!(texts(r#"<ScriptCondition code="answer == 'opeen'"/>"#).problems.is_empty());
    }

    #[test]
    fn anything_more_than_a_comparison_is_refused_at_its_node() {
        for (body, what) in [
            (r#"<ScriptCondition code="answer &lt; 'b'"/>"#, "compares `v` of O by order"),
            (r#"<ScriptCondition code="answer == 7"/>"#, "compares `v` of O with a number"),
            (r#"<Script code="x := answer .. 'b'"/>"#, "computes with `v` of O"),
            (
                r#"<Switch2 variable="{answer}" case_1="5" case_2="bye"><AlwaysSuccess/><AlwaysSuccess/><AlwaysSuccess/></Switch2>"#,
                "compares `v` of O with what may be a number",
            ),
            (r#"<Repeat num_cycles="{answer}"><AlwaysSuccess/></Repeat>"#, "reads `v` of O as a int"),
        ] {
            let found = texts(body);
            let problems: Vec<&str> = found.problems.iter().map(Problem::message).collect();
            assert!(problems.iter().any(|problem| problem.contains(what)), "{body}: {problems:?}");
        }
    }
}
