// SPDX-License-Identifier: GPL-3.0-or-later
//! The things that cover the pixels of a tile, and by how much: sums over samples.
//! Memory: most pixels hold one thing or two. A pixel holds at most twice the requested depth; beyond, the thing that
//! covers least is dropped.
//! Tests: crates/render/tests/mattes.rs.

use super::kinds::Mattes;
use crate::state::SavedState;

/// No pixel holds fewer things at most.
const FEWEST: u32 = 12;

/// A thing's id, and the weight of the samples that it covers.
type Cover = (u32, f32);

/// The mattes of a tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct TileMattes {
    /// By kind, then pixel.
    covers: Vec<Vec<Vec<Cover>>>,
    /// Most things of a pixel.
    slots: usize,
}

impl TileMattes {
    pub(crate) fn new(mattes: &Mattes, pixels: usize) -> Self {
        let slots = (2 * mattes.depth).clamp(FEWEST, 2 * Mattes::DEEPEST) as usize;
        Self { covers: vec![vec![Vec::new(); pixels]; mattes.kinds.len()], slots }
    }

    pub(crate) fn clear(&mut self) {
        self.covers.iter_mut().flatten().for_each(Vec::clear);
    }

    /// Adds a part of a sample.
    pub(crate) fn add(&mut self, kind: usize, pixel: usize, id: u32, weight: f32) {
        let covers = &mut self.covers[kind][pixel];
        if let Some((_, sum)) = covers.iter_mut().find(|(known, _)| *known == id) {
            *sum += weight;
            return;
        }
        if covers.len() == self.slots {
            let least = (0..self.slots).min_by(|&a, &b| covers[a].1.total_cmp(&covers[b].1)).unwrap_or(0);
            if covers[least].1 > weight {
                return;
            }
            covers.swap_remove(least);
        }
        covers.push((id, weight));
    }

    /// The things of a pixel, ranked by coverage.
    pub(crate) fn ranked(&self, kind: usize, pixel: usize) -> Vec<Cover> {
        let mut covers = self.covers[kind][pixel].clone();
        covers.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        covers
    }
}

impl SavedState for TileMattes {
    fn state(&mut self, with: &mut dyn FnMut(&mut u64)) {
        for covers in self.covers.iter_mut().flatten() {
            covers.resize(self.slots, (0, 0.0));
            for (id, weight) in covers.iter_mut() {
                let mut word = u64::from(*id) << 32 | u64::from(weight.to_bits());
                with(&mut word);
                (*id, *weight) = ((word >> 32) as u32, f32::from_bits(word as u32));
            }
            covers.retain(|(_, weight)| *weight > 0.0);
        }
    }
}
