//! The search against a naive enumeration, which copies whole channel systems, normalizes them and compares them.

mod keepers;
mod limits;
mod naive;
mod random_systems;
mod spin;
mod storing;

#[expect(dead_code, reason = "only what the search stores and finds again is tested here")]
#[path = "../src/store.rs"]
mod store;
