//! Wrenches about other points, in other axes, and as sums.

use crate::samples_and_tolerances::ROUND_OFF;
use hydroelastic::spatial::{Wrench, rotation_from_vector};
use nalgebra::{Vector6, vector};

#[test]
fn wrench_of_a_force_at_a_point_has_the_torque_of_its_arm() {
    let (force, p_oq) = (vector![1.0, -2.0, 0.5], vector![0.3, 0.1, -0.7]);
    let wrench = Wrench {
        torque: p_oq.cross(&force),
        force,
    };
    // About the point of application, the torque is zero.
    let there = wrench.about(&p_oq);
    assert!(there.torque.amax() <= ROUND_OFF);
    assert_eq!(there.force, force);
    let offset = vector![2.0, 1.0, -1.0];
    let elsewhere = wrench.about(&offset);
    assert!((elsewhere.torque - (p_oq - offset).cross(&force)).amax() <= ROUND_OFF);
    let back = elsewhere.about(&-offset);
    assert!((back.torque - wrench.torque).amax() <= ROUND_OFF);
}

#[test]
fn wrench_power_is_the_same_in_all_axes_and_about_all_points() {
    let wrench = Wrench {
        torque: vector![0.3, 0.2, -1.0],
        force: vector![1.0, -2.0, 0.5],
    };
    let (angular, linear) = (vector![0.5, 0.1, 0.9], vector![-1.0, 0.4, 0.3]);
    let power: f64 = wrench.torque.dot(&angular) + wrench.force.dot(&linear);
    let offset = vector![0.2, 0.7, -0.5];
    let moved = wrench.about(&offset);
    let velocity_there = linear + angular.cross(&offset);
    let power_there: f64 = moved.torque.dot(&angular) + moved.force.dot(&velocity_there);
    assert!((power_there - power).abs() <= ROUND_OFF);
    let rotation = rotation_from_vector(&vector![1.0, 0.3, -0.4]);
    let turned = wrench.rotated(&rotation);
    let power_turned: f64 =
        turned.torque.dot(&(rotation * angular)) + turned.force.dot(&(rotation * linear));
    assert!((power_turned - power).abs() <= ROUND_OFF);
}

#[test]
fn wrenches_add_and_negate_by_components() {
    let a = Wrench {
        torque: vector![1.0, 2.0, 3.0],
        force: vector![4.0, 5.0, 6.0],
    };
    let b = Wrench {
        torque: vector![10.0, 20.0, 30.0],
        force: vector![40.0, 50.0, 60.0],
    };
    assert_eq!(
        (a + b).to_vector(),
        Vector6::new(11.0, 22.0, 33.0, 44.0, 55.0, 66.0)
    );
    let mut sum = Wrench::zero();
    sum += a;
    assert_eq!((sum + -a).to_vector(), Vector6::zeros());
}
