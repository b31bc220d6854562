//! States over time, as bars in lanes.

use std::time::Duration;

use drawing::canvas::{Anchor, Paint, TextStyle};
use drawing::icons::{Icon, Look};
use drawing::text::{Font, Weight};
use drawing::theme::{self, Color};
use drawing::{Area, NodeStatus, Verdict};
use monitors::{Violation, Violations};
use recording::{NavigationStatus, RunView};
use serde_json::{Value, json};

use super::looks::{Looks, variable};
use super::sheet::Chart;
use crate::html::activities::{self, Activity};
use crate::html::words;
use crate::timeline::{Interval, Lane, MonitorState, Timeline, Track};

/// Lanes that belong together.
pub(super) struct Group {
    title: &'static str,
    /// Whether the list of stages explains the colors.
    is_listed: bool,
    lanes: Vec<Bars>,
    /// The words for lanes in which nothing ever happens, and the names of these lanes.
    resting: (&'static str, Vec<String>),
}

/// A lane: a name and its bars.
struct Bars {
    name: String,
    bars: Vec<Bar>,
}

/// A stretch of time in a lane.
#[derive(Clone)]
struct Bar {
    from: Duration,
    to: Duration,
    text: String,
    style: BarStyle,
}

#[derive(Clone, Copy, PartialEq)]
struct BarStyle {
    ground: Color,
    outline: Color,
    ink: Color,
    icon: Option<Icon>,
}

impl BarStyle {
    const fn new(ground: Color, outline: Color, ink: Color) -> Self {
        Self { ground, outline, ink, icon: None }
    }

    /// A state that is neither good nor bad.
    const NEUTRAL: Self = Self::new(theme::PAPER, theme::LINE, theme::INK);
    /// States too short to be drawn individually.
    const CROWD: Self = Self::new(theme::SOLID, theme::LINE, theme::INK);
    /// A property of which something must still happen.
    const WAITING: Self = Self::new(theme::PAPER, theme::GOOD, theme::INK);
    /// A property that was violated before.
    const AFTER: Self = Self::new(theme::BAD_LIGHT, theme::BAD, theme::INK);
    /// Rest: hardly there.
    const QUIET: Self = Self::new(theme::IDLE_LIGHT, theme::RULE, theme::MUTED);

    fn status(status: NodeStatus) -> Self {
        let look = Look::of_status(status);
        Self { icon: Some(look.icon), ..Self::new(look.ground, look.front, theme::INK) }
    }

    fn navigation(status: NavigationStatus) -> Self {
        match status {
            NavigationStatus::GoalReached => Self::status(NodeStatus::Success),
            NavigationStatus::Aborted | NavigationStatus::Error | NavigationStatus::Failing => {
                Self::status(NodeStatus::Failure)
            }
            NavigationStatus::Moving
            | NavigationStatus::Thinking
            | NavigationStatus::PreparingBeforeMove
            | NavigationStatus::WaitingObstacle => Self::status(NodeStatus::Running),
            NavigationStatus::Idle => Self::QUIET,
            NavigationStatus::Paused => Self::NEUTRAL,
        }
    }

    /// The style of a state of a machine, a program or a component. The author of a machine chooses the names of its
    /// states, and a recording has nothing else of them: a state with one of these names is taken to mean this.
    fn of_name(name: &str) -> Self {
        let means = |words: &[&str]| words.iter().any(|word| name == *word || name.ends_with(&format!(": {word}")));
        match () {
            () if means(&["success"]) => Self::status(NodeStatus::Success),
            () if means(&["failure", "aborted", "error", "failing"]) => Self::status(NodeStatus::Failure),
            () if means(&["running", "moving", "thinking"]) => Self::status(NodeStatus::Running),
            () if means(&["idle", "rest", "halted"]) => Self::QUIET,
            () => Self::NEUTRAL,
        }
    }
}

/// All lanes of a run except the battery's.
pub(super) fn groups(view: &RunView, timeline: &Timeline) -> Vec<Group> {
    let end = timeline.end();
    let navigation = bars("navigation's status", timeline.navigation(), end, |navigation| {
        (navigation.words(), BarStyle::navigation(navigation.status))
    });
    let mut components: Vec<Bars> = Some(navigation).into_iter().filter(|lane| !lane.bars.is_empty()).collect();
    components.extend(timeline.components().iter().map(|lane| named(lane, end)));
    let leaves = timeline.leaves().iter().map(|lane| {
        bars(&lane.name, &lane.track, end, |status| {
            let words = Look::of_status(*status).words;
            (if *status == NodeStatus::NotTicked { String::new() } else { words.to_owned() }, BarStyle::status(*status))
        })
    });
    let ending = |property: usize| view.monitors().nth(property).and_then(|monitor| monitor.ending().violations);
    let monitors = timeline.monitors().iter().enumerate();
    let monitors = monitors.map(|(property, lane)| monitor(lane, ending(property), end));
    // A recording may lack a tree.
    let activities = if timeline.leaves().is_empty() { Vec::new() } else { vec![activities(timeline)] };
    let skills = timeline.skills().iter().map(|lane| skill(lane, timeline));
    let group = |title, rest, lanes: Vec<Bars>| {
        let (resting, lanes): (Vec<Bars>, Vec<Bars>) = lanes.into_iter().partition(Bars::is_at_rest);
        let resting = resting.into_iter().map(|lane| lane.name).collect();
        Group { title, is_listed: false, lanes, resting: (rest, resting) }
    };
    let never = if view.header().knows_ticks() { "never ticked" } else { "no answer is known" };
    let groups = vec![
        Group { is_listed: true, ..group("What the tree was doing", "never for longer than a moment", activities) },
        group("Leaves of the behavior tree", never, leaves.collect()),
        group("States of the skills", "never away from rest for longer than a moment", skills.collect()),
        group("Components", "never away from rest for longer than a moment", components),
        group("Monitors", "", monitors.collect()),
    ];
    groups.into_iter().filter(|group| !group.lanes.is_empty() || !group.resting.1.is_empty()).collect()
}

impl Group {
    /// For the script: title, lanes, and those in which nothing happens.
    pub(super) fn data(&self, looks: &mut Looks) -> Value {
        let (what, names) = &self.resting;
        let rest = if names.is_empty() { String::new() } else { format!("{what}: {}", names.join(", ")) };
        let lanes: Vec<Value> = self.lanes.iter().map(|lane| lane.data(looks)).collect();
        json!({ "title": self.title, "lanes": lanes, "rest": rest })
    }
}

impl Bars {
    /// For the script: each bar's length in milliseconds and its look, or -1 where there is none.
    fn data(&self, looks: &mut Looks) -> Value {
        let mut bars = Vec::new();
        let mut last_ms = 0;
        for Bar { from, to, text, style } in &self.bars {
            let [from_ms, to_ms] = [from, to].map(|time| time.as_millis() as i64);
            if from_ms > last_ms {
                bars.extend([from_ms - last_ms, -1]);
            }
            let sign = match style.icon {
                Some(Icon::Check) => "✓ ",
                Some(Icon::Cross) => "✗ ",
                Some(Icon::Play) => "▸ ",
                _ => "",
            };
            let is_line = style.icon == Some(Icon::Dash);
            let ground = if is_line { String::new() } else { variable(style.ground) };
            let look = [format!("{sign}{text}"), ground, variable(style.outline), variable(style.ink)];
            bars.extend([to_ms - from_ms.max(last_ms), looks.number(look) as i64]);
            last_ms = to_ms;
        }
        json!({ "name": self.name, "bars": bars })
    }

    fn is_at_rest(&self) -> bool {
        self.bars.iter().all(|bar| [BarStyle::QUIET, BarStyle::status(NodeStatus::NotTicked)].contains(&bar.style))
    }
}

/// A monitor's lane: the verdict on its property, and since when something is due; of one that goes on after a
/// violation, each violation.
fn monitor(lane: &Lane<MonitorState>, violations: Option<Violations>, end: Duration) -> Bars {
    let bar = |span: Interval<'_, MonitorState>| {
        let MonitorState { verdict, is_open } = *span.state;
        let text = match verdict {
            Verdict::Violated => "violated".to_owned(),
            Verdict::Satisfied => "satisfied".to_owned(),
            _ if is_open => format!("waiting since {}", words::time(span.from)),
            _ => "undecided".to_owned(),
        };
        let style = if is_open && verdict == Verdict::HoldsSoFar { BarStyle::WAITING } else { verdict_style(verdict) };
        Bar { from: span.from, to: span.to, text, style }
    };
    let mut bars: Vec<Bar> = lane.track.spans(end).map(bar).collect();
    // What changes with the last event has no length, and is the verdict.
    if let [.., before, last] = bars.as_mut_slice()
        && last.from == last.to
    {
        last.from = before.from.max(end - shortest(end));
        before.to = last.from;
    }
    if let Some(Violations { first, goes_on: true, .. }) = violations
        && let Some(violated) = bars.pop_if(|last| last.style == verdict_style(Verdict::Violated))
    {
        bars.extend(each_violation(&violated, &first));
    }
    Bars { name: lane.name.clone(), bars }
}

/// What takes no time is drawn this long, so that it can be seen.
fn shortest(end: Duration) -> Duration {
    end / 150
}

/// A bar for each violation, and for the time after it; one that was over at once can still be seen.
fn each_violation(violated: &Bar, all: &[Violation]) -> Vec<Bar> {
    let end = violated.to;
    let ends = all.iter().map(|violation| {
        let until = violation.until.map_or(end, |until| until.time);
        until.max(violation.from.time + shortest(end)).min(end)
    });
    let nexts = all.iter().skip(1).map(|next| next.from.time).chain([end]);
    let bars = all.iter().zip(ends).zip(nexts).flat_map(|((violation, until), next)| {
        let after = Bar { from: until, to: next, text: "violated before".to_owned(), style: BarStyle::AFTER };
        [Bar { from: violation.from.time, to: until.min(next), ..violated.clone() }, after]
    });
    bars.filter(|bar| bar.from < bar.to).collect()
}

/// A lane whose states are names.
fn named(lane: &Lane<String>, end: Duration) -> Bars {
    bars(&lane.name, &lane.track, end, |state| (state.clone(), BarStyle::of_name(state)))
}

/// A skill's lane: the state of its machine, in gray while the tree does not ask it.
fn skill(lane: &Lane<String>, timeline: &Timeline) -> Bars {
    let end = timeline.end();
    let leaf = timeline.leaves().iter().find(|leaf| leaf.name == lane.name);
    let Some(leaf) = leaf else { return named(lane, end) };
    // A bar ends when the state changes, or when the tree starts or stops asking the skill.
    let (mut states, mut asked) = (lane.track.spans(end).peekable(), leaf.track.spans(end).peekable());
    let mut bars: Vec<Bar> = Vec::new();
    while let (Some(state), Some(status)) = (states.peek(), asked.peek()) {
        let (from, to) = (state.from.max(status.from), state.to.min(status.to));
        let is_asked = *status.state != NodeStatus::NotTicked;
        let style = if is_asked { BarStyle::of_name(state.state) } else { BarStyle::QUIET };
        match bars.last_mut().filter(|last| last.text == *state.state && last.style == style) {
            Some(last) => last.to = to,
            None if from < to => bars.push(Bar { from, to, text: state.state.clone(), style }),
            None => {}
        }
        if state.to <= status.to {
            states.next();
        } else {
            asked.next();
        }
    }
    Bars { name: lane.name.clone(), bars }
}

/// The meaning of the colors in the visible lanes.
pub(super) fn colors(view: &RunView, groups: &[Group], charts: &[Chart]) -> String {
    let silent =
        if view.header().knows_ticks() { "a leaf that is not ticked" } else { "no answer of the leaf is known" };
    let silent = format!("a thin line: {silent}");
    let lanes = || groups.iter().filter(|group| !group.is_listed).flat_map(|group| &group.lanes);
    let drawn = |chart: &Chart| lanes().flat_map(|lane| chart.drawable(&lane.bars)).collect::<Vec<_>>();
    let bars: Vec<(f64, f64, Bar)> = charts.iter().flat_map(drawn).collect();
    let has = |style: BarStyle| bars.iter().any(|(left, right, bar)| right - left > 4.0 && bar.style == style);
    let colors = [
        (has(BarStyle::status(NodeStatus::Success)), "green with ✓: success"),
        (has(BarStyle::status(NodeStatus::Failure)), "red with ✗: failure"),
        (has(BarStyle::status(NodeStatus::Running)), "orange: running"),
        (has(BarStyle::QUIET), "gray: at rest, or a skill that is not asked"),
        (has(BarStyle::status(NodeStatus::NotTicked)), silent.as_str()),
        (has(BarStyle::NEUTRAL), "an empty bar: another state"),
        (has(verdict_style(Verdict::HoldsSoFar)), "pale green: a property that nothing has violated so far"),
        (has(BarStyle::WAITING), "an empty bar with a green edge: a property for which something must still happen"),
        (has(verdict_style(Verdict::Satisfied)), "solid green: a property that is satisfied for good"),
        (has(verdict_style(Verdict::Violated)), "solid red: a property that is violated"),
        (has(BarStyle::AFTER), "pale red: a property that was violated before"),
    ];
    let there: Vec<&str> = colors.into_iter().filter(|(is_there, _)| *is_there).map(|(_, words)| words).collect();
    words::sentence(&there.join("; "))
}

fn verdict_style(verdict: Verdict) -> BarStyle {
    match verdict {
        Verdict::Violated => {
            BarStyle { icon: Some(Icon::Cross), ..BarStyle::new(theme::BAD, theme::BAD, theme::PAPER) }
        }
        Verdict::Satisfied => {
            BarStyle { icon: Some(Icon::Check), ..BarStyle::new(theme::GOOD, theme::GOOD, theme::PAPER) }
        }
        Verdict::HoldsSoFar | Verdict::Inconclusive => BarStyle::new(theme::GOOD_LIGHT, theme::GOOD, theme::INK),
    }
}

fn activities(timeline: &Timeline) -> Bars {
    let bar = |activity: Activity| {
        let style = match activity.stage.doing.as_str() {
            "" => BarStyle::QUIET,
            _ => BarStyle::new(activity.color, activity.color, theme::PAPER),
        };
        let text = activity.number.map_or(String::new(), |number| format!("{number} {}", activity.words()));
        Bar { from: activity.stage.from, to: activity.stage.to, text, style }
    };
    Bars { name: "running leaf".to_owned(), bars: activities::activities(timeline).into_iter().map(bar).collect() }
}

fn bars<S>(name: &str, track: &Track<S>, end: Duration, show: impl Fn(&S) -> (String, BarStyle)) -> Bars {
    let bar = |span: Interval<'_, S>| {
        let (text, style) = show(span.state);
        Bar { from: span.from, to: span.to, text, style }
    };
    Bars { name: name.to_owned(), bars: track.spans(end).map(bar).collect() }
}

/// The most lanes of a group in the drawing; the script shows all.
const MOST_LANES: usize = 100;

/// A narrower bar is drawn together with its neighbors, in pixels.
const NARROWEST: f64 = 8.0;

impl Chart {
    pub(super) fn heading(&mut self, title: &str) {
        let font = Font { weight: Weight::Bold, ..self.sizes.font };
        self.y += 6.0;
        let at = (1.0, self.y + font.line_height() / 2.0);
        self.canvas.centered_text(at, title, TextStyle::new(font, theme::INK).with_halo());
        self.y += font.line_height() + 6.0;
    }

    pub(super) fn group(&mut self, group: &Group) {
        self.breaks.push(self.y);
        self.heading(group.title);
        for (number, lane) in group.lanes.iter().take(MOST_LANES).enumerate() {
            // A title alone at the end would belong to nothing.
            if number > 0 {
                self.breaks.push(self.y);
            }
            self.lane(lane);
        }
        if let Some(more) = group.lanes.len().checked_sub(MOST_LANES).filter(|more| *more > 0) {
            self.resting(&format!("{more} more are not drawn on paper, or without scripts"));
        }
        let (what, names) = &group.resting;
        if !names.is_empty() {
            self.resting(&format!("{what}: {}", names.join(", ")));
        }
        self.y += 6.0;
    }

    /// Lanes in which nothing happens, in words.
    fn resting(&mut self, text: &str) {
        /// More lines than this would not be read.
        const MOST: usize = 12;
        let font = self.sizes.small;
        for line in font.wrap(text, self.sizes.width - 14.0 - self.plot.x, MOST) {
            let at = (self.plot.x, self.y + font.line_height() / 2.0);
            self.canvas.centered_text(at, &line, TextStyle::new(font, theme::MUTED).with_halo());
            self.y += font.line_height();
        }
    }

    fn lane(&mut self, lane: &Bars) {
        let sizes = self.sizes;
        let name_style = TextStyle::new(sizes.font, theme::MUTED);
        let top = if sizes.names_above {
            let room = sizes.width - self.plot.x;
            let at = (self.plot.x, self.y + sizes.font.line_height() / 2.0);
            self.canvas.centered_text(at, &sizes.font.fit_ends(&lane.name, room), name_style.with_halo());
            self.y + sizes.font.line_height() + 1.0
        } else {
            let at = (self.plot.x - 10.0, self.y + sizes.lane / 2.0);
            let name = sizes.font.fit_ends(&lane.name, self.plot.x - 14.0);
            self.canvas.centered_text(at, &name, name_style.anchored(Anchor::End));
            self.y
        };
        for (left, right, bar) in self.drawable(&lane.bars) {
            self.bar(Area::new(left, top, right - left, sizes.lane - 1.0), &bar);
        }
        self.y += sizes.pitch();
    }

    /// Whether there are states too short to be drawn individually.
    pub(super) fn is_crowded(&self, groups: &[Group]) -> bool {
        let lanes = groups.iter().flat_map(|group| &group.lanes);
        lanes.flat_map(|lane| self.drawable(&lane.bars)).any(|(.., bar)| bar.style == BarStyle::CROWD)
    }

    fn drawable(&self, bars: &[Bar]) -> Vec<(f64, f64, Bar)> {
        drawable(bars, |time| self.axis.x(time))
    }

    fn bar(&mut self, area: Area, bar: &Bar) {
        let style = bar.style;
        let quiet = style.icon == Some(Icon::Dash);
        if quiet {
            // Not ticked: only a line.
            let y = area.center().1;
            let paint = Paint::stroke(theme::RULE, 1.5);
            self.canvas.line((area.x + 2.0, y), ((area.right() - 2.0).max(area.x + 2.0), y), paint);
            return;
        }
        let gap = if area.width > 4.0 { 0.6 } else { 0.0 };
        let body = Area::new(area.x + gap, area.y, (area.width - 2.0 * gap).max(1.2), area.height);
        self.canvas.rounded(body, 3.5, Paint::fill(style.ground).outlined(style.outline, 1.0));
        let mut left = body.x + 6.0;
        if let Some(icon) = style.icon.filter(|_| body.width >= 16.0) {
            let size = self.sizes.small.size * 0.85;
            let ink = if style.ink == theme::PAPER { style.ink } else { style.outline };
            icon.draw(&mut self.canvas, (body.x + 4.0 + size / 2.0, body.center().1), size, ink);
            left += size + 2.0;
        }
        let room = body.right() - 3.0 - left;
        let text = match self.sizes.small.width(&bar.text) <= room {
            true => bar.text.clone(),
            // The beginning of a name is better than nothing, unless it is very short.
            false => {
                Some(self.sizes.small.fit(&bar.text, room)).filter(|text| text.chars().count() > 8).unwrap_or_default()
            }
        };
        self.canvas.centered_text((left, body.center().1), &text, TextStyle::new(self.sizes.small, style.ink));
    }
}

/// The bars from left to right; adjacent narrow bars become one bar, with a color only if all of them look alike.
fn drawable(bars: &[Bar], x: impl Fn(Duration) -> f64) -> Vec<(f64, f64, Bar)> {
    let mut drawn: Vec<(f64, f64, Bar)> = Vec::new();
    let mut crowded = false;
    for bar in bars {
        let (left, right) = (x(bar.from), x(bar.to));
        let narrow = right - left < NARROWEST;
        match drawn.last_mut().filter(|_| narrow && crowded) {
            Some((_, end, last)) => {
                *end = right;
                if (last.style, &last.text) != (bar.style, &bar.text) {
                    (last.style, last.text) = (BarStyle::CROWD, "changes".to_owned());
                }
            }
            None => drawn.push((left, right, bar.clone())),
        }
        crowded = narrow;
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_bars_that_look_alike_keep_their_color() {
        let bars = |states: &[(&str, BarStyle)]| {
            let times = (0..).map(Duration::from_secs);
            let bars = times.zip(states).map(|(from, (text, style))| {
                let to = from + Duration::from_secs(1);
                Bar { from, to, text: (*text).to_owned(), style: *style }
            });
            let drawn = drawable(&bars.collect::<Vec<_>>(), |time| time.as_secs_f64());
            drawn.into_iter().map(|(_, right, bar)| (right, bar.text, bar.style == BarStyle::CROWD)).collect::<Vec<_>>()
        };
        let [violated, waiting] = [("violated", BarStyle::AFTER), ("waiting", BarStyle::WAITING)];
        assert_eq!(bars(&[violated; 3]), [(3.0, "violated".to_owned(), false)]);
        assert_eq!(bars(&[violated, violated, waiting, waiting]), [(4.0, "changes".to_owned(), true)]);
    }
}
