use super::triangle_components::Components;
use super::welding::{UsedVertices, merge_coincident};
use super::{
    DensityError, SurfaceError, TetMesh, coordinates, mass, triangle_checks, triangle_edges,
    triangle_solid,
};
use crate::geometry::{Aabb, Tetrahedron};
use crate::spatial::{MassGradient, MassProperties};
use nalgebra::Vector3;

/// The closed surface of a solid: triangles, counter-clockwise seen from outside, that meet two by two in their edges.
/// All `f64`, validated once: finite vertices, all in use; triangles that have a normal; components that enclose a volume.
///
/// It may have several connected components. One whose triangles are turned inwards, so that its volume is negative, is a
/// cavity, and has to lie inside another, which is checked at one point of it. Components may touch each other at
/// vertices.
///
/// Whether the surface passes through itself is *not* checked. Where it does, or where a component lies in the solid of
/// another without being a cavity, each sheet of it presses on what it meets as if it were there alone, and volume and
/// mass count the overlap as often as it is enclosed.
///
/// ```
/// use hydroelastic::mesh::TriangleSurface;
/// use nalgebra::vector;
///
/// // The corner of a cube, cut off.
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
}

impl TriangleSurface {
    /// From vertices (m, in the body frame) and triangles as indices of three vertices each, counter-clockwise seen from
    /// outside.
    ///
    /// # Errors
    /// If there are fewer than four triangles or more than a `u32` counts, a coordinate is not finite, an index out of
    /// range or repeated, or a vertex unused; if a triangle is a line to round-off (height below 1e-12 of its
    /// longest edge); if an edge belongs to one triangle or to more than two, or two that share it are turned
    /// different ways; if a component is flat, or turned inwards without being a cavity; or if the surface is so large
    /// that its inertia is beyond double precision. Each error names the culprit.
    ///
    /// Takes n log n for n triangles. Only cavities take longer: each is compared with every triangle of the components
    /// whose boxes contain it.
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
        let neighbors = triangle_edges::neighbors(&triangles)?;
        let components = Components::of(&neighbors);
        triangle_solid::check_volumes(&vertices, &triangles, &components)?;
        Ok(Self {
            reach: coordinates::reach(&vertices),
            component_starts: components.starts().collect(),
            vertices,
            triangles,
            neighbors,
        })
    }

    /// Merges vertices (m) at exactly the same place, drops unused vertices, and builds the surface as [`Self::new`] does.
    ///
    /// Triangles and remaining vertices keep their order. An unused vertex may have any coordinates. A triangle with two corners at the
    /// same place is an error; [`Self::from_soup`] omits it.
    ///
    /// # Errors
    /// See [`Self::new`]. Vertices are named by their index in `vertices`; of merged vertices, the first is named.
    pub fn welded(
        vertices: Vec<Vector3<f64>>,
        mut triangles: Vec<[usize; 3]>,
    ) -> Result<Self, SurfaceError> {
        triangle_checks::check_range(&triangles, vertices.len())?;
        merge_coincident(&vertices, &mut triangles);
        Self::without_unused(vertices, &triangles)
    }

    /// From triangles with corners (m) of their own, as an STL file has them, counter-clockwise seen from outside.
    ///
    /// Corners at exactly the same place become one vertex. A triangle with two corners at the same place is omitted,
    /// because it has no area. Its neighbors then share an edge.
    ///
    /// # Errors
    /// See [`Self::new`]. Triangles are counted without the omitted ones. A vertex is named by its first corner: corner k of triangle t
    /// of `corners` has the index 3t + k.
    pub fn from_soup(corners: &[[Vector3<f64>; 3]]) -> Result<Self, SurfaceError> {
        let vertices = corners.as_flattened();
        if let Some((vertex, value)) = coordinates::first_non_finite(vertices) {
            return Err(SurfaceError::NonFiniteCoordinate { vertex, value });
        }
        let has_three_places = |&triangle: &usize| {
            let [a, b, c] = corners[triangle];
            a != b && b != c && c != a
        };
        let triangles = (0..corners.len()).filter(has_three_places);
        let triangles = triangles.map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner));
        Self::welded(vertices.to_vec(), triangles.collect())
    }

    /// The surface of a tetrahedral mesh: a rigid body of the same shape.
    ///
    /// # Errors
    /// If more than two triangles of the mesh's surface meet in an edge, which is so where parts of the solid touch in that
    /// edge alone; or as [`Self::new`], if a part of the solid is flat to round-off, although its tetrahedra are not.
    pub fn around(mesh: &TetMesh) -> Result<Self, SurfaceError> {
        Self::without_unused(mesh.vertices().to_vec(), mesh.surface_triangles())
    }

    /// Drops unused vertices. Errors name vertices by their index in `vertices`. All indices must be in range.
    fn without_unused(
        vertices: Vec<Vector3<f64>>,
        triangles: &[[usize; 3]],
    ) -> Result<Self, SurfaceError> {
        let used = UsedVertices::of(vertices, triangles);
        let surface = Self::new(used.vertices, used.triangles);
        surface.map_err(|error| error.with_vertices(&used.original))
    }

    /// Positions of the vertices (m), in the body frame.
    #[must_use]
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.vertices
    }

    /// The triangles, as indices of their vertices, counter-clockwise seen from outside.
    #[must_use]
    pub fn triangles(&self) -> &[[usize; 3]] {
        &self.triangles
    }

    /// The corners of a triangle (m).
    ///
    /// # Panics
    /// If there is no triangle of that index.
    #[inline]
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [Vector3<f64>; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex])
    }

    /// The triangle beyond an edge (0..3) of a triangle: edge k is opposite to corner k.
    ///
    /// # Panics
    /// If there is no triangle, or no edge, of that index.
    #[inline]
    #[must_use]
    pub fn neighbor(&self, triangle: usize, edge: usize) -> usize {
        self.neighbors[triangle][edge] as usize
    }

    /// For each triangle those beyond its edges, by the opposite corner.
    pub(crate) fn neighbors(&self) -> &[[u32; 3]] {
        &self.neighbors
    }

    /// Number of connected components. Components that touch at vertices only are several.
    #[must_use]
    pub fn component_count(&self) -> usize {
        self.component_starts.len()
    }

    /// The first triangle of each connected component.
    #[must_use]
    pub fn component_starts(&self) -> &[usize] {
        &self.component_starts
    }

    /// The smallest box around the surface.
    #[must_use]
    pub fn aabb(&self) -> Aabb {
        Aabb::around(&self.vertices)
    }

    /// Largest distance (m) of a vertex from the origin of the body frame.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Volume (m³) inside, without the cavities.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let corners = (0..self.triangles.len()).map(|triangle| self.corners(triangle));
        triangle_solid::volume(self.aabb().center(), corners)
    }

    /// Mass, center of mass and inertia tensor of the solid inside at a uniform density (kg/m³). Exact up to round-off.
    ///
    /// # Errors
    /// If the density is not positive, or the mass or the inertia is not finite.
    pub fn mass_properties(&self, density: f64) -> Result<MassProperties, DensityError> {
        let middle = self.aabb().center();
        mass::mass_properties(middle, self.tetrahedra_to(middle), density)
    }

    /// The derivatives by the vertices (the number's unit over m) of a number that has these derivatives by
    /// [`Self::mass_properties`] at this density (kg/m³). Exact up to round-off.
    ///
    /// # Errors
    /// As [`Self::mass_properties`].
    pub fn mass_gradient(
        &self,
        density: f64,
        gradient: &MassGradient,
    ) -> Result<Vec<Vector3<f64>>, DensityError> {
        let middle = self.aabb().center();
        let by_corners =
            mass::mass_gradients(middle, self.tetrahedra_to(middle), density, gradient)?;
        let mut by_vertices = vec![Vector3::zeros(); self.vertices.len()];
        // What the middle makes of a change is nothing in the sum.
        for (triangle, [_, by_corners @ ..]) in self.triangles.iter().zip(by_corners) {
            for (&vertex, by_corner) in triangle.iter().zip(by_corners) {
                by_vertices[vertex] += by_corner;
            }
        }
        Ok(by_vertices)
    }

    /// Center of the volume inside (m).
    pub(super) fn center(&self) -> Vector3<f64> {
        let middle = self.aabb().center();
        mass::center(middle, self.tetrahedra_to(middle))
    }

    /// The signed tetrahedra between a point and the triangles.
    fn tetrahedra_to(&self, point: Vector3<f64>) -> impl Iterator<Item = Tetrahedron> + Clone {
        (0..self.triangles.len()).map(move |triangle| {
            let [a, b, c] = self.corners(triangle);
            Tetrahedron {
                corners: [point, a, b, c],
            }
        })
    }
}
