// SPDX-License-Identifier: GPL-3.0-or-later
//! OpenEXR: a picture with all its layers, by the `exr` library.
//! Tests: `tests/{round_trip,broken}.rs`.

mod read;
mod write;

pub(super) use read::{decode, stored};
pub(super) use write::encode;

/// Precision of the colours in an EXR.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ExrPixels {
    /// Half where all values fit, else float: a sun that is seen is not cut off.
    #[default]
    Fitting,
    /// 16-bit floats: off by at most 1/2048, up to 65504; what is above becomes that.
    Half,
    /// 32-bit floats: exact.
    Float,
}
