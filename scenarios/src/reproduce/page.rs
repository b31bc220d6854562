//! The results as a page: what the paper says and how often it was so, then its figures, one by one.

use super::film::SEED;
use super::shots::Shows;
use super::{ClaimResult, ExperimentResult, Reproduction, Still};
use crate::draw::Frame;
use crate::html::{Drawing, document, escape, figure, picture};

const PAPER: &str = "Colledanchise, Cicala, Domenichelli, Natale, Tacchella: Formalizing the Execution Context of Behavior Trees \
                     for Runtime Verification of Deliberative Policies (IROS 2021)";

/// One self-contained page.
pub(super) fn page(reproduction: &Reproduction) -> String {
    let runs = reproduction.seeds * reproduction.experiments.len() as u64;
    let outcome = match reproduction.is_as_printed() {
        true => format!("All {runs} runs are as the paper says."),
        false => format!("Not all of the {runs} runs are as the paper says."),
    };
    let figures = figures(&reproduction.stills);
    let links: String =
        figures.iter().map(|figure| format!("<a href=\"#{}\">{}</a>", figure.id(), figure.short())).collect();
    let main = format!(
        "<header class=\"head\">\n<p class=\"over\">A service robot under runtime monitors</p>\n<h1>The paper’s experiments, run \
         again</h1>\n<p class=\"about\">{outcome}</p>\n<p class=\"quiet\">{PAPER} · {} seeds of each experiment</p>\n\
         <nav><a href=\"#claims\">What the paper says</a>{links}</nav>\n</header>\n{}{}",
        reproduction.seeds,
        claims(&reproduction.experiments, reproduction.seeds),
        figures.iter().map(Figure::section).collect::<String>(),
    );
    document("The paper’s experiments, run again", &main)
}

/// What the paper says of each experiment, and in how many runs it was so.
fn claims(experiments: &[ExperimentResult], seeds: u64) -> String {
    let one = |experiment: &ExperimentResult| {
        let rows: String = experiment.claims.iter().map(|claim| row(claim, seeds)).collect();
        format!(
            "<article class=\"panel\"><h3>{}</h3>\n<p class=\"quiet\">Scenario <code>{2}</code>: <code>steward --scenario \
             {2}</code></p>\n<table class=\"claims\"><tbody>\n{1}</tbody></table></article>\n",
            escape(experiment.title),
            rows,
            escape(experiment.scenario),
        )
    };
    let all: String = experiments.iter().map(one).collect();
    format!(
        "<section id=\"claims\">\n<h2>What the paper says, and in how many runs it was so</h2>\n<div class=\"pairs\">{all}</div>\n</section>\n"
    )
}

fn row(claim: &ClaimResult, seeds: u64) -> String {
    let class = if claim.differences.is_empty() { "satisfied" } else { "violated" };
    let difference = |difference: &super::Difference| {
        format!("<span class=\"note bad\">seed {}: {}</span>", difference.seed, escape(&difference.found))
    };
    let differences: String = claim.differences.iter().map(difference).collect();
    format!(
        "<tr><th scope=\"row\">{}<span class=\"note\">{}</span>{differences}</th><td class=\"{class}\">{} of {seeds}</td></tr>\n",
        escape(claim.says),
        escape(claim.source),
        claim.runs,
    )
}

/// A figure of the paper with its panels.
struct Figure<'a> {
    number: usize,
    title: &'static str,
    panels: Vec<(usize, &'a Still)>,
}

/// The stills by figure, in their order, each still with a number of its own.
fn figures(stills: &[Still]) -> Vec<Figure<'_>> {
    let mut figures: Vec<Figure<'_>> = Vec::new();
    for (number, still) in stills.iter().enumerate() {
        match figures.last_mut().filter(|figure| figure.title == still.shot.figure) {
            Some(figure) => figure.panels.push((number, still)),
            None => {
                let title = still.shot.figure;
                figures.push(Figure { number: figures.len(), title, panels: vec![(number, still)] });
            }
        }
    }
    figures
}

impl Figure<'_> {
    fn id(&self) -> String {
        format!("figure-{}", self.number)
    }

    /// What the title begins with.
    fn short(&self) -> &'static str {
        self.title.split([':', ',']).next().unwrap_or(self.title)
    }

    /// The scenes two beside each other, then the machines, as in the paper.
    fn section(&self) -> String {
        let panels: String = self.panels.iter().map(|(number, still)| panel(*number, still)).collect();
        format!(
            "<section id=\"{}\">\n<h2>{}</h2>\n<div class=\"pairs\">\n{panels}</div>\n</section>\n",
            self.id(),
            self.title
        )
    }
}

fn panel(number: usize, still: &Still) -> String {
    let (shot, frame) = (still.shot, &still.frame);
    let letter = if shot.panel.is_empty() { String::new() } else { format!("({}) ", shot.panel) };
    let name = format!("panel-{number}");
    let drawing = match shot.shows {
        Shows::Tree => figure(shot.caption, |layout| picture::tree(&frame.tree, layout)),
        Shows::Scene => figure(shot.caption, |layout| picture::scene(&frame.scene, &name, layout)),
        Shows::Monitor(property) => machine(frame, property, None, shot.caption),
        Shows::Passing(property, state) => machine(frame, property, Some(state), shot.caption),
    };
    format!(
        "<figure class=\"panel\">{drawing}<figcaption><strong>{letter}</strong>{}<span class=\"note\">{}</span></figcaption></figure>\n",
        escape(shot.caption),
        escape(&below(still)),
    )
}

/// The monitor of a property; in that state, if one is given, else where it stands.
fn machine(frame: &Frame, property: &str, state: Option<&str>, label: &str) -> String {
    let Some(monitor) = frame.monitors.iter().find(|monitor| monitor.name == property) else { return String::new() };
    let mut diagram = monitor.diagram.clone();
    let wanted = state.and_then(|state| diagram.locations.iter().position(|location| location.name == state));
    diagram.active = wanted.unwrap_or(diagram.active);
    figure(label, |layout| -> Drawing { picture::machine(&diagram, layout) })
}

/// What else there is to say of a moment.
fn below(still: &Still) -> String {
    let (shot, frame) = (still.shot, &still.frame);
    let when = format!("{}, seed {SEED}, {:.2} s", shot.scenario, frame.time.as_secs_f64());
    let monitor = |property: &str| frame.monitors.iter().find(|monitor| monitor.name == property);
    let stands = |property: &str| {
        let diagram = &monitor(property)?.diagram;
        Some(format!("the monitor of {property} is in the state {}", diagram.locations.get(diagram.active)?.name))
    };
    match shot.shows {
        Shows::Tree => format!("{when}: what each node answered to the first tick."),
        Shows::Scene => format!("{when}: the battery is at {:.1} %.", frame.battery.level_pct),
        Shows::Monitor(property) => format!("{when}: {}.", stands(property).unwrap_or_default()),
        Shows::Passing(property, state) => format!(
            "{property}’s monitor passes through {state} with each level that is read, and leaves it in the same step: the \
             request of a level is no event that φ1 speaks of."
        ),
    }
}
