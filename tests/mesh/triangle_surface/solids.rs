//! Volume, mass and inertia of the enclosed solid.

use super::sample_surfaces::{block, reversed, surface, together, torus, unit_block};
use crate::tet_mesh::sample_meshes::{assert_inertia, assert_relative, meshes};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::MassProperties;
use nalgebra::{Matrix3, Rotation3, Vector3, vector};
use std::f64::consts::PI;

/// Relative rounding error of sums over some hundred signed tetrahedra from the middle.
const ROUND_OFF: f64 = 1e-13;

/// Rounding error of moments of a shape whose distance from the origin is ten times its size: about a hundred rounding errors of the
/// squared coordinates.
const SHIFTED_ROUND_OFF: f64 = 1e-12;

/// Tolerance of the factor of a quarter by which the error of an inscribed polyhedron decreases if its edges are halved.
const SECOND_ORDER: f64 = 0.01;

fn box_inertia(mass: f64, lengths: &Vector3<f64>) -> Matrix3<f64> {
    let squares = lengths.component_mul(lengths);
    Matrix3::from_diagonal(&squares.map(|square| mass / 12.0 * (squares.sum() - square)))
}

fn assert_same(actual: &MassProperties, expected: &MassProperties, size: f64) {
    assert_relative(actual.mass, expected.mass, ROUND_OFF);
    let apart = (actual.center_of_mass - expected.center_of_mass).amax();
    assert!(apart <= ROUND_OFF * size, "{apart:e}");
    assert_inertia(&actual.inertia, &expected.inertia, ROUND_OFF);
}

#[test]
fn boxes_have_their_mass_properties_wherever_they_are() {
    let (lengths, density) = (vector![0.5, 1.0, 2.0], 800.0);
    for (low, tolerance) in [
        (Vector3::zeros(), ROUND_OFF),
        (vector![20.0, -10.0, 5.0], SHIFTED_ROUND_OFF),
    ] {
        let solid = surface(block(low, lengths));
        assert_relative(solid.volume(), 1.0, tolerance);
        let properties = solid.mass_properties(density).unwrap();
        assert_relative(properties.mass, density, tolerance);
        assert!((properties.center_of_mass - low - lengths / 2.0).amax() <= tolerance);
        assert_inertia(
            &properties.inertia,
            &box_inertia(density, &lengths),
            tolerance,
        );
    }
}

#[test]
fn a_turned_box_has_the_turned_inertia() {
    let lengths = vector![0.5, 1.0, 2.0];
    let rotation = Rotation3::new(vector![0.4, -1.1, 0.3]);
    let (vertices, triangles) = block(Vector3::zeros(), lengths);
    let turned = vertices.iter().map(|v| rotation * v).collect();
    let properties = surface((turned, triangles)).mass_properties(3.0).unwrap();
    let expected = rotation * box_inertia(3.0, &lengths) * rotation.transpose();
    assert_inertia(&properties.inertia, &expected, ROUND_OFF);
    assert_eq!(properties.inertia, properties.inertia.transpose());
}

#[test]
fn a_surface_has_the_mass_properties_of_the_mesh_it_is_around() {
    for (name, mesh) in meshes() {
        let solid =
            TriangleSurface::around(&mesh).unwrap_or_else(|error| panic!("{name}: {error}"));
        let size = mesh.aabb().half_extents().norm();
        assert_same(
            &solid.mass_properties(7.0).unwrap(),
            &mesh.mass_properties(7.0).unwrap(),
            size,
        );
        assert_relative(solid.volume(), mesh.volume(), ROUND_OFF);
        assert_eq!(solid.triangles().len(), mesh.surface_triangles().len());
        let (actual, expected) = (solid.aabb(), mesh.aabb());
        assert_eq!(
            (actual.lower, actual.upper),
            (expected.lower, expected.upper)
        );
    }
}

#[test]
fn ready_made_shapes_become_surfaces_of_the_same_reach() {
    let fields = [
        shapes::icosphere(0.1, 2),
        shapes::ellipsoid([0.1, 0.2, 0.3], 1),
        shapes::cuboid([0.1, 0.2, 0.3]),
        shapes::distance_cuboid([0.3, 0.1, 0.2]),
        shapes::cylinder(0.1, 0.3, 24),
    ];
    for field in fields {
        let field = field.unwrap();
        let solid = TriangleSurface::around(field.mesh()).unwrap();
        assert_eq!(solid.reach().to_bits(), field.reach().to_bits());
        assert_eq!(solid.component_starts(), [0]);
    }
}

#[test]
fn finer_spheres_tend_to_the_ball_with_the_square_of_their_edges() {
    let (radius, density) = (0.3_f64, 500.0);
    let mass = density * 4.0 / 3.0 * PI * radius.powi(3);
    let ball = MassProperties::solid_ball(mass, radius);
    let errors = [4, 5].map(|subdivisions| {
        let field = shapes::icosphere(radius, subdivisions).unwrap();
        let properties = TriangleSurface::around(field.mesh()).unwrap();
        let properties = properties.mass_properties(density).unwrap();
        let inertia = (ball.inertia - properties.inertia).amax() / ball.inertia.amax();
        [(ball.mass - properties.mass) / ball.mass, inertia]
    });
    for quantity in 0..2 {
        let [coarse, fine] = errors.map(|error| error[quantity]);
        assert!(fine > 0.0 && fine < 0.002, "{fine}");
        assert!(
            (fine / coarse - 0.25).abs() < SECOND_ORDER,
            "{fine} {coarse}"
        );
    }
}

#[test]
fn a_polygonal_ring_has_the_volume_of_pappus() {
    // The torus consists of prisms over an n-gon around an m-gon. By Pappus's theorem, the volume of a wedge is the section's area times
    // the path of its centroid in the direction across, 2·R·tan(π/m), shortened to the chord. In the middle of a wedge, the section is at
    // R·cos(π/m), and lengths around are 2·(R + x)·sin(π/m).
    let (radius, tube, [around, across]) = (1.0, 0.25, [24, 15]);
    let solid = surface(torus(radius, tube, [around, across]));
    let (half, n) = (PI / around as f64, across as f64);
    let section = 0.5 * n * tube * tube * (2.0 * PI / n).sin();
    // Wedges of pyramids sum up to ∫ (R + x)² over the section. By symmetry, ∫ x = 0.
    let volume = around as f64 * half.sin() * half.cos() * 2.0 * radius * section;
    assert_relative(solid.volume(), volume, 1e-12);
}

#[test]
fn a_cavity_is_taken_off() {
    let outer = block(vector![0.0, 0.0, 0.0], vector![3.0, 3.0, 3.0]);
    let inner = block(vector![0.5, 1.0, 1.0], vector![1.0, 1.0, 1.0]);
    let hollow = surface(together([outer.clone(), reversed(inner.clone())]));
    assert_eq!(hollow.component_starts(), [0, 12]);
    assert_relative(hollow.volume(), 26.0, ROUND_OFF);
    let properties = hollow.mass_properties(2.0).unwrap();
    assert_relative(properties.mass, 52.0, ROUND_OFF);
    let center = (Vector3::repeat(1.5) * 27.0 - vector![1.0, 1.5, 1.5]) / 26.0;
    assert!((properties.center_of_mass - center).amax() <= ROUND_OFF);
    // A block in the cavity is a third component. It may touch at corners only.
    let pebble = block(vector![0.75, 1.25, 1.25], vector![0.5, 0.5, 0.5]);
    let rattle = surface(together([reversed(inner), outer, pebble]));
    assert_eq!(rattle.component_count(), 3);
    assert_relative(rattle.volume(), 26.125, ROUND_OFF);
}

#[test]
fn overlapping_components_count_twice() {
    let shifted = unit_block(vector![0.5, 0.0, 0.0]);
    let both = surface(together([unit_block(Vector3::zeros()), shifted]));
    assert_relative(both.volume(), 2.0, ROUND_OFF);
}
