//! Conversion of Python lists to vectors.

use pyo3::CastIntoError;
use pyo3::PyClass;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

/// Converts an argument to a list of objects of a class.
pub fn list_of<'py, T: PyClass>(argument: &Bound<'py, PyAny>) -> PyResult<Vec<Bound<'py, T>>> {
    let kind = argument.py().get_type::<T>().name()?;
    let type_error = |actual: String| {
        PyTypeError::new_err(format!("a list of {kind} is expected, but {actual}"))
    };
    if argument.is_instance_of::<T>() {
        return Err(type_error(format!(
            "the argument is a single {kind}: put it into a list"
        )));
    }
    let items = argument.extract::<Vec<Bound<'py, PyAny>>>();
    let items =
        items.map_err(|_| type_error(format!("the argument is {}", argument.get_type())))?;
    let item = |(index, item): (usize, Bound<'py, PyAny>)| {
        let item = item.cast_into::<T>().map_err(CastIntoError::into_inner);
        item.map_err(|item| type_error(format!("the item at index {index} is {}", item.get_type())))
    };
    items.into_iter().enumerate().map(item).collect()
}

/// Converts an argument to a list of objects of a class, or None.
pub fn optional_list_of<'py, T: PyClass>(
    argument: &Bound<'py, PyAny>,
) -> PyResult<Option<Vec<Bound<'py, T>>>> {
    if argument.is_none() {
        return Ok(None);
    }
    list_of(argument).map(Some)
}

/// Converts an argument to a list of names.
pub fn names(argument: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    if let Ok(name) = argument.extract::<String>() {
        return Err(PyTypeError::new_err(format!(
            "a list of names is expected, but the argument is the name {name:?}: put it into a list"
        )));
    }
    argument.extract()
}
