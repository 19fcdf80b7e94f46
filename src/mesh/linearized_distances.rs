use super::distance::{MadeOfDistances, Passage};
use super::distance_fit::{DistanceFit, FittedTet};
use super::nearest_feet::{Dependence, EQUAL, dependences};
use super::shape_rates::{check_rates, check_velocities};
use super::skin::is_at_end;
use super::splitting::Center;
use super::{MeshError, ShapeRates, TetMesh};
use nalgebra::Vector3;

/// The linear map from the vertices of a mesh to the vertices and extents of a field made from its surface distances.
/// The field is made by [`PressureField::from_distance`](super::PressureField::from_distance),
/// [`from_distance_within`](super::PressureField::from_distance_within) or
/// [`from_distance_up_to`](super::PressureField::from_distance_up_to).
///
/// The field has more vertices than the mesh: those that split simplices, and the points where a skin ends on an
/// edge. All extents depend on the surface. Let d be the distance of a vertex x to its closest point Σ λᵥv, which lies
/// on the closest triangle. With n = (x − Σ λᵥv)/d, the derivative of d is n with respect to x, and −λᵥn with respect
/// to the triangle's vertices. Derivatives are exact up to rounding error, except where they do not exist (see
/// [`Self::ambiguous`]).
///
/// ```
/// use hydroelastic::contact::{ContactBody, ContactPair, Partner, Shape};
/// use hydroelastic::mesh::{PressureField, shapes};
/// use hydroelastic::spatial::Pose;
/// use nalgebra::{SVector, vector};
///
/// let mesh = shapes::ellipsoid([0.1, 0.08, 0.12], 2)?.mesh().clone();
/// let (field, distances) = PressureField::linearized_from_distance(&mesh)?;
/// let shape = Shape::new(field);
/// let pair = ContactPair::new(
///     ContactBody::new(&shape, Pose::from_translation(vector![0.0, 0.0, 0.11]), 1e5)?,
///     Partner::rigid_half_space(Pose::identity())?,
/// );
/// let force_along_z = SVector::from_fn(|row, _| if row == 5 { 1.0 } else { 0.0 });
/// let [by_shape, _] = pair.shape_gradients(&force_along_z);
/// let by_mesh = distances.pullback(&by_shape.by_vertices, &by_shape.by_extents)?;
/// assert_eq!(by_mesh.by_vertices.len(), mesh.vertex_count());
/// // The same derivative in forward mode: the change of the force as the mesh grows.
/// let grown = by_shape.along(&distances.rates(mesh.vertices())?)?;
/// let vertices = by_mesh.by_vertices.iter().zip(mesh.vertices());
/// let sum: f64 = vertices.map(|(by, vertex)| by.dot(vertex)).sum();
/// assert!((grown - sum).abs() < 1e-12 * grown.abs());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct LinearizedDistances {
    /// Number of vertices of the input mesh.
    vertex_count: usize,
    /// The points whose distances are measured, in addition to the vertices of the input mesh: further vertices, then centroids of `fit`.
    centers: Vec<Center>,
    dependences: Vec<Dependence>,
    /// Distances (m) to the surface of all vertices except `passages`, as `fit` fits them.
    distances: Vec<f64>,
    fit: Option<DistanceFit>,
    scale: Scale,
    passages: Vec<Passage>,
    ambiguous: Vec<usize>,
}

/// The derivatives of a scalar with respect to the mesh from which a field was made.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct DistanceGradient {
    /// Derivative with respect to each vertex of the mesh, in the axes of the body frame (unit of the scalar per m).
    pub by_vertices: Vec<Vector3<f64>>,
    /// Derivative with respect to the depth of the skin (unit of the scalar per m). It is 0 for a field without a skin.
    pub by_depth: f64,
}

/// The length by which distances are divided to obtain extents.
#[derive(Debug, Clone)]
enum Scale {
    /// The largest distance (m), with the vertices that have it.
    Largest(f64, Vec<usize>),
    /// The depth (m) of a skin. Extents are clamped to 1 beyond it.
    Depth(f64),
}

impl LinearizedDistances {
    /// Linearizes the field whose extents are the distances divided by the largest distance.
    pub(super) fn normalized(mesh: &TetMesh, made: MadeOfDistances) -> Self {
        let largest = made.distances.iter().copied().fold(0.0, f64::max);
        let equal = EQUAL * made.surface.size();
        let is_farthest = |&vertex: &usize| largest - made.distances[vertex] <= equal;
        let farthest: Vec<_> = (0..made.distances.len()).filter(is_farthest).collect();
        let equally_far = if farthest.len() > 1 {
            farthest.clone()
        } else {
            Vec::new()
        };
        Self::of(mesh, made, Scale::Largest(largest, farthest), equally_far)
    }

    /// Linearizes the field with a skin of this depth (m).
    pub(super) fn up_to(mesh: &TetMesh, made: MadeOfDistances, depth: f64) -> Self {
        let is_clamped = |&vertex: &usize| is_at_end(made.distances[vertex] / depth);
        let clamped = (0..made.distances.len()).filter(is_clamped).collect();
        Self::of(mesh, made, Scale::Depth(depth), clamped)
    }

    fn of(mesh: &TetMesh, made: MadeOfDistances, scale: Scale, mut ambiguous: Vec<usize>) -> Self {
        let (dependences, equally_near) = dependences(&made);
        let mut centers = made.centers;
        let mut distances = made.distances;
        let measured_count = distances.len();
        if let Some(fit) = &made.fit {
            centers.extend(fit.tets.iter().map(FittedTet::centroid));
            ambiguous.extend(fit.at_limits(&distances));
            distances = fit.of_distances(&distances);
        }
        for point in equally_near {
            match (point.checked_sub(measured_count), &made.fit) {
                (Some(tet), Some(fit)) => ambiguous.extend(fit.tets[tet].corners),
                _ => ambiguous.push(point),
            }
        }
        ambiguous.sort_unstable();
        ambiguous.dedup();
        Self {
            vertex_count: mesh.vertex_count(),
            centers,
            dependences,
            distances,
            fit: made.fit,
            scale,
            passages: made.passages,
            ambiguous,
        }
    }

    /// Returns the vertices of the field, in ascending order, at which the extent is not differentiable. A quantity
    /// that depends on the extent of a listed vertex is not differentiable either. If extents are divided by the
    /// largest distance, they all depend on the farthest vertex. If the farthest vertex is listed, no extent is
    /// differentiable.
    ///
    /// A vertex is listed in four cases:
    ///
    /// - Several places of the surface are closest to it, as for vertices on the medial axis of a box.
    /// - Extents are divided by the largest distance, and several vertices have that distance. Such vertices are listed
    ///   even if they stay equally far, as the midpoints of edges above one triangle do. In that case the derivative is
    ///   exact.
    /// - The extent is within a thousandth of the end of a skin, and is clamped to 1.
    /// - The extents are those of [`Solid::field`](super::Solid::field), and the centroid of a tetrahedron at the vertex has several closest
    ///   places. The same holds if the fit of the extent begins to be limited.
    ///
    /// Distances count as equal within 1e-9 of the diagonal of the bounding box of the mesh. The derivative reported is
    /// the mean over the closest places and over the farthest vertices. If there are two of them, central differences
    /// converge to the same mean. An extent at the end of a skin is held fixed. The field does the same for changes
    /// below a thousandth.
    #[must_use]
    pub fn ambiguous(&self) -> &[usize] {
        &self.ambiguous
    }

    /// Computes the derivatives with respect to the mesh (vector-Jacobian product). The arguments are the derivatives
    /// with respect to the vertices and extents of the field.
    ///
    /// # Errors
    /// Returns an error if their number differs from the number of vertices of the field, or if one is not finite.
    pub fn pullback(
        &self,
        by_vertices: &[Vector3<f64>],
        by_extents: &[f64],
    ) -> Result<DistanceGradient, MeshError> {
        let measured_count = self.distances.len();
        let field_count = measured_count + self.passages.len();
        check_velocities(by_vertices, field_count)?;
        check_rates(by_extents, field_count)?;
        let mut gradient = by_vertices[..measured_count].to_vec();
        let mut by_extents: Vec<f64> = (0..measured_count)
            .map(|vertex| self.follows(vertex) * by_extents[vertex])
            .collect();
        for (passage, by_passage) in self.passages.iter().zip(&by_vertices[measured_count..]) {
            let by_share = passage.edge.dot(by_passage);
            let shares = [1.0 - passage.share, passage.share];
            for (end, &vertex) in passage.ends.iter().enumerate() {
                gradient[vertex] += by_passage * shares[end];
                by_extents[vertex] += by_share * passage.slopes[end];
            }
        }
        let (mut by_distances, by_scale) = self.scale.pullback(&by_extents, &self.distances);
        if let Some(fit) = &self.fit {
            by_distances = fit.pullback(&by_distances, &mut gradient);
            gradient.resize(by_distances.len(), Vector3::zeros());
        }
        let by_depth = self.scale.share(by_scale, &mut by_distances);
        for dependence in &self.dependences {
            let by_foot = dependence.direction * by_distances[dependence.point];
            gradient[dependence.point] += by_foot;
            for (&corner, share) in dependence.corners.iter().zip(dependence.shares) {
                gradient[corner] -= by_foot * share;
            }
        }
        self.gather_centers(&mut gradient);
        Ok(DistanceGradient {
            by_vertices: gradient,
            by_depth,
        })
    }

    /// Computes the rates of change of the field as the vertices of the mesh move (Jacobian-vector product). Velocities
    /// are in m per unit of a parameter. The rates are per unit of the same parameter.
    ///
    /// # Errors
    /// Returns an error if the number of velocities differs from the number of vertices of the mesh, or if one is not
    /// finite.
    pub fn rates(&self, velocities: &[Vector3<f64>]) -> Result<ShapeRates, MeshError> {
        check_velocities(velocities, self.vertex_count)?;
        let measured_count = self.distances.len();
        let mut field_velocities = velocities.to_vec();
        for center in &self.centers {
            let corners = center.corners();
            let velocity = corners
                .map(|(corner, share)| field_velocities[corner] * share)
                .sum();
            field_velocities.push(velocity);
        }
        let mut distances = vec![0.0; field_velocities.len()];
        for dependence in &self.dependences {
            let corners = dependence.corners.iter().zip(dependence.shares);
            let foot: Vector3<f64> = corners
                .map(|(&corner, share)| field_velocities[corner] * share)
                .sum();
            distances[dependence.point] += dependence
                .direction
                .dot(&(field_velocities[dependence.point] - foot));
        }
        field_velocities.truncate(measured_count);
        let growth = self.scale.growth(&distances);
        if let Some(fit) = &self.fit {
            distances = fit.rates(&field_velocities, &distances);
        }
        let extents = self.scale.rates(&self.distances, &distances, growth);
        Ok(self.completed(field_velocities, extents))
    }

    /// Computes the rates of change of the field with respect to the depth of its skin (per m). They are 0 without a
    /// skin.
    #[must_use]
    pub fn rates_by_depth(&self) -> ShapeRates {
        let measured_count = self.distances.len();
        let extents = match self.scale {
            Scale::Largest(..) => vec![0.0; measured_count],
            Scale::Depth(depth) => {
                let distances = self.distances.iter();
                distances
                    .map(|distance| -distance / depth / depth)
                    .collect()
            }
        };
        self.completed(vec![Vector3::zeros(); measured_count], extents)
    }

    /// Completes the rates of the field. The arguments are the velocities of all vertices except `passages`, and the
    /// rates of their unclamped extents.
    fn completed(&self, mut vertices: Vec<Vector3<f64>>, mut extents: Vec<f64>) -> ShapeRates {
        for passage in &self.passages {
            let [from, to] = passage.ends;
            let rates = [0, 1].map(|end| passage.slopes[end] * extents[passage.ends[end]]);
            let along = vertices[from] * (1.0 - passage.share) + vertices[to] * passage.share;
            vertices.push(along + passage.edge * (rates[0] + rates[1]));
        }
        for (vertex, extent) in extents.iter_mut().enumerate() {
            *extent *= self.follows(vertex);
        }
        extents.resize(vertices.len(), 0.0);
        ShapeRates {
            vertices,
            extents,
            ambiguous: self.ambiguous.clone(),
        }
    }

    /// Returns 1 if the extent is the distance over the scale, and 0 if it is clamped at the end of a skin.
    fn follows(&self, vertex: usize) -> f64 {
        match self.scale {
            Scale::Largest(..) => 1.0,
            Scale::Depth(depth) => {
                let extent = self.distances[vertex] / depth;
                if extent < 1.0 && !is_at_end(extent) {
                    1.0
                } else {
                    0.0
                }
            }
        }
    }

    /// Removes the centers, the last one first, and adds the derivative at each center to its corners.
    fn gather_centers(&self, gradient: &mut Vec<Vector3<f64>>) {
        for center in self.centers.iter().rev() {
            if let Some(by_center) = gradient.pop() {
                for (corner, share) in center.corners() {
                    gradient[corner] += by_center * share;
                }
            }
        }
    }
}

impl Scale {
    /// Converts derivatives with respect to unclamped extents into derivatives with respect to distances and the scale.
    fn pullback(&self, by_extents: &[f64], distances: &[f64]) -> (Vec<f64>, f64) {
        let over = |scale: f64| {
            by_extents
                .iter()
                .map(move |by| by / scale)
                .collect::<Vec<_>>()
        };
        let by_scale = |scale: f64| {
            let pairs = by_extents.iter().zip(distances);
            -pairs
                .map(|(by, distance)| by * (distance / scale))
                .sum::<f64>()
                / scale
        };
        let (Self::Depth(length) | Self::Largest(length, _)) = self;
        (over(*length), by_scale(*length))
    }

    /// Adds the derivative with respect to the scale to the derivatives with respect to the largest distances. Returns the derivative with
    /// respect to the depth of a skin.
    fn share(&self, by_scale: f64, by_distances: &mut [f64]) -> f64 {
        match self {
            Self::Depth(_) => by_scale,
            Self::Largest(_, farthest) => {
                for &vertex in farthest {
                    by_distances[vertex] += by_scale / farthest.len() as f64;
                }
                0.0
            }
        }
    }

    /// Returns the rate of the scale over the scale, from the rates of distances.
    fn growth(&self, rates: &[f64]) -> f64 {
        match self {
            Self::Depth(_) => 0.0,
            Self::Largest(largest, farthest) => {
                let sum: f64 = farthest.iter().map(|&vertex| rates[vertex]).sum();
                sum / farthest.len() as f64 / largest
            }
        }
    }

    /// Converts rates of distances into rates of unclamped extents, for this growth of the scale.
    fn rates(&self, distances: &[f64], rates: &[f64], growth: f64) -> Vec<f64> {
        let (Self::Depth(length) | Self::Largest(length, _)) = self;
        let pairs = distances.iter().zip(rates);
        pairs
            .map(|(distance, rate)| (rate - distance * growth) / length)
            .collect()
    }
}
