//! What the checks of many pairs have found.

use std::collections::BTreeMap;
use std::fmt;

use channels::Verdict;
use monitors::{Formula, MessageCondition, Method};

/// Why a monitor may give a verdict late.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Why {
    Time,
    Values,
    Terms,
    Limit,
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Time => "the property is timed",
            Self::Values => "values are remembered",
            Self::Terms => "conditions compare fields or calculate",
            Self::Limit => "a limit is met",
        })
    }
}

fn contains(condition: &MessageCondition, is: fn(&MessageCondition) -> bool) -> bool {
    is(condition)
        || match condition {
            MessageCondition::Not(a) => contains(a, is),
            MessageCondition::And(all) | MessageCondition::Or(all) => all.iter().any(|part| contains(part, is)),
            MessageCondition::Implies(a, b) => contains(a, is) || contains(b, is),
            _ => false,
        }
}

/// Why the verdicts of a formula's monitor would come late.
pub(crate) fn why(formula: &Formula) -> Why {
    let has = |is: fn(&MessageCondition) -> bool| {
        let mut found = false;
        formula.events(&mut |event| found |= contains(&event.condition, is));
        found
    };
    if matches!(formula, Formula::Timed(_)) {
        Why::Time
    } else if has(|condition| matches!(condition, MessageCondition::Remember { .. })) {
        Why::Values
    } else if has(|condition| matches!(condition, MessageCondition::Relate { .. })) {
        Why::Terms
    } else {
        Why::Limit
    }
}

/// Whether the verdict of one pair comes late.
pub(crate) struct Late {
    why: Why,
    /// The outcome of all continuations that were tried of the last prefix without a verdict, if it is one.
    pub(crate) same_outcome: Option<bool>,
    is_settled: bool,
    /// The verdict that was already certain when there was none.
    late: Option<bool>,
}

impl Late {
    pub(crate) fn new(formula: &Formula) -> Self {
        Self { why: why(formula), same_outcome: None, is_settled: false, late: None }
    }

    /// The verdict of the monitor that is in use, and one of any machine.
    pub(crate) fn follow(&mut self, verdict: Verdict, any: Option<Verdict>) {
        if self.is_settled {
            return;
        }
        self.is_settled = verdict != Verdict::Inconclusive;
        if !self.is_settled {
            self.late = any.map(|verdict| verdict == Verdict::True).or(self.same_outcome);
        }
    }
}

/// The results of many pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    /// Pairs.
    pub(crate) pairs: u64,
    /// Formulas that are refused, because they would have to remember too much.
    pub(crate) refused: u64,
    /// Prefixes checked.
    pub(crate) prefixes: u64,
    /// Verdicts reached, or to be reached.
    pub(crate) settled: u64,
    /// Pairs monitored by program graphs and rules, automata, and progression.
    pub(crate) graphs: u64,
    pub(crate) automata: u64,
    pub(crate) progressions: u64,
    /// Outcomes that were still open because of an endless word, but of no finite one.
    pub(crate) endless: u64,
    /// Violations after the first one that were found.
    pub(crate) again: u64,
    /// Verdicts that come late, or not at all: those that are violated, and those that are satisfied.
    pub(crate) late: BTreeMap<Why, [u64; 2]>,
}

impl Tally {
    pub(crate) fn begin(&mut self, method: Method) {
        self.pairs += 1;
        match method {
            Method::Graph | Method::Graphs | Method::Rules => self.graphs += 1,
            Method::Automaton { .. } => self.automata += 1,
            Method::Progression => self.progressions += 1,
        }
    }

    pub(crate) fn end(&mut self, late: Late) {
        self.settled += u64::from(late.is_settled || late.late.is_some());
        if let Some(verdict) = late.late {
            self.late.entry(late.why).or_default()[usize::from(verdict)] += 1;
        }
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pairs, refused, prefixes, settled, graphs, automata, progressions, endless, again, late } = self;
        write!(f, "{pairs} pairs ({graphs} by rules, {automata} by automata, {progressions} by progression")?;
        write!(f, "; {refused} refused), {prefixes} prefixes, {endless} open because of endless words alone; ")?;
        let all: u64 = late.values().flatten().sum();
        write!(f, "{settled} verdicts, {all} of them late; {again} further violations")?;
        for (why, [violated, satisfied]) in late {
            let share = |count: &u64| 100.0 * *count as f64 / *settled as f64;
            write!(f, ", because {why}: {:.2} % violated, {:.2} % satisfied", share(violated), share(satisfied))?;
        }
        Ok(())
    }
}
