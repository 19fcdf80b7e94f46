//! Distance fields against the distance to the surface in closed form.

use super::sample_meshes::{
    ROUND_OFF, assert_relative, grid, l_shape, meshes, transformed, unit_tet,
};
use hydroelastic::mesh::{FieldTet, MeshError, PressureField, TetMesh, shapes};
use nalgebra::{Vector3, vector};

#[test]
fn fields_work_at_extreme_scales() {
    for scale in [1e-100, 1e-6, 1e6, 1e100] {
        let mesh = transformed(&l_shape(1), |vertex| vertex * scale);
        let field = PressureField::from_distance(&mesh).unwrap();
        let expected = PressureField::from_distance(&l_shape(1)).unwrap();
        assert_eq!(field.mesh().tets(), expected.mesh().tets());
        for (actual, expected) in field.extents().iter().zip(expected.extents()) {
            assert!(
                (actual - expected).abs() <= ROUND_OFF,
                "{actual} is not {expected} at {scale:e}"
            );
        }
        assert_relative(field.steepest() * scale, expected.steepest(), ROUND_OFF);
        assert_relative(field.reach() / scale, expected.reach(), ROUND_OFF);
        assert_relative(field.mesh().volume(), 6.0 * scale.powi(3), ROUND_OFF);
    }
}

#[test]
fn grids_have_the_distance_to_the_box_as_extent() {
    let (counts, spacing) = ([4, 6, 8], 0.25);
    let field = PressureField::from_distance(&grid(counts, spacing, |_| true)).unwrap();
    let upper = Vector3::from(counts.map(|count| count as f64 * spacing));
    for (position, extent) in field.mesh().vertices().iter().zip(field.extents()) {
        // The largest distance is half the shortest edge, 1/2.
        let distance = position.min().min((upper - position).min());
        assert!((extent - 2.0 * distance).abs() <= ROUND_OFF, "{position}");
    }
}

#[test]
fn stretched_grids_have_the_distance_to_the_box_as_extent() {
    // For long, thin triangles, the nearest triangle need not have the nearest center.
    for stretch in [
        vector![1.0, 9.0, 1.0],
        vector![1.0, 0.2, 13.0],
        vector![7.0, 5.0, 1.0],
    ] {
        let upper = stretch * 5.0;
        let straight = transformed(&grid([5, 5, 5], 1.0, |_| true), |v| {
            v.component_mul(&stretch)
        });
        // The inside is bent, so the vertices have arbitrary positions above the triangles.
        let mesh = transformed(&straight, |v| {
            let bubble = v
                .component_mul(&(upper - v))
                .component_div(&upper.component_mul(&upper));
            v + bubble.product() * 20.0 * vector![v.y, v.x, -v.z].sup(&-stretch).inf(&stretch)
        });
        let field = PressureField::from_distance(&mesh).unwrap();
        let vertices = field.mesh().vertices();
        let distances = vertices.iter().map(|v| v.min().min((upper - v).min()));
        let distances: Vec<f64> = distances.collect();
        let largest = distances.iter().copied().fold(0.0, f64::max);
        for (extent, distance) in field.extents().iter().zip(distances) {
            assert!(
                (extent - distance / largest).abs() <= ROUND_OFF,
                "{stretch:?}"
            );
        }
    }
}

#[test]
fn notched_cube_has_the_distance_to_its_inward_corner_as_extent() {
    // A cube of edge 2 without one octant: the nearest point can be on a wall, an edge or a corner.
    let keeps = |cell: [usize; 3]| cell.iter().any(|&step| step < 3);
    let field = PressureField::from_distance(&grid([6, 6, 6], 1.0 / 3.0, keeps)).unwrap();
    let distance = |p: &Vector3<f64>| {
        let notch = p.map(|x| (1.0 - x).max(0.0)).norm();
        notch.min(p.min()).min(p.map(|x| 2.0 - x).min())
    };
    let distances: Vec<f64> = field.mesh().vertices().iter().map(distance).collect();
    let largest = distances.iter().copied().fold(0.0, f64::max);
    for (extent, distance) in field.extents().iter().zip(distances) {
        assert!((extent * largest - distance).abs() <= ROUND_OFF);
    }
}

/// Returns the distance (m) from a point in the L-shape to its surface.
fn distance_in_l_shape(p: &Vector3<f64>) -> f64 {
    let far = [p.x, p.y, 2.0 - p.x, 2.0 - p.y, p.z, 2.0 - p.z];
    // The concave edge is at x = y = 1, and two walls end there.
    let (x, y) = ((1.0 - p.x).max(0.0), (1.0 - p.y).max(0.0));
    far.iter().copied().fold(x.hypot(y), f64::min)
}

#[test]
fn l_shape_has_the_distance_to_its_inward_edge_as_extent() {
    let field = PressureField::from_distance(&l_shape(4)).unwrap();
    let vertices = field.mesh().vertices();
    let distances: Vec<f64> = vertices.iter().map(distance_in_l_shape).collect();
    let largest = distances.iter().copied().fold(0.0, f64::max);
    for ((position, extent), distance) in vertices.iter().zip(field.extents()).zip(&distances) {
        assert!(
            (extent * largest - distance).abs() <= ROUND_OFF,
            "{position}"
        );
    }
    // Near (1/2, 1/2), both walls and the concave edge matter.
    let extent_at = |p: Vector3<f64>| {
        let vertex = vertices
            .iter()
            .position(|v| (v - p).norm() < ROUND_OFF)
            .unwrap();
        field.extents()[vertex] * largest
    };
    assert_relative(
        extent_at(vector![0.75, 0.75, 1.0]),
        0.125_f64.sqrt(),
        ROUND_OFF,
    );
    assert_relative(extent_at(vector![0.5, 0.5, 1.0]), 0.5, ROUND_OFF);
    assert_relative(extent_at(vector![1.5, 0.75, 1.0]), 0.25, ROUND_OFF);
}

#[test]
fn distance_fields_reach_one_and_leave_no_tetrahedron_inert() {
    for (name, mesh) in meshes() {
        let field = PressureField::from_distance(&mesh).unwrap();
        let largest = field.extents().iter().copied().fold(0.0, f64::max);
        assert_relative(largest, 1.0, f64::EPSILON);
        assert!(!field.tets().iter().any(FieldTet::is_inert), "{name}");
    }
}

#[test]
fn a_single_tetrahedron_has_extent_one_at_its_centroid() {
    let field = PressureField::from_distance(&unit_tet()).unwrap();
    assert_eq!(field.extents(), [0.0, 0.0, 0.0, 0.0, 1.0]);
    // The distance of the oblique face is (1 − 3/4)/√3, and that of the other faces is 1/4.
    assert_relative(field.steepest(), 48.0_f64.sqrt(), ROUND_OFF);
}

/// Returns the largest difference between interpolated and exact distances at points of a block, over its largest distance.
fn error_in_block(field: &PressureField, lengths: [f64; 3]) -> f64 {
    let half = lengths.map(|length| length / 2.0);
    let largest = half.into_iter().fold(f64::INFINITY, f64::min);
    let errors = field.tets().iter().flat_map(|tet| {
        let [a, b, c, d] = tet.tetrahedron.corners;
        let places = [(0.4, 0.3, 0.2), (0.1, 0.2, 0.3), (0.25, 0.25, 0.25)];
        places.map(|(p, q, r)| {
            let point = a * p + b * q + c * r + d * (1.0 - p - q - r);
            let exact = (0..3)
                .map(|k| half[k] - point[k].abs())
                .fold(f64::INFINITY, f64::min);
            (tet.extent.at(&point) - exact / largest).abs()
        })
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn refined_fields_are_the_distance() {
    let lengths = [0.4, 0.1, 0.1];
    // Tetrahedra whose corners are unlike the ridges of the distance.
    let stretched = |share: f64| {
        let grid = shapes::cuboid(lengths).unwrap();
        let vertices = grid.mesh().vertices().iter();
        let vertices = vertices.map(|vertex| {
            if vertex.norm() < 0.05 {
                vertex + vector![share, 0.004, -0.003]
            } else {
                *vertex
            }
        });
        TetMesh::new(vertices.collect(), grid.mesh().tets().to_vec()).unwrap()
    };
    let mesh = stretched(0.01);
    let coarse = PressureField::from_distance(&mesh).unwrap();
    let fine = PressureField::from_distance_within(&mesh, 0.002, Some(1.0)).unwrap();
    let [before, after] = [&coarse, &fine].map(|field| field.distance_error(Some(1.0)));
    assert!(before > 0.05 && after <= 0.002, "{before} {after}");
    let [before, after] = [&coarse, &fine].map(|field| error_in_block(field, lengths));
    assert!(before > 0.5 && after < 0.1, "{before} {after}");
    for (tolerance, depth) in [(0.0, None), (f64::NAN, None), (0.1, Some(-1.0))] {
        let refused = PressureField::from_distance_within(&mesh, tolerance, depth).unwrap_err();
        assert!(
            matches!(refused, MeshError::InvalidDimension { .. }),
            "{refused}"
        );
    }
}
