use super::linearised::{block_diagonal, on_both};
use super::polygon::{CutPolygon, CutSurface, PolygonSource};
use super::surface_law::RelativeMotion;
use super::{BodyError, ContactPair, PartnerShape, SurfaceLaw};
use crate::geometry::AffineField;
use crate::narrow_phase::{COINCIDENCE, Cut, ELASTIC_COINCIDENCE};
use crate::spatial::Twist;
use nalgebra::{SMatrix, SVector, Vector3, Vector6};

/// The derivatives of a number by the shape of a body: by where the vertices of its mesh or surface are, and by their extents.
///
/// Vertices are moved in the body's frame, while its pose, the modulus and all extents stay as they are. Extents that depend
/// on where vertices are, as distances to the surface do, have derivatives of their own, to be added by the chain rule.
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

    /// The derivative as the vertices move at these velocities: the chain rule for any number that they depend on.
    ///
    /// # Panics
    /// If there are not as many velocities as vertices.
    #[must_use]
    pub fn along(&self, velocities: &[Vector3<f64>]) -> f64 {
        assert_eq!(
            velocities.len(),
            self.by_vertices.len(),
            "one velocity for each vertex"
        );
        let pairs = self.by_vertices.iter().zip(velocities);
        pairs
            .map(|(by_vertex, velocity)| by_vertex.dot(velocity))
            .sum()
    }

    /// Adds what one polygon contributes, from the cell's vertices to their places.
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

    fn rotate(&mut self, rotation: &nalgebra::Matrix3<f64>) {
        for by_vertex in &mut self.by_vertices {
            *by_vertex = rotation * *by_vertex;
        }
    }
}

impl ContactPair<'_> {
    /// The derivatives, by the shapes of A and of B, of a number that has these derivatives by the elastic wrenches (rows of
    /// [`LinearisedContact`](super::LinearisedContact): torque and force on A, then on B).
    ///
    /// A product with a vector from the left, at the cost of a Jacobian: all vertices at once, in closed form, from the same
    /// contact polygons. Moving a vertex of B by δ takes λ ∇p_B·δ from p_B, where λ is the vertex's barycentric coordinate, and
    /// the contact surface moves by as much over |g|, g = ∇p_A − ∇p_B, against its normal. So with x from A's origin
    ///
    /// ∂W/∂xᵢ = −Σ (1/|g|) ∫ (x × ∇p_A, ∇p_A) λᵢ ∇p_Bᵀ dA,
    ///
    /// and with A and B exchanged, and W for −W, for A's vertices. Surface vertices are no exception, and nothing is
    /// differentiated through a clip. Where faces of both bodies are flush, the derivatives by all vertices together give those
    /// by the pose, about one generic direction; those by one vertex may be one-sided.
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
    /// // A larger ball is pressed in further: x → (1 + s)x.
    /// assert!(by_ball.along(ball.field().mesh().vertices()) > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn shape_gradients(&self, by_wrenches: &SVector<f64, 12>) -> [ShapeGradient; 2] {
        self.shape_gradients_of(None, by_wrenches)
    }

    /// [`Self::shape_gradients`] of the wrenches of moving bodies, with law and twists as of [`Self::wrench_in_motion`].
    ///
    /// What the law adds jumps from polygon to polygon, so that the motion of their edges counts too: that of the faces that
    /// they lie in.
    #[must_use]
    pub fn shape_gradients_in_motion(
        &self,
        law: &SurfaceLaw,
        twists: [Twist; 2],
        by_wrenches: &SVector<f64, 12>,
    ) -> [ShapeGradient; 2] {
        self.shape_gradients_of(Some((law, twists)), by_wrenches)
    }

    /// The derivatives of both wrenches (rows as of [`LinearisedContact`](super::LinearisedContact)) by some vertices of A and
    /// of B, in the axes of their bodies' frames: of the elastic wrenches or, with a law and twists as of
    /// [`Self::wrench_in_motion`], of those of moving bodies. A vertex takes as long as all.
    ///
    /// # Errors
    /// If a body has no vertex of such an index.
    pub fn vertex_jacobians(
        &self,
        moving: Option<(&SurfaceLaw, [Twist; 2])>,
        vertices: [&[usize]; 2],
    ) -> Result<[Vec<SMatrix<f64, 12, 3>>; 2], BodyError> {
        let unit = |row: usize| Vector6::from_fn(|i, _| if i == row { 1.0 } else { 0.0 });
        let rows = self.relative_shape_gradients(moving, &[0, 1, 2, 3, 4, 5].map(unit));
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

    pub(crate) fn shape_gradients_of(
        &self,
        moving: Option<(&SurfaceLaw, [Twist; 2])>,
        by_wrenches: &SVector<f64, 12>,
    ) -> [ShapeGradient; 2] {
        let (pose_wa, pose_wb) = (self.a().pose(), self.b().pose());
        let from_a_to_b = pose_wb.translation() - pose_wa.translation();
        let by_wrench_a = on_both(&from_a_to_b, &block_diagonal(pose_wa.rotation()));
        let covector = by_wrench_a.tr_mul(by_wrenches);
        let [gradients] = self.relative_shape_gradients(moving, &[covector]);
        gradients
    }

    /// Of numbers that have these derivatives by the wrench on A, in A's axes about A's origin.
    fn relative_shape_gradients<const N: usize>(
        &self,
        moving: Option<(&SurfaceLaw, [Twist; 2])>,
        covectors: &[Vector6<f64>; N],
    ) -> [[ShapeGradient; 2]; N] {
        let moving = moving.filter(|(law, _)| !law.is_elastic());
        let moving = moving.map(|(law, twists)| (law, RelativeMotion::of(self, twists)));
        let octaves = if moving.is_some() {
            COINCIDENCE
        } else {
            ELASTIC_COINCIDENCE
        };
        let source = PolygonSource::of(&self.real());
        let (surface, _) = source.for_derivatives(octaves, self.search());
        let moving = moving.as_ref().map(|(law, motion)| (*law, motion));
        let shares = surface.shape_shares(moving, covectors);
        let shapes = [PartnerShape::Compliant(self.a().shape()), self.b().kind()];
        let rotation_ba = source.pose_ab.rotation().transpose();
        std::array::from_fn(|of| {
            let mut gradients = shapes.map(ShapeGradient::zero);
            for (tets, shares) in &shares {
                for body in 0..2 {
                    let vertices = shapes[body].corner_vertices(tets[body]);
                    gradients[body].add(vertices, &shares[of].0[body]);
                }
            }
            gradients[1].rotate(&rotation_ba);
            gradients
        })
    }
}

/// What a polygon contributes by the corners of a cell (in A's axes) and their extents.
#[derive(Debug, Clone, Copy)]
struct OfCell {
    by_corners: [Vector3<f64>; 4],
    by_extents: [f64; 4],
}

/// What a polygon contributes by the two cells that it lies in.
#[derive(Debug, Clone, Copy)]
pub(super) struct PolygonShare([OfCell; 2]);

/// The barycentric coordinates of the two cells, in A's frame.
pub(super) type Barycentric = [[AffineField; 4]; 2];

impl CutSurface<'_, f64> {
    /// What each polygon contributes, with its cells.
    fn shape_shares<const N: usize>(
        &self,
        moving: Option<(&SurfaceLaw, &RelativeMotion<f64>)>,
        covectors: &[Vector6<f64>; N],
    ) -> Vec<([usize; 2], [PolygonShare; N])> {
        let source = &self.source;
        self.sum_of_cuts(|shares: &mut Vec<_>, cut| {
            let polygon = source.polygon(cut);
            let has_area = polygon.has_area() && polygon.weights.have_area();
            if !has_area && moving.is_none() {
                return;
            }
            let barycentric = source.barycentric(cut);
            let mut of_polygon = [PolygonShare::none(); N];
            if has_area {
                for (share, covector) in of_polygon.iter_mut().zip(covectors) {
                    share.add_elastic(&polygon, covector, source.moduli(), &barycentric);
                }
            }
            if let Some(moving) = moving {
                let cut = (cut, &polygon, &barycentric);
                source.add_traction_shares(cut, moving, covectors, &mut of_polygon);
            }
            shares.push((cut.tets, of_polygon));
        })
    }
}

impl PolygonSource<'_, f64> {
    fn barycentric(&self, cut: &Cut) -> Barycentric {
        let [a, b] = [self.pair.tet_a(cut.tets[0]), self.pair.tet_b(cut.tets[1])];
        let of_b = b
            .barycentric
            .each_ref()
            .map(|field| field.posed(&self.pose_ab));
        [a.barycentric, of_b]
    }
}

/// A linear function of functions f that are affine on a polygon's plane: `value`·f(`at`) + `slope`·∇f.
#[derive(Debug, Clone, Copy)]
pub(super) struct AffineForm {
    pub at: Vector3<f64>,
    pub value: f64,
    pub slope: Vector3<f64>,
}

impl AffineForm {
    fn of(&self, f: &AffineField) -> f64 {
        self.value * f.at(&self.at) + self.slope.dot(&f.gradient)
    }

    fn scaled(&self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            slope: self.slope * factor,
            ..*self
        }
    }
}

impl PolygonShare {
    fn none() -> Self {
        let none = OfCell {
            by_corners: [Vector3::zeros(); 4],
            by_extents: [0.0; 4],
        };
        Self([none; 2])
    }

    /// Adds the elastic part, for a number with this derivative by the wrench on A about A's origin: with the velocity u of the
    /// twist that the covector is, ∫ f ∇p_A·u dA as p_B grows by f|g|, and −∫ f ∇p_B·u dA as p_A does.
    fn add_elastic(
        &mut self,
        polygon: &CutPolygon<f64>,
        covector: &Vector6<f64>,
        moduli: [f64; 2],
        barycentric: &Barycentric,
    ) {
        let [slope_a, slope_b] = [&polygon.pressure_a.gradient, &polygon.plane.slopes[1]];
        let by_growth_b = polygon.flow(slope_a, covector);
        self.add_growth_of_b(polygon, moduli[1], [&by_growth_b; 2], &barycentric[1]);
        let by_growth_a = polygon.flow(slope_b, covector).scaled(-1.0);
        self.add_growth_of_a(polygon, moduli[0], [&by_growth_a; 2], &barycentric[0]);
    }

    /// Adds what follows from changes of p_B/|g|, by motions of the corners and by their extents.
    pub fn add_growth_of_b(
        &mut self,
        polygon: &CutPolygon<f64>,
        modulus: f64,
        by_growth: [&AffineForm; 2],
        barycentric: &[AffineField; 4],
    ) {
        let plane = &polygon.plane;
        self.0[1].add(
            &plane.slopes[1],
            modulus * plane.yielding,
            by_growth,
            barycentric,
        );
    }

    /// Adds what follows from changes of p_A, by motions of the corners and by their extents.
    pub fn add_growth_of_a(
        &mut self,
        polygon: &CutPolygon<f64>,
        modulus: f64,
        by_growth: [&AffineForm; 2],
        barycentric: &[AffineField; 4],
    ) {
        self.0[0].add(
            &polygon.pressure_a.gradient,
            modulus,
            by_growth,
            barycentric,
        );
    }

    /// Adds what follows from the motion of a face (0 to 3 of A, 4 to 7 of B) along its normal.
    pub fn add_motion_of_face(
        &mut self,
        face: usize,
        normal: &Vector3<f64>,
        by_speed: &AffineForm,
        barycentric: &Barycentric,
    ) {
        let (body, opposite) = (face / 4, face % 4);
        for corner in (0..4).filter(|&corner| corner != opposite) {
            let speed = by_speed.of(&barycentric[body][corner]);
            self.0[body].by_corners[corner] += normal * speed;
        }
    }
}

impl OfCell {
    /// A corner that moves by δ takes λ `gradient`·δ from the field, and its extent adds λ `modulus`.
    fn add(
        &mut self,
        gradient: &Vector3<f64>,
        modulus: f64,
        [by_motion, by_extent]: [&AffineForm; 2],
        barycentric: &[AffineField; 4],
    ) {
        for (corner, coordinate) in barycentric.iter().enumerate() {
            self.by_corners[corner] -= gradient * by_motion.of(coordinate);
            self.by_extents[corner] += modulus * by_extent.of(coordinate);
        }
    }
}

impl CutPolygon<f64> {
    /// f ↦ ∫ f a·u dA, where u is the velocity of a twist about the origin (its moment, then its force).
    fn flow(&self, a: &Vector3<f64>, twist: &Vector6<f64>) -> AffineForm {
        let (moment, force) = (twist.fixed_rows::<3>(0), twist.fixed_rows::<3>(3));
        let moments = &self.moments;
        let weight = self.weights.moving.area();
        let at_reference = a.dot(&(force + moment.cross(&moments.reference)));
        let gradient = a.cross(&moment);
        let value = at_reference * moments.area + gradient.dot(&moments.first);
        AffineForm {
            at: moments.reference,
            value: value * weight,
            slope: (moments.first * at_reference + moments.second * gradient) * weight,
        }
    }
}
