use crate::lanes::space::{cross, dot, scaled, sum};
use crate::lanes::{Lanes, Linear, Numbers, ROW, Row};
use crate::narrow_phase::Octet;
use crate::scalar::{Scalar, lift};

/// A wrench or a motion: torque or rotation, then force or translation.
pub(super) type Six<N> = [N; 6];

/// The columns of a 6×6 matrix.
pub(super) type Columns<N> = [Six<N>; 6];

/// The plane of a contact polygon in A's frame, with the fields of both bodies and the moments of the polygon. It holds one polygon if N is
/// a scalar, or one in each lane.
///
/// Points of the plane have coordinates y₁ and y₂ along e₁ and e₂ from the origin.
#[derive(Clone, Copy)]
pub(super) struct PolygonFields<N> {
    /// Origin of the coordinates y (m).
    pub origin: [N; 3],
    /// e₁, e₂ and n, the unit normal out of B into A.
    pub axes: [[N; 3]; 3],
    /// The pressure (Pa) at the origin, and its slopes along e₁ and e₂ (Pa/m).
    pub pressure: [N; 3],
    /// ∇p_A (Pa/m).
    pub gradient_a: [N; 3],
    /// ∇p_A/|g| and ∇p_B/|g|, with g = ∇p_A − ∇p_B (see [`EquilibriumPlane`](crate::narrow_phase::EquilibriumPlane)).
    pub slopes: [[N; 3]; 2],
    /// 1/|g| (m/Pa), or 0 if B is rigid.
    pub inverse_gradient_norm: N,
    /// ∫ m dA for the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂².
    pub moments: [N; 6],
}

impl PolygonFields<f64> {
    /// Zeros, as memory for a plane.
    pub const ZERO: Self = Self {
        origin: [0.0; 3],
        axes: [[0.0; 3]; 3],
        pressure: [0.0; 3],
        gradient_a: [0.0; 3],
        slopes: [[0.0; 3]; 2],
        inverse_gradient_norm: 0.0,
        moments: [0.0; 6],
    };
}

impl<T: Scalar> PolygonFields<T> {
    /// Returns the plane of the polygon at an index of an octet. All derivatives are zero.
    pub fn at(octet: &Octet, index: usize) -> Self {
        Self::from(|row| lift(row(octet)[index]))
    }
}

impl<N: Numbers> PolygonFields<N> {
    /// Loads planes of an octet, beginning with the one at index `first`.
    #[inline(always)]
    pub fn loaded<L: Lanes<Numbers = N>>(lanes: L, octet: &Octet, first: usize) -> Self {
        Self::from(|row| lanes.load(row(octet), first))
    }

    /// Loads planes of octets, each given by octet and index, beginning with index `first`.
    #[inline(always)]
    pub fn gathered<L: Lanes<Numbers = N>>(
        lanes: L,
        octets: &[Octet],
        indices: &[[usize; 2]; ROW],
        first: usize,
    ) -> Self {
        Self::from(|row| {
            lanes.gathered(|lane| {
                let [octet, index] = indices[first + lane];
                row(&octets[octet])[index]
            })
        })
    }

    /// Loads one plane for each lane.
    #[inline(always)]
    pub fn side_by_side<'p, L: Lanes<Numbers = N>>(
        lanes: L,
        plane: impl Fn(usize) -> &'p PolygonFields<f64>,
    ) -> Self {
        macro_rules! vector {
            ($($field:tt)+) => {
                [
                    lanes.gathered(|lane| plane(lane).$($field)+[0]),
                    lanes.gathered(|lane| plane(lane).$($field)+[1]),
                    lanes.gathered(|lane| plane(lane).$($field)+[2]),
                ]
            };
        }
        let mut moments = [lanes.splat(0.0); 6];
        for (moment, number) in moments.iter_mut().enumerate() {
            *number = lanes.gathered(|lane| plane(lane).moments[moment]);
        }
        Self {
            origin: vector!(origin),
            axes: [vector!(axes[0]), vector!(axes[1]), vector!(axes[2])],
            pressure: vector!(pressure),
            gradient_a: vector!(gradient_a),
            slopes: [vector!(slopes[0]), vector!(slopes[1])],
            inverse_gradient_norm: lanes.gathered(|lane| plane(lane).inverse_gradient_norm),
            moments,
        }
    }
}

impl<N: Copy> PolygonFields<N> {
    #[inline(always)]
    fn from(load: impl Fn(fn(&Octet) -> &Row) -> N) -> Self {
        macro_rules! vector {
            ($($rows:tt)+) => {
                [
                    load(|octet| &octet.$($rows)+[0]),
                    load(|octet| &octet.$($rows)+[1]),
                    load(|octet| &octet.$($rows)+[2]),
                ]
            };
        }
        Self {
            origin: vector!(origin),
            axes: [vector!(axes[0]), vector!(axes[1]), vector!(axes[2])],
            pressure: vector!(pressure),
            gradient_a: vector!(gradient_a),
            slopes: [vector!(slopes[0]), vector!(slopes[1])],
            inverse_gradient_norm: load(|octet| &octet.inverse_gradient_norm),
            moments: [
                load(|octet| &octet.moments[0]),
                load(|octet| &octet.moments[1]),
                load(|octet| &octet.moments[2]),
                load(|octet| &octet.moments[3]),
                load(|octet| &octet.moments[4]),
                load(|octet| &octet.moments[5]),
            ],
        }
    }
}

impl<N: Linear> PolygonFields<N> {
    /// Returns ∇p_A·n.
    #[inline(always)]
    pub fn slope_along_normal(&self) -> N {
        dot(self.gradient_a, self.axes[2])
    }

    /// Returns a vector with these components along the axes, in A's axes.
    #[inline(always)]
    fn vector([e1, e2, n]: &[[N; 3]; 3], [c1, c2, c3]: [N; 3]) -> [N; 3] {
        sum(sum(scaled(*e1, c1), scaled(*e2, c2)), scaled(*n, c3))
    }

    /// Transforms a wrench about the origin along the axes to A's axes about A's origin. Derivatives with respect to motions transform in
    /// the same way.
    #[inline(always)]
    pub fn in_a(&self, [t1, t2, t3, f1, f2, f3]: &Six<N>) -> Six<N> {
        let force = Self::vector(&self.axes, [*f1, *f2, *f3]);
        let torque = Self::vector(&self.axes, [*t1, *t2, *t3]);
        let [t1, t2, t3] = sum(torque, cross(self.origin, force));
        let [f1, f2, f3] = force;
        [t1, t2, t3, f1, f2, f3]
    }

    /// Transforms a matrix of wrenches, by motions or velocities, in the same way.
    #[inline(always)]
    pub fn matrix_in_a(&self, matrix: &Columns<N>) -> Columns<N> {
        let mut turned = *matrix;
        for column in &mut turned {
            *column = self.in_a(column);
        }
        for row in 0..6 {
            let [c0, c1, c2, c3, c4, c5] = &turned;
            let across = self.in_a(&[c0[row], c1[row], c2[row], c3[row], c4[row], c5[row]]);
            for column in 0..6 {
                turned[column][row] = across[column];
            }
        }
        turned
    }
}
