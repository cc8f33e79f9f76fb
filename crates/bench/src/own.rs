// SPDX-License-Identifier: GPL-3.0-or-later
//! Our trees, queried as by a program.

use gnurt::accel::{Coherence, INVALID_ID, ObjectTree, Query, RayBatch};
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

impl Engine for OwnEngine<'_> {
    fn make_ready(&self, rays: &RayBatch, answers: &mut Answers) {
        if matches!(self.query_kind, QueryKind::One) {
            answers.own_rays.clear();
            answers.own_rays.extend((0..rays.len()).map(|i| rays.get(i)));
        }
    }

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
                for ((ray, t), prim_id) in answers.own_rays.iter().zip(t).zip(prim_id) {
                    let hit = self.tree.intersect_with(&query, ray);
                    (*t, *prim_id) = hit.map_or((f32::INFINITY, INVALID_ID), |hit| (hit.t, hit.prim_id));
                }
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
                for (ray, occluded) in answers.own_rays.iter().zip(occluded) {
                    *occluded = self.tree.occluded_with(&query, ray);
                }
            }
        }
    }
}
