//! Rigid surfaces that are not convex, have several components or cavities, or intersect themselves.

use super::rigid;
use crate::support::scenes::{Random, grid};
use crate::support::worlds::{cuboid, icosphere};
use hydroelastic::contact::{ContactBody, ContactPair, Partner, RigidShape, Shape};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Vector3, vector};

/// Rounding error of sums of some hundred polygons.
const SAME: f64 = 1e-11;

/// Smallest scale of forces and energies, as a fraction of modulus times volume.
const LEAST: f64 = 1e-3;

/// Combines the triangles of surfaces, each translated and optionally inside out.
fn together(parts: &[(&Shape, Vector3<f64>, bool)]) -> RigidShape {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (shape, place, is_inside_out) in parts {
        let surface = TriangleSurface::around(shape.field().mesh()).unwrap();
        let first = vertices.len();
        vertices.extend(surface.vertices().iter().map(|vertex| vertex + place));
        triangles.extend(surface.triangles().iter().map(|&[a, b, c]| {
            let corners = if *is_inside_out { [a, c, b] } else { [a, b, c] };
            corners.map(|vertex| vertex + first)
        }));
    }
    RigidShape::new(TriangleSurface::new(vertices, triangles).unwrap())
}

struct Scene {
    soft: Shape,
    pose: Pose,
}

impl Scene {
    fn pair<'a>(&'a self, surface: &'a RigidShape, place: Vector3<f64>) -> ContactPair<'a> {
        let a = ContactBody::new(&self.soft, self.pose, 1e5).unwrap();
        let pose = Pose::from_translation(place);
        ContactPair::new(a, Partner::rigid(surface, pose).unwrap())
    }

    fn on(&self, surface: &RigidShape, place: Vector3<f64>) -> (Wrench, f64) {
        let pair = self.pair(surface, place);
        (pair.wrench().on_a, pair.potential_energy())
    }
}

fn scenes(count: usize, seed: u8) -> impl Iterator<Item = Scene> {
    let mut random = Random::new(seed);
    (0..count).map(move |_| Scene {
        soft: icosphere(0.8, 1),
        pose: Pose::from_rotation_vector(&random.rotation_vector(), random.vector() * 0.9),
    })
}

/// Checks that wrench and energy are signed sums over parts.
fn assert_sum(scene: &Scene, whole: &RigidShape, parts: &[(&RigidShape, Vector3<f64>, f64)]) {
    let (found, energy) = scene.on(whole, Vector3::zeros());
    // If the body touches no part, only round-off remains.
    let least = LEAST * 1e5 * scene.soft.field().mesh().volume();
    let (mut expected, mut sum, mut size) = (Wrench::zero().to_vector(), 0.0, least);
    for (surface, place, sign) in parts {
        let (wrench, energy) = scene.on(surface, *place);
        expected += wrench.to_vector() * *sign;
        size += wrench.to_vector().amax();
        sum += energy * sign;
    }
    let error = (found.to_vector() - expected).amax();
    assert!(error <= SAME * size, "{error:e} of {size:e}");
    assert!((energy - sum).abs() <= SAME * size, "{energy} {sum}");
}

#[test]
fn components_and_cavities_add_up() {
    let [cube, ball] = [shapes::cuboid([0.7, 0.8, 0.9]), shapes::icosphere(0.3, 1)];
    let [cube, ball] = [cube, ball].map(|field| Shape::new(field.unwrap()));
    let (left, right) = (vector![-0.6, 0.0, 0.0], vector![0.5, 0.1, 0.2]);
    let two = together(&[(&cube, left, false), (&ball, right, false)]);
    let hollow = together(&[(&cube, left, false), (&ball, left, true)]);
    assert_eq!(two.surface().component_count(), 2);
    let [cube, ball] = [rigid(&cube), rigid(&ball)];
    for scene in scenes(40, 71) {
        assert_sum(&scene, &two, &[(&cube, left, 1.0), (&ball, right, 1.0)]);
        assert_sum(&scene, &hollow, &[(&cube, left, 1.0), (&ball, left, -1.0)]);
    }
}

/// The surface of an L-shaped solid against the surfaces of its three boxes. The shared sides of the boxes cancel.
#[test]
fn a_solid_that_is_not_convex_is_the_sum_of_its_boxes() {
    let all = |_: [usize; 3]| true;
    let l = grid(&[2, 2, 1], 0.6, |[i, j, _]| i == 0 || j == 0).unwrap();
    let l = rigid(&Shape::new(l));
    let cube = rigid(&Shape::new(grid(&[1, 1, 1], 0.6, all).unwrap()));
    let boxes = [[-0.3, -0.3], [0.3, -0.3], [-0.3, 0.3]];
    let parts = boxes.map(|[x, y]| (&cube, vector![x, y, 0.0], 1.0));
    for scene in scenes(40, 72) {
        assert_sum(&scene, &l, &parts);
    }
}

/// If a surface intersects itself, each layer has its own pressure, so a point inside twice is pushed out twice.
#[test]
fn parts_that_overlap_press_each_by_itself() {
    let cube = cuboid([0.8; 3]);
    let (left, right) = (vector![-0.3, 0.0, 0.0], vector![0.2, 0.13, 0.07]);
    let both = together(&[(&cube, left, false), (&cube, right, false)]);
    let cube = rigid(&cube);
    for scene in scenes(40, 73) {
        assert_sum(&scene, &both, &[(&cube, left, 1.0), (&cube, right, 1.0)]);
    }
}

/// Bodies that do not touch are not submerged in each other, wherever the origin of the surface's frame is.
#[test]
fn bodies_beside_each_other_have_not_sunk_through() {
    let small = icosphere(0.1, 1);
    let l = grid(&[3, 3, 1], 0.5, |[i, j, _]| i == 0 || j == 0).unwrap();
    let cube = cuboid([1.0; 3]);
    let away = together(&[(&cube, vector![3.0, 0.2, 0.1], false)]);
    let l = rigid(&Shape::new(l));
    let mut random = Random::new(74);
    for _ in 0..200 {
        // Positions in the notch of the L, and between a cube and the far origin of its frame.
        let notch = vector![0.25, 0.25, 0.0] + random.vector() * 0.3;
        let between = vector![2.0, 0.13, 0.07] + random.vector() * 0.3;
        for (surface, place) in [(&l, notch), (&away, between)] {
            let pose = Pose::from_rotation_vector(&random.rotation_vector(), place);
            let a = ContactBody::new(&small, pose, 1e5).unwrap();
            let pair = ContactPair::new(a, Partner::rigid(surface, Pose::identity()).unwrap());
            assert!(pair.surface().is_empty());
            assert!(!pair.has_sunk_through(), "{}", pair.potential_energy());
        }
    }
}

/// A body inside another is submerged with all of its energy, wherever the origin is.
#[test]
fn bodies_inside_have_sunk_through_with_all_of_their_energy() {
    let small = icosphere(0.1, 1);
    let cube = cuboid([1.0; 3]);
    let most = 1e5 * small.field().mesh().volume() / 4.0;
    for distance in [0.0, 0.5, 3.0, 1e3, 1e6] {
        let place = vector![distance, 0.2 * distance, 0.1 * distance];
        let cube = together(&[(&cube, place, false)]);
        let inside = place + vector![0.2, 0.13, -0.1];
        let a = ContactBody::new(&small, Pose::from_translation(inside), 1e5).unwrap();
        let pair = ContactPair::new(a, Partner::rigid(&cube, Pose::identity()).unwrap());
        assert!(pair.has_sunk_through());
        let error = (pair.potential_energy() / most - 1.0).abs();
        assert!(error < 1e-12 + 1e-14 * distance, "{distance}: {error:e}");
    }
}
