// SPDX-License-Identifier: GPL-3.0-or-later
//! All emissive triangles of a scene as one light: a triangle in proportion to its power, a point on it by area.
//! Source: [SWZ96] (sampling many luminaires); [PJH23] section 6.5 (area to solid angle).
//! Space: world. One-sided: light leaves the side of the geometric normal. Textures and opacity modulate it.
//! Proof: `tests::rectangle_has_its_closed_form`, crates/render/tests/lights.rs.

use std::sync::Arc;

use glam::Vec3;

use crate::batch::Vec3s;
use crate::materials::{Coverage, Emission};
use crate::sampling::{Distribution, triangle};
use crate::shader::{LightBatch, LightShader};

/// What a group of triangles gives off.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// Radiance.
    pub emission: Emission,
    /// Where the surface is not there it does not shine.
    pub coverage: Option<Coverage>,
}

/// A triangle that shines, world space.
#[derive(Clone, Debug)]
pub struct EmissiveTriangle {
    /// Vertices, counter-clockwise seen from the side that shines.
    pub p: [Vec3; 3],
    /// Texture coordinates.
    pub uv: [[f32; 2]; 3],
    /// Which emitter it belongs to.
    pub emitter: u32,
}

/// One light of many triangles.
pub struct TriangleLights {
    triangles: Vec<EmissiveTriangle>,
    emitters: Vec<Arc<Emitter>>,
    distribution: Distribution,
}

impl TriangleLights {
    /// `None` if no triangle shines. Panics if a triangle names an emitter that is not there.
    #[must_use]
    pub fn new(triangles: Vec<EmissiveTriangle>, emitters: Vec<Arc<Emitter>>) -> Option<Self> {
        let brightness: Vec<f64> = emitters.iter().map(|e| f64::from(e.emission.mean_luminance())).collect();
        let power = |t: &EmissiveTriangle| double_area(t) * brightness[t.emitter as usize];
        let distribution = Distribution::new(triangles.iter().map(power))?;
        Some(Self { triangles, emitters, distribution })
    }

    /// How many triangles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there are no triangles: never, see [`new`](Self::new).
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// A direction from `p` to a point on a triangle, its distance and the arriving light over its probability.
    fn sample(&self, p: Vec3, random: [f32; 2]) -> Option<(Vec3, f32, Vec3)> {
        let choice = self.distribution.sample(random[0]);
        let shape = &self.triangles[choice.index];
        let [b1, b2] = triangle([choice.rest, random[1]]);
        let [e1, e2] = [shape.p[1] - shape.p[0], shape.p[2] - shape.p[0]];
        let cross = e1.cross(e2);
        let double_area = cross.length();
        let normal = cross / double_area;
        let q = {
            let on_triangle = shape.p[0] + e1 * b1 + e2 * b2;
            // Stop short of the triangle by what rounding may have moved the point, so that it does not shade itself.
            on_triangle + normal * rounding(shape, p)
        };
        let way = q - p;
        let distance2 = way.length_squared();
        let dist = distance2.sqrt();
        let dir = way / dist;
        let cos = -normal.dot(dir);
        if !(cos > 0.0 && dist > 0.0) {
            return None;
        }
        let emitter = &self.emitters[shape.emitter as usize];
        let uv = interpolate(&shape.uv, b1, b2);
        let mut radiance = emitter.emission.at(uv);
        if let Some(coverage) = &emitter.coverage {
            radiance *= coverage.at(uv, 1.0);
        }
        let pdf_area = choice.probability * 2.0 / double_area;
        Some((dir, dist, radiance * (cos / (distance2 * pdf_area))))
    }
}

impl LightShader for TriangleLights {
    fn illuminate(&self, p: &Vec3s, _normal: &Vec3s, random: &[[f32; 2]], out: &mut LightBatch) {
        for (i, &random) in random.iter().enumerate() {
            if let Some((dir, dist, radiance)) = self.sample(p.get(i), random) {
                out.dir.set(i, dir);
                out.dist[i] = dist;
                out.radiance.set(i, radiance);
            }
        }
    }

    fn is_visible(&self) -> bool {
        true
    }
}

fn double_area(t: &EmissiveTriangle) -> f64 {
    let p = t.p.map(Vec3::as_dvec3);
    (p[1] - p[0]).cross(p[2] - p[0]).length()
}

/// How far a point computed on the triangle and seen from `p` may be off, and some more.
fn rounding(shape: &EmissiveTriangle, p: Vec3) -> f32 {
    let largest = shape.p.iter().fold(p.abs().max_element(), |m, q| m.max(q.abs().max_element()));
    16.0 * f32::EPSILON * largest
}

fn interpolate(uv: &[[f32; 2]; 3], b1: f32, b2: f32) -> [f32; 2] {
    [0, 1].map(|k| uv[0][k] + b1 * (uv[1][k] - uv[0][k]) + b2 * (uv[2][k] - uv[0][k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::sample_pair;

    /// A 2 x 2 square at height 1 that shines down, as two triangles of which one is cut in two.
    fn square() -> TriangleLights {
        let corner = |x, y| Vec3::new(x, y, 1.0);
        let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        let middle = corner(0.0, 0.0);
        let triangles = [[a, b, c], [a, middle, d], [middle, c, d]].map(|p| EmissiveTriangle {
            p,
            uv: [[0.0; 2]; 3],
            emitter: 0,
        });
        let emission = Emission { factor: Vec3::new(1.0, 2.0, 3.0), texture: None };
        TriangleLights::new(triangles.into(), vec![Arc::new(Emitter { emission, coverage: None })])
            .expect("it shines")
    }

    fn irradiance(light: &TriangleLights, p: Vec3, up: Vec3) -> Vec3 {
        const N: u32 = 1 << 14;
        let sum = (0..N).fold(Vec3::ZERO, |sum, sample| {
            let random = sample_pair(0, SampleKey { pixel: 1, sample, branch: 0 }, 0, 0);
            let lit = light.sample(p, random);
            sum + lit.map_or(Vec3::ZERO, |(dir, _, radiance)| radiance * dir.dot(up).max(0.0))
        });
        sum / N as f32
    }

    #[test]
    fn rectangle_has_its_closed_form() {
        // Four equal corner rectangles of 1 x 1 at distance 1: the classic form factor, times pi.
        let corner = 1.0_f64 / 2.0_f64.sqrt();
        let wanted = 4.0 * corner * corner.atan();
        let found = irradiance(&square(), Vec3::ZERO, Vec3::Z);
        assert!((f64::from(found.x) / wanted - 1.0).abs() < 1e-3, "{} instead of {wanted}", found.x);
        assert!((found.z / found.x - 3.0).abs() < 1e-4, "in all colours");
    }

    #[test]
    fn the_back_is_dark() {
        let above = irradiance(&square(), Vec3::new(0.0, 0.0, 2.0), -Vec3::Z);
        assert_eq!(above, Vec3::ZERO, "light leaves one side only");
    }

    #[test]
    fn dark_or_flat_triangles_are_no_light() {
        let emission = Emission { factor: Vec3::ONE, texture: None };
        let emitter = Arc::new(Emitter { emission, coverage: None });
        let flat =
            EmissiveTriangle { p: [Vec3::ZERO, Vec3::X, Vec3::X * 2.0], uv: [[0.0; 2]; 3], emitter: 0 };
        assert!(TriangleLights::new(vec![flat], vec![emitter]).is_none(), "no area, no light");
    }
}
