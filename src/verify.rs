//! `steward verify LOG… [--property FILE.scope]`: checks recorded runs and robots against properties.

pub(crate) mod announcer;
pub(crate) mod args;
pub(crate) mod bag;
#[cfg(test)]
mod beside;
pub(crate) mod inputs;
mod logs;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use bags::Contents;
use campaigns::Error;
use diagnostics::counted;
use judging::{ShowRun, VerificationResult, Wanted};
use monitors::Property;
use recording::Certainty;
use reports::report::ViolationsReport;
use serde_json::json;

use crate::interrupt::{self, HOST};
use crate::output::{complain, note, print, print_json, print_json_line, print_wrapped};
use announcer::{Announcer, Reactions};
use logs::Line;

pub(crate) use args::VerifyArgs;

/// Checks each log. Status 2 if one cannot be checked, or a property has no verdict, otherwise 1 if a property is
/// violated, or its verdict is unsure.
pub(crate) fn verify(args: &VerifyArgs) -> Result<ExitCode, Error> {
    args.results.begin()?;
    let folders = folders(args);
    let names: Vec<String> = args.logs.iter().map(|log| log.display().to_string()).collect();
    args.results.or_refused("verify", &names, logs::check_outputs(args, &folders))?;
    let (mut bad, mut refused, mut is_shown, mut reports, mut lines) = (false, false, false, Vec::new(), Vec::new());
    let several = args.logs.len() > 1;
    for (is_given, done) in [(args.follow, "followed"), (args.board.is_live(), "shown")] {
        if is_given && several {
            let message = format!("several logs cannot be {done} at once");
            return Err(Error::refused(message, "give each its own command"));
        }
    }
    if args.follow {
        interrupt::listen();
    }
    for (log, folder) in args.logs.iter().zip(folders) {
        let output = if args.list {
            bag::list(log).map(LogOutput::Contents)
        } else {
            verify_log(args, log, folder.as_deref()).map(|result| LogOutput::Verdicts(Box::new(result)))
        };
        let output = match output {
            Ok(output) => output,
            Err(error) => {
                complain(&error);
                refused = true;
                reports.push(Line::refused(log, &error));
                lines.push(Line::of(args, log, folder, Err(&error)));
                continue;
            }
        };
        if let LogOutput::Verdicts(result) = &output {
            lines.push(Line::of(args, log, folder, Ok(result)));
            is_shown = true;
        }
        let status = output.status();
        bad |= status == 1;
        refused |= status == 2;
        if args.json {
            reports.push(output.as_json(log));
            continue;
        }
        if several {
            print_wrapped(format!("{}:\n", log.display()))?;
        }
        match output {
            LogOutput::Verdicts(result) => print_wrapped(in_words(&result))?,
            // The mapping is meant to be pasted, so its lines are not wrapped.
            LogOutput::Contents(contents) => print(&bag::in_words(&contents, &BTreeMap::new()))?,
        }
    }
    logs::sort(&mut lines);
    args.results.write("verify", || lines.iter().map(Line::suite).collect())?;
    match reports.as_slice() {
        [report] if args.json && args.follow => print_json_line(report)?,
        [report] if args.json && !several => print_json(report)?,
        reports if args.json => print_json(&reports)?,
        _ if several && !args.list => print(&logs::in_words(&lines))?,
        _ => {}
    }
    if let Some(out) = args.out.as_ref().filter(|_| several) {
        logs::write_index(&lines, out)?;
    }
    if is_shown && args.board.is_live() {
        // Until here, Ctrl-C ends the program at once, unless a log is followed.
        if !args.follow {
            interrupt::listen();
        }
        args.board.stay();
    }
    Ok(ExitCode::from(if refused { 2 } else { u8::from(bad) }))
}

/// The folder for the report of each log; none without `--out`.
fn folders(args: &VerifyArgs) -> Vec<Option<PathBuf>> {
    match &args.out {
        None => vec![None; args.logs.len()],
        Some(out) if args.logs.len() == 1 => vec![Some(out.clone())],
        Some(out) => logs::folders(&args.logs, out).into_iter().map(Some).collect(),
    }
}

/// The output for a log: verdicts or, with `--list`, contents.
enum LogOutput {
    Verdicts(Box<VerificationResult>),
    Contents(Contents),
}

impl LogOutput {
    fn status(&self) -> u8 {
        if let Self::Verdicts(result) = self { result.status() } else { 0 }
    }

    fn as_json(&self, log: &Path) -> serde_json::Value {
        match self {
            Self::Verdicts(result) => as_json(result, log),
            Self::Contents(contents) => bag::as_json(contents, log),
        }
    }
}

/// Checks a log, and writes its report to the folder, if there is one.
fn verify_log(args: &VerifyArgs, path: &Path, folder: Option<&Path>) -> Result<VerificationResult, Error> {
    let tree = args.tree.load(std::slice::from_ref(&path.to_owned()))?;
    let page: ShowRun<'_> = &|view| args.board.feed(view);
    let wanted = Wanted {
        command: args.command(path),
        folder,
        stories: args.results.have_stories(),
        inputs: &|| args.inputs(path),
        observer: args.follow.then(|| Announcer::boxed(args.json, Reactions::default())),
        record: None,
        page: args.board.is_live().then_some(page),
        host: HOST,
    };
    let mut result = judging::verify(&args.request(path, tree.as_ref())?, wanted)?;
    result.notes.extend(bag::part(&args.logs, path).filter(|_| args.map_channels.is_some()));
    result.notes.iter().for_each(|text| note(text));
    Ok(result)
}

/// The verdicts as text.
pub(crate) fn in_words(result: &VerificationResult) -> String {
    let VerificationResult { properties, end, start_ns, knows_ticks, .. } = result;
    let mut text = String::new();
    let since = start_ns.map_or_else(String::new, |ns| format!(" since {}", bags::moment(ns)));
    let ticks = if *knows_ticks { format!(", {}", counted(end.ticks, "tick")) } else { String::new() };
    text += &format!("{}{ticks}{since}\n", counted(end.messages, "message"));
    for empty in result.empty_inputs() {
        text += &format!("{empty}\n");
    }
    for assumption in result.assumptions() {
        text += &format!("it is assumed that {assumption}\n");
    }
    let widest = properties.iter().map(|property| property.name.chars().count()).fold(12, usize::max);
    for (index, property) in properties.iter().enumerate() {
        text += &format!("{:<widest$} {}\n", property.name, result.verdict(index));
        match result.evidence[index].certainty() {
            Certainty::Sure => {}
            Certainty::Unless(why) => text += &format!("  unless {why}\n"),
            Certainty::Unsure(why) => {
                text += &format!("  {why}\n  without what is missing: {}\n", result.outcome(index));
            }
            Certainty::Groundless(why) => {
                text += &format!("  {why}\n");
                continue;
            }
        }
        for channel in result.evidence[index].silent() {
            text += &format!("  no message {channel} in the whole run\n");
        }
        if let Some(unreported) = &result.unreported_levels[index] {
            text += &format!("  {unreported}\n");
        }
        let Some(monitor) = property.scope_monitor() else { continue };
        if let Some(witness) = monitor.witness() {
            text += &reports::witness_in_words(witness, *knows_ticks);
            if let Some(start_ns) = start_ns {
                let ns = i64::try_from(witness.settled.time.as_nanos()).unwrap_or(i64::MAX);
                text += &format!("  at {}\n", bags::moment(start_ns.saturating_add(ns)));
            }
        }
        if let Some(words) = monitor.violations().and_then(|violations| violations.in_words(result.end_time())) {
            text += &format!("  {words}\n");
        }
        for open in result.open(monitor) {
            text += &format!("  {open}\n");
        }
        for vacuity in monitor.vacuous() {
            text += &format!("  {vacuity}\n");
        }
    }
    text
}

/// The verdicts as JSON.
pub(crate) fn as_json(result: &VerificationResult, log: &Path) -> serde_json::Value {
    let VerificationResult { properties, evidence, unreported_levels, start_ns, notes, .. } = result;
    let of = |(index, property): (usize, &Property)| {
        let evidence = &evidence[index];
        let monitor = property.scope_monitor().filter(|_| !matches!(evidence.certainty(), Certainty::Groundless(_)));
        let vacuous = monitor.map(|monitor| monitor.vacuous()).unwrap_or_default();
        let open = monitor.map(|monitor| result.open(monitor)).unwrap_or_default();
        let witness = monitor.and_then(|monitor| monitor.witness());
        let violations = monitor.and_then(|monitor| monitor.violations());
        json!({
            "name": property.name,
            "property": property.formula,
            "timed": property.scope_monitor().is_some_and(|monitor| monitor.formula().is_timed()),
            "verdict": result.verdict(index).name(),
            "certainty": evidence.certainty().name(),
            "unsure": evidence.certainty().why(),
            "assumptions": evidence.assumptions(),
            "silent": evidence.silent(),
            "state": property.monitor.location(),
            "witness": witness.map(|witness| reports::witness(witness, result.knows_ticks)),
            "violations": violations.map(|violations| ViolationsReport::of(violations, result.end_time())),
            "open": open,
            "vacuous": vacuous.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "unheard": unreported_levels[index],
        })
    };
    let mut report = json!({
        "log": log.display().to_string(),
        "version": env!("CARGO_PKG_VERSION"),
        "provenance": result.provenance(),
        "monitors": properties.iter().enumerate().map(of).collect::<Vec<_>>(),
    });
    report["notes"] = result.empty_inputs().map(str::to_owned).chain(notes.iter().cloned()).collect();
    if let Some(start_ns) = start_ns {
        report["start_s"] = bags::seconds(*start_ns).into();
    }
    report
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::path::PathBuf;

    use super::*;
    use crate::live::BoardArgs;
    use crate::results::ResultsArgs;

    fn args(log: &Path, property: &str) -> VerifyArgs {
        let (logs, properties) = (vec![log.to_owned()], vec![PathBuf::from(property)]);
        VerifyArgs {
            logs,
            properties,
            robots: args::RobotsArgs::default(),
            scenario: None,
            map_channels: None,
            tree: crate::bag_tree::BagTreeArgs::default(),
            out: None,
            results: ResultsArgs::default(),
            follow: false,
            board: BoardArgs::default(),
            list: false,
            json: true,
        }
    }

    /// A line of a log: a message about the battery's level.
    fn level(step: u64, to: &str, level: f64) -> String {
        let ends = format!(r#""from":"BatteryReader","to":"{to}""#);
        format!(r#"{{"step":{step},"tick":0,"time_s":0,{ends},"message":[{{"sym":"ok"}},{level}]}}"#)
    }

    #[test]
    fn a_log_without_events_is_reported_and_has_no_verdict() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        for text in ["", "{}\n"] {
            write!(file, "{text}").expect("room for a line");
            let result = verify_log(&args(file.path(), "phi1"), file.path(), None).expect("a readable log");
            assert!(in_words(&result).starts_with("0 messages, 0 ticks\nthe log contains no events\n"), "{text}");
            assert_eq!((result.verdict(0).name(), result.status()), ("no verdict", 2), "{text}");
            let notes = &as_json(&result, file.path())["notes"];
            assert!(notes[0].as_str().is_some_and(|note| note.contains("no events")), "{notes}");
        }
    }

    #[test]
    fn verdicts_that_missing_lines_could_change_are_unsure() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let first = [r#"{"scenario":"nominal"}"#, r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#];
        writeln!(file, "{}\n{}\n{}", first.join("\n"), level(1, "BatteryLevel", 50.0), level(9, "BatteryLevel", 40.0))
            .expect("room for four lines");
        let result = verify_log(&args(file.path(), "phi1"), file.path(), None).expect("a readable log");
        assert_eq!((result.verdict(0).name(), result.outcome(0)), ("unsure", monitors::Outcome::Satisfied));
        let missing = "lines are missing before line 4 of the log: step 9 comes where 2 should";
        assert_eq!((result.evidence[0].certainty().why(), &result.notes), (Some(missing), &vec![missing.to_owned()]));
        writeln!(file, "{}", level(11, "BatteryLevel", 10.0)).expect("room for a line");
        let result = verify_log(&args(file.path(), "phi1"), file.path(), None).expect("a readable log");
        let extent = format!("how often and how long phi1 was violated is unsure: {missing}");
        assert_eq!((result.verdict(0).name(), &result.notes), ("violated", &vec![missing.to_owned(), extent]));
    }

    #[test]
    fn a_log_that_breaks_off_is_unsure_of_what_more_could_change() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let first =
            [r#"{"scenario":"nominal","has_end":true}"#, r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#];
        let judged =
            |file: &Path| verify_log(&args(file, "phi1"), file, None).expect("a readable log").verdict(0).name();
        writeln!(file, "{}\n{}", first.join("\n"), level(1, "BatteryLevel", 50.0)).expect("room for three lines");
        assert_eq!(judged(file.path()), "unsure");
        writeln!(file, r#"{{"end":"arrival","step":1,"tick":0,"time_s":99.5}}"#).expect("room for a line");
        assert_eq!(judged(file.path()), "satisfied");
        let result = verify_log(&args(file.path(), "phi1"), file.path(), None).expect("a readable log");
        assert_eq!(
            result.end_time(),
            std::time::Duration::from_secs_f64(99.5),
            "what lasts to the end lasts until then"
        );
        let mut cut = tempfile::NamedTempFile::new().expect("a file");
        writeln!(cut, "{}\n{}", first.join("\n"), level(1, "BatteryLevel", 9.0)).expect("room for three lines");
        assert_eq!(judged(cut.path()), "violated", "whatever came after it");
    }

    /// Such a log is, for example, converted from a log of BehaviorTree.CPP.
    #[test]
    fn a_log_without_ticks_is_refused_where_they_are_counted() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let first = r#"{"scenario":"nominal","tick_s":0.0}"#;
        writeln!(file, "{first}\n{}", level(1, "BatteryLevel", 50.0)).expect("room for two lines");
        let judged = |property: &str| verify_log(&args(file.path(), property), file.path(), None);
        let refused = judged("phi2").err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refused.contains("counts ticks"), "{refused}");
        let verified = judged("phi1").expect("a readable log");
        let assumed =
            "the log has every message of the scenario's channels, and that the program logged every change of status";
        assert!(verified.assumptions().contains(assumed), "{:?}", verified.assumptions());
    }

    #[test]
    fn a_property_that_counts_ticks_is_unsure_on_a_log_that_has_none() {
        let mut log = tempfile::NamedTempFile::new().expect("a file");
        let lines = [level(1, "BatteryLevel", 50.0), level(2, "BatteryLevel", 9.0)];
        writeln!(log, "{}\n{}", lines[0], lines[1]).expect("room for two lines");
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("p.scope");
        let verdict = |formula: &str| {
            let text = format!("property p := {formula}\nproperty other := eventually (LEVEL = 50)\n");
            std::fs::write(&file, text.replace("LEVEL", "BatteryReader, BatteryLevel, m[2]")).expect("room for both");
            let args = args(log.path(), file.to_str().expect("a path in UTF-8"));
            let verified = verify_log(&args, log.path(), None).expect("a readable log");
            assert_eq!(verified.verdict(1).name(), "satisfied", "it counts no ticks");
            verified.verdict(0).name()
        };
        assert_eq!(verdict("always ((LEVEL = 50) implies time_until (LEVEL < 10) < 3)"), "unsure");
        assert_eq!(verdict("always ((LEVEL < 10) implies once[<= 3] (LEVEL = 50))"), "unsure");
        assert_eq!(verdict("always (LEVEL > 1)"), "satisfied");
    }

    /// The messages are, for example, of a scenario in which a process has another name.
    #[test]
    fn messages_on_other_channels_leave_no_verdict_about_channels_that_may_not_have_been_in_the_log() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let first =
            [r#"{"scenario":"nominal","version":"0.1.0"}"#, r#"{"step":0,"tick":0,"time_s":0,"generated":"tick"}"#];
        let judged = |file: &Path| {
            let result = verify_log(&args(file, "phi1"), file, None).expect("a readable log");
            (result.verdict(0).name(), result.evidence[0].certainty().why().unwrap_or_default().to_owned())
        };
        writeln!(file, "{}\n{}", first.join("\n"), level(1, "BatLevel", 10.0)).expect("room for three lines");
        let (verdict, why) = judged(file.path());
        assert!(
            verdict == "no verdict" && why.contains("from BatteryReader to BatteryLevel: none is in the log"),
            "{why}"
        );
        // After a message on the channel, the channel is known to be in the log.
        writeln!(file, "{}", level(2, "BatteryLevel", 50.0)).expect("room for a line");
        assert_eq!(judged(file.path()), ("satisfied", String::new()));
    }

    #[test]
    fn a_log_is_checked_against_the_shipped_properties() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        let lines = [
            r#"{"scenario":"battery_fault","seed":1}"#,
            r#"{"step":0,"tick":0,"time_s":0.0,"generated":"tick"}"#,
            r#"{"step":1,"tick":0,"time_s":0.1,"from":"BatteryReader","to":"BatteryLevel","message":[{"sym":"ok"},10.0]}"#,
        ];
        writeln!(file, "{}", lines.join("\n")).expect("room for three lines");
        let verdict = |name: &str| format!("{:?}", verify(&args(file.path(), name)).expect("a readable log"));
        assert_eq!(verdict("phi1"), format!("{:?}", ExitCode::from(1)));
        assert_eq!(verdict("phi2"), format!("{:?}", ExitCode::SUCCESS));
    }

    #[test]
    fn bounds_in_seconds_are_counted_in_the_ticks_of_the_log() {
        let folder = tempfile::tempdir().expect("a folder");
        let property = folder.path().join("soon.scope");
        let text = "property soon := always ((BatteryReader, BatteryLevel, m[2] < 20) implies\n\
                    time_until (GotoRechargingStation, Navigation, m[1] = <start_navigation>) < 2 s)\n";
        std::fs::write(&property, text).expect("room for a property");
        let log = folder.path().join("log.jsonl");
        let ticks = |from: u64, to: u64| {
            let step = from.min(1);
            (from..to)
                .map(move |tick| format!(r#"{{"step":{step},"tick":{tick},"time_s":{tick}.0,"generated":"tick"}}"#))
        };
        let low = r#"{"step":1,"tick":0,"time_s":0.1,"from":"BatteryReader","to":"BatteryLevel","message":[{"sym":"ok"},10.0]}"#;
        let status = |tick_s: f64| {
            // As long as that of a system with many channels.
            let about = "x".repeat(100_000);
            let mut lines = vec![format!(r#"{{"about":"{about}","scenario":"nominal","tick_s":{tick_s}}}"#)];
            lines.extend(ticks(0, 1).chain([low.to_owned()]).chain(ticks(1, 4)));
            std::fs::write(&log, lines.join("\n")).expect("room for a log");
            let property = property.to_str().expect("its name is text");
            format!("{:?}", verify(&args(&log, property)).expect("a readable log"))
        };
        assert_eq!(status(1.0), format!("{:?}", ExitCode::from(1)), "two ticks are two seconds");
        assert_eq!(status(0.5), format!("{:?}", ExitCode::SUCCESS), "there are two ticks per second");
    }
}
