//! Differences between this system and the published one.

/// A difference: what it concerns, what the paper or its published code has, and what this system has.
pub(super) struct Deviation {
    pub(super) of: &'static str,
    pub(super) published: &'static str,
    pub(super) here: &'static str,
}

/// All known differences.
pub(super) const DEVIATIONS: [Deviation; 14] = [
    Deviation {
        of: "Robot",
        published: "Experiments 1 and 2 in a simulation, experiment 3 on a real R1.",
        here: "All three, and the undisturbed run, in this project's own simulation, without a real robot.",
    },
    Deviation {
        of: "Simulation",
        published: "Fake motion control of two wheels, a laser cast on the map, no physics.",
        here: "A disc of the same radius with rigid-body physics; lasers are cast on the map. Neither has noise.",
    },
    Deviation {
        of: "Localization",
        published: "AMCL on the real robot; in the published simulation, odometry, which is exact there.",
        here: "A particle filter (AMCL) with two lasers, also in simulation; its error is in each run’s report.",
    },
    Deviation {
        of: "Map",
        published: "A recorded map of offices.",
        here: "A map of this project’s own with the published coordinates of start, station and destination. --map \
               accepts the published map, which needs --start 0,0.5,0: its start is closer to a wall than the robot’s \
               radius.",
    },
    Deviation {
        of: "Skills",
        published: "Four machines in the C++ data model of Qt SCXML, six of them running; the seventh leaf is built into the tree.",
        here: "Seven machines in the ECMAScript data model of SCXML 1.0, written from scratch.",
    },
    Deviation {
        of: "At Location",
        published: "Asks the localization component in the paper; in the published code it always answers failure.",
        here: "Asks the localization component.",
    },
    Deviation {
        of: "Wait for User",
        published: "A condition that returns running; in the published code, a built-in action.",
        here: "An action with its own machine, which answers running.",
    },
    Deviation {
        of: "Between tree and skills",
        published: "The tree asks a skill repeatedly until it is no longer idle; it does not wait when it stops one.",
        here: "A skill answers each tick once, when the answer is known, and acknowledges each stop.",
    },
    Deviation {
        of: "Between skills and navigation",
        published: "The two GoTo skills take turns with a lock on a blackboard, and a stop ends any trip.",
        here: "No lock: a stop names its place, ends only the trip to that place, and is acknowledged. \
               The scenario late_halt runs the published protocol.",
    },
    Deviation {
        of: "Components",
        published: "BatteryComponent, GoToComponent (which also reports where the robot is) and Blackboard.",
        here: "BatteryReader, Localization and Navigation, as in the paper’s text.",
    },
    Deviation {
        of: "Monitors",
        published: "Built manually, in SCXML, and fed by plug-ins that copy the messages on the ports.",
        here: "Made from the formulas of Figure 4. Those of Figure 5, built manually, watch the same runs.",
    },
    Deviation {
        of: "What the response monitor receives",
        published: "As built: the destination changes to the station. In Figure 5 (b): the command to go there is sent.",
        here: "The command, as in Figures 4 and 5 (b); 30 % counts as low, as in Figure 4 (in the published machine it does not).",
    },
    Deviation {
        of: "Ticks",
        published: "1 Hz by the wall clock; a tick counts when the tree asks the battery’s skill.",
        here: "1 Hz in simulated time; a tick counts when it is generated.",
    },
    Deviation {
        of: "Charging",
        published: "Within 0.5 m and 10° of the station, up to 99.7 %.",
        here: "The same, after 1 s at rest there; it starts again only below 95 % or after the robot has left.",
    },
];
