// SPDX-License-Identifier: GPL-3.0-or-later
//! One object's triangles, ready to be asked for rays: built once, never changed, shared through `Arc`.
//! Source: original. Space: object.

use crate::geometry::{Screened, mesh_of};
use crate::triangle::{WatertightRay, WatertightTriangles};
use crate::{
    Aabb, BadPrimitives, BuildOptions, Hit, HitBatch, Query, Ray, RayBatch, Record, Threads, TreeStats,
    Triangles,
};

/// A tree over the triangles of an object's meshes.
#[derive(Debug)]
pub struct ObjectTree {
    starts: Vec<u32>,
    good: Vec<u32>,
    triangles: WatertightTriangles,
    bounds: Aabb,
    bad: BadPrimitives,
    stats: TreeStats,
}

impl ObjectTree {
    /// Builds over `meshes`. Triangles that cannot be traced are left out and counted; no triangle at all is fine.
    #[must_use]
    pub fn build(meshes: &[Triangles], options: &BuildOptions, threads: Threads) -> Self {
        let _ = (options, threads);
        let screened = Screened::new(meshes);
        let mut corners = vec![[[0.0; 3]; 3]; screened.count()];
        for &number in &screened.good {
            corners[number as usize] = screened.corners(number);
        }
        let stats = TreeStats { primitives: screened.good.len() as u64, ..TreeStats::default() };
        Self {
            triangles: WatertightTriangles { corners },
            bounds: screened.bounds,
            bad: screened.bad,
            stats,
            starts: screened.starts,
            good: screened.good,
        }
    }

    /// Box around all triangles, object space; [`Aabb::EMPTY`] without any.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// What was left out at build.
    #[must_use]
    pub fn bad_primitives(&self) -> BadPrimitives {
        self.bad
    }

    /// Size and shape of the tree.
    #[must_use]
    pub fn stats(&self) -> TreeStats {
        self.stats
    }

    /// The closest hit; `inst_id` is 0.
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let prepared = WatertightRay::new(ray);
        let mut best: Option<Hit> = None;
        for &number in &self.good {
            let t_far = best.map_or(ray.t_far, |hit| hit.t);
            if let Some(at) = self.triangles.meet(number, &prepared, ray.t_near, t_far) {
                let mesh = mesh_of(&self.starts, number);
                best = Some(Hit {
                    t: at.t,
                    u: at.u,
                    v: at.v,
                    prim_id: number - self.starts[mesh],
                    geom_id: mesh as u32,
                    inst_id: 0,
                });
            }
        }
        best
    }

    /// Whether anything is hit.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.intersect(ray).is_some()
    }

    /// Closest hits of a batch; `hits` is resized to it.
    pub fn intersect_batch(&self, query: &Query, rays: &RayBatch, hits: &mut HitBatch, record: &mut Record) {
        let _ = query;
        hits.reset(rays.len());
        for i in 0..rays.len() {
            if let Some(hit) = self.intersect(&rays.get(i)) {
                hits.set(i, hit);
            }
        }
        record.counters.rays += rays.len() as u64;
    }

    /// Whether anything is hit, ray by ray; `occluded` is resized to the batch.
    pub fn occluded_batch(
        &self,
        query: &Query,
        rays: &RayBatch,
        occluded: &mut Vec<bool>,
        record: &mut Record,
    ) {
        let _ = query;
        occluded.clear();
        occluded.extend((0..rays.len()).map(|i| self.occluded(&rays.get(i))));
        record.counters.rays += rays.len() as u64;
    }
}
