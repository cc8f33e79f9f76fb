// SPDX-License-Identifier: GPL-3.0-or-later
//! Colour spaces of `rgb` parameters, to linear light of Rec. 709 primaries, which GNU RT works in.
//! Source: matrices from the primaries of each space (ITU-R BT.2020, SMPTE ST 2065-1, SMPTE RP 431-2 with D65), white
//! adapted by Bradford where it is not D65. Tests: `tests`.

/// A colour space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum ColorSpace {
    #[default]
    Srgb,
    DciP3,
    Rec2020,
    Aces,
}

impl ColorSpace {
    /// Their names, as files have them.
    pub(crate) const NAMES: [(&'static str, Self); 4] = [
        ("srgb", Self::Srgb),
        ("dci-p3", Self::DciP3),
        ("rec2020", Self::Rec2020),
        ("aces2065-1", Self::Aces),
    ];

    /// The space of this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let known = Self::NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        known.map(|(_, space)| *space)
    }

    /// The same colour with the primaries of Rec. 709.
    pub(crate) fn to_srgb(self, rgb: [f32; 3]) -> [f32; 3] {
        let rows = match self {
            Self::Srgb => return rgb,
            Self::DciP3 => {
                [[1.224_94, -0.224_94, 0.0], [-0.042_06, 1.042_06, 0.0], [-0.019_64, -0.078_64, 1.098_28]]
            }
            Self::Rec2020 => [
                [1.660_49, -0.587_64, -0.072_85],
                [-0.124_55, 1.132_90, -0.008_35],
                [-0.018_15, -0.100_58, 1.118_73],
            ],
            Self::Aces => [
                [2.521_69, -1.134_13, -0.387_56],
                [-0.276_48, 1.372_72, -0.096_24],
                [-0.015_38, -0.152_98, 1.168_35],
            ],
        };
        rows.map(|row: [f32; 3]| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_stays_white() {
        for (name, space) in ColorSpace::NAMES {
            let white = space.to_srgb([1.0; 3]);
            assert!(white.iter().all(|x| (x - 1.0).abs() < 1e-3), "{name}: {white:?}");
        }
    }
}
