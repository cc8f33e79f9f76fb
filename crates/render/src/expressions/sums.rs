// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of light of a tile: sums over samples per pixel, in double precision.
//! Invariant: a sample that is no number counts as black in all layers, as in the picture.
//! Tests: crates/render/tests/{light_layers,checkpoint}.rs.

use std::ops::Range;

use gnurt_shading::Vec3s;

use crate::state::{SavedState, put_f64};

/// By layer, then pixel.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightSums(Vec<Vec<[f64; 3]>>);

impl LightSums {
    pub(crate) fn new(layers: usize, pixels: usize) -> Self {
        Self(vec![vec![[0.0; 3]; pixels]; layers])
    }

    pub(crate) fn clear(&mut self) {
        self.0.iter_mut().for_each(|sums| sums.fill([0.0; 3]));
    }

    /// Adds one sample, that of `lanes`, to each pixel; `radiance` is that of the picture.
    pub(crate) fn add(&mut self, layers: &[Vec3s], radiance: &Vec3s, lanes: Range<usize>) {
        for (sums, layer) in self.0.iter_mut().zip(layers) {
            for (sum, lane) in sums.iter_mut().zip(lanes.clone()) {
                if radiance.get(lane).is_finite() {
                    let light = layer.get(lane);
                    (0..3).for_each(|k| sum[k] += f64::from(light[k]));
                }
            }
        }
    }

    /// The sum of a pixel.
    pub(crate) fn get(&self, layer: usize, pixel: usize) -> [f64; 3] {
        self.0.get(layer).map_or([0.0; 3], |sums| sums[pixel])
    }
}

impl SavedState for LightSums {
    fn state(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let sums = self.0.iter_mut().flat_map(|sums| sums.as_flattened_mut());
        sums.for_each(|x| put_f64(x, with));
    }
}
