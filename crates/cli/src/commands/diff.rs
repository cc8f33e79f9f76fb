// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt diff A B`: how much two pictures differ, and whether that is too much.
//! Source: after `idiff` of OpenImageIO. `--fail T` bounds the largest absolute difference of a linear value.
//! Opacity counts only between two PNG or two EXR files: a PNG is opaque where an EXR has the share of hits,
//! and the other formats have none. `-o` writes a picture of the differences, `--flip` measures those that people see. With `-q` only different pictures are reported. Tests:
//! `tests/program/differences.rs`.

use std::path::Path;

use gnurt::image::{self, Comparison};

use crate::arguments::{DiffArguments, DisplayOptions};
use crate::failure::{Failure, Outcome};
use crate::messages::{Messages, print};
use crate::output::Output;
use crate::workers::read_picture;

/// Compares.
pub(crate) fn run(arguments: &DiffArguments, messages: Messages) -> Outcome {
    let a = read_picture(&arguments.a).map_err(Failure::usage)?;
    let b = read_picture(&arguments.b).map_err(Failure::usage)?;
    let comparison = image::compare(&a, &b).map_err(|error| {
        Failure::usage(format_args!("{}, {}: {error}", arguments.a.display(), arguments.b.display()))
    })?;
    let seen = arguments.flip.then(|| image::flip(&a, &b)).transpose().map_err(Failure::usage)?;
    if let Some(path) = &arguments.output {
        let output = Output::named(path)?;
        output.spare(&[arguments.a.clone(), arguments.b.clone()])?;
        output.check()?;
        output.write(&image::differences(&a, &b, seen.as_deref()), DisplayOptions::default())?;
    }
    let both_are = |format: &str| has_extension(&arguments.a, format) && has_extension(&arguments.b, format);
    let with_opacity = both_are("png") || both_are("exr");
    messages.detail(if with_opacity { "opacity counts" } else { "opacity does not count" });
    let passes = passes(&comparison, arguments.fail, with_opacity);
    if !(passes && messages.is_quiet()) {
        print(comparison.to_string().trim_end())?;
        if let Some(seen) = &seen {
            let mean = seen.iter().map(|&x| f64::from(x)).sum::<f64>() / seen.len() as f64;
            print(format_args!("{:<22} {mean:.6}", "FLIP"))?;
        }
    }
    if passes { Ok(()) } else { Err(Failure::Differs) }
}

/// Whether no value differs by more than `tolerance`; a tolerance of 0 requires equal bits.
fn passes(comparison: &Comparison, tolerance: f64, with_opacity: bool) -> bool {
    let opacity = if with_opacity { comparison.max_opacity_difference } else { 0.0 };
    // A NaN on either side is an infinite difference, and no tolerance is infinite.
    comparison.max_difference <= tolerance && opacity <= tolerance
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}
