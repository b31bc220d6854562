//! With coverage: `cargo +nightly fuzz run load --features libfuzzer`, in the folder skills.

#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| skills_fuzz::exercise(text));
