//! Sample surfaces of the tests, as vertices and triangles.

use hydroelastic::mesh::TriangleSurface;
use nalgebra::{Vector3, vector};

pub type Triangulation = (Vec<Vector3<f64>>, Vec<[usize; 3]>);

/// Returns a box with a corner at `low` and corners numbered 4·x + 2·y + z.
pub fn block(low: Vector3<f64>, lengths: Vector3<f64>) -> Triangulation {
    let corner = |c: usize| {
        let steps = Vector3::new((c >> 2 & 1) as f64, (c >> 1 & 1) as f64, (c & 1) as f64);
        low + steps.component_mul(&lengths)
    };
    let quads = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    let halves = quads
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    ((0..8).map(corner).collect(), halves.collect())
}

pub fn unit_block(low: Vector3<f64>) -> Triangulation {
    block(low, vector![1.0, 1.0, 1.0])
}

/// Returns the surface turned inside out.
pub fn reversed((vertices, triangles): Triangulation) -> Triangulation {
    let triangles = triangles.into_iter().map(|[a, b, c]| [a, c, b]);
    (vertices, triangles.collect())
}

pub fn together(parts: impl IntoIterator<Item = Triangulation>) -> Triangulation {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for (more, indices) in parts {
        let first = vertices.len();
        vertices.extend(more);
        triangles.extend(indices.into_iter().map(|t| t.map(|vertex| first + vertex)));
    }
    (vertices, triangles)
}

pub fn soup((vertices, triangles): &Triangulation) -> Vec<[Vector3<f64>; 3]> {
    let corners = triangles.iter().map(|t| t.map(|vertex| vertices[vertex]));
    corners.collect()
}

pub fn surface((vertices, triangles): Triangulation) -> TriangleSurface {
    TriangleSurface::new(vertices, triangles).unwrap()
}

/// Returns a torus with these numbers of quads around and across, each quad cut into two triangles.
pub fn torus(radius: f64, tube: f64, counts: [usize; 2]) -> Triangulation {
    let [around, across] = counts;
    let angle = |step: usize, count: usize| std::f64::consts::TAU * step as f64 / count as f64;
    let vertex = |(i, j): (usize, usize)| {
        let (sin_u, cos_u) = angle(i, around).sin_cos();
        let (sin_v, cos_v) = angle(j, across).sin_cos();
        let out = radius + tube * cos_v;
        vector![out * cos_u, out * sin_u, tube * sin_v]
    };
    let cells = || (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let index = |i: usize, j: usize| (i % around) * across + j % across;
    let halves = |(i, j): (usize, usize)| {
        let [a, b, c, d] = [
            index(i, j),
            index(i + 1, j),
            index(i + 1, j + 1),
            index(i, j + 1),
        ];
        [[a, b, c], [a, c, d]]
    };
    (
        cells().map(vertex).collect(),
        cells().flat_map(halves).collect(),
    )
}
