//! Volume, mass and inertia of the enclosed solid.

use super::sample_surfaces::{block, reversed, surface, together, torus, unit_block};
use crate::tet_mesh::sample_meshes::{assert_inertia, assert_relative, meshes};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::MassProperties;
use nalgebra::{Vector3, vector};
use std::f64::consts::PI;

/// Relative rounding error of sums over some hundred signed tetrahedra from the middle.
const ROUND_OFF: f64 = 1e-13;

/// Tolerance of the factor of a quarter by which the error of an inscribed polyhedron decreases if its edges are halved.
const SECOND_ORDER: f64 = 0.01;

fn assert_same(found: &MassProperties, expected: &MassProperties, size: f64) {
    assert_relative(found.mass, expected.mass, ROUND_OFF);
    let apart = (found.center_of_mass - expected.center_of_mass).amax();
    assert!(apart <= ROUND_OFF * size, "{apart:e}");
    assert_inertia(&found.inertia, &expected.inertia, ROUND_OFF);
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
        let (found, expected) = (solid.aabb(), mesh.aabb());
        assert_eq!((found.lower, found.upper), (expected.lower, expected.upper));
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
        let found = TriangleSurface::around(field.mesh()).unwrap();
        let found = found.mass_properties(density).unwrap();
        let inertia = (ball.inertia - found.inertia).amax() / ball.inertia.amax();
        [(ball.mass - found.mass) / ball.mass, inertia]
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
    let found = hollow.mass_properties(2.0).unwrap();
    assert_relative(found.mass, 52.0, ROUND_OFF);
    let center = (Vector3::repeat(1.5) * 27.0 - vector![1.0, 1.5, 1.5]) / 26.0;
    assert!((found.center_of_mass - center).amax() <= ROUND_OFF);
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
