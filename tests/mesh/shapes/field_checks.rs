//! What the tests of several shapes share: extents at points, the promises of every field, tolerances.

use hydroelastic::mesh::{FieldTet, PressureField};
use nalgebra::{Vector3, vector};
use proptest::prelude::*;

/// Sums over many tetrahedra, relative to the result.
pub const SUM_ROUND_OFF: f64 = 1e-13;

/// A field evaluated at a point, relative to its largest value, in a mesh of ordinary proportions.
pub const EXACT: f64 = 1e-13;

/// The same where edges of the core are so short beside the shape that gradients lose digits, or
/// where they were left out for that reason.
pub const NEARLY_DEGENERATE: f64 = 1e-5;

/// How far outside its tetrahedron (in barycentric coordinates) a point on a face may come out.
const ON_FACE: f64 = 1e-9;

pub fn assert_relative(found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{found:e} is not {expected:e}"
    );
}

/// The extent at a point, from the tetrahedron the point lies deepest in.
pub fn extent_at(field: &PressureField, point: &Vector3<f64>) -> f64 {
    let depth = |tet: &FieldTet| {
        let coordinates = tet.barycentric.iter().map(|field| field.at(point));
        coordinates.fold(f64::INFINITY, f64::min)
    };
    let deepest = field
        .tets()
        .iter()
        .max_by(|a, b| depth(a).total_cmp(&depth(b)));
    let tet = deepest.unwrap();
    assert!(depth(tet) >= -ON_FACE, "{point} lies in no tetrahedron");
    tet.extent.at(point)
}

/// What every ready-made field promises.
pub fn assert_sound(field: &PressureField) {
    let mesh = field.mesh();
    for (index, tet) in field.tets().iter().enumerate() {
        assert!(mesh.tetrahedron(index).signed_volume() > 0.0);
        assert!(!tet.is_inert());
        // The surface is where the extent is 0, and faces between three corners of it.
        let faces = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
        for (index, face) in faces.iter().enumerate() {
            let is_zero = face.iter().all(|&corner| tet.extents[corner] == 0.0);
            assert_eq!(tet.zero_faces & 1 << index != 0, is_zero);
        }
    }
    for (vertex, extent) in field.extents().iter().enumerate() {
        let expected = if mesh.is_on_surface(vertex) {
            0.0_f64
        } else {
            1.0
        };
        assert_eq!(extent.to_bits(), expected.to_bits());
    }
}

/// Failures are kept beside the source.
pub fn proptest_config() -> ProptestConfig {
    ProptestConfig {
        failure_persistence: Some(Box::new(
            proptest::test_runner::FileFailurePersistence::WithSource("regressions"),
        )),
        ..ProptestConfig::with_cases(200)
    }
}

/// Low-discrepancy points in the unit cube.
pub fn spread_points(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    // Powers of the reciprocal of the root of x⁴ = x + 1.
    let steps = vector![
        0.819_172_513_396_164_4,
        0.671_043_606_703_789_2,
        0.549_700_477_901_942_6
    ];
    (1..=count).map(move |k| steps.map(|step| (k as f64 * step).fract()))
}
