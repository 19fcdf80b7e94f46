//! Contact of two bodies about their centers of mass.

use crate::contact::LinearizedContact;
use crate::dynamics::{Body, BodyState};
use crate::spatial::{Wrench, add_block, skew};
use nalgebra::{Matrix6, SMatrix, SVector, Vector3, Vector6};

/// Six numbers of A, then six of B.
pub(super) type PairVector = SVector<f64, 12>;
pub(super) type PairMatrix = SMatrix<f64, 12, 12>;
type Maps = SMatrix<f64, 6, 12>;

/// States of two bodies, with the maps between motions of their centers of mass and their contact.
pub(super) struct PairGeometry<'s> {
    states: [&'s BodyState; 2],
    /// Vector from each origin to the center of mass, in world axes (m).
    arms: [Vector3<f64>; 2],
}

/// Derivatives of the velocity of A relative to B (angular, linear at the origin of A, in the axes of A).
pub(super) struct RelativeVelocity {
    /// Derivative with respect to the velocities of both bodies about their centers of mass.
    pub by_velocities: Maps,
    /// Derivative with respect to displacements of both bodies, which move with their velocities.
    pub by_displacements: Maps,
}

impl<'s> PairGeometry<'s> {
    pub fn of(bodies: [&Body; 2], states: [&'s BodyState; 2]) -> Self {
        let arm = |i: usize| {
            let center = bodies[i].inertia().map(|inertia| inertia.center_of_mass);
            states[i].pose.rotation() * center.unwrap_or_default()
        };
        Self {
            states,
            arms: [arm(0), arm(1)],
        }
    }

    /// Derivatives of the relative velocity. With o_A = c_A − r_A, the point of B at the origin of A has the velocity v_B + ω_B × (o_A −
    /// c_B).
    pub fn relative_velocity(&self) -> RelativeVelocity {
        let [a, b] = self.states;
        let [arm_a, arm_b] = &self.arms;
        let to_a = a.pose.rotation().transpose();
        let [spin_a, spin_b] = [a.twist.angular, b.twist.angular];
        let origin_from_b = a.pose.translation() - (b.pose.translation() + arm_b);
        let velocity_a = a.twist.linear - spin_a.cross(arm_a);
        let linear = velocity_a - b.twist.linear - spin_b.cross(&origin_from_b);
        let mut by_velocities = Maps::zeros();
        add_block(&mut by_velocities, [0, 0], to_a);
        add_block(&mut by_velocities, [0, 6], -to_a);
        add_block(&mut by_velocities, [3, 0], to_a * skew(arm_a));
        add_block(&mut by_velocities, [3, 3], to_a);
        add_block(&mut by_velocities, [3, 6], to_a * skew(&origin_from_b));
        add_block(&mut by_velocities, [3, 9], -to_a);
        let mut by_displacements = Maps::zeros();
        let carried = to_a * skew(&spin_b);
        let turned = skew(&linear) + (skew(&spin_a) - skew(&spin_b)) * skew(arm_a);
        let spin = spin_a - spin_b;
        add_block(&mut by_displacements, [0, 0], to_a * skew(&spin));
        add_block(&mut by_displacements, [3, 0], to_a * turned);
        add_block(&mut by_displacements, [3, 3], -carried);
        add_block(&mut by_displacements, [3, 9], carried);
        RelativeVelocity {
            by_velocities,
            by_displacements,
        }
    }

    /// Wrenches about the centers of mass, from wrenches about the origins.
    pub fn wrenches(&self, [on_a, on_b]: [&Wrench; 2]) -> PairVector {
        let [a, b] = [on_a.about(&self.arms[0]), on_b.about(&self.arms[1])];
        let (a, b) = (a.to_vector(), b.to_vector());
        PairVector::from_fn(|row, _| if row < 6 { a[row] } else { b[row - 6] })
    }

    /// Derivatives of the wrenches about the centers of mass with respect to displacements, from the derivatives of the wrenches about the
    /// origins with respect to poses.
    pub fn by_displacements(&self, by_poses: &PairMatrix, wrenches: [&Wrench; 2]) -> PairMatrix {
        let mut about = self.moved_to_centers(by_poses);
        for (body, wrench) in wrenches.into_iter().enumerate() {
            // If a body turns by θ, its arm changes by θ × r, which subtracts (θ × r) × F from the torque.
            let turned = skew(&wrench.force) * skew(&self.arms[body]);
            add_block(&mut about, [6 * body, 6 * body], -turned);
        }
        about
    }

    /// Derivatives of the wrenches about the centers of mass, with respect to displacements and to velocities.
    pub fn linearized(&self, contact: &LinearizedContact) -> [PairMatrix; 2] {
        let mut by_poses = contact.by_poses;
        for body in 0..2 {
            // The velocity v − ω × r of the origin changes by −ω × (θ × r).
            let spin = skew(&self.states[body].twist.angular);
            let change = spin * skew(&self.arms[body]);
            let by_origin = contact.by_twists.fixed_columns::<3>(6 * body + 3) * change;
            let mut columns = by_poses.fixed_columns_mut::<3>(6 * body);
            columns += by_origin;
        }
        let wrenches = [&contact.wrench.on_a, &contact.wrench.on_b];
        [
            self.by_displacements(&by_poses, wrenches),
            self.moved_to_centers(&contact.by_twists),
        ]
    }

    /// Shifts the columns to motions of the centers of mass, and the rows to torques about them.
    fn moved_to_centers(&self, slopes: &PairMatrix) -> PairMatrix {
        let mut moved = *slopes;
        for (body, arm) in self.arms.iter().enumerate() {
            let (mut torques, forces) =
                moved.rows_range_pair_mut(6 * body..6 * body + 3, 6 * body + 3..6 * body + 6);
            torques.gemm(1.0, &skew(arm).transpose(), &forces, 1.0);
        }
        for (body, arm) in self.arms.iter().enumerate() {
            let (mut turns, shifts) =
                moved.columns_range_pair_mut(6 * body..6 * body + 3, 6 * body + 3..6 * body + 6);
            turns.gemm(1.0, &shifts, &skew(arm), 1.0);
        }
        moved
    }
}

/// Six numbers of one body.
pub(super) fn part(vector: &PairVector, body: usize) -> Vector6<f64> {
    vector.fixed_rows::<6>(6 * body).into_owned()
}

/// Block with the rows of one body and the columns of another.
pub(super) fn block(matrix: &PairMatrix, row: usize, column: usize) -> Matrix6<f64> {
    matrix.fixed_view::<6, 6>(6 * row, 6 * column).into_owned()
}

/// Vector of the six numbers of each of two bodies. `None` stands for the zeros of a body that is not dynamic.
pub(super) fn joined(parts: [Option<Vector6<f64>>; 2]) -> PairVector {
    let [a, b] = parts.map(Option::unwrap_or_default);
    PairVector::from_fn(|row, _| if row < 6 { a[row] } else { b[row - 6] })
}
