// SPDX-License-Identifier: GPL-3.0-or-later
//! One lobe of each of many points, prepared for one direction each: its numbers, common to all kinds.
//! Space: world, unit directions away from the surface.
//! Values that depend on the view, evaluations and densities: `prepared_values.rs`; glass and deltas:
//! `prepared_glass.rs`; lobes evaluated per point: `prepared_scalar.rs`. Tests: `tests` of `bsdf`.

use super::anisotropy::{AnisotropyFrame, Slopes};
use super::ggx::Ggx;
use super::lobe::{Kind, rare};
use super::lobes::MOST;
use super::lobes_at::Rarities;
use crate::real::{Real, Vector};

/// Points' lobes in one position of their lists, prepared for one direction each.
#[derive(Clone, Copy, Debug)]
pub(super) struct PreparedLobe<R> {
    pub(super) kind: R,
    pub(super) kinds: u32,
    pub(super) normal: Vector<R>,
    /// Where it is seen from, raised to where that sees the front, and its cosine.
    pub(super) wo: Vector<R>,
    pub(super) cos: R,
    /// Factor of its values, except for the light that the layers above leave: `left` of that for the
    /// prepared direction.
    pub(super) weight: Vector<R>,
    pub(super) left: Vector<R>,
    pub(super) a: Vector<R>,
    pub(super) b: Vector<R>,
    pub(super) c: Vector<R>,
    /// Colour of multiple scattering between microfacets; where it is in their own lobe, the scale of that.
    pub(super) more: Vector<R>,
    pub(super) alpha: R,
    pub(super) eta: R,
    /// Smith's auxiliary function, and the energy that single scattering loses.
    pub(super) hidden: R,
    pub(super) lost: R,
    /// Chance that it is drawn from; that further bounces are, if it is.
    pub(super) probability: R,
    pub(super) share_of_more: R,
    pub(super) cover: Vector<R>,
    pub(super) covers: bool,
    /// Bits of the points below each of the lobes before.
    pub(super) layers_above: [u32; MOST],
    pub(super) any_layer_above: u32,
    pub(super) rare: u32,
    pub(super) rarities: Rarities<R>,
}

impl<Q: Copy> PreparedLobe<Q> {
    /// No lobe: all its numbers are `zero`.
    #[inline(always)]
    pub(super) fn none(zero: Q) -> Self {
        let black = Vector { x: zero, y: zero, z: zero };
        Self {
            kind: zero,
            kinds: 0,
            normal: black,
            wo: black,
            cos: zero,
            weight: black,
            left: black,
            a: black,
            b: black,
            c: black,
            more: black,
            alpha: zero,
            eta: zero,
            hidden: zero,
            lost: zero,
            probability: zero,
            share_of_more: zero,
            cover: black,
            covers: false,
            layers_above: [0; MOST],
            any_layer_above: 0,
            rare: 0,
            rarities: Rarities::all(zero),
        }
    }

    /// Changes each number by that of another; rare ones only where either has some.
    #[inline(always)]
    pub(super) fn each_with<P>(&mut self, other: &PreparedLobe<P>, mut f: impl FnMut(&mut Q, &P)) {
        f(&mut self.kind, &other.kind);
        self.normal.each_with(&other.normal, &mut f);
        self.wo.each_with(&other.wo, &mut f);
        f(&mut self.cos, &other.cos);
        self.weight.each_with(&other.weight, &mut f);
        self.left.each_with(&other.left, &mut f);
        self.a.each_with(&other.a, &mut f);
        self.b.each_with(&other.b, &mut f);
        self.c.each_with(&other.c, &mut f);
        self.more.each_with(&other.more, &mut f);
        f(&mut self.alpha, &other.alpha);
        f(&mut self.eta, &other.eta);
        f(&mut self.hidden, &other.hidden);
        f(&mut self.lost, &other.lost);
        f(&mut self.probability, &other.probability);
        f(&mut self.share_of_more, &other.share_of_more);
        if self.covers | other.covers {
            self.cover.each_with(&other.cover, &mut f);
        }
        if self.rare | other.rare != 0 {
            self.rarities.each_with(&other.rarities, &mut f);
        }
    }
}

impl<R: Real> PreparedLobe<R> {
    #[inline(always)]
    pub(super) fn has(&self, kind: Kind) -> bool {
        self.kinds & kind.bit() != 0
    }

    #[inline(always)]
    pub(super) fn is(&self, kind: Kind) -> R::Mask {
        self.kind.is(self.kind.all(kind as u32 as f32))
    }

    /// Points that lie below lobe `j`.
    #[inline(always)]
    pub(super) fn below(&self, j: usize) -> R::Mask {
        self.cos.points(u64::from(self.layers_above[j]))
    }

    /// Its microfacets.
    #[inline(always)]
    pub(super) fn slopes(&self) -> Slopes<R> {
        let ggx = Ggx::from_alpha(self.alpha);
        if self.rare & rare::ANISOTROPY == 0 {
            return Slopes { ggx, anisotropy: None };
        }
        let Rarities { tangent, across, .. } = self.rarities;
        let is = across.above_all(0.0);
        // As narrow as slopes along the first axis may be.
        let across = R::pick(is, Ggx::from_alpha(across).alpha(), across);
        Slopes {
            ggx,
            anisotropy: Some(AnisotropyFrame { tangent, bitangent: self.normal.cross(tangent), across, is }),
        }
    }

    /// Becomes `next` for the points of the mask, in all fields for choosing directions.
    #[inline(always)]
    pub(super) fn mix(&mut self, mask: R::Mask, next: &Self) {
        self.kinds |= next.kinds;
        self.rare |= next.rare;
        self.each_with(
            next,
            #[inline(always)]
            |own, &next| *own = R::pick(mask, next, *own),
        );
    }
}
