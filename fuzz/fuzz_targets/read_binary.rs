#![no_main]

#[path = "../bodies/format.rs"]
mod format;

libfuzzer_sys::fuzz_target!(|data: &[u8]| format::read_binary(data));
