// SPDX-License-Identifier: GPL-3.0-or-later
//! Hair as a rough dielectric cylinder of elliptic section: light that its surface reflects (R), that leaves where it meets
//! the surface again (TT), after a reflection within (TRT), or after further ones. A lobe is one of the four; together they are the model.
//! The way of light within is random, drawn by numbers of the point, and the same for all directions of the light; its last event is a lobe
//! of rough glass. So values and densities have closed forms, and their mean over points is the integral over all ways.
//! Source: \[HHH22\] for the model. Differences:
//! * Ways are drawn once for each point.
//! * Near field: the offset from the middle of the fibre comes from the normal of the hit.
//! * Further reflections, which the model leaves out, are a lobe of their own.
//! * Light that single scattering between microfacets loses is added to the rest, as \[Tur19\] does.
//!
//! Space: x along the fibre to its tip, z the outward normal. The half length of the section's major axis is 1. Values contain the cosine and have
//! no horizon. Invariant: without absorption light leaves again. Tests: `rough_fibre_tests`, beside paths through a cylinder.

use glam::{Vec2, Vec3};

use super::anisotropy::Slopes;
use super::dielectric::refract;
use super::fresnel;
use super::ggx::Ggx;
use super::rough_dielectric::{Glass, Plain, PreparedGlass, mirrored_and_lost};
use crate::real::Vector;
use crate::sampling::frame_around;

/// Light is followed through so many reflections within.
const MOST_REFLECTIONS: u32 = 64;
/// The largest probability of a further one.
const MOST_LIKELY: f32 = 0.95;

/// One of the terms of a fibre.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoughFibre {
    /// 0: R; 1: TT; 2: TRT; 3: further reflections.
    pub(super) term: usize,
    /// Absorption within the fibre, for a half axis of 1.
    pub(super) absorption: Vec3,
    /// Width of the microfacets' slopes.
    pub(super) alpha: f32,
    /// Index of refraction over that around it.
    pub(super) index: f32,
    /// Angle of the scales: their normals lean to the tip.
    pub(super) tilt: f32,
    /// Minor axis of the section over its major axis.
    pub(super) aspect: f32,
    /// Direction of the major axis by y and z; zero: across the view.
    pub(super) major: Vec2,
    /// Number that draws the way of light.
    pub(super) random: f32,
}

/// The last event of light on its way to the view, as rough glass seen from within or from outside.
struct Last {
    /// Axes of the fibre around x: the major and the minor one of its section.
    axes: [Vec2; 2],
    /// Axes with z = the normal, on the side that the view is on.
    frame: [Vec3; 3],
    /// The view in that frame.
    view: Vec3,
    glass: Glass<f32>,
    prepared: PreparedGlass<f32>,
    /// Light that the event gets, and the share of it that goes on as the term has it.
    weight: Vec3,
    share: f32,
    /// Share that a single scattering between microfacets keeps.
    retained: f32,
}

/// Random numbers of one point.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        // A step of a linear congruential generator, and PCG's permutation of the state.
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = (self.0 >> ((self.0 >> 28) + 4) ^ self.0).wrapping_mul(277_803_737);
        ((word >> 22 ^ word) >> 8) as f32 * (1.0 / 16_777_216.0)
    }
}

/// Axes of a frame with z = the unit `n`.
fn frame(n: Vec3) -> [Vec3; 3] {
    let [x, y] = frame_around::<f32>(n.into());
    [x.into(), y.into(), n]
}

fn into_frame([x, y, z]: [Vec3; 3], w: Vec3) -> Vec3 {
    Vec3::new(x.dot(w), y.dot(w), z.dot(w))
}

fn out_of_frame([x, y, z]: [Vec3; 3], w: Vec3) -> Vec3 {
    x * w.x + y * w.y + z * w.z
}

impl RoughFibre {
    fn ggx(&self) -> Ggx<f32> {
        Ggx::from_alpha(self.alpha)
    }

    /// Share of light at the cosine `cos` that microfacets mirror, over the share that one bounce keeps; and that share.
    fn shares(&self, cos: f32, eta: f32) -> (f32, f32) {
        let [mirrored, lost] = mirrored_and_lost(self.ggx().alpha(), eta, cos.clamp(0.0, 1.0));
        let retained = (1.0 - lost).max(1e-3);
        ((mirrored / retained).clamp(0.0, 1.0), retained)
    }

    /// The normal of scales at a point of the section, in the axes of the fibre.
    fn normal(&self, at: Vec2) -> Vec3 {
        let across = Vec2::new(at.x, at.y / (self.aspect * self.aspect)).normalize_or(Vec2::Y);
        let (sin, cos) = self.tilt.sin_cos();
        Vec3::new(sin, cos * across.x, cos * across.y)
    }

    /// Axes of the section, and the point that is seen from `wo`.
    fn entry(&self, wo: Vec3) -> ([Vec2; 2], Vec2) {
        let view = Vec2::new(wo.y, wo.z).normalize_or(Vec2::Y);
        let side = Vec2::new(view.y, -view.x);
        // The hit's normal is z: it shows how far from the middle the view is.
        let offset = side.y.clamp(-1.0, 1.0);
        let major = if self.major == Vec2::ZERO { side } else { self.major };
        let axes = [major, Vec2::new(-major.y, major.x)];
        let of = |w: Vec2| Vec2::new(w.dot(axes[0]), w.dot(axes[1]));
        let (side, view) = (of(side), of(view));
        // On the circle that the section is stretched to.
        let side = Vec2::new(side.x, side.y * self.aspect).normalize_or(Vec2::X);
        let view = Vec2::new(view.x, view.y / self.aspect).normalize_or(Vec2::Y);
        let at = side * offset + view * (1.0 - offset * offset).max(0.0).sqrt();
        (axes, Vec2::new(at.x, at.y * self.aspect))
    }

    /// Where light in a direction meets the surface again, and how far that is.
    fn chord(&self, at: Vec2, way: Vec3) -> Option<(Vec2, f32)> {
        let way = Vec2::new(way.y, way.z);
        let b2 = self.aspect * self.aspect;
        let far = way.x * way.x + way.y * way.y / b2;
        let length = -2.0 * (at.x * way.x + at.y * way.y / b2) / far;
        (length > 0.0 && length.is_finite()).then(|| (at + way * length, length))
    }

    /// One microfacet: where light that comes from `w` above `n` goes on, mirrored or through, and its weight.
    fn step(&self, n: Vec3, w: Vec3, eta: f32, mirrored: bool, random: &mut Numbers) -> Option<(Vec3, f32)> {
        let frame = frame(n);
        let w = into_frame(frame, w);
        if w.z <= 0.0 {
            return None;
        }
        let slopes = Slopes { ggx: self.ggx(), anisotropy: None };
        let h: Vec3 = slopes.sample_visible(w.into(), [random.next(), random.next()]).into();
        let cos = w.dot(h);
        let reflected = fresnel::dielectric(cos, eta);
        let (to, share) = if mirrored {
            (h * (2.0 * cos) - w, reflected)
        } else {
            let (to, some) = refract::<f32>(w.into(), h.into(), eta);
            (Vec3::from(to).normalize_or_zero(), if some { 1.0 - reflected } else { 0.0 })
        };
        let cos_to = if mirrored { to.z } else { -to.z };
        let (_, retained) = self.shares(w.z, eta);
        let weight = share * self.ggx().sample_weight(w.z, cos_to) / retained;
        (cos_to > 0.0 && weight > 0.0).then(|| (out_of_frame(frame, to), weight))
    }

    /// The event by which light leaves towards the view, or comes to it.
    fn last(&self, axes: [Vec2; 2], n: Vec3, view: Vec3, within: bool, weight: Vec3) -> Option<Last> {
        let frame = frame(n);
        let view = into_frame(frame, view);
        if view.z <= 1e-4 {
            return None;
        }
        let reflects = self.term == 0;
        let eta = if within { self.index } else { 1.0 / self.index };
        let tint = |is: bool| Vector::grey(if is { 1.0 } else { 0.0 });
        let glass = Glass {
            slopes: Slopes { ggx: self.ggx(), anisotropy: None },
            eta,
            film: None,
            rise: Plain,
            tints: [tint(reflects), tint(!reflects)],
            losses: Vector::grey(0.0),
            thin: false,
        };
        let (mirrored, retained) = self.shares(view.z, eta);
        let prepared = PreparedGlass { hidden: glass.slopes.lambda(view.into(), view.z), lost: 0.0 };
        let share = if reflects { mirrored } else { 1.0 - mirrored };
        Some(Last { axes, frame, view, glass, prepared, weight, share, retained })
    }

    /// Follows the view through the fibre, to the event before which light comes from outside.
    fn follow(&self, wo: Vec3) -> Option<Last> {
        let (axes, mut at) = self.entry(wo);
        let wo = Vec3::new(wo.x, wo.y * axes[0].x + wo.z * axes[0].y, wo.y * axes[1].x + wo.z * axes[1].y);
        let n = self.normal(at);
        if self.term == 0 {
            // Width is that of the section: scales that lean to the view or from it show more or less of themselves.
            let level = Vec3::new(0.0, at.x, at.y / (self.aspect * self.aspect)).normalize_or_zero();
            let shown = self.tilt.cos() + self.tilt.sin() * wo.x / level.dot(wo).max(1e-4);
            return self.last(axes, n, wo, false, Vec3::splat(shown.clamp(0.0, 2.0)));
        }
        let mut random = Numbers(self.random.to_bits() ^ (self.term as u32) << 30);
        random.next();
        let (mut way, share) = self.step(n, wo, 1.0 / self.index, false, &mut random)?;
        let mut weight = Vec3::splat(share);
        for reflections in 0..MOST_REFLECTIONS {
            let (next, length) = self.chord(at, way)?;
            at = next;
            weight *= (-self.absorption * length).exp();
            let n = -self.normal(at);
            if self.term as u32 == reflections + 1 && self.term < 3 {
                return self.last(axes, n, -way, true, weight);
            }
            if reflections >= 2 {
                // Light leaves here, or goes on.
                let on = self.shares(n.dot(-way), self.index).0.min(MOST_LIKELY);
                if random.next() >= on {
                    return self.last(axes, n, -way, true, weight / (1.0 - on));
                }
                weight /= on;
            }
            let (to, share) = self.step(n, -way, self.index, true, &mut random)?;
            way = to;
            weight *= share;
        }
        None
    }

    /// Share of light that is scattered.
    pub(super) fn albedo(&self, wo: Vec3) -> Vec3 {
        self.follow(wo).map_or(Vec3::ZERO, |last| last.weight * last.share)
    }

    /// Value and density of the unit `wi`.
    pub(super) fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let Some(last) = self.follow(wo) else { return (Vec3::ZERO, 0.0) };
        let [major, minor] = last.axes;
        let across = Vec2::new(wi.y, wi.z);
        let wi = into_frame(last.frame, Vec3::new(wi.x, across.dot(major), across.dot(minor)));
        let cosines = [last.view.z, wi.z];
        let (value, pdf) =
            last.glass.eval_pdf(last.prepared, Vec3::Z.into(), [last.view.into(), wi.into()], cosines);
        (last.weight / last.retained * Vec3::from(value), pdf)
    }

    /// A unit direction; zero where there is none.
    pub(super) fn sample(&self, wo: Vec3, u: [f32; 3]) -> Vec3 {
        let Some(last) = self.follow(wo) else { return Vec3::ZERO };
        let (wi, some) = last.glass.sample(last.prepared, last.view.into(), u, Vec3::Z.into());
        if !some {
            return Vec3::ZERO;
        }
        let wi = out_of_frame(last.frame, wi.into());
        let across = last.axes[0] * wi.y + last.axes[1] * wi.z;
        Vec3::new(wi.x, across.x, across.y)
    }
}
