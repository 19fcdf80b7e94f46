//! Wrenches against closed forms.
#![allow(
    clippy::redundant_closure_for_method_calls,
    reason = "a method's path is not general enough in its lifetimes"
)]

use crate::support::scenes::pair;
use crate::support::worlds::{cuboid, icosphere};
use hydroelastic::contact::{ContactPair, Culling, Search, Shape};
use hydroelastic::mesh::{PressureField, TetMesh};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::f64::consts::PI;

/// Rounding error of a sum over some hundred polygons.
const EXACT: f64 = 1e-12;

/// Printed digits of the table's rest depth, which comes from a root finder.
const REST_DEPTH: f64 = 1e-9;

/// The nine printed digits of the table's frequency.
const FREQUENCY: f64 = 2e-9;

/// The printed digits of the table of relative errors.
const PRINTED: f64 = 6e-4;

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(vector![x, y, z])
}

fn icospheres_of_the_paper(shape: &Shape) -> ContactPair<'_> {
    pair(
        (shape, at(0.031, -0.5, 0.052), 1.0),
        (shape, at(0.0, 0.5, 0.0), 1.0),
    )
}

#[test]
fn icosphere_pairs_have_the_force_of_three_independent_codes() {
    let expected = [
        (
            1,
            vector![
                0.013_362_484_175_243,
                -0.441_277_152_337_403,
                0.023_269_900_431_408
            ],
        ),
        (
            2,
            vector![
                0.015_412_652_420_915,
                -0.500_327_868_058_84,
                0.026_029_548_602_807
            ],
        ),
    ];
    for (subdivisions, force) in expected {
        let shape = icosphere(1.0, subdivisions);
        let found = icospheres_of_the_paper(&shape).wrench().on_a.force;
        assert!((found - force).amax() <= EXACT, "{found:?}");
    }
}

#[test]
fn work_counts_of_the_papers_scene_stay_as_they_are() {
    let shape = icosphere(1.0, 2);
    let pair = icospheres_of_the_paper(&shape);
    let followed = pair.work_count();
    let culled = pair
        .with_search(Search::Culling(Culling::default()))
        .work_count();
    assert_eq!([followed.polygons, culled.polygons], [427; 2]);
    assert_eq!(followed.candidate_pairs, 597);
    assert_eq!(culled.candidate_pairs, 4_566);
}

/// The pair of tetrahedra is that of the unit tests of the paper's code. In a mesh with one tetrahedron, a corner on the surface would have
/// pressure. Therefore each of the two is one of four tetrahedra around its apex.
#[test]
fn the_papers_pair_of_tetrahedra_meets_in_its_triangle() {
    let body = |upward: f64, base: f64| {
        let vertices = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [-0.5, -0.5, 3.0],
        ];
        let vertices = vertices.map(|[x, y, z]| vector![x, y, base + upward * z]);
        let tets = vec![[0, 1, 2, 3], [4, 1, 2, 3], [0, 4, 2, 3], [0, 1, 4, 3]];
        let mesh = TetMesh::new(vertices.into(), tets).unwrap();
        Shape::new(PressureField::new(mesh, vec![0.0, 0.0, 0.0, 1.0, 0.0]).unwrap())
    };
    let (below, above) = (body(1.0, 0.0), body(-1.0, 1.8));
    let pair = pair(
        (&below, Pose::identity(), 1.0),
        (&above, Pose::identity(), 1.0),
    );
    let surface = pair.surface();
    let found = surface.polygons.iter().find(|p| p.tets == [0, 0]).unwrap();
    let corners = found.outline.corners();
    let expected = [[0.0, 0.0, 0.9], [0.1, 0.0, 0.9], [0.0, 0.1, 0.9]].map(Vector3::from);
    for corner in expected {
        let is_near = |c: &&Vector3<f64>| (*c - corner).amax() <= EXACT;
        assert_eq!(corners.iter().filter(is_near).count(), 1);
    }
    assert_eq!(corners.len(), 3);
    assert!((found.force().norm() - 0.0045).abs() <= EXACT);
}

/// A cube of 0.2 m and 1 MPa pressed 1 cm into a box of 3 MPa: κ is the pressure gradient.
mod cube_on_box {
    use super::*;
    use approx::assert_relative_eq;

    const EDGE: f64 = 0.2;
    const MODULI: [f64; 2] = [1e6, 3e6];

    fn shapes_and<R>(depth: f64, read: impl Fn(&ContactPair) -> R) -> R {
        let cube = cuboid([EDGE; 3]);
        let ground = cuboid([2.0, 2.0, 1.0]);
        let above = at(0.013, -0.007, 0.5 + EDGE / 2.0 - depth);
        read(&pair(
            (&cube, above, MODULI[0]),
            (&ground, Pose::identity(), MODULI[1]),
        ))
    }

    #[test]
    fn force_and_derivatives_are_the_closed_ones() {
        let contact = shapes_and(0.01, |pair| pair.linearized());
        let (wrench, by_moduli) = (contact.wrench, contact.by_moduli.row(5));
        let found = [
            wrench.on_a.force.z,
            -contact.by_poses[(5, 5)],
            by_moduli[0] * MODULI[0],
            by_moduli[1] * MODULI[1],
        ];
        let expected = [
            1_444.453_125,
            138_960.937_5,
            575.947_265_625,
            868.505_859_375,
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            assert_relative_eq!(found, expected, max_relative = EXACT);
        }
        let lateral = wrench.on_a.force.xy().amax();
        assert!(lateral <= EXACT * wrench.on_a.force.z, "{lateral:e}");
    }

    #[test]
    fn rest_depth_under_gravity_is_found_by_newtons_method_on_the_wrench() {
        let (mut depth, weight) = (1e-4, 9.81);
        for _ in 0..8 {
            let contact = shapes_and(depth, |pair| pair.linearized());
            depth += (weight - contact.wrench.on_a.force.z) / -contact.by_poses[(5, 5)];
        }
        assert!(
            (depth - 6.541_604_590_930e-5).abs() <= REST_DEPTH * depth,
            "{depth:e}"
        );
        let stiffness = shapes_and(depth, |pair| -pair.linearized().by_poses[(5, 5)]);
        assert!((stiffness.sqrt() / 387.203_326 - 1.0).abs() <= FREQUENCY);
    }
}

#[test]
fn cubes_offset_along_an_axis_have_the_force_of_the_papers_figure_3() {
    for (edge, modulus) in [(1.0, 0.5), (0.2, 1e6)] {
        let cube = cuboid([edge; 3]);
        for axis in 0..3 {
            for step in (-40..=40).filter(|&step| step != 0) {
                let s = f64::from(step) / 40.0;
                let offset = Vector3::ith(axis, s * edge);
                let moved = (&cube, Pose::from_translation(offset), modulus);
                let pair = pair(moved, (&cube, Pose::identity(), modulus));
                let force = pair.wrench().on_a.force;
                let magnitude = modulus * edge * edge * (1.0 - s.abs().powi(3)) / 3.0;
                let expected = Vector3::ith(axis, magnitude * s.signum());
                assert!(
                    (force - expected).amax() <= EXACT * modulus * edge * edge,
                    "{s} {force:?}"
                );
            }
        }
    }
}

#[test]
fn coincident_cubes_have_no_force() {
    let cube = cuboid([1.0; 3]);
    let there = (&cube, Pose::identity(), 0.5);
    let pair = pair(there, there);
    assert_eq!(pair.wrench().on_a.force, Vector3::zeros());
    // The energy is the integral of the field, which is a pyramid over each face.
    assert!((pair.potential_energy() - 0.5 / 4.0).abs() <= EXACT);
}

#[test]
fn mirrored_icospheres_approach_the_force_of_spheres_at_second_order() {
    let overlap: f64 = 0.2;
    // The mirror plane between the spheres presses each sphere in by half the overlap.
    let depth = overlap / 2.0;
    let smooth = PI * depth * depth * (1.0 - 2.0 * depth / 3.0);
    assert!((smooth / 0.029_321_531_43 - 1.0).abs() < 1e-9);
    let errors = [-0.694, -0.214, -0.0561, -0.0144, -0.0036];
    for (subdivisions, expected) in (1..).zip(errors) {
        let sphere = icosphere(1.0, subdivisions);
        let force = pair(
            (&sphere, Pose::identity(), 1.0),
            (&sphere, at(0.0, 0.0, 2.0 - overlap), 1.0),
        )
        .wrench()
        .on_a
        .force
        .norm();
        let error = force / smooth - 1.0;
        assert!(
            (error - expected).abs() < PRINTED,
            "{subdivisions}: {error}"
        );
    }
}
