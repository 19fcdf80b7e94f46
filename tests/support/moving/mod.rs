//! Moving pairs of bodies at special positions, and the references for their linearized contact.
//!
//! `bodies` creates the shapes, `poses` combines pairs of them, and `motions` sets them in motion. `differences` computes one-sided and
//! central differences of the wrenches with respect to all 28 variables, and `verdict` compares.

pub mod bodies;
pub mod differences;
pub mod motions;
pub mod poses;
pub mod special;
pub mod verdict;

use crate::support::scenes::Random;
use hydroelastic::contact::{ContactBody, ContactPair, ContactWrench, SurfaceLaw};
use hydroelastic::scalar::{DenseDual, Scalar, lift_vector};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{SMatrix, SVector};

/// Columns of a linearized contact: poses of A and B, twists of A and B, moduli of A and B, dissipation, friction.
pub const COLUMNS: usize = 28;

/// Rows: the wrench on A, then the wrench on B. Columns: see [`COLUMNS`].
pub type Jacobian = SMatrix<f64, 12, COLUMNS>;

/// A dual number with a derivative for each column.
pub type Wide = DenseDual<COLUMNS>;

/// Returns changes of zero, each with a derivative of 1 with respect to its own column.
pub fn seeds() -> SVector<Wide, COLUMNS> {
    SVector::from_fn(|column, _| Wide::variable(0.0, column))
}

/// Returns the derivatives of wrenches.
pub fn jacobian_of(wrench: &ContactWrench<Wide>) -> Jacobian {
    let rows = numbers(wrench);
    Jacobian::from_fn(|row, column| rows[row].eps[column])
}

/// A moving pair in real numbers.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    pub pair: ContactPair<'a>,
    pub twists: [Twist; 2],
    pub dissipation: f64,
    pub friction: f64,
    /// (m/s)
    pub slip_tolerance: f64,
    /// Distance from the special position, in angle and relative to the size.
    pub missed: f64,
}

impl<'a> Scene<'a> {
    /// Returns a pair in a generic position, with random dissipation and friction and random twists of up to 0.5 (rad/s, m/s).
    pub fn at_random(pair: &ContactPair<'a>, random: &mut Random) -> Self {
        let mut number = || random.between(-0.5, 0.5);
        let twists = [0, 1].map(|_| Twist::from_vector(&SVector::from_fn(|_, _| number())));
        Self {
            pair: *pair,
            twists,
            dissipation: random.between(0.0, 0.8),
            friction: random.between(0.0, 1.0),
            slip_tolerance: 0.05,
            missed: f64::INFINITY,
        }
    }

    pub fn law(&self) -> SurfaceLaw {
        SurfaceLaw::new(self.dissipation, self.friction, self.slip_tolerance).unwrap()
    }

    /// Returns the 12×28 Jacobian of [`hydroelastic::contact::LinearizedContact::jacobian`].
    pub fn linearized(&self) -> Jacobian {
        self.pair
            .moving(self.law(), self.twists)
            .linearized()
            .jacobian()
    }

    /// Returns the pair, its law and its velocities after changes of the variables.
    pub fn changed<T: Scalar>(
        &self,
        changes: &SVector<T, COLUMNS>,
    ) -> (ContactPair<'a, T>, SurfaceLaw<T>, [Twist<T>; 2]) {
        let twist = |row| Twist::from_vector(&changes.fixed_rows::<6>(row).into_owned());
        let moved = |pose: &Pose, row| Pose::<T>::lifted(pose).moved_by(&twist(row));
        let (a, b) = (self.pair.a(), self.pair.b());
        let modulus_a = changes[24] + a.modulus();
        let modulus_b = changes[25] + b.modulus().unwrap_or(1.0);
        let pair = ContactPair::new(
            ContactBody::new(a.shape(), moved(a.pose(), 0), modulus_a).unwrap(),
            b.at(moved(b.pose(), 6), modulus_b).unwrap(),
        );
        let (dissipation, friction) = (changes[26] + self.dissipation, changes[27] + self.friction);
        let law = SurfaceLaw::new(dissipation, friction, self.slip_tolerance).unwrap();
        let velocity = |of: usize| {
            let change = changes.fixed_rows::<6>(12 + 6 * of).into_owned();
            let Twist { angular, linear } = Twist::from_vector(&change);
            let twist = &self.twists[of];
            Twist {
                angular: angular + lift_vector(&twist.angular),
                linear: linear + lift_vector(&twist.linear),
            }
        };
        (pair, law, [velocity(0), velocity(1)])
    }

    /// Returns the wrenches after changes.
    pub fn wrenches(&self, changes: &SVector<f64, COLUMNS>) -> SVector<f64, 12> {
        let (pair, law, twists) = self.changed(changes);
        numbers(&pair.moving(law, twists).wrench())
    }

    /// Returns the error of a Jacobian along a direction, relative to the largest entry of the derivative, against the best of central
    /// differences with these steps. If one step straddles a change of a polygon's topology or suffers from rounding, another step does
    /// not.
    pub fn error_along(
        &self,
        direction: &SVector<f64, COLUMNS>,
        jacobian: &Jacobian,
        steps: &[f64],
    ) -> f64 {
        let expected = jacobian * direction;
        let error = |step: &f64| {
            let ahead = self.wrenches(&(direction * *step));
            let difference = (ahead - self.wrenches(&(direction * -step))) / (2.0 * step);
            (difference - expected).amax() / expected.amax()
        };
        steps.iter().map(error).fold(f64::INFINITY, f64::min)
    }

    /// Returns the scene with the names of the bodies exchanged.
    pub fn exchanged(&self) -> Self {
        Self {
            pair: ContactPair::new(self.pair.b().body().unwrap(), *self.pair.a()),
            twists: [self.twists[1], self.twists[0]],
            ..*self
        }
    }
}

/// Returns the wrench on A, then the wrench on B.
pub fn numbers<T: Scalar>(wrench: &ContactWrench<T>) -> SVector<T, 12> {
    let (on_a, on_b) = (wrench.on_a.to_vector(), wrench.on_b.to_vector());
    SVector::from_fn(|i, _| if i < 6 { on_a[i] } else { on_b[i - 6] })
}

/// Returns the Jacobian of the exchanged pair in the order of the original pair.
pub fn with_names_exchanged(jacobian: &Jacobian) -> Jacobian {
    let row = |row: usize| (row + 6) % 12;
    let column = |column: usize| match column {
        0..12 => (column + 6) % 12,
        12..24 => 12 + (column - 6) % 12,
        24 => 25,
        25 => 24,
        _ => column,
    };
    Jacobian::from_fn(|i, j| jacobian[(row(i), column(j))])
}
