//! The process that supplies ticks.

use std::time::Duration;

use crate::{
    Action, ChannelId, Envelope, FieldKind, Message, NoNormalForm, NormalForm, Offer, Pattern, Process, Shape,
    TransitionId, Use, Value,
};

/// The process TickGenerator: sends `[<tick>, n]` for each tick that is generated and can be delivered.
///
/// [`ChannelSystem::generate_tick`](crate::ChannelSystem::generate_tick) decides from outside when a tick is due and
/// whether it is delivered.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TickGenerator {
    output: ChannelId,
    pending: Option<u64>,
}

impl TickGenerator {
    /// A generator that sends its ticks on this channel.
    #[must_use]
    pub fn new(output: ChannelId) -> Self {
        Self { output, pending: None }
    }

    /// The shape of a tick: `[<tick>, n]`.
    #[must_use]
    pub fn shape() -> Shape {
        Shape::new([("tick", FieldKind::symbols(["tick"])), ("number", FieldKind::Int)])
    }

    /// The channel on which it sends its ticks.
    #[must_use]
    pub fn output(&self) -> ChannelId {
        self.output
    }

    /// `[<tick>, n]`.
    pub(crate) fn tick(number: u64) -> Envelope {
        let number = i64::try_from(number).unwrap_or(i64::MAX);
        Message::new([Value::symbol("tick"), Value::Int(number)]).into()
    }

    /// Whether a tick waits to be sent.
    #[must_use]
    pub fn is_pending(&self) -> bool {
        self.pending.is_some()
    }

    /// Makes it send a tick with this number.
    pub fn generate(&mut self, tick: u64) {
        self.pending = Some(tick);
    }
}

impl Process for TickGenerator {
    fn offers(&self, offers: &mut Vec<Offer>) {
        offers.extend(self.pending.map(|number| {
            let action = Action::Send(self.output, Self::tick(number));
            Offer { transition: TransitionId(0), action }
        }));
    }

    fn take(&mut self, _transition: TransitionId, _received: Option<Envelope>, _now: Duration) {
        self.pending = None;
    }

    fn uses(&self) -> Vec<Use> {
        vec![Use::Sends(self.output, None)]
    }

    /// The number of a tick serves only for reports: in the normal form, every tick has the number 0.
    fn normalize(&mut self, _form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        self.pending = self.pending.map(|_| 0);
        Ok(())
    }

    fn location(&self) -> String {
        if self.pending.is_some() { "tick" } else { "idle" }.to_owned()
    }
}

/// Whether a receive offer would take a tick. This decides whether a tick is delivered or overruns.
pub(crate) fn takes_ticks(offer: &Offer, channel: ChannelId) -> bool {
    matches!(&offer.action, Action::Receive(on, Pattern::Any) if *on == channel)
}
