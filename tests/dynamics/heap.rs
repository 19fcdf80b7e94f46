//! A heap of balls dropped into a box comes to rest. If friction holds the heap, it creeps according to the friction law. If the heap has
//! found a packing that needs no friction, it does not move at all.
//!
//! Run both forms by `cargo test --test dynamics heap:: -- --include-ignored --nocapture`, which prints the results.

use crate::scenes::GRAVITY;
use crate::support::scenes::Random;
use crate::support::worlds::{cuboid, fixed, icosphere, rubbing};
use hydroelastic::dynamics::{Body, BodyState, Mass, Material, Plan, State, World};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::sync::Arc;

/// Radius (m) and mass (kg) of a ball.
const RADIUS: f64 = 0.05;
const MASS: f64 = 0.1;

/// Distance (m) between neighboring balls before they fall, and largest offset (m) of a ball from its lattice position.
const SPACING: f64 = 0.12;
const OFF_PLACE: f64 = 8e-3;

/// Thickness and height (m) of the walls.
const WALL: f64 = 0.1;
const HEIGHT: f64 = 1.0;

/// Balls to drop into a box: `across` in a row, with equally many rows in a layer and equally many layers.
struct Heap {
    across: usize,
}

impl Heap {
    fn count(&self) -> usize {
        self.across.pow(3)
    }

    /// Returns the width (m) inside the box.
    fn width(&self) -> f64 {
        SPACING * self.across as f64
    }

    fn skin() -> Material {
        rubbing(1e5, 2.0, 0.3)
    }

    fn balls(&self) -> Vec<Body> {
        let mut random = Random::new(5);
        let shape = Arc::new(icosphere(RADIUS, 1));
        let ball = |index: usize| {
            let cell = [1, 2, 3].map(|power| index / self.across.pow(power - 1) % self.across);
            let place = Vector3::from(cell.map(|count| SPACING * (count as f64 + 0.5)));
            let middle = vector![self.width() / 2.0, self.width() / 2.0, 0.0];
            let place = place - middle + random.vector() * OFF_PLACE;
            let pose = Pose::from_rotation_vector(&random.rotation_vector(), place);
            let (name, mass) = (format!("ball {index}"), Mass::Total(MASS));
            let ball = Body::dynamic(&name, Arc::clone(&shape), Self::skin(), mass);
            ball.unwrap().with_pose(pose)
        };
        (0..self.count()).map(ball).collect()
    }

    /// Returns a floor and four walls, open at the top. The floor's top is z = 0.
    fn container(&self) -> [Body; 5] {
        let (outer, off) = (self.width() + 2.0 * WALL, self.width() / 2.0 + WALL / 2.0);
        let side = |name, lengths: [f64; 3], place| {
            let slab = cuboid(lengths);
            let side = fixed(name, slab, Self::skin());
            side.with_pose(Pose::from_translation(place))
        };
        let (along_x, along_y) = ([outer, WALL, HEIGHT], [WALL, outer, HEIGHT]);
        let middle = HEIGHT / 2.0;
        [
            side(
                "floor",
                [outer, outer, WALL],
                vector![0.0, 0.0, -WALL / 2.0],
            ),
            side("east", along_y, vector![off, 0.0, middle]),
            side("west", along_y, vector![-off, 0.0, middle]),
            side("north", along_x, vector![0.0, off, middle]),
            side("south", along_x, vector![0.0, -off, middle]),
        ]
    }

    fn world(&self, slip_tolerance: f64) -> World {
        let bodies = self.balls().into_iter().chain(self.container());
        let world = World::new(bodies.collect()).unwrap();
        let world = world.with_slip_tolerance(slip_tolerance).unwrap();
        world.with_gravity(vector![0.0, 0.0, -GRAVITY]).unwrap()
    }

    fn weight(&self) -> f64 {
        MASS * GRAVITY * self.count() as f64
    }

    fn is_inside(&self, ball: &BodyState) -> bool {
        let [x, y, z] = (*ball.position()).into();
        x.abs().max(y.abs()) < self.width() / 2.0 && z > 0.0 && z < HEIGHT
    }
}

/// Longest step (s), fraction of the stability limit, and number of steps between evaluations of the limit. A ball falls at 1 m/s, and
/// contacts stiffen within 10 ms.
const LONGEST: f64 = 8e-4;
const SAFETY: f64 = 0.5;
const STEPS: usize = 20;

/// Steps from a state for a time (s), within the stability limit of every state. Calls `see` with some states.
fn stepped(world: &World, mut state: State, time: f64, mut see: impl FnMut(&State)) -> State {
    let end = state.time + time;
    while state.time < end {
        let limit = world
            .largest_stable_step(&state)
            .unwrap()
            .unwrap_or(f64::INFINITY);
        let plan = Plan::new(LONGEST.min(SAFETY * limit), STEPS).unwrap();
        let mut rollout = world.rollout(&plan).with_state(state).unwrap();
        for _ in 0..STEPS {
            rollout.advance().unwrap();
        }
        state = rollout.state().clone();
        see(&state);
    }
    state
}

/// Largest energy gain in a part of a run, relative to the weight times a meter: round-off and the second-order oscillation.
const NO_GAIN: f64 = 1e-6;

/// Slip tolerances (m/s) while the balls fall and settle. With the first, friction holds the balls except for creep. With the second,
/// friction is too weak at their speeds to hold them, but slows them down.
const HELD: f64 = 5e-2;
const LOOSE: f64 = 2.0;

/// Returns the heap after a time (s). Asserts that the heap stays in its box and its energy never grows.
fn dropped(heap: &Heap, slip_tolerance: f64, time: f64) -> State {
    let world = heap.world(slip_tolerance);
    let mut before = f64::INFINITY;
    stepped(&world, world.initial_state(), time, |state| {
        let energy = world.diagnostics(state).unwrap().total_energy();
        let gain = (energy - before) / heap.weight();
        assert!(gain <= NO_GAIN, "{gain:e} m at {} s", state.time);
        before = energy;
        let mut balls = state.bodies[..heap.count()].iter();
        assert!(balls.all(|ball| heap.is_inside(ball)));
    })
}

/// Returns the largest speed (m/s) of a ball's center, or of its surface relative to the center.
fn fastest(state: &State) -> f64 {
    let speed = |body: &BodyState| {
        let twist = &body.twist;
        twist.linear.norm().max(RADIUS * twist.angular.norm())
    };
    state.bodies.iter().map(speed).fold(0.0, f64::max)
}

/// Time (s) until the balls creep according to a new slip tolerance, and duration (s) of the observation.
const TRANSIENT: f64 = 0.05;
const WATCHED: f64 = 0.05;

/// Observations of a heap.
struct Creep {
    /// Largest speed (m/s) as in [`fastest`].
    fastest: f64,
    /// Final kinetic energy (J).
    kinetic_energy: f64,
    /// Final force (N) on the box.
    force: Vector3<f64>,
}

impl Creep {
    fn of(heap: &Heap, rest: &State, slip_tolerance: f64) -> Self {
        let world = heap.world(slip_tolerance);
        let start = stepped(&world, rest.clone(), TRANSIENT, |_| {});
        let mut largest = 0.0_f64;
        let end = stepped(&world, start, WATCHED, |state| {
            largest = largest.max(fastest(state));
        });
        let contacts = world.contacts(&end).unwrap().into_iter();
        let on_box = contacts.filter(|contact| contact.bodies[1] >= heap.count());
        Self {
            fastest: largest,
            kinetic_energy: world.diagnostics(&end).unwrap().kinetic_energy,
            force: on_box.map(|contact| contact.wrench.on_b.force).sum(),
        }
    }
}

/// Slip tolerances (m/s) of the held heap.
const COARSE: f64 = 2e-2;
const FINE: f64 = 1e-2;

/// Relative deviation of creep from proportionality to the slip tolerance. The heap moves during the observation, which changes the load on
/// its friction.
const PROPORTIONAL: f64 = 0.05;

/// Relative deviation of the forces on the box from the weight. A creeping heap is nearly in equilibrium.
const BALANCED: f64 = 1e-3;

/// Root mean square of the balls' speeds, relative to the slip tolerance. Most balls are much slower than the fastest.
const SLOW: f64 = 0.2;

/// Drops the heap for a time (s), lets friction bring it to rest for another time (s), and then observes it.
///
/// Friction bears the fraction r < 1 of its full value at a slip of v_s·r/√(1 − r²). A heap that friction holds therefore creeps, with
/// speeds below the slip tolerance v_s and proportional to it. The speed of a sliding heap does not depend on v_s.
fn assert_comes_to_rest(across: usize, falling: f64, calming: f64) {
    let heap = Heap { across };
    let rest = dropped(&heap, HELD, falling);
    let rest = stepped(&heap.world(COARSE), rest, calming, |_| {});
    let [coarse, fine] =
        [COARSE, FINE].map(|tolerance| (tolerance, Creep::of(&heap, &rest, tolerance)));
    for (tolerance, creep) in [&coarse, &fine] {
        let (fastest, force) = (creep.fastest, creep.force / heap.weight());
        println!(
            "{} balls, slip tolerance {tolerance} m/s: at most {fastest:.2e} m/s, {:.1e} J kinetic, {:?} of the weight on the box",
            heap.count(),
            creep.kinetic_energy,
            force.as_slice()
        );
        assert!(fastest < *tolerance);
        let mass = MASS * heap.count() as f64;
        let mean_speed = (2.0 * creep.kinetic_energy / mass).sqrt();
        assert!(mean_speed < SLOW * tolerance, "{mean_speed:e} m/s");
        assert!((force + Vector3::z()).amax() <= BALANCED);
    }
    let ratio = coarse.1.fastest / fine.1.fastest;
    assert!(
        (ratio / (COARSE / FINE) - 1.0).abs() <= PROPORTIONAL,
        "{ratio}"
    );
}

#[test]
fn eight_balls_come_to_rest() {
    assert_comes_to_rest(2, 3.0, 0.3);
}

/// Speed (m/s) of a heap at rest, and largest displacement (m) of its balls during the observation. The observed speed after 12 s is
/// 9e-7 m/s.
const RESTING: f64 = 1e-5;
const UNMOVED: f64 = 1e-6;

/// If friction is too weak to hold the balls, they find a packing that needs no friction. They stay there, no matter how small the slip
/// tolerance is.
#[test]
#[ignore = "64 balls: minutes"]
fn sixty_four_balls_come_to_rest_and_stay() {
    let heap = Heap { across: 4 };
    let rest = dropped(&heap, LOOSE, 12.0);
    println!("64 balls after 12 s: at most {:.1e} m/s", fastest(&rest));
    assert!(fastest(&rest) < RESTING);
    for tolerance in [LOOSE, COARSE, FINE] {
        let world = heap.world(tolerance);
        let end = stepped(&world, rest.clone(), 1.0, |state| {
            assert!(fastest(state) < RESTING);
        });
        let moved = |(ball, at_rest): (&BodyState, &BodyState)| {
            (ball.position() - at_rest.position()).norm()
        };
        let balls = end.bodies.iter().zip(&rest.bodies).map(moved);
        let farthest = balls.fold(0.0, f64::max);
        println!("slip tolerance {tolerance} m/s: moved {farthest:.1e} m in 1 s");
        assert!(farthest < UNMOVED);
    }
}
