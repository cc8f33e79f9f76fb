// SPDX-License-Identifier: GPL-3.0-or-later
//! Many paths between two edges, as structures of arrays, and the light on them.
//! Source: wavefronts after the paper's section 8. Space: world.
//! Invariant: all arrays have `len()` values, except between `begin` and `end`, while they are written: then
//! they are longer, and only `len()` of them count. Memory stays from step to step.
//! Tests: crates/render/tests/{path,lanes}.rs.

use glam::Vec3;
use gnurt_accel::{HitBatch, Ray, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::lanes::{LANES, LanesOf};
use gnurt_shading::real::{Real, Vector};
use gnurt_shading::{Bounces, RayKind, RayRequest, Rays, SampleKey, Vec3s};

use super::below::Walks;
use super::links::LinkedPaths;
use super::manifold::Chain;
use super::medium_vertices::MediumVertices;
use super::through::Through;
use crate::cone::{Cone, Cones};
use crate::expressions::Ledger;
use crate::guide::Recorder;
use crate::seen::{MANY, SeenLight};
use crate::world::{Inside, Media};

/// A continuing path.
pub(crate) struct Path {
    /// Whose radiance it brings.
    pub(crate) lane: u32,
    pub(crate) key: SampleKey,
    /// Factor of light at its end.
    pub(crate) throughput: Vec3,
    /// Edges up to the next hit, that one included.
    pub(crate) edges: u32,
    /// Surfaces passed straight through since the last vertex.
    pub(crate) layers: u32,
    /// The origin of the scattered ray; `None` if no light sample could have found its hit.
    pub(crate) from: Option<Origin>,
    /// Where it was scattered in any case, and how much is absorbed there along it: meant if paths have media.
    pub(crate) start: Vec3,
    pub(crate) absorption: Vec3,
    /// The bodies that its ray is in.
    pub(crate) inside: Inside,
    /// Scatterings after those of the smooth surfaces that it begins with, up to [`MANY`].
    pub(crate) scattered: u8,
    /// The trail that a recorder keeps of it, and the factor by which roulette spares it: meant if paths are guided.
    pub(crate) trail: u32,
    pub(crate) spared: f32,
    /// Smooth surfaces since it was scattered.
    pub(crate) chain: Chain,
}

impl Path {
    /// Whether it is a camera ray, or goes straight on from one.
    pub(crate) fn is_straight(&self) -> bool {
        is_straight(self.edges)
    }
}

/// Whether a path with this number of edges, up to its next hit, goes straight on from the camera.
fn is_straight(edges: u32) -> bool {
    edges == 1
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

/// The density that represents no origin.
pub(crate) const NOWHERE: f32 = -1.0;

/// Many of them.
#[derive(Default)]
pub(crate) struct Paths {
    count: usize,
    /// How long all arrays are at least.
    capacity: usize,
    pub(crate) lane: Vec<u32>,
    keys: Vec<SampleKey>,
    pub(crate) throughput: Vec3s,
    pub(crate) edges: Vec<u32>,
    layers: Vec<u32>,
    scattered: Vec<u8>,
    from_p: Vec3s,
    from_ns: Vec3s,
    from_pdf: Vec<f32>,
    /// How much is absorbed along the ray where it was scattered; empty if nothing is anywhere.
    absorption: Vec3s,
    has_media: bool,
    /// The bodies that each ray is in; empty if no body has a medium that paths fly through.
    inside: Vec<Inside>,
    has_bodies: bool,
    /// The trail of each, and the density of its directions over that of lobes; empty if none is guided.
    pub(crate) trail: Vec<u32>,
    pub(crate) spared: Vec<f32>,
    is_guided: bool,
    /// Smooth surfaces since each was scattered; empty if none searches.
    pub(crate) chain: Vec<Chain>,
    has_chains: bool,
    /// The next ray of each.
    rays: RayBatch,
    cones: Cones,
}

/// Paths that continue from the points of one step.
pub(crate) struct Scattered<R> {
    pub(crate) ray: Rays<R>,
    pub(crate) throughput: Vector<R>,
    pub(crate) p: Vector<R>,
    pub(crate) ns: Vector<R>,
    /// [`NOWHERE`] if no light sample could have found the ray's hit.
    pub(crate) pdf: R,
    /// Absorption along the rays at their origins; used if paths have media.
    pub(crate) absorption: Vector<R>,
    /// The rays' cones: initial width and spread; `None` if they are not needed.
    pub(crate) cone: Option<[R; 2]>,
    /// The kinds of the rays, as bits: delta, transmitted, diffuse.
    pub(crate) how: [u64; 3],
    /// Rays that show what smooth surfaces show, as bits.
    pub(crate) seen: u64,
    /// The boundary that rays may go through.
    pub(crate) boundary: Option<Boundary>,
}

/// The surface of a body with a medium, at some points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boundary {
    pub(crate) medium: u16,
    /// Points that the path came to from outside, as bits.
    pub(crate) fronts: u64,
}

impl Boundary {
    /// The bodies that a ray is in behind point `i`, or before.
    fn after(boundary: Option<Self>, inside: Inside, i: usize, transmitted: bool) -> Inside {
        match boundary.filter(|_| transmitted) {
            Some(Self { medium, fronts }) => inside.crossing(medium, fronts >> i & 1 != 0),
            None => inside,
        }
    }
}

/// Which paths some points belong to.
#[derive(Clone, Copy)]
pub(crate) struct Of<'a> {
    pub(crate) paths: &'a Paths,
    pub(crate) keys: &'a [SampleKey],
    /// Those of their rays; `None` = counts of bounces start again.
    pub(crate) cones: Option<&'a Cones>,
    /// Numbers of paths, one for each point.
    pub(crate) numbers: &'a [u32],
}

impl Of<'_> {
    /// The factors by which roulette spares the paths of the points; 1 beyond them.
    #[inline(always)]
    pub(super) fn spared<R: Real>(&self, like: R) -> R {
        like.each(
            #[inline(always)]
            |i| self.numbers.get(i).map_or(1.0, |&number| self.paths.spared_of(number as usize)),
        )
    }
}

impl Paths {
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
            start: self.from_p.get(i),
            absorption: if self.has_media { self.absorption.get(i) } else { Vec3::ZERO },
            inside: self.inside_of(i),
            scattered: self.scattered[i],
            trail: self.trail_of(i),
            spared: self.spared_of(i),
            chain: self.chain_of(i),
            from: (pdf != NOWHERE).then(|| Origin { p: self.from_p.get(i), ns: self.from_ns.get(i), pdf }),
        }
    }

    /// The bodies that path `i` is in.
    fn inside_of(&self, i: usize) -> Inside {
        if self.has_bodies { self.inside[i] } else { Inside::default() }
    }

    /// Sets whether paths note the bodies that they are in.
    pub(crate) fn set_bodies(&mut self, has_bodies: bool) {
        self.has_bodies = has_bodies;
        self.capacity = 0;
    }

    /// Sets the bodies that camera rays begin in.
    pub(crate) fn begin_inside(&mut self, inside: Vec<Inside>) {
        if self.has_bodies {
            self.inside = inside;
        }
    }

    /// Whether light is absorbed anywhere between surfaces.
    pub(crate) fn has_media(&self) -> bool {
        self.has_media
    }

    /// Sets whether they do.
    pub(crate) fn set_media(&mut self, has_media: bool) {
        self.has_media = has_media;
        self.absorption.resize(0);
        self.capacity = 0;
    }

    /// Sets whether they are guided.
    pub(crate) fn set_guided(&mut self, is_guided: bool) {
        self.is_guided = is_guided;
        self.capacity = 0;
    }

    /// Sets whether smooth surfaces on their way are counted.
    pub(crate) fn set_chains(&mut self, has_chains: bool) {
        self.has_chains = has_chains;
        self.capacity = 0;
    }

    /// The smooth surfaces on path `i`.
    pub(crate) fn chain_of(&self, i: usize) -> Chain {
        if self.has_chains { self.chain[i] } else { Chain::default() }
    }

    /// The trail of path `i`.
    pub(crate) fn trail_of(&self, i: usize) -> u32 {
        if self.is_guided { self.trail[i] } else { 0 }
    }

    /// The factor by which roulette spares path `i`.
    pub(crate) fn spared_of(&self, i: usize) -> f32 {
        if self.is_guided { self.spared[i] } else { 1.0 }
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// One path for each camera ray; rays, keys and cones are not in it.
    pub(crate) fn start(&mut self, rays: &RayBatch) {
        let n = rays.len();
        (self.count, self.capacity) = (n, 0);
        self.lane.clear();
        self.lane.extend(0..n as u32);
        self.throughput.reset(n, Vec3::ONE);
        for (array, value) in [(&mut self.edges, 1), (&mut self.layers, 0)] {
            array.clear();
            array.resize(n, value);
        }
        self.scattered.clear();
        self.scattered.resize(n, 0);
        self.from_p.resize(n);
        self.from_ns.resize(n);
        self.from_pdf.clear();
        self.from_pdf.resize(n, NOWHERE);
        if self.has_media {
            (0..n).for_each(|i| self.from_p.set(i, Vec3::from(rays.get(i).org)));
            self.absorption.reset(n, Vec3::ZERO);
        }
        if self.is_guided {
            self.trail.clear();
            self.trail.resize(n, 0);
            self.spared.clear();
            self.spared.resize(n, 1.0);
        }
        if self.has_chains {
            self.chain.clear();
            self.chain.resize(n, Chain::default());
        }
    }

    /// Applies absorption to path `i`.
    pub(crate) fn dim(&mut self, i: usize, left: Vec3) {
        self.throughput.set(i, self.throughput.get(i) * left);
    }

    /// Sets the factor of light at the end of path `i`.
    pub(crate) fn set_throughput(&mut self, i: usize, throughput: Vec3) {
        self.throughput.set(i, throughput);
    }

    /// Lends out rays, keys and cones, so that they can be read while a step is taken.
    pub(crate) fn lend(&mut self) -> (RayBatch, Vec<SampleKey>, Cones) {
        let Self { rays, keys, cones, .. } = self;
        (std::mem::take(rays), std::mem::take(keys), std::mem::take(cones))
    }

    /// Whether some go straight on from camera rays.
    pub(crate) fn has_straight(&self) -> bool {
        self.edges[..self.count].iter().any(|&edges| is_straight(edges))
    }

    /// Writes which instances rays meet: those that are straight meet what camera rays do.
    pub(crate) fn set_kinds(&self, rays: &mut RayBatch) {
        let kind_of = |&edges: &u32| if is_straight(edges) { RayMask::CAMERA.0 } else { RayMask::OTHER.0 };
        rays.mask.clear();
        rays.mask.extend(self.edges[..rays.len()].iter().map(kind_of));
    }

    /// Takes their memory back.
    pub(crate) fn take_back(&mut self, (rays, keys, cones): (RayBatch, Vec<SampleKey>, Cones)) {
        (self.rays, self.keys, self.cones) = (rays, keys, cones);
    }

    /// Drops all paths.
    pub(crate) fn begin(&mut self) {
        self.count = 0;
        self.keys.clear();
    }

    /// Reserves memory for `more` paths, plus the lanes of one write.
    pub(crate) fn reserve(&mut self, more: usize) {
        // Longer is as good, and need not be cleared.
        if self.capacity < self.count + more + LANES {
            self.resize(self.count + more + LANES);
        }
    }

    /// Ends writing.
    pub(crate) fn end(&mut self) {
        self.resize(self.count);
        self.rays.t_near.clear();
        self.rays.t_near.resize(self.count, 0.0);
        self.rays.t_far.clear();
        self.rays.t_far.resize(self.count, f32::INFINITY);
    }

    fn resize(&mut self, n: usize) {
        self.capacity = n;
        let Self { lane, edges, layers, .. } = self;
        [lane, edges, layers].into_iter().for_each(|array| array.resize(n, 0));
        let Self { throughput, from_p, from_ns, .. } = self;
        [throughput, from_p, from_ns].into_iter().for_each(|array| array.resize(n));
        self.from_pdf.resize(n, 0.0);
        self.scattered.resize(n, 0);
        if self.has_media {
            self.absorption.resize(n);
        }
        if self.has_bodies {
            self.inside.resize(n, Inside::default());
        }
        if self.is_guided {
            self.trail.resize(n, 0);
            self.spared.resize(n, 1.0);
        }
        if self.has_chains {
            self.chain.resize(n, Chain::default());
        }
        self.cones.resize(n);
        self.rays.org.iter_mut().chain(&mut self.rays.dir).for_each(|array| array.resize(n, 0.0));
    }

    /// Appends the paths of the points in `alive`, one edge longer; there must be space.
    #[inline(always)]
    pub(crate) fn push_all<R: Real>(&mut self, alive: R::Mask, of: Of, next: &Scattered<R>) {
        let at = self.count;
        let (RayBatch { org, dir, .. }, Vec3s { x, y, z }) = (&mut self.rays, &mut self.throughput);
        next.throughput.squeeze(alive, [x, y, z], at);
        let Vec3s { x, y, z } = &mut self.from_p;
        next.p.squeeze(alive, [x, y, z], at);
        let Vec3s { x, y, z } = &mut self.from_ns;
        next.ns.squeeze(alive, [x, y, z], at);
        let [x, y, z] = org;
        next.ray.org.squeeze(alive, [x, y, z], at);
        let [x, y, z] = dir;
        next.ray.dir.squeeze(alive, [x, y, z], at);
        next.pdf.squeeze(alive, &mut self.from_pdf, at);
        if self.has_media {
            let Vec3s { x, y, z } = &mut self.absorption;
            next.absorption.squeeze(alive, [x, y, z], at);
        }
        if let Some([width, spread]) = next.cone {
            width.squeeze(alive, &mut self.cones.width, at);
            spread.squeeze(alive, &mut self.cones.spread, at);
        }
        for i in LanesOf(R::bits(alive)) {
            let number = of.numbers[i] as usize;
            self.lane[self.count] = of.paths.lane[number];
            self.edges[self.count] = of.paths.edges[number] + 1;
            self.layers[self.count] = 0;
            let before = of.paths.scattered[number];
            let stays = before == 0 && next.seen >> i & 1 != 0;
            self.scattered[self.count] = if stays { 0 } else { (before + 1).min(MANY) };
            if self.has_bodies {
                let inside = of.paths.inside_of(number);
                let transmitted = next.how[1] >> i & 1 != 0;
                self.inside[self.count] = Boundary::after(next.boundary, inside, i, transmitted);
            }
            if self.is_guided {
                self.trail[self.count] = of.paths.trail_of(number);
                self.spared[self.count] = of.paths.spared_of(number);
            }
            if self.has_chains {
                self.chain[self.count] = of.paths.chain_of(number).lost();
            }
            let [delta, transmitted, wide] = next.how.map(|bits| bits >> i & 1 != 0);
            let kind = RayKind::of(delta, transmitted, wide);
            self.cones.kind[self.count] = kind;
            self.cones.bounces[self.count] =
                of.cones.map_or_else(Bounces::default, |cones| cones.get(number).bounces).and(kind);
            self.keys.push(of.keys[number]);
            self.count += 1;
        }
    }

    /// Appends one; there must be space.
    pub(crate) fn push(&mut self, path: Path, (ray, cone): (Ray, Cone)) {
        let at = self.count;
        self.count += 1;
        (self.lane[at], self.edges[at], self.layers[at]) = (path.lane, path.edges, path.layers);
        self.scattered[at] = path.scattered;
        self.keys.push(path.key);
        self.throughput.set(at, path.throughput);
        let from = path.from.unwrap_or(Origin { p: Vec3::ZERO, ns: Vec3::ZERO, pdf: NOWHERE });
        self.from_p.set(at, path.start);
        if self.has_media {
            self.absorption.set(at, path.absorption);
        }
        if self.has_bodies {
            self.inside[at] = path.inside;
        }
        if self.is_guided {
            (self.trail[at], self.spared[at]) = (path.trail, path.spared);
        }
        if self.has_chains {
            self.chain[at] = path.chain;
        }
        self.from_ns.set(at, from.ns);
        self.from_pdf[at] = from.pdf;
        self.cones.set(at, cone);
        for k in 0..3 {
            (self.rays.org[k][at], self.rays.dir[k][at]) = (ray.org[k], ray.dir[k]);
        }
    }
}

/// Light towards vertices, unless it is occluded.
#[derive(Default)]
pub(crate) struct Unshadowed {
    /// The parents are whose radiance it is.
    pub(crate) request: RayRequest,
    /// Radiance per ray, at the eye.
    radiance: Vec3s,
    /// Edges up to the light.
    edges: Vec<u32>,
    /// As [`Path::scattered`], and the scattering at the vertex.
    scattered: Vec<u8>,
    /// Whether it is a delta light, and the ray begins outside of absorbing media: such lights are searched
    /// for through glass.
    is_delta: Vec<bool>,
    /// The bodies that each ray begins in.
    inside: Vec<Inside>,
    /// The trails of their paths.
    trail: Vec<u32>,
    count: usize,
}

impl Unshadowed {
    /// As [`Paths::begin`].
    pub(crate) fn begin(&mut self) {
        self.count = 0;
        self.request.key.clear();
    }

    /// As [`Paths::reserve`].
    pub(crate) fn reserve(&mut self, more: usize) {
        if self.edges.len() < self.count + more + LANES {
            self.resize(self.count + more + LANES);
        }
    }

    /// As [`Paths::end`].
    pub(crate) fn end(&mut self) {
        self.resize(self.count);
        self.request.rays.t_near.clear();
        self.request.rays.t_near.resize(self.count, 0.0);
    }

    fn resize(&mut self, n: usize) {
        let Self {
            request: RayRequest { rays, parent, .. },
            radiance,
            edges,
            scattered,
            is_delta,
            inside,
            trail,
            ..
        } = self;
        [parent, edges, trail].into_iter().for_each(|array| array.resize(n, 0));
        is_delta.resize(n, false);
        scattered.resize(n, 0);
        inside.resize(n, Inside::default());
        radiance.resize(n);
        let floats = rays.org.iter_mut().chain(&mut rays.dir).chain([&mut rays.t_far]);
        floats.for_each(|array| array.resize(n, 0.0));
    }

    /// As [`Paths::push_all`]: light at the eye; `delta_requests` are those whose lights are searched for
    /// through glass; `through`: the boundary that some rays go through, and which do, as bits.
    #[inline(always)]
    pub(crate) fn push_all<R: Real>(
        &mut self,
        [lit, delta_requests]: [R::Mask; 2],
        of: Of,
        ray: &Rays<R>,
        light: Vector<R>,
        through: Option<(Boundary, u64)>,
    ) {
        let at = self.count;
        let RayRequest { rays, parent, key, .. } = &mut self.request;
        let Vec3s { x, y, z } = &mut self.radiance;
        light.squeeze(lit, [x, y, z], at);
        let [x, y, z] = &mut rays.org;
        ray.org.squeeze(lit, [x, y, z], at);
        let [x, y, z] = &mut rays.dir;
        ray.dir.squeeze(lit, [x, y, z], at);
        ray.t_far.squeeze(lit, &mut rays.t_far, at);
        for i in LanesOf(R::bits(lit)) {
            let number = of.numbers[i] as usize;
            parent[self.count] = of.paths.lane[number];
            self.edges[self.count] = of.paths.edges[number] + 1;
            self.scattered[self.count] = of.paths.scattered[number] + 1;
            self.trail[self.count] = of.paths.trail_of(number);
            self.is_delta[self.count] = R::bits(delta_requests) >> i & 1 != 0;
            let (boundary, transmitted) =
                (through.map(|(boundary, _)| boundary), through.map_or(0, |(_, t)| t));
            let inside = of.paths.inside_of(number);
            self.inside[self.count] = Boundary::after(boundary, inside, i, transmitted >> i & 1 != 0);
            key.push(of.keys[number]);
            self.count += 1;
        }
    }

    /// Appends light to the vertex at the end of a path; there must be space. `is_delta`: whether its light
    /// is searched for through glass. The ray begins in the bodies of `path`.
    pub(crate) fn push(&mut self, path: &Path, ray: Ray, radiance: Vec3, is_delta: bool) {
        let at = self.count;
        self.count += 1;
        let RayRequest { rays, parent, key, .. } = &mut self.request;
        for k in 0..3 {
            (rays.org[k][at], rays.dir[k][at]) = (ray.org[k], ray.dir[k]);
        }
        (rays.t_far[at], parent[at], self.edges[at]) = (ray.t_far, path.lane, path.edges + 1);
        key.push(path.key);
        self.radiance.set(at, radiance);
        self.is_delta[at] = is_delta;
        self.scattered[at] = path.scattered + 1;
        self.trail[at] = path.trail;
        self.inside[at] = path.inside;
    }

    /// Those whose lights are searched for through glass, edges up to there, and the bodies that rays begin in.
    pub(crate) fn delta_requests(&self) -> impl Iterator<Item = (usize, u32, Inside)> {
        (0..self.count).filter(|&k| self.is_delta[k]).map(|k| (k, self.edges[k], self.inside[k]))
    }

    /// The media along the rays; `None` if there are none.
    pub(crate) fn through<'a>(&'a self, media: &'a Media) -> Option<Through<'a>> {
        let (inside, edges) = (&self.inside[..], &self.edges[..]);
        (!media.is_empty()).then_some(Through { media, inside, edges })
    }

    /// The trail of the path of light `k`.
    pub(crate) fn trail_of(&self, k: usize) -> u32 {
        self.trail[k]
    }

    /// Scatterings and edges of the path of light `k`, as [`SeenLight::add`] takes them.
    pub(crate) fn way_of(&self, k: usize) -> (u8, u32) {
        (self.scattered[k], self.edges[k])
    }

    /// Light `k`: whose radiance it is, how much and over how many edges.
    pub(crate) fn get(&self, k: usize) -> (u32, Vec3, u32) {
        (self.request.parent[k], self.radiance.get(k), self.edges[k])
    }
}

/// State that a path tracer keeps from step to step, and from batch to batch.
#[derive(Default)]
pub(crate) struct Wavefront {
    pub(crate) paths: Paths,
    /// The same after the step.
    pub(crate) next: Paths,
    pub(crate) hits: HitBatch,
    pub(crate) unshadowed: Unshadowed,
    pub(crate) through: Vec3s,
    /// Paths in order of the materials that they met: material in the upper half, number in the lower one.
    pub(crate) order: Vec<u64>,
    /// Lanes whose shader only returns radiance.
    pub(crate) radiance_only: Vec<u32>,
    pub(crate) closures: ClosureBatch,
    pub(crate) in_media: MediumVertices,
    /// Places in media where paths only take light of near lamps.
    pub(crate) near_lamps: MediumVertices,
    pub(crate) below: Walks,
    /// The accounts of layers of light, if some are requested.
    pub(crate) ledger: Option<Ledger>,
    /// Where paths were scattered, if some lights do not reach everything.
    pub(crate) linked: Option<LinkedPaths>,
    /// Notes vertices of paths for a guide, if one is learned.
    pub(crate) recorder: Option<Recorder>,
    /// Light by scatterings, for the layers of denoisers.
    pub(crate) seen: SeenLight,
}
