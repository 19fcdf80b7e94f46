//! A mug on the floor between two fingers.

use super::guide::Guide;
use super::path::{self, Move};
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, Control, Integrator, Mass, Material, Plan, World, WorldError};
use hydroelastic::io::{MeshOptions, read_mesh};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::spatial::Wrench;
use nalgebra::vector;
use std::error::Error;
use std::sync::Arc;

/// Indices of the bodies in the world.
pub const MUG: usize = 0;
pub const PRESSED: usize = 1;
pub const LEADING: usize = 2;

/// Integrator, steps per second, and slip tolerance (m/s), below which friction is less than full. A smaller slip tolerance requires
/// shorter explicit steps, but not shorter implicit steps.
pub const STEPPING: (Integrator, usize, f64) = (Integrator::Sdirk3, 200, 1e-3);

/// Mesh made by mug.py.
const MESH: &str = "examples/grasp/mug.msh";

pub const GRAVITY: f64 = 9.81;
pub const FRICTION: f64 = 0.5;
const DISSIPATION: f64 = 5.0;
/// Radius of the mug (m), and its density (kg/m³). The weight is 2.25 N.
const RADIUS: f64 = 0.04;
const DENSITY: f64 = 2_000.0;
/// Edges (m) and mass (kg) of a finger.
pub const FINGER: [f64; 3] = [0.03, 0.03, 0.05];
const FINGER_MASS: f64 = 0.5;
/// Moduli (Pa). Below the surface, the pressure gradient is 10 MPa/m in the fingers and about 200 MPa/m in the mug. The floor is rigid.
const SOFT: f64 = 1.5e5;
const MUG_MODULUS: f64 = 1e6;
/// Initial gap (m) between the mug's wall and a finger's face, final depth (m) of the leading finger, and the times (s) of closing.
const GAP: f64 = 5e-4;
const DEPTH: f64 = 1e-3;
const CLOSING: [f64; 2] = [0.0, 0.1];

/// The squeeze (N) and its duration (s).
pub const SQUEEZE: f64 = 6.0;
const DURATION: f64 = 10.0;

/// Returns the world with the mug on the floor and the fingers still open.
pub fn squeezed() -> Result<World<f64, Guide>, Box<dyn Error>> {
    let skin = |modulus| {
        Material::elastic(modulus)
            .with_dissipation(DISSIPATION)
            .with_friction(FRICTION)
    };
    let mug = Shape::new(PressureField::from_distance(
        &read_mesh(MESH, &MeshOptions::default())?.mesh,
    )?);
    let finger = Arc::new(Shape::new(shapes::distance_cuboid(FINGER)?));
    let hard = Material::rigid().with_friction(FRICTION);

    let touching = RADIUS + FINGER[1] / 2.0;
    let closing = Move {
        from: touching + GAP,
        to: touching - DEPTH,
        times: CLOSING,
    };
    let start = path::carried([-touching - GAP, 0.0], 0.0);
    let leading = move |time: f64| path::carried(closing.at(time), time);
    let world = World::new(vec![
        Body::dynamic("mug", mug, skin(MUG_MODULUS), Mass::Density(DENSITY))?,
        Body::dynamic(
            "pressed",
            Arc::clone(&finger),
            skin(SOFT),
            Mass::Total(FINGER_MASS),
        )?
        .with_pose(start.pose),
        Body::kinematic("leading", finger, skin(SOFT), Arc::new(leading))?,
        Body::fixed("floor", HalfSpace::rigid(), hard)?,
    ])?
    .with_gravity(vector![0.0, 0.0, -GRAVITY])?
    .with_slip_tolerance(STEPPING.2)?;
    let guide = Guide {
        body: PRESSED,
        linear: [4e4, 80.0],
        angular: [4.0, 0.025],
        along: 50.0,
    };
    let push = Wrench {
        force: vector![0.0, SQUEEZE, 0.0],
        ..Wrench::zero()
    };
    let control = Control::new("pressed", DURATION, vec![push])?;
    // These pairs never touch.
    let world = world
        .with_ignored("pressed", "floor")?
        .with_ignored("pressed", "leading")?;
    Ok(world.with_forces(guide)?.with_control(control)?)
}

/// Returns a plan of a number of tenths of a second.
pub fn plan(tenths: usize) -> Result<Plan, WorldError> {
    let (integrator, rate, _) = STEPPING;
    let plan = Plan::new(1.0 / rate as f64, tenths * rate / 10)?;
    Ok(plan.with_integrator(integrator))
}
