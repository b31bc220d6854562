//! With coverage: `cargo +nightly fuzz run log --features libfuzzer`, in the folder bt.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| bt_fuzz::log::exercise(bytes));
