// SPDX-License-Identifier: GPL-3.0-or-later
//! A picture in pieces, each rendered by itself, and the picture put together again.
//! A piece is every n-th tile: neighbours cost about the same, and so do pieces. Its pixels travel tile by
//! tile in a small picture of their own, for most of the frame is others'. Samples of a pixel stay in one
//! piece: their sum depends on their order.
//! Invariant: pixels are copied, so that the whole has the bits of a picture rendered at once. Tests: `tests` here;
//! crates/cli/tests/program/pieces.rs.

use gnurt_image::{BACKGROUND, Channel, ChannelData, Layer, Opacity, Picture};

use crate::accumulation::Accumulation;
use crate::error::RenderError;
use crate::expressions::OUTPUT_PREFIX;
use crate::film::TileFilm;
use crate::options::RenderOptions;

/// The name of the background in a piece: under the standard name a file's reader would add it to the colour,
/// and round.
const BEHIND: &str = "behind";

/// Rectangles `[x0, y0, x1, y1]` in pixels that are rendered under these options, ends excluded: all of the region, or the piece's.
///
/// # Errors
/// [`RenderError`] if the options leave nothing to render.
pub fn rendered_rects(options: &RenderOptions) -> Result<Vec<[u32; 4]>, RenderError> {
    Ok(TileFilm::rects(options.region()?, options).collect())
}

/// A picture of the whole frame with all layers, in which nothing is rendered yet.
///
/// # Errors
/// As [`rendered_rects`].
pub fn empty_picture(options: &RenderOptions) -> Result<Picture, RenderError> {
    let options = RenderOptions { aovs: true, heatmap: false, piece: None, rows: None, ..options.clone() };
    Ok(Accumulation::new(options)?.picture())
}

/// The pixels of a piece's rectangles, side by side in rows; `picture` is that of the whole frame.
#[must_use]
pub fn pack_piece(picture: &Picture, rects: &[[u32; 4]]) -> Picture {
    let slots = Slots::of(rects);
    let [width, height] = slots.size();
    let mut packed = Picture { opacity: Opacity::Associated, ..Picture::new(width, height) };
    packed.metadata.clone_from(&picture.metadata);
    for layer in &picture.layers {
        let name = if layer.name == BACKGROUND { BEHIND } else { &layer.name };
        let channels = layer.channels.iter().map(|channel| blank(channel, packed.pixel_count())).collect();
        packed.layers.push(Layer { name: name.into(), channels });
    }
    let corner = |rect: &[u32; 4]| [rect[0], rect[1]];
    let copied = rects.iter().enumerate().map(|(i, rect)| (corner(rect), slots.corner(i), size(rect)));
    // They have the same layers.
    let _ = copy(picture, &mut packed, copied);
    packed
}

/// Puts the pixels of a piece in their positions in a picture that was [empty](empty_picture). Returns false
/// and does nothing if `packed` has another number of rectangles, or lacks layers of the picture.
#[must_use]
pub fn unpack_piece(picture: &mut Picture, packed: &Picture, rects: &[[u32; 4]]) -> bool {
    let slots = Slots::of(rects);
    let corner = |rect: &[u32; 4]| [rect[0], rect[1]];
    let copied = rects.iter().enumerate().map(|(i, rect)| (slots.corner(i), corner(rect), size(rect)));
    take_forms(picture, packed);
    [packed.width, packed.height] == slots.size() && copy(packed, picture, copied)
}

/// Gives empty layers of shaders' outputs the channels that a piece has: an output's type is known only with its scene.
fn take_forms(picture: &mut Picture, packed: &Picture) {
    let count = picture.pixel_count();
    let is_empty = |channel: &Channel| match &channel.data {
        ChannelData::F32(values) => values.iter().all(|&x| x == 0.0),
        ChannelData::U32(_) => false,
    };
    for layer in picture.layers.iter_mut().filter(|layer| layer.name.starts_with(OUTPUT_PREFIX)) {
        let Some(other) = packed.layer(&layer.name) else { continue };
        let is_same = layer.channels.len() == other.channels.len()
            && other.channels.iter().all(|channel| layer.channel(&channel.name).is_some());
        if !is_same && layer.channels.iter().all(is_empty) {
            layer.channels = other.channels.iter().map(|channel| blank(channel, count)).collect();
        }
    }
}

fn size([x0, y0, x1, y1]: &[u32; 4]) -> [u32; 2] {
    [x1 - x0, y1 - y0]
}

/// Copies rectangles: upper left corners here and there, and sizes. False if the layers are not the same.
fn copy(
    from: &Picture,
    to: &mut Picture,
    rects: impl Iterator<Item = ([u32; 2], [u32; 2], [u32; 2])>,
) -> bool {
    fn all<T: Copy>(runs: &[[usize; 3]], from: &[T], to: &mut [T]) {
        for &[a, b, n] in runs {
            to[b..b + n].copy_from_slice(&from[a..a + n]);
        }
    }
    let at = |picture: &Picture, [x, y]: [u32; 2]| y as usize * picture.width as usize + x as usize;
    let mut runs = Vec::new();
    for ([ax, ay], [bx, by], [width, height]) in rects {
        runs.extend(
            (0..height).map(|row| [at(from, [ax, ay + row]), at(to, [bx, by + row]), width as usize]),
        );
    }
    let plain = |name: &str| if name == BEHIND { BACKGROUND } else { name }.to_owned();
    let mut pairs = Vec::new();
    for (i, layer) in to.layers.iter().enumerate() {
        let Some(source) = from.layers.iter().find(|source| plain(&source.name) == plain(&layer.name)) else {
            return false;
        };
        for (k, channel) in layer.channels.iter().enumerate() {
            let Some(source) = source.channel(&channel.name) else { return false };
            if std::mem::discriminant(&source.data) != std::mem::discriminant(&channel.data) {
                return false;
            }
            pairs.push((i, k, source));
        }
    }
    all(&runs, &from.color, &mut to.color);
    for (i, k, source) in pairs {
        match (&mut to.layers[i].channels[k].data, &source.data) {
            (ChannelData::F32(to), ChannelData::F32(from)) => all(&runs, from, to),
            (ChannelData::U32(to), ChannelData::U32(from)) => all(&runs, from, to),
            _ => {}
        }
    }
    true
}

/// A channel of zeros of the same kind.
fn blank(channel: &Channel, pixels: usize) -> Channel {
    let data = match channel.data {
        ChannelData::F32(_) => ChannelData::F32(vec![0.0; pixels]),
        ChannelData::U32(_) => ChannelData::U32(vec![0; pixels]),
    };
    Channel { name: channel.name.clone(), data, half: channel.half }
}

/// The grid of a piece's tiles in its file: nearly square, at least one slot, each as large as the largest
/// tile.
struct Slots {
    columns: u32,
    rows: u32,
    position: u32,
}

impl Slots {
    fn of(rects: &[[u32; 4]]) -> Self {
        let count = u32::try_from(rects.len()).unwrap_or(u32::MAX).max(1);
        let columns = f64::from(count).sqrt().ceil() as u32;
        let position = rects.iter().flat_map(size).max().unwrap_or(1);
        Self { columns, rows: count.div_ceil(columns), position }
    }

    fn size(&self) -> [u32; 2] {
        [self.columns * self.position, self.rows * self.position]
    }

    fn corner(&self, i: usize) -> [u32; 2] {
        let i = i as u32;
        [i % self.columns * self.position, i / self.columns * self.position]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::piece::Piece;

    /// A picture in which each number of each channel is another one.
    fn filled(options: &RenderOptions) -> Picture {
        let mut picture = empty_picture(options).expect("sound options");
        let mut next = 0_u32;
        let mut count = || {
            next += 1;
            next
        };
        for pixel in &mut picture.color {
            *pixel = [0; 4].map(|_| 1.0 / count() as f32);
        }
        for channel in picture.layers.iter_mut().flat_map(|layer| &mut layer.channels) {
            match &mut channel.data {
                ChannelData::F32(values) => values.iter_mut().for_each(|x| *x = 1.0 / count() as f32),
                ChannelData::U32(values) => values.iter_mut().for_each(|x| *x = count()),
            }
        }
        picture
    }

    #[test]
    fn pieces_make_the_whole() {
        for (size, crop, count) in
            [([70, 45], None, 3), ([33, 20], Some([5, 2, 30, 19]), 2), ([9, 9], None, 4)]
        {
            let options = RenderOptions { width: size[0], height: size[1], crop, ..RenderOptions::default() };
            let whole = filled(&options);
            let mut joined = empty_picture(&options).expect("sound options");
            let mut covered = 0;
            for index in (0..count).rev() {
                let piece = RenderOptions { piece: Some(Piece { index, count }), ..options.clone() };
                let rects = rendered_rects(&piece).expect("sound options");
                covered += rects.iter().map(size_of).sum::<u32>();
                let packed = pack_piece(&whole, &rects);
                assert!(packed.check().is_ok(), "{:?}", packed.check());
                assert!(
                    packed.width * packed.height <= 2 * 256 * rects.len().max(1) as u32,
                    "no larger than it is"
                );
                assert!(unpack_piece(&mut joined, &packed, &rects), "piece {index} of {count}");
                assert!(!unpack_piece(&mut joined, &packed, &[[0; 4]; 99]), "others' rectangles");
            }
            let [x0, y0, x1, y1] = options.region().expect("sound");
            assert_eq!(covered, (x1 - x0) * (y1 - y0), "each pixel once");
            for y in y0..y1 {
                for x in x0..x1 {
                    assert_eq!(joined.pixel(x, y), whole.pixel(x, y), "{x},{y}");
                }
            }
            if crop.is_none() {
                assert!(joined == whole, "layers as well");
            }
        }
    }

    fn size_of(rect: &[u32; 4]) -> u32 {
        size(rect).iter().product()
    }

    #[test]
    fn what_is_no_piece_is_refused() {
        let with = |index, count, interleave| RenderOptions {
            piece: Some(Piece { index, count }),
            integrator: crate::Integrator::InstantRadiosity,
            interleave,
            ..RenderOptions::default()
        };
        assert!(rendered_rects(&with(0, 2, 1)).is_ok(), "the first of two");
        for (index, count, interleave) in [(2, 2, 1), (0, 0, 1), (0, 2, 3)] {
            let options = with(index, count, interleave);
            assert!(Accumulation::new(options).is_err(), "{index} of {count}, interleaved {interleave}");
        }
    }
}
