// SPDX-License-Identifier: GPL-3.0-or-later
//! Values for the appearance of a picture: exposure, tone, filters, where it is shown. See
//! docs/reference/cli.md. Tests: `tests` of `value/mod.rs`.

use gnurt::denoise::Method;
use gnurt::image::ToneCurve;
use gnurt::render::ReconstructionFilter;
use gnurt_view::TevAddress;

use super::plain::{by_name, number};
use crate::nearest::unknown;

/// How noise is to be taken out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DenoiserChoice {
    /// Not at all.
    None,
    /// By this filter.
    By(Method),
}

/// How bright a picture for a screen is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ExposureChoice {
    /// As suits the picture.
    Auto,
    /// A number of stops, each of which doubles the light.
    Stops(f32),
}

/// -64 to 64 stops, or to be chosen from the picture.
pub(crate) fn exposure(text: &str) -> Result<ExposureChoice, String> {
    if text == "auto" {
        return Ok(ExposureChoice::Auto);
    }
    let right = || "give stops from -64 to 64, or auto".to_owned();
    let stops = number(text).map_err(|_| right())?;
    if stops.abs() <= 64.0 { Ok(ExposureChoice::Stops(stops)) } else { Err(right()) }
}

/// `tev:HOST:PORT`.
pub(crate) fn display(text: &str) -> Result<TevAddress, String> {
    text.parse()
}

/// A denoiser's name, or none.
pub(crate) fn denoiser(name: &str) -> Result<DenoiserChoice, String> {
    const NONE: &str = "none";
    if name == NONE {
        return Ok(DenoiserChoice::None);
    }
    let names: Vec<&str> = Method::ALL.into_iter().map(Method::name).chain([NONE]).collect();
    name.parse().map(DenoiserChoice::By).map_err(|_| unknown("denoiser", name, &names))
}

/// A reconstruction filter's name.
pub(crate) fn filter(name: &str) -> Result<ReconstructionFilter, String> {
    by_name("filter", name, &ReconstructionFilter::ALL[..])
}

/// A tone curve's name.
pub(crate) fn tone(name: &str) -> Result<ToneCurve, String> {
    by_name("tone curve", name, &ToneCurve::ALL)
}
