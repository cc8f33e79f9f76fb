// SPDX-License-Identifier: GPL-3.0-or-later
//! Our trees, queried as by a program.

use gnurt::accel::{Coherence, INVALID_ID, ObjectTree, Query, Ray, RayBatch};
use gnurt::simd::Level;

use crate::job::QueryKind;
use crate::timing::{Answers, Engine};

/// A tree, and its kind of query.
pub(crate) struct OwnEngine<'a> {
    pub(crate) tree: &'a ObjectTree,
    pub(crate) query_kind: QueryKind,
    pub(crate) level: Level,
}

impl OwnEngine<'_> {
    fn query(&self, coherence: Coherence) -> Query {
        Query { level: self.level, coherence, ..Query::default() }
    }
}

/// Takes the rays out one by one, for as little as it costs to take them out for Embree.
#[inline(always)]
fn each(rays: &RayBatch, mut run_query: impl FnMut(usize, Ray)) {
    let count = rays.len();
    let ([x, y, z], [dx, dy, dz]) = (&rays.org, &rays.dir);
    let (x, y, z) = (&x[..count], &y[..count], &z[..count]);
    let (dx, dy, dz) = (&dx[..count], &dy[..count], &dz[..count]);
    let (t_near, t_far) = (&rays.t_near[..count], &rays.t_far[..count]);
    for i in 0..count {
        let ray = Ray::new([x[i], y[i], z[i]], [dx[i], dy[i], dz[i]]);
        run_query(i, ray.within(t_near[i], t_far[i]));
    }
}

impl Engine for OwnEngine<'_> {
    fn closest(&self, rays: &RayBatch, answers: &mut Answers) {
        match self.query_kind {
            QueryKind::Batch(coherence) => {
                let query = self.query(coherence);
                self.tree.intersect_batch(&query, rays, &mut answers.hits, &mut answers.record);
            }
            QueryKind::One => {
                let query = self.query(Coherence::default());
                answers.resize(rays.len());
                let (t, prim_id) =
                    (&mut answers.hits.t[..rays.len()], &mut answers.hits.prim_id[..rays.len()]);
                each(rays, |i, ray| {
                    let hit = self.tree.intersect_with(&query, &ray);
                    (t[i], prim_id[i]) = hit.map_or((f32::INFINITY, INVALID_ID), |hit| (hit.t, hit.prim_id));
                });
            }
        }
    }

    fn any(&self, rays: &RayBatch, answers: &mut Answers) {
        match self.query_kind {
            QueryKind::Batch(coherence) => {
                let query = self.query(coherence);
                self.tree.occluded_batch(&query, rays, &mut answers.occluded, &mut answers.record);
            }
            QueryKind::One => {
                let query = self.query(Coherence::default());
                answers.resize(rays.len());
                let occluded = &mut answers.occluded[..rays.len()];
                each(rays, |i, ray| occluded[i] = self.tree.occluded_with(&query, &ray));
            }
        }
    }
}
