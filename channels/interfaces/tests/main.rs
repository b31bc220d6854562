//! Interfaces and definitions as files have them.

mod definitions;
mod files;
mod random;
