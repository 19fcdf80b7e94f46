use crate::contact::{ContactBody, ContactPair, ContactWrench, SurfaceLaw};
use crate::dynamics::{Body, BodyState, Material};
use crate::scalar::{DenseDual, Scalar, lift, lift_vector, real_part, real_vector};
use crate::spatial::{Pose, Twist, Wrench, skew};
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};

/// Of two bodies, A's six numbers (angular, linear) before B's.
type PairMatrix = SMatrix<f64, 12, 12>;

/// A number with derivatives by the poses of A and B, or by their twists.
type Slope = DenseDual<12>;

/// The contact of two bodies, linearised, in coordinates in which every dynamic body has unit mass
/// and unit inertia: symmetric, and zero for bodies that forces do not move.
#[derive(Debug, Clone)]
pub(super) struct PairRates {
    /// The places of A and B among the bodies.
    pub bodies: [usize; 2],
    /// Stiffness over mass K (1/s²).
    pub stiffness: PairMatrix,
    /// Damping over mass C (1/s).
    pub damping: PairMatrix,
}

impl PairRates {
    /// Of the bodies in two places; none if they do not touch.
    ///
    /// Stiffness is that of the pressure, which dissipation raises as bodies approach. Friction adds
    /// nothing to it: its slope by the poses (more pressure, more friction) stands on one side of the
    /// diagonal only, where it hardly moves an eigenvalue, while half of it on either side would.
    pub fn of(places: [usize; 2], bodies: &[RealBody; 2], slip_tolerance: f64) -> Option<Self> {
        let [a, b] = bodies.each_ref().map(|body| &body.material);
        let law = a.lifted().law_with(&b.lifted(), slip_tolerance);
        let (wrench, by_poses) = by_poses(bodies, &law);
        if by_poses.amax() == 0.0 {
            return None;
        }
        let rubs = real_part(law.dissipation) > 0.0 || real_part(law.friction) > 0.0;
        let by_twists = if rubs {
            by_twists(bodies, &law)
        } else {
            PairMatrix::zeros()
        };
        Some(Self {
            bodies: places,
            stiffness: over_mass(bodies, &about_centers(bodies, &wrench, by_poses)),
            damping: over_mass(bodies, &by_twists),
        })
    }
}

/// A body in a state, without derivatives.
pub(super) struct RealBody<'a> {
    contact: ContactBody<'a>,
    material: Material,
    /// At the origin of the body frame, in world axes.
    twist: Twist,
    /// From the origin of the body frame to the centre of mass, in world axes (m).
    to_center: Vector3<f64>,
    /// Six twists of the origin as columns, in world axes: motions with the kinetic energy ½, about
    /// and along axes through the centre of mass. Zero for a body that forces do not move.
    unit_motions: Matrix6<f64>,
}

impl<'a> RealBody<'a> {
    pub fn of<T: Scalar>(body: &'a Body<T>, state: &BodyState<T>) -> Self {
        let (pose, twist) = (state.pose.real(), body.twist_at_origin(state));
        let material = Material {
            modulus: real_part(body.material.modulus),
            dissipation: real_part(body.material.dissipation),
            friction: real_part(body.material.friction),
        };
        let center_of_mass = body.inertia().map(|inertia| inertia.center_of_mass);
        let to_center = pose.rotation() * center_of_mass.unwrap_or_default();
        Self {
            contact: ContactBody::from_valid(&body.shape, pose, material.modulus),
            material,
            twist: Twist {
                angular: real_vector(&twist.angular),
                linear: real_vector(&twist.linear),
            },
            unit_motions: unit_motions(body, &pose, &to_center),
            to_center,
        }
    }

    /// The body as a constant.
    fn constant(&self) -> ContactBody<'a, Slope> {
        self.contact.perturbed(&Twist::zero(), lift(0.0))
    }

    /// The body, to be differentiated by its pose: by six numbers from the `first` on.
    fn by_pose(&self, first: usize) -> ContactBody<'a, Slope> {
        self.contact
            .perturbed(&seeded(&Twist::zero(), first), lift(0.0))
    }
}

fn unit_motions<T: Scalar>(body: &Body<T>, pose: &Pose, to_center: &Vector3<f64>) -> Matrix6<f64> {
    let mut motions = Matrix6::zeros();
    let Some(inertia) = body.inertia() else {
        return motions;
    };
    let mass = real_part(inertia.mass);
    let rates = inertia.unit_moments.map(|m| (mass * m).sqrt().recip());
    let turns = pose.rotation() * inertia.principal_axes * Matrix3::from_diagonal(&rates);
    let shifts = Matrix3::from_diagonal_element(mass.sqrt().recip());
    // The origin is −r away from the centre of mass, and ω × −r = [r]ₓω.
    let blocks = [
        ([0, 0], turns),
        ([3, 0], skew(to_center) * turns),
        ([3, 3], shifts),
    ];
    for ([row, column], block) in blocks {
        let mut view = motions.fixed_view_mut::<3, 3>(row, column);
        view.copy_from(&block);
    }
    motions
}

/// Both wrenches, and their derivatives by both poses, friction left out.
fn by_poses(bodies: &[RealBody; 2], law: &SurfaceLaw<Slope>) -> (ContactWrench, PairMatrix) {
    let [a, b] = bodies;
    if real_part(law.dissipation) > 0.0 {
        let frictionless = SurfaceLaw {
            friction: lift(0.0),
            ..*law
        };
        let pair = ContactPair::new(a.by_pose(0), b.by_pose(6));
        let twists = [a, b].map(|body| Twist {
            angular: lift_vector(&body.twist.angular),
            linear: lift_vector(&body.twist.linear),
        });
        let wrench = pair.wrench_in_motion_carried(&frictionless, twists);
        return (real_wrench(&wrench), slopes(&wrench));
    }
    let (wrench, jacobian) = ContactPair::new(a.contact, b.contact).wrench_and_jacobian();
    let mut by_poses = PairMatrix::zeros();
    for (row, of_wrench) in [(0, jacobian.on_a), (6, jacobian.on_b)] {
        let mut rows = by_poses.fixed_rows_mut::<6>(row);
        rows.copy_from(&of_wrench.matrix().fixed_columns::<12>(0));
    }
    (wrench, by_poses)
}

/// The derivatives of both wrenches by both twists.
fn by_twists([a, b]: &[RealBody; 2], law: &SurfaceLaw<Slope>) -> PairMatrix {
    let pair = ContactPair::new(a.constant(), b.constant());
    let twists = [seeded(&a.twist, 0), seeded(&b.twist, 6)];
    slopes(&pair.wrench_in_motion_carried(law, twists))
}

/// Derivatives by poses, for wrenches about the centres of mass: as a body turns by θ, its centre
/// moves by θ × r against its origin, which takes (θ × r) × F from the torque of a force F.
fn about_centers(
    bodies: &[RealBody; 2],
    wrench: &ContactWrench,
    mut by_poses: PairMatrix,
) -> PairMatrix {
    for (body, (place, wrench)) in bodies.iter().zip([(0, wrench.on_a), (6, wrench.on_b)]) {
        let mut by_turn = by_poses.fixed_view_mut::<3, 3>(place, place);
        by_turn -= skew(&wrench.force) * skew(&body.to_center);
    }
    by_poses
}

/// The symmetric part of what resists the unit motions.
fn over_mass(bodies: &[RealBody; 2], slopes: &PairMatrix) -> PairMatrix {
    let mut motions = PairMatrix::zeros();
    for (body, place) in bodies.iter().zip([0, 6]) {
        let mut own = motions.fixed_view_mut::<6, 6>(place, place);
        own.copy_from(&body.unit_motions);
    }
    let resisting = -motions.transpose() * slopes * motions;
    (resisting + resisting.transpose()) / 2.0
}

/// A twist with derivatives by itself: by six numbers from the `first` on.
fn seeded(twist: &Twist, first: usize) -> Twist<Slope> {
    let vector = |vector: &Vector3<f64>, first: usize| {
        Vector3::from_fn(|i, _| Slope::variable(vector[i], first + i))
    };
    Twist {
        angular: vector(&twist.angular, first),
        linear: vector(&twist.linear, first + 3),
    }
}

fn slopes(wrench: &ContactWrench<Slope>) -> PairMatrix {
    let rows = [wrench.on_a, wrench.on_b].map(|wrench: Wrench<Slope>| wrench.to_vector());
    PairMatrix::from_fn(|row, column| rows[row / 6][row % 6].eps[column])
}

fn real_wrench(wrench: &ContactWrench<Slope>) -> ContactWrench {
    ContactWrench {
        on_a: wrench.on_a.real(),
        on_b: wrench.on_b.real(),
    }
}
