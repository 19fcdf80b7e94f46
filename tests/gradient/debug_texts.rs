//! Debug output of experiments and gradients.

use crate::support::worlds::{dynamic, icosphere};
use hydroelastic::dynamics::{Material, Plan, Trajectory, World};
use hydroelastic::gradient::{Experiment, Outcome};
use hydroelastic::scalar::Scalar;
use nalgebra::vector;

/// Final height of the ball.
struct Height;

impl Outcome for Height {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        vec![trajectory.last().bodies[0].position().z]
    }
}

fn falling() -> World {
    let ball = icosphere(0.1, 0);
    let ball = dynamic("ball", ball, Material::elastic(1e5), 1.0);
    let world = World::new(vec![ball]).unwrap();
    world.with_gravity(vector![0.0, 0.0, -8.0]).unwrap()
}

#[test]
fn an_experiment_shows_its_plan_and_a_gradient_the_value_it_is_of() {
    let plan = Plan::new(0.125, 8).unwrap();
    let experiment = Experiment::new(falling(), &plan);
    let text = format!("{experiment:?}");
    assert_eq!(text, format!("Experiment {{ plan: {plan:?}, .. }}"));
    let gradient = experiment.full_gradient(&Height).unwrap();
    let text = format!("{gradient:?}");
    assert_eq!(
        text,
        format!("RolloutGradient {{ value: {:?}, .. }}", gradient.value)
    );
}
