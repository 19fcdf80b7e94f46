//! Mass, center of mass and inertia of meshes and of their surfaces against closed forms.

use super::sample_meshes::{
    FIVE, KUHN, ROUND_OFF, assert_inertia, assert_relative, cube, meshes, transformed, unit_tet,
};
use hydroelastic::mesh::{DensityError, TetMesh, TriangleSurface};
use hydroelastic::spatial::MassGradient;
use nalgebra::{Matrix3, Rotation3, Vector3, vector};

/// Rounding error of moments of a shape whose distance from the origin is ten times its size: about a hundred rounding errors of the
/// squared coordinates.
const SHIFTED_ROUND_OFF: f64 = 1e-12;

/// Returns the inertia (kg m²) of a box about its center.
fn box_inertia(mass: f64, lengths: &Vector3<f64>) -> Matrix3<f64> {
    let squares = lengths.component_mul(lengths);
    Matrix3::from_diagonal(&Vector3::from_fn(|axis, _| {
        mass / 12.0 * (squares.sum() - squares[axis])
    }))
}

#[test]
fn boxes_have_their_mass_properties_wherever_they_are() {
    let (lengths, density) = (vector![0.5, 1.0, 2.0], 800.0);
    for (shift, tolerance) in [
        (vector![0.0, 0.0, 0.0], ROUND_OFF),
        (vector![20.0, -10.0, 5.0], SHIFTED_ROUND_OFF),
    ] {
        let mesh = transformed(&cube(&KUHN), |v| v.component_mul(&lengths) + shift);
        let surface = TriangleSurface::around(&mesh).unwrap();
        for (volume, properties) in [
            (mesh.volume(), mesh.mass_properties(density)),
            (surface.volume(), surface.mass_properties(density)),
        ] {
            let properties = properties.unwrap();
            assert_relative(volume, 1.0, tolerance);
            assert_relative(properties.mass, density, tolerance);
            let center = lengths * 0.5 + shift;
            assert!((properties.center_of_mass - center).amax() <= tolerance);
            let expected = box_inertia(density, &lengths);
            assert_inertia(&properties.inertia, &expected, tolerance);
        }
    }
}

#[test]
fn a_turned_box_has_the_turned_inertia() {
    let (lengths, density) = (vector![0.5, 1.0, 2.0], 3.0);
    let rotation = Rotation3::new(vector![0.4, -1.1, 0.3]);
    let mesh = transformed(&cube(&FIVE), |v| rotation * v.component_mul(&lengths));
    let expected = rotation * box_inertia(density, &lengths) * rotation.transpose();
    let surface = TriangleSurface::around(&mesh).unwrap();
    for properties in [
        mesh.mass_properties(density),
        surface.mass_properties(density),
    ] {
        let inertia = properties.unwrap().inertia;
        assert_inertia(&inertia, &expected, ROUND_OFF);
        // The matrix is exactly symmetric, so algorithms for symmetric matrices lose nothing.
        assert_eq!(inertia, inertia.transpose());
    }
}

#[test]
fn a_tetrahedron_has_its_mass_properties() {
    let properties = unit_tet().mass_properties(6.0).unwrap();
    assert_relative(properties.mass, 1.0, ROUND_OFF);
    assert!((properties.center_of_mass - Vector3::repeat(0.25)).amax() <= ROUND_OFF);
    // Over the unit tetrahedron ∫ x² dV = 1/60 and ∫ x y dV = 1/120. With mass 1 about the centroid: ⟨x²⟩ = 1/10 − 1/16 and ⟨x y⟩ = 1/20 −
    // 1/16.
    let expected = Matrix3::from_fn(|i, j| if i == j { 2.0 * 0.0375 } else { 0.0125 });
    assert_inertia(&properties.inertia, &expected, ROUND_OFF);
}

#[test]
fn mass_properties_do_not_depend_on_the_order_of_vertices_and_tetrahedra() {
    for (name, mesh) in meshes() {
        let count = mesh.vertex_count();
        // Seven is coprime to the counts here, so this is a permutation.
        let shuffled_index = |vertex: usize| (7 * vertex + 3) % count;
        assert!(count % 7 != 0, "{name}");
        let mut vertices = vec![Vector3::zeros(); count];
        for (vertex, position) in mesh.vertices().iter().enumerate() {
            vertices[shuffled_index(vertex)] = *position;
        }
        let tets = mesh
            .tets()
            .iter()
            .rev()
            .map(|[a, b, c, d]| [*c, *a, *d, *b].map(shuffled_index));
        let shuffled = TetMesh::new(vertices, tets.collect()).unwrap();
        let (actual, expected) = (
            shuffled.mass_properties(2.0).unwrap(),
            mesh.mass_properties(2.0).unwrap(),
        );
        assert_relative(actual.mass, expected.mass, ROUND_OFF);
        assert!((actual.center_of_mass - expected.center_of_mass).amax() <= ROUND_OFF);
        assert_inertia(&actual.inertia, &expected.inertia, ROUND_OFF);
    }
}

#[test]
fn densities_that_give_no_mass_are_refused() {
    let mesh = transformed(&cube(&KUHN), |v| v * 100.0);
    let surface = TriangleSurface::around(&mesh).unwrap();
    let gradient = MassGradient {
        by_mass: 1.0,
        by_center_of_mass: Vector3::zeros(),
        by_inertia: Matrix3::zeros(),
    };
    // At 1e305 the mass is finite, but the inertia is not.
    for density in [
        0.0,
        -1.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e308,
        1e305,
    ] {
        let errors = [
            mesh.mass_properties(density).err(),
            surface.mass_properties(density).err(),
            mesh.mass_gradient(density, &gradient).err(),
            surface.mass_gradient(density, &gradient).err(),
        ];
        for error in errors {
            let DensityError(refused_density) = error.unwrap();
            assert_eq!(refused_density.to_bits(), density.to_bits());
        }
    }
}
