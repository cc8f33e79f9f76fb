// SPDX-License-Identifier: GPL-3.0-or-later
//! The input of a denoiser: the colours of a region, their variance, and the features of first hits.
//! Invariant: all values are finite, for any picture. Tests: `built_in::tests`.

use gnurt_image::{ChannelData, Picture};

use crate::error::Error;

/// Three values.
pub(crate) type Triple = [f32; 3];

/// The layers of light behind mirrors and smooth glass.
const SEEN: [&str; 5] =
    ["seen_light", "seen_split", "seen_direct", "seen_direct_variance", "seen_indirect_variance"];

/// A part of a picture, row by row.
pub(crate) struct Noisy {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Linear light.
    pub(crate) color: Vec<Triple>,
    /// Of each pixel's mean; 0 where it is not known.
    pub(crate) variance: Vec<Triple>,
    /// In 0..1; black where nothing was met.
    pub(crate) albedo: Vec<Triple>,
    /// Means of unit vectors towards the eye; 0 where nothing was met.
    pub(crate) normal: Vec<Triple>,
    /// The directly visible part of the colour, from lights and environment; 0 if unknown.
    pub(crate) emission: Vec<Triple>,
    /// What is known of the light behind mirrors and smooth glass.
    pub(crate) seen: Option<Seen>,
}

/// Light of lamps and environment that is seen directly, or in mirrors and through smooth glass only.
pub(crate) struct Seen {
    /// As it is in the colours, and with less noise.
    pub(crate) light: Vec<Triple>,
    pub(crate) split: Vec<Triple>,
    /// Direct light of the surfaces that are seen.
    pub(crate) direct: Vec<Triple>,
    /// Of the means of direct light, and of all other light.
    pub(crate) variances: [Vec<Triple>; 2],
}

impl Noisy {
    /// Cuts the region out of a picture; values that are not finite become 0.
    pub(crate) fn of(picture: &Picture, region: [u32; 4]) -> Result<Self, Error> {
        picture.check().map_err(|error| Error::Shape(error.to_string()))?;
        let [x0, y0, x1, y1] = region;
        let (columns, rows) = (picture.width, picture.height);
        if x0 >= x1 || y0 >= y1 || x1 > columns || y1 > rows {
            return Err(Error::Region { region, width: columns, height: rows });
        }
        let cut = |value: &dyn Fn(usize) -> Triple| -> Vec<Triple> {
            let pixels =
                (y0..y1).flat_map(|y| (x0..x1).map(move |x| y as usize * columns as usize + x as usize));
            pixels.map(|i| value(i).map(finite)).collect()
        };
        let layer = |name: &str, channels: [&str; 3]| -> Result<Vec<Triple>, Error> {
            let missing = |channel: &str| Error::NoChannel(format!("{name}.{channel}"));
            let find = |channel: &str| {
                let found = picture.layer(name).and_then(|layer| layer.channel(channel));
                match found.map(|channel| &channel.data) {
                    Some(ChannelData::F32(values)) => Ok(values),
                    _ => Err(missing(channel)),
                }
            };
            let [a, b, c] = channels.map(find);
            let (a, b, c) = (a?, b?, c?);
            Ok(cut(&|i| [a[i], b[i], c[i]]))
        };
        let (rgb, xyz) = (["R", "G", "B"], ["X", "Y", "Z"]);
        let is_seen = |name: &str| picture.layer(name).is_some();
        let first = |seen: &'static str, own: &'static str| if is_seen(seen) { seen } else { own };
        let is_known = SEEN.into_iter().all(is_seen);
        let seen = is_known.then(|| -> Result<Seen, Error> {
            Ok(Seen {
                light: layer("seen_light", rgb)?,
                split: layer("seen_split", rgb)?,
                direct: layer("seen_direct", rgb)?,
                variances: [layer("seen_direct_variance", rgb)?, layer("seen_indirect_variance", rgb)?],
            })
        });
        Ok(Self {
            width: (x1 - x0) as usize,
            height: (y1 - y0) as usize,
            color: cut(&|i| [picture.color[i][0], picture.color[i][1], picture.color[i][2]]),
            variance: layer("variance", rgb)?,
            albedo: layer(first("seen_albedo", "albedo"), rgb)?,
            normal: layer(first("seen_N", "N"), xyz)?,
            // Other renderers, and layers of light, have emission by itself.
            emission: match ["unscattered", "emission"].into_iter().find(|name| picture.layer(name).is_some())
            {
                Some(name) => layer(name, rgb)?,
                None => vec![[0.0; 3]; (x1 - x0) as usize * (y1 - y0) as usize],
            },
            seen: seen.transpose()?,
        })
    }
}

fn finite(x: f32) -> f32 {
    if x.is_finite() { x } else { 0.0 }
}
