// SPDX-License-Identifier: GPL-3.0-or-later
//! Rare lobes of many points: evaluated point by point by `scalar_lobes.rs`, in the frames of their slopes.
//! Space: world. Tests: `tests` of `bsdf`.

use glam::Vec3;

use super::fibres;
use super::lobe::Kind;
use super::prepared_lobe::PreparedLobe;
use super::scalar_lobes::{ScalarLobe, View};
use crate::real::{Real, Vector};
use crate::sampling::frame_around;

impl<R: Real> PreparedLobe<R> {
    /// Points whose lobe is evaluated per point.
    #[inline(always)]
    pub(super) fn is_scalar(&self) -> R::Mask {
        let is = self.is(Kind::Phong) | self.is(Kind::Ward);
        is | self.is(Kind::Beckmann)
            | self.is(Kind::SchlickGlass)
            | self.is(Kind::Fibres)
            | self.is(Kind::Hair)
            | self.is(Kind::Toon)
            | self.is(Kind::GlossyToon)
            | self.is(Kind::Strand)
            | self.is(Kind::RoughFibre)
    }

    /// That of point `i`, seen from `wo` in the frame of its slopes.
    pub(super) fn scalar(&self, i: usize, wo: Vec3) -> ScalarLobe {
        let (along, across) = (self.alpha.lane(i), self.rarities.across.lane(i));
        let [share, ior, thickness] = self.rarities.film;
        ScalarLobe {
            kind: Kind::ALL.get(self.kind.lane(i) as usize).copied().unwrap_or_default(),
            wo,
            a: self.a.get(i),
            b: self.b.get(i),
            c: self.c.get(i),
            widths: [along, if across > 0.0 { across } else { along }],
            eta: self.eta.lane(i),
            spread: self.rarities.spread.lane(i),
            film: [share.lane(i), ior.lane(i), thickness.lane(i)],
        }
    }

    /// The axes of the slopes.
    pub(super) fn axes(&self) -> [Vector<R>; 2] {
        let [x, y] = frame_around(self.normal);
        let is = self.rarities.across.above_all(0.0);
        let along = Vector::pick(is, self.rarities.tangent, x);
        [along, Vector::pick(is, self.normal.cross(along), y)]
    }

    /// Albedos, [`hidden`](Self::hidden) and [`lost`](Self::lost) of points in a mask.
    #[inline(always)]
    pub(super) fn prepare_scalar(&self, is: R::Mask) -> (Vector<R>, R, R) {
        let [x, y] = self.axes();
        let wo = Vector::new(x.dot(self.wo), y.dot(self.wo), self.cos);
        let [r, g, b, hidden, lost] = self.cos.each_where(
            is,
            #[inline(always)]
            |i| {
                let View { albedo, hidden, lost } = self.scalar(i, wo.get(i)).prepare();
                [albedo.x, albedo.y, albedo.z, hidden, lost]
            },
        );
        (Vector::new(r, g, b), hidden, lost)
    }

    /// Values times the cosine and densities of points in a mask for `wi` at the cosine `cos`.
    #[inline(always)]
    pub(super) fn eval_pdf_scalar(&self, is: R::Mask, wi: Vector<R>, cos: R) -> (Vector<R>, R) {
        cos.outline(
            #[inline(always)]
            || {
                let [x, y] = self.axes();
                let wo = Vector::new(x.dot(self.wo), y.dot(self.wo), self.cos);
                let wi = Vector::new(x.dot(wi), y.dot(wi), cos);
                let [r, g, b, density] = cos.each_where(
                    is,
                    #[inline(always)]
                    |i| {
                        let (hidden, lost) = (self.hidden.lane(i), self.lost.lane(i));
                        let (light, density) = self.scalar(i, wo.get(i)).eval_pdf(hidden, lost, wi.get(i));
                        light.extend(density).into()
                    },
                );
                (Vector::new(r, g, b), density)
            },
        )
    }

    /// Light that fibres at points in a mask reflect towards the prepared direction from `wi`, at the cosine
    /// `cos`, in the opposite order of directions: their values are not reciprocal. Times the cosine `cos`,
    /// as other values are.
    #[inline(always)]
    pub(super) fn fibres_from(&self, is: R::Mask, wi: Vector<R>, cos: R) -> R {
        let [x, y] = self.axes();
        let wo = Vector::new(x.dot(self.wo), y.dot(self.wo), self.cos);
        let wi = Vector::new(x.dot(wi), y.dot(wi), cos);
        let [back] = cos.each_where(
            is,
            #[inline(always)]
            |i| {
                let (wo, wi) = (wo.get(i), wi.get(i));
                [fibres::eval_pdf(self.alpha.lane(i), wi, wo).0 * wi.z / wo.z]
            },
        );
        back
    }

    /// Where lobes of points in a mask send light that comes from `wo`, in the frame of that; zero where they send none.
    #[inline(always)]
    pub(super) fn sample_scalar(
        &self,
        is: R::Mask,
        wo: Vector<R>,
        u: [R; 3],
        cosine: Vector<R>,
    ) -> Vector<R> {
        wo.x.outline(
            #[inline(always)]
            || {
                Vector::grey(wo.x.all(0.0)).each_colour(
                    is,
                    #[inline(always)]
                    |i, _| {
                        let (hidden, lost) = (self.hidden.lane(i), self.lost.lane(i));
                        let u = [u[0].lane(i), u[1].lane(i), u[2].lane(i)];
                        self.scalar(i, wo.get(i)).sample(hidden, lost, u, cosine.get(i))
                    },
                )
            },
        )
    }
}
