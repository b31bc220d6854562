//! The statistics of a campaign for a report: counted in passes over its journal, in memory that does not grow with the
//! runs.

use std::collections::BTreeMap;

use drawing::scale::{Scale, short};

use super::super::journal::Layout;
use super::super::statistics::Count;
use super::super::{Measure, RunRecord};
use super::against::ModelSurvey;
use super::axis::{Axis, Extent, Taken};
use super::histogram::Histogram;
use super::target::Target;

/// Up to this many numbers are shown individually, run by run.
pub(super) const FEW_RUNS: u64 = 400;
/// Pairs are made from at most this many parameters: the first ones.
const PAIRED: usize = 6;
/// The number of bins in histograms for quantiles.
const FINE: usize = 480;
/// The number of combinations of violations that are distinguished.
const MOST_PATTERNS: usize = 200;

/// Everything that is counted.
pub(in super::super) struct Survey {
    pub(super) runs: u64,
    pub(super) targets: Vec<Target>,
    /// The targets to draw: those that happened in some runs but not in all, and not in exactly the same runs as an
    /// earlier one.
    pub(super) drawn: Vec<usize>,
    pub(super) parameters: Vec<ParameterSurvey>,
    pub(super) pairs: Vec<Pair>,
    /// Which targets happened together, how often, and in which run first.
    pub(super) patterns: Vec<Pattern>,
    /// For each property, the time from fault to violation.
    pub(super) latencies: Vec<Option<Histogram>>,
    pub(super) model: Option<ModelSurvey>,
    pub(super) instructive: Vec<Instructive>,
    /// All runs, if there are few.
    pub(super) records: Vec<RunRecord>,
}

/// A run that is worth a look.
pub(super) struct Instructive {
    pub(super) record: RunRecord,
    /// The reasons, in words.
    pub(super) why: Vec<String>,
}

/// The counts of a parameter.
pub(super) struct ParameterSurvey {
    /// None if it has too many values that are not numbers.
    pub(super) axis: Option<Axis>,
    /// For each bin, how often each target happened.
    pub(super) rates: Vec<Vec<Count>>,
    /// For each measurement, its distribution in each bin.
    pub(super) measures: Vec<(Measure, Vec<Histogram>)>,
}

/// The counts of two parameters together.
pub(super) struct Pair {
    /// The indices of the parameters.
    pub(super) across: [usize; 2],
    /// How often each target happened, by the bin of the first parameter and the bin of the second.
    pub(super) cells: Vec<Vec<Vec<Count>>>,
}

/// Runs in which the same targets happened.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pattern {
    /// For each target, whether it happened; none in runs that failed.
    pub(super) happened: Vec<Option<bool>>,
    pub(super) runs: u64,
    /// The first such run.
    pub(super) first: u64,
}

impl Survey {
    pub(super) fn add(&mut self, record: &RunRecord) {
        let happened: Vec<Option<bool>> = self.targets.iter().map(|target| target.happened(record)).collect();
        let bins = self.bins(record);
        for (parameter, bin) in self.parameters.iter_mut().zip(&bins) {
            let Some(bin) = *bin else { continue };
            count(&mut parameter.rates[bin], &happened);
            for (measure, histograms) in &mut parameter.measures {
                if let Some(value) = record.facts.as_ref().and_then(|facts| facts.measured(*measure)) {
                    histograms[bin].add(value);
                }
            }
        }
        for pair in &mut self.pairs {
            if let [Some(a), Some(b)] = pair.across.map(|place| bins[place]) {
                count(&mut pair.cells[a][b], &happened);
            }
        }
        for (target, latencies) in self.targets.iter().zip(&mut self.latencies) {
            if let (Some(histogram), Some(latency_s)) = (latencies, target.latency_s(record)) {
                histogram.add(latency_s);
            }
        }
        if let Some(model) = &mut self.model {
            model.add(record, happened[model.target]);
        }
        // `runs` is the number of all runs, known from the first pass: the records of many runs are never held in
        // memory.
        if self.runs <= FEW_RUNS {
            self.records.push(record.clone());
        }
    }

    /// The frontiers of the model and of the runs, in words; none without a model.
    pub(in super::super) fn frontier_in_words(&self) -> Option<String> {
        let model = self.model.as_ref()?;
        let (frontier, wrong) = model.frontier?;
        let (event, runs) = (self.targets[model.target].event(), self.runs);
        let [[_, surprise], [spared, _]] = model.predicted_and_was;
        let layout = &model.layout;
        Some(format!(
            "{event} where {} exceeds {} (wrong in {wrong} of {runs} runs); the model says {} (wrong in {})",
            layout.quantity,
            short(frontier),
            short(layout.bound),
            surprise + spared
        ))
    }

    /// The runs that are worth a look, and why.
    pub(in super::super) fn instructive_in_words(&self) -> Vec<(u64, Option<String>)> {
        self.instructive.iter().map(|run| (run.record.k, Some(run.why.join("; ")))).collect()
    }

    /// The bin of each parameter's value.
    pub(super) fn bins(&self, record: &RunRecord) -> Vec<Option<usize>> {
        let placed = self.parameters.iter().zip(&record.values);
        placed.map(|(parameter, value)| parameter.axis.as_ref()?.bin(value)).collect()
    }
}

fn count(counts: &mut [Count], happened: &[Option<bool>]) {
    for (count, happened) in counts.iter_mut().zip(happened) {
        if let Some(happened) = happened {
            count.push(*happened);
        }
    }
}

/// The first pass: measures ranges.
pub(super) struct FirstLook {
    targets: Vec<Target>,
    runs: u64,
    counts: Vec<Count>,
    /// For each target and each earlier one, whether both have happened in exactly the same runs.
    same_as: Vec<Vec<bool>>,
    taken: Vec<Taken>,
    measures: Vec<(Measure, Extent)>,
    latencies: Vec<Extent>,
    patterns: BTreeMap<Vec<Option<bool>>, (u64, u64)>,
    model: Option<ModelSurvey>,
}

impl FirstLook {
    pub(super) fn new(layout: &Layout) -> Self {
        let targets = Target::all(layout);
        Self {
            runs: 0,
            counts: vec![Count::default(); targets.len()],
            same_as: (0..targets.len()).map(|target| vec![true; target]).collect(),
            taken: vec![Taken::default(); layout.parameters.len()],
            measures: layout.measures.iter().map(|measure| (*measure, Extent::default())).collect(),
            latencies: vec![Extent::default(); targets.len()],
            patterns: BTreeMap::new(),
            model: ModelSurvey::new(layout, &targets),
            targets,
        }
    }

    pub(super) fn add(&mut self, record: &RunRecord) {
        self.runs += 1;
        let happened: Vec<Option<bool>> = self.targets.iter().map(|target| target.happened(record)).collect();
        count(&mut self.counts, &happened);
        for (target, same) in self.same_as.iter_mut().enumerate() {
            same.iter_mut().enumerate().for_each(|(other, same)| *same &= happened[target] == happened[other]);
        }
        // With n properties, there may be 2ⁿ patterns: once there are many, only known ones are still counted.
        if self.patterns.len() < MOST_PATTERNS || self.patterns.contains_key(&happened) {
            self.patterns.entry(happened).or_insert((0, record.k)).0 += 1;
        }
        self.taken.iter_mut().zip(&record.values).for_each(|(taken, value)| taken.add(value));
        for (measure, extent) in &mut self.measures {
            record
                .facts
                .as_ref()
                .and_then(|facts| facts.measured(*measure))
                .into_iter()
                .for_each(|value| extent.add(value));
        }
        for (target, extent) in self.targets.iter().zip(&mut self.latencies) {
            target.latency_s(record).into_iter().for_each(|latency_s| extent.add(latency_s));
        }
        if let Some(model) = &mut self.model {
            model.look(record);
        }
    }

    /// The second pass, prepared: bins of the measured ranges, with empty counts.
    pub(super) fn survey(self, layout: &Layout) -> Survey {
        // With √n/4 bins, each has 4·√n of n runs: more runs make the bins finer and their intervals narrower.
        let bins = (libm::sqrt(self.runs as f64) / 4.0) as usize;
        let bins = bins.clamp(4, 20);
        let targets = self.targets.len();
        let measures = self.histograms();
        let parameter = |axis: Option<Axis>| {
            let bins = axis.as_ref().map_or(0, Axis::bins);
            let measured = measures.iter().map(|(measure, histogram)| (*measure, vec![histogram.clone(); bins]));
            ParameterSurvey { rates: vec![vec![Count::default(); targets]; bins], measures: measured.collect(), axis }
        };
        let drawn = (0..targets).filter(|target| self.is_worth_drawing(*target)).collect();
        let axes = self.taken.into_iter().zip(&layout.parameters).map(|(taken, layout)| taken.axis(layout, bins));
        let parameters: Vec<ParameterSurvey> = axes.map(parameter).collect();
        let latency = |extent: Extent| {
            let range = extent.range()?;
            Some(Histogram::new(Scale::new(0.0..range.end, false, FINE)))
        };
        Survey {
            runs: self.runs,
            drawn,
            targets: self.targets,
            pairs: pairs(&parameters, targets),
            parameters,
            patterns: by_frequency(self.patterns),
            latencies: self.latencies.into_iter().map(latency).collect(),
            model: self.model.map(|model| model.measured(bins)),
            instructive: Vec::new(),
            records: Vec::new(),
        }
    }

    /// An empty histogram for each measurement that has values.
    fn histograms(&self) -> Vec<(Measure, Histogram)> {
        let histogram = |(measure, extent): &(Measure, Extent)| {
            let range = extent.range()?;
            // On a linear scale, values over such a range would crowd into the first bins. (20 is chosen, not
            // measured.)
            let is_wide = range.start > 0.0 && range.end / range.start > 20.0;
            Some((*measure, Histogram::new(Scale::new(range, is_wide, FINE))))
        };
        self.measures.iter().filter_map(histogram).collect()
    }

    /// Whether a target happened in some runs but not in all, and not in exactly the same runs as an earlier one.
    fn is_worth_drawing(&self, target: usize) -> bool {
        let (count, same) = (self.counts[target], &self.same_as[target]);
        count.happened() > 0 && count.happened() < count.runs() && !same.contains(&true)
    }
}

/// The patterns, the most frequent first.
fn by_frequency(patterns: BTreeMap<Vec<Option<bool>>, (u64, u64)>) -> Vec<Pattern> {
    let patterns = patterns.into_iter().map(|(happened, (runs, first))| Pattern { happened, runs, first });
    let mut patterns: Vec<Pattern> = patterns.collect();
    patterns.sort_by_key(|pattern| (std::cmp::Reverse(pattern.runs), pattern.first));
    patterns
}

/// All pairs of parameters that have axes, with empty counts.
fn pairs(parameters: &[ParameterSurvey], targets: usize) -> Vec<Pair> {
    let with_axis = parameters.iter().enumerate().filter(|(_, parameter)| parameter.rates.len() > 1);
    let paired: Vec<(usize, usize)> =
        with_axis.map(|(place, parameter)| (place, parameter.rates.len())).take(PAIRED).collect();
    let mut pairs = Vec::new();
    for (index, (a, a_bins)) in paired.iter().enumerate() {
        for (b, b_bins) in &paired[index + 1..] {
            let cells = vec![vec![vec![Count::default(); targets]; *b_bins]; *a_bins];
            pairs.push(Pair { across: [*a, *b], cells });
        }
    }
    pairs
}
