//! Clearance between two bodies along a motion.

use super::{Body, BodyShape, Model, State, Trajectory, WorldError};
use crate::contact::{Clearance, ContactBody, ContactPair, Partner, PartnerShape, Shape};
use crate::scalar::{DenseDual, Scalar, lift, real_part};
use crate::spatial::{Pose, Twist, skew};
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;
use std::sync::Arc;

/// Number of bisections of the interval between two recorded states. The error of the time is then round-off.
const BISECTIONS: usize = 60;

/// Number of Newton steps that make an interpolated rotation orthonormal. Each step squares the deviation.
const NEWTON_STEPS: usize = 3;

/// Two bodies whose clearance is evaluated at states of a world. Shapes, moduli and centers of mass are constants.
#[derive(Debug, Clone)]
pub(crate) struct PairClearance {
    /// Indices of the bodies. A is compliant with a mesh.
    bodies: [usize; 2],
    shape_a: Arc<Shape>,
    shape_b: BodyShape,
    /// Moduli (Pa).
    moduli: [f64; 2],
    /// Centers of mass (m) in the body frames.
    centers: [Vector3<f64>; 2],
}

/// First contact of two bodies along a trajectory.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Approach<T> {
    /// Time (s) at which the bodies touch first.
    Touching(T),
    /// Least clearance (m) of bodies that are apart at all recorded times, and the index of its state.
    Apart(T, usize),
}

/// Motion of two bodies between two recorded states.
struct Path<'t, T> {
    pair: &'t PairClearance,
    /// Poses at both times, and twists of the origins multiplied by the duration between them.
    ends: [[(Pose<T>, Twist<T>); 2]; 2],
}

impl PairClearance {
    /// Creates the pair of two named bodies.
    ///
    /// # Errors
    /// - If one of the names is unknown, or both are the same.
    /// - If neither body is compliant with a mesh, or one has no shape.
    pub fn between(model: &Model, names: [&str; 2]) -> Result<Self, WorldError> {
        let [first, second] = [model.index_of(names[0])?, model.index_of(names[1])?];
        if first == second {
            return Err(WorldError::SameBody(names[0].to_owned()));
        }
        let shape_of = |index: usize| &model.bodies[index].shape;
        let in_order = [[first, second], [second, first]].into_iter();
        let mut pairs = in_order.filter_map(|[a, b]| {
            let has_shape = shape_of(b).partner().is_some();
            Some(([a, b], shape_of(a).compliant().filter(|_| has_shape)?))
        });
        let (bodies, shape_a) = pairs
            .next()
            .ok_or_else(|| WorldError::NoContact(names.map(str::to_owned)))?;
        let center = |body: &Body| {
            let inertia = body.inertia();
            inertia.map_or_else(Vector3::zeros, |inertia| inertia.center_of_mass)
        };
        Ok(Self {
            bodies,
            shape_a: Arc::clone(shape_a),
            shape_b: shape_of(bodies[1]).clone(),
            moduli: bodies.map(|index| model.bodies[index].material.modulus.unwrap_or(1.0)),
            centers: bodies.map(|index| center(&model.bodies[index])),
        })
    }

    /// Returns the clearance at a state of the world.
    pub fn at<T: Scalar>(&self, state: &State<T>) -> Clearance<T> {
        self.at_poses(self.bodies.map(|body| state.bodies[body].pose))
    }

    /// Returns the clearance at poses of A and B.
    fn at_poses<T: Scalar>(&self, poses: [Pose<T>; 2]) -> Clearance<T> {
        let [modulus_a, modulus_b] = self.moduli.map(lift);
        let a = ContactBody::from_valid(&self.shape_a, poses[0], modulus_a);
        // `between` rejects a body without shape.
        let shape_b = self.shape_b.partner();
        let shape_b = shape_b.unwrap_or(PartnerShape::Compliant(&self.shape_a));
        ContactPair::new(a, Partner::from_valid(shape_b, poses[1], modulus_b)).clearance()
    }

    /// Returns the least clearance (m) at the recorded states, and the index of its state.
    pub fn least<T: Scalar>(&self, trajectory: &Trajectory<T>) -> (T, usize) {
        let states = trajectory.states();
        let distances: Vec<f64> = states.iter().map(|state| self.real_at(state)).collect();
        let records = 0..states.len();
        let record = records.min_by(|&i, &j| distances[i].total_cmp(&distances[j]));
        let record = record.unwrap_or_default();
        (self.at(&states[record]).distance, record)
    }

    /// Returns the first contact, at a recorded state or between two of them.
    pub fn approach<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Approach<T> {
        let states = trajectory.states();
        match states.iter().position(|state| self.real_at(state) <= 0.0) {
            None => {
                let (least, record) = self.least(trajectory);
                Approach::Apart(least, record)
            }
            Some(0) => Approach::Touching(lift(states[0].time)),
            Some(record) => {
                let [before, after] = [&states[record - 1], &states[record]];
                let duration = after.time - before.time;
                let share = self.path([before, after], duration).first_contact();
                Approach::Touching(share * duration + before.time)
            }
        }
    }

    /// Returns the clearance (m) at a state, without derivatives.
    fn real_at<T: Scalar>(&self, state: &State<T>) -> f64 {
        let poses = self.bodies.map(|body| state.bodies[body].pose.real());
        self.at_poses(poses).distance
    }

    fn path<T: Scalar>(&self, states: [&State<T>; 2], duration: f64) -> Path<'_, T> {
        let end = |state: &State<T>, k: usize| {
            let body = &state.bodies[self.bodies[k]];
            let Twist { angular, linear } = body.twist;
            let to_center = body.pose.rotated_constant(&self.centers[k]);
            let linear = linear - angular.cross(&to_center);
            let twist = Twist {
                angular: angular * lift::<T>(duration),
                linear: linear * lift::<T>(duration),
            };
            (body.pose, twist)
        };
        Path {
            pair: self,
            ends: states.map(|state| from_fn(|k| end(state, k))),
        }
    }
}

impl<T: Scalar> Path<'_, T> {
    /// Returns the clearance (m) at a fraction of the duration, from 0 to 1.
    fn distance_at(&self, share: T) -> T {
        let pose = |k: usize| interpolated(self.ends.each_ref().map(|end| &end[k]), share);
        self.pair.at_poses([pose(0), pose(1)]).distance
    }

    fn converted<U: Scalar>(&self, convert: impl Fn(T) -> U + Copy) -> Path<'_, U> {
        let converted = |(pose, twist): &(Pose<T>, Twist<T>)| {
            let rotation = pose.rotation().map(convert);
            let pose = Pose::from_parts(rotation, pose.translation().map(convert));
            let [angular, linear] = [twist.angular, twist.linear].map(|part| part.map(convert));
            (pose, Twist { angular, linear })
        };
        Path {
            pair: self.pair,
            ends: self
                .ends
                .each_ref()
                .map(|end| end.each_ref().map(converted)),
        }
    }

    /// Returns the fraction of the duration at which the bodies first touch. The bodies are apart at the first state.
    ///
    /// Bisection brackets the root s of the clearance g(s) in `f64`. Newton steps with the slope of g at the root then compute the
    /// derivatives of the root (implicit function theorem). Each step makes the derivatives of one more order exact.
    fn first_contact(&self) -> T {
        let real = self.converted(real_part);
        let [mut apart, mut touching] = [0.0, 1.0];
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (apart + touching);
            if real.distance_at(middle) > 0.0 {
                apart = middle;
            } else {
                touching = middle;
            }
        }
        let dual = real.converted(lift::<DenseDual<1>>);
        let [slope] = dual.distance_at(DenseDual::variable(apart, 0)).eps;
        let newton = |share: T, _| share - self.distance_at(share) * slope.recip();
        (0..T::NDERIV).fold(lift(apart), newton)
    }
}

/// Returns the pose at a fraction of the duration, by cubic Hermite interpolation of positions and of rotation matrices. The rotation
/// matrix is then made orthonormal.
fn interpolated<T: Scalar>(ends: [&(Pose<T>, Twist<T>); 2], share: T) -> Pose<T> {
    let [(start, start_twist), (end, end_twist)] = ends;
    let (square, rest) = (share * share, -share + lift::<T>(1.0));
    let late = square * (-share * 2.0 + 3.0);
    let weights = [
        lift::<T>(1.0) - late,
        late,
        share * rest * rest,
        -square * rest,
    ];
    let turning = |pose: &Pose<T>, twist: &Twist<T>| skew(&twist.angular) * pose.rotation();
    let rotations = [
        *start.rotation(),
        *end.rotation(),
        turning(start, start_twist),
        turning(end, end_twist),
    ];
    let positions = [
        *start.translation(),
        *end.translation(),
        start_twist.linear,
        end_twist.linear,
    ];
    let (mut rotation, mut position) = (
        Matrix3::from_element(lift(0.0)),
        Vector3::from_element(lift(0.0)),
    );
    for (k, weight) in weights.into_iter().enumerate() {
        rotation += rotations[k] * weight;
        position += positions[k] * weight;
    }
    // The steps toward the nearest rotation are not small, so their derivatives are needed in full.
    let three = Matrix3::from_diagonal_element(lift::<T>(3.0));
    for _ in 0..NEWTON_STEPS {
        let gram = rotation.transpose() * rotation;
        rotation = (rotation * (three - gram)).map(|entry| entry * 0.5);
    }
    Pose::from_parts(rotation, position)
}
