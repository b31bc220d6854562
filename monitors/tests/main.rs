//! The language, its semantics and its monitors, from outside.

mod agreement;
mod cases;
mod diagnostics;
mod endless;
mod language;
mod laws;
mod logs;
mod paper_monitors;
mod reports;
mod robot;
mod semantics;
mod support;
