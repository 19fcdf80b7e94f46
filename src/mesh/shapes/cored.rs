use super::staircase::prism;
use crate::mesh::welding::position_key;
use crate::mesh::{MeshError, PressureField, ShapeRates, TetMesh};
use crate::scalar::{DenseDual, Scalar, change, lift, real_part, real_vector};
use nalgebra::Vector3;
use std::collections::HashMap;

/// Flatness tolerance of a tetrahedron along an edge of the core: six times its volume over the cubed size of the
/// shape. It is ten times the tolerance of [`TetMesh`], because tetrahedra may be longer than the size of the shape.
const SLIMMEST: f64 = 1e-11;

/// A shape filled from its surface to its *core*, the set of points farthest from the surface. The core is a point, a
/// segment or a flat polygon.
pub(super) struct CoredSurface<T = f64> {
    /// Vertices of the surface (m).
    pub vertices: Vec<Vector3<T>>,
    /// Triangles of the surface, counter-clockwise when seen from outside.
    pub triangles: Vec<[usize; 3]>,
    /// The point of the core (m) to which each surface vertex is joined.
    pub core_points: Vec<Vector3<T>>,
    /// Flag that is set if the core gains a dimension as soon as a dimension of the shape changes.
    pub is_about_to_open: bool,
}

/// Returns true if the core is collapsed along an axis by a tie between closest faces, rather than by slenderness.
///
/// `size` is the size (m) of the core along the axis. `solid` is the result of [`core_size`] for
/// this size. Faces are tied if `size` is at most 1e-9 of the `depth` (m) of the shape.
pub(super) fn is_about_to_open<T: Scalar>(size: f64, solid: T, depth: f64) -> bool {
    real_part(solid) == 0.0 && size <= 1e-9 * depth
}

/// Returns the size (m) of a core along an axis, or 0 if the tetrahedra along it would be flat.
///
/// Six times the volume of these tetrahedra is `size` × `across` (m²). The size of the shape is `shape_size` (m). If
/// the core is collapsed, the field differs from the true distance by up to `size`.
pub(super) fn core_size<T: Scalar>(size: T, across: f64, shape_size: f64) -> T {
    if real_part(size) * across > SLIMMEST * shape_size.powi(3) {
        size
    } else {
        lift(0.0)
    }
}

/// Returns the minimum. In a tie, the derivatives are the mean of the derivatives of the tied numbers.
pub(super) fn least<T: Scalar>(numbers: &[T]) -> T {
    let least = numbers
        .iter()
        .map(|&number| real_part(number))
        .fold(f64::INFINITY, f64::min);
    let equal = numbers.iter().filter(|&&number| real_part(number) <= least);
    let count = equal.clone().count() as f64;
    let changes = equal.map(|&number| change(number) / count);
    changes.fold(lift(least), |sum, part| sum + part)
}

impl<T: Scalar> CoredSurface<T> {
    /// Returns the vertices (surface first), the tetrahedra, and the extents: 0 on the surface and 1 on the core.
    ///
    /// A prism lies between a surface triangle and its image in the core. It is degenerate if core vertices coincide.
    /// It is divided into tetrahedra by a staircase that climbs from the surface to the core one vertex at a time. The
    /// order of the vertices is the same for the whole surface, so that two prisms divide their common side alike.
    /// Vertices with the same core vertex are consecutive in this order. Otherwise a flat tetrahedron would arise
    /// between them.
    fn filled(self) -> Filled<T> {
        let surface_count = self.vertices.len();
        let (core, core_of) = distinct(&self.core_points);
        let mut tets = Vec::new();
        for triangle in &self.triangles {
            let mut low = *triangle;
            low.sort_unstable_by_key(|&vertex| (core_of[vertex], vertex));
            let high = low.map(|vertex| surface_count + core_of[vertex]);
            tets.extend(prism(low, high));
        }
        let mut extents = vec![0.0; surface_count];
        extents.resize(surface_count + core.len(), 1.0);
        let vertices = [self.vertices, core].concat();
        (vertices, tets, extents)
    }
}

impl CoredSurface {
    /// Builds the field with extent 0 on the surface and 1 on the core.
    pub fn field(self) -> Result<PressureField, MeshError> {
        let (vertices, tets, extents) = self.filled();
        PressureField::new(TetMesh::new(vertices, tets)?, extents)
    }
}

impl<const N: usize> CoredSurface<DenseDual<N>> {
    /// Computes the rates of change of the field with respect to each variable. Fails if [`CoredSurface::field`] has an
    /// invalid mesh.
    pub fn rates(self) -> Result<[ShapeRates; N], MeshError> {
        let (surface_count, is_ambiguous) = (self.vertices.len(), self.is_about_to_open);
        let (vertices, tets, extents) = self.filled();
        TetMesh::new(vertices.iter().map(real_vector).collect(), tets)?;
        let ambiguous = if is_ambiguous {
            (surface_count..vertices.len()).collect()
        } else {
            Vec::new()
        };
        Ok(std::array::from_fn(|variable| ShapeRates {
            vertices: vertices
                .iter()
                .map(|at| at.map(|x| x.eps[variable]))
                .collect(),
            // Extents are constant: 0 and 1.
            extents: vec![0.0; extents.len()],
            ambiguous: ambiguous.clone(),
        }))
    }
}

/// Vertices (m), tetrahedra and extents.
type Filled<T> = (Vec<Vector3<T>>, Vec<[usize; 4]>, Vec<f64>);

/// Returns the distinct points, and the index of each point among them.
fn distinct<T: Scalar>(points: &[Vector3<T>]) -> (Vec<Vector3<T>>, Vec<usize>) {
    let mut known = Vec::new();
    let mut indices = HashMap::new();
    let index_of = points.iter().map(|point| {
        *indices
            .entry(position_key(&real_vector(point)))
            .or_insert_with(|| {
                known.push(*point);
                known.len() - 1
            })
    });
    let index_of = index_of.collect();
    (known, index_of)
}
