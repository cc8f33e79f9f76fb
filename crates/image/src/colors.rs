// SPDX-License-Identifier: GPL-3.0-or-later
//! Colours of a picture and of its layers in another space.
//! Layers with channels R, G and B are colours, but for ids of Cryptomatte; those named `variance` are variances of
//! colours, whose channels count as independent. Space: linear light. Tests: `tests`.

use crate::working_space::convert;
use crate::{ChannelData, Layer, Picture, WorkingSpace};

/// Converts pixels of a rendering in this space to Rec. 709.
pub fn convert_from(space: WorkingSpace, pixels: &mut [[f32; 4]]) {
    if let Some(rows) = space.to_rec709() {
        convert_all(pixels, &rows);
    }
}

fn convert_all(pixels: &mut [[f32; 4]], rows: &[[f32; 3]; 3]) {
    for pixel in pixels {
        let [r, g, b, a] = *pixel;
        let [r, g, b] = convert(rows, [r, g, b]);
        *pixel = [r, g, b, a];
    }
}

impl Picture {
    /// Converts its colours, and those of its layers, by the rows of a matrix.
    pub fn convert_colors(&mut self, rows: &[[f32; 3]; 3]) {
        convert_all(&mut self.color, rows);
        let mattes: Vec<String> = self.mattes().map(str::to_owned).collect();
        for layer in &mut self.layers {
            if mattes.iter().any(|name| layer.name.starts_with(&name[..])) {
                continue;
            }
            match layer.name.rsplit('.').next() {
                Some("variance") => layer.convert(&rows.map(|row| row.map(|x| x * x))),
                _ => layer.convert(rows),
            }
        }
    }

    /// Converts the colours of a rendering in this space to Rec. 709, in which pictures are.
    pub fn convert_from(&mut self, space: WorkingSpace) {
        if let Some(rows) = space.to_rec709() {
            self.convert_colors(&rows);
        }
    }

    /// The names that layers of Cryptomatte begin with, as the metadata has them.
    fn mattes(&self) -> impl Iterator<Item = &str> {
        let names =
            self.metadata.iter().filter(|(key, _)| key.starts_with("cryptomatte/") && key.ends_with("/name"));
        names.map(|(_, name)| &name[..])
    }
}

impl Layer {
    fn convert(&mut self, rows: &[[f32; 3]; 3]) {
        let at = |name: &str| self.channels.iter().position(|channel| channel.name == name);
        let [Some(r), Some(g), Some(b)] = ["R", "G", "B"].map(at) else { return };
        let floats = |i: usize| match &self.channels[i].data {
            ChannelData::F32(values) => Some(values),
            ChannelData::U32(_) => None,
        };
        let [Some(red), Some(green), Some(blue)] = [r, g, b].map(floats) else { return };
        let all = red.iter().zip(green).zip(blue);
        let converted: Vec<[f32; 3]> = all.map(|((&r, &g), &b)| convert(rows, [r, g, b])).collect();
        for (k, i) in [r, g, b].into_iter().enumerate() {
            self.channels[i].data = ChannelData::F32(converted.iter().map(|color| color[k]).collect());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_stay_and_variances_are_squares() {
        let mut picture = Picture::new(1, 1);
        picture.color[0] = [1.0, 2.0, 3.0, 0.5];
        let of = |name: &str| Layer::floats(name, ["R", "G", "B"].map(|channel| (channel, vec![1.0])));
        picture.layers = vec![of("albedo"), of("variance"), of("CryptoObject00")];
        picture.layers.push(Layer::floats("normal", ["X", "Y", "Z"].map(|channel| (channel, vec![1.0]))));
        picture.set_metadata("cryptomatte/1234567/name", "CryptoObject");
        picture.convert_colors(&[[2.0, 0.0, 0.0], [0.0, 3.0, 1.0], [0.0, 0.0, 1.0]]);
        assert_eq!(picture.color[0], [2.0, 9.0, 3.0, 0.5]);
        let values = |layer: &Layer| {
            let value = |channel: &crate::Channel| match &channel.data {
                ChannelData::F32(values) => values[0],
                ChannelData::U32(_) => f32::NAN,
            };
            layer.channels.iter().map(value).collect::<Vec<_>>()
        };
        let all: Vec<Vec<f32>> = picture.layers.iter().map(values).collect();
        assert_eq!(all, [[2.0, 4.0, 1.0], [4.0, 10.0, 1.0], [1.0; 3], [1.0; 3]]);
    }
}
