//! The binary under test.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The binary: the one that `STEWARD_BINARY` names, or else the one that was built with the tests.
pub(crate) fn binary() -> PathBuf {
    env::var_os("STEWARD_BINARY").map_or_else(|| env!("CARGO_BIN_EXE_steward").into(), PathBuf::from)
}

/// Calls the binary with these arguments.
pub(crate) fn steward(arguments: &[&str]) -> Output {
    Command::new(binary()).args(arguments).output().expect("the binary starts")
}

/// Runs a scenario with these additional arguments and returns its report; the exit status must be 0 or 1.
pub(crate) fn report(scenario: &str, out: &Path, arguments: &[&str]) -> serde_json::Value {
    let out_text = out.to_str().expect("a path in UTF-8");
    let mut all = vec!["--scenario", scenario, "--out", out_text, "--json"];
    all.extend(arguments);
    let output = steward(&all);
    let status = output.status.code();
    assert!(matches!(status, Some(0 | 1)), "{status:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("the report is JSON")
}

/// The binary's message on stderr when it refuses its input with exit status 2.
pub(crate) fn refusal(arguments: &[&str]) -> String {
    let output = steward(arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

/// Width and height of a PNG, in pixels.
pub(crate) fn picture_size(file: &Path) -> (u32, u32) {
    image::ImageReader::open(file).expect("the picture is there").into_dimensions().expect("the picture is a PNG")
}
