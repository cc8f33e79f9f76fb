// SPDX-License-Identifier: GPL-3.0-or-later
//! A picture: linear colours with opacity, and named layers of other data. Values are linear light (Rec. 709
//! primaries), unclamped; row 0 is the top, columns run to the right.
//!
//! The colour is the visible one. Its opacity is the hidden share of the background; [`Opacity`] relates the
//! two. A known background is the layer [`BACKGROUND`]: `R`, `G`, `B`, its visible part, and `A`, its visible
//! share of the pixel. Then the colour is the sum of both, and the foreground is the colour minus the
//! background, associated with its opacity [PD84]. Opacity and `A` make 1 where something was rendered. Files
//! with opacity get the foreground (EXR) or the visible colour (PNG); others the visible colour.
//!
//! Invariant: `color` and every channel hold `width * height` values; `check` proves it before a file is written.
//! Tests: `tests/round_trip.rs` (every format), `tests` here.

use crate::Error;

/// The name of the layer with the visible part of the background.
pub const BACKGROUND: &str = "background";

/// The meaning of a colour whose opacity is less than 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Opacity {
    /// The colour as if it were opaque, as in PNG.
    #[default]
    Straight,
    /// Its colour over black, multiplied with its opacity, as in EXR \[PD84\].
    Associated,
}

/// Linear colours with opacity, and named layers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue in linear light and opacity, `width * height` values in rows from the upper left pixel.
    pub color: Vec<[f32; 4]>,
    /// How colours and opacities go together.
    pub opacity: Opacity,
    /// Other data of each pixel: depth, normals, ids.
    pub layers: Vec<Layer>,
    /// Names and values for the file's header, where the format has one (EXR).
    pub metadata: Vec<(String, String)>,
}

/// A named group of channels, such as `N` with `X`, `Y` and `Z`.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The name before the dot of the file's channel name; empty for channels without one (`Z`).
    pub name: String,
    /// The channels.
    pub channels: Vec<Channel>,
}

/// One number per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The name after the dot, such as `X`.
    pub name: String,
    /// The values in rows from the upper left pixel.
    pub data: ChannelData,
    /// Whether floats are stored with 16 bits.
    pub half: bool,
}

/// The values of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelData {
    /// Measures: distances, coordinates, colours.
    F32(Vec<f32>),
    /// Numbers of objects.
    U32(Vec<u32>),
}

impl Picture {
    /// A black, transparent picture without layers.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let color = vec![[0.0; 4]; width as usize * height as usize];
        Self { width, height, color, ..Self::default() }
    }

    /// Columns times rows.
    #[must_use]
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Colour and opacity at column `x`, row `y` (from the top); `None` outside.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        let inside = x < self.width && y < self.height;
        inside.then(|| y as usize * self.width as usize + x as usize).and_then(|i| self.color.get(i).copied())
    }

    /// The layer of this name.
    #[must_use]
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.name == name)
    }

    /// The value of the first metadata entry of this name.
    #[must_use]
    pub fn metadata(&self, name: &str) -> Option<&str> {
        self.metadata.iter().find(|(key, _)| key == name).map(|(_, value)| &value[..])
    }

    /// Adds a metadata entry, or replaces the one of this name.
    pub fn set_metadata(&mut self, name: &str, value: impl Into<String>) {
        match self.metadata.iter_mut().find(|(key, _)| key == name) {
            Some(entry) => entry.1 = value.into(),
            None => self.metadata.push((name.into(), value.into())),
        }
    }

    /// Makes the pixels of a region, `[x0, y0, x1, y1]` with the upper left corner first and the ends
    /// excluded, opaque: on a screen the background is part of the picture. `None` = all. Parts outside of
    /// the picture are ignored.
    pub fn make_opaque(&mut self, region: Option<[u32; 4]>) {
        let [x0, y0, x1, y1] = region.unwrap_or([0, 0, self.width, self.height]).map(|x| x as usize);
        let x1 = x1.min(self.width as usize);
        let rows = self.color.chunks_exact_mut((self.width as usize).max(1));
        for row in rows.take(y1).skip(y0) {
            row[x0.min(x1)..x1].iter_mut().for_each(|pixel| pixel[3] = 1.0);
        }
    }

    /// Leaves the foreground over nothing, and no layer of the background.
    pub fn drop_background(&mut self) {
        let front: Vec<[f32; 4]> =
            self.in_front().map(|[r, g, b, a]| [r.max(0.0), g.max(0.0), b.max(0.0), a]).collect();
        (self.color, self.opacity) = (front, Opacity::Associated);
        self.layers.retain(|layer| layer.name != BACKGROUND);
    }

    /// The channels R, G, B and A of the background, if it is known.
    pub(crate) fn background(&self) -> Option<[&[f32]; 4]> {
        let layer = self.layer(BACKGROUND)?;
        let values = |name: &str| match &layer.channel(name)?.data {
            ChannelData::F32(values) if values.len() == self.pixel_count() => Some(&values[..]),
            _ => None,
        };
        Some([values("R")?, values("G")?, values("B")?, values("A")?])
    }

    /// The foreground pixels over nothing, as associated colour and opacity.
    pub(crate) fn in_front(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        let background = self.background();
        self.color.iter().enumerate().map(move |(i, &[r, g, b, a])| match (background, self.opacity) {
            // Exactly zero, after any filter of the colour.
            (Some(_), _) if a <= 0.0 => [0.0; 4],
            (Some([br, bg, bb, _]), _) => [r - br[i], g - bg[i], b - bb[i], a],
            (None, Opacity::Straight) if a != 1.0 => [r * a, g * a, b * a, a],
            (None, _) => [r, g, b, a],
        })
    }

    /// The pixels with the background, as straight colour and opacity: the displayed ones, row by row from the upper left
    /// one, in linear light.
    pub fn on_screen(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        let background = self.background();
        self.color.iter().enumerate().map(move |(i, &[r, g, b, a])| {
            let a = background.map_or(a, |[.., behind]| {
                let a = a + behind[i];
                // Sums of shares are off by a rounding.
                if a > 0.999 { 1.0 } else { a }
            });
            match self.opacity {
                Opacity::Associated if a > 0.0 && a < 1.0 => [r / a, g / a, b / a, a],
                _ => [r, g, b, a],
            }
        })
    }

    /// Whether sizes fit: at least one pixel, and as many values everywhere as there are pixels.
    ///
    /// # Errors
    /// [`Error::Shape`] with the part that has the wrong size.
    pub fn check(&self) -> Result<(), Error> {
        let pixels = self.pixel_count();
        if pixels == 0 {
            return Err(Error::Shape(format!(
                "a picture of {} x {} pixels is empty",
                self.width, self.height
            )));
        }
        if self.color.len() != pixels {
            return Err(Error::Shape(format!("{} colours for {pixels} pixels", self.color.len())));
        }
        let mut channels = self.layers.iter().flat_map(|l| l.channels.iter().map(move |c| (l, c)));
        match channels.find(|(_, channel)| channel.data.len() != pixels) {
            Some((layer, channel)) => {
                let (found, name) = (channel.data.len(), layer.full_name(channel));
                Err(Error::Shape(format!("{found} values for {pixels} pixels in channel '{name}'")))
            }
            None => Ok(()),
        }
    }
}

impl Layer {
    /// A layer of float channels, such as `Layer::floats("N", [("X", xs), ("Y", ys), ("Z", zs)])`.
    pub fn floats<'a>(name: &str, channels: impl IntoIterator<Item = (&'a str, Vec<f32>)>) -> Self {
        let float = |(name, values): (&str, _)| Channel {
            name: name.into(),
            data: ChannelData::F32(values),
            half: false,
        };
        Self { name: name.into(), channels: channels.into_iter().map(float).collect() }
    }

    /// A layer of whole numbers, such as `Layer::ids("id", [("object", objects)])`.
    pub fn ids<'a>(name: &str, channels: impl IntoIterator<Item = (&'a str, Vec<u32>)>) -> Self {
        let id = |(name, values): (&str, _)| Channel {
            name: name.into(),
            data: ChannelData::U32(values),
            half: false,
        };
        Self { name: name.into(), channels: channels.into_iter().map(id).collect() }
    }

    /// The channel of this name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// A channel's name in a file: `N.X`, or `Z` where the layer has no name.
    #[must_use]
    pub fn full_name(&self, channel: &Channel) -> String {
        if self.name.is_empty() { channel.name.clone() } else { format!("{}.{}", self.name, channel.name) }
    }
}

impl ChannelData {
    /// How many values there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::U32(values) => values.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_finds_each_wrong_size() {
        let good = Picture::new(3, 2);
        assert!(good.check().is_ok(), "six colours for 3 x 2 pixels are right");
        assert!(Picture::new(0, 2).check().is_err(), "an empty picture must be refused");
        let mut short = good.clone();
        short.color.pop();
        assert!(short.check().is_err(), "a missing colour must be found");
        let mut layered = good;
        layered.layers.push(Layer::floats("N", [("X", vec![0.0; 6]), ("Y", vec![0.0; 5])]));
        let message = layered.check().expect_err("a short channel must be found").to_string();
        assert!(message.contains("'N.Y'"), "the message names the channel: {message}");
    }

    #[test]
    fn what_is_seen_is_front_and_background() {
        let mut picture = Picture::new(3, 1);
        picture.color = vec![[0.5, 0.25, 1.0, 0.0], [0.5, 0.5, 0.5, 0.5], [0.0; 4]];
        picture.opacity = Opacity::Associated;
        assert_eq!(
            picture.on_screen().nth(1).expect("a pixel"),
            [1.0, 1.0, 1.0, 0.5],
            "divided, for those who multiply"
        );
        assert_eq!(picture.in_front().nth(1).expect("a pixel"), [0.5; 4], "as it is");
        let behind = |r: f32, a: f32| vec![r, 0.25 * a, 0.0];
        let channels = [
            ("R", behind(0.5, 0.4)),
            ("G", behind(0.25, 0.4)),
            ("B", behind(1.0, 0.4)),
            ("A", behind(1.0, 2.0)),
        ];
        picture.layers.push(Layer::floats(BACKGROUND, channels));
        assert_eq!(picture.in_front().next().expect("a pixel"), [0.0; 4], "nothing is in front");
        assert_eq!(
            picture.on_screen().next().expect("a pixel"),
            [0.5, 0.25, 1.0, 1.0],
            "what lies behind is seen, and opaque"
        );
        assert_eq!(
            picture.in_front().nth(1).expect("a pixel"),
            [0.4, 0.4, 0.4, 0.5],
            "without what lies behind"
        );
        assert_eq!(picture.on_screen().nth(1).expect("a pixel"), [0.5, 0.5, 0.5, 1.0], "with it");
        assert_eq!(
            picture.on_screen().nth(2).expect("a pixel")[3],
            0.0,
            "what was not rendered stays transparent"
        );
        let straight = Picture { color: vec![[0.5, 0.5, 0.5, 0.5]], ..Picture::new(1, 1) };
        assert_eq!(straight.in_front().next().expect("a pixel"), [0.25, 0.25, 0.25, 0.5], "multiplied");
        assert_eq!(straight.on_screen().next().expect("a pixel"), [0.5; 4], "as it is");
    }

    #[test]
    fn the_background_can_be_dropped() {
        let mut picture = Picture::new(2, 1);
        (picture.color, picture.opacity) =
            (vec![[0.5, 0.5, 0.5, 0.5], [1.0, 1.0, 1.0, 0.0]], Opacity::Associated);
        let channels = ["R", "G", "B", "A"]
            .map(|name| (name, if name == "A" { vec![0.5, 1.0] } else { vec![0.25, 1.0] }));
        picture.layers.push(Layer::floats(BACKGROUND, channels));
        picture.drop_background();
        let shown: Vec<_> = picture.on_screen().collect();
        assert_eq!(
            shown,
            [[0.5, 0.5, 0.5, 0.5], [0.0; 4]],
            "straight colours with opacity, nothing behind them"
        );
        assert!(picture.layers.is_empty(), "no background is left");
    }

    #[test]
    fn regions_become_opaque() {
        let mut picture = Picture::new(3, 2);
        picture.make_opaque(Some([1, 1, 9, 9]));
        let opaque: Vec<_> = picture.color.iter().map(|pixel| pixel[3]).collect();
        assert_eq!(opaque, [0.0, 0.0, 0.0, 0.0, 1.0, 1.0], "what lies in the picture");
        picture.make_opaque(None);
        assert!(picture.color.iter().all(|pixel| pixel[3] == 1.0), "all");
    }

    #[test]
    fn metadata_is_replaced_not_doubled() {
        let mut picture = Picture::new(1, 1);
        picture.set_metadata("seed", "1");
        picture.set_metadata("seed", "2");
        assert_eq!(picture.metadata("seed"), Some("2"), "the later value wins");
        assert_eq!(picture.metadata.len(), 1, "there is one entry per name");
    }

    #[test]
    fn pixels_are_found_by_column_and_row() {
        let mut picture = Picture::new(2, 2);
        picture.color[2] = [1.0; 4];
        assert_eq!(picture.pixel(0, 1), Some([1.0; 4]), "index 2 of a 2-wide picture is column 0, row 1");
        assert_eq!(picture.pixel(2, 0), None, "column 2 is outside");
    }
}
