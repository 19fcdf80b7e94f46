use crate::contact::plane::PlanePolygon;
use nalgebra::{Matrix6, Vector3, Vector6};
use wide::f64x2;

/// From the axes and the center of a plane to A's axes and A's origin: for wrenches, and the same way for motions.
pub(super) struct PlaneFrame {
    /// e₁, e₂ and n.
    axes: [Vector3<f64>; 3],
    center: Vector3<f64>,
}

impl PlaneFrame {
    pub fn of(plane: &PlanePolygon<f64>) -> Self {
        Self {
            axes: [0, 1, 2].map(|axis| plane.axes.column(axis).into_owned()),
            center: plane.center,
        }
    }

    /// Two wrenches about the center along the axes, about A's origin in A's axes.
    #[inline]
    pub fn of_wrenches(&self, [one, other]: [&Vector6<f64>; 2]) -> [Vector6<f64>; 2] {
        let both = |row: usize| f64x2::new([one[row], other[row]]);
        let turned = self.turned([0, 1, 2, 3, 4, 5].map(both));
        let row = |row: usize| turned[row].to_array();
        let [t1, t2, t3, f1, f2, f3] = [row(0), row(1), row(2), row(3), row(4), row(5)];
        [0, 1].map(|of| Vector6::new(t1[of], t2[of], t3[of], f1[of], f2[of], f3[of]))
    }

    /// Adds a matrix of wrenches by motions, or by velocities, to one in A's axes about A's origin.
    pub fn add_matrix(&self, matrix: &Matrix6<f64>, sum: &mut Matrix6<f64>) {
        let columns = matrix.as_slice();
        // Two rows at a time, then two columns.
        let mut rows = [[f64x2::ZERO; 6]; 3];
        for (pair, row) in rows.iter_mut().enumerate() {
            let two = |column: usize| {
                let place = 6 * column + 2 * pair;
                f64x2::new([columns[place], columns[place + 1]])
            };
            *row = self.turned([two(0), two(1), two(2), two(3), two(4), two(5)]);
        }
        let sums = sum.as_mut_slice();
        for pair in 0..3 {
            let two = |of: usize| f64x2::transpose([rows[of][2 * pair], rows[of][2 * pair + 1]]);
            let ([t1, t2], [t3, f1], [f2, f3]) = (two(0), two(1), two(2));
            let [t1, t2, t3, f1, f2, f3] = self.turned([t1, t2, t3, f1, f2, f3]);
            let columns = [[t1, t2], [t3, f1], [f2, f3]].map(f64x2::transpose);
            for (row, [first, second]) in columns.into_iter().enumerate() {
                add_at(sums, 12 * pair + 2 * row, first);
                add_at(sums, 12 * pair + 6 + 2 * row, second);
            }
        }
    }

    #[inline]
    fn turned(&self, [t1, t2, t3, f1, f2, f3]: [f64x2; 6]) -> [f64x2; 6] {
        let [e1, e2, n] = &self.axes;
        let [tx, ty, tz] = [0, 1, 2].map(|i| t1 * e1[i] + t2 * e2[i] + t3 * n[i]);
        let [fx, fy, fz] = [0, 1, 2].map(|i| f1 * e1[i] + f2 * e2[i] + f3 * n[i]);
        let c = &self.center;
        [
            tx + (fz * c.y - fy * c.z),
            ty + (fx * c.z - fz * c.x),
            tz + (fy * c.x - fx * c.y),
            fx,
            fy,
            fz,
        ]
    }
}

#[inline]
fn add_at(sums: &mut [f64], place: usize, values: f64x2) {
    let sum = f64x2::new([sums[place], sums[place + 1]]) + values;
    sums[place..place + 2].copy_from_slice(sum.as_array());
}
