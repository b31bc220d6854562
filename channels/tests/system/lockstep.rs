//! A system and its normal form, side by side: their behavior cannot be distinguished.

#![allow(dead_code, clippy::unwrap_used, reason = "several crates test with it, and not all of them need ticks")]

use std::hash::{DefaultHasher, Hasher};
use std::time::Duration;

use channels::{ChannelSystem, EventKind, Message, NormalForm, ProcessId, Scheduler, Value};

/// Two copies of a system that make the same choices. One of them is brought into normal form after every step.
pub(crate) struct Lockstep {
    pub(crate) plain: ChannelSystem,
    pub(crate) normal: ChannelSystem,
    now: Duration,
}

impl Lockstep {
    pub(crate) fn new(system: &ChannelSystem, now: Duration) -> Self {
        let mut both = Self { plain: system.fork(), normal: system.fork(), now };
        both.compare();
        both
    }

    /// Does something to both copies.
    pub(crate) fn with(&mut self, mut act: impl FnMut(&mut ChannelSystem)) {
        act(&mut self.plain);
        act(&mut self.normal);
        self.compare();
    }

    /// Generates a tick in both. Returns whether it is delivered.
    pub(crate) fn tick(&mut self, generator: ProcessId) -> bool {
        let [(_, plain), (_, normal)] =
            [&mut self.plain, &mut self.normal].map(|system| system.generate_tick(generator));
        assert_eq!(plain, normal, "whether a tick is delivered");
        self.compare();
        plain
    }

    /// Lets time pass.
    pub(crate) fn advance(&mut self, by: Duration) {
        self.now += by;
        self.plain.advance(self.now);
        self.normal.advance(NormalForm::NOW + by);
        self.compare();
    }

    /// The time until the next timer is due.
    pub(crate) fn next_timer(&self) -> Option<Duration> {
        Some(self.plain.next_timer()?.saturating_sub(self.now))
    }

    /// Takes the same transition in both, and returns whether there was one.
    pub(crate) fn step(&mut self, scheduler: &mut dyn Scheduler) -> bool {
        let enabled = self.plain.enabled();
        if enabled.is_empty() {
            return false;
        }
        let chosen = enabled[scheduler.choose(&enabled)].clone();
        let events = [&mut self.plain, &mut self.normal].map(|system| system.take(&chosen).unwrap());
        let [plain, normal] = events.map(|event| event.map(|event| without_number(event.kind)));
        assert_eq!(plain, normal, "what {chosen:?} shows");
        self.compare();
        true
    }

    /// Takes transitions until both are quiet. Returns how many.
    pub(crate) fn run(&mut self, scheduler: &mut dyn Scheduler) -> usize {
        (0..).find(|_| !self.step(scheduler)).unwrap_or_default()
    }

    /// Brings the second copy into normal form, which must equal that of the first, and compares what can happen next.
    fn compare(&mut self) {
        self.normal.normalize().unwrap_or_else(|(id, why)| panic!("{}: {why}", self.plain.topology().name(id)));
        let mut of_plain = self.plain.fork();
        of_plain.normalize().unwrap();
        for id in self.plain.topology().processes() {
            assert_eq!(of_plain.clone_process(id), self.normal.clone_process(id), "their normal forms");
        }
        for channel in self.plain.topology().channels() {
            assert_eq!(of_plain.content(channel), self.normal.content(channel), "the normal forms of messages");
        }
        assert!(of_plain.same_state(&self.normal), "their normal forms");
        assert_eq!(hash(&of_plain), hash(&self.normal));
        assert_eq!(self.plain.enabled(), self.normal.enabled(), "what can happen");
        let timers = [(&self.plain, self.now), (&self.normal, NormalForm::NOW)]
            .map(|(system, now)| Some(system.next_timer()?.saturating_sub(now)));
        assert_eq!(timers[0], timers[1], "when the next timer is due");
    }
}

/// The number of a tick serves only for reports.
fn without_number(kind: EventKind) -> EventKind {
    match kind {
        EventKind::Received { channel, message } if message.head() == Some("tick") => {
            let fields = message.fields().iter();
            let fields = fields.map(|field| if matches!(field, Value::Int(_)) { Value::Int(0) } else { field.clone() });
            EventKind::Received { channel, message: Message::new(fields) }
        }
        kind => kind,
    }
}

fn hash(system: &ChannelSystem) -> u64 {
    let mut hasher = DefaultHasher::new();
    system.hash_state(&mut hasher);
    hasher.finish()
}
