//! Messages of a robot whose clock is that of a simulation, and messages that are missing.

use bags::{Account, Definition, Events, Head, Received, Source, Survey, Topic};

use crate::messages::{TWIST, twist};
use crate::reading::{lines, mapping, nothing};

/// Says these things in turn, a second apart by its own clock.
struct Script {
    steps: std::vec::IntoIter<Step>,
    survey: Survey,
    now_ns: i64,
}

#[derive(Clone, Copy)]
enum Step {
    /// The times on `/clock`, in milliseconds.
    Clock(i64),
    Message,
    Missing(u64),
}

impl Script {
    fn new(steps: &[Step]) -> Self {
        let mut survey = Survey::default();
        for (name, kind, text) in [("/clock", "rosgraph_msgs/msg/Clock", ""), ("/a", TWIST.0, TWIST.1)] {
            let definition = Definition { language: "ros2msg".to_owned(), text: text.to_owned() };
            let [name, kind, encoding] = [name, kind, "cdr"].map(str::to_owned);
            survey.add(Topic { name, kind, encoding, definition: Some(definition), hash: None });
        }
        Self { steps: Vec::from(steps).into_iter(), survey, now_ns: 1_700_000_000_000_000_000 }
    }
}

impl Source for Script {
    fn receive(&mut self, body: &mut Vec<u8>) -> Received {
        self.now_ns += 1_000_000_000;
        let topic = match self.steps.next() {
            None => return Received::Over,
            Some(Step::Missing(count)) => {
                return Received::Lost { topic: 1, count: Some(count), since_ns: self.now_ns - 1_000_000_000 };
            }
            Some(Step::Clock(ms)) => {
                let (s, ns) = (ms / 1000, ms % 1000 * 1_000_000);
                *body = [&[0, 1, 0, 0][..], &(s as i32).to_le_bytes(), &(ns as u32).to_le_bytes()].concat();
                0
            }
            Some(Step::Message) => {
                *body = twist(1.0);
                1
            }
        };
        self.survey.count(topic, self.now_ns);
        Received::Message(Head { topic, log_ns: self.now_ns, publish_ns: self.now_ns })
    }

    fn account(&self) -> Account<'_> {
        Account { survey: &self.survey, lost: &[], notes: &[], counts_losses: false }
    }
}

fn events(time: &str, lossy: &str, steps: &[Step]) -> Vec<String> {
    let text = format!(
        "tick_s = 0.5\nreorder_s = 0\ntime = \"{time}\"\n[[messages]]\ntopic = \"/a\"\nfrom = \"a\"\nto = \"m\"\n{lossy}\n\
         fields = {{ x = \"linear.x\" }}\n"
    );
    let (source, mapping) = (Script::new(steps), mapping(&text));
    let compiled =
        mapping.compile(&source.survey, None, &nothing).unwrap_or_else(|problems| panic!("{}", problems.plain()));
    let topology = compiled.topology.clone();
    let mut events = Events::new(Box::new(source), &mapping, compiled, &nothing);
    let mut found: Vec<String> = lines(&mut events, &topology).collect();
    found.extend(events.notes());
    found
}

#[test]
fn time_passes_as_on_the_clock_of_a_simulation() {
    let steps = [Step::Message, Step::Clock(4000), Step::Message, Step::Clock(4300), Step::Message, Step::Clock(5000)];
    assert_eq!(
        events("clock", "", &steps),
        [
            // What came before the first time of the clock has that time.
            "0 ms: 0, tick 0",
            "0 ms: 1, tick 0: a → m [1.0]",
            "0 ms: 2, tick 0: a → m [1.0]",
            "300 ms: 3, tick 0: a → m [1.0]",
            "500 ms: 3, tick 1",
            "1000 ms: 3, tick 2",
        ]
    );
}

#[test]
fn a_clock_that_goes_back_ends_the_run() {
    let steps = [Step::Clock(4000), Step::Message, Step::Clock(1000), Step::Message];
    let events = events("clock", "", &steps);
    assert_eq!(events.last().unwrap(), "/clock jumped from 4.000000000 s to 1.000000000 s, which ends the run");
    assert_eq!(events.len(), 3, "{events:?}");
}

#[test]
fn a_gap_lies_between_messages_unless_the_mapping_accepts_it() {
    let steps = [Step::Message, Step::Missing(2), Step::Message, Step::Missing(1), Step::Message];
    let counted = "3 messages on /a are missing, the first after 2023-11-14 22:13:21.000 UTC";
    let found = events("log", "", &steps);
    let gaps: Vec<&String> = found.iter().filter(|line| line.contains("missing") || line.contains("goes on")).collect();
    assert_eq!(
        gaps,
        [
            "2 messages on /a are missing after 2023-11-14 22:13:21.000 UTC since Some(0ns)",
            "a → m goes on",
            "1 message on /a is missing after 2023-11-14 22:13:23.000 UTC since Some(2s)",
            "a → m goes on",
            counted,
        ]
    );
    let found = events("log", "lossy = true", &steps);
    assert_eq!(found.iter().filter(|line| line.contains("missing")).collect::<Vec<_>>(), [counted]);
}

#[test]
fn any_number_of_messages_can_be_missing() {
    for count in [0, 1, 1 << 32, 1 << 61, u64::MAX] {
        let steps = [Step::Message, Step::Missing(count), Step::Message, Step::Missing(count), Step::Message];
        let found = events("log", "", &steps);
        let words = |count: u64| match count {
            1 => "1 message on /a is missing".to_owned(),
            _ => format!("{count} messages on /a are missing"),
        };
        for second in [1, 3] {
            let gap = format!("{} after 2023-11-14 22:13:2{second}.000 UTC since", words(count));
            assert_eq!(found.iter().filter(|line| line.starts_with(&gap)).count(), 1, "{found:#?}");
        }
        assert_eq!(found.iter().filter(|line| *line == "a → m goes on").count(), 2, "{found:#?}");
        let all = format!("{}, the first after", words(count.saturating_mul(2)));
        assert_eq!(found.iter().filter(|line| line.starts_with(&all)).count(), 1, "{found:#?}");
    }
}
