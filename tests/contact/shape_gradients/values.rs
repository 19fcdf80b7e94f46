//! Shape gradients in closed form.

use super::row;
use crate::support::reference::shape;
use hydroelastic::contact::Shape;
use hydroelastic::contact::{ContactBody, ContactPair, Partner};
use hydroelastic::mesh::{PressureField, TetMesh};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

const EXACT: f64 = 1e-12;

/// The cube has edge 0.2 m and 1e6 Pa at its center, and is 0.01 m below a rigid plane: F = κ(a²x − 2ax² + 4x³/3), κ = 2E/a.
#[test]
fn a_cube_flat_on_a_rigid_plane() {
    let unit = shape("cube");
    let field = unit.field();
    let vertices: Vec<_> = field.mesh().vertices().iter().map(|x| x * 0.2).collect();
    let mesh = TetMesh::new(vertices, field.mesh().tets().to_vec()).unwrap();
    let cube = Shape::new(PressureField::new(mesh, field.extents().to_vec()).unwrap());
    let above = Pose::from_translation(vector![0.0, 0.0, 0.09]);
    let pair = ContactPair::new(
        ContactBody::new(&cube, above, 1e6).unwrap(),
        Partner::rigid_half_space(Pose::identity()).unwrap(),
    );
    let [by_cube, _] = pair.shape_gradients(&row(5));
    let close = |actual: f64, expected: f64| {
        assert!(
            (actual - expected).abs() <= EXACT * 1e5,
            "{actual} for {expected}"
        );
    };
    let vertices = cube.field().mesh().vertices();
    for (axis, expected) in [10840.0 / 3.0, 10840.0 / 3.0, 29160.0]
        .into_iter()
        .enumerate()
    {
        let stretched = vertices
            .iter()
            .map(|x| Vector3::from_fn(|i, _| if i == axis { x[i] } else { 0.0 }));
        let rates = stretched.collect::<Vec<_>>().into();
        close(by_cube.along(&rates).unwrap(), expected);
    }
    let at = |x: [f64; 3]| {
        let index = vertices
            .iter()
            .position(|v| (v - Vector3::from(x)).amax() < 1e-12);
        by_cube.by_vertices[index.unwrap()]
    };
    let corner = at([-0.1, -0.1, -0.1]);
    for (axis, expected) in [-9025.0, -9025.0, -97200.0].into_iter().enumerate() {
        close(corner[axis], expected);
    }
    let center = at([0.0, 0.0, 0.0]);
    for (axis, expected) in [0.0, 0.0, -32400.0].into_iter().enumerate() {
        close(center[axis], expected);
    }
    close(
        by_cube
            .by_extents
            .iter()
            .zip(cube.field().extents())
            .map(|(by, e)| by * e)
            .sum(),
        10840.0 / 3.0,
    );
}
