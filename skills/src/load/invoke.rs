//! Compiling `<invoke>` (SCXML 6.4) and `<finalize>` (SCXML 6.5).

use std::sync::Arc;

use diagnostics::{Problem, nearest_or_all};

use super::compile::{self, Compiler};
use super::xml::{Element, Written, elements, elements_named, name_span};
use crate::chart::{ActionKind, Block};
use crate::chart::{AssignTarget, INVOKE_KINDS, Invoke, InvokeSource, Param, Source, visit_actions};
use crate::expression::Expr;
use crate::expression::Form;

impl Compiler<'_> {
    pub(super) fn invoke(&mut self, node: Element<'_>) -> Invoke {
        if let Some(kind) = Written::attribute(node, "type")
            && !INVOKE_KINDS.contains(&kind.value)
        {
            let problem = Problem::new(format!("unknown service type `{}`", kind.value));
            let help = nearest_or_all(kind.value, "types", &["scxml"]);
            self.defer(problem.at(kind.span(), "unknown type").with_help(help));
        }
        let id_location = Written::attribute(node, "idlocation").and_then(|written| self.assign_target(&written).ok());
        Invoke {
            id: node.attribute("id").map(Arc::from),
            id_location,
            kind: self.alternative(node, "type", "typeexpr"),
            source: self.invoke_source(node),
            name_list: self.name_list(node),
            params: elements_named(node, "param").filter_map(|param| self.invoke_param(param)).collect(),
            auto_forward: self.auto_forward(node),
            finalize: elements_named(node, "finalize").next().map(|finalize| self.finalize(finalize)),
            span: name_span(node).into(),
        }
    }

    fn auto_forward(&mut self, node: Element<'_>) -> bool {
        let Some(written) = Written::attribute(node, "autoforward") else {
            return false;
        };
        if !["true", "false"].contains(&written.value) {
            let problem = Problem::new(format!("`{}` is neither true nor false", written.value));
            self.problems.push(problem.at(written.span(), "not a truth").with_help("use `true` or `false`"));
        }
        written.value == "true"
    }

    fn invoke_param(&mut self, node: Element<'_>) -> Option<Param> {
        let location = Written::attribute(node, "location");
        let param = self.param(node)?;
        Some(Param { location: location.and_then(|written| self.assign_target(&written).ok()), ..param })
    }

    fn finalize(&mut self, node: Element<'_>) -> Block {
        let block = self.block(node);
        let mut misplaced = Vec::new();
        visit_actions(&block, &mut |action| {
            if matches!(action.kind, ActionKind::Raise { .. } | ActionKind::Send(_)) {
                misplaced.push(action.span);
            }
        });
        for span in misplaced {
            let problem = Problem::new("<finalize> cannot send or raise events").at(span, "not here");
            self.defer(
                problem.with_help("it copies values from a message to the data; a transition reacts to the message"),
            );
        }
        block
    }

    fn invoke_source(&mut self, node: Element<'_>) -> InvokeSource {
        let content = elements_named(node, "content").next();
        let file = self.alternative(node, "src", "srcexpr");
        match (file, content) {
            (Some(file), Some(content)) => {
                let problem = Problem::new("a machine comes either from a file or from content, not both");
                self.problems.push(problem.at(file.span, "either this").at(name_span(content), "or this"));
                InvokeSource::Broken("two sources".into())
            }
            (Some(file), None) => {
                if let (Source::Literal(address), Some(written)) = (&file.source, Written::attribute(node, "src"))
                    && let Err(reason) = self.origin.try_invoked(address)
                {
                    self.defer(Problem::new(reason).at(written.span(), "cannot be invoked"));
                }
                InvokeSource::File(file.source)
            }
            (None, Some(content)) => self.invoke_content(content),
            (None, None) => {
                let problem = Problem::new("<invoke> does not name a machine").at(name_span(node), "nothing to invoke");
                let help = "use <content> with a machine in it, or `src` with the name of a file";
                InvokeSource::Broken(self.defer(problem.with_help(help)))
            }
        }
    }

    fn invoke_content(&mut self, content: Element<'_>) -> InvokeSource {
        if let Some(written) = Written::attribute(content, "expr") {
            return InvokeSource::Computed(self.expression(&written));
        }
        match elements(content).find(|child| child.tag_name().name() == "scxml") {
            Some(machine) => {
                let (chart, forgivable) = compile::chart(machine, self.origin, self.problems);
                self.forgivable += forgivable;
                InvokeSource::Inline(Arc::new(chart))
            }
            None => {
                let text = Written::text(content).map_or("", |text| text.value);
                InvokeSource::Computed(Expr::Constant(text.into()))
            }
        }
    }

    /// The data named by `namelist`. An unreadable one is reported, and is an error when it is read.
    pub(super) fn name_list(&mut self, node: Element<'_>) -> Vec<Param> {
        let Some(written) = Written::attribute(node, "namelist") else {
            return Vec::new();
        };
        written.words().into_iter().map(|word| self.named(word)).collect()
    }

    fn named(&mut self, word: Written<'_>) -> Param {
        let (value, location) = match self.assign_target(&word) {
            Ok(AssignTarget::Compiled(location)) => (location.to_expr(), Some(AssignTarget::Compiled(location))),
            Ok(foreign) => (self.expression(&word), Some(foreign)),
            Err(reason) => (Expr::Broken(reason), None),
        };
        Param { name: word.value.into(), value, location, span: word.span().into() }
    }

    /// Compiles a location. One that cannot be compiled is reported, and `Err` describes the problem.
    pub(super) fn assign_target(&mut self, written: &Written<'_>) -> Result<AssignTarget, Arc<str>> {
        let parsed = crate::expression::location(written.value, &self.names);
        self.compiled(written, parsed, Form::Location, AssignTarget::Compiled, AssignTarget::Foreign)
    }
}
