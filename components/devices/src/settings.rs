//! The kinds of devices, and their settings.

use std::io::ErrorKind;
use std::path::Path;
use std::time::Duration;

use interfaces::Interface;

/// The definitions of ROS 2 that interfaces name and that ROS 2 does not have.
const DEFINITIONS: [(&str, &str); 2] = [
    ("steward_msgs/srv/GetPeople.srv", include_str!("../interfaces/steward_msgs/srv/GetPeople.srv")),
    ("steward_msgs/srv/Say.srv", include_str!("../interfaces/steward_msgs/srv/Say.srv")),
];

/// A kind of device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DeviceKind {
    /// A door of the world, which opens and closes on request.
    Door,
    /// A sensor on the robot that counts people in view.
    People,
    /// A speaker: says texts.
    Speaker,
    /// A button: pressed at set times.
    Button,
    /// A microphone: detects requests at set times.
    Microphone,
    /// A tray on the robot: carries a box.
    Tray,
}

impl DeviceKind {
    /// All kinds.
    pub const ALL: [Self; 6] = [Self::Door, Self::People, Self::Speaker, Self::Button, Self::Microphone, Self::Tray];

    /// Its name in a scenario.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Door => "door",
            Self::People => "people",
            Self::Speaker => "speaker",
            Self::Button => "button",
            Self::Microphone => "microphone",
            Self::Tray => "tray",
        }
    }

    /// Its name in messages.
    #[must_use]
    pub const fn noun(self) -> &'static str {
        match self {
            Self::People => "people sensor",
            other => other.name(),
        }
    }

    /// Whether it needs a robot in a world.
    #[must_use]
    pub const fn needs_robot(self) -> bool {
        matches!(self, Self::Door | Self::People | Self::Tray)
    }

    /// Whether it senses its surroundings.
    #[must_use]
    pub const fn is_sensor(self) -> bool {
        matches!(self, Self::People | Self::Button | Self::Microphone)
    }

    /// The file with its interface.
    #[must_use]
    pub const fn interface_file(self) -> &'static str {
        match self {
            Self::Door => include_str!("../interfaces/door.toml"),
            Self::People => include_str!("../interfaces/people.toml"),
            Self::Speaker => include_str!("../interfaces/speaker.toml"),
            Self::Button => include_str!("../interfaces/button.toml"),
            Self::Microphone => include_str!("../interfaces/microphone.toml"),
            Self::Tray => include_str!("../interfaces/tray.toml"),
        }
    }

    /// Its services and topics, with their types in ROS 2.
    #[must_use]
    pub fn interface(self) -> Interface {
        let own = [(self.name(), self.interface_file())];
        let read = |path: &Path| {
            let mut files = own.iter().chain(&DEFINITIONS);
            let file = files.find(|(name, _)| Path::new(name) == path).ok_or(ErrorKind::NotFound)?;
            Ok(file.1.as_bytes().to_vec())
        };
        Interface::load(Path::new(self.name()), &[], &read).expect("a test loads all of them")
    }
}

/// A device of a scenario.
#[derive(Clone, Debug, PartialEq)]
pub enum DeviceSettings {
    /// A door of the world.
    Door {
        /// Its name in the world.
        door: String,
    },
    /// A sensor that counts people.
    People {
        /// Its range from the robot's center, in meters.
        within_m: f64,
        /// The people that it detects; all if none are listed.
        only: Vec<String>,
    },
    /// A speaker.
    Speaker {
        /// How fast it speaks.
        letters_per_s: f64,
    },
    /// A button.
    Button {
        /// The times at which it is pressed.
        pressed: Vec<Duration>,
    },
    /// A microphone.
    Microphone {
        /// The requests that it detects, with their times.
        hears: Vec<(Duration, String)>,
    },
    /// A tray.
    Tray {
        /// The maximum distance of a box from the robot's edge, in meters.
        reach_m: f64,
    },
}

impl DeviceSettings {
    /// The kind of device.
    #[must_use]
    pub fn kind(&self) -> DeviceKind {
        match self {
            Self::Door { .. } => DeviceKind::Door,
            Self::People { .. } => DeviceKind::People,
            Self::Speaker { .. } => DeviceKind::Speaker,
            Self::Button { .. } => DeviceKind::Button,
            Self::Microphone { .. } => DeviceKind::Microphone,
            Self::Tray { .. } => DeviceKind::Tray,
        }
    }
}
