//! A small mesh and any partner, in any poses and motion, have finite wrenches and derivatives, and opposite forces.
//!
//! Numbers come in eighths, so that faces and edges often fall on one another.
#![no_main]

use hydroelastic::contact::{
    ContactBody, ContactPair, ContactWrench, Culling, HalfSpace, Partner, RigidShape, Search,
    Shape, SurfaceLaw,
};
use hydroelastic::mesh::{MeshError, PressureField, TetMesh, TriangleSurface, shapes};
use hydroelastic::spatial::{Pose, Twist, Wrench};
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
struct Place {
    turn: [i8; 3],
    at: [i8; 3],
}

#[derive(Debug, Arbitrary)]
struct Placed {
    solid: Solid,
    place: Place,
    modulus: u8,
}

#[derive(Debug, Arbitrary)]
enum Other {
    Compliant(Placed),
    Rigid(Placed),
    RigidHalfSpace(Place),
    Layer {
        thickness: u8,
        place: Place,
        modulus: u8,
    },
}

#[derive(Debug, Arbitrary)]
struct Motion {
    twists: [[[i8; 3]; 2]; 2],
    dissipation: u8,
    friction: u8,
    slip_tolerance: u8,
}

fuzz_target!(|scene: (Placed, Other, Motion)| {
    let (one, other, motion) = scene;
    let Ok(field) = one.solid.field() else {
        return;
    };
    let shape = Shape::new(field);
    let a = one.body(&shape);
    match other {
        Other::Compliant(other) => {
            if let Ok(field) = other.solid.field() {
                let shape = Shape::new(field);
                let b = other.body(&shape);
                check(&ContactPair::new(a, b), &motion);
                check_exchanged([a, b]);
            }
        }
        Other::Rigid(other) => {
            let surface = other.solid.field().ok();
            let surface = surface.and_then(|field| TriangleSurface::around(field.mesh()).ok());
            if let Some(surface) = surface {
                let shape = RigidShape::new(surface);
                let b = Partner::rigid(&shape, other.place.pose()).expect("the pose is finite");
                check(&ContactPair::new(a, b), &motion);
            }
        }
        Other::RigidHalfSpace(place) => {
            let b = Partner::rigid_half_space(place.pose()).expect("the pose is finite");
            check(&ContactPair::new(a, b), &motion);
        }
        Other::Layer {
            thickness,
            place,
            modulus,
        } => {
            if let Ok(layer) = HalfSpace::layer(eighths(thickness)) {
                let b = Partner::half_space(&layer, place.pose(), modulus_of(modulus))
                    .expect("pose and modulus are finite, and this positive");
                check(&ContactPair::new(a, b), &motion);
            }
        }
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

/// From 1 Pa to 1e8 Pa.
fn modulus_of(number: u8) -> f64 {
    10_f64.powf(f64::from(number) / 32.0)
}

impl Place {
    fn pose(&self) -> Pose {
        Pose::from_rotation_vector(&vector(self.turn), vector(self.at))
    }
}

impl Placed {
    fn body<'a>(&self, shape: &'a Shape) -> ContactBody<'a> {
        ContactBody::new(shape, self.place.pose(), modulus_of(self.modulus))
            .expect("pose and modulus are finite, and this positive")
    }
}

impl Motion {
    fn twists(&self) -> [Twist; 2] {
        self.twists.map(|[angular, linear]| Twist {
            angular: vector(angular),
            linear: vector(linear),
        })
    }

    fn law(&self) -> SurfaceLaw {
        let slip_tolerance = eighths(self.slip_tolerance.max(1));
        SurfaceLaw::new(
            eighths(self.dissipation),
            eighths(self.friction),
            slip_tolerance,
        )
        .expect("all are finite, and the tolerance is positive")
    }
}

fn check(pair: &ContactPair, motion: &Motion) {
    let contact = pair.linearized();
    let wrench = contact.wrench;
    assert_finite(contact.jacobian().as_slice());
    let scale = force_scale(pair);
    assert!(scale.is_finite());
    assert_opposite(pair, &wrench, scale);
    let plain = pair.wrench();
    assert_same(
        &plain.on_a,
        &wrench.on_a,
        scale,
        "with and without derivatives",
    );
    let culled = pair.with_search(Search::Culling(Culling::default()));
    assert_same(&culled.wrench().on_a, &wrench.on_a, scale, "by culling");

    let (law, twists) = (motion.law(), motion.twists());
    let moving = pair.moving(law, twists).wrench();
    let linearized = pair.moving(law, twists).linearized();
    assert_finite(linearized.jacobian().as_slice());
    let scale = scale * motion_scale(pair, &law, &twists);
    assert_opposite(pair, &moving, scale);
    let own = linearized.wrench.on_a;
    assert_same(
        &own,
        &moving.on_a,
        scale,
        "with and without derivatives, in motion",
    );
    let culled = culled.moving(law, twists).wrench().on_a;
    assert_same(&culled, &moving.on_a, scale, "by culling, in motion");
}

fn check_exchanged([a, b]: [ContactBody; 2]) {
    let pair = ContactPair::new(a, b);
    let exchanged = ContactPair::new(b, a).wrench();
    let wrench = pair.wrench();
    let scale = force_scale(&pair);
    assert_same(
        &exchanged.on_b,
        &wrench.on_a,
        scale,
        "bodies in the other order",
    );
}

fn assert_finite(numbers: &[f64]) {
    assert!(
        numbers.iter().all(|number| number.is_finite()),
        "{numbers:?}"
    );
}

fn assert_opposite(pair: &ContactPair, wrench: &ContactWrench, scale: f64) {
    let from_a_to_b = pair.b().pose().translation() - pair.a().pose().translation();
    let from_a = -wrench.on_a.about(&from_a_to_b);
    assert_same(&wrench.on_b, &from_a, scale, "third law");
}

/// Returns the largest distance (m) of a partner from the origin of the world. For a half-space, this is the distance of its frame.
fn reach_of(partner: &Partner) -> f64 {
    let own = match (partner.shape(), partner.rigid_shape()) {
        (Some(shape), _) => shape.field().reach(),
        (_, Some(shape)) => shape.surface().reach(),
        _ => 0.0,
    };
    own + partner.pose().translation().norm()
}

/// Largest pressure times area that either could have (N), and so a torque (N m) with the reach of both.
fn force_scale(pair: &ContactPair) -> f64 {
    let a = Partner::from(*pair.a());
    let highest = |partner: &Partner| {
        let extents = partner
            .shape()
            .map_or(&[][..], |shape| shape.field().extents());
        let extent = extents.iter().copied().fold(0.0, f64::max);
        extent * partner.modulus().unwrap_or_default()
    };
    let reach = 1.0 + reach_of(&a) + reach_of(pair.b());
    highest(&a).max(highest(pair.b())) * reach.powi(3)
}

/// Returns an upper bound of the factor by which dissipation and friction may increase the force.
fn motion_scale(pair: &ContactPair, law: &SurfaceLaw, twists: &[Twist; 2]) -> f64 {
    let reach = reach_of(&Partner::from(*pair.a())) + reach_of(pair.b());
    let speed = |twist: &Twist| twist.linear.norm() + 2.0 * twist.angular.norm() * reach;
    let speed = speed(&twists[0]) + speed(&twists[1]);
    (1.0 + law.dissipation() * speed) * (1.0 + law.friction())
}

fn assert_same(found: &Wrench, expected: &Wrench, scale: f64, what: &str) {
    let difference = (found.to_vector() - expected.to_vector()).amax();
    let is_same = difference <= ROUND_OFF * scale;
    assert!(
        is_same,
        "{what}: {found:?} {expected:?} differ by {difference:e}, scale {scale:e}"
    );
}
