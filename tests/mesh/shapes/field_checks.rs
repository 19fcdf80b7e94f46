//! Common parts of the tests of shapes: extents at points, invariants of every field, tolerances.

use hydroelastic::mesh::{FieldTet, PressureField};
use nalgebra::{Vector3, vector};
use proptest::prelude::*;

/// Relative rounding error of sums over many tetrahedra.
pub const SUM_ROUND_OFF: f64 = 1e-13;

/// Error of a field at a point, relative to its largest value, in a mesh of ordinary proportions.
pub const EXACT: f64 = 1e-13;

/// Error of a field at a point if edges of the core are so short relative to the shape that gradients lose digits. The same tolerance
/// applies if these edges were omitted for that reason.
pub const NEARLY_DEGENERATE: f64 = 1e-5;

/// Largest distance (in barycentric coordinates) of a point on a face outside its tetrahedron.
const ON_FACE: f64 = 1e-9;

pub fn assert_relative(actual: f64, expected: f64, tolerance: f64) {
    let error = (actual - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{actual:e} is not {expected:e}"
    );
}

/// Returns the extent at a point, from the tetrahedron in which the point lies deepest.
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

/// Asserts the invariants of every built-in field.
pub fn assert_sound(field: &PressureField) {
    let mesh = field.mesh();
    for (index, tet) in field.tets().iter().enumerate() {
        assert!(mesh.tetrahedron(index).signed_volume() > 0.0);
        assert!(!tet.is_inert());
        // The surface is the set of faces with extent 0 at all three corners.
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

/// Returns a configuration that stores failures beside the source.
pub fn proptest_config() -> ProptestConfig {
    ProptestConfig {
        failure_persistence: Some(Box::new(
            proptest::test_runner::FileFailurePersistence::WithSource("regressions"),
        )),
        ..ProptestConfig::with_cases(200)
    }
}

/// Yields low-discrepancy points in the unit cube.
pub fn spread_points(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    // The steps are powers of the reciprocal of the root of x⁴ = x + 1.
    let steps = vector![
        0.819_172_513_396_164_4,
        0.671_043_606_703_789_2,
        0.549_700_477_901_942_6
    ];
    (1..=count).map(move |k| steps.map(|step| (k as f64 * step).fract()))
}
