use super::welding::{self, Triangles, Welded};
use super::{
    SurfaceError, TriangleSurface, convex_hull, coordinates, thin_triangles, triangle_checks,
    triangle_edges,
};
use crate::geometry::Aabb;
use nalgebra::Vector3;

/// Tolerances, relative to the diagonal of the bounding box, with which [`TriangleSoup::closed`] merges vertices in turn. The second is
/// above the rounding error of coordinates in single precision, and the third above the error of files with 6 digits.
const TOLERANCES: [f64; 3] = [0.0, 1e-7, 1e-6];

/// Unvalidated triangles, for example of a file: they may have holes, overlap, or be oriented inconsistently.
///
/// [`Self::closed`] makes a surface from triangles that enclose a solid, and repairs them if the meaning is clear. The other methods are
/// repairs on request.
///
/// ```
/// use hydroelastic::mesh::{SurfaceError, TriangleSoup};
/// use nalgebra::vector;
///
/// // A pyramid without its base.
/// let base = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0]];
/// let [a, b, c, d] = base.map(Into::into);
/// let apex = vector![0.05, 0.05, 0.1];
/// let soup = TriangleSoup::from_corners(&[[a, b, apex], [b, c, apex], [c, d, apex], [d, a, apex]]);
/// let Err(SurfaceError::NotClosed(faults)) = soup.clone().closed() else {
///     panic!("the surface is open");
/// };
/// assert_eq!(faults.open.map(|fault| fault.count), Some(4));
///
/// let pyramid = soup.convex_hull()?.closed()?;
/// assert!((pyramid.volume() - 0.001 / 3.0).abs() < 1e-18);
/// # Ok::<(), SurfaceError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriangleSoup {
    /// Positions of the vertices (m) in the body frame.
    pub vertices: Vec<Vector3<f64>>,
    /// Vertex indices of each triangle, counter-clockwise when seen from outside. They may be out of range.
    pub triangles: Vec<[usize; 3]>,
}

impl TriangleSoup {
    /// Creates a soup of triangles that do not share vertices. Corner k (m) of triangle t becomes vertex 3t + k.
    #[must_use]
    pub fn from_corners(corners: &[[Vector3<f64>; 3]]) -> Self {
        Self {
            vertices: corners.as_flattened().to_vec(),
            triangles: (0..corners.len())
                .map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner))
                .collect(),
        }
    }

    /// Merges vertices at most `tolerance` (m) apart, and drops unused vertices. A tolerance of 0 merges equal positions only.
    ///
    /// Merging is transitive: vertices are merged if a chain of vertices connects them, each at most the tolerance from the next. The
    /// first vertex of a chain is kept. Triangles with two corners at one vertex are dropped. So are pairs of triangles with the same corners
    /// and opposite orientations, because nothing lies between them. Triangles and vertices keep their order.
    ///
    /// # Errors
    /// Returns an error if a vertex index is out of range, or if a coordinate of a used vertex is not finite.
    pub fn welded(&self, tolerance: f64) -> Result<Self, SurfaceError> {
        self.checked_corners()?;
        let Welded { triangles, .. } = welding::welded(&self.vertices, &self.triangles, tolerance);
        Ok(triangles.into())
    }

    /// Reverses the orientation of all triangles, for a surface that is turned inwards as a whole.
    #[must_use]
    pub fn flipped(mut self) -> Self {
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
        }
        self
    }

    /// Returns the surface of the convex hull of all vertices, including unused ones.
    ///
    /// The vertices of the hull are vertices of the soup. Other vertices are outside it by at most 2e-10 of the largest distance of a
    /// vertex from the origin. The algorithm is quickhull [Barber, Dobkin, Huhdanpaa 1996] with exact predicates.
    ///
    /// # Errors
    /// Returns an error if a coordinate is not finite, or if the vertices lie in a plane.
    pub fn convex_hull(&self) -> Result<Self, SurfaceError> {
        if let Some((vertex, value)) = coordinates::first_non_finite(&self.vertices) {
            return Err(SurfaceError::NonFiniteCoordinate { vertex, value });
        }
        let point_count = self.vertices.len();
        let hull = convex_hull::triangles(&self.vertices);
        let triangles = hull.ok_or(SurfaceError::FlatHull { point_count })?;
        let vertices = self.vertices.clone();
        Ok(welding::without_unused(vertices, &triangles).into())
    }

    /// Creates the closed surface of a solid.
    ///
    /// The following defects are repaired. [`TriangleSurface::warnings`] reports a repair that moves vertices.
    ///
    /// - Unused vertices are dropped, and vertices at equal positions are merged. If the surface is then not closed, vertices are
    ///   merged within 1e-7, or else 1e-6, of the diagonal of the bounding box, as by [`Self::welded`].
    /// - A triangle whose corners lie on a line is removed, and the triangle across its longest edge is split in two.
    /// - Pairs of triangles with the same corners and opposite orientations are dropped.
    ///
    /// A repaired surface lists its split triangles last.
    ///
    /// # Errors
    /// Returns [`SurfaceError::NotClosed`] with all faults if the surface is not closed. Also returns the other errors of
    /// [`TriangleSurface::new`], which name a triangle by its index after the repairs, and by a point on it.
    pub fn closed(self) -> Result<TriangleSurface, SurfaceError> {
        self.checked_corners()?;
        let corners = self.triangles.as_flattened().iter();
        let aabb = Aabb::around(corners.map(|&vertex| &self.vertices[vertex]));
        let size = (aabb.upper - aabb.lower).norm();
        let mut first_error = None;
        for tolerance in TOLERANCES {
            match welding::welded(&self.vertices, &self.triangles, tolerance * size).closed() {
                Err(SurfaceError::NotClosed(faults)) => {
                    let may_close = faults.open.is_some() || faults.thin.is_some();
                    let error = SurfaceError::NotClosed(faults);
                    first_error.get_or_insert(error);
                    if !may_close {
                        break;
                    }
                }
                result => return result,
            }
        }
        Err(first_error.unwrap_or(SurfaceError::TooFewTriangles { count: 0 }))
    }

    /// Checks that all corners exist and are finite.
    fn checked_corners(&self) -> Result<(), SurfaceError> {
        triangle_checks::check_range(&self.triangles, self.vertices.len())?;
        for &vertex in self.triangles.as_flattened() {
            if let Some((_, value)) = coordinates::first_non_finite([&self.vertices[vertex]]) {
                return Err(SurfaceError::NonFiniteCoordinate { vertex, value });
            }
        }
        Ok(())
    }
}

impl Welded {
    /// Removes triangles without area, and creates the surface.
    fn closed(self) -> Result<TriangleSurface, SurfaceError> {
        let (vertices, triangles) = self.triangles;
        triangle_checks::check_size(vertices.len(), triangles.len())?;
        let (triangles, thin) = thin_triangles::split(&vertices, triangles);
        let mut faults = match triangle_edges::neighbors(&vertices, &triangles) {
            Ok(neighbors) if thin.is_none() => {
                let repairs = self.warning.into_iter().collect();
                return TriangleSurface::of_neighbors((vertices, triangles), neighbors, repairs);
            }
            Ok(_) => Box::default(),
            Err(faults) => faults,
        };
        faults.thin = thin;
        Err(SurfaceError::NotClosed(faults))
    }
}

impl From<Triangles> for TriangleSoup {
    fn from((vertices, triangles): Triangles) -> Self {
        Self {
            vertices,
            triangles,
        }
    }
}

impl From<TriangleSurface> for TriangleSoup {
    fn from(surface: TriangleSurface) -> Self {
        Self {
            vertices: surface.vertices().to_vec(),
            triangles: surface.triangles().to_vec(),
        }
    }
}
