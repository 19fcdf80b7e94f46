//! Derivatives of a contact by the shapes of its bodies.

use crate::any_shape::AnyShape;
use crate::arrays::{Floats, Whole, count, wholes};
use crate::errors::value_error;
use crate::pair::{BOTH, Pair, write_columns};
use crate::pair_inputs::Inputs;
use crate::shape_gradient::{self, ShapeGradient};
use hydroelastic::contact::BodyError;
use pyo3::prelude::*;

/// Numbers of the Jacobian by a vertex.
const BY_VERTEX: usize = 3 * BOTH;

impl Pair {
    /// How many vertices and extents A and B have.
    fn counts(&self) -> [[usize; 2]; 2] {
        let a = AnyShape::Compliant(self.a.clone());
        [shape_gradient::counts(&a), shape_gradient::counts(&self.b)]
    }

    fn check_vertices(&self, vertices: [&[usize]; 2]) -> PyResult<()> {
        for (vertices, [count, _]) in vertices.into_iter().zip(self.counts()) {
            if let Some(&vertex) = vertices.iter().find(|&&vertex| vertex >= count) {
                return Err(value_error(BodyError::Vertex { vertex, count }));
            }
        }
        Ok(())
    }
}

#[pymethods]
impl Pair {
    /// The derivatives of a number by the shapes of A and of B, from those by the wrenches, by_wrenches (12,) or (n, 12): a
    /// ShapeGradient each, in closed form, all vertices and extents at the cost of a Jacobian. Without twists of the wrenches of
    /// bodies at rest; with them, dissipation and friction take part. Where faces of both bodies are flush, derivatives by
    /// one vertex may be one-sided.
    #[pyo3(signature = (pose_a, pose_b, by_wrenches, twist_a=None, twist_b=None, *, moduli=None, law=None))]
    fn shape_gradients<'py>(
        &self,
        py: Python<'py>,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        by_wrenches: &Bound<'py, PyAny>,
        twist_a: Option<&Bound<'py, PyAny>>,
        twist_b: Option<&Bound<'py, PyAny>>,
        moduli: Option<&Bound<'py, PyAny>>,
        law: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(ShapeGradient, ShapeGradient)> {
        let (poses, twists) = ([pose_a, pose_b], [twist_a, twist_b]);
        let inputs = Inputs::of(self, poses, twists, moduli, law)?.with_covectors(by_wrenches)?;
        let counts = self.counts();
        let found = inputs.found(py, self, shape_gradient::width(counts), |at, row| {
            let gradients = at.pair.shape_gradients(&at.by_wrenches);
            shape_gradient::write(row, &gradients);
        })?;
        shape_gradient::both(py, &found, counts)
    }

    /// The Jacobians of both wrenches, (12,), by where some vertices of A and of B are, in the axes of their bodies' frames:
    /// (k, 12, 3) for the k vertices listed of A, and as many of B as are listed there; or n of each. Twists as of
    /// shape_gradients. A vertex takes as long as all.
    #[pyo3(signature = (pose_a, pose_b, vertices_a=vec![], vertices_b=vec![], twist_a=None, twist_b=None, *, moduli=None, law=None))]
    fn vertex_jacobians<'py>(
        &self,
        py: Python<'py>,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = wholes)] vertices_a: Vec<Whole>,
        #[pyo3(from_py_with = wholes)] vertices_b: Vec<Whole>,
        twist_a: Option<&Bound<'py, PyAny>>,
        twist_b: Option<&Bound<'py, PyAny>>,
        moduli: Option<&Bound<'py, PyAny>>,
        law: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let (poses, twists) = ([pose_a, pose_b], [twist_a, twist_b]);
        let inputs = Inputs::of(self, poses, twists, moduli, law)?;
        let indices = |vertices: &[Whole], name| {
            let indices = vertices.iter().map(|&vertex| count(vertex, name));
            indices.collect::<PyResult<Vec<_>>>()
        };
        let [vertices_a, vertices_b] = [
            indices(&vertices_a, "vertices_a")?,
            indices(&vertices_b, "vertices_b")?,
        ];
        let vertices = [&*vertices_a, &*vertices_b];
        self.check_vertices(vertices)?;
        let [of_a, of_b] = vertices.map(|it| it.len() * BY_VERTEX);
        let found = inputs.found(py, self, of_a + of_b, |at, row| {
            // The vertices have been checked.
            let Ok(jacobians) = at.pair.vertex_jacobians(vertices) else {
                return;
            };
            let jacobians = jacobians.iter().flatten();
            for (rows, jacobian) in row.chunks_mut(BY_VERTEX).zip(jacobians) {
                write_columns(rows, 3, 0, jacobian);
            }
        })?;
        let by_a = found.array(py, 0, &[vertices_a.len(), BOTH, 3])?;
        Ok((by_a, found.array(py, of_a, &[vertices_b.len(), BOTH, 3])?))
    }
}
