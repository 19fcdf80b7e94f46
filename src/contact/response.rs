//! The response of the wrench of one polygon to changes of the two fields that meet in it, and of the faces that bound it.

use super::affine_form::AffineForm;
use super::plane_polygon::PlanePolygon;
use super::polygon_fields::PolygonFields;
use super::sums::PartialSum;
use crate::geometry::AffineField;
use crate::narrow_phase::{Octet, Weight, Weights};
use nalgebra::{Matrix3, Vector3, Vector6};

/// Data that is kept for each polygon while a contact is linearized: nothing, `()`, or the response to changes of shape,
/// [`PolygonResponse`].
pub(super) trait Responses: PartialSum {
    /// Whether responses are kept.
    const ARE_KEPT: bool;

    /// Keeps the response of a polygon.
    fn keep(&mut self, response: impl FnOnce() -> PolygonResponse);

    /// Creates the data from the responses of several polygons. It is empty if nothing is kept.
    fn of(responses: Vec<PolygonResponse>) -> Self;
}

impl Responses for () {
    const ARE_KEPT: bool = false;

    fn keep(&mut self, _: impl FnOnce() -> PolygonResponse) {}

    fn of(_: Vec<PolygonResponse>) -> Self {}
}

impl Responses for Vec<PolygonResponse> {
    const ARE_KEPT: bool = true;

    fn keep(&mut self, response: impl FnOnce() -> PolygonResponse) {
        self.push(response());
    }

    fn of(responses: Vec<PolygonResponse>) -> Self {
        responses
    }
}

/// Derivatives of the wrench of one polygon on A, in A's axes. They are derivatives with respect to the fields p_A and p_B, and with
/// respect to the faces of both cells. Their form is the input of [`Self::pulled_back`].
pub(super) struct PolygonResponse {
    pub tets: [usize; 2],
    plane: PolygonFields<f64>,
    weights: Weights,
    /// The contribution of the surface law, if there is one.
    pub law: Option<LawResponse>,
}

/// The contribution of dissipation and friction, about the origin of the polygon's plane along its axes.
#[derive(Default)]
pub(super) struct LawResponse {
    /// Derivatives as the plane moves along its normal at the speeds 1, y₁ and y₂.
    pub by_speed: [Vector6<f64>; 3],
    /// Correction of `by_speed` for growing fields, if any (see [`Weights`]).
    pub modulus_correction: Option<Box<[Vector6<f64>; 3]>>,
    /// Derivatives as the pressure grows by 1, y₁ and y₂, over the whole polygon without its weights.
    pub by_pressure: [Vector6<f64>; 3],
    pub by_faces: Vec<FaceResponse>,
}

/// The contribution of a face that moves an edge.
pub(super) struct FaceResponse {
    /// The body of the face: 0 for A, 1 for B.
    pub body: usize,
    /// The corner of the cell opposite to the face.
    pub opposite: usize,
    /// Outward normal, in A's axes.
    pub normal: Vector3<f64>,
    /// Derivatives as the face moves along its normal at the speeds 1, y₁ and y₂.
    pub by_speed: [Vector6<f64>; 3],
}

/// Contribution of a polygon to the derivatives of a number with respect to the corners of a cell (in A's axes) and their extents.
#[derive(Debug, Clone, Copy)]
pub(super) struct OfCell {
    pub by_corners: [Vector3<f64>; 4],
    pub by_extents: [f64; 4],
}

/// The barycentric coordinates of the two cells, in A's frame.
pub(super) type Barycentric = [[AffineField; 4]; 2];

impl PolygonResponse {
    /// Creates the elastic response of a polygon.
    pub fn of(tets: [usize; 2], polygon: &PlanePolygon<f64>) -> Self {
        let mut plane = polygon.plane;
        if !polygon.has_counted_area() {
            plane.moments = [0.0; 6];
        }
        Self {
            tets,
            plane,
            weights: polygon.weights,
            law: None,
        }
    }

    /// Creates the elastic response of the polygon at an index of an octet.
    pub fn at(octet: &Octet, index: usize) -> Self {
        Self {
            tets: octet.tets()[index].map(|tet| tet as usize),
            plane: PolygonFields::at(octet, index),
            weights: Weights::WHOLE,
            law: None,
        }
    }

    /// Returns the response with an empty contribution of the surface law, to which terms are added later.
    pub fn with_law(self) -> Self {
        Self {
            law: Some(LawResponse::default()),
            ..self
        }
    }

    /// Returns the contribution to the derivatives of a number with this derivative with respect to the wrench on A about A's origin.
    ///
    /// If p_B grows by δ, the plane moves by δ/|g|, and the elastic wrench changes by ∫ δ s_A/|g| dA. If p_A grows by δ, the wrench changes
    /// by −∫ δ s_B/|g| dA (see [`RelativeJacobian`](super::jacobian::RelativeJacobian)). The contribution of the law changes by K as the
    /// plane moves. As p_A grows, the plane moves by −δ/|g|, and the pressure at a fixed point grows too.
    ///
    /// A moving corner is a motion, and a growing extent is the growth of a field. The polygon counts with the corresponding weight (see
    /// [`Weights`]).
    pub fn pulled_back(
        &self,
        covector: &Vector6<f64>,
        moduli: [f64; 2],
        barycentric: &Barycentric,
    ) -> [OfCell; 2] {
        let [_, slope_b] = self.plane.slopes;
        let elastic = [
            self.flow(slope_b, covector, -1.0),
            self.flow(self.plane.gradient_a, covector, 1.0),
        ];
        let [moving, still] = [self.weights.moving, self.weights.still].map(Weight::area);
        let forms = [moving, still].map(|weight| elastic.map(|form| form * weight));
        let law = self.law.as_ref().map(|law| (law, self.in_plane(covector)));
        self.with_law_on(law.as_slice(), forms, moduli, barycentric)
    }

    /// Returns the contributions of the growth of p_A and p_B, as corners move and as extents grow. `forms` has the elastic contributions.
    /// Each entry of `parts` has the response of a part of the polygon, and the derivative of the loss with respect to the wrench on this
    /// part, transformed by [`Self::in_plane`].
    pub fn with_law_on(
        &self,
        parts: &[(&LawResponse, Vector6<f64>)],
        mut forms: [[AffineForm; 2]; 2],
        moduli: [f64; 2],
        [in_a, in_b]: &Barycentric,
    ) -> [OfCell; 2] {
        let weights = [self.weights.moving, self.weights.still].map(Weight::area);
        for (law, covector) in parts {
            let form = |wrenches: &[Vector6<f64>; 3]| self.contracted(covector, wrenches);
            let by_pressure = form(&law.by_pressure);
            let mut by_speed = [form(&law.by_speed); 2];
            if let Some(more) = &law.modulus_correction {
                by_speed[1] = by_speed[1] + form(more);
            }
            for ((forms, by_speed), weight) in forms.iter_mut().zip(by_speed).zip(weights) {
                let by_plane = by_speed * -self.plane.inverse_gradient_norm;
                *forms = [
                    forms[0] + by_pressure * weight + by_plane,
                    forms[1] + by_speed,
                ];
            }
        }
        let mut cells = self.of_fields(forms, moduli, [in_a, in_b]);
        for (law, covector) in parts {
            for face in &law.by_faces {
                let by_speed = self.contracted(covector, &face.by_speed);
                let coordinates = [in_a, in_b][face.body];
                for corner in (0..4).filter(|&corner| corner != face.opposite) {
                    let by_corner = face.normal * by_speed.of(&coordinates[corner]);
                    cells[face.body].by_corners[corner] += by_corner;
                }
            }
        }
        cells
    }

    /// Returns the contributions of the growth of p_A and of p_B, as corners move and as extents grow.
    fn of_fields(
        &self,
        [by_motion, by_growth]: [[AffineForm; 2]; 2],
        moduli: [f64; 2],
        [in_a, in_b]: [&[AffineField; 4]; 2],
    ) -> [OfCell; 2] {
        let scale_b = moduli[1] * self.plane.inverse_gradient_norm;
        [
            OfCell::of(
                (&self.plane.gradient_a.into(), &by_motion[0]),
                (moduli[0], &by_growth[0]),
                in_a,
            ),
            OfCell::of(
                (&self.plane.slopes[1].into(), &by_motion[1]),
                (scale_b, &by_growth[1]),
                in_b,
            ),
        ]
    }

    /// Returns f ↦ ∫ f a·u dA over the whole polygon, times a factor. Here u is the velocity of a twist about the origin (its moment, then
    /// its force).
    fn flow(&self, a: [f64; 3], twist: &Vector6<f64>, factor: f64) -> AffineForm {
        let (origin, [e1, e2, _]) = (self.origin(), self.axes());
        let [moment, force] =
            [0, 3].map(|first| twist.fixed_rows::<3>(first).into_owned() * factor);
        let a = Vector3::from(a);
        // a·u = c₀ + c₁y₁ + c₂y₂.
        let turned = a.cross(&moment);
        let c0 = a.dot(&(force + moment.cross(&origin)));
        let [c1, c2] = [e1.dot(&turned), e2.dot(&turned)];
        let [area, y1, y2, y11, y12, y22] = self.plane.moments;
        let value = c0 * area + c1 * y1 + c2 * y2;
        let by_y1 = c0 * y1 + c1 * y11 + c2 * y12;
        let by_y2 = c0 * y2 + c1 * y12 + c2 * y22;
        AffineForm::about(&origin, value, e1 * by_y1 + e2 * by_y2)
    }

    fn origin(&self) -> Vector3<f64> {
        self.plane.origin.into()
    }

    fn axes(&self) -> [Vector3<f64>; 3] {
        self.plane.axes.map(Into::into)
    }

    /// Transforms a derivative with respect to a wrench about A's origin to one with respect to a wrench about the origin of the plane
    /// along its axes.
    pub fn in_plane(&self, covector: &Vector6<f64>) -> Vector6<f64> {
        let moment: Vector3<f64> = covector.fixed_rows::<3>(0).into_owned();
        let force = covector.fixed_rows::<3>(3) + moment.cross(&self.origin());
        let axes = Matrix3::from_columns(&self.axes());
        let [moment, force] = [moment, force].map(|vector| axes.tr_mul(&vector));
        Vector6::new(moment.x, moment.y, moment.z, force.x, force.y, force.z)
    }

    /// Contracts the wrenches of 1, y₁ and y₂ with a derivative with respect to the wrench.
    fn contracted(&self, covector: &Vector6<f64>, wrenches: &[Vector6<f64>; 3]) -> AffineForm {
        let [at_origin, y1, y2] = wrenches.each_ref().map(|wrench| covector.dot(wrench));
        let [e1, e2, _] = self.axes();
        AffineForm::about(&self.origin(), at_origin, e1 * y1 + e2 * y2)
    }
}

impl OfCell {
    /// Computes the contribution from two linear functions. A corner that moves by δ takes λ `gradient`·δ from the field, and its extent
    /// adds λ `modulus`.
    fn of(
        (gradient, by_motion): (&Vector3<f64>, &AffineForm),
        (modulus, by_growth): (f64, &AffineForm),
        barycentric: &[AffineField; 4],
    ) -> Self {
        Self {
            by_corners: barycentric
                .each_ref()
                .map(|of| gradient * -by_motion.of(of)),
            by_extents: barycentric.each_ref().map(|of| modulus * by_growth.of(of)),
        }
    }

    /// Returns the contribution in other axes.
    pub fn rotated(&self, rotation: &Matrix3<f64>) -> Self {
        Self {
            by_corners: self.by_corners.map(|by_corner| rotation * by_corner),
            ..*self
        }
    }
}
