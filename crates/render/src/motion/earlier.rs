// SPDX-License-Identifier: GPL-3.0-or-later
//! Pixels of the previous whole picture at a point, and whether they show a surface of this one. Space of
//! points: pixels from the left and the top. Tests: crates/render/tests/motion.rs.

use glam::{Vec3, Vec4};

use super::around::{around, bilinear};
use super::surface_key::{Same, SurfaceKey};
use super::texel::{Shown, Texel};

/// Distance of points of one surface in widths of pixels, as [`SurfaceKey::agrees`] takes it.
const ON: f32 = 1.5;

/// The picture before.
pub(super) struct Earlier<'a> {
    pub(super) full: [u32; 2],
    pub(super) texels: &'a [Texel],
}

impl Earlier<'_> {
    /// The mean of the four pixels around a point, if all of them show the surface.
    #[inline(always)]
    pub(super) fn inside_surface(&self, point: [f32; 2], key: &SurfaceKey) -> Option<Shown> {
        // From the centre of the first pixel. A point that is not there is NaN, and not inside.
        let [x, y] = point.map(|at| at - 0.5);
        let is_inside = |at: f32, side: u32| (at >= 0.0) & (at < side as f32 - 1.0);
        if !(is_inside(x, self.full[0]) & is_inside(y, self.full[1])) {
            return None;
        }
        let (left, top) = (x as u32, y as u32);
        let first = (top * self.full[0] + left) as usize;
        let [above, below] = [first, first + self.full[0] as usize].map(|i| &self.texels[i..i + 2]);
        let (taps, number) = ([&above[0], &above[1], &below[0], &below[1]], key.number());
        // Bits without branches: numbers are never NaN, nor negative.
        let differs = |tap: &Texel| tap.number().to_bits() ^ number.to_bits();
        if taps.iter().fold(0, |all, tap| all | differs(tap)) != 0 {
            return None;
        }
        let [right, below] = [x - left as f32, y - top as f32];
        let shown = Shown::mean(taps, bilinear([1.0 - right, right], [1.0 - below, below]), number);
        is_on(shown.p(), key).then_some(shown)
    }

    /// The mean of those of the four pixels around a point that show the surface, and their share of weights.
    #[inline(always)]
    pub(super) fn of_surface(&self, point: [f32; 2], key: &SurfaceKey) -> (Shown, f32) {
        match self.inside_surface(point, key) {
            Some(shown) => (shown, 1.0),
            None => self.of_surface_at_edge(point.map(|at| at - 0.5), key),
        }
    }

    /// The same where some of the pixels show something else.
    #[inline(always)]
    fn of_surface_at_edge(&self, [x, y]: [f32; 2], key: &SurfaceKey) -> (Shown, f32) {
        let is_near = |at: f32, side: u32| at > -1.0 && at < side as f32;
        if !(is_near(x, self.full[0]) && is_near(y, self.full[1])) {
            return (Shown::default(), 0.0);
        }
        let (left, top) = (x.floor(), y.floor());
        let (at, weights) = around([left as i32, top as i32], [x - left, y - top], self.full);
        let taps = at.map(|i| &self.texels[i]);
        let number = key.number();
        let same = Vec4::from(taps.map(|tap| if tap.number() == number { 1.0 } else { 0.0 }));
        let mut weights = Vec4::from(weights) * same;
        if key.is_surface() {
            let points = [taps[0].p(), taps[1].p(), taps[2].p(), taps[3].p()];
            let each = |k: usize| Vec4::new(points[0][k], points[1][k], points[2][k], points[3][k]);
            weights = key.on_surface([each(0), each(1), each(2)], weights, ON);
        }
        let [a, b, c, d] = weights.to_array();
        let sum = a + b + c + d;
        if sum <= 0.0 {
            return (Shown::default(), 0.0);
        }
        (Shown::mean(taps, (weights / sum).to_array(), number), sum)
    }

    /// The pixel that holds a point.
    pub(super) fn nearest(&self, point: [f32; 2]) -> Option<&Texel> {
        let is_inside = (0..2).all(|k| point[k] >= 0.0 && point[k] < self.full[k] as f32);
        is_inside.then(|| &self.texels[(point[1] as u32 * self.full[0] + point[0] as u32) as usize])
    }
}

/// Whether a point of a thing with the same id is on the surface of a traced pixel beside it.
#[inline(always)]
pub(super) fn is_on(p: Vec3, key: &SurfaceKey) -> bool {
    let offset = p - key.p;
    let same = Same::new(key.width, ON);
    !key.is_surface() || same.holds(offset.length_squared(), offset.dot(key.ns), 1.0)
}
