//! Central differences of contact wrenches and of scalars.

use hydroelastic::contact::{ContactBody, ContactPair};
use hydroelastic::spatial::Twist;
use nalgebra::{SMatrix, SVector, Vector6};

/// A motion of a pair: twist of A, twist of B, relative changes of the moduli.
pub type Motion = SVector<f64, 14>;

/// Returns the pair after a motion.
pub fn moved<'a>(pair: &ContactPair<'a>, motion: &Motion) -> ContactPair<'a> {
    let body = |body: &ContactBody<'a>, row: usize, modulus_row: usize| {
        let twist: Vector6<f64> = motion.fixed_rows::<6>(row).into_owned();
        let pose = body.pose().moved_by(&Twist::from_vector(&twist));
        let modulus = body.modulus() * (1.0 + motion[modulus_row]);
        ContactBody::new(body.shape(), pose, modulus).unwrap()
    };
    ContactPair::new(
        body(pair.a(), 0, 12),
        body(&pair.b().body().unwrap(), 6, 13),
    )
}

/// Returns the central difference of the wrench on A: 6×14, with the columns of a motion (moduli: logarithmic).
pub fn central_difference(pair: &ContactPair, step: f64) -> SMatrix<f64, 6, 14> {
    let columns: Vec<Vector6<f64>> = (0..14)
        .map(|column| {
            let mut motion = Motion::zeros();
            motion[column] = step;
            let ahead = moved(pair, &motion).wrench().on_a.to_vector();
            let behind = moved(pair, &-motion).wrench().on_a.to_vector();
            (ahead - behind) / (2.0 * step)
        })
        .collect();
    SMatrix::from_columns(&columns)
}

/// Returns the 6×14 block of a 12×28 Jacobian: the derivatives of the wrench on A with respect to both poses and both moduli.
pub fn at_rest(jacobian: &SMatrix<f64, 12, 28>) -> SMatrix<f64, 6, 14> {
    SMatrix::from_fn(|row, column| jacobian[(row, if column < 12 { column } else { column + 12 })])
}

/// Converts the Jacobian of the wrench on A from derivatives with respect to moduli to derivatives with respect to a motion.
pub fn by_motion(matrix: &SMatrix<f64, 6, 14>, pair: &ContactPair) -> SMatrix<f64, 6, 14> {
    let mut matrix = *matrix;
    matrix.column_mut(12).scale_mut(pair.a().modulus());
    matrix.column_mut(13).scale_mut(pair.b().modulus().unwrap());
    matrix
}

/// Asserts that a slope is within a tolerance of the central differences of a value at 0, with the best of three steps. The tolerance is
/// relative to the slope, or to 1 if the slope is smaller.
pub fn compare_slope((slope, tolerance): (f64, f64), value: impl Fn(f64) -> f64, label: &str) {
    let error = |step: f64| {
        let difference = (value(step) - value(-step)) / (2.0 * step);
        (slope - difference).abs() / slope.abs().max(1.0)
    };
    let errors = [1e-5, 1e-6, 1e-7].map(error);
    let least = errors.into_iter().fold(f64::INFINITY, f64::min);
    println!("{label}: {slope}, off by {least:.1e}");
    assert!(least <= tolerance, "{label}: {slope}, off by {least:e}");
}
