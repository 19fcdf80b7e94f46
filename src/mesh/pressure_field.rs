use super::distance::{self, MadeOfDistances};
use super::{LinearisedDistances, MeshError, TetMesh, coordinates, skin};
use crate::geometry::{AffineField, FACES, Tetrahedron};
use crate::threads;

/// A tetrahedral mesh with an extent on every vertex: 0 on the surface, positive inside.
///
/// The pressure is the hydroelastic modulus (Pa) times the extent, linear in each tetrahedron.
/// Where extents are normalized to a largest value of 1, the modulus is the largest pressure.
#[derive(Debug, Clone)]
pub struct PressureField {
    mesh: TetMesh,
    extents: Vec<f64>,
    tets: Vec<FieldTet>,
    steepest: f64,
    reach: f64,
}

/// What the contact kernel needs of one tetrahedron, computed once per mesh.
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
    /// Σ eᵢ·|∇λᵢ| (1/m): bound of the extent's error per meter of error in a coordinate. It means something on plateaus
    /// too, where the gradient is round-off.
    pub sensitivity: f64,
    /// Norms of the gradients of the barycentric coordinates (1/m): one over each height.
    pub barycentric_steepness: [f64; 4],
    /// The faces all over which the extent is 0, unless it is 0 at the corner opposite too: bit k for the
    /// face opposite to corner k.
    pub zero_faces: u8,
}

impl PressureField {
    /// From the extent of each vertex (any unit: pressure = modulus × extent).
    ///
    /// # Errors
    /// If an extent is negative or not finite, is not 0 on the surface, rises by more per meter than double precision can
    /// hold, or if a tetrahedron has extent 0 at all corners.
    pub fn new(mesh: TetMesh, extents: Vec<f64>) -> Result<Self, MeshError> {
        let field = Self::with_inert_tets(mesh, extents)?;
        match field.tets.iter().position(FieldTet::is_inert) {
            Some(tet) => Err(MeshError::ZeroField { tet }),
            None => Ok(field),
        }
    }

    /// As [`Self::new`], for fields made elsewhere in which some tetrahedra have extent 0 at all
    /// corners: they are part of the body's mass, but nothing that enters them is pushed back.
    ///
    /// # Errors
    /// If an extent is negative or not finite, is not 0 on the surface, or rises by more per meter than double precision can
    /// hold.
    pub fn with_inert_tets(mesh: TetMesh, extents: Vec<f64>) -> Result<Self, MeshError> {
        check_extents(&mesh, &extents)?;
        let tets = threads::values_of(mesh.tet_count(), |tet| {
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

    /// With the distance to the surface, divided by the largest one, as extent. Tetrahedra (and
    /// inner edges and faces) whose corners all lie on the surface are split first
    /// ([`TetMesh::with_inner_vertices`]), so that the field rises everywhere inside.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_distance(mesh: &TetMesh) -> Result<Self, MeshError> {
        let MadeOfDistances { mesh, extents, .. } = distance::normalized(mesh)?;
        Self::new(mesh, extents)
    }

    /// [`Self::from_distance`], and how it changes with the vertices of the mesh.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn linearised_from_distance(
        mesh: &TetMesh,
    ) -> Result<(Self, LinearisedDistances), MeshError> {
        let mut made = distance::normalized(mesh)?;
        let field = Self::new(made.mesh.clone(), std::mem::take(&mut made.extents))?;
        Ok((field, LinearisedDistances::normalized(mesh, made)))
    }

    /// With min(d/`depth`, 1) as extent at the distance d from the surface: a skin of this depth (m) around a *plateau*, in
    /// which the pressure is the modulus. Below the surface it rises by modulus/`depth` per meter, in thick bodies and
    /// in thin ones, unless these are thinner than two skins.
    ///
    /// Distances are interpolated between vertices. Tetrahedra are split as by [`Self::from_distance`], and then where their
    /// edges pass `depth`, so that the skin ends there and not at the next vertex. A vertex whose distance is within a
    /// thousandth of `depth` counts as the end, since slivers would be left beside it.
    ///
    /// # Errors
    /// If `depth` is not positive and finite, or if a part of a split tetrahedron is flat to round-off, as
    /// in a skin that is 10⁶ times thinner than the tetrahedra below it.
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
        let MadeOfDistances { mesh, extents, .. } = skin::layered(mesh, depth)?;
        Self::new(mesh, extents)
    }

    /// [`Self::from_distance_up_to`], and how it changes with the vertices of the mesh and the depth.
    ///
    /// # Errors
    /// As [`Self::from_distance_up_to`].
    pub fn linearised_from_distance_up_to(
        mesh: &TetMesh,
        depth: f64,
    ) -> Result<(Self, LinearisedDistances), MeshError> {
        let mut made = skin::layered(mesh, depth)?;
        let field = Self::new(made.mesh.clone(), std::mem::take(&mut made.extents))?;
        Ok((field, LinearisedDistances::up_to(mesh, made, depth)))
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// Extent of each vertex.
    #[must_use]
    pub fn extents(&self) -> &[f64] {
        &self.extents
    }

    /// The tetrahedra with their fields.
    #[must_use]
    pub fn tets(&self) -> &[FieldTet] {
        &self.tets
    }

    /// Largest norm of the extent's gradient over the mesh (1/m for normalized extents).
    #[must_use]
    pub fn steepest(&self) -> f64 {
        self.steepest
    }

    /// Largest distance (m) of a vertex from the origin of the body frame.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.reach
    }
}

impl FieldTet {
    /// Whether the extent is 0 at all corners: the tetrahedron takes no part in any contact.
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

/// Bit k for each face, by its opposite corner k, of which the statement is true.
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
