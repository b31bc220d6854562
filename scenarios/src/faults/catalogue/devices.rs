//! Faults of the world's devices.

use crate::faults::effect::{DeviceTrouble, Effect};
use crate::faults::kind::{FaultKind, Subsystem};
use crate::faults::{ArgumentDomain, Arguments, Parameter};
use diagnostics::document::Referent;

fn device(with: &Arguments, trouble: DeviceTrouble) -> Effect {
    Effect::Device { component: with.name("component"), trouble }
}

pub(super) const DOOR_STUCK: FaultKind = FaultKind {
    name: "door_stuck",
    subsystem: Subsystem::Devices,
    about: "a door of the world does not move",
    parameters: &[Parameter::required("door", "the door's name in the world", ArgumentDomain::Name(Referent::Door))],
    example: "at_s = 10\ndoor = \"gallery\"\nlasts_s = 60",
    effect: |with| {
        let door = with.text("door").to_owned();
        Effect::world(move |faults| faults.stuck_doors.push(door.clone()))
    },
    words: |with| format!("the {} is stuck", with.text("door")),
};

pub(super) const DEVICE_DEAF: FaultKind = FaultKind {
    name: "device_deaf",
    subsystem: Subsystem::Devices,
    about: "a button, a microphone or a people sensor detects nothing",
    parameters: &[Parameter::required("component", "which device", ArgumentDomain::Name(Referent::Component))],
    example: "at_s = 10\ncomponent = \"CallButton\"\nlasts_s = 60",
    effect: |with| device(with, DeviceTrouble::Deaf),
    words: |with| format!("{} detects nothing", with.text("component")),
};

pub(super) const SPEAKER_MUTE: FaultKind = FaultKind {
    name: "speaker_mute",
    subsystem: Subsystem::Devices,
    about: "a speaker cannot be heard, but reports success",
    parameters: &[Parameter::required("component", "which speaker", ArgumentDomain::Name(Referent::Component))],
    example: "at_s = 10\ncomponent = \"Speaker\"\nlasts_s = 60",
    effect: |with| device(with, DeviceTrouble::Mute),
    words: |with| format!("{} cannot be heard", with.text("component")),
};

pub(super) const BOX_DROPPED: FaultKind = FaultKind {
    name: "box_dropped",
    subsystem: Subsystem::Devices,
    about: "the box on a tray falls off behind the robot, and the tray finds out when it is to put it down",
    parameters: &[Parameter::required("component", "which tray", ArgumentDomain::Name(Referent::Component))],
    example: "at_s = 10\ncomponent = \"Tray\"",
    effect: |with| device(with, DeviceTrouble::Drop),
    words: |with| format!("the box falls off {}", with.text("component")),
};
