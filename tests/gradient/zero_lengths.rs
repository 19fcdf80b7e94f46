//! Springs whose end points coincide.

use crate::support::worlds::{dynamic, fixed, icosphere, plan_of};
use hydroelastic::dynamics::{Integrator, Material, Plan, Spring, Trajectory, World};
use hydroelastic::gradient::{Experiment, FinalState, Mode, Outcome, Parameter};
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

/// Agreement with differences, which are exact up to round-off because the motion is linear in the initial state.
const SAME: f64 = 1e-8;

/// Agreement with an arm. The body rotates, so the motion has a term of second order in the change.
const BENT: f64 = 1e-6;

/// Agreement of SDIRK3. It divides the first step from a changed initial state, but not from the initial state itself, at which nothing
/// moves. The final states differ by the error of this step.
const IN_PARTS: f64 = 1e-7;

/// Change of the initial state (m, m/s).
const CHANGE: f64 = 1e-4;

/// Discretization error times the phase: the factor is (hω)²/24 for leapfrog, of order (hω)³ for SDIRK3, hω for implicit Euler.
const DISCRETE: [(Integrator, f64); 3] = [
    (Integrator::Leapfrog, 1e-4),
    (Integrator::Sdirk3, 1e-3),
    (Integrator::ImplicitEuler, 5e-2),
];

const STIFFNESS: f64 = 100.0;
const TIME_STEP: f64 = 1e-3;
const STEPS: usize = 314;

/// Position and velocity of the first body along an axis.
struct Along(usize);

impl Outcome for Along {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let body = &trajectory.last().bodies[0];
        vec![body.position()[self.0] + body.velocity()[self.0] * 0.01]
    }
}

/// Returns a body of 1 kg on a spring whose ends initially coincide. The end on the body is `away` (m) from the origin of the body.
fn hung(away: f64, rest_length: f64, damping: f64, scale: f64) -> World<f64, Spring> {
    let ball = || icosphere(0.1 * scale, 1);
    let post = Vector3::new(1.0, 0.3, 0.7) * scale;
    let skin = Material::elastic(1e5);
    let bodies = vec![
        dynamic("ball", ball(), skin, 1.0),
        fixed("post", ball(), skin).with_pose(Pose::from_translation(post)),
    ];
    let arm = vector![away, 0.0, 0.0] * scale;
    let spring = Spring {
        bodies: ["ball".into(), "post".into()],
        points: [arm.into(), (arm - post).into()],
        rest_length: rest_length.into(),
        stiffness: STIFFNESS.into(),
        damping: damping.into(),
    };
    World::new(bodies).unwrap().with_forces(spring).unwrap()
}

fn plan(integrator: Integrator) -> Plan {
    let plan = plan_of(integrator, TIME_STEP, STEPS);
    plan.with_solver_tolerance(1e-13).unwrap()
}

#[test]
fn a_body_at_its_anchor_swings_back_by_the_cosine() {
    let phase = STIFFNESS.sqrt() * TIME_STEP * STEPS as f64;
    for (integrator, discrete) in DISCRETE {
        for scale in [1e-6, 1.0, 1e6] {
            let world = hung(0.0, 0.0, 0.0, scale);
            let experiment = Experiment::new(&world, &plan(integrator));
            let by = [Parameter::initial_position("ball")];
            let end = FinalState::of_body(&world, "ball").unwrap();
            let jacobian = experiment.jacobian(&by, &end).unwrap().jacobian;
            for axis in 0..3 {
                let error = jacobian[(axis, axis)] - phase.cos();
                assert!(error.abs() < discrete, "{integrator:?}, {scale}: {error:e}");
            }
        }
    }
}

/// The derivative with respect to the damping is not zero, because the damping acts along the line on which the body moves.
#[test]
fn forwards_backwards_and_differences_agree_at_length_zero() {
    for (integrator, _) in DISCRETE {
        for (away, damping) in [(0.0, 0.0), (0.0, 2.0), (0.2, 0.0)] {
            let world = hung(away, 0.0, damping, 1.0);
            let experiment = Experiment::new(&world, &plan(integrator));
            for axis in 0..3 {
                for parameter in [Parameter::InitialPosition, Parameter::InitialVelocity] {
                    let by = [parameter("ball".into())];
                    let [forward, reverse] = [Mode::Forward, Mode::Reverse].map(|mode| {
                        experiment
                            .gradient_with_mode(mode, &by, &Along(axis))
                            .unwrap()
                            .1
                    });
                    assert!((&forward - &reverse).amax() <= SAME * forward.amax());
                    let value = |sign: f64| {
                        let mut change = [0.0; 3];
                        change[axis] = sign * CHANGE;
                        experiment
                            .value_perturbed(&by, &change, &Along(axis))
                            .unwrap()[0]
                    };
                    let difference = (value(1.0) - value(-1.0)) / (2.0 * CHANGE);
                    let error = (forward[axis] - difference).abs();
                    let allowed = match integrator {
                        _ if away > 0.0 => BENT,
                        Integrator::Sdirk3 if damping > 0.0 => IN_PARTS,
                        _ => SAME,
                    };
                    assert!(
                        error <= allowed * difference.abs(),
                        "{integrator:?}, {away} m, {damping}: {} for {difference}",
                        forward[axis]
                    );
                }
            }
        }
    }
}
