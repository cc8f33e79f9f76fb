// SPDX-License-Identifier: GPL-3.0-or-later
//! How light becomes bytes of the screen.

use gnurt::image::ToneCurve;

/// Exposure and tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exposure {
    /// Each stop doubles the light.
    pub stops: f32,
    /// The curve above white.
    pub tone: ToneCurve,
}

impl Exposure {
    /// The next curve of the list, from the last one to the first.
    pub(crate) fn next_tone(self) -> ToneCurve {
        let at = ToneCurve::ALL.iter().position(|&tone| tone == self.tone).unwrap_or(0);
        ToneCurve::ALL[(at + 1) % ToneCurve::ALL.len()]
    }
}
