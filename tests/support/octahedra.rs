//! Two octahedra, one above the other, whose contact has closed forms.
//!
//! The extent is 1 − |x| − |y| − |z| from the center, which is (0, 0, h) for A and (0, 0, −h) for B. With s = |x| + |y| and the overlap L =
//! 1 − h, the pressures between the centers are
//!
//! p_A = E_A (L − s + z), p_B = E_B (L − s − z).
//!
//! They are equal on z = c (L − s) with c = (E_B − E_A)/(E_A + E_B), a roof of four triangles. On the roof, both pressures are k (L − s)
//! with k = 2 E_A E_B/(E_A + E_B).

use super::scenes::{Random, pair};
use super::subdivisions::{Division, divided};
use hydroelastic::contact::{ContactPair, Shape};
use hydroelastic::mesh::{PressureField, TetMesh};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

/// Height (m) of A's center above the middle, and depth of B's center below it.
pub const HEIGHT: f64 = 0.7;

/// L (m): half the diagonal of the square covered by the contact surface.
pub const OVERLAP: f64 = 1.0 - HEIGHT;

/// Returns an octahedron with corners 1 m from its center. Its tetrahedra are divided into eight a number of times.
pub fn octahedron(times: usize) -> Shape {
    let mut vertices: Vec<Vector3<f64>> = vec![Vector3::zeros()];
    vertices.extend((0..3).flat_map(|axis| [Vector3::ith(axis, 1.0), Vector3::ith(axis, -1.0)]));
    let octants = (0..8).map(|octant| [0, 1 + octant % 2, 3 + octant / 2 % 2, 5 + octant / 4]);
    let mesh = TetMesh::new(vertices, octants.collect()).unwrap();
    let whole = PressureField::new(mesh, vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    let mut random = Random::new(1);
    Shape::new((0..times).fold(whole, |field, _| {
        divided(&field, Division::Halves, &mut random)
    }))
}

/// Returns the pose of the scene in the world, which is generic, so that no axis is special.
pub fn stage() -> Pose {
    Pose::from_rotation_vector(&vector![0.3, -0.5, 0.4], vector![0.2, -0.1, 0.35])
}

/// Returns the poses of A and B on the stage.
pub fn poses() -> [Pose; 2] {
    [HEIGHT, -HEIGHT].map(|z| stage() * Pose::from_translation(vector![0.0, 0.0, z]))
}

/// Returns A above B on the stage, with moduli (Pa).
pub fn stacked(octahedron: &Shape, moduli: [f64; 2]) -> ContactPair<'_> {
    let [above, below] = poses();
    pair(
        (octahedron, above, moduli[0]),
        (octahedron, below, moduli[1]),
    )
}

/// Returns c, the slope of the roof.
pub fn slope([modulus_a, modulus_b]: [f64; 2]) -> f64 {
    (modulus_b - modulus_a) / (modulus_a + modulus_b)
}

/// Returns k (Pa/m), the decrease of the pressure with distance from the middle.
pub fn fall([modulus_a, modulus_b]: [f64; 2]) -> f64 {
    2.0 * modulus_a * modulus_b / (modulus_a + modulus_b)
}

/// Returns the force (N): k ∫ (L − s) dx dy = 2 k L³/3.
pub fn force(moduli: [f64; 2]) -> f64 {
    2.0 * fall(moduli) * OVERLAP.powi(3) / 3.0
}
