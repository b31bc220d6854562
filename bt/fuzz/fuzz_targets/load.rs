//! With coverage: `cargo +nightly fuzz run load --features libfuzzer`, in the folder bt.

#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| bt_fuzz::exercise(text));
