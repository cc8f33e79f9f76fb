// SPDX-License-Identifier: GPL-3.0-or-later
//! Interleaved sampling: each pixel of an N x N pattern gathers its own subset of the virtual lights. Light
//! is then averaged over N x N pixels of the same surface, so that each pixel has light of all of them.
//! Source: [WKB*02] (interleaved sampling with a discontinuity buffer), [KH01] (the pattern). Light is
//! averaged without the surface's albedo, so that textures stay sharp. Differs: direct light and light by
//! scattered rays is averaged, too, and takes fewer samples, with random numbers that belong to positions of
//! the pattern: no noise, and the same numbers from frame to frame.
//! Space: world. Biased: light is blurred over N pixels of a surface, and near its edges some of the virtual
//! lights are missing.
//! Invariant: a pixel receives nothing from pixels of other surfaces or of the background.
//! Tests: `tests`, crates/render/tests/interleave.rs.

use glam::Vec3;
use gnurt_accel::INVALID_ID;
use gnurt_shading::{SampleKey, Vec3s};

use super::vpl::Vpl;
use crate::film::TileFilm;
use crate::tracer::Sharing;

/// Marks numbers for a position of the pattern.
const PATTERN: u32 = 0x1e4f_0000;
/// Cosine between normals of one surface, at least.
const SAME_NORMAL: f32 = 0.95;
/// Greatest sine of the angle between a surface and the direction to another of its points.
const SAME_PLANE: f32 = 0.2;
/// Distance of neighbouring pixels on one surface, at most, in widths of pixels: it is foreshortened.
const NEAR: f32 = 16.0;

/// The light and the surface of a pixel, separately.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Texel {
    /// Radiance that is not averaged: directly visible lights, and surfaces that are excluded.
    pub(crate) plain: Vec3,
    /// Share of light that goes from the surface to the eye.
    pub(crate) share: Vec3,
    /// Light on the surface, averaged over directions as the surface scatters them.
    pub(crate) light: Vec3,
    pub(crate) p: Vec3,
    /// Unit, towards the eye.
    pub(crate) ns: Vec3,
    /// Width of the pixel there.
    pub(crate) width: f32,
    /// `INVALID_ID` = nothing to average.
    pub(crate) instance: u32,
    /// Whether it scatters light alike to all sides.
    pub(crate) is_diffuse: bool,
}

impl Default for Texel {
    fn default() -> Self {
        Self {
            plain: Vec3::ZERO,
            share: Vec3::ZERO,
            light: Vec3::ZERO,
            p: Vec3::ZERO,
            ns: Vec3::ZERO,
            width: 0.0,
            instance: INVALID_ID,
            is_diffuse: true,
        }
    }
}

impl Texel {
    fn is_surface(&self) -> bool {
        self.instance != INVALID_ID
    }

    /// Whether light of two pixels may be averaged.
    fn agrees(&self, other: &Self) -> bool {
        let offset = other.p - self.p;
        let distance = offset.length();
        let is_in_plane = |normal: Vec3| offset.dot(normal).abs() <= SAME_PLANE * distance;
        self.instance == other.instance
            && self.is_diffuse == other.is_diffuse
            && self.ns.dot(other.ns) >= SAME_NORMAL
            && is_in_plane(self.ns)
            && is_in_plane(other.ns)
            && (self.width <= 0.0 || distance <= NEAR * self.width)
    }
}

/// The subset of the virtual lights that a pixel gathers: the number of its position in the pattern.
pub(crate) fn place_of(pixel: u32, width: u32, n: u32) -> usize {
    (pixel % width % n + pixel / width % n * n) as usize
}

/// The key of a pixel's random numbers. All pixels at one position of the pattern have the same key, so that
/// neighbours differ only by their positions, which are averaged, and not by noise; together the positions
/// are one stratified set.
pub(super) fn key_of_place(key: SampleKey, width: u32, n: u32) -> SampleKey {
    let position = place_of(key.pixel, width, n) as u32;
    // Within 32 bits the last samples of a long rendering may reuse numbers, but never those of other
    // positions.
    let sample = key.sample % (u32::MAX / (n * n));
    SampleKey { pixel: PATTERN, sample: sample * (n * n) + position, ..key }
}

/// The subset of a key, of this number.
pub(super) fn share_of_key(sharing: Sharing, key: SampleKey, shares: usize) -> usize {
    let number = match sharing {
        Sharing::All => 0,
        Sharing::Pattern => key.sample,
        Sharing::Random => key.pixel,
    };
    number as usize % shares.max(1)
}

/// The virtual lights of each of this number of subsets, each with the power of all of them.
pub(super) fn shares(vpls: &[Vpl], pattern_size: usize) -> Vec<Vec<Vpl>> {
    let share = |position: usize| {
        vpls.iter().skip(position).step_by(pattern_size).map(|vpl| vpl.scaled(pattern_size as f32)).collect()
    };
    (0..pattern_size).map(share).collect()
}

/// The texels of a picture's part, by tiles of the film.
pub(crate) struct PatternTexels<'a> {
    /// Row by row in each tile.
    tiles: Vec<(&'a [u32; 4], &'a [Texel])>,
    /// Adjacent tiles.
    columns: usize,
    /// Width of tiles, and number of the first tile's column and row.
    grid: [u32; 3],
    region: [u32; 4],
    n: u32,
}

impl<'a> PatternTexels<'a> {
    /// `tiles` cover `region` in rows, on a grid of `size` pixels from the picture's corner.
    pub(crate) fn new(
        tiles: impl Iterator<Item = (&'a [u32; 4], &'a [Texel])>,
        region: [u32; 4],
        size: u32,
        n: u32,
    ) -> Self {
        let [x0, y0, x1, _] = region;
        let columns = (x1.div_ceil(size) - x0 / size) as usize;
        Self { tiles: tiles.collect(), columns, grid: [size, x0 / size, y0 / size], region, n }
    }

    fn at(&self, x: u32, y: u32) -> &Texel {
        let [size, column, row] = self.grid;
        let tile = (y / size - row) as usize * self.columns + (x / size - column) as usize;
        let ([x0, y0, x1, _], texels) = self.tiles[tile];
        &texels[((y - y0) * (x1 - x0) + (x - x0)) as usize]
    }

    /// Writes the radiance of a tile's pixels, in the film's order.
    pub(crate) fn filtered(&self, tile: &TileFilm, radiance: &mut Vec3s) {
        let [x0, y0, x1, y1] = self.region;
        let n = self.n;
        // The window is inside, so that it has each position of the pattern.
        let window = |at: u32, low: u32, high: u32| {
            let begin = at.saturating_sub(n / 2).clamp(low, high.saturating_sub(n).max(low));
            begin..(begin + n).min(high)
        };
        radiance.reset(tile.first.len(), Vec3::ZERO);
        for (lane, [x, y]) in tile.pixels().enumerate() {
            let middle = self.at(x, y);
            let mut pattern_texels = middle.plain;
            if middle.is_surface() {
                let (mut sum, mut count) = (Vec3::ZERO, 0.0);
                for row in window(y, y0, y1) {
                    for column in window(x, x0, x1) {
                        let other = self.at(column, row);
                        if (column, row) == (x, y) || middle.agrees(other) {
                            sum += other.light;
                            count += 1.0;
                        }
                    }
                }
                pattern_texels += middle.share * sum / count;
            }
            radiance.set(lane, pattern_texels);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::RenderOptions;

    /// A floor left of `edge`, and another object right of it.
    fn texel(x: u32, y: u32, edge: u32, neighbours: fn(&mut Texel)) -> Texel {
        let light = if x < edge { 1.0 } else { 100.0 };
        let mut texel = Texel {
            share: Vec3::splat(0.5),
            // Nine times the light at one position of the pattern.
            light: Vec3::splat(if (x % 3, y % 3) == (1, 2) { 9.0 * light } else { 0.0 }),
            p: Vec3::new(x as f32, y as f32, 0.0),
            ns: Vec3::Z,
            width: 1.0,
            instance: 0,
            ..Texel::default()
        };
        if x >= edge {
            neighbours(&mut texel);
        }
        texel
    }

    fn filtered(edge: u32, neighbours: fn(&mut Texel)) -> Vec<([u32; 2], f32)> {
        let region = [5, 3, 60, 40];
        let options = RenderOptions { interleave: 3, ..RenderOptions::default() };
        let tiles = TileFilm::cover(region, &options);
        let texels: Vec<Vec<Texel>> = tiles
            .iter()
            .map(|tile| {
                let [x0, y0, x1, y1] = tile.rect;
                (y0..y1).flat_map(|y| (x0..x1).map(move |x| texel(x, y, edge, neighbours))).collect()
            })
            .collect();
        let rects = tiles.iter().map(|tile| &tile.rect).zip(texels.iter().map(Vec::as_slice));
        let pattern_texels = PatternTexels::new(rects, region, crate::film::tile_size(&options), 3);
        let of_tile = |tile: &TileFilm| {
            let mut radiance = Vec3s::default();
            pattern_texels.filtered(tile, &mut radiance);
            tile.pixels().enumerate().map(|(i, pixel)| (pixel, radiance.x[i])).collect::<Vec<_>>()
        };
        tiles.iter().flat_map(of_tile).collect()
    }

    #[test]
    fn all_places_of_the_pattern_come_together() {
        for (pixel, light) in filtered(99, |_| ()) {
            assert!((light - 0.5).abs() < 1e-6, "pixel {pixel:?}: {light}");
        }
    }

    #[test]
    fn nothing_comes_over_edges() {
        let others: [fn(&mut Texel); 4] = [
            |texel| texel.instance = 1,
            |texel| texel.ns = Vec3::X,
            |texel| texel.p.z += 2.0,
            |texel| texel.p.x += 20.0,
        ];
        for neighbours in others {
            // The first column beyond has light.
            let all = filtered(31, neighbours);
            let near = |pixel: &&([u32; 2], f32)| pixel.0[0] < 31;
            let brightest = all.iter().filter(near).map(|(_, light)| *light).fold(0.0, f32::max);
            assert!(brightest < 2.0, "a hundred times brighter, but next door: {brightest}");
            let mean = all.iter().filter(near).map(|(_, light)| light / 962.0).sum::<f32>();
            assert!((mean - 0.5).abs() < 0.02, "all in all no light is lost: {mean}");
        }
    }
}
