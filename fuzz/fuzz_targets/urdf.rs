//! URDF files of any bytes hold a robot or are refused.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzzing::read_robot(bytes));
