use crate::contact::{ContactPair, LinearizedContact, Partner, SurfaceLaw};
use crate::dynamics::{Body, BodyState, Material};
use crate::scalar::{Scalar, real_part};
use crate::spatial::{Pose, Twist, skew};
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};

/// Matrix over the motions of two bodies: six numbers (angular, linear) of A, then six of B.
type PairMatrix = SMatrix<f64, 12, 12>;

/// Linearized contact of two bodies, in coordinates in which every dynamic body has unit mass and unit inertia. The matrices are symmetric,
/// and zero for bodies that are not dynamic.
#[derive(Debug, Clone)]
pub(super) struct PairRates {
    /// Indices of bodies A and B.
    pub bodies: [usize; 2],
    /// Stiffness divided by mass, K (1/s²).
    pub stiffness: PairMatrix,
    /// Damping divided by mass, C (1/s).
    pub damping: PairMatrix,
}

impl PairRates {
    /// Rates of the contact of two bodies, with or without the damping of friction, or `None` if
    /// they do not touch. `indices` are the indices of the bodies.
    ///
    /// The stiffness is the stiffness of the pressure. Dissipation raises the pressure as bodies
    /// approach, and thus the stiffness. Friction adds no stiffness. The derivative of friction
    /// with respect to the poses is not zero, because friction grows with pressure. It is only on
    /// one side of the diagonal, where it hardly changes an eigenvalue. Its symmetric part would
    /// change eigenvalues.
    pub fn of(
        indices: [usize; 2],
        bodies: &[RealBody; 2],
        slip_tolerance: f64,
        with_friction: bool,
    ) -> Option<Self> {
        let [a, b] = bodies;
        let pair = ContactPair::new(a.contact.body()?, b.contact);
        let twists = [a.twist, b.twist];
        let law = a.material.combined_with(&b.material, slip_tolerance);
        let frictionless = SurfaceLaw {
            friction: 0.0,
            ..law
        };
        let pressed = pair.moving(frictionless, twists).linearized();
        let by_poses = about_centers(bodies, &pressed);
        let contact = if with_friction && law.friction > 0.0 {
            pair.moving(law, twists).linearized()
        } else {
            pressed
        };
        (by_poses.amax() > 0.0).then(|| Self {
            bodies: indices,
            stiffness: over_mass(bodies, &by_poses),
            damping: over_mass(bodies, &contact.by_twists),
        })
    }
}

/// Body in a state, without derivatives.
pub(super) struct RealBody<'a> {
    contact: Partner<'a>,
    material: Material,
    /// Twist at the origin of the body frame, in world axes.
    twist: Twist,
    /// Vector from the origin of the body frame to the center of mass, in world axes (m).
    to_center: Vector3<f64>,
    /// Six twists of the origin as columns, in world axes. The columns are motions with the kinetic energy ½ about and along axes through
    /// the center of mass. They are zero for a body that is not dynamic.
    unit_motions: Matrix6<f64>,
}

impl<'a> RealBody<'a> {
    /// The body, or `None` if it has no shape.
    pub fn of<T: Scalar>(body: &'a Body<T>, state: &BodyState<T>) -> Option<Self> {
        let (pose, twist) = (state.pose.real(), body.twist_at_origin(state));
        let material = body.material.real();
        let center_of_mass = body.inertia().map(|inertia| inertia.center_of_mass);
        let to_center = pose.rotation() * center_of_mass.unwrap_or_default();
        let modulus = material.modulus.unwrap_or(1.0);
        Some(Self {
            contact: Partner::from_valid(body.shape.partner()?, pose, modulus),
            material,
            twist: twist.real(),
            unit_motions: unit_motions(body, &pose, &to_center),
            to_center,
        })
    }
}

fn unit_motions<T: Scalar>(body: &Body<T>, pose: &Pose, to_center: &Vector3<f64>) -> Matrix6<f64> {
    let mut motions = Matrix6::zeros();
    let Some(inertia) = body.inertia() else {
        return motions;
    };
    let mass = real_part(inertia.mass);
    let principal = &inertia.principal;
    let rates = principal.moments.map(|m| (mass * m).sqrt().recip());
    let turns = principal.frame(pose.rotation()) * Matrix3::from_diagonal(&rates);
    let shifts = Matrix3::from_diagonal_element(mass.sqrt().recip());
    // The origin is at −r from the center of mass, and ω × −r = [r]ₓω.
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

/// Derivatives with respect to poses of the wrenches about the centers of mass. If a body turns by θ, its center moves by θ × r relative to
/// its origin, which subtracts (θ × r) × F from the torque of a force F.
fn about_centers(bodies: &[RealBody; 2], contact: &LinearizedContact) -> PairMatrix {
    let mut by_poses = contact.by_poses;
    let wrenches = [contact.wrench.on_a, contact.wrench.on_b];
    for (body, (first, wrench)) in bodies.iter().zip([0, 6].into_iter().zip(wrenches)) {
        let mut by_turn = by_poses.fixed_view_mut::<3, 3>(first, first);
        by_turn -= skew(&wrench.force) * skew(&body.to_center);
    }
    by_poses
}

/// Symmetric part of the resistance to the unit motions.
fn over_mass(bodies: &[RealBody; 2], slopes: &PairMatrix) -> PairMatrix {
    let mut motions = PairMatrix::zeros();
    for (body, first) in bodies.iter().zip([0, 6]) {
        let mut diagonal_block = motions.fixed_view_mut::<6, 6>(first, first);
        diagonal_block.copy_from(&body.unit_motions);
    }
    let resisting = -motions.transpose() * slopes * motions;
    (resisting + resisting.transpose()) / 2.0
}
