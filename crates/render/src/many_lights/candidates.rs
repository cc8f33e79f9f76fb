// SPDX-License-Identifier: GPL-3.0-or-later
//! Complete paths from a light to the camera, and the virtual lights on them. Standard virtual lights lie
//! where a light path hits a surface, reverse ones where a ray from a visible point hits one; reverse ones
//! are joined to all vertices of the light path, and to a light.
//! Source: [SIMP06]; the two strategies are weighted by the balance heuristic [VG95]. Differs: densities of
//! reverse virtual lights are exact, see `pilots`. Space: world.
//! Invariant: for uniform random numbers the summed contribution of a path's virtual lights has the mean of
//! all light in their share, for any pilot points. Tests: crates/render/tests/many_lights.rs.

use std::borrow::Borrow;
use std::f32::consts::FRAC_1_PI;
use std::ops::Range;

use glam::Vec3;
use gnurt_shading::bsdf::{Bsdf, Carrying, left_after};
use gnurt_shading::lights::LightKind;
use gnurt_shading::{RayRequest, SampleKey, SurfacePoint, Tracer, Vec3s};

use super::lanes::{BLOCK, END};
use super::light_path::{self, LightVertex, Numbers};
use super::pilots::{Pilots, Scratch, VisibleMask};
use super::vpl::{self, Vpl, is_open};
use crate::cone::Cone;
use crate::tracer::BatchTracer;
use crate::transport::Vertex;
use crate::transport::mis::{balance_heuristic, over_both};
use crate::transport::walks::Walks;

/// The number of the edge from the camera's side, among the numbers of a path.
pub(super) const EYE_EDGE: u32 = 1;
/// Pairs of it that choose the camera's side of a path.
pub(super) const EYE_PAIRS: Range<u32> = pair::PILOT..pair::POSITION + 1;
/// Pairs of that edge: the choice of a pilot point, two for a direction, two for a light. Others of edge 1
/// belong to the light path.
mod pair {
    pub(super) const PILOT: u32 = 4;
    pub(super) const DIRECTION: u32 = 5;
    pub(super) const LAMP: u32 = 6;
    pub(super) const POSITION: u32 = 7;
}

/// A virtual light and how much it matters.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) vpl: Vpl,
    pub(super) importance: f32,
}

/// A path from a light, and the virtual lights on it.
#[derive(Clone, Debug, Default)]
pub(super) struct LightSide {
    vertices: Vec<LightVertex>,
    pub(super) own: Vec<Candidate>,
}

/// The end of a ray from a pilot point: a position for reverse virtual lights.
#[derive(Clone, Debug, Default)]
pub(super) struct EyeSide {
    end: Option<End>,
    /// The virtual light by direct light there.
    pub(super) own: Option<Candidate>,
}

#[derive(Clone, Debug)]
struct End {
    point: SurfacePoint,
    bsdf: Bsdf,
    light_gain: f32,
    mask: VisibleMask,
    /// Per area, of all pilots' rays.
    density: f32,
}

/// Two surfaces, or a surface and a light, that need mutual visibility.
struct Join {
    ray: gnurt_accel::Ray,
    /// Whose light it is.
    of: usize,
    vpl: Vpl,
    mask: VisibleMask,
}

/// Light that virtual lights bring to pilots.
pub(super) fn total<'a>(found: impl IntoIterator<Item = &'a Candidate>) -> f32 {
    found.into_iter().map(|candidate| candidate.importance).sum()
}

/// Whether both strategies are possible: partly transparent surfaces make the densities of the reverse
/// strategy unknown.
fn both_ways(tracer: &BatchTracer, pilots: &Pilots) -> bool {
    tracer.world.materials().all_solid() && !pilots.points.is_empty() && pilots.max_depth > 2
}

/// Paths from lights.
pub(super) fn light_sides(
    tracer: &mut BatchTracer,
    pilots: &Pilots,
    paths: Range<u32>,
    numbers: &Numbers,
) -> Vec<LightSide> {
    let (first, mut scratch) = (paths.start, Scratch::default());
    let mut sides = vec![LightSide::default(); paths.len()];
    let light = light_path::trace(tracer, paths, numbers, pilots.max_depth.saturating_sub(2));
    let points: Vec<_> = light.iter().map(|v| (v.vpl.point, &v.vpl.bsdf)).collect();
    let mask = pilots.visible_from(tracer, &points, &mut scratch);
    let both_ways = both_ways(tracer, pilots);
    for (vertex, mask) in light.into_iter().zip(mask) {
        let side = &mut sides[(vertex.path - first) as usize];
        if vertex.vpl.emits() {
            let share = if both_ways && vertex.connectable {
                let reverse = pilots.pdf(&vertex.vpl.point, &mask, &mut scratch) * vertex.reverse;
                balance_heuristic(vertex.pdf, reverse)
            } else {
                1.0
            };
            side.own.extend(judged(pilots, vertex.vpl.scaled(share), &mask, &mut scratch));
        }
        side.vertices.push(vertex);
    }
    sides
}

fn judged(pilots: &Pilots, vpl: Vpl, mask: &VisibleMask, scratch: &mut Scratch) -> Option<Candidate> {
    let importance = pilots.importance(&vpl, mask, scratch);
    (importance > 0.0 && vpl.power.is_finite()).then_some(Candidate { vpl, importance })
}

/// Ends of rays from pilot points, one for each of the paths of `numbers`.
pub(super) fn eye_sides(
    tracer: &mut BatchTracer,
    pilots: &Pilots,
    paths: Range<u32>,
    numbers: &Numbers,
) -> Vec<EyeSide> {
    let (first, mut scratch) = (paths.start, Scratch::default());
    let mut sides = vec![EyeSide::default(); paths.len()];
    if !both_ways(tracer, pilots) {
        return sides;
    }
    let (ends, pilot_of) = ends(tracer, pilots, paths, numbers);
    let points: Vec<_> = ends.iter().map(|(_, vertex)| (vertex.point, &vertex.scattering.bsdf)).collect();
    let mut mask = pilots.visible_from(tracer, &points, &mut scratch);
    // By rounding a ray may hit a surface that a shadow ray between the same points misses.
    mask.iter_mut().zip(&pilot_of).for_each(|(mask, &k)| mask[k / BLOCK] |= 1 << (k % BLOCK));
    let mut joins = Vec::new();
    for ((path, vertex), mask) in ends.iter().zip(mask) {
        let density = pilots.pdf(&vertex.point, &mask, &mut scratch);
        let (point, bsdf) = (vertex.point, vertex.scattering.bsdf.clone());
        let end = End { point, bsdf, light_gain: vertex.light_gain, mask, density };
        if density > 0.0 {
            joins.extend(to_lamp(tracer, *path, (*path - first) as usize, &end, numbers));
        }
        sides[(*path - first) as usize].end = Some(end);
    }
    let lit = settle(tracer, pilots, joins, &mut scratch);
    lit.into_iter().for_each(|(of, candidate)| sides[of].own = Some(candidate));
    sides
}

/// The virtual lights where eye sides are joined to light sides, pair by pair.
pub(super) fn joined(
    tracer: &mut BatchTracer,
    pilots: &Pilots,
    pairs: impl IntoIterator<Item = (impl Borrow<LightSide>, impl Borrow<EyeSide>)>,
) -> Vec<(usize, Candidate)> {
    let max_edges = pilots.max_depth.saturating_sub(2);
    let can_go_on = |z: &&LightVertex| z.vpl.edges < max_edges && z.vpl.bsdf.is_smooth();
    let mut joins = Vec::new();
    for (pair, (light, eye)) in pairs.into_iter().enumerate() {
        if let Some(end) = &eye.borrow().end {
            let vertices = light.borrow().vertices.iter().filter(can_go_on);
            joins.extend(vertices.filter_map(|z| to_vertex(pair, z, end)));
        }
    }
    settle(tracer, pilots, joins, &mut Scratch::default())
}

/// The visible ones, with their contributions.
fn settle(
    tracer: &mut BatchTracer,
    pilots: &Pilots,
    joins: Vec<Join>,
    scratch: &mut Scratch,
) -> Vec<(usize, Candidate)> {
    let mut request = RayRequest::default();
    joins.iter().for_each(|join| request.rays.push(join.ray));
    request.key.resize(joins.len(), SampleKey::default());
    let mut through = Vec3s::default();
    tracer.occluded(&request, &mut through);
    let lit =
        joins.into_iter().enumerate().filter(|(i, join)| through.get(*i) != Vec3::ZERO && join.vpl.emits());
    lit.filter_map(|(_, join)| Some((join.of, judged(pilots, join.vpl, &join.mask, scratch)?))).collect()
}

/// Where a ray from a pilot ends, for each path that has one, and which pilot it came from.
fn ends(
    tracer: &mut BatchTracer,
    pilots: &Pilots,
    paths: Range<u32>,
    numbers: &Numbers,
) -> (Vec<(u32, Vertex)>, Vec<usize>) {
    let mut walks = Walks::default();
    for path in paths {
        let [which, lobe] = numbers(path, EYE_EDGE, pair::PILOT);
        let k = ((which * pilots.points.len() as f32) as usize).min(pilots.points.len() - 1);
        let eye = &pilots.points[k];
        let [u, v] = numbers(path, EYE_EDGE, pair::DIRECTION);
        if let Some((ray, sample)) = eye.scatter([lobe, u, v]).filter(|(_, sample)| !sample.delta) {
            let cone = Cone::from_point(sample.pdf);
            walks.push((ray, cone), SampleKey { pixel: path, sample: 0, branch: 0xeee }, (path, k));
        }
    }
    // Only where they end counts.
    let met = walks.meet(tracer, 1).vertices;
    let (mut ends, mut pilot_of) = (Vec::new(), Vec::new());
    for ((path, k), vertex) in walks.carried.into_iter().zip(met) {
        let lit = |v: &Vertex| !v.is_final && v.scattering.bsdf.is_smooth();
        if let Some(vertex) = vertex.filter(lit) {
            ends.push((path, vertex));
            pilot_of.push(k);
        }
    }
    (ends, pilot_of)
}

/// The reverse virtual light that a light illuminates.
fn to_lamp(tracer: &BatchTracer, path: u32, of: usize, end: &End, numbers: &Numbers) -> Option<Join> {
    let lights = tracer.world.light_set();
    let [emitter_choice, _] = numbers(path, EYE_EDGE, pair::LAMP);
    let [u, v] = numbers(path, EYE_EDGE, pair::POSITION);
    let point = end.point;
    let sample = lights.sample(point.p, Vec3::ZERO, [emitter_choice, u, v])?;
    let LightKind::Shape(shape) = lights.kind(sample.light) else { return None };
    if !is_lit(&point, sample.dir) {
        return None;
    }
    let cos = point.ng.dot(sample.dir);
    // Per solid angle of the light, and per area of the virtual light.
    let share = light_path::share_of_light_set(tracer.world);
    let standard = share * lights.pdf_emit_position(shape) * cos * FRAC_1_PI;
    let left = left_after(sample.dist, [end.bsdf.absorption(sample.dir), Vec3::ZERO]);
    let power =
        sample.radiance * left * (end.light_gain * cos * over_both(end.density * sample.pdf, standard));
    let vpl = Vpl::new(point, end.bsdf.clone(), sample.dir, power, 1);
    let ray = point.spawn_to(sample.dir, sample.dist);
    Some(Join { ray, of, vpl, mask: end.mask })
}

/// The reverse virtual light that a vertex of the light path illuminates.
fn to_vertex(of: usize, z: &LightVertex, end: &End) -> Option<Join> {
    let offset = end.point.p - z.vpl.point.p;
    let distance2 = offset.length_squared();
    let to = offset / distance2.sqrt();
    let point = end.point;
    // A light path may continue to either side, but must be consistent with its face.
    let through = z.vpl.point.ng.dot(to) < 0.0;
    if !(distance2 > 0.0 && to.is_finite() && is_lit(&point, -to))
        || through != (z.vpl.bsdf.normal().dot(to) < 0.0)
    {
        return None;
    }
    let carrying = Carrying::new(&z.vpl.bsdf, z.vpl.from);
    let (scattered, pdf) = carrying.eval_pdf(to, z.vpl.point.ng);
    let scattered = scattered * carrying.correction(to, z.vpl.point.ng);
    if scattered == Vec3::ZERO {
        return None;
    }
    let per_area = point.ng.dot(to).abs() / distance2;
    let standard = pdf * z.survival * per_area;
    let left = left_after(distance2.sqrt(), [z.vpl.bsdf.absorption(to), end.bsdf.absorption(-to)]);
    let power = z.vpl.power * scattered * left * (per_area * over_both(end.density, standard));
    let vpl = Vpl::new(point, end.bsdf.clone(), -to, power, z.vpl.edges + 1);
    let start = vpl::end(&z.vpl.point, to);
    let offset = vpl::end(&point, -to) - start;
    let ray = gnurt_accel::Ray::new(start.into(), offset.into()).within(0.0, END);
    Some(Join { ray, of, vpl, mask: end.mask })
}

/// Whether light from `from` reaches the side of a hit point.
fn is_lit(point: &SurfacePoint, from: Vec3) -> bool {
    is_open(point, from) && point.ng.dot(from) > 0.0
}
