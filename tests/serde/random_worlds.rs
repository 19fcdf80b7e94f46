//! Every world that can be constructed can be saved and loaded, also after some steps.

use crate::support::scenes::Random;
use crate::support::worlds::{cuboid, icosphere, plan_of, rubbing};
use crate::text_and_bits::{TIME_STEP, saved, trajectory_bits};
use hydroelastic::contact::{HalfSpace, RigidShape, Shape};
use hydroelastic::dynamics::{
    Body, BodyShape, Integrator, Mass, Material, Spring, World, WorldBuilder, WorldError,
};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{Matrix3, Vector3, vector};
use std::sync::Arc;

/// Rounds to a number of significant digits.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap()
}

/// Returns principal moments of a solid, often of a plate or nearly a plate, rounded as in a file.
fn moments(random: &mut Random) -> Vector3<f64> {
    let size = 10_f64.powf(random.between(-6.0, 3.0));
    let [a, b, c] = [(); 3].map(|()| {
        let parts = [1.0, 1.0, random.between(0.0, 1.0), 1e-7, 0.0];
        size * parts[random.below(5)]
    });
    let digits = [5, 5, 9, 17][random.below(4)];
    vector![b + c, a + c, a + b].map(|moment| rounded(moment, digits))
}

fn properties(random: &mut Random) -> MassProperties {
    let moments = Matrix3::from_diagonal(&moments(random));
    let turn = Pose::from_rotation_vector(&random.rotation_vector(), Vector3::zeros());
    let turn = [*turn.rotation(), Matrix3::identity()][random.below(2)];
    let mass = 10_f64.powf(random.between(-3.0, 3.0));
    MassProperties {
        mass,
        center_of_mass: random.vector() * 0.02,
        inertia: turn * moments * turn.transpose() * [1.0, mass][random.below(2)],
    }
}

struct Kit {
    soft: [Arc<Shape>; 2],
    rigid: Arc<RigidShape>,
}

fn shape(kit: &Kit, random: &mut Random) -> (BodyShape, Material) {
    let skin = rubbing(
        10_f64.powf(random.between(1.0, 5.0)),
        [0.0, random.between(0.0, 2.0)][random.below(2)],
        [0.0, random.between(0.0, 1.0)][random.below(2)],
    );
    match random.below(4) {
        0 => (Arc::clone(&kit.rigid).into(), Material::rigid()),
        1 => (Arc::clone(&kit.soft[0]).into(), skin),
        _ => (Arc::clone(&kit.soft[1]).into(), skin),
    }
}

/// Returns one or two bodies near a floor, with or without a spring, or an error if the random numbers make no valid world.
fn world(kit: &Kit, random: &mut Random) -> Result<World<f64, Vec<Spring>>, WorldError> {
    let mut bodies = Vec::new();
    for name in ["a", "b"].into_iter().take(1 + random.below(2)) {
        let (shape, skin) = shape(kit, random);
        let mass = match random.below(3) {
            0 => Mass::Total(10_f64.powf(random.between(-3.0, 3.0))),
            _ => Mass::Properties(properties(random)),
        };
        let position = vector![0.0, 0.0, 0.1] + random.vector() * 0.06;
        let pose = Pose::from_rotation_vector(&random.rotation_vector(), position);
        let body = Body::dynamic(name, shape, skin, mass)?.with_pose(pose);
        let body = body.with_velocity(random.vector());
        bodies.push(body.with_angular_velocity(random.vector() * 3.0));
    }
    let floors: [(BodyShape, Material); 2] = [
        (HalfSpace::rigid().into(), Material::rigid()),
        (
            HalfSpace::layer(0.1).unwrap().into(),
            Material::elastic(1e4),
        ),
    ];
    let [hard, soft] = floors;
    let (floor, skin) = if random.below(2) == 0 { hard } else { soft };
    bodies.push(Body::fixed("floor", floor, skin)?);
    let spring = Spring {
        bodies: ["a".into(), "floor".into()],
        points: [random.vector().into(), random.vector().into()],
        rest_length: random.between(0.0, 1.0).into(),
        stiffness: random.between(0.0, 10.0).into(),
        damping: random.between(0.0, 1.0).into(),
    };
    let springs = vec![spring; random.below(2)];
    let ignored = [["a", "floor"], ["b", "floor"], ["a", "b"]];
    let count = bodies.len();
    let ignored = if count == 3 {
        &ignored[..]
    } else {
        &ignored[..1]
    };
    let builder = World::builder()
        .bodies(bodies)
        .gravity(random.vector() * 10.0);
    let ignoring = |builder: WorldBuilder, pair: &[&str; 2]| builder.ignore(pair[0], pair[1]);
    let mut world = ignored
        .iter()
        .fold(builder, ignoring)
        .build()?
        .with_forces(springs)?;
    if random.below(2) == 0 {
        world = world.with_slip_tolerance(10_f64.powf(random.between(-6.0, 0.0)))?;
    }
    Ok(world)
}

#[test]
fn random_worlds_are_loaded_as_they_were_saved() {
    assert_loaded_as_saved(300);
}

#[test]
#[ignore = "ten thousand worlds: three minutes"]
fn ten_thousand_random_worlds_are_loaded_as_they_were_saved() {
    assert_loaded_as_saved(10_000);
}

fn assert_loaded_as_saved(count: usize) {
    let cube = shapes::cuboid([0.1, 0.08, 0.06]).unwrap();
    let surface = TriangleSurface::around(cube.mesh()).unwrap();
    let kit = Kit {
        soft: [Arc::new(Shape::new(cube)), Arc::new(icosphere(0.05, 0))],
        rigid: Arc::new(RigidShape::new(surface)),
    };
    let mut random = Random::numbered(31);
    let (mut loaded, mut refused) = (0, 0);
    while loaded < count {
        let Ok(world) = world(&kit, &mut random) else {
            refused += 1;
            continue;
        };
        let integrator = [Integrator::Leapfrog, Integrator::Sdirk3][loaded % 2];
        let plan = plan_of(integrator, TIME_STEP, 2);
        let plan = plan.without_stability_check();
        let states = match world.rollout(&plan).run() {
            Ok(trajectory) => trajectory,
            Err(interrupted) => interrupted.trajectory,
        };
        // The initial state, and the state after some steps.
        for start in [&world.initial_state(), states.last()] {
            let world = world.clone().with_initial_state(start).unwrap();
            let text = saved(&world);
            let again: World<f64, Vec<Spring>> =
                serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
            assert_eq!(saved(&again), text);
            let [expected, actual] = [&world, &again].map(|world| {
                let recorded = world.rollout(&plan).run();
                recorded.unwrap_or_else(|interrupted| interrupted.trajectory)
            });
            assert_eq!(trajectory_bits(&expected), trajectory_bits(&actual));
        }
        loaded += 1;
    }
    // A rod has a zero moment, and rounding makes some plates invalid.
    assert!(refused < count, "{refused}");
}

/// The largest moment of a plate, rounded to five digits as in a URDF, may exceed the sum of the other two moments.
#[test]
fn plates_rounded_to_five_digits_are_bodies_and_can_be_loaded() {
    for moments in [
        [1.0, 1.0, 2.00001],
        [0.083_333, 0.083_333, 0.166_67],
        [1.0, 1.0, 2.0001],
    ] {
        let cube = cuboid([0.1; 3]);
        let mass = Mass::Properties(MassProperties {
            mass: 1.0,
            center_of_mass: Vector3::zeros(),
            inertia: Matrix3::from_diagonal(&moments.into()),
        });
        let plate = Body::dynamic("plate", cube, Material::elastic(1e5), mass).unwrap();
        let text = saved(&World::new(vec![plate]).unwrap());
        serde_json::from_str::<World>(&text).unwrap();
    }
}
