// SPDX-License-Identifier: GPL-3.0-or-later
//! One step of paths that met Lambert's reflector, sixteen at a time: light found, a light asked, a direction chosen.
//! Source: as `integrators::path`, of which this is the fast form; lanes after the paper's section 8. Space: world.
//! Invariant: what `path` does with the vertices of such surfaces, bit for bit. Other lanes are only listed.
//! Proof: crates/render/tests/lanes.rs.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use gnurt_accel::INVALID_ID;
use gnurt_shading::Vec3s;
use gnurt_shading::lanes::{LANES, LanesOf, Mask, Vec3x16, floats, select3};
use gnurt_shading::point_lanes::{RayX16, above_x16, shadow_ray_x16};
use gnurt_shading::sampling::{DrawsX16, cosine_hemisphere_x16, key_words, purpose, to_world_x16};
use gnurt_simd::{Simd, prelude::*, u32x16};

use super::mis::weigh;
use super::paths::{Scattered, Wavefront, load_floats, load_vectors, load_words};
use super::{ROULETTE_FROM, SURVIVAL, add};
use crate::options::RenderOptions;
use crate::world::{FlatLanes, HitLanes, World};

/// What a step is taken in.
#[derive(Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    pub(crate) world: &'a World,
    pub(crate) options: &'a RenderOptions,
    /// What the rays of the paths hit.
    pub(crate) from: HitLanes<'a>,
    /// Whether nothing goes by lanes: all that hit something are listed.
    pub(crate) by_shader: bool,
}

/// What sixteen lanes hit, sorted.
struct Sorted<'w> {
    flat: FlatLanes<'w>,
    /// Lanes of it.
    lanes: u64,
    /// Those of them that shine, at least on the other side.
    shining: u64,
    albedo: [[f32; LANES]; 3],
}

/// Takes the step of all paths in `wavefront.paths` that met such surfaces; those that go on are in `wavefront.next`, and
/// light for them in `wavefront.unshadowed`. Lists the others.
#[inline(always)]
pub(crate) fn step<S: Simd>(simd: S, around: &Surroundings, wavefront: &mut Wavefront, radiance: &mut Vec3s) {
    let count = wavefront.paths.len();
    wavefront.missed.clear();
    wavefront.by_shader.clear();
    wavefront.next.begin(count);
    wavefront.unshadowed.begin(count);
    let mut sorted = Sorted::new();
    for first in (0..count).step_by(LANES) {
        sorted.sort(around, first, LANES.min(count - first), wavefront);
        if sorted.lanes != 0 {
            sixteen(simd, around, &sorted, first, wavefront, radiance);
        }
    }
    wavefront.next.end();
    wavefront.unshadowed.end();
}

/// Only lists all lanes, for CPUs on which lanes do not pay.
pub(crate) fn list(around: &Surroundings, wavefront: &mut Wavefront) {
    let (world, hits) = (around.world, around.from.hits);
    wavefront.missed.clear();
    wavefront.missed.extend((0..hits.len()).filter(|&lane| hits.prim_id[lane] == INVALID_ID));
    world.sort_by_material(hits, 0..hits.len(), &mut wavefront.by_shader);
    wavefront.next.begin(0);
    wavefront.next.end();
    wavefront.unshadowed.begin(0);
    wavefront.unshadowed.end();
}

impl<'w> Sorted<'w> {
    fn new() -> Self {
        Self { flat: FlatLanes::new(), lanes: 0, shining: 0, albedo: [[0.0; LANES]; 3] }
    }

    /// Looks at what the `count` lanes from `first` on hit.
    #[inline(always)]
    fn sort(&mut self, around: &Surroundings<'w>, first: usize, count: usize, wavefront: &mut Wavefront) {
        let (world, hits) = (around.world, around.from.hits);
        (self.lanes, self.shining) = (0, 0);
        let (mut last, mut mesh) = ([INVALID_ID; 2], None);
        for i in 0..count {
            let lane = first + i;
            let (prim_id, ids) = (hits.prim_id[lane], [hits.inst_id[lane], hits.geom_id[lane]]);
            if prim_id == INVALID_ID {
                wavefront.missed.push(lane);
                continue;
            }
            if last != ids {
                (last, mesh) = (ids, world.flat_mesh(ids[0], ids[1]).filter(|_| !around.by_shader));
            }
            let Some(flat) = mesh else {
                let material = world.material_of(ids[0], ids[1]);
                wavefront.by_shader.push(u64::from(material) << 32 | lane as u64);
                continue;
            };
            self.flat.put(i, flat, prim_id);
            self.lanes |= 1 << i;
            let look = flat.look;
            self.shining |= u64::from(look.emission.is_some()) << i;
            let albedo = match &look.albedo.texture {
                None => look.albedo.factor,
                Some(_) => look.albedo.at(flat.texcoord(prim_id, [hits.u[lane], hits.v[lane]])),
            };
            for k in 0..3 {
                self.albedo[k][i] = albedo[k];
            }
        }
    }
}

/// The step of the sixteen lanes from `first` on, as far as they are in `sorted`.
#[inline(always)]
fn sixteen<S: Simd>(
    simd: S,
    around: &Surroundings,
    sorted: &Sorted,
    first: usize,
    wavefront: &mut Wavefront,
    radiance: &mut Vec3s,
) {
    let (options, from, lights) = (around.options, around.from, around.world.light_set());
    let (zero, one) = (floats(simd, 0.0), floats(simd, 1.0));
    let [x, y, z] = &from.rays.dir;
    let ray_dir = load_vectors(simd, [x, y, z], first);
    let place = [load_floats(simd, &from.hits.u, first), load_floats(simd, &from.hits.v, first)];
    let point = sorted.flat.points(simd, sorted.lanes, place, ray_dir, from.epsilon);
    let shining = sorted.shining & point.front.to_bitmask();
    for i in LanesOf(shining) {
        found_light(around, sorted, (first + i, i), point.p.get(i), wavefront, radiance);
    }

    let paths = &wavefront.paths;
    let edges = load_words(simd, &paths.edges, first);
    let alive: Mask<S> = Mask::from_bitmask(simd, sorted.lanes);
    let alive = alive & edges.simd_lt(u32x16::splat(simd, options.max_depth));
    if !alive.any_true() {
        return;
    }
    let [r, g, b] = &sorted.albedo;
    let albedo = Vec3x16::load(simd, [r, g, b], 0);
    let Vec3s { x, y, z } = &paths.throughput;
    let throughput = load_vectors(simd, [x, y, z], first);
    let draws = DrawsX16::new(simd, options.seed, key_words(simd, &from.keys[first..]), edges);
    let origin = above_x16(point.p, point.normal, point.error);

    if !lights.is_empty() {
        let [x, y] = draws.pair(purpose::LIGHT_PLACE);
        let choice = draws.first(purpose::LIGHT_CHOICE);
        let light = lights.sample_x16(alive, point.p, point.normal, [choice, x, y]);
        let cos = point.normal.dot(light.dir);
        let value = albedo * (cos * FRAC_1_PI);
        let lit = light.found & cos.simd_gt(zero) & !value.is_zero() & !light.radiance.is_zero();
        if lit.any_true() {
            // As `power_heuristic`.
            let ratio = cos * FRAC_1_PI / light.pdf;
            let weight = one / (one + ratio * ratio);
            let weight = (light.delta | light.pdf.is_infinite()).select(one, weight);
            let arriving = light.radiance * (weight / light.pdf);
            let ray = shadow_ray_x16(point.p, origin, light.dir, light.dist, point.error);
            let light = (throughput * value * arriving, edges + 1);
            wavefront.unshadowed.push_lanes(lit, (paths, from.keys), first, &ray, light);
        }
    }

    let local = cosine_hemisphere_x16(draws.pair(purpose::DIRECTION));
    let pdf = local.z * FRAC_1_PI;
    let dir = to_world_x16(point.normal, local).normalize();
    let mut alive = alive & pdf.simd_gt(zero) & dir.is_finite() & point.normal.dot(dir).simd_gt(zero);
    let mut throughput = throughput * albedo;
    let short = edges.simd_lt(u32x16::splat(simd, ROULETTE_FROM));
    if !(short | !alive).all_true() {
        let keep = throughput.max_element().min(floats(simd, SURVIVAL));
        alive &= short | draws.second(purpose::CHOICE).simd_lt(keep);
        throughput = select3(short, throughput, throughput.over(keep));
    }
    alive &= throughput.is_finite() & !throughput.is_zero();
    let ray = RayX16 { org: origin, dir, t_far: floats(simd, f32::INFINITY) };
    let next = Scattered { ray, throughput, edges, p: point.p, ns: point.normal, pdf };
    wavefront.next.push_lanes(alive, (&wavefront.paths, from.keys), first, &next);
}

/// Takes the light of a lane whose ray met the front of something that shines, at `p`.
fn found_light(
    around: &Surroundings,
    sorted: &Sorted,
    (lane, i): (usize, usize),
    p: Vec3,
    wavefront: &Wavefront,
    radiance: &mut Vec3s,
) {
    let (hits, path) = (around.from.hits, wavefront.paths.get(lane, around.from.keys[lane]));
    let Some(flat) = sorted.flat.meshes[i] else { return };
    let Some(emission) = &flat.look.emission else { return };
    let place = [hits.u[lane], hits.v[lane]];
    let uv =
        if emission.texture.is_some() { flat.texcoord(sorted.flat.prim_ids[i], place) } else { [0.0; 2] };
    let found = emission.at(uv);
    if found == Vec3::ZERO {
        return;
    }
    let ids = [hits.inst_id[lane], hits.geom_id[lane], hits.prim_id[lane]];
    let dir = Vec3::from(around.from.rays.get(lane).dir);
    let weight = weigh(around.world.light_set(), &path, ids, p, dir);
    add(radiance, path.lane, path.throughput * (found * weight), path.edges, around.options.clamp);
}
