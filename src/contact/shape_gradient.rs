use super::linearised::block_diagonal;
use super::polygon_source::PolygonSource;
use super::reaction::on_both;
use super::response::{Barycentric, OfCell, PolygonResponse};
use super::{BodyError, ContactPair, LinearisedContact, PartnerShape};
use crate::mesh::{MeshError, ShapeRates};
use nalgebra::{SMatrix, SVector, Vector3, Vector6};

/// The derivatives of a number by the shape of a body: by where the vertices of its mesh or surface are, and by their extents.
///
/// Vertices are moved in the body's frame, while its pose, the modulus and all extents stay as they are. To the
/// dimensions of a ready-made shape, or the mesh that a field was made of by distances, the chain rule leads: [`Self::along`],
/// [`LinearisedDistances::pullback`](crate::mesh::LinearisedDistances::pullback).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ShapeGradient {
    /// By each vertex, in the axes of the body's frame (the number's unit over m). None for a half-space.
    pub by_vertices: Vec<Vector3<f64>>,
    /// By the extent of each vertex (the number's unit over the extents'). None for a rigid body or a half-space.
    pub by_extents: Vec<f64>,
}

impl ShapeGradient {
    /// Of what depends on no vertex of a shape.
    pub(crate) fn zero(shape: PartnerShape) -> Self {
        let (vertices, extents) = shape.number_counts();
        Self {
            by_vertices: vec![Vector3::zeros(); vertices],
            by_extents: vec![0.0; extents],
        }
    }

    /// The derivative as vertices move and extents change at these rates, by the chain rule: that by the number which the rates are
    /// by. Ready-made shapes have rates by their dimensions in [`shapes`](crate::mesh::shapes).
    ///
    /// # Errors
    /// If there are not as many velocities as vertices, or, where there are any, not as many rates of extents as extents; or if
    /// one is not finite.
    pub fn along(&self, rates: &ShapeRates) -> Result<f64, MeshError> {
        rates.dot(&self.by_vertices, &self.by_extents)
    }

    /// Adds what one polygon contributes: by each corner of a cell to the vertex of the shape that it is, if it is one.
    fn add(&mut self, vertices: [Option<usize>; 4], of_body: &OfCell) {
        let corners = vertices.iter().zip(&of_body.by_corners);
        for (vertex, by_corner) in corners.filter_map(|(vertex, by)| vertex.zip(Some(by))) {
            self.by_vertices[vertex] += by_corner;
        }
        if self.by_extents.is_empty() {
            return;
        }
        let extents = vertices.iter().zip(&of_body.by_extents);
        for (vertex, by_extent) in extents.filter_map(|(vertex, by)| vertex.zip(Some(by))) {
            self.by_extents[vertex] += by_extent;
        }
    }
}

impl ContactPair<'_> {
    /// The derivatives, by the shapes of A and of B, of a number that has these derivatives by the wrenches (rows of
    /// [`LinearisedContact`]: torque and force on A, then on B).
    ///
    /// A product with a vector from the left, at the cost of a Jacobian: all vertices at once, in closed form, from the same
    /// contact polygons. Moving a vertex of B by δ takes λ ∇p_B·δ from p_B, where λ is the vertex's barycentric coordinate, and
    /// the contact surface moves by as much over |g|, g = ∇p_A − ∇p_B, against its normal. So with x from A's origin
    ///
    /// ∂W/∂xᵢ = −Σ (1/|g|) ∫ (x × ∇p_A, ∇p_A) λᵢ ∇p_Bᵀ dA,
    ///
    /// and with A and B exchanged, and W for −W, for A's vertices. Surface vertices are no exception, and nothing is
    /// differentiated through a clip. Where faces of both bodies are flush, the derivatives by all vertices together give those
    /// by the pose, about one generic direction, and those by all extents, times these, add up to that by the modulus, times this.
    /// That by a single vertex need not lie between those of both sides, where the vertex moves at an angle to the face. Where
    /// fields are equal over a volume ([`Kinks::are_equal`](crate::contact::Kinks)), the sums need not be those by pose and
    /// modulus.
    ///
    /// ```
    /// use hydroelastic::contact::{ContactBody, ContactPair, Partner, Shape};
    /// use hydroelastic::mesh::shapes;
    /// use hydroelastic::spatial::Pose;
    /// use nalgebra::{SVector, vector};
    ///
    /// let ball = Shape::new(shapes::icosphere(0.1, 2)?);
    /// let above = Pose::from_translation(vector![0.0, 0.0, 0.095]);
    /// let pair = ContactPair::new(
    ///     ContactBody::new(&ball, above, 1e5)?,
    ///     Partner::rigid_half_space(Pose::identity())?,
    /// );
    /// let force_along_z = SVector::from_fn(|row, _| if row == 5 { 1.0 } else { 0.0 });
    /// let [by_ball, _] = pair.shape_gradients(&force_along_z);
    /// // A larger ball is pressed in further.
    /// assert!(by_ball.along(&shapes::icosphere_rates(0.1, 2)?)? > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn shape_gradients(&self, by_wrenches: &SVector<f64, 12>) -> [ShapeGradient; 2] {
        let [mut of_a, mut of_b] = self.shapes().map(ShapeGradient::zero);
        let (_, response) = self.linearised_with_shapes();
        response.pull_back(by_wrenches, [&mut of_a, &mut of_b]);
        [of_a, of_b]
    }

    /// The derivatives of both wrenches (rows as of [`LinearisedContact`]) by some vertices of A and
    /// of B (m), in the axes of their bodies' frames. One vertex takes as long as all of them.
    ///
    /// # Errors
    /// If a body has no vertex of such an index.
    pub fn vertex_jacobians(
        &self,
        vertices: [&[usize]; 2],
    ) -> Result<[Vec<SMatrix<f64, 12, 3>>; 2], BodyError> {
        let unit = |row: usize| Vector6::from_fn(|i, _| if i == row { 1.0 } else { 0.0 });
        let mut rows = [0, 1, 2, 3, 4, 5].map(|_| self.shapes().map(ShapeGradient::zero));
        let gradients = rows.each_mut().map(|[of_a, of_b]| [of_a, of_b]);
        let (_, response) = self.linearised_with_shapes();
        response.pull_back_relative(&[0, 1, 2, 3, 4, 5].map(unit), gradients);
        let (pose_wa, pose_wb) = (self.a().pose(), self.b().pose());
        let from_a_to_b = pose_wb.translation() - pose_wa.translation();
        let turned = block_diagonal(pose_wa.rotation());
        let mut jacobians = [Vec::new(), Vec::new()];
        for (body, jacobians) in jacobians.iter_mut().enumerate() {
            let count = rows[0][body].by_vertices.len();
            for &vertex in vertices[body] {
                if vertex >= count {
                    return Err(BodyError::Vertex { vertex, count });
                }
                let by_vertex = |row: usize, axis| rows[row][body].by_vertices[vertex][axis];
                let on_a = turned * SMatrix::<f64, 6, 3>::from_fn(by_vertex);
                jacobians.push(on_both(&from_a_to_b, &on_a));
            }
        }
        Ok(jacobians)
    }

    fn shapes(&self) -> [PartnerShape<'_>; 2] {
        [
            PartnerShape::Compliant(self.a().shape()),
            self.b().partner_shape(),
        ]
    }
}

/// How the wrenches of a contact answer to changes of the two shapes.
pub(crate) struct ShapeResponse<'a> {
    pair: ContactPair<'a>,
    polygons: Vec<PolygonResponse>,
}

impl<'a> ContactPair<'a> {
    /// Linearizes the contact, including derivatives by the shapes.
    pub(crate) fn linearised_with_shapes(&self) -> (LinearisedContact, ShapeResponse<'a>) {
        let (relative, polygons) = self.relative_linearisation();
        let pair = *self;
        (relative.in_world(self), ShapeResponse { pair, polygons })
    }
}

impl ShapeResponse<'_> {
    /// Adds the derivatives by both shapes of a number that has these by the wrenches: see
    /// [`ContactPair::shape_gradients`].
    pub fn pull_back(&self, by_wrenches: &SVector<f64, 12>, gradients: [&mut ShapeGradient; 2]) {
        let (pose_wa, pose_wb) = (self.pair.a().pose(), self.pair.b().pose());
        let from_a_to_b = pose_wb.translation() - pose_wa.translation();
        let by_wrench_a = on_both(&from_a_to_b, &block_diagonal(pose_wa.rotation()));
        let covector = by_wrench_a.tr_mul(by_wrenches);
        self.pull_back_relative(&[covector], [gradients]);
    }

    /// The same of several numbers, from their derivatives by the wrench on A, in A's axes about A's origin.
    fn pull_back_relative<const N: usize>(
        &self,
        covectors: &[Vector6<f64>; N],
        mut gradients: [[&mut ShapeGradient; 2]; N],
    ) {
        let shapes = self.pair.shapes();
        let source = self.pair.real().source();
        let rotation_ba = source.pose_ab.rotation().transpose();
        for polygon in &self.polygons {
            let vertices = [0, 1].map(|body| shapes[body].corner_vertices(polygon.tets[body]));
            let barycentric = source.barycentric(polygon.tets);
            for ([of_a, of_b], covector) in gradients.iter_mut().zip(covectors) {
                let [in_a, in_b] = polygon.pulled_back(covector, source.moduli(), &barycentric);
                of_a.add(vertices[0], &in_a);
                of_b.add(vertices[1], &in_b.rotated(&rotation_ba));
            }
        }
    }
}

impl PolygonSource<'_, f64> {
    /// The barycentric coordinates of two cells, in A's frame.
    pub fn barycentric(&self, [a, b]: [usize; 2]) -> Barycentric {
        let [a, b] = [self.pair.tet_a(a), self.pair.tet_b(b)];
        let of_b = b
            .barycentric
            .each_ref()
            .map(|field| field.posed(&self.pose_ab));
        [a.barycentric, of_b]
    }
}
