//! Tests that compare derivatives in closed form with dual numbers, for random trees.

use super::*;
use crate::dynamics::BodyState;
use crate::dynamics::joint::{Joint, JointPosition};
use crate::scalar::{DenseDual, SplitMix64};
use crate::spatial::{MassProperties, Twist, rotation_from_vector, turn_from_real};
use nalgebra::{DVector, Matrix3, Unit, Vector3, Vector6};

/// Largest number of columns of a forest.
const MOST_COLUMNS: usize = 24;

/// Number of random forests.
const FORESTS: usize = 60;

/// Relative tolerance for the round-off of sums over a tree.
const ROUND_OFF: f64 = 1e-13;

/// Relative tolerance of linear solves with a mass matrix. The condition number amplifies the round-off.
const SOLUTION: f64 = 1e-10;

type Dual = DenseDual<MOST_COLUMNS>;

/// Random numbers between −1 and 1.
struct Random(SplitMix64);

impl Random {
    fn number(&mut self) -> f64 {
        4.0 * self.0.next() - 3.0
    }

    /// Random index below a count.
    fn index(&mut self, count: usize) -> usize {
        let number = self.number().abs() * count as f64;
        (1..count).filter(|&index| number >= index as f64).count()
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.number())
    }

    fn pose(&mut self) -> Pose {
        Pose::from_rotation_vector(&(self.vector() * 2.0), self.vector())
    }

    fn inertia(&mut self) -> Inertia {
        let axes = rotation_from_vector(&self.vector());
        let moments = Vector3::from_fn(|_, _| 1.5 + 0.4 * self.number());
        Inertia::new(&MassProperties {
            mass: 1.5 + self.number(),
            center_of_mass: self.vector() * 0.3,
            inertia: axes * Matrix3::from_diagonal(&moments) * axes.transpose() * 0.1,
        })
    }

    fn kind(&mut self, is_root: bool) -> JointKind {
        let axis = Unit::new_normalize(self.vector());
        match self.index(5) {
            0 if is_root => JointKind::Free,
            0 => JointKind::Fixed,
            1 => JointKind::Ball,
            2 => JointKind::Prismatic(axis),
            _ => JointKind::Revolute(axis),
        }
    }

    fn position(&mut self, kind: &JointKind) -> JointPosition {
        match kind {
            JointKind::Free => JointPosition::Pose(self.pose()),
            JointKind::Ball => JointPosition::Rotation(rotation_from_vector(&self.vector())),
            JointKind::Revolute(_) | JointKind::Prismatic(_) => {
                JointPosition::Scalar(self.number())
            }
            JointKind::Fixed => JointPosition::Fixed,
        }
    }

    /// Forest of up to seven links. The parent of some links is a moving neighbor.
    fn forest(&mut self) -> Multibody {
        let mut links = Vec::new();
        let mut width = 0;
        for index in 0..7 {
            let is_root = index == 0 || self.number() > 0.7;
            let kind = self.kind(is_root);
            if width + kind.width() > MOST_COLUMNS {
                break;
            }
            width += kind.width();
            let parent = match kind {
                JointKind::Free => Parent::World,
                _ if is_root && self.number() > 0.0 => Parent::Neighbor(0),
                _ if is_root => Parent::World,
                _ => Parent::Link(self.index(index)),
            };
            let mut joint = Joint::fixed("")
                .with_armature(self.number().abs())
                .with_origin(self.pose());
            joint.kind = kind;
            links.push((self.inertia(), joint, parent));
        }
        let links = links.iter().enumerate();
        Multibody::new(
            links
                .map(|(body, (inertia, joint, parent))| {
                    Link::new(body, *inertia, (joint, *joint.law()), *parent)
                })
                .collect(),
            &[0],
        )
    }

    fn coordinates(&mut self, forest: &Multibody) -> Coordinates {
        Coordinates {
            positions: forest
                .links
                .iter()
                .map(|link| self.position(&link.kind))
                .collect(),
            velocities: self.numbers(forest.width()),
            multipliers: zeros(0),
        }
    }

    fn numbers(&mut self, count: usize) -> DVector<f64> {
        DVector::from_fn(count, |_, _| self.number())
    }

    fn wrenches(&mut self, count: usize) -> Vec<Vector6<f64>> {
        (0..count)
            .map(|_| Vector6::from_fn(|_, _| self.number()))
            .collect()
    }

    fn neighbor(&mut self) -> BodyState {
        let twist = Twist {
            angular: self.vector(),
            linear: self.vector(),
        };
        BodyState {
            pose: self.pose(),
            twist,
        }
    }
}

fn seeded(values: &DVector<f64>) -> DVector<Dual> {
    DVector::from_fn(values.len(), |i, _| Dual::variable(values[i], i))
}

fn constant(values: &DVector<f64>) -> DVector<Dual> {
    values.map(lift)
}

fn lifted(positions: &[JointPosition]) -> Vec<JointPosition<Dual>> {
    positions.iter().map(JointPosition::lifted).collect()
}

/// Derivatives of numbers with respect to the seeds.
fn jacobian(numbers: &DVector<Dual>) -> DMatrix<f64> {
    DMatrix::from_fn(numbers.len(), numbers.len(), |row, column| {
        numbers[row].eps[column]
    })
}

fn assert_close(found: &DMatrix<f64>, expected: &DMatrix<f64>, claim: &str) {
    let error = (found - expected).amax() / (1.0 + expected.amax());
    assert!(error < ROUND_OFF, "{claim}: {error:e}");
}

/// Direction of differentiation.
#[derive(Debug, Clone, Copy)]
enum By {
    StageVelocities,
    Positions,
    Velocities,
}

/// Calls a check for random forests, states and directions, with the kinematics in `f64` and in dual numbers.
fn for_all(
    mut check: impl FnMut(
        &mut Random,
        &Multibody,
        (&Kinematics, &Directions),
        &Kinematics<Dual>,
        f64,
        By,
    ),
) {
    let random = &mut Random(SplitMix64::default());
    for _ in 0..FORESTS {
        let forest = random.forest();
        let dual_forest = forest.lifted::<Dual>();
        let start = random.coordinates(&forest);
        let neighbor = random.neighbor();
        let dual_neighbor = [neighbor.lifted()];
        let duration = 0.3;
        let Coordinates {
            positions,
            velocities,
            ..
        } = &start;
        let zero = DVector::zeros(forest.width());
        for by in [By::StageVelocities, By::Positions, By::Velocities] {
            let (dual_velocities, displacement) = match by {
                By::StageVelocities => (
                    seeded(velocities),
                    seeded(velocities) * lift::<Dual>(duration),
                ),
                By::Positions => (constant(velocities), seeded(&zero)),
                By::Velocities => (seeded(velocities), constant(&zero)),
            };
            let dual_positions = dual_forest.displaced(&lifted(positions), &displacement);
            let dual = dual_forest.kinematics(
                Coordinates {
                    positions: dual_positions,
                    velocities: dual_velocities,
                    multipliers: zeros(0),
                },
                &dual_neighbor,
            );
            let real_displacement = displacement.map(crate::scalar::real_part);
            let real_positions = forest.displaced(positions, &real_displacement);
            let kinematics = forest.kinematics(
                Coordinates {
                    positions: real_positions,
                    velocities: velocities.clone(),
                    multipliers: zeros(0),
                },
                &[neighbor],
            );
            let (directions, tau) = match by {
                By::StageVelocities => (forest.stage_directions(&kinematics, duration), duration),
                By::Positions => (kinematics.position_directions(duration), duration),
                By::Velocities => (kinematics.velocity_directions(), 0.0),
            };
            check(random, &forest, (&kinematics, &directions), &dual, tau, by);
        }
    }
}

#[test]
fn derivatives_of_momenta_agree_with_dual_numbers() {
    for_all(|_, forest, (kinematics, directions), dual, duration, by| {
        let found = forest.assembled(&forest.momentum_slopes(kinematics, directions));
        let momenta = forest.lifted::<Dual>().projected_momenta(dual, duration);
        assert_close(&found, &jacobian(&momenta), &format!("{by:?}"));
    });
}

#[test]
fn derivatives_of_forces_agree_with_dual_numbers() {
    for_all(|random, forest, (kinematics, directions), dual, _, by| {
        let wrenches = random.wrenches(forest.links.len());
        let mut slopes: Vec<_> = forest
            .trees
            .iter()
            .map(|columns| DMatrix::zeros(columns.len(), columns.len()))
            .collect();
        forest.add_force_slopes(&mut slopes, (kinematics, directions), &wrenches, 1.0);
        let found = forest.assembled(&slopes);
        let dual_wrenches: Vec<_> = wrenches
            .iter()
            .map(|wrench| wrench.map(lift::<Dual>))
            .collect();
        let forces = forest
            .lifted::<Dual>()
            .generalized_forces(dual, &dual_wrenches);
        assert_close(&found, &jacobian(&forces), &format!("{by:?}"));
    });
}

#[test]
fn derivatives_of_inverse_dynamics_agree_with_dual_numbers() {
    for_all(|random, forest, (kinematics, _), dual, _, by| {
        let gravity = random.vector();
        let generalized = random.numbers(forest.width());
        let accelerations = forest.accelerations(kinematics, generalized.clone(), &gravity);
        let [by_positions, by_velocities] =
            forest.inverse_dynamics_slopes(kinematics, &accelerations);
        let found = match by {
            By::StageVelocities => return,
            By::Positions => by_positions,
            By::Velocities => by_velocities,
        };
        let forest = forest.lifted::<Dual>();
        let accelerations =
            forest.accelerations(dual, constant(&generalized), &gravity.map(lift::<Dual>));
        let forces = forest.inverse_dynamics(dual, &accelerations);
        assert_close(&found, &jacobian(&forces), &format!("{by:?}"));
    });
}

#[test]
fn motions_of_links_agree_with_dual_numbers() {
    for_all(|_, forest, (kinematics, directions), dual, _, by| {
        for (link, state) in dual.states.iter().take(forest.links.len()).enumerate() {
            let center = state
                .pose
                .transformed_constant(&forest.links[link].inertia.center_of_mass);
            let turn = turn_from_real(state.pose.rotation());
            let twist = state.twist.to_vector();
            let mut expected = [
                DMatrix::zeros(6, forest.width()),
                DMatrix::zeros(6, forest.width()),
            ];
            for column in 0..forest.width() {
                for row in 0..3 {
                    expected[0][(row, column)] = turn[row].eps[column];
                    expected[0][(row + 3, column)] = center[row].eps[column];
                }
                for row in 0..6 {
                    expected[1][(row, column)] = twist[row].eps[column];
                }
            }
            let mut found = [
                DMatrix::zeros(6, forest.width()),
                DMatrix::zeros(6, forest.width()),
            ];
            for motion in forest.body_columns(kinematics, directions, link) {
                found[0].set_column(motion.column, &motion.displacement);
                found[1].set_column(motion.column, &motion.velocity);
            }
            for (found, expected) in found.iter().zip(&expected) {
                assert_close(found, expected, &format!("{by:?}"));
            }
        }
    });
}

/// Random trees, at rest or in motion, with a moving neighbor.
fn random_forest(random: &mut Random) -> (Multibody, Kinematics) {
    let forest = random.forest();
    let coordinates = random.coordinates(&forest);
    let neighbor = random.neighbor();
    let kinematics = forest.kinematics(coordinates, &[neighbor]);
    (forest, kinematics)
}

#[test]
fn the_mass_matrix_is_the_derivative_of_the_momenta_and_its_factors_invert_it() {
    let random = &mut Random(SplitMix64::default());
    for _ in 0..FORESTS {
        let (forest, kinematics) = random_forest(random);
        let directions = kinematics.velocity_directions();
        let expected = forest.assembled(&forest.momentum_slopes(&kinematics, &directions));
        let mass = forest.assembled(&forest.mass_matrices(&kinematics));
        assert_close(&mass, &expected, "mass matrix");
        let velocities = random.numbers(forest.width());
        let factors = forest.mass_factors(&kinematics);
        let error = (factors.velocities(&mass * &velocities) - &velocities).amax();
        assert!(error < SOLUTION, "{error:e}");
        assert_eq!(forest.positive_mass_factors(&kinematics).err(), None);
    }
}

/// Chain of links on revolute joints about axes through the origin. The flag of a link is true if the link has mass.
fn chain(links: &[(Vector3<f64>, bool)], armature: f64) -> (Multibody, Kinematics) {
    let random = &mut Random(SplitMix64::default());
    let inertia = random.inertia();
    let links: Vec<_> = links
        .iter()
        .map(|(axis, has_mass)| {
            let mass = if *has_mass { inertia.mass } else { 0.0 };
            let joint = Joint::revolute("", Unit::new_normalize(*axis)).with_armature(armature);
            (Inertia { mass, ..inertia }, joint)
        })
        .collect();
    let links = links.iter().enumerate().map(|(body, (inertia, joint))| {
        let parent = body.checked_sub(1).map_or(Parent::World, Parent::Link);
        Link::new(body, *inertia, (joint, *joint.law()), parent)
    });
    let chain = Multibody::new(links.collect(), &[]);
    let positions = vec![JointPosition::Scalar(0.0); chain.links.len()];
    let velocities = DVector::zeros(chain.width());
    let coordinates = Coordinates {
        positions,
        velocities,
        multipliers: zeros(0),
    };
    let kinematics = chain.kinematics(coordinates, &[]);
    (chain, kinematics)
}

#[test]
fn a_joint_that_moves_no_inertia_is_detected() {
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
    let tilted = x + y * 0.1 + z * 0.3;
    for (links, expected) in [
        (vec![(x, true), (y, false)], Some(1)),
        (vec![(x, false), (y, false)], Some(1)),
        // The two axes coincide, so the joint of the massless link moves no inertia.
        (vec![(x, false), (x, true)], Some(0)),
        (vec![(tilted, false), (tilted, true)], Some(0)),
        (vec![(x, false), (y, true)], None),
        (vec![(x, false), (y, false), (z, true)], None),
        (vec![(x, true), (x, true)], None),
    ] {
        let (forest, kinematics) = chain(&links, 0.0);
        assert_eq!(
            forest.positive_mass_factors(&kinematics).err(),
            expected,
            "{links:?}"
        );
        let (forest, kinematics) = chain(&links, 1e-3);
        assert_eq!(
            forest.positive_mass_factors(&kinematics).err(),
            None,
            "{links:?}"
        );
    }
}

#[test]
fn the_mass_matrix_gives_the_kinetic_energy_and_forces_their_power() {
    let random = &mut Random(SplitMix64::default());
    for _ in 0..FORESTS {
        let forest = random.forest();
        let coordinates = random.coordinates(&forest);
        let at_rest = BodyState {
            twist: Twist::zero(),
            ..random.neighbor()
        };
        let kinematics = forest.kinematics(coordinates, &[at_rest]);
        let velocities = kinematics.velocities();
        let mass = forest.assembled(&forest.mass_matrices(&kinematics));
        let found = velocities.dot(&(&mass * velocities));
        let links = forest.links.iter().zip(&kinematics.states);
        let mut expected: f64 = links
            .map(|(link, state)| link.inertia.momentum(state).dot(&state.twist.to_vector()))
            .sum();
        for link in &forest.links {
            expected += link
                .columns
                .clone()
                .map(|c| link.law.armature * velocities[c] * velocities[c])
                .sum::<f64>();
        }
        assert!(
            (found - expected).abs() < ROUND_OFF * (1.0 + expected),
            "{found} {expected}"
        );
        let wrenches = random.wrenches(forest.links.len());
        let power = forest
            .generalized_forces(&kinematics, &wrenches)
            .dot(velocities);
        let states = wrenches.iter().zip(&kinematics.states);
        let expected: f64 = states
            .map(|(wrench, state)| wrench.dot(&state.twist.to_vector()))
            .sum();
        assert!(
            (power - expected).abs() < ROUND_OFF * 100.0,
            "{power} {expected}"
        );
    }
}
