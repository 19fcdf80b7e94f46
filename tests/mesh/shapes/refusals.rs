//! Invalid dimensions and resolutions of shapes are rejected, each by name.

use hydroelastic::mesh::{MeshError, PressureField, shapes};

#[test]
fn shapes_too_slender_for_round_off_are_refused() {
    let is_flat = |field: Result<PressureField, MeshError>| {
        matches!(field, Err(MeshError::ZeroVolume { .. }))
    };
    assert!(is_flat(shapes::cuboid([1.0, 1.0, 1e-13])));
    assert!(is_flat(shapes::cuboid([1.0, 1e-7, 1e-7])));
    assert!(is_flat(shapes::distance_cuboid([1.0, 1e-7, 1e-7])));
    assert!(is_flat(shapes::cylinder(1e-7, 1.0, 6)));
    assert!(is_flat(shapes::ellipsoid([1.0, 1e-7, 1e-7], 2)));
}

#[test]
fn bad_dimensions_are_named_with_their_value() {
    for bad in [0.0, -1.0, f64::INFINITY, f64::NAN, -0.0, f64::NEG_INFINITY] {
        let is_named = |field: Result<PressureField, MeshError>, expected: &str| {
            matches!(field, Err(MeshError::InvalidDimension { name, value })
                if name == expected && value.to_bits() == bad.to_bits())
        };
        for axis in 0..3 {
            let mut lengths = [1.0, 2.0, 3.0];
            lengths[axis] = bad;
            assert!(is_named(shapes::cuboid(lengths), "edge length"), "{bad}");
            assert!(
                is_named(shapes::distance_cuboid(lengths), "edge length"),
                "{bad}"
            );
            assert!(
                is_named(shapes::ellipsoid(lengths, 1), "semi-axis"),
                "{bad}"
            );
        }
        assert!(is_named(shapes::icosphere(bad, 1), "radius"), "{bad}");
        assert!(is_named(shapes::capsule(bad, 1.0, 8), "radius"), "{bad}");
        assert!(is_named(shapes::capsule(1.0, bad, 8), "length"), "{bad}");
        assert!(is_named(shapes::cylinder(bad, 1.0, 8), "radius"), "{bad}");
        assert!(is_named(shapes::cylinder(1.0, bad, 8), "length"), "{bad}");
    }
    let message = shapes::icosphere(-2.0, 1).unwrap_err().to_string();
    assert_eq!(
        message,
        "the radius of a shape must be positive and finite, but is -2"
    );
}

#[test]
fn bad_resolutions_are_named_with_their_limits() {
    let error = |name, found, lowest, highest| MeshError::InvalidResolution {
        name,
        found,
        lowest,
        highest,
    };
    for subdivisions in [11, usize::MAX] {
        let expected = error("subdivisions", subdivisions, 0, 8);
        assert_eq!(shapes::icosphere(1.0, subdivisions).unwrap_err(), expected);
        assert_eq!(
            shapes::ellipsoid([1.0; 3], subdivisions).unwrap_err(),
            expected
        );
    }
    for segments in [0, 2, 100_001, usize::MAX] {
        let expected = error("segments", segments, 3, 100_000);
        assert_eq!(shapes::cylinder(1.0, 1.0, segments).unwrap_err(), expected);
    }
    let message = shapes::cylinder(1.0, 1.0, 2).unwrap_err().to_string();
    assert_eq!(message, "a shape takes 3 to 100000 segments, not 2");
}
