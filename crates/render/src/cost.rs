// SPDX-License-Identifier: GPL-3.0-or-later
//! Cost of each pixel of a tile: nodes visited and triangles tested by all its rays.

use gnurt_shading::SampleKey;

use crate::pixel_order::PixelOrder;

/// Costs of the pixels of a rectangle.
#[derive(Clone, Debug)]
pub(crate) struct TileCosts {
    /// Left, upper, right and lower edge; the latter two exclusive.
    rect: [u32; 4],
    /// Keys of the picture.
    order: PixelOrder,
    pub(crate) costs: Vec<u64>,
}

impl TileCosts {
    pub(crate) fn new(rect: [u32; 4], order: PixelOrder) -> Self {
        let [x0, y0, x1, y1] = rect;
        Self { rect, order, costs: vec![0; ((x1 - x0) * (y1 - y0)) as usize] }
    }

    /// Adds the cost of each ray to the pixel of its key.
    pub(crate) fn add(&mut self, keys: &[SampleKey], costs: &[u32]) {
        let [x0, y0, x1, _] = self.rect;
        for (key, &cost) in keys.iter().zip(costs) {
            let [x, y] = self.order.pixel(*key);
            let position = u64::from(y.wrapping_sub(y0)) * u64::from(x1 - x0) + u64::from(x.wrapping_sub(x0));
            if let Some(sum) = self.costs.get_mut(position as usize) {
                *sum += u64::from(cost);
            }
        }
    }
}
