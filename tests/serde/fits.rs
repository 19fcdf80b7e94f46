use crate::text_and_bits::{reloaded, trajectory_bits};
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{
    Body, BodyState, Integrator, Mass, Material, Plan, State, Trajectory, World,
};
use hydroelastic::gradient::Parameter;
use hydroelastic::identification::{Fit, Identification, Measurement, Prediction, Unknown};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::vector;

fn world() -> World {
    let ball = Shape::new(shapes::icosphere(0.05, 1).unwrap());
    let skin = Material::elastic(1e5).with_friction(0.2);
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(0.2)).unwrap();
    let ball = ball.with_pose(Pose::from_translation(vector![0.0, 0.0, 0.06]));
    let ball = ball.with_velocity(vector![0.8, 0.0, -0.8]);
    let table = Body::fixed("table", HalfSpace::rigid(), Material::rigid()).unwrap();
    let world = World::new(vec![ball, table]).unwrap();
    world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
}

/// Returns the recording with a ball below the table in the first state, which cannot be simulated.
fn sunk(recording: &Trajectory) -> Trajectory {
    let mut states: Vec<State> = recording.states().to_vec();
    let pose = Pose::from_translation(vector![0.0, 0.0, -1.0]);
    states[0].bodies[0] = BodyState {
        pose,
        twist: Twist::zero(),
    };
    Trajectory::new(states).unwrap()
}

#[test]
fn saved_fits_have_their_numbers_and_the_texts_of_their_errors() {
    let plan = Plan::new(0.01, 20).unwrap();
    let plan = plan.with_integrator(Integrator::Sdirk3);
    let recording = world().rollout(&plan).run().unwrap();
    let unknown = Unknown::new(Parameter::friction("ball")).logarithmic();
    let identification = Identification::new(&world(), &plan, &[unknown]).unwrap();
    let measurements = [sunk(&recording), recording].map(|states| Measurement::new("toss", states));
    let fit = identification.fit(&measurements).unwrap();
    let loaded: Fit = reloaded(&fit);
    assert_eq!(loaded.estimates, fit.estimates);
    assert_eq!(loaded.covariance, fit.covariance);
    assert_eq!(loaded.sandwich_covariance, fit.sandwich_covariance);
    assert_eq!(loaded.directions, fit.directions);
    assert_eq!(loaded.checkpoint, fit.checkpoint);
    assert_eq!(loaded.cost.to_bits(), fit.cost.to_bits());
    assert_eq!(
        (loaded.iterations, loaded.termination),
        (fit.iterations, fit.termination)
    );
    let texts = |fit: &Fit| {
        let errors = fit.measurements.iter().map(|fitted| &fitted.error);
        errors
            .map(|error| error.as_ref().map(ToString::to_string))
            .collect::<Vec<_>>()
    };
    assert_eq!(texts(&loaded), texts(&fit));
    assert!(texts(&fit)[0].is_some() && texts(&fit)[1].is_none());
    let predictions = identification
        .residuals(&measurements, &loaded.checkpoint)
        .unwrap();
    let prediction = predictions[1].as_ref().unwrap();
    let loaded: Prediction = reloaded(prediction);
    assert_eq!(
        trajectory_bits(&loaded.trajectory),
        trajectory_bits(&prediction.trajectory)
    );
    assert_eq!(loaded.position_errors, prediction.position_errors);
    assert_eq!(loaded.normalized_errors, prediction.normalized_errors);
}
