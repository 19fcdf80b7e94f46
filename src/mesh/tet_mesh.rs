use super::surface::{OUTSIDE, Surface};
use super::{DensityError, MeshError, coordinates, mass};
use crate::geometry::{Aabb, Tetrahedron};
use crate::spatial::{MassGradient, MassProperties};
use nalgebra::Vector3;

/// A tetrahedron counts as flat where six times its volume is below this fraction of its longest
/// edge cubed: its barycentric gradients would have fewer than four correct digits left.
pub(super) const FLATNESS: f64 = 1e-12;

/// A tetrahedral mesh, validated: finite vertices, positively oriented tetrahedra of real volume
/// that meet in whole faces, every vertex in use.
#[derive(Debug, Clone)]
pub struct TetMesh {
    vertices: Vec<Vector3<f64>>,
    tets: Vec<[usize; 4]>,
    surface: Surface,
}

impl TetMesh {
    /// From vertices (m, in the body frame) and tetrahedra as indices of four vertices each.
    /// Tetrahedra given in negative orientation are turned round.
    ///
    /// # Errors
    /// If a coordinate is not finite, an index out of range or repeated, a tetrahedron flat, a
    /// vertex unused, or if tetrahedra overlap at a common face; each names the culprit.
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

    /// Positions of the vertices (m), in the body frame.
    #[must_use]
    pub fn vertices(&self) -> &[Vector3<f64>] {
        &self.vertices
    }

    /// The tetrahedra, as indices of their vertices, positively oriented.
    #[must_use]
    pub fn tets(&self) -> &[[usize; 4]] {
        &self.tets
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Number of tetrahedra.
    #[must_use]
    pub fn tet_count(&self) -> usize {
        self.tets.len()
    }

    /// The triangles of the surface, as indices of vertices, counter-clockwise seen from outside.
    #[must_use]
    pub fn surface_triangles(&self) -> &[[usize; 3]] {
        &self.surface.triangles
    }

    /// The tetrahedron that shares the face opposite to a corner (0..4) of a tetrahedron, or `None`
    /// where that face is part of the surface.
    #[inline]
    #[must_use]
    pub fn neighbor(&self, tet: usize, corner: usize) -> Option<usize> {
        let neighbor = self.surface.neighbors[tet][corner];
        (neighbor != OUTSIDE).then_some(neighbor as usize)
    }

    /// For each tetrahedron those that share the faces opposite to its corners, or [`OUTSIDE`].
    pub(crate) fn neighbors(&self) -> &[[u32; 4]] {
        &self.surface.neighbors
    }

    /// Whether the vertex lies on the surface.
    #[must_use]
    pub fn is_on_surface(&self, vertex: usize) -> bool {
        self.surface.has_vertex[vertex]
    }

    /// The corners of a tetrahedron (m).
    #[must_use]
    pub fn tetrahedron(&self, tet: usize) -> Tetrahedron {
        Tetrahedron {
            corners: self.tets[tet].map(|vertex| self.vertices[vertex]),
        }
    }

    /// The smallest box around the mesh.
    #[must_use]
    pub fn aabb(&self) -> Aabb {
        Aabb::around(&self.vertices)
    }

    /// Volume (m³).
    #[must_use]
    pub fn volume(&self) -> f64 {
        (0..self.tet_count())
            .map(|tet| self.tetrahedron(tet).signed_volume())
            .sum()
    }

    /// Mass, center of mass and inertia tensor at a uniform density (kg/m³).
    ///
    /// # Errors
    /// If the density is not positive, or the mass or the inertia is not finite.
    pub fn mass_properties(&self, density: f64) -> Result<MassProperties, DensityError> {
        let tetrahedra = (0..self.tet_count()).map(|tet| self.tetrahedron(tet));
        mass::mass_properties(self.aabb().center(), tetrahedra, density)
    }

    /// The derivatives by the vertices (the number's unit over m) of a number that has these derivatives by
    /// [`Self::mass_properties`] at this density (kg/m³). Exact up to round-off; those by inner vertices are 0.
    ///
    /// # Errors
    /// As [`Self::mass_properties`].
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
    for (place, &vertex) in corners.iter().enumerate() {
        if vertex >= vertex_count {
            return Err(MeshError::VertexOutOfRange {
                tet,
                vertex,
                vertex_count,
            });
        }
        if corners[..place].contains(&vertex) {
            return Err(MeshError::RepeatedVertex { tet, vertex });
        }
    }
    Ok(())
}

/// Gives the tetrahedron positive orientation, or says that it is flat.
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
            longest_edge: longest_edge(&tetrahedron),
        });
    }
    if volume < 0.0 {
        corners.swap(0, 1);
    }
    Ok(())
}

/// Whether the tetrahedron is flat to round-off, or too large for its volume to be a number.
pub(super) fn is_flat(tetrahedron: &Tetrahedron) -> bool {
    let volume = tetrahedron.signed_volume();
    // Not `<=`: a volume that overflowed or is NaN must not pass.
    let solid = 6.0 * volume.abs() > FLATNESS * longest_edge(tetrahedron).powi(3);
    !(solid && volume.is_finite())
}

fn longest_edge(tetrahedron: &Tetrahedron) -> f64 {
    let c = &tetrahedron.corners;
    [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
        .iter()
        .map(|&(i, j)| (c[i] - c[j]).norm())
        .fold(0.0, f64::max)
}
