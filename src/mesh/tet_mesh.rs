use super::surface::{OUTSIDE, Surface};
use super::{DensityError, MeshError, coordinates, mass};
use crate::geometry::{Aabb, Tetrahedron};
use crate::spatial::{MassGradient, MassProperties};
use nalgebra::Vector3;

/// Flatness tolerance: six times the volume of a tetrahedron over its longest edge cubed. Below this value, barycentric
/// gradients would have fewer than four correct digits.
pub(super) const FLATNESS: f64 = 1e-12;

/// A validated tetrahedral mesh. Vertices are finite and in use. Tetrahedra have positive orientation and volume, and
/// meet in whole faces.
#[derive(Debug, Clone)]
pub struct TetMesh {
    vertices: Vec<Vector3<f64>>,
    tets: Vec<[usize; 4]>,
    surface: Surface,
}

impl TetMesh {
    /// Creates a mesh from vertices (m, in the body frame) and tetrahedra with four vertex indices each. Tetrahedra of
    /// negative orientation are reoriented.
    ///
    /// # Errors
    /// Returns an error if a coordinate is not finite, an index is out of range or repeated, a tetrahedron is flat, a
    /// vertex is unused, or tetrahedra overlap at a common face. The error names the offending element.
    pub fn new(vertices: Vec<Vector3<f64>>, mut tets: Vec<[usize; 4]>) -> Result<Self, MeshError> {
        check_size(vertices.len(), tets.len())?;
        if let Some((vertex, value)) = coordinates::first_non_finite(&vertices) {
            return Err(MeshError::NonFiniteCoordinate { vertex, value });
        }
        let mut used = vec![false; vertices.len()];
        for (index, tet) in tets.iter_mut().enumerate() {
            check_indices(index, tet, vertices.len())?;
            for &vertex in tet.iter() {
                used[vertex] = true;
            }
            orient(index, tet, &vertices)?;
        }
        if let Some(vertex) = used.iter().position(|used| !used) {
            return Err(MeshError::UnusedVertex { vertex });
        }
        let surface = Surface::of(&tets, vertices.len())?;
        Ok(Self {
            vertices,
            tets,
            surface,
        })
    }

    /// Moves the vertices to these positions (m), one for each vertex.
    ///
    /// Returns an error if a tetrahedron becomes flat or inverted.
    pub(super) fn with_vertices(self, vertices: Vec<Vector3<f64>>) -> Result<Self, MeshError> {
        let mesh = Self { vertices, ..self };
        for tet in 0..mesh.tet_count() {
            let tetrahedron = mesh.tetrahedron(tet);
            let volume = tetrahedron.signed_volume();
            if is_flat(&tetrahedron) || volume < 0.0 {
                return Err(MeshError::ZeroVolume {
                    tet,
                    volume,
                    longest_edge: tetrahedron.longest_edge(),
                });
            }
        }
        Ok(mesh)
    }

    /// Returns the positions of the vertices (m) in the body frame.
    #[must_use]
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.vertices
    }

    /// Returns the vertex indices of the tetrahedra, positively oriented.
    #[must_use]
    pub fn tets(&self) -> &[[usize; 4]] {
        &self.tets
    }

    /// Returns the number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Returns the number of tetrahedra.
    #[must_use]
    pub fn tet_count(&self) -> usize {
        self.tets.len()
    }

    /// Returns the vertex indices of the surface triangles, counter-clockwise when seen from outside.
    #[must_use]
    pub fn surface_triangles(&self) -> &[[usize; 3]] {
        &self.surface.triangles
    }

    /// Returns the tetrahedron across the face opposite to a corner (0..4), or `None` if the face is part of the
    /// surface.
    #[inline]
    #[must_use]
    pub fn neighbor(&self, tet: usize, corner: usize) -> Option<usize> {
        let neighbor = self.surface.neighbors[tet][corner];
        (neighbor != OUTSIDE).then_some(neighbor as usize)
    }

    /// Returns the neighbors of each tetrahedron across the faces opposite to its corners, or [`OUTSIDE`].
    pub(crate) fn neighbors(&self) -> &[[u32; 4]] {
        &self.surface.neighbors
    }

    /// Returns true if the vertex lies on the surface.
    #[must_use]
    pub fn is_on_surface(&self, vertex: usize) -> bool {
        self.surface.has_vertex[vertex]
    }

    /// Returns the tetrahedron with its corners (m) in the body frame.
    #[must_use]
    pub fn tetrahedron(&self, tet: usize) -> Tetrahedron {
        Tetrahedron {
            corners: self.tets[tet].map(|vertex| self.vertices[vertex]),
        }
    }

    /// Returns the bounding box of the mesh in the body frame (m).
    #[must_use]
    pub fn aabb(&self) -> Aabb {
        Aabb::around(&self.vertices)
    }

    /// Returns the volume (m³).
    #[must_use]
    pub fn volume(&self) -> f64 {
        (0..self.tet_count())
            .map(|tet| self.tetrahedron(tet).signed_volume())
            .sum()
    }

    /// Computes mass, center of mass and inertia tensor at a uniform density (kg/m³).
    ///
    /// # Errors
    /// Returns an error if the density is not positive, or if the mass or the inertia is not finite.
    pub fn mass_properties(&self, density: f64) -> Result<MassProperties, DensityError> {
        let tetrahedra = (0..self.tet_count()).map(|tet| self.tetrahedron(tet));
        mass::mass_properties(self.aabb().center(), tetrahedra, density)
    }

    /// Computes the derivatives of a scalar with respect to the vertices (unit of the scalar per m).
    ///
    /// `gradient` has the derivatives of the scalar with respect to [`Self::mass_properties`] at this density (kg/m³).
    /// Results are exact up to rounding error. Derivatives with respect to inner vertices are 0.
    ///
    /// # Errors
    /// Returns the errors of [`Self::mass_properties`].
    pub fn mass_gradient(
        &self,
        density: f64,
        gradient: &MassGradient,
    ) -> Result<Vec<Vector3<f64>>, DensityError> {
        let tetrahedra = (0..self.tet_count()).map(|tet| self.tetrahedron(tet));
        let origin = self.aabb().center();
        let by_corners = mass::mass_gradients(origin, tetrahedra, density, gradient)?;
        let mut by_vertices = vec![Vector3::zeros(); self.vertex_count()];
        for (tet, by_corners) in self.tets.iter().zip(by_corners) {
            for (&vertex, by_corner) in tet.iter().zip(by_corners) {
                by_vertices[vertex] += by_corner;
            }
        }
        Ok(by_vertices)
    }
}

fn check_size(vertex_count: usize, tet_count: usize) -> Result<(), MeshError> {
    let (count, limit) = (vertex_count.max(tet_count), u32::MAX as usize);
    if tet_count == 0 {
        Err(MeshError::Empty)
    } else if count > limit {
        Err(MeshError::TooLarge { count, limit })
    } else {
        Ok(())
    }
}

fn check_indices(tet: usize, corners: &[usize; 4], vertex_count: usize) -> Result<(), MeshError> {
    for (corner, &vertex) in corners.iter().enumerate() {
        if vertex >= vertex_count {
            return Err(MeshError::VertexOutOfRange {
                tet,
                vertex,
                vertex_count,
            });
        }
        if corners[..corner].contains(&vertex) {
            return Err(MeshError::RepeatedVertex { tet, vertex });
        }
    }
    Ok(())
}

/// Gives the tetrahedron positive orientation, or returns an error if it is flat.
fn orient(
    tet: usize,
    corners: &mut [usize; 4],
    vertices: &[Vector3<f64>],
) -> Result<(), MeshError> {
    let tetrahedron = Tetrahedron {
        corners: corners.map(|vertex| vertices[vertex]),
    };
    let volume = tetrahedron.signed_volume();
    if is_flat(&tetrahedron) {
        return Err(MeshError::ZeroVolume {
            tet,
            volume,
            longest_edge: tetrahedron.longest_edge(),
        });
    }
    if volume < 0.0 {
        corners.swap(0, 1);
    }
    Ok(())
}

/// Returns true if the tetrahedron is flat to within rounding error, or if its volume overflows.
pub(super) fn is_flat(tetrahedron: &Tetrahedron) -> bool {
    let volume = tetrahedron.signed_volume();
    // The comparison is not `<=`, so that an infinite or NaN volume is rejected.
    let solid = 6.0 * volume.abs() > FLATNESS * tetrahedron.longest_edge().powi(3);
    !(solid && volume.is_finite())
}
