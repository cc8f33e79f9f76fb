// SPDX-License-Identifier: GPL-3.0-or-later
//! Media between surfaces: fog, smoke, milk, wax. Plain data.
//! Source: \[PJH23\] chapter 11; KHR_materials_volume_scatter. Units: 1 over world units, radiance.
//! Conventions: coefficients are those at density 1; a grid's density is multiplied to them.
//! Tests: `tests`, crates/render/tests/media.rs.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::affine::Affine;

/// A medium that absorbs, scatters or gives off light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Medium {
    /// A label; need not be unique.
    pub name: String,
    /// Absorption coefficient by colour, 1 over world units.
    pub absorption: [f32; 3],
    /// Scattering coefficient by colour, 1 over world units.
    pub scattering: [f32; 3],
    /// Radiance that it gives off, as a black body of this colour would: what leaves a stretch is this times its absorption.
    pub emission: [f32; 3],
    /// Directions of scattered light.
    pub phase: Phase,
    /// Where it is.
    pub extent: Extent,
    /// Density in space; `None` = 1 everywhere.
    pub grid: Option<Arc<DensityGrid>>,
    /// Where bodies overlap, the medium with the highest priority is there; of equal ones, the one that was entered last.
    pub priority: i32,
    /// In bodies: it is there in addition to other media, whatever their priority; it replaces none.
    pub adds: bool,
}

/// Where a medium is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Extent {
    /// Inside the closed surfaces whose materials name it. Their normals point out.
    #[default]
    Bodies,
    /// Everywhere but in bodies with a medium of their own, in a ball. Of several, the last one counts.
    Around {
        /// Centre, world.
        centre: [f32; 3],
        /// World units; may be infinite. Nothing is seen through infinitely much of a medium.
        radius: f32,
    },
    /// In the box of its grid, in addition to all that is there.
    Free,
}

/// A phase function: two lobes of Henyey and Greenstein.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// Mean cosine of the first lobe, in (-1, 1): above 0 = forward.
    pub anisotropy: f32,
    /// The same of the second lobe.
    pub second_anisotropy: f32,
    /// Share of the second lobe, in `[0, 1]`.
    pub second_share: f32,
}

/// Numbers in space, in the cells of a box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DensityGrid {
    /// Columns, rows and layers.
    pub size: [u32; 3],
    /// Density at the centres of the cells, x first, then y, then z; interpolated linearly.
    pub density: Vec<f32>,
    /// Multiplied to the emission, cell by cell; empty = 1.
    pub emission: Vec<[f32; 3]>,
    /// From the unit cube, which the cells fill, to the world.
    pub world_from_unit: Affine,
}

impl Default for Medium {
    /// Nothing.
    fn default() -> Self {
        Self {
            name: String::new(),
            absorption: [0.0; 3],
            scattering: [0.0; 3],
            emission: [0.0; 3],
            phase: Phase::default(),
            extent: Extent::default(),
            grid: None,
            priority: 0,
            adds: false,
        }
    }
}

impl Medium {
    /// A problem that would make light meaningless; `None` = sound.
    #[must_use]
    pub fn problem(&self) -> Option<&'static str> {
        let all = [self.absorption, self.scattering, self.emission];
        if !all.iter().flatten().all(|x| x.is_finite() && *x >= 0.0) {
            return Some("coefficients and emission must be finite and not below 0");
        }
        let Phase { anisotropy, second_anisotropy, second_share } = self.phase;
        if !(anisotropy.abs() < 1.0 && second_anisotropy.abs() < 1.0 && (0.0..=1.0).contains(&second_share)) {
            return Some("anisotropies must be above -1 and below 1, the share of the second lobe in [0, 1]");
        }
        match (&self.grid, self.extent) {
            (None, Extent::Free) => Some("a free medium needs a grid"),
            (Some(grid), _) => grid.problem(),
            _ => None,
        }
    }
}

impl DensityGrid {
    fn problem(&self) -> Option<&'static str> {
        let cells = self.size.iter().try_fold(1_usize, |cells, &n| cells.checked_mul(n as usize));
        if cells.is_none_or(|cells| cells == 0 || cells != self.density.len()) {
            return Some("a grid needs one density for each cell");
        }
        if !self.emission.is_empty() && self.emission.len() != self.density.len() {
            return Some("a grid needs one emission for each cell, or none");
        }
        let is_sound = |x: &f32| x.is_finite() && *x >= 0.0;
        if !self.density.iter().chain(self.emission.iter().flatten()).all(is_sound) {
            return Some("densities and emission must be finite and not below 0");
        }
        self.world_from_unit.inverse().is_none().then_some("the transform of a grid must have an inverse")
    }
}

/// The albedo of one scattering event whose many make a thick body of the colour `color` without a surface.
/// Source: \[KC17\], the inverse of a fit to isotropic scattering; with anisotropy by similarity.
#[must_use]
pub fn single_albedo(color: f32, anisotropy: f32) -> f32 {
    let color = color.clamp(0.0, 1.0);
    let s = 4.097_12 + 4.208_63 * color - (9.592_17 + 41.680_8 * color + 17.712_6 * color * color).sqrt();
    let s2 = s * s;
    ((1.0 - s2) / (1.0 - anisotropy * s2)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn albedo_goes_from_black_to_white() {
        assert!(single_albedo(0.0, 0.0).abs() < 1e-2 && single_albedo(1.0, 0.0) > 0.999_9);
        let mut before = 0.0;
        for k in 1..=20 {
            let albedo = single_albedo(k as f32 / 20.0, 0.3);
            assert!(albedo > before, "more colour, more scattering");
            before = albedo;
        }
    }

    #[test]
    fn nonsense_is_named() {
        assert_eq!(Medium::default().problem(), None);
        let free = Medium { extent: Extent::Free, ..Medium::default() };
        assert!(free.problem().is_some_and(|problem| problem.contains("grid")));
        let bright = Medium { scattering: [f32::NAN; 3], ..Medium::default() };
        assert!(bright.problem().is_some_and(|problem| problem.contains("finite")));
        let phase = Phase { anisotropy: 1.0, ..Phase::default() };
        assert!(Medium { phase, ..Medium::default() }.problem().is_some());
        let grid = |density: Vec<f32>| {
            let world_from_unit = Affine::IDENTITY;
            let grid = DensityGrid { size: [2, 1, 1], density, emission: vec![], world_from_unit };
            Medium { grid: Some(Arc::new(grid)), ..Medium::default() }.problem()
        };
        assert_eq!(grid(vec![0.0, 2.0]), None);
        assert!(grid(vec![0.0]).is_some() && grid(vec![-1.0, 0.0]).is_some());
    }
}
