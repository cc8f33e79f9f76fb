// SPDX-License-Identifier: GPL-3.0-or-later
//! Working spaces: the primaries in which light is computed. Pictures are of Rec. 709 before and after.
//! Products of colours, as in light between two walls, depend on the space; sums do not.
//! Space: linear light. Tests: `tests`, crates/render/tests/working_space.rs.

use crate::Error;
use crate::chromaticities::{ACES_CG, Chromaticities, REC709};

/// The space of a computation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WorkingSpace {
    /// Linear Rec. 709: no conversion.
    #[default]
    Rec709,
    /// ACEScg, whose primaries are near those of light of one wavelength: saturated colours stay positive.
    AcesCg,
}

impl WorkingSpace {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Rec709, Self::AcesCg];

    /// The name that users write.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rec709 => "rec709",
            Self::AcesCg => "acescg",
        }
    }

    /// Primaries and white.
    #[must_use]
    pub fn chromaticities(self) -> Chromaticities {
        match self {
            Self::Rec709 => REC709,
            Self::AcesCg => ACES_CG,
        }
    }

    /// Rows of the matrix from Rec. 709; `None` = they are the same.
    #[must_use]
    pub fn from_rec709(self) -> Option<[[f32; 3]; 3]> {
        (self != Self::Rec709).then(|| REC709.to(&self.chromaticities())).flatten()
    }

    /// Rows of the matrix to Rec. 709; `None` = they are the same.
    #[must_use]
    pub fn to_rec709(self) -> Option<[[f32; 3]; 3]> {
        (self != Self::Rec709).then(|| self.chromaticities().to(&REC709)).flatten()
    }
}

impl std::str::FromStr for WorkingSpace {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        Self::ALL.into_iter().find(|space| space.name() == name).ok_or_else(|| Error::UnknownName {
            what: "space",
            name: name.into(),
            valid: Self::ALL.map(Self::name).join(", "),
        })
    }
}

impl std::fmt::Display for WorkingSpace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A colour under a matrix of these rows.
#[must_use]
pub fn convert(rows: &[[f32; 3]; 3], [r, g, b]: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * r + row[1] * g + row[2] * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        assert_eq!((WorkingSpace::Rec709.from_rec709(), WorkingSpace::Rec709.to_rec709()), (None, None));
        let [there, back] = [WorkingSpace::AcesCg.from_rec709(), WorkingSpace::AcesCg.to_rec709()];
        let (there, back) = (there.expect("a matrix"), back.expect("a matrix"));
        for color in [[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.25, 4.0]] {
            let wide = convert(&there, color);
            assert!(wide.iter().all(|&x| x >= 0.0), "ACEScg holds all of Rec. 709: {wide:?}");
            for (a, b) in convert(&back, wide).into_iter().zip(color) {
                assert!((a - b).abs() < 1e-5, "{color:?}");
            }
        }
        let white = convert(&there, [1.0; 3]);
        assert!(white.iter().all(|x| (x - 1.0).abs() < 1e-5), "white stays white: {white:?}");
    }
}
