//! A campaign's report as a page: `report.html`, one self-contained file.
//!
//! It is made only from the journal, which is read in a few passes, in memory that does not grow with the number of
//! runs. The same campaign gives the same bytes on any number of cores, resumed or not, sharded or not.

mod against;
mod axis;
mod charts;
mod frontier;
mod histogram;
mod instructive;
mod passes;
mod plot;
mod runs;
mod survey;
mod target;

use drawing::scale::short;
use maud::{Markup, html};
use reports::html::{document, figure, row, section, table, text};

use super::Measure;
use super::journal::{Layout, ParameterLayout};
use super::statistics::{Confidence, Count, Interval};
use super::summary::{Estimate, Share, Summary};

use axis::Axis;
pub(super) use passes::survey;
use plot::written;
pub(super) use survey::Survey;
use survey::{Pair, ParameterSurvey};

/// The maximum number of heat maps.
const MOST_MAPS: usize = 12;
/// The number of bars in a histogram.
const BARS: usize = 24;

/// The page of a campaign.
pub(super) fn page(summary: &Summary, layout: &Layout, survey: &Survey) -> String {
    let page = Page { summary, layout, survey };
    let main = html! {
        (page.head())
        (page.rates())
        (page.frontier())
        (page.parameters())
        (page.pairs())
        (page.measures())
        (page.latencies())
        (page.instructive())
        (page.failures())
        (page.all_runs())
        (page.data())
    };
    document(&format!("{} · {} runs", summary.campaign, survey.runs), &main)
}

/// The data for the sections of the page.
struct Page<'p> {
    summary: &'p Summary,
    layout: &'p Layout,
    survey: &'p Survey,
}

/// Charts side by side below a text that applies to all of them; empty without charts.
fn charts_below(lead: &Markup, charts: &Markup) -> Markup {
    html! { @if !charts.0.is_empty() { (lead) div.pairs { (charts) } } }
}

/// A chart beside others.
fn chart(title: &str, drawing: &Markup, caption: Option<&str>) -> Markup {
    html! {
        div.panel {
            h3 { (title) }
            figure { (drawing) @if let Some(caption) = caption { figcaption { (caption) } } }
        }
    }
}

/// A parameter's name for people.
fn title(parameter: &ParameterLayout) -> &str {
    parameter.about.as_deref().unwrap_or(&parameter.key)
}

/// A parameter's short name.
fn name(parameter: &ParameterLayout) -> &str {
    parameter.name.as_deref().unwrap_or(&parameter.key)
}

fn percent(rate: f64) -> String {
    format!("{}\u{a0}%", short(100.0 * rate))
}

/// Whether there is hardly more than one run for each value or range of values.
fn is_thin(counts: &[Count]) -> bool {
    let runs: u64 = counts.iter().map(|count| count.runs()).sum();
    runs < 2 * counts.iter().filter(|count| count.runs() > 0).count() as u64
}

/// The ends of an interval of probabilities, to a hundredth of a percent.
fn interval(interval: Interval) -> String {
    format!("{:.2} to {:.2}\u{a0}%", 100.0 * interval.low, 100.0 * interval.high)
}

impl Page<'_> {
    fn head(&self) -> Markup {
        let Summary { campaign, scenario, runs, version, outcomes, .. } = self.summary;
        html! {
            header.head {
                p.over { "A campaign with a service robot under runtime monitors" }
                h1 { (campaign) }
                p.about { (text(&self.layout.about)) }
                p.quiet {
                    (runs) " runs of " code { (scenario) } ", which differ in " (self.what_varies()) " · "
                    @if self.summary.expects { (outcomes.as_expected) " as expected, " (outcomes.not_as_expected) " not, " }
                    @else { "nothing expected of them, " }
                    (outcomes.failed) " failed · steward " (version)
                }
            }
        }
    }

    fn what_varies(&self) -> Markup {
        let parameters = &self.layout.parameters;
        html! {
            @if parameters.is_empty() { "their seeds" }
            @for (place, parameter) in parameters.iter().enumerate() {
                @if place > 0 { ", " }
                code { (parameter.key) }
            }
        }
    }

    fn rates(&self) -> Markup {
        // The bars are boxes with a style, not drawings, so that they are as wide as the page leaves them.
        let share = |name: &str, what: &str, share: Share, notes: &Markup| {
            let (count, Interval { low, high }) = (share.count, share.interval);
            let range = format!("left:{:.2}%;width:{:.2}%", 100.0 * low, 100.0 * (high - low));
            let rate = format!("left:{:.2}%", 100.0 * share.rate.unwrap_or(0.0));
            html! {
                tr {
                    th scope="row" { strong { (name) } span.note { (what) } }
                    td { (count.happened()) " of " (count.runs()) (notes) }
                    td { (share.rate.map_or("–".to_owned(), percent)) }
                    td { (interval(share.interval)) }
                    td.bar { span.rate { i style=(range) {} b style=(rate) {} } }
                }
            }
        };
        // What is open may be a violation: it stands in a row of the same size.
        let line = |name: &str, estimate: &Estimate, what: &str| {
            let notes = html! {
                @if let Some(all) = estimate.repeated() { span.note { (all.to_string()) } }
                @if let Some(runs @ 1..) = estimate.vacuous { span.note { "vacuous in " (runs) } }
            };
            html! {
                (share(name, what, estimate.happened(), &notes))
                @if let Some(open) = estimate.open() {
                    (share(name, "inconclusive: something was still pending at the end", open, &Markup::default()))
                }
            }
        };
        let (listed, groups) = self.summary.by_rate();
        let group = |group: &[&Estimate]| {
            let names: Vec<&str> = group.iter().map(|estimate| estimate.of.as_str()).collect();
            line(&format!("{} properties", group.len()), group[0], &format!("violated, each: {}", names.join(", ")))
        };
        let rows = html! {
            @for estimate in listed { (line(&estimate.of, estimate, "violated")) }
            @for alike in &groups { (group(alike)) }
            @if self.summary.expects || self.summary.outcomes.failed > 0 {
                @let what = "not met: the run was not as the scenario expects, or it failed";
                (line(&self.summary.expectation.of, &self.summary.expectation, what))
            }
        };
        let content = html! {
            div.panel {
                (table("rates", ["property", "runs", "rate", "95\u{a0}% interval", "from 0 to 100\u{a0}%"], &rows))
                p.quiet {
                    "The intervals are those of Clopper and Pearson: they contain the true rate in 95\u{a0}% of all \
                     campaigns like this one. With other parameters or other ranges, the rates would be different."
                }
                (self.goal())
            }
            (self.patterns())
        };
        section("rates", "How often", content)
    }

    fn goal(&self) -> Markup {
        let Some(goal) = &self.summary.goal else { return Markup::default() };
        let answer = match (goal.interval, goal.side) {
            (Some(goal), _) => format!("the probability lies in {}", interval(goal)),
            (None, Some(side)) => format!("the probability is {} the bound", side.name()),
            (None, None) => "undecided".to_owned(),
        };
        let reached = if goal.reached { "reached" } else { "not reached" };
        html! { p { "Goal " (reached) " for " strong { (goal.of) } " after " (goal.count.runs()) " runs: " (answer) "." } }
    }

    /// For each parameter, a chart for each target.
    fn parameters(&self) -> Markup {
        let with_axis = self.layout.parameters.iter().zip(&self.survey.parameters);
        let charts = html! { @for (layout, parameter) in with_axis { (self.parameter(layout, parameter)) } };
        let lead = html! {
            p {
                "Each point is the rate in one part of a parameter’s range; the line through it is the 95\u{a0}% \
                 interval. All other parameters vary at the same time."
            }
        };
        section("parameters", "What it depends on", charts_below(&lead, &charts))
    }

    fn parameter(&self, layout: &ParameterLayout, parameter: &ParameterSurvey) -> Markup {
        let Some(axis) = &parameter.axis else { return Markup::default() };
        let one = |target: usize| {
            let event = self.survey.targets[target].event();
            let counts: Vec<_> = parameter.rates.iter().map(|counts| counts[target]).collect();
            match axis {
                // Names have no order and need room, so a table shows them better than a chart.
                Axis::Classes(values) if values.iter().any(|value| value.number().is_none()) => html! {
                    div.panel {
                        h3 { (event) }
                        table {
                            thead { tr { @for name in [title(layout), "runs", "95\u{a0}% interval"] { th { (name) } } } }
                            tbody {
                                @for (value, count) in values.iter().zip(&counts) {
                                    (row(written(value), [
                                        format!("{} of {}", count.happened(), count.runs()),
                                        interval(count.interval(Confidence::OF_RESULTS)),
                                    ]))
                                }
                            }
                        }
                    }
                },
                // A rate needs more than a run.
                _ if is_thin(&counts) => Markup::default(),
                _ => {
                    let label = format!("Rate of {event} against {}", title(layout));
                    let draw = |size| charts::rates(axis, &counts, title(layout), size);
                    chart(&event, &figure(&label, draw), None)
                }
            }
        };
        html! { @for target in &self.survey.drawn { (one(*target)) } }
    }

    /// A heat map for each pair of parameters.
    fn pairs(&self) -> Markup {
        let asked = self.survey.model.as_ref().map(|model| model.target);
        // Maps are many: a model is about one event, and the others have their charts.
        let targets: Vec<usize> = match asked {
            Some(target) => vec![target],
            None => self.survey.drawn.clone(),
        };
        let wanted = targets.len() * self.survey.pairs.len();
        let each = targets.iter().flat_map(|target| self.survey.pairs.iter().map(move |pair| (*target, pair)));
        let map = |(target, pair): (usize, &Pair)| {
            let [a, b] = pair.across.map(|place| (&self.layout.parameters[place], &self.survey.parameters[place]));
            let (Some(x), Some(y)) = (&a.1.axis, &b.1.axis) else { return Markup::default() };
            let event = self.survey.targets[target].event();
            let cells: Vec<Vec<_>> =
                pair.cells.iter().map(|column| column.iter().map(|counts| counts[target]).collect()).collect();
            let label = format!("Rate of {event} by {} and {}", title(a.0), title(b.0));
            let draw = |size| charts::heat_map([x, y], [title(a.0), title(b.0)], &cells, size);
            chart(&event, &figure(&label, draw), None)
        };
        let lead = html! {
            p {
                "The color of each cell shows its rate, in percent: green is 0, red 100. Grey cells have no run."
                @if wanted > MOST_MAPS { " The first " (MOST_MAPS) " of " (wanted) " maps are drawn." }
            }
        };
        let maps = html! { @for each in each.take(MOST_MAPS) { (map(each)) } };
        section("pairs", "Two parameters at a time", charts_below(&lead, &maps))
    }

    /// The measurements against each parameter.
    fn measures(&self) -> Markup {
        let parameters = self.layout.parameters.iter().zip(&self.survey.parameters);
        let charts = parameters.flat_map(|(layout, parameter)| {
            parameter.measures.iter().filter_map(move |(measure, histograms)| {
                let axis = parameter.axis.as_ref()?;
                let about = measure.about();
                let label = format!("{about} against {}", title(layout));
                let draw = |size| charts::measured(axis, histograms, title(layout), size);
                Some(chart(&text(about), &figure(&label, draw), None))
            })
        });
        let lead = html! { p { "The line is the median; the band contains the middle 80\u{a0}% of the runs." } };
        let charts = html! { @for chart in charts { (chart) } };
        let known = self.survey.parameters.first().map_or(&[][..], |parameter| &parameter.measures);
        let mut silent = self.layout.measures.clone();
        silent.retain(|measure| known.iter().all(|(known, _)| known != measure));
        let silent: Vec<&str> = silent.into_iter().map(Measure::about).collect();
        let measured = html! {
            (charts_below(&lead, &charts))
            @if !silent.is_empty() && !self.survey.parameters.is_empty() {
                p.note { "No run has a value of: " (silent.join("; ")) "." }
            }
        };
        section("measures", "What was measured", measured)
    }

    fn latencies(&self) -> Markup {
        let each = self.survey.targets.iter().zip(&self.survey.latencies);
        let charts = each.filter_map(|(target, latencies)| {
            let latencies = latencies.as_ref()?;
            let quantile = |share| short(latencies.quantile(share).unwrap_or(0.0));
            let bars = latencies.coarser(BARS);
            let label = format!("Time from the first fault to {}", target.event());
            let draw = |size| charts::histogram(&bars, "time from the first fault to the violation, s", size);
            let caption = format!(
                "{} violations after a fault: half of them within {} s, 90\u{a0}% within {} s, all within {} s.",
                latencies.total(),
                quantile(0.5),
                quantile(0.9),
                short(latencies.scale.high)
            );
            Some(chart(&target.event(), &figure(&label, draw), Some(&caption)))
        });
        let charts = html! { @for chart in charts { (chart) } };
        section("latency", "How soon a fault is detected", charts_below(&Markup::default(), &charts))
    }

    fn data(&self) -> Markup {
        let files = html! {
            div.panel {
                ul {
                    li {
                        code { "dataset.parquet" }
                        ": one row per run, with parameters, verdicts, times and measurements"
                    }
                    li { code { "summary.json" } ": the rates of this page, as data" }
                    li { code { "timing.csv" } ": how long each run took on the computer that ran it" }
                }
            }
        };
        section("data", "The numbers behind it", files)
    }
}
