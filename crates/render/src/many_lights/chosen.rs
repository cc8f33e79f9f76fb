// SPDX-License-Identifier: GPL-3.0-or-later
//! Which virtual lights a block of points asks, where there are many: a sample of them, in proportion to what they promise there,
//! times how much of it came through to the blocks of its tile before.
//! Source: [TCE05] (resampling); [GKPS12] (what is learned from neighbours, visibility included, guides the choice). Differs:
//! what is promised is judged anew at points of the block, only visibility is taken over, and from the same pass.
//! Space: world. Points that do not scatter alike to all sides ask by what lights send, as `cut` has it: what their lobes make of it is
//! not known to neighbours.
//! Invariant: a light that may shine on the block is never impossible; what blocks before found guides the choice alone, and
//! numbers of blocks are their own, so the mean does not change, and neighbours do not err alike.
//! Proof: `tests`, crates/render/tests/many_lights.rs.

use std::f32::consts::PI;

use super::cut::{cut_of, resample};
use super::eye::EyePoint;
use super::lanes::Source;

/// Points that stand for a block.
const WITNESSES: usize = 8;
/// Added to cosines: points between witnesses may see more.
const SLACK: f32 = 0.05;
/// What a light is thought to bring through at least, as share of its promise.
const HOPE: f32 = 0.1;

/// How much of what virtual lights promised came through, light by light, in the order of a list in which neighbours are neighbours.
pub(super) struct Learned {
    asked: Vec<f32>,
    came: Vec<f32>,
}

impl Learned {
    /// Nothing, of so many lights.
    pub(super) fn new(lights: usize) -> Self {
        Self { asked: vec![0.0; lights], came: vec![0.0; lights] }
    }

    /// Of `asked` rays of a light, `came` met nothing.
    pub(super) fn note(&mut self, light: usize, asked: u32, came: u32) {
        self.asked[light] += asked as f32;
        self.came[light] += came as f32;
    }

    /// The share that came through, by what is known of the light and of its neighbours in the list.
    fn share(&self, light: usize) -> f32 {
        // As if one ray had come.
        let (mut asked, mut came) = (1.0, 1.0);
        for (near, weight) in [(light.wrapping_sub(1), 0.25), (light, 1.0), (light + 1, 0.25)] {
            if let (Some(&of), Some(&some)) = (self.asked.get(near), self.came.get(near)) {
                (asked, came) = (asked + weight * of, came + weight * some);
            }
        }
        (came / asked).max(HOPE)
    }
}

/// The lights that a block of points asks, `most` at most: their places in the list, and what they count. `u` in [0, 1).
pub(super) fn chosen(
    eyes: &[EyePoint],
    sources: &[Source],
    learned: &Learned,
    most: usize,
    u: f32,
) -> Vec<(usize, f32)> {
    if sources.len() <= most {
        return (0..sources.len()).map(|i| (i, 1.0)).collect();
    }
    if eyes.iter().any(|eye| eye.bsdf.lambertian().is_none()) {
        return cut_of(eyes, sources, most, u);
    }
    let some = Witnesses::new(eyes);
    let weight = |(i, source)| f64::from(some.promise(source) * learned.share(i));
    resample(sources.iter().enumerate().map(weight), most, u)
}

/// Points that stand for a block.
struct Witnesses {
    points: Vec<EyePoint>,
    /// About how far points lie from the nearest of them, squared.
    near2: f32,
}

impl Witnesses {
    fn new(eyes: &[EyePoint]) -> Self {
        let points: Vec<EyePoint> = eyes.iter().step_by(eyes.len().div_ceil(WITNESSES)).copied().collect();
        let far = eyes.iter().map(|eye| eye.point.p.distance_squared(points[0].point.p)).fold(0.0, f32::max);
        Self { points, near2: (far / WITNESSES as f32).max(f32::MIN_POSITIVE) }
    }

    /// About what a light brings them all if nothing is in between; not zero but where both ends look away.
    fn promise(&self, source: &Source) -> f32 {
        let vpl = &source.vpl;
        let most = PI * source.bound;
        let to = |eye: &EyePoint| {
            let way = vpl.point.p - eye.point.p;
            let distance2 = way.length_squared();
            let to = way / distance2.sqrt().max(f32::MIN_POSITIVE);
            let (sees, shines) = (eye.point.ns.dot(to).max(0.0), (-vpl.point.ng.dot(to)).max(0.0));
            ((SLACK + sees) * (SLACK + shines) / (distance2 + self.near2)).min(most)
        };
        vpl.strength() * self.points.iter().map(to).sum::<f32>()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gnurt_shading::SurfacePoint;
    use gnurt_shading::bsdf::Bsdf;

    use super::super::bound::Bound;
    use super::super::test_points;
    use super::super::vpl::Vpl;
    use super::*;

    fn random(n: u32, purpose: u32) -> [f32; 2] {
        test_points::random(11, n, purpose)
    }

    fn surface(n: u32) -> (SurfacePoint, Bsdf) {
        test_points::surface(11, n)
    }

    /// What a part of the lights brings has the mean of what all bring, whatever has been learned, with less noise where the
    /// lights that nobody sees are known.
    #[test]
    fn a_part_stands_for_all() {
        let bound = Bound::on_geometry_term(3.0);
        let light = |n: u32| {
            let (point, bsdf) = surface(n);
            Vpl::new(point, bsdf, point.ng, Vec3::new(3.0, 2.0, 1.0), 1)
        };
        let vpls: Vec<Vpl> = (1000..2200).map(light).collect();
        let sources = super::super::gather::sources(&vpls, &bound);
        let eye = |n: u32| {
            let (mut point, bsdf) = surface(7);
            point.p += Vec3::new(random(n, 3)[0], random(n, 3)[1], 0.0) * 0.05;
            EyePoint { point, wo: point.ng, bsdf, throughput: Vec3::ONE, edges: 1, lane: n }
        };
        let eyes: Vec<EyePoint> = (0..64).map(eye).collect();
        // Lights in one half of the room are hidden.
        let is_hidden = |source: &Source| source.vpl.point.p.x > 0.5;
        let brings = |source: &Source| -> f32 {
            let brought = eyes.iter().filter_map(|eye| source.vpl.brings(eye, &bound, 6)).map(|c| c.x).sum();
            if is_hidden(source) { 0.0 } else { brought }
        };
        let light: Vec<f32> = sources.iter().map(brings).collect();
        let wanted: f32 = light.iter().sum();
        let mut learned = Learned::new(sources.len());
        assert_eq!(
            chosen(&eyes, &sources, &learned, sources.len(), 0.5).len(),
            sources.len(),
            "so few are all asked"
        );
        let most = sources.len() / 4;
        let mut noise = [0.0; 2];
        for noise in &mut noise {
            const TIMES: u32 = 64;
            let mut mean = 0.0;
            for n in 0..TIMES {
                let some = chosen(&eyes, &sources, &learned, most, (n as f32 + 0.5) / TIMES as f32);
                assert!(some.len() <= most, "a part of them: {}", some.len());
                let sum: f32 = some.iter().map(|&(i, weight)| light[i] * weight).sum();
                mean += sum / TIMES as f32;
                *noise += (sum / wanted - 1.0).powi(2) / TIMES as f32;
            }
            assert!((mean / wanted - 1.0).abs() < 0.02, "{mean} instead of {wanted}");
            for (i, source) in sources.iter().enumerate() {
                learned.note(i, 64, if is_hidden(source) { 0 } else { 64 });
            }
        }
        assert!(noise[1] < 0.9 * noise[0], "less noise where it is known what is hidden: {noise:?}");
    }
}
