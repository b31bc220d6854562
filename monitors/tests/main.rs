//! Tests of the language, its semantics and its monitors.

mod agreement;
mod broken_files;
mod cases;
mod diagnostics;
mod edges;
mod endless;
mod items;
mod language;
mod laws;
mod layout;
mod logs;
mod paper_monitors;
mod patterns;
mod proofs;
mod reports;
mod robot;
mod semantics;
mod support;
mod world;
