// SPDX-License-Identifier: GPL-3.0-or-later
//! Colour spaces of files, converted to sRGB: ICC profiles, and primaries and curves that a PNG gives by numbers.
//! Source: ICC.1:2022, read by `moxcms`; PNG specification, third edition, sections 11.3.2 (cHRM, gAMA, cICP).
//! Colours outside of sRGB are cut off. A profile that changes no colour by more than a byte's step is skipped, so
//! that pictures in sRGB stay as they are. The curves of HDR (PQ, HLG) are not converted. Tests:
//! `tests/profiles.rs`.

use image::DynamicImage;
use moxcms::{ColorProfile, DataColorSpace, Layout, TransformOptions};

use crate::chromaticities::{Chromaticities, REC709};
use crate::srgb;

/// Primaries and curve by numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Space {
    /// Red, green, blue and white.
    pub(super) primaries: Option<Chromaticities>,
    /// Linear light is the value to this power; `None` = sRGB's curve.
    pub(super) power: Option<f32>,
}

/// A conversion to sRGB.
#[derive(Clone)]
pub(super) enum Conversion {
    Profile(Box<ColorProfile>),
    Space { rows: [[f32; 3]; 3], power: Option<f32> },
}

impl Conversion {
    /// That of an ICC profile, if it has an effect.
    pub(super) fn of_profile(bytes: &[u8]) -> Option<Self> {
        let profile = ColorProfile::new_from_slice(bytes).ok()?;
        // Others describe inks or measurements.
        if !matches!(profile.color_space, DataColorSpace::Rgb | DataColorSpace::Gray) {
            return None;
        }
        let made = Self::Profile(Box::new(profile));
        let probes: Vec<u8> = (0..6_u8)
            .flat_map(|i| {
                (0..6_u8).flat_map(move |j| (0..6_u8).flat_map(move |k| [51 * i, 51 * j, 51 * k, 255]))
            })
            .collect();
        let mut image = DynamicImage::ImageRgba8(image::RgbaImage::from_raw(216, 1, probes.clone())?);
        if !made.apply(&mut image) {
            return None;
        }
        let after = image.into_rgba8().into_raw();
        let is_other = after.iter().zip(&probes).any(|(a, b)| a.abs_diff(*b) > 1);
        is_other.then_some(made)
    }

    /// That of primaries and a curve, if it has an effect.
    pub(super) fn of_space(space: &Space) -> Option<Self> {
        // Nearly sRGB's curve, as old files write it.
        let power = space.power.filter(|power| (power - 2.2).abs() > 0.03);
        let primaries = space.primaries.filter(|primaries| !primaries.is_near(&REC709));
        if power.is_none() && primaries.is_none() {
            return None;
        }
        let rows = primaries.map_or(Some(crate::chromaticities::IDENTITY), |from| from.to(&REC709))?;
        Some(Self::Space { rows, power })
    }

    /// Converts a picture; whether it could.
    pub(super) fn apply(&self, image: &mut DynamicImage) -> bool {
        let is_wide = image.color().bytes_per_pixel() > image.color().channel_count();
        let is_grey = !image.color().has_color();
        match self {
            Self::Profile(profile) => {
                // A profile of grey has one channel.
                let is_of_grey = profile.color_space == DataColorSpace::Gray;
                if is_of_grey && !is_grey {
                    return false;
                }
                let (from, options) =
                    (if is_of_grey { Layout::Gray } else { Layout::Rgba }, TransformOptions::default());
                let srgb = ColorProfile::new_srgb();
                if is_wide {
                    let Ok(transform) = profile.create_transform_16bit(from, &srgb, Layout::Rgba, options)
                    else {
                        return false;
                    };
                    let mut pixels = std::mem::take(image).into_rgba16();
                    rows(&mut pixels, is_of_grey, |from, to| transform.transform(from, to).is_ok());
                    *image = DynamicImage::ImageRgba16(pixels);
                } else {
                    let Ok(transform) = profile.create_transform_8bit(from, &srgb, Layout::Rgba, options)
                    else {
                        return false;
                    };
                    let mut pixels = std::mem::take(image).into_rgba8();
                    rows(&mut pixels, is_of_grey, |from, to| transform.transform(from, to).is_ok());
                    *image = DynamicImage::ImageRgba8(pixels);
                }
                true
            }
            Self::Space { rows, power } => {
                let decode = |encoded: f32| power.map_or_else(|| srgb::decode(encoded), |p| encoded.powf(p));
                let convert = |[r, g, b]: [f32; 3]| {
                    let linear = [decode(r), decode(g), decode(b)];
                    rows.map(|row| {
                        let sum = row[0] * linear[0] + row[1] * linear[1] + row[2] * linear[2];
                        srgb::encode(sum.clamp(0.0, 1.0))
                    })
                };
                if is_wide {
                    let mut pixels = std::mem::take(image).into_rgba16();
                    for pixel in pixels.pixels_mut() {
                        let [r, g, b, a] = pixel.0;
                        let [r, g, b] = convert([r, g, b].map(|x| f32::from(x) / 65535.0));
                        let [r, g, b] = [r, g, b].map(|x| (x * 65535.0 + 0.5) as u16);
                        pixel.0 = [r, g, b, a];
                    }
                    *image = DynamicImage::ImageRgba16(pixels);
                } else {
                    let mut pixels = std::mem::take(image).into_rgba8();
                    for pixel in pixels.pixels_mut() {
                        let [r, g, b, a] = pixel.0;
                        let [r, g, b] = convert([r, g, b].map(|x| f32::from(x) / 255.0));
                        let [r, g, b] = [r, g, b].map(|x| (x * 255.0 + 0.5) as u8);
                        pixel.0 = [r, g, b, a];
                    }
                    *image = DynamicImage::ImageRgba8(pixels);
                }
                true
            }
        }
    }
}

/// Converts a picture row by row; opacity stays.
fn rows<T: image::Primitive>(
    image: &mut image::ImageBuffer<image::Rgba<T>, Vec<T>>,
    is_grey: bool,
    mut convert: impl FnMut(&[T], &mut [T]) -> bool,
) where
    image::Rgba<T>: image::Pixel<Subpixel = T>,
{
    let width = image.width() as usize;
    let mut out = vec![T::DEFAULT_MIN_VALUE; 4 * width];
    for row in image.as_flat_samples_mut().samples.chunks_exact_mut(4 * width) {
        let done = match is_grey {
            true => {
                let grey: Vec<T> = row.chunks_exact(4).map(|pixel| pixel[0]).collect();
                convert(&grey, &mut out)
            }
            false => convert(row, &mut out),
        };
        if !done {
            return;
        }
        for (pixel, new) in row.chunks_exact_mut(4).zip(out.chunks_exact(4)) {
            pixel[..3].copy_from_slice(&new[..3]);
        }
    }
}
