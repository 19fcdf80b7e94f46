//! Derivatives of contact wrenches with respect to vertices, extents and the parameters of these, and derivatives of mass properties with
//! respect to vertices.

mod dimensions;
mod identities;
pub mod in_motion;
mod mass;
mod reference_data;
mod values;

use crate::partners::Shapes;
use crate::support::scenes::{Random, random_pair};
use hydroelastic::contact::{ContactPair, RigidShape, Shape, SurfaceLaw};
use hydroelastic::mesh::{PressureField, TetMesh, TriangleSurface};
use hydroelastic::spatial::Twist;
use nalgebra::{SVector, Vector3};

/// Returns weights that select one row of the wrenches.
fn row(row: usize) -> SVector<f64, 12> {
    SVector::from_fn(|i, _| if i == row { 1.0 } else { 0.0 })
}

/// Returns the shape with moved vertices and changed extents.
fn reshaped(shape: &Shape, moves: &[Vector3<f64>], changes: &[f64]) -> Shape {
    let field = shape.field();
    let pairs = field.mesh().vertices().iter().zip(moves);
    let vertices = pairs.map(|(vertex, by)| vertex + by).collect();
    let extents = field.extents().iter().zip(changes);
    let extents = extents.map(|(extent, change)| extent + change).collect();
    let mesh = TetMesh::new(vertices, field.mesh().tets().to_vec()).unwrap();
    Shape::new(PressureField::with_inert_tets(mesh, extents).unwrap())
}

/// Returns the surface with moved vertices.
fn rigid_reshaped(shape: &RigidShape, moves: &[Vector3<f64>]) -> RigidShape {
    let surface = shape.surface();
    let pairs = surface.vertices().iter().zip(moves);
    let vertices = pairs.map(|(vertex, by)| vertex + by).collect();
    RigidShape::new(TriangleSurface::new(vertices, surface.triangles().to_vec()).unwrap())
}

/// Visits touching pairs: two compliant bodies, and a compliant body with a rigid body or a half-space.
pub fn for_pairs(count: usize, seed: u8, mut check: impl FnMut(&ContactPair, &mut Random)) {
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

/// Returns the vertices of A and of B in the frames of their bodies.
fn vertices<'a>(pair: &ContactPair<'a>) -> [&'a [Vector3<f64>]; 2] {
    let of_mesh = |shape: &'a Shape| shape.field().mesh().vertices();
    let b = pair.b();
    let rigid = b.rigid_shape().map(|shape| shape.surface().vertices());
    let of_b = rigid.or(b.shape().map(of_mesh)).unwrap_or(&[]);
    [of_mesh(pair.a().shape()), of_b]
}

/// Returns a random law and velocities.
fn motion(random: &mut Random) -> (SurfaceLaw, [Twist; 2]) {
    let mut number = || random.between(-0.5, 0.5);
    let twists = [0, 1].map(|_| Twist::from_vector(&SVector::from_fn(|_, _| number())));
    let law = SurfaceLaw::new(random.between(0.0, 0.8), random.between(0.0, 1.0), 0.05);
    (law.unwrap(), twists)
}
