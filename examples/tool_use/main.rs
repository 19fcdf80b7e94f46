//! With what force does a soft block resist a rigid tool that presses into it and slides over it?
//!
//! `cargo run --release -p hydroelastic-examples --example tool_use [-- --record FILE.glb --plot FILE.svg]`
//!
//! The tool is a hook from an STL file, and the block stands on a half-space. Below its upper face, the block's pressure is κ times the
//! depth, as in a liquid of weight κ per volume. Therefore Archimedes' principle gives the force on a tool of any shape: −∫ p N dA = κV,
//! upward through the centroid of the displaced volume V. This holds as long as the side faces are farther away than the upper face.
//! Friction is μ∫p dA, not μN, because the flanks of a round tool carry more than their share of N. In a slide along x, a triangle with
//! normal n contributes μ√(1 − n_x²) of its force.
//!
//! A hand with a spring guides the tool. The example compares the derivatives of its force and work, with respect to the block's modulus
//! and the depth of the path, with differences.

mod archimedes;
mod felt;
mod hand;
mod press;
mod scene;
#[path = "../show/mod.rs"]
mod show;

use felt::{Felt, step_at};
use hand::{ALONG, Hand};
use hydroelastic::dynamics::{State, World};
use hydroelastic::gradient::{Experiment, Parameter};
use hydroelastic::io::Recording;
use nalgebra::{DVector, vector};
use scene::{BLOCK, BLOCK_SIZE, MODULUS, TOOL, plan};
use std::error::Error;

/// Number of depths to which the tool is pressed. Every fourth depth is printed.
const DEPTHS: usize = 16;
/// The first depth (m), and the distance between depths.
const DEPTH: f64 = 0.25e-3;
/// Lowest point of the hand's path (m): 3 mm below the block's upper face.
const LOWEST: f64 = BLOCK_SIZE[2] - 0.003;
/// Relative rounding error of a sum over a hundred polygons.
const ROUND_OFF: f64 = 1e-11;
/// Relative error of the friction. Under friction the block leans by 0.2 mrad, so a fraction of N counts as friction.
const LEANING: f64 = 1e-3;
/// Relative error of central differences.
const BY_DIFFERENCES: f64 = 1e-7;
/// Steps of the differences: of the modulus (Pa), and of the path's depth (m).
const STEPS: [f64; 2] = [1e-4 * MODULUS, 1e-7];

fn main() -> Result<(), Box<dyn Error>> {
    let wanted = show::wanted()?;
    let depths: Vec<_> = (1..=DEPTHS).map(|n| n as f64 * DEPTH).collect();
    let pressed = press::at_depths(&depths)?;
    assert!(pressed.iter().all(|at| press::deviation(at) < ROUND_OFF));
    for at in pressed.iter().skip(3).step_by(4) {
        let [found, _] = at.wrenches;
        let off = press::deviation(at);
        println!(
            "{} mm deep: {:.4} N, {:.4?} N mm; from Archimedes by {off:.0e}",
            1e3 * at.depth,
            found.force.z,
            (1e3 * found.torque).as_slice(),
        );
    }
    let world = scene::world(LOWEST)?;
    let trajectory = world.rollout(&plan()?).run()?;
    let sliding = step_at(f64::midpoint(ALONG[0], ALONG[1]));
    check_friction(&world, &trajectory.states()[sliding])?;
    check_gradients(&world)?;

    wanted.record(|| {
        let recording = Recording::new(&world, &trajectory).slowed(8.0);
        Ok(recording.seen_from(vector![0.08, -0.17, 0.11], vector![0.0, 0.0, 0.035]))
    })?;
    wanted.plot(|| {
        let felt = felt(LOWEST);
        vec![press::over_depth(&pressed), felt.over_time(&trajectory)]
    })
}

/// Returns the outcome for a path with this lowest height (m).
fn felt(lowest: f64) -> Felt {
    Felt(Hand { tool: TOOL, lowest })
}

/// Compares the friction on the sliding tool with the pressure and the directions of its triangles.
fn check_friction(world: &World<f64, Hand>, state: &State) -> Result<(), Box<dyn Error>> {
    let contacts = world.contacts(state)?;
    let mut of_tool = contacts.iter().filter(|it| it.bodies == [BLOCK, TOOL]);
    let contact = of_tool.next().ok_or("the tool does not touch the block")?;
    let wrench = contact.wrench.on_b;
    let polygons = contact.surface.polygons.iter();
    let share = |normal: f64| (1.0 - normal * normal).sqrt();
    let full: f64 = polygons
        .map(|polygon| polygon.force().norm() * share(polygon.normal.x))
        .sum();
    let friction = -wrench.force.x;
    println!(
        "sliding: {friction:.3} N against the slip, {:.3} μN, {:.6} of what the flanks make of μ",
        friction / (scene::friction() * wrench.force.z),
        friction / (scene::friction() * full)
    );
    assert!((friction / (scene::friction() * full) - 1.0).abs() < LEANING);
    Ok(())
}

/// Compares the derivatives of force and work with respect to the modulus of the block and the depth of the path with differences.
fn check_gradients(world: &World<f64, Hand>) -> Result<(), Box<dyn Error>> {
    let experiment = Experiment::new(world, &plan()?);
    // A lower path is equivalent to a path at the same height above a higher block on higher ground.
    let by_modulus = [Parameter::modulus("block")];
    let mut by = by_modulus.to_vec();
    by.extend(["block", "ground"].map(Parameter::initial_position));
    let exact = experiment.jacobian(&by, &felt(LOWEST))?;
    let column = |column: usize| exact.jacobian.column(column).into_owned();
    let slopes = [column(0), column(3) + column(6)];

    let after = |change: f64| experiment.value_perturbed(&by_modulus, &[change], &felt(LOWEST));
    let lowered = |by: f64| {
        let experiment = Experiment::new(scene::world(LOWEST - by)?, &plan()?);
        Ok::<_, Box<dyn Error>>(experiment.value_perturbed(&[], &[], &felt(LOWEST - by))?)
    };
    let [step, way] = STEPS;
    let differences = [
        difference(&after(step)?, &after(-step)?, step),
        difference(&lowered(way)?, &lowered(-way)?, way),
    ];
    println!(
        "pressed with {:.4} N, work {:.6} J",
        exact.value[0], exact.value[1]
    );
    let names = ["modulus (Pa)", "depth (m)"];
    for ((name, slope), difference) in names.into_iter().zip(slopes).zip(differences) {
        let off = difference.component_div(&slope).add_scalar(-1.0).amax();
        println!(
            "by {name}: {:.4e} N, {:.4e} J; differences are off by {off:.0e}",
            slope[0], slope[1]
        );
        assert!(off < BY_DIFFERENCES);
    }
    Ok(())
}

/// Returns the central difference of values at a step ahead and a step behind.
fn difference(ahead: &[f64], behind: &[f64], step: f64) -> DVector<f64> {
    let slopes = ahead
        .iter()
        .zip(behind)
        .map(|(a, b)| (a - b) / (2.0 * step));
    DVector::from_iterator(ahead.len(), slopes)
}
