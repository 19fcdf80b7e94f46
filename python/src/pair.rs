//! Pairs of shapes, and the contact between them at given poses.

use crate::any_shape::{self, AnyShape};
use crate::arrays::{Floats, optional_real, real};
use crate::errors::{file_error, value_error};
use crate::material::{SurfaceLaw, modulus_repr};
use crate::pair_inputs::Inputs;
use crate::poses::single_pose;
use crate::shape::Shape;
use crate::surface::Surface;
use crate::taxel_grid::{TaxelGrid, grid_body};
use hydroelastic::contact::{ContactPair, ContactWrench, LinearizedClearance, LinearizedContact};
use hydroelastic::io::write_surface;
use hydroelastic::nalgebra::SMatrix;
use hydroelastic::spatial::Pose;
use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Number of components of both wrenches.
pub const BOTH: usize = 12;

/// Number of coordinates of two points, one on each body.
const POINTS: usize = 6;

/// Number of columns of the Jacobian at rest.
const AT_REST: usize = 14;
/// Number of columns of the Jacobian in motion.
const IN_MOTION: usize = 28;

/// Two shapes A and B that can collide, with their moduli and their surface law. A is compliant; B is of any kind.
///
/// - A pose is a (4, 4) array of float64 that maps coordinates in the body frame to the world.
/// - A twist is a (6,) array: angular velocity (rad/s), then velocity (m/s) of the origin of the body frame, in world axes.
/// - Both wrenches together are a (12,) array: torque (N m) and force (N) on A about the origin of its frame, then torque and force on
///   B about the origin of its frame, in world axes.
/// - Moduli are a (2,) array: A, then B (Pa). If B is rigid, the second modulus is ignored, and derivatives with respect to it are 0.
///
/// Each array may have an additional first axis of length n. Then each result has this axis too. All cores compute such a batch,
/// without the GIL, with the same bits as a loop.
///
/// Parameters
/// ----------
/// a : Shape
///     Shape of A.
/// b : Shape, RigidShape or HalfSpace
///     Shape of B.
/// modulus_a : float
///     Hydroelastic modulus (Pa) of A, positive.
/// modulus_b : float, optional
///     Hydroelastic modulus (Pa) of B, positive. None, the default, for a rigid B.
/// law : SurfaceLaw, optional
///     Surface law. Default: no dissipation and no friction.
///
/// Raises
/// ------
/// HydroelasticError
///     If a modulus is not positive, a rigid B has a modulus, or a compliant B has none. Every method raises it if an array has an
///     unexpected shape, a pose is not rigid, or a number is not finite.
/// TypeError
///     If A is not a Shape. Every method raises it if an array cannot be converted to float64 without a loss.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Pair {
    pub a: Shape,
    pub b: AnyShape,
    modulus_a: f64,
    modulus_b: Option<f64>,
    pub law: SurfaceLaw,
}

impl Pair {
    /// Both moduli (Pa). A missing modulus is replaced by 1, which has no effect.
    pub fn moduli_or_1(&self) -> [f64; 2] {
        [self.modulus_a, self.modulus_b.unwrap_or(1.0)]
    }

    /// Creates the contact at two poses, with two moduli.
    pub fn at(
        &self,
        [pose_a, pose_b]: [Pose; 2],
        [modulus_a, modulus_b]: [f64; 2],
    ) -> PyResult<ContactPair<'_>> {
        let a = self.a.at(pose_a, modulus_a).map_err(value_error)?;
        let b = self.b.partner(pose_b, modulus_b).map_err(value_error)?;
        Ok(ContactPair::new(a, b))
    }

    /// Creates the contact at two poses.
    fn at_poses(
        &self,
        pose_a: &Bound<'_, PyAny>,
        pose_b: &Bound<'_, PyAny>,
    ) -> PyResult<ContactPair<'_>> {
        let poses = [
            single_pose(pose_a, "pose_a")?,
            single_pose(pose_b, "pose_b")?,
        ];
        self.at(poses, self.moduli_or_1())
    }
}

impl Pair {
    /// Computes the forces on taxels and their Jacobian with `N` columns.
    fn tactile_jacobian<'py, const N: usize>(
        &self,
        py: Python<'py>,
        inputs: &Inputs,
        grid: &TaxelGrid,
        body: &str,
    ) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let (body, [rows, columns, _]) = (grid_body(body)?, grid.shape());
        let size = 3 * rows * columns;
        let results = inputs.compute(py, self, size * (1 + N), |at, numbers| {
            let linearized = at.pair.linearized_tactile_image(body, &grid.inner);
            let (forces, jacobian) = numbers.split_at_mut(size);
            grid.write(linearized.image(), false, forces);
            for taxel in linearized.image().taxels() {
                let block = linearized.jacobian(taxel.row, taxel.column);
                let first = 3 * N * (taxel.row * columns + taxel.column);
                write_inputs::<N>(&mut jacobian[first..first + 3 * N], &block);
            }
        })?;
        let forces = results.array(py, 0, &grid.shape())?;
        Ok((forces, results.array(py, size, &[rows, columns, 3, N])?))
    }
}

/// Writes derivatives row by row, with all 28 columns, or with the 14 columns of poses and moduli.
fn write_inputs<const N: usize>(rows: &mut [f64], block: &SMatrix<f64, 3, IN_MOTION>) {
    for (row, entries) in rows.chunks_exact_mut(N).enumerate() {
        for (column, entry) in entries.iter_mut().enumerate() {
            // The 14 columns have no twists, so the moduli follow the poses.
            let skipped = if N == AT_REST && column >= 12 { 12 } else { 0 };
            *entry = block[(row, column + skipped)];
        }
    }
}

/// Checks that B has a modulus exactly if B is not rigid.
fn check_modulus(b: &AnyShape, modulus: Option<f64>) -> PyResult<()> {
    match (b.inner().is_rigid(), modulus) {
        (true, Some(modulus)) => Err(value_error(format!(
            "{} is rigid and has no modulus, but modulus_b is {modulus:?} Pa",
            b.__repr__()
        ))),
        (false, None) => Err(value_error(format!(
            "{} is not rigid: modulus_b is missing",
            b.__repr__()
        ))),
        _ => Ok(()),
    }
}

/// Converts a zero-dimensional array to a number, and returns other arrays unchanged.
fn number_or_array(values: Floats<'_>) -> PyResult<Bound<'_, PyAny>> {
    match values.ndim() {
        0 => values.call_method0("item"),
        _ => Ok(values.into_any()),
    }
}

/// Components of both wrenches.
pub fn wrench_numbers(wrench: &ContactWrench) -> [f64; BOTH] {
    let [a, b] = [wrench.on_a.to_vector(), wrench.on_b.to_vector()];
    std::array::from_fn(|index| if index < 6 { a[index] } else { b[index - 6] })
}

/// Writes a block of columns of a Jacobian, from the column `first` on. Each row has `width` numbers.
pub fn write_columns<const R: usize, const C: usize>(
    rows: &mut [f64],
    width: usize,
    first: usize,
    block: &SMatrix<f64, R, C>,
) {
    for (row, entries) in rows.chunks_exact_mut(width).take(R).enumerate() {
        for (column, entry) in entries[first..first + C].iter_mut().enumerate() {
            *entry = block[(row, column)];
        }
    }
}

/// Writes the Jacobian at rest, row by row.
fn write_at_rest(rows: &mut [f64], contact: &LinearizedContact) {
    write_columns(rows, AT_REST, 0, &contact.by_poses);
    write_columns(rows, AT_REST, 12, &contact.by_moduli);
}

/// Writes the Jacobian in motion, row by row.
fn write_in_motion(rows: &mut [f64], contact: &LinearizedContact) {
    write_columns(rows, IN_MOTION, 0, &contact.by_poses);
    write_columns(rows, IN_MOTION, 12, &contact.by_twists);
    write_columns(rows, IN_MOTION, 24, &contact.by_moduli);
    write_columns(rows, IN_MOTION, 26, &contact.by_law);
}

#[pymethods]
impl Pair {
    #[new]
    #[pyo3(signature = (a, b, modulus_a, modulus_b=None, law=None))]
    fn new(
        #[pyo3(from_py_with = any_shape::shape)] a: AnyShape,
        #[pyo3(from_py_with = any_shape::shape)] b: AnyShape,
        #[pyo3(from_py_with = real)] modulus_a: f64,
        #[pyo3(from_py_with = optional_real)] modulus_b: Option<f64>,
        law: Option<&SurfaceLaw>,
    ) -> PyResult<Self> {
        let law = law
            .copied()
            .map_or_else(|| SurfaceLaw::new(0.0, 0.0, 1e-3), Ok)?;
        let a = match a {
            AnyShape::Compliant(shape) => shape,
            shape => {
                return Err(PyTypeError::new_err(format!(
                    "a must be a compliant Shape, but is {}: pass the rigid body as b",
                    shape.__repr__()
                )));
            }
        };
        check_modulus(&b, modulus_b)?;
        let pair = Self {
            a,
            b,
            modulus_a,
            modulus_b,
            law,
        };
        pair.at([Pose::identity(); 2], pair.moduli_or_1())?;
        Ok(pair)
    }

    /// Shapes of A and B.
    #[getter]
    fn shapes(&self) -> (Shape, AnyShape) {
        (self.a.clone(), self.b.clone())
    }

    /// Hydroelastic moduli (Pa) of A and B. The second is None if B is rigid.
    #[getter]
    fn moduli(&self) -> (f64, Option<f64>) {
        (self.modulus_a, self.modulus_b)
    }

    /// Surface law.
    #[getter]
    fn law(&self) -> SurfaceLaw {
        self.law
    }

    /// Computes the wrenches on both bodies.
    ///
    /// Without twists, the bodies are at rest. With a twist, the wrenches include dissipation and friction.
    ///
    /// Parameters
    /// ----------
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// twist_a, twist_b : (6,) or (n, 6) array_like, optional
    ///     Twists of A and B. If one is given, the other is zero by default.
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair.
    /// law : (2,) or (n, 2) array_like, optional
    ///     Dissipation (s/m) and friction coefficient in place of those of the pair.
    ///
    /// Returns
    /// -------
    /// (12,) or (n, 12) ndarray of float64
    ///     Torque (N m) and force (N) on A, then on B.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument or a result is not valid, as in the class description.
    #[pyo3(signature = (pose_a, pose_b, twist_a=None, twist_b=None, *, moduli=None, law=None))]
    fn wrench<'py>(
        &self,
        py: Python<'py>,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        twist_a: Option<&Bound<'py, PyAny>>,
        twist_b: Option<&Bound<'py, PyAny>>,
        moduli: Option<&Bound<'py, PyAny>>,
        law: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Floats<'py>> {
        let (poses, twists) = ([pose_a, pose_b], [twist_a, twist_b]);
        let inputs = Inputs::of(self, poses, twists, moduli, law)?;
        let results = inputs.compute(py, self, BOTH, |at, row| {
            row.copy_from_slice(&wrench_numbers(&at.pair.wrench()));
        })?;
        results.array(py, 0, &[BOTH])
    }

    /// Computes the wrenches on bodies at rest and their Jacobian, in closed form.
    ///
    /// The columns of the Jacobian are the pose of A (6), the pose of B (6), the modulus of A and the modulus of B. Derivatives with
    /// respect to a pose are with respect to a twist in world axes, as in moved_pose.
    ///
    /// Parameters
    /// ----------
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair.
    ///
    /// Returns
    /// -------
    /// wrenches : (12,) or (n, 12) ndarray of float64
    ///     Torque (N m) and force (N) on A, then on B.
    /// jacobian : (12, 14) or (n, 12, 14) ndarray of float64
    ///     Derivatives of the wrenches.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument or a result is not valid, as in the class description.
    #[pyo3(signature = (pose_a, pose_b, *, moduli=None))]
    fn wrench_and_jacobian<'py>(
        &self,
        py: Python<'py>,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        moduli: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let (poses, twists, law) = ([pose_a, pose_b], [None, None], None);
        let inputs = Inputs::of(self, poses, twists, moduli, law)?;
        let results = inputs.compute(py, self, BOTH * (1 + AT_REST), |at, row| {
            let contact = at.pair.linearized();
            let (wrenches, rows) = row.split_at_mut(BOTH);
            wrenches.copy_from_slice(&wrench_numbers(&contact.wrench));
            write_at_rest(rows, &contact);
        })?;
        let wrenches = results.array(py, 0, &[BOTH])?;
        Ok((wrenches, results.array(py, BOTH, &[BOTH, AT_REST])?))
    }

    /// Computes the wrenches on moving bodies and their Jacobian, in closed form.
    ///
    /// The columns of the Jacobian are the pose of A (6), the pose of B (6), the twist of A (6), the twist of B (6), the modulus of A,
    /// the modulus of B, the dissipation and the friction coefficient. Derivatives with respect to a pose are with respect to a twist in
    /// world axes, as in moved_pose.
    ///
    /// Parameters
    /// ----------
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// twist_a, twist_b : (6,) or (n, 6) array_like, optional
    ///     Twists of A and B. Default: zero.
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair.
    /// law : (2,) or (n, 2) array_like, optional
    ///     Dissipation (s/m) and friction coefficient in place of those of the pair.
    ///
    /// Returns
    /// -------
    /// wrenches : (12,) or (n, 12) ndarray of float64
    ///     Torque (N m) and force (N) on A, then on B.
    /// jacobian : (12, 28) or (n, 12, 28) ndarray of float64
    ///     Derivatives of the wrenches.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument or a result is not valid, as in the class description.
    #[pyo3(signature = (pose_a, pose_b, twist_a=None, twist_b=None, *, moduli=None, law=None))]
    fn linearized<'py>(
        &self,
        py: Python<'py>,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        twist_a: Option<&Bound<'py, PyAny>>,
        twist_b: Option<&Bound<'py, PyAny>>,
        moduli: Option<&Bound<'py, PyAny>>,
        law: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let (poses, twists) = ([pose_a, pose_b], [twist_a, twist_b]);
        let inputs = Inputs::of(self, poses, twists, moduli, law)?.moving();
        let results = inputs.compute(py, self, BOTH * (1 + IN_MOTION), |at, row| {
            let linearized = at.pair.linearized();
            let (wrenches, rows) = row.split_at_mut(BOTH);
            wrenches.copy_from_slice(&wrench_numbers(&linearized.wrench));
            write_in_motion(rows, &linearized);
        })?;
        let wrenches = results.array(py, 0, &[BOTH])?;
        Ok((wrenches, results.array(py, BOTH, &[BOTH, IN_MOTION])?))
    }

    /// Computes the forces on the taxels of a grid that is fixed to A or to B, as exact integrals.
    ///
    /// Each force acts on the body of the grid. Its components are along the axes of the taxel: two components of shear, then the normal
    /// component, which is negative if the taxel is pressed. With a twist, forces include dissipation and friction. Contact outside of the
    /// patch is omitted.
    ///
    /// Parameters
    /// ----------
    /// grid : TaxelGrid
    ///     Grid of H rows and W columns.
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// twist_a, twist_b : (6,) or (n, 6) array_like, optional
    ///     Twists of A and B. If one is given, the other is zero by default.
    /// body : str, optional
    ///     Body of the grid, "a" or "b". Default: "a".
    /// mean : bool, optional
    ///     If True, returns mean tractions (Pa) instead of forces: the force divided by the contact area in the taxel. Default: False.
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair.
    /// law : (2,) or (n, 2) array_like, optional
    ///     Dissipation (s/m) and friction coefficient in place of those of the pair.
    ///
    /// Returns
    /// -------
    /// (H, W, 3) or (n, H, W, 3) ndarray of float64
    ///     Forces (N), or mean tractions (Pa).
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument or a result is not valid, as in the class description.
    #[pyo3(signature = (grid, pose_a, pose_b, twist_a=None, twist_b=None, *, body="a", mean=false, moduli=None, law=None))]
    fn tactile_image<'py>(
        &self,
        py: Python<'py>,
        grid: &TaxelGrid,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        twist_a: Option<&Bound<'py, PyAny>>,
        twist_b: Option<&Bound<'py, PyAny>>,
        body: &str,
        mean: bool,
        moduli: Option<&Bound<'py, PyAny>>,
        law: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Floats<'py>> {
        let (poses, twists) = ([pose_a, pose_b], [twist_a, twist_b]);
        let inputs = Inputs::of(self, poses, twists, moduli, law)?;
        let (body, shape) = (grid_body(body)?, grid.shape());
        let results = inputs.compute(py, self, shape.iter().product(), |at, numbers| {
            grid.write(&at.pair.tactile_image(body, &grid.inner), mean, numbers);
        })?;
        results.array(py, 0, &shape)
    }

    /// Computes the forces on the taxels of a grid on bodies at rest, and their Jacobian.
    ///
    /// The Jacobian has the same columns as wrench_and_jacobian.
    ///
    /// Parameters
    /// ----------
    /// grid : TaxelGrid
    ///     Grid of H rows and W columns.
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// body : str, optional
    ///     Body of the grid, "a" or "b". Default: "a".
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair.
    ///
    /// Returns
    /// -------
    /// forces : (H, W, 3) or (n, H, W, 3) ndarray of float64
    ///     Forces (N), as in tactile_image.
    /// jacobian : (H, W, 3, 14) or (n, H, W, 3, 14) ndarray of float64
    ///     Derivatives of the forces.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument or a result is not valid, as in the class description.
    #[pyo3(signature = (grid, pose_a, pose_b, *, body="a", moduli=None))]
    fn tactile_image_and_jacobian<'py>(
        &self,
        py: Python<'py>,
        grid: &TaxelGrid,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        body: &str,
        moduli: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let (poses, twists) = ([pose_a, pose_b], [None, None]);
        let inputs = Inputs::of(self, poses, twists, moduli, None)?;
        self.tactile_jacobian::<AT_REST>(py, &inputs, grid, body)
    }

    /// Computes the forces on the taxels of a grid on moving bodies, and their Jacobian.
    ///
    /// The Jacobian has the same columns as linearized.
    ///
    /// Parameters
    /// ----------
    /// grid : TaxelGrid
    ///     Grid of H rows and W columns.
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// twist_a, twist_b : (6,) or (n, 6) array_like, optional
    ///     Twists of A and B. Default: zero.
    /// body : str, optional
    ///     Body of the grid, "a" or "b". Default: "a".
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair.
    /// law : (2,) or (n, 2) array_like, optional
    ///     Dissipation (s/m) and friction coefficient in place of those of the pair.
    ///
    /// Returns
    /// -------
    /// forces : (H, W, 3) or (n, H, W, 3) ndarray of float64
    ///     Forces (N), as in tactile_image.
    /// jacobian : (H, W, 3, 28) or (n, H, W, 3, 28) ndarray of float64
    ///     Derivatives of the forces.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument or a result is not valid, as in the class description.
    #[pyo3(signature = (grid, pose_a, pose_b, twist_a=None, twist_b=None, *, body="a", moduli=None, law=None))]
    fn linearized_tactile_image<'py>(
        &self,
        py: Python<'py>,
        grid: &TaxelGrid,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        twist_a: Option<&Bound<'py, PyAny>>,
        twist_b: Option<&Bound<'py, PyAny>>,
        body: &str,
        moduli: Option<&Bound<'py, PyAny>>,
        law: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let (poses, twists) = ([pose_a, pose_b], [twist_a, twist_b]);
        let inputs = Inputs::of(self, poses, twists, moduli, law)?.moving();
        self.tactile_jacobian::<IN_MOTION>(py, &inputs, grid, body)
    }

    /// Computes the potential energy of the contact.
    ///
    /// The wrench on bodies at rest is minus the derivative of the energy. The energy takes much longer than the wrench.
    ///
    /// Parameters
    /// ----------
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair.
    ///
    /// Returns
    /// -------
    /// float or (n,) ndarray of float64
    ///     Potential energy (J).
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument or a result is not valid, as in the class description.
    #[pyo3(signature = (pose_a, pose_b, *, moduli=None))]
    fn potential_energy<'py>(
        &self,
        py: Python<'py>,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        moduli: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (poses, twists, law) = ([pose_a, pose_b], [None, None], None);
        let inputs = Inputs::of(self, poses, twists, moduli, law)?;
        let results = inputs.compute(py, self, 1, |at, row| row[0] = at.pair.potential_energy())?;
        number_or_array(results.array(py, 0, &[])?)
    }

    /// Computes the signed distance between the bodies and its derivatives, also before contact.
    ///
    /// The distance has kinks where the closest features change, for example at parallel faces. At a kink of bodies apart, the gradient
    /// is computed for one of the pairs of closest features. If the bodies touch, it is the mean over these pairs. Derivatives with
    /// respect to a pose are derivatives with respect to a twist in world axes, as in moved_pose.
    ///
    /// Parameters
    /// ----------
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair. They matter only if the bodies overlap.
    ///
    /// Returns
    /// -------
    /// distance : float or (n,) ndarray of float64
    ///     Distance (m) between the surfaces, or minus the depth (m) if the bodies overlap. The depth depends on the pressure fields.
    /// points : (2, 3) or (n, 2, 3) ndarray of float64
    ///     Closest points (m) of A and B in the world. Both are the deepest point if the bodies overlap.
    /// gradient : (14,) or (n, 14) ndarray of float64
    ///     Derivatives of the distance with respect to the pose of A, the pose of B (m/rad and m/m each) and the moduli (m/Pa).
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument or a result is not valid, as in the class description.
    #[pyo3(signature = (pose_a, pose_b, *, moduli=None))]
    fn clearance<'py>(
        &self,
        py: Python<'py>,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        moduli: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Floats<'py>, Floats<'py>)> {
        let (poses, twists, law) = ([pose_a, pose_b], [None, None], None);
        let inputs = Inputs::of(self, poses, twists, moduli, law)?;
        let results = inputs.compute(py, self, 1 + POINTS + AT_REST, |at, row| {
            let LinearizedClearance {
                clearance,
                by_poses,
                by_moduli,
                ..
            } = at.pair.linearized_clearance();
            row[0] = clearance.distance;
            let [a, b] = clearance.points;
            row[1..4].copy_from_slice(a.as_slice());
            row[4..=POINTS].copy_from_slice(b.as_slice());
            row[1 + POINTS..][..BOTH].copy_from_slice(by_poses.as_slice());
            row[1 + POINTS + BOTH..].copy_from_slice(by_moduli.as_slice());
        })?;
        let distances = number_or_array(results.array(py, 0, &[])?)?;
        let points = results.array(py, 1, &[2, 3])?;
        Ok((
            distances,
            points,
            results.array(py, 1 + POINTS, &[AT_REST])?,
        ))
    }

    /// Computes the contact surface.
    ///
    /// Parameters
    /// ----------
    /// pose_a, pose_b : (4, 4) array_like
    ///     Poses of A and B in the world.
    ///
    /// Returns
    /// -------
    /// Surface
    ///     Contact surface in the world frame.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a pose is not rigid.
    fn surface<'py>(
        &self,
        py: Python<'py>,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
    ) -> PyResult<Surface> {
        let pair = self.at_poses(pose_a, pose_b)?;
        let surface = py.detach(|| pair.surface());
        Surface::of(py, &surface)
    }

    /// Returns whether the bodies overlap so deeply that contact may no longer push them apart.
    ///
    /// This is true if the bodies overlap without a contact surface, one body is wholly inside the other, or each body contains the middle
    /// of the other. A rod that pierces a body away from the point of highest pressure is not reported.
    ///
    /// Parameters
    /// ----------
    /// pose_a, pose_b : (4, 4) array_like
    ///     Poses of A and B in the world.
    ///
    /// Returns
    /// -------
    /// bool
    ///     True if the bodies have sunk through each other.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a pose is not rigid.
    fn has_sunk_through(
        &self,
        py: Python<'_>,
        pose_a: &Bound<'_, PyAny>,
        pose_b: &Bound<'_, PyAny>,
    ) -> PyResult<bool> {
        let pair = self.at_poses(pose_a, pose_b)?;
        Ok(py.detach(|| pair.has_sunk_through()))
    }

    /// Writes the contact surface as a VTK file, for ParaView and similar programs.
    ///
    /// The point data of the file are the pressures (Pa). The cell data are the mean pressure (Pa), the area (m²) and the normal of each
    /// polygon.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     File, with the extension .vtp for VTK XML or .vtk for legacy VTK.
    /// pose_a, pose_b : (4, 4) array_like
    ///     Poses of A and B in the world.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a pose is not rigid, or the extension is unknown.
    /// OSError
    ///     If the file cannot be written.
    fn write_surface(
        &self,
        py: Python<'_>,
        path: PathBuf,
        pose_a: &Bound<'_, PyAny>,
        pose_b: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let pair = self.at_poses(pose_a, pose_b)?;
        py.detach(|| write_surface(path, &pair.surface()).map_err(file_error))
    }

    fn __repr__(&self) -> String {
        let (a, b) = (self.a.__repr__(), self.b.__repr__());
        let (modulus_a, modulus_b) = (self.modulus_a, modulus_repr(self.modulus_b));
        let law = self.law.__repr__();
        format!("Pair({a}, {b}, modulus_a={modulus_a:?}, modulus_b={modulus_b}, law={law})")
    }

    fn __getnewargs__(&self) -> (Shape, AnyShape, f64, Option<f64>, SurfaceLaw) {
        let (a, b) = self.shapes();
        (a, b, self.modulus_a, self.modulus_b, self.law)
    }
}
