use super::linearized::block_diagonal;
use super::polygon_source::PolygonSource;
use super::reaction::on_both;
use super::response::{Barycentric, OfCell, PolygonResponse};
use super::{BodyError, ContactPair, LinearizedContact, PartnerShape};
use crate::mesh::{MeshError, ShapeRates};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6};

/// Derivatives of a number with respect to the shape of a body: the positions of the vertices of its mesh or surface, and their extents.
///
/// Vertices move in the body's frame, while its pose, the modulus and all extents are constant. The chain rule gives the derivatives with
/// respect to the dimensions of a ready-made shape, or to the mesh from which a field of distances was computed: see [`Self::along`] and
/// [`LinearizedDistances::pullback`](crate::mesh::LinearizedDistances::pullback).
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct ShapeGradient {
    /// Derivatives with respect to each vertex, in the axes of the body's frame (the number's unit over m). Empty for a half-space and for
    /// a body without a shape.
    pub by_vertices: Vec<Vector3<f64>>,
    /// Derivatives with respect to the extent of each vertex (the number's unit over the extents'). Empty for a rigid body, for a
    /// half-space and for a body without a shape.
    pub by_extents: Vec<f64>,
}

impl ShapeGradient {
    /// Creates zero derivatives for a shape.
    pub(crate) fn zero(shape: PartnerShape) -> Self {
        let (vertices, extents) = shape.number_counts();
        Self {
            by_vertices: vec![Vector3::zeros(); vertices],
            by_extents: vec![0.0; extents],
        }
    }

    /// Returns the derivative as vertices move and extents change at these rates, by the chain rule: the derivative with respect to the
    /// parameter of the rates. Ready-made shapes have rates with respect to their dimensions in [`shapes`](crate::mesh::shapes).
    ///
    /// # Errors
    /// Returns an error if the numbers of velocities and vertices differ, or if a rate is not finite. Returns an error also if there are
    /// extents, and the numbers of rates and extents differ.
    pub fn along(&self, rates: &ShapeRates) -> Result<f64, MeshError> {
        rates.dot(&self.by_vertices, &self.by_extents)
    }

    /// Adds the contribution of one polygon to the gradients of A and of B, from the vertices of both cells. The derivatives are in A's axes.
    pub(super) fn add_polygon(
        [of_a, of_b]: [&mut Self; 2],
        vertices: [[Option<usize>; 4]; 2],
        [in_a, in_b]: &[OfCell; 2],
        rotation_ba: &Matrix3<f64>,
    ) {
        of_a.add(vertices[0], in_a);
        of_b.add(vertices[1], &in_b.rotated(rotation_ba));
    }

    /// Adds the derivatives with respect to each corner of a cell that is a vertex of the shape.
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
    /// Returns the derivatives of a number with respect to the shapes of A and of B, from its derivatives with respect to the wrenches
    /// (rows of [`LinearizedContact`]: torque and force on A, then on B).
    ///
    /// This is the transposed Jacobian times a vector. It takes as long as a Jacobian, for all vertices together, and is computed in closed
    /// form from the same contact polygons. Moving a vertex of B by δ takes λ ∇p_B·δ from p_B, where λ is the vertex's barycentric
    /// coordinate. The contact surface moves by the same amount over |g|, g = ∇p_A − ∇p_B, against its normal. With x from A's origin, this
    /// gives
    ///
    /// ∂W/∂xᵢ = −Σ (1/|g|) ∫ (x × ∇p_A, ∇p_A) λᵢ ∇p_Bᵀ dA,
    ///
    /// For A's vertices, exchange A and B, and W and −W. The formula also holds for surface vertices, and nothing is differentiated through
    /// a clip.
    ///
    /// If faces of both bodies are flush, the derivatives with respect to all vertices together give the derivatives with respect to the
    /// pose, about one generic direction. The sum of the derivatives with respect to all extents, each times its extent, is the derivative
    /// with respect to the modulus, times the modulus. The derivative with respect to a single vertex need not lie between the derivatives
    /// of both sides if the vertex moves at an angle to the face. If fields are equal over a volume
    /// ([`Kinks::are_equal`](crate::contact::Kinks)), the sums may differ from the derivatives with respect to pose and modulus.
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
        let (_, response) = self.linearized_with_shapes();
        response.pull_back(by_wrenches, [&mut of_a, &mut of_b]);
        [of_a, of_b]
    }

    /// Returns the derivatives of both wrenches (rows as in [`LinearizedContact`]) with respect to some vertices of A and of B (m), in the
    /// axes of their bodies' frames. One vertex takes as long as all of them.
    ///
    /// # Errors
    /// Returns an error if a body has no vertex with a given index.
    pub fn vertex_jacobians(
        &self,
        vertices: [&[usize]; 2],
    ) -> Result<[Vec<SMatrix<f64, 12, 3>>; 2], BodyError> {
        let unit = |row: usize| Vector6::from_fn(|i, _| if i == row { 1.0 } else { 0.0 });
        let mut rows = [0, 1, 2, 3, 4, 5].map(|_| self.shapes().map(ShapeGradient::zero));
        let gradients = rows.each_mut().map(|[of_a, of_b]| [of_a, of_b]);
        let (_, response) = self.linearized_with_shapes();
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

    pub(super) fn shapes(&self) -> [PartnerShape<'_>; 2] {
        [
            PartnerShape::Compliant(self.a().shape()),
            self.b().partner_shape(),
        ]
    }
}

/// The derivatives of the wrenches of a contact with respect to the two shapes.
pub(crate) struct ShapeResponse<'a> {
    pair: ContactPair<'a>,
    polygons: Vec<PolygonResponse>,
}

impl<'a> ContactPair<'a> {
    /// Linearizes the contact, including derivatives with respect to the shapes.
    pub(crate) fn linearized_with_shapes(&self) -> (LinearizedContact, ShapeResponse<'a>) {
        let (relative, polygons) = self.relative_linearization();
        let pair = *self;
        (relative.in_world(self), ShapeResponse { pair, polygons })
    }
}

impl ShapeResponse<'_> {
    /// Adds the derivatives of a number with respect to both shapes, from its derivatives with respect to the wrenches: see
    /// [`ContactPair::shape_gradients`].
    pub fn pull_back(&self, by_wrenches: &SVector<f64, 12>, gradients: [&mut ShapeGradient; 2]) {
        let (pose_wa, pose_wb) = (self.pair.a().pose(), self.pair.b().pose());
        let from_a_to_b = pose_wb.translation() - pose_wa.translation();
        let by_wrench_a = on_both(&from_a_to_b, &block_diagonal(pose_wa.rotation()));
        let covector = by_wrench_a.tr_mul(by_wrenches);
        self.pull_back_relative(&[covector], [gradients]);
    }

    /// Adds the derivatives of several numbers, from their derivatives with respect to the wrench on A, in A's axes about A's origin.
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
                let cells = polygon.pulled_back(covector, source.moduli(), &barycentric);
                ShapeGradient::add_polygon([of_a, of_b], vertices, &cells, &rotation_ba);
            }
        }
    }
}

impl PolygonSource<'_, f64> {
    /// Returns the barycentric coordinates of two cells, in A's frame.
    pub fn barycentric(&self, [a, b]: [usize; 2]) -> Barycentric {
        let [a, b] = [self.pair.tet_a(a), self.pair.tet_b(b)];
        let of_b = b
            .barycentric
            .each_ref()
            .map(|field| field.posed(&self.pose_ab));
        [a.barycentric, of_b]
    }
}
