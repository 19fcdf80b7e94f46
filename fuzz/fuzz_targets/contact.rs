//! Any two small meshes in any poses have finite wrenches and Jacobians, and push on each other alike.
//!
//! Numbers come in eighths, so that faces and edges often fall on one another.
#![no_main]

use hydroelastic::contact::{ContactBody, ContactPair, Culling, Search, Shape};
use hydroelastic::mesh::{MeshError, PressureField, TetMesh, shapes};
use hydroelastic::spatial::{Pose, Wrench};
use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use nalgebra::Vector3;

/// Round-off of sums over some hundred polygons, of the forces' scale (pressure × area).
const ROUND_OFF: f64 = 1e-9;

#[derive(Debug, Arbitrary)]
enum Solid {
    Ball {
        radius: u8,
        order: u8,
    },
    Cuboid([u8; 3]),
    DistanceCuboid([u8; 3]),
    Cylinder {
        radius: u8,
        length: u8,
        segments: u8,
    },
    Tetrahedra {
        vertices: [[i8; 3]; 5],
        is_double: bool,
    },
    Field {
        vertices: [[i8; 3]; 5],
        extents: [u8; 5],
    },
}

#[derive(Debug, Arbitrary)]
struct Placed {
    solid: Solid,
    turn: [i8; 3],
    at: [i8; 3],
    modulus: u8,
}

fuzz_target!(|pair: (Placed, Placed)| {
    let (one, other) = pair;
    if let (Ok(a), Ok(b)) = (one.solid.field(), other.solid.field()) {
        let (a, b) = (Shape::new(a), Shape::new(b));
        check(&ContactPair::new(one.body(&a), other.body(&b)));
    }
});

fn eighths(number: u8) -> f64 {
    f64::from(number) / 8.0
}

fn vector(numbers: [i8; 3]) -> Vector3<f64> {
    Vector3::from(numbers.map(|number| f64::from(number) / 8.0))
}

impl Solid {
    fn field(&self) -> Result<PressureField, MeshError> {
        match *self {
            Self::Ball { radius, order } => {
                shapes::icosphere(eighths(radius), usize::from(order % 2))
            }
            Self::Cuboid(edges) => shapes::cuboid(edges.map(eighths)),
            Self::DistanceCuboid(edges) => shapes::distance_cuboid(edges.map(eighths)),
            Self::Cylinder {
                radius,
                length,
                segments,
            } => shapes::cylinder(eighths(radius), eighths(length), usize::from(segments % 12)),
            Self::Tetrahedra {
                vertices,
                is_double,
            } => PressureField::from_distance(&tetrahedra(&vertices, is_double)?),
            Self::Field { vertices, extents } => {
                // Four tetrahedra about the last vertex, so that there can be one inside.
                let tets = vec![[0, 1, 2, 4], [0, 1, 3, 4], [0, 2, 3, 4], [1, 2, 3, 4]];
                let mesh = TetMesh::new(vertices.map(vector).into(), tets)?;
                PressureField::with_inert_tets(mesh, extents.map(eighths).into())
            }
        }
    }
}

/// One tetrahedron, or two with a face in common.
fn tetrahedra(vertices: &[[i8; 3]; 5], is_double: bool) -> Result<TetMesh, MeshError> {
    let count = if is_double { 2 } else { 1 };
    let vertices = vertices[..3 + count].iter().map(|&vertex| vector(vertex));
    let tets = [[0, 1, 2, 3], [0, 1, 2, 4]][..count].to_vec();
    TetMesh::new(vertices.collect(), tets)
}

impl Placed {
    fn body<'a>(&self, shape: &'a Shape) -> ContactBody<'a> {
        let pose = Pose::from_rotation_vector(&vector(self.turn), vector(self.at));
        let modulus = 10_f64.powf(f64::from(self.modulus) / 32.0);
        ContactBody::new(shape, pose, modulus)
            .expect("pose and modulus are finite, and this positive")
    }
}

fn check(pair: &ContactPair) {
    let (wrench, jacobian) = pair.wrench_and_jacobian();
    let matrices = [jacobian.on_a.matrix(), jacobian.on_b.matrix()];
    assert!(
        matrices
            .iter()
            .all(|matrix| matrix.iter().all(|entry| entry.is_finite())),
        "{matrices:?}"
    );
    let scale = force_scale(pair);
    assert!(scale.is_finite());
    let from_a_to_b = pair.b().pose().translation() - pair.a().pose().translation();
    assert_same(
        &wrench.on_b,
        &-wrench.on_a.about(&from_a_to_b),
        scale,
        "third law",
    );
    assert_same(
        &pair.wrench().on_a,
        &wrench.on_a,
        scale,
        "with and without Jacobian",
    );
    let swapped = ContactPair::new(*pair.b(), *pair.a()).wrench();
    assert_same(
        &swapped.on_b,
        &wrench.on_a,
        scale,
        "bodies in the other order",
    );
    let culled = pair
        .with_search(Search::Culling(Culling::default()))
        .wrench();
    assert_same(&culled.on_a, &wrench.on_a, scale, "by culling");
}

/// Largest pressure times area that the two could have (N), and so a torque (N m) with their reach.
fn force_scale(pair: &ContactPair) -> f64 {
    let of_body = |body: &ContactBody| {
        let field = body.shape().field();
        let extent = field
            .extents()
            .iter()
            .fold(0.0, |most: f64, &extent| most.max(extent));
        let reach = field.reach() + body.pose().translation().norm();
        (body.modulus() * extent, reach)
    };
    let ((pressure_a, reach_a), (pressure_b, reach_b)) = (of_body(pair.a()), of_body(pair.b()));
    let reach = 1.0 + reach_a + reach_b;
    pressure_a.max(pressure_b) * reach.powi(3)
}

fn assert_same(found: &Wrench, expected: &Wrench, scale: f64, what: &str) {
    let difference = (found.to_vector() - expected.to_vector()).amax();
    let is_same = difference <= ROUND_OFF * scale;
    assert!(
        is_same,
        "{what}: {found:?} {expected:?} differ by {difference:e}, scale {scale:e}"
    );
}
