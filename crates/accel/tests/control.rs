// SPDX-License-Identifier: GPL-3.0-or-later
//! Builds that are cancelled, watched, and kept within a budget.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::common::{TESTS, options};
use gnurt_accel::{
    BuildControl, BuildError, BuildOptions, Instance, ObjectTree, Quality, SceneError, SceneTree, Threads,
    Triangles,
};
use gnurt_testkit::{Soup, closed};

/// Records reports, and stops a build.
#[derive(Default)]
struct Notes {
    reported: Mutex<Vec<f32>>,
    peak: AtomicU64,
    last: AtomicU64,
    requests: AtomicU64,
    /// Says no when it is asked so often; 0 for never.
    no: u64,
    budget: Option<u64>,
}

impl BuildControl for Notes {
    fn keep_going(&self) -> bool {
        self.requests.fetch_add(1, Relaxed) + 1 != self.no
    }

    fn progress(&self, done: f32) {
        self.reported.lock().expect("nobody panics").push(done);
    }

    fn memory(&self, bytes: u64) {
        self.peak.fetch_max(bytes, Relaxed);
        self.last.store(bytes, Relaxed);
    }

    fn memory_budget(&self) -> u64 {
        self.budget.unwrap_or(u64::MAX)
    }
}

fn try_build(
    mesh: &Soup,
    kind: crate::common::Kind,
    threads: Threads,
    notes: &Notes,
) -> Result<ObjectTree, BuildError> {
    let mesh = Triangles { positions: &mesh.positions, indices: &mesh.indices };
    ObjectTree::try_build(&[mesh], &options(kind), threads, notes)
}

#[test]
fn who_listens_does_not_change_the_tree() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads start");
    let mesh = closed::torus(60);
    for (kind, _) in TESTS {
        let plain = crate::common::build(std::slice::from_ref(&mesh), kind);
        for threads in [Threads::Single, Threads::Pool(&pool)] {
            let notes = Notes::default();
            let tree = try_build(&mesh, kind, threads, &notes).expect("nobody stops it");
            assert!(tree.same_tree(&plain), "{kind:?}: node for node");
            let reported = notes.reported.into_inner().expect("nobody panics");
            assert!(reported.len() > 1, "{kind:?}: {reported:?} is not much");
            assert!(
                reported.is_sorted() && reported.last() == Some(&1.0),
                "{kind:?}: {reported:?} goes to 1"
            );
            let stats = tree.stats();
            let (result, last) = (stats.tree_bytes + stats.primitive_bytes, notes.last.into_inner());
            let peak = notes.peak.into_inner();
            assert!(peak > result, "{kind:?}: {peak} at its peak for {result}");
            let about = |part: f64| (part * result as f64) as u64;
            assert!((about(0.9)..about(1.5)).contains(&last), "{kind:?}: {last} at the end for {result}");
        }
    }
}

/// Counts how often it is asked before it is told something new.
#[derive(Default)]
struct Patience {
    requests: AtomicU64,
    most: AtomicU64,
}

impl BuildControl for Patience {
    fn keep_going(&self) -> bool {
        self.most.fetch_max(self.requests.fetch_add(1, Relaxed) + 1, Relaxed);
        true
    }

    fn progress(&self, _: f32) {
        self.requests.store(0, Relaxed);
    }
}

#[test]
fn progress_goes_on_while_knots_are_moved() {
    let mesh = closed::torus(200);
    let triangles = Triangles { positions: &mesh.positions, indices: &mesh.indices };
    for quality in [Quality::Medium, Quality::High] {
        let patience = Patience::default();
        let options = BuildOptions { quality, ..BuildOptions::default() };
        let built = ObjectTree::try_build(&[triangles], &options, Threads::Single, &patience);
        assert!(built.is_ok(), "nobody stops it");
        // A build asks where it works, every few thousand triangles, and between its stages.
        let most = patience.most.into_inner();
        assert!(most <= 12, "{quality:?}: asked {most} times without a word");
    }
}

#[test]
fn any_no_ends_a_build() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads start");
    let mesh = closed::torus(60);
    for (kind, _) in TESTS {
        for threads in [Threads::Single, Threads::Pool(&pool)] {
            let all = Notes::default();
            try_build(&mesh, kind, threads, &all).expect("nobody stops it");
            let all = all.requests.into_inner();
            assert!(all > 4, "{kind:?}: asked {all} times only");
            for no in [1, 2, 3, all / 2, all - 1] {
                let notes = Notes { no, ..Notes::default() };
                let error = try_build(&mesh, kind, threads, &notes).err();
                assert_eq!(
                    error,
                    Some(BuildError::Cancelled),
                    "{kind:?}: no, when asked for the {no}th time"
                );
                let reported = notes.reported.into_inner().expect("nobody panics");
                assert!(reported.last() != Some(&1.0), "{kind:?}: not finished");
            }
        }
    }
}

#[test]
fn a_build_stays_within_its_budget() {
    let mesh = closed::torus(60);
    for (kind, _) in TESTS {
        let free = Notes::default();
        let tree = try_build(&mesh, kind, Threads::Single, &free).expect("nobody stops it");
        let peak = free.peak.into_inner();
        let with = |budget: u64| {
            let notes = Notes { budget: Some(budget), ..Notes::default() };
            let built = try_build(&mesh, kind, Threads::Single, &notes);
            assert!(notes.peak.into_inner() <= budget, "{kind:?}: {budget} bytes and no more");
            built
        };
        assert!(with(peak).is_ok_and(|same| same.same_tree(&tree)), "{kind:?}: {peak} bytes are enough");
        for budget in [0, 1000, peak / 3, peak / 2, peak - 1] {
            match with(budget).err() {
                Some(BuildError::OutOfMemory { needed, budget: allowed }) => {
                    assert_eq!(allowed, budget, "{kind:?}: as it was set");
                    assert!(needed > budget && needed <= peak, "{kind:?}: {needed} of {peak} bytes");
                }
                other => panic!("{kind:?}: {other:?} with {budget} of {peak} bytes"),
            }
        }
    }
}

/// Scenes of instances are built under the same control; the last one that says no wins over instances that are fine.
#[test]
fn scenes_are_built_under_control() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads start");
    let ball = std::sync::Arc::new(crate::common::build(&[closed::sphere(4)], crate::common::WATERTIGHT[0]));
    let at = |i: u32| {
        let mut instance = Instance::identity(ball.clone());
        instance.world_from_object[3] = [f64::from(i % 70), f64::from(i / 70), f64::from(i * i % 13)];
        instance
    };
    let list: Vec<Instance> = (0..6000).map(at).collect();
    for quality in [Quality::Fast, Quality::Medium, Quality::High] {
        let options = BuildOptions { quality, ..BuildOptions::default() };
        for threads in [Threads::Single, Threads::Pool(&pool)] {
            let build = |notes: &Notes| SceneTree::try_build(&list, &options, threads, notes);
            let free = Notes::default();
            let stats = build(&free).expect("nobody stops it").stats();
            let reported = free.reported.into_inner().expect("nobody panics");
            assert!(
                reported.len() > 2 && reported.is_sorted() && reported.last() == Some(&1.0),
                "{reported:?} goes to 1"
            );
            let (peak, last) = (free.peak.into_inner(), free.last.into_inner());
            let result = stats.tree_bytes + stats.primitive_bytes;
            assert!(peak > result, "{peak} at its peak for {result}");
            assert!((result * 9 / 10..result * 3 / 2).contains(&last), "{last} at the end for {result}");
            for no in [1, 2, free.requests.into_inner() - 1] {
                let notes = Notes { no, ..Notes::default() };
                let error = build(&notes).err();
                assert_eq!(
                    error,
                    Some(SceneError::Build(BuildError::Cancelled)),
                    "no, when asked for time {no}"
                );
            }
            for budget in [0, peak / 2, peak - 1] {
                let notes = Notes { budget: Some(budget), ..Notes::default() };
                let error = build(&notes).err();
                let is_named = matches!(
                    error,
                    Some(SceneError::Build(BuildError::OutOfMemory { needed, budget: allowed }))
                        if needed > budget && allowed == budget
                );
                assert!(is_named, "{error:?} with {budget} of {peak} bytes");
            }
        }
    }
}
