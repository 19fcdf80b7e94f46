//! Grids of taxels on the surfaces of bodies.

use crate::arrays::{
    Floats, Numbers, Whole, array, count, finite_row, numbers, real, whole, wrong_shape,
};
use crate::errors::value_error;
use crate::poses::{matrix, single_pose};
use hydroelastic::contact::{self, GridBody, TactileImage};
use hydroelastic::geometry::{Aabb, AffineField};
use hydroelastic::nalgebra::Vector3;
use hydroelastic::spatial::Pose;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// Grid of taxels on a patch of the surface of a body, fixed in the frame of the body. See Pair.tactile_image.
///
/// Planes divide space into H rows and W columns. A taxel is the intersection of a row and a column. It is unbounded along its normal, so
/// both faces of a thin plate are in the patch. Each taxel has its own axes: the first axis is normal to the middle of its column, the
/// third axis is the normal of the taxel, and the second axis completes a right-handed frame. The normal points out of the body if the z
/// axis of the frame of the patch does.
///
/// The constructor is for a patch with its own parametrization. A plane (a, b, c, d) is the set of points with a x + b y + c z + d = 0. The
/// normal (a, b, c) points towards higher columns or rows. Two planes between columns must not cross in the box from lower to upper, which
/// contains the patch. The same holds for two planes between rows.
///
/// Parameters
/// ----------
/// column_planes : (W + 1, 4) array_like
///     Planes between columns, in the frame of the body, in ascending order.
/// row_planes : (H + 1, 4) array_like
///     Planes between rows.
/// lower, upper : (3,) array_like
///     Corners (m) of the box.
///
/// Raises
/// ------
/// HydroelasticError
///     If planes cross in the box or are out of order, a column is parallel to a row, a plane has no normal, lower exceeds
///     upper, or a number is not finite.
#[pyclass(frozen, module = "hydroelastic")]
pub struct TaxelGrid {
    pub inner: contact::TaxelGrid,
    /// Name and arguments of the function that creates an equal grid.
    method: &'static str,
    arguments: Py<PyTuple>,
}

/// Function that creates a grid, and its arguments.
type Again<'py> = (Bound<'py, PyAny>, Py<PyTuple>);

impl TaxelGrid {
    fn of<
        'py,
        A: IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error = PyErr>,
    >(
        py: Python<'py>,
        inner: Result<contact::TaxelGrid, contact::TaxelGridError>,
        method: &'static str,
        arguments: A,
    ) -> PyResult<Self> {
        Ok(Self {
            inner: inner.map_err(value_error)?,
            method,
            arguments: arguments.into_pyobject(py)?.unbind(),
        })
    }

    /// Shape of an image: H, W and 3.
    pub fn shape(&self) -> [usize; 3] {
        [self.inner.row_count(), self.inner.column_count(), 3]
    }

    /// Writes the forces (N), or the mean tractions (Pa), on all taxels.
    pub fn write(&self, image: &TactileImage<'_>, is_mean: bool, numbers: &mut [f64]) {
        let columns = self.inner.column_count();
        for taxel in image.taxels() {
            let (row, column) = (taxel.row, taxel.column);
            let vector = if is_mean {
                image.mean_traction(row, column)
            } else {
                image.force(row, column)
            };
            let first = 3 * (row * columns + column);
            numbers[first..first + 3].copy_from_slice(vector.as_slice());
        }
    }
}

/// Returns the body of a pair with this name.
pub fn grid_body(name: &str) -> PyResult<GridBody> {
    match name {
        "a" => Ok(GridBody::A),
        "b" => Ok(GridBody::B),
        _ => Err(value_error(format!(
            "body must be \"a\" or \"b\", but is {name:?}"
        ))),
    }
}

fn frame_of(frame: Option<&Bound<'_, PyAny>>) -> PyResult<Pose> {
    frame.map_or_else(|| Ok(Pose::identity()), |frame| single_pose(frame, "frame"))
}

/// Reads planes (n, 4). A row has the normal, and the value at the origin.
fn planes(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<AffineField>> {
    let Numbers { values, shape } = numbers(argument, name)?;
    if shape.len() != 2 || shape[1] != 4 {
        return Err(wrong_shape(name, "(n, 4)", &shape));
    }
    let field = |plane: &[f64]| AffineField {
        gradient: Vector3::from_column_slice(&plane[..3]),
        offset: plane[3],
    };
    Ok(values.chunks(4).map(field).collect())
}

fn planes_array<'py>(py: Python<'py>, planes: &[AffineField]) -> PyResult<Floats<'py>> {
    let numbers = planes.iter().flat_map(|plane| {
        let normal = plane.gradient;
        [normal.x, normal.y, normal.z, plane.offset]
    });
    array(py, numbers.collect(), &[planes.len(), 4])
}

#[pymethods]
impl TaxelGrid {
    #[new]
    fn new(
        py: Python<'_>,
        column_planes: &Bound<'_, PyAny>,
        row_planes: &Bound<'_, PyAny>,
        lower: &Bound<'_, PyAny>,
        upper: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let columns = planes(column_planes, "column_planes")?;
        let rows = planes(row_planes, "row_planes")?;
        let [lower, upper] = [(lower, "lower"), (upper, "upper")]
            .map(|(argument, name)| finite_row::<3>(argument, name));
        let (lower, upper) = (lower?, upper?);
        let patch = Aabb {
            lower: lower.into(),
            upper: upper.into(),
        };
        let arguments = (
            planes_array(py, &columns)?,
            planes_array(py, &rows)?,
            lower,
            upper,
        );
        let inner = contact::TaxelGrid::new(&columns, &rows, &patch);
        Self::of(py, inner, "", arguments)
    }

    /// Creates a grid on a rectangle in the plane z = 0 of a frame. Columns follow each other along x, and rows along y. The axes of all
    /// taxels are those of the frame.
    ///
    /// Parameters
    /// ----------
    /// size : (2,) array_like
    ///     Lengths (m) along x and along y, positive. The rectangle is centered on the origin of the frame.
    /// columns, rows : int
    ///     Numbers of columns and rows, from 1 to 4096.
    /// frame : (4, 4) array_like, optional
    ///     Pose of the frame in the frame of the body. Default: the frame of the body.
    ///
    /// Returns
    /// -------
    /// TaxelGrid
    ///     Grid.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a length is not positive and finite, a number is out of range, or the frame is not rigid.
    #[staticmethod]
    #[pyo3(signature = (size, columns, rows, frame=None))]
    fn flat(
        py: Python<'_>,
        size: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = whole)] columns: Whole,
        #[pyo3(from_py_with = whole)] rows: Whole,
        frame: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (size, frame) = (finite_row::<2>(size, "size")?, frame_of(frame)?);
        let counts = [count(columns, "columns")?, count(rows, "rows")?];
        let inner = contact::TaxelGrid::flat(&frame, size, counts);
        Self::of(
            py,
            inner,
            "flat",
            (size, counts[0], counts[1], matrix(py, &frame)?),
        )
    }

    /// Creates a grid on a cylinder about the y axis of a frame.
    ///
    /// Columns are sectors of the angle from the z axis towards the x axis, and rows follow each other along y. The axes of a taxel are the
    /// circumferential direction, y, and the radial direction at the middle of its column.
    ///
    /// Parameters
    /// ----------
    /// angle : float
    ///     Total angle (rad) of all columns, less than π. The patch is centered on the z axis.
    /// length : float
    ///     Length (m) along y, positive. The patch is centered on the origin.
    /// columns, rows : int
    ///     Numbers of columns and rows, from 1 to 4096.
    /// frame : (4, 4) array_like, optional
    ///     Pose of the frame in the frame of the body. Default: the frame of the body.
    ///
    /// Returns
    /// -------
    /// TaxelGrid
    ///     Grid.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the angle is not between 0 and π, the length is not positive and finite, a number is out of range, or the frame is not rigid.
    #[staticmethod]
    #[pyo3(signature = (angle, length, columns, rows, frame=None))]
    fn cylindrical(
        py: Python<'_>,
        #[pyo3(from_py_with = real)] angle: f64,
        #[pyo3(from_py_with = real)] length: f64,
        #[pyo3(from_py_with = whole)] columns: Whole,
        #[pyo3(from_py_with = whole)] rows: Whole,
        frame: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let frame = frame_of(frame)?;
        let counts = [count(columns, "columns")?, count(rows, "rows")?];
        let inner = contact::TaxelGrid::cylindrical(&frame, angle, length, counts);
        let arguments = (angle, length, counts[0], counts[1], matrix(py, &frame)?);
        Self::of(py, inner, "cylindrical", arguments)
    }

    /// Creates a grid on a dome around the z axis of a frame, such as the cap of a fingertip with its center at the origin.
    ///
    /// Columns are sectors of the angle about the y axis, and rows are sectors of the angle about the x axis. The third axis of a taxel is
    /// the radial direction at its middle.
    ///
    /// Parameters
    /// ----------
    /// angles : (2,) array_like
    ///     Total angle (rad) of all columns, and total angle of all rows, less than π each. The patch is centered on the z axis.
    /// columns, rows : int
    ///     Numbers of columns and rows, from 1 to 4096.
    /// frame : (4, 4) array_like, optional
    ///     Pose of the frame in the frame of the body. Default: the frame of the body.
    ///
    /// Returns
    /// -------
    /// TaxelGrid
    ///     Grid.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an angle is not between 0 and π, a number is out of range, or the frame is not rigid.
    #[staticmethod]
    #[pyo3(signature = (angles, columns, rows, frame=None))]
    fn dome(
        py: Python<'_>,
        angles: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = whole)] columns: Whole,
        #[pyo3(from_py_with = whole)] rows: Whole,
        frame: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (angles, frame) = (finite_row::<2>(angles, "angles")?, frame_of(frame)?);
        let counts = [count(columns, "columns")?, count(rows, "rows")?];
        let inner = contact::TaxelGrid::dome(&frame, angles, counts);
        Self::of(
            py,
            inner,
            "dome",
            (angles, counts[0], counts[1], matrix(py, &frame)?),
        )
    }

    /// Number of columns, W.
    #[getter]
    fn columns(&self) -> usize {
        self.inner.column_count()
    }

    /// Number of rows, H.
    #[getter]
    fn rows(&self) -> usize {
        self.inner.row_count()
    }

    /// Axes of the taxels in the frame of the body, (H, W, 3, 3) float64. The columns of each matrix are two tangential directions and the
    /// normal.
    #[getter]
    fn axes<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let [rows, columns, _] = self.shape();
        let taxels = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        // nalgebra iterates over columns, and the array has the entries row by row.
        let entries = taxels.flat_map(|(row, column)| {
            let axes = self.inner.axes(row, column).transpose();
            let entries: [f64; 9] = std::array::from_fn(|entry| axes.as_slice()[entry]);
            entries
        });
        array(py, entries.collect(), &[rows, columns, 3, 3])
    }

    pub fn __repr__(&self) -> String {
        let [rows, columns, _] = self.shape();
        format!("TaxelGrid({columns} columns, {rows} rows)")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Again<'py>> {
        let class = py.get_type::<Self>().into_any();
        let function = match self.method {
            "" => class,
            method => class.getattr(method)?,
        };
        Ok((function, self.arguments.clone_ref(py)))
    }
}
