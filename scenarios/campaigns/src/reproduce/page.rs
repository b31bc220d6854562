//! The results as a page: what the paper says and how often it was so, then its figures, one by one; what is this project's
//! own, where the system differs from the published one, and how to run everything again.

use std::path::Path;

use diagnostics::Staging;
use drawing::Frame;
use reports::html::{Drawing, document, escape, figure, picture};

use super::deviations::{DEVIATIONS, Deviation};
use super::film::SEED;
use super::shots::{self, Shows};
use super::{ClaimResult, ExperimentResult, FIGURE_MONITORS, Reproduction, Still, runs};
use crate::Error;

const PAPER: &str = "Colledanchise, Cicala, Domenichelli, Natale, Tacchella: Formalizing the Execution Context of Behavior Trees \
                     for Runtime Verification of Deliberative Policies (IROS 2021)";

impl Reproduction {
    /// Writes the results as `reproduce.json` and as a page, `index.html`, to a folder.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let staging = Staging::begin(folder)?;
        staging.write("reproduce.json", serde_json::to_string_pretty(self).expect("results are always JSON") + "\n")?;
        staging.write("index.html", page(self))?;
        Ok(staging.publish(&["reproduce.json", "index.html"])?)
    }
}

/// One self-contained page.
fn page(reproduction: &Reproduction) -> String {
    let figures = figures(reproduction);
    let links: String =
        figures.iter().map(|figure| format!("<a href=\"#{}\">{}</a>", figure.id(), figure.short())).collect();
    let settings = match reproduction.settings.as_slice() {
        [] => String::new(),
        settings => format!(" · <code>{}</code>", escape(&settings.join(" "))),
    };
    let main = format!(
        "<header class=\"head\">\n<p class=\"over\">A service robot under runtime monitors</p>\n<h1>The paper’s experiments, run \
         again in simulation</h1>\n<p class=\"about\">{}</p>\n<p class=\"about\">Everything on this page was simulated, \
         experiment 3 too, for which the paper used a real robot.</p>\n<p class=\"quiet\">{PAPER}</p>\n\
         <p class=\"quiet\">steward {} · seeds 1 to {}{settings}</p>\n<nav><a href=\"#claims\">What the paper \
         says</a>{links}<a href=\"#ours\">What is ours</a><a href=\"#deviations\">Differences</a><a href=\"#again\">ExperimentRun it \
         again</a></nav>\n</header>\n{}{}{}{}{}",
        escape(&reproduction.outcome()),
        reproduction.version,
        reproduction.seeds,
        claims(&reproduction.experiments, reproduction.seeds),
        figures.iter().map(Figure::section).collect::<String>(),
        ours(reproduction),
        deviations(),
        again(reproduction),
    );
    document("The paper’s experiments, run again in simulation", &main)
}

/// What the paper says of each experiment, and in how many runs it was so.
fn claims(experiments: &[ExperimentResult], seeds: u64) -> String {
    let one = |experiment: &ExperimentResult| {
        format!(
            "<article class=\"panel\"><h3>{}</h3>\n<p class=\"quiet\">{}</p>\n{}<p class=\"note\"><code>steward --scenario \
             {}</code></p></article>\n",
            escape(experiment.title),
            escape(experiment.here),
            rows(&experiment.claims, seeds),
            escape(experiment.scenario),
        )
    };
    let all: String = experiments.iter().map(one).collect();
    format!(
        "<section id=\"claims\">\n<h2>What the paper says, and in how many simulated runs it was so</h2>\n<div \
         class=\"pairs\">{all}</div>\n</section>\n"
    )
}

fn rows(claims: &[ClaimResult], seeds: u64) -> String {
    let rows: String = claims.iter().map(|claim| row(claim, seeds)).collect();
    format!("<table class=\"claims\"><tbody>\n{rows}</tbody></table>\n")
}

fn row(claim: &ClaimResult, seeds: u64) -> String {
    let class = if claim.holds() { "satisfied" } else { "violated" };
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
struct Figure {
    title: &'static str,
    /// What a reader has to know of all panels: markup.
    about: String,
    panels: Vec<String>,
}

/// The figures in the order of the paper.
fn figures(reproduction: &Reproduction) -> Vec<Figure> {
    let shot = |title, about: String| Figure { title, about, panels: panels(reproduction, title) };
    let plain = |title, about: &str, panel: String| Figure { title, about: about.to_owned(), panels: vec![panel] };
    let simulated =
        || "<p class=\"quiet\">The paper shows a real robot; these are pictures of a simulated one.</p>".to_owned();
    vec![
        shot(shots::FIGURE_1, String::new()),
        plain(
            "Figure 2: the tree and its surrounding context",
            "<p class=\"quiet\">Drawn from the channels of the system that ran. The paper’s figure shows five of the seven skills \
             and two components. A line with two heads is a channel each way; each holds one message.</p>",
            format!(
                "<figure class=\"panel whole\">{}<figcaption>The triangle stands for the tree’s process, grey boxes for skills, \
                 blue ones for components, lines for channels.</figcaption></figure>\n",
                figure("Processes and channels", |layout| picture::context(&reproduction.context, layout))
            ),
        ),
        plain(
            "Figure 3: the grammar of SCOPE",
            "",
            format!(
                "<figure class=\"panel whole\"><pre><code>{}\nrelop      = &lt; | &gt; | &lt;= | &gt;= | = | !=</code></pre>\
                 <figcaption>The paper’s grammar, which the properties below are read with, and its abbreviations false, implies, \
                 eventually and always. <code>cargo doc --open -p steward-monitors</code> has the semantics.</figcaption></figure>\n",
                preformatted(monitors::GRAMMAR)
            ),
        ),
        Figure {
            title: "Figure 4: the requirements as properties",
            about: String::new(),
            panels: properties(reproduction),
        },
        shot(shots::FIGURE_5, two_monitors(reproduction)),
        shot(shots::FIGURE_6, String::new()),
        shot(shots::FIGURE_7, simulated()),
        shot(shots::FIGURE_8, simulated()),
    ]
}

impl Figure {
    fn id(&self) -> String {
        self.short().to_lowercase().replace(' ', "-")
    }

    /// What the title begins with.
    fn short(&self) -> &'static str {
        self.title.split(':').next().unwrap_or(self.title)
    }

    /// The scenes two beside each other, then the machines, as in the paper.
    fn section(&self) -> String {
        format!(
            "<section id=\"{}\">\n<h2>{}</h2>\n{}<div class=\"pairs\">\n{}</div>\n</section>\n",
            self.id(),
            escape(self.title),
            self.about,
            self.panels.concat(),
        )
    }
}

/// φ1 and φ2 as their files have them.
fn properties(reproduction: &Reproduction) -> Vec<String> {
    let notes = [
        ("phi1", "φ1, as the paper prints it."),
        (
            "phi2",
            "φ2, with the parenthesis that the paper’s print leaves out: antecedent and consequence both belong inside “always”. \
             θ = 10 is the published code’s.",
        ),
    ];
    let of = |(name, note): (&str, &str)| {
        let file = reproduction.properties.iter().find(|(file, _)| file.contains(&format!("{name}.")))?;
        Some(format!(
            "<figure class=\"panel whole\"><pre><code>{}</code></pre><figcaption>{note}<span class=\"note\"><code>steward monitor \
             explain monitors/properties/{name}.scope</code></span></figcaption></figure>\n",
            preformatted(file.1.trim_end())
        ))
    };
    notes.into_iter().filter_map(of).collect()
}

/// Where the verdicts of the published response monitor and of the formula differ.
fn two_monitors(reproduction: &Reproduction) -> String {
    let run = reproduction.experiments.iter().find(|experiment| experiment.scenario == "skill_bug");
    let ticks = run.and_then(|experiment| experiment.runs.first());
    let tick = |name: &str| ticks.and_then(|run| run.violated_at_tick.get(name));
    let (Some(formula), Some(figure)) = (tick("phi2"), tick("figure_5b")) else { return String::new() };
    format!(
        "<p>All four watch the same runs. Their verdicts differ in one way: the published response monitor sets its timer to θ, takes one \
         away at each tick and fails on the tick that finds it at 0, the tick θ + 1; φ2 asks for the command in less than θ ticks, \
         and the monitor made from it fails on the tick θ. In experiment 2 with seed 1, where the low level is read at tick \
         {}, they fail at the ticks {figure} and {formula}.</p>",
        formula.saturating_sub(10),
    )
}

/// Text whose lines stay lines.
fn preformatted(text: &str) -> String {
    text.lines().map(escape).collect::<Vec<_>>().join("\n")
}

/// The panels of a figure that are stills.
fn panels(reproduction: &Reproduction, title: &str) -> Vec<String> {
    let stills = reproduction.stills.iter().enumerate().filter(|(_, still)| still.shot.figure == title);
    stills.map(|(number, still)| panel(number, still, &reproduction.settings)).collect()
}

fn panel(number: usize, still: &Still, settings: &[String]) -> String {
    let (shot, frame) = (still.shot, &still.frame);
    let letter = if shot.panel.is_empty() { String::new() } else { format!("({}) ", shot.panel) };
    let name = format!("panel-{number}");
    let (drawing, whole) = match shot.shows {
        Shows::Tree => (figure(shot.caption, |layout| picture::tree(&frame.tree, layout)), true),
        Shows::Scene => (figure(shot.caption, |layout| picture::scene(&frame.scene, &name, layout)), false),
        Shows::Monitor(property) => machine(frame, property, None, shot.caption),
        Shows::Passing(property, state) => machine(frame, property, Some(state), shot.caption),
    };
    let class = if whole { "panel whole" } else { "panel" };
    format!(
        "<figure class=\"{class}\">{drawing}<figcaption><strong>{letter}</strong>{}<span class=\"note\">{}</span><span \
         class=\"note\"><code>{}</code></span></figcaption></figure>\n",
        escape(shot.caption),
        escape(&below(still)),
        escape(&command(still, settings)),
    )
}

/// The monitor of a property; in that state, if one is given, else where it stands. Also, whether it needs the page's width.
fn machine(frame: &Frame, property: &str, state: Option<&str>, label: &str) -> (String, bool) {
    let Some(monitor) = frame.monitors.iter().find(|monitor| monitor.name == property) else {
        return (String::new(), false);
    };
    let mut diagram = monitor.diagram.clone();
    let wanted = state.and_then(|state| diagram.locations.iter().position(|location| location.name == state));
    diagram.active = wanted.unwrap_or(diagram.active);
    let whole = picture::machine(&diagram, reports::html::Layout::Wide).width > picture::HALF;
    (figure(label, |layout| -> Drawing { picture::machine(&diagram, layout) }), whole)
}

/// The command that makes a picture of the moment, with the map, the tree, the battery and all monitors.
fn command(still: &Still, settings: &[String]) -> String {
    let (shot, time_s) = (still.shot, still.frame.time.as_secs_f64());
    let quoted = |setting: &str| format!(" --set '{setting}'");
    let mut command =
        format!("steward --scenario {} --seed {SEED} --set 'snapshots.at_s=[{time_s:.2}]'", shot.scenario);
    if let Shows::Monitor(name) | Shows::Passing(name, _) = shot.shows
        && name.starts_with("figure_")
    {
        command += &quoted(FIGURE_MONITORS);
    }
    settings.iter().for_each(|setting| command += &quoted(setting));
    command
}

/// What else there is to say of a moment.
fn below(still: &Still) -> String {
    let (shot, frame) = (still.shot, &still.frame);
    let when = format!("{}, seed {SEED}, {:.2} s", shot.scenario, frame.time.as_secs_f64());
    let monitor = |property: &str| frame.monitors.iter().find(|monitor| monitor.name == property);
    let stands = |property: &str| {
        let diagram = &monitor(property)?.diagram;
        Some(format!("{property} is in the state {}", diagram.locations.get(diagram.active)?.name))
    };
    match shot.shows {
        Shows::Tree => format!("{when}: what each node answered to the first tick."),
        Shows::Scene => format!("{when}: the battery is at {:.1} %.", frame.battery.level_pct),
        Shows::Monitor(property) => format!("{when}: {}.", stands(property).unwrap_or_default()),
        Shows::Passing(_, state) => format!(
            "{when}. The caption has the monitor wait in {state} for the reply to a request. In Figure 5 (a), in the published \
             machine and here it enters {state} with the reply, and leaves it in the same step: the request is not watched."
        ),
    }
}

/// What the paper does not have.
fn ours(reproduction: &Reproduction) -> String {
    let seeds = reproduction.seeds;
    let one = |experiment: &ExperimentResult| {
        format!(
            "<article class=\"panel\"><h3>{}</h3>\n{}</article>\n",
            escape(experiment.title),
            rows(&experiment.ours, seeds)
        )
    };
    let claims: String = reproduction.experiments.iter().map(one).collect();
    format!(
        "<section id=\"ours\">\n<h2>What is ours</h2>\n<p>The paper has none of this. φ3 (<code>phi3</code>) is a property of this \
         project: below 30 % the robot is at the station within 120 ticks. The scenarios <code>never_arrives</code>, \
         <code>already_there</code>, <code>late_halt</code> and <code>early_release</code> are this project’s as well, and no part of these \
         runs.</p>\n\
         <div class=\"pairs\">{claims}</div>\n<h3>Pictures of experiment 2, for which the paper has no figure</h3>\n<div \
         class=\"pairs\">\n{}</div>\n</section>\n",
        panels(reproduction, shots::EXPERIMENT_2).concat(),
    )
}

fn deviations() -> String {
    let row = |Deviation { of, published, here }: &Deviation| {
        format!(
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>\n",
            escape(of),
            escape(published),
            escape(here)
        )
    };
    let rows: String = DEVIATIONS.iter().map(row).collect();
    format!(
        "<section id=\"deviations\">\n<h2>Where this system differs from the published one</h2>\n<div class=\"panel\"><table \
         class=\"deviations\"><thead><tr><th></th><th>In the paper and its published code</th><th>Here</th></tr></thead><tbody>\n\
         {rows}</tbody></table></div>\n</section>\n"
    )
}

/// The commands, and the hashes by which the same runs are recognised elsewhere.
fn again(reproduction: &Reproduction) -> String {
    let settings: String = reproduction.settings.iter().map(|setting| format!(" --set '{setting}'")).collect();
    let hashes = |experiment: &ExperimentResult| {
        let row = |run: &super::RunResult| {
            format!("<tr><td>{}</td><td><code>{}</code></td></tr>\n", run.seed, run.trace_hash)
        };
        let rows: String = experiment.runs.iter().map(row).collect();
        format!(
            "<details><summary>{0}: trace hashes of {1}</summary>\n<p class=\"note\"><code>{2}</code></p>\n<table><thead><tr><th>seed</th>\
             <th>trace hash</th></tr></thead><tbody>\n{rows}</tbody></table></details>\n",
            escape(experiment.scenario),
            runs(experiment.runs.len() as u64),
            escape(&format!("steward --scenario {} --no-snapshots --json{settings} --seed SEED", experiment.scenario)),
        )
    };
    let hashes: String = reproduction.experiments.iter().map(hashes).collect();
    let options = options(&reproduction.settings);
    format!(
        "<section id=\"again\">\n<h2>ExperimentRun it again</h2>\n<div class=\"panel\">\n<p>All of this page: <code>steward reproduce --seeds \
         {}{}</code>. A panel’s own command stands below it; the picture is in <code>out/</code>.</p>\n<p>steward {} gives a run the same \
         trace hash on every machine of a target: it covers every message and, step by step, the true pose, odometry, \
         battery and scans. Monitors do not enter. Each command prints it as <code>trace_hash</code>.</p>\n{hashes}</div>\n</section>\n",
        reproduction.seeds,
        escape(&options),
        reproduction.version,
    )
}

/// The settings as `steward reproduce` takes them.
fn options(settings: &[String]) -> String {
    let option = |setting: &String| {
        let (key, value) = setting.split_once('=')?;
        Some(format!(" --{} {}", key.rsplit('.').next()?, value.trim_matches(['[', ']'])))
    };
    settings.iter().filter_map(option).collect()
}
