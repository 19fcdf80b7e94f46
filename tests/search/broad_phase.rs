//! The broad phase omits no pair of tetrahedra that share a point.
//!
//! The reference tests all pairs with all 44 directions that can separate two tetrahedra.

use hydroelastic::broad_phase::{Projections, RStarTree};
use hydroelastic::geometry::{Aabb, Tetrahedron};
use hydroelastic::mesh::{PressureField, TetMesh, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Error of a transformed coordinate as a fraction of the bodies' reach. `contact::ContactPair` uses the same margin.
const MARGIN: f64 = 3e-14;

/// Gaps below this fraction of the bodies' reach count as contact, because coordinates of touching tetrahedra have rounding errors.
const TOUCH: f64 = 4e-16;

/// A direction shorter than this fraction of its edges is the cross product of parallel edges, which is round-off.
const PARALLEL: f64 = 1e-10;

/// Tetrahedra of both bodies in A's frame.
struct Scene {
    field_a: PressureField,
    field_b: PressureField,
    pose_ab: Pose,
    posed_b: Vec<Tetrahedron>,
    /// Sum of both bodies' reaches from their origins (m).
    reach: f64,
}

impl Scene {
    fn new(field_a: PressureField, field_b: PressureField, pose_ab: Pose) -> Self {
        let posed_b = field_b.tets().iter().map(|tet| Tetrahedron {
            corners: tet
                .tetrahedron
                .corners
                .map(|corner| pose_ab.transformed_point(&corner)),
        });
        Self {
            posed_b: posed_b.collect(),
            reach: field_a.reach() + field_b.reach(),
            field_a,
            field_b,
            pose_ab,
        }
    }

    fn margin(&self) -> f64 {
        MARGIN * self.reach
    }

    /// Returns the pairs (of A, of B) that the trees do not exclude, found as in `contact::ContactPair`. Panics if a pair is found twice.
    fn candidates(&self) -> BTreeSet<(usize, usize)> {
        let (tree_a, tree_b) = (RStarTree::new(&self.field_a), RStarTree::new(&self.field_b));
        let mut pairs = BTreeSet::new();
        tree_b.visit_near(
            &self.field_a.mesh().aabb(),
            &self.pose_ab,
            self.margin(),
            |b| {
                let query = self.posed_b[b].aabb().inflated(self.margin());
                tree_a.visit_overlapping(&query, |a| {
                    assert!(pairs.insert((a, b)), "{a}, {b} found twice");
                });
            },
        );
        pairs
    }

    /// Returns the pairs that share a point, by a search over all pairs.
    fn intersecting(&self) -> BTreeSet<(usize, usize)> {
        let tets_a = self.field_a.tets().iter().map(|tet| tet.tetrahedron);
        let mut pairs = BTreeSet::new();
        for (a, tet_a) in tets_a.enumerate() {
            for (b, tet_b) in self.posed_b.iter().enumerate() {
                if share_a_point(&tet_a, tet_b, TOUCH * self.reach) {
                    pairs.insert((a, b));
                }
            }
        }
        pairs
    }
}

fn edges(tetrahedron: &Tetrahedron) -> [Vector3<f64>; 6] {
    let c = &tetrahedron.corners;
    [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)].map(|(from, to)| c[to] - c[from])
}

/// Returns the face normals, each from two edges of the face.
fn normals(e: &[Vector3<f64>; 6]) -> [Vector3<f64>; 4] {
    [(0, 1), (0, 2), (1, 2), (3, 4)].map(|(i, j)| e[i].cross(&e[j]))
}

/// Returns the gap (m) between the tetrahedra along a direction. The gap is negative if their projections overlap.
fn gap(a: &Tetrahedron, b: &Tetrahedron, direction: &Vector3<f64>) -> f64 {
    let limits = |tetrahedron: &Tetrahedron| {
        // Coordinates relative to A's first corner avoid cancellation.
        let shadow = tetrahedron
            .corners
            .map(|corner| (corner - a.corners[0]).dot(direction));
        let low = shadow.iter().copied().fold(f64::INFINITY, f64::min);
        (
            low,
            shadow.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        )
    };
    let ((low_a, high_a), (low_b, high_b)) = (limits(a), limits(b));
    (low_a - high_b).max(low_b - high_a) / direction.norm()
}

/// Returns whether no face normal and no cross product of two edges has a gap wider than `touch` (m).
fn share_a_point(a: &Tetrahedron, b: &Tetrahedron, touch: f64) -> bool {
    let (edges_a, edges_b) = (edges(a), edges(b));
    let is_gap = |direction: &Vector3<f64>| gap(a, b, direction) > touch;
    if normals(&edges_a).iter().any(is_gap) || normals(&edges_b).iter().any(is_gap) {
        return false;
    }
    let mut crosses = edges_a
        .iter()
        .flat_map(|a| edges_b.iter().map(move |b| (a, b)));
    !crosses.any(|(a, b)| {
        let direction = a.cross(b);
        direction.norm() > PARALLEL * a.norm() * b.norm() && is_gap(&direction)
    })
}

/// Asserts that every intersecting pair is a candidate and is not separated.
fn assert_complete(scene: &Scene) -> Result<(), TestCaseError> {
    let (candidates, intersecting) = (scene.candidates(), scene.intersecting());
    let tets_a = scene.field_a.tets();
    let shadows: Vec<Projections> = scene.posed_b.iter().map(Projections::of).collect();
    for &(a, b) in &intersecting {
        prop_assert!(candidates.contains(&(a, b)), "{a}, {b} left out");
        let separated = Projections::of(&tets_a[a].tetrahedron).separate(
            &shadows[b],
            Projections::COUNT,
            scene.margin(),
        );
        prop_assert!(!separated, "{a}, {b} separated");
    }
    Ok(())
}

fn shape() -> impl Strategy<Value = PressureField> {
    let length = || 0.2..2.0;
    prop_oneof![
        (length(), 0_usize..3).prop_map(|(radius, k)| shapes::icosphere(radius, k)),
        [length(), length(), length()].prop_map(shapes::cuboid),
        [length(), length(), length()].prop_map(shapes::distance_cuboid),
        (length(), length(), 3_usize..12).prop_map(|(r, l, n)| shapes::cylinder(r, l, n)),
    ]
    .prop_map(Result::unwrap)
}

/// Generates any rotation, and distances at which shapes of up to 2 m often touch.
fn pose() -> impl Strategy<Value = Pose> {
    let turn = || -PI..PI;
    let shift = || -1.5..1.5;
    ([turn(), turn(), turn()], [shift(), shift(), shift()]).prop_map(|(rotation, translation)| {
        Pose::from_rotation_vector(&rotation.into(), translation.into())
    })
}

/// Generates quarter turns about one axis after another.
fn aligned_rotation() -> impl Strategy<Value = Pose> {
    prop::array::uniform3(0_u8..4).prop_map(|quarters| {
        let turn = |axis: usize| {
            let vector = Vector3::ith(axis, f64::from(quarters[axis]) * PI / 2.0);
            Pose::from_rotation_vector(&vector, Vector3::zeros())
        };
        turn(0) * turn(1) * turn(2)
    })
}

/// Returns the shift that places B beside A, such that their boxes touch exactly along some axes and overlap completely along others.
fn beside(a: &Aabb, b: &Aabb, sides: [i8; 3]) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| match sides[axis] {
        1 => a.upper[axis] - b.lower[axis],
        -1 => a.lower[axis] - b.upper[axis],
        _ => 0.0,
    })
}

/// Returns the field at another position in its body frame.
fn shifted(field: &PressureField, shift: Vector3<f64>) -> PressureField {
    let vertices = field.mesh().vertices().iter().map(|vertex| vertex + shift);
    let mesh = TetMesh::new(vertices.collect(), field.mesh().tets().to_vec()).unwrap();
    PressureField::new(mesh, field.extents().to_vec()).unwrap()
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::with_cases(cases)
    }
}

proptest! {
    #![proptest_config(config(512))]

    #[test]
    fn no_intersecting_pair_is_left_out(
        field_a in shape(), field_b in shape(), pose_ab in pose(),
    ) {
        assert_complete(&Scene::new(field_a, field_b, pose_ab))?;
    }

    #[test]
    fn no_touching_pair_of_aligned_bodies_is_left_out(
        field_a in shape(),
        field_b in shape(),
        turn in aligned_rotation(),
        sides in prop::array::uniform3(-1_i8..=1),
    ) {
        let turned = Scene::new(field_a.clone(), field_b.clone(), turn);
        let corners = turned.posed_b.iter().flat_map(|tet| &tet.corners);
        let shift = beside(&field_a.mesh().aabb(), &Aabb::around(corners), sides);
        assert_complete(&Scene::new(field_a, field_b, Pose::from_translation(shift) * turn))?;
    }

    #[test]
    fn no_pair_of_coinciding_bodies_is_left_out(
        field in shape(), sides in prop::array::uniform3(-1_i8..=1),
    ) {
        let aabb = field.mesh().aabb();
        let shift = beside(&aabb, &aabb, sides);
        let scene = Scene::new(field.clone(), field, Pose::from_translation(shift));
        assert_complete(&scene)?;
    }

    #[test]
    fn no_intersecting_pair_far_from_the_origins_of_the_bodies_is_left_out(
        field_a in shape(), field_b in shape(), pose in pose(), log in 1.0..4.0,
    ) {
        let (far_a, far_b) = (vector![-0.6, 0.8, 0.3], vector![0.5, 0.2, -0.9]);
        let distance = 10.0_f64.powf(log);
        let (far_a, far_b) = (far_a * distance, far_b * distance);
        let pose_ab = Pose::from_translation(far_a) * pose * Pose::from_translation(-far_b);
        assert_complete(&Scene::new(shifted(&field_a, far_a), shifted(&field_b, far_b), pose_ab))?;
    }
}

fn tetrahedron(corners: [[f64; 3]; 4]) -> Tetrahedron {
    Tetrahedron {
        corners: corners.map(Vector3::from),
    }
}

const UNIT: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];

fn unit_moved(shift: [f64; 3]) -> Tetrahedron {
    tetrahedron(UNIT.map(|corner| std::array::from_fn(|axis| corner[axis] + shift[axis])))
}

#[test]
fn the_oracle_knows_touching_tetrahedra() {
    let unit = tetrahedron(UNIT);
    // Equal positions, then contact at a corner, along an edge and face to face, then deep contact.
    for shift in [
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.5, 0.5, 0.0],
        [0.0, 0.0, -1.0],
        [0.1, 0.2, 0.1],
    ] {
        assert!(share_a_point(&unit, &unit_moved(shift), 0.0), "{shift:?}");
    }
    for shift in [
        [1.001, 0.0, 0.0],
        [0.5, 0.501, 0.0],
        [0.4, 0.4, 0.4],
        [0.0, 0.0, -1.001],
    ] {
        assert!(!share_a_point(&unit, &unit_moved(shift), 0.0), "{shift:?}");
    }
}

#[test]
fn the_oracle_knows_edges_that_cross() {
    // Wedges whose sharp edges cross at right angles with a gap of `gap`. Only the cross product of these two edges separates them.
    let lower = tetrahedron([
        [-1.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, -3.0, -1.0],
        [0.0, 3.0, -1.0],
    ]);
    for (gap, expected) in [(0.0, true), (1e-3, false), (-1e-3, true)] {
        let upper = tetrahedron([
            [0.0, -1.0, gap],
            [0.0, 1.0, gap],
            [-3.0, 0.0, 1.0 + gap],
            [3.0, 0.0, 1.0 + gap],
        ]);
        assert_eq!(share_a_point(&lower, &upper, 0.0), expected, "{gap}");
    }
}

#[test]
fn projections_separate_what_is_apart_by_more_than_the_margin() {
    let (unit, far) = (
        Projections::of(&tetrahedron(UNIT)),
        unit_moved([3.0, 0.0, 0.0]),
    );
    let far = Projections::of(&far);
    assert!(unit.separate(&far, Projections::COUNT, 0.0));
    assert!(far.separate(&unit, Projections::COUNT, 0.0));
    // The gap is 2 m along x, and smaller along every other direction.
    assert!(!unit.separate(&far, Projections::COUNT, 2.0));
    assert!(!unit.separate(&far, 0, 0.0));
    assert!(!unit.separate(&unit, Projections::COUNT, 0.0));
}

#[test]
fn bodies_apart_have_no_candidates() {
    let ball = || shapes::icosphere(1.0, 2).unwrap();
    for shift in [
        vector![2.1, 0.0, 0.0],
        vector![0.0, -2.1, 0.0],
        vector![1e6, 1e6, 1e6],
    ] {
        let scene = Scene::new(ball(), ball(), Pose::from_translation(shift));
        assert!(scene.candidates().is_empty());
    }
}

#[test]
fn work_counts_of_two_balls_stay_as_they_are() {
    let ball = || shapes::icosphere(1.0, 2).unwrap();
    let pose_ab = Pose::from_rotation_vector(&vector![0.3, 0.5, -0.2], vector![1.1, 0.9, 0.7]);
    let scene = Scene::new(ball(), ball(), pose_ab);
    // There are 102,400 pairs in total.
    let counts = (scene.candidates().len(), scene.intersecting().len());
    assert_eq!(counts, (1248, 316));
}
