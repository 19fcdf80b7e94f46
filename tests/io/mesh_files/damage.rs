//! Mesh files that are truncated or have wrong bytes.

use super::sample_files::{PLAIN, WITH_EXTENTS, bracket, path_of, read_bytes};

/// Yields the first positions, positions from the end, and some between.
fn offsets(count: usize, at_ends: usize) -> impl Iterator<Item = usize> {
    let inner = (at_ends..count - at_ends).step_by(count / 97);
    (0..at_ends).chain(inner).chain(count - at_ends..count)
}

#[test]
fn truncated_files_are_refused_or_lack_only_what_is_not_the_mesh() {
    for name in PLAIN.iter().chain(&WITH_EXTENTS) {
        let whole = bracket(name).mesh;
        let bytes = std::fs::read(path_of(name)).unwrap();
        // The last two bytes are excluded, because the final 10 of an ASCII file would become a 1.
        for length in offsets(bytes.len() - 2, 100) {
            if let Ok(file) = read_bytes(&format!("truncated_{name}"), &bytes[..length]) {
                let same = file.mesh.tets() == whole.tets();
                assert!(
                    same && file.mesh.vertices() == whole.vertices(),
                    "{name}: {length} bytes"
                );
            }
        }
    }
}

#[test]
fn files_with_wrong_bytes_never_panic() {
    for name in PLAIN.iter().chain(&WITH_EXTENTS) {
        let bytes = std::fs::read(path_of(name)).unwrap();
        for offset in offsets(bytes.len(), 50) {
            for wrong in [b'0', b'<', 0xff, bytes[offset] ^ 1] {
                let mut damaged = bytes.clone();
                damaged[offset] = wrong;
                // Some damaged files still contain a mesh, although a different one. No mesh is empty.
                let file = read_bytes(&format!("damaged_{name}"), &damaged);
                assert!(file.is_err() || file.unwrap().mesh.tet_count() > 0);
            }
        }
    }
}
