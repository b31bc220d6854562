//! The section that checks the results against the campaign's model.

use diagnostics::counted;
use drawing::scale::short;
use maud::{Markup, html};
use reports::html::{figure, section, text};

use super::{Page, chart, charts, percent, title};

impl Page<'_> {
    /// Where the frontier is, according to the runs and to the model.
    pub(super) fn frontier(&self) -> Markup {
        let Some(model) = &self.survey.model else { return Markup::default() };
        let event = self.survey.targets[model.target].event();
        let label = format!("Rate of {event} against {}", model.layout.quantity);
        let lead = html! {
            div.panel {
                p {
                    (text(&model.layout.about)) " The model: " strong { (event) } " as soon as "
                    code { (model.layout.quantity) } " exceeds " (short(model.layout.bound)) "."
                }
                (self.how_they_differ())
                figure {
                    (figure(&label, |size| charts::quantity(model, size)))
                    figcaption {
                        "How often “" (event) "” happens in each part of the quantity's range, with its 95\u{a0}% interval. \
                         Dashed: the model’s bound. Solid: the bound that fits the runs best."
                    }
                }
            }
        };
        let slices = self.slices();
        section("frontier", "Where it begins", html! { (lead) @if !slices.0.is_empty() { div.pairs { (slices) } } })
    }

    /// The comparison in words and numbers.
    fn how_they_differ(&self) -> Markup {
        let Some(model) = &self.survey.model else { return Markup::default() };
        let event = self.survey.targets[model.target].event();
        let [[held, surprise], [spared, happened]] = model.predicted_and_was;
        let all = (held + surprise + spared + happened).max(1);
        let share = |count: u64| percent(count as f64 / all as f64);
        html! {
            p {
                "The model is right in " (share(held + happened)) " of the " (all) " runs. It misses “" (event) "” \
                 in " (counted(surprise, "run")) " and wrongly predicts it in " (counted(spared, "run")) "."
            }
            @if let (Some((frontier, wrong)), Some(least), Some(greatest)) =
                (model.frontier, model.least_happened, model.greatest_not) {
                p {
                    "The frontier of the simulated robot is at " strong { (short(frontier)) } ", the bound that leaves the \
                     fewest runs on its wrong side: " (wrong) " (" (share(wrong)) "). The smallest quantity with “"
                    (event) "” is " (short(least)) "; the greatest without it is " (short(greatest)) "."
                }
            }
        }
    }

    /// The maps of the model's first two parameters, one per slice of the third.
    fn slices(&self) -> Markup {
        let Some(model) = &self.survey.model else { return Markup::default() };
        let layout = |input: usize| &self.layout.parameters[model.inputs[input].place];
        let caption = "Between cells: where the rate of the runs crosses one half. Dashed: the model, in the middle \
                       of the slice. Solid: the same formula with the bound that fits the runs best.";
        let map = |slice: usize| {
            let titles = [title(layout(0)), title(layout(1))];
            let heading = match model.inputs.get(2) {
                Some(input) if model.slices.len() > 1 => {
                    let [low, high] = input.scale.with_bins(model.slices.len()).ends(slice).map(short);
                    format!("{}: {low} to {high}", text(title(layout(2))))
                }
                _ => self.survey.targets[model.target].event(),
            };
            let label = format!("Map of the rate by {} and {}", titles[0], titles[1]);
            let draw = |size| charts::slice(model, slice, titles, size);
            chart(&heading, &figure(&label, draw), Some(caption))
        };
        html! { @for slice in 0..model.slices.len() { (map(slice)) } }
    }
}
