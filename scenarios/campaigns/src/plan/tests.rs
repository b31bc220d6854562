//! Tests of what a campaign file may contain, and that a run is a function of the plan and the number.

use std::collections::BTreeSet;

use super::*;
use crate::file::MAX_RUNS;

const ERRAND: &str = "scenario = \"errand\"\n";

fn plan(text: &str) -> Plan {
    Plan::parse("campaign.toml", &format!("{ERRAND}{text}")).unwrap_or_else(|error| panic!("{error:?}"))
}

/// The problems of a file, one per line.
fn problems(text: &str) -> Vec<String> {
    let Err(problems) = CampaignFile::parse("campaign.toml", text) else { panic!("it is accepted: {text}") };
    problems.plain().lines().map(str::to_owned).collect()
}

fn parameter(key: &str, domain: &str) -> String {
    format!("[[parameters]]\nkey = \"{key}\"\n{domain}\n")
}

#[test]
fn a_grid_enumerates_every_combination_and_then_repeats() {
    let text =
        ["sampling = \"grid\"\nrepeats = 2\n", &parameter("battery.initial_pct", "values = [40, 50.5]")].concat();
    let plan = plan(&(text + &parameter("execution.step_budget", "from = 1000\nto = 1002\nwhole = true")));
    assert_eq!(plan.runs(), 12);
    let all: Vec<Vec<String>> = (0..12).map(|k| plan.run(k).overrides(&plan)).collect();
    assert_eq!(all[0], ["battery.initial_pct=40", "execution.step_budget=1000"]);
    assert_eq!(all[1], ["battery.initial_pct=40", "execution.step_budget=1001"]);
    assert_eq!(all[5], ["battery.initial_pct=50.5", "execution.step_budget=1002"]);
    assert_eq!(all[..6], all[6..]);
    assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), 6);
    assert_eq!((plan.run(0).seed, plan.run(11).seed), (1, 12), "repeats differ in their seeds");
}

#[test]
fn a_run_is_a_function_of_plan_and_number() {
    for sampling in ["random", "sobol", "latin_hypercube"] {
        let text =
            format!("sampling = \"{sampling}\"\nruns = 50\nseed = 9\nset = [\"battery.drain_pct_per_s=0.01\"]\n")
                + &parameter("battery.initial_pct", "normal = { mean = 50, sd = 30, min = 31, max = 100 }")
                + &parameter("execution.tick_s", "from = 0.5\nto = 2\nscale = \"log\"");
        let (forwards, again) = (plan(&text), plan(&text));
        let all: Vec<PlannedRun> = (0..50).map(|k| forwards.run(k)).collect();
        let backwards: Vec<PlannedRun> = (0..50).rev().map(|k| again.run(k)).collect();
        assert!(all.iter().eq(backwards.iter().rev()), "{sampling}");
        let different: BTreeSet<String> = all.iter().map(|run| format!("{:?}", run.values)).collect();
        assert_eq!(different.len(), 50, "{sampling}");
        assert_eq!(all[3].overrides(&forwards)[0], "battery.drain_pct_per_s=0.01");
        let other = plan(&text.replace("seed = 9", "seed = 10"));
        assert_ne!(other.run(3).values, all[3].values, "{sampling}");
    }
}

#[test]
fn adding_a_parameter_or_runs_changes_no_random_number() {
    let head = "sampling = \"random\"\nruns = 10\n";
    let battery = parameter("battery.initial_pct", "from = 31\nto = 80");
    let tick = parameter("execution.tick_s", "from = 0.5\nto = 2");
    let alone = plan(&[head, &battery].concat()).run(7);
    let with_another = plan(&[&head.replace("10", "20"), &*tick, &*battery].concat()).run(7);
    assert_eq!(alone.values[0], with_another.values[1]);
}

#[test]
fn seeds_may_stay_the_same() {
    let plan = plan("runs = 5\nseeds = \"same\"\nseed = 3\n");
    assert_eq!((plan.run(0).seed, plan.run(4).seed), (3, 3));
    assert_eq!(plan.run(4).values, []);
}

#[test]
fn a_goal_determines_the_number_of_runs() {
    let goal = "[goal]\nestimate = \"phi1\"\nhalf_width = 0.05\nconfidence = 0.95\n";
    assert_eq!(plan(goal).runs(), 838);
    assert_eq!(plan(&format!("runs = 100\n{goal}")).runs(), 100);
    let test = "[goal]\ntest = \"expectation\"\nbound = 0.1\nindifference = 0.05\nerror = 0.05\n";
    assert_eq!(plan(&format!("runs = 5000\n{test}")).runs(), 5000);
    let help = problems(&[ERRAND, test].concat());
    assert!(help.len() == 1 && help[0].contains("maximum number of runs"), "{help:?}");
}

#[test]
fn a_grid_of_a_trillion_runs_is_rejected() {
    let steps = "from = 0\nto = 1\nsteps = 1000000";
    let text = [ERRAND, "sampling = \"grid\"\n", &parameter("a", steps), &parameter("b", steps)].concat();
    let problems = problems(&text);
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert!(problems[0].contains("1000000 × 1000000 × 1 = 1000000000000 runs"), "{problems:?}");
    assert!(
        problems[0].starts_with("campaign.toml:4:7: ") && problems[0].contains(&MAX_RUNS.to_string()),
        "{problems:?}"
    );
}

/// A campaign file in which nearly everything is wrong.
const WRONG: &str = r#"
        scenario = "errand"
        sampling = "sobol"
        rums = 10
        runs = 0
        [[parameters]]
        key = "a"
        from = 5
        to = 5
        [[parameters]]
        key = "b..c"
        values = []
        [[parameters]]
        key = "d"
        normal = { mean = 0, sd = -1 }
        steps = 4
        [[parameters]]
        key = "e"
        [[parameters]]
        key = "f"
        values = [1]
        from = 1
        to = 2
        [[parameters]]
        key = "g"
        from = 0
        to = 1
        scale = "log"
        [[parameters]]
        key = "h"
        normal = { mean = 0, sd = 1, min = 50 }
        [goal]
        estimate = "phi1"
        half_width = 3
        confidence = 0.95
    "#;

#[test]
fn all_errors_in_a_file_are_reported_at_once() {
    let all = problems(WRONG).join("\n");
    for wanted in [
        "rums",
        "`runs` must lie between 1 and",
        "`to` must be greater than `from`",
        "`key` must be a dotted key",
        "`values` must have 1 to",
        "`sd` must be greater than 0",
        "`steps` requires `from`",
        "the parameter has no values",
        "both `values` and `from`",
        "a logarithmic scale must start above 0",
        "almost none of the distribution",
        "half width of an interval must lie between",
    ] {
        assert!(all.contains(wanted), "{wanted} is missing:\n{all}");
    }
}

#[test]
fn incompatible_settings_are_rejected() {
    let range = "from = 31\nto = 80";
    let goal = "[goal]\nestimate = \"phi1\"\nhalf_width = 0.05\nconfidence = 0.95\n";
    for (text, wanted) in [
        ("sampling = \"grid\"\n".to_owned() + &parameter("a", range), "a grid cannot enumerate all values of `a`"),
        ("sampling = \"grid\"\nruns = 3\n".to_owned() + &parameter("a", "values = [1]"), "set `repeats` for more"),
        ("sampling = \"random\"\nruns = 3\nrepeats = 2\n".to_owned() + &parameter("a", range), "only a grid repeats"),
        ("runs = 3\n".to_owned() + &parameter("a", range), "`sampling` is missing"),
        ("sampling = \"random\"\n".to_owned() + &parameter("a", range), "`runs` is missing"),
        ("sampling = \"latin_hypercube\"\n".to_owned() + &parameter("a", range) + goal, "cannot stop early"),
        (
            "sampling = \"random\"\nruns = 3\n".to_owned() + &parameter("a", range) + &parameter("a", range),
            "is varied twice",
        ),
        ("sampling = \"random\"\nruns = 3\n".to_owned() + &parameter("a", range) + &parameter("a.b", range), "overlap"),
        (
            "sampling = \"sobol\"\nruns = 3\n".to_owned()
                + &(0..17).map(|n| parameter(&format!("a{n}"), range)).collect::<String>(),
            "at most 16 parameters",
        ),
        ("runs = 3\n[goal]\nhalf_width = 0.1\n".to_owned(), "a goal either estimates or tests"),
    ] {
        let all = problems(&format!("{ERRAND}{text}")).join("\n");
        assert!(all.contains(wanted), "{wanted} is missing:\n{all}");
    }
}

/// Values that the scenario would reject in the middle of a campaign are rejected before the first run, for all
/// parameters.
#[test]
fn the_scenario_rejects_values_before_the_first_run() {
    let text = "sampling = \"random\"\nruns = 3\n".to_owned()
        + &parameter("battery.initial_pct", "from = 31\nto = 120")
        + &parameter("batery.drain_pct_per_s", "values = [1]")
        + &parameter("faults.0.level_pct", "values = [1]");
    let Err(Error::Scenario(scenarios::Error::BadInput(diagnostics))) =
        Plan::parse("campaign.toml", &format!("{ERRAND}{text}"))
    else {
        panic!("it is taken");
    };
    let all: Vec<String> = diagnostics.iter().map(ToString::to_string).collect();
    assert_eq!(all.len(), 3, "{all:?}");
    assert!(all[0].contains("battery.initial_pct=120.0") && all[0].contains("between 0 and 100"), "{all:?}");
    assert!(all[1].contains("`batery.drain_pct_per_s=1`") && all[2].contains("`faults.0.level_pct=1`"), "{all:?}");
    let goal = "runs = 9\n[goal]\nestimate = \"phi9\"\nhalf_width = 0.1\nconfidence = 0.9\n";
    let error = Plan::parse("campaign.toml", &format!("{ERRAND}{goal}")).unwrap_err().to_string();
    assert!(error.contains("unknown property `phi9`"), "{error}");
    let error = Plan::parse("campaign.toml", "scenario = \"nominall\"\nruns = 1\n").unwrap_err().to_string();
    assert!(error.contains("unknown scenario `nominall`"), "{error}");
}

#[test]
fn a_model_refers_to_parameters_by_their_names() {
    let named = parameter("battery.initial_pct", "name = \"charge\"\nfrom = 31\nto = 80\n");
    let with = |model: &str| format!("sampling = \"sobol\"\nruns = 3\n[model]\n{model}\n{named}");
    let plan = plan(&with("of = \"phi1\"\nquantity = \"100 - charge\"\nbound = 50"));
    assert_eq!(plan.file().model.as_ref().map(|model| model.quantity.value.to_string()), Some("100 - charge".into()));
    for (model, wanted) in [
        (
            "of = \"phi1\"\nquantity = \"100 - change\"\nbound = 50",
            "there is no numeric parameter with the name `change`",
        ),
        ("of = \"phi1\"\nquantity = \"100 -\"\nbound = 50", "the formula is incomplete"),
        ("of = \"phi1\"\nquantity = \"charge\"", "`bound` is missing"),
    ] {
        let reported = problems(&format!("{ERRAND}{}", with(model)));
        assert!(reported.iter().any(|problem| problem.contains(wanted)), "{model}: {reported:?}");
    }
    let Err(error) =
        Plan::parse("campaign.toml", &format!("{ERRAND}{}", with("of = \"phi9\"\nquantity = \"charge\"\nbound = 1")))
    else {
        panic!("there is no phi9")
    };
    assert!(error.reasons().contains("unknown property `phi9`"), "{error:?}");
    let reported = problems(&format!("{ERRAND}runs = 3\nmeasures = [\"colisions\"]\n"));
    assert!(reported.iter().any(|problem| problem.contains("unknown measure `colisions`")), "{reported:?}");
}

#[test]
fn every_campaign_that_comes_with_the_program_can_be_planned() {
    // A component of the guide is a program, which only a `main` that manages programs can start. So
    // tests/check_command.rs checks that campaign.
    for (name, _) in shipped_campaigns().filter(|(name, _)| *name != "guide_patience") {
        let plan = Plan::load(Path::new(name)).unwrap_or_else(|error| panic!("{name}: {}", error.reasons()));
        assert_eq!(plan.name(), name);
        assert!(!plan.file().about.is_empty() && plan.runs() > 0, "{name}");
    }
    let Err(error) = Plan::load(Path::new("batery_reserve")) else { panic!("there is none") };
    assert_eq!(error.reasons(), "there is no campaign `batery_reserve`");
}

#[test]
fn the_bug_hunt_tries_every_mistake_of_every_skill() {
    let plan = Plan::load(Path::new("bug_hunt")).unwrap();
    let tried: Vec<String> = (0..plan.runs())
        .map(|k| match &plan.run(k).values[..] {
            [ParameterValue::Text(mutant)] => mutant.clone(),
            other => panic!("{other:?}"),
        })
        .collect();
    let all = skills::SHIPPED.iter().flat_map(|(name, text)| {
        let mistakes = skills::mutations(name, text).unwrap();
        mistakes.into_iter().map(move |mistake| format!("{name}: {mistake}"))
    });
    assert_eq!(tried, all.collect::<Vec<_>>(), "`steward skill mutants` lists them");
}
