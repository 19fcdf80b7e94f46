//! Skins: fields that rise up to a depth and are constant below, against min(distance/depth, 1).

use super::sample_meshes::{
    ROUND_OFF, assert_relative, enclosed_volume, grid, meshes, transformed, unit_tet,
};
use hydroelastic::mesh::{FieldTet, MeshError, PressureField, TetMesh, shapes};
use nalgebra::{Vector3, vector};

/// Rounding error of coordinates of new vertices in a few thin tetrahedra.
const INTERPOLATED: f64 = 1e-12;

/// Barycentric coordinates of a few points in a tetrahedron.
const PLACES: [[f64; 4]; 4] = [
    [0.25, 0.25, 0.25, 0.25],
    [0.7, 0.1, 0.1, 0.1],
    [0.1, 0.2, 0.6, 0.1],
    [0.05, 0.05, 0.4, 0.5],
];

/// Returns a few points in a tetrahedron and the extents there.
fn samples(tet: &FieldTet) -> [(Vector3<f64>, f64); 4] {
    PLACES.map(|weights| {
        let corners = tet.tetrahedron.corners.iter().zip(&tet.extents);
        let weighted = corners.zip(weights);
        weighted.fold((Vector3::zeros(), 0.0), |(p, e), ((corner, extent), w)| {
            (p + corner * w, e + extent * w)
        })
    })
}

/// Returns the extent at a point inside the mesh.
fn extent_at(field: &PressureField, point: &Vector3<f64>) -> f64 {
    let depth_in = |tet: &&FieldTet| {
        let coordinates = tet.barycentric.iter().map(|field| field.at(point));
        coordinates.fold(f64::INFINITY, f64::min)
    };
    let tets = field.tets().iter();
    let tet = tets.max_by(|a, b| depth_in(a).total_cmp(&depth_in(b)));
    tet.unwrap().extent.at(point)
}

#[test]
fn a_box_has_a_skin_of_the_given_depth_and_is_flat_below() {
    let lengths = vector![1.0, 1.4, 2.0];
    let cuboid = shapes::distance_cuboid(lengths.into()).unwrap();
    // The depths are thin, equal to the depth of the core, within round-off of it, and larger.
    for depth in [1e-4, 0.02, 0.37, 0.5 - 1e-15, 0.5, 0.7] {
        let field = PressureField::from_distance_up_to(cuboid.mesh(), depth).unwrap();
        for (point, extent) in field.tets().iter().flat_map(samples) {
            let distance = (lengths / 2.0 - point.abs()).min();
            let expected = (distance / depth).min(1.0);
            // The rounding error of a coordinate is proportional to its magnitude.
            let allowed = INTERPOLATED.max(ROUND_OFF / depth);
            assert!((extent - expected).abs() <= allowed, "{depth}: {point}");
        }
        assert_relative(field.steepest(), 1.0 / depth, INTERPOLATED / depth);
        let highest = field.extents().iter().copied().fold(0.0, f64::max);
        assert_relative(highest, (0.5 / depth).min(1.0), ROUND_OFF);
    }
}

#[test]
fn every_mesh_gets_its_interpolated_distance_cut_off_at_the_depth() {
    for (name, mesh) in meshes() {
        let by_distance = PressureField::from_distance(&mesh).unwrap();
        for share in [0.123_4, 0.371_8, 0.871_8] {
            // All extents of `by_distance` are relative to the largest distance.
            let steepness = by_distance.steepest();
            let depth = share * largest_distance(&by_distance);
            let field = PressureField::from_distance_up_to(&mesh, depth).unwrap();
            assert!(field.mesh().tet_count() > by_distance.mesh().tet_count());
            for (point, extent) in field.tets().iter().flat_map(samples) {
                let expected = (extent_at(&by_distance, &point) / share).min(1.0);
                assert!(
                    (extent - expected).abs() <= INTERPOLATED,
                    "{name}: {extent} {expected}"
                );
            }
            assert!(field.steepest() * share <= steepness * (1.0 + INTERPOLATED));
            assert_relative(field.mesh().volume(), mesh.volume(), INTERPOLATED);
            assert_relative(enclosed_volume(field.mesh()), mesh.volume(), INTERPOLATED);
            let triangles = [field.mesh(), by_distance.mesh()].map(|m| m.surface_triangles().len());
            assert_eq!(triangles[0], triangles[1]);
        }
    }
}

/// Returns the distance (m) at which a distance field has extent 1.
fn largest_distance(field: &PressureField) -> f64 {
    let deep = PressureField::from_distance_up_to(field.mesh(), 1e6).unwrap();
    deep.extents().iter().copied().fold(0.0, f64::max) * 1e6
}

#[test]
fn a_vertex_that_is_nearly_as_deep_ends_the_skin_and_leaves_no_sliver() {
    let (mesh, spacing) = (grid([6, 6, 6], 0.1, |_| true), 0.1);
    let expected = PressureField::from_distance_up_to(&mesh, spacing).unwrap();
    // No tetrahedron is cut, because the skin is the outer layer of cells.
    let split = mesh.with_inner_vertices().unwrap();
    assert_eq!(expected.mesh().tet_count(), split.tet_count());
    for off in [1e-16, 1e-12, 1e-6, 9e-4, -9e-4] {
        let field = PressureField::from_distance_up_to(&mesh, spacing * (1.0 + off)).unwrap();
        assert_eq!(field.mesh().tets(), expected.mesh().tets(), "{off:e}");
        for (actual, expected) in field.extents().iter().zip(expected.extents()) {
            assert!((actual - expected).abs() <= off.abs() + ROUND_OFF);
        }
    }
    let field = PressureField::from_distance_up_to(&mesh, spacing * 1.01).unwrap();
    assert!(field.mesh().tet_count() > split.tet_count());
}

#[test]
fn thick_and_thin_bodies_of_one_skin_have_one_gradient() {
    let steepest = [0.02, 0.1, 3.0].map(|thickness| {
        let plate = shapes::distance_cuboid([1.0, 1.0, thickness]).unwrap();
        let field = PressureField::from_distance_up_to(plate.mesh(), 0.005).unwrap();
        field.steepest()
    });
    for slope in steepest {
        assert_relative(slope, 200.0, INTERPOLATED);
    }
}

#[test]
fn the_plateau_has_no_gradient_beyond_round_off() {
    let mesh = transformed(&grid([5, 5, 5], 0.2, |_| true), |v| v.add_scalar(3.0));
    let field = PressureField::from_distance_up_to(&mesh, 0.07).unwrap();
    let is_flat = |tet: &&FieldTet| tet.extents.iter().all(|&extent| extent >= 1.0);
    let plateau: Vec<_> = field.tets().iter().filter(is_flat).collect();
    assert!(plateau.len() > 100);
    for tet in plateau {
        assert!(tet.steepness <= ROUND_OFF * tet.sensitivity);
    }
}

#[test]
fn depths_that_make_no_skin_are_refused() {
    let of = |mesh: &TetMesh, depth| PressureField::from_distance_up_to(mesh, depth).map(|_| ());
    for value in [0.0, -0.01, f64::INFINITY] {
        let name = "skin depth";
        let expected = MeshError::InvalidDimension { name, value };
        assert_eq!(of(&unit_tet(), value), Err(expected));
    }
    let error = of(&unit_tet(), f64::NAN).unwrap_err();
    assert!(error.to_string().contains("skin depth"), "{error}");
    for depth in [1e-13, 1e-100, 5e-324] {
        let error = of(&unit_tet(), depth).unwrap_err();
        assert!(matches!(error, MeshError::ZeroVolume { .. }), "{error}");
    }
}
