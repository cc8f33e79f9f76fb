// SPDX-License-Identifier: GPL-3.0-or-later
//! From batches to single calls.

use gnurt::accel::{Ray, RayBatch};
use gnurt_bench::{Answers, Engine, Subject};

/// A structure that takes one ray at a time.
pub(crate) trait Tracer: Sync {
    /// The closest hit's `t`, infinite for a miss.
    fn closest(&self, ray: &Ray) -> f32;
    /// Whether anything is hit.
    fn any(&self, ray: &Ray) -> bool;
}

/// Queries a tracer ray by ray.
pub(crate) struct OneByOne<T>(pub(crate) T);

impl<T: Tracer> Engine for OneByOne<T> {
    fn closest(&self, rays: &RayBatch, answers: &mut Answers) {
        answers.resize(rays.len());
        for (i, t) in answers.hits.t.iter_mut().enumerate() {
            *t = self.0.closest(&rays.get(i));
        }
    }

    fn any(&self, rays: &RayBatch, answers: &mut Answers) {
        answers.resize(rays.len());
        for (i, occluded) in answers.occluded.iter_mut().enumerate() {
            *occluded = self.0.any(&rays.get(i));
        }
    }
}

/// The instruction set that this program is compiled for.
pub(crate) const ISA: &str = if cfg!(target_feature = "avx512f") {
    "avx512"
} else if cfg!(target_feature = "avx2") {
    "avx2"
} else {
    "baseline"
};

/// Corners of all triangles.
pub(crate) fn corners(subject: &Subject) -> impl Iterator<Item = [[f32; 3]; 3]> {
    let triangles = subject.triangles();
    triangles.indices.iter().map(move |triangle| triangle.map(|i| triangles.positions[i as usize]))
}
