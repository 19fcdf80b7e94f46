//! Derivatives of a contact with respect to the shapes of its bodies.

use crate::any_shape::AnyShape;
use crate::arrays::{Floats, Whole, check_finite, count, numbers_of_shape, wholes};
use crate::errors::value_error;
use crate::pair::{BOTH, Pair, write_columns};
use crate::pair_inputs::Inputs;
use crate::shape_gradient::{self, ShapeGradient};
use crate::taxel_grid::{TaxelGrid, grid_body};
use hydroelastic::contact::BodyError;
use hydroelastic::nalgebra::Vector3;
use pyo3::prelude::*;

/// Number of entries of the Jacobian with respect to one vertex.
const BY_VERTEX: usize = 3 * BOTH;

impl Pair {
    /// Numbers of vertices and of extents of A and B.
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
    /// Computes the gradients of a loss with respect to the shapes of A and B, in closed form.
    ///
    /// The gradients with respect to all vertices and extents cost as much as a Jacobian. Without twists, the bodies are at rest. With a
    /// twist, the wrenches include dissipation and friction. If faces of both bodies are flush, derivatives with respect to one vertex may
    /// be one-sided.
    ///
    /// Parameters
    /// ----------
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// by_wrenches : (12,) or (n, 12) array_like
    ///     Derivatives of the loss with respect to the wrenches.
    /// twist_a, twist_b : (6,) or (n, 6) array_like, optional
    ///     Twists of A and B. If one is given, the other is zero by default.
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair.
    /// law : (2,) or (n, 2) array_like, optional
    ///     Dissipation (s/m) and friction coefficient in place of those of the pair.
    ///
    /// Returns
    /// -------
    /// gradient_a, gradient_b : ShapeGradient
    ///     Gradients with respect to the shapes of A and B.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument or a result is not valid, as in the class description.
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
        let results = inputs.compute(py, self, shape_gradient::width(counts), |at, row| {
            let gradients = at.pair.shape_gradients(&at.by_wrenches);
            shape_gradient::write(row, &gradients);
        })?;
        shape_gradient::both(py, &results, counts)
    }

    /// Computes the gradients of a loss with respect to the shapes of A and B from its gradient with respect to a tactile image.
    ///
    /// The grid does not move with the vertices. The gradients with respect to all vertices and extents are in closed form. Twists have the
    /// same meaning as in shape_gradients.
    ///
    /// Parameters
    /// ----------
    /// grid : TaxelGrid
    ///     Grid of H rows and W columns.
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// by_forces : (H, W, 3) or (n, H, W, 3) array_like
    ///     Derivatives of the loss with respect to the forces of tactile_image.
    /// twist_a, twist_b : (6,) or (n, 6) array_like, optional
    ///     Twists of A and B. If one is given, the other is zero by default.
    /// body : str, optional
    ///     Body of the grid, "a" or "b". Default: "a".
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair.
    /// law : (2,) or (n, 2) array_like, optional
    ///     Dissipation (s/m) and friction coefficient in place of those of the pair.
    ///
    /// Returns
    /// -------
    /// gradient_a, gradient_b : ShapeGradient
    ///     Gradients with respect to the shapes of A and B.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument or a result is not valid, as in the class description.
    #[pyo3(signature = (grid, pose_a, pose_b, by_forces, twist_a=None, twist_b=None, *, body="a", moduli=None, law=None))]
    fn tactile_shape_gradients<'py>(
        &self,
        py: Python<'py>,
        grid: &TaxelGrid,
        pose_a: &Bound<'py, PyAny>,
        pose_b: &Bound<'py, PyAny>,
        by_forces: &Bound<'py, PyAny>,
        twist_a: Option<&Bound<'py, PyAny>>,
        twist_b: Option<&Bound<'py, PyAny>>,
        body: &str,
        moduli: Option<&Bound<'py, PyAny>>,
        law: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(ShapeGradient, ShapeGradient)> {
        let inputs = Inputs::of(self, [pose_a, pose_b], [twist_a, twist_b], moduli, law)?;
        let (body, [rows, columns, _]) = (grid_body(body)?, grid.shape());
        let batch = inputs.count()?.into_iter();
        let shape: Vec<usize> = batch.chain(grid.shape()).collect();
        let by_forces = numbers_of_shape(by_forces, "by_forces", &shape)?;
        check_finite(&by_forces, "by_forces")?;
        let counts = self.counts();
        let results = inputs.compute(py, self, shape_gradient::width(counts), |at, numbers| {
            let by_force = |row: usize, column: usize| {
                let first = 3 * ((at.index * rows + row) * columns + column);
                Vector3::from_column_slice(&by_forces[first..first + 3])
            };
            let gradients = at.pair.tactile_shape_gradients(body, &grid.inner, by_force);
            shape_gradient::write(numbers, &gradients);
        })?;
        shape_gradient::both(py, &results, counts)
    }

    /// Computes the Jacobians of both wrenches with respect to the positions of vertices.
    ///
    /// One vertex costs as much as all vertices. Twists have the same meaning as in shape_gradients.
    ///
    /// Parameters
    /// ----------
    /// pose_a, pose_b : (4, 4) or (n, 4, 4) array_like
    ///     Poses of A and B in the world.
    /// vertices_a, vertices_b : (k,) array_like of int
    ///     Indices of vertices of A and B. Default: no vertices.
    /// twist_a, twist_b : (6,) or (n, 6) array_like, optional
    ///     Twists of A and B. If one is given, the other is zero by default.
    /// moduli : (2,) or (n, 2) array_like, optional
    ///     Moduli (Pa) in place of the moduli of the pair.
    /// law : (2,) or (n, 2) array_like, optional
    ///     Dissipation (s/m) and friction coefficient in place of those of the pair.
    ///
    /// Returns
    /// -------
    /// by_vertices_a, by_vertices_b : (k, 12, 3) or (n, k, 12, 3) ndarray of float64
    ///     Derivatives of the wrenches with respect to the k listed vertices of A, and to the listed vertices of B. Positions are in the
    ///     body frame.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a vertex does not exist, or an argument or a result is not valid, as in the class description.
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
        let [of_a, of_b] = vertices.map(|list| list.len() * BY_VERTEX);
        let results = inputs.compute(py, self, of_a + of_b, |at, row| {
            // The vertices have been checked.
            let Ok(jacobians) = at.pair.vertex_jacobians(vertices) else {
                return;
            };
            let jacobians = jacobians.iter().flatten();
            for (rows, jacobian) in row.chunks_mut(BY_VERTEX).zip(jacobians) {
                write_columns(rows, 3, 0, jacobian);
            }
        })?;
        let by_a = results.array(py, 0, &[vertices_a.len(), BOTH, 3])?;
        Ok((by_a, results.array(py, of_a, &[vertices_b.len(), BOTH, 3])?))
    }
}
