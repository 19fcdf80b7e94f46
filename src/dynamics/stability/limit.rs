use super::pair::PairRates;
use nalgebra::{DVector, SMatrix, Vector6};

/// The power iteration has converged when the direction changes by less than this fraction of its
/// length. The fraction is far below the error of the linearization.
const SETTLED: f64 = 1e-6;

/// Maximum number of iterations. Modes that are still mixed after these iterations have nearly the
/// same limits.
const MOST_ITERATIONS: usize = 1_000;

/// Fractional part of the golden ratio. The fractional parts of its multiples show no pattern to which a mode could be orthogonal.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Largest stable step (s) of bodies under these contacts, or `None` if the contacts resist no
/// motion.
///
/// The step h is stable if x·(h²K + 2hC)x ≤ 4 for all unit motions x (see
/// [`World::largest_stable_step`](crate::dynamics::World::largest_stable_step)). The limit is
/// therefore the smallest step at which some x reaches 4. Power iteration with h²(K + s) + 2hC,
/// where h is the step of the current x, turns x toward that motion. Power iteration with K alone
/// would turn x toward the eigenvalue of the largest magnitude, which may be negative. Eigenvalues
/// of K are negative if a contact pushes a displaced body further away. Deep contacts and contacts
/// on an edge do this. The shift s makes all eigenvalues of K + s at least zero.
///
/// Some eigenvalue is within the residual of 4. The step is reduced by the same amount, so that a search that ends early errs toward a
/// shorter step.
pub(super) fn stability_limit(pairs: &[PairRates], body_count: usize) -> Option<f64> {
    let shift = shift(pairs, body_count);
    let mut motion = generic_motion(6 * body_count);
    let mut limit = None;
    for _ in 0..MOST_ITERATIONS {
        let [elastic, viscous] = forces_against(pairs, &motion);
        let Some(step) = step_of_mode(motion.dot(&elastic), motion.dot(&viscous)) else {
            // The contacts do not resist this motion. Turn toward a motion that they resist, if there is one.
            motion = (elastic + &motion * shift).try_normalize(0.0)?;
            continue;
        };
        // h²K x + 2hC x is 4x at the limit.
        let image = (elastic * step + viscous * 2.0) * (step / 4.0);
        let residual = (&image - &motion).norm();
        limit = Some(step / (1.0 + residual));
        if residual <= SETTLED {
            break;
        }
        motion = (image + &motion * (shift * step * step / 4.0)).normalize();
    }
    limit
}

/// Number s for which K + s has no negative eigenvalue: the largest sum, over the pairs of one body, of the magnitudes of their lowest
/// negative eigenvalues.
fn shift(pairs: &[PairRates], body_count: usize) -> f64 {
    let mut shifts = vec![0.0; body_count];
    for pair in pairs {
        let lowest = pair.stiffness.symmetric_eigenvalues().min();
        for body in pair.bodies {
            shifts[body] += (-lowest).max(0.0);
        }
    }
    shifts.into_iter().fold(0.0, f64::max)
}

/// Pair whose bodies alone have the smallest limit.
pub(super) fn stiffest(pairs: &[PairRates]) -> Option<&PairRates> {
    let alone = |pair: &PairRates| {
        let bodies = [0, 1];
        let pair = PairRates {
            bodies,
            ..pair.clone()
        };
        stability_limit(&[pair], bodies.len()).unwrap_or(f64::INFINITY)
    };
    let limits = pairs.iter().map(|pair| (pair, alone(pair)));
    let shortest = limits.min_by(|(_, a), (_, b)| a.total_cmp(b));
    shortest.map(|(pair, _)| pair)
}

/// Step (s) with h²k + 2hc = 4, or `None` if the rates are zero.
fn step_of_mode(stiffness: f64, damping: f64) -> Option<f64> {
    let (stiffness, damping) = (stiffness.max(0.0), damping.max(0.0));
    let step = 4.0 / (damping + (damping * damping + 4.0 * stiffness).sqrt());
    step.is_finite().then_some(step)
}

/// Unit motion with a component of every mode.
fn generic_motion(dimension: usize) -> DVector<f64> {
    let number = |index: usize, _| (GOLDEN * (index + 1) as f64).fract() - 0.5;
    DVector::from_fn(dimension, number).normalize()
}

/// Products K x and C x.
fn forces_against(pairs: &[PairRates], motion: &DVector<f64>) -> [DVector<f64>; 2] {
    let mut forces = [0, 1].map(|_| DVector::zeros(motion.len()));
    for pair in pairs {
        let of_pair = SMatrix::<f64, 12, 1>::from_fn(|row, _| motion[row_of(pair, row)]);
        for (sum, rates) in forces.iter_mut().zip([&pair.stiffness, &pair.damping]) {
            let force = rates * of_pair;
            for (half, &body) in pair.bodies.iter().enumerate() {
                let on_body: Vector6<f64> = force.fixed_rows::<6>(6 * half).into_owned();
                let mut total = sum.fixed_rows_mut::<6>(6 * body);
                total += on_body;
            }
        }
    }
    forces
}

/// Row of the motion of all bodies for a row of the motion of a pair.
fn row_of(pair: &PairRates, row: usize) -> usize {
    6 * pair.bodies[row / 6] + row % 6
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Shape;
    use crate::dynamics::{Body, Mass, Material, World};
    use crate::mesh::shapes;
    use crate::spatial::Pose;
    use nalgebra::{DMatrix, vector};
    use std::sync::Arc;

    /// Bed of balls of different sizes, each in contact with about six others.
    fn bed(edge: usize) -> World {
        let skin = Material::elastic(1e5)
            .with_dissipation(0.5)
            .with_friction(0.4);
        let ball = |index: usize| {
            let size = 0.055 + 0.01 * (GOLDEN * (index + 1) as f64).fract();
            let shape = Arc::new(Shape::new(shapes::icosphere(size, 1).unwrap()));
            let position = [index % edge, index / edge % edge, index / edge / edge];
            let position = position.map(|count| 0.11 * count as f64);
            let turn = vector![0.1, 0.2, 0.3] * index as f64;
            Body::dynamic(&index.to_string(), shape, skin, Mass::Density(1000.0))
                .unwrap()
                .with_pose(Pose::from_rotation_vector(&turn, position.into()))
        };
        World::new((0..edge.pow(3)).map(ball).collect()).unwrap()
    }

    fn dense(pairs: &[PairRates], bodies: usize, step: f64) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(6 * bodies, 6 * bodies);
        for pair in pairs {
            let rates = pair.stiffness * (step * step) + pair.damping * (2.0 * step);
            for row in 0..12 {
                for column in 0..12 {
                    matrix[(row_of(pair, row), row_of(pair, column))] += rates[(row, column)];
                }
            }
        }
        matrix
    }

    /// Error of the search in the largest eigenvalue, with rounding.
    const LARGEST: f64 = 1e-5;

    #[test]
    fn at_the_limit_of_many_bodies_the_largest_eigenvalue_is_four() {
        for edge in 2..=4 {
            let world = bed(edge);
            let states = world.initial_state().bodies;
            let pairs = world.model.rates(&states, true);
            let limit = stability_limit(&pairs, states.len()).unwrap();
            let matrix = dense(&pairs, states.len(), limit);
            let largest = matrix.symmetric_eigenvalues().max();
            assert!((largest / 4.0 - 1.0).abs() <= LARGEST);
        }
    }

    /// Cube or rod at every angle, with its center inside another cube or near the surface of that cube.
    fn pressed_deep(attempt: usize) -> World {
        let number = |factor: f64| (factor * (attempt + 1) as f64).fract();
        let skin = Material::elastic(1e5);
        let edges = [[0.2; 3], [0.02, 0.02, 0.6]][attempt % 2];
        let turn = vector![number(GOLDEN), number(0.414), number(0.732)] * 6.0;
        let position = vector![number(0.236), number(0.646), number(0.317)] * 0.24;
        let body = |name, edges| {
            let shape = Shape::new(shapes::cuboid(edges).unwrap());
            Body::dynamic(name, shape, skin, Mass::Total(1.0)).unwrap()
        };
        World::new(vec![
            body("body", edges).with_pose(Pose::from_rotation_vector(&turn, position)),
            body("block", [0.2; 3]),
        ])
        .unwrap()
    }

    /// Error of the search in the step if two modes have nearly the same stiffness.
    const STEP: f64 = 2e-3;

    #[test]
    fn motions_that_contact_drives_on_do_not_hide_those_it_resists() {
        let [mut driven, mut overdriven] = [0, 0];
        for attempt in 0..600 {
            let world = pressed_deep(attempt);
            let states = world.initial_state().bodies;
            let pairs = world.model.rates(&states, true);
            let eigenvalues = dense(&pairs, 2, 1.0).symmetric_eigenvalues();
            let (lowest, largest) = (eigenvalues.min(), eigenvalues.max());
            if pairs.is_empty() || largest < STEP * -lowest {
                continue;
            }
            let expected = 2.0 / largest.sqrt();
            let limit = stability_limit(&pairs, 2).unwrap();
            assert!(
                (limit / expected - 1.0).abs() < STEP,
                "{attempt}: {limit} instead of {expected} of {eigenvalues:?}"
            );
            driven += usize::from(lowest < -0.1 * largest);
            overdriven += usize::from(lowest < -largest);
        }
        let counts = [driven, overdriven];
        assert!(driven > 100 && overdriven > 20, "only {counts:?} drive on");
    }
}
