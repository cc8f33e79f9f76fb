// SPDX-License-Identifier: GPL-3.0-or-later
//! The files of a film that are there. Tests: `tests/program/{denoise,finished,relight}.rs`.

use gnurt::Numbered;
use gnurt::image::system_reason;

use crate::failure::Failure;

/// The numbers of a film's files, in order: at least one.
pub(crate) fn film_numbers(film: &Numbered) -> Result<Vec<u32>, Failure> {
    let failed =
        |why: &dyn std::fmt::Display| Failure::data(format_args!("{}: {why}", film.pattern().display()));
    let numbers = film.numbers().map_err(|error| failed(&system_reason(&error)))?;
    if numbers.is_empty() { Err(failed(&"no file has such a name")) } else { Ok(numbers) }
}
