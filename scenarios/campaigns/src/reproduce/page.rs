//! The results as a page: the paper's claims and how often they were true, then its figures; what this project adds,
//! how this system differs from the published one, and how to run everything again.

use std::path::Path;

use diagnostics::Staging;
use drawing::Frame;
use maud::{Markup, html};
use reports::html::{Drawing, Layout, NARROW, document, figure, picture, row, section, table};

use super::deviations::{DEVIATIONS, Deviation};
use super::film::SEED;
use super::shots::{self, Shows};
use super::{ClaimResult, ExperimentResult, FIGURE_MONITORS, FILES, Reproduction, Still};
use crate::Error;

const PAPER: &str = "Colledanchise, Cicala, Domenichelli, Natale, Tacchella: Formalizing the Execution Context of Behavior Trees \
                     for Runtime Verification of Deliberative Policies (IROS 2021)";

impl Reproduction {
    /// Writes the results as `reproduce.json` and as a page, `index.html`, to a folder.
    ///
    /// # Errors
    /// [`Error::Scenario`] if they cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let staging = Staging::begin(folder)?;
        let [data, shown] = FILES;
        staging.write(data, serde_json::to_string_pretty(self).expect("results are always JSON") + "\n")?;
        staging.write(shown, page(self))?;
        Ok(staging.publish(&FILES)?)
    }
}

/// One self-contained page.
fn page(reproduction: &Reproduction) -> String {
    let figures = figures(reproduction);
    let main = html! {
        header.head {
            p.over { "A service robot under runtime monitors" }
            h1 { "The paper’s experiments, run again in simulation" }
            p.about { (reproduction.outcome()) }
            p.about {
                "Everything on this page was simulated, even experiment 3, for which the paper used a real robot."
            }
            p.quiet { (PAPER) }
            p.quiet {
                "steward " (reproduction.version) " · "
                @if reproduction.seeds == 1 { "seed 1" } @else { "seeds 1 to " (reproduction.seeds) }
                @if !reproduction.settings.is_empty() { " · " code { (reproduction.settings.join(" ")) } }
            }
            nav {
                a href="#claims" { "What the paper says" }
                @for figure in &figures { a href={ "#" (figure.id()) } { (figure.short()) } }
                a href="#ours" { "What is ours" }
                a href="#deviations" { "Differences" }
                a href="#again" { "Run it again" }
            }
        }
        (claims(&reproduction.experiments, reproduction.seeds))
        @for figure in figures { (figure.section()) }
        (ours(reproduction))
        (deviations())
        (again(reproduction))
    };
    document("The paper’s experiments, run again in simulation", &main)
}

/// The paper's claims about each experiment, and in how many runs they were true.
fn claims(experiments: &[ExperimentResult], seeds: u64) -> Markup {
    let all = html! {
        div.pairs {
            @for experiment in experiments {
                article.panel {
                    h3 { (experiment.title) }
                    p.quiet { (experiment.here) }
                    (rows(&experiment.claims, seeds))
                    p.note { code { "steward run " (experiment.scenario) } }
                }
            }
        }
    };
    section("claims", "What the paper says, and in how many simulated runs it was true", all)
}

fn rows(claims: &[ClaimResult], seeds: u64) -> Markup {
    html! { table.claims { tbody { @for claim in claims { (claim_row(claim, seeds)) } } } }
}

fn claim_row(claim: &ClaimResult, seeds: u64) -> Markup {
    html! {
        tr {
            th scope="row" {
                (claim.says)
                span.note { (claim.source) }
                @for difference in &claim.differences {
                    span.note.bad { "seed " (difference.seed) ": " (difference.found) }
                }
            }
            td.(if claim.holds() { "satisfied" } else { "violated" }) { (claim.runs) " of " (seeds) }
        }
    }
}

/// A figure of the paper with its panels.
struct Figure {
    title: &'static str,
    /// What applies to all panels.
    about: Markup,
    panels: Markup,
}

/// The figures in the order of the paper.
fn figures(reproduction: &Reproduction) -> Vec<Figure> {
    let shot = |title, about| Figure { title, about, panels: panels(reproduction, title) };
    let none = Markup::default;
    let simulated = || html! { p.quiet { "The paper shows a real robot; these are pictures of a simulated one." } };
    vec![
        shot(shots::FIGURE_1, none()),
        figure_2(reproduction),
        figure_3(),
        Figure { title: "Figure 4: the requirements as properties", about: none(), panels: properties(reproduction) },
        shot(shots::FIGURE_5, two_monitors(reproduction)),
        shot(shots::FIGURE_6, none()),
        shot(shots::FIGURE_7, simulated()),
        shot(shots::FIGURE_8, simulated()),
    ]
}

/// The system and its surroundings.
fn figure_2(reproduction: &Reproduction) -> Figure {
    let context = figure("Processes and channels", |layout| picture::context(&reproduction.context, layout));
    Figure {
        title: "Figure 2: the tree and its surrounding context",
        about: html! {
            p.quiet {
                "Drawn from the channels of the system that ran. The paper’s figure shows five of the seven skills and \
                 two components. A line with two heads stands for two channels, one in each direction; each holds one message."
            }
        },
        panels: whole(
            &context,
            &html! {
                "The triangle stands for the tree’s process, gray boxes for skills, blue ones for components, lines for \
                 channels."
            },
        ),
    }
}

/// The language of the properties.
fn figure_3() -> Figure {
    Figure {
        title: "Figure 3: the grammar of SCOPE",
        about: Markup::default(),
        panels: whole(
            &html! { pre { code { (monitors::GRAMMAR.trim_end()) "\nrelop      = < | > | <= | >= | = | !=" } } },
            &html! {
                "The grammar with which the properties below are parsed: the paper’s, and what this project adds to it, \
                 such as the past; with the abbreviations false, implies, eventually and always. " code { "cargo doc --open -p steward-monitors" } " has the semantics."
            },
        ),
    }
}

/// A panel as wide as the page.
fn whole(content: &Markup, caption: &Markup) -> Markup {
    html! { figure.panel.whole { (content) figcaption { (caption) } } }
}

impl Figure {
    fn id(&self) -> String {
        self.short().to_lowercase().replace(' ', "-")
    }

    /// The beginning of the title.
    fn short(&self) -> &'static str {
        self.title.split(':').next().unwrap_or(self.title)
    }

    /// The scenes in pairs, then the machines, as in the paper.
    fn section(&self) -> Markup {
        section(&self.id(), self.title, html! { (self.about) div.pairs { (self.panels) } })
    }
}

/// φ1 and φ2 as in their files.
fn properties(reproduction: &Reproduction) -> Markup {
    let notes = [
        ("phi1", "φ1, as the paper prints it."),
        (
            "phi2",
            "φ2, with the parenthesis that is missing in the paper: both antecedent and consequent belong inside “always”. \
             θ = 10 is the published code’s.",
        ),
    ];
    let of = |(name, note): (&str, &str)| {
        let file = reproduction.properties.iter().find(|(file, _)| file.contains(&format!("{name}.")))?;
        let command = format!("steward monitor explain {name}");
        let caption = html! { (note) span.note { code { (command) } } };
        Some(whole(&html! { pre { code { (file.1.trim_end()) } } }, &caption))
    };
    html! { @for panel in notes.into_iter().filter_map(of) { (panel) } }
}

/// How the verdicts of the published response monitor and of the formula differ.
fn two_monitors(reproduction: &Reproduction) -> Markup {
    let run = reproduction.experiments.iter().find(|experiment| experiment.scenario == "skill_bug");
    let ticks = run.and_then(|experiment| experiment.runs.first());
    let tick = |name: &str| ticks.and_then(|run| run.violated_at_tick.get(name));
    let (Some(formula), Some(figure)) = (tick("phi2"), tick("figure_5b")) else { return Markup::default() };
    html! {
        p {
            "All four watch the same runs. Their verdicts differ in one way: the published response monitor sets its \
             timer to θ, subtracts 1 at each tick and fails on the tick that finds it at 0, which is tick θ + 1; φ2 \
             requires the command in fewer than θ ticks, and the monitor made from it fails on tick θ. In experiment 2 with seed 1, \
             where the low level is read at tick " (formula.saturating_sub(10)) ", they fail at the ticks " (figure)
            " and " (formula) "."
        }
    }
}

/// The panels of a figure that show a moment.
fn panels(reproduction: &Reproduction, title: &str) -> Markup {
    let stills = reproduction.stills.iter().enumerate().filter(|(_, still)| still.shot.figure == title);
    html! { @for (number, still) in stills { (panel(number, still, &reproduction.settings)) } }
}

fn panel(number: usize, still: &Still, settings: &[String]) -> Markup {
    let (shot, frame) = (still.shot, &still.frame);
    let letter = if shot.panel.is_empty() { String::new() } else { format!("({}) ", shot.panel) };
    let name = format!("panel-{number}");
    let (drawing, whole) = match shot.shows {
        Shows::Tree => (figure(shot.caption, |layout| picture::tree(&frame.tree, layout)), true),
        Shows::Scene => {
            let drawing = |scene| figure(shot.caption, |layout| picture::scene(scene, &name, layout));
            (frame.scene.as_ref().map(drawing).unwrap_or_default(), false)
        }
        Shows::Monitor(property) => machine(frame, property, None, shot.caption),
        Shows::Passing(property, state) => machine(frame, property, Some(state), shot.caption),
    };
    html! {
        figure.panel.whole[whole] {
            (drawing)
            figcaption {
                strong { (letter) } (shot.caption)
                span.note { (below(still)) }
                span.note { (reports::html::command(&command(still, settings))) }
            }
        }
    }
}

/// The monitor of a property, in the given state or else in its present one; and whether it needs the page's width.
fn machine(frame: &Frame, property: &str, state: Option<&str>, label: &str) -> (Markup, bool) {
    let Some(monitor) = frame.monitors.iter().find(|monitor| monitor.name == property) else {
        return (Markup::default(), false);
    };
    let mut diagram = monitor.diagram.clone();
    let wanted = state.and_then(|state| diagram.locations.iter().position(|location| location.name == state));
    diagram.active = wanted.unwrap_or(diagram.active);
    let width = |layout| picture::machine(&diagram, layout).width;
    let whole = width(Layout::Wide) > picture::HALF;
    let swiped = width(Layout::Narrow) > NARROW;
    let drawing = figure(label, |layout| -> Drawing { picture::machine(&diagram, layout) });
    (html! { div.swipe tabindex="0" { (drawing) } @if swiped { p.quiet.narrow { "Swipe to see the rest." } } }, whole)
}

/// The command that makes a picture of the moment, with the map, the tree, the battery and all monitors.
fn command(still: &Still, settings: &[String]) -> String {
    let (shot, time_s) = (still.shot, still.frame.time.as_secs_f64());
    let quoted = |setting: &str| format!(" --set '{setting}'");
    let mut command = format!("steward run {} --seed {SEED} --set 'snapshots.at_s=[{time_s:.2}]'", shot.scenario);
    // Maps name the monitors that have been violated.
    let shows_more = match shot.shows {
        Shows::Scene => true,
        Shows::Monitor(name) | Shows::Passing(name, _) => name.starts_with("figure_"),
        Shows::Tree => false,
    };
    if shows_more {
        FIGURE_MONITORS.iter().for_each(|setting| command += &quoted(setting));
    }
    settings.iter().for_each(|setting| command += &quoted(setting));
    command
}

/// Further remarks on a moment.
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
        Shows::Scene => {
            let level_pct = frame.battery.as_ref().map(|battery| battery.level_pct);
            format!("{when}: the battery is at {:.1} %.", level_pct.unwrap_or_default())
        }
        Shows::Monitor(property) => format!("{when}: {}.", stands(property).unwrap_or_default()),
        Shows::Passing(_, state) => format!(
            "{when}. According to the caption, the monitor waits in {state} for the reply to a request. In Figure 5 \
             (a), in the published machine and here, it enters {state} with the reply and leaves it in the same step: \
             it does not watch the request."
        ),
    }
}

/// The parts that the paper does not have.
fn ours(reproduction: &Reproduction) -> Markup {
    let content = html! {
        p {
            "The paper has none of this. φ3 (" code { "phi3" } ") is a property of this project: below 30 %, the \
             robot is at the station in fewer than 120 ticks. The scenarios " code { "never_arrives" } ", " code { "already_there" } ", "
            code { "late_halt" } " and " code { "early_release" } " are also this project’s, and not part of these runs."
        }
        div.pairs {
            @for experiment in &reproduction.experiments {
                article.panel { h3 { (experiment.title) } (rows(&experiment.ours, reproduction.seeds)) }
            }
        }
        h3 { "Pictures of experiment 2, for which the paper has no figure" }
        div.pairs { (panels(reproduction, shots::EXPERIMENT_2)) }
    };
    section("ours", "What is ours", content)
}

fn deviations() -> Markup {
    let rows = html! { @for Deviation { of, published, here } in &DEVIATIONS { (row(of, [published, here])) } };
    let table = table("deviations", ["Of", "In the paper and its published code", "Here"], &rows);
    section("deviations", "Where this system differs from the published one", html! { div.panel { (table) } })
}

/// The commands, and the hashes that identify the same runs elsewhere.
fn again(reproduction: &Reproduction) -> Markup {
    let settings: String = reproduction.settings.iter().map(|setting| format!(" --set '{setting}'")).collect();
    let hashes = |ExperimentResult { scenario, runs, .. }: &ExperimentResult| {
        html! {
            details.again {
                summary { (scenario) ": trace hashes of " (diagnostics::counted(runs.len(), "run")) }
                p.note { code { "steward run " (scenario) " --no-snapshots --json" (settings) " --seed SEED" } }
                table {
                    thead { tr { th { "seed" } th { "trace hash" } } }
                    tbody { @for run in runs { tr { td { (run.seed) } td { code { (run.trace_hash) } } } } }
                }
            }
        }
    };
    let commands = html! {
        div.panel {
            p {
                "This whole page: "
                code { "steward reproduce --seeds " (reproduction.seeds) (options(&reproduction.settings)) }
                ". A panel’s command is below it; the picture is in " code { "out/" } "."
            }
            p {
                "steward " (reproduction.version) " gives a run the same trace hash on every machine with the same \
                 target: it covers every message and, step by step, the true pose, odometry, battery and scans. Monitors do not affect \
                 it. Each \
                 command prints it as " code { "trace_hash" } "."
            }
            @for experiment in &reproduction.experiments { (hashes(experiment)) }
        }
    };
    section("again", "Run it again", commands)
}

/// The settings as options of `steward reproduce`.
fn options(settings: &[String]) -> String {
    let option = |setting: &String| {
        let (key, value) = setting.split_once('=')?;
        Some(format!(" --{} {}", key.rsplit('.').next()?, value.trim_matches(['[', ']'])))
    };
    settings.iter().filter_map(option).collect()
}
