use crate::mesh::welding::place_key;
use crate::mesh::{MeshError, PressureField, ShapeRates, TetMesh};
use crate::scalar::{DenseDual, Scalar, change, lift, real_part, real_vector};
use nalgebra::Vector3;
use std::collections::HashMap;

/// A tetrahedron along an edge of the core must have six times its volume above this fraction of
/// the shape's size cubed: ten times what counts as flat, because tetrahedra are longer than the
/// shape is wide.
const SLIMMEST: f64 = 1e-11;

/// A shape filled from its surface to its *core*, the set of points farthest from the surface:
/// a point, a segment or a flat polygon.
pub(super) struct CoredSurface<T = f64> {
    /// Vertices of the surface (m).
    pub vertices: Vec<Vector3<T>>,
    /// Triangles of the surface, counter-clockwise seen from outside.
    pub triangles: Vec<[usize; 3]>,
    /// For each vertex of the surface the point of the core (m) that it is joined to.
    pub core_points: Vec<Vector3<T>>,
    /// Whether the core opens in another direction as soon as a dimension of the shape changes.
    pub is_about_to_open: bool,
}

/// Whether a core that has this size (m) in one direction, and the size `solid` (m) after [`core_size`], is closed there in a
/// shape of this depth (m) because further faces of the shape are as near as the nearest, up to nine digits, and not
/// because the shape is slender.
pub(super) fn is_about_to_open<T: Scalar>(size: f64, solid: T, depth: f64) -> bool {
    real_part(solid) == 0.0 && size <= 1e-9 * depth
}

/// The size of a core in one direction (m), or 0 where the tetrahedra along it would be flat: those
/// with six times the volume `size` × `across` (m²), in a shape of `shape_size` (m). Without that
/// direction of the core the field departs from the true distance by up to `size`.
pub(super) fn core_size<T: Scalar>(size: T, across: f64, shape_size: f64) -> T {
    if real_part(size) * across > SLIMMEST * shape_size.powi(3) {
        size
    } else {
        lift(0.0)
    }
}

/// The least of some numbers; of several that are equal, the mean, which has the mean of their derivatives.
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
    /// The vertices, those of the surface first, the tetrahedra, and the extents: 0 on the surface and 1 on the core.
    ///
    /// Between a surface triangle and its image in the core lies a prism, which may have lost
    /// edges where core vertices coincide. It falls into tetrahedra along the staircase that
    /// climbs from the surface to the core vertex by vertex, in one order for the whole surface;
    /// both prisms at a common side climb alike, so the mesh fits together. Vertices with the same
    /// core vertex follow each other, or a flat tetrahedron would be left between them.
    fn filled(self) -> Filled<T> {
        let surface_count = self.vertices.len();
        let (core, core_of) = distinct(&self.core_points);
        let mut tets = Vec::new();
        for triangle in &self.triangles {
            let mut low = *triangle;
            low.sort_unstable_by_key(|&vertex| (core_of[vertex], vertex));
            let high = low.map(|vertex| surface_count + core_of[vertex]);
            for climbed in (0..3).rev() {
                let tet = staircase_step(low, high, climbed);
                if !has_repeats(tet) {
                    tets.push(tet);
                }
            }
        }
        let mut extents = vec![0.0; surface_count];
        extents.resize(surface_count + core.len(), 1.0);
        let vertices = [self.vertices, core].concat();
        (vertices, tets, extents)
    }
}

impl CoredSurface {
    /// The field with extent 0 on the surface and 1 on the core.
    pub fn field(self) -> Result<PressureField, MeshError> {
        let (vertices, tets, extents) = self.filled();
        PressureField::new(TetMesh::new(vertices, tets)?, extents)
    }
}

impl<const N: usize> CoredSurface<DenseDual<N>> {
    /// How the field changes with each variable, if [`CoredSurface::field`] would have one.
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
            // They are 0 and 1, whatever the size.
            extents: vec![0.0; extents.len()],
            ambiguous: ambiguous.clone(),
        }))
    }
}

/// Vertices (m), tetrahedra and extents.
type Filled<T> = (Vec<Vector3<T>>, Vec<[usize; 4]>, Vec<f64>);

/// The distinct points, and for each point its place among them.
fn distinct<T: Scalar>(points: &[Vector3<T>]) -> (Vec<Vector3<T>>, Vec<usize>) {
    let mut known = Vec::new();
    let mut places = HashMap::new();
    let place_of = points.iter().map(|point| {
        *places
            .entry(place_key(&real_vector(point)))
            .or_insert_with(|| {
                known.push(*point);
                known.len() - 1
            })
    });
    let place_of = place_of.collect();
    (known, place_of)
}

/// The tetrahedron low[0..=climbed], high[climbed..3].
fn staircase_step(low: [usize; 3], high: [usize; 3], climbed: usize) -> [usize; 4] {
    std::array::from_fn(|place| {
        if place <= climbed {
            low[place]
        } else {
            high[place - 1]
        }
    })
}

fn has_repeats(tet: [usize; 4]) -> bool {
    (1..4).any(|place| tet[..place].contains(&tet[place]))
}
