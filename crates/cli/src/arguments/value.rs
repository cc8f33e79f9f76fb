// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of options: from text to numbers, vectors, names. Each error says what would be right.
//! Source: original; the ranges are the contract of the command line.
//! Invariant: no value leaves here that is NaN, infinite or out of its range. Proof: `tests`.

use std::fmt::Display;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use gnurt::accel::Memory;
use gnurt::denoise::Method;
use gnurt::image::ToneCurve;
use gnurt::render::{Integrator, ReconstructionFilter};
use gnurt::scene::builtin::SKIES;
use gnurt::simd::Level;
use gnurt::{BUILTIN, Surroundings};
use gnurt_bench::{Class, ENGINES};
use gnurt_view::TevAddress;

use crate::nearest::unknown;

/// Columns and rows of a picture, at least 1 each and 2^31 together at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Resolution {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// A shader for the material of a name, or for all by `*`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ShaderChoice {
    pub(crate) material: String,
    /// Of the shader's class.
    pub(crate) class: String,
    /// The plugin that has the class; none for built-in ones.
    pub(crate) file: Option<PathBuf>,
    /// Names and values.
    pub(crate) parameters: Vec<(String, String)>,
}

/// Column and row of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pixel {
    pub(crate) x: u32,
    pub(crate) y: u32,
}

/// A rectangle of pixels as it was asked for: it may reach beyond the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Crop {
    corners: [i64; 4],
}

const MOST_PIXELS: u64 = 1 << 31;
const MOST_THREADS: usize = 1024;

impl Crop {
    /// The part of it that lies in the frame: `[x0, y0, x1, y1]`, ends exclusive; `None` if there is none.
    pub(crate) fn within(self, frame: Resolution) -> Option<[u32; 4]> {
        let clip = |value: i64, end: u32| u32::try_from(value.clamp(0, i64::from(end))).unwrap_or(end);
        let [x0, y0, x1, y1] = self.corners;
        let [w, h] = [frame.width, frame.height];
        let clipped = [clip(x0, w), clip(y0, h), clip(x1, w), clip(y1, h)];
        (clipped[0] < clipped[2] && clipped[1] < clipped[3]).then_some(clipped)
    }
}

impl Display for Crop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x0, y0, x1, y1] = self.corners;
        write!(f, "{x0},{y0},{x1},{y1}")
    }
}

impl Display for Resolution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// `1280x720`.
pub(crate) fn resolution(text: &str) -> Result<Resolution, String> {
    let form = || "give width and height like 1280x720".to_owned();
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(form)?;
    let side = |digits: &str| match digits.parse::<u64>() {
        Ok(side) => Ok(side),
        // Too many digits for a number is a large number all the same.
        Err(_) if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) => Ok(u64::MAX),
        Err(_) => Err(form()),
    };
    let (width, height) = (side(width)?, side(height)?);
    if width == 0 || height == 0 {
        return Err("a picture without pixels; width and height must be at least 1".into());
    }
    if width.saturating_mul(height) > MOST_PIXELS {
        return Err(format!("too many pixels; at most {MOST_PIXELS} in all"));
    }
    let side = |side: u64| u32::try_from(side).map_err(|_| form());
    Ok(Resolution { width: side(width)?, height: side(height)? })
}

/// `12,34`.
pub(crate) fn pixel(text: &str) -> Result<Pixel, String> {
    let form = "give column and row like 12,34, counted from 0 at the upper left corner";
    let [x, y] = list::<2, u32>(text, form)?;
    Ok(Pixel { x, y })
}

/// `0,0,640,360`.
pub(crate) fn crop(text: &str) -> Result<Crop, String> {
    let form = "give x0,y0,x1,y1 in pixels like 0,0,640,360; x1 and y1 are excluded";
    Ok(Crop { corners: list(text, form)? })
}

/// Three numbers.
pub(crate) fn point(text: &str) -> Result<[f32; 3], String> {
    let numbers: [f32; 3] = list(text, "give three numbers like 0,1.5,-3")?;
    if numbers.iter().all(|x| x.is_finite()) {
        Ok(numbers)
    } else {
        Err("not a finite number; give three numbers like 0,1.5,-3".into())
    }
}

/// Three numbers that are not all zero.
pub(crate) fn direction(text: &str) -> Result<[f32; 3], String> {
    match point(text)? {
        [0.0, 0.0, 0.0] => Err("zero points nowhere; give a direction like 0,1,0".into()),
        direction => Ok(direction),
    }
}

/// Degrees between 0 and 180.
pub(crate) fn angle_of_view(text: &str) -> Result<f32, String> {
    let degrees = number(text)?;
    // An angle that rounds to 0 or to 180 in single precision shows nothing either.
    let usable = (1e-4..=179.999).contains(&degrees);
    if usable { Ok(degrees) } else { Err("give degrees above 0 and below 180".into()) }
}

/// 1 to 2^31 - 1.
pub(crate) fn samples(text: &str) -> Result<u32, String> {
    whole(text, 1, i32::MAX.unsigned_abs())
}

/// 0 to 2^64 - 1.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    whole(text, 0, u64::MAX)
}

/// 0 to 1000.
pub(crate) fn depth(text: &str) -> Result<u32, String> {
    whole(text, 0, 1000)
}

/// 1 to 2^20.
pub(crate) fn virtual_lights(text: &str) -> Result<u32, String> {
    whole(text, 1, 1 << 20)
}

/// 1, 3, 5 or 7.
pub(crate) fn interleave(text: &str) -> Result<u32, String> {
    let n = whole(text, 1, 7).ok().filter(|n| n % 2 == 1);
    n.ok_or_else(|| "give 1, 3, 5 or 7".into())
}

/// A number, at least 0; `inf` is one.
pub(crate) fn clamp(text: &str) -> Result<f32, String> {
    let value = text.parse::<f32>().ok().filter(|value| *value >= 0.0);
    value.ok_or_else(|| "give a number that is not negative, like 2.5".into())
}

/// A share above 0.
pub(crate) fn noise(text: &str) -> Result<f32, String> {
    let value = text.parse::<f32>().ok().filter(|value| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| "give a share above 0, like 0.02 for two per cent".into())
}

/// 0 to 1024.
pub(crate) fn threads(text: &str) -> Result<usize, String> {
    whole(text, 0, MOST_THREADS)
}

/// A finite number, at least 0.
pub(crate) fn tolerance(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite() && *value >= 0.0);
    value.ok_or_else(|| "give a number that is not negative, like 0.01".into())
}

/// -64 to 64 stops.
pub(crate) fn exposure(text: &str) -> Result<f32, String> {
    let stops = number(text)?;
    if stops.abs() <= 64.0 { Ok(stops) } else { Err("give stops from -64 to 64".into()) }
}

/// `90`, `90s`, `1.5m`, `2h`, `500ms`.
pub(crate) fn time(text: &str) -> Result<Duration, String> {
    let form = || "give a time above 0 like 90, 90s, 1.5m or 2h".to_owned();
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0), ("", 1.0)];
    let (digits, unit) =
        units.iter().find_map(|(name, unit)| Some((text.strip_suffix(name)?, unit))).ok_or_else(form)?;
    let seconds = digits.trim_end().parse::<f64>().map_err(|_| form())? * unit;
    let time = Duration::try_from_secs_f64(seconds).map_err(|_| form())?;
    if time.is_zero() { Err(form()) } else { Ok(time) }
}

/// Degrees, both ways around.
pub(crate) fn turn(text: &str) -> Result<f64, String> {
    let degrees = f64::from(number(text)?);
    if degrees.abs() <= 1e6 { Ok(degrees) } else { Err("give degrees from -1000000 to 1000000".into()) }
}

/// A radiance, a sky of the program, or a file.
pub(crate) fn surroundings(text: &str) -> Result<Surroundings, String> {
    if let Some(name) = text.strip_prefix(BUILTIN) {
        let names: Vec<&str> = SKIES.iter().map(|sky| sky.name).collect();
        return Surroundings::sky(name).ok_or_else(|| unknown("built-in sky", name, &names));
    }
    if text.is_empty() {
        return Err("give a picture, a radiance like 1,1,1 or builtin:day".into());
    }
    match point(text) {
        Ok(radiance) if radiance.iter().any(|&x| x < 0.0) => {
            Err("light is not negative; give R,G,B of 0 or more".into())
        }
        Ok(radiance) => Ok(Surroundings::Uniform(radiance)),
        Err(_) => Ok(Surroundings::Picture(text.into())),
    }
}

/// `MATERIAL=CLASS[@FILE][:NAME=VALUE...]`.
pub(crate) fn shader(text: &str) -> Result<ShaderChoice, String> {
    const RIGHT: &str =
        "give MATERIAL=CLASS, or MATERIAL=CLASS@FILE for a plugin's, and parameters as :NAME=VALUE";
    let mut parts = text.split(':');
    let (material, class) = parts.next().and_then(|part| part.split_once('=')).ok_or(RIGHT)?;
    let (class, file) = class.split_once('@').map_or((class, None), |(class, file)| (class, Some(file)));
    if material.is_empty() || class.is_empty() || file.is_some_and(str::is_empty) {
        return Err(RIGHT.into());
    }
    let pair = |part: &str| match part.split_once('=') {
        Some((name, value)) if !name.is_empty() && !value.is_empty() => {
            Ok((name.to_owned(), value.to_owned()))
        }
        _ => Err(format!("'{part}' is no parameter; {RIGHT}")),
    };
    let parameters = parts.map(pair).collect::<Result<_, _>>()?;
    Ok(ShaderChoice {
        material: material.to_owned(),
        class: class.to_owned(),
        file: file.map(PathBuf::from),
        parameters,
    })
}

/// `tev:HOST:PORT`.
pub(crate) fn display(text: &str) -> Result<TevAddress, String> {
    text.parse()
}

/// An integrator's name.
pub(crate) fn integrator(name: &str) -> Result<Integrator, String> {
    by_name("integrator", name, &Integrator::ALL[..])
}

/// A denoiser's name.
pub(crate) fn denoiser(name: &str) -> Result<Method, String> {
    let names = Method::ALL.map(Method::name);
    name.parse().map_err(|_| unknown("denoiser", name, &names))
}

/// A reconstruction filter's name.
pub(crate) fn filter(name: &str) -> Result<ReconstructionFilter, String> {
    by_name("filter", name, &ReconstructionFilter::ALL[..])
}

/// A tone curve's name.
pub(crate) fn tone(name: &str) -> Result<ToneCurve, String> {
    by_name("tone curve", name, &ToneCurve::ALL)
}

/// What trees are made for.
pub(crate) fn memory(name: &str) -> Result<Memory, String> {
    match name {
        "fast" => Ok(Memory::Fast),
        "compact" => Ok(Memory::Compact),
        _ => Err(unknown("kind of trees", name, &["fast", "compact"])),
    }
}

/// An instruction set's name; this CPU must have it.
pub(crate) fn isa(name: &str) -> Result<Level, String> {
    let names: Vec<&str> = std::iter::once("auto").chain(Level::ALL.map(Level::name)).collect();
    match name.parse() {
        Ok(level) => Ok(level),
        Err(lacking) if names.contains(&name) => Err(format!("{lacking}")),
        Err(_) => {
            let here: Vec<&str> = Level::available().into_iter().map(Level::name).collect();
            Err(format!("{}; this CPU has: {}", unknown("instruction set", name, &names), here.join(", ")))
        }
    }
}

/// The name of a class of rays.
pub(crate) fn ray_class(name: &str) -> Result<Class, String> {
    by_name("class of rays", name, &Class::ALL)
}

/// The name of an engine.
pub(crate) fn engine(name: &str) -> Result<String, String> {
    by_name("engine", name, &ENGINES).map(str::to_owned)
}

/// Columns of primary rays.
pub(crate) fn columns(text: &str) -> Result<u32, String> {
    whole(text, 8, 8192)
}

/// How often something is measured.
pub(crate) fn rounds(text: &str) -> Result<usize, String> {
    whole(text, 1, 1000)
}

/// Rays per batch.
pub(crate) fn batch(text: &str) -> Result<usize, String> {
    whole(text, 1, 1 << 24)
}

fn by_name<T: Copy + Display>(what: &str, name: &str, all: &[T]) -> Result<T, String> {
    let names: Vec<String> = all.iter().map(ToString::to_string).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let place = names.iter().position(|&known| known == name).ok_or_else(|| unknown(what, name, &names))?;
    Ok(all[place])
}

/// A whole number in a range, both ends included.
fn whole<T: FromStr + PartialOrd + Display>(text: &str, least: T, most: T) -> Result<T, String> {
    let value = text.parse::<T>().ok().filter(|value| *value >= least && *value <= most);
    value.ok_or_else(|| format!("give a whole number from {least} to {most}"))
}

/// A finite number in single precision.
fn number(text: &str) -> Result<f32, String> {
    let value = text.trim().parse::<f32>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| "not a finite number".into())
}

/// Exactly `N` values between commas.
fn list<const N: usize, T: FromStr>(text: &str, form: &str) -> Result<[T; N], String> {
    let values: Result<Vec<T>, _> = text.split(',').map(|part| part.trim().parse::<T>()).collect();
    values.ok().and_then(|values| values.try_into().ok()).ok_or_else(|| form.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(resolution("640x480"), Ok(Resolution { width: 640, height: 480 }), "the usual form");
        assert!(resolution("65536x32768").is_ok(), "2^31 pixels are allowed");
        for bad in
            ["", "640", "0x0", "10x0", "-1x5", "65536x32769", "99999999999999999999x1", "1x2x3", "1.5x2", "x"]
        {
            assert!(resolution(bad).is_err(), "'{bad}' is no size");
        }
    }

    #[test]
    fn crops_are_clipped_to_the_frame() {
        let frame = Resolution { width: 10, height: 8 };
        let clipped = |text| crop(text).expect("four numbers").within(frame);
        assert_eq!(clipped("-5,2,99,99"), Some([0, 2, 10, 8]), "the part inside");
        assert_eq!(clipped("10,0,20,8"), None, "beside the frame");
        assert_eq!(clipped("5,5,5,6"), None, "no width");
        assert_eq!(clipped("6,0,5,8"), None, "turned round");
        assert!(
            crop("1,2,3").is_err() && crop("1,2,3,4,5").is_err() && crop("a,b,c,d").is_err(),
            "four numbers"
        );
    }

    #[test]
    fn times() {
        for (text, seconds) in [("90", 90.0), ("90s", 90.0), ("1.5m", 90.0), ("2h", 7200.0), ("500ms", 0.5)] {
            assert_eq!(time(text), Ok(Duration::from_secs_f64(seconds)), "'{text}'");
        }
        for bad in ["", "0", "-1", "s", "nan", "inf", "1e300", "5 minutes", "1d"] {
            assert!(time(bad).is_err(), "'{bad}' is no time");
        }
    }

    #[test]
    fn numbers_are_finite_and_in_range() {
        assert_eq!(point("-0.5,1,3e0"), Ok([-0.5, 1.0, 3.0]), "a point");
        for bad in ["1,2", "1,2,3,4", "nan,0,0", "inf,0,0", "1e99,0,0", "1,,2", "1;2;3", ""] {
            assert!(point(bad).is_err(), "'{bad}' is no point");
        }
        assert!(direction("0,0,-0").is_err(), "no direction");
        for bad in ["0", "180", "-5", "360", "nan", "1e-9", "179.99999"] {
            assert!(angle_of_view(bad).is_err(), "'{bad}' is no angle of view");
        }
        assert_eq!(samples("2147483647"), Ok(2_147_483_647), "the most samples");
        assert!(
            samples("2147483648").is_err() && samples("0").is_err() && samples("-1").is_err(),
            "out of range"
        );
        assert_eq!(seed("18446744073709551615"), Ok(u64::MAX), "the largest seed");
        assert!(seed("18446744073709551616").is_err(), "beyond it");
        assert_eq!(threads("1024"), Ok(1024), "the most threads");
        assert!(threads("1025").is_err(), "more than that");
        assert!(
            tolerance("nan").is_err() && tolerance("-1").is_err() && tolerance("0.5").is_ok(),
            "tolerances"
        );
        assert!(exposure("-3").is_ok() && exposure("65").is_err(), "stops");
    }

    #[test]
    fn names_are_suggested() {
        assert_eq!(integrator("whitted"), Ok(Integrator::Whitted), "a name");
        let message = integrator("wited").expect_err("a slip");
        assert!(message.contains("did you mean 'whitted'"), "{message}");
        let message = isa("avx3").expect_err("no such level");
        assert!(message.contains("scalar") && message.contains("did you mean"), "{message}");
        assert!(filter("tent").expect_err("a stranger").contains("blackman-harris"), "the list");
        assert!(tone("aces").is_err(), "no such curve");
    }
}
