//! Pairs of bodies in motion at special positions, and what their linearized contact is held against.
//!
//! `bodies` makes the shapes, `poses` puts pairs of them together, `motions` moves them; `differences` takes one-sided and
//! central differences of the wrenches by all 28 numbers, and `verdict` compares.

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

/// Poses of A and B, twists of A and B, moduli of A and B, dissipation, friction: the columns of a linearized contact.
pub const COLUMNS: usize = 28;

/// Rows: the wrench on A, then that on B. Columns as of [`COLUMNS`].
pub type Jacobian = SMatrix<f64, 12, COLUMNS>;

/// A dual number with a slope by each column.
pub type Wide = DenseDual<COLUMNS>;

/// Changes of zero, each with a slope of 1 by its own column.
pub fn seeds() -> SVector<Wide, COLUMNS> {
    SVector::from_fn(|column, _| Wide::variable(0.0, column))
}

/// The slopes of wrenches.
pub fn jacobian_of(wrench: &ContactWrench<Wide>) -> Jacobian {
    let rows = numbers(wrench);
    Jacobian::from_fn(|row, column| rows[row].eps[column])
}

/// A pair in motion, in plain numbers.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    pub pair: ContactPair<'a>,
    pub twists: [Twist; 2],
    pub dissipation: f64,
    pub friction: f64,
    /// (m/s)
    pub slip_tolerance: f64,
    /// How far the special position is missed, in angle and relative to the size.
    pub missed: f64,
}

impl<'a> Scene<'a> {
    /// A pair in no special position, with twists of up to 0.5 (rad/s, m/s), dissipation and friction at random.
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

    /// 12×28: see [`hydroelastic::contact::LinearizedContact::jacobian`].
    pub fn linearized(&self) -> Jacobian {
        self.pair
            .moving(self.law(), self.twists)
            .linearized()
            .jacobian()
    }

    /// The pair, its law and its velocities after changes of the numbers.
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
            let own = &self.twists[of];
            Twist {
                angular: angular + lift_vector(&own.angular),
                linear: linear + lift_vector(&own.linear),
            }
        };
        (pair, law, [velocity(0), velocity(1)])
    }

    /// The wrenches after changes.
    pub fn wrenches(&self, changes: &SVector<f64, COLUMNS>) -> SVector<f64, 12> {
        let (pair, law, twists) = self.changed(changes);
        numbers(&pair.moving(law, twists).wrench())
    }

    /// The error of a Jacobian along a direction against the best of central differences with these steps, relative to the
    /// largest number of the derivative: where a step straddles a polygon's change of topology, or its wrench is rounded,
    /// another does not.
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

    /// The same with the names of the bodies exchanged.
    pub fn exchanged(&self) -> Self {
        Self {
            pair: ContactPair::new(self.pair.b().body().unwrap(), *self.pair.a()),
            twists: [self.twists[1], self.twists[0]],
            ..*self
        }
    }
}

/// The wrench on A, then that on B.
pub fn numbers<T: Scalar>(wrench: &ContactWrench<T>) -> SVector<T, 12> {
    let (on_a, on_b) = (wrench.on_a.to_vector(), wrench.on_b.to_vector());
    SVector::from_fn(|i, _| if i < 6 { on_a[i] } else { on_b[i - 6] })
}

/// The Jacobian of the exchanged pair, put in the order of this one.
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
