// SPDX-License-Identifier: GPL-3.0-or-later
//! `bench dynamic`, cases `crowd` and `crowd64`: a thousand characters of 5,000 triangles, each in its own
//! pose or in one of 64, that all change from frame to frame. \[SIP06\], section 6, requests it. `instanced`
//! shares structures between poses ([`Crowd`]), `separate` builds a tree for each character, by the fastest
//! builder. Both get the same vertices and the same rays, and must have the same hits, bit for bit. Times are
//! processor time of one thread; an update is all trees and the tree over them. Bytes include trees,
//! triangles, shared parts, and the vertices that the program keeps for each pose. Tests:
//! `tests::both_hit_the_same`.

use std::sync::Arc;

use gnurt::accel::{
    BuildOptions, Coherence, Crowd, HitBatch, Instance, ObjectTree, Quality, Query, Ray, RayBatch, Record,
    SceneTree, Threads, Triangles,
};
use gnurt::simd::Level;

use crate::clock::process_seconds;
use crate::dynamic_row::DynamicRow;
use crate::error::Error;
use crate::random::Random;
use crate::row::median;
use crate::vector::{cross, minus, unit};

/// The scenes to measure, and the method.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Characters.
    pub characters: usize,
    /// Frames; each is an update.
    pub frames: usize,
    /// Columns and rows of primary rays.
    pub size: u32,
    /// Instruction set of rays.
    pub level: Level,
}

/// Rings of a limb, and vertices of a ring: with two poles these make 1,000 triangles.
const RINGS: usize = 25;
const SIDES: usize = 20;

/// Where a limb begins, where it goes at rest, its length and thickness, and how far it swings and bends.
struct Limb {
    from: [f32; 3],
    down: f32,
    length: f32,
    radius: f32,
    swing: f32,
    bend: f32,
}

const LIMBS: [Limb; 5] = [
    Limb { from: [0.0, 0.9, 0.0], down: -1.0, length: 0.95, radius: 0.17, swing: 0.15, bend: 0.3 },
    Limb { from: [-0.26, 1.5, 0.0], down: 1.0, length: 0.75, radius: 0.06, swing: 0.9, bend: 0.8 },
    Limb { from: [0.26, 1.5, 0.0], down: 1.0, length: 0.75, radius: 0.06, swing: -0.9, bend: 0.8 },
    Limb { from: [-0.11, 0.92, 0.0], down: 1.0, length: 0.92, radius: 0.09, swing: -0.7, bend: -0.9 },
    Limb { from: [0.11, 0.92, 0.0], down: 1.0, length: 0.92, radius: 0.09, swing: 0.7, bend: -0.9 },
];

/// Triangles of a character: five limbs of 1,000.
fn indices() -> Vec<[u32; 3]> {
    let mut all = Vec::new();
    for limb in 0..LIMBS.len() {
        let first = (limb * (RINGS * SIDES + 2)) as u32;
        let at = |ring: usize, side: usize| first + (ring * SIDES + side % SIDES) as u32;
        let poles = [first + (RINGS * SIDES) as u32, first + (RINGS * SIDES) as u32 + 1];
        for side in 0..SIDES {
            all.push([poles[0], at(0, side + 1), at(0, side)]);
            all.push([poles[1], at(RINGS - 1, side), at(RINGS - 1, side + 1)]);
            for ring in 0..RINGS - 1 {
                let [a, b, c, d] =
                    [at(ring, side), at(ring, side + 1), at(ring + 1, side), at(ring + 1, side + 1)];
                all.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
    all
}

/// Vertices of a character in a walk at a phase of period 1.
fn pose(phase: f32) -> Vec<[f32; 3]> {
    let mut all = Vec::with_capacity(LIMBS.len() * (RINGS * SIDES + 2));
    for limb in &LIMBS {
        let (swing, bend) = (limb.swing * phase.sin(), limb.bend * (0.5 + 0.5 * (phase + 0.6).cos()));
        let step = limb.length / RINGS as f32;
        let mut middle = limb.from;
        let mut poles = [middle; 2];
        for ring in 0..RINGS {
            let along = ring as f32 / (RINGS - 1) as f32;
            // A joint at half of the length.
            let joint = ((along - 0.4) * 5.0).clamp(0.0, 1.0);
            let (sin, cos) = (swing + bend * joint * joint * (3.0 - 2.0 * joint)).sin_cos();
            let axis = [0.0, -limb.down * cos, sin];
            let across = [0.0, sin, limb.down * cos];
            let radius = limb.radius * (0.35 + 0.65 * (std::f32::consts::PI * (0.08 + 0.84 * along)).sin());
            for side in 0..SIDES {
                let (s, c) = (std::f32::consts::TAU * side as f32 / SIDES as f32).sin_cos();
                all.push(
                    [0, 1, 2]
                        .map(|k| middle[k] + radius * (c * if k == 0 { 1.0 } else { 0.0 } + s * across[k])),
                );
            }
            poles[usize::from(ring == RINGS - 1)] = middle;
            middle = [0, 1, 2].map(|k| middle[k] + step * axis[k]);
        }
        all.extend(poles);
    }
    all
}

/// A method to follow the characters.
struct Follower {
    strategy: &'static str,
    trees: Vec<Arc<ObjectTree>>,
    scene: SceneTree,
    update: Vec<f64>,
    trace: Vec<f64>,
    hits: HitBatch,
}

impl Follower {
    fn new(strategy: &'static str) -> Self {
        let (scene, hits) = (SceneTree::default(), HitBatch::default());
        Self { strategy, trees: Vec::new(), scene, update: Vec::new(), trace: Vec::new(), hits }
    }

    /// Trees by `tree` and the tree over them.
    fn follow(&mut self, matrices: &[[[f64; 3]; 4]], tree: impl Fn(usize) -> Arc<ObjectTree>) {
        let before = process_seconds();
        self.trees = (0..matrices.len()).map(tree).collect();
        let instances: Vec<Instance> = self
            .trees
            .iter()
            .zip(matrices)
            .map(|(tree, &matrix_of)| Instance::new(Arc::clone(tree), matrix_of))
            .collect();
        self.scene = SceneTree::build(&instances, &BuildOptions::default(), Threads::Single);
        self.update.push(process_seconds() - before);
    }

    fn trace(&mut self, rays: &RayBatch, level: Level) {
        let query = Query { level, coherence: Coherence::Coherent, ..Query::default() };
        let before = process_seconds();
        self.scene.intersect_batch(&query, rays, &mut self.hits, &mut Record::default());
        self.trace.push(process_seconds() - before);
    }

    /// Of trees, their shared part, and the tree over them.
    fn bytes(&self) -> u64 {
        let mut trees: Vec<&Arc<ObjectTree>> = self.trees.iter().collect();
        trees.sort_by_key(|tree| Arc::as_ptr(tree));
        trees.dedup_by_key(|tree| Arc::as_ptr(tree));
        let own = |tree: &&Arc<ObjectTree>| tree.stats().tree_bytes + tree.stats().primitive_bytes;
        // All of them share with the same one.
        let shared = trees.iter().map(|tree| tree.shared_bytes()).max().unwrap_or(0);
        let top = self.scene.stats();
        trees.iter().map(own).sum::<u64>() + shared + top.tree_bytes + top.primitive_bytes
    }
}

/// Measures characters in `poses` different poses; `case` is their name in rows.
///
/// # Errors
/// Hits differ, which is a bug.
pub fn run(case: &'static str, poses: usize, options: &Options) -> Result<Vec<DynamicRow>, Error> {
    let indices = indices();
    let matrices = matrices(options.characters);
    let rays = rays(options.characters, options.size);
    let mut followers = [Follower::new("instanced"), Follower::new("separate")];
    let crowd = Crowd::default();
    let (medium, fast) =
        (BuildOptions::default(), BuildOptions { quality: Quality::Fast, ..BuildOptions::default() });
    let mut vertices = 0;
    for frame in 0..options.frames {
        let phase = |i: usize| std::f32::consts::TAU * i as f32 / poses as f32 + 0.15 * frame as f32;
        let bodies: Vec<Vec<[f32; 3]>> = (0..poses).map(|i| pose(phase(i))).collect();
        vertices = bodies[0].len();
        for angle in 0..2 {
            let i = (angle + frame) % 2;
            let mesh = |character: usize| {
                // Neighbours are in different poses.
                Triangles { positions: &bodies[character * 7 % poses], indices: &indices }
            };
            followers[i].follow(&matrices, |character| match i {
                0 => crowd.pose(&[mesh(character).into()], &medium, Threads::Single),
                _ => Arc::new(ObjectTree::build(&[mesh(character)], &fast, Threads::Single)),
            });
            followers[i].trace(&rays, options.level);
        }
        let [a, b] = followers.each_ref().map(|follower| &follower.hits);
        if (&a.t, &a.inst_id, &a.prim_id) != (&b.t, &b.inst_id, &b.prim_id) {
            let why = format!("in frame {frame} of {case}, poses that share and trees by themselves");
            return Err(Error::Differ(why));
        }
    }
    let row = |follower: &Follower| DynamicRow {
        case,
        scene: "walkers".into(),
        strategy: follower.strategy,
        engine: "gnurt",
        threads: 1,
        triangles: (options.characters * indices.len()) as u64,
        instances: options.characters as u64,
        update_ms_cpu: 1e3 * median(&follower.update),
        trace_mrays_cpu: rays.len() as f64 / 1e6 / median(&follower.trace).max(1e-9),
        bytes: Some(
            follower.bytes() + (poses.min(options.characters) * vertices * size_of::<[f32; 3]>()) as u64,
        ),
        hits: (0..rays.len()).filter(|&i| follower.hits.get(i).is_some()).count() as u64,
        rebuilds: follower.trees.iter().filter(|tree| !tree.is_posed()).count(),
    };
    Ok(followers.iter().map(row).collect())
}

/// The number of characters in a row.
fn columns(characters: usize) -> usize {
    (characters as f64).sqrt().ceil() as usize
}

/// Transforms of characters: in rows, each with its own rotation.
fn matrices(characters: usize) -> Vec<[[f64; 3]; 4]> {
    let mut random = Random::new(1);
    let columns = columns(characters);
    let matrix_of = |i: usize, angle: f32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(angle)).sin_cos();
        let at = [1.2 * (i % columns) as f64, 0.0, 1.2 * (i / columns) as f64];
        [[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos], at]
    };
    (0..characters).map(|i| matrix_of(i, random.unit())).collect()
}

/// Rays of a camera that sees all of them from one side.
fn rays(characters: usize, size: u32) -> RayBatch {
    let wide = 1.2 * columns(characters) as f32;
    let (eye, target) = ([0.5 * wide, 0.35 * wide + 2.0, -0.35 * wide - 2.0], [0.5 * wide, 0.0, 0.45 * wide]);
    let ahead = unit(minus(target, eye));
    let right = unit(cross(ahead, [0.0, 1.0, 0.0]));
    let up = cross(right, ahead);
    let ray = |i: u32| {
        // In squares of eight by eight, whose rays go together.
        let (square, within) = (i / 64, i % 64);
        let (x, y) = (square % (size / 8) * 8 + within % 8, square / (size / 8) * 8 + within / 8);
        let at = |pixel: u32| 1.2 * ((pixel as f32 + 0.5) / size as f32 - 0.5);
        let dir = [0, 1, 2].map(|k| ahead[k] + at(x) * right[k] - at(y) * up[k]);
        Ray::new(eye, dir)
    };
    let size = size / 8 * 8;
    (0..size * size).map(ray).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_hit_the_same() {
        assert_eq!((indices().len(), pose(0.0).len()), (5000, 2510), "a character");
        let options = Options { characters: 20, frames: 2, size: 64, level: Level::best() };
        for (case, poses) in [("crowd", 20), ("crowd64", 3)] {
            let rows = run(case, poses, &options).expect("they agree");
            let [instanced, separate] = &rows[..] else { panic!("{rows:?}") };
            assert!(instanced.hits == separate.hits && instanced.hits > 500, "{rows:?}");
            assert_eq!((instanced.rebuilds, separate.rebuilds), (0, 20), "{rows:?}");
            assert!(instanced.bytes < separate.bytes, "{rows:?}");
        }
    }
}
