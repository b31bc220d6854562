//! Two runs of a tree beside each other: where they are alike, and where they first differ.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use bt::{Outcome, Status};

use crate::{Header, RunView};

/// Compares the answers of nodes in two runs, node by node, while their records are read. A node is known by its name,
/// and those of one name by their order in the tree, if both trees have as many of them.
///
/// The order in which the runs are read does not matter, except that each is read from its start.
#[derive(Clone, Debug)]
pub struct RunComparison {
    names: Vec<String>,
    /// By run and the index of a node: which of the common nodes it is, if it is one.
    places: [Vec<Option<usize>>; 2],
    /// How many nodes are not compared.
    others: usize,
    /// Whether both runs contain results that repeat the one before.
    has_repeats: bool,
    nodes: Vec<[NodeAnswers; 2]>,
    agreement: Option<Agreement>,
    difference: Option<Difference>,
    /// How many answers of the first run there were.
    count: usize,
}

#[derive(Clone, Debug, Default)]
struct NodeAnswers {
    first: Option<(Duration, Outcome)>,
    last: Option<Outcome>,
    /// The results that have not been compared yet, with the number of answers of the first run up to then.
    waiting: VecDeque<(usize, Duration, Outcome)>,
}

/// The earliest node in the first run that gave the same first answer in both.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// Its name.
    pub name: String,
    /// The answer.
    pub answer: Outcome,
    /// When it was given in each run, since that run's start.
    pub times: [Duration; 2],
}

/// The earliest result in the first run that was another one in the second.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The name of the node.
    pub name: String,
    /// Its index in each tree.
    pub nodes: [usize; 2],
    /// The result in each run.
    pub results: [Outcome; 2],
    /// When each was given, since the start of that run.
    pub times: [Duration; 2],
    /// The number of answers of the first run up to then.
    number: usize,
}

impl RunComparison {
    /// Compares runs with these headers, of which nothing has been read.
    #[must_use]
    pub fn new(runs: [&Header; 2]) -> Self {
        let index = |header: &Header| {
            let mut index: BTreeMap<String, Vec<usize>> = BTreeMap::new();
            for (number, node) in header.tree.iter().enumerate() {
                index.entry(node.process.clone()).or_default().push(number);
            }
            index
        };
        let [first, second] = runs.map(index);
        let mut places = runs.map(|header| vec![None; header.tree.len()]);
        let mut names = Vec::new();
        for (name, numbers) in first {
            let Some(others) = second.get(&name).filter(|others| others.len() == numbers.len()) else { continue };
            for (number, other) in numbers.iter().zip(others) {
                (places[0][*number], places[1][*other]) = (Some(names.len()), Some(names.len()));
                names.push(name.clone());
            }
        }
        Self {
            others: places.iter().flatten().filter(|place| place.is_none()).count(),
            nodes: vec![Default::default(); names.len()],
            names,
            places,
            // A simulation records an outcome only when it changes.
            has_repeats: runs.iter().all(|header| !header.knows_ticks()),
            agreement: None,
            difference: None,
            count: 0,
        }
    }

    /// Takes note of the last step of a run, 0 or 1.
    ///
    /// # Panics
    /// If there is no such run, or the view is not of the run that the header was of.
    pub fn note(&mut self, run: usize, view: &RunView) {
        let details = view.step().details.as_deref();
        let all = details.iter().flat_map(|details| details.before_ticks.iter().flatten().chain(&details.outcomes));
        for (node, outcome) in all {
            if let (Some(place), Some(outcome)) = (self.places[run][*node], outcome) {
                self.answer(run, place, (view.time(), *outcome));
            }
        }
    }

    fn answer(&mut self, run: usize, place: usize, (time, outcome): (Duration, Outcome)) {
        self.count += usize::from(run == 0);
        let courses = &mut self.nodes[place];
        if courses[run].first.is_none() {
            courses[run].first = Some((time, outcome));
            self.agree(place);
        }
        let courses = &mut self.nodes[place];
        // What runs may take one more tick elsewhere, and a log lacks what was skipped.
        let is_result = !matches!(outcome, Outcome::Answered(Status::Running | Status::Skipped));
        let is_new = self.has_repeats || courses[run].last != Some(outcome);
        if !is_result || !is_new {
            return;
        }
        courses[run].last = Some(outcome);
        // After a difference, only what came before it in the first run still counts.
        let counts = self.difference.is_none() || run == 1 && !courses[0].waiting.is_empty();
        if counts {
            courses[run].waiting.push_back((self.count, time, outcome));
            self.compare(place);
        }
    }

    /// Looks whether both runs gave the same first answer.
    fn agree(&mut self, place: usize) {
        let [Some((first, answer)), Some((second, other))] = self.nodes[place].each_ref().map(|course| course.first)
        else {
            return;
        };
        let is_earlier = self.agreement.as_ref().is_none_or(|known| first < known.times[0]);
        if answer == other && is_earlier {
            self.agreement = Some(Agreement { name: self.names[place].clone(), answer, times: [first, second] });
        }
    }

    /// Compares the next results of a node, if both are known.
    fn compare(&mut self, place: usize) {
        let [first, second] = &mut self.nodes[place];
        let (Some(one), Some(other)) = (first.waiting.front(), second.waiting.front()) else { return };
        let ((number, at, result), (_, then, instead)) = (*one, *other);
        first.waiting.pop_front();
        second.waiting.pop_front();
        if result == instead || self.difference.as_ref().is_some_and(|known| known.number <= number) {
            return;
        }
        let node = |run: usize| self.places[run].iter().position(|known| *known == Some(place)).unwrap_or_default();
        let (name, nodes) = (self.names[place].clone(), [0, 1].map(node));
        let difference = Difference { name, nodes, results: [result, instead], times: [at, then], number };
        for [first, _] in &mut self.nodes {
            first.waiting.retain(|(earlier, ..)| *earlier < number);
        }
        self.difference = Some(difference);
    }

    /// The earliest node in the first run that gave the same first answer in both, as far as they have been read.
    #[must_use]
    pub fn agreement(&self) -> Option<&Agreement> {
        self.agreement.as_ref()
    }

    /// The earliest result in the first run that was another one in the second, as far as they have been read: of each
    /// node, the first results of both runs are compared, then the second ones and so on. Results are success, failure
    /// and halted.
    #[must_use]
    pub fn difference(&self) -> Option<&Difference> {
        self.difference.as_ref()
    }

    /// Whether the trees have nodes in common, by their names.
    #[must_use]
    pub fn has_common_nodes(&self) -> bool {
        !self.names.is_empty()
    }

    /// How many nodes are not compared: one of the trees has none of their name, or fewer.
    #[must_use]
    pub fn others(&self) -> usize {
        self.others
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Details, Node, Step};

    /// A log of a tree of these nodes, each below the one before.
    fn log(names: &[&str]) -> RunView {
        let node = |(number, name): (usize, &&str)| Node {
            parent: number.checked_sub(1),
            process: (*name).to_owned(),
            symbol: None,
            is_leaf: false,
        };
        let tree = names.iter().enumerate().map(node).collect();
        RunView::new(Header { tree, ..Header::default() }, Step::default()).unwrap()
    }

    /// Lets nodes answer: `0R` is the first one, running. Each answer takes a second.
    fn answer(view: &mut RunView, text: &str, mut note: impl FnMut(&RunView)) {
        for answer in text.split_whitespace() {
            let (node, status) = answer.split_at(1);
            let outcome = match status {
                "R" => Outcome::Answered(Status::Running),
                "S" => Outcome::Answered(Status::Success),
                "F" => Outcome::Answered(Status::Failure),
                _ => Outcome::Halted,
            };
            let details = Details { outcomes: vec![(node.parse().unwrap(), Some(outcome))], ..Details::default() };
            let time = view.time() + Duration::from_secs(1);
            view.apply(Step { time, details: Some(Box::new(details)), ..Step::default() }).unwrap();
            note(view);
        }
    }

    /// Compares two logs, in both orders of reading.
    fn compared(names: [&[&str]; 2], answers: [&str; 2]) -> RunComparison {
        let both = |order: [usize; 2]| {
            let mut views = names.map(log);
            let mut comparison = RunComparison::new([views[0].header(), views[1].header()]);
            for run in order {
                answer(&mut views[run], answers[run], |view| comparison.note(run, view));
            }
            comparison
        };
        let [one, other] = [both([0, 1]), both([1, 0])];
        assert_eq!(one.agreement(), other.agreement(), "{answers:?}");
        assert_eq!(one.difference(), other.difference(), "{answers:?}");
        one
    }

    const SAME: [&[&str]; 2] = [&["main", "Drive", "Dock"], &["main", "Drive", "Dock"]];

    fn times(difference: &Difference) -> (&str, [u64; 2]) {
        (&difference.name, difference.times.map(|time| time.as_secs()))
    }

    #[test]
    fn runs_agree_where_a_node_first_gave_the_same_answer() {
        let at = |answers| {
            let agreement = compared(SAME, answers).agreement().cloned()?;
            Some((agreement.name, agreement.times.map(|time| time.as_secs())))
        };
        assert_eq!(at(["0R 1R", "1R 0R"]), Some(("main".to_owned(), [1, 2])));
        assert_eq!(at(["0F 1R 1S 2R", "0R 1S 2R"]), Some(("Dock".to_owned(), [4, 3])));
        assert_eq!(at(["0R", "0S"]), None);
        assert_eq!(at(["0R", ""]), None);
    }

    #[test]
    fn the_first_different_result_is_the_earliest_of_the_first_run() {
        let comparison = compared(SAME, ["0R 1R 1S 2R 2S 0S", "0R 1R 1S 2R 2F 0F"]);
        let difference = comparison.difference().unwrap();
        assert_eq!(times(difference), ("Dock", [5, 5]));
        assert_eq!(difference.results, [Outcome::Answered(Status::Success), Outcome::Answered(Status::Failure)]);
        assert_eq!(difference.nodes, [2, 2]);
        // Results are compared one by one, and not by their times: the second one of Drive differs.
        let comparison = compared(SAME, ["1S 2S 1S 2F 0F", "1S 1F 2S 2S 2S 0S"]);
        assert_eq!(times(comparison.difference().unwrap()), ("Drive", [3, 2]));
    }

    #[test]
    fn how_long_a_node_was_running_is_no_difference_and_neither_is_an_end() {
        assert_eq!(compared(SAME, ["1S 2S 0S", "0R 1R 1S 2R 2S"]).difference(), None);
        assert!(compared(SAME, ["1S 2R 2H", "1S 2R 2S"]).difference().is_some());
    }

    #[test]
    fn nodes_are_compared_by_their_names() {
        let comparison = compared([&["main", "Drive", "Dock"], &["main", "Dock", "Charge"]], ["1F 2S", "2F 1F"]);
        assert_eq!(comparison.difference().map(|difference| difference.nodes), Some([2, 1]));
        assert_eq!(comparison.others(), 2);
    }

    #[test]
    fn nodes_of_one_name_are_compared_in_the_order_of_the_tree() {
        const TWICE: &[&str] = &["main", "Drive", "Wait", "Drive"];
        let comparison = compared([TWICE, TWICE], ["1S 3S", "1S 3F"]);
        assert_eq!(
            (comparison.others(), comparison.difference().map(|difference| difference.nodes)),
            (0, Some([3, 3]))
        );
        // Which of them is the one of the other tree is not known.
        let comparison = compared([TWICE, SAME[0]], ["1S 3S", "1F"]);
        assert_eq!((comparison.others(), comparison.difference()), (5, None));
    }

    #[test]
    fn results_that_a_simulation_does_not_repeat_count_once() {
        let (mut log, mut simulated) = (log(SAME[0]), log(SAME[1]));
        let header = Header { tick: Duration::from_secs(1), ..simulated.header().clone() };
        simulated = RunView::new(header, Step::default()).unwrap();
        let mut comparison = RunComparison::new([log.header(), simulated.header()]);
        answer(&mut log, "1S 1S 1S 1F", |view| comparison.note(0, view));
        answer(&mut simulated, "1S 1F", |view| comparison.note(1, view));
        assert_eq!(comparison.difference(), None);
    }
}
