//! The activities of the tree, in numbered stages, with the same numbers and colors on the map, on the timeline and in
//! the text.

use std::collections::BTreeSet;

use drawing::theme::{self, Color};

use super::colors;
use crate::timeline::{Stage, Timeline};

/// A stage of the run with its number and color.
#[derive(Clone, Debug)]
pub(super) struct Activity {
    /// Its number, from 1; none where no leaf was running.
    pub(super) number: Option<usize>,
    pub(super) color: Color,
    pub(super) stage: Stage,
}

impl Activity {
    /// The leaves that were running, in words.
    pub(super) fn words(&self) -> &str {
        if self.stage.doing.is_empty() { "no leaf running" } else { &self.stage.doing }
    }
}

/// The stages of a run. Stages with the same running leaves have the same color.
pub(super) fn activities(timeline: &Timeline) -> Vec<Activity> {
    let mut known: Vec<String> = Vec::new();
    let mut color = |doing: &str| {
        if doing.is_empty() {
            return theme::LINE;
        }
        let number = known.iter().position(|other| other == doing).unwrap_or_else(|| {
            known.push(doing.to_owned());
            known.len() - 1
        });
        colors::activity(number)
    };
    let mut count = 0;
    let mut number = |doing: &str| {
        count += usize::from(!doing.is_empty());
        (!doing.is_empty()).then_some(count)
    };
    let stages = timeline.trail().stages(timeline.end()).into_iter();
    stages.map(|stage| Activity { number: number(&stage.doing), color: color(&stage.doing), stage }).collect()
}

/// Whether stages with different running leaves have the same color.
pub(super) fn has_more_leaves_than_colors(activities: &[Activity]) -> bool {
    let doing: BTreeSet<&str> = activities.iter().map(|activity| &*activity.stage.doing).collect();
    doing.iter().filter(|doing| !doing.is_empty()).count() > colors::ACTIVITIES.len()
}
