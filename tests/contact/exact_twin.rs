//! The wrench against its exact twin, at generic poses and at every kind of degenerate pose.
//!
//! `cargo test --release --test contact exact_twin:: -- --ignored --nocapture` compares many more pairs and prints the results.

use crate::support::aligned::{aligned_pose, bodies, polygons_in_faces};
use crate::support::exact;
use crate::support::exact_claims::{Standing, compared};
use crate::support::hostile::{Family, Hostile};
use crate::support::scenes::{Random, pair};
use crate::support::subdivisions::{Division, divided};
use crate::support::sweep::{Tally, in_batches, merge, range_from_environment, report};
use crate::support::worlds::cuboid;
use hydroelastic::contact::{ContactPair, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::ops::Range;

/// Number of pairs that share a set of shapes.
const BATCH: usize = 4096;

/// Number of pairs in the short form: 70 of each family.
const SHORT: usize = 770;

/// Number of pairs in the long form, unless EXACT_PAIRS is set: 1,000 of each family.
const LONG: usize = 11_000;

/// Number of pairs that a thread processes at a time.
const SHARE: usize = 70;

/// Relative rounding error of the twin's result and of a closed form.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

type Tallies = [Tally; Family::ALL.len()];

/// Adds the pair with a number. The wrench of a pair with equal or blurred fields must only be within the largest jump.
fn add(tally: &mut Tally, number: usize, pair: &ContactPair) {
    let found = compared(pair);
    let agrees = found.ratio <= 1.0;
    let excess = match found.standing {
        Standing::Determined => found.ratio.max(found.jump),
        Standing::EqualFields | Standing::Blurred => found.jump,
    };
    tally.count("touching", usize::from(found.polygons > 0));
    tally.count("polygons", found.polygons);
    if found.standing == Standing::Determined {
        tally.note(found.ratio);
    }
    tally.count("agreeing", usize::from(agrees));
    tally.count(format!("{:?}", found.standing), 1);
    // NaN must fail.
    let fails = excess.is_nan() || found.ratio.is_nan() || excess > 1.0;
    tally.add(
        number,
        fails.then(|| ("times the tolerance".to_owned(), excess)),
    );
}

/// Compares the pairs with these numbers.
fn tried(numbers: Range<usize>) -> Tallies {
    let (mut batch, mut tallies) = (None, Tallies::default());
    for number in numbers {
        let own = number / BATCH;
        let (_, hostile) = batch
            .take_if(|(number, _)| *number == own)
            .unwrap_or_else(|| (own, Hostile::new(own as u64)));
        let family = number % Family::ALL.len();
        let pair = hostile.pair(Family::ALL[family], number as u64);
        add(&mut tallies[family], number, &pair);
        batch = Some((own, hostile));
    }
    tallies
}

/// Compares `count` consecutive pairs, beginning with pair `first`, on all threads.
fn soaked(first: usize, count: usize) -> Tallies {
    let work = |total: &mut Tallies, _, numbers| merge(total, tried(numbers));
    in_batches((first, count), SHARE, work, merge)
}

#[test]
fn hostile_pairs_have_the_exact_wrench() {
    let tallies = soaked(0, SHORT);
    report(&Family::ALL, &tallies);
    for tally in &tallies {
        tally.assert_often("touching", 4);
        tally.assert_often("Determined", 3);
    }
}

/// If polygons lie in shared faces of tetrahedra, the kernel's half weights and the twin's mean of both sides agree.
#[test]
fn aligned_pairs_have_the_exact_wrench() {
    let (fields, mut in_faces) = (bodies(), 0);
    for number in 0..100 {
        let random = &mut Random::numbered(number);
        let shapes = [0, 1].map(|_| {
            let field = &fields[random.below(fields.len())];
            let division = [Division::Whole, Division::Halves][random.below(2)];
            Shape::new(divided(field, division, random))
        });
        let modulus = [1.0, 2.0][random.below(2)];
        let b = (&shapes[1], aligned_pose(random), modulus);
        let pair = pair((&shapes[0], Pose::identity(), 1.0), b);
        let found = compared(&pair);
        if found.standing != Standing::Blurred {
            assert!(found.ratio <= 1.0, "pair {number}: {:e}", found.ratio);
            in_faces += polygons_in_faces(&pair).len();
        }
        assert!(found.jump <= 1.0, "pair {number}: {:e}", found.jump);
    }
    assert!(in_faces >= 100, "{in_faces}");
}

/// EXACT_PAIRS is the number of pairs, and EXACT_FIRST is the number of the first pair. With these, a single failing pair can be examined.
#[test]
#[ignore = "minutes: eleven thousand pairs"]
fn many_hostile_pairs_have_the_exact_wrench() {
    let (first, count) = range_from_environment("EXACT", (SHORT, LONG));
    report(&Family::ALL, &soaked(first, count));
}

fn exact_force(a: &Shape, b: &Shape, at: Vector3<f64>, moduli: [f64; 2]) -> Vector3<f64> {
    let pose = Pose::from_translation(at);
    let pair = pair((a, Pose::identity(), moduli[0]), (b, pose, moduli[1]));
    exact::contact(&pair).wrench.fixed_rows::<3>(3).into_owned()
}

/// The bodies are two unit cubes of twelve tetrahedra with pressure E/2 at the centers, one of them displaced by s along an axis. The axial
/// force is E·(1 − s³)/3, and by symmetry there is no other force. Figure 3 of the paper has E = 1/2.
#[test]
fn twin_has_the_closed_form_of_the_papers_cubes() {
    let cube = cuboid([1.0; 3]);
    for s in [0.125, 0.25, 0.5, 0.75, 0.875, 0.984_375] {
        let force = exact_force(&cube, &cube, vector![s, 0.0, 0.0], [1.0; 2]);
        let expected = vector![-(1.0 - s * s * s) / 3.0, 0.0, 0.0];
        assert!(
            (force - expected).norm() <= ROUNDING * expected.norm(),
            "{force}"
        );
    }
}

/// The plane of equal pressure is at a quarter of the cubes' edge. If both cubes are divided in halves, they have faces in that plane. Each
/// polygon then lies in a face that two tetrahedra of each cube share.
#[test]
fn twin_counts_what_lies_in_shared_faces_once() {
    let whole = shapes::cuboid([1.0; 3]).unwrap();
    let halves = divided(&whole, Division::Halves, &mut Random::new(71));
    let shapes = [whole, halves].map(Shape::new);
    let at = vector![0.5, 0.0, 0.0];
    for moduli in [[1.0, 1.0], [1.0, 2.0], [3.0, 1.0]] {
        let force = |a: usize, b: usize| exact_force(&shapes[a], &shapes[b], at, moduli);
        let expected = force(0, 0);
        assert!(expected.x < -0.1);
        for (a, b) in [(0, 1), (1, 0), (1, 1)] {
            let error = (force(a, b) - expected).norm();
            assert!(error <= ROUNDING * expected.norm(), "{moduli:?}: {error:e}");
        }
    }
}
