//! Friction and dissipation of bodies whose sides are flush, exactly or up to round-off: derivatives of the wrench of moving bodies against
//! differences.

use crate::support::scenes::{Random, pair};
use crate::support::worlds::{at, cuboid, falling, fixed, rubbing};
use hydroelastic::contact::{ContactBody, ContactPair, Shape, SurfaceLaw};
use hydroelastic::dynamics::{Body, Mass, Plan, State, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{SMatrix, SVector, Vector3, vector};

/// Steps of differences (SI units; relative for the moduli).
const STEPS: [f64; 6] = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10];

/// Agreement, relative to a column's largest entry, at which two differences with neighboring steps count as the derivative.
const AGREEMENT: f64 = 5e-5;

/// Columns whose largest entry is below this fraction of the wrench (per SI unit) are round-off.
const NOTHING: f64 = 1e-6;

/// Number of columns: poses of A and B, their twists, moduli, dissipation and friction.
const COLUMNS: usize = 28;

/// Dissipation (s/m), friction, slip tolerance (m/s).
const LAW: [f64; 3] = [0.3, 0.4, 0.02];

struct Scene<'a> {
    pair: ContactPair<'a>,
    law: [f64; 3],
    twists: [Twist; 2],
}

impl Scene<'_> {
    fn law(&self) -> SurfaceLaw {
        let [dissipation, friction, slip_tolerance] = self.law;
        SurfaceLaw::new(dissipation, friction, slip_tolerance).unwrap()
    }

    /// Returns the Jacobian. The columns of the moduli are with respect to relative changes.
    fn jacobian(&self) -> SMatrix<f64, 12, COLUMNS> {
        let mut jacobian = self
            .pair
            .moving(self.law(), self.twists)
            .linearized()
            .jacobian();
        for (column, body) in [(24, self.pair.a()), (25, &self.pair.b().body().unwrap())] {
            jacobian.column_mut(column).scale_mut(body.modulus());
        }
        jacobian
    }

    fn after(&self, changes: &SVector<f64, COLUMNS>) -> SVector<f64, 12> {
        let twist = |row| Twist::from_vector(&changes.fixed_rows::<6>(row).into_owned());
        let body = |body: &ContactBody<'_>, number: usize| {
            let modulus = body.modulus() * (1.0 + changes[24 + number]);
            (body.pose().moved_by(&twist(6 * number)), modulus)
        };
        let ((pose_a, modulus_a), (pose_b, modulus_b)) = (
            body(self.pair.a(), 0),
            body(&self.pair.b().body().unwrap(), 1),
        );
        let moved = pair(
            (self.pair.a().shape(), pose_a, modulus_a),
            (self.pair.b().shape().unwrap(), pose_b, modulus_b),
        );
        let twists = [0, 1].map(|number| {
            let (twist, change) = (self.twists[number], twist(12 + 6 * number));
            Twist {
                angular: twist.angular + change.angular,
                linear: twist.linear + change.linear,
            }
        });
        let [dissipation, friction, slip_tolerance] = self.law;
        let law = SurfaceLaw::new(
            dissipation + changes[26],
            friction + changes[27],
            slip_tolerance,
        );
        let wrench = moved.moving(law.unwrap(), twists).wrench();
        let [a, b] = [wrench.on_a, wrench.on_b].map(|wrench| wrench.to_vector());
        SVector::from_fn(|row, _| if row < 6 { a[row] } else { b[row - 6] })
    }

    fn difference(&self, column: usize, step: f64) -> SVector<f64, 12> {
        let change = SVector::ith(column, step);
        (self.after(&change) - self.after(&-change)) / (2.0 * step)
    }

    /// Returns the smallest error of a column, relative to its largest entry, against two agreeing differences with neighboring steps.
    /// Returns `None` if no two differences agree.
    fn error(&self, derivative: &SVector<f64, 12>, column: usize) -> Option<f64> {
        let differences = STEPS.map(|step| self.difference(column, step));
        let agree = |d: &&[SVector<f64, 12>]| (d[0] - d[1]).amax() <= AGREEMENT * d[0].amax();
        let settled = differences.windows(2).filter(agree);
        settled
            .map(|d| (derivative - d[0]).amax().min((derivative - d[1]).amax()) / d[0].amax())
            .reduce(f64::min)
    }
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
        let jacobian = scene.jacobian();
        let force = scene.after(&SVector::zeros()).amax();
        for column in columns {
            let derivative = jacobian.column(column).into_owned();
            if derivative.amax() <= NOTHING * force {
                continue;
            }
            let Some(error) = scene.error(&derivative, column) else {
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
                let scene = Scene {
                    pair: pair.unwrap(),
                    law: LAW,
                    twists: [lower, lower + 1].map(|index| state.bodies[index].twist),
                };
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
        tally.add(&Scene { pair, law, twists }, columns.iter().copied());
    }
    tally.assert_right(&format!("{poses} poses, law {law:?}, spin {spin}"));
}

const ALL: [usize; COLUMNS] = {
    let mut all = [0; COLUMNS];
    let mut column = 0;
    while column < COLUMNS {
        all[column] = column;
        column += 1;
    }
    all
};

/// Columns of the upper box's rotation about z and translation along y.
const ACROSS: [usize; 2] = [8, 10];

#[test]
fn derivatives_at_poses_flush_up_to_round_off_are_those_of_differences() {
    let whole = cuboid(BOX);
    let layers = Shape::new(shapes::distance_cuboid(BOX).unwrap());
    for spin in [0.0, 3.0] {
        tally_near_flush(&whole, LAW, spin, 4_000, &ACROSS);
        for shape in [&whole, &layers] {
            tally_near_flush(shape, LAW, spin, 50, &ALL);
        }
    }
}

/// Half a polygon lies on either side of each of two flush sides. Either both sides cut it, or neither.
#[test]
fn elastic_derivatives_at_poses_flush_up_to_round_off_are_those_of_differences() {
    let shape = cuboid(BOX);
    tally_near_flush(&shape, [0.0, 0.0, 0.02], 0.0, 1_000, &ACROSS);
}
