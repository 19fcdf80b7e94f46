//! Pressure fields from given extents: validation and interpolation.

use super::sample_meshes::{FIVE, ROUND_OFF, cube, l_shape, tet_around_a_vertex};
use hydroelastic::mesh::{FieldTet, MeshError, PressureField, TetMesh};
use nalgebra::vector;

fn field_error(mesh: TetMesh, extents: &[f64]) -> MeshError {
    PressureField::new(mesh, extents.to_vec()).unwrap_err()
}

#[test]
fn a_field_needs_one_extent_per_vertex() {
    for extents in [&[0.0; 4][..], &[0.0; 6][..], &[]] {
        let error = field_error(tet_around_a_vertex(), extents);
        let expected = MeshError::ExtentCount {
            vertex_count: 5,
            extent_count: extents.len(),
        };
        assert_eq!(error, expected);
    }
    let error = field_error(tet_around_a_vertex(), &[]);
    assert_eq!(
        error.to_string(),
        "a pressure field needs one extent per vertex: 5, but has 0"
    );
}

#[test]
fn extents_must_be_finite_and_not_negative() {
    for bad in [-1e-300, -1.0, f64::NAN, f64::INFINITY] {
        let error = field_error(tet_around_a_vertex(), &[0.0, 0.0, 0.0, 0.0, bad]);
        assert!(
            matches!(error, MeshError::InvalidExtent { vertex: 4, value }
                if value.to_bits() == bad.to_bits()),
            "{error}"
        );
    }
    let error = field_error(tet_around_a_vertex(), &[0.0, 0.0, -2.5, 0.0, 1.0]);
    assert_eq!(
        error.to_string(),
        "vertex 2 has the extent -2.5, but extents must be finite and not negative"
    );
}

#[test]
fn an_extent_must_not_rise_beyond_double_precision() {
    let error = field_error(tet_around_a_vertex(), &[0.0, 0.0, 0.0, 0.0, f64::MAX]);
    assert_eq!(error, MeshError::SteepField { tet: 0 });
    assert_eq!(
        error.to_string(),
        "the extent in tetrahedron 0 rises by more per meter than double precision can hold"
    );
}

#[test]
fn the_extent_on_the_surface_must_be_zero() {
    let error = field_error(tet_around_a_vertex(), &[0.0, 0.0, 0.0, 1e-9, 1.0]);
    let expected = MeshError::SurfaceExtent {
        vertex: 3,
        value: 1e-9,
    };
    assert_eq!(error, expected);
    assert_eq!(
        error.to_string(),
        "vertex 3 lies on the surface, where the extent must be 0, but has 0.000000001"
    );
}

#[test]
fn tetrahedra_without_pressure_are_named_or_inert() {
    let mesh = cube(&FIVE);
    assert_eq!(
        field_error(mesh.clone(), &[0.0; 8]),
        MeshError::ZeroField { tet: 0 }
    );
    let message = MeshError::ZeroField { tet: 0 }.to_string();
    assert!(
        message.contains("TetMesh::with_inner_vertices"),
        "{message}"
    );
    let field = PressureField::with_inert_tets(mesh, vec![0.0; 8]).unwrap();
    assert!(field.tets().iter().all(FieldTet::is_inert));
}

#[test]
fn the_first_tetrahedron_without_pressure_is_the_one_named() {
    // An additional tetrahedron shares a face with a tetrahedron that has an inner vertex.
    let mesh = tet_around_a_vertex();
    let vertices = [mesh.vertices(), &[vector![1.0, 1.0, 1.0]]].concat();
    let tets = [mesh.tets(), &[[1, 2, 3, 5]]].concat();
    let mesh = TetMesh::new(vertices, tets).unwrap();
    let error = field_error(mesh, &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    assert_eq!(error, MeshError::ZeroField { tet: 4 });
}

#[test]
fn fields_interpolate_the_extents_of_the_vertices() {
    let field = PressureField::from_distance(&l_shape(2)).unwrap();
    for (tet, corners) in field.tets().iter().zip(field.mesh().tets()) {
        for (corner, &vertex) in corners.iter().enumerate() {
            let position = &field.mesh().vertices()[vertex];
            let expected = field.extents()[vertex];
            assert!((tet.extent.at(position) - expected).abs() <= ROUND_OFF);
            for (other_corner, barycentric) in tet.barycentric.iter().enumerate() {
                let expected = f64::from(u8::from(other_corner == corner));
                assert!((barycentric.at(position) - expected).abs() <= ROUND_OFF);
            }
        }
        assert!(tet.steepness <= field.steepest());
    }
}
