//! A campaign's report as a page: `report.html`, one self-contained file.
//!
//! It is made of the journal alone, read in a few passes in memory that does not grow with the number of runs; the same
//! campaign gives the same bytes, on any number of cores, resumed, sharded or neither.

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
use reports::html::{document, escape, figure, text};

use super::journal::{JournalReader, Layout, ParameterLayout};
use super::statistics::{Confidence, Interval};
use super::summary::{Estimate, Summary};
use crate::Error;

use axis::Axis;
use plot::written;
use survey::{ParameterSurvey, Survey};

/// The page's file.
pub(super) const FILE: &str = "report.html";
/// The confidence of the intervals that charts show.
const CONFIDENCE: f64 = 0.95;
/// No more heat maps than this.
const MOST_MAPS: usize = 12;
/// Bars of a histogram.
const BARS: usize = 24;

/// The page of the campaign whose journal `journal` opens.
///
/// # Errors
/// If the journal cannot be read.
pub(super) fn page(
    summary: &Summary,
    layout: &Layout,
    journal: impl Fn() -> Result<JournalReader, Error>,
) -> Result<String, Error> {
    let survey = passes::survey(layout, journal)?;
    let confidence = Confidence::new(CONFIDENCE).map_err(|error| Error::refused(error.to_string(), ""))?;
    let page = Page { summary, layout, survey: &survey, confidence };
    let sections = [
        page.rates(),
        page.frontier(),
        page.parameters(),
        page.pairs(),
        page.measures(),
        page.latencies(),
        page.instructive(),
        page.failures(),
        page.all_runs(),
        page.data(),
    ];
    let name = escape(&summary.campaign);
    Ok(document(&format!("{name} · {} runs", survey.runs), &format!("{}{}", page.head(), sections.concat())))
}

/// What the sections of the page are made of.
struct Page<'p> {
    summary: &'p Summary,
    layout: &'p Layout,
    survey: &'p Survey,
    confidence: Confidence,
}

/// A section; nothing without content.
fn section(id: &str, title: &str, content: &str) -> String {
    if content.is_empty() {
        return String::new();
    }
    format!("<section id=\"{id}\">\n<h2>{title}</h2>\n{content}</section>\n")
}

/// A chart beside others.
fn chart(title: &str, drawing: &str, caption: &str) -> String {
    let caption = if caption.is_empty() { String::new() } else { format!("<figcaption>{caption}</figcaption>") };
    format!("<div class=\"panel\">\n<h3>{title}</h3>\n<figure>{drawing}{caption}</figure>\n</div>\n")
}

/// What a parameter is called for people.
fn title(parameter: &ParameterLayout) -> &str {
    parameter.about.as_deref().unwrap_or(&parameter.key)
}

fn percent(rate: f64) -> String {
    format!("{}&nbsp;%", short(100.0 * rate))
}

/// The ends of an interval of probabilities, to a hundredth of a percent.
fn interval(interval: Interval) -> String {
    format!("{:.2} to {:.2}&nbsp;%", 100.0 * interval.low, 100.0 * interval.high)
}

impl Page<'_> {
    fn head(&self) -> String {
        let Summary { campaign, scenario, runs, version, outcomes, .. } = self.summary;
        format!(
            "<header class=\"head\">\n<p class=\"over\">A campaign of runs of a service robot under runtime monitors</p>\n\
             <h1>{}</h1>\n<p class=\"about\">{}</p>\n<p class=\"quiet\">{runs} runs of <code>{}</code>, which differ in {} · \
             {} as expected, {} not, {} failed · steward {}</p>\n</header>\n",
            escape(campaign),
            text(&self.layout.about),
            escape(scenario),
            self.what_varies(),
            outcomes.as_expected,
            outcomes.not_as_expected,
            outcomes.failed,
            escape(version),
        )
    }

    fn what_varies(&self) -> String {
        let keys: Vec<String> =
            self.layout.parameters.iter().map(|parameter| format!("<code>{}</code>", escape(&parameter.key))).collect();
        if keys.is_empty() { "their seeds".to_owned() } else { keys.join(", ") }
    }

    fn rates(&self) -> String {
        let row = |estimate: &Estimate, what: &str| {
            let (count, low) = (estimate.count, estimate.interval.low);
            let bar = format!(
                "<span class=\"rate\"><i style=\"left:{:.2}%;width:{:.2}%\"></i><b style=\"left:{:.2}%\"></b></span>",
                100.0 * low,
                100.0 * (estimate.interval.high - low),
                100.0 * estimate.rate.unwrap_or(0.0)
            );
            format!(
                "<tr><th scope=\"row\"><strong>{}</strong><span class=\"note\">{what}</span></th><td>{} of {}</td><td>{}</td><td>{}</td><td class=\"bar\">{bar}</td></tr>\n",
                escape(&estimate.of),
                count.happened(),
                count.runs(),
                estimate.rate.map_or("–".to_owned(), percent),
                interval(estimate.interval),
            )
        };
        let mut rows: String = self.summary.properties.iter().map(|estimate| row(estimate, "violated")).collect();
        rows += &row(&self.summary.expectation, "not what the scenario expects, or failed");
        let table = format!(
            "<div class=\"panel\">\n<table class=\"rates\"><thead><tr><th scope=\"col\"></th><th scope=\"col\">runs</th>\
             <th scope=\"col\">rate</th><th scope=\"col\">95&nbsp;% interval</th><th></th></tr></thead><tbody>\n{rows}</tbody></table>\n\
             <p class=\"quiet\">Intervals of Clopper and Pearson. They hold for the runs of this design: how often something \
             happens depends on what varies, and over which ranges.</p>\n{}</div>\n{}",
            self.goal(),
            self.patterns(),
        );
        section("rates", "How often", &table)
    }

    fn goal(&self) -> String {
        let Some(goal) = &self.summary.goal else { return String::new() };
        let said = match (goal.interval, goal.side) {
            (Some(goal), _) => format!("the probability lies in {}", interval(goal)),
            (None, Some(side)) => format!("the probability is {} the bound", side.name()),
            (None, None) => "undecided".to_owned(),
        };
        let reached = if goal.reached { "reached" } else { "not reached" };
        format!(
            "<p>Goal {reached} for <strong>{}</strong> after {} runs: {said}.</p>\n",
            escape(&goal.of),
            goal.count.runs()
        )
    }

    /// For each parameter, a chart for each target.
    fn parameters(&self) -> String {
        let drawn: Vec<usize> = self.survey.drawn.clone();
        let with_axis = self.layout.parameters.iter().zip(&self.survey.parameters);
        let charts: String = with_axis.map(|(layout, parameter)| self.parameter(layout, parameter, &drawn)).collect();
        if charts.is_empty() {
            return String::new();
        }
        let lead = "<p>A point for each part of a parameter's range, with its 95&nbsp;% interval; all other parameters vary \
                    as they do.</p>\n";
        section("parameters", "What it depends on", &format!("{lead}<div class=\"pairs\">\n{charts}</div>\n"))
    }

    fn parameter(&self, layout: &ParameterLayout, parameter: &ParameterSurvey, drawn: &[usize]) -> String {
        let Some(axis) = &parameter.axis else { return String::new() };
        let of_numbers = match axis {
            Axis::Scale(_) => true,
            Axis::Classes(values) => values.iter().all(|value| axis::number(value).is_some()),
        };
        let one = |target: &usize| {
            let event = self.survey.targets[*target].event();
            let counts: Vec<_> = parameter.rates.iter().map(|counts| counts[*target]).collect();
            let heading = escape(&event);
            if of_numbers {
                let label = format!("Rate of {event} against {}", title(layout));
                let draw = |size| charts::rates(axis, &counts, title(layout), self.confidence, size);
                return chart(&heading, &figure(&label, draw), "");
            }
            let Axis::Classes(values) = axis else { return String::new() };
            let rows: String = values
                .iter()
                .zip(&counts)
                .map(|(value, count)| {
                    format!(
                        "<tr><th scope=\"row\">{}</th><td>{} of {}</td><td>{}</td></tr>\n",
                        escape(&written(value)),
                        count.happened(),
                        count.runs(),
                        interval(count.interval(self.confidence))
                    )
                })
                .collect();
            let of = escape(title(layout));
            format!(
                "<div class=\"panel\">\n<h3>{heading}</h3>\n<table><thead><tr><th>{of}</th><th>runs</th><th>95&nbsp;% interval</th></tr></thead><tbody>\n{rows}</tbody></table>\n</div>\n"
            )
        };
        drawn.iter().map(one).collect()
    }

    /// A heat map for each pair of parameters.
    fn pairs(&self) -> String {
        let asked = self.survey.model.as_ref().map(|model| model.target);
        let targets: Vec<usize> = match asked {
            Some(target) => vec![target],
            None => self.survey.drawn.clone(),
        };
        let wanted = targets.len() * self.survey.pairs.len();
        let each = targets.iter().flat_map(|target| self.survey.pairs.iter().map(move |pair| (*target, pair)));
        let maps: String = each
            .take(MOST_MAPS)
            .map(|(target, pair)| {
                let [a, b] = pair.across.map(|place| (&self.layout.parameters[place], &self.survey.parameters[place]));
                let (Some(x), Some(y)) = (&a.1.axis, &b.1.axis) else { return String::new() };
                let event = self.survey.targets[target].event();
                let cells: Vec<Vec<_>> =
                    pair.cells.iter().map(|column| column.iter().map(|counts| counts[target]).collect()).collect();
                let label = format!("Rate of {event} by {} and {}", title(a.0), title(b.0));
                let draw = |size| charts::heat_map([x, y], [title(a.0), title(b.0)], &cells, size);
                chart(&escape(&event), &figure(&label, draw), "")
            })
            .collect();
        if maps.is_empty() {
            return String::new();
        }
        let left_out = if wanted > MOST_MAPS {
            format!(" The first {MOST_MAPS} of {wanted} maps are drawn.")
        } else {
            String::new()
        };
        let lead = format!(
            "<p>Each cell is coloured by its rate, in percent: green 0, red 100; grey cells have no run.{left_out}</p>\n"
        );
        section("pairs", "Two parameters at a time", &format!("{lead}<div class=\"pairs\">\n{maps}</div>\n"))
    }

    /// What was measured against each parameter.
    fn measures(&self) -> String {
        let parameters = self.layout.parameters.iter().zip(&self.survey.parameters);
        let charts: String = parameters
            .flat_map(|(layout, parameter)| {
                parameter.measures.iter().filter_map(move |(measure, histograms)| {
                    let axis = parameter.axis.as_ref()?;
                    let about = measure.about();
                    let label = format!("{about} against {}", title(layout));
                    let draw = |size| charts::measured(axis, histograms, title(layout), size);
                    Some(chart(&text(about), &figure(&label, draw), ""))
                })
            })
            .collect();
        if charts.is_empty() {
            return String::new();
        }
        let lead = "<p>The line is the median; eight of ten runs lie in the band.</p>\n";
        section("measures", "What was measured", &format!("{lead}<div class=\"pairs\">\n{charts}</div>\n"))
    }

    fn latencies(&self) -> String {
        let each = self.survey.targets.iter().zip(&self.survey.latencies);
        let charts: String = each
            .filter_map(|(target, latencies)| {
                let latencies = latencies.as_ref()?;
                let quantile = |share| short(latencies.quantile(share).unwrap_or(0.0));
                let bars = latencies.coarser(BARS);
                let label = format!("Time from the first fault to {}", target.event());
                let draw = |size| charts::histogram(&bars, "time from the first fault to the violation, s", size);
                let caption = format!(
                    "{} violations after a fault; half of them within {} s, nine of ten within {} s, all within {} s.",
                    latencies.total(),
                    quantile(0.5),
                    quantile(0.9),
                    short(latencies.scale.high)
                );
                Some(chart(&escape(&target.event()), &figure(&label, draw), &text(&caption)))
            })
            .collect();
        let charts = if charts.is_empty() { charts } else { format!("<div class=\"pairs\">\n{charts}</div>\n") };
        section("latency", "How soon a fault is noticed", &charts)
    }

    fn data(&self) -> String {
        let content = "<div class=\"panel\"><ul>\n<li><code>dataset.parquet</code>: a row for each run, with parameters, \
                       verdicts, times and measurements</li>\n<li><code>summary.json</code>: the rates of this page, for programs</li>\n\
                       <li><code>timing.csv</code>: how long the computer took for each run, where it ran</li>\n</ul></div>\n";
        section("data", "The numbers behind it", content)
    }
}
