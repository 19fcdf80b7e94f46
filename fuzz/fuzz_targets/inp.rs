//! Abaqus files of any bytes hold a mesh or are refused.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzzing::read("inp", bytes));
