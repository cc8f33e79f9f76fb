// SPDX-License-Identifier: GPL-3.0-or-later
//! Our trees, asked as a program asks them. Source: original.

use gnurt::accel::{Coherence, INVALID_ID, ObjectTree, Query, RayBatch};
use gnurt::simd::Level;

use crate::job::Asked;
use crate::timing::{Answers, Engine};

/// A tree, and how it is asked.
pub(crate) struct OwnEngine<'a> {
    pub(crate) tree: &'a ObjectTree,
    pub(crate) asked: Asked,
    pub(crate) level: Level,
}

impl OwnEngine<'_> {
    fn query(&self, coherence: Coherence) -> Query {
        Query { level: self.level, coherence, ..Query::default() }
    }
}

impl Engine for OwnEngine<'_> {
    fn closest(&self, rays: &RayBatch, answers: &mut Answers) {
        match self.asked {
            Asked::Batch(coherence) => {
                let query = self.query(coherence);
                self.tree.intersect_batch(&query, rays, &mut answers.hits, &mut answers.record);
            }
            Asked::One => {
                answers.resize(rays.len());
                for i in 0..rays.len() {
                    let hit = self.tree.intersect(&rays.get(i));
                    answers.hits.t[i] = hit.map_or(f32::INFINITY, |hit| hit.t);
                    answers.hits.prim_id[i] = hit.map_or(INVALID_ID, |hit| hit.prim_id);
                }
            }
        }
    }

    fn any(&self, rays: &RayBatch, answers: &mut Answers) {
        match self.asked {
            Asked::Batch(coherence) => {
                let query = self.query(coherence);
                self.tree.occluded_batch(&query, rays, &mut answers.occluded, &mut answers.record);
            }
            Asked::One => {
                answers.resize(rays.len());
                for i in 0..rays.len() {
                    answers.occluded[i] = self.tree.occluded(&rays.get(i));
                }
            }
        }
    }
}
