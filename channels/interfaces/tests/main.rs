//! Interfaces and definitions in files.

mod definitions;
mod files;
mod random;
