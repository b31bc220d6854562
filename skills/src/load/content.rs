//! Compiling executable content.

use std::sync::Arc;

use diagnostics::Problem;

use super::compile::Compiler;
use super::rules::EXECUTABLE;
use super::value::InlineContent;
use super::xml::{Element, Written, elements, elements_named, name_span};
use crate::Datum;
use crate::chart::{
    Action, ActionKind, Attribute, Block, Branch, Content, Foreach, Param, Payload, Source, is_event_name,
};
use crate::expression::Form;
use crate::expression::{self, Expr, is_identifier};

impl Compiler<'_> {
    pub(super) fn block(&mut self, node: Element<'_>) -> Block {
        self.actions(elements(node).filter(|child| EXECUTABLE.contains(&child.tag_name().name())))
    }

    fn actions<'a>(&mut self, nodes: impl Iterator<Item = Element<'a>>) -> Block {
        nodes.filter_map(|node| self.action(node)).collect()
    }

    /// An element of executable content; `None` if a required part is missing.
    fn action(&mut self, node: Element<'_>) -> Option<Action> {
        let kind = match node.tag_name().name() {
            "raise" => self.raise(node)?,
            "if" => ActionKind::If(self.branches(node)?),
            "foreach" => self.foreach(node)?,
            "log" => ActionKind::Log {
                label: node.attribute("label").unwrap_or_default().into(),
                value: Written::attribute(node, "expr")
                    .filter(|written| !written.value.trim().is_empty())
                    .map(|written| self.expression(&written)),
            },
            "assign" => self.assign(node)?,
            "script" => return Some(self.script(node)),
            "send" => self.send(node),
            "cancel" => match self.alternative(node, "sendid", "sendidexpr") {
                Some(id) => ActionKind::Cancel(id.source),
                None => {
                    let problem =
                        Problem::new("<cancel> does not name a <send>").at(name_span(node), "`sendid` is missing");
                    self.problems.push(problem.with_help("`sendid` is the `id` of the <send> to be canceled"));
                    return None;
                }
            },
            _ => return None,
        };
        Some(Action { kind, span: name_span(node).into() })
    }

    fn raise(&mut self, node: Element<'_>) -> Option<ActionKind> {
        let written = Written::attribute(node, "event")?;
        self.event_name(&written);
        Some(ActionKind::Raise { event: written.value.into(), class: self.events.class(written.value) })
    }

    pub(super) fn event_name(&mut self, written: &Written<'_>) {
        if !is_event_name(written.value) {
            let problem = Problem::new(format!("`{}` cannot be the name of an event", written.value));
            self.problems
                .push(problem.at(written.span(), "not a name").with_help("use words joined by dots: `door.opened`"));
        }
    }

    fn branches(&mut self, node: Element<'_>) -> Option<Vec<Branch>> {
        let condition = self.condition(&Written::attribute(node, "cond")?);
        let mut branches = vec![Branch { condition: Some(condition), content: Block::new() }];
        let mut closed = false;
        for child in elements(node) {
            let name = child.tag_name().name();
            if name == "elseif" || name == "else" {
                if closed {
                    let problem = Problem::new(format!("<{name}> after <else>")).at(name_span(child), "never reached");
                    self.problems.push(problem.with_help("<else/> must be the last branch of an <if>"));
                }
                closed = name == "else";
                let condition = Written::attribute(child, "cond").filter(|_| name == "elseif");
                let condition = condition.map(|written| self.condition(&written));
                branches.push(Branch { condition, content: Block::new() });
            } else if let Some(action) = self.action(child)
                && let Some(branch) = branches.last_mut()
            {
                branch.content.push(action);
            }
        }
        Some(branches)
    }

    fn foreach(&mut self, node: Element<'_>) -> Option<ActionKind> {
        let array = self.expression(&Written::attribute(node, "array")?);
        let mut variable = |name: &'static str| {
            let written = Written::attribute(node, name)?;
            if !is_identifier(written.value) {
                let problem = Problem::new(format!("`{}` cannot be the name of a datum", written.value));
                return Some(Err(self.defer(problem.at(written.span(), "not a name"))));
            }
            self.names.data.get(written.value).copied().map(Ok)
        };
        let (item, index) = (variable("item")?, variable("index"));
        let content = self.block(node);
        match (item, index.transpose()) {
            (Ok(item), Ok(index)) => Some(ActionKind::Foreach(Box::new(Foreach { array, item, index, content }))),
            (Err(reason), _) | (_, Err(reason)) => Some(ActionKind::Fail(reason)),
        }
    }

    fn assign(&mut self, node: Element<'_>) -> Option<ActionKind> {
        let location = self.assign_target(&Written::attribute(node, "location")?);
        let value = match (Written::attribute(node, "expr"), InlineContent::of(node)) {
            (Some(expr), None) if expr.value.trim().is_empty() => Expr::Constant(Datum::Undefined),
            (Some(expr), None) => self.expression(&expr),
            (None, Some(text)) => Expr::Constant(text.value),
            (None, None) => {
                let problem = Problem::new("nothing is assigned").at(name_span(node), "`expr` is missing");
                Expr::Broken(self.defer(problem))
            }
            (Some(expr), Some(text)) => {
                let problem = Problem::new("an assignment has either an expression or content, not both");
                self.problems.push(problem.at(expr.span(), "either this").at(text.span, "or this"));
                return None;
            }
        };
        Some(match location {
            Ok(location) => ActionKind::Assign(location, value),
            Err(reason) => ActionKind::Fail(reason),
        })
    }

    pub(super) fn script(&mut self, node: Element<'_>) -> Action {
        let kind = match (Written::attribute(node, "src"), Written::text(node)) {
            (Some(src), Some(text)) => {
                let problem = Problem::new("a script is either in a file or here, not both");
                self.problems.push(problem.at(src.span(), "either this").at(text.span(), "or this"));
                ActionKind::Script(Vec::new())
            }
            (Some(src), None) => self.script_file(&src),
            (None, Some(text)) => {
                let parsed = expression::script(text.value, &self.names);
                self.compiled(&text, parsed, Form::Script, ActionKind::Script, ActionKind::Foreign)
                    .unwrap_or_else(ActionKind::Fail)
            }
            (None, None) => ActionKind::Script(Vec::new()),
        };
        Action { kind, span: name_span(node).into() }
    }

    /// A script from a file. If it cannot be read, the machine is refused (SCXML 5.8).
    fn script_file(&mut self, src: &Written<'_>) -> ActionKind {
        let text = match self.origin.read(src.value) {
            Ok(text) => text,
            Err(reason) => {
                self.problems.push(Problem::new(reason).at(src.span(), "cannot be read"));
                return ActionKind::Script(Vec::new());
            }
        };
        let parsed = expression::script(&text, &self.names);
        let whole = src.whole(&text);
        self.compiled(&whole, parsed, Form::Script, ActionKind::Script, ActionKind::Foreign)
            .unwrap_or_else(ActionKind::Fail)
    }

    /// The value that the attribute `literal` contains or the attribute `computed` computes.
    pub(super) fn alternative(&mut self, node: Element<'_>, literal: &str, computed: &str) -> Option<Attribute> {
        if let Some(written) = Written::attribute(node, literal) {
            return Some(Attribute { source: Source::Literal(written.value.into()), span: written.span().into() });
        }
        let written = Written::attribute(node, computed)?;
        Some(Attribute { source: Source::Computed(self.expression(&written)), span: written.span().into() })
    }

    /// The parameters or the content of a `<send>` or `<donedata>`.
    pub(super) fn payload(&mut self, node: Element<'_>) -> Payload {
        let params: Vec<Param> = elements_named(node, "param").filter_map(|param| self.param(param)).collect();
        let content = elements_named(node, "content").next();
        if let (Some(content), false) = (content, params.is_empty()) {
            let problem = Problem::new("use either parameters or content, not both");
            self.problems.push(problem.at(name_span(content), "content beside parameters"));
        }
        Payload { params, content: content.map(|content| self.content(content)) }
    }

    pub(super) fn param(&mut self, node: Element<'_>) -> Option<Param> {
        let name: Arc<str> = Written::attribute(node, "name")?.value.into();
        let written = Written::attribute(node, "expr").or_else(|| Written::attribute(node, "location"));
        let Some(written) = written else {
            let problem = Problem::new(format!("the parameter `{name}` has no value"));
            self.problems.push(problem.at(name_span(node), "`expr` is missing"));
            return None;
        };
        Some(Param { name, value: self.expression(&written), location: None, span: written.span().into() })
    }

    fn content(&mut self, node: Element<'_>) -> Content {
        match Written::attribute(node, "expr") {
            Some(written) => Content::Computed(self.expression(&written), written.span().into()),
            None => Content::Literal(InlineContent::of(node).map_or_else(|| "".into(), |text| text.value)),
        }
    }
}
