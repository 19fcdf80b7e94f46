//! glTF files of any bytes hold a closed surface or are refused.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzzing::read_surface("glb", bytes));
