//! The search against a naive enumeration, which copies whole channel systems, normalizes them and compares them.

mod keepers;
mod limits;
mod naive;
mod random_systems;
mod spin;
