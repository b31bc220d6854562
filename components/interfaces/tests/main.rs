//! Interfaces in files.

mod files;
mod random;
