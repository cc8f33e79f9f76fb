// SPDX-License-Identifier: GPL-3.0-or-later
//! Pixels of the previous whole picture at a point, and whether they show a surface of this one. Space of
//! points: pixels from the left and the top. Tests: crates/render/tests/motion.rs.

use glam::Vec3;

use super::surface_key::{Same, SurfaceKey};
use super::texel::{Shown, Texel};

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
        let is_one = taps.iter().fold(true, |is_one, tap| is_one & (tap.number() == number));
        if !is_one {
            return None;
        }
        let shown = Shown::mean(taps, weights([x - left as f32, y - top as f32]), number);
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
        let mut weights = weights([x - left, y - top]);
        let absent = Texel::default();
        let mut taps = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[dx, dy]| {
            let (column, row) = (left as i32 + dx, top as i32 + dy);
            let is_there =
                column >= 0 && row >= 0 && column < self.full[0] as i32 && row < self.full[1] as i32;
            is_there.then(|| &self.texels[row as usize * self.full[0] as usize + column as usize])
        });
        for (tap, weight) in taps.iter_mut().zip(&mut weights) {
            *tap = tap.filter(|tap| tap.number() == key.number() && is_on(tap.p(), key));
            if tap.is_none() {
                *weight = 0.0;
            }
        }
        let sum: f32 = weights.iter().sum();
        if sum <= 0.0 {
            return (Shown::default(), 0.0);
        }
        let taps = taps.map(|tap| tap.unwrap_or(&absent));
        (Shown::mean(taps, weights.map(|weight| weight / sum), key.number()), sum)
    }

    /// The pixel that holds a point.
    pub(super) fn nearest(&self, point: [f32; 2]) -> Option<&Texel> {
        let is_inside = (0..2).all(|k| point[k] >= 0.0 && point[k] < self.full[k] as f32);
        is_inside.then(|| &self.texels[(point[1] as u32 * self.full[0] + point[0] as u32) as usize])
    }
}

/// Weights of the pixels left and right, above and below.
#[inline(always)]
fn weights([right, below]: [f32; 2]) -> [f32; 4] {
    [(1.0 - right) * (1.0 - below), right * (1.0 - below), (1.0 - right) * below, right * below]
}

/// Whether a point of a thing with the same id is on the surface of a traced pixel beside it.
#[inline(always)]
pub(super) fn is_on(p: Vec3, key: &SurfaceKey) -> bool {
    let offset = p - key.p;
    let same = Same::new(key.width, 1.5);
    !key.is_surface() || same.holds(offset.length_squared(), offset.dot(key.ns), 1.0)
}
