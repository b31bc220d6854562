//! The one way to write a path that many lead to.

use std::path::{Component, Path, PathBuf};

/// A path from the root of the file system, without `.` and `..`. Links are not resolved.
#[must_use]
pub fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(normal.pop()),
            part => normal.push(part),
        }
    }
    normal
}
