use super::wrenches::{Matrix, Six};
use crate::contact::plane::PlanePolygon;
use crate::lanes::Linear;
use crate::lanes::space::{cross, scaled, sum};

/// A plane's origin and axes, e₁, e₂ and n.
pub(super) struct Frame<N> {
    pub origin: [N; 3],
    pub axes: [[N; 3]; 3],
}

impl<N: Linear> Frame<N> {
    /// A wrench about the origin along the axes, about A's origin in A's axes; and the same way motions.
    #[inline(always)]
    pub fn turned(&self, [t1, t2, t3, f1, f2, f3]: &Six<N>) -> Six<N> {
        let [e1, e2, n] = self.axes;
        let force = sum(sum(scaled(e1, *f1), scaled(e2, *f2)), scaled(n, *f3));
        let torque = sum(sum(scaled(e1, *t1), scaled(e2, *t2)), scaled(n, *t3));
        let [t1, t2, t3] = sum(torque, cross(self.origin, force));
        let [f1, f2, f3] = force;
        [t1, t2, t3, f1, f2, f3]
    }

    /// A matrix of wrenches by motions or velocities, in A's axes about A's origin.
    #[inline(always)]
    pub fn turned_matrix(&self, matrix: &Matrix<N>) -> Matrix<N> {
        let mut turned = *matrix;
        for column in &mut turned {
            *column = self.turned(column);
        }
        for row in 0..6 {
            let [c0, c1, c2, c3, c4, c5] = &turned;
            let across = self.turned(&[c0[row], c1[row], c2[row], c3[row], c4[row], c5[row]]);
            for column in 0..6 {
                turned[column][row] = across[column];
            }
        }
        turned
    }
}

impl Frame<f64> {
    pub fn of(plane: &PlanePolygon<f64>) -> Self {
        Self {
            origin: plane.center.into(),
            axes: plane.axes.data.0,
        }
    }
}
