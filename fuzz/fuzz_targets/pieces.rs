#![no_main]

#[path = "../bodies/convert.rs"]
mod convert;

libfuzzer_sys::fuzz_target!(|data: &[u8]| convert::pieces(data));
