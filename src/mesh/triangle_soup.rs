use super::surface_faults::Fault;
use super::triangle_components::Components;
use super::welding::{self, Triangles, Welded};
use super::{
    SurfaceError, SurfaceWarning, TriangleSurface, convex_hull, coordinates, thin_triangles,
    triangle_checks, triangle_edges, triangle_solid,
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

    /// Reverses each connected component that is turned inwards and is not a cavity. Also returns the number of these components.
    ///
    /// Vertices at equal positions are merged, as by [`Self::welded`]. If a surface with cavities is turned inwards as a whole, use
    /// [`Self::flipped`], because its cavities are turned outwards.
    ///
    /// # Errors
    /// Returns an error if the triangles are not closed, or if a component is flat. Also returns the errors of [`Self::welded`].
    pub fn with_outward_components(&self) -> Result<(Self, usize), SurfaceError> {
        let mut soup = self.welded(0.0)?;
        triangle_checks::check_size(soup.vertices.len(), soup.triangles.len())?;
        let neighbors = triangle_edges::neighbors(&soup.vertices, &soup.triangles);
        let components = Components::of(&neighbors.map_err(SurfaceError::NotClosed)?);
        let inward = triangle_solid::inward(&soup.vertices, &soup.triangles, &components)?;
        for &triangle in inward.iter().copied().flatten() {
            soup.triangles[triangle].swap(1, 2);
        }
        Ok((soup, inward.len()))
    }

    /// Returns the surface of the convex hull of all vertices, including unused ones.
    ///
    /// The vertices of the hull are vertices of the soup. Other vertices are outside it by at most 2e-10 of the largest distance of a
    /// vertex from the center of the bounding box. The algorithm is quickhull [Barber, Dobkin, Huhdanpaa 1996] with exact predicates.
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

    /// Returns the surface of the convex hull of each connected component. First merges vertices at equal positions, as [`Self::welded`].
    /// Triangles are connected if they share a vertex.
    ///
    /// # Errors
    /// Returns an error if the vertices of a component lie in a plane. Also returns the errors of [`Self::welded`].
    pub fn component_hulls(&self) -> Result<Vec<Self>, SurfaceError> {
        let soup = self.welded(0.0)?;
        let components = welding::connected(&soup.triangles).into_iter();
        let hulls = components.map(|triangles| {
            let corners = triangles
                .iter()
                .map(|triangle| triangle.map(|v| soup.vertices[v]));
            Self::from_corners(&corners.collect::<Vec<_>>()).convex_hull()
        });
        hulls.collect()
    }

    /// Creates the closed surface of a solid.
    ///
    /// The following defects are repaired. [`TriangleSurface::warnings`] reports vertices that move and repeated triangles.
    ///
    /// - Unused vertices are dropped, and vertices at equal positions are merged. If the surface is then not closed, vertices are
    ///   merged within 1e-7, or else 1e-6, of the diagonal of the bounding box, as by [`Self::welded`].
    /// - A triangle whose corners lie on a line is removed, and the triangle across its longest edge is split in two.
    /// - Pairs of triangles with the same corners and opposite orientations are dropped.
    /// - Triangles that repeat another one with the same orientation are dropped, unless the surface is closed with them only.
    ///
    /// A repaired surface lists its split triangles last.
    ///
    /// # Errors
    /// Returns [`SurfaceError::NotClosed`] with all faults if the surface is not closed, or [`SurfaceError::Cancelled`] if the repairs
    /// leave fewer than 4 triangles. Also returns the other errors of
    /// [`TriangleSurface::new`], which name a triangle by its index after the repairs, and by a point on it.
    pub fn closed(self) -> Result<TriangleSurface, SurfaceError> {
        self.checked_corners()?;
        let corners = self.triangles.as_flattened().iter();
        let aabb = Aabb::around(corners.map(|&vertex| &self.vertices[vertex]));
        let size = (aabb.upper - aabb.lower).norm();
        // The fifth power of the size bounds the second moments (m⁵). Areas that overflow would be NaN and count as thin.
        if !(self.triangles.is_empty() || size.powi(5).is_finite()) {
            return Err(SurfaceError::BeyondPrecision { diagonal: size });
        }
        let mut first_error = None;
        for tolerance in TOLERANCES {
            let error =
                match welding::welded(&self.vertices, &self.triangles, tolerance * size).closed() {
                    Err(SurfaceError::TooFewTriangles { count }) if self.triangles.len() >= 4 => {
                        SurfaceError::Cancelled {
                            given: self.triangles.len(),
                            count,
                        }
                    }
                    Err(error @ SurfaceError::NotClosed(_)) => error,
                    result => return result,
                };
            let may_close = error.may_close();
            first_error.get_or_insert(error);
            if !may_close {
                break;
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
    /// Removes triangles that are repeated or have no area, and creates the surface.
    fn closed(self) -> Result<TriangleSurface, SurfaceError> {
        let Self {
            triangles: (vertices, triangles),
            warning,
        } = self;
        let warnings: Vec<SurfaceWarning> = warning.into_iter().collect();
        let [first, repeats] = welding::without_repeats(&triangles);
        let corners = repeats.iter().map(|t| t.map(|vertex| vertices[vertex]));
        let Some(repeated) = Fault::of(corners) else {
            return surface((vertices, triangles), warnings);
        };
        let report = SurfaceWarning::Repeated {
            triangle_count: repeated.count,
        };
        let with_report = warnings.iter().cloned().chain([report]).collect();
        surface((vertices.clone(), first), with_report).or_else(|mut error| {
            if let SurfaceError::NotClosed(faults) = &mut error {
                faults.repeated = Some(repeated);
            }
            surface((vertices, triangles), warnings).map_err(|_| error)
        })
    }
}

/// Removes triangles without area, and creates the surface.
fn surface(
    (vertices, triangles): Triangles,
    repairs: Vec<SurfaceWarning>,
) -> Result<TriangleSurface, SurfaceError> {
    let (triangles, thin) = thin_triangles::split(&vertices, triangles);
    let (vertices, triangles) = welding::without_unused(vertices, &triangles);
    triangle_checks::check_size(vertices.len(), triangles.len())?;
    let mut faults = match triangle_edges::neighbors(&vertices, &triangles) {
        Ok(neighbors) if thin.is_none() => {
            return TriangleSurface::of_neighbors((vertices, triangles), neighbors, repairs);
        }
        Ok(_) => Box::default(),
        Err(faults) => faults,
    };
    faults.thin = thin;
    Err(SurfaceError::NotClosed(faults))
}

impl SurfaceError {
    /// Returns true if merging of vertices may close the surface.
    fn may_close(&self) -> bool {
        matches!(self, Self::NotClosed(faults) if faults.open.is_some() || faults.thin.is_some())
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
