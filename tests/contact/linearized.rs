//! The linearized contact, propagated to dual numbers by the chain rule, against the generic pipeline and against differences.

use crate::support::moving::{COLUMNS, Scene, Wide, jacobian_of, numbers, seeds};
use crate::support::scenes::{Random, dented_ball, mixed_shapes, pair, random_pair};
use crate::support::worlds::{cuboid, dynamic, falling, fixed};
use hydroelastic::contact::{ContactWrench, Shape, SurfaceLaw};
use hydroelastic::dynamics::{Material, Plan, State, World};
use hydroelastic::gradient::{Experiment, FinalState, Outcome, Parameter, dual_wrench_jacobian};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{SVector, vector};
use num_dual::Dual2_64;

/// Rounding error of derivatives through slices and clips of generic pairs, relative to the largest entry.
const TWO_WAYS: f64 = 1e-10;

/// Rounding error of values that are rotated into the world in another order.
const SAME_VALUE: f64 = 1e-12;

/// Error of finite differences with the best of three step sizes.
const DIFFERENCES: f64 = 1e-6;
const STEPS: [f64; 3] = [1e-5, 1e-6, 1e-7];

/// Step sizes of finite differences at a kink, where the error is the step size times the jump of the second derivative.
const KINK_STEPS: [f64; 3] = [1e-6, 1e-7, 1e-8];

/// Error of trajectories. It is larger, because hundreds of steps amplify the rounding error of each step.
const TRAJECTORIES: f64 = 1e-11;

fn assert_same(closed: &ContactWrench<Wide>, whole: &ContactWrench<Wide>) -> f64 {
    let (actual, expected) = (numbers(closed), numbers(whole));
    let largest = expected.map(|number| number.re).amax();
    let error = (actual.map(|n| n.re) - expected.map(|n| n.re)).amax();
    assert!(error <= SAME_VALUE * largest, "{error:e} of {largest:e}");
    let (actual, expected) = (jacobian_of(closed), jacobian_of(whole));
    let error = (actual - expected).amax() / expected.amax();
    assert!(error <= TWO_WAYS, "{error:e}");
    error
}

/// Visits generic poses in contact.
fn for_scenes(count: usize, seed: u8, mut check: impl FnMut(&Scene, &mut Random)) {
    let (shapes, mut random) = (mixed_shapes(), Random::new(seed));
    let mut checked = 0;
    while checked < count {
        let scene = Scene::at_random(&random_pair(&shapes, &mut random), &mut random);
        if !scene.pair.surface().is_empty() {
            check(&scene, &mut random);
            checked += 1;
        }
    }
}

#[test]
fn wrenches_of_first_order_have_the_derivatives_of_the_generic_pipeline() {
    let mut worst = [0.0_f64; 2];
    for_scenes(200, 31, |scene, _| {
        let (pair, law, twists) = scene.changed(&seeds());
        let elastic = assert_same(&pair.wrench(), &pair.pipeline().wrench());
        let closed = pair.moving(law, twists).wrench();
        let through_clips = pair.moving(law, twists).pipeline().wrench();
        let moving = scene.pair.moving(scene.law(), scene.twists);
        let (_, by_duals) = dual_wrench_jacobian(&moving);
        let error = (by_duals - scene.linearized()).amax();
        assert!(error <= TWO_WAYS * by_duals.amax(), "{error:e}");
        let rubbing = assert_same(&closed, &through_clips);
        worst = [worst[0].max(elastic), worst[1].max(rubbing)];
    });
    println!("worst: elastic {:.1e}, rubbing {:.1e}", worst[0], worst[1]);
}

#[test]
fn derivatives_of_a_pair_in_motion_are_differences() {
    let mut worst = 0.0_f64;
    for_scenes(200, 32, |scene, random| {
        let (pair, law, twists) = scene.changed(&seeds());
        let by_inputs = jacobian_of(&pair.moving(law, twists).wrench());
        let direction = SVector::<f64, COLUMNS>::from_fn(|_, _| random.between(-1.0, 1.0));
        worst = worst.max(scene.error_along(&direction, &by_inputs, &STEPS));
        assert!(worst <= DIFFERENCES, "{worst:e}");
    });
    println!("worst: {worst:.1e}");
}

#[test]
fn changes_pushed_forward_and_covectors_pulled_back_are_products_with_the_jacobian() {
    for_scenes(20, 33, |scene, random| {
        let contact = scene.pair.moving(scene.law(), scene.twists).linearized();
        let jacobian = contact.jacobian();
        // Derivatives with respect to moduli are much smaller than the other derivatives. Changes relative to the size of each variable
        // make all columns matter.
        let change = SVector::<f64, COLUMNS>::from_fn(|column, _| {
            random.between(-1.0, 1.0) / jacobian.column(column).amax().max(f64::MIN_POSITIVE)
        });
        let covector = SVector::<f64, 12>::from_fn(|_, _| random.between(-1.0, 1.0));
        let error = (contact.pushforward(&change) - jacobian * change).amax();
        assert!(error <= SAME_VALUE * COLUMNS as f64, "{error:e}");
        let back = contact.pullback(&covector) - jacobian.tr_mul(&covector);
        for (column, error) in back.iter().enumerate() {
            let largest = jacobian.column(column).amax();
            assert!(error.abs() <= SAME_VALUE * largest, "{column}: {error:e}");
        }
    });
}

#[test]
fn contacts_at_generic_poses_have_no_kinks() {
    for_scenes(50, 34, |scene, _| {
        let contact = scene.pair.moving(scene.law(), scene.twists).linearized();
        assert!(!contact.kinks.is_any(), "{:?}", contact.kinks);
    });
}

/// Returns an ellipsoid that is thrown on a slab and is in contact for a part of the rollout.
fn thrown(skin: Material) -> World {
    let ball = Shape::new(shapes::ellipsoid([0.1, 0.11, 0.09], 1).unwrap());
    let slab = cuboid([1.0; 3]);
    let ball = dynamic("ball", ball, skin, 1.0);
    let slab = fixed("slab", slab, skin);
    falling(vec![
        ball.with_pose(Pose::from_translation(vector![0.05, 0.02, 0.1]))
            .with_velocity(vector![0.3, 0.1, -0.5])
            .with_angular_velocity(vector![1.0, 2.0, 0.5]),
        slab.with_pose(Pose::from_translation(vector![0.0, 0.0, -0.5])),
    ])
}

fn start() -> [Parameter; 4] {
    [
        Parameter::initial_orientation("ball"),
        Parameter::initial_position("ball"),
        Parameter::initial_angular_velocity("ball"),
        Parameter::initial_velocity("ball"),
    ]
}

/// Returns the derivative of the ball's final position along a direction. Second-order numbers force the contact through the generic
/// pipeline.
fn by_generic_pipeline(world: &World, direction: &SVector<f64, 12>, steps: usize) -> Vec<f64> {
    let lifted = world.lifted::<Dual2_64>();
    let mut start: State<Dual2_64> = lifted.initial_state();
    let seeds = direction.map(|slope| Dual2_64::new(0.0, slope, 0.0));
    let twist = |row| Twist::from_vector(&seeds.fixed_rows::<6>(row).into_owned());
    let ball = &mut start.bodies[0];
    ball.pose = ball.pose.moved_by(&twist(0));
    ball.twist.angular += twist(6).angular;
    ball.twist.linear += twist(6).linear;
    let plan = Plan::new(5e-4, steps).unwrap().recording_every(steps);
    let trajectory = lifted
        .rollout(&plan)
        .with_state(start)
        .unwrap()
        .run()
        .unwrap();
    let end = FinalState::of_body(world, "ball").unwrap().of(&trajectory);
    end.into_iter().map(|number| number.v1).collect()
}

#[test]
fn gradients_of_whole_trajectories_are_those_of_the_generic_pipeline() {
    let rubbing = Material::elastic(1e5)
        .with_dissipation(0.4)
        .with_friction(0.3);
    let mut random = Random::new(33);
    for skin in [Material::elastic(1e5), rubbing] {
        let (world, steps) = (thrown(skin), 300);
        let experiment = Experiment::new(&world, &Plan::new(5e-4, steps).unwrap());
        let outcome = FinalState::of_body(&world, "ball").unwrap();
        let jacobian = experiment.jacobian(&start(), &outcome).unwrap().jacobian;
        for _ in 0..3 {
            let direction = SVector::<f64, 12>::from_fn(|_, _| random.between(-1.0, 1.0));
            let product = &jacobian * direction;
            let expected = by_generic_pipeline(&world, &direction, steps);
            let expected = nalgebra::DVector::from_vec(expected);
            let error = (product - &expected).amax() / expected.amax();
            println!("{error:.1e}");
            assert!(error <= TRAJECTORIES, "{error:e}");
        }
    }
}

#[test]
fn many_numbers_take_several_passes_and_give_what_few_give() {
    let world = thrown(Material::elastic(1e5));
    let experiment = Experiment::new(&world, &Plan::new(5e-4, 100).unwrap());
    let outcome = FinalState::of_body(&world, "ball").unwrap();
    let value = nalgebra::DVector::from_vec(experiment.value(&outcome).unwrap());
    let alone = experiment.jacobian(&start()[3..], &outcome).unwrap();
    // The counts make 3, 12, 36, 96 and 99 parameters: one pass of each width, a full pass, and two passes.
    for count in [1, 4, 12, 32, 33] {
        let parameters = vec![start()[3].clone(); count];
        let many = experiment.jacobian(&parameters, &outcome).unwrap();
        assert_eq!(many.jacobian.ncols(), 3 * count);
        assert!((&many.value - &value).amax() <= SAME_VALUE * value.amax());
        for block in 0..count {
            let error = many.jacobian.columns(3 * block, 3) - &alone.jacobian;
            assert!(error.amax() <= TRAJECTORIES * alone.jacobian.amax());
        }
    }
    let empty = experiment.jacobian(&[], &outcome).unwrap();
    assert_eq!((empty.value, empty.jacobian.shape()), (value, (18, 0)));
}

/// A face of constant extent meets the contact surface in the same line as a face of the other body. Which face bounds a polygon is
/// arbitrary until the modulus of one body changes. The direction of friction jumps at this line, so friction has a kink there, and its
/// derivative is the mean of both sides.
#[test]
fn layers_of_equal_pressure_have_the_derivatives_of_differences_by_either_modulus() {
    let mut random = Random::new(33);
    let mut worst = [0.0_f64; 2];
    for extents in [[1.0, 0.5], [1.0, 0.3], [1.0, 0.7], [0.6, 1.0]] {
        let ball = Shape::new(dented_ball(1.0, 1, extents));
        for _ in 0..20 {
            let position = random.direction() * random.between(0.2, 1.2);
            let turned = Pose::from_rotation_vector(&random.rotation_vector(), position);
            let layers = pair((&ball, turned, 2.0), (&ball, Pose::identity(), 2.0));
            let scene = Scene::at_random(&layers, &mut random);
            let (pair, law, twists) = scene.changed(&seeds());
            let [elastic, in_motion] =
                [pair.wrench(), pair.moving(law, twists).wrench()].map(|w| jacobian_of(&w));
            for modulus in [24, 25] {
                let values = |step: f64| {
                    let mut changes = SVector::<f64, COLUMNS>::zeros();
                    changes[modulus] = step;
                    let (pair, law, twists) = scene.changed(&changes);
                    [pair.wrench(), pair.moving(law, twists).wrench()].map(|w| numbers(&w))
                };
                let ways = [&elastic, &in_motion];
                for (index, jacobian) in ways.into_iter().enumerate() {
                    let expected = jacobian.column(modulus);
                    let error = |step: f64| {
                        let [ahead, behind] = [step, -step].map(|step| values(step)[index]);
                        let difference = (ahead - behind) / (2.0 * step);
                        (difference - expected).norm() / expected.norm()
                    };
                    let error = KINK_STEPS
                        .map(error)
                        .into_iter()
                        .fold(f64::INFINITY, f64::min);
                    assert!(error <= DIFFERENCES, "{extents:?}, way {index}: {error:e}");
                    worst[index] = worst[index].max(error);
                }
            }
        }
    }
    println!("elastic {:.1e}, rubbing {:.1e}", worst[0], worst[1]);
}

/// A cube rests on a wide floor, pressed in by less than the coincidence margin on the scale of the floor.
#[test]
fn faces_that_are_hardly_pressed_in_do_not_just_touch() {
    /// Stiffness (N/m) of an area of 0.1 m × 0.1 m between two fields of 1e11 Pa over 0.05 m.
    const STIFFNESS: f64 = 1e10;
    let cube = cuboid([0.1; 3]);
    for (width, depth) in [
        (2.0, 9.81e-10),
        (20.0, 9.81e-10),
        (20.0, 1e-11),
        (2000.0, 1e-9),
    ] {
        let slab = cuboid([width, width, 0.1]);
        let pair = pair(
            (
                &cube,
                Pose::from_translation(vector![0.013, 0.021, 0.05 - depth]),
                1e11,
            ),
            (
                &slab,
                Pose::from_translation(vector![0.0, 0.0, -0.05]),
                1e11,
            ),
        );
        let law = SurfaceLaw::new(0.0, 0.0, 1e-3).unwrap();
        let in_motion = pair.moving(law, [Twist::zero(); 2]).linearized().by_poses[(5, 5)];
        let elastic = pair.linearized().by_poses[(5, 5)];
        for response in [in_motion, elastic] {
            // The facets of the contact's rim are as large as the depth.
            assert!(
                (response / -STIFFNESS - 1.0).abs() < 1e-6,
                "{width} {depth}: {response}"
            );
        }
    }
}
