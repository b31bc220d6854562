//! A machine's use of a quantity that it receives: the constants with which it compares it.

use std::collections::BTreeSet;
use std::sync::Arc;

use diagnostics::Problem;
use miette::SourceSpan;

use crate::chart::{Action, ActionKind, AssignTarget, Content, Send, visit_actions};
use crate::expression::{EventField, Expr, Statement, UnaryOp};
use crate::ids::DataId;
use crate::{Chart, Datum};

/// How to fix a machine that computes with a quantity.
const WAY_OUT: &str =
    "compare it with constants and continue with the result; a proof distinguishes numbers only by such comparisons";

impl Chart {
    /// The constants with which the machine compares a quantity that events carry as `_event.data.FIELD`, in no
    /// particular order. `given` are the initial values of its data that its caller sets, and `open` the data whose
    /// values the caller sets later.
    ///
    /// # Errors
    /// Everything else that the machine does with it, each at its position: it computes with it, or passes it on.
    pub fn thresholds(&self, field: &str, given: &[(&str, Datum)], open: &[&str]) -> Result<Vec<f64>, Vec<Problem>> {
        let mut following = Following {
            chart: self,
            field,
            given,
            open,
            holders: BTreeSet::new(),
            thresholds: Vec::new(),
            problems: Vec::new(),
        };
        following.find_holders();
        following.check();
        let Following { mut thresholds, mut problems, .. } = following;
        for inner in self.inner() {
            match inner.thresholds(field, &[], &[]) {
                Ok(more) => thresholds.extend(more),
                Err(more) => problems.extend(more),
            }
        }
        problems.sort_by_key(Problem::offset);
        problems.dedup_by_key(|problem| (problem.offset(), problem.to_string()));
        if problems.is_empty() { Ok(thresholds) } else { Err(problems) }
    }
}

/// The quantity on its way through a machine.
struct Following<'a> {
    chart: &'a Chart,
    field: &'a str,
    given: &'a [(&'a str, Datum)],
    open: &'a [&'a str],
    /// The data that may hold it.
    holders: BTreeSet<DataId>,
    thresholds: Vec<f64>,
    problems: Vec<Problem>,
}

impl<'a> Following<'a> {
    /// All assignments: the datum and the value.
    fn assignments(&self) -> Vec<(DataId, &'a Expr)> {
        let mut assignments = Vec::new();
        for block in self.chart.blocks() {
            visit_actions(block, &mut |action| match &action.kind {
                ActionKind::Assign(AssignTarget::Compiled(location), value) => assignments.push((location.data, value)),
                ActionKind::Script(statements) => {
                    assignments.extend(statements.iter().filter_map(|statement| match statement {
                        Statement::Assign(location, value) => Some((location.data, value)),
                        _ => None,
                    }));
                }
                _ => {}
            });
        }
        let initial = self.chart.data.iter().enumerate().map(|(index, item)| (DataId::new(index), item.init.as_ref()));
        assignments.extend(initial.filter_map(|(data, value)| Some((data, value?))));
        assignments
    }

    fn find_holders(&mut self) {
        let assignments = self.assignments();
        loop {
            let holds = |(data, value): &(DataId, &Expr)| self.carries(value).then_some(*data);
            let before = self.holders.len();
            let new: Vec<DataId> = assignments.iter().filter_map(holds).collect();
            self.holders.extend(new);
            if self.holders.len() == before {
                return;
            }
        }
    }

    /// Whether the expression is the quantity, or a datum that may hold it.
    fn is_quantity(&self, expr: &Expr) -> bool {
        match expr {
            Expr::Data(data) => self.holders.contains(data),
            Expr::Member(of, name) => matches!(**of, Expr::EventField(EventField::Data)) && **name == *self.field,
            _ => false,
        }
    }

    /// Whether the value of the expression may depend on the quantity.
    fn mentions(&self, expr: &Expr) -> bool {
        match expr {
            _ if self.is_quantity(expr) => true,
            Expr::Event | Expr::EventField(EventField::Data | EventField::Raw) => true,
            Expr::Foreign(code) => code.mentions_event || code.mentions.iter().any(|data| self.holders.contains(data)),
            Expr::Member(of, _) if matches!(**of, Expr::EventField(EventField::Data)) => false,
            _ => expr.parts().into_iter().any(|part| self.mentions(part)),
        }
    }

    /// Whether the value of the expression may be the quantity, or computed from it, and not only the result of a
    /// comparison.
    fn carries(&self, expr: &Expr) -> bool {
        match expr {
            Expr::Binary(op, _) if op.compares() => false,
            Expr::Unary(UnaryOp::Not, _) => false,
            Expr::Choice(parts) => parts[1..].iter().any(|part| self.carries(part)),
            Expr::Logic(_, parts) => parts.iter().any(|part| self.carries(part)),
            expr => self.mentions(expr),
        }
    }

    fn refuse(&mut self, place: SourceSpan, what: &str, label: &str) {
        let problem = Problem::new(format!("the machine {what}, which a proof cannot follow"));
        self.problems.push(problem.of(self.chart.file()).at(place, label).with_help(WAY_OUT));
    }

    /// Checks an expression whose value may be the quantity itself, or the result of comparisons with it.
    fn follow(&mut self, expr: &Expr, place: SourceSpan) {
        if self.is_quantity(expr) || !self.mentions(expr) {
            return;
        }
        match expr {
            Expr::Binary(op, parts) if op.compares() => {
                let [left, right] = &**parts;
                for (this, other) in [(left, right), (right, left)] {
                    if self.is_quantity(this) {
                        match self.constants(other) {
                            Some(constants) => self.thresholds.extend(constants),
                            None => self.refuse(place, "compares a number with something that is not constant", "here"),
                        }
                    } else {
                        self.follow(this, place);
                    }
                }
            }
            // Whether it is 0.
            Expr::Unary(UnaryOp::Not, part) => self.follow(part, place),
            Expr::Logic(_, parts) => parts.iter().for_each(|part| self.follow(part, place)),
            Expr::Choice(parts) => parts.iter().for_each(|part| self.follow(part, place)),
            Expr::Event | Expr::EventField(_) => self.refuse(place, "keeps an entire event with a number", "here"),
            _ => self.refuse(place, "computes with a number", "this is computed from it"),
        }
    }

    /// All numbers that the expression may be; `None` if that is not known.
    fn constants(&self, expr: &Expr) -> Option<Vec<f64>> {
        match expr {
            // A number is compared with a string or a Boolean as with the number that it converts to (7.2.13).
            Expr::Constant(constant) => {
                Some(vec![constant.to_number()].into_iter().filter(|it| !it.is_nan()).collect())
            }
            Expr::Unary(UnaryOp::Minus, part) => {
                Some(self.constants(part)?.into_iter().map(|number| -number).collect())
            }
            Expr::Data(data) => self.values_of(*data),
            _ => None,
        }
    }

    /// All numbers that a datum may hold.
    fn values_of(&self, data: DataId) -> Option<Vec<f64>> {
        let item = &self.chart.data[data.index()];
        if self.open.contains(&&*item.id) || self.chart.foreign.contains(&data) || self.is_updated(data) {
            return None;
        }
        let given = self.given.iter().find(|(id, _)| *id == &*item.id).map(|(_, value)| Expr::Constant(value.clone()));
        let initial = given.or_else(|| item.init.clone());
        let assigned = self.assignments();
        let assigned = assigned.iter().filter(|(to, value)| {
            // The initial value may be replaced by a given one.
            *to == data && !item.init.as_ref().is_some_and(|init| std::ptr::eq(init, *value))
        });
        let values = initial.iter().chain(assigned.map(|(_, value)| *value));
        let mut all = Vec::new();
        for value in values {
            match value {
                Expr::Data(_) => return None,
                value => all.extend(self.constants(value)?),
            }
        }
        Some(all)
    }

    /// Whether a script or a loop changes the datum other than by an assignment.
    fn is_updated(&self, data: DataId) -> bool {
        let mut is_updated = false;
        for block in self.chart.blocks() {
            visit_actions(block, &mut |action| {
                is_updated |= match &action.kind {
                    ActionKind::Script(statements) => statements
                        .iter()
                        .any(|statement| matches!(statement, Statement::Update(location, ..) if location.data == data)),
                    ActionKind::Foreach(foreach) => foreach.item == data || foreach.index == Some(data),
                    _ => false,
                };
            });
        }
        is_updated
    }

    /// Checks everything that the machine does.
    fn check(&mut self) {
        let chart = self.chart;
        for condition in chart.transitions.iter().filter_map(|transition| transition.condition.as_ref()) {
            self.follow(&condition.test, condition.span);
        }
        for item in &chart.data {
            if let Some(init) = &item.init {
                self.follow(init, item.span);
            }
        }
        chart.blocks().for_each(|block| visit_actions(block, &mut |action| self.check_action(action)));
        for invoke in chart.invokes() {
            for param in invoke.params.iter().chain(&invoke.name_list) {
                self.pass_on(&param.value, invoke.span);
            }
        }
        for (payload, span) in chart.states.iter().map(|state| (&state.done_data, state.span)) {
            payload.params.iter().for_each(|param| self.pass_on(&param.value, param.span));
            if let Some(Content::Computed(value, _)) = &payload.content {
                self.pass_on(value, span);
            }
        }
    }

    fn check_action(&mut self, action: &Action) {
        let span = action.span;
        match &action.kind {
            ActionKind::Assign(AssignTarget::Compiled(_), value) => self.follow(value, span),
            ActionKind::Assign(AssignTarget::Foreign(_), value) => self.keep_out(value, span),
            ActionKind::If(branches) => {
                for condition in branches.iter().filter_map(|branch| branch.condition.as_ref()) {
                    self.follow(&condition.test, condition.span);
                }
            }
            ActionKind::Foreach(foreach) => self.keep_out(&foreach.array, span),
            ActionKind::Script(statements) => statements.iter().for_each(|statement| match statement {
                Statement::Assign(_, value) | Statement::Evaluate(value) => self.follow(value, span),
                Statement::Update(location, _, value) => {
                    self.keep_out(value, span);
                    self.keep_out(&location.to_expr(), span);
                }
            }),
            ActionKind::Foreign(code) => self.keep_out(&Expr::Foreign(Arc::clone(code)), span),
            ActionKind::Send(send) => self.check_send(send),
            // Logged values are only reported.
            ActionKind::Log { .. } | ActionKind::Raise { .. } | ActionKind::Cancel(_) | ActionKind::Fail(_) => {}
        }
    }

    fn check_send(&mut self, send: &Send) {
        for (_, value, place) in send.named() {
            self.pass_on(value, place);
        }
        if let Some(Content::Computed(value, place)) = &send.payload.content {
            self.pass_on(value, *place);
        }
    }

    fn pass_on(&mut self, value: &Expr, place: SourceSpan) {
        if self.carries(value) {
            self.refuse(place, "passes a number on", "this is sent");
        } else {
            self.follow(value, place);
        }
    }

    fn keep_out(&mut self, value: &Expr, place: SourceSpan) {
        if self.carries(value) {
            self.refuse(place, "computes with a number", "this is computed from it");
        } else {
            self.follow(value, place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn thresholds(data: &str, body: &str) -> Result<Vec<f64>, Vec<String>> {
        let text = format!(
            r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript" name="m">
            <datamodel>{data}</datamodel><state id="s">{body}</state></scxml>"#
        );
        let chart = Chart::load("m.scxml", &text).expect("a sound machine");
        let found = chart.thresholds("level", &[("given", 40.0.into())], &["open"]);
        found.map_err(|problems| problems.iter().map(|problem| problem.message().to_owned()).collect())
    }

    #[test]
    fn a_level_is_compared_with_literals_and_data() {
        let data = r#"<data id="low" expr="30"/><data id="given" expr="1"/><data id="kept" expr="-1"/>"#;
        let body = r#"<transition event="a" cond="_event.data.level &gt; low &amp;&amp; !(12.5 &gt;= _event.data.level)">
                <assign location="kept" expr="_event.data.level"/><log expr="'level ' + _event.data.level"/></transition>
            <transition cond="kept &lt; given"><assign location="low" expr="25"/></transition>"#;
        let mut found = thresholds(data, body).expect("nothing but comparisons");
        found.sort_by(f64::total_cmp);
        assert_eq!(found, [12.5, 25.0, 30.0, 40.0]);
    }

    #[test]
    fn a_string_or_a_boolean_is_compared_as_the_number_that_it_converts_to() {
        let body = r#"<transition event="a" cond="_event.data.level == '20' || _event.data.level &lt; true"/>
            <transition event="b" cond="_event.data.level &gt; null || _event.data.level == 'full'"/>"#;
        assert_eq!(thresholds("", body).expect("nothing but comparisons"), [20.0, 1.0, 0.0]);
    }

    #[test]
    fn anything_more_than_a_comparison_is_refused_with_its_location() {
        let refused = |data: &str, body: &str| thresholds(data, body).expect_err(body).join("; ");
        let sum = refused("", r#"<transition event="a" cond="_event.data.level + 1 &gt; 30"/>"#);
        assert_eq!(sum, "the machine computes with a number, which a proof cannot follow");
        let open =
            refused(r#"<data id="open" expr="1"/>"#, r#"<transition event="a" cond="_event.data.level &gt; open"/>"#);
        assert!(open.contains("compares a number with something that is not constant"), "{open}");
        let sent = r#"<transition event="a"><send type="channel" target="X" event="e">
            <param name="p" expr="_event.data.level"/></send></transition>"#;
        assert!(refused("", sent).contains("passes a number on"));
        let data = r#"<data id="sum" expr="0"/>"#;
        let script = r#"<transition event="a"><script>sum += _event.data.level</script></transition>"#;
        assert!(refused(data, script).contains("computes with a number"));
    }

    #[test]
    fn the_shipped_condition_has_one_threshold() {
        let text = crate::shipped("BatteryLevel").expect("it is shipped");
        let chart = Chart::load("BatteryLevel.scxml", text).expect("a sound machine");
        assert_eq!(chart.thresholds("level", &[], &[]).expect("a comparison"), [30.0]);
    }
}
