//! Gradients with respect to the shapes of a contact.

use crate::any_shape::AnyShape;
use crate::arrays::{Floats, check_finite, check_kept, finite, finite_row, table, wrong_shape};
use crate::errors::value_error;
use crate::pair_inputs::Results;
use crate::shape_rates::ShapeRates;
use hydroelastic::contact;
use hydroelastic::nalgebra::{Matrix3, Vector3};
use hydroelastic::spatial::MassGradient;
use numpy::{PyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// Gradient of a loss with respect to the shape of a body.
///
/// Vertices move in the body frame, while the pose, the modulus and all extents stay fixed. The chain rule gives derivatives with
/// respect to the numbers that define a shape: see along and LinearizedShape.pullback. Each array of a batch of n contacts has an
/// additional first axis of length n.
///
/// Parameters
/// ----------
/// by_vertices : (v, 3) or (n, v, 3) ndarray of float64
///     Derivatives with respect to the vertices.
/// by_extents : (v,) or (n, v) ndarray of float64
///     Derivatives with respect to the extents.
///
/// Raises
/// ------
/// HydroelasticError
///     If an array has an unexpected shape, or a number is not finite.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct ShapeGradient {
    /// Derivatives (1/m) with respect to the v vertices, in the axes of the body frame, (v, 3) or (n, v, 3) float64. A half-space has no
    /// vertices, so v is 0.
    by_vertices: Py<PyArrayDyn<f64>>,
    /// Derivatives with respect to the extents of the vertices, (v,) or (n, v) float64. The array is empty for a rigid shape and for a
    /// half-space.
    by_extents: Py<PyArrayDyn<f64>>,
}

#[pymethods]
impl ShapeGradient {
    #[new]
    fn new(
        py: Python<'_>,
        by_vertices: Py<PyArrayDyn<f64>>,
        by_extents: Py<PyArrayDyn<f64>>,
    ) -> PyResult<Self> {
        // A rigid body has no extents.
        let rigid = by_extents.bind(py).shape().last() == Some(&0);
        let axes: &[&str] = if rigid { &["n?", "0"] } else { &["n?", "v"] };
        let by_vertices_axes: &[&str] = &["n?", "v", "3"];
        check_kept(
            py,
            &[
                (&by_vertices, "by_vertices", by_vertices_axes),
                (&by_extents, "by_extents", axes),
            ],
        )?;
        Ok(Self {
            by_vertices,
            by_extents,
        })
    }

    /// Applies the chain rule: computes derivatives with respect to the numbers that define the shape, such as the radius of a ball.
    ///
    /// Parameters
    /// ----------
    /// rates : ShapeRates
    ///     Rates of the same shape with respect to one number or to k numbers.
    ///
    /// Returns
    /// -------
    /// (), (k,), (n,) or (n, k) ndarray of float64
    ///     Derivatives of the loss with respect to the numbers.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the rates have another number of vertices.
    fn along<'py>(
        &self,
        py: Python<'py>,
        rates: &Bound<'py, ShapeRates>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rates = rates.get();
        let numpy = py.import("numpy")?;
        let shape = |array: &Py<PyArrayDyn<f64>>| array.bind(py).shape().to_vec();
        let (expected, of_rates) = (shape(&self.by_vertices), shape(&rates.vertices));
        if expected.len() < 2
            || expected[expected.len() - 2..] != of_rates[of_rates.len().saturating_sub(2)..]
        {
            return Err(wrong_shape(
                "the vertices of the rates",
                &of_shape(&expected),
                &of_rates,
            ));
        }
        // The sums are over the vertices and their coordinates, and over the extents, which are the last axes.
        let sum =
            |gradient: &Py<PyArrayDyn<f64>>, rates: &Py<PyArrayDyn<f64>>, axes: [&[i64]; 2]| {
                let axes = (axes[0].to_vec(), axes[1].to_vec());
                numpy.call_method1("tensordot", (gradient.bind(py), rates.bind(py), axes))
            };
        let last: &[i64] = &[-2, -1];
        let by_vertices = sum(&self.by_vertices, &rates.vertices, [last, last])?;
        if shape(&self.by_extents).last() == Some(&0) {
            return Ok(by_vertices);
        }
        by_vertices.add(sum(&self.by_extents, &rates.extents, [&[-1], &[-1]])?)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape = |array: &Py<PyArrayDyn<f64>>| {
            array
                .bind(py)
                .getattr("shape")?
                .repr()
                .map(|representation| representation.to_string())
        };
        Ok(format!(
            "ShapeGradient(by_vertices {}, by_extents {})",
            shape(&self.by_vertices)?,
            shape(&self.by_extents)?
        ))
    }

    fn __getnewargs__(&self, py: Python<'_>) -> (Py<PyArrayDyn<f64>>, Py<PyArrayDyn<f64>>) {
        (
            self.by_vertices.clone_ref(py),
            self.by_extents.clone_ref(py),
        )
    }
}

/// Describes the expected shape of the vertices of rates, from the shape of the derivatives with respect to vertices.
fn of_shape(by_vertices: &[usize]) -> String {
    let vertices = by_vertices.iter().rev().nth(1).copied().unwrap_or(0);
    format!("({vertices}, 3) or (k, {vertices}, 3)")
}

/// Numbers of vertices and of extents of a shape.
pub fn counts(shape: &AnyShape) -> [usize; 2] {
    match shape {
        AnyShape::Compliant(shape) => [shape.0.field().mesh().vertex_count(); 2],
        AnyShape::Rigid(shape) => [shape.0.surface().vertices().len(), 0],
        AnyShape::HalfSpace(_) => [0; 2],
    }
}

/// Number of components of both gradients.
pub fn width(counts: [[usize; 2]; 2]) -> usize {
    let of_body = |[vertices, extents]: [usize; 2]| 3 * vertices + extents;
    counts.into_iter().map(of_body).sum()
}

/// Writes all components of both gradients.
pub fn write(row: &mut [f64], gradients: &[contact::ShapeGradient; 2]) {
    let numbers = gradients.iter().flat_map(|gradient| {
        let by_vertices = gradient.by_vertices.iter().flatten();
        by_vertices.chain(&gradient.by_extents)
    });
    for (entry, number) in row.iter_mut().zip(numbers) {
        *entry = *number;
    }
}

/// Converts the components of all contacts to both gradients.
pub fn both(
    py: Python<'_>,
    results: &Results,
    counts: [[usize; 2]; 2],
) -> PyResult<(ShapeGradient, ShapeGradient)> {
    let mut first = 0;
    let mut next = |shape: &[usize]| -> PyResult<Floats<'_>> {
        let array = results.array(py, first, shape);
        first += shape.iter().product::<usize>();
        array
    };
    let mut gradient = |[vertices, extents]: [usize; 2]| {
        PyResult::Ok(ShapeGradient {
            by_vertices: next(&[vertices, 3])?.unbind(),
            by_extents: next(&[extents])?.unbind(),
        })
    };
    let [a, b] = counts;
    Ok((gradient(a)?, gradient(b)?))
}

/// Reads the gradient of a loss with respect to mass properties.
pub fn mass_gradient(
    by_mass: f64,
    by_center: &Bound<'_, PyAny>,
    by_inertia: &Bound<'_, PyAny>,
) -> PyResult<MassGradient> {
    let rows = table::<3>(by_inertia, "by_inertia")?;
    check_finite(rows.as_flattened(), "by_inertia")?;
    let [x, y, z] = rows[..] else {
        let message = format!(
            "by_inertia must have the shape (3, 3), but has ({}, 3)",
            rows.len()
        );
        return Err(value_error(message));
    };
    Ok(MassGradient {
        by_mass: finite(by_mass, "by_mass")?,
        by_center_of_mass: Vector3::from(finite_row::<3>(by_center, "by_center")?),
        by_inertia: Matrix3::from([x, y, z]).transpose(),
    })
}
