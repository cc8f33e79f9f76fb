// SPDX-License-Identifier: GPL-3.0-or-later
//! What the pixels of a picture hold, at a glance: for lists of contents. Tests: `tests`.

use crate::Picture;

/// Ranges and counts of a picture's colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survey {
    /// The least finite value of red, green and blue, in linear light; 0 where none is finite.
    pub least: [f32; 3],
    /// The greatest.
    pub greatest: [f32; 3],
    /// Pixels with a value that is not finite, opacity included.
    pub odd: usize,
    /// Pixels whose opacity is below 1.
    pub open: usize,
}

impl Survey {
    /// That of a picture.
    #[must_use]
    pub fn of(picture: &Picture) -> Self {
        let range = |k: usize, start: f32, pick: fn(f32, f32) -> f32| {
            let finite = picture.color.iter().map(|pixel| pixel[k]).filter(|x| x.is_finite());
            let found = finite.fold(start, pick);
            if found.is_finite() { found } else { 0.0 }
        };
        Self {
            least: [0, 1, 2].map(|k| range(k, f32::INFINITY, f32::min)),
            greatest: [0, 1, 2].map(|k| range(k, f32::NEG_INFINITY, f32::max)),
            odd: picture.color.iter().filter(|pixel| pixel.iter().any(|x| !x.is_finite())).count(),
            open: picture.color.iter().filter(|pixel| pixel[3] < 1.0).count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_leave_out_what_is_not_finite() {
        let mut picture = Picture::new(3, 1);
        picture.color =
            vec![[f32::NAN, 2.0, -1.0, 1.0], [f32::NAN, 3.0, 0.5, 0.5], [f32::INFINITY, 1.0, 0.0, 1.0]];
        let expected = Survey { least: [0.0, 1.0, -1.0], greatest: [0.0, 3.0, 0.5], odd: 3, open: 1 };
        assert_eq!(Survey::of(&picture), expected, "red has no finite value");
    }
}
