//! Does a soft fingertip find the pose of an object from one tactile image?
//!
//! `cargo run --release -p hydroelastic-examples --example tactile_pose`
//!
//! A rigid block presses with one face into a flat soft pad, whose taxels measure pressure and shear without noise. The whole face is on
//! the pad, so all six degrees of freedom are observable: the edges determine position and yaw, and the pressure determines depth and tilt.
//! The orientation of a ball would not be observable, and neither would the position of a face larger than the pad.
//!
//! From 100 random poses within 5 mm and 10°, the Levenberg–Marquardt method fits the pose to the image. It uses the exact Jacobian of the
//! taxels. A start may be above the pad, where the image and its Jacobian are zero. Therefore a bisection first finds the depth at which
//! the normal force equals the measured normal force.

use hydroelastic::contact::{
    BodyError, ContactBody, ContactPair, GridBody, Partner, RigidShape, Shape, TaxelGrid,
};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Matrix6, Vector3, Vector6, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};

/// Edges of the pad and of the block (m), and the modulus of the pad (Pa).
const PAD: [f64; 3] = [0.04, 0.04, 0.012];
const BLOCK: [f64; 3] = [0.014, 0.009, 0.01];
const MODULUS: f64 = 1e5;
/// Number of columns and of rows.
const TAXELS: usize = 32;
/// Number of starts, and their largest distance (m) and angle (rad) from the true pose.
const STARTS: usize = 100;
const DISTANCE: f64 = 0.005;
const ANGLE: f64 = 10.0 / 180.0 * std::f64::consts::PI;
/// Largest position error (m) of a pose that counts as found, and the smallest number of poses to find.
const FOUND: f64 = 1e-4;
const EXPECTED: usize = 95;
/// Largest number of steps of a fit.
const STEPS: usize = 100;

/// Forces on all taxels (N), row by row.
type Image = Vec<Vector3<f64>>;

struct Finger {
    pad: Shape,
    block: RigidShape,
    grid: TaxelGrid,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let block = shapes::cuboid(BLOCK)?;
    let top = Pose::from_translation(vector![0.0, 0.0, PAD[2] / 2.0]);
    let finger = Finger {
        pad: Shape::new(shapes::cuboid(PAD)?),
        block: RigidShape::new(TriangleSurface::around(block.mesh())?),
        grid: TaxelGrid::flat(&top, [PAD[0], PAD[1]], [TAXELS; 2])?,
    };
    let height = f64::midpoint(PAD[2], BLOCK[2]) - 0.0015;
    let truth =
        Pose::from_rotation_vector(&vector![0.03, -0.02, 0.4], vector![0.002, -0.001, height]);
    let measured = finger.image(&truth)?;
    let mut random = StdRng::seed_from_u64(1);
    let mut found = 0;
    for start in 0..STARTS {
        let guess = truth.moved_by(&random_twist(&mut random));
        let (pose, steps) = finger.fitted(&measured, &guess)?;
        let error = (pose.translation() - truth.translation()).norm();
        let angle = pose.rotation().transpose() * truth.rotation();
        let angle = ((angle.trace() - 1.0) / 2.0).min(1.0).acos().to_degrees();
        found += usize::from(error < FOUND);
        if start < 5 || error >= FOUND {
            println!(
                "start {start}: off by {:.1e} mm and {angle:.1e}° after {steps} steps",
                1e3 * error
            );
        }
    }
    println!("{found} of {STARTS} poses found to {} mm", 1e3 * FOUND);
    assert!(found >= EXPECTED);
    Ok(())
}

/// Returns a twist whose angular and linear parts are uniform in balls with the radii `ANGLE` and `DISTANCE`.
fn random_twist(random: &mut StdRng) -> Twist {
    let mut vector = |size: f64| loop {
        let vector = Vector3::from_fn(|_, _| random.random_range(-1.0..1.0));
        if vector.norm() <= 1.0 {
            return vector * size;
        }
    };
    Twist {
        angular: vector(ANGLE),
        linear: vector(DISTANCE),
    }
}

impl Finger {
    fn pair(&self, pose: &Pose) -> Result<ContactPair<'_>, BodyError> {
        let pad = ContactBody::new(&self.pad, Pose::identity(), MODULUS)?;
        Ok(ContactPair::new(pad, Partner::rigid(&self.block, *pose)?))
    }

    fn image(&self, pose: &Pose) -> Result<Image, BodyError> {
        let image = self.pair(pose)?.tactile_image(GridBody::A, &self.grid);
        let taxels = (0..TAXELS * TAXELS).map(|taxel| image.force(taxel / TAXELS, taxel % TAXELS));
        Ok(taxels.collect())
    }

    /// Returns half the sum of the squared differences from a measured image (N²).
    fn cost(&self, measured: &Image, pose: &Pose) -> Result<f64, BodyError> {
        let image = self.image(pose)?;
        Ok(image
            .iter()
            .zip(measured)
            .map(|(a, b)| 0.5 * (a - b).norm_squared())
            .sum())
    }

    /// Returns the pose with the height at which the pad carries the measured normal force.
    fn lowered(&self, measured: &Image, pose: &Pose) -> Result<Pose, BodyError> {
        let load = |image: &Image| -> f64 { image.iter().map(|force| -force.z).sum() };
        let at = |shift: f64| pose.with_translation(pose.translation() + Vector3::z() * shift);
        let (mut low, mut high) = (-2.0 * DISTANCE, 2.0 * DISTANCE);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            let is_too_low = load(&self.image(&at(middle))?) > load(measured);
            *(if is_too_low { &mut low } else { &mut high }) = middle;
        }
        Ok(at(0.5 * (low + high)))
    }

    /// Fits the pose to a measured image from a first guess. Returns the pose and the number of steps.
    fn fitted(&self, measured: &Image, guess: &Pose) -> Result<(Pose, usize), BodyError> {
        let mut pose = self.lowered(measured, guess)?;
        let (mut cost, mut damping) = (self.cost(measured, &pose)?, 1e-2);
        for step in 0..STEPS {
            let (information, slope) = self.linearized(measured, &pose)?;
            loop {
                let damped =
                    information + Matrix6::from_diagonal(&(information.diagonal() * damping));
                let change = damped
                    .cholesky()
                    .map_or(Vector6::zeros(), |cholesky| cholesky.solve(&slope));
                let changed = pose.moved_by(&Twist::from_vector(&change));
                let new_cost = self.cost(measured, &changed)?;
                if new_cost < cost {
                    (pose, cost, damping) = (changed, new_cost, damping / 5.0);
                    break;
                }
                damping *= 5.0;
                if damping > 1e10 {
                    return Ok((pose, step));
                }
            }
        }
        Ok((pose, STEPS))
    }

    /// Returns JᵀJ and −Jᵀr of the residuals r with respect to a twist of the block.
    fn linearized(
        &self,
        measured: &Image,
        pose: &Pose,
    ) -> Result<(Matrix6<f64>, Vector6<f64>), BodyError> {
        let linearized = self
            .pair(pose)?
            .linearized_tactile_image(GridBody::A, &self.grid);
        let (mut information, mut slope) = (Matrix6::zeros(), Vector6::zeros());
        for taxel in linearized.image().taxels() {
            let (row, column) = (taxel.row, taxel.column);
            let by_pose = linearized
                .jacobian(row, column)
                .fixed_columns::<6>(6)
                .into_owned();
            let residual = linearized.image().force(row, column) - measured[row * TAXELS + column];
            information += by_pose.tr_mul(&by_pose);
            slope -= by_pose.tr_mul(&residual);
        }
        Ok((information, slope))
    }
}
