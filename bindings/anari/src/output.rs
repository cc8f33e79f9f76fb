// SPDX-License-Identifier: GPL-3.0-or-later
//! A frame's channels in the formats that the program asked for; row 0 is the lowest one.
//! Source: ANARI 1.1, frames. Tests: tests/channels.rs.

use gnurt::image::srgb;

use crate::attribute::Color;
use crate::first_hit::{FirstHit, NO_ID};
use crate::object::Snapshot;
use crate::types::{self, DataType};

/// The channels, by parameter name.
pub(crate) const CHANNELS: [&str; 7] = [
    "channel.color",
    "channel.depth",
    "channel.normal",
    "channel.albedo",
    "channel.primitiveId",
    "channel.objectId",
    "channel.instanceId",
];

/// Formats that a program asked for, by channel.
pub(crate) type Formats = [Option<DataType>; 7];

/// The formats of a frame; those that a channel cannot have are named.
pub(crate) fn formats(now: &Snapshot, fault: &mut dyn FnMut(&str, DataType)) -> Formats {
    const ALLOWED: [&[DataType]; 7] = [
        &[types::UFIXED8_VEC4, types::UFIXED8_RGBA_SRGB, types::FLOAT32_VEC4],
        &[types::FLOAT32],
        &[types::FIXED16_VEC3, types::FLOAT32_VEC3],
        &[types::UFIXED8_VEC3, types::UFIXED8_RGB_SRGB, types::FLOAT32_VEC3],
        &[types::UINT32],
        &[types::UINT32],
        &[types::UINT32],
    ];
    std::array::from_fn(|k| {
        let format = now.u32(CHANNELS[k])? as DataType;
        if ALLOWED[k].contains(&format) {
            return Some(format);
        }
        if format != types::UNKNOWN {
            fault(CHANNELS[k], format);
        }
        None
    })
}

/// A finished picture.
#[derive(Default)]
pub(crate) struct Output {
    pub(crate) size: [u32; 2],
    /// Words, so that all formats are aligned.
    channels: [Option<(DataType, Vec<u64>)>; 7],
    /// Seconds that it took.
    pub(crate) duration: f32,
    /// Samples of each pixel so far.
    pub(crate) samples: u32,
}

/// Bytes in words.
fn words(bytes: &[u8]) -> Vec<u64> {
    let word = |chunk: &[u8]| {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        u64::from_ne_bytes(word)
    };
    bytes.chunks(8).map(word).collect()
}

fn byte(x: f32) -> u8 {
    // NaN becomes 0.
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

fn floats(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_ne_bytes).collect()
}

fn color(format: DataType, pixels: &[Color]) -> Vec<u8> {
    match format {
        types::FLOAT32_VEC4 => floats(pixels.iter().flatten().copied()),
        types::UFIXED8_RGBA_SRGB => pixels
            .iter()
            .flat_map(|&[r, g, b, a]| [srgb::encode_u8(r), srgb::encode_u8(g), srgb::encode_u8(b), byte(a)])
            .collect(),
        _ => pixels.iter().flatten().map(|&x| byte(x)).collect(),
    }
}

fn first_hit(channel: usize, format: DataType, first_hits: &[FirstHit]) -> Vec<u8> {
    let ids = |id: fn(&FirstHit) -> u32| {
        first_hits.iter().flat_map(|first_hit| id(first_hit).to_ne_bytes()).collect()
    };
    match (channel, format) {
        (1, _) => floats(first_hits.iter().map(|first_hit| first_hit.depth)),
        (2, types::FIXED16_VEC3) => {
            let fixed = |x: f32| ((x.clamp(-1.0, 1.0) * f32::from(i16::MAX)).round() as i16).to_ne_bytes();
            first_hits.iter().flat_map(|first_hit| first_hit.normal.to_array()).flat_map(fixed).collect()
        }
        (2, _) => floats(first_hits.iter().flat_map(|first_hit| first_hit.normal.to_array())),
        (3, types::FLOAT32_VEC3) => {
            floats(first_hits.iter().flat_map(|first_hit| first_hit.albedo.to_array()))
        }
        (3, types::UFIXED8_RGB_SRGB) => {
            first_hits.iter().flat_map(|first_hit| first_hit.albedo.to_array()).map(srgb::encode_u8).collect()
        }
        (3, _) => first_hits.iter().flat_map(|first_hit| first_hit.albedo.to_array()).map(byte).collect(),
        (4, _) => ids(|first_hit| first_hit.primitive),
        (5, _) => ids(|first_hit| first_hit.object),
        _ => ids(|first_hit| first_hit.instance),
    }
}

impl Output {
    /// The channels of a picture; both lists begin with the lowest row.
    pub(crate) fn new(size: [u32; 2], formats: &Formats, pixels: &[Color], first_hits: &[FirstHit]) -> Self {
        let channels = std::array::from_fn(|k| {
            let format = formats[k]?;
            let bytes = if k == 0 { color(format, pixels) } else { first_hit(k, format, first_hits) };
            Some((format, words(&bytes)))
        });
        Self { size, channels, duration: 0.0, samples: 0 }
    }

    /// A picture of nothing, for frames that cannot be rendered.
    pub(crate) fn empty(size: [u32; 2], formats: &Formats) -> Self {
        let count = size[0] as usize * size[1] as usize;
        let nothing = FirstHit {
            depth: f32::INFINITY,
            normal: glam::Vec3::ZERO,
            albedo: glam::Vec3::ZERO,
            primitive: NO_ID,
            object: NO_ID,
            instance: NO_ID,
        };
        Self::new(size, formats, &vec![[0.0; 4]; count], &vec![nothing; count])
    }

    /// Format and address of a channel by name.
    pub(crate) fn channel(&self, name: &str) -> Option<(DataType, *const u64)> {
        let index = CHANNELS.iter().position(|channel| *channel == name)?;
        self.channels[index].as_ref().map(|(format, words)| (*format, words.as_ptr()))
    }
}
