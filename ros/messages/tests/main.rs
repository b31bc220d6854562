//! What users of the crate see.

mod definitions;
mod random;
