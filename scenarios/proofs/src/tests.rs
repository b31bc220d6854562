//! Proofs about random systems.

use super::Proof;

mod texts;
mod waiting;
