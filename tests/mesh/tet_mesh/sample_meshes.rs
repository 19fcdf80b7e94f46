//! Sample meshes of the tests, and comparisons to round-off.

use hydroelastic::mesh::{TetMesh, shapes};
use nalgebra::{Matrix3, Vector3, vector};
use std::collections::BTreeMap;

/// Relative rounding error of sums over a few hundred tetrahedra.
pub const ROUND_OFF: f64 = 1e-14;

/// The six tetrahedra of a cube about its diagonal (Kuhn). Corners are numbered 4·x + 2·y + z.
pub const KUHN: [[usize; 4]; 6] = [
    [0, 4, 6, 7],
    [0, 4, 5, 7],
    [0, 2, 6, 7],
    [0, 2, 3, 7],
    [0, 1, 5, 7],
    [0, 1, 3, 7],
];

/// The five tetrahedra of a cube: one inside, four at corners.
pub const FIVE: [[usize; 4]; 5] = [
    [0, 3, 5, 6],
    [1, 0, 3, 5],
    [2, 0, 3, 6],
    [4, 0, 5, 6],
    [7, 3, 5, 6],
];

pub fn unit_corners() -> Vec<Vector3<f64>> {
    vec![
        vector![0.0, 0.0, 0.0],
        vector![1.0, 0.0, 0.0],
        vector![0.0, 1.0, 0.0],
        vector![0.0, 0.0, 1.0],
    ]
}

pub fn unit_tet() -> TetMesh {
    TetMesh::new(unit_corners(), vec![[0, 1, 2, 3]]).unwrap()
}

/// Creates a mesh from the cells of a grid whose lowest corner satisfies `keeps`, with six tetrahedra per cell.
pub fn grid(counts: [usize; 3], spacing: f64, keeps: impl Fn([usize; 3]) -> bool) -> TetMesh {
    let mut indices = BTreeMap::new();
    let mut vertices = Vec::new();
    let mut tets = Vec::new();
    let cells = (0..counts[0])
        .flat_map(|x| (0..counts[1]).flat_map(move |y| (0..counts[2]).map(move |z| [x, y, z])));
    for cell in cells.filter(|&cell| keeps(cell)) {
        let corner = |corner: usize| [2, 1, 0].map(|bit| corner >> bit & 1);
        let corners: Vec<usize> = (0..8)
            .map(|c| {
                let steps: [usize; 3] = std::array::from_fn(|axis| cell[axis] + corner(c)[axis]);
                *indices.entry(steps).or_insert_with(|| {
                    vertices.push(Vector3::from(steps.map(|step| step as f64 * spacing)));
                    vertices.len() - 1
                })
            })
            .collect();
        tets.extend(KUHN.map(|tet| tet.map(|c| corners[c])));
    }
    TetMesh::new(vertices, tets).unwrap()
}

pub fn cube(tets: &[[usize; 4]]) -> TetMesh {
    let corner = |c: usize| Vector3::new((c >> 2 & 1) as f64, (c >> 1 & 1) as f64, (c & 1) as f64);
    TetMesh::new((0..8).map(corner).collect(), tets.to_vec()).unwrap()
}

/// Returns a cube of edge 2 without a quarter: an L of height 2 with its concave edge at x = y = 1.
pub fn l_shape(cells: usize) -> TetMesh {
    let keeps = |[x, y, _]: [usize; 3]| x < cells || y < cells;
    grid([2 * cells, 2 * cells, 2 * cells], 1.0 / cells as f64, keeps)
}

pub fn meshes() -> Vec<(&'static str, TetMesh)> {
    vec![
        ("one tetrahedron", unit_tet()),
        ("cube of five", cube(&FIVE)),
        ("cube of six", cube(&KUHN)),
        ("bar", grid([5, 1, 1], 0.25, |_| true)),
        ("plate", grid([3, 4, 1], 0.5, |_| true)),
        ("block", grid([3, 3, 3], 0.5, |_| true)),
        ("L", l_shape(1)),
        ("frame", grid([3, 3, 1], 1.0, |[x, y, _]| (x, y) != (1, 1))),
        ("ball", shapes::icosphere(0.3, 1).unwrap().mesh().clone()),
        (
            "disc",
            shapes::cylinder(0.5, 0.2, 9).unwrap().mesh().clone(),
        ),
    ]
}

pub fn transformed(mesh: &TetMesh, map: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> TetMesh {
    TetMesh::new(
        mesh.vertices().iter().map(map).collect(),
        mesh.tets().to_vec(),
    )
    .unwrap()
}

/// Returns the volume inside the surface by the divergence theorem: Σ a·(b × c)/6.
pub fn enclosed_volume(mesh: &TetMesh) -> f64 {
    let origin = mesh.vertices()[0];
    let sixth = |triangle: &[usize; 3]| {
        let [a, b, c] = triangle.map(|vertex| mesh.vertices()[vertex] - origin);
        a.dot(&b.cross(&c)) / 6.0
    };
    mesh.surface_triangles().iter().map(sixth).sum()
}

pub fn assert_relative(actual: f64, expected: f64, tolerance: f64) {
    let error = (actual - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{actual:e} is not {expected:e}"
    );
}

/// Returns a mesh of five vertices, the last of which is inside.
pub fn tet_around_a_vertex() -> TetMesh {
    let mut vertices = unit_corners();
    vertices.push(vector![0.2, 0.2, 0.2]);
    let tets = vec![[0, 1, 2, 4], [0, 1, 3, 4], [0, 2, 3, 4], [1, 2, 3, 4]];
    TetMesh::new(vertices, tets).unwrap()
}

/// Compares inertias relative to the largest moment.
pub fn assert_inertia(actual: &Matrix3<f64>, expected: &Matrix3<f64>, tolerance: f64) {
    let error = (actual - expected).amax();
    assert!(
        error <= tolerance * expected.amax(),
        "{actual} is not {expected}"
    );
}
