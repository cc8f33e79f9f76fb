// SPDX-License-Identifier: GPL-3.0-or-later
//! A grid of densities as rays meet it: lookup, and upper bounds block by block.
//! Source: [SKTM11] (local majorants, and steps through a coarse grid). Space: the unit cube that the cells
//! fill; a ray keeps its parameter, because the map from the world is affine.
//! Invariant: no density within a block is above its bound. Tests: `tests`.

use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec3};
use gnurt_scene::medium::DensityGrid;

/// Cells along the edge of a block.
const BLOCK: u32 = 8;

/// Densities and their bounds.
pub(crate) struct Grid {
    data: Arc<DensityGrid>,
    unit_from_world: Affine3A,
    size: Vec3,
    /// Blocks along each axis.
    blocks: [u32; 3],
    bounds: Vec<f32>,
}

/// A ray in the space of a grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GridRay {
    org: Vec3,
    dir: Vec3,
    /// The parameters between which it is in the grid.
    span: [f32; 2],
}

impl GridRay {
    /// The parameters between which it is in the grid.
    pub(crate) fn span(&self) -> [f32; 2] {
        self.span
    }
}

impl Grid {
    pub(crate) fn new(data: &Arc<DensityGrid>) -> Self {
        let world = data.world_from_unit.inverse().unwrap_or_default();
        let [x, y, z, w] = world.to_f32().map(Vec3::from);
        let blocks = data.size.map(|n| n.div_ceil(BLOCK));
        let mut grid = Self {
            data: data.clone(),
            unit_from_world: Affine3A::from_mat3_translation(Mat3::from_cols(x, y, z), w),
            size: Vec3::from(data.size.map(|n| n as f32)),
            blocks,
            bounds: Vec::new(),
        };
        let count = blocks.iter().map(|&n| n as usize).product();
        grid.bounds = vec![0.0; count];
        let [nx, ny, nz] = data.size;
        for (z, y, x) in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x)))) {
            let density = grid.cell([x, y, z]);
            if density == 0.0 {
                continue;
            }
            // Interpolation reaches a cell's neighbours.
            let reach = [x, y, z].map(|i| (i.saturating_sub(1) / BLOCK, (i + 1) / BLOCK));
            let upto = |k: usize| reach[k].0..=reach[k].1.min(blocks[k] - 1);
            for (bz, by, bx) in
                upto(2).flat_map(|z| upto(1).flat_map(move |y| upto(0).map(move |x| (z, y, x))))
            {
                let bound = &mut grid.bounds[((bz * blocks[1] + by) * blocks[0] + bx) as usize];
                *bound = bound.max(density);
            }
        }
        grid
    }

    /// Whether it was made of this.
    pub(crate) fn is_of(&self, data: &Arc<DensityGrid>) -> bool {
        Arc::ptr_eq(&self.data, data)
    }

    fn index(&self, [x, y, z]: [u32; 3]) -> usize {
        let [nx, ny, _] = self.data.size;
        (z as usize * ny as usize + y as usize) * nx as usize + x as usize
    }

    fn cell(&self, at: [u32; 3]) -> f32 {
        self.data.density[self.index(at)]
    }

    /// A ray of the world; `None` if it misses the grid.
    pub(crate) fn ray(&self, org: Vec3, dir: Vec3) -> Option<GridRay> {
        let org = self.unit_from_world.transform_point3(org);
        let dir = self.unit_from_world.transform_vector3(dir);
        let mut span = [0.0_f32, f32::INFINITY];
        for k in 0..3 {
            if dir[k] == 0.0 {
                if !(0.0..=1.0).contains(&org[k]) {
                    return None;
                }
                continue;
            }
            let [a, b] = [-org[k] / dir[k], (1.0 - org[k]) / dir[k]];
            span = [span[0].max(a.min(b)), span[1].min(a.max(b))];
        }
        (span[0] < span[1]).then_some(GridRay { org, dir, span })
    }

    /// A bound of the density along a ray from parameter `t` on, and up to where it holds.
    pub(crate) fn bound(&self, ray: &GridRay, t: f32) -> (f32, f32) {
        let [begin, end] = ray.span;
        if t < begin {
            return (0.0, begin);
        }
        if t >= end {
            return (0.0, f32::INFINITY);
        }
        let edge = BLOCK as f32 / self.size;
        let p = ray.org + ray.dir * t;
        let (mut at, mut upto) = ([0; 3], end);
        for k in 0..3 {
            let position = p[k] / edge[k];
            let last = self.blocks[k] as f32 - 1.0;
            let mut block = position.floor().clamp(0.0, last);
            // On a face, the block ahead counts.
            if ray.dir[k] < 0.0 && block > 0.0 && position <= block {
                block -= 1.0;
            }
            at[k] = block as u32;
            let face = if ray.dir[k] > 0.0 { block + 1.0 } else { block };
            if ray.dir[k] != 0.0 {
                let crossing = (face * edge[k] - ray.org[k]) / ray.dir[k];
                upto = upto.min(crossing.max(t));
            }
        }
        let bound = self.bounds[((at[2] * self.blocks[1] + at[1]) * self.blocks[0] + at[0]) as usize];
        (bound, upto.max(t + t.abs() * 4.0 * f32::EPSILON + end * f32::EPSILON))
    }

    /// Density, and the factor of emission, at a parameter of a ray.
    pub(crate) fn at(&self, ray: &GridRay, t: f32) -> (f32, Vec3) {
        let p = (ray.org + ray.dir * t).clamp(Vec3::ZERO, Vec3::ONE) * self.size - 0.5;
        let p = p.clamp(Vec3::ZERO, self.size - 1.0);
        let base = p.floor();
        let part = p - base;
        let low = [base.x as u32, base.y as u32, base.z as u32];
        let (mut density, mut emission) = (0.0, Vec3::ZERO);
        for corner in 0..8_u32 {
            let bit = |k: usize| corner >> k & 1;
            let weight: f32 = (0..3).map(|k| if bit(k) == 1 { part[k] } else { 1.0 - part[k] }).product();
            if weight > 0.0 {
                let at = std::array::from_fn(|k| (low[k] + bit(k)).min(self.data.size[k] - 1));
                density += weight * self.cell(at);
                if let Some(factor) = self.data.emission.get(self.index(at)) {
                    emission += weight * Vec3::from(*factor);
                }
            }
        }
        (density, if self.data.emission.is_empty() { Vec3::ONE } else { emission })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_scene::Affine;

    #[test]
    fn no_density_is_above_its_bound() {
        let size = [19, 8, 23];
        let mut random = 1_u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) as f32 / 16_777_216.0
        };
        let density: Vec<f32> =
            (0..19 * 8 * 23).map(|_| if next() < 0.7 { 0.0 } else { next() * 3.0 }).collect();
        let place = Affine::translation([1.0, 2.0, -3.0]) * Affine::scale([2.0, 5.0, 3.0]);
        let grid =
            Grid::new(&Arc::new(DensityGrid { size, density, emission: Vec::new(), world_from_unit: place }));
        let mut met = 0;
        for _ in 0..500 {
            let mut point = || Vec3::new(next() * 4.0, next() * 9.0, next() * 5.0 - 4.0);
            let (from, to) = (point(), point());
            let Some(ray) = grid.ray(from, (to - from).normalize()) else { continue };
            let (mut t, mut steps) = (0.0, 0);
            while t < ray.span[1] {
                let (bound, end) = grid.bound(&ray, t);
                assert!(end > t, "it goes on: {t} {end}");
                steps += 1;
                assert!(steps < 200, "it ends");
                let upto = end.min(ray.span[1]);
                for k in 0..20 {
                    let at = t + (upto - t) * (k as f32 + 0.5) / 20.0;
                    let density = if at < ray.span[0] { 0.0 } else { grid.at(&ray, at).0 };
                    assert!(density <= bound * 1.000_1 + 1e-5, "{density} above {bound} at {at}");
                    met += usize::from(density > 0.0);
                }
                t = end;
            }
        }
        assert!(met > 1000, "{met}");
    }
}
