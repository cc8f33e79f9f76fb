// SPDX-License-Identifier: GPL-3.0-or-later
//! The displayed quantity: light by an integrator, or properties of the camera rays' hits, as colours. Depth
//! is shown as r / (r + d), r = the distance from eye to target: near is white. Ids are shown as colours that
//! are the same each time. Tests: `tests`.

use std::fmt;

use gnurt::image::{ChannelData, Picture};
use gnurt::render::Integrator;

/// A kind of picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Light.
    Light(Integrator),
    /// Base colours.
    Albedo,
    /// Distances from the eye.
    Depth,
    /// A colour for each id of this channel in the picture's layer `id`.
    Ids(&'static str),
    /// Base colours, with lines where triangles meet.
    Wireframe,
}

impl Shown {
    /// All kinds, in the order of the keys 1 to 9 and 0.
    #[must_use]
    pub fn all() -> Vec<Self> {
        // There is no time for pilots here.
        let light = Integrator::ALL.into_iter().filter(|&integrator| integrator != Integrator::Auto);
        let light = light.map(Self::Light);
        let ids = ["material", "instance", "prim"].map(Self::Ids);
        light.chain([Self::Albedo, Self::Depth]).chain(ids).chain([Self::Wireframe]).collect()
    }

    /// The one at this offset in the list, which is a circle.
    #[must_use]
    pub fn neighbour(self, pixels: isize) -> Self {
        let all = Self::all();
        let at = all.iter().position(|&shown| shown == self).unwrap_or(0);
        all[(at as isize + pixels).rem_euclid(all.len() as isize) as usize]
    }

    /// The integrator that computes it: layers need none, so the cheapest one runs with them.
    #[must_use]
    pub fn integrator(self) -> Integrator {
        match self {
            Self::Light(integrator) => integrator,
            _ => Integrator::Eyelight,
        }
    }

    /// Whether it is made from the picture's layers.
    #[must_use]
    pub fn needs_layers(self) -> bool {
        !matches!(self, Self::Light(_))
    }

    /// Colours of each pixel. `reach` is the distance that is shown as middle grey.
    pub(crate) fn colors(self, picture: &Picture, reach: f32, out: &mut [[f32; 4]]) {
        let floats = |layer: &str, channel: &str| match &picture.layer(layer)?.channel(channel)?.data {
            ChannelData::F32(values) => Some(&values[..]),
            ChannelData::U32(_) => None,
        };
        let ids = |channel: &str| match &picture.layer("id")?.channel(channel)?.data {
            ChannelData::U32(values) => Some(&values[..]),
            ChannelData::F32(_) => None,
        };
        match self {
            Self::Light(_) => out.iter_mut().zip(&picture.color).for_each(|(out, &color)| *out = color),
            Self::Albedo | Self::Wireframe => {
                for (k, name) in ["R", "G", "B"].into_iter().enumerate() {
                    let values = floats("albedo", name).unwrap_or_default();
                    out.iter_mut().zip(values).for_each(|(out, &value)| out[k] = value);
                }
            }
            Self::Depth => {
                let values = floats("depth", "Z").unwrap_or_default();
                out.iter_mut().zip(values).for_each(|(out, &d)| *out = [reach / (reach + d); 4]);
            }
            Self::Ids(name) => {
                let values = ids(name).unwrap_or_default();
                out.iter_mut().zip(values).for_each(|(out, &id)| *out = id_color(id));
            }
        }
        if self == Self::Wireframe {
            let [prims, instances] = ["prim", "instance"].map(|name| ids(name).unwrap_or_default());
            let place = |i: usize| (prims.get(i), instances.get(i));
            let width = (picture.width as usize).max(1);
            for (i, pixel) in out.iter_mut().enumerate() {
                let right = if (i + 1) % width == 0 { i } else { i + 1 };
                let below = if i + width < picture.pixel_count() { i + width } else { i };
                let is_edge = place(i) != place(right) || place(i) != place(below);
                // Lines are dark, faces are pale. Where all is lines, shapes remain.
                *pixel = pixel.map(|x| if is_edge { 0.15 * x } else { 0.3 + 0.5 * x });
            }
        }
        out.iter_mut().for_each(|pixel| pixel[3] = 1.0);
    }
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Light(integrator) => integrator.name(),
            Self::Albedo => "albedo",
            Self::Depth => "depth",
            Self::Ids("material") => "materials",
            Self::Ids("instance") => "instances",
            Self::Ids(_) => "triangles",
            Self::Wireframe => "wireframe",
        })
    }
}

/// A colour that is neither dark nor grey; black where there is nothing.
pub(crate) fn id_color(id: u32) -> [f32; 4] {
    if id == u32::MAX {
        return [0.0, 0.0, 0.0, 1.0];
    }
    // Steps of the golden section around the circle of hues separate neighbours.
    let hue = (f64::from(id) * 0.618_033_988_749_895).fract() * 6.0;
    let scale = 1.0 - 0.35 * (f64::from(id) * 0.381_966).fract();
    let channel = |offset: f64| {
        let distance = ((hue + offset).rem_euclid(6.0) - 3.0).abs() - 1.0;
        ((0.15 + 0.85 * distance.clamp(0.0, 1.0)) * scale) as f32
    };
    [channel(0.0), channel(4.0), channel(2.0), 1.0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::image::Layer;

    #[test]
    fn lists_are_circles() {
        let all = Shown::all();
        assert_eq!(all[0].neighbour(-1), all[all.len() - 1], "before the first one");
        assert_eq!(all[all.len() - 1].neighbour(1), all[0], "behind the last one");
        let mut names: Vec<String> = all.iter().map(ToString::to_string).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), all.len(), "each has a name of its own");
    }

    #[test]
    fn layers_become_colours() {
        let mut picture = Picture::new(2, 1);
        picture.layers.push(Layer::floats("depth", [("Z", vec![1.0, f32::INFINITY])]));
        picture.layers.push(Layer::ids("id", [("material", vec![7, u32::MAX])]));
        let albedo = [("R", vec![0.1, 0.2]), ("G", vec![0.3, 0.4]), ("B", vec![0.5, 0.6])];
        picture.layers.push(Layer::floats("albedo", albedo));
        let colors = |shown: Shown| {
            let mut out = [[9.0; 4]; 2];
            shown.colors(&picture, 1.0, &mut out);
            out
        };
        assert_eq!(
            colors(Shown::Depth),
            [[0.5, 0.5, 0.5, 1.0], [0.0, 0.0, 0.0, 1.0]],
            "half way, and nothing"
        );
        assert_eq!(colors(Shown::Albedo), [[0.1, 0.3, 0.5, 1.0], [0.2, 0.4, 0.6, 1.0]], "as it is");
        let mut meshed = picture.clone();
        meshed.layers.push(Layer::ids("id", [("prim", vec![1, 2]), ("instance", vec![3, 3])]));
        meshed.layers.swap_remove(1);
        let mut lines = [[9.0; 4]; 2];
        Shown::Wireframe.colors(&meshed, 1.0, &mut lines);
        assert!((lines[0][0] - 0.015).abs() < 1e-6, "another triangle is next to it: {lines:?}");
        assert!((lines[1][0] - 0.4).abs() < 1e-6, "a face");
        let [thing, nothing] = colors(Shown::Ids("material"));
        assert!(
            thing[..3].iter().all(|&x| x > 0.05) && nothing == [0.0, 0.0, 0.0, 1.0],
            "{thing:?} {nothing:?}"
        );
    }
}
