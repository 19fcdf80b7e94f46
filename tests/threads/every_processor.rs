//! Contacts and worlds have the same bits on every processor and with every C library. The tests compare them with recorded bits.
//!
//! Numbers come from sums, products, quotients and square roots, which IEEE 754 defines to the last bit. Sines, arctangents and logarithms
//! use only these operations, too (`scalar::portable`). Numbers in SIMD lanes have the same bits with 2, 4 and 8 lanes. Implicit steps of
//! 16 or more bodies are not tested here, because their sparse solver uses fused multiply-add if the processor has it.
//!
//! If a change of the library is meant to change bits, copy the new bits from the failures of
//!
//! ```sh
//! cargo test --test threads every_processor::
//! ```

use crate::reproducible::{bytes, hash, jacobian_bytes, rollout_bytes};
use hydroelastic::contact::{
    ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape, SurfaceLaw,
};
use hydroelastic::dynamics::{Body, Integrator, Mass, Material, Plan, World};
use hydroelastic::gradient::{FinalPosition, Parameter};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Matrix3, SVector, Vector3, vector};
use std::sync::Arc;

/// Hash of all bits of each contact between A and its partner.
const CONTACTS: [(&str, u64); 15] = [
    ("many polygons", 0xa71a_a18d_ae3b_23ca),
    ("ball, ball", 0x37b1_d374_dd06_5997),
    ("ball, block", 0xef09_a7be_7be8_0afc),
    ("ball, rigid ball", 0x980f_21b7_8616_1369),
    ("ball, half-space", 0xa59a_d3fb_de8f_fed7),
    ("ball, cylinder", 0xac7e_caa3_9aec_17a2),
    ("cylinder, cylinder", 0x0b59_7604_15d0_99c2),
    ("ball, layer", 0x8959_a82d_5325_5371),
    ("block, block", 0x5cd7_5b8a_1e34_de26),
    ("flush blocks", 0x8ac5_2487_f96a_479f),
    ("flush blocks, turned", 0xa3e2_f610_6851_1965),
    ("flush, rigid", 0x3551_1ca5_90c3_5f11),
    ("flush, half-space", 0x3dc8_f2f0_3c88_6802),
    ("flush, layer", 0x19dd_fb50_b759_b538),
    ("same block", 0x7ae1_b14a_b6a1_8e1b),
];

/// Hash of all bits of all states, by integrator and number of steps.
const ROLLOUTS: [((Integrator, usize), u64); 4] = [
    ((Integrator::SymplecticEuler, 300), 0x7882_89b2_16cb_0b23),
    ((Integrator::Leapfrog, 300), 0xba78_9563_0498_2a7c),
    ((Integrator::Sdirk3, 40), 0xfaac_dc69_85b3_414f),
    ((Integrator::ImplicitEuler, 40), 0xf4f7_d44e_11b6_8ec9),
];

/// Hash of the derivatives of a rollout and of its final state.
const JACOBIAN: [(&str, u64); 1] = [("jacobian", 0xbbf4_4574_2bb3_0203)];

const TIME_STEP: f64 = 1e-3;
const JACOBIAN_STEPS: usize = 30;

/// Friction coefficients with slip tolerances (m/s). With the first law, the slip direction varies little within a polygon. With the second
/// law, it varies more and needs other quadrature rules. With the third law, it varies quickly and needs the closed form with its
/// logarithms and arctangents.
const LAWS: [[f64; 2]; 3] = [[0.0, 20.0], [0.5, 0.5], [0.5, 1e-3]];

/// Slip tolerance (m/s) of the heap.
const SLIP_TOLERANCE: f64 = 1e-2;

/// Returns the rotation of a quaternion w + v of whole numbers: (w² − v·v)·I + 2·v·vᵀ + 2w·\[v\]ₓ, which is exact until the division by w²
/// + v·v.
fn rotation(quaternion: [i32; 4]) -> Matrix3<f64> {
    let [w, v @ ..] = quaternion.map(f64::from);
    let v = Vector3::from(v);
    let along = Matrix3::from_diagonal_element(w * w - v.dot(&v));
    let turned = v * v.transpose() + v.cross_matrix() * w;
    (along + turned * 2.0) / (w * w + v.dot(&v))
}

fn pose(quaternion: [i32; 4], translation: Vector3<f64>) -> Pose {
    Pose::new(rotation(quaternion), translation).unwrap()
}

/// Returns wrenches and Jacobians at rest and in motion, with and without friction, and the shape gradients in motion.
fn contact(pair: &ContactPair) -> Vec<u8> {
    let twists = [
        Twist {
            angular: vector![1.0, -2.0, 0.75],
            linear: vector![0.25, 0.125, -0.5],
        },
        Twist {
            angular: vector![-0.5, 0.25, 1.0],
            linear: vector![0.0, 0.5, 0.25],
        },
    ];
    let covector = SVector::from_fn(|row, _| 1.0 / (row as f64 + 3.0));
    let contact = pair.linearized();
    let mut wrenches = vec![pair.wrench(), contact.wrench];
    let mut all = vec![pair.potential_energy(), pair.surface().area()];
    for row in [0, 6] {
        all.extend(contact.by_poses.fixed_rows::<6>(row).iter());
        all.extend(contact.by_moduli.fixed_rows::<6>(row).iter());
    }
    for [friction, slip_tolerance] in LAWS {
        let law = SurfaceLaw::new(0.5, friction, slip_tolerance).unwrap();
        let linearized = pair.moving(law, twists).linearized();
        wrenches.extend([pair.moving(law, twists).wrench(), linearized.wrench]);
        all.extend(linearized.jacobian().iter());
        for shape in pair.moving(law, twists).shape_gradients(&covector) {
            all.extend(shape.by_vertices.iter().flatten());
            all.extend(shape.by_extents);
        }
    }
    for wrench in wrenches {
        all.extend(wrench.on_a.to_vector().iter());
        all.extend(wrench.on_b.to_vector().iter());
    }
    bytes(all)
}

struct Shapes {
    fine: Shape,
    ball: Shape,
    block: Shape,
    cylinder: Shape,
    rigid_ball: RigidShape,
    rigid_block: RigidShape,
    layer: HalfSpace,
}

impl Shapes {
    fn new() -> Self {
        let [fine, ball] = [3, 2].map(|times| Shape::new(shapes::icosphere(0.1, times).unwrap()));
        let block = Shape::new(shapes::cuboid([0.1, 0.125, 0.0875]).unwrap());
        let cylinder = Shape::new(shapes::cylinder(0.05, 0.15, 17).unwrap());
        let rigid = |shape: &Shape| {
            let surface = TriangleSurface::around(shape.field().mesh());
            RigidShape::new(surface.unwrap())
        };
        Self {
            rigid_ball: rigid(&ball),
            rigid_block: rigid(&block),
            layer: HalfSpace::layer(0.02).unwrap(),
            fine,
            ball,
            block,
            cylinder,
        }
    }

    /// Returns pairs at generic poses, whose polygons are processed in SIMD lanes.
    fn generic(&self) -> [(&'static str, ContactPair<'_>); 9] {
        let turned = pose([1, 2, 2, 4], vector![0.02, 0.05, 0.09]);
        let pose_b = pose([2, -1, 4, 2], vector![-0.03, 0.01, 0.02]);
        let ground = pose([4, -2, 1, 2], vector![0.01, -0.02, 0.03]);
        let on = |partner| pair((&self.ball, turned), partner);
        let fine = hard(&self.fine, pose_b);
        let by_vector = |vector, translation| Pose::from_rotation_vector(&vector, translation);
        let upright = by_vector(vector![0.9, -0.4, 0.2], vector![0.01, 0.02, 0.07]);
        let slightly = by_vector(vector![0.1, 0.2, -0.1], vector![0.0, 0.01, 0.0]);
        [
            ("many polygons", pair((&self.fine, turned), fine)),
            ("ball, ball", on(hard(&self.ball, pose_b))),
            ("ball, block", on(hard(&self.block, pose_b))),
            ("ball, rigid ball", on(rigid(&self.rigid_ball, pose_b))),
            ("ball, half-space", on(half_space(ground))),
            ("ball, layer", on(layer(&self.layer, ground))),
            ("ball, cylinder", on(hard(&self.cylinder, pose_b))),
            (
                "cylinder, cylinder",
                pair((&self.cylinder, upright), hard(&self.cylinder, slightly)),
            ),
            (
                "block, block",
                pair((&self.block, turned), hard(&self.block, pose_b)),
            ),
        ]
    }

    /// Returns pairs with coplanar faces, exactly or to round-off, whose polygons are processed one pair at a time.
    fn flush(&self) -> [(&'static str, ContactPair<'_>); 6] {
        let ground = pose([4, -2, 1, 2], vector![0.01, -0.02, 0.03]);
        let here = Pose::identity();
        let on_top: Pose = Pose::from_translation(vector![0.0125, 0.0, 0.0625]);
        let sunk: Pose = Pose::from_translation(vector![0.0, 0.0, 0.04]);
        let block = |pose, partner| pair((&self.block, pose), partner);
        [
            ("flush blocks", block(on_top, hard(&self.block, here))),
            (
                "flush blocks, turned",
                block(ground * on_top, hard(&self.block, ground)),
            ),
            (
                "flush, rigid",
                block(on_top, rigid(&self.rigid_block, here)),
            ),
            ("flush, half-space", block(sunk, half_space(here))),
            ("flush, layer", block(sunk, layer(&self.layer, here))),
            ("same block", block(ground, hard(&self.block, ground))),
        ]
    }
}

fn pair<'s>((shape, pose): (&'s Shape, Pose), partner: Partner<'s>) -> ContactPair<'s> {
    ContactPair::new(ContactBody::new(shape, pose, 1e5).unwrap(), partner)
}

fn hard(shape: &Shape, pose: Pose) -> Partner<'_> {
    ContactBody::new(shape, pose, 2e5).unwrap().into()
}

fn rigid(shape: &RigidShape, pose: Pose) -> Partner<'_> {
    Partner::rigid(shape, pose).unwrap()
}

fn half_space(pose: Pose) -> Partner<'static> {
    Partner::rigid_half_space(pose).unwrap()
}

fn layer(shape: &HalfSpace, pose: Pose) -> Partner<'_> {
    Partner::half_space(shape, pose, 3e5).unwrap()
}

/// Returns balls and bricks, pressed into each other and into a compliant layer, rotating and with friction.
fn heap() -> World {
    let skin = Material::elastic(1e5)
        .with_dissipation(0.25)
        .with_friction(0.5);
    let ball = Arc::new(Shape::new(shapes::icosphere(0.1, 1).unwrap()));
    let brick = Arc::new(Shape::new(
        shapes::cuboid([0.1875, 0.15625, 0.125]).unwrap(),
    ));
    let falling = |index: u32| {
        let cell = Vector3::from([index % 2, index / 2 % 2, index / 4].map(f64::from));
        let shape = [&ball, &brick][(index % 3 % 2) as usize];
        let body = Body::dynamic(
            &format!("body {index}"),
            Arc::clone(shape),
            skin,
            Mass::Total(1.0),
        );
        let quaternion = [[1, 2, 2, 4], [4, -2, 1, 2], [2, -1, 4, 2]][index as usize % 3];
        body.unwrap()
            .with_pose(pose(quaternion, cell * 0.1875 + vector![0.0, 0.0, 0.09375]))
            .with_angular_velocity(vector![2.0, -1.0, 0.5])
    };
    let ground = Body::fixed("ground", HalfSpace::layer(0.05).unwrap(), skin).unwrap();
    let world = World::new((0..8).map(falling).chain([ground]).collect()).unwrap();
    let world = world.with_gravity(vector![0.0, 0.0, -9.8125]).unwrap();
    world.with_slip_tolerance(SLIP_TOLERANCE).unwrap()
}

fn rollout((integrator, steps): (Integrator, usize)) -> Vec<u8> {
    let plan = Plan::new(TIME_STEP, steps).unwrap();
    rollout_bytes(&heap(), &plan.with_integrator(integrator))
}

fn jacobian() -> Vec<u8> {
    let by = [
        Parameter::initial_velocity("body 7"),
        Parameter::initial_angular_velocity("body 0"),
        Parameter::friction("body 0"),
        Parameter::modulus("body 1"),
        Parameter::Gravity,
    ];
    let world = heap();
    let end = FinalPosition::of_body(&world, "body 4").unwrap();
    jacobian_bytes(
        &world,
        &Plan::new(TIME_STEP, JACOBIAN_STEPS).unwrap(),
        &by,
        &end,
    )
}

/// Formats a hash as in the tables.
fn grouped(hash: u64) -> String {
    let groups = [48, 32, 16, 0].map(|shift| format!("{:04x}", hash >> shift & 0xffff));
    format!("0x{}", groups.join("_"))
}

/// Asserts that all bits equal the recorded bits. The message has one line for each difference, formatted as in the table.
fn assert_written_down<N: PartialEq + std::fmt::Debug>(
    actual: impl IntoIterator<Item = (N, Vec<u8>)>,
    written: &[(N, u64)],
) {
    let actual: Vec<_> = actual
        .into_iter()
        .map(|(name, bits)| (name, hash(&bits)))
        .collect();
    let differences = actual
        .iter()
        .filter(|pair_bits| !written.contains(pair_bits));
    let differences: Vec<_> = differences
        .map(|(name, hash)| format!("({name:?}, {}),", grouped(*hash)))
        .collect();
    assert!(
        differences.is_empty() && actual.len() == written.len(),
        "Bits differ from the recorded bits. If the change is meant to change bits, copy these lines to the table:\n{}",
        differences.join("\n")
    );
}

#[test]
fn contacts_have_the_bits_that_are_written_down() {
    let shapes = Shapes::new();
    let (generic, flush) = (shapes.generic(), shapes.flush());
    // Octets of polygons are summed and their memory is reused.
    assert!(generic[0].1.work_count().polygons > 1000);
    let pairs = generic.iter().chain(&flush);
    assert!(
        pairs
            .clone()
            .all(|(_, pair)| pair.work_count().polygons > 0)
    );
    assert_written_down(pairs.map(|(name, pair)| (*name, contact(pair))), &CONTACTS);
}

#[test]
fn rollouts_have_the_bits_that_are_written_down() {
    assert_written_down(ROLLOUTS.map(|(kind, _)| (kind, rollout(kind))), &ROLLOUTS);
}

#[test]
fn the_derivatives_of_a_rollout_have_the_bits_that_are_written_down() {
    assert_written_down([("jacobian", jacobian())], &JACOBIAN);
}
