// SPDX-License-Identifier: GPL-3.0-or-later
//! Parts of a picture that can be shown: its colour, and its layers as colours.
//! Layers of R, G, B are colours, those of X, Y, Z are vectors v shown as (v + 1) / 2, those of U, V are red and green. Any other channel is
//! a grey picture of its own, and ids have a colour each. Tests: `tests`.

use std::borrow::Cow;
use std::fmt;

use gnurt::image::{ChannelData, Layer, Picture};

use crate::shown::id_color;

/// A part of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    /// Its colour.
    Color,
    /// A layer of three channels, or of U and V.
    Layer(String),
    /// A channel of a layer.
    Channel(String, String),
}

impl fmt::Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Color => f.write_str("color"),
            Self::Layer(layer) => f.write_str(layer),
            Self::Channel(layer, channel) if layer.is_empty() => f.write_str(channel),
            Self::Channel(layer, channel) => write!(f, "{layer}.{channel}"),
        }
    }
}

/// Channels that make one part together, in the order of red, green and blue.
const TOGETHER: [&[&str]; 3] = [&["R", "G", "B"], &["X", "Y", "Z"], &["U", "V"]];

fn group(layer: &Layer) -> Option<&'static [&'static str]> {
    let floats =
        |name: &&str| layer.channel(name).is_some_and(|channel| matches!(channel.data, ChannelData::F32(_)));
    TOGETHER.into_iter().find(|group| group.iter().all(floats))
}

/// All parts of a picture, its colour first.
#[must_use]
pub fn items(picture: &Picture) -> Vec<Item> {
    let mut all = vec![Item::Color];
    for layer in &picture.layers {
        let together = group(layer).unwrap_or_default();
        if !together.is_empty() {
            all.push(Item::Layer(layer.name.clone()));
        }
        let is_opacity = |name: &str| together.len() == 3 && name == "A";
        let others = layer.channels.iter().map(|channel| &channel.name[..]);
        let others = others.filter(|name| !together.contains(name) && !is_opacity(name));
        all.extend(others.map(|name| Item::Channel(layer.name.clone(), name.to_owned())));
    }
    all
}

impl Item {
    /// The colours of a part; `None` if the picture lacks it.
    pub(crate) fn colors<'a>(&self, picture: &'a Picture) -> Option<Cow<'a, [[f32; 4]]>> {
        let opaque = |color: [f32; 3]| [color[0], color[1], color[2], 1.0];
        Some(match self {
            Self::Color => Cow::Borrowed(&picture.color[..]),
            Self::Layer(name) => {
                let layer = picture.layer(name)?;
                let together = group(layer)?;
                let values = |name: &&str| match &layer.channel(name)?.data {
                    ChannelData::F32(values) => Some(&values[..]),
                    ChannelData::U32(_) => None,
                };
                let channels: Vec<&[f32]> = together.iter().map(values).collect::<Option<_>>()?;
                let is_vector = together[0] == "X";
                let value = |i: usize, k: usize| {
                    let value = channels.get(k).map_or(0.0, |values| values[i]);
                    if is_vector { 0.5 * value + 0.5 } else { value }
                };
                (0..picture.pixel_count()).map(|i| opaque([0, 1, 2].map(|k| value(i, k)))).collect()
            }
            Self::Channel(layer, channel) => match &picture.layer(layer)?.channel(channel)?.data {
                ChannelData::F32(values) => values.iter().map(|&value| opaque([value; 3])).collect(),
                ChannelData::U32(values) => values.iter().map(|&id| id_color(id)).collect(),
            },
        })
    }

    /// The values of a part at a pixel, as they are in the file.
    pub(crate) fn values(&self, picture: &Picture, [x, y]: [u32; 2]) -> String {
        let i = y as usize * picture.width as usize + x as usize;
        let of = |layer: &str, names: &[&str]| {
            let layer = picture.layer(layer)?;
            let value = |name: &&str| match &layer.channel(name)?.data {
                ChannelData::F32(values) => values.get(i).map(|value| format!("{value:.5}")),
                ChannelData::U32(values) if values.get(i) == Some(&u32::MAX) => Some("none".to_owned()),
                ChannelData::U32(values) => values.get(i).map(u32::to_string),
            };
            names.iter().map(value).collect::<Option<Vec<_>>>().map(|values| values.join("  "))
        };
        let found = match self {
            Self::Color => {
                picture.pixel(x, y).map(|[r, g, b, a]| format!("{r:.5}  {g:.5}  {b:.5}  a {a:.3}"))
            }
            Self::Layer(name) => picture.layer(name).and_then(group).and_then(|names| of(name, names)),
            Self::Channel(layer, channel) => of(layer, &[channel]),
        };
        found.unwrap_or_else(|| "-".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_names_colours_and_values() {
        let mut picture = Picture::new(2, 1);
        picture.color = vec![[0.25, 0.5, 1.0, 1.0], [3.0, 0.0, 0.0, 0.5]];
        picture.layers = vec![
            Layer::floats("N", [("X", vec![0.0, 1.0]), ("Y", vec![-1.0, 0.0]), ("Z", vec![0.0, 0.0])]),
            Layer::floats("depth", [("Z", vec![2.0, f32::INFINITY])]),
            Layer::ids("id", [("material", vec![7, u32::MAX]), ("instance", vec![1, 2])]),
            Layer::floats("uv", [("U", vec![0.1, 0.2]), ("V", vec![0.3, 0.4])]),
        ];
        let all = items(&picture);
        let names: Vec<String> = all.iter().map(Item::to_string).collect();
        assert_eq!(names, ["color", "N", "depth.Z", "id.material", "id.instance", "uv"]);
        let colors = |i: usize| all[i].colors(&picture).expect("it is there").into_owned();
        assert_eq!(colors(0), picture.color);
        assert_eq!(colors(1), [[0.5, 0.0, 0.5, 1.0], [1.0, 0.5, 0.5, 1.0]], "vectors");
        assert_eq!(colors(2), [[2.0, 2.0, 2.0, 1.0], [f32::INFINITY, f32::INFINITY, f32::INFINITY, 1.0]]);
        assert_eq!(colors(3)[1], [0.0, 0.0, 0.0, 1.0], "nothing is black");
        assert_ne!(colors(3)[0], colors(4)[0], "ids differ in colour");
        assert_eq!(colors(5)[1], [0.2, 0.4, 0.0, 1.0]);
        assert_eq!(all[1].values(&picture, [0, 0]), "0.00000  -1.00000  0.00000");
        assert_eq!(all[3].values(&picture, [1, 0]), "none");
        assert_eq!(all[0].values(&picture, [5, 0]), "-", "outside");
        assert_eq!(Item::Layer("none".into()).colors(&picture), None);
    }
}
