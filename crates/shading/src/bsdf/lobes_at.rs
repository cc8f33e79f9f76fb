// SPDX-License-Identifier: GPL-3.0-or-later
//! Lobes of many points as numbers, before they are seen from anywhere.
//! Space: world. Invariant: the numbers of [`Lobe`]. Tests: `tests` of `bsdf`.

use super::lobe::Lobe;
use crate::real::Vector;

/// The lobes in one position of many points' lists, as numbers.
#[derive(Clone, Copy)]
pub(crate) struct LobesAt<'a, R> {
    /// `Kind` by point, and the set of the present ones.
    pub(super) kind: R,
    pub(super) kinds: u32,
    pub(super) weight: Vector<R>,
    pub(super) normal: Vector<R>,
    pub(super) a: Vector<R>,
    pub(super) b: Vector<R>,
    pub(super) c: Vector<R>,
    pub(super) alpha: R,
    pub(super) eta: R,
    pub(super) cover: Vector<R>,
    /// Which lobes lie above, by point; a bit set for all of them.
    pub(super) layers_above: &'a [u32],
    pub(super) any_layer_above: u32,
    pub(super) covers: bool,
    /// The rare features that some have: bits of `rare`.
    pub(super) rare: u32,
    pub(super) rarities: Rarities<R>,
}

/// Numbers of rare features of lobes; zero where a point has none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rarities<R> {
    /// See [`Lobe::tangent`]; once seen, unit and along the surface.
    pub(super) tangent: Vector<R>,
    pub(super) across: R,
    /// Share, index, thickness of the film.
    pub(super) film: [R; 3],
    pub(super) spread: R,
    /// Chances of the three colours where they are bent into different directions.
    pub(super) channels: Vector<R>,
}

impl<R: Copy> Rarities<R> {
    #[inline(always)]
    pub(super) fn all(x: R) -> Self {
        let v = Vector { x, y: x, z: x };
        Self { tangent: v, across: x, film: [x; 3], spread: x, channels: v }
    }
}

impl<Q> Rarities<Q> {
    /// Changes each number by that of another.
    #[inline(always)]
    pub(super) fn each_with<P>(&mut self, other: &Rarities<P>, f: &mut impl FnMut(&mut Q, &P)) {
        self.tangent.each_with(&other.tangent, &mut *f);
        f(&mut self.across, &other.across);
        for (own, other) in self.film.iter_mut().zip(&other.film) {
            f(own, other);
        }
        f(&mut self.spread, &other.spread);
        self.channels.each_with(&other.channels, f);
    }
}

impl<'a> LobesAt<'a, f32> {
    /// That of one point.
    pub(super) fn of_point(lobe: &'a Lobe) -> Self {
        Self {
            kind: lobe.kind as u32 as f32,
            kinds: lobe.kind.bit(),
            weight: lobe.weight.into(),
            normal: lobe.normal.into(),
            a: lobe.a.into(),
            b: lobe.b.into(),
            c: lobe.c.into(),
            alpha: lobe.alpha,
            eta: lobe.eta,
            cover: lobe.cover.into(),
            layers_above: std::slice::from_ref(&lobe.layers_above),
            any_layer_above: lobe.layers_above,
            covers: lobe.covers(),
            rare: lobe.rare(),
            rarities: Rarities {
                tangent: lobe.tangent.into(),
                across: lobe.across,
                film: [lobe.film.share, lobe.film.ior, lobe.film.thickness],
                spread: lobe.spread,
                channels: Vector::grey(0.0),
            },
        }
    }
}
