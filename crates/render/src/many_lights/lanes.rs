// SPDX-License-Identifier: GPL-3.0-or-later
//! One virtual light on a block of points, lane by lane: geometry, both ends' BSDFs, the bound.
//! Source: [Kel97]; loops over arrays that compilers turn into vector code. Space: world.
//! Ends are Lambertian, or facets over a body, of which Lambert's reflector is one; what is neither is left to
//! `Vpl::brings`. Shadow rays start at the light: as a cone from one point they are narrower than as a bundle to it.
//! Invariant: lanes compute what `Vpl::brings` computes, up to rounding; every CPU level gives the same bits.
//! Proof: `tests::lanes_agree_with_single_points`.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;
use gnurt_accel::Pencil;
use gnurt_shading::SurfacePoint;
use gnurt_shading::bsdf::{FacetLanes, Facets, GRAZING, SentBack};

use super::bound::Bound;
use super::eye::EyePoint;
use super::vpl::{self, Vpl};

/// Points per block: as many as rays that the tree takes at a time.
pub(super) const BLOCK: usize = Pencil::MOST;

pub(super) type Lanes = [f32; BLOCK];

/// Points as lanes.
pub(super) struct Block {
    p: [Lanes; 3],
    /// Where rays end on the side of the normals.
    end: [Lanes; 3],
    /// Shading normals of the BSDFs, those of the mesh, geometric ones; where a point is lifted to the curved surface that
    /// the mesh stands for, the latter do not count.
    bent: [Lanes; 3],
    ns: [Lanes; 3],
    ng: [Lanes; 3],
    lifted: Lanes,
    /// Albedo / pi times throughput where the point is Lambertian.
    diffuse: [Lanes; 3],
    throughput: [Lanes; 3],
    /// Most edges that a virtual light's path may have.
    most_edges: Lanes,
    /// All lanes that are facets over a body or Lambertian, if some are not Lambertian.
    facets: Option<Box<FacetLanes<BLOCK>>>,
    /// Lanes that are neither.
    pub(super) other: Vec<usize>,
    /// Least and greatest places and shading normals.
    places: Extent,
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

/// What one virtual light brings to a block.
#[derive(Default)]
pub(super) struct Light {
    /// Shadow rays from the light; where no light is to be tested for shadow there is none.
    pub(super) rays: Pencil,
    /// What arrives if nothing is in between.
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

    /// Adds the lanes whose bits are not set.
    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self, except: u64) {
        // All bits or none: then this is plain arithmetic on lanes.
        let mut kept = [0_u32; BLOCK];
        for (i, kept) in kept.iter_mut().enumerate() {
            let half = (except >> (i & 32)) as u32;
            *kept = (half >> (i & 31) & 1).wrapping_sub(1);
        }
        for (sums, colors) in self.0.iter_mut().zip(&other.0) {
            for i in 0..BLOCK {
                sums[i] += f32::from_bits(colors[i].to_bits() & kept[i]);
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
    /// Of Lambertian ones.
    diffuse: Option<Vec3>,
    edges: f32,
    /// On the density, per area.
    bound: f32,
    /// Of facets over a body.
    facets: Option<Box<Sender>>,
    pub(super) vpl: Vpl,
}

/// Facets over a body that send light.
#[derive(Clone, Debug)]
struct Sender {
    /// Seen from where the light came from.
    facets: Facets,
    table: SentBack,
    /// What to multiply to their value, times the cosine of the geometric normal over that of the shading normal.
    power: Vec3,
}

impl Source {
    pub(super) fn new(vpl: &Vpl, bound: &Bound) -> Self {
        let sender = || {
            let came = vpl.point.ng.dot(vpl.from);
            let facets = Facets::new(&vpl.bsdf, vpl.from)?;
            let power = vpl.power * (facets.cos() / came);
            Some(Box::new(Sender { facets, table: facets.sent_back(), power }))
        };
        Self {
            p: vpl.point.p,
            start: vpl::end(&vpl.point, vpl.point.ng),
            bent: vpl.bsdf.normal(),
            ng: vpl.point.ng,
            diffuse: vpl.diffuse,
            edges: vpl.edges as f32,
            bound: bound.density(),
            facets: if vpl.diffuse.is_some() { None } else { sender() },
            vpl: *vpl,
        }
    }

    /// The same light, `share` times as strong.
    pub(super) fn scaled(&self, share: f32) -> Self {
        let mut scaled = Self { vpl: self.vpl.scaled(share), ..self.clone() };
        scaled.diffuse = scaled.vpl.diffuse;
        if let Some(facets) = &mut scaled.facets {
            facets.power *= share;
        }
        scaled
    }

    /// Whether lanes know what it sends.
    fn is_known(&self) -> bool {
        self.diffuse.is_some() || self.facets.is_some()
    }
}

impl Block {
    pub(super) fn new(points: &[EyePoint], max_edges: u32) -> Self {
        let zero = [[0.0; BLOCK]; 3];
        let mut block = Self {
            p: zero,
            end: zero,
            bent: zero,
            ns: zero,
            ng: zero,
            lifted: [0.0; BLOCK],
            diffuse: zero,
            throughput: zero,
            most_edges: [-1.0; BLOCK],
            facets: None,
            other: Vec::new(),
            places: Extent::NONE,
            normals: Extent::NONE,
        };
        if points.iter().any(|eye| eye.bsdf.lambertian().is_none()) {
            block.facets = Some(Box::default());
        }
        for (i, eye) in points.iter().enumerate() {
            let point = &eye.point;
            // Lights below the horizon are left out later.
            let end = point.scatter_ray(point.ns, false, 1.0).map_or(point.p, |ray| ray.org.into());
            let lambertian = eye.bsdf.lambertian();
            let diffuse = lambertian.unwrap_or(Vec3::ZERO) * eye.throughput * FRAC_1_PI;
            for k in 0..3 {
                block.p[k][i] = point.p[k];
                block.end[k][i] = end[k];
                block.bent[k][i] = eye.bsdf.normal()[k];
                block.ns[k][i] = point.ns[k];
                block.ng[k][i] = point.ng[k];
                block.diffuse[k][i] = diffuse[k];
                block.throughput[k][i] = eye.throughput[k];
            }
            block.places.add(point.p);
            block.normals.add(point.ns);
            block.lifted[i] = f32::from(u8::from(point.lift != Vec3::ZERO));
            block.most_edges[i] = max_edges as f32 - 1.0 - eye.edges as f32;
            let facets = block
                .facets
                .as_mut()
                .map(|lanes| Facets::new(&eye.bsdf, eye.wo).map(|facets| lanes.set(i, &facets)).is_some());
            if !facets.unwrap_or(true) {
                block.other.push(i);
                block.most_edges[i] = -1.0;
            }
        }
        block
    }

    /// Whether `source`, which lanes know, may bring anything to lanes that they know: one test for all of them. Rounding
    /// may lose what is all but below a horizon.
    pub(super) fn may_get(&self, source: &Source) -> bool {
        let way = Extent { low: source.p - self.places.high, high: source.p - self.places.low };
        let back = Extent { low: -source.ng, high: -source.ng };
        way.most_dot(&back) > 0.0 && way.most_dot(&self.normals) > 0.0
    }
}

/// Rays end this share short of the far end: rounding of their own numbers.
pub(crate) const END: f32 = 1.0 - 8.0 * f32::EPSILON;

/// Room for what lanes need on the way.
pub(super) struct Work {
    /// Unit, towards the light.
    to: [Lanes; 3],
    /// Cosines to the shading normals of both ends, of points and of the light.
    eye_b: Lanes,
    vpl_b: Lanes,
    /// To the geometric ones.
    eye_g: Lanes,
    vpl_g: Lanes,
    /// One over the square of the distance; 0 where nothing is brought.
    near: Lanes,
    /// What facets of one end send back at once.
    back: [Lanes; 2],
    /// What the light sends, and the density with which it chooses points.
    sent: [Lanes; 3],
    pdf_vpl: Lanes,
}

impl Default for Work {
    fn default() -> Self {
        let none = [0.0; BLOCK];
        Self {
            to: [none; 3],
            eye_b: none,
            vpl_b: none,
            eye_g: none,
            vpl_g: none,
            near: none,
            back: [none; 2],
            sent: [none; 3],
            pdf_vpl: none,
        }
    }
}

impl Block {
    /// What `source` brings; the lanes of `other` are left dark. Says how many lanes get something, if lanes know what it
    /// sends.
    #[inline(always)]
    pub(super) fn light(&self, source: &Source, work: &mut Work, light: &mut Light) -> Option<u32> {
        if !source.is_known() {
            return None;
        }
        light.rays.org = source.start.into();
        if let (None, Some(diffuse)) = (&self.facets, source.diffuse) {
            return Some(lambertian(self, source, diffuse, light));
        }
        geometry(self, source, work, light);
        match &source.facets {
            Some(sender) => sent_by_facets(sender, work),
            None => sent_by_lambert(source.diffuse.unwrap_or_default(), work),
        }
        Some(match &self.facets {
            Some(facets) => got_by_facets(self, facets, source.bound, work, light),
            None => got_by_lambert(self, source.bound, work, light),
        })
    }

    /// Where lane `i`'s shadow ray from a light ends.
    pub(super) fn end(&self, i: usize) -> Vec3 {
        Vec3::new(self.end[0][i], self.end[1][i], self.end[2][i])
    }
}

/// Cosines to the way between a lane and a light, times the length of the way.
struct Cosines {
    /// To the shading normals of point and light.
    eye_b: f32,
    vpl_b: f32,
    /// To the geometric ones.
    eye_g: f32,
    vpl_g: f32,
    /// Whether each sees the other's front, and paths may be that long.
    sees: bool,
}

impl Block {
    /// From lane `i` to the light.
    #[inline(always)]
    fn way(&self, i: usize, source: &Source) -> [f32; 3] {
        [source.p.x - self.p[0][i], source.p.y - self.p[1][i], source.p.z - self.p[2][i]]
    }

    #[inline(always)]
    fn cosines(&self, i: usize, source: &Source, [x, y, z]: [f32; 3]) -> Cosines {
        let to = |normal: &[Lanes; 3]| normal[0][i] * x + normal[1][i] * y + normal[2][i] * z;
        let from = |normal: Vec3| -(normal.x * x + normal.y * y + normal.z * z);
        let (eye_b, eye_s, eye_g) = (to(&self.bent), to(&self.ns), to(&self.ng));
        let (vpl_b, vpl_g) = (from(source.bent), from(source.ng));
        let above = (eye_s > 0.0) & ((eye_g > 0.0) | (self.lifted[i] > 0.0));
        let sees = above & (eye_b > 0.0) & (vpl_g > 0.0) & (source.edges <= self.most_edges[i]);
        Cosines { eye_b, vpl_b, eye_g, vpl_g, sees }
    }

    /// The shadow ray's way.
    #[inline(always)]
    fn shadow_way(&self, i: usize, source: &Source) -> [f32; 3] {
        let [x, y, z] = &self.end;
        [x[i] - source.start.x, y[i] - source.start.y, z[i] - source.start.z]
    }
}

/// Lambertian virtual light on a Lambertian block: a plain loop that becomes lanes. So there is no sum of floats in it,
/// whose order would keep the compiler from that.
#[inline(always)]
fn lambertian(block: &Block, source: &Source, diffuse: Vec3, light: &mut Light) -> u32 {
    let (mut lit, bound) = (0, source.bound * PI);
    let ([wx, wy, wz], t_far) = light.rays.lanes();
    let [r, g, b] = &mut light.color.0;
    for i in 0..BLOCK {
        let [x, y, z] = block.way(i, source);
        let distance2 = x * x + y * y + z * z;
        let Cosines { eye_b, vpl_b, eye_g, vpl_g, sees } = block.cosines(i, source, [x, y, z]);
        let over = 1.0 / (distance2 * distance2);
        // Both ways to choose the edge, as cosines over distance squared.
        let largest = (eye_b * vpl_g).max(vpl_b * eye_g.abs()) * over;
        let share = if largest > bound { bound / largest } else { 1.0 };
        let value = if sees & (over < f32::INFINITY) { eye_b * vpl_g * over * share } else { 0.0 };
        r[i] = value * block.diffuse[0][i] * diffuse.x;
        g[i] = value * block.diffuse[1][i] * diffuse.y;
        b[i] = value * block.diffuse[2][i] * diffuse.z;
        let is_lit = r[i] + g[i] + b[i] > 0.0;
        t_far[i] = if is_lit { END } else { -1.0 };
        lit += u32::from(is_lit);
        [wx[i], wy[i], wz[i]] = block.shadow_way(i, source);
    }
    lit
}

/// What arrives at points that are facets or Lambertian.
#[inline(always)]
fn got_by_facets(
    block: &Block,
    facets: &FacetLanes<BLOCK>,
    bound: f32,
    work: &mut Work,
    light: &mut Light,
) -> u32 {
    facets.sent_back(&work.eye_b, &mut work.back);
    let work = &*work;
    let Work { to, eye_b, back, .. } = work;
    let throughput = &block.throughput;
    got(
        bound,
        work,
        light,
        #[inline(always)]
        |i| {
            let to = [to[0][i], to[1][i], to[2][i]];
            let ([r, g, b], pdf) = facets.lane(i).eval(to, eye_b[i], [back[0][i], back[1][i]]);
            ([r * throughput[0][i], g * throughput[1][i], b * throughput[2][i]], pdf)
        },
    )
}

/// What arrives at Lambertian points.
#[inline(always)]
fn got_by_lambert(block: &Block, bound: f32, work: &Work, light: &mut Light) -> u32 {
    let [r, g, b] = &block.diffuse;
    let cos = &work.eye_b;
    got(
        bound,
        work,
        light,
        #[inline(always)]
        |i| ([r[i] * cos[i], g[i] * cos[i], b[i] * cos[i]], cos[i] * FRAC_1_PI),
    )
}

/// `value(i)` is what lane `i` makes of light, and the density with which it chooses where that comes from.
#[inline(always)]
fn got(bound: f32, work: &Work, light: &mut Light, value: impl Fn(usize) -> ([f32; 3], f32)) -> u32 {
    let Work { eye_g, vpl_g, near, sent, pdf_vpl, .. } = work;
    let [r, g, b] = &mut light.color.0;
    let (_, t_far) = light.rays.lanes();
    let mut lit = 0;
    for i in 0..BLOCK {
        let (got, pdf_eye) = value(i);
        // Both ways to choose the edge, as densities per area.
        let largest = (pdf_eye * vpl_g[i]).max(pdf_vpl[i] * eye_g[i].abs()) * near[i];
        let value = near[i] * if largest > bound { bound / largest } else { 1.0 };
        let is_near = near[i] > 0.0;
        r[i] = if is_near { got[0] * sent[0][i] * value } else { 0.0 };
        g[i] = if is_near { got[1] * sent[1][i] * value } else { 0.0 };
        b[i] = if is_near { got[2] * sent[2][i] * value } else { 0.0 };
        let is_lit = r[i] + g[i] + b[i] > 0.0;
        t_far[i] = if is_lit { END } else { -1.0 };
        lit += u32::from(is_lit);
    }
    lit
}

/// What a virtual light of facets sends, and the density with which it chooses each lane.
#[inline(always)]
fn sent_by_facets(sender: &Sender, work: &mut Work) {
    let Sender { facets, table, power } = sender;
    let Work { to, vpl_b, vpl_g, back, sent, pdf_vpl, .. } = work;
    for i in 0..BLOCK {
        [back[0][i], back[1][i]] = table.at(vpl_b[i].max(GRAZING));
    }
    let (n, [x, y, z]) = (facets.normal(), sent);
    for i in 0..BLOCK {
        let lift = (GRAZING - vpl_b[i]).max(0.0);
        let way = [lift * n[0] - to[0][i], lift * n[1] - to[1][i], lift * n[2] - to[2][i]];
        let to_unit = 1.0 / (way[0] * way[0] + way[1] * way[1] + way[2] * way[2]).sqrt();
        let way = [way[0] * to_unit, way[1] * to_unit, way[2] * to_unit];
        let cos = (vpl_b[i] + lift) * to_unit;
        let (value, pdf) = facets.eval(way, cos, [back[0][i], back[1][i]]);
        let tilt = vpl_g[i] / cos;
        (x[i], y[i], z[i]) =
            (value[0] * power.x * tilt, value[1] * power.y * tilt, value[2] * power.z * tilt);
        pdf_vpl[i] = if vpl_b[i] > 0.0 { pdf } else { 0.0 };
    }
}

/// The same of a Lambertian one.
#[inline(always)]
fn sent_by_lambert(diffuse: Vec3, work: &mut Work) {
    let Work { vpl_b, vpl_g, sent, pdf_vpl, .. } = work;
    let [x, y, z] = sent;
    for i in 0..BLOCK {
        (x[i], y[i], z[i]) = (diffuse.x * vpl_g[i], diffuse.y * vpl_g[i], diffuse.z * vpl_g[i]);
        pdf_vpl[i] = vpl_b[i].max(0.0) * FRAC_1_PI;
    }
}

/// Directions, cosines, distances, and the ways of shadow rays.
#[inline(always)]
fn geometry(block: &Block, source: &Source, work: &mut Work, light: &mut Light) {
    let ([wx, wy, wz], _) = light.rays.lanes();
    let [tx, ty, tz] = &mut work.to;
    for i in 0..BLOCK {
        let [x, y, z] = block.way(i, source);
        let near = 1.0 / (x * x + y * y + z * z);
        let to_unit = near.sqrt();
        let to = [x * to_unit, y * to_unit, z * to_unit];
        let Cosines { eye_b, vpl_b, eye_g, vpl_g, sees } = block.cosines(i, source, to);
        work.near[i] = if sees & (near < f32::INFINITY) { near } else { 0.0 };
        work.eye_b[i] = eye_b.max(f32::MIN_POSITIVE);
        work.vpl_b[i] = vpl_b;
        (work.eye_g[i], work.vpl_g[i]) = (eye_g, vpl_g);
        [tx[i], ty[i], tz[i]] = to;
        [wx[i], wy[i], wz[i]] = block.shadow_way(i, source);
    }
}

impl Block {
    /// Shadow rays from a point to the lanes that see its front; those of `other` count as others do, by their normals.
    #[inline(always)]
    pub(super) fn ways_from(&self, point: &SurfacePoint, rays: &mut Pencil) {
        let (p, n, start) = (point.p, point.ng, vpl::end(point, point.ng));
        rays.org = start.into();
        let ([wx, wy, wz], t_far) = rays.lanes();
        for i in 0..BLOCK {
            let way = [p.x - self.p[0][i], p.y - self.p[1][i], p.z - self.p[2][i]];
            let to =
                |normal: &[Lanes; 3]| normal[0][i] * way[0] + normal[1][i] * way[1] + normal[2][i] * way[2];
            let above = (to(&self.ns) > 0.0) & ((to(&self.ng) > 0.0) | (self.lifted[i] > 0.0));
            let front = n.x * way[0] + n.y * way[1] + n.z * way[2] < 0.0;
            t_far[i] = if above & front { END } else { -1.0 };
            let [x, y, z] = &self.end;
            (wx[i], wy[i], wz[i]) = (x[i] - start.x, y[i] - start.y, z[i] - start.z);
        }
    }

    /// Densities per area with which rays that the lanes' BSDFs choose meet the front of a point, if nothing is in between;
    /// of `other` lanes they are not known.
    #[inline(always)]
    pub(super) fn densities(&self, point: &SurfacePoint, out: &mut Lanes) {
        let (p, n) = (point.p, point.ng);
        for (i, out) in out.iter_mut().enumerate() {
            let [x, y, z] = [p.x - self.p[0][i], p.y - self.p[1][i], p.z - self.p[2][i]];
            let near = 1.0 / (x * x + y * y + z * z);
            let to_unit = near.sqrt();
            let to = [x * to_unit, y * to_unit, z * to_unit];
            let cos = self.bent[0][i] * to[0] + self.bent[1][i] * to[1] + self.bent[2][i] * to[2];
            let front = -(n.x * to[0] + n.y * to[1] + n.z * to[2]);
            let chosen = match &self.facets {
                Some(facets) => facets.lane(i).eval(to, cos.max(f32::MIN_POSITIVE), [0.0; 2]).1,
                None => cos * FRAC_1_PI,
            };
            let density = chosen * front * near;
            *out = if (cos > 0.0) & (front > 0.0) & (density < f32::INFINITY) { density } else { 0.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use gnurt_shading::bsdf::{Bsdf, Lobe, Model, Principled};
    use gnurt_shading::sampling::{Basis, sample_pair, uniform_sphere};
    use gnurt_shading::{SampleKey, SurfacePoint};

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
        Bsdf::new(ns, Model::Lambert { albedo: Vec3::new(r, g, 0.5) })
    }

    /// Plastic, metal, something between, or Lambert's reflector.
    fn facets(n: u32, ns: Vec3) -> Bsdf {
        let metallic = [0.0, 1.0, 0.5][n as usize % 3];
        let roughness = 0.3 + 0.7 * random(n, 4)[0];
        let principled = Principled::new(Vec3::new(0.8, 0.5, 0.2), metallic, roughness, 1.5);
        if n.is_multiple_of(4) { lambert(n, ns) } else { Bsdf::new(ns, Model::Principled(principled)) }
    }

    type Make = fn(u32, Vec3) -> Bsdf;

    #[test]
    fn lanes_agree_with_single_points() {
        let ways: [(Make, Make); 4] =
            [(lambert, lambert), (lambert, facets), (facets, lambert), (facets, facets)];
        for (of_eyes, of_lights) in ways {
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
        let block = Block::new(&eyes, max_edges);
        let (mut lit, mut bounded) = (0, 0);
        let mut work = Work::default();
        for n in 1000..1100 {
            let point = point(n);
            let bsdf = of_lights(n, point.ns);
            let vpl = Vpl::new(point, bsdf, point.ns, Vec3::new(3.0, 2.0, 1.0), 2 + n % 3);
            let (source, mut light) = (Source::new(&vpl, &bound), Light::default());
            let asked = block.light(&source, &mut work, &mut light).expect("lanes know");
            assert!(block.other.is_empty(), "all of them");
            assert!(asked == 0 || block.may_get(&source), "light {n} is not left out");
            let rays = light.rays.t_far().iter().filter(|&&far| far > 0.0).count();
            assert_eq!(asked as usize, rays, "light {n}: lanes that ask");
            for (i, eye) in eyes.iter().enumerate() {
                let wanted = vpl.brings(eye, &bound, max_edges).unwrap_or(Vec3::ZERO);
                let found = light.color.get(i);
                let off = (found - wanted).length() / wanted.length().max(1e-2);
                assert!(off < 1e-3, "light {n}, point {i}: {found} instead of {wanted}");
                let is_dark = wanted.length() < 1e-6;
                assert!(is_dark || light.rays.t_far()[i] > 0.0, "light {n}, point {i}: asks for shadow");
                let free = vpl.brings(eye, &Bound::on_geometry_term(f32::INFINITY), max_edges);
                lit += u32::from(wanted != Vec3::ZERO);
                bounded += u32::from(free.is_some_and(|free| free.x > wanted.x * 1.01));
            }
        }
        assert!(lit > 200 && bounded > 20, "the test has something to test: {lit}, {bounded}");
    }

    #[test]
    fn densities_are_those_of_single_points() {
        for of_eyes in [lambert as Make, facets] {
            let eyes: Vec<EyePoint> = (0..BLOCK as u32)
                .map(|n| {
                    let point = point(n);
                    let wo = (point.ns + 0.5 * point.ng).normalize();
                    let bsdf = of_eyes(n, point.ns);
                    EyePoint { point, wo, bsdf, throughput: Vec3::ONE, edges: 1, lane: n }
                })
                .collect();
            let block = Block::new(&eyes, 6);
            let (mut densities, mut rays, mut some) = (Densities::default(), Pencil::EMPTY, 0);
            for n in 1000..1020 {
                let point = point(n);
                block.densities(&point, &mut densities.0);
                block.ways_from(&point, &mut rays);
                for (i, eye) in eyes.iter().enumerate() {
                    let way = point.p - eye.point.p;
                    let to = way.normalize();
                    let is_seen = vpl::is_open(&eye.point, to) && eye.point.ns.dot(to) > 0.0;
                    let is_seen = is_seen && point.ng.dot(to) < 0.0;
                    assert_eq!(
                        rays.t_far()[i] > 0.0,
                        is_seen,
                        "point {n}, lane {i}: a ray where both see fronts"
                    );
                    if is_seen {
                        let wanted = eye.bsdf.pdf(eye.wo, to) * -point.ng.dot(to) / way.length_squared();
                        let found = densities.0[i];
                        assert!(
                            (found - wanted).abs() < 1e-3 * wanted.max(1e-2),
                            "{found} instead of {wanted}"
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
            Bsdf::new(ns, Model::Lobe(Lobe::OrenNayar { albedo: Vec3::ONE, roughness: n as f32 }))
        };
        let eye = |n: u32| {
            let point = point(n);
            let bsdf = if n == 2 { rough(1, point.ns) } else { lambert(n, point.ns) };
            EyePoint { point, wo: point.ns, bsdf, throughput: Vec3::ONE, edges: 1, lane: n }
        };
        let eyes: Vec<EyePoint> = (0..5).map(eye).collect();
        let (block, bound) = (Block::new(&eyes, 6), Bound::on_geometry_term(3.0));
        assert_eq!(block.other, [2], "one is neither Lambertian nor of facets");
        let (mut light, mut work) = (Light::default(), Work::default());
        let mut some = 0;
        for n in 1000..1100 {
            let point = point(n);
            let vpl = Vpl::new(point, lambert(n, point.ns), point.ns, Vec3::ONE, 1);
            let lit = block.light(&Source::new(&vpl, &bound), &mut work, &mut light);
            some += u32::from(lit > Some(0));
            let is_dark = light.rays.t_far()[2] < 0.0 && light.color.get(2) == Vec3::ZERO;
            assert!(is_dark, "dark until somebody else says");
            let other = Vpl::new(point, rough(1, point.ns), point.ns, Vec3::ONE, 1);
            let none = block.light(&Source::new(&other, &bound), &mut work, &mut light);
            assert!(none.is_none(), "lanes cannot know");
        }
        assert!(some > 10, "others are lit");
    }
}
