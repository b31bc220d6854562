//! What a source delivers is written so that it can be read again with the same events.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs;
use std::rc::Rc;

use bags::{
    Account, Bag, BagWriter, Definition, Events, Found, Ground, Head, Received, Recorder, Source, Survey, Topic,
};
use proptest::prelude::*;

use crate::messages::{TF, TWIST, tf, twist};
use crate::reading::{line, mapping, nothing};

/// A step of a source that is made up.
#[derive(Clone, Debug)]
enum Step {
    /// A message on the topic with this index, so many milliseconds later.
    Message(usize, i64),
    /// One that is cut off.
    Wrong(i64),
    ClockAdvanced(i64),
    Idle,
    /// Something is lost, with the next step or at once.
    Lost(i64),
    Broken,
    /// So many messages on the topic with this index are missing, or an unknown number.
    Missing(usize, Option<u64>),
    /// From now on, none is.
    Resumed(usize),
    /// The last one was so many milliseconds late.
    Late(usize, i64),
    Noted,
    /// The messages on the topic with this index are numbered from the start, or not.
    Vouched(usize, bool),
}

/// A source that is made up: it does these steps, and then is over.
struct MadeUp {
    steps: std::vec::IntoIter<Step>,
    counts_losses: bool,
    is_losing: bool,
    now_ns: i64,
    survey: Survey,
    lost: Vec<String>,
    notes: Vec<String>,
}

impl MadeUp {
    fn new(steps: Vec<Step>, counts_losses: bool) -> Self {
        let mut survey = Survey::default();
        survey.add(topic(0));
        let start_ns = 1_700_000_000_000_000_000;
        Self {
            steps: steps.into_iter(),
            counts_losses,
            is_losing: false,
            now_ns: start_ns,
            survey,
            lost: Vec::new(),
            notes: Vec::new(),
        }
    }
}

/// Only the first topic is known from the start.
fn topic(index: usize) -> Topic {
    let (kind, text) = [TWIST, TF][index];
    let (kind, text) = (kind.to_owned(), text.to_owned());
    let definition = Some(Definition { language: "ros2msg".to_owned(), text });
    Topic { name: ["/a", "/b"][index].to_owned(), kind, encoding: "cdr".to_owned(), definition, hash: None }
}

impl Source for MadeUp {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        if std::mem::take(&mut self.is_losing) {
            self.lost.push(format!("loss {}", self.lost.len()));
        }
        match self.steps.next() {
            None => Received::Over,
            Some(Step::Idle) => Received::Idle,
            Some(Step::Noted) => {
                self.notes.push(format!("note {}", self.notes.len()));
                Received::Idle
            }
            Some(Step::Vouched(index, is_numbered)) => {
                let topic = self.survey.add(topic(index));
                let ground = if is_numbered { Ground::Numbered } else { Ground::Assumed("all arrive".to_owned()) };
                self.survey.vouch(topic, ground);
                Received::Idle
            }
            Some(Step::Missing(index, count)) => {
                let topic = self.survey.add(topic(index));
                Received::Lost { topic, count, since_ns: self.now_ns - 300_000_000 }
            }
            Some(Step::Late(index, ms)) => {
                let topic = self.survey.add(topic(index));
                Received::Late { topic, since_ns: self.now_ns - ms * 1_000_000 }
            }
            Some(Step::Resumed(index)) => {
                let topic = self.survey.add(topic(index));
                Received::Resumed { topic, at_ns: self.now_ns }
            }
            Some(Step::Broken) => {
                self.lost.push(format!("loss {}", self.lost.len()));
                Received::Idle
            }
            Some(Step::Message(index, ms)) => {
                self.now_ns += ms * 1_000_000;
                let topic = self.survey.add(topic(index));
                self.survey.count(topic, self.now_ns);
                // Some have no items.
                *body = if index == 0 { twist(self.now_ns as f64) } else { tf(ms % 3) };
                Received::Message(Head { topic, log_ns: self.now_ns, publish_ns: self.now_ns - 1000 })
            }
            Some(Step::Wrong(ms)) => {
                self.now_ns += ms * 1_000_000;
                *body = twist(0.5)[..9].to_vec();
                self.survey.count(0, self.now_ns);
                Received::Message(Head { topic: 0, log_ns: self.now_ns, publish_ns: self.now_ns })
            }
            Some(Step::ClockAdvanced(ms)) => {
                self.now_ns += ms * 1_000_000;
                Received::ClockAdvanced(self.now_ns)
            }
            Some(Step::Lost(ms)) => {
                self.now_ns += ms * 1_000_000;
                self.is_losing = true;
                Received::ClockAdvanced(self.now_ns)
            }
        }
    }

    fn account(&self) -> Account<'_> {
        let Self { survey, lost, notes, .. } = self;
        Account { survey, lost, notes, counts_losses: self.counts_losses }
    }
}

/// A source that is notified when it is over, as a robot is that is no longer watched.
struct Told<S>(S);

impl<S: Source> Source for Told<S> {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        let received = self.0.receive(body);
        if received == Received::Over {
            self.0.end();
        }
        received
    }

    fn account(&self) -> Account<'_> {
        Account { counts_losses: false, ..self.0.account() }
    }
}

fn events(source: Box<dyn Source>, survey: &Survey, text: &str) -> Vec<String> {
    let mapping = mapping(text);
    let compiled = mapping.compile(survey, None, &nothing).unwrap_or_else(|problems| panic!("{}", problems.plain()));
    let topology = compiled.topology.clone();
    let mut events = Events::new(source, &mapping, compiled, &nothing);
    // Neither a note nor a ground has a place among the events; the last ground of a channel counts.
    let (mut lines, mut grounds, mut ends, mut first) = (Vec::new(), BTreeMap::new(), BTreeMap::new(), None);
    for found in events.by_ref() {
        let place = match &found {
            Found::Idle | Found::Noted(_) | Found::Ended(_) => continue,
            Found::Vouched(channel, ground) => {
                grounds.insert(*channel, ground.clone());
                continue;
            }
            Found::LeftOut(gap) if gap.ends => (gap.channel, ends.get(&gap.channel).copied().unwrap_or(0), true),
            Found::LeftOut(gap) => (gap.channel, 0, true),
            Found::Resumed(channel) => {
                let ends = ends.entry(Some(*channel)).or_insert(0);
                *ends += 1;
                (Some(*channel), *ends, false)
            }
            Found::Event(_) => {
                first.get_or_insert(lines.len());
                (None, 0, true)
            }
        };
        lines.push((place, line(found, &topology)));
    }
    // Before the first event, a recording has no time: a gap has an order only with the end of its channel's gaps.
    let first = first.unwrap_or(lines.len());
    lines[..first].sort();
    let mut lines: Vec<String> = lines.into_iter().map(|(_, line)| line).collect();
    lines.extend(events.notes());
    lines.extend(grounds.into_iter().map(|(channel, ground)| line(Found::Vouched(channel, ground), &topology)));
    lines
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        4 => (0..2_usize, 0..700_i64).prop_map(|(topic, ms)| Step::Message(topic, ms)),
        2 => (0..2500_i64).prop_map(Step::ClockAdvanced),
        1 => Just(Step::Idle),
        1 => (0..2_usize, any::<bool>()).prop_map(|(topic, is_numbered)| Step::Vouched(topic, is_numbered)),
        1 => (0..3000_i64).prop_map(Step::Wrong),
        1 => (0..300_i64).prop_map(Step::Lost),
        1 => Just(Step::Broken),
        2 => (0..2_usize, prop::option::of(1..5_u64)).prop_map(|(topic, count)| Step::Missing(topic, count)),
        1 => (0..2_usize).prop_map(Step::Resumed),
        1 => (0..2_usize, 0..900_i64).prop_map(|(topic, ms)| Step::Late(topic, ms)),
        1 => Just(Step::Noted),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn a_recording_has_the_same_events_and_gaps(
        steps in prop::collection::vec(step(), 0..40),
        reorder_s in prop::sample::select(vec!["0", "0.1", "1"]),
        times in prop::sample::select(vec!["log", "publish"]),
        counts_losses in any::<bool>(),
    ) {
        let text = format!(
            "tick_s = 0.25\nreorder_s = {reorder_s}\ntime = \"{times}\"\n[[messages]]\ntopic = \"/a\"\nfrom = \"a\"\n\
             to = \"m\"\nfields = {{ x = \"linear.x\" }}\n[[messages]]\ntopic = \"/b\"\ntype = \"tf2_msgs/msg/TFMessage\"\n\
             from = \"b\"\nto = \"m\"\neach = \"transforms\"\nfields = {{ x = \"transform.translation.x\" }}\n"
        );
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        let (file, source) = (fs::File::create(&path).expect("a file"), MadeUp::new(steps, counts_losses));
        let survey = source.survey().clone();
        let writer = Rc::new(RefCell::new(BagWriter::begin(file).expect("room for a file")));
        let source = Box::new(Told(Recorder::new(source, Rc::clone(&writer))));
        let live = events(source, &survey, &text);
        writer.borrow_mut().finish().expect("room for the end");
        let bag = Bag::open(&path).expect("a bag");
        let messages = Box::new(bag.messages_on(mapping(&text).topics()));
        // Also if none was lost.
        prop_assert!(messages.counts_losses() || !counts_losses);
        prop_assert_eq!(live, events(messages, bag.survey(), &text));
    }
}
