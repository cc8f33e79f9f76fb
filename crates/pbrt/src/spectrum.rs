// SPDX-License-Identifier: GPL-3.0-or-later
//! Spectra as three numbers: the colour of light, the albedo of surfaces, indices of refraction.
//! Source: the CIE's observer of 1931; pbrt-v4 divides each light by the Y of its spectrum (of its illuminant, if it is an
//! `rgb`), so that a light of scale 1 has luminance 1 whatever its spectrum's numbers are: `light`.
//! Albedos are seen under D65. Wavelengths are in nanometres. Tests: `tests`.

use std::sync::LazyLock;

use gnurt_scene::io::Error;
use gnurt_scene::io::reader::{Access, quoted, resolve};
use gnurt_sl_lib::color::wavelength_xyz;

use crate::parameter::{Kind, Parameter, Parameters, Values};
use crate::tables::{D65, GLASSES, ILLUMINANTS, METALS};

/// Bytes of a file with a spectrum.
const LONGEST: u64 = 1 << 20;
/// Wavelengths of integrals: 380 to 780 nm.
const FIRST: u32 = 380;
const LAST: u32 = 780;
const STEP: usize = 5;

/// A spectrum of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Spectrum {
    /// Linear, of Rec. 709.
    Rgb([f32; 3]),
    /// Kelvin.
    Blackbody(f32),
    /// Wavelengths, ascending, and values; linear between them, 0 beyond.
    Samples(Vec<[f32; 2]>),
    /// A named illuminant's chromaticity.
    Illuminant([f32; 2]),
    /// A named metal's indices or extinction coefficients.
    Metal([f32; 3]),
    /// A named glass: index and Abbe's number.
    Glass(f32, f32),
}

fn rgb_from_xyz([x, y, z]: [f64; 3]) -> [f32; 3] {
    let rows = [
        [3.240_454_2, -1.537_138_5, -0.498_531_4],
        [-0.969_266, 1.876_010_8, 0.041_556],
        [0.055_643_4, -0.204_025_9, 1.057_225_2],
    ];
    rows.map(|row: [f64; 3]| (row[0] * x + row[1] * y + row[2] * z) as f32)
}

/// D65 at a wavelength.
fn daylight(wavelength: f32) -> f64 {
    let at = (wavelength - FIRST as f32) / 10.0;
    let i = (at as usize).min(D65.len() - 2);
    let rest = f64::from(at - i as f32);
    f64::from(D65[i]) * (1.0 - rest) + f64::from(D65[i + 1]) * rest
}

/// Integrals of the observer's functions times a spectrum.
fn xyz(spectrum: impl Fn(f32) -> f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for wavelength in (FIRST..=LAST).step_by(STEP) {
        let value = spectrum(wavelength as f32);
        // The last one is that of 780 nm: next to nothing.
        let observer = wavelength_xyz(wavelength as f32);
        for (sum, observer) in sum.iter_mut().zip(observer) {
            *sum += f64::from(observer) * value;
        }
    }
    sum
}

/// The Y of D65.
static DAYLIGHT_Y: LazyLock<f64> = LazyLock::new(|| xyz(daylight)[1]);

/// A reflectance or an index by wavelength as a colour, seen under D65.
fn under_daylight(spectrum: impl Fn(f32) -> f64) -> [f32; 3] {
    rgb_from_xyz(xyz(|l| spectrum(l) * daylight(l)).map(|x| x / *DAYLIGHT_Y))
}

/// A colour of luminance 1.
fn of_unit_luminance(xyz: [f64; 3]) -> [f32; 3] {
    if xyz[1] > 0.0 { rgb_from_xyz(xyz.map(|x| x / xyz[1])).map(|c| c.max(0.0)) } else { [0.0; 3] }
}

/// Planck's law, of any unit.
fn planck(wavelength: f32, kelvin: f32) -> f64 {
    let metres = f64::from(wavelength) * 1e-9;
    let power = 1.438_777e-2 / (metres * f64::from(kelvin));
    1e-30 / (metres.powi(5) * power.exp_m1())
}

/// Radiance of a black body as pbrt's volumes have it: its spectrum scaled to a greatest value of 1, in front of a film that adds
/// up the observer's functions per nanometre. Components are at least 0.
pub(crate) fn radiance_of_black_body(kelvin: f32) -> [f32; 3] {
    // Wien's law; nanometres.
    let greatest = planck(2_897_772.0 / kelvin, kelvin);
    let xyz = xyz(|l| planck(l, kelvin) / greatest);
    rgb_from_xyz(xyz.map(|x| x * STEP as f64)).map(|c| c.max(0.0))
}

fn sampled(samples: &[[f32; 2]], wavelength: f32) -> f64 {
    let after = samples.partition_point(|sample| sample[0] <= wavelength);
    let Some(&[first, value]) = after.checked_sub(1).and_then(|before| samples.get(before)) else {
        return 0.0;
    };
    match samples.get(after) {
        Some(&[next, at_next]) => {
            f64::from(value) + f64::from((wavelength - first) / (next - first)) * f64::from(at_next - value)
        }
        None if wavelength == first => f64::from(value),
        None => 0.0,
    }
}

impl Spectrum {
    /// The colour of a light of scale 1.
    pub(crate) fn light(&self) -> [f32; 3] {
        match self {
            Self::Rgb(rgb) => *rgb,
            Self::Blackbody(kelvin) => of_unit_luminance(xyz(|l| planck(l, *kelvin))),
            Self::Samples(samples) => of_unit_luminance(xyz(|l| sampled(samples, l))),
            Self::Illuminant([x, y]) => {
                let (x, y) = (f64::from(*x), f64::from(*y));
                of_unit_luminance([x / y, 1.0, (1.0 - x - y) / y])
            }
            Self::Metal(rgb) => *rgb,
            Self::Glass(..) => of_unit_luminance(xyz(|_| 1.0)),
        }
    }

    /// The colour of a surface with this reflectance; otherwise the index of glass, or the colour of a light.
    pub(crate) fn value(&self) -> [f32; 3] {
        match self {
            Self::Samples(samples) => under_daylight(|l| sampled(samples, l)),
            Self::Glass(index, _) => [*index; 3],
            Self::Rgb(rgb) | Self::Metal(rgb) => *rgb,
            Self::Blackbody(_) | Self::Illuminant(_) => self.light(),
        }
    }

    /// As an index of glass: for yellow light, and Abbe's number if it changes with the wavelength.
    pub(crate) fn index(&self) -> (f32, Option<f32>) {
        match self {
            Self::Glass(index, abbe) => (*index, Some(*abbe)),
            Self::Samples(samples) => {
                let [blue, yellow, red] = [486.1, 587.6, 656.3].map(|l| sampled(samples, l) as f32);
                let abbe = (yellow - 1.0) / (blue - red);
                (yellow, Some(abbe).filter(|abbe| *abbe > 0.0 && abbe.is_finite()))
            }
            other => (other.value().iter().sum::<f32>() / 3.0, None),
        }
    }

    /// The spectrum of a parameter, if it is given: `rgb`, `blackbody`, numbers, a name or a file.
    pub(crate) fn of(parameters: &Parameters, name: &str, access: &Access) -> Result<Option<Self>, Error> {
        let Some(found) = parameters.find(name, &[Kind::Rgb, Kind::Blackbody, Kind::Spectrum]) else {
            return Ok(None);
        };
        Self::of_parameter(found, access).map(Some)
    }

    fn of_parameter(parameter: &Parameter, access: &Access) -> Result<Self, Error> {
        match (parameter.kind, &parameter.values) {
            (Kind::Rgb, Values::Floats(list)) => {
                let &[r, g, b] = &list[..] else {
                    return Err(parameter.error("has more than one value", "give one"));
                };
                if r < 0.0 || g < 0.0 || b < 0.0 {
                    return Err(parameter.error("has a negative component", "colours are 0 or above"));
                }
                Ok(Self::Rgb(parameter.space.to_srgb([r, g, b]).map(|c| c.max(0.0))))
            }
            (Kind::Blackbody, Values::Floats(list)) => match list[..] {
                [kelvin] if kelvin > 0.0 && kelvin.is_finite() => Ok(Self::Blackbody(kelvin)),
                _ => Err(parameter.error("is not one temperature", "give one above 0, in kelvin")),
            },
            (_, Values::Floats(list)) => {
                let (pairs, rest) = list.as_chunks::<2>();
                if !rest.is_empty() {
                    return Err(
                        parameter.error("has an odd number of values", "give a value for each wavelength")
                    );
                }
                check(pairs).map_err(|why| parameter.error(why, "give pairs of a wavelength and a value"))?;
                Ok(Self::Samples(pairs.to_vec()))
            }
            (_, Values::Texts(list)) => match &list[..] {
                [name] => Self::named(name).map_or_else(|| read(parameter, name, access), Ok),
                _ => Err(parameter.error("has more than one value", "give one")),
            },
            _ => Err(parameter.error("is no spectrum", "give rgb, blackbody or spectrum")),
        }
    }

    /// A spectrum that pbrt knows by name.
    fn named(name: &str) -> Option<Self> {
        if let Some((_, index, abbe)) = GLASSES.iter().find(|(known, ..)| *known == name) {
            return Some(Self::Glass(*index, *abbe));
        }
        if let Some((_, xy)) = ILLUMINANTS.iter().find(|(known, _)| *known == name) {
            return Some(Self::Illuminant(*xy));
        }
        let (metal, part) = name.strip_prefix("metal-")?.split_once('-')?;
        let metal = METALS.iter().find(|known| known.name == metal)?;
        match part {
            "eta" => Some(Self::Metal(metal.eta)),
            "k" => Some(Self::Metal(metal.k)),
            _ => None,
        }
    }
}

/// Wavelengths must ascend.
fn check(samples: &[[f32; 2]]) -> Result<(), &'static str> {
    let ascend = samples.windows(2).all(|pair| pair[0][0] < pair[1][0]);
    if !ascend {
        return Err("has wavelengths that do not ascend");
    }
    let finite = samples.as_flattened().iter().all(|x| x.is_finite());
    if finite { Ok(()) } else { Err("has a value that is not finite") }
}

/// A spectrum in a file: a wavelength and a value on each line.
fn read(parameter: &Parameter, name: &str, access: &Access) -> Result<Spectrum, Error> {
    let path = resolve(&parameter.location.path, name);
    let remedy = "give the file of a spectrum, or one of pbrt's names like metal-Au-eta";
    let before = access.budget.held();
    let bytes = access.read(&path, LONGEST).map_err(|e| {
        parameter.error(
            &format!("names {}, which is no spectrum that is known: {}", quoted(name), e.problem),
            remedy,
        )
    })?;
    let text = String::from_utf8_lossy(&bytes);
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    let numbers: Result<Vec<f32>, _> = lines.flat_map(str::split_ascii_whitespace).map(str::parse).collect();
    let bad = |why: &str| parameter.error(&format!("names {}, which {why}", quoted(name)), remedy);
    let numbers = numbers.map_err(|_| bad("holds more than numbers"))?;
    let (pairs, rest) = numbers.as_chunks::<2>();
    if pairs.is_empty() || !rest.is_empty() {
        return Err(bad("does not hold pairs of numbers"));
    }
    check(pairs).map_err(bad)?;
    let samples = pairs.to_vec();
    access.budget.settle(before);
    Ok(Spectrum::Samples(samples))
}

/// Indices and extinction coefficients per channel of a metal whose both are spectra: under D65 it mirrors the same colour at
/// normal incidence.
pub(crate) fn metal(eta: &Spectrum, k: &Spectrum) -> [[f32; 3]; 2] {
    let (Spectrum::Samples(etas), Spectrum::Samples(ks)) = (eta, k) else { return [eta.value(), k.value()] };
    let mirrored = under_daylight(|l| {
        let (eta, k) = (sampled(etas, l), sampled(ks, l));
        ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k)
    });
    let index = eta.value().map(|eta| eta.max(0.02));
    let extinction = std::array::from_fn(|c| {
        let (share, eta) = (mirrored[c].clamp(0.0, 0.998), index[c]);
        let square = (share * (eta + 1.0).powi(2) - (eta - 1.0).powi(2)) / (1.0 - share);
        square.max(0.0).sqrt()
    });
    [index, extinction]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f32; 3], b: [f32; 3], by: f32) {
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < by), "{a:?} instead of {b:?}");
    }

    #[test]
    fn white_under_daylight_is_white() {
        near(Spectrum::Samples(vec![[300.0, 0.5], [900.0, 0.5]]).value(), [0.5; 3], 1e-3);
        near(Spectrum::Illuminant([0.3127, 0.3290]).light(), [1.0; 3], 2e-3);
        near(Spectrum::Blackbody(6504.0).light(), [1.0; 3], 0.06);
        // A flat spectrum of 1 would have the luminance 106.86; at 5200 K the greatest value is at 557 nm.
        let [red, green, blue] = radiance_of_black_body(5200.0);
        let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        assert!((100.0..106.86).contains(&luminance), "{luminance}");
    }

    #[test]
    fn lights_have_luminance_one() {
        let all = [
            Spectrum::Blackbody(2700.0),
            Spectrum::Samples(vec![[400.0, 70.0], [700.0, 3.0]]),
            Spectrum::Illuminant([0.447_57, 0.407_45]),
        ];
        for spectrum in all {
            let [r, g, b] = spectrum.light();
            let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            assert!((luminance - 1.0).abs() < 2e-3, "{spectrum:?}: {luminance}");
        }
        near(Spectrum::Blackbody(2856.0).light(), Spectrum::Illuminant([0.447_57, 0.407_45]).light(), 0.01);
    }

    #[test]
    fn metals_mirror_what_their_spectra_do() {
        let flat = |x: f32| Spectrum::Samples(vec![[300.0, x], [900.0, x]]);
        let [eta, k] = metal(&flat(1.4), &flat(7.0));
        near(eta, [1.4; 3], 2e-3);
        near(k, [7.0; 3], 2e-2);
    }
}
