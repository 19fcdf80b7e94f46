//! Checked conversion of Python arguments to numbers, and conversion of results to NumPy arrays.

use crate::errors::value_error;
use numpy::ndarray::{Array, Array2, ArrayView2, IxDyn};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods,
    PyUntypedArray, PyUntypedArrayMethods, ToPyArray,
};
use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PySlice, PyString, PyTuple};
use std::collections::BTreeMap;
use std::ops::Range;

/// Array of `float64` that is returned to Python.
pub type Floats<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Numbers of an argument in C order, and the shape of the argument.
pub struct Numbers {
    pub values: Vec<f64>,
    pub shape: Vec<usize>,
}

/// Reads the numbers of an argument: an array of integers or of floats of up to 64 bits, or a list or tuple, which may be nested.
/// `name` is the name of the argument in error messages.
pub fn numbers(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Numbers> {
    if let Ok(array) = argument.cast::<PyArrayDyn<f64>>() {
        let shape = array.shape().to_vec();
        let view = array.try_readonly().map_err(value_error)?;
        let values = match view.as_slice() {
            // The slice of an array in Fortran order is column by column.
            Ok(slice) if array.is_c_contiguous() => slice.to_vec(),
            _ => view.as_array().iter().copied().collect(),
        };
        return Ok(Numbers { values, shape });
    }
    let is_list = argument.is_instance_of::<PyList>() || argument.is_instance_of::<PyTuple>();
    let array = if is_list {
        let numpy = argument.py().import("numpy")?;
        let array = numpy.call_method1("asarray", (argument,));
        array.map_err(|_| not_numbers(argument, name))?
    } else {
        argument.clone()
    };
    let Ok(untyped) = array.cast::<PyUntypedArray>() else {
        return Err(not_numbers(argument, name));
    };
    match untyped.dtype().kind() {
        b'i' | b'u' => numbers(&array.call_method1("astype", ("float64",))?, name),
        b'f' if untyped.dtype().itemsize() <= size_of::<f64>() => {
            numbers(&array.call_method1("astype", ("float64",))?, name)
        }
        _ => Err(not_numbers(&array, name)),
    }
}

/// Reads the numbers of an argument that must have the expected shape.
pub fn numbers_of_shape(
    argument: &Bound<'_, PyAny>,
    name: &str,
    expected: &[usize],
) -> PyResult<Vec<f64>> {
    let Numbers { values, shape } = numbers(argument, name)?;
    if shape == expected {
        return Ok(values);
    }
    let sizes: Vec<String> = expected.iter().map(usize::to_string).collect();
    let expected = format!("({})", sizes.join(", "));
    Err(wrong_shape(name, &expected, &shape))
}

/// Creates the exception for an argument that cannot be converted to `float64` without a loss.
fn not_numbers(argument: &Bound<'_, PyAny>, name: &str) -> PyErr {
    let actual = match argument.cast::<PyUntypedArray>() {
        Ok(array) => match array.dtype().kind() {
            b'b' | b'f' => format!(
                "an array of {} (array.astype(numpy.float64) converts it)",
                array.dtype()
            ),
            _ => format!("an array of {}", array.dtype()),
        },
        Err(_) if argument.is_instance_of::<PyList>() || argument.is_instance_of::<PyTuple>() => {
            "a list whose rows are not of equal length".to_owned()
        }
        Err(_) if argument.hasattr("__array__").unwrap_or(false) => {
            format!("{} (numpy.asarray converts it)", argument.get_type())
        }
        Err(_) => argument.get_type().to_string(),
    };
    PyTypeError::new_err(format!(
        "{name} must be a numpy array of floats of up to 64 bits or of integers, or a list of numbers, but is {actual}"
    ))
}

/// Checks that numbers are finite.
pub fn check_finite(values: &[f64], name: &str) -> PyResult<()> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(value_error(format!(
            "{name} must be finite, but number {index}, counted from 0, is {}",
            values[index]
        ))),
    }
}

/// Returns a number, or an error if it is not finite.
pub fn finite(value: f64, name: &str) -> PyResult<f64> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(value_error(format!(
        "{name} must be finite, but is {value}"
    )))
}

/// Converts an argument to a number. Booleans and integers beyond float64 are errors.
pub fn real(argument: &Bound<'_, PyAny>) -> PyResult<f64> {
    extracted(argument)
}

/// Converts an argument to a number, or None.
pub fn optional_real(argument: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    if argument.is_none() {
        return Ok(None);
    }
    real(argument).map(Some)
}

/// Reads a number. `name` is the name of the number in error messages.
pub fn named_real(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    real(argument).map_err(|error| {
        if error.is_instance_of::<PyTypeError>(argument.py()) {
            let kind = argument.get_type();
            return PyTypeError::new_err(format!("{name} must be a number, but is {kind}"));
        }
        error
    })
}

/// Reads a sequence of N parts. `name` is the name of the sequence in error messages, and `expected` describes its parts.
pub fn parts<'py, const N: usize>(
    argument: &Bound<'py, PyAny>,
    name: &str,
    expected: &str,
) -> PyResult<[Bound<'py, PyAny>; N]> {
    let items = argument.try_iter();
    let items = items.and_then(Iterator::collect::<PyResult<Vec<_>>>);
    let is_sequence =
        !argument.is_instance_of::<PyString>() && !argument.is_instance_of::<PyDict>();
    let Some(items) = items.ok().filter(|_| is_sequence) else {
        let kind = argument.get_type();
        return Err(PyTypeError::new_err(format!(
            "{name} must be {expected}, but is {kind}"
        )));
    };
    let count = items.len();
    <[_; N]>::try_from(items)
        .map_err(|_| value_error(format!("{name} must be {expected}, but has {count} parts")))
}

/// Converts an argument to pairs of names of bodies, or None.
pub fn name_pairs(argument: &Bound<'_, PyAny>) -> PyResult<Option<Vec<(String, String)>>> {
    let items: Option<Vec<Bound<'_, PyAny>>> = argument.extract()?;
    let pair = |item: Bound<'_, PyAny>| {
        let [first, second] = parts(&item, "an item of ignoring", "two names of bodies")?;
        Ok((first.extract()?, second.extract()?))
    };
    items
        .map(|items| items.into_iter().map(pair).collect())
        .transpose()
}

/// Converts an argument to an integer. Booleans and integers beyond 128 bits are errors.
pub fn whole(argument: &Bound<'_, PyAny>) -> PyResult<Whole> {
    extracted(argument)
}

/// Converts an argument to an integer, or None.
pub fn optional_whole(argument: &Bound<'_, PyAny>) -> PyResult<Option<Whole>> {
    if argument.is_none() {
        return Ok(None);
    }
    whole(argument).map(Some)
}

/// Converts an argument to a list of integers.
pub fn wholes(argument: &Bound<'_, PyAny>) -> PyResult<Vec<Whole>> {
    argument.try_iter()?.map(|item| whole(&item?)).collect()
}

fn extracted<'py, T>(argument: &Bound<'py, PyAny>) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py, Error = PyErr>,
{
    if argument.extract::<bool>().is_ok() {
        return Err(PyTypeError::new_err(
            "a number is expected, but the argument is a bool",
        ));
    }
    argument.extract().map_err(|error: PyErr| {
        if error.is_instance_of::<PyOverflowError>(argument.py()) {
            return value_error("an integer argument is too large");
        }
        error
    })
}

/// An integer argument, before [`count`] checks its range.
pub type Whole = i128;

/// Returns an integer, or an error if it is negative or too large.
pub fn count(value: Whole, name: &str) -> PyResult<usize> {
    match usize::try_from(value) {
        Ok(count) if isize::try_from(count).is_ok() => Ok(count),
        _ => Err(value_error(format!(
            "{name} must be from 0 to {}, but is {value}",
            isize::MAX
        ))),
    }
}

/// Returns an integer, or an error if it is below 1 or too large.
pub fn positive_count(value: Whole, name: &str) -> PyResult<usize> {
    match count(value, name)? {
        0 => Err(value_error(format!("{name} must be at least 1, but is 0"))),
        count => Ok(count),
    }
}

/// Array that a class stores, the name of its argument, and its axes. An axis is a size or a letter. Equal letters stand for equal
/// sizes. A first axis with a question mark is optional.
pub type Kept<'a> = (&'a Py<PyArrayDyn<f64>>, &'a str, &'static [&'static str]);

/// Checks that the arrays that a class stores are finite, and that their shapes match.
pub fn check_kept(py: Python<'_>, arrays: &[Kept<'_>]) -> PyResult<()> {
    let mut sizes: BTreeMap<&'static str, usize> = BTreeMap::new();
    for (array, name, axes) in arrays {
        let Numbers { values, shape } = numbers(array.bind(py), name)?;
        let is_short = axes[0].ends_with('?') && shape.len() + 1 == axes.len();
        let present = &axes[usize::from(is_short)..];
        let mut pairs = present.iter().zip(&shape);
        let mut known = |axis: &'static str, size| {
            axis.parse()
                .unwrap_or_else(|_| *sizes.entry(axis).or_insert(size))
        };
        let fits =
            present.len() == shape.len() && pairs.all(|(axis, &size)| known(axis, size) == size);
        if !fits {
            let shown = axes.iter().map(|axis| match sizes.get(axis) {
                Some(size) => size.to_string(),
                None => (*axis).to_owned(),
            });
            let shown: Vec<String> = shown.collect();
            return Err(wrong_shape(
                name,
                &format!("({})", shown.join(", ")),
                &shape,
            ));
        }
        check_finite(&values, name)?;
    }
    Ok(())
}

/// Creates the exception for an array of an unexpected shape.
pub fn wrong_shape(name: &str, expected: &str, shape: &[usize]) -> PyErr {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    let comma = if lengths.len() == 1 { "," } else { "" };
    value_error(format!(
        "{name} must have the shape {expected}, but has ({}{comma})",
        lengths.join(", ")
    ))
}

/// One value for all items, or one value for each item of a batch.
pub enum Many<T> {
    One(T),
    Each(Vec<T>),
}

impl<T> Many<T> {
    /// Value of an item.
    pub fn at(&self, item: usize) -> &T {
        match self {
            Self::One(value) => value,
            Self::Each(values) => &values[item],
        }
    }

    /// Number of items of a batch; `None` if all items share one value.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::One(_) => None,
            Self::Each(values) => Some(values.len()),
        }
    }

    /// Converts each value. The error of a value in a batch names the index of the value.
    pub fn mapped<U>(&self, name: &str, value: impl Fn(&T) -> PyResult<U>) -> PyResult<Many<U>> {
        match self {
            Self::One(single) => Ok(Many::One(value(single)?)),
            Self::Each(values) => {
                let mapped = |(item, item_value): (usize, &T)| {
                    value(item_value)
                        .map_err(|error| named_error(&format!("{name}[{item}]"), &error))
                };
                values
                    .iter()
                    .enumerate()
                    .map(mapped)
                    .collect::<PyResult<_>>()
                    .map(Many::Each)
            }
        }
    }
}

fn message(error: &PyErr) -> String {
    Python::attach(|py| error.value(py).to_string())
}

/// Adds the name of an argument to the error of its value.
pub fn named_error(name: &str, error: &PyErr) -> PyErr {
    value_error(format!("{name}: {}", message(error)))
}

/// Reads a one-dimensional `float64` array of `N` numbers. This is a fast path for the most frequent arguments.
fn short_row<const N: usize>(argument: &Bound<'_, PyAny>) -> Option<[f64; N]> {
    let array = argument.cast::<PyArray1<f64>>().ok()?;
    let mut values = [0.0; N];
    if array.len() != N {
        return None;
    }
    for (index, value) in values.iter_mut().enumerate() {
        *value = array.get_owned(index)?;
    }
    Some(values)
}

/// Reads the entries of a 4×4 `float64` array, row by row.
pub fn short_matrix(argument: &Bound<'_, PyAny>) -> Option<[f64; 16]> {
    let array = argument.cast::<PyArray2<f64>>().ok()?;
    let mut values = [0.0; 16];
    if array.shape() != [4, 4] {
        return None;
    }
    for (index, value) in values.iter_mut().enumerate() {
        *value = array.get_owned([index / 4, index % 4])?;
    }
    Some(values)
}

/// Reads one row of `N` numbers, or n rows.
pub fn rows<const N: usize>(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Many<[f64; N]>> {
    if let Some(row) = short_row(argument) {
        return Ok(Many::One(row));
    }
    let Numbers { values, shape } = numbers(argument, name)?;
    match shape[..] {
        [length] if length == N => Ok(Many::One(chunk(&values))),
        [_, length] if length == N => Ok(Many::Each(values.chunks(N).map(chunk).collect())),
        _ => Err(wrong_shape(name, &format!("({N},) or (n, {N})"), &shape)),
    }
}

/// Reads an array of n rows of `N` numbers.
pub fn table<const N: usize>(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<[f64; N]>> {
    let Numbers { values, shape } = numbers(argument, name)?;
    match shape[..] {
        [_, length] if length == N => Ok(values.chunks(N).map(chunk).collect()),
        _ => Err(wrong_shape(name, &format!("(n, {N})"), &shape)),
    }
}

/// Reads a row of `N` numbers.
pub fn row<const N: usize>(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; N]> {
    let Numbers { values, shape } = numbers(argument, name)?;
    match shape[..] {
        [length] if length == N => Ok(chunk(&values)),
        _ => Err(wrong_shape(name, &format!("({N},)"), &shape)),
    }
}

/// Returns `N` numbers, or an error if one is not finite.
pub fn finite_row<const N: usize>(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; N]> {
    let values = row(argument, name)?;
    check_finite(&values, name)?;
    Ok(values)
}

/// Reads a one-dimensional array.
pub fn list(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<f64>> {
    let Numbers { values, shape } = numbers(argument, name)?;
    match shape.len() {
        1 => Ok(values),
        _ => Err(wrong_shape(name, "(n,)", &shape)),
    }
}

/// Reads n rows of `N` indices, of any integer type. Indices start at 0.
pub fn indices<const N: usize>(
    argument: &Bound<'_, PyAny>,
    name: &str,
) -> PyResult<Vec<[usize; N]>> {
    let is_list = argument.is_instance_of::<PyList>() || argument.is_instance_of::<PyTuple>();
    let argument = if is_list {
        let numpy = argument.py().import("numpy")?;
        numpy
            .call_method1("asarray", (argument,))
            .unwrap_or_else(|_| argument.clone())
    } else {
        argument.clone()
    };
    let array = argument.call_method1("astype", ("int64",)).ok();
    let kind = argument
        .getattr("dtype")
        .and_then(|dtype| dtype.getattr("kind"));
    let is_whole =
        kind.is_ok_and(|kind| kind.eq("i").unwrap_or(false) || kind.eq("u").unwrap_or(false));
    let array = array.filter(|_| is_whole).ok_or_else(|| {
        PyTypeError::new_err(format!(
            "{name} must be a numpy array of integers, or a list of rows of them"
        ))
    })?;
    let array = array.cast_into::<PyArrayDyn<i64>>()?;
    let shape = array.shape().to_vec();
    if shape.len() != 2 || shape[1] != N {
        return Err(wrong_shape(name, &format!("(n, {N})"), &shape));
    }
    let whole = |&index: &i64| {
        usize::try_from(index).map_err(|_| {
            value_error(format!(
                "{name} has the index {index}, but indices count from 0"
            ))
        })
    };
    let values = array
        .readonly()
        .as_array()
        .iter()
        .map(whole)
        .collect::<PyResult<Vec<_>>>()?;
    Ok(values
        .chunks(N)
        .map(|row| std::array::from_fn(|column| row[column]))
        .collect())
}

/// Copies the first `N` numbers of a slice, which has at least `N`.
fn chunk<const N: usize>(values: &[f64]) -> [f64; N] {
    std::array::from_fn(|index| values[index])
}

/// Creates an array of a shape.
pub fn array<'py>(py: Python<'py>, values: Vec<f64>, shape: &[usize]) -> PyResult<Floats<'py>> {
    match *shape {
        [length] if length == values.len() => {
            Ok(PyArray1::from_slice(py, &values).to_dyn().clone())
        }
        [rows, columns] => {
            let array = Array2::from_shape_vec((rows, columns), values).map_err(value_error)?;
            Ok(array.into_pyarray(py).to_dyn().clone())
        }
        _ => {
            let array = Array::from_shape_vec(IxDyn(shape), values).map_err(value_error)?;
            Ok(array.into_pyarray(py))
        }
    }
}

/// Python slice of a range of indices.
pub fn slice<'py>(py: Python<'py>, indices: &Range<usize>) -> PyResult<Bound<'py, PySlice>> {
    let end = |index: usize| isize::try_from(index).map_err(value_error);
    Ok(PySlice::new(py, end(indices.start)?, end(indices.end)?, 1))
}

/// Creates an array of a shape with a single NumPy allocation. This is faster than [`array`] for a few numbers.
pub fn copied<'py>(py: Python<'py>, values: &[f64], shape: &[usize]) -> PyResult<Floats<'py>> {
    match *shape {
        [rows, columns] => {
            let view = ArrayView2::from_shape((rows, columns), values).map_err(value_error)?;
            Ok(view.to_pyarray(py).to_dyn().clone())
        }
        [_] => Ok(PyArray1::from_slice(py, values).to_dyn().clone()),
        _ => array(py, values.to_vec(), shape),
    }
}

/// Creates an array of integers of a shape.
pub fn whole_array<'py>(
    py: Python<'py>,
    values: Vec<i64>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
    let array = Array::from_shape_vec(IxDyn(shape), values).map_err(value_error)?;
    Ok(array.into_pyarray(py))
}

/// Converts indices and counts of the library, which are below 2⁶³, to signed integers for NumPy.
pub fn signed(values: impl IntoIterator<Item = usize>) -> Vec<i64> {
    values
        .into_iter()
        .map(|value| i64::try_from(value).unwrap_or(i64::MAX))
        .collect()
}
