// SPDX-License-Identifier: GPL-3.0-or-later
//! A weighted sum of lobes, some of them below others: the complete scattering of a point. Sums and layers as
//! shading languages have them (MaterialX's `layer`).
//! Invariant: lobes above others come first; no lobe lies below itself. Layout: most surfaces have one lobe or two, and points are passed
//! on often: more lie elsewhere. Tests: `tests`.

use std::sync::Arc;

use glam::Vec3;

use super::lobe::{Kind, Lobe};

/// Maximum number of lobes of one point. Further ones are dropped.
pub const MOST: usize = 8;

/// Lobes that lie where the list does.
const FEW: usize = 2;

/// A weighted sum of lobes.
#[derive(Debug, Default)]
pub struct Lobes {
    /// All of them, if they fit; entries behind the first `count` are unused.
    few: [Lobe; FEW],
    /// All of them, if they are more; else left-overs.
    many: Option<Arc<[Lobe; MOST]>>,
    count: u32,
}

impl Clone for Lobes {
    #[inline]
    fn clone(&self) -> Self {
        let many = if self.are_few() { None } else { self.many.clone() };
        Self { few: self.few, many, count: self.count }
    }
}

impl PartialEq for Lobes {
    fn eq(&self, other: &Self) -> bool {
        self.as_slice() == other.as_slice()
    }
}

impl From<Lobe> for Lobes {
    fn from(lobe: Lobe) -> Self {
        let mut lobes = Self::default();
        lobes.push(lobe);
        lobes
    }
}

impl Lobes {
    #[inline(always)]
    fn are_few(&self) -> bool {
        self.count as usize <= FEW
    }

    /// The lobes.
    #[inline]
    #[must_use]
    pub fn as_slice(&self) -> &[Lobe] {
        match &self.many {
            Some(many) if !self.are_few() => &many[..self.count as usize],
            _ => &self.few[..self.count as usize],
        }
    }

    pub(super) fn as_mut_slice(&mut self) -> &mut [Lobe] {
        let (count, are_few) = (self.count as usize, self.are_few());
        match &mut self.many {
            Some(many) if !are_few => &mut Arc::make_mut(many)[..count],
            _ => &mut self.few[..count],
        }
    }

    /// Takes all lobes away; where they were stays as it is.
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    #[inline]
    pub(super) fn push(&mut self, lobe: Lobe) {
        let count = self.count as usize;
        if let Some(entry) = self.few.get_mut(count) {
            *entry = lobe;
            self.count += 1;
        } else if count < MOST {
            let many = Arc::make_mut(self.many.get_or_insert_default());
            if count == FEW {
                many[..FEW].copy_from_slice(&self.few);
            }
            many[count] = lobe;
            self.count += 1;
        }
    }

    /// Appends a lobe below those whose bits are set; gives its bit.
    #[inline]
    pub(super) fn put(&mut self, lobe: Lobe, layers_above: u32) -> u32 {
        self.push(Lobe { layers_above, ..lobe });
        1 << (self.count - 1)
    }

    /// The sum of both.
    #[must_use]
    pub fn plus(mut self, other: impl Into<Self>) -> Self {
        let first = self.count;
        for lobe in other.into().as_slice() {
            self.push(Lobe { layers_above: lobe.layers_above << first, ..*lobe });
        }
        self
    }

    /// All of it times a colour.
    #[must_use]
    pub fn times(mut self, weight: Vec3) -> Self {
        self.as_mut_slice().iter_mut().for_each(|lobe| lobe.weight *= weight);
        self
    }

    /// `(1 - share)` of it and `share` of the other.
    #[must_use]
    pub fn mixed(self, other: impl Into<Self>, share: f32) -> Self {
        let other = other.into().times(Vec3::splat(share));
        self.times(Vec3::splat(1.0 - share)).plus(other)
    }

    /// It above `base`, which gets the rest of the light. A `base` with microfacets loses the larger loss of
    /// both directions, a diffuse one loses both, so that a white body reflects all light. Each colour is by itself, as are
    /// weights. A diffuse lobe or a metal hides `base` by its weight, whatever its reflectance: it absorbs the rest. Light transmitted by
    /// glass does not reach `base` either.
    #[must_use]
    pub fn over(mut self, base: impl Into<Self>) -> Self {
        let above = (1_u32 << self.count) - 1;
        let mut hidden = Vec3::ZERO;
        for lobe in self.as_mut_slice() {
            let [cover, hides] = lobe.above();
            lobe.cover = cover;
            hidden += hides;
        }
        let base = base.into().times((Vec3::ONE - hidden).max(Vec3::ZERO));
        let first = self.count;
        for lobe in base.as_slice() {
            self.push(Lobe { layers_above: lobe.layers_above << first | above, ..*lobe });
        }
        self
    }

    /// The lobes selected by `keep`; the others scatter nothing, but still cover the lobes below.
    #[must_use]
    pub fn filtered(mut self, keep: impl Fn(&Lobe) -> bool) -> Self {
        for lobe in self.as_mut_slice() {
            if !keep(lobe) {
                lobe.weight = Vec3::ZERO;
            }
        }
        self
    }

    /// What of the lobes stays on the side that light came from; hair counts whole.
    #[must_use]
    pub fn reflecting(mut self) -> Self {
        for lobe in self.as_mut_slice() {
            match lobe.kind {
                Kind::Translucent => lobe.weight = Vec3::ZERO,
                Kind::SchlickGlass if lobe.spread < 0.0 => lobe.weight = Vec3::ZERO,
                Kind::Strand if lobe.c.x > 0.0 => lobe.weight = Vec3::ZERO,
                Kind::Glass | Kind::Pane | Kind::SmoothGlass | Kind::SmoothPane | Kind::Beckmann => {
                    lobe.b = Vec3::ZERO;
                }
                _ => {}
            }
        }
        self
    }

    /// The albedo, if it is only Lambert's reflector around the point's normal.
    #[must_use]
    pub fn lambertian(&self) -> Option<Vec3> {
        match self.as_slice() {
            [] => Some(Vec3::ZERO),
            [lobe]
                if lobe.kind == Kind::Diffuse
                    && (lobe.alpha, lobe.eta) == (0.0, 1.0)
                    && lobe.normal == Vec3::ZERO =>
            {
                Some(lobe.a * lobe.weight)
            }
            _ => None,
        }
    }
}
