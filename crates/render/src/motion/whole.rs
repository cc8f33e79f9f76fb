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

/// Share of the four pixels around a point that have to show its surface.
const LEAST_SHOWN: f32 = 0.25;
/// From this share on no other neighbour is asked.
const ENOUGH_SHOWN: f32 = 0.99;
/// How far off a pixel's centre the points of thin things may be, in pixels.
const OFF_CENTRE: f32 = 0.75;
/// Rows that go together.
const ROWS: u32 = 8;

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

/// A traced pixel, for those between it and the next ones.
#[derive(Clone, Copy, Default)]
struct Spot {
    light: Vec3,
    /// Whether the next one in the row shows the same surface, and the one below.
    right: bool,
    below: bool,
}

/// The pixels of the last whole picture.
#[derive(Default)]
pub(super) struct Whole {
    full: [u32; 2],
    texels: Vec<Texel>,
    /// Colours and opacities as shown.
    colors: Vec<[f32; 4]>,
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

    /// The next picture. Call within a pool of threads.
    pub(super) fn next(&mut self, traced: &Traced, level: Level) {
        let full = traced.lattice.full;
        let before = self.is_of(full).then_some(Earlier { full, texels: &self.texels });
        let (mut texels, pixels) = (std::mem::take(&mut self.spare), full[0] as usize * full[1] as usize);
        texels.resize(pixels, Texel::default());
        self.colors.resize(pixels, [0.0; 4]);
        find_spots(traced, &mut self.spots);
        let spots = &self.spots;
        let band = (full[0] * ROWS) as usize;
        let (bands, colors) = (Pieces::new(&mut texels, band), Pieces::new(&mut self.colors, band));
        threads::for_each(true, bands.count(), &|n| {
            let (mut texels, mut colors) = (bands.lock(n), colors.lock(n));
            let rows = texels.chunks_mut(full[0] as usize).zip(colors.chunks_mut(full[0] as usize));
            for (y, (texels, colors)) in (n as u32 * ROWS..).zip(rows) {
                dispatch_two!(level, _simd => row(traced, spots, before.as_ref(), y, (texels, colors)));
            }
        });
        drop((bands, colors));
        self.spare = std::mem::replace(&mut self.texels, texels);
        self.full = full;
    }

    /// Colour and opacity of a pixel.
    #[inline(always)]
    pub(super) fn color(&self, x: u32, y: u32) -> [f32; 4] {
        self.colors[(y * self.full[0] + x) as usize]
    }
}

/// Row `y` of a picture.
#[inline(always)]
fn row(
    traced: &Traced,
    spots: &[Spot],
    before: Option<&Earlier>,
    y: u32,
    (texels, colors): (&mut [Texel], &mut [[f32; 4]]),
) {
    let rows = traced.lattice.beside(1, y);
    for (x, (texel, color)) in (0_u32..).zip(texels.iter_mut().zip(colors)) {
        let pixel = Pixel { at: [x, y], beside: [traced.lattice.beside(0, x), rows] };
        let (shown, light) = pixel.shown(traced, spots, before);
        (*texel, *color) = (shown.texel(), shown.color(light));
    }
}

/// Light on traced pixels, and the surfaces that go on from one to the next.
fn find_spots(traced: &Traced, spots: &mut Vec<Spot>) {
    let [width, height] = traced.lattice.size().map(|side| side as usize);
    spots.resize(width * height, Spot::default());
    let rows = Pieces::new(spots, width);
    threads::for_each(true, rows.count(), &|y| {
        let own = &traced.surface_keys[y * width..][..width];
        let below = traced.surface_keys.get((y + 1) * width..).unwrap_or_default();
        for (x, spot) in rows.lock(y).iter_mut().enumerate() {
            let same = |other: &SurfaceKey| {
                own[x].id == other.id && (!own[x].is_surface() || own[x].agrees(other, 1.5))
            };
            let light = traced.shown.light(x, y);
            *spot = Spot {
                light: if light.count > 0.0 { light.mean } else { traced.unknown },
                right: own.get(x + 1).is_some_and(same),
                below: below.get(x).is_some_and(same),
            };
        }
    });
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

    /// Its surface, and the light there.
    #[inline(always)]
    fn shown(&self, traced: &Traced, spots: &[Spot], before: Option<&Earlier>) -> (Shown, Vec3) {
        let [[left, right], [top, bottom]] = self.beside;
        let corners = [[left, top], [right, top], [left, bottom], [right, bottom]].map(|at| traced.index(at));
        let [first, last] = [[left, top], [right, bottom]].map(|at| traced.lattice.pixel(at));
        // Beyond the first and the last ones it is not.
        let is_between = (0..2).all(|k| first[k] + last[k] == 2 * self.at[k]);
        if is_between && corners[0] == corners[3] {
            let light = spots[corners[0]].light;
            return (traced.shown([left, top], light), light);
        }
        let goes_on = is_between
            && (left == right || spots[corners[0]].right)
            && (top == bottom || spots[corners[0]].below && spots[corners[1]].below);
        if let Some(before) = before.filter(|_| goes_on) {
            // Within a surface its point and its light are between those of the traced pixels.
            let point = [0, 1].map(|k| 0.25 * corners.iter().map(|&i| traced.origins[i][k]).sum::<f32>());
            if let Some(shown) = before.inside_surface(point, &traced.surface_keys[corners[0]]) {
                return (shown, 0.25 * corners.iter().map(|&i| spots[i].light).sum::<Vec3>());
            }
        }
        self.at_edge(traced, spots, before)
    }

    /// Where several surfaces meet.
    #[inline(always)]
    fn at_edge(&self, traced: &Traced, spots: &[Spot], before: Option<&Earlier>) -> (Shown, Vec3) {
        let Some(shown) = before.and_then(|before| self.known(traced, before)) else {
            let far = self.farthest(traced);
            let light = spots[traced.index(far)].light;
            return (traced.shown(far, light), light);
        };
        let (mut light, mut count) = (Vec3::ZERO, 0.0);
        for i in self.neighbours().map(|at| traced.index(at)) {
            let key = &traced.surface_keys[i];
            if key.number() == shown.number() && is_on(shown.p(), key) {
                light += spots[i].light;
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
