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
use gnurt::render::{Integrator, Piece, ReconstructionFilter};
use gnurt::scene::Projection;
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

/// Which camera, and what it looks through.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum CameraChoice {
    /// The scene's of this name or number.
    Named(String),
    /// A shader in the place of that; of the first one where its `material`, a camera here, is empty.
    Script(ShaderChoice),
}

/// How noise is to be taken out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DenoiserChoice {
    /// Not at all.
    None,
    /// By this filter.
    By(Method),
}

/// How bright a picture for a screen is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ExposureChoice {
    /// As suits the picture.
    Auto,
    /// So many stops, each of which doubles the light.
    Stops(f32),
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

/// Frames of an animation, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameRange {
    pub(crate) first: u32,
    pub(crate) last: u32,
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

/// `2/8`.
pub(crate) fn piece(text: &str) -> Result<Piece, String> {
    const MOST: u32 = 1 << 20;
    let form = || format!("give the number of the piece and how many there are like 2/8, from 1 to {MOST}");
    let (index, count) = text.split_once('/').ok_or_else(form)?;
    let number = |text: &str| text.parse::<u32>().ok().filter(|number| (1..=MOST).contains(number));
    let (index, count) = number(index).zip(number(count)).ok_or_else(form)?;
    if index > count {
        return Err(format!("there is no piece {index} of {count}; pieces count from 1"));
    }
    Ok(Piece { index: index - 1, count })
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

/// Degrees above 0, up to 360; how many a projection takes shows when it is known.
pub(crate) fn angle_of_view(text: &str) -> Result<f32, String> {
    let degrees = number(text)?;
    // An angle that rounds to 0 in single precision shows nothing either.
    let usable = (1e-4..=360.0).contains(&degrees);
    if usable {
        Ok(degrees)
    } else {
        Err("give degrees above 0 and below 180, or of a fisheye at most 360".into())
    }
}

/// A projection's name; the height of an orthographic one comes by an option of its own and is 0 here.
pub(crate) fn projection(name: &str) -> Result<Projection, String> {
    let all = [
        Projection::Perspective,
        Projection::Orthographic { height: 0.0 },
        Projection::Fisheye,
        Projection::Panorama,
    ];
    by_name("projection", name, &all)
}

/// A length above 0.
pub(crate) fn length(text: &str) -> Result<f32, String> {
    let length = number(text)?;
    if length > 0.0 { Ok(length) } else { Err("give a length above 0".into()) }
}

/// A diameter of 0 or above.
pub(crate) fn aperture(text: &str) -> Result<f32, String> {
    let diameter = number(text)?;
    if diameter >= 0.0 { Ok(diameter) } else { Err("give a diameter of 0 or above".into()) }
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

/// -64 to 64 stops, or to be chosen from the picture.
pub(crate) fn exposure(text: &str) -> Result<ExposureChoice, String> {
    if text == "auto" {
        return Ok(ExposureChoice::Auto);
    }
    let right = || "give stops from -64 to 64, or auto".to_owned();
    let stops = number(text).map_err(|_| right())?;
    if stops.abs() <= 64.0 { Ok(ExposureChoice::Stops(stops)) } else { Err(right()) }
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

/// A radiance, a sky of the program, or a file; `FILE.osl[:NAME=VALUE...]` if that is a shader.
pub(crate) fn surroundings(text: &str) -> Result<Surroundings, String> {
    if let Some(name) = text.strip_prefix(BUILTIN) {
        let names: Vec<&str> = SKIES.iter().map(|sky| sky.name).collect();
        return Surroundings::sky(name).ok_or_else(|| unknown("built-in sky", name, &names));
    }
    if text.is_empty() {
        return Err("give a picture, a radiance like 1,1,1 or builtin:day".into());
    }
    let first = pieces(text, ':')[0];
    let is_script = split_plain(first, '=').is_none() && gnurt_plugins::is_script(first);
    match point(text) {
        Ok(radiance) if radiance.iter().any(|&x| x < 0.0) => {
            Err("light is not negative; give R,G,B of 0 or more".into())
        }
        Ok(radiance) => Ok(Surroundings::Uniform(radiance)),
        Err(_) if is_script => match shader(text)? {
            ShaderChoice { class, file: None, parameters, .. } => {
                Ok(Surroundings::Shader(class.into(), parameters))
            }
            _ => Ok(Surroundings::Picture(text.into())),
        },
        Err(_) => Ok(Surroundings::Picture(text.into())),
    }
}

/// `MATERIAL=CLASS[@FILE][:NAME=VALUE...]`. A backslash before `:`, `=`, `@` or a backslash makes it a letter like any other.
pub(crate) fn shader(text: &str) -> Result<ShaderChoice, String> {
    const RIGHT: &str = "give MATERIAL=CLASS, MATERIAL=FILE.osl, or MATERIAL=CLASS@FILE for a plugin's, and parameters as :NAME=VALUE; \
                         within names \\ stands before :, = and @";
    let mut parts = pieces(text, ':').into_iter();
    let first = parts.next().unwrap_or_default();
    // A light's file says by itself what it is for.
    let of_no_material = split_plain(first, '=').is_none() && gnurt_plugins::is_script(first);
    let (material, class) =
        if of_no_material { ("", first) } else { split_plain(first, '=').ok_or(RIGHT)? };
    let (class, file) =
        split_plain(class, '@').map_or((class, None), |(class, file)| (class, Some(unescaped(file))));
    if material.is_empty() != of_no_material
        || class.is_empty()
        || file.as_ref().is_some_and(String::is_empty)
    {
        return Err(RIGHT.into());
    }
    let pair = |part: &str| match split_plain(part, '=') {
        Some((name, value)) if !name.is_empty() && !value.is_empty() => {
            Ok((unescaped(name), unescaped(value)))
        }
        _ => Err(format!("'{part}' is no parameter; {RIGHT}")),
    };
    let parameters = parts.map(pair).collect::<Result<_, _>>()?;
    let (material, class) = (unescaped(material), unescaped(class));
    Ok(ShaderChoice { material, class, file: file.map(PathBuf::from), parameters })
}

/// `[NAME=]FILE.osl[:NAME=VALUE...]`, or else a name or a number.
pub(crate) fn camera(text: &str) -> Result<CameraChoice, String> {
    let first = pieces(text, ':')[0];
    let file = split_plain(first, '=').map_or(first, |(_, file)| file);
    if gnurt_plugins::is_script(file) {
        shader(text).map(CameraChoice::Script)
    } else {
        Ok(CameraChoice::Named(text.to_owned()))
    }
}

/// `FILE.osl[:NAME=VALUE...]`.
pub(crate) fn pixel_shader(text: &str) -> Result<ShaderChoice, String> {
    let choice = shader(text).ok().filter(|choice| choice.material.is_empty());
    choice.ok_or_else(|| {
        "give FILE.osl, and parameters as :NAME=VALUE; within names \\ stands before :, = and @".to_owned()
    })
}

/// What has a meaning in `--shader`, unless a backslash stands before it.
const SHADER_SIGNS: [char; 4] = [':', '=', '@', '\\'];

/// What stands before and after the first `sign` that no backslash stands before.
fn split_plain(text: &str, sign: char) -> Option<(&str, &str)> {
    let mut letters = text.char_indices().peekable();
    while let Some((at, letter)) = letters.next() {
        if letter == '\\' && letters.peek().is_some_and(|(_, next)| SHADER_SIGNS.contains(next)) {
            letters.next();
        } else if letter == sign {
            return Some((&text[..at], &text[at + sign.len_utf8()..]));
        }
    }
    None
}

/// The pieces between signs that no backslash stands before.
fn pieces(mut text: &str, sign: char) -> Vec<&str> {
    let mut pieces = Vec::new();
    while let Some((piece, rest)) = split_plain(text, sign) {
        pieces.push(piece);
        text = rest;
    }
    pieces.push(text);
    pieces
}

/// The text without the backslashes that take a sign's meaning away; all others stay.
fn unescaped(text: &str) -> String {
    let mut letters = text.chars().peekable();
    let mut plain = String::new();
    while let Some(letter) = letters.next() {
        let sign = letters.next_if(|next| letter == '\\' && SHADER_SIGNS.contains(next));
        plain.push(sign.unwrap_or(letter));
    }
    plain
}

/// `tev:HOST:PORT`.
pub(crate) fn display(text: &str) -> Result<TevAddress, String> {
    text.parse()
}

/// An integrator's name.
pub(crate) fn integrator(name: &str) -> Result<Integrator, String> {
    by_name("integrator", name, &Integrator::ALL[..])
}

/// A denoiser's name, or none.
pub(crate) fn denoiser(name: &str) -> Result<DenoiserChoice, String> {
    const NONE: &str = "none";
    if name == NONE {
        return Ok(DenoiserChoice::None);
    }
    let names: Vec<&str> = Method::ALL.into_iter().map(Method::name).chain([NONE]).collect();
    name.parse().map(DenoiserChoice::By).map_err(|_| unknown("denoiser", name, &names))
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

/// A case of `bench dynamic`.
pub(crate) fn motion_case(name: &str) -> Result<String, String> {
    by_name("case", name, &MOTION_CASES).map(str::to_owned)
}

const MOTION_CASES: [&str; 6] = ["refit", "rebuild", "top", "stadium", "crowd", "crowd64"];

/// Instances of the case `top`.
pub(crate) fn instances(text: &str) -> Result<usize, String> {
    whole(text, 1, 10_000_000)
}

/// Characters of a crowd.
pub(crate) fn characters(text: &str) -> Result<usize, String> {
    whole(text, 1, 100_000)
}

/// Columns of primary rays.
pub(crate) fn columns(text: &str) -> Result<u32, String> {
    whole(text, 8, 8192)
}

/// A moment of an animation.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| "give a time in seconds like 1.5".into())
}

/// Frames per second.
pub(crate) fn frames_per_second(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| (1e-6..=1e6).contains(value));
    value.ok_or_else(|| "give frames per second above 0, like 24 or 29.97".into())
}

/// For how many frames a shutter is open.
pub(crate) fn shutter(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| (0.0..=1e6).contains(value));
    value.ok_or_else(|| "give how many frames the shutter is open, 0 or more, like 0.5".into())
}

/// `0..47`, or one number.
pub(crate) fn frames(text: &str) -> Result<FrameRange, String> {
    const MOST: u32 = i32::MAX as u32;
    let number = |text: &str| text.trim().parse::<u32>().ok().filter(|&number| number <= MOST);
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    let form = || format!("give the first and the last frame like 0..47, whole numbers up to {MOST}");
    let (first, last) = number(first).zip(number(last)).ok_or_else(form)?;
    if last < first {
        return Err(format!("the last frame is before the first; did you mean {last}..{first}?"));
    }
    Ok(FrameRange { first, last })
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
        for bad in ["0", "-5", "361", "nan", "1e-9"] {
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
    fn frames_have_both_ends() {
        let range = |first, last| Ok(FrameRange { first, last });
        assert_eq!(
            (frames("0..47"), frames("7"), frames("5..5")),
            (range(0, 47), range(7, 7), range(5, 5)),
            "ends"
        );
        assert!(frames("5..2").expect_err("turned round").contains("did you mean 2..5?"), "turned round");
        for bad in ["", "..", "1..", "..2", "-1..2", "1...2", "1..2147483648", "1.5..2", "a"] {
            assert!(frames(bad).is_err(), "'{bad}' is no range");
        }
        assert_eq!((seconds("-0.5"), seconds("1e1")), (Ok(-0.5), Ok(10.0)), "moments");
        assert!(seconds("nan").is_err() && seconds("inf").is_err() && seconds("1s").is_err(), "no moments");
        assert!(frames_per_second("0").is_err() && frames_per_second("29.97").is_ok(), "rates");
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

    #[test]
    fn shaders_of_files_with_any_name() {
        let choice = |material: &str, class: &str, file: Option<&str>, parameters: &[(&str, &str)]| {
            let pair = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
            let parameters = parameters.iter().map(pair).collect();
            let (material, class) = (material.to_owned(), class.to_owned());
            Ok(ShaderChoice { material, class, file: file.map(PathBuf::from), parameters })
        };
        for (text, wanted) in [
            ("*=Phong", choice("*", "Phong", None, &[])),
            ("a=b@c.so:d=1,2:e=@f.png", choice("a", "b", Some("c.so"), &[("d", "1,2"), ("e", "@f.png")])),
            // Signs that have no meaning where they stand need no backslash.
            ("a=b@x@y=z.so:d=e=f", choice("a", "b", Some("x@y=z.so"), &[("d", "e=f")])),
            (
                r"Glass\:001=b@2026\:01\@home.so:d=@a\:b.png",
                choice("Glass:001", "b", Some("2026:01@home.so"), &[("d", "@a:b.png")]),
            ),
            (r"x\=y=Phong", choice("x=y", "Phong", None, &[])),
            (r"a=b@C\:\dir\c.dll", choice("a", "b", Some(r"C:\dir\c.dll"), &[])),
            (r"a=b@dir\\:d=1", choice("a", "b", Some(r"dir\"), &[("d", "1")])),
        ] {
            assert_eq!(shader(text), wanted, "'{text}'");
        }
        for bad in ["", "a", "=b", "a=", "a=b@", "a=b:", "a=b::c=d", "a=b:c", "a=b:=c", "a=b:c=", r"a\=b"] {
            assert!(shader(bad).is_err(), "'{bad}' is none");
        }
    }
}
