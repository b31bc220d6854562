//! The clock of a model: it fires the timers of all machines.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, ChannelId, Envelope, Message, NoNormalForm, NormalForm, Offer, Process, RequestNumber, TransitionId,
    Unobserved, Use, Value,
};

use crate::instance::CLOCK_EVENT;

#[derive(Debug)]
pub(super) struct Timer {
    /// The index of the channel to the machine.
    pub(super) out: usize,
    pub(super) event: String,
    pub(super) period_ns: u64,
}

#[derive(Debug, Default)]
pub(super) struct ClockWiring {
    pub(super) outgoing: Vec<ChannelId>,
    pub(super) timers: Vec<Timer>,
    /// The channels to the subscribers of the topic `clock`.
    pub(super) listeners: Vec<usize>,
    /// The time between two messages on that topic: the greatest common divisor of all periods.
    pub(super) step_ns: u64,
}

/// The clock. When several timers are due at the same time, it fires one per call of
/// [`fire_timers`](Process::fire_timers), in the order of their declarations: everything that follows from one happens
/// before the next.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Clock {
    wiring: Unobserved<Arc<ClockWiring>>,
    outboxes: Vec<VecDeque<Envelope>>,
    /// When each timer is next due, in nanoseconds.
    due_ns: Vec<u64>,
    /// When the next message on the topic `clock` is due, in nanoseconds.
    tick_ns: u64,
}

impl Clock {
    pub(super) fn new(wiring: ClockWiring) -> Self {
        Self {
            outboxes: vec![VecDeque::new(); wiring.outgoing.len()],
            due_ns: wiring.timers.iter().map(|timer| timer.period_ns).collect(),
            tick_ns: wiring.step_ns,
            wiring: Unobserved(Arc::new(wiring)),
        }
    }

    fn next_ns(&self) -> Option<u64> {
        let tick = (!self.wiring.listeners.is_empty()).then_some(self.tick_ns);
        self.due_ns.iter().copied().chain(tick).min()
    }

    fn post(&mut self, out: usize, message: Message) {
        self.outboxes[out].push_back(Envelope { message, request: RequestNumber::default() });
    }
}

impl Process for Clock {
    fn offers(&self, offers: &mut Vec<Offer>) {
        for (index, (out, waiting)) in self.wiring.outgoing.iter().zip(&self.outboxes).enumerate() {
            if let Some(envelope) = waiting.front() {
                let action = Action::Send(*out, envelope.clone());
                offers.push(Offer { transition: TransitionId(index as u32), action });
            }
        }
    }

    fn take(&mut self, transition: TransitionId, _: Option<Envelope>, _: Duration) {
        self.outboxes[transition.0 as usize].pop_front();
    }

    fn next_timer(&self) -> Option<Duration> {
        self.next_ns().map(Duration::from_nanos)
    }

    fn fire_timers(&mut self, _: Duration) {
        let Some(now) = self.next_ns() else { return };
        let wiring = self.wiring.clone();
        if !wiring.listeners.is_empty() && self.tick_ns == now {
            self.tick_ns += wiring.step_ns;
            let (seconds, rest) = (now / 1_000_000_000, now % 1_000_000_000);
            let fields = [Value::symbol(CLOCK_EVENT), Value::Int(seconds as i64), Value::Int(rest as i64)];
            wiring.listeners.iter().for_each(|out| self.post(*out, Message::new(fields.clone())));
        } else if let Some(index) = self.due_ns.iter().position(|due| *due == now) {
            let timer = &wiring.timers[index];
            self.due_ns[index] += timer.period_ns;
            self.post(timer.out, Message::new([Value::symbol(&timer.event)]));
        }
    }

    fn uses(&self) -> Vec<Use> {
        self.wiring.outgoing.iter().map(|out| Use::Sends(*out, None)).collect()
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        if !self.wiring.listeners.is_empty() {
            return Err(NoNormalForm::Unsupported {
                reason: "it publishes the time of the run, which never repeats".to_owned(),
                help: Some("remove the subscriptions to the topic `clock`, and use `<ros_time_rate>`".to_owned()),
            });
        }
        for waiting in &self.outboxes {
            form.queue(waiting.len(), || format!("more than {} expired timers are waiting", NormalForm::QUEUE))?;
        }
        for due_ns in &mut self.due_ns {
            let mut due = Duration::from_nanos(*due_ns);
            form.time(&mut due);
            *due_ns = u64::try_from(due.as_nanos()).unwrap_or(u64::MAX);
        }
        Ok(())
    }

    fn location(&self) -> String {
        "ticking".to_owned()
    }
}
