//! Friction and dissipation of bodies whose sides are flush, exactly or up to round-off: derivatives of the wrench of moving bodies against
//! differences.

use crate::support::moving::{COLUMNS, Scene};
use crate::support::scenes::{Random, pair};
use crate::support::worlds::{at, cuboid, falling, fixed, rubbing};
use hydroelastic::contact::{ContactPair, Shape};
use hydroelastic::dynamics::{Body, Mass, Plan, State, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{SVector, Vector3, vector};

/// Steps of differences (SI units; relative for the moduli).
const STEPS: [f64; 6] = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];

/// Agreement, relative to a column's largest entry, at which two differences with neighboring steps count as the derivative.
const AGREEMENT: f64 = 5e-5;

/// Columns whose largest entry is below this fraction of the wrench (per SI unit) are round-off.
const NOTHING: f64 = 1e-6;

/// Dissipation (s/m), friction, slip tolerance (m/s).
const LAW: [f64; 3] = [0.3, 0.4, 0.02];

fn scene<'a>(pair: &ContactPair<'a>, law: [f64; 3], twists: [Twist; 2]) -> Scene<'a> {
    let [dissipation, friction, slip_tolerance] = law;
    Scene {
        pair: *pair,
        twists,
        dissipation,
        friction,
        slip_tolerance,
        missed: 0.0,
    }
}

/// Returns the unit of a column: moduli change relative to themselves.
fn unit(scene: &Scene, column: usize) -> f64 {
    match column {
        24 => scene.pair.a().modulus(),
        25 => scene.pair.b().modulus().unwrap(),
        _ => 1.0,
    }
}

/// Returns the smallest error of a column, relative to its largest entry, against two agreeing differences with neighboring steps.
/// Returns `None` if no two differences agree.
fn error(scene: &Scene, derivative: &SVector<f64, 12>, column: usize) -> Option<f64> {
    let differences = STEPS.map(|step| {
        let change = SVector::ith(column, step * unit(scene, column));
        (scene.wrenches(&change) - scene.wrenches(&-change)) / (2.0 * step)
    });
    let agree = |d: &&[SVector<f64, 12>]| (d[0] - d[1]).amax() <= AGREEMENT * d[0].amax();
    let settled = differences.windows(2).filter(agree);
    settled
        .map(|d| (derivative - d[0]).amax().min((derivative - d[1]).amax()) / d[0].amax())
        .reduce(f64::min)
}

/// Errors, relative to a column's largest entry, above which a derivative counts as off and as wrong.
const OFF: f64 = 1e-4;
const WRONG: f64 = 1e-2;

/// One of this many derivatives may be off, because differences that agree to a fraction of the tolerance may themselves be off by the
/// tolerance.
const RARE: usize = 1_000;

/// Smallest fraction of the nonzero derivatives whose differences must agree at two steps.
const SETTLED: f64 = 0.9;

/// Counts of comparisons.
#[derive(Default, Debug)]
struct Tally {
    compared: usize,
    unsettled: usize,
    off: usize,
    wrong: usize,
    worst: f64,
}

impl Tally {
    fn add(&mut self, scene: &Scene, columns: impl Iterator<Item = usize>) {
        let jacobian = scene.linearized();
        let force = scene.wrenches(&SVector::zeros()).amax();
        for column in columns {
            let derivative = jacobian.column(column) * unit(scene, column);
            if derivative.amax() <= NOTHING * force {
                continue;
            }
            let Some(error) = error(scene, &derivative, column) else {
                self.unsettled += 1;
                continue;
            };
            self.compared += 1;
            self.worst = self.worst.max(error);
            self.off += usize::from(error > OFF);
            self.wrong += usize::from(error > WRONG);
        }
    }

    fn assert_right(&self, what: &str) {
        println!("{what}: {self:?}");
        let all = self.compared + self.unsettled;
        assert!(self.compared as f64 >= SETTLED * all as f64, "{what}");
        assert_eq!(self.wrong, 0, "{what}");
        assert!(self.off * RARE <= self.compared, "{what}");
    }
}

const BOX: [f64; 3] = [0.2, 0.2, 0.1];

/// Returns boxes on top of each other that slide along a floor.
fn stack(count: usize) -> World {
    let [dissipation, friction, slip_tolerance] = LAW;
    let skin = |modulus| rubbing(modulus, dissipation, friction);
    let floor = cuboid([2.0, 2.0, 0.2]);
    let floor = fixed("floor", floor, skin(2e5));
    let mut bodies = vec![floor.with_pose(at(0.0, 0.0, -0.1))];
    for number in 0..count {
        let (part, shape) = (number as f64, cuboid(BOX));
        let mass = Mass::Total(1.0 - 0.5 * part / (count - 1) as f64);
        let body = Body::dynamic(
            &number.to_string(),
            shape,
            skin(1e5 * (1.0 + 0.3 * part)),
            mass,
        );
        let place = at(0.0, 0.0, 0.0495 + 0.0995 * part);
        bodies.push(
            body.unwrap()
                .with_pose(place)
                .with_velocity(vector![0.5, 0.0, 0.0]),
        );
    }
    let heavy = falling(bodies);
    heavy.with_slip_tolerance(slip_tolerance).unwrap()
}

fn states(world: &World, steps: usize) -> Vec<State> {
    let rollout = world.rollout(&Plan::new(2e-4, steps).unwrap());
    rollout.run().unwrap().states().to_vec()
}

#[test]
fn derivatives_in_the_states_of_sliding_stacks_are_those_of_differences() {
    let mut tally = Tally::default();
    for (count, steps) in [(2, 500), (5, 60)] {
        let world = stack(count);
        for state in states(&world, steps).iter().step_by(5) {
            for lower in 0..count {
                let name = |index: usize| world.bodies()[index].name();
                let pair = world.contact_between(state, name(lower), name(lower + 1));
                let twists = [lower, lower + 1].map(|index| state.bodies[index].twist);
                let scene = scene(&pair.unwrap(), LAW, twists);
                if scene.pair.wrench().on_a.force != Vector3::zeros() {
                    tally.add(&scene, 0..COLUMNS);
                }
            }
        }
    }
    tally.assert_right("states of stacks");
}

/// Compares poses of one box on another, flush up to round-off except for a pitch. The velocities are a slide and a spin (rad/s) about the
/// vertical.
fn tally_near_flush(shape: &Shape, law: [f64; 3], spin: f64, poses: usize, columns: &[usize]) {
    let (mut random, mut tally) = (Random::new(97), Tally::default());
    for _ in 0..poses {
        let round_off = 10_f64.powf(random.between(-14.5, -12.5));
        let scale = vector![round_off, 1e-4, round_off];
        let turn = random.vector().component_mul(&scale);
        let scale = vector![1e-5, 0.1 * round_off, 2e-4];
        let aside = random.vector().component_mul(&scale);
        let place = Pose::from_rotation_vector(&turn, aside + vector![0.0, 0.0, 0.0995]);
        let twists = [[0.49, 0.0], [0.5, spin]].map(|[along, spin]| Twist {
            angular: vector![0.0, 0.0, spin],
            linear: vector![along, 0.0, 0.0],
        });
        let pair = pair((shape, Pose::identity(), 1e5), (shape, place, 1.3e5));
        tally.add(&scene(&pair, law, twists), columns.iter().copied());
    }
    tally.assert_right(&format!("{poses} poses, law {law:?}, spin {spin}"));
}

/// Columns of the upper box's rotation about z and translation along y.
const ACROSS: [usize; 2] = [8, 10];

#[test]
fn derivatives_at_poses_flush_up_to_round_off_are_those_of_differences() {
    let whole = cuboid(BOX);
    let layers = Shape::new(shapes::distance_cuboid(BOX).unwrap());
    let all: Vec<usize> = (0..COLUMNS).collect();
    for spin in [0.0, 3.0] {
        tally_near_flush(&whole, LAW, spin, 4_000, &ACROSS);
        for shape in [&whole, &layers] {
            tally_near_flush(shape, LAW, spin, 50, &all);
        }
    }
}

/// Half a polygon lies on either side of each of two flush sides. Either both sides cut it, or neither.
#[test]
fn elastic_derivatives_at_poses_flush_up_to_round_off_are_those_of_differences() {
    let shape = cuboid(BOX);
    tally_near_flush(&shape, [0.0, 0.0, 0.02], 0.0, 1_000, &ACROSS);
}
