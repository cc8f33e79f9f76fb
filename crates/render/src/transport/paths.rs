// SPDX-License-Identifier: GPL-3.0-or-later
//! Many paths between two edges, as structures of arrays, and the light on its way to them.
//! Source: original; wavefronts after the paper's section 8. Space: world.
//! Invariant: all arrays have `len()` values, but between `begin` and `end`, when lanes are written in sixteens: then they
//! are longer, and `len()` says how many count. Memory stays from step to step.
//! Proof: crates/render/tests/{path,lanes}.rs.

use glam::Vec3;
use gnurt_accel::{HitBatch, Ray, RayBatch};
use gnurt_shading::lanes::{Floats, LANES, LanesOf, Mask, Vec3x16, Words};
use gnurt_shading::point_lanes::RayX16;
use gnurt_shading::{RayRequest, SampleKey, Vec3s};
use gnurt_simd::{Simd, prelude::*, u32x16};

/// A path that goes on.
pub(crate) struct Path {
    /// Whose radiance it brings.
    pub(crate) lane: u32,
    pub(crate) key: SampleKey,
    /// What light at its end is multiplied with.
    pub(crate) throughput: Vec3,
    /// Edges up to the next hit, that one included.
    pub(crate) edges: u32,
    /// Surfaces passed straight through since the last vertex.
    pub(crate) layers: u32,
    /// Where the ray was scattered; `None` where no light sample could have found what it meets.
    pub(crate) from: Option<Origin>,
}

/// Where a ray was scattered with a density.
#[derive(Clone, Copy)]
pub(crate) struct Origin {
    pub(crate) p: Vec3,
    /// The normal that lights were sampled for.
    pub(crate) ns: Vec3,
    /// Density of the ray's direction per solid angle.
    pub(crate) pdf: f32,
}

/// The density that stands for no origin.
const NOWHERE: f32 = -1.0;

/// Many of them.
#[derive(Default)]
pub(crate) struct Paths {
    count: usize,
    pub(crate) lane: Vec<u32>,
    keys: Vec<SampleKey>,
    pub(crate) throughput: Vec3s,
    pub(crate) edges: Vec<u32>,
    layers: Vec<u32>,
    from_p: Vec3s,
    from_ns: Vec3s,
    from_pdf: Vec<f32>,
    /// The next ray of each.
    rays: RayBatch,
}

/// Paths of sixteen lanes that go on from vertices, by one edge.
pub(crate) struct Scattered<S: Simd> {
    pub(crate) ray: RayX16<S>,
    pub(crate) throughput: Vec3x16<S>,
    /// Edges up to the vertices.
    pub(crate) edges: Words<S>,
    pub(crate) p: Vec3x16<S>,
    pub(crate) ns: Vec3x16<S>,
    pub(crate) pdf: Floats<S>,
}

impl Paths {
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Path `i`, whose key is lent out.
    pub(crate) fn get(&self, i: usize, key: SampleKey) -> Path {
        let pdf = self.from_pdf[i];
        Path {
            lane: self.lane[i],
            key,
            throughput: self.throughput.get(i),
            edges: self.edges[i],
            layers: self.layers[i],
            from: (pdf != NOWHERE).then(|| Origin { p: self.from_p.get(i), ns: self.from_ns.get(i), pdf }),
        }
    }

    /// One path for each of `n` camera rays; rays and keys are not in it.
    pub(crate) fn start(&mut self, n: usize) {
        self.count = n;
        self.lane.clear();
        self.lane.extend(0..n as u32);
        self.throughput.reset(n, Vec3::ONE);
        for (array, value) in [(&mut self.edges, 1), (&mut self.layers, 0)] {
            array.clear();
            array.resize(n, value);
        }
        self.from_p.resize(n);
        self.from_ns.resize(n);
        self.from_pdf.clear();
        self.from_pdf.resize(n, NOWHERE);
    }

    /// Lends out rays and keys, so that they can be read while a step is taken.
    pub(crate) fn lend(&mut self) -> (RayBatch, Vec<SampleKey>) {
        (std::mem::take(&mut self.rays), std::mem::take(&mut self.keys))
    }

    /// Takes their memory back.
    pub(crate) fn take_back(&mut self, rays: RayBatch, keys: Vec<SampleKey>) {
        (self.rays, self.keys) = (rays, keys);
    }

    /// Forgets all paths and makes room to write up to `n` of them in sixteens.
    pub(crate) fn begin(&mut self, n: usize) {
        self.count = 0;
        self.keys.clear();
        self.resize(n + LANES);
        self.rays.t_near.clear();
        self.rays.t_far.clear();
    }

    /// Ends writing in sixteens.
    pub(crate) fn end(&mut self) {
        self.resize(self.count);
        self.rays.t_near.resize(self.count, 0.0);
        self.rays.t_far.resize(self.count, f32::INFINITY);
    }

    fn resize(&mut self, n: usize) {
        let Self { lane, edges, layers, .. } = self;
        [lane, edges, layers].into_iter().for_each(|array| array.resize(n, 0));
        let Self { throughput, from_p, from_ns, .. } = self;
        [throughput, from_p, from_ns].into_iter().for_each(|array| array.resize(n));
        self.from_pdf.resize(n, 0.0);
        self.rays.org.iter_mut().chain(&mut self.rays.dir).for_each(|array| array.resize(n, 0.0));
    }

    /// Appends, between [`begin`](Self::begin) and [`end`](Self::end), the paths that are left in `alive` of those that
    /// were sixteen from `first` on.
    #[inline(always)]
    pub(crate) fn push_lanes<S: Simd>(
        &mut self,
        alive: Mask<S>,
        (before, keys): (&Self, &[SampleKey]),
        first: usize,
        next: &Scattered<S>,
    ) {
        let simd = next.pdf.token();
        let at = self.count;
        write_words(&mut self.lane, at, alive, load_words(simd, &before.lane, first));
        write_words(&mut self.edges, at, alive, next.edges + 1);
        write_words(&mut self.layers, at, alive, u32x16::splat(simd, 0));
        let (RayBatch { org, dir, .. }, Vec3s { x, y, z }) = (&mut self.rays, &mut self.throughput);
        write_vectors([x, y, z], at, alive, next.throughput);
        let Vec3s { x, y, z } = &mut self.from_p;
        write_vectors([x, y, z], at, alive, next.p);
        let Vec3s { x, y, z } = &mut self.from_ns;
        write_vectors([x, y, z], at, alive, next.ns);
        let [x, y, z] = org;
        write_vectors([x, y, z], at, alive, next.ray.org);
        let [x, y, z] = dir;
        write_vectors([x, y, z], at, alive, next.ray.dir);
        write_floats(&mut self.from_pdf, at, alive, next.pdf);
        let bits = alive.to_bitmask();
        for i in LanesOf(bits) {
            self.keys.push(keys[first + i]);
        }
        self.count += bits.count_ones() as usize;
    }

    /// Appends one.
    pub(crate) fn push(&mut self, path: Path, ray: Ray) {
        self.count += 1;
        self.lane.push(path.lane);
        self.keys.push(path.key);
        self.throughput.push(path.throughput);
        self.edges.push(path.edges);
        self.layers.push(path.layers);
        let from = path.from.unwrap_or(Origin { p: Vec3::ZERO, ns: Vec3::ZERO, pdf: NOWHERE });
        self.from_p.push(from.p);
        self.from_ns.push(from.ns);
        self.from_pdf.push(from.pdf);
        self.rays.push(ray);
    }
}

/// Light on its way to vertices, unless something is in between.
#[derive(Default)]
pub(crate) struct Unshadowed {
    /// The parents are whose radiance it is.
    pub(crate) request: RayRequest,
    /// Radiance per ray, at the eye.
    radiance: Vec3s,
    /// Edges up to the lamp.
    edges: Vec<u32>,
    count: usize,
}

impl Unshadowed {
    /// As [`Paths::begin`].
    pub(crate) fn begin(&mut self, n: usize) {
        self.count = 0;
        self.request.key.clear();
        self.resize(n + LANES);
        self.request.rays.t_near.clear();
    }

    /// As [`Paths::end`].
    pub(crate) fn end(&mut self) {
        self.resize(self.count);
        self.request.rays.t_near.resize(self.count, 0.0);
    }

    fn resize(&mut self, n: usize) {
        let Self { request: RayRequest { rays, parent, .. }, radiance, edges, .. } = self;
        [parent, edges].into_iter().for_each(|array| array.resize(n, 0));
        radiance.resize(n);
        let floats = rays.org.iter_mut().chain(&mut rays.dir).chain([&mut rays.t_far]);
        floats.for_each(|array| array.resize(n, 0.0));
    }

    /// As [`Paths::push_lanes`]: light over `edges` edges.
    #[inline(always)]
    pub(crate) fn push_lanes<S: Simd>(
        &mut self,
        lit: Mask<S>,
        (paths, keys): (&Paths, &[SampleKey]),
        first: usize,
        ray: &RayX16<S>,
        (radiance, edges): (Vec3x16<S>, Words<S>),
    ) {
        let at = self.count;
        let RayRequest { rays, parent, key, .. } = &mut self.request;
        write_words(parent, at, lit, load_words(edges.token(), &paths.lane, first));
        write_words(&mut self.edges, at, lit, edges);
        let Vec3s { x, y, z } = &mut self.radiance;
        write_vectors([x, y, z], at, lit, radiance);
        let [x, y, z] = &mut rays.org;
        write_vectors([x, y, z], at, lit, ray.org);
        let [x, y, z] = &mut rays.dir;
        write_vectors([x, y, z], at, lit, ray.dir);
        write_floats(&mut rays.t_far, at, lit, ray.t_far);
        let bits = lit.to_bitmask();
        for i in LanesOf(bits) {
            key.push(keys[first + i]);
        }
        self.count += bits.count_ones() as usize;
    }

    /// Appends light to the vertex at the end of a path.
    pub(crate) fn push(&mut self, path: &Path, ray: Ray, radiance: Vec3) {
        self.count += 1;
        self.request.rays.push(ray);
        self.request.parent.push(path.lane);
        self.request.key.push(path.key);
        self.radiance.push(radiance);
        self.edges.push(path.edges + 1);
    }

    /// Light `k`: whose radiance it is, how much and over how many edges.
    pub(crate) fn get(&self, k: usize) -> (u32, Vec3, u32) {
        (self.request.parent[k], self.radiance.get(k), self.edges[k])
    }
}

/// What a path tracer keeps from step to step, and from batch to batch.
#[derive(Default)]
pub(crate) struct Wavefront {
    pub(crate) paths: Paths,
    /// The same after the step.
    pub(crate) next: Paths,
    pub(crate) hits: HitBatch,
    pub(crate) unshadowed: Unshadowed,
    pub(crate) through: Vec3s,
    /// Lanes that hit nothing.
    pub(crate) missed: Vec<usize>,
    /// Lanes that go by batches of their shader: material in the upper half, lane in the lower one.
    pub(crate) by_shader: Vec<u64>,
    /// Lanes whose shader says what comes back from there, and not why.
    pub(crate) finals: Vec<usize>,
}

/// Writes the lanes of a set side by side, from place `at` on, and anything up to sixteen places beyond.
#[inline(always)]
fn write_words<S: Simd>(array: &mut [u32], at: usize, lanes: Mask<S>, words: Words<S>) {
    words.compress(lanes).store_slice(&mut array[at..at + LANES]);
}

#[inline(always)]
fn write_floats<S: Simd>(array: &mut [f32], at: usize, lanes: Mask<S>, floats: Floats<S>) {
    floats.compress(lanes).store_slice(&mut array[at..at + LANES]);
}

#[inline(always)]
fn write_vectors<S: Simd>([x, y, z]: [&mut [f32]; 3], at: usize, lanes: Mask<S>, vectors: Vec3x16<S>) {
    write_floats(x, at, lanes, vectors.x);
    write_floats(y, at, lanes, vectors.y);
    write_floats(z, at, lanes, vectors.z);
}

/// Sixteen words from place `at` on; zeros beyond the end.
#[inline(always)]
pub(crate) fn load_words<S: Simd>(simd: S, array: &[u32], at: usize) -> Words<S> {
    match array.get(at..at + LANES) {
        Some(part) => u32x16::from_slice(simd, part),
        None => u32x16::from_slice(simd, &padded(&array[at..])),
    }
}

/// Sixteen floats from place `at` on; zeros beyond the end.
#[inline(always)]
pub(crate) fn load_floats<S: Simd>(simd: S, array: &[f32], at: usize) -> Floats<S> {
    match array.get(at..at + LANES) {
        Some(part) => Floats::from_slice(simd, part),
        None => Floats::from_slice(simd, &padded(&array[at..])),
    }
}

/// The last lanes of an array, and zeros.
fn padded<T: Copy + Default>(rest: &[T]) -> [T; LANES] {
    std::array::from_fn(|i| rest.get(i).copied().unwrap_or_default())
}

/// Sixteen vectors from place `at` on; zeros beyond the end.
#[inline(always)]
pub(crate) fn load_vectors<S: Simd>(simd: S, [x, y, z]: [&[f32]; 3], at: usize) -> Vec3x16<S> {
    Vec3x16::new(load_floats(simd, x, at), load_floats(simd, y, at), load_floats(simd, z, at))
}
