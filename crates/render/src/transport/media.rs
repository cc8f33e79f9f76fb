// SPDX-License-Identifier: GPL-3.0-or-later
//! Paths from the eye in media: where the camera is, free flight between surfaces, and vertices in media, as
//! many at a time as the CPU's registers hold.
//! Source: [PJH23] chapter 14, as `step` for surfaces: a light sample and a direction of the phase function,
//! combined by the power heuristic. Space: world.
//! Invariant: the result of a path depends on its ray and key only, independent of the other paths and of the
//! number of lanes. Lights of shader plugins that only have `illuminate` do not light media.
//! Tests: crates/render/tests/media.rs.

use glam::Vec3;
use gnurt_accel::{Coherence, HitBatch, INVALID_ID, Ray, RayBatch};
use gnurt_scene::RayMask;
use gnurt_shading::lanes::{LANES, LanesOf};
use gnurt_shading::phase::Phase;
use gnurt_shading::real::{Real, Vector};
use gnurt_shading::sampling::purpose;
use gnurt_shading::{Leaving, Rays, SampleKey, SurfaceBatch, Vec3s};

use super::flight::{Parts, Random};
use super::forced_collision::ForcedCollision;
use super::medium_vertices::{MediumVertex, MediumVertices};
use super::mis::{most_light_samples, power_heuristic};
use super::near_lamps::NearLamps;
use super::paths::{Of, Paths, Scattered};
use super::step::Onward;
use super::width::{LightRequests, Width, for_each_light_sample};
use super::{add, roulette};
use crate::expressions::{Ledger, Scatter};
use crate::guide::{self, Guide, Mixture, Recorder};
use crate::options::RenderOptions;
use crate::space_tree::IN_MEDIUM;
use crate::tracer::{AttributeRequests, BatchTracer};
use crate::world::{HitLanes, Inside, Media, World};

/// Rounding error of a point of a ray, as a multiple of its largest coordinate.
const ERROR_SCALE: f32 = 4.0 * f32::EPSILON;
/// How fast the cones of scattered rays widen.
const SPREAD: f32 = 0.3;
/// Vertices of more edges teach a guide nothing: in thick bodies they would take all its room.
const DEEPEST_LESSON: u32 = 16;
/// Surfaces between a camera and the outside that are counted.
const MOST_BODIES: u32 = 64;

impl Media {
    /// The medium behind the surface of some points of one material, or 0.
    pub(crate) fn of_points(&self, world: &World, points: &SurfaceBatch) -> u16 {
        match (points.leaf_id.first(), points.geom_id.first()) {
            (Some(&leaf), Some(&mesh)) if self.has_bodies() => {
                self.of_material(world.material_of(leaf, mesh))
            }
            _ => 0,
        }
    }
}

/// Whether a ray left the scene: it neither hit a surface nor was scattered before.
pub(crate) fn is_missed(hits: &HitBatch, i: usize) -> bool {
    hits.prim_id[i] == INVALID_ID && !hits.t[i].is_finite()
}

/// Which bodies with media the origins of rays are in.
pub(crate) fn inside_at(tracer: &mut BatchTracer, rays: &RayBatch, keys: &[SampleKey]) -> Vec<Inside> {
    let (world, count) = (tracer.world, rays.len());
    let mut found = vec![Inside::default(); count];
    if !world.media().has_bodies() || count == 0 {
        return found;
    }
    let first = rays.get(0).org;
    let is_pinhole = (0..count).all(|i| rays.get(i).org == first);
    let asked = if is_pinhole { 1 } else { count };
    // One direction for all, so that open surfaces answer all alike.
    let dir = Vec3::new(0.267_3, 0.801_8, 0.534_5).normalize();
    // Bodies that each ray has entered, and left without having entered them.
    let mut bodies = vec![(Vec::new(), Vec::new()); asked];
    let (mut these, mut theirs): (RayBatch, Vec<usize>) = (RayBatch::default(), (0..asked).collect());
    (0..asked).for_each(|i| these.push(Ray::new(rays.get(i).org, dir.into())));
    for _ in 0..MOST_BODIES {
        if theirs.is_empty() {
            break;
        }
        let keys: Vec<_> = theirs.iter().map(|&i| keys[i]).collect();
        let hits = tracer.intersect(RayMask::OTHER, &these, &keys, Coherence::Incoherent);
        tracer.stats.secondary_rays += these.len() as u64;
        let from = HitLanes { rays: &these, keys: &keys, hits: &hits, cones: None, depth: 1 };
        let (mut next, mut ours) = (RayBatch::default(), Vec::new());
        tracer.for_each_surface(from, AttributeRequests::Light, |_, _, lanes, points| {
            let medium = world.media().of_points(world, points);
            for (k, &lane) in lanes.iter().enumerate() {
                let i = theirs[lane as usize];
                let (entered, left) = &mut bodies[i];
                if medium != 0 && points.front(k) {
                    entered.push(medium);
                } else if medium != 0 {
                    match entered.iter().rposition(|&body| body == medium) {
                        Some(at) => _ = entered.remove(at),
                        None => left.push(medium),
                    }
                }
                next.push(points.spawn(k, dir, f32::INFINITY));
                ours.push(i);
            }
        });
        (these, theirs) = (next, ours);
    }
    for (inside, (_, left)) in found.iter_mut().zip(&bodies) {
        *inside = left.iter().rev().fold(Inside::default(), |inside, &body| inside.crossing(body, true));
    }
    if is_pinhole {
        let of_all = found[0];
        found.fill(of_all);
    }
    found
}

/// Flies along the paths' rays up to their hits. Paths that are scattered before become vertices, and hit
/// nothing. Places near lamps, where paths only take light, are vertices of their own.
pub(crate) fn fly(
    (world, options): (&World, &RenderOptions),
    (rays, keys): (&RayBatch, &[SampleKey]),
    paths: &mut Paths,
    hits: &mut HitBatch,
    [vertices, lamps]: [&mut MediumVertices; 2],
    (radiance, mut ledger, mut recorder): (&mut Vec3s, Option<&mut Ledger>, Option<&mut Recorder>),
) {
    vertices.clear();
    lamps.clear();
    let (media, mut parts) = (world.media(), Parts::default());
    for (i, &key) in keys.iter().enumerate().take(rays.len()) {
        let ray = rays.get(i);
        let (org, dir) = (Vec3::from(ray.org), Vec3::from(ray.dir));
        if dir == Vec3::ZERO {
            continue;
        }
        let path = paths.get(i, key);
        media.parts(path.inside, org, dir, &mut parts);
        if parts.is_empty() {
            continue;
        }
        let length = if hits.prim_id[i] == INVALID_ID { f32::INFINITY } else { hits.t[i] };
        let way = (org, dir, length);
        let mut random = Random::of_edge(options.seed, key, path.edges);
        let takes_light = path.edges < options.max_depth;
        let forced = takes_light.then(|| ForcedCollision::of(&parts, &path, length)).flatten();
        let scattered = forced.as_ref().map_or(1.0, ForcedCollision::chance);
        let mut near = NearLamps::of((world, options), (&parts, &random), &path, way);
        if let Some(near) = &mut near {
            near.add(world, (&parts, scattered), (i as u32, org, dir), lamps);
        }
        let flight = parts.fly(length, path.throughput, &mut random);
        if flight.emitted != Vec3::ZERO {
            let light = add(radiance, path.lane, flight.emitted, path.edges, options.clamp);
            if let Some(recorder) = &mut recorder {
                recorder.found(path.trail, light);
            }
            if let Some(ledger) = &mut ledger {
                let end = ledger.paths.classes.medium();
                ledger.found(i, (path.lane, light), end);
            }
        }
        paths.throughput.set(i, flight.throughput);
        let Some((t, number)) = flight.scattered else {
            if let Some(forced) = forced {
                let from = (&path, i as u32, org, dir);
                forced.add((world, &random), (&parts, near.as_ref()), from, lamps);
            }
            continue;
        };
        // No hit, and no miss either.
        (hits.prim_id[i], hits.t[i]) = (INVALID_ID, t);
        let (phase, p, throughput) = (media.get(number).phase, org + dir * t, flight.throughput);
        let density = || parts.density(t, path.throughput) / scattered;
        let share = scattered * near.map_or(1.0, |near| near.share_of_flight(density(), t));
        vertices.push((i as u32, key), &MediumVertex { p, along: dir, phase, throughput, share });
    }
}

/// Samples light for vertices in media, and scatters their paths if these go on.
#[inline(always)]
pub(crate) fn scatter<W: Width>(
    width: W,
    (world, options, guide): (&World, &RenderOptions, Option<&Guide>),
    (paths, keys): (&Paths, &[SampleKey]),
    (vertices, goes_on): (&MediumVertices, bool),
    onward: &mut Onward,
) {
    let count = vertices.numbers.len();
    onward.next.reserve(count);
    onward.unshadowed.reserve(count * most_light_samples(world.light_set()));
    for first in (0..count).step_by(W::R::LANES) {
        let lanes = W::R::LANES.min(count - first);
        scatter_lanes(
            width,
            (world, options, guide),
            (paths, keys),
            (vertices, goes_on),
            (first, lanes),
            onward,
        );
    }
}

#[inline(always)]
fn scatter_lanes<W: Width>(
    width: W,
    (world, options, guide): (&World, &RenderOptions, Option<&Guide>),
    (paths, keys): (&Paths, &[SampleKey]),
    (vertices, goes_on): (&MediumVertices, bool),
    (first, lanes): (usize, usize),
    onward: &mut Onward,
) {
    let (zero, lights) = (width.zero(), world.light_set());
    let of = Of { paths, keys, cones: None, numbers: &vertices.numbers[first..] };
    let mut there = u64::MAX >> (64 - lanes);
    let mut edges = [0; LANES];
    for (i, edges) in edges.iter_mut().enumerate().take(lanes) {
        *edges = paths.edges[vertices.numbers[first + i] as usize];
        if *edges >= options.max_depth {
            there &= !(1 << i);
        }
    }
    if there == 0 {
        return;
    }
    let there = zero.points(there);
    let load = |v: &Vec3s| Vector::load(zero, [&v.x, &v.y, &v.z], first);
    let (p, along) = (load(&vertices.p), load(&vertices.along));
    let [a, b, second_share] = [0, 1, 2].map(|k| zero.load(&vertices.phase[k], first));
    let phase = Phase { anisotropy: [a, b], second_share };
    let mut throughput = load(&vertices.throughput);
    let share = zero.load(&vertices.share, first);
    let draws = width.draws(options.seed, &vertices.keys[first..], &edges);
    let error = p.abs().max_element() * ERROR_SCALE;
    let mixture = guide.map(
        #[inline(always)]
        |guide| {
            zero.outline(
                #[inline(always)]
                || Mixture::in_media(guide, there, p),
            )
        },
    );
    let mixture = mixture.as_ref();
    if !lights.is_empty() {
        let points =
            LitVertices { of, p, along, phase: &phase, throughput: throughput * share, error, mixture };
        for_each_light_sample(
            width,
            (lights, draws),
            (there, &edges),
            #[inline(always)]
            |sample| take_light_sample(width, world, &points, sample, onward),
        );
    }
    if !goes_on {
        return;
    }
    let [x, y, choice] = W::triple(draws, purpose::DIRECTION);
    let [_, survival] = W::pair(draws, purpose::CHOICE);
    let before = throughput;
    let (dir, pdf, of_phase) = match mixture {
        None => {
            let (dir, pdf) = phase.sample(along, [choice, x, y]);
            (dir, pdf, pdf)
        }
        Some(mixture) => zero.outline(
            #[inline(always)]
            || mixture.sample_phase(&phase, along, [choice, x, y]),
        ),
    };
    let mut spared = zero.all(1.0);
    if mixture.is_some() {
        spared = Mixture::spared(of.spared(zero), [pdf, of_phase], there);
        throughput = throughput * (of_phase / pdf);
    }
    let mut long = 0;
    for (i, &edges) in edges.iter().enumerate().take(lanes) {
        long |= u64::from(roulette::decides(edges)) << i;
    }
    let mut alive = there;
    if long != 0 {
        let long = zero.points(long);
        let mut left = throughput.max_element();
        if mixture.is_some() {
            left = left * spared;
        }
        let keep = roulette::survival_in_medium(left);
        alive = alive & (keep.above(survival) | !long);
        throughput = Vector::pick(long, throughput.over(keep), throughput);
    }
    alive = alive & throughput.is_finite() & !throughput.is_zero();
    let far = zero.all(f32::INFINITY);
    let ray = Rays { org: p, dir, t_far: far };
    let cone = Some([zero, zero.all(SPREAD)]);
    let how = [0, 0, u64::MAX];
    let ns = Vector::grey(zero);
    let absorption = ns;
    let next = Scattered { ray, throughput, p, ns, pdf, absorption, cone, how, seen: 0, boundary: None };
    let first_new = onward.next.count();
    onward.next.push_all(alive, of, &next);
    if mixture.is_some() {
        for (n, i) in LanesOf(W::R::bits(alive)).enumerate() {
            onward.next.spared[first_new + n] = spared.lane(i);
            let teaches = edges[i] <= DEEPEST_LESSON;
            if let Some(recorder) = onward.recorder.as_mut().filter(|_| teaches) {
                let vertex = guide::Vertex {
                    p: p.get(i),
                    dir: dir.get(i),
                    pdf: pdf.lane(i),
                    pdf_of_lobes: of_phase.lane(i),
                    guidable: 1.0,
                    throughput: guide::grey(before.get(i)),
                    light: 0.0,
                    class: IN_MEDIUM,
                    before: paths.trail_of(of.numbers[i] as usize),
                };
                onward.next.trail[first_new + n] = recorder.scatter(vertex);
            }
        }
    }
    if let Some(linked) = &mut onward.linked {
        LanesOf(W::R::bits(alive)).for_each(|_| linked.scatter(None));
    }
    if let Some(ledger) = &mut onward.ledger {
        for i in LanesOf(W::R::bits(alive)) {
            ledger.scatter(of.numbers[i] as usize, &[(Scatter::VOLUME, Vec3::ONE)]);
        }
    }
}

/// Vertices that request light.
struct LitVertices<'a, R: Real> {
    of: Of<'a>,
    p: Vector<R>,
    /// Unit, along the rays.
    along: Vector<R>,
    phase: &'a Phase<R>,
    throughput: Vector<R>,
    error: R,
    mixture: Option<&'a Mixture<'a, R>>,
}

/// Samples a light, of one group if it is named, for the vertices that request it.
#[inline(always)]
fn take_light_sample<W: Width>(
    width: W,
    world: &World,
    vertices: &LitVertices<W::R>,
    (requests, group, [x, y, choice]): LightRequests<W>,
    onward: &mut Onward,
) {
    let &LitVertices { of, p, along, phase, throughput, error, mixture } = vertices;
    let (zero, one) = (width.zero(), width.zero().all(1.0));
    let (lights, none) = (world.light_set(), zero.points(0));
    // From all sides.
    let light = width.lights((lights, group), [requests, requests], [p, along], [choice, x, y]);
    let value = phase.value(along.dot(light.dir));
    let lit = requests & light.found & !light.radiance.is_zero();
    let mut pdf = value;
    if let Some(mixture) = mixture {
        pdf = zero.outline(
            #[inline(always)]
            || mixture.pdf(lit & !light.delta, light.dir, value),
        );
    }
    let mut weight = W::R::pick(light.delta, one, power_heuristic(light.pdf, pdf));
    let mut blockers = [0; LANES];
    if let Some(linked) = &onward.linked {
        let mut alone = 0;
        for i in LanesOf(W::R::bits(lit)) {
            let u = [choice.lane(i), x.lane(i), y.lane(i)];
            let found = lights.sample_among(group, p.get(i), Vec3::ZERO, u);
            blockers[i] = found.map_or(0, |found| linked.links.blockers(found.light));
            alone |= u64::from(blockers[i] != 0) << i;
        }
        weight = W::R::pick(zero.points(alone), one, weight);
    }
    let arriving = light.radiance * (value * weight / light.pdf);
    let here = throughput * arriving;
    let lit = lit & here.is_finite();
    let at = Leaving { p, error, ng: light.dir, ns: light.dir, lift: Vector::grey(zero) };
    let (ray, _) = at.shadow_rays(light.dir, light.dist, none);
    onward.unshadowed.push_all([lit, lit & light.delta], of, &ray, here, None);
    if let Some(linked) = &mut onward.linked {
        linked.blockers.extend(LanesOf(W::R::bits(lit)).map(|i| blockers[i]));
    }
    if let Some(ledger) = &mut onward.ledger {
        for i in LanesOf(W::R::bits(lit)) {
            let u = [choice.lane(i), x.lane(i), y.lane(i)];
            let chosen = lights.sample_among(group, p.get(i), Vec3::ZERO, u).map(|sample| sample.light);
            let classes = &ledger.paths.classes;
            let end = chosen.map_or_else(|| classes.plugin(), |light| classes.light(light, lights));
            ledger.light(of.numbers[i] as usize, &[(Scatter::VOLUME, Vec3::ONE)], end);
        }
    }
}
