//! Logs that are converted from one format into another, for tests: a verdict is the same in all of them, or each is
//! refused.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use campaigns::Error;
use channels::Topology;
use checks::System;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng as _;
use recording::{Detail, Header, Recording, RunView, conduct};
use tree_logs::{LogWriter, LoggedTransition};

use crate::event_log::{Specification, verify_by};
use crate::host::Host;
use crate::judge::VerificationResult;
use crate::log_request::{LogRequest, Robots};
use crate::wanted::Wanted;

/// The time between ticks in the scenario of a log without it: its run was made with another.
const TICK_OF_SCENARIO: Duration = Duration::from_millis(200);

/// A tree as BehaviorTree.CPP logs it, what such a log can decide, and what it cannot, since it has no ticks.
const TREE: &str = r#"<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence _uid="1"><Lift _uid="2"/>
    <Drive _uid="3"/></Sequence></BehaviorTree></root>"#;
const OF_TREES: &str = "
    property lifts := eventually (Lift, BT, reply = <success>)
    property safe := always not (Drive, BT, reply = <failure>)
    property before := (not (Drive, BT, reply = <running>)) until (Lift, BT, reply = <success>)
    property lifted := always ((Drive, BT, reply = <success>) implies once (Lift, BT, reply = <success>))
    property held := always ((Drive, BT, reply = <running>) implies
        ((not (Lift, BT, reply = <failure>)) since (Lift, BT, reply = <success>)))
    property ends := eventually (always (Sequence, BT, reply != <failure>))
    timed property soon := always ((Lift, BT, reply = <running>) implies
        time_until (Lift, BT, reply = <success>) < 0.4 s)";
const OF_TICKS: &str = "property counted := always ((Lift, BT, reply = <running>) implies
    time_until (Lift, BT, reply = <success>) < 3)";

/// What `verify` finds in a log if these are the channels of its scenario, or why it refuses the log.
pub(crate) fn judge(path: &Path, properties: &str, topology: &Arc<Topology>) -> Result<VerificationResult, Error> {
    let request = LogRequest {
        path,
        properties: &[],
        scenario: None,
        mapping: None,
        robots: Robots::default(),
        tree: None,
        is_followed: false,
    };
    let wanted = Wanted {
        command: String::new(),
        folder: None,
        stories: false,
        inputs: &Vec::new,
        observer: None,
        record: None,
        page: None,
        host: Host::SILENT,
    };
    verify_by(&request, Recording::open(path).ok(), wanted, |described, header| {
        let tick = described.tick.unwrap_or(header.map_or(TICK_OF_SCENARIO, |header| header.tick));
        let system = System::new(Arc::clone(topology), tick);
        let properties = system.read("p.scope", properties)?.properties;
        Ok(Specification { system, run: Header::default(), properties, unjudged: Vec::new() })
    })
}

/// The verdicts on a log; none if it is refused.
fn verdicts(path: &Path, properties: &str, topology: &Arc<Topology>) -> Option<Vec<&'static str>> {
    let verified = judge(path, properties, topology).ok()?;
    Some((0..verified.properties.len()).map(|index| verified.verdict(index).name()).collect())
}

/// Converts a recording into every format, as `report --record` does, and some of these once more. Returns the verdicts
/// on each; none where it is refused.
pub(crate) fn in_every_format(
    path: &Path,
    properties: &str,
    topology: &Arc<Topology>,
) -> [Option<Vec<&'static str>>; 5] {
    let folder = tempfile::tempdir().expect("a folder");
    let files = ["a.rec", "b.mcap", "c.jsonl", "d.jsonl"].map(|name| folder.path().join(name));
    let [a, b, c, d] = files.each_ref().map(PathBuf::as_path);
    for (from, to) in [(path, a), (a, b), (path, c), (b, d)] {
        let recording = Recording::open(from).expect("a recording");
        let begin = |_: &RunView| Ok::<(), Box<dyn std::error::Error>>(());
        let played = conduct(recording, Detail::Full, Some(to), begin, |_| ControlFlow::Continue(()));
        played.expect("room for a file");
    }
    [path, a, b, c, d].map(|path| verdicts(path, properties, topology))
}

/// Checks that a log of BehaviorTree.CPP, which may be cut off, has the same verdicts in every format.
pub(crate) fn check_tree_log(path: &Path, random: &mut ChaCha8Rng) {
    let mut writer = LogWriter::begin(Vec::new(), TREE, 0).expect("room for a tree");
    let mut at_us = 0;
    for _ in 0..5 + random.next_u32() % 30 {
        at_us += i64::from(random.next_u32() % 300_000);
        let [uid, status] = [1 + random.next_u32() % 3, random.next_u32() % 5].map(i64::from);
        writer.write(LoggedTransition { at_us, uid, status }).expect("it fits");
    }
    let mut bytes = writer.finish().expect("room for a log");
    if random.next_u32().is_multiple_of(6) {
        // In the last change.
        bytes.truncate(bytes.len() - 1 - random.next_u32() as usize % (LoggedTransition::BYTES - 1));
    }
    fs::write(path, bytes).expect("room for a file");
    let view = Recording::open(path).expect("a recording").begin().expect("a tree");
    let topology = Arc::clone(&view.header().topology);
    let found = in_every_format(path, OF_TREES, &topology);
    assert!(found[0].is_some() && found.iter().all(|other| *other == found[0]), "{found:?}");
    let found = in_every_format(path, OF_TICKS, &topology);
    assert!(found.iter().all(Option::is_none), "{found:?}");
}
