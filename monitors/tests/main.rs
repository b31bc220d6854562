//! The language, its semantics and its monitors, from outside.

mod agreement;
mod support;
