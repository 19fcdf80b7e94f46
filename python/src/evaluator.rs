//! Evaluator of a fit in Python, for example on a cluster.

use crate::fit::Checkpoint;
use crate::pickle::loaded;
use hydroelastic::identification::{self, Equations, Evaluated, Evaluator, IdentificationError};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex};

/// Exception of a Python function that is called during a fit.
pub type Raised = Arc<Mutex<Option<PyErr>>>;

/// Evaluator with the methods costs and equations of a Python object.
pub struct PythonEvaluator {
    pub evaluator: Py<PyAny>,
    pub raised: Raised,
}

impl Evaluator for PythonEvaluator {
    fn costs(&self, point: &identification::Checkpoint, measurements: &[usize]) -> Evaluated<f64> {
        self.results("costs", point, measurements, |cost| cost.extract())
    }

    fn equations(
        &self,
        point: &identification::Checkpoint,
        measurements: &[usize],
    ) -> Evaluated<Equations> {
        self.results("equations", point, measurements, |saved| {
            loaded(saved.extract()?)
        })
    }
}

impl PythonEvaluator {
    /// Calls a method of the evaluator and converts its results. A string is the error of one measurement. An exception is stored, and ends
    /// the fit.
    fn results<V>(
        &self,
        method: &str,
        point: &identification::Checkpoint,
        measurements: &[usize],
        read: impl Fn(&Bound<'_, PyAny>) -> PyResult<V>,
    ) -> Evaluated<V> {
        let results = Python::attach(|py| {
            let arguments = (Checkpoint(point.clone()), measurements.to_vec());
            let results = self.evaluator.call_method1(py, method, arguments)?;
            let result = |result: PyResult<Bound<'_, PyAny>>| {
                let result = result?;
                match result.extract::<String>() {
                    Ok(text) => Ok(Err(IdentificationError::Evaluation(text))),
                    Err(_) => read(&result).map(Ok),
                }
            };
            let results = results.bind(py).try_iter()?;
            results.map(result).collect::<PyResult<Vec<_>>>()
        });
        results.map_err(|exception| {
            let text = exception.to_string();
            store(&self.raised, exception);
            IdentificationError::Evaluation(text)
        })
    }
}

/// Stores an exception, which is raised after the fit.
pub fn store(raised: &Mutex<Option<PyErr>>, exception: PyErr) {
    if let Ok(mut raised) = raised.lock() {
        *raised = Some(exception);
    }
}
