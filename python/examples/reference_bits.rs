//! Prints the results of the library for the scenes of `tests/test_bits.py`, with the bits of every number in hexadecimal:
//!
//! ```sh
//! cargo run --release -p hydroelastic-examples --example reference_bits > tests/data/reference_bits.json
//! ```

use hydroelastic::contact::{
    ContactBody, ContactPair, ContactWrench, HalfSpace, Partner, RigidShape, Shape, SurfaceLaw,
};
use hydroelastic::dynamics::{
    Body, BodyStateGradient, Control, Drag, Force, Integrator, Mass, Material, Plan, Spring, State,
    StateGradient, Thruster, Trajectory, World,
};
use hydroelastic::gradient::{Experiment, FinalState, Parameter};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::nalgebra::{self, DMatrix, SVector, Vector6, vector};
use hydroelastic::spatial::{Pose, Twist, Wrench};
use serde_json::{Map, Value, json};
use std::error::Error;
use std::sync::Arc;

type Found = Map<String, Value>;

fn main() -> Result<(), Box<dyn Error>> {
    let mut found = Found::new();
    contact(&mut found)?;
    partners(&mut found)?;
    rigid_world(&mut found)?;
    worlds(&mut found)?;
    println!("{}", serde_json::to_string_pretty(&found)?);
    Ok(())
}

fn keep<'n>(found: &mut Found, name: &str, numbers: impl IntoIterator<Item = &'n f64>) {
    let bits = numbers
        .into_iter()
        .map(|number| format!("{:016x}", number.to_bits()));
    found.insert(name.to_owned(), json!(bits.collect::<Vec<_>>()));
}

fn both(wrench: &ContactWrench) -> Vec<f64> {
    let [a, b] = [wrench.on_a, wrench.on_b].map(|it| it.to_vector());
    a.iter().chain(&b).copied().collect()
}

fn ball_pose() -> Pose {
    Pose::from_rotation_vector(&vector![0.3, -0.2, 0.5], vector![0.013, 0.021, 0.1921])
}

fn twists() -> [Twist; 2] {
    [
        Twist::from_vector(&Vector6::new(0.1, 0.2, -0.3, 0.5, 0.1, -0.05)),
        Twist::from_vector(&Vector6::new(0.0, 0.0, 0.1, 0.0, -0.1, 0.0)),
    ]
}

fn contact(found: &mut Found) -> Result<(), Box<dyn Error>> {
    let ball = Shape::new(shapes::icosphere(0.1, 3)?);
    let block = Shape::new(shapes::cuboid([0.4, 0.4, 0.2])?);
    let pose_b = Pose::from_rotation_vector(&vector![0.02, -0.03, 0.01], vector![0.0, 0.0, 0.0]);
    let (a, b) = (
        ContactBody::new(&ball, ball_pose(), 1e5)?,
        ContactBody::new(&block, pose_b, 1e6)?,
    );
    let pair = ContactPair::new(a, b);
    keep(found, "wrench", &both(&pair.wrench()));
    let contact = pair.linearized();
    let rows = (0..12).flat_map(|row| {
        let of_row = contact.by_poses.row(row).into_owned();
        let by_moduli = contact.by_moduli.row(row).into_owned();
        let numbers: Vec<_> = of_row.iter().chain(&by_moduli).copied().collect();
        numbers
    });
    let rows: Vec<_> = rows.collect();
    keep(found, "jacobian", &rows);
    let law = SurfaceLaw::new(0.2, 0.4, 1e-2)?;
    keep(
        found,
        "wrench in motion",
        &both(&pair.moving(law, twists()).wrench()),
    );
    let linearized = pair.moving(law, twists()).linearized();
    keep(found, "linearized wrench", &both(&linearized.wrench));
    keep(
        found,
        "linearized jacobian",
        &linearized.jacobian().transpose(),
    );
    keep(found, "energy", &[pair.potential_energy()]);
    let surface = pair.surface();
    keep(found, "area", &[surface.area()]);
    let halves = std::iter::successors(Some(1.0), |factor| Some(factor / 2.0));
    let by_wrenches = SVector::from_iterator(halves);
    let gradients = pair.moving(law, twists()).shape_gradients(&by_wrenches);
    for (gradient, name) in gradients.iter().zip(["A", "B"]) {
        let by_vertices = gradient.by_vertices.iter().flatten();
        keep(found, &format!("by vertices of {name}"), by_vertices);
        let name = format!("by extents of {name}");
        keep(found, &name, &gradient.by_extents);
    }
    let corners = surface.polygons.iter().flat_map(|it| it.outline.corners());
    keep(found, "corners", corners.flat_map(|corner| corner.iter()));
    let pressure = |it: &hydroelastic::contact::ContactPolygon| {
        let corners = it.outline.corners().iter();
        corners
            .map(|corner| it.pressure_at(corner))
            .collect::<Vec<_>>()
    };
    let pressures: Vec<f64> = surface.polygons.iter().flat_map(pressure).collect();
    keep(found, "pressures", &pressures);
    Ok(())
}

/// Contacts of the same ball with a rigid half-space, a half-space with a layer and a rigid block.
fn partners(found: &mut Found) -> Result<(), Box<dyn Error>> {
    let ball = Shape::new(shapes::icosphere(0.1, 3)?);
    let ball = ContactBody::new(&ball, ball_pose(), 1e5)?;
    let block = rigid_block()?;
    let tilt = vector![0.02, -0.03, 0.01];
    let on_top = Pose::from_rotation_vector(&tilt, vector![0.0, 0.0, 0.1]);
    let layer = HalfSpace::layer(0.05)?;
    let law = SurfaceLaw::new(0.2, 0.4, 1e-2)?;
    for (name, partner) in [
        ("half-space", Partner::rigid_half_space(on_top)?),
        ("layer", Partner::half_space(&layer, on_top, 1e6)?),
        (
            "rigid block",
            Partner::rigid(
                &block,
                Pose::from_rotation_vector(&tilt, vector![0.0, 0.0, 0.0]),
            )?,
        ),
    ] {
        let pair = ContactPair::new(ball, partner);
        let linearized = pair.moving(law, twists()).linearized();
        keep(found, name, &both(&pair.wrench()));
        keep(
            found,
            &format!("{name} jacobian"),
            &linearized.jacobian().transpose(),
        );
        keep(found, &format!("{name} energy"), &[pair.potential_energy()]);
    }
    Ok(())
}

fn rigid_block() -> Result<RigidShape, Box<dyn Error>> {
    let field = shapes::cuboid([0.4, 0.4, 0.2])?;
    Ok(RigidShape::new(TriangleSurface::around(field.mesh())?))
}

/// Records a ball that rolls over a half-space and is pushed by a rigid block.
fn rigid_world(found: &mut Found) -> Result<(), Box<dyn Error>> {
    let skin = Material::elastic(1e5)
        .with_dissipation(0.2)
        .with_friction(0.4);
    let hard = Material::rigid().with_friction(0.5);
    let ball = Shape::new(shapes::icosphere(0.1, 2)?);
    let bodies = vec![
        Body::dynamic("ball", ball, skin, Mass::Total(1.0))?
            .with_pose(Pose::from_translation(vector![0.0, 0.0, 0.12])),
        Body::dynamic("block", rigid_block()?, hard, Mass::Density(100.0))?
            .with_pose(Pose::from_translation(vector![-0.31, 0.0, 0.1]))
            .with_velocity(vector![0.5, 0.0, 0.5]),
        Body::fixed("ground", HalfSpace::rigid(), hard)?,
    ];
    let world = World::builder()
        .bodies(bodies)
        .ignore("block", "ground")
        .build()?;
    let world = world.with_gravity(vector![0.0, 0.0, -9.81])?;
    let plan = Plan::new(5e-3, 40)?
        .with_integrator(Integrator::Sdirk3)
        .recording_every(20);
    recorded(found, "rigid world", &world, &plan)
}

/// Creates a world with a ball and a brick above a floor.
fn scene() -> Result<World, Box<dyn Error>> {
    let skin = Material::elastic(1e5)
        .with_dissipation(0.2)
        .with_friction(0.4);
    let ball = Shape::new(shapes::icosphere(0.1, 2)?);
    let brick = Shape::new(shapes::cuboid([0.1, 0.2, 0.3])?);
    let floor = Shape::new(shapes::cuboid([2.0, 2.0, 0.2])?);
    let tilted = Pose::from_rotation_vector(&vector![0.1, 0.3, -0.2], vector![0.3, 0.0, 0.26]);
    Ok(World::new(vec![
        Body::dynamic("ball", ball, skin, Mass::Total(1.0))?
            .with_pose(Pose::from_translation(vector![-0.3, 0.0, 0.25]))
            .with_velocity(vector![0.5, 0.0, 0.0])
            .with_angular_velocity(vector![0.0, 1.0, 0.5]),
        Body::dynamic("brick", brick, skin, Mass::Density(800.0))?.with_pose(tilted),
        Body::fixed("floor", floor, skin)?,
    ])?
    .with_gravity(vector![0.0, 0.0, -9.81])?
    .with_slip_tolerance(1e-2)?)
}

fn states(found: &mut Found, name: &str, states: &[State]) {
    let mut numbers = Vec::new();
    for body in states.iter().flat_map(|state| &state.bodies) {
        numbers.extend(body.pose.rotation().transpose().iter().copied());
        numbers.extend(body.pose.translation().iter().copied());
        numbers.extend(body.twist.to_vector().iter().copied());
    }
    keep(found, name, &numbers);
}

fn recorded<F: Force>(
    found: &mut Found,
    name: &str,
    world: &World<f64, F>,
    plan: &Plan,
) -> Result<(), Box<dyn Error>> {
    states(found, name, world.rollout(plan).run()?.states());
    Ok(())
}

fn by_rows(found: &mut Found, name: &str, matrix: &DMatrix<f64>) {
    keep(found, name, &matrix.transpose());
}

fn worlds(found: &mut Found) -> Result<(), Box<dyn Error>> {
    let world = scene()?;
    let explicit = Plan::new(2e-4, 900)?.recording_every(300);
    recorded(found, "leapfrog", &world, &explicit)?;
    let euler = explicit.with_integrator(Integrator::SymplecticEuler);
    recorded(found, "symplectic Euler", &world, &euler)?;
    let implicit = Plan::new(5e-3, 40)?.recording_every(20);
    let sdirk = implicit.with_integrator(Integrator::Sdirk3);
    recorded(found, "sdirk3", &world, &sdirk)?;
    recorded(
        found,
        "implicit Euler",
        &world,
        &implicit.with_integrator(Integrator::ImplicitEuler),
    )?;

    let push = Wrench {
        torque: vector![0.0, 0.0, 0.05],
        force: vector![0.5, 0.0, 0.0],
    };
    let spring = Spring {
        bodies: ["ball".into(), "brick".into()],
        points: [[0.0; 3], [0.01, 0.02, 0.1]],
        rest_length: 0.5.into(),
        stiffness: 20.0.into(),
        damping: 0.1.into(),
    };
    let drag = Drag {
        body: "ball".into(),
        linear: 0.3.into(),
        angular: 0.01.into(),
    };
    let thruster = Thruster {
        body: "brick".into(),
        point: [0.0, 0.1, 0.0],
        force: [1.0, 0.0, 0.5],
    };
    let driven = scene()?.with_control(Control::new("ball", 0.05, vec![push, -push, push])?)?;
    let driven = driven.with_forces((spring, drag, thruster))?;
    recorded(found, "forces, leapfrog", &driven, &explicit)?;
    recorded(found, "forces, sdirk3", &driven, &sdirk)?;

    let by = [
        Parameter::initial_velocity("ball"),
        Parameter::friction("ball"),
        Parameter::control("ball", 1),
    ];
    let plan = Plan::new(5e-4, 300)?.recording_every(300);
    let shared = Arc::new(driven);
    let experiment = Experiment::new(Arc::clone(&shared), &plan);
    let end = experiment.jacobian(&by, &FinalState::of_body(&shared, "ball")?)?;
    keep(found, "end", &end.value);
    by_rows(found, "end jacobian", &end.jacobian);
    let vjp = experiment.vjp(&by)?;
    let by_states = by_last_state(vjp.trajectory());
    keep(found, "pullback", &vjp.pull_back(&by_states)?);
    let linearized = Experiment::new(Arc::clone(&shared), &Plan::new(1e-3, 100)?).linearize(&by)?;
    by_rows(found, "A", &linearized.by_state);
    by_rows(found, "B", &linearized.by_parameters);
    Ok(())
}

/// Derivatives of a loss with respect to two recorded states. Only those with respect to the last state of the ball are not zero.
fn by_last_state(trajectory: &Trajectory) -> Vec<StateGradient> {
    let mut by_states = vec![StateGradient::zero(trajectory.last()); 2];
    by_states[1].bodies[0] = BodyStateGradient {
        turn: vector![0.1, 0.2, 0.3],
        shift: vector![1.0, -2.0, 3.0],
        spin: vector![0.01, 0.02, -0.03],
        velocity: vector![-0.1, 0.4, 0.2],
    };
    by_states
}
