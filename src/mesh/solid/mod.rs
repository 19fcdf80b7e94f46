//! Tetrahedral meshes of solids, from their surfaces or from distance functions.

mod boundary;
mod error;
mod fitting;
mod grading;
mod lattice;
mod region;
mod resolution;
mod stuffing;
mod winding;

pub use error::SolidError;
pub use resolution::{Resolution, SolidWarning};

use super::distance::fitted_with_deepest;
use super::shape_rates::check_velocities;
use super::{
    LinearizedDistances, MeshError, PressureField, SurfaceError, TetMesh, TriangleSoup,
    TriangleSurface, coordinates, triangle_checks,
};
use crate::geometry::Aabb;
use boundary::Boundary;
use fitting::Input;
use nalgebra::Vector3;
use region::WhereNegative;
use resolution::{Refined, check_bounds, refined};
use std::sync::Mutex;

/// A tetrahedral mesh that fills the inside of triangles, or the region in which a distance function is negative.
///
/// The mesh is made by isosurface stuffing: a body-centered cubic lattice whose nodes near the boundary move onto it [Labelle, Shewchuk
/// 2007]. Tetrahedra deep inside are larger. Every tetrahedron has a vertex inside, so that a pressure field is positive in it. The
/// time is O(n log n) for n triangles and tetrahedra.
///
/// Each vertex is either a node of the lattice, which is fixed, or on the boundary, at an edge of the lattice that crosses it. Vertices on
/// smooth, curved parts of the surface then move along these edges, until the mean gap between the surface and the triangles around each
/// vertex is zero. Edges and corners of the surface are cut off by less than a spacing. The force of a contact patch with a radius below
/// about three spacings is therefore too small. [`Self::pullback`] and [`Self::rates`] return the derivatives with respect to the vertices
/// of the triangles.
///
/// ```
/// use hydroelastic::mesh::{Resolution, Solid, TriangleSoup, TriangleSurface, shapes};
///
/// let surface = TriangleSurface::around(shapes::icosphere(0.1, 3)?.mesh())?;
/// let solid = Solid::of_surface(&surface, Resolution::default())?;
/// let error = solid.mesh().volume() / surface.volume() - 1.0;
/// assert!(error.abs() < 0.01);
/// let field = solid.field()?;
/// assert!(field.tets().iter().all(|tet| !tet.is_inert()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Solid(Refined);

impl TriangleSoup {
    /// Fills the inside of the triangles with tetrahedra. The inside is where the winding number is above one half in absolute value,
    /// so that small holes are closed, overlapping parts are united, and surfaces may be oriented inwards as a whole.
    ///
    /// # Errors
    /// - If no triangle has a positive area, an index is out of range, or a coordinate is not finite.
    /// - If the region is flat, or its moments overflow or underflow.
    /// - If the resolution is not positive, or too fine.
    /// - If nothing is inside.
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
        let input = Input::new(vertices, triangles);
        let refined = refined(&input.region, volume, resolution, |stuffing| {
            input.fitted(stuffing)
        });
        Ok(Self(refined?))
    }

    /// Fills the region in which a signed distance is negative.
    ///
    /// `distances` returns the distances (m) of points (m), negative inside. It may return less than the distance in absolute value,
    /// but not more, as for unions of distances or distances to smoothed edges. `bounds` contains the region. Vertices on the boundary
    /// stay on it.
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
        let taken_fault = || fault.lock().ok().and_then(|mut fault| fault.take());
        let refined = refined(&region, None, resolution, |stuffing| match taken_fault() {
            Some(fault) => Err(fault),
            None => Ok((
                TetMesh::new(stuffing.vertices, stuffing.tets)?,
                Boundary::of(&stuffing.cuts),
            )),
        });
        taken_fault().map_or(refined.map(Self), Err)
    }

    /// Returns the mesh.
    #[must_use]
    pub fn mesh(&self) -> &TetMesh {
        &self.0.mesh
    }

    /// Returns the spacing of the lattice (m).
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.0.spacing
    }

    /// Returns the error of the volume over the volume, if it is known: against the volume of a closed surface of one component, or
    /// estimated from the spacing before, with [`Resolution::VolumeWithin`].
    #[must_use]
    pub fn volume_error(&self) -> Option<f64> {
        self.0.volume_error
    }

    /// Returns warnings about errors above their tolerance.
    #[must_use]
    pub fn warnings(&self) -> &[SolidWarning] {
        &self.0.warnings
    }

    /// Returns the error of the distance to the surface that the mesh interpolates, with [`Resolution::DistanceWithin`]. The distances of
    /// [`Self::field`] are fitted and have a smaller error.
    #[must_use]
    pub fn distance_error(&self) -> Option<f64> {
        self.0.distance_error
    }

    /// Returns the pressure field whose extent is the distance to the surface of the mesh over the largest distance. One tetrahedron is
    /// split at the point with the largest distance if that point is not close to a vertex.
    ///
    /// The distance between vertices is interpolated. Inside a convex body the interpolated distance is too small, so that the distances of
    /// the inner vertices are raised until the mean error around each vertex is about zero. The largest extent therefore exceeds 1 by a
    /// few percent.
    ///
    /// # Errors
    /// Returns the errors of [`PressureField::new`].
    pub fn field(&self) -> Result<PressureField, MeshError> {
        PressureField::made_of(fitted_with_deepest(self.0.mesh.clone())?)
    }

    /// Returns the field and its linearization with respect to the vertices of the mesh. [`Self::pullback`] goes on from there.
    ///
    /// # Errors
    /// Returns the errors of [`Self::field`].
    pub fn linearized_field(&self) -> Result<(PressureField, LinearizedDistances), MeshError> {
        let made = fitted_with_deepest(self.0.mesh.clone())?;
        PressureField::linearized_made(made, |made| {
            LinearizedDistances::normalized(&self.0.mesh, made)
        })
    }

    /// Returns the vertices of the mesh, in ascending order, whose derivatives may not exist. Derivatives of other vertices are exact up to
    /// rounding error, for changes of the surface that add no vertex to this list.
    ///
    /// A vertex is listed in these cases:
    ///
    /// - A small change of the boundary changes the tetrahedra, or the edge of the lattice along which the vertex moves.
    /// - The vertex is on an edge of the surface between triangles that are not in one plane.
    /// - The vertex has no triangle to follow, because it is in a hole or because an edge of the lattice grazes the boundary.
    /// - A neighbor on the boundary is listed for one of these reasons, because the fit of the vertex depends on the neighbor.
    #[must_use]
    pub fn ambiguous(&self) -> &[usize] {
        &self.0.boundary.ambiguous
    }

    /// Returns the velocity of each vertex of the mesh (m per unit of a parameter) from the velocities of the vertices of the triangles.
    ///
    /// # Errors
    /// Returns an error if the number of velocities is not that of the triangles' vertices, or if one is not finite.
    pub fn rates(&self, velocities: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, MeshError> {
        let Refined { mesh, boundary, .. } = &self.0;
        boundary.rates(mesh.vertex_count(), velocities)
    }

    /// Returns the derivatives of a scalar with respect to the vertices of the triangles (unit of the scalar per m) from those with
    /// respect to the vertices of the mesh.
    ///
    /// # Errors
    /// Returns an error if the number of derivatives is not that of the mesh's vertices, or if one is not finite.
    pub fn pullback(&self, by_vertices: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, MeshError> {
        let Refined { mesh, boundary, .. } = &self.0;
        check_velocities(by_vertices, mesh.vertex_count())?;
        Ok(boundary.pullback(by_vertices))
    }

    /// Returns the indices of the vertices on the boundary, in the order in which [`Self::rates_of_distance`] takes derivatives.
    pub fn boundary_vertices(&self) -> impl Iterator<Item = usize> {
        self.0.boundary.vertices.iter().map(|vertex| vertex.vertex)
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
        let Refined { mesh, boundary, .. } = &self.0;
        boundary.rates_of_distance(mesh.vertex_count(), gradients, by_parameter)
    }
}

fn check_triangles(vertices: &[Vector3<f64>], triangles: &[[usize; 3]]) -> Result<(), SolidError> {
    triangle_checks::check_range(triangles, vertices.len())?;
    if let Some((vertex, value)) = coordinates::first_non_finite(vertices) {
        return Err(SurfaceError::NonFiniteCoordinate { vertex, value }.into());
    }
    let corners = |triangle: &[usize; 3]| triangle.map(|vertex| vertices[vertex]);
    let is_thin = |triangle: &[usize; 3]| triangle_checks::is_thin(corners(triangle));
    if triangles.iter().all(is_thin) {
        return Err(SolidError::NoTriangles);
    }
    Ok(())
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
