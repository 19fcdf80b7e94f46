use super::integrate::{Integrand, Remainder};
use super::jacobian::RelativeJacobian;
use super::motion::RelativeMotion;
use super::plane_polygon::PlanePolygon;
use super::polygon_source::PolygonSource;
use super::traction_derivatives::{AddedByLaw, FrozenPolygon};
use super::{ContactPair, ContactWrench, LinearizedContact, SurfaceLaw};
use crate::geometry::set_bits;
use crate::narrow_phase::{Cut, Weights};
use crate::search::GenericPairs;
use crate::spatial::Twist;
use nalgebra::{SMatrix, Vector6};

/// A contact of moving bodies at one pose, with a model of the contact nearby. An implicit time step iterates on the model between two
/// evaluations of the contact.
///
/// The wrench and the elastic derivatives are exact. The model integrates dissipation and friction over the unchanged contact polygons,
/// with the pressure that the fields of the bodies have there. The model is cheap to evaluate again after a change of velocities. It is
/// exact as the direction of friction changes. These changes are the reason why friction is hard to solve.
#[derive(Clone)]
pub(crate) struct FrozenContact {
    /// The exact wrenches, in the world, about the origins of the bodies.
    pub wrench: ContactWrench,
    /// Derivatives of the elastic wrenches with respect to the poses of A and B: see [`LinearizedContact::by_poses`].
    pub by_poses: SMatrix<f64, 12, 12>,
    /// The contribution of the law at this pose.
    pub added: AddedByLaw,
    /// `None` if the bodies are elastic.
    law: Option<SurfaceLaw>,
    polygons: Vec<FrozenPolygon>,
}

/// The integrand of a frozen contact: the exact elastic contact, and the polygons if there is dissipation or friction.
struct Freeze {
    is_dissipative: bool,
}

impl Integrand<f64> for Freeze {
    type Sum = (RelativeJacobian, Vec<FrozenPolygon>);

    const OCTETS: usize = 32;

    fn add(&self, source: &PolygonSource<f64>, cut: &Cut, (elastic, polygons): &mut Self::Sum) {
        if let Some(polygon) = source.counted_polygon(cut, Weights::has_still_area) {
            elastic.add(&polygon);
            polygons.extend(self.is_dissipative.then(|| FrozenPolygon::of(polygon)));
        }
    }

    fn add_octets(
        &self,
        _: &PolygonSource<f64>,
        generic: GenericPairs,
        _: &mut Remainder,
        (elastic, polygons): &mut Self::Sum,
    ) {
        elastic.add_octets(generic.octets);
        if self.is_dissipative {
            for octet in generic.octets {
                let polygon = |index| FrozenPolygon::of(PlanePolygon::at(octet, index));
                polygons.extend(set_bits(octet.polygons()).map(polygon));
            }
        }
    }
}

impl ContactPair<'_> {
    /// Evaluates the contact and a model of it nearby, in little more time than the wrench. Returns `None` if the bodies do not touch.
    pub(crate) fn frozen(&self) -> Option<FrozenContact> {
        let moving = self.relative_motion().filter(|(law, _)| !law.is_elastic());
        let surface = self.source().for_values(self.search());
        if surface.search_result.is_empty() {
            return None;
        }
        let is_dissipative = moving.is_some();
        let (elastic, polygons) = surface.integral(&Freeze { is_dissipative });
        let mut elastic = elastic.linearization(self.moduli());
        let added = match &moving {
            Some((law, motion)) => {
                FrozenPolygon::added(&polygons, law, (&Vector6::zeros(), motion))
            }
            None => AddedByLaw::nothing(),
        };
        elastic.wrench += added.wrench;
        let LinearizedContact {
            wrench, by_poses, ..
        } = elastic.in_world(&self.at_rest());
        Some(FrozenContact {
            wrench,
            by_poses,
            added,
            law: moving.map(|(law, _)| law),
            polygons,
        })
    }
}

impl FrozenContact {
    /// Returns whether there is dissipation or friction.
    pub fn is_dissipative(&self) -> bool {
        self.law.is_some()
    }

    /// Returns the contribution of dissipation and friction after a motion of B. `twist` is the
    /// velocity of A relative to B. The motion and the velocity have an angular part and a linear
    /// part at A's origin, in A's axes.
    pub fn added(&self, motion: &Vector6<f64>, twist: &Vector6<f64>) -> AddedByLaw {
        let Some(law) = &self.law else {
            return AddedByLaw::nothing();
        };
        let Twist { angular, linear } = Twist::from_vector(twist);
        let velocity = RelativeMotion {
            angular,
            at_origin: linear,
        };
        FrozenPolygon::added(&self.polygons, law, (motion, &velocity))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactBody, Shape};
    use crate::mesh::{PressureField, TetMesh, shapes};
    use crate::scalar::{DenseDual, lift, real_part};
    use crate::spatial::Pose;
    use nalgebra::{Vector3, vector};

    /// Round-off of sums over polygons, relative to the largest entry.
    const EXACT: f64 = 1e-12;

    /// Error of central differences with the step `STEP` (rad, m, rad/s or m/s), relative to the largest entry. At the boundary the step
    /// cuts off a part on one side only.
    const DIFFERENCES: f64 = 1e-6;
    const STEP: f64 = 1e-7;

    /// A rotation and a translation, or their speeds, in no special direction.
    const SOME: [f64; 6] = [0.3, -0.5, 0.4, 0.7, 0.2, -0.6];

    fn law() -> SurfaceLaw {
        SurfaceLaw::new(0.3, 0.4, 0.1).unwrap()
    }

    /// Creates eight tetrahedra about the origin, with corners at ±r along x and y and at ±h along z. The extent falls from the middle to 0
    /// on the surface.
    fn octahedron([r, h]: [f64; 2], extent: f64) -> Shape {
        let along =
            |axis: usize, length: f64| [1.0, -1.0].map(|side| Vector3::ith(axis, side * length));
        let tips = [along(0, r), along(1, r), along(2, h)].concat();
        let vertices = [vec![Vector3::zeros()], tips].concat();
        let octants = (0..8).map(|octant| [0, 1 + octant % 2, 3 + octant / 2 % 2, 5 + octant / 4]);
        let extents = [vec![extent], vec![0.0; 6]].concat();
        let mesh = TetMesh::new(vertices, octants.collect()).unwrap();
        Shape::new(PressureField::new(mesh, extents).unwrap())
    }

    /// Calls `check` with a pair at a generic pose, and with a pair whose contact surface is the square |x| + |y| ≤ 1 inside both bodies,
    /// in faces that tetrahedra of A share. On this square, E_A (1 − |x| − |y| − |z|) is E_B (2 − |x| − |y| − 2|z + ½|).
    fn for_pairs(mut check: impl FnMut(&ContactPair)) {
        let body = |shape, pose| ContactBody::new(shape, pose, 2.0).unwrap();
        let (ball, cube) = (shapes::icosphere(1.0, 1), shapes::cuboid([1.0, 1.4, 0.8]));
        let [ball, cube] = [ball, cube].map(|field| Shape::new(field.unwrap()));
        let pose = Pose::from_rotation_vector(&vector![0.3, -0.5, 0.4], vector![0.5, 0.3, 0.8]);
        let generic = ContactPair::new(body(&ball, Pose::identity()), body(&cube, pose));
        let [small, large] = [octahedron([1.0; 2], 1.0), octahedron([2.0, 1.0], 2.0)];
        let below = Pose::from_translation(vector![0.0, 0.0, -0.5]);
        let in_faces = ContactPair::new(body(&small, Pose::identity()), body(&large, below));
        let source = in_faces.source();
        let weights = in_faces
            .cut_surface()
            .sum_of_cuts(|weights: &mut Vec<f64>, cut: &Cut| {
                let polygon = source.pressed_polygon(cut);
                weights.extend(polygon.map(|polygon| polygon.weights.still.area()));
            });
        assert_eq!(weights, [0.5; 8]);
        [generic, in_faces].iter().for_each(&mut check);
    }

    #[test]
    fn the_model_of_a_contact_as_it_is_has_the_wrench_of_the_contact() {
        let twists = [1.0, -0.3].map(|part| Twist::from_vector(&(Vector6::from(SOME) * part)));
        for_pairs(|pair| {
            let actual = pair.moving(law(), twists).frozen().unwrap().wrench;
            let exact = pair.moving(law(), twists).wrench();
            for (actual, exact) in [(actual.on_a, exact.on_a), (actual.on_b, exact.on_b)] {
                let [actual, exact] = [actual, exact].map(|wrench| wrench.to_vector());
                let error = (actual - exact).amax();
                assert!(error <= EXACT * exact.amax(), "{error:e}");
            }
        });
    }

    /// Computes the contribution of the law over frozen polygons and its derivatives, with dual numbers through the wrench of each polygon.
    fn by_dual_numbers(
        frozen: &FrozenContact,
        law: &SurfaceLaw,
        [motion, twist]: [&Vector6<f64>; 2],
    ) -> AddedByLaw {
        type Dual = DenseDual<12>;
        let seeded = |value: &Vector6<f64>, first: usize| {
            let mut seeded = [lift::<Dual>(0.0); 6];
            for (k, number) in seeded.iter_mut().enumerate() {
                *number = Dual::variable(value[k], first + k);
            }
            seeded
        };
        let motion = seeded(motion, 0);
        let [w1, w2, w3, v1, v2, v3] = seeded(twist, 6);
        let velocity = RelativeMotion {
            angular: Vector3::new(w1, w2, w3),
            at_origin: Vector3::new(v1, v2, v3),
        };
        let lifted = |dissipation: f64, friction: f64| {
            SurfaceLaw::new(
                lift::<Dual>(dissipation),
                lift(friction),
                law.slip_tolerance,
            )
            .unwrap()
        };
        let elastic_law = lifted(0.0, 0.0);
        let law = lifted(law.dissipation, law.friction);
        let mut sum = AddedByLaw::nothing();
        for polygon in &frozen.polygons {
            let polygon = polygon.after(&motion);
            let [all, elastic] = [&law, &elastic_law]
                .map(|law| polygon.wrench_in_motion(law, &velocity).to_vector());
            let added = all - elastic;
            for row in 0..6 {
                sum.wrench[row] += real_part(added[row]);
                for column in 0..6 {
                    sum.by_motion[(row, column)] += added[row].eps[column];
                    sum.by_twist[(row, column)] += added[row].eps[6 + column];
                }
            }
        }
        sum
    }

    #[test]
    fn frozen_polygons_add_what_dual_numbers_give() {
        let some = Vector6::from(SOME);
        let law = law();
        for_pairs(|pair| {
            let frozen = pair.moving(law, [Twist::zero(); 2]).frozen().unwrap();
            for (part, spin) in [(0.0, 0.0), (0.03, 1e-3), (-0.2, 1.0), (0.2, 30.0)] {
                let (motion, mut twist) = (some * part, some);
                twist.fixed_rows_mut::<3>(0).scale_mut(spin);
                let actual = frozen.added(&motion, &twist);
                let expected = by_dual_numbers(&frozen, &law, [&motion, &twist]);
                let errors = [
                    (actual.wrench - expected.wrench).amax() / expected.wrench.amax(),
                    (actual.by_motion - expected.by_motion).amax() / expected.by_motion.amax(),
                    (actual.by_twist - expected.by_twist).amax() / expected.by_twist.amax(),
                ];
                assert!(errors.iter().all(|&error| error <= EXACT), "{errors:?}");
            }
        });
    }

    #[test]
    fn the_model_of_a_contact_has_the_derivatives_of_differences() {
        let some = Vector6::from(SOME);
        for_pairs(|pair| {
            let frozen = pair.moving(law(), [Twist::zero(); 2]).frozen().unwrap();
            for (motion, twist) in [(some * 0.0, some), (some * 0.03, some * -0.5)] {
                let AddedByLaw {
                    by_motion,
                    by_twist,
                    ..
                } = frozen.added(&motion, &twist);
                let wrench = |d: &Vector6<f64>, v: &Vector6<f64>| {
                    frozen.added(&(motion + d), &(twist + v)).wrench
                };
                let zero = Vector6::zeros();
                for column in 0..6 {
                    let step = Vector6::ith(column, STEP);
                    let by =
                        |ahead: Vector6<f64>, behind: Vector6<f64>| (ahead - behind) / (2.0 * STEP);
                    let pairs = [
                        (by_motion, by(wrench(&step, &zero), wrench(&-step, &zero))),
                        (by_twist, by(wrench(&zero, &step), wrench(&zero, &-step))),
                    ];
                    for (derivative, difference) in pairs {
                        let error = (derivative.column(column) - difference).amax();
                        assert!(
                            error <= DIFFERENCES * derivative.amax(),
                            "{column}: {error:e}"
                        );
                    }
                }
            }
        });
    }
}
