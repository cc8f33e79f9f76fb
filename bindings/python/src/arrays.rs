// SPDX-License-Identifier: GPL-3.0-or-later
//! Arrays from and to Python, checked: an error names the argument and the expected form.
//! Invariant: an array is copied only if its type or its gaps cannot be read directly.
//! Tests: `tests/test_arrays.py`.

use gnurt_accel::Floats;
use pyo3::buffer::Element;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::ffi_arrays::Rows;

pub(crate) fn numpy<'py>(py: Python<'py>) -> PyResult<Bound<'py, PyModule>> {
    py.import(intern!(py, "numpy"))
}

/// The argument `name` as a numpy array whose numbers are aligned, as those of a field of packed records are not.
pub(crate) fn array<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let py = value.py();
    let array = numpy(py)?.call_method1(intern!(py, "asarray"), (value,)).map_err(|error| {
        PyTypeError::new_err(format!("{name}: expected an array of numbers ({})", error.value(py)))
    })?;
    let is_aligned = array.getattr(intern!(py, "flags"))?.getattr(intern!(py, "aligned"))?.is_truthy()?;
    if is_aligned { Ok(array) } else { array.call_method0(intern!(py, "copy")) }
}

fn kind(array: &Bound<'_, PyAny>) -> PyResult<String> {
    let py = array.py();
    array.getattr(intern!(py, "dtype"))?.getattr(intern!(py, "kind"))?.extract()
}

fn shape(array: &Bound<'_, PyAny>) -> PyResult<Vec<usize>> {
    array.getattr(intern!(array.py(), "shape"))?.extract()
}

/// A shape as Python writes it.
fn written(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        _ => format!("({})", shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// An array of a type, without gaps; the array itself if it is one.
pub(crate) fn of_type<'py>(array: &Bound<'py, PyAny>, dtype: &str) -> PyResult<Bound<'py, PyAny>> {
    let py = array.py();
    numpy(py)?.call_method1(intern!(py, "ascontiguousarray"), (array, dtype))
}

/// Single or double precision, in rows.
pub(crate) enum Numbers {
    Single(Rows<f32>),
    Double(Rows<f64>),
}

impl Numbers {
    /// The argument `name`: an array of `width` columns, or of one dimension where that is `None`.
    pub(crate) fn new(name: &str, value: &Bound<'_, PyAny>, width: Option<usize>) -> PyResult<Self> {
        let mut array = array(name, value)?;
        if !matches!(kind(&array)?.as_str(), "f" | "i" | "u" | "b") {
            let dtype = array.getattr("dtype")?;
            return Err(PyTypeError::new_err(format!("{name}: expected numbers, not {dtype}")));
        }
        let shape = shape(&array)?;
        let fits = match width {
            Some(width) => shape.len() == 2 && shape[1] == width,
            None => shape.len() == 1,
        };
        if !fits {
            let expected = width.map_or("(n,)".into(), |width| format!("(n, {width})"));
            return Err(PyValueError::new_err(format!(
                "{name}: expected shape {expected}, not {}",
                written(&shape)
            )));
        }
        let (size, native): (usize, bool) = {
            let dtype = array.getattr("dtype")?;
            (dtype.getattr("itemsize")?.extract()?, dtype.getattr("isnative")?.extract()?)
        };
        let is_float = kind(&array)? == "f" && native;
        for _ in 0..2 {
            let numbers = match (is_float, size) {
                (true, 4) => Rows::new(&array)?.map(Self::Single),
                (true, 8) => Rows::new(&array)?.map(Self::Double),
                _ => Rows::new(&of_type(&array, "float64")?)?.map(Self::Double),
            };
            if let Some(numbers) = numbers {
                return Ok(numbers);
            }
            array = of_type(&array, if size == 4 { "float32" } else { "float64" })?;
        }
        Err(PyValueError::new_err(format!("{name}: its memory cannot be read")))
    }

    pub(crate) fn count(&self) -> usize {
        match self {
            Self::Single(rows) => rows.count(),
            Self::Double(rows) => rows.count(),
        }
    }

    pub(crate) fn step(&self) -> usize {
        match self {
            Self::Single(rows) => rows.step(),
            Self::Double(rows) => rows.step(),
        }
    }

    /// All numbers from row `first` on to the end of row `last - 1`, gaps included.
    pub(crate) fn rows(&self, first: usize, last: usize) -> Floats<'_> {
        fn part<T>(all: &[T], step: usize, first: usize, last: usize) -> &[T] {
            &all[(first * step).min(all.len())..(last * step).min(all.len())]
        }
        match self {
            Self::Single(rows) => Floats::F32(part(rows.all(), rows.step(), first, last)),
            Self::Double(rows) => Floats::F64(part(rows.all(), rows.step(), first, last)),
        }
    }

    /// Up to three numbers of a row; zeros beyond its end.
    pub(crate) fn row(&self, i: usize) -> [f64; 3] {
        fn of<T: Copy + Into<f64>>(all: &[T], at: usize, width: usize) -> [f64; 3] {
            [0, 1, 2].map(|k| if k < width { all[at + k].into() } else { 0.0 })
        }
        match self {
            Self::Single(rows) => of(rows.all(), i * rows.step(), rows.width()),
            Self::Double(rows) => of(rows.all(), i * rows.step(), rows.width()),
        }
    }

    /// Rows of `N` in single precision.
    pub(crate) fn singles<const N: usize>(&self) -> Vec<[f32; N]> {
        fn gather<T: Copy, const N: usize>(
            all: &[T],
            step: usize,
            count: usize,
            single: fn(T) -> f32,
        ) -> Vec<[f32; N]> {
            (0..count).map(|i| std::array::from_fn(|k| single(all[i * step + k]))).collect()
        }
        match self {
            Self::Single(rows) => gather(rows.all(), rows.step(), rows.count(), |x| x),
            Self::Double(rows) => gather(rows.all(), rows.step(), rows.count(), |x| x as f32),
        }
    }

    /// Rows of three in double precision.
    pub(crate) fn points(&self) -> Vec<[f64; 3]> {
        fn gather<T: Copy + Into<f64>>(all: &[T], step: usize, count: usize) -> Vec<[f64; 3]> {
            (0..count).map(|i| [0, 1, 2].map(|k| all[i * step + k].into())).collect()
        }
        match self {
            Self::Single(rows) => gather(rows.all(), rows.step(), rows.count()),
            Self::Double(rows) => gather(rows.all(), rows.step(), rows.count()),
        }
    }
}

/// A transform as numpy has it: rows of a matrix that is multiplied with columns; as columns of an affine
/// map.
pub(crate) fn transform(name: &str, value: &Bound<'_, PyAny>) -> PyResult<[[f64; 3]; 4]> {
    let matrix = of_type(&array(name, value)?, "float64")
        .map_err(|error| PyTypeError::new_err(format!("{name}: expected numbers ({error})")))?;
    let shape = shape(&matrix)?;
    if shape != [4, 4] && shape != [3, 4] {
        let shape = written(&shape);
        return Err(PyValueError::new_err(format!("{name}: expected shape (4, 4) or (3, 4), not {shape}")));
    }
    let rows = Rows::<f64>::new(&matrix)?;
    let rows = rows.as_ref().map(Rows::all).unwrap_or_default();
    if rows.iter().any(|x| !x.is_finite()) {
        return Err(PyValueError::new_err(format!("{name}: holds a number that is not finite")));
    }
    if rows.len() == 16 && rows[12..] != [0.0, 0.0, 0.0, 1.0] {
        let last = &rows[12..];
        return Err(PyValueError::new_err(format!("{name}: its last row must be 0 0 0 1, not {last:?}")));
    }
    let columns: [[f64; 3]; 4] = [0, 1, 2, 3].map(|column| [0, 1, 2].map(|row| rows[4 * row + column]));
    let [[a, b, c], [d, e, f], [g, h, i], _] = columns;
    if a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g) == 0.0 {
        return Err(PyValueError::new_err(format!("{name}: is singular, it flattens space")));
    }
    Ok(columns)
}

/// A new array, and its memory to be written.
pub(crate) struct New<'py, T: Element> {
    array: Bound<'py, PyAny>,
    rows: Rows<T>,
}

/// Types of new arrays.
pub(crate) trait Output: Element + Copy {
    const DTYPE: &'static str;
}

impl Output for f32 {
    const DTYPE: &'static str = "float32";
}

impl Output for f64 {
    const DTYPE: &'static str = "float64";
}

impl Output for u32 {
    const DTYPE: &'static str = "uint32";
}

impl Output for i64 {
    const DTYPE: &'static str = "int64";
}

impl Output for u8 {
    const DTYPE: &'static str = "uint8";
}

impl<'py, T: Output> New<'py, T> {
    /// Of `count` rows of `width`, or of one dimension if that is 1.
    pub(crate) fn empty(py: Python<'py>, count: usize, width: usize) -> PyResult<Self> {
        let shape = if width == 1 { PyTuple::new(py, [count])? } else { PyTuple::new(py, [count, width])? };
        let array = numpy(py)?.call_method1(intern!(py, "empty"), (shape, T::DTYPE))?;
        let rows =
            Rows::new(&array)?.ok_or_else(|| PyValueError::new_err("numpy made an array with gaps"))?;
        Ok(Self { array, rows })
    }

    pub(crate) fn of(py: Python<'py>, values: &[T]) -> PyResult<Self> {
        let mut new = Self::empty(py, values.len(), 1)?;
        new.all().copy_from_slice(values);
        Ok(new)
    }

    pub(crate) fn all(&mut self) -> &mut [T] {
        self.rows.all_mut()
    }

    pub(crate) fn done(self) -> Py<PyAny> {
        self.array.unbind()
    }

    /// The same bits as another type, in rows of `width`, also where that is 1.
    pub(crate) fn rows_as(self, dtype: &str, width: usize) -> PyResult<Py<PyAny>> {
        let viewed = self.array.call_method1("view", (dtype,))?;
        Ok(viewed.call_method1("reshape", (-1, width))?.unbind())
    }

    /// The same bits as another type.
    pub(crate) fn done_as(self, dtype: &str) -> PyResult<Py<PyAny>> {
        Ok(self.array.call_method1("view", (dtype,))?.unbind())
    }
}
