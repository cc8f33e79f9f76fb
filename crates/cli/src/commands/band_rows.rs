// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render --band-rows N`: compatible options, and the rows of a band. Options that read the whole picture are
//! rejected: filters, exposures chosen from it. Tests: `tests/program/bands.rs`.

use gnurt::render::BAND_UNIT;

use crate::arguments::RenderArguments;
use crate::failure::{Failure, Outcome};
use crate::output::Output;

/// Rejects options that exclude bands.
pub(super) fn check(arguments: &RenderArguments) -> Outcome {
    let Some(rows) = arguments.band_rows else { return Ok(()) };
    let refuse = |why: &str| Err(Failure::usage(format_args!("--band-rows {rows}: {why}")));
    let excluded = [
        (arguments.piece.is_some(), "--piece"),
        (arguments.times.frames.is_some(), "--frames"),
        (arguments.heatmap.is_some(), "--heatmap"),
        (arguments.time.is_some(), "--time"),
        (arguments.checkpoint.is_some(), "--checkpoint"),
        (arguments.display.is_some(), "--display"),
    ];
    if let Some((_, option)) = excluded.into_iter().find(|(is_given, _)| *is_given) {
        return refuse(&format!("it does not go with {option}; leave out one of the two"));
    }
    if arguments.denoiser.options(None).is_some() {
        return refuse("noise is taken out of the whole picture; leave out --denoise");
    }
    if arguments.frame.integrator.has_virtual_lights() && arguments.frame.interleave > 1 {
        return refuse(
            "interleaved pixels read their neighbours, which are in other bands; leave out --interleave",
        );
    }
    Ok(())
}

/// Rows of a band of this output.
pub(super) fn rows(arguments: &RenderArguments, output: &Output) -> Result<Option<u32>, Failure> {
    let Some(requested) = arguments.band_rows else { return Ok(None) };
    let unit = output.band_unit(arguments.light.file)?;
    // The least number that both the file's blocks and the tiles divide.
    let unit = unit / greatest_divisor(unit, BAND_UNIT) * BAND_UNIT;
    Ok(Some(requested.div_ceil(unit).saturating_mul(unit)))
}

fn greatest_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_divisor(b, a % b) }
}
