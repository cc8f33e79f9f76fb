// SPDX-License-Identifier: GPL-3.0-or-later
//! One step of paths that hit surfaces of one shader, as many at a time as the CPU's registers hold: add
//! emission, sample a light, choose a direction.
//! Source: as `integrators::path`. Space: world.
//! Invariant: the result of a path depends on its ray and key only, independent of the other paths and of the
//! number of lanes.
//! Tests: crates/render/tests/{lanes,path,agreement}.rs.

use glam::Vec3;
use gnurt_shading::bsdf::{ClosureBatch, Prepared, Sampled, left_after};
use gnurt_shading::lanes::{LANES, LanesOf};
use gnurt_shading::lights::{LightId, LightSet};
use gnurt_shading::real::{Real, Vector};
use gnurt_shading::sampling::purpose;
use gnurt_shading::{Bounces, Leaving, RayKind, SurfaceBatch, Vec3s};

use super::links::LinkedPaths;
use super::manifold::{self, Caustics, Chain, SmoothPoint};
use super::mis::{most_light_samples, power_heuristic, unguided_share, weigh};
use super::paths::{Boundary, NOWHERE, Of, Path, Paths, Scattered, Unshadowed};
use super::width::{LightRequests, Width, for_each_light_sample};
use super::{add, opacity, roulette};
use crate::cone::{ConeHit, fineness};
use crate::expressions::{Ledger, Lobe, Scatter};
use crate::guide::{self, Guide, Mixture, Recorder};
use crate::held::Held;
use crate::options::RenderOptions;
use crate::pixel_order::PixelOrder;
use crate::seen::SeenLight;
use crate::space_tree::class_of;
use crate::world::{HitLanes, World};

/// Paths that met one shader.
#[derive(Clone, Copy)]
pub(crate) struct Met<'a> {
    pub(crate) world: &'a World,
    pub(crate) options: &'a RenderOptions,
    pub(crate) pixel_order: PixelOrder,
    /// The hits of all paths' rays.
    pub(crate) from: HitLanes<'a>,
    pub(crate) paths: &'a Paths,
    /// Numbers of the paths that hit it.
    pub(crate) numbers: &'a [u32],
    /// The points and their closures.
    pub(crate) points: &'a SurfaceBatch,
    pub(crate) closures: &'a ClosureBatch,
    /// The radiance of a shadow catcher under all light of the environment, if it is one.
    pub(crate) backdrop: Option<Vec3>,
    /// Whether its emission is all that is known of its radiance: paths end here.
    pub(crate) is_final: bool,
    /// The medium behind the surface, or 0.
    pub(crate) medium: u16,
    /// By point: the factor of paths that its lobes scatter, if some paths enter the surface; else empty.
    pub(crate) shares: &'a [f32],
    /// Where light comes from, if paths are guided.
    pub(crate) guide: Option<&'a Guide>,
    /// Smooth surfaces and lamps of searches, if points make them.
    pub(crate) caustics: Option<&'a Caustics>,
}

/// Where the step leads.
pub(crate) struct Onward<'a> {
    pub(crate) next: &'a mut Paths,
    pub(crate) unshadowed: &'a mut Unshadowed,
    pub(crate) radiance: &'a mut Vec3s,
    /// Notes the same for layers of light.
    pub(crate) ledger: Option<&'a mut Ledger>,
    /// Notes where paths were scattered, if some lights do not reach everything.
    pub(crate) linked: Option<&'a mut LinkedPaths>,
    /// Notes vertices for a guide, if one is learned.
    pub(crate) recorder: Option<&'a mut Recorder>,
    /// Light by scatterings for the layers of denoisers, if they are requested.
    pub(crate) seen: Option<&'a mut SeenLight>,
    /// What lanes of the camera see of holes, if the world has holdouts.
    pub(crate) held: Option<&'a mut Vec<Held>>,
}

impl Met<'_> {
    /// The path at point `k`.
    pub(crate) fn path(&self, k: usize) -> Path {
        let number = self.numbers[k] as usize;
        self.paths.get(number, self.from.keys[number])
    }

    /// Whether the path at point `k` hits the surface; else it passes through.
    pub(crate) fn is_there(&self, k: usize, path: &Path) -> bool {
        opacity::is_met(self.options.seed, path.key, path.edges, self.closures.coverage(k))
    }

    /// Continues the path at point `k` straight through.
    fn pass(&self, k: usize, onward: &mut Onward) {
        let mut path = self.path(k);
        path.layers += 1;
        if self.medium != 0 {
            path.inside = path.inside.crossing(self.medium, self.points.front(k));
        }
        path.key = opacity::key_beyond(path.key);
        path.throughput *= self.closures.passing(k);
        if path.layers <= opacity::MOST_LAYERS {
            let ray = self.points.spawn(k, self.points.ray_dir.get(k), f32::INFINITY);
            onward.next.push(path, (ray, ConeHit::of(self.points, k).straight()));
            if let Some(ledger) = &mut onward.ledger {
                ledger.pass(self.numbers[k] as usize);
            }
            if let Some(linked) = &mut onward.linked {
                linked.pass(self.numbers[k] as usize);
            }
        }
    }

    /// Whether the path at point `k` comes straight from the camera and sees an instance that is a hole, which it may
    /// pass. Holes by closures take coverage only.
    fn is_held_out(&self, k: usize, passes: bool, onward: &mut Onward) -> bool {
        let path = self.path(k);
        let is_one = is_hole(self.world, path.edges, self.points.inst_id[k]);
        let share = if path.edges == 1 { self.closures.held_out(k) } else { 0.0 };
        if (is_one || share > 0.0)
            && !passes
            && let Some(held) = onward.held.as_mut().and_then(|held| held.get_mut(path.lane as usize))
        {
            *held = if is_one { Held::ALL } else { Held { share, is_dark: false } };
        }
        is_one
    }

    /// Where the path at point `k` left its last vertex.
    fn left(&self, k: usize) -> Vec3 {
        let path = self.path(k);
        // Rays beyond transparent parts begin there.
        if path.layers > 0 { path.start } else { self.from.rays.get(self.numbers[k] as usize).org.into() }
    }

    /// The weight of the lamp at point `k` that searches may find, too.
    fn beside_searches(&self, lights: &LightSet, path: &Path, k: usize) -> f32 {
        let Some(caustics) = self.caustics else { return 1.0 };
        let edge = (self.left(k), self.points.p.get(k), self.points.ray_dir.get(k));
        path.chain.beside_searches((lights, caustics), self.ids(k), edge)
    }

    /// The part of light from point `k` that counts: of points that stop no path for sure, and of media before those that the path passes.
    fn part_of_light(&self, k: usize, passes: bool) -> Vec3 {
        let part = Vec3::splat(self.closures.coverage(k));
        if !(passes && self.paths.has_media()) {
            return part;
        }
        // Paths that are stopped were dimmed as a whole.
        let path = self.path(k);
        let dist = (self.points.p.get(k) - path.start).length();
        part * left_after(dist, [path.absorption, self.closures.medium(k).on(true)])
    }

    /// Whether the path at point `k` sees a hole there.
    pub(crate) fn is_hidden(&self, k: usize, path: &Path) -> bool {
        is_hole(self.world, path.edges, self.points.inst_id[k])
    }

    /// The smooth surfaces on a path that goes on from point `k` to `wi`: by a delta lobe, or with this density of its direction.
    fn chain(&self, k: usize, (wi, transmitted): (Vec3, bool), density: Option<f32>) -> Chain {
        let Some(caustics) = self.caustics else { return Chain::default() };
        let number = self.numbers[k] as usize;
        let before = self.paths.chain_of(number);
        match density {
            Some(density) => {
                let throughput = self.paths.throughput.get(number);
                before.rough(density, before.chance(caustics, throughput, &self.points.point(k)))
            }
            None => {
                let at = SmoothPoint::of((self.world, caustics), (self.points, self.closures), k);
                let from = (self.left(k), self.points.ray_dir.get(k));
                manifold::turned(at.as_ref(), from, (wi, transmitted), before)
            }
        }
    }

    /// Whether light is absorbed between surfaces by the rule of the ends, not by media that paths fly through.
    pub(crate) fn absorbs(&self) -> bool {
        self.closures.has_media() && self.paths.has_media()
    }

    /// The boundary of a medium, if the surface is one, at the points from `first` on.
    fn boundary(&self, first: usize, count: usize) -> Option<Boundary> {
        (self.medium != 0).then(|| {
            let front = |i: &usize| first + i < self.numbers.len() && self.points.front(first + i);
            let fronts = (0..count).filter(front).fold(0, |bits, i| bits | 1 << i);
            Boundary { medium: self.medium, fronts }
        })
    }

    /// How much is absorbed along rays that leave the points from `first` on that are in a mask, through the surface or not.
    #[inline(always)]
    fn absorption<R: Real>(&self, first: usize, leaving: R::Mask, through: R::Mask, zero: R) -> Vector<R> {
        let black = Vector::grey(zero);
        if !self.absorbs() {
            return black;
        }
        let through = R::bits(through);
        black.each_colour(
            leaving,
            #[inline(always)]
            |i, _| self.closures.medium(first + i).on(through >> i & 1 == 0),
        )
    }

    /// Transmittance over this distance at the lit points from `first` on, through the surface or not.
    #[inline(always)]
    fn dimmed<R: Real>(
        &self,
        first: usize,
        lit: R::Mask,
        (light, through): (Vector<R>, R::Mask),
        dist: R,
    ) -> Vector<R> {
        if !self.absorbs() {
            return light;
        }
        let through = R::bits(through);
        light.each_colour(
            lit,
            #[inline(always)]
            |i, light| {
                let here = self.closures.medium(first + i).on(through >> i & 1 == 0);
                light * left_after(dist.lane(i), [here, Vec3::ZERO])
            },
        )
    }

    /// Adds the emission of the surface and, if it stops the path, the background behind it.
    fn take_light(&self, k: usize, passes: bool, lights: &LightSet, onward: &mut Onward) {
        let (path, clamp) = (self.path(k), self.options.clamp);
        if let Some(behind) = self.backdrop.filter(|_| !passes) {
            let light = add(onward.radiance, path.lane, path.throughput * behind, path.edges, clamp);
            if let Some(ledger) = &mut onward.ledger {
                let end = ledger.paths.classes.background();
                ledger.found(self.numbers[k] as usize, (path.lane, light), end);
            }
        }
        let mut found = self.closures.emission(k);
        if found != Vec3::ZERO {
            if passes && self.paths.has_media() {
                // Paths that are stopped are dimmed as a whole.
                let dist = (self.points.p.get(k) - path.start).length();
                found *= left_after(dist, [path.absorption, self.closures.medium(k).on(true)]);
            }
            let found = self.counted(found, lights, &path, (k, onward.linked.as_deref()));
            let light = add(onward.radiance, path.lane, path.throughput * found, path.edges, clamp);
            if let Some(recorder) = &mut onward.recorder {
                let (ids, p, dir) = (self.ids(k), self.points.p.get(k), self.points.ray_dir.get(k));
                let share = unguided_share(recorder, &path, dir, |path| weigh(lights, path, ids, p, dir));
                recorder.found(path.trail, light * share);
            }
            if let Some(seen) = onward.seen.as_mut().filter(|_| !self.is_final) {
                seen.add(path.lane, light, (path.scattered, path.edges));
            }
            if let Some(ledger) = &mut onward.ledger {
                let (ids, dir) = (self.ids(k), self.points.ray_dir.get(k));
                let end = ledger.paths.classes.surface(lights, ids, dir, self.material());
                ledger.found(self.numbers[k] as usize, (path.lane, light), end);
            }
        }
    }

    fn ids(&self, k: usize) -> [u32; 3] {
        [self.points.leaf_id[k], self.points.geom_id[k], self.points.prim_id[k]]
    }

    fn material(&self) -> u32 {
        self.world.material_of(self.points.leaf_id[0], self.points.geom_id[0])
    }

    /// The weighted emission at the hit of a scattered ray: light samples find it, too. Of radiance-only
    /// surfaces they find the described emission.
    fn counted(
        &self,
        found: Vec3,
        lights: &LightSet,
        path: &Path,
        (k, linked): (usize, Option<&LinkedPaths>),
    ) -> Vec3 {
        let points = self.points;
        let (ids, dir) = (self.ids(k), points.ray_dir.get(k));
        if let (Some(linked), Some(shape)) = (linked, lights.shape(ids, dir))
            && !linked.counts(self.numbers[k] as usize, LightId(shape), path.from.is_some())
        {
            return Vec3::ZERO;
        }
        let weight = weigh(lights, path, ids, points.p.get(k), dir) * self.beside_searches(lights, path, k);
        match lights.shape(ids, dir) {
            Some(shape) if self.is_final && points.front(k) && path.from.is_some() => {
                let met = ([points.u[k], points.v[k]], points.p.get(k));
                let emitted = lights.radiance_of_shape(shape, met, dir, points.t[k]);
                found - emitted * (1.0 - weight)
            }
            _ => found * weight,
        }
    }
}

/// Whether a path with this number of edges comes straight from the camera and sees a hole, an instance.
pub(crate) fn is_hole(world: &World, edges: u32, instance: u32) -> bool {
    edges == 1 && world.labels().holdouts.contains(&instance)
}

/// Takes the step of all paths that met the shader.
#[inline(always)]
pub(crate) fn step<W: Width>(width: W, met: &Met, onward: &mut Onward) {
    let count = met.numbers.len();
    onward.next.reserve(count);
    onward.unshadowed.reserve(count * most_light_samples(met.world.light_set()));
    let has_holdouts = onward.held.is_some();
    let needs_vertices = has_holdouts
        || met.closures.emits()
        || met.closures.is_partly_transparent()
        || met.backdrop.is_some();
    for first in (0..count).step_by(W::R::LANES) {
        let mut there = u64::MAX >> (64 - W::R::LANES.min(count - first));
        // Points that paths pass, and that scatter some light all the same.
        let mut passed = 0;
        if needs_vertices {
            for i in LanesOf(there) {
                let k = first + i;
                let passes = met.closures.is_partly_transparent() && !met.is_there(k, &met.path(k));
                let is_held_out = has_holdouts && met.is_held_out(k, passes, onward);
                if !is_held_out {
                    met.take_light(k, passes, met.world.light_set(), onward);
                }
                if passes {
                    met.pass(k, onward);
                    passed |= u64::from(!is_held_out && met.closures.coverage(k) > 0.0) << i;
                }
                if passes || is_held_out {
                    there &= !(1 << i);
                }
            }
        }
        let mut edges = [0; LANES];
        for i in LanesOf(there | passed) {
            edges[i] = met.paths.edges[met.numbers[first + i] as usize];
            if edges[i] >= met.options.max_depth {
                there &= !(1 << i);
                passed &= !(1 << i);
            }
        }
        if there | passed != 0 && !met.is_final {
            scatter(width, met, first, [there, passed], &edges, onward);
        }
    }
}

/// Samples light for the points from `first` on that stop paths or are passed, and scatters those paths that they stop. Light samples
/// of points that are there in part count that part, whether or not a path is stopped.
#[inline(always)]
fn scatter<W: Width>(
    width: W,
    met: &Met,
    first: usize,
    [stopped, passed]: [u64; 2],
    edges: &[u32; LANES],
    onward: &mut Onward,
) {
    let (options, points, lights) = (met.options, met.points, met.world.light_set());
    let zero = width.zero();
    let HitLanes { keys, cones, .. } = met.from;
    let of = Of { paths: met.paths, keys, cones, numbers: &met.numbers[first..] };
    let [there, asks] = [stopped, stopped | passed].map(
        #[inline(always)]
        |points| zero.points(points),
    );
    let wo = -vectors(zero, &points.ray_dir, first);
    let at = leaving(zero, points, first, wo);
    let [r, g, b] = zero.each_of(
        #[inline(always)]
        |i| number_of(of, i).map_or([0.0; 3], |number| met.paths.throughput.get(number).into()),
    );
    let throughput = Vector::new(r, g, b);
    let mut prepared = Prepared::none(zero);
    width.prepare(met.closures, first, (wo, throughput), &mut prepared);
    let draws = width.draws(options.seed, &points.key[first..], edges);
    // A shadow catcher's share of light is not that of its lobes.
    let mixture = met.guide.filter(|_| met.backdrop.is_none()).map(
        #[inline(always)]
        |guide| {
            zero.outline(
                #[inline(always)]
                || Mixture::new(guide, asks, [at.p, at.ns], &prepared),
            )
        },
    );
    let mixture = mixture.as_ref();
    if !lights.is_empty() {
        let requests = asks & prepared.is_smooth();
        let mut there_in_part = throughput;
        if met.closures.is_partly_transparent() {
            let [r, g, b] = zero.each_of(
                #[inline(always)]
                |i| match number_of(of, i) {
                    None => [0.0; 3],
                    Some(_) => met.part_of_light(first + i, passed >> i & 1 != 0).into(),
                },
            );
            there_in_part = throughput * Vector::new(r, g, b);
        }
        let points =
            LitPoints { first, of, at: &at, wo, throughput: there_in_part, prepared: &prepared, mixture };
        for_each_light_sample(
            width,
            (lights, draws),
            (requests, edges),
            #[inline(always)]
            |sample| take_light_sample(width, met, &points, sample, onward),
        );
    }
    if stopped == 0 {
        return;
    }
    let [x, y, choice] = W::triple(draws, purpose::DIRECTION);
    let [_, survival] = W::pair(draws, purpose::CHOICE);
    let (chosen, of_lobes) = match mixture {
        None => {
            let chosen = prepared.sample([choice, x, y]);
            (chosen, chosen.pdf)
        }
        Some(mixture) => zero.outline(
            #[inline(always)]
            || mixture.sample(&prepared, [choice, x, y]),
        ),
    };
    let mut cone = None;
    if !points.footprint.is_empty() {
        let at = hit_info(zero, points, first, wo);
        let order = met.pixel_order;
        let fineness = zero.each(
            #[inline(always)]
            |i| points.key.get(first + i).map_or(1.0, |&key| fineness(order.sample(key))),
        );
        cone = Some([at.width, at.spread_after(of_lobes, chosen.delta, chosen.transmitted, fineness)]);
    }
    let chosen = Chosen { at: chosen, of_lobes, throughput, mixture };
    go_on((met, first), (of, there), &at, &prepared, chosen, (survival, edges, cone), onward);
}

/// Directions that were chosen for points.
struct Chosen<'a, R: Real> {
    at: Sampled<R>,
    /// Their density by lobes alone.
    of_lobes: R,
    /// Of the paths before.
    throughput: Vector<R>,
    mixture: Option<&'a Mixture<'a, R>>,
}

/// Points that request light: those of a batch from `first` on.
struct LitPoints<'a, R: Real> {
    first: usize,
    of: Of<'a>,
    at: &'a Leaving<R>,
    /// Unit, against the rays.
    wo: Vector<R>,
    throughput: Vector<R>,
    prepared: &'a Prepared<R>,
    mixture: Option<&'a Mixture<'a, R>>,
}

/// Samples a light, of one group if it is named, for the points that request it.
#[inline(always)]
fn take_light_sample<W: Width>(
    width: W,
    met: &Met,
    of_points: &LitPoints<W::R>,
    (requests, group, [x, y, choice]): LightRequests<W>,
    onward: &mut Onward,
) {
    let (options, points, lights) = (met.options, met.points, met.world.light_set());
    let &LitPoints { first, of, at, wo, throughput, prepared, mixture } = of_points;
    let (zero, one) = (width.zero(), width.zero().all(1.0));
    let translucent = prepared.is_translucent();
    let boundary = met.boundary(first, W::R::LANES);
    let light = width.lights((lights, group), [requests, translucent], [at.p, at.ns], [choice, x, y]);
    let (value, mut pdf) = prepared.eval_pdf(light.dir);
    let lit = requests & light.found & !value.is_zero() & !light.radiance.is_zero();
    if let Some(mixture) = mixture {
        pdf = zero.outline(
            #[inline(always)]
            || mixture.pdf(lit, light.dir, pdf),
        );
    }
    let weight = if met.backdrop.is_some() { one } else { power_heuristic(light.pdf, pdf) };
    let mut weight = W::R::pick(light.delta, one, weight);
    let (mut lit, mut blockers) = (lit, [0; LANES]);
    if let Some(linked) = &onward.linked {
        let all_sides = W::R::bits(translucent);
        let [mut reached, mut alone] = [0, 0];
        for i in LanesOf(W::R::bits(lit)) {
            let ns = if all_sides >> i & 1 != 0 { Vec3::ZERO } else { at.ns.get(i) };
            let u = [choice.lane(i), x.lane(i), y.lane(i)];
            let Some(found) = lights.sample_among(group, at.p.get(i), ns, u) else { continue };
            blockers[i] = linked.links.blockers(found.light);
            let is_reached = linked.links.reaches(found.light, points.inst_id[first + i]);
            reached |= u64::from(is_reached) << i;
            alone |= u64::from(blockers[i] != 0) << i;
        }
        lit = lit & zero.points(reached);
        weight = W::R::pick(zero.points(alone), one, weight);
    }
    let arriving = light.radiance * (weight / light.pdf);
    let transmitted = zero.above(prepared.normal().dot(light.dir));
    let (ray, sends) = at.shadow_rays(light.dir, light.dist, transmitted);
    let lit = lit & sends;
    let here = throughput * value * arriving;
    let here = met.dimmed(first, lit, (here, transmitted), light.dist);
    if met.backdrop.is_some() {
        // The backdrop includes the environment's light: it is subtracted, and added again if
        // unoccluded.
        let far = lit & !light.delta & !light.dist.is_number();
        for i in LanesOf(W::R::bits(far)) {
            let path = met.path(first + i);
            let light = add(onward.radiance, path.lane, -here.get(i), path.edges + 1, options.clamp);
            if let Some(ledger) = &mut onward.ledger {
                let end = ledger.paths.classes.background();
                ledger.found(met.numbers[first + i] as usize, (path.lane, light), end);
            }
        }
    }
    let begins = met.absorption(first, lit, transmitted, zero);
    let delta_requests = lit & light.delta & begins.is_zero();
    let through = boundary.map(|boundary| (boundary, W::R::bits(transmitted)));
    onward.unshadowed.push_all([lit, delta_requests], of, &ray, here, through);
    if let Some(linked) = &mut onward.linked {
        linked.blockers.extend(LanesOf(W::R::bits(lit)).map(|i| blockers[i]));
    }
    if let Some(ledger) = &mut onward.ledger {
        let transmitted = W::R::bits(transmitted);
        let all_sides = W::R::bits(translucent);
        for i in LanesOf(W::R::bits(lit)) {
            let is_lit = LitLane {
                k: first + i,
                p: at.p.get(i),
                ns: if all_sides >> i & 1 != 0 { Vec3::ZERO } else { at.ns.get(i) },
                group,
                u: [choice.lane(i), x.lane(i), y.lane(i)],
                wo: wo.get(i),
                wi: light.dir.get(i),
                is_transmitted: transmitted >> i & 1 != 0,
            };
            note_light(met, &is_lit, ledger);
        }
    }
}

/// A light sample of one point, for layers of light.
struct LitLane {
    /// The point.
    k: usize,
    p: Vec3,
    ns: Vec3,
    /// The group, if it was named, and the random numbers that chose it.
    group: Option<usize>,
    u: [f32; 3],
    wo: Vec3,
    wi: Vec3,
    is_transmitted: bool,
}

/// Notes a light sample: its light is chosen again, which gives the same one.
fn note_light(met: &Met, lit: &LitLane, ledger: &mut Ledger) {
    let (lights, classes) = (met.world.light_set(), &ledger.paths.classes);
    let light = lights.sample_among(lit.group, lit.p, lit.ns, lit.u).map(|sample| sample.light);
    let end = light.map_or_else(|| classes.plugin(), |light| classes.light(light, lights));
    let number = met.numbers[lit.k] as usize;
    if met.backdrop.is_some() && end == classes.background() {
        // What a shadow catcher shows of the environment is not scattered there.
        ledger.light(number, &[], end);
        return;
    }
    let events = met.events(ledger, lit.k, [lit.wo, lit.wi], (lit.is_transmitted, false));
    ledger.light(number, &events, end);
}

impl Met<'_> {
    /// The events of light from the unit `wi` that point `k` scatters to `wo`: by diffuse lobes and by glossy ones.
    pub(crate) fn events(
        &self,
        ledger: &Ledger,
        k: usize,
        [wo, wi]: [Vec3; 2],
        (is_transmitted, is_delta): (bool, bool),
    ) -> [(Scatter, Vec3); 2] {
        let material = self.material();
        let event = |lobe| ledger.paths.classes.scatter(material, is_transmitted, lobe);
        if is_delta {
            return [(event(Lobe::Singular), Vec3::ONE), (event(Lobe::Glossy), Vec3::ZERO)];
        }
        let (mut wide, mut narrow) = (false, false);
        for (kind, _) in self.closures.widths(k) {
            wide |= kind.is_wide();
            narrow |= !(kind.is_wide() || kind.is_delta());
        }
        let share = match (wide, narrow) {
            (true, true) => self.closures.point(k).bsdf.wide_share(wo, wi),
            (_, false) => Vec3::ONE,
            (false, true) => Vec3::ZERO,
        };
        [(event(Lobe::Diffuse), share), (event(Lobe::Glossy), Vec3::ONE - share)]
    }
}

/// Sends on the paths that are there, in the directions that were chosen.
#[inline(always)]
fn go_on<R: Real>(
    (met, first): (&Met, usize),
    (of, there): (Of, R::Mask),
    at: &Leaving<R>,
    prepared: &Prepared<R>,
    Chosen { at: chosen, of_lobes, throughput: before, mixture }: Chosen<R>,
    (survival, edges, cone): (R, &[u32; LANES], Option<[R; 2]>),
    onward: &mut Onward,
) {
    let (zero, one) = (at.error.all(0.0), at.error.all(1.0));
    let mut throughput = before * chosen.weight;
    if !met.shares.is_empty() {
        throughput = throughput * zero.load(met.shares, first);
    }
    let mut alive = there & chosen.found;
    // Guided paths carry less where more of them go. Roulette decides by the load that they would have without a guide.
    let mut spared = one;
    if mixture.is_some() {
        spared = Mixture::spared(of.spared(zero), [chosen.pdf, of_lobes], !chosen.delta);
    }
    let mut long = 0;
    for (i, &edges) in edges.iter().enumerate().take(R::LANES) {
        long |= u64::from(roulette::decides(edges)) << i;
    }
    if long != 0 {
        let long = zero.points(long);
        let mut left = throughput.max_element();
        if mixture.is_some() {
            left = left * spared;
        }
        let keep = roulette::survival_from_eye(left);
        alive = alive & (keep.above(survival) | !long);
        throughput = Vector::pick(long, throughput.over(keep), throughput);
    }
    alive = alive & throughput.is_finite() & !throughput.is_zero();
    let (ray, sends) = at.scatter_rays(chosen.wi, chosen.transmitted);
    // A shadow catcher leaves to light samples all light that they can find.
    let pdf = if met.backdrop.is_some() { zero } else { chosen.pdf };
    let pdf = R::pick(chosen.delta, one.all(NOWHERE), pdf);
    let ns = Vector::pick(prepared.is_translucent(), Vector::grey(zero), at.ns);
    let absorption = met.absorption(first, alive, chosen.transmitted, zero);
    let how = [chosen.delta, chosen.transmitted, chosen.wide].map(R::bits);
    let boundary = met.boundary(first, R::LANES);
    let mut seen = 0;
    if onward.seen.is_some() {
        // Light samples bring next to nothing by lobes this narrow.
        let polished = LanesOf(R::bits(alive) & !how[0]).filter(|i| met.closures.is_polished(first + i));
        seen = how[0] | polished.fold(0, |bits, i| bits | 1 << i);
    }
    for i in LanesOf(seen & R::bits(alive)) {
        // Colours go different ways.
        seen &= !(u64::from(met.closures.is_dispersed(first + i)) << i);
    }
    let next = Scattered { ray, throughput, p: at.p, ns, pdf, absorption, cone, how, seen, boundary };
    let first_new = onward.next.count();
    onward.next.push_all(alive & sends, of, &next);
    if met.caustics.is_some() {
        for (n, i) in LanesOf(R::bits(alive & sends)).enumerate() {
            let turn = (chosen.wi.get(i), how[1] >> i & 1 != 0);
            let density = (how[0] >> i & 1 == 0).then(|| of_lobes.lane(i));
            onward.next.chain[first_new + n] = met.chain(first + i, turn, density);
        }
    }
    if let Some(mixture) = mixture {
        for (n, i) in LanesOf(R::bits(alive & sends)).enumerate() {
            onward.next.spared[first_new + n] = spared.lane(i);
            let is_guidable = mixture.guidable.lane(i) > 0.0 && how[0] >> i & 1 == 0;
            if let Some(recorder) = onward.recorder.as_mut().filter(|_| is_guidable) {
                let vertex = guide::Vertex {
                    p: at.p.get(i),
                    dir: chosen.wi.get(i),
                    pdf: chosen.pdf.lane(i),
                    pdf_of_lobes: of_lobes.lane(i),
                    guidable: mixture.guidable.lane(i),
                    throughput: guide::grey(before.get(i)),
                    light: 0.0,
                    class: class_of(at.ns.get(i)),
                    before: met.paths.trail_of(of.numbers[i] as usize),
                };
                onward.next.trail[first_new + n] = recorder.scatter(vertex);
            }
        }
    }
    if let Some(linked) = &mut onward.linked {
        for i in LanesOf(R::bits(alive & sends)) {
            linked.scatter(Some(met.points.inst_id[first + i]));
        }
    }
    if let Some(ledger) = &mut onward.ledger {
        let [deltas, transmitted] = [chosen.delta, chosen.transmitted].map(R::bits);
        for i in LanesOf(R::bits(alive & sends)) {
            let (k, wi) = (first + i, chosen.wi.get(i));
            let how = (transmitted >> i & 1 != 0, deltas >> i & 1 != 0);
            let events = met.events(ledger, k, [-met.points.ray_dir.get(k), wi], how);
            ledger.scatter(met.numbers[k] as usize, &events);
        }
    }
}

#[inline(always)]
fn number_of(of: Of, i: usize) -> Option<usize> {
    of.numbers.get(i).map(|&number| number as usize)
}

#[inline(always)]
fn vectors<R: Real>(like: R, v: &Vec3s, first: usize) -> Vector<R> {
    Vector::load(like, [&v.x, &v.y, &v.z], first)
}

/// How the cones of rays from `-wo` meet the points from `first` on.
#[inline(always)]
fn hit_info<R: Real>(like: R, points: &SurfaceBatch, first: usize, wo: Vector<R>) -> ConeHit<R> {
    let zero = like.all(0.0);
    let cos = vectors(like, &points.ng, first).dot(wo);
    let known = |values: &[f32]| if values.is_empty() { zero } else { like.load(values, first) };
    let curvature = known(&points.curvature);
    ConeHit {
        width: known(&points.footprint),
        spread: known(&points.cone_spread),
        curvature: R::pick(zero.above(cos), -curvature, curvature),
        cos: cos.size(),
        // Each ray's own.
        kind: RayKind::default(),
        bounces: Bounces::default(),
    }
}

/// State for rays that leave the points from `first` on; see [`SurfaceBatch::point`].
#[inline(always)]
fn leaving<R: Real>(like: R, points: &SurfaceBatch, first: usize, wo: Vector<R>) -> Leaving<R> {
    let zero = like.all(0.0);
    let (ng, ns) = (vectors(like, &points.ng, first), vectors(like, &points.ns, first));
    let ng = Vector::pick(zero.above(ng.dot(wo)), -ng, ng);
    let ns = Vector::pick(zero.above(ns.dot(ng)), -ns, ns);
    Leaving {
        p: vectors(like, &points.p, first),
        error: like.load(&points.error, first),
        ng,
        ns,
        lift: vectors(like, &points.lift, first),
    }
}
