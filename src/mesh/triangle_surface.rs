use super::triangle_components::Components;
use super::{
    DensityError, SurfaceError, SurfaceWarning, TetMesh, coordinates, mass, overlaps,
    triangle_checks, triangle_edges, triangle_solid, welding,
};
use crate::geometry::{Aabb, Tetrahedron};
use crate::spatial::{MassGradient, MassProperties};
use nalgebra::Vector3;

/// The closed surface of a solid: triangles, counter-clockwise when seen from outside. Two triangles meet in every
/// edge, or a larger even number if parts of the solid touch there. [`TriangleSoup`](super::TriangleSoup) repairs triangles that are not yet
/// a surface.
///
/// A surface is `f64` and validated once. Vertices are finite and in use. Triangles have a normal, and components
/// enclose a volume.
///
/// A surface may have several connected components, which may touch at vertices and edges. A component whose triangles face
/// inwards has a negative volume and is a cavity. It must lie inside another component, which is checked at its outermost triangles in 14
/// directions.
///
/// Self-intersection is accepted. If the surface intersects itself, or a component that is not a cavity lies inside another, each part
/// of the surface acts in contact independently. Volume and mass then count an overlap once for each enclosing component.
/// [`Self::warnings`] reports overlapping components.
///
/// ```
/// use hydroelastic::mesh::TriangleSurface;
/// use nalgebra::vector;
///
/// // A corner cut off a cube.
/// let vertices = vec![
///     vector![0.0, 0.0, 0.0], vector![0.1, 0.0, 0.0], vector![0.0, 0.1, 0.0], vector![0.0, 0.0, 0.1],
/// ];
/// let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// let corner = TriangleSurface::new(vertices, triangles)?;
/// assert_eq!(corner.neighbor(3, 0), 2);
/// assert!((corner.volume() - 0.001 / 6.0).abs() < 1e-18);
/// # Ok::<(), hydroelastic::mesh::SurfaceError>(())
/// ```
#[derive(Debug, Clone)]
pub struct TriangleSurface {
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[usize; 3]>,
    neighbors: Vec<[u32; 3]>,
    component_starts: Vec<usize>,
    reach: f64,
    repairs: Vec<SurfaceWarning>,
}

impl TriangleSurface {
    /// Creates a surface from vertices (m, in the body frame) and triangles with three vertex indices each. Triangles
    /// are counter-clockwise when seen from outside.
    ///
    /// The time is O(n log n) for n triangles, except for cavities. Each cavity is compared with every triangle of the
    /// components whose boxes contain it.
    ///
    /// # Errors
    /// Returns an error in the following cases, and names the offending element:
    ///
    /// - There are fewer than four triangles, or more triangles or vertices than a `u32` can count.
    /// - A coordinate is not finite, an index is out of range or repeated, or a vertex is unused.
    /// - A triangle is degenerate to within rounding error (height below 1e-12 of its longest edge).
    /// - The triangles at an edge do not run equally often in both directions.
    /// - A component is flat, or is oriented inwards without being a cavity.
    /// - Cavities have at least as much volume as the other components.
    /// - The surface is so large that its inertia overflows double precision.
    pub fn new(
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[usize; 3]>,
    ) -> Result<Self, SurfaceError> {
        triangle_checks::check_size(vertices.len(), triangles.len())?;
        if let Some((vertex, value)) = coordinates::first_non_finite(&vertices) {
            return Err(SurfaceError::NonFiniteCoordinate { vertex, value });
        }
        triangle_checks::check_range(&triangles, vertices.len())?;
        triangle_checks::check_corners(&triangles, vertices.len())?;
        triangle_solid::check_moments(&vertices, triangles.len())?;
        for (triangle, corners) in triangles.iter().enumerate() {
            triangle_checks::check_thickness(triangle, corners.map(|vertex| vertices[vertex]))?;
        }
        let neighbors = triangle_edges::neighbors(&vertices, &triangles);
        let neighbors = neighbors.map_err(SurfaceError::NotClosed)?;
        Self::of_neighbors((vertices, triangles), neighbors, Vec::new())
    }

    /// Creates a surface from valid triangles, their neighbors, and the repairs of the triangles.
    ///
    /// # Errors
    /// Returns an error if a volume is invalid, or if the surface is too large.
    pub(super) fn of_neighbors(
        (vertices, triangles): (Vec<Vector3<f64>>, Vec<[usize; 3]>),
        neighbors: Vec<[u32; 3]>,
        repairs: Vec<SurfaceWarning>,
    ) -> Result<Self, SurfaceError> {
        triangle_solid::check_moments(&vertices, triangles.len())?;
        let components = Components::of(&neighbors);
        triangle_solid::check_volumes(&vertices, &triangles, &components)?;
        Ok(Self {
            reach: coordinates::reach(&vertices),
            component_starts: components.starts().collect(),
            vertices,
            triangles,
            neighbors,
            repairs,
        })
    }

    /// Returns the surface of a tetrahedral mesh, for a rigid body of the same shape. Unused vertices are dropped.
    ///
    /// # Errors
    /// Returns the errors of [`Self::new`]: a part of the solid may be flat to within rounding error although its tetrahedra are not.
    pub fn around(mesh: &TetMesh) -> Result<Self, SurfaceError> {
        let vertices = mesh.vertices().to_vec();
        let (vertices, triangles) = welding::without_unused(vertices, mesh.surface_triangles());
        Self::new(vertices, triangles)
    }

    /// Returns properties of the surface that may be mistakes: vertices that were merged, triangles that were
    /// dropped because they are repeated, components that overlap, and an unusual size.
    ///
    /// Overlaps are found by about 16,000 rays through the boxes that components share. An overlap is reported if it is larger than a
    /// thousandth of the smaller component. Surfaces of one component are not searched. At most 4,096 pairs are searched.
    #[must_use]
    pub fn warnings(&self) -> Vec<SurfaceWarning> {
        let mut warnings = self.repairs.clone();
        if self.component_count() > 1 {
            let corners: Vec<_> = (0..self.triangles.len()).map(|t| self.corners(t)).collect();
            let overlaps = overlaps::warnings(&corners, &Components::of(&self.neighbors));
            warnings.extend(overlaps);
        }
        warnings.extend(SurfaceWarning::of_size(&self.aabb()));
        warnings
    }

    /// Returns the positions of the vertices (m) in the body frame.
    #[must_use]
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.vertices
    }

    /// Returns the vertex indices of the triangles, counter-clockwise when seen from outside.
    #[must_use]
    pub fn triangles(&self) -> &[[usize; 3]] {
        &self.triangles
    }

    /// Returns the corners of a triangle (m) in the body frame.
    ///
    /// # Panics
    /// Panics if the index is out of range.
    #[inline]
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [Vector3<f64>; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex])
    }

    /// Returns the triangle across an edge (0..3) of a triangle. Edge k is opposite to corner k.
    ///
    /// # Panics
    /// Panics if an index is out of range.
    #[inline]
    #[must_use]
    pub fn neighbor(&self, triangle: usize, edge: usize) -> usize {
        self.neighbors[triangle][edge] as usize
    }

    /// Returns the neighbors of each triangle across the edges opposite to its corners.
    pub(crate) fn neighbors(&self) -> &[[u32; 3]] {
        &self.neighbors
    }

    /// Returns the number of connected components. Components that touch at vertices or edges are counted separately.
    #[must_use]
    pub fn component_count(&self) -> usize {
        self.component_starts.len()
    }

    /// Returns the first triangle of each connected component.
    #[must_use]
    pub fn component_starts(&self) -> &[usize] {
        &self.component_starts
    }

    /// Returns the bounding box of the surface in the body frame (m).
    #[must_use]
    pub fn aabb(&self) -> Aabb {
        Aabb::around(&self.vertices)
    }

    /// Returns the largest distance (m) of a vertex from the origin of the body frame.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Returns the enclosed volume (m³) without the cavities.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let corners = (0..self.triangles.len()).map(|triangle| self.corners(triangle));
        triangle_solid::volume(self.aabb().center(), corners)
    }

    /// Computes mass, center of mass and inertia tensor of the enclosed solid at a uniform density (kg/m³). Results are
    /// exact up to rounding error.
    ///
    /// # Errors
    /// Returns an error if the density is not positive, or if the mass or the inertia is not finite.
    pub fn mass_properties(&self, density: f64) -> Result<MassProperties, DensityError> {
        let middle = self.aabb().center();
        mass::mass_properties(middle, self.tetrahedra_to(middle), density)
    }

    /// Computes the derivatives of a scalar with respect to the vertices (unit of the scalar per m).
    ///
    /// `gradient` has the derivatives of the scalar with respect to [`Self::mass_properties`] at this density (kg/m³).
    /// Results are exact up to rounding error.
    ///
    /// # Errors
    /// Returns the errors of [`Self::mass_properties`].
    pub fn mass_gradient(
        &self,
        density: f64,
        gradient: &MassGradient,
    ) -> Result<Vec<Vector3<f64>>, DensityError> {
        let middle = self.aabb().center();
        let by_corners =
            mass::mass_gradients(middle, self.tetrahedra_to(middle), density, gradient)?;
        let mut by_vertices = vec![Vector3::zeros(); self.vertices.len()];
        // The derivatives with respect to the common apex are dropped, because they sum to zero.
        for (triangle, [_, by_corners @ ..]) in self.triangles.iter().zip(by_corners) {
            for (&vertex, by_corner) in triangle.iter().zip(by_corners) {
                by_vertices[vertex] += by_corner;
            }
        }
        Ok(by_vertices)
    }

    /// Returns the centroid of the enclosed volume (m).
    pub(super) fn center(&self) -> Vector3<f64> {
        let middle = self.aabb().center();
        mass::center(middle, self.tetrahedra_to(middle))
    }

    /// Returns the signed tetrahedra spanned by a point and the triangles.
    fn tetrahedra_to(&self, point: Vector3<f64>) -> impl Iterator<Item = Tetrahedron> + Clone {
        (0..self.triangles.len()).map(move |triangle| {
            let [a, b, c] = self.corners(triangle);
            Tetrahedron {
                corners: [point, a, b, c],
            }
        })
    }
}
