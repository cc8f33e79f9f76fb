// SPDX-License-Identifier: GPL-3.0-or-later
//! tinybvh-rs: Jacco Bikker's tinybvh, C++ behind a Rust interface. Source: its documentation.
//! The interface has no query for any hit and no near end; rays here begin at 0, as its own do. Its trees may not be
//! shared by threads, so each thread builds its own at its first ray: before anything is timed, with one thread.
//! Two faults of version 0.1.0-beta.3 are worked round. Its rays are aligned to 16 bytes where the C++ side
//! requires 64, so ours are in a frame of their own. Its trees copy pointers that two owners free, so none is
//! ever dropped.

use std::cell::RefCell;
use std::collections::HashMap;
use std::mem::ManuallyDrop;

use gnurt::accel::RayBatch;
use gnurt_bench::{Answers, Contestant, Engine, Subject};
use tinybvh_rs::{INFINITE, Intersector, Ray, bvh, bvh8_cpu, mbvh};

use crate::one_by_one::{ISA, corners};

thread_local! {
    /// This thread's trees, by the name of their scene and mode.
    static TREES: RefCell<HashMap<String, ManuallyDrop<bvh8_cpu::BVH>>> = RefCell::default();
}

/// A ray with C++'s alignment, and space for the further fields of its type.
#[repr(C, align(64))]
struct Framed {
    ray: Ray,
    spare: [u64; 8],
}

struct Trees {
    name: String,
    /// Corners, one after the other, padded as the library wants them.
    corners: Vec<[f32; 4]>,
    high_quality: bool,
}

impl Trees {
    fn build(&self) -> ManuallyDrop<bvh8_cpu::BVH> {
        let positions = self.corners.as_slice().into();
        let built = if self.high_quality { bvh::BVH::new_hq(positions) } else { bvh::BVH::new(positions) };
        let mut binary = ManuallyDrop::new(built.expect("corners come in threes"));
        binary.split_leaves(4);
        let wide = ManuallyDrop::new(mbvh::BVH::new(&binary));
        ManuallyDrop::new(bvh8_cpu::BVH::new(&wide).expect("leaves hold four"))
    }

    /// Gives `t`, infinite for a miss, ray by ray.
    fn trace(&self, rays: &RayBatch, mut take: impl FnMut(usize, f32)) {
        TREES.with_borrow_mut(|trees| {
            let tree = trees.entry(self.name.clone()).or_insert_with(|| self.build());
            for i in 0..rays.len() {
                let ray = rays.get(i);
                let t_far = ray.t_far.min(INFINITE);
                let mut framed = Framed {
                    ray: Ray {
                        origin: ray.org,
                        dir: ray.dir,
                        r_d: ray.dir.map(f32::recip),
                        // The mask: everything.
                        padding_0: u32::MAX,
                        ..Ray::default()
                    },
                    spare: [0; 8],
                };
                framed.ray.hit.t = t_far;
                tree.intersect(&mut framed.ray);
                let t = framed.ray.hit.t;
                take(i, if t < t_far { t } else { f32::INFINITY });
            }
        });
    }
}

impl Engine for Trees {
    fn closest(&self, rays: &RayBatch, answers: &mut Answers) {
        answers.resize(rays.len());
        self.trace(rays, |i, t| answers.hits.t[i] = t);
    }

    fn any(&self, rays: &RayBatch, answers: &mut Answers) {
        answers.resize(rays.len());
        self.trace(rays, |i, t| answers.occluded[i] = t.is_finite());
    }
}

/// BVH8_CPU over both kinds of binary trees.
pub(crate) fn contestants(subject: &Subject) -> [Contestant<'static>; 2] {
    let padded = |corner: [f32; 3]| [corner[0], corner[1], corner[2], 0.0];
    let all: Vec<[f32; 4]> = corners(subject).flatten().map(padded).collect();
    [("bvh8", false), ("bvh8-hq", true)].map(|(mode, high_quality)| Contestant {
        engine: "tinybvh",
        mode: mode.into(),
        isa: ISA,
        tracer: Box::new(Trees {
            name: format!("{} {mode}", subject.name),
            corners: all.clone(),
            high_quality,
        }),
    })
}
