// SPDX-License-Identifier: GPL-3.0-or-later
//! Tone curves: from unbounded linear light to the 0..1 of a screen, channel by channel or by colours.
//! Source: Reinhard's x / (1 + x) [Rei02]; the filmic curve is Narkowicz's rational fit of the ACES
//! tone curve (its reference transform for screens) [Nar15], the default of the command line: 0.18 shows as 0.27, 1 as 0.80.
//! AgX [Sob22] in Wrensch's fit of its sigmoid [Wre23]: logarithmic light of turned primaries, so that bright
//! colours go to white instead of to other hues. Neutral is Khronos' for products [Khr24]: colours up to 0.76
//! stay as they are but for a small offset.
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
    /// AgX: bright colours go to white.
    Agx,
    /// Khronos PBR Neutral: base colours as they are, bright ones go to white.
    Neutral,
}

impl ToneCurve {
    /// All curves.
    pub const ALL: [Self; 5] = [Self::Clamp, Self::Reinhard, Self::Filmic, Self::Agx, Self::Neutral];

    /// The name that users write.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Reinhard => "reinhard",
            Self::Filmic => "filmic",
            Self::Agx => "agx",
            Self::Neutral => "neutral",
        }
    }

    /// Linear colour on a screen, 0..1.
    #[must_use]
    pub fn apply_rgb(self, linear: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Agx => agx(linear),
            Self::Neutral => neutral(linear),
            _ => linear.map(|channel| self.apply(channel)),
        }
    }

    /// Linear value of grey on a screen, 0..1.
    #[must_use]
    #[inline]
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
            Self::Agx | Self::Neutral => self.apply_rgb([light; 3])[1],
        }
    }
}

/// The brightest light that the curves of colours tell from infinity.
const BRIGHTEST: f32 = 1e6;

/// Light that is a number, not negative and not infinite.
fn light(linear: [f32; 3]) -> [f32; 3] {
    // `max` answers the number where the other side is NaN.
    linear.map(|channel| channel.max(0.0)).map(|channel| channel.min(BRIGHTEST))
}

/// Rows of a matrix times a colour.
fn turned(rows: &[[f32; 3]; 3], color: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * color[0] + row[1] * color[1] + row[2] * color[2])
}

/// AgX from Rec. 709 to Rec. 709.
fn agx(linear: [f32; 3]) -> [f32; 3] {
    const INSET: [[f32; 3]; 3] = [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_64, 0.079_166_13],
        [0.042_375_656, 0.078_433_6, 0.879_143],
    ];
    const OUTSET: [[f32; 3]; 3] = [
        [1.196_879, -0.098_020_88, -0.099_029_74],
        [-0.052_896_85, 1.151_903_1, -0.098_961_18],
        [-0.052_971_636, -0.098_043_45, 1.151_073_7],
    ];
    // Ten stops below middle grey, six and a half above.
    const LEAST: f32 = -12.473_93;
    const MOST: f32 = 4.026_069;
    let curve = |channel: f32| {
        let x = (channel.log2().clamp(LEAST, MOST) - LEAST) / (MOST - LEAST);
        let x2 = x * x;
        let x4 = x2 * x2;
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232
    };
    let encoded = turned(&OUTSET, turned(&INSET, light(linear)).map(curve));
    encoded.map(|channel| channel.clamp(0.0, 1.0).powf(2.2))
}

/// Khronos PBR Neutral.
fn neutral(linear: [f32; 3]) -> [f32; 3] {
    const BEGIN: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let color = light(linear);
    let least = color.into_iter().fold(BRIGHTEST, f32::min);
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let color = color.map(|channel| channel - offset);
    let peak = color.into_iter().fold(0.0, f32::max);
    if peak < BEGIN {
        return color;
    }
    let room = 1.0 - BEGIN;
    let compressed = 1.0 - room * room / (peak + room - BEGIN);
    let grey = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    color.map(|channel| {
        let channel = channel * (compressed / peak);
        channel + (compressed - channel) * grey
    })
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
    let [r, g, b] = curve.apply_rgb([color[0] * gain, color[1] * gain, color[2] * gain]);
    // `as` saturates and turns NaN into 0.
    let opacity = (color[3] * 255.0 + 0.5) as u8;
    [srgb::encode_u8(r), srgb::encode_u8(g), srgb::encode_u8(b), opacity]
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

    /// The sigmoid of AgX, of which the polynomial is a fit: a line of slope 2 through the pivot, with ends of
    /// power 3.
    fn sigmoid(x: f64) -> f64 {
        let (pivot, middle, slope, power) = (10.0 / 16.5, 0.5, 2.0, 3.0);
        let scale = |x: f64, y: f64| {
            ((slope * x).powf(-power) * ((slope * (x / y)).powf(power) - 1.0)).powf(-1.0 / power)
        };
        let scale = if x < pivot { -scale(pivot, middle) } else { scale(1.0 - pivot, 1.0 - middle) };
        let term = slope * (x - pivot) / scale;
        scale * term / (1.0 + term.powf(power)).powf(1.0 / power) + middle
    }

    #[test]
    fn agx_follows_its_sigmoid() {
        for i in 0..=100 {
            let x = f64::from(i) / 100.0;
            let linear = (x * 16.5 - 12.473_93).exp2() as f32;
            let shown = ToneCurve::Agx.apply_rgb([linear; 3])[1].powf(1.0 / 2.2);
            assert!((f64::from(shown) - sigmoid(x).max(0.0)).abs() < 5e-3, "{x}: {shown}, {}", sigmoid(x));
        }
        // Middle grey shows as half of the encoded range; a bright red loses its hue slowly.
        let grey = ToneCurve::Agx.apply(0.18).powf(1.0 / 2.2);
        assert!((grey - 0.5).abs() < 0.005, "{grey}");
        let [r, g, b] = ToneCurve::Agx.apply_rgb([50.0, 0.0, 0.0]);
        assert!(r > g && g > 0.2 && b > 0.2, "to white: {r} {g} {b}");
    }

    #[test]
    fn neutral_follows_its_definition() {
        let close = |from: [f32; 3], to: [f32; 3]| {
            let found = ToneCurve::Neutral.apply_rgb(from);
            let is = found.iter().zip(to).all(|(a, b)| (a - b).abs() < 1e-5);
            assert!(is, "{from:?} becomes {found:?}, not {to:?}");
        };
        close([0.5, 0.3, 0.2], [0.46, 0.26, 0.16]);
        close([0.04, 0.5, 0.5], [0.01, 0.47, 0.47]);
        // By hand: peak 0.96 becomes 1 - 0.0576 / 0.44, then 0.13395 times 0.15 towards grey.
        let compressed = 1.0 - 0.0576 / 0.44;
        let grey = 1.0 - 1.0 / (0.15 * (0.96 - compressed) + 1.0);
        let low = 0.06 * compressed / 0.96;
        close(
            [1.0, 0.1, 0.1],
            [compressed, low + (compressed - low) * grey, low + (compressed - low) * grey],
        );
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
        assert!(
            message.contains("clamp, reinhard, filmic, agx, neutral"),
            "valid names are listed: {message}"
        );
    }
}
