// SPDX-License-Identifier: GPL-3.0-or-later
//! How pictures are written.

use crate::ToneCurve;

/// Precision of the colours in an EXR.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ExrPixels {
    /// Half where all values fit, else float: a sun that is seen is not cut off.
    #[default]
    Fitting,
    /// 16-bit floats: off by at most 1/2048, up to 65504; greater values become that.
    Half,
    /// 32-bit floats: exact.
    Float,
}

/// How a picture is written where the format leaves a choice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WriteOptions {
    /// PNG: how light above white is shown.
    pub tone: ToneCurve,
    /// PNG: exposure in stops; each doubles the light.
    pub exposure: f32,
    /// EXR: precision of the colours. Channels of layers state their own.
    pub exr_pixels: ExrPixels,
}
