//! Solvers of argmin on problems of experiments.

use argmin::core::{CostFunction, Executor, Operator};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, Integrator, Mass, Material, Plan, Trajectory, World};
use hydroelastic::gradient::{Experiment, FinalPosition, GradientError, Outcome, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift_vector};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

/// A throw (m/s) that bounces off the floor.
const THROW: [f64; 3] = [0.8, 0.2, -0.6];

/// Squared distance (m²) of the ball from a target at the end.
#[derive(Debug, Clone)]
struct Miss(Vector3<f64>);

impl Outcome for Miss {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let away = trajectory.last().bodies[0].position() - lift_vector::<T>(&self.0);
        vec![away.dot(&away)]
    }
}

/// A ball that falls on a floor and bounces with friction.
fn world() -> World {
    let skin = Material::elastic(1e5)
        .with_dissipation(0.1)
        .with_friction(0.3);
    let ball = Shape::new(shapes::icosphere(0.1, 1).unwrap());
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(1.0)).unwrap();
    let ball = ball.with_pose(Pose::from_translation(vector![0.0, 0.0, 0.2]));
    let floor = Body::fixed("floor", HalfSpace::rigid(), Material::rigid()).unwrap();
    let builder = World::builder().bodies([ball, floor]);
    builder.gravity(vector![0.0, 0.0, -9.81]).build().unwrap()
}

fn experiment() -> Experiment {
    let plan = Plan::new(5e-3, 80)
        .unwrap()
        .with_integrator(Integrator::Sdirk3);
    Experiment::new(world(), &plan.recording_ends())
}

fn by() -> [Parameter; 1] {
    [Parameter::initial_velocity("ball")]
}

#[test]
fn l_bfgs_finds_the_throw_that_met_a_target_after_a_bounce() {
    let end = FinalPosition::of_body(&world(), "ball").unwrap();
    let target = experiment().value_at(&by(), &THROW, &end).unwrap();
    let miss = Miss(Vector3::from_column_slice(&target));
    let problem = experiment().problem(&by(), miss).unwrap();
    let start = [0.5, 0.0, -0.4];
    assert!(problem.value(&start).unwrap()[0] > 1e-2);
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), 5);
    let solved = Executor::new(problem.clone(), solver)
        .configure(|state| {
            state
                .param(vec![0.5, 0.0, -0.4])
                .max_iters(30)
                .target_cost(1e-8)
        })
        .run()
        .unwrap();
    let velocity = solved.state.best_param.unwrap();
    let missed = problem.value(&velocity).unwrap()[0];
    assert!(missed <= 1e-8, "{missed} m²");
}

#[test]
fn residuals_and_jacobians_are_those_of_a_world_with_the_values() {
    let values = [0.3, -0.2, 0.1];
    let end = FinalPosition::of_body(&world(), "ball").unwrap();
    let problem = experiment().problem(&by(), end).unwrap();
    let thrown = world().with_values(&by(), &values).unwrap();
    let expected = Experiment::new(&thrown, experiment().plan()).jacobian(&by(), &end);
    let expected = expected.unwrap();
    assert_eq!(
        problem.apply(&values.to_vec()).unwrap(),
        expected.value.as_slice()
    );
    let rows = argmin::core::Jacobian::jacobian(&problem, &values.to_vec()).unwrap();
    for (row, expected) in rows.iter().zip(expected.jacobian.row_iter()) {
        assert!(row.iter().eq(expected.iter()));
    }
}

#[test]
fn outcomes_of_several_numbers_are_no_cost() {
    let end = FinalPosition::of_body(&world(), "ball").unwrap();
    let problem = experiment().problem(&by(), end).unwrap();
    let error = CostFunction::cost(&problem, &vec![0.0; 3]).unwrap_err();
    let error = error.downcast::<GradientError>().unwrap();
    assert_eq!(error, GradientError::NotALoss { count: 3 });
}
