// SPDX-License-Identifier: GPL-3.0-or-later
//! Numbers, lists and names, as all values of options are made of them.
//! See docs/reference/cli.md. Tests: `tests` of `value/mod.rs`.

use std::fmt::Display;
use std::str::FromStr;

use crate::nearest::unknown;

pub(super) fn by_name<T: Copy + Display>(what: &str, name: &str, all: &[T]) -> Result<T, String> {
    let names: Vec<String> = all.iter().map(ToString::to_string).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let index = names.iter().position(|&known| known == name).ok_or_else(|| unknown(what, name, &names))?;
    Ok(all[index])
}

/// A whole number in a range, both ends included.
pub(super) fn whole<T: FromStr + PartialOrd + Display>(text: &str, least: T, most: T) -> Result<T, String> {
    let value = text.parse::<T>().ok().filter(|value| *value >= least && *value <= most);
    value.ok_or_else(|| format!("give a whole number from {least} to {most}"))
}

/// A finite number in single precision.
pub(super) fn number(text: &str) -> Result<f32, String> {
    let value = text.trim().parse::<f32>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| "not a finite number".into())
}

/// Exactly `N` values between commas.
pub(super) fn list<const N: usize, T: FromStr>(text: &str, form: &str) -> Result<[T; N], String> {
    let values: Result<Vec<T>, _> = text.split(',').map(|part| part.trim().parse::<T>()).collect();
    values.ok().and_then(|values| values.try_into().ok()).ok_or_else(|| form.to_owned())
}
