//! Properties of every machine, every event and every text.

use std::fmt::Write;
use std::time::Duration;

use proptest::prelude::*;
use proptest::sample::Index;
use skills::{Chart, Event, Machine, SHIPPED, StateKind, Status, Strictness, Transcript};

use crate::appendix_d::Interpreter;
use crate::stage::file;

#[derive(Clone, Debug)]
enum Shape {
    State,
    Final,
    Compound(Vec<Shape>, Option<bool>),
    Parallel(Vec<Shape>, Option<bool>),
}

fn shape() -> impl Strategy<Value = Shape> {
    let leaf = prop_oneof![4 => Just(Shape::State), 1 => Just(Shape::Final)];
    leaf.prop_recursive(4, 20, 4, |inner| {
        let regions =
            inner.clone().prop_filter("a region is not a final state", |shape| !matches!(shape, Shape::Final));
        let history = || prop::option::of(any::<bool>());
        prop_oneof![
            (prop::collection::vec(inner, 1..4), history())
                .prop_map(|(children, deep)| Shape::Compound(children, deep)),
            (prop::collection::vec(regions, 1..4), history())
                .prop_map(|(children, deep)| Shape::Parallel(children, deep)),
        ]
    })
}

#[derive(Clone, Debug)]
struct Arrow {
    source: Index,
    target: Option<Index>,
    event: u8,
    internal: bool,
}

fn arrow() -> impl Strategy<Value = Arrow> {
    (any::<Index>(), prop::option::weighted(0.9, any::<Index>()), 0..9_u8, any::<bool>())
        .prop_map(|(source, target, event, internal)| Arrow { source, target, event, internal })
}

/// Writes machines: states are named in document order, history states after their parents.
#[derive(Default)]
struct Writer {
    sources: Vec<String>,
    targets: Vec<String>,
    arrows: Vec<(String, String)>,
    next: usize,
}

impl Writer {
    fn names(&mut self, shape: &Shape) {
        let id = format!("s{}", self.next);
        self.next += 1;
        self.targets.push(id.clone());
        match shape {
            Shape::Final => return,
            Shape::State => {}
            Shape::Compound(children, history) | Shape::Parallel(children, history) => {
                if history.is_some() {
                    self.targets.push(format!("h{id}"));
                }
                self.sources.push(id);
                return children.iter().for_each(|child| self.names(child));
            }
        }
        self.sources.push(id);
    }

    fn arrow(&mut self, arrow: &Arrow) {
        let source = self.sources[arrow.source.index(self.sources.len())].clone();
        let target = arrow.target.map(|target| self.targets[target.index(self.targets.len())].clone());
        let event = match (arrow.event, &target) {
            (0..=5, _) => format!("event='e{}'", arrow.event % 3),
            (6, Some(target)) if target.starts_with('s') => format!("cond=\"!In('{target}')\""),
            (7, _) => "event='done'".to_owned(),
            _ => format!("event='done.state.{source}'"),
        };
        let kind = if arrow.internal { "type='internal'" } else { "" };
        let to = target.as_ref().map_or(String::new(), |target| format!("target='{target}'"));
        let log = format!("<log expr=\"'{source}>{}'\"/>", target.unwrap_or_default());
        self.arrows.push((source, format!("<transition {event} {to} {kind}>{log}</transition>")));
    }

    fn state(&mut self, shape: &Shape) -> String {
        let id = format!("s{}", self.next);
        self.next += 1;
        let mut inside = format!("<onentry><log expr=\"'+{id}'\"/></onentry><onexit><log expr=\"'-{id}'\"/></onexit>");
        for (_, arrow) in self.arrows.iter().filter(|(source, _)| *source == id) {
            inside += arrow;
        }
        let (tag, children, history) = match shape {
            Shape::State => ("state", &[][..], None),
            Shape::Final => ("final", &[][..], None),
            Shape::Compound(children, history) => ("state", &children[..], *history),
            Shape::Parallel(children, history) => ("parallel", &children[..], *history),
        };
        if let Some(deep) = history {
            let kind = if deep { "deep" } else { "shallow" };
            let default = self.next;
            write!(inside, "<history id='h{id}' type='{kind}'><transition target='s{default}'/></history>").unwrap();
        }
        for child in children {
            inside += &self.state(child);
        }
        format!("<{tag} id='{id}'>{inside}</{tag}>")
    }
}

pub(crate) fn machine_text() -> impl Strategy<Value = String> {
    (prop::collection::vec(shape(), 1..4), prop::collection::vec(arrow(), 0..16)).prop_map(|(shapes, arrows)| {
        let mut writer = Writer::default();
        shapes.iter().for_each(|shape| writer.names(shape));
        if !writer.sources.is_empty() {
            arrows.iter().for_each(|arrow| writer.arrow(arrow));
        }
        writer.next = 0;
        let states: String = shapes.iter().map(|shape| writer.state(shape)).collect();
        file("", &states)
    })
}

/// Exactly one child of an active compound state is active, all children of an active parallel one, and every active
/// state has an active parent.
fn is_legal(machine: &Machine) -> bool {
    let chart = machine.chart();
    let is_active = |state| state == chart.root() || machine.configuration().any(|active| active == state);
    std::iter::once(chart.root()).chain(machine.configuration()).all(|id| {
        let state = chart.state(id);
        let active = state.children().iter().filter(|child| is_active(**child)).count();
        let children_fit = match state.kind() {
            StateKind::Compound => active == 1,
            StateKind::Parallel => active == state.children().len(),
            StateKind::Atomic | StateKind::Final => true,
            StateKind::History(_) => false,
        };
        children_fit && state.parent().is_none_or(is_active)
    })
}

proptest! {
    #[test]
    fn the_machine_follows_appendix_d(text in machine_text(), events in prop::collection::vec(0..3_u8, 0..12)) {
        let chart = Chart::load("random.scxml", &text).unwrap_or_else(|error| panic!("{text}\n{:?}", miette::Report::new(error)));
        let mut machine = Machine::new(chart.clone());
        let mut host = Transcript::default();
        machine.start(Duration::ZERO, &mut host);
        let mut oracle = Interpreter::start(&chart);
        for event in std::iter::once(None).chain(events.into_iter().map(Some)) {
            if let Some(event) = event.map(|event| format!("e{event}.more")) {
                machine.handle(Event::external(event.as_str()), Duration::ZERO, &mut host);
                oracle.handle(&event);
            }
            let log: Vec<String> = host.log_lines().collect();
            if oracle.is_stuck() || machine.status() == Status::Stuck {
                prop_assert!(oracle.is_stuck() && machine.status() == Status::Stuck);
                break;
            }
            prop_assert_eq!(&log, &oracle.trace, "{}", text);
            prop_assert_eq!(machine.active_ids().collect::<Vec<_>>(), oracle.active());
            prop_assert_eq!(machine.status() == Status::Done, !oracle.running);
            prop_assert!(is_legal(&machine), "{} {}", text, machine.active_ids().collect::<Vec<_>>().join(" "));
        }
    }

    #[test]
    fn equal_machines_behave_equally(text in machine_text(), events in prop::collection::vec(0..3_u8, 0..8), fork in 0..8_usize) {
        let mut machine = Machine::new(Chart::load("random.scxml", &text).unwrap());
        let mut host = Transcript::default();
        machine.start(Duration::ZERO, &mut host);
        let mut copy = None;
        for (index, event) in events.iter().enumerate() {
            if index == fork {
                copy = Some(machine.clone());
            }
            let event = Event::external(format!("e{event}"));
            machine.handle(event.clone(), Duration::ZERO, &mut host);
            if let Some(copy) = &mut copy {
                copy.handle(event, Duration::ZERO, &mut Transcript::default());
                prop_assert_eq!(&*copy, &machine);
            }
        }
    }

    #[test]
    fn no_text_crashes_the_loader(text in "\\PC{0,200}") {
        let _ = Chart::load("x", &text);
        let _ = Chart::load("x", &file("", &text));
    }

    #[test]
    fn no_expression_crashes_the_loader_or_the_machine(
        words in prop::collection::vec(prop::sample::select(WORDS.to_vec()), 0..14),
        wild in "\\PC{0,30}",
    ) {
        for expression in [words.concat(), words.join(" "), wild] {
            let escaped = expression.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
            let text = file("", &format!(
                "<datamodel><data id='x' expr='[1, {{a: 2}}]'/><data id='y' expr=\"{escaped}\"/></datamodel>
                 <state id='a'><onentry><script>{escaped}</script></onentry><onentry><assign location=\"{escaped}\" expr='1'/>
                 </onentry><transition cond=\"{escaped}\" target='b'/></state><state id='b'/>"
            ));
            if let Ok(chart) = Chart::load_with("x", &text, Strictness::Standard) {
                let mut machine = Machine::new(chart);
                machine.start(Duration::ZERO, &mut Transcript::default());
            }
        }
    }

    #[test]
    fn no_damage_to_a_file_causes_a_crash(
        which in 0..SHIPPED.len(),
        damage in prop::collection::vec((any::<Index>(), 0..4_u8, any::<Index>()), 1..6),
        events in prop::collection::vec(any::<Index>(), 0..10),
    ) {
        let mut text: Vec<char> = SHIPPED[which].1.chars().collect();
        for (place, how, other) in damage {
            let (place, other) = (place.index(text.len()), other.index(text.len()));
            match how {
                0 => drop(text.remove(place)),
                1 => text.insert(place, text[other]),
                2 => text[place] = text[other],
                _ => text.swap(place, other),
            }
        }
        let text: String = text.into_iter().collect();
        for strictness in [Strictness::Strict, Strictness::Standard] {
            if let Ok(chart) = Chart::load_with("x", &text, strictness) {
                let mut machine = Machine::new(chart);
                let mut host = Transcript::default();
                machine.start(Duration::ZERO, &mut host);
                for (second, event) in events.iter().enumerate() {
                    let name = ["BT.tick", "BT.halt", "Navigation.ok", "BatteryReader.ok", "error"][event.index(5)];
                    machine.handle(Event::external(name), Duration::from_secs(second as u64), &mut host);
                    machine.fire_timers(Duration::from_secs(second as u64 + 1), &mut host);
                }
            }
        }
    }
}

const WORDS: [&str; 40] = [
    "x",
    "y",
    "1",
    "0.5",
    "'a'",
    "\"b\"",
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ":",
    ",",
    "?",
    ".",
    "+",
    "-",
    "*",
    "/",
    "%",
    "==",
    "===",
    "!=",
    "<",
    ">=",
    "&&",
    "||",
    "!",
    "~",
    "typeof ",
    "_event",
    "data",
    "In('a')",
    "null",
    "undefined",
    "length",
    "=",
    "++",
    ";",
];

#[test]
fn expressions_of_any_depth_and_length_are_refused_or_evaluated() {
    for (open, middle, close) in [
        ("(", "1", ")"),
        ("[", "1", "]"),
        ("!", "1", ""),
        ("-", "1", ""),
        ("{a:", "1", "}"),
        ("1+", "1", ""),
        ("x.", "x", ""),
        ("1?1:", "1", ""),
    ] {
        for depth in [10, 100, 1_000, 100_000] {
            let expression = format!("{}{middle}{}", open.repeat(depth), close.repeat(depth));
            let text = file(
                "",
                &format!(
                    "<datamodel><data id='x'/></datamodel><state id='a'><transition cond=\"{expression}\"/></state>"
                ),
            );
            let _ = Chart::load_with("x", &text, Strictness::Standard).map(|chart| {
                Machine::new(chart).start(Duration::ZERO, &mut Transcript::default());
            });
        }
    }
}
