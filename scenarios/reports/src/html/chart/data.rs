//! The timeline as data, for the script that draws it anew for each view.

use std::collections::HashMap;

use drawing::time_axis::Stretch;
use recording::RunView;
use serde_json::{Value, json};

use super::happenings::{self, Happening};
use super::lanes::{self, Group};
use super::plots::{self, Plot};
use super::sheet::{Chart, Sizes};
use crate::html::colors;
use crate::html::figure::Layout;
use crate::timeline::Timeline;

/// The looks of all bars, each once: text, ground, outline and ink.
#[derive(Default)]
pub(super) struct Looks {
    numbers: HashMap<[String; 4], usize>,
    all: Vec<[String; 4]>,
}

impl Looks {
    /// The number of a look. Without a ground, a bar is a thin line.
    pub(super) fn number(&mut self, look: [String; 4]) -> usize {
        let all = &mut self.all;
        *self.numbers.entry(look).or_insert_with_key(|look| {
            all.push(look.clone());
            all.len() - 1
        })
    }
}

/// Everything that the drawn timeline shows. Times are in seconds, those of bars in milliseconds.
pub(in crate::html) fn data(view: &RunView, timeline: &Timeline) -> Value {
    let happenings = happenings::of(view, timeline);
    let chart = Chart::new(timeline, &happenings, Sizes::of(Layout::Wide));
    let share = |x: f64| round((x - chart.plot.x) / chart.plot.width, 6);
    let stretch = |stretch: &Stretch| {
        json!([stretch.from_s, stretch.to_s, share(stretch.left), share(stretch.right), stretch.shortened])
    };
    let axis: Vec<Value> = chart.axis.stretches().iter().map(stretch).collect();
    let mut looks = Looks::default();
    let groups: Vec<Value> = lanes::groups(timeline).iter().map(|group| Group::data(group, &mut looks)).collect();
    let plots = plots::plots(view, timeline).into_iter().map(|Plot { title, points, range, ticks, bounds, .. }| {
        let points = points.iter().map(|(at, value)| [round(at.as_secs_f64(), 3), round(*value, 4)]);
        json!({ "title": title, "points": points.collect::<Vec<_>>(), "range": range, "ticks": ticks, "bounds": bounds })
    });
    json!({
        "end": round(timeline.end().as_secs_f64(), 3),
        "axis": axis,
        "groups": groups,
        "looks": looks.all,
        "events": happenings.iter().map(Happening::data).collect::<Vec<_>>(),
        "held": happenings.iter().flat_map(Happening::held).collect::<Vec<_>>(),
        "plots": plots.collect::<Vec<_>>(),
    })
}

/// The name of a color in the page's style sheet: `--good`.
pub(super) fn variable(color: drawing::theme::Color) -> String {
    colors::variable(color).replace("var(", "").replace(')', "")
}

pub(super) fn round(number: f64, decimals: i32) -> f64 {
    let factor = 10_f64.powi(decimals);
    (number * factor).round() / factor
}
