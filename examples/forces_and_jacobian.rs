//! Do the closed-form derivatives of the forces on a non-convex part agree with differences?
//!
//! `cargo run --release -p hydroelastic-examples --example forces_and_jacobian [FILE.vtk]`
//!
//! A ball is pressed into the inner corner of a bracket meshed by Gmsh. The example writes the contact surface for ParaView, to the given
//! path or to the directory for temporary files.

use hydroelastic::contact::{BodyError, ContactBody, ContactPair, Shape};
use hydroelastic::io::{MeshOptions, read_mesh, write_surface};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{SMatrix, SVector, Vector3};
use std::path::{Path, PathBuf};

const BRACKET: &str = "../tests/data/meshes_from_mesher/bracket.msh";
/// Radius of the ball (m), and moduli of ball and bracket (Pa).
const RADIUS: f64 = 0.04;
const MODULI: [f64; 2] = [2e5, 1e6];

/// Step of the differences, relative to 1 rad, the radius and the moduli. The errors are the squared step times the curvature, and
/// round-off (1e-15) divided by the step.
const STEP: f64 = 1e-6;
/// Largest deviation, relative to the largest entry of the same units: 100 times these errors.
const TOLERANCE: f64 = 1e-7;

/// Rows: wrench on the ball, wrench on the bracket. Columns: twists of both bodies, moduli of both bodies.
type Jacobian = SMatrix<f64, 12, 14>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = read_mesh(
        Path::new(env!("CARGO_MANIFEST_DIR")).join(BRACKET),
        &MeshOptions::default(),
    )?;
    let bracket = Shape::new(PressureField::from_distance(&file.mesh)?);
    let ball = Shape::new(shapes::icosphere(RADIUS, 3)?);
    // The corner is an upright wall and a floor. It runs along y at x = z = 0.07 m.
    let [turn, tilt] = [[0.3, -0.2, 0.5], [0.02, -0.03, 0.01]].map(Vector3::from);
    let pose_wa = Pose::from_rotation_vector(&turn, Vector3::new(0.1033, 0.0471, 0.1049));
    let pose_wb = Pose::from_rotation_vector(&tilt, Vector3::zeros());

    // Both wrenches after twists of both bodies in world axes, and relative changes of the moduli.
    let moved = |motion: SVector<f64, 14>| {
        let twist = |row| Twist::from_vector(&motion.fixed_rows::<6>(row).into_owned());
        let moduli = [0, 1].map(|i| MODULI[i] * (1.0 + motion[12 + i]));
        let a = ContactBody::new(&ball, pose_wa.moved_by(&twist(0)), moduli[0])?;
        let b = ContactBody::new(&bracket, pose_wb.moved_by(&twist(6)), moduli[1])?;
        Ok::<_, BodyError>(ContactPair::new(a, b))
    };
    let pair = moved(SVector::zeros())?;
    let contact = pair.linearized();
    let Wrench { torque, force } = contact.wrench.on_a;
    println!("Force on the ball (N): {force:.4?}");
    println!("Torque about its center (N m): {torque:.6?}");
    println!("Potential energy (J): {:.6}", pair.potential_energy());
    // Columns: poses of A and B (angular, linear each), moduli of A and B.
    let exact = Jacobian::from_fn(|row, column| match column {
        0..12 => contact.by_poses[(row, column)],
        _ => contact.by_moduli[(row, column - 12)],
    });
    println!("By poses and moduli: {:.1e}", exact.fixed_rows::<6>(0));

    let mut differences = Jacobian::zeros();
    for (column, mut slope) in differences.column_iter_mut().enumerate() {
        let step = STEP * [1.0, RADIUS, 1.0, RADIUS, 1.0][column / 3];
        let motion = SVector::from_fn(|row, _| if row == column { step } else { 0.0 });
        let [ahead, behind] = [moved(motion)?, moved(-motion)?].map(|pair| {
            let wrench = pair.wrench();
            both(wrench.on_a.to_vector(), wrench.on_b.to_vector())
        });
        let modulus = [1.0, MODULI[0], MODULI[1]][column.saturating_sub(11)];
        slope.copy_from(&((ahead - behind) / (2.0 * step * modulus)));
    }
    let deviation = deviation(&exact, &differences);
    println!("Largest relative deviation from differences: {deviation:.1e}");

    let argument = std::env::args_os().nth(1).map(PathBuf::from);
    let file = argument.unwrap_or_else(|| std::env::temp_dir().join("forces_and_jacobian.vtk"));
    write_surface(&file, &pair.surface())?;
    println!("Contact surface: {}", file.display());

    assert!(deviation < TOLERANCE);
    // By Newton's third law, both forces are opposite and on one line.
    let from_a_to_b = pose_wb.translation() - pose_wa.translation();
    let sum = contact.wrench.on_a.about(&from_a_to_b) + contact.wrench.on_b;
    assert!(sum.to_vector().amax() < 1e-12 * force.amax());
    assert!(force.x > 1.0 && force.z > 1.0); // both wall and floor press
    Ok(())
}

fn both<const N: usize>(a: SMatrix<f64, 6, N>, b: SMatrix<f64, 6, N>) -> SMatrix<f64, 12, N> {
    SMatrix::from_fn(|row, n| [a, b][row / 6][(row % 6, n)])
}

fn deviation(exact: &Jacobian, differences: &Jacobian) -> f64 {
    let places = || (0..12).flat_map(|row| (0..14).map(move |column| (row, column)));
    // Units of an entry: torque or force, with respect to radians, meters or pascals.
    let units = |(row, column): (usize, usize)| (row / 3 % 2, [0, 1, 0, 1, 2][column / 3]);
    let error = |place| {
        let alike = places().filter(|&other| units(other) == units(place));
        let largest = alike.map(|other| exact[other].abs()).fold(0.0, f64::max);
        (exact[place] - differences[place]).abs() / largest
    };
    places().map(error).max_by(f64::total_cmp).unwrap() // NaN counts as largest
}
