//! Hostile pairs with a rigid body or a half-space in place of B.

use super::shapes::graded;
use super::{Family, Hostile, nudged, triangle_frame};
use crate::support::scenes::Random;
use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape};
use hydroelastic::mesh::TriangleSurface;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

/// The kind of B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Rigid,
    RigidHalfSpace,
    SoftHalfSpace,
}

impl Kind {
    pub const ALL: [Self; 3] = [Self::Rigid, Self::RigidHalfSpace, Self::SoftHalfSpace];
}

/// Rigid bodies and half-spaces that replace compliant bodies.
pub struct StandIns<'a> {
    /// For each shape, its surface and the surface divided into triangles of very different size, or `None` if it is too thin.
    rigid: Vec<(&'a Shape, [Option<RigidShape>; 2])>,
    layers: Vec<HalfSpace>,
}

/// Thicknesses of soft layers (m).
const THICKNESSES: [f64; 5] = [1e-6, 1e-2, 0.3, 1.0, 1e3];

impl<'a> StandIns<'a> {
    pub fn of(shapes: impl Iterator<Item = &'a Shape>, random: &mut Random) -> Self {
        let rigid = shapes.map(|shape| {
            let surface = TriangleSurface::around(shape.field().mesh()).ok();
            let divided = surface.as_ref().and_then(|surface| graded(surface, random));
            (shape, [surface, divided].map(|s| s.map(RigidShape::new)))
        });
        Self {
            rigid: rigid.collect(),
            layers: THICKNESSES.map(|t| HalfSpace::layer(t).unwrap()).into(),
        }
    }

    /// Returns the pair with B replaced by its surface, or by a half-space below one of its triangles with its origin at a random point of
    /// the plane.
    pub fn replaced<'s>(
        &'s self,
        pair: &ContactPair<'s>,
        kind: Kind,
        random: &mut Random,
    ) -> ContactPair<'s> {
        let b = pair.b().body().unwrap();
        let is_same = |(shape, _): &&(&Shape, _)| std::ptr::eq(*shape, b.shape());
        let (_, surfaces) = self.rigid.iter().find(is_same).unwrap();
        let surface = surfaces[random.below(2)].as_ref().or(surfaces[0].as_ref());
        let partner = match (kind, surface) {
            (Kind::Rigid, Some(surface)) => Partner::rigid(surface, *b.pose()),
            (Kind::SoftHalfSpace, _) => {
                let layer = &self.layers[random.below(self.layers.len())];
                // One in four has the pressure gradient of A.
                let steepness_a = pair.a().modulus() * pair.a().shape().field().steepest();
                let alike = steepness_a * layer.thickness().unwrap();
                let modulus = [b.modulus(), b.modulus(), b.modulus(), alike][random.below(4)];
                Partner::half_space(layer, plane_of(&b, random), modulus)
            }
            _ => Partner::rigid_half_space(plane_of(&b, random)),
        };
        ContactPair::new(*pair.a(), partner.unwrap())
    }
}

/// Returns a pose of a half-space with a triangle of the body on its plane.
fn plane_of(body: &ContactBody, random: &mut Random) -> Pose {
    let frame = *body.pose() * triangle_frame(body.shape(), random);
    let away = [0.0, 10_f64.powf(random.between(-1.0, 1.5))][random.below(2)];
    let aside = vector![random.between(-1.0, 1.0), random.between(-1.0, 1.0), 0.0];
    let aside = aside * (away * body.shape().field().reach());
    let turn = Vector3::z() * random.between(0.0, 3.0);
    frame * Pose::from_rotation_vector(&turn, aside)
}

impl Hostile {
    /// Returns the pair with a number, with a rigid body or half-space as partner. In the families `Moduli` and `Combined`, moduli are 1e-3
    /// to 1e15 Pa.
    pub fn pair_with<'a>(
        &'a self,
        partners: &'a StandIns<'a>,
        family: Family,
        number: u64,
    ) -> ContactPair<'a> {
        let random = &mut Random::numbered(number ^ 0x5eed << 40);
        let kind = Kind::ALL[random.below(3)];
        let pair = partners.replaced(&self.pair(family, number), kind, random);
        let (a, b) = (pair.a(), pair.b());
        let wild = matches!(family, Family::Moduli | Family::Combined);
        let factor = if wild {
            10_f64.powf(random.between(-3.0, 3.0))
        } else {
            1.0
        };
        let a = ContactBody::new(a.shape(), *a.pose(), a.modulus() * factor).unwrap();
        // Planes of the triangles of a rotated body have offsets of round-off; some poses need larger offsets.
        let pose = if family == Family::NearlyCoplanar && kind != Kind::Rigid {
            nudged(*b.pose(), a.shape().field().reach(), random)
        } else {
            *b.pose()
        };
        let b = b.at(pose, b.modulus().unwrap_or(1.0)).unwrap();
        ContactPair::new(a, b)
    }
}
