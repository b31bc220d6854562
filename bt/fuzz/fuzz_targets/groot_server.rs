//! With coverage: `cargo +nightly fuzz run groot_server --features libfuzzer`, in the folder bt.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| bt_fuzz::groot_server::exercise(bytes));
