// SPDX-License-Identifier: GPL-3.0-or-later
//! Arguments by name, checked: an error names the argument and the expected form.
//! Invariant: every number from here is finite. Tests: `tests/test_pictures.py::test_wrong_arguments`.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The arguments of a call.
pub(crate) struct Given<'a, 'py> {
    all: &'a Bound<'py, PyDict>,
    query: Vec<&'static str>,
}

impl<'a, 'py> Given<'a, 'py> {
    pub(crate) fn new(all: &'a Bound<'py, PyDict>) -> Self {
        Self { all, query: Vec::new() }
    }

    /// The argument, if it is given and not `None`.
    pub(crate) fn get(&mut self, name: &'static str) -> PyResult<Option<Bound<'py, PyAny>>> {
        if !self.query.contains(&name) {
            self.query.push(name);
        }
        Ok(self.all.get_item(name)?.filter(|value| !value.is_none()))
    }

    /// Several choices by words, as bits of their indices in a list.
    pub(crate) fn words(&mut self, name: &'static str, words: &[&str]) -> PyResult<Option<u32>> {
        let expected = format!("a list of some of: {}", words.join(", "));
        self.read(name, &expected, |value| {
            let mut bits = 0;
            for word in value.try_iter().ok()? {
                let word: String = word.ok()?.extract().ok()?;
                bits |= 1 << words.iter().position(|known| *known == word)?;
            }
            Some(bits)
        })
    }

    /// Rejects arguments that were not read.
    pub(crate) fn end(self) -> PyResult<()> {
        for name in self.all.keys() {
            let name: String = name.extract()?;
            if !self.query.iter().any(|known| *known == name) {
                let known = self.query.join(", ");
                return Err(PyTypeError::new_err(format!("{name}: unknown argument; valid are: {known}")));
            }
        }
        Ok(())
    }

    fn read<T>(
        &mut self,
        name: &'static str,
        expected: &str,
        read: impl FnOnce(&Bound<'py, PyAny>) -> Option<T>,
    ) -> PyResult<Option<T>> {
        let Some(value) = self.get(name)? else { return Ok(None) };
        let wrong = || {
            let shown = value.repr().map_or_else(|_| "that".into(), |text| text.to_string());
            PyTypeError::new_err(format!("{name}: expected {expected}, not {shown}"))
        };
        read(&value).map(Some).ok_or_else(wrong)
    }

    pub(crate) fn text(&mut self, name: &'static str) -> PyResult<Option<String>> {
        self.read(name, "a word", |value| value.extract().ok())
    }

    pub(crate) fn flag(&mut self, name: &'static str) -> PyResult<Option<bool>> {
        self.read(name, "True or False", |value| value.extract().ok())
    }

    /// A number between two, both included.
    pub(crate) fn number(&mut self, name: &'static str, low: f64, high: f64) -> PyResult<Option<f64>> {
        let found = self.read(name, "a number", |value| value.extract::<f64>().ok())?;
        match found.filter(|x| !(low..=high).contains(x)) {
            None => Ok(found),
            Some(x) if high == f64::from(f32::MAX) => {
                Err(PyValueError::new_err(format!("{name}: expected a finite number from {low} on, not {x}")))
            }
            Some(x) => {
                Err(PyValueError::new_err(format!("{name}: expected a number from {low} to {high}, not {x}")))
            }
        }
    }

    /// A whole number between two, both included.
    pub(crate) fn whole(&mut self, name: &'static str, low: u64, high: u64) -> PyResult<Option<u64>> {
        let expected = format!("a whole number from {low} to {high}");
        let found = self.read(name, &expected, |value| value.extract::<i128>().ok())?;
        match found.map(|n| (n, u64::try_from(n).ok().filter(|n| (low..=high).contains(n)))) {
            None => Ok(None),
            Some((_, Some(n))) => Ok(Some(n)),
            Some((n, None)) => Err(PyValueError::new_err(format!("{name}: expected {expected}, not {n}"))),
        }
    }

    /// `N` finite numbers.
    pub(crate) fn numbers<const N: usize>(&mut self, name: &'static str) -> PyResult<Option<[f32; N]>> {
        let expected = format!("{N} finite numbers");
        self.read(name, &expected, |value| {
            let list: Vec<f64> =
                value.try_iter().ok()?.map(|x| x.ok()?.extract().ok()).collect::<Option<_>>()?;
            let list: [f64; N] = list.try_into().ok()?;
            let list = list.map(|x| x as f32);
            list.iter().all(|x| x.is_finite()).then_some(list)
        })
    }

    /// Three numbers from 0 on, or one for all three: linear light.
    pub(crate) fn color(&mut self, name: &'static str) -> PyResult<Option<[f32; 3]>> {
        let grey = |value: Bound<'py, PyAny>| value.extract::<f64>().ok().map(|x| [x as f32; 3]);
        let color = match self.get(name)?.and_then(grey) {
            Some(grey) => Some(grey),
            None => self.numbers(name)?,
        };
        match color.filter(|color| color.iter().any(|x| !(x.is_finite() && *x >= 0.0))) {
            None => Ok(color),
            Some(color) => Err(PyValueError::new_err(format!(
                "{name}: expected finite numbers from 0 on, not {color:?}"
            ))),
        }
    }

    /// One of some words.
    pub(crate) fn choice<T: std::str::FromStr<Err: std::fmt::Display>>(
        &mut self,
        name: &'static str,
    ) -> PyResult<Option<T>> {
        let word = self.text(name)?;
        let read = |word: String| {
            word.parse().map_err(|error: T::Err| PyValueError::new_err(format!("{name}: {error}")))
        };
        word.map(read).transpose()
    }
}
