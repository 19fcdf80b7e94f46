//! First derivatives of what dissipation and friction add to the elastic pressure, polygon by polygon.
//!
//! Let t be the traction less p n, a function of the pressure p, the normal n and the velocity v of A relative to B, and T
//! its derivative by v. As a body moves or a modulus changes, the equilibrium plane moves along its normal at the speed
//! h = h₀ + h₁y₁ + h₂y₂, and turns by dn = −∇h. Then the wrench W(t) of the traction changes by h₀K₀ + h₁K₁ + h₂K₂, where
//! for the monomials m₀ = 1, m₁ = y₁, m₂ = y₂
//!
//! Kᵢ = W(mᵢD) + ∫ mᵢ (n × t) dA + Gᵢ + Σ over edges ∫ mᵢ t v dl,
//!
//! - D = ∂t/∂p·∂p_A/∂n + T(ω × n): pressure and velocity at the moved point;
//! - G₁ = W(θ×t) − W(T(θ×v)), θ = n × dn = e₂ for h = y₁, G₂ with −e₁: turning normal and velocity together turns the
//!   traction, so turning the normal alone turns it too, and the velocity back;
//! - v, the outward speed of an edge in the plane: that of the line in which the plane meets the face that owns the edge.
//!   With the face's outward normal m, which moves at w, v = (w·m − h m·n)/|m − (m·n)n|. Owners of an edge share it
//!   equally.
//!
//! Nothing divides by a length or an angle between edges, and no corner is differentiated.

use super::friction::SlipMoments;
use super::jacobian::RelativeJacobian;
use super::linearised::RelativeLinearisation;
use super::plane::{EXPONENTS, Outline, PlanePolygon, at, moment_of, monomials, place, product};
use super::polygon::{CutPolygon, PartialSum, PolygonSource, sum_over};
use super::surface_law::RelativeMotion;
use super::{ContactPair, SurfaceLaw};
use crate::narrow_phase::Cut;
use crate::search::Found;
use crate::spatial::{Wrench, skew};
use nalgebra::{Matrix3, Matrix6, Matrix6x2, Vector3, Vector6};

/// Moments of a vector along e₁, e₂ and n by the first six monomials.
type VectorMoments = [[f64; 3]; 6];

/// Gauss' points and weights for the mean over an edge, from its start: exact to degree five.
const THREE_POINTS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// The elastic contact and what the surface law adds to it.
struct InMotion {
    elastic: RelativeJacobian<f64>,
    added: RelativeLinearisation<f64>,
}

impl PartialSum for InMotion {
    fn empty() -> Self {
        Self {
            elastic: RelativeJacobian::empty(),
            added: RelativeLinearisation::empty(),
        }
    }

    fn merge(&mut self, next: Self) {
        self.elastic.merge(next.elastic);
        self.added.merge(next.added);
    }
}

impl ContactPair<'_> {
    /// In A's axes, of a pair in A's frame.
    ///
    /// The wrench is that of the contact polygons as they are. Its derivatives have kinks where faces coincide; within
    /// round-off of them they are those of polygons that are cut as if they did (see
    /// [`PolygonSource::linearised`]). So are the elastic ones: of two flush sides either may be the one
    /// that has a polygon, and taken for flush are both, or neither.
    pub(super) fn linearisation_in_motion(
        &self,
        law: &SurfaceLaw,
        motion: &RelativeMotion<f64>,
    ) -> RelativeLinearisation<f64> {
        let source = PolygonSource::of(self);
        let (mut sum, wrench) = source.linearised(
            self.search(),
            |source, found| source.linearisation(found, (law, motion)),
            |found| {
                source.sum(found, |sum: &mut Wrench, polygon| {
                    *sum += polygon.wrench_in_motion(law, motion);
                })
            },
        );
        if let Some(wrench) = wrench {
            sum.wrench = wrench.to_vector();
        }
        sum
    }
}

impl RelativeLinearisation<f64> {
    /// From E_B ∂W/∂E_B as the second column by the moduli to the derivatives by both: as the wrench is homogeneous of
    /// degree one in the moduli, E_A ∂W/∂E_A + E_B ∂W/∂E_B = W.
    fn by_both_moduli(mut self, [modulus_a, modulus_b]: [f64; 2]) -> Self {
        let by_b = self.by_moduli.column(1).into_owned();
        let by_a = self.wrench - by_b;
        self.by_moduli = Matrix6x2::from_columns(&[by_a / modulus_a, by_b / modulus_b]);
        self
    }
}

impl PolygonSource<'_, f64> {
    /// The wrench on A and its derivatives, from these cuts.
    fn linearisation(
        &self,
        found: &Found,
        (law, motion): (&SurfaceLaw, &RelativeMotion<f64>),
    ) -> RelativeLinearisation<f64> {
        let moduli = [self.modulus_a, self.modulus_b];
        let InMotion { elastic, added } = sum_over(found, |sum: &mut InMotion, cut| {
            let polygon = self.polygon(cut);
            if polygon.has_area() {
                polygon.add_to(&mut sum.elastic);
            }
            self.add_traction_rates((cut, &polygon), (law, motion), &mut sum.added);
        });
        let mut sum = elastic.linearisation(moduli);
        sum.merge(added.by_both_moduli(moduli));
        sum
    }

    /// Adds what dissipation and friction contribute to the wrench on A and its derivatives; of those by the moduli, only
    /// E_B ∂W/∂E_B, in the second column.
    fn add_traction_rates(
        &self,
        (cut, polygon): (&Cut, &CutPolygon<f64>),
        (law, motion): (&SurfaceLaw, &RelativeMotion<f64>),
        sum: &mut RelativeLinearisation<f64>,
    ) {
        let Some(plane) = PlanePolygon::of(polygon, motion) else {
            return;
        };
        let traction = Traction::of(&plane, law);
        let mut rates = Rates::default();
        if polygon.has_area() {
            rates.add_area(&traction, polygon);
            rates.scale(cut.weight().area);
        }
        if !law.is_elastic() {
            self.add_edges(cut, &traction, &mut rates);
        }
        rates.add_to(&plane, polygon, sum);
    }

    /// Adds what the motion of the edges contributes.
    fn add_edges(&self, cut: &Cut, traction: &Traction, rates: &mut Rates) {
        let [a, b] = [self.pair.tet_a(cut.tets[0]), self.pair.tet_b(cut.tets[1])];
        let edges = traction.plane.outline.corners().len();
        for (edge, &owners) in cut.polygon.owners().iter().enumerate().take(edges) {
            // At the rim there is no pressure.
            if owners == 0 || owners & a.zero_faces != 0 {
                continue;
            }
            let along = traction.plane.edge(edge);
            if along[0] == 0.0 && along[1] == 0.0 {
                continue;
            }
            let flux = wrenches(&traction.along_edge(edge));
            let share = cut.weight().edges / f64::from(owners.count_ones());
            for face in (0..8).filter(|face| owners & 1 << face != 0) {
                let outward = if face < 4 {
                    a.barycentric[face].gradient * -a.barycentric_steepness[face].recip()
                } else {
                    let face = face - 4;
                    let in_b =
                        b.barycentric[face].gradient * -b.barycentric_steepness[face].recip();
                    self.pose_ab.rotation() * in_b
                };
                let m = traction.plane.axes.tr_mul(&outward);
                rates.add_flux(&flux, &m, share * outwardness(&along, &m), face >= 4);
            }
        }
    }
}

/// 1/|m − (m·n)n|, negative if a face's normal m points into the polygon at this edge, 0 if the face lies in the plane.
fn outwardness(along: &[f64; 2], m: &Vector3<f64>) -> f64 {
    let sine = m.x.hypot(m.y);
    let turn = m.x * along[1] - m.y * along[0];
    if sine == 0.0 {
        0.0
    } else {
        turn.signum() / sine
    }
}

impl PlanePolygon<f64> {
    /// From the start of an edge of the contact polygon to its end.
    fn edge(&self, edge: usize) -> [f64; 2] {
        let [from, to] = self.ends(edge);
        [to[0] - from[0], to[1] - from[1]]
    }

    fn ends(&self, edge: usize) -> [[f64; 2]; 2] {
        let corners = self.outline.corners();
        [
            corners[edge],
            corners[if edge + 1 == corners.len() {
                0
            } else {
                edge + 1
            }],
        ]
    }
}

/// What the surface law adds to the pressure on a polygon.
struct Traction<'p> {
    plane: &'p PlanePolygon<f64>,
    friction: f64,
    dissipation: f64,
    /// ψ = 1 − d v₃.
    damping: [f64; 3],
    /// The part of the polygon where ψ is positive, if it is not everywhere.
    part: Option<Outline<f64>>,
    slip: SlipMoments,
}

impl<'p> Traction<'p> {
    fn of(plane: &'p PlanePolygon<f64>, law: &SurfaceLaw) -> Self {
        let damping = plane.damping(law.dissipation);
        let part = plane.outline.cut(&damping);
        let pressed = part.as_ref().unwrap_or(&plane.outline);
        let slip = plane.slip(law);
        Self {
            slip: slip.moments(pressed.corners(), &plane.pressure, &damping),
            plane,
            friction: law.friction,
            dissipation: law.dissipation,
            damping,
            part,
        }
    }

    fn pressed(&self) -> &Outline<f64> {
        self.part.as_ref().unwrap_or(&self.plane.outline)
    }

    /// ψ − 1 = −d v₃.
    fn excess_damping(&self) -> [f64; 3] {
        self.plane.separating().map(|c| -self.dissipation * c)
    }

    /// ∫ t m dl along an edge of the contact polygon.
    fn along_edge(&self, edge: usize) -> VectorMoments {
        let mut moments = [[0.0; 3]; 6];
        let pressed = self.pressed().edges().iter();
        if let Some(part) = pressed.clone().position(|&of| usize::from(of) == edge) {
            for (moment, friction) in moments.iter_mut().zip(&self.slip.edges[part]) {
                moment[0] = -self.friction * friction[0];
                moment[1] = -self.friction * friction[1];
            }
        }
        if self.dissipation != 0.0 {
            self.add_normal_along_edge(edge, &mut moments);
        }
        moments
    }

    /// Adds ∫ p (ψ − 1) m dl, with ψ = 0 where it would be negative.
    fn add_normal_along_edge(&self, edge: usize, moments: &mut VectorMoments) {
        let [from, to] = self.plane.ends(edge);
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let excess = self.excess_damping();
        let mut add = |[start, end]: [f64; 2], factor: &dyn Fn(&[f64; 2]) -> f64| {
            for (place, weight) in THREE_POINTS {
                let share = start + place * (end - start);
                let y = [0, 1].map(|i| from[i] + share * (to[i] - from[i]));
                let p = at(&self.plane.pressure, &y) * weight * length * (end - start);
                let values = monomials(&y, p * factor(&y));
                for (moment, value) in moments.iter_mut().zip(values) {
                    moment[2] += value;
                }
            }
        };
        let [start, end] = [from, to].map(|y| at(&self.damping, &y));
        let cut = start / (start - end);
        let (inside, outside) = match (start >= 0.0, end >= 0.0) {
            (true, true) => ([0.0, 1.0], [0.0, 0.0]),
            (true, false) => ([0.0, cut], [cut, 1.0]),
            (false, true) => ([cut, 1.0], [0.0, cut]),
            (false, false) => ([0.0, 0.0], [0.0, 1.0]),
        };
        add(inside, &|y| at(&excess, y));
        if outside != [0.0, 0.0] {
            add(outside, &|_| -1.0);
        }
    }
}

/// The derivatives of one polygon's wrench, about its center along its axes.
#[derive(Default)]
struct Rates {
    wrench: Vector6<f64>,
    /// K₀, K₁ and K₂.
    by_speed: [Vector6<f64>; 3],
    by_motion: Matrix6<f64>,
    by_twist: Matrix6<f64>,
    by_dissipation: Vector6<f64>,
    by_friction: Vector6<f64>,
}

/// The wrench of a traction from its moments by three monomials.
fn wrench_of([x, by_y1, by_y2]: [[f64; 3]; 3]) -> Vector6<f64> {
    Vector6::new(by_y2[2], -by_y1[2], by_y1[1] - by_y2[0], x[0], x[1], x[2])
}

/// The wrenches of a traction times 1, y₁ and y₂.
fn wrenches(m: &VectorMoments) -> [Vector6<f64>; 3] {
    [
        wrench_of([m[0], m[1], m[2]]),
        wrench_of([m[1], m[3], m[4]]),
        wrench_of([m[2], m[4], m[5]]),
    ]
}

impl Rates {
    fn scale(&mut self, weight: f64) {
        self.wrench *= weight;
        self.by_speed = self.by_speed.map(|k| k * weight);
        self.by_twist *= weight;
        self.by_dissipation *= weight;
        self.by_friction *= weight;
    }
}

impl Rates {
    /// Adds the integrals over the area: velocities, law, and K without the edges.
    fn add_area(&mut self, traction: &Traction, polygon: &CutPolygon<f64>) {
        let area = AreaMoments::of(traction);
        let [first, second, third] = area.by_velocity.each_ref().map(wrenches);
        let columns = |k: usize| [first[k], second[k], third[k]];
        let [by_velocity, by_y1, by_y2] = [0, 1, 2].map(columns);
        self.by_twist = Matrix6::from_columns(&[
            by_y2[2],
            -by_y1[2],
            by_y1[1] - by_y2[0],
            by_velocity[0],
            by_velocity[1],
            by_velocity[2],
        ]);
        self.wrench = wrench_of(area.traction);
        self.by_dissipation = wrench_of(area.by_dissipation);
        self.by_friction = wrench_of(area.by_friction);
        let t = area.traction;
        let q = wrenches(&area.by_pressure);
        let along_normal = polygon.pressure_a.gradient.dot(&polygon.plane.normal);
        let [v1, v2, v3] = traction.plane.velocity;
        let [w1, w2, w3] = traction.plane.angular;
        for (k, by) in [by_velocity, by_y1, by_y2].iter().enumerate() {
            let lifted = Vector6::new(-t[k][1], t[k][0], 0.0, 0.0, 0.0, 0.0);
            self.by_speed[k] += q[k] * along_normal + by[0] * w2 - by[1] * w1 + lifted;
        }
        // The wrench of v_i times column j of T.
        let times_v1 = |j: usize| by_velocity[j] * v1 - by_y2[j] * w3;
        let times_v2 = |j: usize| by_velocity[j] * v2 + by_y1[j] * w3;
        let times_v3 = |j: usize| by_velocity[j] * v3 - by_y1[j] * w2 + by_y2[j] * w1;
        let turned = |turn: fn([f64; 3]) -> [f64; 3]| wrench_of(t.map(turn));
        self.by_speed[1] += turned(|t| [-t[2], 0.0, t[0]]) + times_v3(0) - times_v1(2);
        self.by_speed[2] += turned(|t| [0.0, -t[2], t[1]]) + times_v3(1) - times_v2(2);
    }

    /// Adds the flux through an edge of a face with the outward normal m, times `scale`; the face moves with A or with B.
    fn add_flux(
        &mut self,
        flux: &[Vector6<f64>; 3],
        m: &Vector3<f64>,
        scale: f64,
        moves_with_b: bool,
    ) {
        for (k, f) in self.by_speed.iter_mut().zip(flux) {
            *k -= f * (scale * m.z);
        }
        if moves_with_b {
            self.by_motion += along_normal_of(&(m * scale), flux);
        }
    }

    /// Adds the rates to those in A's axes about A's origin.
    fn add_to(
        &self,
        plane: &PlanePolygon<f64>,
        polygon: &CutPolygon<f64>,
        sum: &mut RelativeLinearisation<f64>,
    ) {
        // h = −s_B·ξ/|g| for a motion ξ of B, and p/|g| for δE_B/E_B.
        let per_gradient = polygon.plane.steepness.recip();
        let gradient_b = plane.axes.tr_mul(&polygon.pressure_b.gradient) * -per_gradient;
        let by_motion = self.by_motion + along_normal_of(&gradient_b, &self.by_speed);
        let [p0, p1, p2] = plane.pressure.map(|p| p * per_gradient);
        let [k0, k1, k2] = &self.by_speed;
        let frame = PlaneFrame::of(plane);
        sum.wrench += frame.of_wrench(&self.wrench);
        sum.by_motion += frame.of_matrix(&by_motion);
        sum.by_twist += frame.of_matrix(&self.by_twist);
        let by_modulus_b = frame.of_wrench(&(k0 * p0 + k1 * p1 + k2 * p2));
        let mut column = sum.by_moduli.column_mut(1);
        column += by_modulus_b;
        let rates = [&self.by_dissipation, &self.by_friction].map(|rate| frame.of_wrench(rate));
        for (column, rate) in rates.iter().enumerate() {
            let mut own = sum.by_law.column_mut(column);
            own += rate;
        }
    }
}

/// What the motion (θ, u) about the center contributes by moving points y with the speed m·(u + θ × y), from what speeds
/// of 1, y₁ and y₂ contribute.
fn along_normal_of(m: &Vector3<f64>, [f0, f1, f2]: &[Vector6<f64>; 3]) -> Matrix6<f64> {
    // m·(θ × y) = θ·(y × m), y × m = (y₂m₃, −y₁m₃, y₁m₂ − y₂m₁).
    Matrix6::from_columns(&[
        f2 * m.z,
        f1 * -m.z,
        f1 * m.y - f2 * m.x,
        f0 * m.x,
        f0 * m.y,
        f0 * m.z,
    ])
}

/// From the axes and the center of a plane to A's axes and A's origin: for wrenches, and the same way for motions.
struct PlaneFrame {
    axes: Matrix3<f64>,
    /// [c]ₓ.
    lever: Matrix3<f64>,
}

impl PlaneFrame {
    fn of(plane: &PlanePolygon<f64>) -> Self {
        Self {
            axes: plane.axes,
            lever: skew(&plane.center),
        }
    }

    fn of_wrench(&self, wrench: &Vector6<f64>) -> Vector6<f64> {
        let [torque, force] = [0, 3].map(|row| self.axes * wrench.fixed_rows::<3>(row));
        let torque = torque + self.lever * force;
        Vector6::new(torque.x, torque.y, torque.z, force.x, force.y, force.z)
    }

    /// A matrix of wrenches by motions, or by velocities.
    fn of_matrix(&self, matrix: &Matrix6<f64>) -> Matrix6<f64> {
        let block = |row, column| {
            let block = matrix.fixed_view::<3, 3>(row, column);
            self.axes * block * self.axes.transpose()
        };
        let (torque_turn, torque_shift) = (block(0, 0), block(0, 3));
        let (force_turn, force_shift) = (block(3, 0), block(3, 3));
        let torque_turn = torque_turn + self.lever * force_turn;
        let torque_shift = torque_shift + self.lever * force_shift;
        let mut whole = Matrix6::zeros();
        let blocks = [
            ([0, 0], torque_turn - torque_shift * self.lever),
            ([0, 3], torque_shift),
            ([3, 0], force_turn - force_shift * self.lever),
            ([3, 3], force_shift),
        ];
        for ([row, column], block) in blocks {
            whole.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
        }
        whole
    }
}

/// Moments over the area of a polygon.
struct AreaMoments {
    /// Of t, by 1, y₁ and y₂.
    traction: [[f64; 3]; 3],
    /// Of ∂t/∂p.
    by_pressure: VectorMoments,
    /// Of the columns of T.
    by_velocity: [VectorMoments; 3],
    /// Of ∂t/∂d and ∂t/∂μ, by 1, y₁ and y₂.
    by_dissipation: [[f64; 3]; 3],
    by_friction: [[f64; 3]; 3],
}

impl AreaMoments {
    /// With ψ, u and σ as in [`Traction`] and [`SlipMoments`], on the part where ψ > 0
    ///
    /// t = p(−μψu₁, −μψu₂, ψ − 1),  ∂t/∂(v₁, v₂) = μpψ(u uᵀ − 1)/σ,  ∂t/∂v₃ = −dp(−μu₁, −μu₂, 1),
    ///
    /// and ∂t/∂d the same as ∂t/∂v₃ with v₃ in place of d. Beyond, t = −p n.
    fn of(traction: &Traction) -> Self {
        let (plane, slip) = (traction.plane, &traction.slip);
        let (mu, d) = (traction.friction, traction.dissipation);
        let moments = traction.pressed().moments();
        let direction = [0, 1].map(|axis| slip.direction.map(|moment| moment[axis]));
        // Of (−μu₁, −μu₂, 1) times a polynomial.
        let pushed = |f: &[f64], m: [usize; 2]| {
            let [u1, u2] = direction.each_ref().map(|u| moment_of(f, u, m));
            [-mu * u1, -mu * u2, moment_of(f, &moments, m)]
        };
        let whole = traction.part.is_some().then(|| plane.outline.moments());
        let excess = traction.excess_damping();
        let by_pressure = EXPONENTS.map(|m| {
            let [u1, u2, psi] = pushed(&traction.damping, m);
            let normal = match &whole {
                None => moment_of(&excess, &moments, m),
                Some(whole) => psi - whole[place(m[0], m[1])],
            };
            [u1, u2, normal]
        });
        let by_slip = slip.by_slip.map(|entries| entries.map(|entry| mu * entry));
        let damped = plane.pressure.map(|p| -d * p);
        let parting = product(&plane.pressure, &plane.separating()).map(|c| -c);
        let load = product(&plane.pressure, &traction.damping);
        let linear = [[0, 0], [1, 0], [0, 1]];
        Self {
            traction: linear.map(|m| {
                [0, 1, 2].map(|axis| {
                    let of_axis = by_pressure.map(|moment| moment[axis]);
                    affine_moment(&plane.pressure, &of_axis, m)
                })
            }),
            by_pressure,
            by_velocity: [
                by_slip.map(|[t11, t12, _]| [t11, t12, 0.0]),
                by_slip.map(|[_, t12, t22]| [t12, t22, 0.0]),
                EXPONENTS.map(|m| pushed(&damped, m)),
            ],
            by_dissipation: linear.map(|m| pushed(&parting, m)),
            by_friction: linear.map(|m| {
                let [u1, u2] = direction.each_ref().map(|u| moment_of(&load, u, m));
                [-u1, -u2, 0.0]
            }),
        }
    }
}

/// As [`moment_of`] for an affine function, from six moments.
fn affine_moment(f: &[f64; 3], moments: &[f64; 6], [a, b]: [usize; 2]) -> f64 {
    f[0] * moments[place(a, b)] + f[1] * moments[place(a + 1, b)] + f[2] * moments[place(a, b + 1)]
}
