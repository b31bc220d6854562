//! The software and the processes on this machine. The tests of the binary also use this file.

use std::path::Path;
use std::process::Command;

/// Whether Python is installed; prints a note if not.
pub(crate) fn has_python() -> bool {
    let found = Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success());
    if !found {
        eprintln!("not run here: no python3");
    }
    found
}

/// The command lines of running processes that name this folder or have it as their working directory.
pub(crate) fn left_over(folder: &Path) -> Vec<String> {
    let command_line = |entry: std::io::Result<std::fs::DirEntry>| {
        let process = entry.ok()?.path();
        let line = String::from_utf8_lossy(&std::fs::read(process.join("cmdline")).ok()?).replace('\0', " ");
        let works_there = std::fs::read_link(process.join("cwd")).is_ok_and(|place| place.starts_with(folder));
        (works_there || line.contains(folder.to_str()?)).then_some(line)
    };
    std::fs::read_dir("/proc").into_iter().flatten().filter_map(command_line).collect()
}
