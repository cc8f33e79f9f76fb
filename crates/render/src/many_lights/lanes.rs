// SPDX-License-Identifier: GPL-3.0-or-later
//! One virtual light on a block of points, as many at a time as the CPU's registers hold: geometry, both ends' BSDFs, the bound.
//! Source: [Kel97]. Space: world.
//! Transmitting lights are left to `Vpl::brings`. Shadow rays start at the light: a cone from one point is
//! narrower than a bundle to it.
//! Invariant: lanes compute the same as `Vpl::brings`, up to rounding; every CPU level gives the same bits.
//! Tests: `tests::lanes_agree_with_single_points`.

use glam::Vec3;
use gnurt_accel::Pencil;
use gnurt_shading::SurfacePoint;
use gnurt_shading::bsdf::{CachedLobes, Carrying, GRAZING};
use gnurt_shading::lanes::LANES;
use gnurt_shading::real::{Real, Vector};
use gnurt_simd::{Level, dispatch_wide, f32x16, prelude::*};

use super::bound::Bound;
use super::eye::EyePoint;
use super::vpl::{self, Vpl};

/// Points per block: the largest pencil of the tree.
pub(super) const BLOCK: usize = Pencil::MOST;

pub(super) type Lanes = [f32; BLOCK];
type Lanes3 = [Lanes; 3];

/// Points as lanes.
pub(super) struct Block {
    p: Lanes3,
    /// Where rays end on the side of the normals.
    end: Lanes3,
    /// Shading normals of the BSDFs, those of the mesh, geometric ones; a point lifted to the curved surface
    /// that the mesh approximates ignores the latter.
    bent: Lanes3,
    ns: Lanes3,
    ng: Lanes3,
    lifted: Lanes,
    throughput: Lanes3,
    /// Most edges that a virtual light's path may have.
    most_edges: Lanes,
    /// Their lobes for the direction to the eye, in groups of sixteen.
    persistent: Vec<CachedLobes>,
    /// Lanes that light may go through.
    pub(super) other: Vec<usize>,
    /// Least and greatest positions and shading normals.
    positions: Extent,
    normals: Extent,
}

/// Least and greatest of some vectors.
#[derive(Clone, Copy)]
struct Extent {
    low: Vec3,
    high: Vec3,
}

impl Extent {
    const NONE: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    fn add(&mut self, v: Vec3) {
        (self.low, self.high) = (self.low.min(v), self.high.max(v));
    }

    /// The greatest dot product of one of its vectors and one of the other's, at least.
    fn most_dot(&self, other: &Self) -> f32 {
        let some = (self.low * other.low).max(self.low * other.high);
        some.max(self.high * other.low).max(self.high * other.high).element_sum()
    }
}

/// Light of one virtual light on a block.
#[derive(Default)]
pub(super) struct Light {
    /// Shadow rays from the light; where no light is to be tested for shadow there is none.
    pub(super) rays: Pencil,
    /// Unoccluded light.
    pub(super) color: Color,
}

/// Densities of lanes.
pub(super) struct Densities(pub(super) Lanes);

impl Default for Densities {
    fn default() -> Self {
        Self([0.0; BLOCK])
    }
}

/// Colours of lanes.
#[derive(Clone, Copy)]
pub(super) struct Color(pub(super) [Lanes; 3]);

impl Default for Color {
    fn default() -> Self {
        Self([[0.0; BLOCK]; 3])
    }
}

impl Color {
    pub(super) fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    pub(super) fn set(&mut self, i: usize, color: Vec3) {
        [self.0[0][i], self.0[1][i], self.0[2][i]] = color.into();
    }

    /// Adds the lanes whose bits are not set, times a weight.
    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self, except: u64, weight: f32) {
        // All bits or none: then this is plain arithmetic on lanes.
        let mut persistent = [0_u32; BLOCK];
        for (i, persistent) in persistent.iter_mut().enumerate() {
            let half = (except >> (i & 32)) as u32;
            *persistent = (half >> (i & 31) & 1).wrapping_sub(1);
        }
        for (sums, colors) in self.0.iter_mut().zip(&other.0) {
            for i in 0..BLOCK {
                sums[i] += f32::from_bits(colors[i].to_bits() & persistent[i]) * weight;
            }
        }
    }
}

/// The virtual light as lanes see it.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    p: Vec3,
    /// Where rays start on the side of the normals.
    start: Vec3,
    bent: Vec3,
    ng: Vec3,
    edges: f32,
    /// On the density, per area.
    pub(super) bound: f32,
    /// Its BSDF prepared for the light, and the factor of its value times the ratio of the cosines of the
    /// geometric and the shading normal; `None` for transmitting surfaces.
    sender: Option<(Box<Carrying>, Vec3)>,
    pub(super) vpl: Vpl,
}

impl Source {
    pub(super) fn new(vpl: &Vpl, bound: &Bound) -> Self {
        let sender = || {
            let carrying = Carrying::new(&vpl.bsdf, vpl.from);
            let power = vpl.power * (carrying.cos().max(GRAZING) / vpl.point.ng.dot(vpl.from));
            (Box::new(carrying), power)
        };
        Self {
            p: vpl.point.p,
            start: vpl::end(&vpl.point, vpl.point.ng),
            bent: vpl.bsdf.normal(),
            ng: vpl.point.ng,
            edges: vpl.edges as f32,
            bound: bound.density(),
            sender: (!vpl.bsdf.is_translucent()).then(sender),
            vpl: vpl.clone(),
        }
    }

    /// The same light, `share` times as strong.
    pub(super) fn scaled(&self, share: f32) -> Self {
        let mut scaled = self.clone();
        scaled.vpl = scaled.vpl.scaled(share);
        if let Some((_, power)) = &mut scaled.sender {
            *power *= share;
        }
        scaled
    }
}

impl Block {
    pub(super) fn new(points: &[&EyePoint], max_edges: u32) -> Self {
        let zero = [[0.0; BLOCK]; 3];
        let mut block = Self {
            p: zero,
            end: zero,
            bent: zero,
            ns: zero,
            ng: zero,
            lifted: [0.0; BLOCK],
            throughput: zero,
            most_edges: [-1.0; BLOCK],
            persistent: Vec::with_capacity(BLOCK / LANES),
            other: Vec::new(),
            positions: Extent::NONE,
            normals: Extent::NONE,
        };
        for (i, eye) in points.iter().enumerate() {
            let point = &eye.point;
            // Lights below the horizon are left out later.
            let end = point.scatter_ray(point.ns, false, 1.0).map_or(point.p, |ray| ray.org.into());
            for k in 0..3 {
                block.p[k][i] = point.p[k];
                block.end[k][i] = end[k];
                block.bent[k][i] = eye.bsdf.normal()[k];
                block.ns[k][i] = point.ns[k];
                block.ng[k][i] = point.ng[k];
                block.throughput[k][i] = eye.throughput[k];
            }
            block.positions.add(point.p);
            block.normals.add(point.ns);
            block.lifted[i] = f32::from(u8::from(point.lift != Vec3::ZERO));
            block.most_edges[i] = max_edges as f32 - 1.0 - eye.edges as f32;
            if eye.bsdf.is_translucent() {
                block.other.push(i);
                block.most_edges[i] = -1.0;
            }
        }
        for some in points.chunks(LANES) {
            block.persistent.push(CachedLobes::new(some.iter().map(|eye| (&eye.bsdf, eye.wo))));
        }
        block
    }

    /// Whether `source` may reach any of the lanes: one test for all of them. Rounding may lose lights just
    /// below a horizon; a transmitting light may shine to either side.
    pub(super) fn may_get(&self, source: &Source) -> bool {
        if source.sender.is_none() {
            return true;
        }
        let offset = Extent { low: source.p - self.positions.high, high: source.p - self.positions.low };
        let back = Extent { low: -source.ng, high: -source.ng };
        offset.most_dot(&back) > 0.0 && offset.most_dot(&self.normals) > 0.0
    }
}

/// Rays end this share short of the far end: rounding of their own numbers.
pub(crate) const END: f32 = 1.0 - 8.0 * f32::EPSILON;

#[inline(always)]
fn at<R: Real>(like: R, [x, y, z]: &Lanes3, first: usize) -> Vector<R> {
    Vector::load(like, [x, y, z], first)
}

impl Block {
    /// Light of `source`; the lanes of `other` stay dark. Returns the number of lit lanes, or `None` if the
    /// light has no lanes. One function for all callers: it is long.
    pub(super) fn light(&self, level: Level, source: &Source, light: &mut Light) -> Option<u32> {
        dispatch_wide!(
            level,
            simd => self.light_by(f32x16::splat(simd, 0.0), source, light),
            else self.light_by(0.0_f32, source, light)
        )
    }

    /// [`light`](Self::light); `like` only selects the number of points per step.
    #[inline(always)]
    fn light_by<R: Real>(&self, like: R, source: &Source, light: &mut Light) -> Option<u32> {
        let (sender, power) = source.sender.as_ref()?;
        light.rays.org = source.start.into();
        let (zero, mut lit) = (like.all(0.0), 0);
        let ([wx, wy, wz], t_far) = light.rays.lanes();
        let [bent_light, ng_light] = [source.bent, source.ng].map(|v| Vector::all(zero, v));
        let (start, p_light) = (Vector::all(zero, source.start), Vector::all(zero, source.p));
        for first in (0..BLOCK).step_by(R::LANES) {
            let offset = p_light - at(zero, &self.p, first);
            let near = zero.all(1.0) / offset.length_squared();
            let to = offset * near.root();
            let (eye_b, eye_s) = (at(zero, &self.bent, first).dot(to), at(zero, &self.ns, first).dot(to));
            let eye_g = at(zero, &self.ng, first).dot(to);
            let (vpl_b, vpl_g) = (-bent_light.dot(to), -ng_light.dot(to));
            let above = eye_s.above(zero)
                & (eye_g.above(zero) | zero.load(&self.lifted, first).above(zero))
                & eye_b.above(zero);
            let sees = above
                & vpl_g.above(zero)
                & zero.load(&self.most_edges, first).above(zero.all(source.edges - 0.5))
                & near.is_number();
            let mut color = Vector::grey(zero);
            let mut bright = sees;
            if R::any(sees) {
                // Raised to where it sees the light's front, as views are.
                let lift = (zero.all(GRAZING) - vpl_b).or_more(zero);
                let away = (bent_light * lift - to).normalize();
                let (value, pdf) = sender.eval_pdf_all(away);
                let sent = value * Vector::all(zero, *power) * (vpl_g / bent_light.dot(away));
                let pdf_vpl = R::pick(vpl_b.above(zero), pdf, zero);
                let (got, pdf_eye) = self.reflected_at(first, to);
                // Both densities of the edge, per area.
                let largest = (pdf_eye * vpl_g).or_more(pdf_vpl * eye_g.size()) * near;
                let bound = zero.all(source.bound);
                let share = R::pick(largest.above(bound), bound / largest, zero.all(1.0));
                let brought = got * at(zero, &self.throughput, first) * sent * (near * share);
                color = Vector::pick(sees & brought.is_finite(), brought, color);
                bright = color.sum().above(zero);
            }
            let to_lanes = at(zero, &self.end, first) - start;
            let far = R::pick(bright, zero.all(END), zero.all(-1.0));
            let all = zero.is(zero);
            lit += R::bits(bright).count_ones();
            let [r, g, b] = &mut light.color.0;
            color.squeeze(all, [r, g, b], first);
            to_lanes.squeeze(all, [wx, wy, wz], first);
            far.squeeze(all, t_far, first);
        }
        Some(lit)
    }

    /// Reflectance of the points from `first` on for light from the unit vector `to`, and the density with
    /// which they choose it.
    #[inline(always)]
    fn reflected_at<R: Real>(&self, first: usize, to: Vector<R>) -> (Vector<R>, R) {
        match self.persistent.get(first / LANES) {
            Some(persistent) => persistent.eval_pdf(first % LANES, to),
            None => (Vector::grey(to.x.all(0.0)), to.x.all(0.0)),
        }
    }

    /// Where lane `i`'s shadow ray from a light ends.
    pub(super) fn end(&self, i: usize) -> Vec3 {
        Vec3::new(self.end[0][i], self.end[1][i], self.end[2][i])
    }

    /// Shadow rays from a point to the lanes that see its front; those of `other` count as others do, by their normals.
    #[inline(always)]
    pub(super) fn directions_from<R: Real>(&self, like: R, point: &SurfacePoint, rays: &mut Pencil) {
        let zero = like.all(0.0);
        let start = vpl::end(point, point.ng);
        let (p, n, from) =
            (Vector::all(zero, point.p), Vector::all(zero, point.ng), Vector::all(zero, start));
        rays.org = start.into();
        let ([wx, wy, wz], t_far) = rays.lanes();
        for first in (0..BLOCK).step_by(R::LANES) {
            let offset = p - at(zero, &self.p, first);
            let above = at(zero, &self.ns, first).dot(offset).above(zero)
                & (at(zero, &self.ng, first).dot(offset).above(zero)
                    | zero.load(&self.lifted, first).above(zero));
            let front = zero.above(n.dot(offset));
            let (all, to_lanes) = (zero.is(zero), at(zero, &self.end, first) - from);
            R::pick(above & front, zero.all(END), zero.all(-1.0)).squeeze(all, t_far, first);
            to_lanes.squeeze(all, [wx, wy, wz], first);
        }
    }

    /// Densities per area with which rays that the lanes' BSDFs choose meet the front of a point, if nothing is in between;
    /// of `other` lanes they are not known.
    #[inline(always)]
    pub(super) fn densities<R: Real>(&self, like: R, point: &SurfacePoint, out: &mut Lanes) {
        let zero = like.all(0.0);
        let (p, n) = (Vector::all(zero, point.p), Vector::all(zero, point.ng));
        for first in (0..BLOCK).step_by(R::LANES) {
            let offset = p - at(zero, &self.p, first);
            let near = zero.all(1.0) / offset.length_squared();
            let to = offset * near.root();
            let front = -n.dot(to);
            let (_, chosen) = self.reflected_at(first, to);
            let density = chosen * front * near;
            let good =
                at(zero, &self.bent, first).dot(to).above(zero) & front.above(zero) & density.is_number();
            R::pick(good, density, zero).squeeze(zero.is(zero), out, first);
        }
    }
}

#[cfg(test)]
mod tests {
    use gnurt_shading::bsdf::{Bsdf, Lobe, Lobes, Principled};
    use gnurt_shading::sampling::{Basis, sample_pair, uniform_sphere};
    use gnurt_shading::{SampleKey, SurfacePoint};

    use gnurt_simd::{Level, dispatch_wide, f32x16, prelude::*};

    use super::*;

    fn random(n: u32, purpose: u32) -> [f32; 2] {
        sample_pair(5, SampleKey { pixel: n, sample: 0, branch: 0 }, 0, purpose)
    }

    /// A point somewhere in a cube, with a shading normal that is a little off.
    fn point(n: u32) -> SurfacePoint {
        let ([x, y], [z, tilt]) = (random(n, 0), random(n, 1));
        let ng = uniform_sphere(random(n, 2));
        let ns = (ng + Basis::around(ng).tangent * 0.3 * tilt).normalize();
        SurfacePoint { p: Vec3::new(x, y, z), error: 1e-6, ng, ns, lift: Vec3::ZERO }
    }

    fn lambert(n: u32, ns: Vec3) -> Bsdf {
        let [r, g] = random(n, 3);
        let albedo = Vec3::new(r, g, 0.5);
        // Smooth, and yet not alike to all sides.
        let lobe = if n % 5 == 3 { Lobe::burley(albedo, 0.0) } else { Lobe::lambert(albedo) };
        Bsdf::new(ns, lobe)
    }

    /// Plastic, metal, something between, or Lambert's reflector.
    fn microfacets(n: u32, ns: Vec3) -> Bsdf {
        let metallic = [0.0, 1.0, 0.5][n as usize % 3];
        let roughness = 0.3 + 0.7 * random(n, 4)[0];
        let principled = Principled::new(Vec3::new(0.8, 0.5, 0.2), metallic, roughness, 1.5);
        if n.is_multiple_of(4) { lambert(n, ns) } else { Bsdf::new(ns, principled) }
    }

    /// Lobes that few surfaces have, and lobes around normals of their own.
    fn odd(n: u32, ns: Vec3) -> Bsdf {
        let tint = Vec3::new(0.8, 0.5, 0.2);
        let tangent = Basis::around(ns).tangent;
        let tilted = |mut lobe: Lobe| {
            lobe.normal = (ns + 0.5 * tangent).normalize();
            lobe
        };
        let body = Lobe::lambert(tint);
        let lobes = match n % 10 {
            0 => Lobe::phong(30.0).into(),
            1 => Lobe::ward(0.4).into(),
            2 => Lobe::ward(0.3).brushed(tangent, 0.6).into(),
            3 => Lobes::from(tilted(Lobe::ward(0.5))).plus(body),
            4 => Lobe::fibres(tint, 0.6).into(),
            5 => Lobes::from(tilted(Lobe::coat(0.4))).over(body),
            6 => Lobes::from(Lobe::coat(0.4)).over(tilted(body)),
            7 => Lobes::from(tilted(body)).plus(Lobe::microfacets(0.5, tint, Vec3::ONE)),
            8 => Lobes::from(tilted(Lobe::fibres(tint, 0.4))).plus(body),
            _ => Lobes::from(tilted(Lobe::phong(9.0))).over(body),
        };
        Bsdf::new(ns, lobes)
    }

    type Make = fn(u32, Vec3) -> Bsdf;

    /// The result of the CPU's lanes, which must have the bits of single points.
    fn by_lanes(block: &Block, source: &Source, light: &mut Light) -> Option<u32> {
        let (mut one, lit) = (Light::default(), block.light_by(0.0_f32, source, light));
        for level in Level::available() {
            let many = dispatch_wide!(level, simd => block.light_by(f32x16::splat(simd, 0.0), source, &mut one), else continue);
            assert_eq!(many, lit, "{level}");
            if lit.is_none() {
                continue;
            }
            assert!(
                one.color.0 == light.color.0 && one.rays.t_far() == light.rays.t_far(),
                "{level} has other bits"
            );
        }
        lit
    }

    #[test]
    fn lanes_agree_with_single_points() {
        let makers: [(Make, Make); 7] = [
            (lambert, lambert),
            (lambert, microfacets),
            (microfacets, lambert),
            (microfacets, microfacets),
            (odd, lambert),
            (lambert, odd),
            (odd, odd),
        ];
        for (of_eyes, of_lights) in makers {
            agree(of_eyes, of_lights);
        }
    }

    fn agree(of_eyes: Make, of_lights: Make) {
        let eyes: Vec<EyePoint> = (0..BLOCK as u32)
            .map(|n| {
                let point = point(n);
                let (wo, throughput) = ((point.ns + 0.5 * point.ng).normalize(), Vec3::new(1.0, 0.5, 0.25));
                let bsdf = of_eyes(n, point.ns);
                EyePoint { point, wo, bsdf, throughput, edges: 1 + n % 3, lane: n }
            })
            .collect();
        let (max_edges, bound) = (6, Bound::on_geometry_term(3.0));
        let block = Block::new(&eyes.iter().collect::<Vec<_>>(), max_edges);
        let (mut lit, mut bounded) = (0, 0);
        for n in 1000..1100 {
            let point = point(n);
            let bsdf = of_lights(n, point.ns);
            let vpl = Vpl::new(point, bsdf, point.ns, Vec3::new(3.0, 2.0, 1.0), 2 + n % 3);
            let (source, mut light) = (Source::new(&vpl, &bound), Light::default());
            let requests = by_lanes(&block, &source, &mut light).expect("lanes know");
            assert!(block.other.is_empty(), "all of them");
            assert!(requests == 0 || block.may_get(&source), "light {n} is not left out");
            let rays = light.rays.t_far().iter().filter(|&&far| far > 0.0).count();
            assert_eq!(requests as usize, rays, "light {n}: lanes that ask");
            for (i, eye) in eyes.iter().enumerate() {
                // Lanes raise views to the front of the point's normal before those of lobes' own, single points do not.
                let tilted = vpl.bsdf.lobes().as_slice().iter().any(|lobe| lobe.normal != Vec3::ZERO);
                let away = (eye.point.p - point.p).normalize();
                if tilted && vpl.bsdf.normal().dot(away) < 2.0 * GRAZING {
                    continue;
                }
                let expected = vpl.brings(eye, &bound, max_edges).unwrap_or(Vec3::ZERO);
                let found = light.color.get(i);
                let off = (found - expected).length() / expected.length().max(1e-2);
                assert!(off < 1e-3, "light {n}, point {i}: {found} instead of {expected}");
                let is_dark = expected.length() < 1e-6;
                assert!(is_dark || light.rays.t_far()[i] > 0.0, "light {n}, point {i}: asks for shadow");
                let free = vpl.brings(eye, &Bound::on_geometry_term(f32::INFINITY), max_edges);
                lit += u32::from(expected != Vec3::ZERO);
                bounded += u32::from(free.is_some_and(|free| free.x > expected.x * 1.01));
            }
        }
        assert!(lit > 200 && bounded > 20, "the test has something to test: {lit}, {bounded}");
    }

    #[test]
    fn densities_are_those_of_single_points() {
        for of_eyes in [lambert as Make, microfacets, odd] {
            let eyes: Vec<EyePoint> = (0..BLOCK as u32)
                .map(|n| {
                    let point = point(n);
                    let wo = (point.ns + 0.5 * point.ng).normalize();
                    let bsdf = of_eyes(n, point.ns);
                    EyePoint { point, wo, bsdf, throughput: Vec3::ONE, edges: 1, lane: n }
                })
                .collect();
            let block = Block::new(&eyes.iter().collect::<Vec<_>>(), 6);
            let (mut densities, mut rays, mut some) = (Densities::default(), Pencil::EMPTY, 0);
            for n in 1000..1020 {
                let point = point(n);
                block.densities(0.0_f32, &point, &mut densities.0);
                block.directions_from(0.0_f32, &point, &mut rays);
                for (i, eye) in eyes.iter().enumerate() {
                    let offset = point.p - eye.point.p;
                    let to = offset.normalize();
                    let is_facing = vpl::is_open(&eye.point, to) && eye.point.ns.dot(to) > 0.0;
                    let is_facing = is_facing && point.ng.dot(to) < 0.0;
                    assert_eq!(
                        rays.t_far()[i] > 0.0,
                        is_facing,
                        "point {n}, lane {i}: a ray where both see fronts"
                    );
                    if is_facing {
                        let expected = eye.bsdf.pdf(eye.wo, to) * -point.ng.dot(to) / offset.length_squared();
                        let found = densities.0[i];
                        assert!(
                            (found - expected).abs() < 1e-3 * expected.max(1e-2),
                            "{found} instead of {expected}"
                        );
                        some += 1;
                    }
                }
            }
            assert!(some > 100, "the test has something to test: {some}");
        }
    }

    #[test]
    fn what_lanes_do_not_know_is_left_out() {
        let rough = |n: u32, ns: Vec3| {
            Bsdf::new(ns, Lobe::rough_glass(0.3 + n as f32, 1.5, Vec3::ONE, Vec3::ONE, true))
        };
        let eye = |n: u32| {
            let point = point(n);
            let bsdf = if n == 2 { rough(1, point.ns) } else { lambert(n, point.ns) };
            EyePoint { point, wo: point.ns, bsdf, throughput: Vec3::ONE, edges: 1, lane: n }
        };
        let eyes: Vec<EyePoint> = (0..5).map(eye).collect();
        let block = Block::new(&eyes.iter().collect::<Vec<_>>(), 6);
        let bound = Bound::on_geometry_term(3.0);
        assert_eq!(block.other, [2], "light goes through one");
        let mut light = Light::default();
        let mut some = 0;
        for n in 1000..1100 {
            let point = point(n);
            let vpl = Vpl::new(point, lambert(n, point.ns), point.ns, Vec3::ONE, 1);
            let lit = by_lanes(&block, &Source::new(&vpl, &bound), &mut light);
            some += u32::from(lit > Some(0));
            let is_dark = light.rays.t_far()[2] < 0.0 && light.color.get(2) == Vec3::ZERO;
            assert!(is_dark, "dark until somebody else says");
            let other = Vpl::new(point, rough(1, point.ns), point.ns, Vec3::ONE, 1);
            let none = by_lanes(&block, &Source::new(&other, &bound), &mut light);
            assert!(none.is_none(), "lanes cannot know");
            // It also transmits light to points behind it.
            let brings =
                |eye: &EyePoint| other.brings(eye, &bound, 6).is_some_and(|light| light != Vec3::ZERO);
            assert!(block.may_get(&Source::new(&other, &bound)) || !eyes.iter().any(brings), "light {n}");
        }
        assert!(some > 10, "others are lit");
    }
}
