//! The moments that the paper's figures show.

/// A panel of a figure.
#[derive(Debug)]
pub(super) struct Shot {
    /// The scenario that repeats the experiment.
    pub(super) scenario: &'static str,
    pub(super) figure: &'static str,
    /// The panel's letter in the figure; empty if the paper has no such panel.
    pub(super) panel: &'static str,
    /// The paper's caption, or a description where the paper has no such panel.
    pub(super) caption: &'static str,
    pub(super) when: When,
    pub(super) shows: Shows,
}

/// A moment of a run.
#[derive(Clone, Copy, Debug)]
pub(super) enum When {
    /// The first step.
    Start,
    /// The last tick before the fault with this index took effect.
    BeforeFault(usize),
    /// This many seconds after the fault with this index took effect.
    AfterFault(usize, f64),
    /// This many seconds after it ended.
    AfterRelease(usize, f64),
    /// This many seconds after this property was violated.
    AfterVerdict(&'static str, f64),
}

/// The part of a moment that a panel shows.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shows {
    /// The behavior tree.
    Tree,
    /// The map with the robot, its path and what the lasers see.
    Scene,
    /// The monitor of this property.
    Monitor(&'static str),
    /// The monitor of this property in a state that it only passes through: a level is read and compared in one step.
    Passing(&'static str, &'static str),
}

pub(super) const FIGURE_1: &str = "Figure 1: the behavior tree of the scenario";
pub(super) const FIGURE_5: &str = "Figure 5: runtime monitors";
pub(super) const FIGURE_6: &str = "Figure 6: Experiment 1";
pub(super) const FIGURE_7: &str = "Figure 7: Experiment 3 (simulated here)";
pub(super) const FIGURE_8: &str = "Figure 8: the monitor in Experiment 3 (simulated here)";
/// Ours: the paper has no figure for it.
pub(super) const EXPERIMENT_2: &str = "Experiment 2";

const fn shot(
    scenario: &'static str,
    figure: &'static str,
    panel: &'static str,
    caption: &'static str,
    when: When,
    shows: Shows,
) -> Shot {
    Shot { scenario, figure, panel, caption, when, shows }
}

/// All panels, in the order of the paper.
pub(super) const SHOTS: &[Shot] = &[
    shot("nominal", FIGURE_1, "", "BT for the validation scenario.", When::Start, Shows::Tree),
    shot("nominal", FIGURE_5, "a", "Safety: the monitor as published.", When::Start, Shows::Monitor("figure_5a")),
    shot("nominal", FIGURE_5, "a, here", "Safety: the monitor made from φ1.", When::Start, Shows::Monitor("phi1")),
    shot("nominal", FIGURE_5, "b", "Response: the monitor as published.", When::Start, Shows::Monitor("figure_5b")),
    shot("nominal", FIGURE_5, "b, here", "Response: the monitor made from φ2.", When::Start, Shows::Monitor("phi2")),
    shot(
        "battery_fault",
        FIGURE_6,
        "a",
        "Battery level above 30%. The robot is reaching the destination. The safety property φ1 is satisfied.",
        When::BeforeFault(0),
        Shows::Scene,
    ),
    shot(
        "battery_fault",
        FIGURE_6,
        "b",
        "Battery level below 30%. The robot is reaching the recharging station. The safety property φ1 is violated.",
        When::AfterVerdict("phi1", 6.0),
        Shows::Scene,
    ),
    shot(
        "battery_fault",
        FIGURE_6,
        "c",
        "The monitor at state Idle; waiting for the skill to send a request to the component.",
        When::BeforeFault(0),
        Shows::Monitor("figure_5a"),
    ),
    shot(
        "battery_fault",
        FIGURE_6,
        "d",
        "The monitor at state Get; waiting for the component to respond.",
        When::BeforeFault(0),
        Shows::Passing("figure_5a", "get"),
    ),
    shot(
        "battery_fault",
        FIGURE_6,
        "e",
        "The monitor at state Failure. Property violated.",
        When::AfterVerdict("phi1", 0.0),
        Shows::Monitor("figure_5a"),
    ),
    shot("skill_bug", EXPERIMENT_2, "", "Before: the level is above 30 %.", When::BeforeFault(1), Shows::Scene),
    shot(
        "skill_bug",
        EXPERIMENT_2,
        "",
        "At the verdict: the level is below 30 %, and the robot drives on to the destination.",
        When::AfterVerdict("phi2", 0.0),
        Shows::Scene,
    ),
    shot("skill_bug", EXPERIMENT_2, "", "Before: nothing is pending.", When::BeforeFault(1), Shows::Monitor("phi2")),
    shot(
        "skill_bug",
        EXPERIMENT_2,
        "",
        "A low level has been read on the way, and the command is pending.",
        When::AfterFault(1, 5.0),
        Shows::Monitor("phi2"),
    ),
    shot(
        "skill_bug",
        EXPERIMENT_2,
        "",
        "The monitor made from φ2 goes to an error state.",
        When::AfterVerdict("phi2", 0.0),
        Shows::Monitor("phi2"),
    ),
    shot(
        "skill_bug",
        EXPERIMENT_2,
        "",
        "A tick later, the monitor as published goes to an error state.",
        When::AfterVerdict("figure_5b", 0.0),
        Shows::Monitor("figure_5b"),
    ),
    shot("joypad", FIGURE_7, "a", "The robot navigates to the charging station.", When::BeforeFault(0), Shows::Scene),
    shot(
        "joypad",
        FIGURE_7,
        "b",
        "A malicious user moves the robot elsewhere.",
        When::AfterRelease(0, 0.0),
        Shows::Scene,
    ),
    shot(
        "joypad",
        FIGURE_7,
        "c",
        "The robot resumes its navigation to the charging station.",
        When::AfterRelease(0, 5.0),
        Shows::Scene,
    ),
    shot(
        "joypad",
        FIGURE_7,
        "d",
        "A malicious user moves the robot elsewhere. The battery level gets lower than 20%.",
        When::AfterVerdict("phi1", 0.0),
        Shows::Scene,
    ),
    shot(
        "joypad",
        FIGURE_8,
        "a",
        "Battery level 35%. The property is satisfied.",
        When::Start,
        Shows::Monitor("figure_5a"),
    ),
    shot(
        "joypad",
        FIGURE_8,
        "b",
        "Battery level 19%. The property is violated.",
        When::AfterVerdict("phi1", 0.0),
        Shows::Monitor("figure_5a"),
    ),
];
