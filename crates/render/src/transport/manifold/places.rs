// SPDX-License-Identifier: GPL-3.0-or-later
//! Where searches are worth their rays: the light that those of a pilot found, by parts of space.
//! Far from caustics a search is a waste, so that few are made there, which count more.
//! Source: as [`SpaceTree`]; the chance is that of Russian roulette by expected light. Space: world.
//! Invariant: chances change noise, not the mean. Tests: `tests`, crates/render/tests/caustics.rs.

use glam::Vec3;

use crate::space_tree::{SpaceTree, class_of};

/// Searches of a cell, at most.
const MOST: usize = 64;
/// The least chance of a search: the pilot may have missed a caustic.
const LEAST: f32 = 1.0 / 32.0;

/// A search of a pilot: where it was made, and the light that it found for a path of throughput 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Searched {
    pub(crate) p: Vec3,
    pub(crate) class: u8,
    pub(crate) light: f32,
    /// The variance of its pixel that it spares, over that by scattered rays alone; infinite if these find nothing.
    pub(crate) spared: f32,
}

/// The chances of searches, place by place.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    tree: SpaceTree,
    /// By cell: the root mean square of light over the brightness of the picture.
    worth: Vec<f32>,
}

impl Places {
    /// Of the searches of a pilot whose picture has this mean.
    pub(crate) fn new(searches: &[Searched], brightness: f32) -> Self {
        let points: Vec<_> = searches.iter().map(|search| (search.p, search.class)).collect();
        let (tree, cells) = SpaceTree::build(&points, MOST);
        let worth = |numbers: &Vec<u32>| {
            let squares = numbers.iter().map(|&i| f64::from(searches[i as usize].light).powi(2));
            let mean = squares.sum::<f64>() / numbers.len().max(1) as f64;
            (mean.sqrt() / f64::from(brightness).max(f64::MIN_POSITIVE)) as f32
        };
        let worth = cells.iter().map(worth).collect();
        Self { tree, worth }
    }

    /// The chance of a search at a point of a path with this throughput.
    pub(super) fn chance(&self, (p, ng): (Vec3, Vec3), throughput: Vec3) -> f32 {
        let cell = self.tree.cell(p, class_of(ng));
        let worth = cell.map_or(0.0, |cell| self.worth[cell as usize]);
        (worth * throughput.max_element()).clamp(LEAST, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn searched(x: f32, y: f32, light: f32) -> Searched {
        Searched { p: Vec3::new(x, y, 0.0), class: class_of(Vec3::Z), light, spared: 0.0 }
    }

    #[test]
    fn searches_are_made_where_some_found_light() {
        // On a floor, of which a corner has a caustic that every other search finds.
        let at = |i: u32| ((i % 64) as f32, (i / 64) as f32);
        let all: Vec<Searched> = (0..4096)
            .map(|i| {
                let (x, y) = at(i);
                let light = if x < 8.0 && y < 8.0 && i % 2 == 0 { 0.5 } else { 0.0 };
                searched(x, y, light)
            })
            .collect();
        let places = Places::new(&all, 1.0);
        let chance = |x, y, normal: Vec3, throughput| {
            let p = Vec3::new(x, y, 0.0);
            places.chance((p, normal), throughput)
        };
        let expected = 0.5 * 0.5_f32.sqrt();
        assert!((chance(3.0, 3.0, Vec3::Z, Vec3::ONE) - expected).abs() < 1e-6, "its root mean square");
        assert!((chance(3.0, 3.0, Vec3::Z, Vec3::splat(0.5)) - 0.5 * expected).abs() < 1e-6, "what is left");
        assert_eq!(chance(3.0, 3.0, Vec3::Z, Vec3::splat(40.0)), 1.0, "no more than one");
        assert_eq!(chance(40.0, 3.0, Vec3::Z, Vec3::ONE), LEAST, "where there was none");
        assert_eq!(chance(3.0, 3.0, Vec3::X, Vec3::ONE), LEAST, "surfaces that were not seen");
        assert_eq!(Places::new(&[], 1.0).worth.len(), 0, "no searches at all");
        let black = Places::new(&all, 0.0);
        assert!(black.worth.iter().all(|worth| !worth.is_nan()), "black pictures");
    }
}
