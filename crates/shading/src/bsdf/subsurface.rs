// SPDX-License-Identifier: GPL-3.0-or-later
//! The entry of paths below the surface, where lobes have mean free paths.
//! Lobes of light below the surface are Lambert's reflectors for integrators that do not follow light there. A path tracer
//! takes them out of a batch before it scatters paths: a point's path enters with the probability of its lobe, and other
//! lobes get the rest. Source: \[CKB16\] (walks), \[KC17\] (albedos of walks).
//! Space: world. Tests: `tests` here, crates/render/tests/subsurface.rs.

use glam::Vec3;

use super::batch::ClosureBatch;
use super::lobe::Lobe;
use super::prepared::Prepared;
use crate::lanes::LANES;

/// A path that goes below the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Unit shading normal, on the side that the path comes from.
    pub normal: Vec3,
    /// Factor of its light, over the probability of the entry.
    pub weight: Vec3,
    /// Colour of a thick body; 0 in channels that do not enter.
    pub albedo: Vec3,
    /// Mean free path, world units; above 0.
    pub radius: Vec3,
    /// Mean cosine of scattering.
    pub anisotropy: f32,
    /// Index of refraction by which it is bent; 1 = it enters to all sides alike.
    pub ior: f32,
}

impl ClosureBatch {
    /// Whether some point may have light below its surface.
    #[must_use]
    pub fn has_subsurface(&self) -> bool {
        let blocks = &self.blocks[..self.len().div_ceil(LANES)];
        blocks.iter().any(|block| block.lobes[..block.count as usize].iter().any(|rows| rows.any_subsurface))
    }

    /// Takes the lobes below the surface out of point `i`, seen from the unit `wo`, and decides by `u` in [0, 1) whether its
    /// path enters through one of them. Returns the entry, and the factor of paths that its other lobes scatter. Colours
    /// whose mean free path is not above `shortest`, world units, stay at the surface.
    pub fn enter(&mut self, i: usize, wo: Vec3, u: f32, shortest: f32) -> (Option<Entry>, f32) {
        let (block, lane) = (&mut self.blocks[i / LANES], i % LANES);
        let count = block.count as usize;
        let rows = &mut block.lobes[..count];
        if !rows.iter().any(|rows| rows.any_subsurface && rows.get(lane).is_subsurface()) {
            return (None, 1.0);
        }
        let [x, y, z] = &block.normal;
        let normal = Vec3::new(x.0[lane], y.0[lane], z.0[lane]);
        let lobes: Vec<Lobe> = rows.iter().map(|rows| rows.get(lane)).collect();
        let prepared = Prepared::of_point(&lobes, normal, wo, Vec3::ONE);
        let (mut entry, mut total) = (None, 0.0);
        for (k, (lobe, from)) in lobes.iter().zip(prepared.lobes()).enumerate() {
            let goes = |c: usize| lobe.b[c] > shortest;
            if !lobe.is_subsurface() || !(0..3).any(goes) {
                continue;
            }
            let below = Vec3::from([0, 1, 2].map(|c| f32::from(u8::from(goes(c)))));
            // As the sampler chooses lobes: by the light that they scatter.
            let all = lobe.a.max_element();
            let share = if all > 0.0 { (lobe.a * below).max_element() / all } else { 0.0 };
            let chance = from.probability * share;
            let is_chosen = chance > 0.0 && (total..total + chance).contains(&u);
            total += chance;
            if is_chosen {
                let weight = prepared.reaching(k, lobe.weight) * below / chance;
                let normal = if lobe.normal == Vec3::ZERO { normal } else { lobe.normal };
                let (albedo, radius) = (lobe.a * below, lobe.b.max(Vec3::splat(f32::MIN_POSITIVE)));
                entry = Some(Entry { normal, weight, albedo, radius, anisotropy: lobe.c.x, ior: lobe.c.y });
            }
            // Other colours are scattered here.
            rows[k].set(lane, &Lobe { a: lobe.a * (Vec3::ONE - below), ..*lobe });
        }
        let rest = (1.0 - total).max(0.0);
        let factor = if entry.is_some() || rest <= 1e-6 { 0.0 } else { 1.0 / rest };
        (entry, factor)
    }

    /// The normal of the first lobe of point `i` with light below the surface, or else the point's: unit, on the side of
    /// its ray.
    #[must_use]
    pub fn leaving_normal(&self, i: usize) -> Vec3 {
        let (block, lane) = (&self.blocks[i / LANES], i % LANES);
        let mut lobes = block.lobes[..block.count as usize].iter().map(|rows| rows.get(lane));
        let own =
            lobes.find(Lobe::is_subsurface).map(|lobe| lobe.normal).filter(|&normal| normal != Vec3::ZERO);
        let [x, y, z] = &block.normal;
        own.unwrap_or(Vec3::new(x.0[lane], y.0[lane], z.0[lane]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Lobes;

    fn batch(lobes: &Lobes) -> ClosureBatch {
        let mut batch = ClosureBatch::default();
        batch.reset(3);
        batch.set(1, Vec3::Z, lobes.as_slice());
        batch
    }

    fn skin() -> Lobe {
        Lobe::subsurface(Vec3::new(0.8, 0.4, 0.2), Vec3::new(1.0, 0.5, 0.0), 0.3, 1.0)
    }

    #[test]
    fn other_integrators_see_a_lambertian_body() {
        let lobe = skin();
        let [o, i] = [Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.28, 0.96)];
        let of = |lobe: Lobe| super::super::Bsdf::new(Vec3::Z, lobe).eval_pdf(o, i);
        assert_eq!(of(lobe), of(Lobe::lambert(lobe.a)));
    }

    #[test]
    fn entries_have_the_probability_and_the_light_of_their_lobe() {
        let coat = Lobe::coat(0.04);
        let both = Lobes::from(coat).over(skin());
        assert!(batch(&both).has_subsurface() && !batch(&Lobes::from(coat)).has_subsurface());
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let (mut light, mut others, n) = (Vec3::ZERO, 0.0, 10_000);
        for k in 0..n {
            let mut batch = batch(&both);
            let (entry, factor) = batch.enter(1, wo, (k as f32 + 0.5) / n as f32, 0.0);
            others += factor / n as f32;
            assert!(entry.is_none() || factor == 0.0, "one way or the other");
            light += entry.map_or(Vec3::ZERO, |entry| entry.weight * entry.albedo) / n as f32;
            let left = batch.point(1).bsdf;
            assert!(left.lobes().as_slice()[1].a.z == 0.2, "blue has no mean free path, and stays");
            assert!(!batch.has_subsurface() || left.lobes().as_slice()[1].a.x == 0.0);
        }
        assert!((others - 1.0).abs() < 1e-3, "paths of other lobes are as many as without: {others}");
        let expected = super::super::Bsdf::new(Vec3::Z, both).albedo(wo)
            - super::super::Bsdf::new(Vec3::Z, Lobes::from(coat)).albedo(wo);
        let difference = (light - expected * Vec3::new(1.0, 1.0, 0.0)).abs().max_element();
        assert!(difference < 1e-3, "{light} of {expected}");
    }

    #[test]
    fn a_body_alone_always_enters() {
        let mut batch = batch(&Lobes::from(Lobe { b: Vec3::ONE, ..skin() }));
        let (entry, factor) = batch.enter(1, Vec3::Z, 0.999, 0.0);
        assert!(entry.is_some_and(|entry| entry.weight == Vec3::ONE && entry.ior == 1.0));
        assert_eq!(factor, 0.0);
        assert_eq!(batch.enter(1, Vec3::Z, 0.5, 0.0).0, None, "its light is taken out");
        assert_eq!(batch.enter(0, Vec3::Z, 0.5, 0.0), (None, 1.0), "no light below");
    }
}
