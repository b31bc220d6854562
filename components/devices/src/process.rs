//! A device as a process of a channel system.

use std::time::Duration;

use channels::{
    ChannelId, Envelope, NoNormalForm, NormalForm, Offer, Process, ProcessId, RequestNumber, Topology, TransitionId,
    Use,
};
use skills::{Adapter as _, ChannelAdapter};

use crate::door::Door;
use crate::lines::Lines;
use crate::people::People;
use crate::signals::Signals;
use crate::speaker::Speaker;
use crate::tray::Tray;
use crate::{DeviceSettings, Surroundings};

/// A device that communicates over channels. Its interface is that of its [kind](crate::DeviceKind::interface).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct DeviceProcess {
    adapter: ChannelAdapter,
    work: Work,
    /// Whether a fault keeps a sensor from detecting anything, or mutes a speaker.
    is_impaired: bool,
}

/// The behavior of a device.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Work {
    Door(Door),
    People(People),
    Speaker(Speaker),
    Signals(Signals),
    Tray(Tray),
}

impl DeviceProcess {
    /// The device with these settings, as this process of the topology.
    #[must_use]
    pub fn new(topology: &Topology, process: ProcessId, settings: &DeviceSettings) -> Self {
        let work = match settings {
            DeviceSettings::Door { door } => Work::Door(Door::new(door)),
            DeviceSettings::People { within_m, only } => Work::People(People::new(*within_m, only)),
            DeviceSettings::Speaker { letters_per_s } => Work::Speaker(Speaker::new(*letters_per_s)),
            DeviceSettings::Button { pressed } => Work::Signals(Signals::of_button(pressed)),
            DeviceSettings::Microphone { hears } => Work::Signals(Signals::of_microphone(hears)),
            DeviceSettings::Tray { reach_m } => Work::Tray(Tray::new(*reach_m)),
        };
        Self { adapter: ChannelAdapter::new(topology, process), work, is_impaired: false }
    }

    /// Senses changes in the surroundings, and does what has been requested. Must be called once per step.
    pub fn act(&mut self, surroundings: &mut dyn Surroundings) {
        let lines = &mut Lines::new(&mut self.adapter);
        match &mut self.work {
            Work::Door(door) => door.act(surroundings, lines),
            Work::People(people) => people.look(surroundings, self.is_impaired, lines),
            Work::Tray(tray) => tray.act(surroundings, lines),
            Work::Speaker(_) | Work::Signals(_) => {}
        }
    }

    /// Makes a sensor notice nothing or a speaker fall silent, or undoes that. Signals before then are never noticed,
    /// even if the device hangs.
    pub fn impair(&mut self, is_impaired: bool, now: Duration) {
        if self.is_impaired
            && let Work::Signals(signals) = &mut self.work
        {
            signals.miss(now);
        }
        self.is_impaired = is_impaired;
    }

    /// Makes a tray's box fall.
    ///
    /// # Errors
    /// The reason why none falls, in words.
    pub fn drop_box(&mut self, surroundings: &mut dyn Surroundings) -> Result<(), &'static str> {
        match &mut self.work {
            Work::Tray(tray) => tray.drop_box(surroundings),
            _ => Err("it is not a tray"),
        }
    }

    /// The text that a speaker is saying, and since when, unless it is mute.
    #[must_use]
    pub fn speech(&self) -> Option<(Duration, &str)> {
        match &self.work {
            Work::Speaker(speaker) if !self.is_impaired => speaker.speech(),
            _ => None,
        }
    }

    /// Crashes and restarts it: it forgets its requests and everything it noticed. A box on a tray stays there.
    pub fn restart(&mut self, now: Duration) {
        self.adapter = self.adapter.succeeding();
        match &mut self.work {
            Work::Door(door) => door.restart(),
            Work::People(people) => people.restart(),
            Work::Speaker(speaker) => speaker.restart(),
            Work::Signals(signals) => signals.restart(now),
            Work::Tray(tray) => tray.restart(),
        }
    }
}

impl Process for DeviceProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        self.adapter.offers(offers);
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        let Some(event) = self.adapter.take(transition, received.as_ref()) else { return };
        let Some(client) = event.origin.as_deref() else { return };
        let lines = &mut Lines::new(&mut self.adapter);
        match &mut self.work {
            Work::Door(door) => door.handle(&event.name, client, lines),
            Work::People(people) => people.handle(client, lines),
            Work::Speaker(speaker) => speaker.handle(client, &event.data, now, lines),
            Work::Signals(signals) => signals.handle(client, lines),
            Work::Tray(tray) => tray.handle(&event.name, client, lines),
        }
    }

    fn next_timer(&self) -> Option<Duration> {
        match &self.work {
            Work::Speaker(speaker) => speaker.finishes(),
            Work::Signals(signals) => signals.next(),
            _ => None,
        }
    }

    fn fire_timers(&mut self, now: Duration) {
        let lines = &mut Lines::new(&mut self.adapter);
        match &mut self.work {
            Work::Speaker(speaker) => speaker.finish(now, self.is_impaired, lines),
            Work::Signals(signals) => signals.notice(now, self.is_impaired, lines),
            _ => {}
        }
    }

    fn uses(&self) -> Vec<Use> {
        self.adapter.receives().chain(self.adapter.sends()).collect()
    }

    fn awaits(&self, requests: &mut Vec<(ChannelId, RequestNumber)>) {
        self.adapter.awaits(requests);
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        match &mut self.work {
            Work::Speaker(speaker) => speaker.normalize(form),
            Work::Signals(signals) => signals.normalize(form)?,
            Work::Door(_) | Work::People(_) | Work::Tray(_) => {}
        }
        self.adapter.normalize(form)
    }

    fn location(&self) -> String {
        match &self.work {
            Work::Door(door) => door.location().to_owned(),
            Work::People(people) => people.location(),
            Work::Speaker(speaker) => speaker.location().to_owned(),
            Work::Signals(signals) => signals.location(),
            Work::Tray(tray) => tray.location(),
        }
    }
}
