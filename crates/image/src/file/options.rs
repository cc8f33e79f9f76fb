// SPDX-License-Identifier: GPL-3.0-or-later
//! How pictures are written.

use super::exr::ExrPixels;
use crate::ToneCurve;

/// How a picture is written where the format leaves a choice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WriteOptions {
    /// PNG: how light above white is shown.
    pub tone: ToneCurve,
    /// PNG: exposure in stops; each doubles the light.
    pub exposure: f32,
    /// EXR: precision of the colours. Channels of layers say theirs themselves.
    pub exr_pixels: ExrPixels,
}
