// SPDX-License-Identifier: GPL-3.0-or-later
//! All emissive shapes of a scene as one light: a shape is chosen by its estimated contribution to the
//! point, a position on a triangle by area, on a sphere by angle.
//! Source: [TCE05] (resampled importance sampling), [SWZ96] (sampling many luminaires); [PJH23] section 6.5 (area to
//! solid angle). Differs: candidates are stratified by power, and one number chooses both the shape and
//! the position, see `choose`.
//! Space: world. One-sided: light leaves the side of the geometric normal; a two-sided emitter is two
//! triangles. Textures and opacity modulate it, or a surface's shader gives the exit radiance: choices use
//! each triangle's mean, light uses its position.
//! Tests: `tests::{rectangle_has_its_closed_form, many_emitters_add_up, nothing_is_wasted, textures_count_where_they_are}`,
//! crates/render/tests/{lights,glow}.rs.

use std::sync::Arc;

use glam::Vec3;
use gnurt_image::srgb::luminance;

use super::beam::Beam;
use super::light_estimates::{Aim, LEAST_SHARE};
use super::light_tree::LightBounds;
use super::shape::{Outline, Shape};
use crate::batch::Vec3s;
use crate::materials::{Coverage, Emission};
use crate::sampling::distribution::ALMOST_ONE;
use crate::sampling::{self, Distribution};
use crate::shader::{LightBatch, LightShader, SurfaceShader};
use crate::texture::TextureSampler;

/// Sampled points on one triangle.
const SAMPLE_COUNTS: [f32; 2] = [4.0, 256.0];

/// The emission of a group of triangles.
#[derive(Clone)]
pub struct Emitter {
    /// Empty if only `shader` defines it.
    emission: Emission,
    coverage: Option<Coverage>,
    /// The shader that gives the exit radiance.
    shader: Option<Arc<dyn SurfaceShader>>,
    /// Over the whole texture: found once, since textures are large.
    brightness: f32,
}

impl Emitter {
    /// Emits `emission`, weighted by `coverage`.
    #[must_use]
    pub fn new(emission: Emission, coverage: Option<Coverage>) -> Self {
        let brightness = emission.mean_luminance();
        Self { emission, coverage, shader: None, brightness }
    }

    /// Emits by `shader`, on both sides.
    #[must_use]
    pub fn by_shader(shader: Arc<dyn SurfaceShader>) -> Self {
        let emission = Emission::constant(Vec3::ZERO);
        Self { emission, coverage: None, shader: Some(shader), brightness: 0.0 }
    }

    /// Whether it gives off just this.
    #[must_use]
    pub fn gives_off(&self, emission: &Emission, coverage: Option<&Coverage>) -> bool {
        self.shader.is_none() && self.emission == *emission && self.coverage.as_ref() == coverage
    }

    /// The shader that gives the exit radiance, if it is not known otherwise.
    #[must_use]
    pub fn shader(&self) -> Option<&Arc<dyn SurfaceShader>> {
        self.shader.as_ref()
    }

    /// Mean brightness of a triangle whose corners have these texture coordinates and opacities, from a point
    /// for each of its texels. No triangle is quite dark, because its brightest texel may lie between them.
    /// Undefined if a shader defines the emission.
    #[must_use]
    pub fn mean_over(&self, uv: &[[f32; 2]; 3], opacity: [f32; 3]) -> f32 {
        let textures = [
            self.emission.texture.as_ref(),
            self.coverage.as_ref().and_then(|coverage| coverage.texture.as_ref()),
        ];
        if textures == [None, None] && opacity == [opacity[0]; 3] {
            return luminance(self.radiance(uv, opacity, [1.0 / 3.0; 2]).into());
        }
        let edge = |k: usize| [uv[k][0] - uv[0][0], uv[k][1] - uv[0][1]];
        let ([a, b], [c, d]) = (edge(1), edge(2));
        let texels = |texture: &TextureSampler| {
            let [e, f, g, h, ..] = texture.uv_from_mesh;
            let size = texture.texels.width as f32 * texture.texels.height as f32;
            0.5 * (a * d - b * c).abs() * (e * h - f * g).abs() * size
        };
        let texels = textures.into_iter().flatten().map(texels).fold(0.0, f32::max);
        let count = (2.0 * texels).clamp(SAMPLE_COUNTS[0], SAMPLE_COUNTS[1]) as u32;
        let probe = |i| {
            let position = sampling::triangle(looking_at(i));
            luminance(self.radiance(uv, opacity, position).into())
        };
        let mean = (0..count).map(probe).sum::<f32>() / count as f32;
        mean.max(LEAST_SHARE * self.brightness)
    }

    /// Exit radiance at the barycentric weights of the second and third corner.
    fn radiance(&self, uv: &[[f32; 2]; 3], opacity: [f32; 3], [b1, b2]: [f32; 2]) -> Vec3 {
        let uv = interpolate(uv, b1, b2);
        let radiance = self.emission.at(uv);
        // Weighted as the opacities of points that rays meet are.
        let weights = [1.0 - b1 - b2, b1, b2];
        let opacity = (0..3).map(|c| weights[c] * opacity[c]).sum();
        self.coverage.as_ref().map_or(radiance, |coverage| radiance * coverage.at(uv, opacity))
    }
}

/// Sample `i` for a mean, spread evenly over the unit square: Roberts's sequence.
#[must_use]
pub fn looking_at(i: u32) -> [f32; 2] {
    const STEPS: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];
    STEPS.map(|step| ((0.5 + f64::from(i) * step).fract() as f32).min(ALMOST_ONE))
}

/// A point on an emissive shape, and the ray towards it.
#[derive(Clone, Copy, Debug, Default)]
pub struct EmitterPoint {
    /// Number of the shape.
    pub shape: u32,
    /// The weights of a triangle's second and third corner, or a place of [`Outline::place`].
    pub position: [f32; 2],
    /// Unit, of a ray that comes to it: against its normal.
    pub dir: Vec3,
    /// How far the ray comes, world units; 1 where that is unknown.
    pub distance: f32,
}

/// Emission of shapes whose emitters have a shader.
pub trait EmitterShaders: Send + Sync {
    /// Writes the radiance that leaves each point against its ray, weighted by the surface's coverage.
    fn radiance(&self, requests: &[EmitterPoint], out: &mut [Vec3]);
}

/// An emissive shape.
#[derive(Clone, Debug)]
pub struct EmissiveShape {
    /// What it is.
    pub outline: Outline,
    /// Whether a triangle's second corner is the mesh's third, and vice versa.
    pub is_turned: bool,
    /// Texture coordinates of the corners.
    pub uv: [[f32; 2]; 3],
    /// Opacities of the vertices, by which the emitter's is multiplied.
    pub opacity: [f32; 3],
    /// Which emitter it belongs to.
    pub emitter: u32,
    /// Mean brightness, the weight of its choice.
    pub brightness: f32,
    /// Where its light goes, if that is to some directions alone.
    pub beam: Option<Arc<Beam>>,
}

/// One light of many shapes.
pub struct ShapeLights {
    all: Vec<EmissiveShape>,
    /// The data for choices, for each shape.
    pub(super) shapes: Vec<Shape>,
    emitters: Vec<Arc<Emitter>>,
    /// Emission of the emitters that have a shader.
    shaders: Option<Arc<dyn EmitterShaders>>,
    distribution: Distribution,
}

/// Shapes that compete for each sample.
const CANDIDATES: usize = 8;

/// A shape that was chosen.
struct Chosen {
    index: usize,
    /// Factor of its light: one over the probability of the choice, on average.
    weight: f32,
    /// Two fresh numbers in [0, 1).
    random: [f32; 2],
}

/// Light of a point of a shape, as [`LightBatch`] has it.
struct Arriving {
    dir: Vec3,
    dist: f32,
    radiance: Vec3,
    pdf: f32,
}

impl Arriving {
    fn write(&self, lane: usize, out: &mut LightBatch) {
        out.dir.set(lane, self.dir);
        out.dist[lane] = self.dist;
        out.radiance.set(lane, self.radiance);
        out.pdf[lane] = self.pdf;
    }
}

impl ShapeLights {
    /// `None` if no shape emits. Panics if a shape names an emitter that is not there.
    #[must_use]
    pub fn new(
        all: Vec<EmissiveShape>,
        emitters: Vec<Arc<Emitter>>,
        shaders: Option<Arc<dyn EmitterShaders>>,
    ) -> Option<Self> {
        let last = all.iter().map(|t| t.emitter as usize).max();
        assert!(last < Some(emitters.len()), "emitter {last:?} of {}", emitters.len());
        let power = |shape: &EmissiveShape| shape.outline.area() * f64::from(shape.brightness);
        let distribution = Distribution::new(all.iter().map(power))?;
        let shapes = all.iter().map(|shape| Shape::new(&shape.outline, shape.brightness)).collect();
        Some(Self { all, shapes, emitters, shaders, distribution })
    }

    /// How many shapes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there are no shapes: never, see [`new`](Self::new).
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Approximate unoccluded contribution of a shape to a surface at `p` of the unit `normal`; without a horizon if that is zero.
    pub(super) fn contribution(&self, index: usize, p: Vec3, normal: Vec3) -> f32 {
        let shape = &self.shapes[index];
        let even = shape.contribution(p, normal);
        self.all[index].beam.as_ref().map_or(even, |beam| even * beam.share(shape.seen().cells(p.into())))
    }

    /// The beams of shapes, by shape; empty if none has one.
    pub(super) fn beams(&self) -> Vec<Option<Arc<Beam>>> {
        if self.all.iter().all(|shape| shape.beam.is_none()) {
            return Vec::new();
        }
        self.all.iter().map(|shape| shape.beam.clone()).collect()
    }

    /// Bounds of all shapes.
    pub(super) fn bounds(&self) -> impl Iterator<Item = LightBounds> {
        self.shapes.iter().zip(&self.all).map(|(shape, of)| shape.bounds(of.beam.as_deref()))
    }

    /// Chooses among candidates in proportion to their contribution.
    ///
    /// Candidate k lies at `(k + random[0]) / CANDIDATES` of all power, so that candidates are spread over the lights.
    /// The mean is right for any joint law of the candidates, because each is weighted with one over its own
    /// probability and the choice is independent of all of them; the remainders of both numbers choose the
    /// position.
    fn choose(&self, p: Vec3, normal: Vec3, random: [f32; 2]) -> Option<Chosen> {
        let mut candidates = [(0, 0.0_f32, 0.0_f32); CANDIDATES];
        let mut weights = [0.0_f64; CANDIDATES];
        for (k, (candidate, weight)) in candidates.iter_mut().zip(&mut weights).enumerate() {
            let at = (k as f64 + f64::from(random[0])) / CANDIDATES as f64;
            let choice = self.distribution.sample(at);
            let contribution = self.contribution(choice.index, p, normal);
            *candidate = (choice.index, contribution, choice.rest);
            *weight = f64::from(contribution) / f64::from(choice.probability);
        }
        let sum: f64 = weights.iter().sum();
        let mut at = f64::from(random[1]) * sum;
        let last = weights.iter().rposition(|&weight| weight > 0.0)?;
        let k = (0..last).find(|&k| {
            let here = at < weights[k];
            at -= if here { 0.0 } else { weights[k] };
            here
        });
        let k = k.unwrap_or(last);
        let (index, contribution, rest) = candidates[k];
        let weight = (sum / (CANDIDATES as f64 * f64::from(contribution))) as f32;
        let fresh = ((at / weights[k]) as f32).clamp(0.0, ALMOST_ONE);
        weight.is_finite().then_some(Chosen { index, weight, random: [rest, fresh] })
    }

    /// As [`illuminate`](LightShader::illuminate), by the light of some triangles only.
    pub fn illuminate_some(
        &self,
        (p, normal): (&Vec3s, &Vec3s),
        random: &[[f32; 2]],
        counts: impl Fn(u32) -> bool,
        out: &mut LightBatch,
    ) {
        for (i, &random) in random.iter().enumerate() {
            let chosen = self.choose(p.get(i), normal.get(i), random);
            let chosen = chosen.filter(|chosen| counts(chosen.index as u32));
            if let Some(found) = chosen.and_then(|chosen| self.sample_on(&chosen, p.get(i))) {
                found.write(i, out);
            }
        }
    }

    /// Light of a point on a shape.
    fn sample(&self, p: Vec3, normal: Vec3, random: [f32; 2]) -> Option<Arriving> {
        self.sample_on(&self.choose(p, normal, random)?, p)
    }

    /// The same for a chosen shape.
    fn sample_on(&self, chosen: &Chosen, p: Vec3) -> Option<Arriving> {
        let shape = &self.shapes[chosen.index];
        let (position, dir, dist, solid_angle) = if shape.extent < 0.0 {
            let Aim { position, dir, dist, density } = shape.seen().aim(p.into(), chosen.random, true);
            (position, Vec3::from(dir), dist, chosen.weight / density)
        } else {
            let position = sampling::triangle(chosen.random);
            let offset = shape.nearest_image(p, position) - p;
            let distance2 = offset.length_squared();
            let dist = distance2.sqrt();
            let dir = offset / dist;
            let cos = -shape.normal.dot(dir);
            (position, dir, dist, cos / distance2 * shape.extent * chosen.weight)
        };
        if !(solid_angle > 0.0 && solid_angle.is_finite() && dist > 0.0) {
            return None;
        }
        let radiance = self.radiance(chosen.index, position, dir, dist);
        Some(Arriving { dir, dist, radiance: radiance * solid_angle, pdf: solid_angle.recip() })
    }

    /// Exit radiance of shape `index` if it is constant; `None` where it depends on the position.
    pub(super) fn even_radiance(&self, index: usize) -> Option<Vec3> {
        let emitter = &self.emitters[self.all[index].emitter as usize];
        let even =
            emitter.emission.texture.is_none() && emitter.coverage.is_none() && emitter.shader.is_none();
        even.then_some(emitter.emission.factor)
    }

    /// Exit radiance of shape `index` at a place against a ray along the unit `dir` that comes `distance` far.
    pub(super) fn radiance(&self, index: usize, position: [f32; 2], dir: Vec3, distance: f32) -> Vec3 {
        let mut out = [Vec3::ZERO];
        self.radiances(&[EmitterPoint { shape: index as u32, position, dir, distance }], &mut out);
        out[0]
    }

    /// The same for many points.
    pub(super) fn radiances(&self, requests: &[EmitterPoint], out: &mut [Vec3]) {
        let shape = |at: &EmitterPoint| &self.all[at.shape as usize];
        let emitter = |at: &EmitterPoint| &self.emitters[shape(at).emitter as usize];
        let mut of_shaders = false;
        for (at, out) in requests.iter().zip(out.iter_mut()) {
            let EmissiveShape { uv, opacity, .. } = shape(at);
            of_shaders |= emitter(at).shader.is_some();
            *out = emitter(at).radiance(uv, *opacity, at.position);
        }
        let Some(shaders) = self.shaders.as_ref().filter(|_| of_shaders) else { return };
        if requests.iter().all(|at| emitter(at).shader.is_some()) {
            shaders.radiance(requests, out);
            return;
        }
        let these: Vec<usize> =
            (0..requests.len()).filter(|&i| emitter(&requests[i]).shader.is_some()).collect();
        let emitter_points: Vec<EmitterPoint> = these.iter().map(|&i| requests[i]).collect();
        let mut found = vec![Vec3::ZERO; these.len()];
        shaders.radiance(&emitter_points, &mut found);
        these.into_iter().zip(found).for_each(|(i, found)| out[i] = found);
    }

    /// The same where a ray along `dir` met it at `p`, and at these barycentric weights of the mesh's second and third corner.
    pub(super) fn radiance_where_met(
        &self,
        index: usize,
        ([u, v], p): ([f32; 2], Vec3),
        dir: Vec3,
        distance: f32,
    ) -> Vec3 {
        let position = match (self.shapes[index].place_of(p), self.all[index].is_turned) {
            (Some(place), _) => place,
            (None, true) => [v, u],
            (None, false) => [u, v],
        };
        self.radiance(index, position, dir, distance)
    }
}

impl LightShader for ShapeLights {
    fn illuminate(&self, p: &Vec3s, normal: &Vec3s, random: &[[f32; 2]], out: &mut LightBatch) {
        for (i, &random) in random.iter().enumerate() {
            if let Some(found) = self.sample(p.get(i), normal.get(i), random) {
                found.write(i, out);
            }
        }
    }

    fn is_visible(&self) -> bool {
        true
    }
}

fn interpolate(uv: &[[f32; 2]; 3], b1: f32, b2: f32) -> [f32; 2] {
    [0, 1].map(|k| uv[0][k] + b1 * (uv[1][k] - uv[0][k]) + b2 * (uv[2][k] - uv[0][k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::sample_pair;

    /// A 2 x 2 square at height 1 that emits downwards, as two triangles of which one is cut in two.
    fn square() -> ShapeLights {
        let corner = |x, y| Vec3::new(x, y, 1.0);
        let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        let middle = corner(0.0, 0.0);
        let triangles = [[a, b, c], [a, middle, d], [middle, c, d]].map(|p| EmissiveShape {
            outline: Outline::Triangle(p),
            is_turned: false,
            uv: [[0.0; 2]; 3],
            opacity: [1.0; 3],
            emitter: 0,
            brightness: 2.0,
            beam: None,
        });
        let emission = Emission::constant(Vec3::new(1.0, 2.0, 3.0));
        ShapeLights::new(triangles.into(), vec![Arc::new(Emitter::new(emission, None))], None)
            .expect("it shines")
    }

    fn irradiance(light: &ShapeLights, p: Vec3, up: Vec3) -> Vec3 {
        const N: u32 = 1 << 14;
        let sum = (0..N).fold(Vec3::ZERO, |sum, sample| {
            let random = sample_pair(0, SampleKey { pixel: 1, sample, branch: 0 }, 0, 0);
            let lit = light.sample(p, up, random);
            sum + lit.map_or(Vec3::ZERO, |Arriving { dir, radiance, .. }| radiance * dir.dot(up).max(0.0))
        });
        sum / N as f32
    }

    #[test]
    fn rectangle_has_its_closed_form() {
        // Four equal corner rectangles of 1 x 1 at distance 1: the classic form factor, times pi.
        let corner = 1.0_f64 / 2.0_f64.sqrt();
        let expected = 4.0 * corner * corner.atan();
        let found = irradiance(&square(), Vec3::ZERO, Vec3::Z);
        assert!((f64::from(found.x) / expected - 1.0).abs() < 1e-3, "{} instead of {expected}", found.x);
        assert!((found.z / found.x - 3.0).abs() < 1e-4, "in all colours");
    }

    /// The brightness of all three is that of the square, so light times density is its radiance, from everywhere; the mean of one
    /// over the density is the solid angle that it covers.
    #[test]
    fn densities_are_those_of_the_light_s_directions() {
        const N: u32 = 1 << 14;
        let (light, p) = (square(), Vec3s::splat(1, Vec3::ZERO));
        let mut sum = 0.0;
        for sample in 0..N {
            let random = sample_pair(0, SampleKey { pixel: 3, sample, branch: 0 }, 0, 0);
            let mut out = LightBatch::default();
            out.reset(1);
            light.illuminate(&p, &Vec3s::splat(1, Vec3::Z), &[random], &mut out);
            let seen = out.radiance.get(0) * out.pdf[0];
            assert!((seen - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-4, "{seen}");
            sum += f64::from(out.pdf[0].recip());
        }
        // A pyramid over a square of side 2a at height h: 4 asin (a² / (a² + h²)).
        let expected = 4.0 * 0.5_f64.asin();
        let found = sum / f64::from(N);
        assert!((found / expected - 1.0).abs() < 2e-3, "{found} instead of {expected}");
    }

    #[test]
    fn the_back_is_dark() {
        let above = irradiance(&square(), Vec3::new(0.0, 0.0, 2.0), -Vec3::Z);
        assert_eq!(above, Vec3::ZERO, "light leaves one side only");
    }

    /// Fifty small lights of different brightness, half of them facing away, some below the horizon.
    fn emissive_triangles() -> Vec<[Vec3; 3]> {
        let triangle_light = |i: usize| {
            let middle = Vec3::new((i % 10) as f32 - 4.5, (i / 10) as f32 - 2.0, [1.0, 3.0, -0.5][i % 3]);
            let size = 0.05 + 0.02 * (i % 7) as f32;
            let p = [middle, middle + Vec3::Y * size, middle + Vec3::X * size];
            if i % 4 < 2 { p } else { [p[0], p[2], p[1]] }
        };
        (0..50).map(triangle_light).collect()
    }

    fn light_of(corners: &[[Vec3; 3]]) -> Option<ShapeLights> {
        const BRIGHTNESS: [f32; 4] = [1.0, 5.0, 40.0, 2.0];
        let emit = |factor| Arc::new(Emitter::new(Emission::constant(factor), None));
        let triangle = |(i, &p): (usize, &[Vec3; 3])| EmissiveShape {
            outline: Outline::Triangle(p),
            is_turned: false,
            uv: [[0.0; 2]; 3],
            opacity: [1.0; 3],
            emitter: (i % 2 + i % 3) as u32,
            brightness: BRIGHTNESS[i % 2 + i % 3],
            beam: None,
        };
        let emitters = BRIGHTNESS.map(|x| emit(Vec3::splat(x)));
        ShapeLights::new(corners.iter().enumerate().map(triangle).collect(), emitters.into(), None)
    }

    #[test]
    fn many_emitters_add_up() {
        let all = emissive_triangles();
        let joint = irradiance(&light_of(&all).expect("they shine"), Vec3::ZERO, Vec3::Z).x;
        // One at a time, the others made so small that they bring nothing.
        let one = |i: usize| {
            let mut single = all.clone();
            (0..50).filter(|&k| k != i).for_each(|k| single[k] = [Vec3::ZERO; 3]);
            light_of(&single).map_or(0.0, |light| irradiance(&light, Vec3::ZERO, Vec3::Z).x)
        };
        let expected: f32 = (0..50).map(one).sum();
        assert!((joint / expected - 1.0).abs() < 2e-3, "{joint} instead of {expected}");
    }

    #[test]
    fn nothing_is_wasted() {
        // Half of the power faces away or is below the horizon: chosen by power only, it would take half of
        // the samples.
        let light = light_of(&emissive_triangles()).expect("they shine");
        let dark = |shape: &Shape| shape.contribution(Vec3::ZERO, Vec3::Z) == 0.0;
        let wasted: f32 = light.shapes.iter().filter(|s| dark(s)).map(|s| s.power).sum();
        let all: f32 = light.shapes.iter().map(|s| s.power).sum();
        assert!(wasted / all > 0.4, "the scene is a hard one: {wasted} of {all}");
        let lit = |sample| {
            let random = sample_pair(5, SampleKey { pixel: 2, sample, branch: 0 }, 0, 0);
            let Arriving { dir, radiance, .. } = light.sample(Vec3::ZERO, Vec3::Z, random)?;
            Some(radiance.x * dir.z)
        };
        let samples: Vec<f32> = (0..1024).filter_map(lit).collect();
        assert_eq!(samples.len(), 1024, "every sample reaches a lamp that shines here");
        let expected = samples.iter().sum::<f32>() / 1024.0;
        let variance = samples.iter().map(|x| (x / expected - 1.0).powi(2)).sum::<f32>() / 1024.0;
        assert!(variance < 0.5, "relative variance {variance} of one sample");
    }

    #[test]
    fn dark_or_flat_triangles_are_no_light() {
        let emission = Emission::constant(Vec3::ONE);
        let emitter = Arc::new(Emitter::new(emission, None));
        let flat = EmissiveShape {
            outline: Outline::Triangle([Vec3::ZERO, Vec3::X, Vec3::X * 2.0]),
            is_turned: false,
            uv: [[0.0; 2]; 3],
            opacity: [1.0; 3],
            emitter: 0,
            brightness: 1.0,
            beam: None,
        };
        assert!(ShapeLights::new(vec![flat], vec![emitter], None).is_none(), "no area, no light");
    }

    #[test]
    fn textures_count_where_they_are() {
        // Bright in its left half only.
        let texel = |i: u32| if i % 8 < 4 { [2.0, 2.0, 2.0, 1.0] } else { [0.0, 0.0, 0.0, 1.0] };
        let data = gnurt_image::TexelData::Float((0..64).map(texel).collect());
        let texels = Arc::new(gnurt_image::Texels { width: 8, height: 8, data });
        let texture = TextureSampler { linear: false, ..TextureSampler::new(texels) };
        let emission = Emission { texture: Some(texture), ..Emission::constant(Vec3::splat(3.0)) };
        let emitter = Emitter::new(emission, None);
        let over = |u: [f32; 3]| emitter.mean_over(&[[u[0], 0.1], [u[1], 0.1], [u[2], 0.9]], [1.0; 3]);
        assert!((over([0.05, 0.45, 0.25]) - 6.0).abs() < 1e-5, "where it is bright");
        assert_eq!(over([0.55, 0.95, 0.75]), 3.0 * LEAST_SHARE, "where it is dark, it is not quite so");
        assert!((over([0.25, 0.75, 0.5]) - 3.0).abs() < 0.4, "half of it, by 25 places");
        let faint = Emitter::new(Emission::constant(Vec3::ONE), None);
        assert!((faint.mean_over(&[[0.0; 2]; 3], [0.5; 3]) - 1.0).abs() < 1e-6, "no coverage, no opacity");
    }
}
