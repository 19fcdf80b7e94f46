//! Accumulated effects of many steps: at rest, on an incline, and bouncing. No rotation drifts, no memory grows, and energy has the
//! expected course.
//!
//! Run the long forms by `cargo test --test dynamics long_runs:: -- --ignored --nocapture --test-threads=1`, which prints the results.

use crate::scenes::GRAVITY;
use crate::support::worlds::{at, cuboid, dynamic, fixed, rubbing};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Material, Plan, Rollout, State, World};
use hydroelastic::mesh::{PressureField, shapes};
use nalgebra::{Matrix3, Vector3, vector};
use std::ops::Range;

/// Numbers of steps of the short and the long form.
const SHORT: usize = 100_000;
const LONG: usize = 10_000_000;

/// Bound of the entries of RᵀR − I: each of nine entries of a rotation is rounded.
const ORTHONORMAL: f64 = 1e-15;

/// Memory (kB) that a test may use besides its steps. One byte per step would be 9,000.
const OTHER_MEMORY: u64 = 256;

fn on_floor(field: PressureField, height: f64, skin: Material, down: &Vector3<f64>) -> World {
    let at_height = |z| at(0.0, 0.0, z);
    let body = dynamic("body", Shape::new(field), skin, 1.0);
    let floor = cuboid([2.0, 2.0, 0.4]);
    let floor = fixed("floor", floor, skin);
    let bodies = vec![
        body.with_pose(at_height(height)),
        floor.with_pose(at_height(-0.2)),
    ];
    let world = World::new(bodies).unwrap();
    world.with_gravity(down * GRAVITY).unwrap()
}

/// Observations of the steps up to a power of ten, from the previous power on.
struct Decade {
    /// Lowest and highest total energy (J).
    energy: [f64; 2],
    /// Largest entry of RᵀR − I of the first body.
    deviation: f64,
    /// Final state.
    state: State,
    /// Resident memory (kB) of this process at the end, if the system reports it.
    resident: Option<u64>,
}

/// Number of steps between observations, a prime number, so that observations are not synchronized with bounces.
const LOOK: usize = 97;

impl Decade {
    /// Observes the given steps of a rollout.
    fn of(rollout: &mut Rollout, world: &World, steps: Range<usize>) -> Self {
        let (mut energy, mut deviation) = ([f64::INFINITY, f64::NEG_INFINITY], 0.0_f64);
        for step in steps {
            let state = rollout.advance().unwrap();
            if step % LOOK == 0 {
                let seen = world.diagnostics(state).unwrap().total_energy();
                energy = [energy[0].min(seen), energy[1].max(seen)];
                deviation = deviation.max(deviation_of(state));
            }
        }
        Self {
            energy,
            deviation,
            state: rollout.state().clone(),
            resident: resident(),
        }
    }

    fn position(&self) -> &Vector3<f64> {
        self.state.bodies[0].position()
    }
}

fn deviation_of(state: &State) -> f64 {
    let rotation = state.bodies[0].pose.rotation();
    (rotation.transpose() * rotation - Matrix3::identity()).amax()
}

fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

/// Observes a rollout by decades, beginning with the first thousand steps. Asserts that the rotation never drifts.
fn decades(world: &World, time_step: f64, steps: usize) -> Vec<Decade> {
    let limit = world.largest_stable_step(&world.initial_state()).unwrap();
    assert!(limit.is_none_or(|limit| time_step < 0.6 * limit));
    let mut rollout = world.rollout(&Plan::new(time_step, steps).unwrap());
    let (mut decades, mut start) = (Vec::new(), 0);
    for power in 3..=steps.ilog10() {
        let end = 10_usize.pow(power);
        let decade = Decade::of(&mut rollout, world, start..end);
        start = end;
        println!(
            "10^{power} steps: energy {:?} J, rotation {:.1e}, position {:?} m, memory {:?} kB",
            decade.energy,
            decade.deviation,
            decade.position().as_slice(),
            decade.resident
        );
        assert!(decade.deviation <= ORTHONORMAL);
        decades.push(decade);
    }
    decades
}

/// Asserts that the last decade, nine tenths of a run, used no more memory. The assertion fails in tests that run in parallel with others.
fn assert_no_memory_grew(decades: &[Decade]) {
    let resident: Vec<u64> = decades
        .iter()
        .filter_map(|decade| decade.resident)
        .collect();
    if let [.., before, after] = resident[..] {
        assert!(after <= before + OTHER_MEMORY, "{resident:?} kB");
    }
}

// A brick on a slope.

/// Default slip tolerance (m/s) of a world.
const SLIP_TOLERANCE: f64 = 1e-3;
const FRICTION: f64 = 0.5;

/// Index of the decade, up to 10⁵ steps, at whose end the brick is at rest. Dissipation damps its vertical motion at a rate of 49/s.
const RESTING: usize = 2;

/// Relative error of energies at rest: the last place.
const LAST_PLACE: f64 = 1e-15;

/// Speed (m/s) at rest. Balanced forces have a rounding error of 1e-15 of the weight, which acts for one step.
const AT_REST: f64 = 1e-12;

/// Observes a brick of 1 kg on a floor whose slope has this tangent, released slightly above its rest position.
fn decades_of_brick(slope: f64, steps: usize) -> Vec<Decade> {
    let skin = rubbing(1e6, 10.0, FRICTION);
    let brick = shapes::cuboid([0.2, 0.15, 0.1]).unwrap();
    let down = vector![slope, 0.0, -1.0].normalize();
    decades(&on_floor(brick, 0.0499, skin, &down), 1e-4, steps)
}

fn assert_rests(decades: &[Decade]) {
    let settled = &decades[RESTING];
    for decade in &decades[RESTING..] {
        let [low, high] = decade.energy;
        assert!(high - low <= LAST_PLACE * high, "{low} to {high} J");
        let moved = (decade.position() - settled.position()).amax();
        assert!(moved <= LAST_PLACE, "{moved:e} m");
        let speed = decade.state.bodies[0].velocity().norm();
        assert!(speed <= AT_REST, "{speed:e} m/s");
    }
}

#[test]
fn a_brick_on_a_level_floor_rests() {
    assert_rests(&decades_of_brick(0.0, SHORT));
}

#[test]
#[ignore = "ten million steps: two minutes"]
fn a_brick_on_a_level_floor_rests_for_ten_million_steps() {
    let decades = decades_of_brick(0.0, LONG);
    assert_rests(&decades);
    assert_no_memory_grew(&decades);
}

/// Tangent of the slope: a tenth of the friction coefficient.
const SLOPE: f64 = 0.05;

/// Relative tolerance of the creep, because the brick's sides also have friction at its rim, on a bevel as wide as its depth, 4e-4 of its
/// width.
const BEVEL: f64 = 1e-3;

/// Relative tolerance of a steady creep. Each step adds 1e-8 m to a position with a rounding error of 7e-18 m.
const STEADY: f64 = 1e-9;

/// Friction holds with the fraction r of its full value at the slip v_s·r/√(1 − r²). A brick on a slope creeps at this speed, which does
/// not change with time.
fn assert_creeps_as_its_friction_law_says(decades: &[Decade]) {
    let part = SLOPE / FRICTION;
    let by_hand = SLIP_TOLERANCE * part / (1.0 - part * part).sqrt();
    let creep = |pair: &[Decade]| {
        let time = pair[1].state.time - pair[0].state.time;
        (pair[1].position() - pair[0].position()) / time
    };
    let creeps: Vec<Vector3<f64>> = decades.windows(2).skip(RESTING - 1).map(creep).collect();
    for creep in &creeps {
        println!("creep {:?} m/s, closed form {by_hand:e}", creep.as_slice());
        assert!((creep.x / by_hand - 1.0).abs() <= BEVEL);
        assert!((creep - creeps[0]).amax() <= STEADY * by_hand);
        assert!(creep.y.abs().max(creep.z.abs()) <= STEADY * by_hand);
    }
    // The energy decreases monotonically.
    let energies: Vec<[f64; 2]> = decades.iter().map(|decade| decade.energy).collect();
    assert!(energies.windows(2).all(|pair| pair[1][1] < pair[0][0]));
}

#[test]
fn a_brick_on_a_slope_creeps_as_its_friction_law_says() {
    assert_creeps_as_its_friction_law_says(&decades_of_brick(SLOPE, SHORT));
}

#[test]
#[ignore = "ten million steps: three minutes"]
fn a_brick_on_a_slope_creeps_as_its_friction_law_says_for_ten_million_steps() {
    let decades = decades_of_brick(SLOPE, LONG);
    assert_creeps_as_its_friction_law_says(&decades);
    assert_no_memory_grew(&decades);
}

// A ball that bounces forever.

/// Height (m) that the ball falls.
const FALL: f64 = 0.05;

/// Oscillation of the energy, relative to the energy of the fall, at steps of 1 ms. It is of second order, and 3e-4 in the first thousands
/// of steps.
const SWING: f64 = 1e-3;

/// Largest sideways displacement (m), which is due to round-off only.
const ASIDE: f64 = 1e-9;

fn assert_bounces(decades: &[Decade]) {
    let start = GRAVITY * (0.1 + FALL);
    for decade in decades {
        let [low, high] = decade
            .energy
            .map(|energy| (energy - start) / (GRAVITY * FALL));
        assert!(-SWING <= low && high <= SWING, "{low:e} to {high:e}");
        let aside = decade.position().xy().amax();
        assert!(aside <= ASIDE, "{aside:e} m");
    }
}

fn decades_of_ball(steps: usize) -> Vec<Decade> {
    let ball = shapes::icosphere(0.1, 1).unwrap();
    let (skin, down) = (Material::elastic(2e4), -Vector3::z());
    decades(&on_floor(ball, 0.1 + FALL, skin, &down), 1e-3, steps)
}

#[test]
fn a_ball_bounces_with_the_energy_it_had() {
    assert_bounces(&decades_of_ball(SHORT));
}

#[test]
#[ignore = "ten million steps: a minute and a half"]
fn a_ball_bounces_with_the_energy_it_had_for_ten_million_steps() {
    let decades = decades_of_ball(LONG);
    assert_bounces(&decades);
    assert_no_memory_grew(&decades);
}
