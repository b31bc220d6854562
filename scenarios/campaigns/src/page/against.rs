//! A campaign's results compared with its model.

use drawing::scale::Scale;

use super::super::journal::{Layout, ModelLayout};
use super::super::statistics::Count;
use super::super::{Formula, RunRecord};
use super::axis::Extent;
use super::histogram::Histogram;
use super::target::Target;

/// The number of values of the quantity that are tried as the frontier.
const FINE: usize = 960;
/// The third parameter of a formula is divided into this many slices, each with its own map.
const SLICES: usize = 4;
/// The number of parts into which an axis is divided to find a curve.
const LOOKS: usize = 400;

/// The counts for the model.
pub(super) struct ModelSurvey {
    pub(super) layout: ModelLayout,
    /// The index of the target among all targets.
    pub(super) target: usize,
    pub(super) formula: Formula,
    /// The formula's parameters.
    pub(super) inputs: Vec<Input>,
    extent: Extent,
    /// Histograms of the quantity: over runs in which the target did not happen, and over runs in which it did.
    pub(super) quantities: [Histogram; 2],
    /// The number of runs, by what the model predicts (0: it does not happen, 1: it does) and by what happened.
    pub(super) predicted_and_was: [[u64; 2]; 2],
    /// The smallest quantity with which it happened, and the greatest with which it did not.
    pub(super) least_happened: Option<f64>,
    pub(super) greatest_not: Option<f64>,
    /// The frontier: the value of the quantity that leaves the fewest runs on the wrong side, and their number.
    pub(super) frontier: Option<(f64, u64)>,
    /// For each slice of the third parameter, each bin of the first and each of the second: how often it happened.
    pub(super) slices: Vec<Vec<Vec<Count>>>,
}

/// A parameter in the formula.
pub(super) struct Input {
    /// Its index among the parameters.
    pub(super) place: usize,
    name: String,
    logarithmic: bool,
    extent: Extent,
    pub(super) scale: Scale,
}

impl ModelSurvey {
    /// The counts at the start; none if the campaign has no model.
    pub(super) fn new(layout: &Layout, targets: &[Target]) -> Option<Self> {
        let model = layout.model.clone()?;
        let formula = Formula::parse(&model.quantity).ok()?;
        let none_yet = Scale::new(0.0..1.0, false, 1);
        let input = |name: &&str| {
            let place = layout.parameters.iter().position(|parameter| parameter.name.as_deref() == Some(name))?;
            let logarithmic = layout.parameters[place].logarithmic;
            Some(Input { place, name: (*name).to_owned(), logarithmic, extent: Extent::default(), scale: none_yet })
        };
        let inputs = formula.names().iter().map(input).collect::<Option<Vec<_>>>()?;
        Some(Self {
            target: targets.iter().position(|target| target.name == model.of)?,
            layout: model,
            formula,
            inputs,
            extent: Extent::default(),
            quantities: [Histogram::new(none_yet), Histogram::new(none_yet)],
            predicted_and_was: [[0; 2]; 2],
            least_happened: None,
            greatest_not: None,
            frontier: None,
            slices: Vec::new(),
        })
    }

    /// The first pass: measures ranges.
    pub(super) fn look(&mut self, record: &RunRecord) {
        if let Some(quantity) = self.quantity(record) {
            self.extent.add(quantity);
        }
        for input in &mut self.inputs {
            record.values[input.place].number().into_iter().for_each(|value| input.extent.add(value));
        }
    }

    /// The same, with axes for the measured ranges; those of the maps have this many bins.
    pub(super) fn measured(mut self, bins: usize) -> Self {
        for input in &mut self.inputs {
            let range = input.extent.range().unwrap_or(0.0..1.0);
            input.scale = Scale::new(range, input.logarithmic, bins);
        }
        let range = self.extent.range().unwrap_or(0.0..1.0);
        let wide = range.start > 0.0 && range.end / range.start > 5.0;
        let histogram = Histogram::new(Scale::new(range, wide, FINE));
        self.quantities = [histogram.clone(), histogram];
        if self.inputs.len() >= 2 {
            let slices = if self.inputs.len() == 2 { 1 } else { SLICES };
            self.slices = vec![vec![vec![Count::default(); bins]; bins]; slices];
        }
        self
    }

    pub(super) fn quantity(&self, record: &RunRecord) -> Option<f64> {
        let place = |name: &str| self.inputs.iter().find(|input| input.name == name).map(|input| input.place);
        self.formula.value(&|name| record.values.get(place(name)?)?.number())
    }

    /// The second pass: counts a run.
    pub(super) fn add(&mut self, record: &RunRecord, happened: Option<bool>) {
        let (Some(happened), Some(quantity)) = (happened, self.quantity(record)) else { return };
        self.quantities[usize::from(happened)].add(quantity);
        self.predicted_and_was[usize::from(quantity > self.layout.bound)][usize::from(happened)] += 1;
        if happened {
            self.least_happened = Some(self.least_happened.map_or(quantity, |least| least.min(quantity)));
        } else {
            self.greatest_not = Some(self.greatest_not.map_or(quantity, |greatest| greatest.max(quantity)));
        }
        let bin = |input: &Input| record.values[input.place].number().map(|value| input.scale.bin(value));
        if let [Some(x), Some(y)] = [self.inputs.first().and_then(bin), self.inputs.get(1).and_then(bin)] {
            let slices = self.slices.len();
            let slice = self.inputs.get(2).and_then(|input| {
                record.values[input.place].number().map(|value| input.scale.with_bins(slices.max(1)).bin(value))
            });
            if let Some(cells) = self.slices.get_mut(slice.unwrap_or(0)) {
                cells[x][y].push(happened);
            }
        }
    }

    /// After the second pass: finds the frontier, the value of the quantity that leaves most runs on the right side.
    pub(super) fn settle(&mut self) {
        let [held, happened] = &self.quantities;
        if held.total() == 0 || happened.total() == 0 {
            return;
        }
        // With the frontier below the first bin, the event always happens: all runs in which it did not are wrong.
        let mut wrong = held.total();
        let mut best = (wrong, 0);
        for bin in 0..FINE {
            wrong = wrong - held.counts[bin] + happened.counts[bin];
            if wrong < best.0 {
                best = (wrong, bin + 1);
            }
        }
        self.frontier = Some((held.scale.at(best.1 as f64 / FINE as f64), best.0));
    }

    /// The values on the map of a slice: the middle of the slice for the third parameter, the middle of the range for
    /// others.
    fn fixed(&self, slice: usize) -> Vec<f64> {
        let middle = |(index, input): (usize, &Input)| match index {
            2 => input.scale.at((slice as f64 + 0.5) / self.slices.len().max(1) as f64),
            _ => input.scale.at(0.5),
        };
        self.inputs.iter().enumerate().map(middle).collect()
    }

    /// Where the quantity has the wanted value on the map of a slice, as fractions of its two axes.
    pub(super) fn curve(&self, slice: usize, wanted: f64) -> Vec<(f64, f64)> {
        let fixed = self.fixed(slice);
        let [x_scale, y_scale] = [self.inputs[0].scale, self.inputs[1].scale];
        let off = |x: f64, y: f64| {
            let value = |name: &str| {
                let index = self.inputs.iter().position(|input| input.name == name)?;
                Some(match index {
                    0 => x_scale.at(x),
                    1 => y_scale.at(y),
                    _ => fixed[index],
                })
            };
            self.formula.value(&value).map(|quantity| quantity - wanted)
        };
        let crossing = |x: f64| {
            let look = |step: usize| step as f64 / LOOKS as f64;
            (0..LOOKS).find_map(|step| {
                let (a, b) = (off(x, look(step))?, off(x, look(step + 1))?);
                (a * b <= 0.0).then(|| (x, look(step) + if a == b { 0.0 } else { a / (a - b) } / LOOKS as f64))
            })
        };
        (0..=LOOKS / 4).filter_map(|step| crossing(step as f64 * 4.0 / LOOKS as f64)).collect()
    }
}
