// SPDX-License-Identifier: GPL-3.0-or-later
//! All pixels of a picture of which one in four was traced: the others show the same surface as in earlier
//! pictures, and the light of the traced pixels around them.
//! Source: temporal upsampling [YNS*09], with the surfaces compared instead of colours. A pixel moves as the
//! traced ones beside it. Differs: the reflectance comes from earlier pictures, at most three, the light from
//! this one, so that light that changes does not lag behind. Space: world.
//! Things too thin for the traced pixels show if they were traced before, are before all of them, and did not go away.
//! Invariant: traced pixels are shown as traced; a pixel shows a surface that was traced there or beside it.
//! Tests: crates/render/tests/motion.rs.

use glam::Vec3;
use gnurt_accel::threads::{self, Pieces};
use gnurt_shading::CameraShader;
use gnurt_simd::{Level, dispatch_two};

use super::earlier::{Earlier, is_on};
use super::lattice::Lattice;
use super::smooth::Smooth;
use super::surface_key::{SurfaceKey, Tint};
use super::texel::{Shown, Texel};
use crate::film::{self, BLOCK, TileFilm};

/// Share of the four pixels around a point that have to show its surface.
const LEAST_SHOWN: f32 = 0.25;
/// From this share on no other neighbour is considered: it is the most of them.
const ENOUGH_SHOWN: f32 = 0.5;
/// How far off a pixel's centre the points of thin things may be, in pixels.
const OFF_CENTRE: f32 = 0.75;

/// The traced pixels, row by row of the lattice.
pub(super) struct Traced<'a> {
    pub(super) lattice: Lattice,
    pub(super) surface_keys: &'a [SurfaceKey],
    pub(super) tints: &'a [Tint],
    pub(super) shown: &'a Smooth,
    /// Light on pixels of which nothing is known.
    pub(super) unknown: Vec3,
    /// Where the point of each pixel was in the previous picture, in its pixels; NaN where it was not.
    pub(super) origins: &'a [[f32; 2]],
    pub(super) camera: &'a dyn CameraShader,
    pub(super) eye: Vec3,
}

impl Traced<'_> {
    #[inline(always)]
    fn index(&self, [x, y]: [u32; 2]) -> usize {
        (y * self.lattice.size()[0] + x) as usize
    }

    #[inline(always)]
    fn shown(&self, at: [u32; 2], light: Vec3) -> Shown {
        let i = self.index(at);
        Shown::traced(&self.surface_keys[i], &self.tints[i], light)
    }

    /// How far the point of a pixel is from the eye, squared.
    fn distance2(&self, at: [u32; 2]) -> f32 {
        let key = &self.surface_keys[self.index(at)];
        if key.is_surface() { key.p.distance_squared(self.eye) } else { f32::INFINITY }
    }
}

/// A traced pixel, for those between it and the next ones: light; where its point was in the previous picture;
/// whether the next one in the row shows the same surface, and the one below.
#[derive(Clone, Copy, Default)]
#[repr(align(32))]
struct Spot([f32; 8]);

impl Spot {
    #[inline(always)]
    fn light(&self) -> Vec3 {
        Vec3::new(self.0[0], self.0[1], self.0[2])
    }

    #[inline(always)]
    fn origin(&self) -> [f32; 2] {
        [self.0[3], self.0[4]]
    }

    #[inline(always)]
    fn right(&self) -> bool {
        self.0[5] != 0.0
    }

    #[inline(always)]
    fn below(&self) -> bool {
        self.0[6] != 0.0
    }

    #[inline(always)]
    fn mean(spots: [&Self; 4]) -> Self {
        let mut sum = Self::default();
        for spot in spots {
            sum.0.iter_mut().zip(&spot.0).for_each(|(sum, x)| *sum += x);
        }
        Self(sum.0.map(|x| 0.25 * x))
    }
}

/// The pixels of the last whole picture.
#[derive(Default)]
pub(super) struct Whole {
    full: [u32; 2],
    texels: Vec<Texel>,
    spare: Vec<Texel>,
    spots: Vec<Spot>,
}

impl Whole {
    /// Whether there is a previous picture of this size.
    pub(super) fn is_of(&self, full: [u32; 2]) -> bool {
        self.full == full && !self.texels.is_empty()
    }

    pub(super) fn forget(&mut self) {
        self.full = [0, 0];
        self.texels.clear();
    }

    /// Takes over a picture of which all pixels were traced. Call within a pool of threads.
    pub(super) fn take(&mut self, full: [u32; 2], keys: &[SurfaceKey], tints: &[Tint], shown: &Smooth) {
        self.full = full;
        self.texels.resize(keys.len(), Texel::default());
        let width = full[0] as usize;
        let rows = Pieces::new(&mut self.texels, width);
        threads::for_each(true, rows.count(), &|y| {
            for (x, texel) in rows.lock(y).iter_mut().enumerate() {
                let i = y * width + x;
                *texel = Shown::traced(&keys[i], &tints[i], shown.light(x, y).mean).texel();
            }
        });
    }

    /// The next picture, whose colours and opacities go to `tiles`. Call within a pool of threads.
    pub(super) fn next(&mut self, traced: &Traced, tiles: &mut [TileFilm], level: Level) {
        let full = traced.lattice.full;
        let before = self.is_of(full).then_some(Earlier { full, texels: &self.texels });
        let (mut texels, pixels) = (std::mem::take(&mut self.spare), full[0] as usize * full[1] as usize);
        texels.resize(pixels, Texel::default());
        find_spots(traced, &mut self.spots, level);
        let columns: Vec<Beside> = (0..full[0]).map(|x| Beside::of(traced.lattice, 0, x)).collect();
        let maker = Maker { traced, spots: &self.spots, before: before.as_ref(), columns: &columns };
        let bands = Pieces::new(&mut texels, (full[0] * BLOCK) as usize);
        let mut strips = film::strips(tiles);
        let strips = Pieces::new(&mut strips, 1);
        let width = full[0] as usize;
        let make = |colors: &mut Vec<[f32; 4]>, n: usize| {
            let (mut texels, mut strips) = (bands.lock(n), strips.lock(n));
            colors.resize(texels.len(), [0.0; 4]);
            let rows = texels.chunks_mut(width).zip(colors.chunks_mut(width));
            for (y, (texels, colors)) in (n as u32 * BLOCK..).zip(rows) {
                dispatch_two!(level, _simd => maker.row(y, texels, colors));
            }
            strips[0].show(colors, width);
        };
        threads::map_with(true, bands.count(), Vec::new, make);
        drop(bands);
        self.spare = std::mem::replace(&mut self.texels, texels);
        self.full = full;
    }
}

/// The columns or rows of the lattice beside one of the picture.
#[derive(Clone, Copy)]
struct Beside {
    first: u32,
    last: u32,
    /// Whether it is in the middle between them, or on both.
    is_between: bool,
}

impl Beside {
    fn of(lattice: Lattice, axis: usize, pixel: u32) -> Self {
        let [first, last] = lattice.beside(axis, pixel);
        let [before, after] = [first, last].map(|at| lattice.pixel([at, at])[axis]);
        // Beyond the first and the last ones it is not.
        Self { first, last, is_between: before + after == 2 * pixel }
    }
}

/// The data that the pixels of a picture are made from.
struct Maker<'a> {
    traced: &'a Traced<'a>,
    spots: &'a [Spot],
    before: Option<&'a Earlier<'a>>,
    columns: &'a [Beside],
}

impl Maker<'_> {
    /// Row `y` of a picture.
    #[inline(always)]
    fn row(&self, y: u32, texels: &mut [Texel], colors: &mut [[f32; 4]]) {
        let rows = Beside::of(self.traced.lattice, 1, y);
        let width = self.traced.lattice.size()[0] as usize;
        let (top, bottom) = (rows.first as usize * width, rows.last as usize * width);
        let pixels = texels.iter_mut().zip(colors).zip(self.columns);
        for (x, ((texel, color), columns)) in (0_u32..).zip(pixels) {
            let (left, right) = (columns.first as usize, columns.last as usize);
            let corners = [top + left, top + right, bottom + left, bottom + right];
            let inside = if rows.is_between & columns.is_between { self.inside(corners) } else { None };
            let (shown, light) = inside.unwrap_or_else(|| {
                let beside = [[columns.first, columns.last], [rows.first, rows.last]];
                Pixel { at: [x, y], beside }.at_edge(self.traced, self.spots, self.before)
            });
            (*texel, *color) = (shown.texel(), shown.color(light));
        }
    }

    /// The surface and the light of a pixel amid these, if they show one surface.
    #[inline(always)]
    fn inside(&self, corners: [usize; 4]) -> Option<(Shown, Vec3)> {
        let [a, b, c, d] = corners;
        let spots = [&self.spots[a], &self.spots[b], &self.spots[c], &self.spots[d]];
        if a == d {
            let (key, tint) = (&self.traced.surface_keys[a], &self.traced.tints[a]);
            let light = spots[0].light();
            return Some((Shown::traced(key, tint, light), light));
        }
        let goes_on = (a == b || spots[0].right()) && (a == c || spots[0].below() && spots[1].below());
        let before = self.before.filter(|_| goes_on)?;
        // Within a surface its point and its light are between those of the traced pixels.
        let mean = Spot::mean(spots);
        let shown = before.inside_surface(mean.origin(), &self.traced.surface_keys[a])?;
        Some((shown, mean.light()))
    }
}

/// Light on traced pixels, and the surfaces that go on from one to the next.
fn find_spots(traced: &Traced, spots: &mut Vec<Spot>, level: Level) {
    let [width, height] = traced.lattice.size().map(|side| side as usize);
    spots.resize(width * height, Spot::default());
    let rows = Pieces::new(spots, width);
    threads::for_each(true, rows.count(), &|y| {
        let mut spots = rows.lock(y);
        dispatch_two!(level, _simd => spots_of_row(traced, y, &mut spots));
    });
}

#[inline(always)]
fn spots_of_row(traced: &Traced, y: usize, spots: &mut [Spot]) {
    let width = spots.len();
    let own = &traced.surface_keys[y * width..][..width];
    let below = traced.surface_keys.get((y + 1) * width..).unwrap_or_default();
    let origins = &traced.origins[y * width..][..width];
    for (x, spot) in spots.iter_mut().enumerate() {
        let same = |other: &SurfaceKey| {
            let goes_on = own[x].id == other.id && (!own[x].is_surface() || own[x].agrees(other, 1.5));
            if goes_on { 1.0 } else { 0.0 }
        };
        let light = traced.shown.light(x, y);
        let [r, g, b] = if light.count > 0.0 { light.mean } else { traced.unknown }.to_array();
        let (right, below) = (own.get(x + 1).map_or(0.0, same), below.get(x).map_or(0.0, same));
        *spot = Spot([r, g, b, origins[x][0], origins[x][1], right, below, 0.0]);
    }
}

/// A pixel and the columns and rows of traced ones beside it.
struct Pixel {
    at: [u32; 2],
    beside: [[u32; 2]; 2],
}

impl Pixel {
    /// The traced pixels beside it, each once.
    #[inline(always)]
    fn neighbours(&self) -> impl Iterator<Item = [u32; 2]> + Clone + use<> {
        let [[left, right], [top, bottom]] = self.beside;
        (top..=bottom).flat_map(move |y| (left..=right).map(move |x| [x, y]))
    }

    /// Where several surfaces meet.
    #[inline(always)]
    fn at_edge(&self, traced: &Traced, spots: &[Spot], before: Option<&Earlier>) -> (Shown, Vec3) {
        let Some(shown) = before.and_then(|before| self.known(traced, before)) else {
            let far = self.farthest(traced);
            let light = spots[traced.index(far)].light();
            return (traced.shown(far, light), light);
        };
        let (mut light, mut count) = (Vec3::ZERO, 0.0);
        for i in self.neighbours().map(|at| traced.index(at)) {
            let key = &traced.surface_keys[i];
            if key.number() == shown.number() && is_on(shown.p(), key) {
                light += spots[i].light();
                count += 1.0;
            }
        }
        (shown, if count > 0.0 { light / count } else { shown.light() })
    }

    /// Its surface in the previous picture.
    #[inline(always)]
    fn known(&self, traced: &Traced, before: &Earlier) -> Option<Shown> {
        let (mut best, mut most) = (Shown::default(), 0.0);
        for at in self.neighbours() {
            let key = &traced.surface_keys[traced.index(at)];
            // Another neighbour that shows the same surface moves as the first one.
            if most > 0.0 && key.number() == best.number() && is_on(best.p(), key) {
                continue;
            }
            let (shown, share) = before.of_surface(self.origin(traced, at), key);
            if share > most {
                (best, most) = (shown, share);
            }
            if most >= ENOUGH_SHOWN {
                break;
            }
        }
        if most >= LEAST_SHOWN { Some(best) } else { self.thin(traced, before) }
    }

    /// Where its point was in the previous picture if it moves as a traced one does.
    #[inline(always)]
    fn origin(&self, traced: &Traced, at: [u32; 2]) -> [f32; 2] {
        let (origin, pixel) = (traced.origins[traced.index(at)], traced.lattice.pixel(at));
        [0, 1].map(|k| origin[k] + (self.at[k] as f32 - pixel[k] as f32))
    }

    /// A thing between the traced pixels.
    fn thin(&self, traced: &Traced, before: &Earlier) -> Option<Shown> {
        let [width, height] = before.full.map(|side| side as f32);
        let is_here = |texel: &&Texel| {
            let p = texel.p();
            texel.number() != 0.0
                && self.neighbours().all(|at| p.distance_squared(traced.eye) < traced.distance2(at))
                && traced.camera.project(p, width / height).is_some_and(|[across, up]| {
                    let off = [across * width, (1.0 - up) * height];
                    (0..2).all(|k| (off[k] - self.at[k] as f32 - 0.5).abs() < OFF_CENTRE)
                })
        };
        let candidates = self.neighbours().filter_map(|at| before.nearest(self.origin(traced, at)));
        candidates.into_iter().find(is_here).map(Texel::shown)
    }

    /// The farthest neighbour: uncovered things lie behind.
    fn farthest(&self, traced: &Traced) -> [u32; 2] {
        let far = self.neighbours().max_by(|&a, &b| traced.distance2(a).total_cmp(&traced.distance2(b)));
        far.unwrap_or_default()
    }
}
