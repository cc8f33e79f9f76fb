// SPDX-License-Identifier: GPL-3.0-or-later
//! Values for the amount and the method of sampling. See docs/reference/cli.md. Tests: `tests` of
//! `value/mod.rs`.

use gnurt::accel::Memory;
use gnurt::render::{Caustics, Guiding, Integrator, PixelNoise};
use gnurt::simd::Level;

use super::plain::{by_name, whole};
use crate::nearest::unknown;

const MOST_THREADS: usize = 1024;

/// 1 to 2^31 - 1.
pub(crate) fn samples(text: &str) -> Result<u32, String> {
    whole(text, 1, i32::MAX.unsigned_abs())
}

/// 0 to 2^64 - 1.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    whole(text, 0, u64::MAX)
}

/// 1 to 1000: 0 would be no light at all.
pub(crate) fn depth(text: &str) -> Result<u32, String> {
    whole(text, 1, 1000)
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

/// 1 to 2^24.
pub(crate) fn mebibytes(text: &str) -> Result<u64, String> {
    whole(text, 1, 1 << 24)
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

/// An integrator's name.
pub(crate) fn integrator(name: &str) -> Result<Integrator, String> {
    by_name("integrator", name, &Integrator::ALL[..])
}

/// How errors of neighbouring pixels relate.
pub(crate) fn pixel_noise(name: &str) -> Result<PixelNoise, String> {
    by_name("noise", name, &PixelNoise::ALL[..])
}

/// When paths are guided.
pub(crate) fn guide(name: &str) -> Result<Guiding, String> {
    by_name("choice", name, &Guiding::ALL[..])
}

/// Which lamps behind smooth surfaces are searched for.
pub(crate) fn caustics(name: &str) -> Result<Caustics, String> {
    by_name("choice", name, &Caustics::ALL[..])
}

/// The memory layout of trees.
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
