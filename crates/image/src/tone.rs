// SPDX-License-Identifier: GPL-3.0-or-later
//! Tone curves: from unbounded linear light to the 0..1 of a screen, channel by channel.
//! Source: Reinhard's x / (1 + x) [Rei02]; the filmic curve is Narkowicz's rational fit of the ACES
//! tone curve (its reference transform for screens) [Nar15], the default of the command line: 0.18 shows as 0.27, 1 as 0.80.
//! In: linear light. Out: linear light in 0..1 (to be encoded as sRGB). Exposure is in stops: each doubles the light.
//! Invariants: monotone, 0 stays 0, NaN becomes 0. Tests: `tests`.

use crate::{Error, srgb};

/// How light above white is brought into the range of a screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Cut at 1: values in range stay exact.
    #[default]
    Clamp,
    /// x / (1 + x): never cuts, darkens all.
    Reinhard,
    /// An S-shaped curve with a soft toe and shoulder.
    Filmic,
}

impl ToneCurve {
    /// All curves.
    pub const ALL: [Self; 3] = [Self::Clamp, Self::Reinhard, Self::Filmic];

    /// The name that users write.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Reinhard => "reinhard",
            Self::Filmic => "filmic",
        }
    }

    /// Linear value on a screen, 0..1.
    #[must_use]
    pub fn apply(self, linear: f32) -> f32 {
        // `max` answers the number where the other side is NaN.
        let light = linear.max(0.0);
        match self {
            Self::Clamp => light.min(1.0),
            Self::Reinhard if light.is_infinite() => 1.0,
            Self::Reinhard => light / (1.0 + light),
            Self::Filmic => {
                // Above 1e4 the curve is flat within rounding; the cut keeps infinity / infinity out.
                let x = light.min(1e4);
                ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
            }
        }
    }
}

impl std::str::FromStr for ToneCurve {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        Self::ALL.into_iter().find(|curve| curve.name() == name).ok_or_else(|| Error::UnknownName {
            what: "tone curve",
            name: name.into(),
            valid: Self::ALL.map(Self::name).join(", "),
        })
    }
}

impl std::fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Screen bytes of a linear colour with opacity: exposure, curve, sRGB; the opacity is linear.
#[must_use]
pub fn screen_bytes(color: [f32; 4], curve: ToneCurve, exposure_stops: f32) -> [u8; 4] {
    let gain = exposure_stops.exp2();
    let channel = |linear: f32| srgb::encode_u8(curve.apply(linear * gain));
    // `as` saturates and turns NaN into 0.
    let opacity = (color[3] * 255.0 + 0.5) as u8;
    [channel(color[0]), channel(color[1]), channel(color[2]), opacity]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_rise_from_zero_and_stay_below_one() {
        for curve in ToneCurve::ALL {
            assert_eq!(curve.apply(0.0), 0.0, "{curve} moves black");
            let mut last = 0.0;
            for i in 0..20_000 {
                let y = curve.apply(i as f32 * 1e-2);
                assert!(y >= last && y <= 1.0, "{curve} falls or leaves 0..1 at {}: {y}", i as f32 * 1e-2);
                last = y;
            }
        }
    }

    #[test]
    fn odd_values_stay_in_range() {
        for curve in ToneCurve::ALL {
            assert_eq!(curve.apply(f32::NAN), 0.0, "{curve} of NaN");
            assert_eq!(curve.apply(-3.0), 0.0, "{curve} of a negative value");
            assert!(curve.apply(f32::INFINITY) > 0.99, "{curve} of infinity is white");
            assert!(curve.apply(f32::MAX) > 0.99, "{curve} of the largest float is white");
        }
    }

    #[test]
    fn a_stop_doubles_the_light() {
        let brighter = screen_bytes([0.2, 0.1, 0.05, 1.0], ToneCurve::Clamp, 1.0);
        let doubled = screen_bytes([0.4, 0.2, 0.1, 1.0], ToneCurve::Clamp, 0.0);
        assert_eq!(brighter, doubled, "one stop must equal a factor of 2");
    }

    #[test]
    fn names_lead_back() {
        for curve in ToneCurve::ALL {
            assert_eq!(curve.name().parse::<ToneCurve>().ok(), Some(curve), "name of {curve}");
        }
        let message = "aces".parse::<ToneCurve>().expect_err("no such curve").to_string();
        assert!(message.contains("clamp, reinhard, filmic"), "valid names are listed: {message}");
    }
}
