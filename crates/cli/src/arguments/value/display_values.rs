// SPDX-License-Identifier: GPL-3.0-or-later
//! Values for the appearance of a picture: exposure, tone, filters, where it is shown. See
//! docs/reference/cli.md. Tests: `tests` of `value/mod.rs`.

use gnurt::denoise::Method;
use gnurt::image::{ExrCompression, ToneCurve, WorkingSpace};
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

/// 8, 16 or 32.
pub(crate) fn bits(text: &str) -> Result<u8, String> {
    text.parse().ok().filter(|bits| [8, 16, 32].contains(bits)).ok_or_else(|| "expected 8, 16 or 32".into())
}

/// The name of a compression of EXR.
pub(crate) fn compression(name: &str) -> Result<ExrCompression, String> {
    by_name("compression", name, &ExrCompression::ALL)
}

/// The name of a working space.
pub(crate) fn working_space(name: &str) -> Result<WorkingSpace, String> {
    by_name("space", name, &WorkingSpace::ALL)
}

/// Pixels of a tile's side.
pub(crate) fn tile_size(text: &str) -> Result<u32, String> {
    let size = text.parse().ok().filter(|size| (16..=16384).contains(size));
    size.ok_or_else(|| "expected a whole number from 16 to 16384".into())
}

/// From 1 to 100.
pub(crate) fn quality(text: &str) -> Result<u8, String> {
    let quality = text.parse().ok().filter(|quality| (1..=100).contains(quality));
    quality.ok_or_else(|| "expected a whole number from 1 to 100".into())
}

/// A tone curve's name.
pub(crate) fn tone(name: &str) -> Result<ToneCurve, String> {
    by_name("tone curve", name, &ToneCurve::ALL)
}
