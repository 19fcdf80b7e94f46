//! VTK XML files of any bytes hold a mesh or a closed surface, or are refused.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    fuzzing::read("vtu", bytes);
    fuzzing::read_surface("vtu", bytes);
});
