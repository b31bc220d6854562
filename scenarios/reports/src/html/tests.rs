//! Charts of whole runs, in both layouts: texts do not overlap and stay inside.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use drawing::{Area, Renderer};
use recording::{Detail, End, Ended, Header, Origin, RunView, Step, conduct};
use runs::Run;
use scenarios::scenario::{Scenario, find};

use super::evidence::Evidence;
use super::figure::{Drawing, Layout};
use super::sequence::{self, Sequence};
use super::{activities, chart, map};
use crate::timeline::Timeline;

/// A run of a shipped scenario up to a time.
fn run(name: &str, overrides: &[&str], until_s: u64) -> (RunView, Timeline) {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let scenario = Scenario::load(&find::find(name).unwrap(), &overrides).unwrap();
    let run = Run::new(Arc::new(scenario), 1, true).unwrap();
    let goes_on = |view: &RunView| {
        let over = view.time() >= Duration::from_secs(until_s);
        if over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let begin = |view: &RunView| Ok::<_, scenarios::Error>(Timeline::new(view));
    let (timeline, view) = conduct(run, Detail::Full, None, begin, goes_on).unwrap();
    (view, timeline)
}

/// Checks a drawing as the snapshots' renderer sees it.
fn look_at(what: &str, drawing: Drawing) {
    let whole = Area::new(0.0, 0.0, drawing.width, drawing.height);
    let svg = drawing.canvas.finish(drawing.width, drawing.height);
    assert!(svg.len() < 400_000, "{what} takes {} bytes", svg.len());
    let texts = Renderer::new().texts(&svg).unwrap();
    assert!(!texts.is_empty(), "{what} says nothing");
    for (i, (text, area)) in texts.iter().enumerate() {
        assert!(whole.encloses(area), "{what}: {text:?} leaves the drawing: {area:?}");
        for (other, other_area) in &texts[..i] {
            assert!(!area.inset(0.3).overlaps(other_area), "{what}: {text:?} overlaps {other:?}");
        }
    }
}

fn look_at_all(what: &str, view: &RunView, timeline: &Timeline) {
    let activities = activities::activities(timeline);
    let scene = map::scene(view, timeline).unwrap();
    for layout in [Layout::Wide, Layout::Narrow] {
        look_at(&format!("{what}, timeline, {layout:?}"), chart::draw(view, timeline, layout).0);
        look_at(&format!("{what}, map, {layout:?}"), map::draw(&scene, &activities, &[], layout));
        for episode in timeline.episodes() {
            let evidence = Evidence::of(episode, view);
            let sequence = Sequence::of(&evidence, view.topology(), view.faults(), view.moves());
            assert!((2..=12).contains(&sequence.lifelines.len()), "{:?}", sequence.lifelines);
            assert!(sequence.rows.len() < 80, "{} rows", sequence.rows.len());
            look_at(&format!("{what}, {}, {layout:?}", evidence.name), sequence::draw(&sequence, layout));
        }
    }
}

#[test]
fn the_first_experiment_is_drawn_without_overlaps() {
    let (view, timeline) = run("battery_fault", &[], 60);
    assert_eq!(timeline.episodes().len(), 1);
    look_at_all("battery_fault", &view, &timeline);
}

#[test]
fn a_complete_charge_is_drawn_without_overlaps() {
    let (view, timeline) = run("nominal", &[], 1490);
    look_at_all("nominal", &view, &timeline);
}

#[test]
fn many_faults_do_not_crowd_each_other_out() {
    let faults = (0..40).map(|i| format!("{{kind=\"battery_level\",at_s={},level_pct={}}}", 2 + i, 90 - 2 * (i % 8)));
    let faults = format!("faults=[{}]", faults.collect::<Vec<_>>().join(","));
    let (view, timeline) = run("battery_fault", &[&faults], 45);
    look_at("timeline", chart::draw(&view, &timeline, Layout::Narrow).0);
    look_at("timeline", chart::draw(&view, &timeline, Layout::Wide).0);
    let scene = map::scene(&view, &timeline).unwrap();
    look_at("map", map::draw(&scene, &activities::activities(&timeline), &[], Layout::Narrow));
}

#[test]
fn a_run_that_never_rests_is_still_a_small_drawing() {
    let (view, mut timeline) = run("battery_fault", &[], 20);
    timeline.shake(Duration::from_secs(3600));
    look_at("timeline", chart::draw(&view, &timeline, Layout::Wide).0);
    look_at("timeline", chart::draw(&view, &timeline, Layout::Narrow).0);
    let table = super::facts::stages(&activities::activities(&timeline), true).into_string();
    assert_eq!(table.matches("<tr>").count(), 42, "the heading, 40 stages, and the number of others");
}

#[test]
fn a_run_in_which_nothing_exists_and_nothing_happens_has_a_page() {
    for recorded in [None, Some("steward verify empty.jsonl".to_owned())] {
        let header = Header { origin: Origin { recorded, ..Origin::default() }, ..Header::default() };
        let mut view = RunView::new(header, Step::default()).unwrap();
        let timeline = Timeline::new(&view);
        let end = End {
            ended: Ended::Recorded,
            trace_hash: String::new(),
            monitors: vec![],
            skill_errors: vec![],
            messages_hit: vec![],
            scene: None,
        };
        view.finish(end.clone()).unwrap();
        let report = crate::reporting::report(&view, &end, Vec::new(), Duration::ZERO);
        let page = super::page(&view, &timeline, &report, &[]);
        assert!(page.contains("No property was watched in this run."), "{page}");
        assert!(!page.contains("NaN") && !page.contains("inf"), "{page}");
        for layout in [Layout::Wide, Layout::Narrow] {
            look_at("the timeline of nothing", chart::draw(&view, &timeline, layout).0);
        }
    }
}
