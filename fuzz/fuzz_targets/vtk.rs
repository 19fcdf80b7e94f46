//! VTK legacy files of any bytes hold a mesh or a closed surface, or are refused.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    fuzzing::read("vtk", bytes);
    fuzzing::read_surface("vtk", bytes);
});
