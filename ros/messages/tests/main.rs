//! What users of the crate see.

mod definitions;
mod encoding;
mod on_board;
mod random;
mod standard;
