// SPDX-License-Identifier: GPL-3.0-or-later
//! The speed of rays with times in many instances that move while the shutter is open, compared with Embree's
//! instances with quaternions at time steps, and with the same instances at rest. Spheres in a cube, each of
//! which moves by its own size and rotates about its axis. Rays are traced one by one, by one thread, each at
//! its own time; times are its processor seconds, engines alternate, and results must agree.
//! Tests: `tests::both_hit_the_same`.

use std::sync::Arc;

use gnurt::accel::{
    BuildOptions, Coherence, HitBatch, Instance, MotionPath, ObjectTree, Query, Record, SceneTree, Threads,
    Triangles,
};
use gnurt::simd::Level;

use crate::blur::BlurRow;
use crate::clock::{process_seconds, thread_seconds};
use crate::embree::EmbreeLibrary;
use crate::error::Error;
use crate::ffi_embree::Scene;
use crate::ffi_instances::{Instances, Turned};
use crate::random::Random;
use crate::row::median;
use crate::single::{agree, closest, hit_count};
use crate::top::{ball, rays};

/// A motion: its size, and angle and position at both ends of the time.
struct RigidMotion {
    size: f32,
    ends: [(f32, [f32; 3]); 2],
}

impl RigidMotion {
    fn new(random: &mut Random, spread: f32, turn_angle: f32) -> Self {
        let mut next = || random.unit();
        let (size, angle) = (0.5 + next(), std::f32::consts::TAU * next());
        let position = [spread * next(), spread * next(), spread * next()];
        let by = [0, 1, 2].map(|_| size * (next() - 0.5));
        let to = [position[0] + by[0], position[1] + by[1], position[2] + by[2]];
        Self { size, ends: [(angle, position), (angle + turn_angle, to)] }
    }

    fn columns(&self, end: usize) -> [[f64; 3]; 4] {
        let ((angle, position), size) = (self.ends[end], f64::from(self.size));
        let (s, c) = f64::from(angle).sin_cos();
        [[size * c, 0.0, -size * s], [0.0, size, 0.0], [size * s, 0.0, size * c], position.map(f64::from)]
    }

    fn steps(&self) -> Vec<Turned> {
        self.ends.iter().map(|&(angle, position)| Turned::about_y(self.size, angle, position)).collect()
    }
}

/// Measures `count` instances that rotate by `turn_angle` radians while the shutter is open.
///
/// # Errors
/// [`Error::Embree`] if Embree fails, or if its answers are others than ours.
pub fn run(
    count: usize,
    turn_angle: f32,
    rounds: usize,
    embree: Option<&EmbreeLibrary>,
) -> Result<Vec<BlurRow>, Error> {
    let (positions, indices) = ball();
    let spread = 2.0 * (count as f32).cbrt();
    let mut random = Random::new(1);
    let paths: Vec<RigidMotion> =
        (0..count).map(|_| RigidMotion::new(&mut random, spread, turn_angle)).collect();
    let mut batch = rays(&mut random, spread);
    batch.time = (0..batch.len()).map(|_| random.unit()).collect();
    let mesh = Triangles { positions: &positions, indices: &indices };
    let options = BuildOptions::default();
    let object = Arc::new(ObjectTree::build(&[mesh], &options, Threads::Single));
    let moving = |motion: &RigidMotion| {
        let path = MotionPath::new(&[motion.columns(0), motion.columns(1)]).expect("a ball is not flat");
        Instance::moving(object.clone(), Arc::new(path))
    };
    let still = |motion: &RigidMotion| Instance::new(object.clone(), motion.columns(0));
    let lists: [Vec<Instance>; 2] = [paths.iter().map(moving).collect(), paths.iter().map(still).collect()];
    let mut ours = Vec::new();
    for (name, list) in ["gnurt", "gnurt still"].into_iter().zip(&lists) {
        let before = process_seconds();
        let scene = SceneTree::build(list, &options, Threads::Single);
        ours.push((name, scene, process_seconds() - before));
    }
    let mut padded = positions.clone();
    padded.push([0.0; 3]);
    let device = embree.map(|library| library.device(Level::best(), 1)).transpose()?;
    let theirs = match (&device, embree) {
        (Some(device), Some(library)) => {
            let shown = Scene::build(device, &padded, &indices, 1, 0).map_err(|e| library.failed(e))?;
            let mut theirs = Instances::new(device, &shown, count, 1, 0);
            let steps: Vec<Vec<Turned>> = paths.iter().map(RigidMotion::steps).collect();
            let before = process_seconds();
            theirs.set_moving_matrices(&steps);
            theirs.commit();
            device.check().map_err(|e| library.failed(e))?;
            Some((theirs, process_seconds() - before))
        }
        _ => None,
    };
    let query = Query { coherence: Coherence::Incoherent, ..Query::default() };
    let mut seconds = vec![Vec::new(); 3];
    let mut hits = [HitBatch::default(), HitBatch::default()];
    let mut found = HitBatch::default();
    for _ in 0..rounds {
        for (i, (_, scene, _)) in ours.iter().enumerate() {
            let before = thread_seconds();
            scene.intersect_batch(&query, &batch, &mut hits[i], &mut Record::default());
            seconds[i].push(thread_seconds() - before);
        }
        if let Some((theirs, _)) = &theirs {
            let before = thread_seconds();
            closest(&theirs.scene, &batch, &mut found);
            seconds[2].push(thread_seconds() - before);
        }
    }
    if let (Some(_), Some(library)) = (&theirs, embree) {
        agree(&hits[0], &found, 1e-4, 200).map_err(|e| library.failed(e))?;
    }
    let row = |engine, i: usize, build_seconds, bytes, hits| BlurRow {
        class: "across",
        engine,
        mrays_cpu: batch.len() as f64 / 1e6 / median(&seconds[i]).max(1e-9),
        build_seconds,
        bytes,
        hits,
    };
    let mut rows: Vec<BlurRow> = Vec::new();
    for (i, (name, scene, build_seconds)) in ours.iter().enumerate() {
        let stats = scene.stats();
        let bytes = stats.tree_bytes + stats.primitive_bytes;
        rows.push(row(name, i, *build_seconds, Some(bytes), hit_count(&hits[i])));
    }
    if let Some((_, build_seconds)) = &theirs {
        rows.push(row("embree4", 2, *build_seconds, None, hit_count(&found)));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embree::embree_of_tests;

    #[test]
    fn both_hit_the_same() {
        let library = embree_of_tests();
        let rows = run(300, 2.0, 1, library.as_ref()).expect("they agree");
        assert_eq!(rows.len(), if library.is_some() { 3 } else { 2 }, "{rows:?}");
        assert!(rows.iter().all(|row| row.hits > 10_000), "{rows:?}");
    }
}
