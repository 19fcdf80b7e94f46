use crate::geometry::Aabb;
use crate::mesh::MeshError;
use crate::mesh::tet_mesh::FLATNESS;
use crate::mesh::welding::{place_key, without_unused};
use nalgebra::Vector3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Triangles that close in on a volume, all turned outwards; vertices at the same place are one.
pub(super) struct ClosedSurface {
    /// The vertices (m) of the triangles, and no others.
    pub vertices: Vec<Vector3<f64>>,
    /// The triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[usize; 3]>,
    /// Center of the volume (m).
    pub center: Vector3<f64>,
}

impl ClosedSurface {
    /// From vertices (m) and triangles, if they are such a surface. Vertices at the same place are merged into the first of
    /// them; those of no triangle are dropped without a check.
    pub fn new(
        vertices: Vec<Vector3<f64>>,
        mut triangles: Vec<[usize; 3]>,
    ) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::NoTriangles);
        }
        check_indices(&triangles, vertices.len())?;
        check_coordinates(&vertices, &triangles)?;
        let first_at_place = first_at_place(&vertices);
        for (index, triangle) in triangles.iter_mut().enumerate() {
            *triangle = triangle.map(|vertex| first_at_place[vertex]);
            check_corners(index, *triangle)?;
        }
        check_edges(&triangles)?;
        let (vertices, triangles) = without_unused(vertices, &triangles);
        let (volume, center) = volume_and_center(&vertices, &triangles);
        check_volume(volume, &center, &Aabb::around(&vertices))?;
        Ok(Self {
            vertices,
            triangles,
            center,
        })
    }
}

/// Checks that the vertices of the triangles are finite.
fn check_coordinates(vertices: &[Vector3<f64>], triangles: &[[usize; 3]]) -> Result<(), MeshError> {
    for &vertex in triangles.iter().flatten() {
        let mut coordinates = vertices[vertex].iter();
        if let Some(&value) = coordinates.find(|value| !value.is_finite()) {
            return Err(MeshError::NonFiniteCoordinate { vertex, value });
        }
    }
    Ok(())
}

/// Checks that the triangles refer to vertices that are there.
fn check_indices(triangles: &[[usize; 3]], vertex_count: usize) -> Result<(), MeshError> {
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex >= vertex_count) {
            return Err(MeshError::TriangleVertexOutOfRange {
                triangle,
                vertex,
                vertex_count,
            });
        }
    }
    Ok(())
}

/// For each vertex the first one at its place.
fn first_at_place(vertices: &[Vector3<f64>]) -> Vec<usize> {
    let mut first = HashMap::new();
    let first_at = |(vertex, position): (usize, &Vector3<f64>)| {
        *first.entry(place_key(position)).or_insert(vertex)
    };
    vertices.iter().enumerate().map(first_at).collect()
}

/// Checks that the three corners differ.
fn check_corners(triangle: usize, [a, b, c]: [usize; 3]) -> Result<(), MeshError> {
    for (one, other) in [(a, b), (b, c), (c, a)] {
        if one == other {
            return Err(MeshError::RepeatedTriangleVertex {
                triangle,
                vertex: one,
            });
        }
    }
    Ok(())
}

/// Checks that every edge belongs to two triangles that run along it in opposite directions.
fn check_edges(triangles: &[[usize; 3]]) -> Result<(), MeshError> {
    let mut along = HashMap::with_capacity(3 * triangles.len());
    for (triangle, edge) in directed_edges(triangles) {
        match along.entry(edge) {
            Entry::Vacant(entry) => entry.insert(triangle),
            Entry::Occupied(entry) => {
                return Err(MeshError::InconsistentTriangles {
                    first: *entry.get(),
                    second: triangle,
                    edge,
                });
            }
        };
    }
    let mut edges = directed_edges(triangles);
    match edges.find(|(_, [from, to])| !along.contains_key(&[*to, *from])) {
        Some((triangle, edge)) => Err(MeshError::OpenSurface { triangle, edge }),
        None => Ok(()),
    }
}

/// The edges with their triangles, in the direction in which those run round.
fn directed_edges(triangles: &[[usize; 3]]) -> impl Iterator<Item = (usize, [usize; 2])> {
    let edges_of = |(index, &[a, b, c]): (usize, &[usize; 3])| {
        [[a, b], [b, c], [c, a]].map(|edge| (index, edge))
    };
    triangles.iter().enumerate().flat_map(edges_of)
}

/// Checks that the volume (m³) in a box and its center (m) are finite, and the volume is positive and more
/// than what would be flat for a tetrahedron: of less the center would be round-off.
fn check_volume(volume: f64, center: &Vector3<f64>, aabb: &Aabb) -> Result<(), MeshError> {
    let diagonal = (aabb.upper - aabb.lower).norm();
    let flat = FLATNESS * diagonal.powi(3);
    if 6.0 * volume <= flat && flat.is_finite() {
        return Err(MeshError::EnclosedVolume { volume, diagonal });
    }
    let numbers = [volume, flat, center.x, center.y, center.z];
    if numbers.iter().all(|number| number.is_finite()) {
        Ok(())
    } else {
        Err(MeshError::SurfaceTooLarge { diagonal })
    }
}

/// The volume (m³) inside and its center (m), by the divergence theorem: sums over the signed
/// tetrahedra between the triangles and the middle of the box, so that little cancels.
fn volume_and_center(vertices: &[Vector3<f64>], triangles: &[[usize; 3]]) -> (f64, Vector3<f64>) {
    let middle = Aabb::around(vertices).center();
    let (mut six_volumes, mut moment) = (0.0, Vector3::zeros());
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| vertices[vertex] - middle);
        let part = a.dot(&b.cross(&c));
        six_volumes += part;
        moment += (a + b + c) * part;
    }
    (six_volumes / 6.0, middle + moment / (4.0 * six_volumes))
}
