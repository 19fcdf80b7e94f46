//! Two shapes that may touch.

use crate::any_shape::{self, AnyShape};
use crate::arrays::{Floats, optional_real, real};
use crate::errors::value_error;
use crate::material::{SurfaceLaw, modulus_repr};
use crate::pair_inputs::Inputs;
use crate::poses::one;
use crate::shape::Shape;
use crate::surface::Surface;
use hydroelastic::contact::{ContactPair, ContactWrench, LinearizedContact};
use hydroelastic::nalgebra::SMatrix;
use hydroelastic::spatial::Pose;
use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Numbers of both wrenches.
pub const BOTH: usize = 12;

/// Columns of the Jacobian at rest, and in motion.
const AT_REST: usize = 14;
const IN_MOTION: usize = 28;

/// Two shapes that may touch, with their moduli and the law of their surfaces. A is compliant; B is of any kind.
///
/// Poses are (4, 4) float64, twists (6,) (angular rad/s, linear m/s; the linear part is the velocity of the body's origin), all in
/// the world. Each argument may have n in front, and then so has each result: the contacts are computed by all cores, without
/// the GIL, with the bits of a loop. Wrenches are (12,): torque (N m) and force (N) on A, about A's origin, then those on B,
/// about B's.
///
/// Parameters
/// ----------
/// a : a Shape. b : a Shape, a RigidShape or a HalfSpace.
/// modulus_a, modulus_b : hydroelastic moduli (Pa), positive; the second is None where B is rigid. Arrays of both moduli have two
///     numbers all the same: where B is rigid, the second is ignored, and derivatives by it are 0.
/// law : surface law, or None for no dissipation and no friction.
///
/// Raises
/// ------
/// HydroelasticError if a modulus is not positive, B is rigid and has one, or is not and has none; every method, if an array has another shape, a pose is not rigid or a
/// number is not finite. TypeError if an array is not of float64.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Pair {
    pub a: Shape,
    pub b: AnyShape,
    modulus_a: f64,
    modulus_b: Option<f64>,
    pub law: SurfaceLaw,
}

impl Pair {
    /// Both moduli; 1 stands for one that is not there, and does not matter.
    pub fn moduli_or_1(&self) -> [f64; 2] {
        [self.modulus_a, self.modulus_b.unwrap_or(1.0)]
    }

    /// The contact at two poses, with other moduli.
    pub fn at(
        &self,
        [pose_a, pose_b]: [Pose; 2],
        [modulus_a, modulus_b]: [f64; 2],
    ) -> PyResult<ContactPair<'_>> {
        let a = self.a.at(pose_a, modulus_a).map_err(value_error)?;
        let b = self.b.partner(pose_b, modulus_b).map_err(value_error)?;
        Ok(ContactPair::new(a, b))
    }

    /// The contact at two poses.
    fn at_poses(
        &self,
        pose_a: &Bound<'_, PyAny>,
        pose_b: &Bound<'_, PyAny>,
    ) -> PyResult<ContactPair<'_>> {
        let poses = [one(pose_a, "pose_a")?, one(pose_b, "pose_b")?];
        self.at(poses, self.moduli_or_1())
    }
}

/// Checks that B has a modulus unless it is rigid.
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

/// The numbers of both wrenches.
pub fn wrench_numbers(wrench: &ContactWrench) -> [f64; BOTH] {
    let [a, b] = [wrench.on_a.to_vector(), wrench.on_b.to_vector()];
    std::array::from_fn(|place| if place < 6 { a[place] } else { b[place - 6] })
}

/// Writes a block of columns of a Jacobian whose rows have so many numbers, from a column on.
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
            other => {
                return Err(PyTypeError::new_err(format!(
                    "a must be a compliant Shape, but is {}: pass the rigid body as b",
                    other.__repr__()
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

    /// The shapes A and B.
    #[getter]
    fn shapes(&self) -> (Shape, AnyShape) {
        (self.a.clone(), self.b.clone())
    }

    /// The hydroelastic moduli of A and B (Pa); the second is None where B is rigid.
    #[getter]
    fn moduli(&self) -> (f64, Option<f64>) {
        (self.modulus_a, self.modulus_b)
    }

    /// The surface law.
    #[getter]
    fn law(&self) -> SurfaceLaw {
        self.law
    }

    /// The wrenches: (12,) or (n, 12). Without twists those of bodies at rest; with them, dissipation and friction take part.
    ///
    /// moduli (2,) and law (2,), dissipation and friction, replace those of the pair; they may have n in front too.
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
        let found = inputs.found(py, self, BOTH, |at, row| {
            row.copy_from_slice(&wrench_numbers(&at.pair.wrench()));
        })?;
        found.array(py, 0, &[BOTH])
    }

    /// The wrenches of bodies at rest, (12,), and their Jacobian, (12, 14), in closed form; or n of each. Columns: pose of A
    /// (6), pose of B (6), modulus of A, modulus of B. Poses vary by twists in world axes, as moved_pose moves them.
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
        let found = inputs.found(py, self, BOTH * (1 + AT_REST), |at, row| {
            let contact = at.pair.linearized();
            let (wrenches, rows) = row.split_at_mut(BOTH);
            wrenches.copy_from_slice(&wrench_numbers(&contact.wrench));
            write_at_rest(rows, &contact);
        })?;
        let wrenches = found.array(py, 0, &[BOTH])?;
        Ok((wrenches, found.array(py, BOTH, &[BOTH, AT_REST])?))
    }

    /// The wrenches of moving bodies, (12,), and their Jacobian, (12, 28), in closed form; or n of each. Columns: pose of A (6),
    /// pose of B (6), twist of A (6), twist of B (6), modulus of A, modulus of B, dissipation, friction.
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
        let found = inputs.found(py, self, BOTH * (1 + IN_MOTION), |at, row| {
            let linearized = at.pair.linearized();
            let (wrenches, rows) = row.split_at_mut(BOTH);
            wrenches.copy_from_slice(&wrench_numbers(&linearized.wrench));
            write_in_motion(rows, &linearized);
        })?;
        let wrenches = found.array(py, 0, &[BOTH])?;
        Ok((wrenches, found.array(py, BOTH, &[BOTH, IN_MOTION])?))
    }

    /// Potential energy (J) of the contact, () or (n,): the wrench is minus its derivative. Takes much longer than the wrench.
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
        let found = inputs.found(py, self, 1, |at, row| row[0] = at.pair.potential_energy())?;
        let energies = found.array(py, 0, &[])?;
        // One energy is a number, as of numpy it would be an array of no dimension.
        match energies.ndim() {
            0 => energies.call_method0("item"),
            _ => Ok(energies.into_any()),
        }
    }

    /// The contact surface between two poses.
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

    /// Whether the bodies have passed so far into each other that contact may no longer push them apart: no contact surface is left,
    /// one is wholly inside the other, or each contains the middle of the other. A rod that pierces a body beside the point of
    /// highest pressure is not reported.
    fn has_sunk_through(
        &self,
        py: Python<'_>,
        pose_a: &Bound<'_, PyAny>,
        pose_b: &Bound<'_, PyAny>,
    ) -> PyResult<bool> {
        let pair = self.at_poses(pose_a, pose_b)?;
        Ok(py.detach(|| pair.has_sunk_through()))
    }

    /// Writes the contact surface between two poses for ParaView and its like, by the extension of the name: VTK XML (.vtp) or
    /// legacy (.vtk). Corners have the data pressure (Pa); polygons have pressure (the mean, Pa), area (m²) and normal.
    fn write_surface<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
    ) -> PyResult<()> {
        let surface = self.surface(py, pose_a, pose_b)?;
        py.import("hydroelastic._vtk")?
            .call_method1("write_surface", (path, surface))?;
        Ok(())
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
