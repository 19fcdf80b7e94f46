//! Rigid bodies and half-spaces as partners of a compliant body.

mod closed_forms;
mod flush_faces;
mod hostile;
mod in_motion;
mod invariants;
mod reference_data;
mod refusals;
mod rigid_limit;
mod search;
mod special;
mod surfaces;

use crate::support::scenes::{Random, mixed_shapes};
use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape};
use hydroelastic::mesh::TriangleSurface;
use hydroelastic::spatial::Pose;

/// Compliant shapes, their surfaces as rigid shapes, and half-spaces with and without a compliant layer.
pub struct Shapes {
    pub compliant: Vec<Shape>,
    pub rigid: Vec<RigidShape>,
    half_spaces: [HalfSpace; 2],
}

impl Shapes {
    pub fn mixed() -> Self {
        let compliant = mixed_shapes();
        Self {
            rigid: compliant.iter().map(rigid).collect(),
            compliant,
            half_spaces: [HalfSpace::rigid(), HalfSpace::layer(0.7).unwrap()],
        }
    }

    /// Visits touching pairs at random poses, with equal numbers of each kind of partner.
    pub fn for_pairs(
        &self,
        count: usize,
        seed: u8,
        mut check: impl FnMut(&ContactPair, &mut Random),
    ) {
        let mut random = Random::new(seed);
        let mut checked = 0;
        while checked < count {
            let pair = self.pair(checked % 3, &mut random);
            if !pair.surface().is_empty() {
                check(&pair, &mut random);
                checked += 1;
            }
        }
    }

    fn pair(&self, kind: usize, random: &mut Random) -> ContactPair<'_> {
        let mut pose = |reach: f64| {
            Pose::from_rotation_vector(&random.rotation_vector(), random.direction() * reach)
        };
        let (pose_a, pose_b) = (pose(1.0), pose(1.3));
        let a = &self.compliant[random.below(self.compliant.len())];
        let modulus = |random: &mut Random| 10_f64.powf(random.between(4.0, 6.0));
        let a = ContactBody::new(a, pose_a, modulus(random)).unwrap();
        let b = match kind {
            0 => Partner::rigid(&self.rigid[random.below(self.rigid.len())], pose_b),
            kind => Partner::half_space(&self.half_spaces[kind - 1], pose_b, modulus(random)),
        };
        ContactPair::new(a, b.unwrap())
    }
}

/// Returns the surface of a shape as a rigid shape.
fn rigid(shape: &Shape) -> RigidShape {
    RigidShape::new(TriangleSurface::around(shape.field().mesh()).unwrap())
}
