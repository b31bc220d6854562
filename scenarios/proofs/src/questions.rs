//! The properties to be proved.

use diagnostics::Problem;
use scenarios::Complaints;
use scenarios::names::unknown;
use scenarios::scenario::{
    ALL_REACHED, GENERAL, Monitoring, PROGRESS, ProofOutcome, Scenario, named_like_a_general_one,
};

/// A property to be proved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Question {
    /// Its name.
    pub property: String,
    /// The expected result.
    pub expected: ProofOutcome,
    /// Whether it is named. One that is not named is left out if it cannot be proved.
    pub is_named: bool,
    /// What is asked.
    pub subject: Subject,
}

/// What a property is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// What the monitor with this number requires.
    Monitor(usize),
    /// [`PROGRESS`].
    Progress,
    /// [`ALL_REACHED`].
    AllReached,
}

/// The properties to be proved: those that `only` names or, if it is empty, those of the scenario.
pub(super) fn of(
    scenario: &Scenario,
    monitoring: &Monitoring,
    only: &[String],
    complaints: &mut Complaints,
) -> Vec<Question> {
    let prove = &scenario.file.prove;
    let monitors = monitoring.monitors().iter().map(|(watched, _)| watched.name.as_str());
    let monitors: Vec<(&str, Subject)> = monitors.zip((0..).map(Subject::Monitor)).collect();
    let general = [(PROGRESS, Subject::Progress), (ALL_REACHED, Subject::AllReached)];
    for (watched, _) in monitoring.monitors().iter().filter(|(watched, _)| GENERAL.contains(&watched.name.as_str())) {
        complaints.push(named_like_a_general_one(&watched.name, &watched.place));
    }
    let known: Vec<(&str, Subject)> = monitors.into_iter().chain(general).collect();
    check_names(scenario, &known, only, complaints);
    let expected = |name: &str| prove.expect.iter().find(|(property, _)| property.value == name);
    let is_named = |name: &str| prove.properties.iter().any(|asked| asked.value == name);
    // What is never reached is shown after every complete proof without a monitor; that it is a question of its own,
    // and may fail, must be asked for.
    let is_asked = |name: &str, subject| match (only, subject) {
        ([], Subject::Monitor(_)) if prove.properties.is_empty() => true,
        ([], Subject::Monitor(_)) => is_named(name),
        ([], Subject::Progress) => true,
        ([], Subject::AllReached) => is_named(name) || expected(name).is_some(),
        (only, _) => only.iter().any(|asked| asked == name),
    };
    let asked = known.into_iter().filter(|(name, subject)| is_asked(name, *subject));
    let question = |(name, subject): (&str, Subject)| Question {
        property: name.to_owned(),
        expected: expected(name).map_or(ProofOutcome::Proved, |(_, outcome)| *outcome),
        is_named: !only.is_empty() || !prove.properties.is_empty() || expected(name).is_some(),
        subject,
    };
    asked.map(question).collect()
}

/// Reports unknown properties in the scenario and in `only`.
fn check_names(scenario: &Scenario, known: &[(&str, Subject)], only: &[String], complaints: &mut Complaints) {
    let prove = &scenario.file.prove;
    let known: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
    let is_known = |name: &str| known.contains(&name);
    let named = prove.properties.iter().chain(prove.expect.iter().map(|(name, _)| name));
    for name in named.filter(|name| !is_known(&name.value) && scenario.file.means(name)) {
        complaints.push(unknown("property", name, known.iter().copied()));
    }
    for name in only.iter().filter(|name| !is_known(name)) {
        let help = diagnostics::nearest_or_all(name, "properties", &known);
        complaints.push(Problem::new(format!("there is no property `{name}`")).with_help(help));
    }
}
