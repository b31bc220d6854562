//! Checks whether a machine fits its channels, before anything runs.

use std::collections::BTreeSet;
use std::sync::Arc;

use channels::{Domain, FieldKind, Message, Shape, Topology};
use diagnostics::{Problem, did_you_mean, nearest_or_all};
use miette::SourceSpan;

use super::CLIENT;
use super::wiring::{Incoming, Outgoing, Wiring, has_channel, heads, message, shapes_of, takes};
use crate::Datum;
use crate::chart::{
    ActionKind, AssignTarget, Attribute, Chart, Descriptor, EventClass, Send, SendId, is_event_name, visit_actions,
};
use crate::datum::Memory;
use crate::expression::{Expr, Scope, Statement};
use crate::ids::DataId;
use crate::load::can_be_done;
use crate::machine::Machine;

/// Everything that does not fit.
pub(super) fn problems(machine: &Machine, wiring: &Wiring, topology: &Topology) -> Vec<Problem> {
    let chart = machine.chart();
    let constants = Constants::of(machine, wiring);
    let mut check = Check { wiring, topology, constants, missed: Vec::new(), problems: Vec::new() };
    chart.visit_sends(&mut |send| check.send(send));
    check.events(chart);
    check.problems.sort_by_key(Problem::offset);
    check.problems
}

/// Data that never change while the machine runs, and their values.
pub(super) struct Constants<'a> {
    chart: &'a Chart,
    values: Memory,
    changed: BTreeSet<DataId>,
}

impl<'a> Constants<'a> {
    pub(super) fn of(machine: &'a Machine, wiring: &Wiring) -> Self {
        let chart = machine.chart();
        let mut changed = chart.foreign.clone();
        changed.extend(wiring.inputs().filter_map(|port| chart.find_parameter(port)));
        for block in chart.blocks() {
            visit_actions(block, &mut |action| changed.extend(changed_by(&action.kind)));
        }
        Self { chart, values: machine.first_values(), changed }
    }

    /// The value of an expression, if it never changes.
    pub(super) fn value(&self, expr: &Expr) -> Option<Datum> {
        let is_fixed = |id: DataId| !self.changed.contains(&id) && self.chart.data[id.index()].top_level;
        let scope = Scope { ids: Some(&self.chart.ids), data: &self.values, ..Scope::default() };
        if expr.is_fixed(&is_fixed) { expr.evaluate(&scope).ok() } else { None }
    }

    /// The message of a `<send>`, if it is always the same.
    pub(super) fn message(&self, head: &str, send: &Send, out: &Outgoing) -> Option<Message> {
        let field = |(name, value, _): (&Arc<str>, &Expr, SourceSpan)| Some((Arc::clone(name), self.value(value)?));
        let fields: Vec<(Arc<str>, Datum)> = send.named().map(field).collect::<Option<_>>()?;
        message(&out.domain, head, &Datum::object(fields).ok()?).ok().map(|(message, _)| message)
    }
}

fn changed_by(action: &ActionKind) -> Vec<DataId> {
    match action {
        ActionKind::Assign(AssignTarget::Compiled(location), _) => vec![location.data],
        ActionKind::Foreach(foreach) => std::iter::once(foreach.item).chain(foreach.index).collect(),
        ActionKind::Script(statements) => {
            let changed = |statement: &Statement| match statement {
                Statement::Assign(location, _) | Statement::Update(location, ..) => Some(location.data),
                Statement::Evaluate(_) => None,
            };
            statements.iter().filter_map(changed).collect()
        }
        ActionKind::Send(send) => match &send.id {
            SendId::Generated(AssignTarget::Compiled(location)) => vec![location.data],
            _ => Vec::new(),
        },
        _ => Vec::new(),
    }
}

struct Check<'a> {
    wiring: &'a Wiring,
    topology: &'a Topology,
    constants: Constants<'a>,
    /// Unknown processes to which the machine sends: the answers of the intended processes then have no channel.
    missed: Vec<&'a str>,
    problems: Vec<Problem>,
}

impl<'a> Check<'a> {
    fn send(&mut self, send: &'a Send) {
        if !send.goes_by_channel() {
            return;
        }
        let domain = match &send.target {
            None => Some(&self.wiring.topics),
            Some(target) => match target.literal() {
                Some(peer) => self.target(peer, target.span).map(|out| &out.domain),
                None => return self.computed(send),
            },
        };
        if let Some(domain) = domain
            && let Some(event) = &send.event
            && let Some(head) = self.head(event, send.target.as_ref(), domain)
        {
            self.fields(send, domain, head);
            self.values(send, domain, head);
        }
    }

    /// Reports a message with a computed target that no channel carries.
    fn computed(&mut self, send: &Send) {
        let Some(event) = &send.event else { return };
        let Some(head) = event.literal() else { return };
        let outgoing = &self.wiring.outgoing;
        let carries = |domain: &Domain| shapes_of(domain, head).next().is_some();
        // A component without clients answers no requests, and may have answers that no process requests.
        if !outgoing.is_empty() && !outgoing.iter().any(|out| carries(&out.domain)) && !carries(&self.wiring.answers) {
            let known: Vec<&str> = outgoing.iter().flat_map(|out| heads(&out.domain)).collect();
            let problem = Problem::new(format!("no channel from {} carries <{head}>", self.wiring.name));
            let help = nearest_or_all(head, "messages", &known);
            self.problems.push(problem.at(event.span, "unknown message").with_help(help));
        }
    }

    /// The channel of a message; `None` if it has been reported to be missing.
    fn target(&mut self, peer: &'a str, span: SourceSpan) -> Option<&'a Outgoing> {
        if let Some(out) = self.wiring.outgoing_to(peer) {
            return Some(&self.wiring.outgoing[out]);
        }
        let reached: Vec<&str> = self.wiring.outgoing.iter().map(|out| &*out.peer).collect();
        let problem = if self.topology.find_process(peer).is_some() {
            let problem = Problem::new(format!("there is no channel {} → {peer}", self.wiring.name));
            problem.with_help(nearest_or_all(peer, "possible targets", &reached))
        } else {
            self.missed.push(peer);
            let processes: Vec<&str> = self.topology.processes().map(|process| self.topology.name(process)).collect();
            let near = did_you_mean(peer, processes);
            let help = near.unwrap_or_else(|| {
                let known = nearest_or_all(peer, "possible targets", &self.reachable());
                format!("{known}; the scenario determines which components there are")
            });
            Problem::new(format!("there is no process {peer}")).with_help(help)
        };
        self.problems.push(problem.at(span, "cannot be reached"));
        None
    }

    /// The processes to which a skill may send: those with a channel from it, and the components, which the tree does
    /// not use.
    fn reachable(&self) -> Vec<&'a str> {
        let topology = self.topology;
        let client = topology.find_process(CLIENT);
        let is_component = |process| {
            client.is_none_or(|client| {
                let is_linked = has_channel(topology, process, client) || has_channel(topology, client, process);
                process != client && !is_linked
            })
        };
        let processes = topology.processes().filter(|process| topology.whole(*process) == *process);
        let names = processes.filter(|process| {
            let name = topology.name(*process);
            name != &*self.wiring.name && (self.wiring.outgoing_to(name).is_some() || is_component(*process))
        });
        names.map(|process| topology.name(process)).collect()
    }

    /// The first symbol of a message; `None` if it is computed, or has been reported to be invalid.
    fn head<'e>(&mut self, event: &'e Attribute, target: Option<&Attribute>, domain: &Domain) -> Option<&'e str> {
        let head = event.literal()?;
        if shapes_of(domain, head).next().is_none() {
            let name = &self.wiring.name;
            let (message, what, none) = match target.and_then(Attribute::literal) {
                Some(peer) => (
                    format!("the channel {name} → {peer} carries no <{head}>"),
                    "its messages",
                    format!("{peer} cannot be asked anything: its `interface` has what it can be asked"),
                ),
                None => (
                    format!("{name} does not publish <{head}>, and the message has no target"),
                    "its topics",
                    format!("{name} publishes nothing: its `interface` has what it publishes"),
                ),
            };
            let known = heads(domain);
            let help = if known.is_empty() { none } else { nearest_or_all(head, what, &known) };
            self.problems.push(Problem::new(message).at(event.span, "unknown message").with_help(help));
            return None;
        }
        Some(head)
    }

    /// Reports parameters that are not fields, and fields without a parameter.
    fn fields(&mut self, send: &Send, out: &Domain, head: &str) {
        let help = carried(out, head);
        let given: Vec<(&str, SourceSpan)> = send.named().map(|(name, _, span)| (&**name, span)).collect();
        for (name, span) in &given {
            if !fields(out, head).any(|(field, _)| field == name) {
                let problem = Problem::new(format!("<{head}> has no field `{name}`")).at(*span, "unknown field");
                self.problems.push(problem.with_help(&*help));
            }
        }
        let is_missing = |(name, kind): &&(String, FieldKind)| {
            !matches!(kind, FieldKind::Optional(_)) && !given.iter().any(|(given, _)| given == name)
        };
        let is_complete = |shape: &Shape| !shape.fields().iter().skip(1).any(|field| is_missing(&field));
        if !shapes_of(out, head).any(is_complete)
            && let Some((field, _)) = fields(out, head).find(is_missing)
        {
            let problem = Problem::new(format!("<{head}> lacks the field `{field}`")).at(send.span, "incomplete");
            self.problems.push(problem.with_help(format!("<param name=\"{field}\" expr=\"…\"/>; {help}")));
        }
    }

    /// Reports data that can never have the kind of their field.
    fn values(&mut self, send: &Send, out: &Domain, head: &str) {
        for (name, value, span) in
            send.named().filter(|(name, ..)| fields(out, head).any(|(field, _)| **field == ***name))
        {
            if let Some(value) = self.constants.value(value)
                && !takes(out, head, name, &value)
            {
                let problem = Problem::new(format!("the field `{name}` of <{head}> cannot be {value}"));
                self.problems.push(problem.at(span, "always this value").with_help(carried(out, head)));
            }
        }
    }

    /// Whether this process would answer if its name were not misspelled in a request.
    fn is_missed(&self, peer: &str) -> bool {
        let is_linked = self.wiring.incoming.iter().any(|incoming| &*incoming.peer == peer);
        let is_meant = |missed: &&str| did_you_mean(missed, [peer]).is_some();
        !is_linked && self.topology.find_process(peer).is_some() && self.missed.iter().any(is_meant)
    }

    /// Reports transitions whose events never occur: no process sends them, and the machine does not generate them.
    fn events(&mut self, chart: &Chart) {
        let Some(mut names) = own_events(chart) else {
            return;
        };
        names.extend(self.wiring.incoming.iter().flat_map(Incoming::event_names).map(str::to_owned));
        // A component may be made for more clients than those of one system.
        let understood = heads(&self.wiring.understood);
        let classes: BTreeSet<EventClass> =
            names.iter().map(String::as_str).chain(understood).map(|name| chart.events.class(name)).collect();
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let transitions = chart.transitions().map(|transition| chart.transition(transition));
        let never_comes = |descriptor: &&Descriptor| !descriptor.matches.meets(&classes);
        for descriptor in transitions.flat_map(|transition| &transition.descriptors).filter(never_comes) {
            let text = &*descriptor.text;
            let first = text.split('.').next().unwrap_or_default();
            if self.is_missed(first) {
                continue;
            }
            let message = match self.topology.find_process(first) {
                Some(_) => format!("no message from {first} to {} becomes the event `{text}`", self.wiring.name),
                None => format!("the event `{text}` never occurs"),
            };
            let problem = Problem::new(message).at(descriptor.span, "no process sends it");
            self.problems.push(problem.with_help(nearest_or_all(text, "possible events", &known)));
        }
    }
}

/// The fields of messages that begin with this symbol, after it.
pub(super) fn fields<'a>(out: &'a Domain, head: &'a str) -> impl Iterator<Item = &'a (String, FieldKind)> {
    shapes_of(out, head).flat_map(|shape| shape.fields().get(1..).unwrap_or_default())
}

fn carried(out: &Domain, head: &str) -> String {
    let shapes: Vec<String> = shapes_of(out, head).map(Shape::to_string).collect();
    format!("the channel carries {}", shapes.join(" or "))
}

/// The events that the machine generates itself; `None` if it computes their names, or if they come from machines that
/// it invokes.
pub(super) fn own_events(chart: &Chart) -> Option<BTreeSet<String>> {
    let mut names: BTreeSet<String> = ["error.execution", "error.communication"].map(str::to_owned).into();
    let done = chart.states().filter(|state| can_be_done(chart, *state));
    names.extend(done.map(|state| format!("done.state.{}", chart.state(state).id())));
    let mut is_known = chart.invokes().next().is_none();
    for block in chart.blocks() {
        visit_actions(block, &mut |action| match &action.kind {
            ActionKind::Raise { event, .. } => {
                names.insert(event.to_string());
            }
            ActionKind::Send(send) if !send.goes_by_channel() => {
                match send.event.as_ref().map(|event| event.literal()) {
                    Some(Some(event)) if is_event_name(event) => {
                        names.insert(event.to_string());
                    }
                    Some(None) => is_known = false,
                    _ => {}
                }
            }
            _ => {}
        });
    }
    is_known.then_some(names)
}
