//! The timeline as data, for the script that draws it anew for each view.

use std::time::Duration;

use drawing::time_axis::Stretch;
use recording::RunView;
use serde_json::{Value, json};

use super::happenings::{self, Happening};
use super::lanes::{self, Group};
use super::looks::{Looks, round};
use super::plots::{self, Plot};
use super::sheet::{Chart, Sizes};
use crate::html::figure::Layout;
use crate::timeline::Timeline;

/// Everything that the drawn timeline shows. Times are in seconds, those of bars in milliseconds;
/// `began` is in milliseconds since 1970, if that is known.
pub(in crate::html) fn data(view: &RunView, timeline: &Timeline) -> Value {
    let happenings = happenings::of(view, timeline);
    let chart = Chart::new(timeline, &happenings, Sizes::of(Layout::Wide));
    let share = |x: f64| round((x - chart.plot.x) / chart.plot.width, 1e6);
    let stretch = |stretch: &Stretch| {
        json!([stretch.from_s, stretch.to_s, share(stretch.left), share(stretch.right), stretch.shortened])
    };
    let axis: Vec<Value> = chart.axis.stretches().iter().map(stretch).collect();
    let mut looks = Looks::default();
    let groups: Vec<Value> = lanes::groups(view, timeline).iter().map(|group| Group::data(group, &mut looks)).collect();
    let plots = plots::plots(view, timeline).into_iter().map(|Plot { title, points, range, ticks, bounds, .. }| {
        let points = points.iter().map(|(at, value)| [round(at.as_secs_f64(), 1e3), round(*value, 1e6)]);
        json!({ "title": title, "points": points.collect::<Vec<_>>(), "range": range, "ticks": ticks, "bounds": bounds })
    });
    json!({
        "began": view.date(Duration::ZERO).map(|began| began.timestamp_millis()),
        "end": round(timeline.end().as_secs_f64(), 1e3),
        "axis": axis,
        "groups": groups,
        "looks": looks.all,
        "events": happenings.iter().map(Happening::data).collect::<Vec<_>>(),
        "held": happenings.iter().flat_map(Happening::held).collect::<Vec<_>>(),
        "plots": plots.collect::<Vec<_>>(),
    })
}
