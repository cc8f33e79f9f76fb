// SPDX-License-Identifier: GPL-3.0-or-later
//! The footprint of a ray as a cone around it: its width at the origin, its spread, and the kind of its ray.
//! The camera's cone covers the pixel. A scattered ray starts with the incoming width, and the surface's
//! curvature and the lobe's width add to its spread.
//! Source: [AM21] (ray cones), [Ige99] (ray differentials, which cones replace). Differs: the lobe's width
//! comes from the density of the chosen direction, which all lobes have: a sample represents a solid angle of
//! one over its density. Cones are round. All widths shrink with the number of a pixel's samples, so that the
//! samples determine the final picture. Sample n has cones scaled by 1 / sqrt(n + 1), but not below an
//! eighth, which leaves a blur of an eighth of a pixel.
//! Space: world; spreads are in units per unit of distance, widths are diameters.
//! Tests: `tests`; tests/filtering.rs; the OpenRT binding's tests/c/mipmaps.c.

use gnurt_accel::RayBatch;
use gnurt_shading::bsdf::BsdfSample;
use gnurt_shading::real::Real;
use gnurt_shading::{Bounces, CameraSamples, CameraShader, RayKind, SurfaceBatch};

use crate::options::RenderOptions;
use crate::pixel_order::PixelOrder;

/// The cone of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cone {
    /// How wide it is where the ray begins.
    width: f32,
    /// How fast it widens; below zero it narrows until it has no width, then widens again.
    spread: f32,
    /// The kind of ray.
    kind: RayKind,
    /// How its path was scattered.
    pub(crate) bounces: Bounces,
}

/// The cones of many rays.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cones {
    pub(crate) width: Vec<f32>,
    pub(crate) spread: Vec<f32>,
    pub(crate) kind: Vec<RayKind>,
    pub(crate) bounces: Vec<Bounces>,
}

/// Least share of their full width that cones keep, squared.
const FINEST: f32 = 1.0 / 64.0;
/// The cone of a scattered ray has this over its density of solid angle: `PI / 4` times the square of its width at distance 1.
const SHARE_OF_LOBE: f32 = 0.25 * 4.0 * std::f32::consts::FRAC_1_PI;
/// No lobe makes a ray's cone wider than this at distance 1, squared.
const WIDEST: f32 = 1.0;
/// A mirror rotates its image by twice the rotation of its normal.
const MIRRORED: f32 = 2.0;
/// Glass by about half of that, to any side.
const REFRACTED: f32 = 0.5;
/// Cosines to normals count as this at least, where a cone meets a bent surface.
const LEAST_COS: f32 = 0.1;

/// The square of the share of their full width that the cones of a pixel's sample have.
pub(crate) fn fineness(sample: u32) -> f32 {
    (1.0 / (sample as f32 + 1.0)).max(FINEST)
}

/// Where a cone meets a surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ConeHit<R> {
    pub(crate) width: R,
    pub(crate) spread: R,
    /// Of the surface, positive where it bulges towards the ray.
    pub(crate) curvature: R,
    /// Of the ray to the surface's normal.
    pub(crate) cos: R,
    /// The kind of ray; of one point only.
    pub(crate) kind: RayKind,
    /// How its path was scattered; of one point only.
    pub(crate) bounces: Bounces,
}

impl<R: Real> ConeHit<R> {
    /// The spread of the cone after scattering with this density; `fineness` is that of its sample.
    #[inline(always)]
    pub(crate) fn spread_after(&self, pdf: R, delta: R::Mask, transmitted: R::Mask, fineness: R) -> R {
        let zero = self.width.all(0.0);
        let slope = self.curvature * self.width / self.cos.or_more(zero.all(LEAST_COS));
        let mirrored = slope * zero.all(MIRRORED);
        let bent = self.spread + R::pick(transmitted, slope.size() * zero.all(REFRACTED), mirrored);
        let lobe = (zero.all(SHARE_OF_LOBE) / pdf).or_less(zero.all(WIDEST)) * fineness;
        let bent = R::pick(bent.is_number(), bent, zero);
        R::pick(delta, bent, (bent * bent + lobe).root())
    }
}

impl ConeHit<f32> {
    /// Of lane `i` of a batch.
    pub(crate) fn of(points: &SurfaceBatch, i: usize) -> Self {
        let known = |values: &[f32]| values.get(i).copied().unwrap_or(0.0);
        let cos = points.ng.get(i).dot(points.ray_dir.get(i));
        let bulge = if cos > 0.0 { -known(&points.curvature) } else { known(&points.curvature) };
        let (width, spread) = (known(&points.footprint), known(&points.cone_spread));
        let bounces = points.bounces.get(i).copied().unwrap_or_default();
        Self { width, spread, curvature: bulge, cos: cos.abs(), kind: points.ray_kind(i), bounces }
    }

    /// The cone of the scattered ray.
    pub(crate) fn after(&self, sample: &BsdfSample, fineness: f32) -> Cone {
        let spread = self.spread_after(sample.pdf, sample.delta, sample.transmitted, fineness);
        let kind = sample.ray_kind();
        Cone { width: self.width, spread, kind, bounces: self.bounces.and(kind) }
    }

    /// The cone of the ray that goes straight on, through a transparent surface.
    pub(crate) fn straight(&self) -> Cone {
        let bounces = self.bounces.beyond();
        Cone { width: self.width, spread: self.spread, kind: self.kind, bounces }
    }
}

impl Cone {
    /// The cone of a pixel in the middle of the picture, which all pixels take for theirs; nothing if the camera gives no rays.
    pub(crate) fn of(camera: &dyn CameraShader, options: &RenderOptions) -> Self {
        let (width, height) = (options.width as f32, options.height as f32);
        let mut rays = RayBatch::default();
        let neighbours = [[0.5, 0.5], [0.5 + 1.0 / width, 0.5], [0.5, 0.5 + 1.0 / height]];
        camera.rays(&CameraSamples::sharp(&neighbours), width / height, &mut rays);
        if rays.len() < neighbours.len() {
            return Self::default();
        }
        let distance = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt();
        let [middle, right, up] = [0, 1, 2].map(|i| rays.get(i));
        let larger = |a: f32, b: f32| Some(a.max(b)).filter(|x| x.is_finite()).unwrap_or(0.0);
        Self {
            width: larger(distance(middle.org, right.org), distance(middle.org, up.org)),
            spread: larger(distance(middle.dir, right.dir), distance(middle.dir, up.dir)),
            kind: RayKind::Camera,
            bounces: Bounces::default(),
        }
    }

    /// The cone of a ray that begins without width in a direction of this density, as fine as cones get.
    pub(crate) fn from_point(pdf: f32) -> Self {
        let spread = ConeHit::default().spread_after(pdf, false, false, FINEST);
        Self { spread: if spread.is_finite() { spread } else { 0.0 }, ..Self::default() }
    }

    /// That of a ray that begins as wide as something else and spreads as this.
    pub(crate) fn beginning(self, width: f32) -> Self {
        Self { width, ..self }
    }

    /// That of a ray that something else sends.
    pub(crate) fn sent_by(self, kind: RayKind) -> Self {
        Self { kind, ..self }
    }

    /// Whether the camera sent its ray.
    pub(crate) fn is_of_camera(self) -> bool {
        self.kind == RayKind::Camera
    }

    /// How wide it is `distance` away from a camera.
    pub(crate) fn width_at(self, distance: f32) -> f32 {
        self.width + self.spread * distance
    }

    /// As fine as a sample's.
    pub(crate) fn of_sample(self, sample: u32) -> Self {
        let share = fineness(sample).sqrt();
        Self { width: self.width * share, spread: self.spread * share, ..self }
    }

    /// Writes the widths, spreads and kinds at points that the rays of `lanes` met. `cones` are those of all
    /// rays, if known; rays of depth 0 have the camera's, which is this.
    pub(crate) fn widen(
        self,
        order: PixelOrder,
        points: &mut SurfaceBatch,
        lanes: &[u32],
        cones: Option<&Cones>,
    ) {
        let SurfaceBatch { footprint, cone_spread, kinds, bounces, t, key, depth, .. } = points;
        [&mut *footprint, &mut *cone_spread].into_iter().for_each(|array| array.resize(lanes.len(), 0.0));
        kinds.clear();
        bounces.clear();
        let positions = footprint.iter_mut().zip(cone_spread).zip(lanes.iter().zip(&*t).zip(key));
        for ((footprint, cone_spread), ((&lane, &t), &mut key)) in positions {
            let cone = match cones {
                Some(cones) => cones.get(lane as usize),
                None if *depth == 0 => self.of_sample(order.sample(key)).sent_by(RayKind::Camera),
                None => Self::default(),
            };
            let width = cone.width_at(t);
            *footprint = width.abs();
            // Beyond its narrowest point it widens again.
            *cone_spread = if width < 0.0 { -cone.spread } else { cone.spread };
            kinds.push(cone.kind);
            bounces.push(cone.bounces);
        }
    }
}

impl Cones {
    pub(crate) fn push(&mut self, cone: Cone) {
        self.width.push(cone.width);
        self.spread.push(cone.spread);
        self.kind.push(cone.kind);
        self.bounces.push(cone.bounces);
    }

    /// That of ray `i`; without width where there are fewer.
    pub(crate) fn get(&self, i: usize) -> Cone {
        let known = |values: &[f32]| values.get(i).copied().unwrap_or(0.0);
        let kind = self.kind.get(i).copied().unwrap_or_default();
        let bounces = self.bounces.get(i).copied().unwrap_or_default();
        Cone { width: known(&self.width), spread: known(&self.spread), kind, bounces }
    }

    /// Writes that of ray `i`, which is there.
    pub(crate) fn set(&mut self, i: usize, cone: Cone) {
        (self.width[i], self.spread[i], self.kind[i]) = (cone.width, cone.spread, cone.kind);
        self.bounces[i] = cone.bounces;
    }

    pub(crate) fn resize(&mut self, n: usize) {
        self.width.resize(n, 0.0);
        self.spread.resize(n, 0.0);
        self.kind.resize(n, RayKind::default());
        self.bounces.resize(n, Bounces::default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::SceneCamera;

    #[test]
    fn widens_with_the_way() {
        let camera = gnurt_scene::Camera {
            name: String::new(),
            eye: [0.0; 3],
            target: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            fov_y: 90.0,
            ..gnurt_scene::Camera::default()
        };
        let camera = SceneCamera::new(&camera).expect("a view");
        let options = RenderOptions { width: 200, height: 100, ..RenderOptions::default() };
        let cone = Cone::of(&camera, &options);
        assert_eq!(cone.width, 0.0, "from one eye");
        assert!(
            (cone.spread - 0.02).abs() < 1e-4,
            "a picture 2 high at distance 1, by 100 rows: {}",
            cone.spread
        );
        let order = PixelOrder::new(&options);
        let key = |sample| order.key([0, 0], sample);
        let mut points =
            SurfaceBatch { t: vec![10.0, 5.0], key: vec![key(0), key(3)], ..SurfaceBatch::default() };
        cone.widen(order, &mut points, &[1, 0], None);
        assert!((points.footprint[0] - 0.2).abs() < 1e-3, "at distance 10: {:?}", points.footprint);
        assert!((points.footprint[1] - 0.05).abs() < 1e-3, "the fourth sample: half of 0.1");
        points.depth = 1;
        let kind = vec![RayKind::Glossy, RayKind::Reflection];
        let bounces = vec![Bounces::default(), Bounces::default().and(RayKind::Glossy).beyond()];
        let cones = Cones { width: vec![1.0, 2.0], spread: vec![-0.4, 0.02], kind, bounces };
        cone.widen(order, &mut points, &[1, 0], Some(&cones));
        assert!((points.footprint[0] - 2.2).abs() < 1e-3, "after a mirror: {:?}", points.footprint);
        assert_eq!([points.footprint[1], points.cone_spread[1]], [1.0, 0.4], "beyond a focus");
        assert_eq!(points.kinds, [RayKind::Reflection, RayKind::Glossy], "in the order of lanes");
        assert_eq!(points.bounces[0], Bounces { glossy: 1, transparent: 1, ..Bounces::default() });
        cone.widen(order, &mut points, &[1, 0], None);
        assert_eq!(points.footprint, [0.0; 2], "nobody knows");
    }

    #[test]
    fn surfaces_widen_cones() {
        let flat = ConeHit { width: 0.1_f32, spread: 0.01, cos: 1.0, ..ConeHit::default() };
        let after = |at: &ConeHit<f32>, pdf: f32, delta| at.spread_after(pdf, delta, false, 1.0);
        assert_eq!(after(&flat, f32::INFINITY, true), 0.01, "a plane mirror");
        // A ball of radius 2 rotates its normal by 0.05 over 0.1, and its image by twice that.
        let ball = ConeHit { curvature: 0.5, ..flat };
        assert!((after(&ball, f32::INFINITY, true) - 0.11).abs() < 1e-6, "a ball spreads");
        let bowl = ConeHit { curvature: -0.5, ..flat };
        assert!((after(&bowl, f32::INFINITY, true) + 0.09).abs() < 1e-6, "a bowl focuses");
        let rough = |pdf| after(&flat, pdf, false);
        assert!(rough(1e6) < 0.011 && rough(10.0) > 0.1, "by the width of its lobe: {}", rough(10.0));
        // A quarter of the solid angle pi of a sample of a diffuse lobe, as a disc.
        let diffuse = rough(std::f32::consts::FRAC_1_PI);
        assert!((diffuse - 1.0).abs() < 1e-3, "diffuse: {diffuse}");
        assert_eq!(after(&flat, 0.0, false), (1.0_f32 + 0.0001).sqrt(), "never wider");
    }
}
