//! A chart as text: an outline, or a graph for Graphviz.

use super::{Chart, HistoryKind, StateKind, Transition};
use crate::ids::StateId;

impl Chart {
    /// The states and transitions as indented text, in document order. `*` marks the states that are entered by
    /// default.
    ///
    /// ```
    /// use skills::Chart;
    ///
    /// let chart = Chart::load("Lamp.scxml", r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0">
    ///   <state id="off"><transition event="press" cond="1 &lt; 2" target="on"/></state>
    ///   <final id="on"/>
    /// </scxml>"#)?;
    /// assert_eq!(chart.outline(), "machine Lamp\n  * off\n      press [1 < 2] -> on\n  final on\n");
    /// # Ok::<(), skills::SkillError>(())
    /// ```
    #[must_use]
    pub fn outline(&self) -> String {
        let mut text = format!("machine {}\n", self.name());
        self.outline_children(self.root(), 1, &mut text);
        text
    }

    fn outline_children(&self, parent: StateId, depth: usize, text: &mut String) {
        let around = self.state(parent);
        let mut children: Vec<StateId> = around.children().iter().chain(around.histories()).copied().collect();
        children.sort_unstable();
        for child in children {
            let state = self.state(child);
            let is_default = around.kind == StateKind::Compound && self.enters_first(parent, child);
            let mark = if is_default { "* " } else { "" };
            *text += &format!("{:indent$}{mark}{}{}\n", "", prefix(state.kind), state.id(), indent = 2 * depth);
            if let StateKind::History(_) = state.kind {
                *text += &format!("{:indent$}-> {}\n", "", self.ids(state.initial()), indent = 2 * depth + 4);
            }
            for invoke in &state.invokes {
                let id = invoke.id.as_deref().unwrap_or("a machine");
                *text += &format!("{:indent$}invokes {id}\n", "", indent = 2 * depth + 4);
            }
            for transition in state.transitions() {
                let label = self.label(self.transition(*transition));
                *text += &format!("{:indent$}{label}\n", "", indent = 2 * depth + 4);
            }
            self.outline_children(child, depth + 1, text);
        }
    }

    /// Whether entering a state by default enters this child of it.
    #[must_use]
    pub fn enters_first(&self, state: StateId, child: StateId) -> bool {
        let initial = self.state(state).initial();
        initial.iter().any(|target| *target == child || self.is_descendant(*target, child))
    }

    fn ids(&self, states: &[StateId]) -> String {
        states.iter().map(|state| self.state(*state).id()).collect::<Vec<_>>().join(", ")
    }

    /// A transition's trigger and target, on one line.
    #[must_use]
    pub fn label(&self, transition: &Transition) -> String {
        let mut parts: Vec<String> = transition.events().map(str::to_owned).collect();
        parts.extend(transition.condition().map(|condition| format!("[{condition}]")));
        if transition.targets.is_empty() {
            parts.push("stays".to_owned());
        } else {
            let arrow = if transition.internal { "-> (internal)" } else { "->" };
            parts.push(format!("{arrow} {}", self.ids(&transition.targets)));
        }
        parts.join(" ")
    }

    /// The chart as a graph in the language of Graphviz: `dot -Tsvg`.
    #[must_use]
    pub fn to_dot(&self) -> String {
        let mut text = format!("digraph {} {{\n  compound=true; rankdir=LR;\n", quoted(self.name()));
        text.push_str(
            "  node [shape=box, style=rounded, fontname=Helvetica]; edge [fontname=Helvetica, fontsize=10];\n",
        );
        let root = self.root();
        self.state(root).children().iter().for_each(|child| self.dot_state(*child, 1, &mut text));
        self.dot_start(root, &mut text);
        for transition in self.transitions().map(|transition| self.transition(transition)) {
            let mut label: Vec<String> = transition.events().map(str::to_owned).collect();
            label.extend(transition.condition().map(|condition| format!("[{condition}]")));
            let targets =
                if transition.targets.is_empty() { vec![transition.source] } else { transition.targets.clone() };
            for target in targets {
                let ((start, tail), (end, head)) = (self.dot_end(transition.source), self.dot_end(target));
                let (tail, head) = (cluster("ltail", tail), cluster("lhead", head));
                text += &format!("  s{start} -> s{end} [label={}{tail}{head}];\n", quoted(&label.join("\n")));
            }
        }
        text.push_str("}\n");
        text
    }

    fn dot_state(&self, id: StateId, depth: usize, text: &mut String) {
        let state = self.state(id);
        let indent = "  ".repeat(depth);
        let (number, name) = (id.index(), quoted(state.id()));
        if state.children().is_empty() {
            let shape = match state.kind {
                StateKind::Final => ", peripheries=2",
                StateKind::History(_) => ", shape=circle",
                _ => "",
            };
            let label = if let StateKind::History(kind) = state.kind { quoted(history(kind)) } else { name };
            *text += &format!("{indent}s{number} [label={label}{shape}];\n");
        } else {
            let style = if state.kind == StateKind::Parallel { "dashed" } else { "rounded" };
            *text += &format!("{indent}subgraph cluster_{number} {{\n{indent}  label={name}; style={style};\n");
            state.children().iter().chain(state.histories()).for_each(|child| self.dot_state(*child, depth + 1, text));
            *text += &format!("{indent}}}\n");
            self.dot_start(id, text);
        }
    }

    /// The point from which a compound state starts.
    fn dot_start(&self, id: StateId, text: &mut String) {
        if self.state(id).kind == StateKind::Compound {
            let number = id.index();
            *text += &format!("  i{number} [shape=point, width=0.12, label=\"\"];\n");
            for target in self.state(id).initial() {
                let (end, head) = self.dot_end(*target);
                *text += &format!("  i{number} -> s{end} [style=dotted{}];\n", cluster("lhead", head));
            }
        }
    }

    /// Graphviz draws edges only between nodes. Returns the first node inside a state, and the state itself if it is
    /// not a node.
    fn dot_end(&self, id: StateId) -> (usize, Option<usize>) {
        let mut node = id;
        while let Some(child) = self.state(node).children().first() {
            node = *child;
        }
        (node.index(), (node != id).then_some(id.index()))
    }
}

fn prefix(kind: StateKind) -> &'static str {
    match kind {
        StateKind::Atomic | StateKind::Compound => "",
        StateKind::Parallel => "parallel ",
        StateKind::Final => "final ",
        StateKind::History(HistoryKind::Shallow) => "history ",
        StateKind::History(HistoryKind::Deep) => "deep history ",
    }
}

fn history(kind: HistoryKind) -> &'static str {
    if kind == HistoryKind::Deep { "H*" } else { "H" }
}

fn cluster(attribute: &str, state: Option<usize>) -> String {
    state.map_or_else(String::new, |state| format!(", {attribute}=cluster_{state}"))
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n"))
}
