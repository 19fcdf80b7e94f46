//! Tetrahedral meshes of solids, from their surfaces or from distance functions.

mod error;
mod lattice;
mod region;
mod stuffing;
mod winding;

pub use error::SolidError;

use super::distance::normalized_unsplit;
use super::shape_rates::{check_rates, check_velocities};
use super::{
    LinearizedDistances, MeshError, PressureField, TetMesh, TriangleSoup, TriangleSurface,
    coordinates,
};
use crate::geometry::Aabb;
use lattice::Lattice;
use nalgebra::Vector3;
use region::{InsideTriangles, Region, WhereNegative};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};
use std::sync::Mutex;
use stuffing::{Stuffing, stuffed};

/// Number of tetrahedra above which the spacing is not refined further.
const MAX_TETS: usize = 1_000_000;

/// Number of spacings of the first attempt along the longest edge of the bounds.
const FIRST_CELLS: f64 = 12.0;

/// Cosine of the angle between an edge and a triangle's normal below which the place of a cut is not differentiable in practice.
const GRAZING: f64 = 1e-6;

/// How fine the tetrahedra of a [`Solid`] are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Resolution {
    /// Spacing of the lattice (m): the longest edge of the inner tetrahedra.
    Spacing(f64),
    /// Largest error of the volume, over the volume. The spacing is a power of √2 m, and is divided by √2 until the volume is as close to
    /// that of the surface or, if the triangles have no volume of their own, changes by as little.
    VolumeWithin(f64),
}

impl Default for Resolution {
    /// The volume is within 1 %.
    fn default() -> Self {
        Self::VolumeWithin(0.01)
    }
}

/// A tetrahedral mesh that fills the inside of triangles, or the region in which a distance function is negative.
///
/// The mesh is made by isosurface stuffing: a body-centered cubic lattice whose nodes near the boundary move onto it [Labelle, Shewchuk
/// 2007]. Dihedral angles are above 9°. Every tetrahedron has a vertex inside, so that a pressure field is positive in it. The
/// time is O(n log n) for n triangles and tetrahedra.
///
/// Each vertex is either a node of the lattice, which is fixed, or on the boundary, where an edge of the lattice crosses it. Edges
/// and corners of the surface are therefore cut off by less than a spacing. [`Self::pullback`] and [`Self::rates`] have the derivatives
/// with respect to the vertices of the triangles.
///
/// ```
/// use hydroelastic::mesh::{Resolution, Solid, TriangleSoup, TriangleSurface, shapes};
///
/// let surface = TriangleSurface::around(shapes::icosphere(0.1, 3)?.mesh())?;
/// let solid = Solid::of_surface(&surface, Resolution::VolumeWithin(0.01))?;
/// let error = solid.mesh().volume() / surface.volume() - 1.0;
/// assert!(error.abs() < 0.01);
/// let field = solid.field()?;
/// assert!(field.tets().iter().all(|tet| !tet.is_inert()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Solid {
    mesh: TetMesh,
    spacing: f64,
    volume_error: Option<f64>,
    /// Number of vertices of the triangles from which the solid was made.
    input_count: usize,
    boundary: Vec<BoundaryVertex>,
    ambiguous: Vec<usize>,
}

/// A vertex of the mesh where an edge of the lattice crosses the boundary.
#[derive(Debug, Clone)]
struct BoundaryVertex {
    vertex: usize,
    /// The edge (m), from its inner to its outer end.
    edge: Vector3<f64>,
    follows: Option<Follows>,
}

/// The triangle that a vertex lies on. The vertex moves along the edge e at the rate e (n·ẋ)/(n·e), where ẋ is the velocity of the
/// triangle at the vertex and n its normal.
#[derive(Debug, Clone)]
struct Follows {
    /// Vertices of the triangle.
    corners: [usize; 3],
    /// Barycentric coordinates of the vertex.
    shares: [f64; 3],
    /// The normal n over n·e (1/m).
    normal: Vector3<f64>,
}

impl TriangleSoup {
    /// Fills the inside of the triangles with tetrahedra. The inside is where the winding number is above one half in absolute value,
    /// so that small holes are closed, overlapping parts are united, and surfaces may be oriented inwards as a whole.
    ///
    /// # Errors
    /// - If there are no triangles, an index is out of range, or a coordinate is not finite.
    /// - If the resolution is not positive, or too fine.
    /// - If nothing is inside, or the volume does not become as exact as asked.
    pub fn solid(&self, resolution: Resolution) -> Result<Solid, SolidError> {
        Solid::inside(&self.vertices, &self.triangles, None, resolution)
    }
}

impl Solid {
    /// Fills a closed surface with tetrahedra. Overlapping components are united.
    ///
    /// # Errors
    /// Returns the errors of [`TriangleSoup::solid`].
    pub fn of_surface(
        surface: &TriangleSurface,
        resolution: Resolution,
    ) -> Result<Self, SolidError> {
        let volume = (surface.component_count() == 1).then(|| surface.volume());
        Self::inside(surface.vertices(), surface.triangles(), volume, resolution)
    }

    fn inside(
        vertices: &[Vector3<f64>],
        triangles: &[[usize; 3]],
        volume: Option<f64>,
        resolution: Resolution,
    ) -> Result<Self, SolidError> {
        check_triangles(vertices, triangles)?;
        let corners = triangles
            .iter()
            .map(|triangle| triangle.map(|vertex| vertices[vertex]));
        let region = InsideTriangles::new(corners);
        let of_stuffing = |stuffing: Stuffing, spacing: f64| {
            let follows = |triangle: usize, shares: [f64; 3], edge: &Vector3<f64>| {
                let corners = triangles[triangle];
                let [a, b, c] = corners.map(|vertex| vertices[vertex]);
                let normal = (b - a).cross(&(c - a)).normalize();
                let along = normal.dot(edge);
                (along.abs() > GRAZING * edge.norm()).then(|| Follows {
                    corners,
                    shares,
                    normal: normal / along,
                })
            };
            Self::new(stuffing, spacing, vertices.len(), follows)
        };
        refined(&region, volume, resolution, of_stuffing)
    }

    /// Fills the region in which a signed distance is negative.
    ///
    /// `distances` returns the distances (m) of points (m), negative inside. It may return less than the distance in absolute value,
    /// but not more, as for unions of distances or distances to smoothed edges. `bounds` contains the region.
    ///
    /// ```
    /// use hydroelastic::geometry::Aabb;
    /// use hydroelastic::mesh::{Resolution, Solid};
    /// use nalgebra::{Vector3, vector};
    ///
    /// // Two balls of 5 cm, 6 cm apart.
    /// let centers = [vector![-0.03, 0.0, 0.0], vector![0.03, 0.0, 0.0]];
    /// let distance = |point: &Vector3<f64>| {
    ///     centers.iter().map(|center| (point - center).norm() - 0.05).fold(f64::INFINITY, f64::min)
    /// };
    /// let bounds = Aabb { lower: vector![-0.08, -0.05, -0.05], upper: vector![0.08, 0.05, 0.05] };
    /// let distances = |points: &[Vector3<f64>]| points.iter().map(distance).collect();
    /// let pair = Solid::of_distance(distances, bounds, Resolution::default())?;
    /// assert!(pair.mesh().aabb().upper.x < 0.0801);
    /// # Ok::<(), hydroelastic::mesh::SolidError>(())
    /// ```
    ///
    /// # Errors
    /// - If a distance is not finite, or the function returns the wrong number of values.
    /// - If the region reaches beyond the bounds, or the bounds are not finite.
    /// - The errors of [`TriangleSoup::solid`].
    pub fn of_distance(
        distances: impl Fn(&[Vector3<f64>]) -> Vec<f64> + Sync,
        bounds: Aabb,
        resolution: Resolution,
    ) -> Result<Self, SolidError> {
        check_bounds(&bounds)?;
        let fault = Mutex::new(None);
        let checked = |points: &[Vector3<f64>]| {
            let distances = distances(points);
            match fault_of(points, &distances, &bounds) {
                None => distances,
                Some(error) => {
                    if let Ok(mut fault) = fault.lock() {
                        fault.get_or_insert(error);
                    }
                    vec![f64::INFINITY; points.len()]
                }
            }
        };
        let region = WhereNegative {
            bounds,
            distances: &checked,
        };
        let of_stuffing = |stuffing: Stuffing, spacing: f64| {
            let fault = fault.lock().ok().and_then(|mut fault| fault.take());
            fault.map_or_else(|| Self::new(stuffing, spacing, 0, |_, _, _| None), Err)
        };
        refined(&region, None, resolution, of_stuffing)
    }

    fn new(
        stuffing: Stuffing,
        spacing: f64,
        input_count: usize,
        follows: impl Fn(usize, [f64; 3], &Vector3<f64>) -> Option<Follows>,
    ) -> Result<Self, SolidError> {
        if stuffing.tets.is_empty() {
            return Err(SolidError::Empty { spacing });
        }
        let boundary = stuffing.cuts.iter().map(|cut| BoundaryVertex {
            vertex: cut.vertex,
            edge: cut.edge,
            follows: cut
                .crossing
                .triangle
                .and_then(|(triangle, shares)| follows(triangle, shares, &cut.edge)),
        });
        let boundary: Vec<_> = boundary.collect();
        let is_followed = |vertex: &BoundaryVertex| vertex.follows.is_some() || input_count == 0;
        let ambiguous = stuffing.cuts.iter().zip(&boundary);
        let ambiguous = ambiguous.filter(|(cut, vertex)| cut.is_at_tie || !is_followed(vertex));
        let ambiguous = ambiguous.map(|(cut, _)| cut.vertex).collect();
        Ok(Self {
            mesh: TetMesh::new(stuffing.vertices, stuffing.tets)?,
            spacing,
            volume_error: None,
            input_count,
            boundary,
            ambiguous,
        })
    }

    /// Returns the mesh.
    #[must_use]
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// Returns the spacing of the lattice (m).
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Returns the error of the volume over the volume, if it is known: against the volume of a closed surface of one component, or
    /// estimated from the spacing before, with [`Resolution::VolumeWithin`].
    #[must_use]
    pub fn volume_error(&self) -> Option<f64> {
        self.volume_error
    }

    /// Returns the pressure field whose extent is the distance to the surface of the mesh over the largest distance. The mesh is not
    /// split further.
    ///
    /// # Errors
    /// Returns the errors of [`PressureField::new`].
    pub fn field(&self) -> Result<PressureField, MeshError> {
        PressureField::made_of(normalized_unsplit(self.mesh.clone(), Vec::new()))
    }

    /// Returns the field and its linearization with respect to the vertices of the mesh. [`Self::pullback`] goes on from there.
    ///
    /// # Errors
    /// Returns the errors of [`Self::field`].
    pub fn linearized_field(&self) -> Result<(PressureField, LinearizedDistances), MeshError> {
        let made = normalized_unsplit(self.mesh.clone(), Vec::new());
        PressureField::linearized_made(made, |made| {
            LinearizedDistances::normalized(&self.mesh, made)
        })
    }

    /// Returns the vertices of the mesh, in ascending order, at which a small change of the boundary changes the tetrahedra or at which
    /// the boundary has no triangle to follow, as in a hole or where an edge of the lattice grazes it. Derivatives of other vertices
    /// are exact up to rounding error while no vertex comes to be listed.
    #[must_use]
    pub fn ambiguous(&self) -> &[usize] {
        &self.ambiguous
    }

    /// Returns the velocity of each vertex of the mesh (m per unit of a parameter) from the velocities of the vertices of the triangles.
    ///
    /// # Errors
    /// Returns an error if the number of velocities is not that of the triangles' vertices, or if one is not finite.
    pub fn rates(&self, velocities: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, MeshError> {
        check_velocities(velocities, self.input_count)?;
        let mut rates = vec![Vector3::zeros(); self.mesh.vertex_count()];
        for (vertex, follows) in self.following() {
            let corners = follows.corners.iter().zip(follows.shares);
            let velocity: Vector3<f64> = corners
                .map(|(&corner, share)| velocities[corner] * share)
                .sum();
            rates[vertex.vertex] = vertex.edge * follows.normal.dot(&velocity);
        }
        Ok(rates)
    }

    /// Returns the derivatives of a scalar with respect to the vertices of the triangles (unit of the scalar per m) from those with
    /// respect to the vertices of the mesh.
    ///
    /// # Errors
    /// Returns an error if the number of derivatives is not that of the mesh's vertices, or if one is not finite.
    pub fn pullback(&self, by_vertices: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, MeshError> {
        check_velocities(by_vertices, self.mesh.vertex_count())?;
        let mut gradient = vec![Vector3::zeros(); self.input_count];
        for (vertex, follows) in self.following() {
            let along = vertex.edge.dot(&by_vertices[vertex.vertex]);
            for (&corner, share) in follows.corners.iter().zip(follows.shares) {
                gradient[corner] += follows.normal * (share * along);
            }
        }
        Ok(gradient)
    }

    fn following(&self) -> impl Iterator<Item = (&BoundaryVertex, &Follows)> {
        let boundary = self.boundary.iter();
        boundary.filter_map(|vertex| Some((vertex, vertex.follows.as_ref()?)))
    }

    /// Returns the indices of the vertices on the boundary, in the order in which [`Self::rates_of_distance`] takes derivatives.
    pub fn boundary_vertices(&self) -> impl Iterator<Item = usize> {
        self.boundary.iter().map(|vertex| vertex.vertex)
    }

    /// Returns the velocity of each vertex of the mesh (m per unit of a parameter) from derivatives of the distance function at the
    /// [`Self::boundary_vertices`]: its gradient, and its derivative with respect to the parameter (m per unit). A vertex moves along
    /// its edge e of the lattice at the rate −e ∂φ/∂θ / (∇φ·e).
    ///
    /// # Errors
    /// Returns an error if the number of gradients or derivatives is not that of the vertices on the boundary, or if a velocity is
    /// not finite.
    pub fn rates_of_distance(
        &self,
        gradients: &[Vector3<f64>],
        by_parameter: &[f64],
    ) -> Result<Vec<Vector3<f64>>, MeshError> {
        check_velocities(gradients, self.boundary.len())?;
        check_rates(by_parameter, self.boundary.len())?;
        let mut rates = vec![Vector3::zeros(); self.mesh.vertex_count()];
        for (vertex, (gradient, by)) in self.boundary.iter().zip(gradients.iter().zip(by_parameter))
        {
            rates[vertex.vertex] = vertex.edge * (-by / gradient.dot(&vertex.edge));
        }
        check_velocities(&rates, rates.len())?;
        Ok(rates)
    }
}

/// Fills a region at this resolution.
fn refined(
    region: &impl Region,
    volume: Option<f64>,
    resolution: Resolution,
    of_stuffing: impl Fn(Stuffing, f64) -> Result<Solid, SolidError>,
) -> Result<Solid, SolidError> {
    let bounds = region.bounds();
    check_bounds(&bounds)?;
    let at = |spacing: f64| {
        let lattice = Lattice::around(&bounds, spacing)
            .map_err(|cells| SolidError::TooFine { spacing, cells })?;
        of_stuffing(stuffed(region, &lattice), spacing)
    };
    match resolution {
        Resolution::Spacing(spacing) => {
            check_number("spacing", spacing)?;
            let mut solid = at(spacing)?;
            solid.volume_error = volume.map(|volume| (solid.mesh.volume() / volume - 1.0).abs());
            Ok(solid)
        }
        Resolution::VolumeWithin(asked) => {
            check_number("error of the volume", asked)?;
            let size = 2.0 * bounds.half_extents().max();
            within(asked, volume, power_below(size / FIRST_CELLS), at)
        }
    }
}

/// Refines the spacing until the error of the volume is as asked.
fn within(
    asked: f64,
    volume: Option<f64>,
    first_spacing: f64,
    at: impl Fn(f64) -> Result<Solid, SolidError>,
) -> Result<Solid, SolidError> {
    let (mut spacing, mut before) = (first_spacing, None);
    loop {
        let solid = at(spacing);
        if matches!(solid, Err(SolidError::Empty { .. })) && spacing > first_spacing / 16.0 {
            spacing *= FRAC_1_SQRT_2;
            continue;
        }
        let mut solid = solid?;
        let found = solid.mesh.volume();
        // The error is of second order, so that it equals its change from a spacing √2 times as large.
        let reached = volume
            .or(before)
            .map_or(f64::INFINITY, |volume| (found / volume - 1.0).abs());
        if reached <= asked {
            solid.volume_error = Some(reached);
            return Ok(solid);
        }
        let tets = solid.mesh.tet_count();
        if tets > MAX_TETS {
            return Err(SolidError::VolumeNotReached {
                reached,
                asked,
                spacing,
                tets,
            });
        }
        before = Some(found);
        spacing *= FRAC_1_SQRT_2;
    }
}

/// Returns a power of √2 m of at most this length (m), so that the lattice does not depend on small changes of the region.
fn power_below(length: f64) -> f64 {
    let mut power = 1.0;
    while power < length {
        power *= SQRT_2;
    }
    while power > length {
        power *= FRAC_1_SQRT_2;
    }
    power
}

fn check_triangles(vertices: &[Vector3<f64>], triangles: &[[usize; 3]]) -> Result<(), SolidError> {
    if triangles.is_empty() {
        return Err(SolidError::NoTriangles);
    }
    let vertex_count = vertices.len();
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex >= vertex_count) {
            return Err(SolidError::VertexOutOfRange {
                triangle,
                vertex,
                vertex_count,
            });
        }
    }
    match coordinates::first_non_finite(vertices) {
        Some((point, value)) => Err(SolidError::NonFiniteCoordinate { point, value }),
        None => Ok(()),
    }
}

fn check_bounds(bounds: &Aabb) -> Result<(), SolidError> {
    if let Some((point, value)) = coordinates::first_non_finite([&bounds.lower, &bounds.upper]) {
        return Err(SolidError::NonFiniteCoordinate { point, value });
    }
    let size = bounds.upper - bounds.lower;
    if size
        .iter()
        .all(|&length| length > 0.0 && length.is_finite())
    {
        return Ok(());
    }
    Err(SolidError::NoSize { size: size.into() })
}

fn check_number(name: &'static str, value: f64) -> Result<(), SolidError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(SolidError::InvalidResolution { name, value })
}

/// Returns what is wrong with distances that a function returned.
fn fault_of(points: &[Vector3<f64>], distances: &[f64], bounds: &Aabb) -> Option<SolidError> {
    if points.len() != distances.len() {
        return Some(SolidError::DistanceCount {
            found: distances.len(),
            expected: points.len(),
        });
    }
    points.iter().zip(distances).find_map(|(point, &distance)| {
        let at = (*point).into();
        if !distance.is_finite() {
            return Some(SolidError::NonFiniteDistance {
                point: at,
                value: distance,
            });
        }
        let is_beyond = distance < 0.0 && !bounds.overlaps(&Aabb::around([point]));
        is_beyond.then_some(SolidError::BeyondBounds {
            point: at,
            distance,
        })
    })
}
