//! Finds the commit from which the program is built.
//!
//! Only this crate is built again after a commit, and only then: the script runs again when HEAD or its branch moves.
//! Without git, as in an archive of the crate, the commit is unknown, unless STEWARD_COMMIT names it.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=STEWARD_COMMIT");
    let commit = std::env::var("STEWARD_COMMIT").ok().or_else(|| {
        // An archive may lie in the working tree of something else.
        let here = std::env::var("CARGO_MANIFEST_DIR").ok()?;
        let root = git(&["rev-parse", "--show-toplevel"])?;
        if Path::new(&root).canonicalize().ok()? != Path::new(&here).canonicalize().ok()? {
            return None;
        }
        let branch = git(&["rev-parse", "--symbolic-full-name", "HEAD"]);
        for name in ["HEAD", "packed-refs"].into_iter().map(str::to_owned).chain(branch) {
            let path = git(&["rev-parse", "--git-path", &name]).filter(|path| Path::new(path).exists());
            path.into_iter().for_each(|path| println!("cargo::rerun-if-changed={path}"));
        }
        git(&["rev-parse", "--short=12", "HEAD"])
    });
    let version = std::env::var("CARGO_PKG_VERSION").unwrap_or_default();
    match commit.filter(|commit| !commit.is_empty()) {
        Some(commit) => {
            println!("cargo::rustc-env=STEWARD_COMMIT={commit}");
            println!("cargo::rustc-env=STEWARD_VERSION={version} (commit {commit})");
        }
        None => println!("cargo::rustc-env=STEWARD_VERSION={version} (commit unknown)"),
    }
}

/// What git says, if it does.
fn git(arguments: &[&str]) -> Option<String> {
    let done = Command::new("git").args(arguments).output().ok().filter(|done| done.status.success())?;
    Some(String::from_utf8(done.stdout).ok()?.trim().to_owned()).filter(|text| !text.is_empty())
}
