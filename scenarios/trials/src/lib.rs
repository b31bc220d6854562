//! Navigation and localization measured alone, without a behavior tree: the benchmark of trips that `steward navigate`
//! runs ([`navigate`]), and recorded robots that are localized and mapped by `steward localize` and `steward map`
//! ([`replay`]).

pub mod navigate;
pub mod replay;
