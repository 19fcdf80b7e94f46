//! Relative motions of bodies in contact, and their contact laws.

use super::Scene;
use crate::support::scenes::Random;
use hydroelastic::contact::ContactPair;
use hydroelastic::spatial::Twist;
use nalgebra::Vector3;

/// Position and normal of a contact.
struct Place {
    point: Vector3<f64>,
    normal: Vector3<f64>,
    tangent: Vector3<f64>,
}

/// Returns the pair with twists and a law, if the bodies touch. Lengths are relative to a size (m).
pub fn set_in_motion<'a>(
    pair: &ContactPair<'a>,
    size: f64,
    random: &mut Random,
) -> Option<Scene<'a>> {
    let contact_point = Place::of(pair, random)?;
    let friction = [0.0, 1.0, random.between(0.0, 1.0), random.between(0.0, 1.0)];
    let damped = random.between(0.0, 2.0);
    let mut scene = Scene {
        pair: *pair,
        twists: [Twist::zero(), Twist::zero()],
        dissipation: [0.0, damped, damped, damped][random.below(4)],
        friction: friction[random.below(4)],
        missed: 0.0,
        slip_tolerance: 10_f64.powf(random.between(-5.0, -1.0)),
    };
    if random.below(2) == 0 {
        let [angular, linear] = [0, 1].map(|_| random.vector());
        let speed = 10_f64.powf(random.between(-2.0, 0.0));
        let angular = [Vector3::zeros(), angular * (speed / size)][random.below(2)];
        scene.twists[1] = Twist {
            angular,
            linear: linear * speed,
        };
    }
    let [spin, velocity] = contact_point.relative_motion(scene.dissipation, size, random);
    let [arm_a, arm_b] =
        [pair.a().pose(), pair.b().pose()].map(|pose| contact_point.point - pose.translation());
    let Twist { angular, linear } = scene.twists[1];
    let at_point = linear + angular.cross(&arm_b) + velocity;
    let angular = angular + spin;
    scene.twists[0] = Twist {
        angular,
        linear: at_point - angular.cross(&arm_a),
    };
    Some(scene)
}

impl Place {
    fn of(pair: &ContactPair, random: &mut Random) -> Option<Self> {
        let polygons = pair.surface().polygons;
        let force: Vector3<f64> = polygons
            .iter()
            .map(|p| p.normal * (p.area * p.pressure))
            .sum();
        let load: f64 = polygons.iter().map(|p| p.area * p.pressure).sum();
        let moment: Vector3<f64> = polygons
            .iter()
            .map(|p| p.centroid * (p.area * p.pressure))
            .sum();
        if load <= 0.0 {
            return None;
        }
        let normal = if force.norm() > 1e-6 * load {
            force.normalize()
        } else {
            Vector3::z()
        };
        let along = match random.below(2) {
            0 => *pair.a().pose().rotation() * Vector3::ith(random.below(3), 1.0),
            _ => random.direction(),
        };
        let tangent = along - normal * normal.dot(&along);
        let tangent = if tangent.norm() > 0.1 {
            tangent.normalize()
        } else {
            normal.cross(&random.direction()).normalize()
        };
        Some(Self {
            point: moment / load,
            normal,
            tangent,
        })
    }

    /// Returns spin and velocity of A relative to B at the contact.
    fn relative_motion(
        &self,
        dissipation: f64,
        size: f64,
        random: &mut Random,
    ) -> [Vector3<f64>; 2] {
        let speed = 10_f64.powf(random.between(-2.0, 0.0));
        let (rest, across) = (Vector3::zeros(), self.normal.cross(&self.tangent));
        let spinning = self.normal * (speed / size);
        match random.below(8) {
            0 => [rest, rest],
            1 | 2 => [rest, self.tangent * speed],
            3 => [spinning, rest],
            4 => [spinning, self.tangent * (speed * random.between(0.0, 1.0))],
            5 => [across * (speed / size), rest],
            6 if dissipation > 0.1 => {
                // At this velocity, 1 − d·v_n is zero in the middle or everywhere.
                let parting = self.normal * (random.between(0.5, 1.5) / dissipation);
                let rolling = across * (random.between(0.0, 2.0) / (dissipation * size));
                let exactly = self.normal / dissipation;
                match random.below(8) {
                    0 => [rest, exactly],
                    1 => [rest, parting],
                    _ => [rolling, parting + self.tangent * speed],
                }
            }
            _ => [random.vector() * (speed / size), random.vector() * speed],
        }
    }
}
