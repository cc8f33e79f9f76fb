// SPDX-License-Identifier: GPL-3.0-or-later
//! The choice of virtual lights for a block of points: a sample in proportion to their estimated unoccluded
//! contribution, and to the fraction that reached earlier blocks of its tile.
//! Source: [TCE05] (resampling); [GKPS12] (neighbours guide the choice, visibility included). Differs: the
//! unoccluded contribution is computed at all points of the block; only visibility is reused, and only from
//! the same pass.
//! Space: world.
//! Invariant: a light that may reach the block has a nonzero probability. Earlier blocks guide only the
//! choice, and random numbers differ between blocks, so the mean does not change, and errors of neighbours
//! are uncorrelated.
//! Tests: `tests`, crates/render/tests/many_lights.rs.

use super::cut::resample;
use super::lanes::{BLOCK, Lanes};

/// Lights whose luck is thought alike, neighbours in their list.
const CLUSTER: usize = 8;
/// Prior counts: unoccluded rays of a cluster before any query, and rays of a light with the cluster's
/// result.
const OF_CLUSTER: f32 = 16.0;
const OF_LIGHT: f32 = 32.0;
/// The least fraction of its unoccluded contribution that a light is assumed to bring.
const HOPE: f32 = 0.05;

/// The unoccluded fraction of the contribution, light by light, in the order of a list that keeps neighbours
/// adjacent.
pub(super) struct Learned {
    /// Traced rays, and the unoccluded ones.
    lights: Vec<[f32; 2]>,
    clusters: Vec<[f32; 2]>,
}

impl Learned {
    /// Zero counts for this number of lights.
    pub(super) fn new(lights: usize) -> Self {
        Self { lights: vec![[0.0; 2]; lights], clusters: vec![[0.0; 2]; lights.div_ceil(CLUSTER)] }
    }

    /// Of `requests` rays of a light, `came` met nothing.
    pub(super) fn note(&mut self, light: usize, requests: u32, came: u32) {
        for sums in [&mut self.lights[light], &mut self.clusters[light / CLUSTER]] {
            sums[0] += requests as f32;
            sums[1] += came as f32;
        }
    }

    /// The expected unoccluded fraction, from the records of the light and of its cluster.
    fn share(&self, light: usize) -> f32 {
        let ([requests, came], [of_all, came_of_all]) = (self.lights[light], self.clusters[light / CLUSTER]);
        let of_cluster = (came_of_all + OF_CLUSTER) / (of_all + OF_CLUSTER);
        ((came + OF_LIGHT * of_cluster) / (requests + OF_LIGHT)).max(HOPE)
    }
}

/// Unoccluded contributions of lights to the points of a block.
#[derive(Default)]
pub(super) struct Rows {
    /// Lights with a contribution, by their indices in the list, and the contribution to each point.
    rows: Vec<(usize, Lanes)>,
}

impl Rows {
    pub(super) fn clear(&mut self) {
        self.rows.clear();
    }

    pub(super) fn push(&mut self, light: usize, contribution: &Lanes) {
        if contribution.iter().any(|&contribution| contribution > 0.0) {
            self.rows.push((light, *contribution));
        }
    }

    /// The lights for the block, `most` at most, in the order of the list, with their weights. The
    /// probability follows the mean square of their shares of the points' light. `u` in [0, 1).
    pub(super) fn chosen(&self, learned: &Learned, most: usize, u: f32) -> Vec<(usize, f32)> {
        if self.rows.len() <= most {
            return self.rows.iter().map(|(light, _)| (*light, 1.0)).collect();
        }
        let mut total = [0.0; BLOCK];
        for (_, row) in &self.rows {
            (0..BLOCK).for_each(|i| total[i] += row[i]);
        }
        let scale = total.map(|total| if total > 0.0 && total.is_finite() { 1.0 / total } else { 0.0 });
        let weight = |(light, row): &(usize, Lanes)| {
            let square: f32 = (0..BLOCK).map(|i| (row[i] * scale[i]).powi(2)).sum();
            // Light comes through or does not: the mean of the square is as the share.
            f64::from((square * learned.share(*light)).sqrt())
        };
        let chosen = resample(self.rows.iter().map(weight), most, u);
        chosen.into_iter().map(|(row, weight)| (self.rows[row].0, weight)).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gnurt_image::srgb::luminance;
    use gnurt_simd::Level;

    use super::super::bound::Bound;
    use super::super::contribution::each_contribution;
    use super::super::eye::EyePoint;
    use super::super::lanes::{Block, Light};
    use super::super::test_points::{random, surface};
    use super::super::vpl::Vpl;
    use super::*;

    /// A subset of the lights has the mean of all lights, with any record of visibility, and less noise where
    /// invisible lights are known.
    #[test]
    fn a_part_stands_for_all() {
        let bound = Bound::on_geometry_term(3.0);
        let light = |n: u32| {
            let (point, bsdf) = surface(11, n);
            Vpl::new(point, bsdf, point.ng, Vec3::new(3.0, 2.0, 1.0), 1)
        };
        let vpls: Vec<Vpl> = (1000..2200).map(light).collect();
        let sources = super::super::gather::sources(&vpls, &bound);
        let eye = |n: u32| {
            let (mut point, bsdf) = surface(11, 7);
            point.p += Vec3::new(random(11, n, 3)[0], random(11, n, 3)[1], 0.0) * 0.05;
            EyePoint { point, wo: point.ng, bsdf, throughput: Vec3::ONE, edges: 1, lane: n }
        };
        let eyes: Vec<EyePoint> = (0..64).map(eye).collect();
        let eyes: Vec<&EyePoint> = eyes.iter().collect();
        let (mut rows, mut scratch) = (Rows::default(), Box::<Light>::default());
        let block = Block::new(&eyes, 6);
        let requests = (&block, &eyes[..]);
        each_contribution(Level::default(), requests, &sources, (&bound, 6), &mut scratch, |i, row, _| {
            rows.push(i, row)
        });
        // Lights in one half of the space are hidden.
        let is_hidden = |i: usize| sources[i].vpl.point.p.x > 0.5;
        let brings = |i: usize| -> f32 {
            let brought = eyes.iter().filter_map(|eye| sources[i].vpl.brings(eye, &bound, 6));
            if is_hidden(i) { 0.0 } else { brought.map(|color| luminance(color.into())).sum() }
        };
        let light: Vec<f32> = (0..sources.len()).map(brings).collect();
        let requested: f32 = light.iter().sum();
        let mut learned = Learned::new(sources.len());
        let all: f32 =
            rows.chosen(&learned, sources.len(), 0.5).iter().map(|&(i, weight)| light[i] * weight).sum();
        assert!((all / requested - 1.0).abs() < 1e-4, "so few are all asked: {all} instead of {requested}");
        let most = sources.len() / 8;
        let mut noise = [0.0; 2];
        for noise in &mut noise {
            const TIMES: u32 = 64;
            let mut mean = 0.0;
            for n in 0..TIMES {
                let some = rows.chosen(&learned, most, (n as f32 + 0.5) / TIMES as f32);
                assert!(some.len() <= most, "a part of them: {}", some.len());
                let sum: f32 = some.iter().map(|&(i, weight)| light[i] * weight).sum();
                mean += sum / TIMES as f32;
                *noise += (sum / requested - 1.0).powi(2) / TIMES as f32;
            }
            assert!((mean / requested - 1.0).abs() < 0.02, "{mean} instead of {requested}");
            for i in 0..sources.len() {
                learned.note(i, 64, if is_hidden(i) { 0 } else { 64 });
            }
        }
        assert!(noise[1] < 0.9 * noise[0], "less noise where it is known what is hidden: {noise:?}");
    }
}
