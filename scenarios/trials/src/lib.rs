//! Measures navigation and localization alone, without a behavior tree: the benchmark of trips that `steward navigate`
//! runs ([`navigate`]), and the recorded robots of `steward localize` and `steward map` ([`replay`]).

pub mod navigate;
pub mod replay;
