//! When pictures are taken: the `[snapshots]` of a scenario file.

use diagnostics::document::Table;
use diagnostics::{Spanned, nearest_or_all};
use recording::{SnapshotOccasion, Snapshots};
use serde_json::json;

use super::robot::STEP;

const MOMENTS: [(&str, SnapshotOccasion); 5] = [
    ("start", SnapshotOccasion::Start),
    ("fault", SnapshotOccasion::Fault),
    ("verdict", SnapshotOccasion::Verdict),
    ("arrival", SnapshotOccasion::Arrival),
    ("end", SnapshotOccasion::End),
];

pub(super) fn read_snapshots(root: Table<'_>) -> Snapshots {
    let table = root.table("snapshots").about("When pictures are taken, besides those of violations.").optional();
    let Some(table) = table else { return Snapshots::default() };
    let names = MOMENTS.map(|(name, _)| name);
    let at = table.get::<Vec<Spanned<String>>>("at").about("On these occasions.");
    let at = at.words(&format!("an array of {}", names.join(", "))).rules(|| json!({ "items": { "enum": names } }));
    let at = at.try_map(|given, _| {
        let moment = |name: Spanned<String>| {
            let found = MOMENTS.iter().find(|(known, _)| *known == name.value).map(|(_, moment)| *moment);
            found.ok_or_else(|| {
                let problem = name.span.problem(format!("unknown moment `{}`", name.value));
                let help = nearest_or_all(&name.value, "the moments", &names);
                problem.with_label("no such moment").with_help(help)
            })
        };
        given.into_iter().map(moment).collect::<Result<Vec<_>, _>>()
    });
    let at_times = table.get("at_s").about("At these times, in seconds.").words("an array of numbers");
    let every = table.seconds("every_s").about("Repeatedly, at intervals of this many seconds.").at_least(STEP);
    Snapshots { at: at.or_empty(), at_times: at_times.or_empty(), every: every.optional() }
}
