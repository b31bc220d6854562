//! The runs that are worth a look, and why.

use drawing::scale::short;

use super::super::statistics::Count;
use super::super::{RunOutcome, RunRecord};
use super::survey::{Instructive, Pattern, Survey};

/// How many runs are named.
const NAMED: usize = 10;
/// The minimum number of similar runs from which it is decided that a run is unusual.
const AROUND: u64 = 8;

/// The lower, the better the run fits the reason; none if it does not fit.
type Score = dyn Fn(&Survey, &RunRecord) -> Option<f64>;

/// A reason to look at a run.
struct Reason {
    score: Box<Score>,
    /// The reason in words, for the run with this score.
    words: Box<dyn Fn(f64) -> String>,
    best: Option<(f64, RunRecord)>,
}

/// The best run for each reason so far.
pub(super) struct Selection {
    reasons: Vec<Reason>,
}

impl Selection {
    /// Starts with the reasons, the most important first, and no runs.
    pub(super) fn new(survey: &Survey) -> Self {
        let mut selection = Self { reasons: Vec::new() };
        selection.add(
            |_, record| (record.outcome == RunOutcome::Failed).then_some(record.k as f64),
            |_| "the first run that did not finish".to_owned(),
        );
        selection.near_the_frontier(survey);
        selection.against_the_odds(survey);
        selection.rarest(survey);
        selection.first_and_last(survey);
        selection.closest_call(survey);
        selection.extremes();
        selection
    }

    fn add(
        &mut self,
        score: impl Fn(&Survey, &RunRecord) -> Option<f64> + 'static,
        words: impl Fn(f64) -> String + 'static,
    ) {
        self.reasons.push(Reason { score: Box::new(score), words: Box::new(words), best: None });
    }

    /// If there is a model: the runs nearest to the frontier, with the event and without it, and those farthest on the
    /// wrong side.
    fn near_the_frontier(&mut self, survey: &Survey) {
        let Some((model, (frontier, _))) = survey.model.as_ref().and_then(|model| Some((model, model.frontier?)))
        else {
            return;
        };
        let target = model.target;
        let [event, absence] = [survey.targets[target].event(), survey.targets[target].absence()];
        for (happened, what) in [(true, event), (false, absence)] {
            let quantity = move |survey: &Survey, record: &RunRecord| {
                let quantity = survey.model.as_ref()?.quantity(record)?;
                (survey.targets[target].happened(record)? == happened).then_some(quantity)
            };
            let near = move |survey: &Survey, record: &RunRecord| Some((quantity(survey, record)? - frontier).abs());
            let name = what.clone();
            self.add(near, move |_| format!("{name}, nearest to the frontier"));
            let sign = if happened { 1.0 } else { -1.0 };
            let far = move |survey: &Survey, record: &RunRecord| Some(sign * quantity(survey, record)?);
            let side = if happened { "the smallest" } else { "the greatest" };
            self.add(far, move |score| format!("{what} at {side} quantity, {}", short(sign * score)));
        }
    }

    /// Runs with a result that is unusual among similar runs.
    fn against_the_odds(&mut self, survey: &Survey) {
        let modelled = survey.model.as_ref().map(|model| model.target);
        for target in survey.drawn.iter().copied().filter(|target| Some(*target) != modelled) {
            let [event, absence] = [survey.targets[target].event(), survey.targets[target].absence()];
            for (happened, what) in [(true, event), (false, absence)] {
                let odds = move |survey: &Survey, record: &RunRecord| {
                    (survey.targets[target].happened(record)? == happened)
                        .then(|| probability(survey, record, target, happened))?
                };
                self.add(odds, move |score| {
                    format!("{what}, as only {} % of the runs with similar parameters were", short(100.0 * score))
                });
            }
        }
    }

    /// The first run of the rarest combination.
    fn rarest(&mut self, survey: &Survey) {
        let complete = |pattern: &&Pattern| pattern.happened.iter().all(Option::is_some);
        let Some(pattern) = survey.patterns.iter().rev().find(complete).filter(|_| survey.patterns.len() > 2) else {
            return;
        };
        let (first, runs, all) = (pattern.first, pattern.runs, survey.runs);
        let words = pattern_words(survey, pattern);
        self.add(
            move |_, record| (record.k == first).then_some(0.0),
            move |_| format!("the rarest outcome ({runs} of {all} runs): {words}"),
        );
    }

    fn first_and_last(&mut self, survey: &Survey) {
        for (place, target) in survey.targets.iter().enumerate() {
            let (event, after) = (target.event(), target.event());
            let latency = move |survey: &Survey, record: &RunRecord| survey.targets[place].latency_s(record);
            self.add(latency, move |score| format!("{event} soonest after the fault, in {} s", short(score)));
            self.add(
                move |survey, record| Some(-latency(survey, record)?),
                move |score| format!("{after} latest after the fault, in {} s", short(-score)),
            );
        }
    }

    /// The lowest charge in a run without violations, if other runs had violations.
    fn closest_call(&mut self, survey: &Survey) {
        if survey.drawn.iter().all(|target| survey.targets[*target].is_expectation()) {
            return;
        }
        let charge = |survey: &Survey, record: &RunRecord| {
            let facts = record.facts.as_ref()?;
            let violated = survey.targets.iter().any(|target| target.time_s(record).is_some());
            facts.battery_minimum_pct.filter(|_| !violated)
        };
        self.add(charge, |score| format!("the lowest charge without a violation, {score:.3} %"));
    }

    fn extremes(&mut self) {
        self.add(
            |_, record| Some(-record.facts.as_ref()?.localization_max_m?),
            |score| format!("the largest localization error at any moment, {} m", short(-score)),
        );
        self.add(
            |_, record| {
                let collisions = record.facts.as_ref()?.collisions.filter(|collisions| *collisions > 0);
                collisions.map(|collisions| -(collisions as f64))
            },
            |score| format!("the most collisions, {}", short(-score)),
        );
        self.add(
            |_, record| Some(-record.facts.as_ref()?.arrived_s?),
            |score| format!("the latest arrival, at {} s", short(-score)),
        );
        self.add(
            |_, record| record.facts.as_ref()?.arrived_s,
            |score| format!("the earliest arrival, at {} s", short(score)),
        );
    }

    /// The third pass: considers a run. Of equal runs, the first one counts.
    pub(super) fn consider(&mut self, survey: &Survey, record: &RunRecord) {
        for reason in &mut self.reasons {
            let Some(score) = (reason.score)(survey, record) else { continue };
            if reason.best.as_ref().is_none_or(|(best, _)| score < *best) {
                reason.best = Some((score, record.clone()));
            }
        }
    }

    /// The chosen runs, the most important first.
    pub(super) fn chosen(self) -> Vec<Instructive> {
        let mut chosen: Vec<Instructive> = Vec::new();
        for Reason { words, best, .. } in self.reasons {
            let Some((score, record)) = best else { continue };
            let why = words(score);
            if let Some(other) = chosen.iter_mut().find(|other| other.record.k == record.k) {
                other.why.push(why);
            } else if chosen.len() < NAMED {
                chosen.push(Instructive { record, why: vec![why] });
            }
        }
        chosen
    }
}

/// The smallest fraction of runs with the same result as this one in any group of similar runs: those in the same bins
/// of two parameters, or of one parameter if they are too few.
fn probability(survey: &Survey, record: &RunRecord, target: usize, happened: bool) -> Option<f64> {
    let bins = survey.bins(record);
    let pairs = survey.pairs.iter().filter_map(|pair| {
        let [a, b] = pair.across;
        Some(pair.cells[bins[a]?][bins[b]?][target])
    });
    let singles =
        survey.parameters.iter().zip(&bins).filter_map(|(parameter, bin)| Some(parameter.rates[(*bin)?][target]));
    let rate = |groups: Vec<Count>| {
        let rates = groups.iter().filter(|count| count.runs() >= AROUND).filter_map(|count| count.rate());
        rates.map(|rate| if happened { rate } else { 1.0 - rate }).min_by(f64::total_cmp)
    };
    rate(pairs.collect()).or_else(|| rate(singles.collect()))
}

/// What happened in the runs of a pattern, in words.
pub(super) fn pattern_words(survey: &Survey, pattern: &Pattern) -> String {
    if pattern.happened.iter().any(Option::is_none) {
        return "did not finish".to_owned();
    }
    let happened = survey.targets.iter().zip(&pattern.happened).filter(|(_, happened)| **happened == Some(true));
    let words: Vec<String> = happened.map(|(target, _)| target.event()).collect();
    if words.is_empty() { "nothing violated, and as expected".to_owned() } else { words.join(", ") }
}
