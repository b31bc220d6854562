//! Logs of trees: `.btlog` and `.db3`.

use std::fs;

use tree_logs::Log;

use crate::Random;

/// Logs that BehaviorTree.CPP wrote.
const WRITTEN: [&[u8]; 4] = [
    include_bytes!("../../logs/tests/captured/fetch.btlog"),
    include_bytes!("../../logs/tests/captured/killed.btlog"),
    include_bytes!("../../logs/tests/captured/fetch.db3"),
    include_bytes!("../../logs/tests/captured/killed.db3"),
];

/// Reads a file that may be a log, to its end or to what is wrong with it.
pub fn exercise(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder for the log");
    let path = folder.path().join("log");
    fs::write(&path, bytes).expect("a file for the log");
    let mut entries = 0;
    let read = Log::open(&path).and_then(|mut log| {
        while log.next_entry()?.is_some() {
            entries += 1;
            assert!(entries <= bytes.len(), "an entry takes at least a byte");
        }
        Ok(())
    });
    if let Err(error) = read {
        assert!(!error.to_string().is_empty(), "a refusal has a reason");
    }
}

/// The bytes of a damaged log.
pub fn bytes(random: &mut Random) -> Vec<u8> {
    let mut bytes = WRITTEN[random.below(WRITTEN.len())].to_vec();
    random.damage_bytes(&mut bytes);
    bytes
}
