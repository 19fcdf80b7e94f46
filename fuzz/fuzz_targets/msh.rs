//! Files of Gmsh and MuJoCo of any bytes hold a mesh or a closed surface, or are refused.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    fuzzing::read("msh", bytes);
    fuzzing::read_surface("msh", bytes);
});
