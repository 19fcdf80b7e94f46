//! Derivatives of contact wrenches by vertices and extents and what these are made of, and of mass properties by vertices.

mod dimensions;
mod identities;
mod in_motion;
mod mass;
mod reference_data;
mod values;

use crate::partners::Shapes;
use crate::support::scenes::{Random, random_pair};
use hydroelastic::contact::{ContactPair, RigidShape, Shape, SurfaceLaw};
use hydroelastic::mesh::{PressureField, TetMesh, TriangleSurface};
use hydroelastic::spatial::Twist;
use nalgebra::{SVector, Vector3};

/// A number that is one row of the wrenches.
fn row(row: usize) -> SVector<f64, 12> {
    SVector::from_fn(|i, _| if i == row { 1.0 } else { 0.0 })
}

/// The shape with its vertices moved, and its extents changed.
fn reshaped(shape: &Shape, moves: &[Vector3<f64>], changes: &[f64]) -> Shape {
    let field = shape.field();
    let pairs = field.mesh().vertices().iter().zip(moves);
    let vertices = pairs.map(|(vertex, by)| vertex + by).collect();
    let extents = field.extents().iter().zip(changes);
    let extents = extents.map(|(extent, change)| extent + change).collect();
    let mesh = TetMesh::new(vertices, field.mesh().tets().to_vec()).unwrap();
    Shape::new(PressureField::with_inert_tets(mesh, extents).unwrap())
}

/// The surface with its vertices moved.
fn rigid_reshaped(shape: &RigidShape, moves: &[Vector3<f64>]) -> RigidShape {
    let surface = shape.surface();
    let pairs = surface.vertices().iter().zip(moves);
    let vertices = pairs.map(|(vertex, by)| vertex + by).collect();
    RigidShape::new(TriangleSurface::new(vertices, surface.triangles().to_vec()).unwrap())
}

/// Pairs that touch: of compliant bodies, and of one with a rigid body or a half-space.
fn for_pairs(count: usize, seed: u8, mut check: impl FnMut(&ContactPair, &mut Random)) {
    let shapes = Shapes::mixed();
    shapes.for_pairs(count / 2, seed, &mut check);
    let mut random = Random::new(seed);
    let mut checked = 0;
    while checked < count / 2 {
        let pair = random_pair(&shapes.compliant, &mut random);
        if !pair.surface().is_empty() {
            check(&pair, &mut random);
            checked += 1;
        }
    }
}

/// Where the vertices of A and of B are, in the frames of their bodies.
fn vertices<'a>(pair: &ContactPair<'a>) -> [&'a [Vector3<f64>]; 2] {
    let of_mesh = |shape: &'a Shape| shape.field().mesh().vertices();
    let b = pair.b();
    let rigid = b.rigid_shape().map(|shape| shape.surface().vertices());
    let of_b = rigid.or(b.shape().map(of_mesh)).unwrap_or(&[]);
    [of_mesh(pair.a().shape()), of_b]
}

/// A law and velocities.
fn motion(random: &mut Random) -> (SurfaceLaw, [Twist; 2]) {
    let mut number = || random.between(-0.5, 0.5);
    let twists = [0, 1].map(|_| Twist::from_vector(&SVector::from_fn(|_, _| number())));
    let law = SurfaceLaw::new(random.between(0.0, 0.8), random.between(0.0, 1.0), 0.05);
    (law.unwrap(), twists)
}
