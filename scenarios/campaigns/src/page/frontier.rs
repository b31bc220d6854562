//! The section that holds the results against the campaign's model.

use drawing::scale::short;
use reports::html::{escape, figure, text};

use super::{Page, chart, charts, percent, section, title};

impl Page<'_> {
    /// Where the frontier is, and where the model has it.
    pub(super) fn frontier(&self) -> String {
        let Some(model) = &self.survey.model else { return String::new() };
        let event = self.survey.targets[model.target].event();
        let label = format!("Rate of {event} against {}", model.layout.quantity);
        let main = figure(&label, |size| charts::quantity(model, self.confidence, size));
        let lead = format!(
            "<div class=\"panel\">\n<p>{} The model: <strong>{}</strong> as soon as <code>{}</code> exceeds {}.</p>\n{}\
             <figure>{main}<figcaption>The rate of {} for each part of the quantity's range, with its 95&nbsp;% interval. Dashed: \
             the model’s bound. The line: the bound that fits the runs best.</figcaption></figure>\n</div>\n",
            text(&model.layout.about),
            escape(&event),
            escape(&model.layout.quantity),
            short(model.layout.bound),
            self.how_they_differ(),
            escape(&event),
        );
        let content = format!("{lead}<div class=\"pairs\">\n{}</div>\n", self.slices());
        section("frontier", "Where it begins", &content)
    }

    /// The comparison in words and numbers.
    fn how_they_differ(&self) -> String {
        let Some(model) = &self.survey.model else { return String::new() };
        let target = &self.survey.targets[model.target];
        let [[held, surprise], [spared, happened]] = model.said_and_was;
        let all = (held + surprise + spared + happened).max(1);
        let mut text = format!(
            "<p>The model is right in {} of the {all} runs. In {surprise} runs “{}” comes where the model does not \
             expect it, in {spared} it stays away where the model does.</p>\n",
            percent((held + happened) as f64 / all as f64),
            escape(&target.event()),
        );
        if let (Some((frontier, wrong)), Some(least), Some(greatest)) =
            (model.frontier, model.least_happened, model.greatest_not)
        {
            text += &format!(
                "<p>The simulated robot’s frontier is at <strong>{}</strong>, the bound that leaves the fewest runs on its wrong \
                 side: {wrong} ({}). The least quantity with “{}” is {}, the greatest without is {}.</p>\n",
                short(frontier),
                percent(wrong as f64 / all as f64),
                escape(&target.event()),
                short(least),
                short(greatest),
            );
        }
        text
    }

    /// The maps of the model's first two parameters, for each slice of the third.
    fn slices(&self) -> String {
        let Some(model) = &self.survey.model else { return String::new() };
        let layout = |input: usize| &self.layout.parameters[model.inputs[input].place];
        let map = |slice: usize| {
            let titles = [title(layout(0)), title(layout(1))];
            let heading = match model.inputs.get(2) {
                Some(input) if model.slices.len() > 1 => {
                    let [low, high] = input.scale.with_bins(model.slices.len()).ends(slice).map(short);
                    format!("{}: {low} to {high}", text(title(layout(2))))
                }
                _ => escape(&self.survey.targets[model.target].event()),
            };
            let label = format!("Map of the rate by {} and {}", titles[0], titles[1]);
            let draw = |size| charts::slice(model, slice, titles, size);
            chart(
                &heading,
                &figure(&label, draw),
                "Dark: where the rate of the runs passes one half. Dashed: the model, in the middle of the slice; the line beside it: the same formula with the bound that fits the runs best.",
            )
        };
        (0..model.slices.len()).map(map).collect()
    }
}
