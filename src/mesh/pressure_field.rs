use super::distance::{self, MadeOfDistances};
use super::refinement::{self, Accuracy};
use super::{LinearizedDistances, MeshError, TetMesh, coordinates, skin};
use crate::geometry::{AffineField, FACES, Tetrahedron};
use crate::parallel;

/// A tetrahedral mesh with an extent on every vertex: 0 on the surface, positive inside.
///
/// The pressure is the hydroelastic modulus (Pa) times the extent, and is linear in each tetrahedron. If extents are
/// normalized to a maximum of 1, the modulus is the largest pressure.
#[derive(Debug, Clone)]
pub struct PressureField {
    mesh: TetMesh,
    extents: Vec<f64>,
    tets: Vec<FieldTet>,
    steepest: f64,
    reach: f64,
}

/// One tetrahedron with the data that the contact kernel needs, computed once per mesh.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct FieldTet {
    /// Index of the tetrahedron in its mesh.
    pub index: usize,
    /// The corners (m).
    pub tetrahedron: Tetrahedron,
    /// Extent at each corner.
    pub extents: [f64; 4],
    /// The extent as a function of position.
    pub extent: AffineField,
    /// The barycentric coordinates as functions of position.
    pub barycentric: [AffineField; 4],
    /// Norm of the extent's gradient (1/m).
    pub steepness: f64,
    /// Σ eᵢ·|∇λᵢ| (1/m): bound on the error of the extent per meter of error in a coordinate. It is also meaningful on
    /// plateaus, where the gradient is only rounding error.
    pub sensitivity: f64,
    /// Norms of the gradients of the barycentric coordinates (1/m): the reciprocals of the heights.
    pub barycentric_steepness: [f64; 4],
    /// A bit mask of the faces on which the extent is 0. Bit k is set for the face opposite to corner k, unless the
    /// extent is 0 at corner k too.
    pub zero_faces: u8,
}

impl PressureField {
    /// Creates a field from the extent of each vertex, in any unit: pressure = modulus × extent.
    ///
    /// # Errors
    /// Returns an error if an extent is negative, not finite, or not 0 on the surface. Also returns an error if the
    /// gradient of the extent overflows, or if a tetrahedron has extent 0 at all corners.
    pub fn new(mesh: TetMesh, extents: Vec<f64>) -> Result<Self, MeshError> {
        let field = Self::with_inert_tets(mesh, extents)?;
        match field.tets.iter().position(FieldTet::is_inert) {
            Some(tet) => Err(MeshError::ZeroField { tet }),
            None => Ok(field),
        }
    }

    /// Creates a field in which tetrahedra may have extent 0 at all corners, as fields made by other programs do. These
    /// tetrahedra count for the mass of the body but exert no pressure.
    ///
    /// # Errors
    /// Returns an error if an extent is negative, not finite, or not 0 on the surface, or if the gradient of the extent
    /// overflows.
    pub fn with_inert_tets(mesh: TetMesh, extents: Vec<f64>) -> Result<Self, MeshError> {
        check_extents(&mesh, &extents)?;
        let tets = parallel::values_of(mesh.tet_count(), |tet| {
            let corner_extents = mesh.tets()[tet].map(|vertex| extents[vertex]);
            FieldTet::new(tet, mesh.tetrahedron(tet), corner_extents)
        });
        if let Some(tet) = tets.iter().position(|tet| !tet.sensitivity.is_finite()) {
            return Err(MeshError::SteepField { tet });
        }
        let steepest = tets.iter().map(|tet| tet.steepness).fold(0.0, f64::max);
        Ok(Self {
            reach: coordinates::reach(mesh.vertices()),
            mesh,
            extents,
            tets,
            steepest,
        })
    }

    /// Creates a field whose extent is the distance to the surface divided by the largest distance.
    ///
    /// Tetrahedra, inner faces and inner edges whose corners all lie on the surface are split first (see
    /// [`TetMesh::with_inner_vertices`]), so that the field is positive everywhere inside.
    ///
    /// # Errors
    /// Returns the errors of [`Self::new`].
    pub fn from_distance(mesh: &TetMesh) -> Result<Self, MeshError> {
        Self::made_of(distance::normalized(mesh)?)
    }

    /// Creates the field of [`Self::from_distance`] on a mesh that is refined until the mean error of the interpolated distance is at
    /// most `tolerance` times the mean distance, over the points at most `depth` (m) below the surface. The default depth is
    /// two fifths of the largest distance of a vertex from the surface.
    ///
    /// The field of [`Self::from_distance`] is interpolated between the vertices of the mesh, which makes coarse meshes too soft:
    /// tetrahedra at edges of the body have several vertices on its surface. [`Self::distance_error`] returns this error. Here, the
    /// tetrahedra with the largest errors are split at kinks of the distance. One tetrahedron is also split at the point farthest from the
    /// surface. The parts may have small angles, which contact tolerates.
    ///
    /// # Errors
    /// Returns an error if `depth` or `tolerance` is not positive and finite, or if more than 4,000,000 tetrahedra are needed. Also
    /// returns the errors of [`Self::new`].
    pub fn from_distance_within(
        mesh: &TetMesh,
        tolerance: f64,
        depth: Option<f64>,
    ) -> Result<Self, MeshError> {
        Self::made_of(refinement::normalized_within(
            mesh,
            Accuracy { depth, tolerance },
        )?)
    }

    /// Creates the field of [`Self::from_distance_within`] and its linearization with respect to the vertices of the mesh. Each new
    /// vertex keeps its relative position on its edge.
    ///
    /// # Errors
    /// Returns the errors of [`Self::from_distance_within`].
    pub fn linearized_from_distance_within(
        mesh: &TetMesh,
        tolerance: f64,
        depth: Option<f64>,
    ) -> Result<(Self, LinearizedDistances), MeshError> {
        Self::linearized_made(
            refinement::normalized_within(mesh, Accuracy { depth, tolerance })?,
            |made| LinearizedDistances::normalized(mesh, made),
        )
    }

    /// Returns the mean difference between the exact distance to the surface and the distance interpolated in the tetrahedra, divided by
    /// the mean distance. The means are over points at most `depth` (m) below the surface: the centroids of tetrahedra and the midpoints of
    /// their edges, weighted by volume.
    ///
    /// The default depth is that of [`Self::from_distance_within`]. If the extent is the distance, the result is about the relative error
    /// of the force of a contact up to this depth.
    #[must_use]
    pub fn distance_error(&self, depth: Option<f64>) -> f64 {
        refinement::distance_error(&self.mesh, depth)
    }

    /// Creates the field of a mesh with distances.
    pub(super) fn made_of(made: MadeOfDistances) -> Result<Self, MeshError> {
        Self::new(made.mesh, made.extents)
    }

    /// Creates the field of a mesh with distances, and its linearization.
    pub(super) fn linearized_made(
        mut made: MadeOfDistances,
        linearized: impl FnOnce(MadeOfDistances) -> LinearizedDistances,
    ) -> Result<(Self, LinearizedDistances), MeshError> {
        let field = Self::new(made.mesh.clone(), std::mem::take(&mut made.extents))?;
        Ok((field, linearized(made)))
    }

    /// Creates the field of [`Self::from_distance`] and its linearization with respect to the vertices of the mesh.
    ///
    /// # Errors
    /// Returns the errors of [`Self::new`].
    pub fn linearized_from_distance(
        mesh: &TetMesh,
    ) -> Result<(Self, LinearizedDistances), MeshError> {
        Self::linearized_made(distance::normalized(mesh)?, |made| {
            LinearizedDistances::normalized(mesh, made)
        })
    }

    /// Creates a field with a skin: the extent is min(d/`depth`, 1) at the distance d from the surface.
    ///
    /// Inside the skin is a *plateau*, on which the pressure equals the modulus. The pressure rises by modulus/`depth`
    /// per meter in the skin. This slope does not depend on the thickness of the body, unless the body is thinner than
    /// two skins.
    ///
    /// Distances are interpolated between vertices. Tetrahedra are split as in [`Self::from_distance`]. They are then
    /// split where their edges cross `depth`, so that the skin ends at `depth` instead of at the next vertex. A vertex
    /// whose distance is within a thousandth of `depth` counts as the end of the skin, because a cut beside it would
    /// create slivers.
    ///
    /// # Errors
    /// Returns an error if `depth` is not positive and finite, or if a part of a split tetrahedron is flat to within
    /// rounding error. The latter occurs if the skin is 10⁶ times thinner than the tetrahedra below it.
    ///
    /// ```
    /// use hydroelastic::mesh::{PressureField, shapes};
    ///
    /// let plank = PressureField::from_distance_up_to(shapes::distance_cuboid([1.0, 0.2, 0.02])?.mesh(), 0.005)?;
    /// let block = PressureField::from_distance_up_to(shapes::distance_cuboid([1.0, 1.0, 1.0])?.mesh(), 0.005)?;
    /// assert!((plank.steepest() - 200.0).abs() < 1e-9 && (block.steepest() - 200.0).abs() < 1e-9);
    /// # Ok::<(), hydroelastic::mesh::MeshError>(())
    /// ```
    pub fn from_distance_up_to(mesh: &TetMesh, depth: f64) -> Result<Self, MeshError> {
        Self::made_of(skin::layered(mesh, depth)?)
    }

    /// Creates the field of [`Self::from_distance_up_to`] and its linearization with respect to the vertices and the
    /// depth.
    ///
    /// # Errors
    /// Returns the errors of [`Self::from_distance_up_to`].
    pub fn linearized_from_distance_up_to(
        mesh: &TetMesh,
        depth: f64,
    ) -> Result<(Self, LinearizedDistances), MeshError> {
        Self::linearized_made(skin::layered(mesh, depth)?, |made| {
            LinearizedDistances::up_to(mesh, made, depth)
        })
    }

    /// Returns the mesh.
    #[must_use]
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// Returns the extent of each vertex.
    #[must_use]
    pub fn extents(&self) -> &[f64] {
        &self.extents
    }

    /// Returns the tetrahedra with their fields.
    #[must_use]
    pub fn tets(&self) -> &[FieldTet] {
        &self.tets
    }

    /// Returns the largest norm of the extent's gradient over the mesh (1/m for normalized extents).
    #[must_use]
    pub fn steepest(&self) -> f64 {
        self.steepest
    }

    /// Returns the largest distance (m) of a vertex from the origin of the body frame.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.reach
    }
}

impl FieldTet {
    /// Returns true if the extent is 0 at all corners. Inert tetrahedra take no part in contact.
    #[must_use]
    pub fn is_inert(&self) -> bool {
        self.extents.iter().all(|&extent| extent == 0.0)
    }

    pub(crate) fn new(index: usize, tetrahedron: Tetrahedron, extents: [f64; 4]) -> Self {
        let barycentric = tetrahedron.barycentric_fields();
        let weighted = barycentric.iter().zip(extents);
        let extent = AffineField {
            gradient: weighted.clone().map(|(field, e)| field.gradient * e).sum(),
            offset: weighted.map(|(field, e)| field.offset * e).sum(),
        };
        let summands = barycentric.iter().zip(extents);
        let sensitivity = summands.map(|(field, e)| field.gradient.norm() * e).sum();
        let is_zero = |face: usize| {
            extents[face] > 0.0 && FACES[face].iter().all(|&corner| extents[corner] == 0.0)
        };
        Self {
            index,
            tetrahedron,
            extents,
            extent,
            steepness: extent.gradient.norm(),
            sensitivity,
            barycentric_steepness: barycentric.each_ref().map(|field| field.gradient.norm()),
            barycentric,
            zero_faces: faces_that(is_zero),
        }
    }
}

/// Returns a mask with bit k set if the predicate holds for the face opposite to corner k.
fn faces_that(is_true: impl Fn(usize) -> bool) -> u8 {
    (0..4).map(|face| u8::from(is_true(face)) << face).sum()
}

fn check_extents(mesh: &TetMesh, extents: &[f64]) -> Result<(), MeshError> {
    let (vertex_count, extent_count) = (mesh.vertex_count(), extents.len());
    if vertex_count != extent_count {
        return Err(MeshError::ExtentCount {
            vertex_count,
            extent_count,
        });
    }
    for (vertex, &value) in extents.iter().enumerate() {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(MeshError::InvalidExtent { vertex, value });
        }
        if mesh.is_on_surface(vertex) && value != 0.0 {
            return Err(MeshError::SurfaceExtent { vertex, value });
        }
    }
    Ok(())
}
