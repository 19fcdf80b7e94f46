use crate::contact::plane::PlanePolygon;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// From the axes and the center of a plane to A's axes and A's origin: for wrenches, and the same way for motions.
pub(super) struct PlaneFrame {
    axes: Matrix3<f64>,
    center: Vector3<f64>,
}

impl PlaneFrame {
    pub fn of(plane: &PlanePolygon<f64>) -> Self {
        Self {
            axes: plane.axes,
            center: plane.center,
        }
    }

    pub fn of_wrench(&self, wrench: &Vector6<f64>) -> Vector6<f64> {
        let [torque, force] = [0, 3].map(|row| self.axes * wrench.fixed_rows::<3>(row));
        let torque = torque + self.center.cross(&force);
        Vector6::new(torque.x, torque.y, torque.z, force.x, force.y, force.z)
    }

    /// A matrix of wrenches by motions, or by velocities.
    pub fn of_matrix(&self, matrix: &Matrix6<f64>) -> Matrix6<f64> {
        let column = |column: usize| self.of_wrench(&matrix.column(column).into_owned());
        let [a1, a2, a3, l1, l2, l3] = [0, 1, 2, 3, 4, 5].map(column);
        let turned = |axis: usize, [v1, v2, v3]: [&Vector6<f64>; 3]| {
            let [r1, r2, r3] = [0, 1, 2].map(|from| self.axes[(axis, from)]);
            v1 * r1 + v2 * r2 + v3 * r3
        };
        let [x, y, z] = [0, 1, 2].map(|axis| turned(axis, [&l1, &l2, &l3]));
        let [ax, ay, az] = [0, 1, 2].map(|axis| turned(axis, [&a1, &a2, &a3]));
        let c = &self.center;
        Matrix6::from_columns(&[
            ax + z * c.y - y * c.z,
            ay + x * c.z - z * c.x,
            az + y * c.x - x * c.y,
            x,
            y,
            z,
        ])
    }
}
