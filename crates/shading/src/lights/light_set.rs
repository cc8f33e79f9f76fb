// SPDX-License-Identifier: GPL-3.0-or-later
//! All lights of a scene together, with the densities that light transport needs: sampled from a point,
//! looked up where a ray hit one. Paths that start at lights: `light_emission`.
//! Source: [EK18] (light tree), [PJH23] sections 6.5.3 (area to solid angle) and 12.5 (environments).
//! Space: world. Densities are per solid angle at the shaded point, the choice between lights included.
//! Invariants: `pdf_shape` and `pdf_environment` are the densities of `sample` for the same point and
//! normal. A zero normal requests all sides. Lights of shader plugins are excluded: they only have
//! `illuminate`.
//! Tests: `tests`, crates/render/tests/path.rs.

use std::f32::consts::PI;
use std::sync::{Arc, OnceLock};

use glam::Vec3;
use gnurt_accel::Threads;
use gnurt_image::srgb::luminance;

use super::light_estimates::Aim;
use super::light_lanes::LightLanes;
use super::light_parts::{LightId, LightKind, LightParts, LightSample, is_sound};
use super::light_tree::{LightBounds, LightTree};
use super::shape::Shape;
use crate::sampling::{Choice, Distribution};

/// All lights.
pub struct LightSet {
    pub(super) parts: LightParts,
    /// The choice of lights that have a position: shared by all sets with the same ones.
    pub(super) near: Arc<NearLights>,
    /// Centre and radius of a ball around all that can be lit.
    pub(super) ball: (Vec3, f32),
    /// Shares of lights among light paths, by light; computed at the start of the first path.
    power: OnceLock<Option<Distribution>>,
}

/// The choice of lights that have a position.
pub(super) struct NearLights {
    pub(super) tree: LightTree,
    /// The tree for many points at once; `None` where it is empty.
    pub(super) lanes: Option<LightLanes>,
}

impl NearLights {
    fn new(parts: &LightParts, threads: Threads) -> Self {
        let tree = LightTree::new(&tree_lights(parts), threads);
        let lanes = LightLanes::new(parts, &tree);
        Self { tree, lanes }
    }
}

impl LightSet {
    /// Builds the tree over them.
    #[must_use]
    pub fn new(parts: LightParts, threads: Threads) -> Self {
        let near = Arc::new(NearLights::new(&parts, threads));
        Self::with_near(parts, near)
    }

    /// The set of other parts, which shares the tree with this one; `None` if the lights with a position
    /// differ, which requires another tree.
    #[must_use]
    pub fn again(&self, parts: &LightParts) -> Option<Self> {
        self.parts.same_near(parts).then(|| Self::with_near(parts.clone(), self.near.clone()))
    }

    /// Whether both choose by one tree.
    #[must_use]
    pub fn shares_tree(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.near, &other.near)
    }

    fn with_near(parts: LightParts, near: Arc<NearLights>) -> Self {
        let ball = ball(parts.bounds);
        Self { near, ball, power: OnceLock::new(), parts }
    }

    /// Shares of lights among light paths, by light.
    pub(super) fn power(&self) -> Option<&Distribution> {
        let all = || near_powers(&self.parts).chain(far_powers(&self.parts, self.ball.1));
        self.power.get_or_init(|| Distribution::new(all())).as_ref()
    }

    /// How many lights.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parts.finite_count()
            + self.parts.directionals.len()
            + usize::from(self.parts.environment.is_some())
    }

    /// Whether there is no light.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The kind of a light.
    #[must_use]
    pub fn kind(&self, light: LightId) -> LightKind {
        type Kind = fn(u32) -> LightKind;
        let mut i = light.0;
        let kinds = [
            (self.parts.shape_count(), LightKind::Shape as Kind),
            (self.parts.points.len(), LightKind::Point),
            (self.parts.directionals.len(), LightKind::Directional),
        ];
        for (count, kind) in kinds {
            if (i as usize) < count {
                return kind(i);
            }
            i -= count as u32;
        }
        LightKind::Environment
    }

    /// The number of the emissive shape that a ray along `dir` hit, given leaf, mesh and primitive; for a
    /// two-sided triangle that of the hit side.
    #[must_use]
    pub fn shape(&self, met: [u32; 3], dir: Vec3) -> Option<u32> {
        let ids = &self.parts.shape_ids;
        let first = ids.partition_point(|ids| *ids < met);
        if ids.get(first) != Some(&met) {
            return None;
        }
        let lights = self.parts.shapes.as_ref()?;
        let is_behind = ids.get(first + 1) == Some(&met) && lights.shapes[first].normal.dot(dir) > 0.0;
        Some((first + usize::from(is_behind)) as u32)
    }

    /// Chooses a light and a direction to it for a surface at `p` that faces the unit normal `ns`; zero
    /// requests all sides. `None` if no light reaches the point. The direction may still lie below the
    /// horizon.
    #[must_use]
    pub fn sample(&self, p: Vec3, ns: Vec3, u: [f32; 3]) -> Option<LightSample> {
        self.sample_among(None, p, ns, u)
    }

    /// The same among the lights of one group, if it is named: one of [`split_groups`](Self::split_groups).
    #[must_use]
    pub fn sample_among(&self, group: Option<usize>, p: Vec3, ns: Vec3, u: [f32; 3]) -> Option<LightSample> {
        let group = match group {
            Some(index) => Choice { index, probability: 1.0, rest: u[0] },
            None => self.choose_group(p, ns, u[0])?,
        };
        let sample = if group.index == 0 {
            let contribution = |light| self.contribution(light, p, ns);
            let (light, probability) = self.near.tree.choose(p, ns, group.rest, contribution)?;
            self.sample_near(light, p, [u[1], u[2]], group.probability * probability)
        } else {
            self.sample_far(group.index - 1, ns, [u[1], u[2]], group.probability)
        }?;
        Some(sample).filter(is_sound)
    }

    pub(super) fn sample_near(
        &self,
        light: u32,
        p: Vec3,
        u: [f32; 2],
        probability: f32,
    ) -> Option<LightSample> {
        let id = LightId(light);
        match self.kind(id) {
            LightKind::Shape(i) => {
                let lights = self.parts.shapes.as_ref()?;
                let shape = &lights.shapes[i as usize];
                let Aim { position, dir, dist, density } = shape.seen().aim(p.into(), u, true);
                let (dir, pdf) = (dir.into(), probability * density);
                let radiance = lights.radiance(i as usize, position, dir, dist);
                (dist > 0.0).then_some(LightSample { dir, dist, radiance, pdf, delta: false, light: id })
            }
            LightKind::Point(i) => {
                let (dir, dist, radiance) = self.parts.points[i as usize].seen_from(p, u)?;
                Some(LightSample { dir, dist, radiance, pdf: probability, delta: true, light: id })
            }
            LightKind::Directional(_) | LightKind::Environment => None,
        }
    }

    pub(super) fn sample_far(
        &self,
        index: usize,
        ns: Vec3,
        u: [f32; 2],
        probability: f32,
    ) -> Option<LightSample> {
        let light = LightId((self.parts.finite_count() + index) as u32);
        if let Some(directional) = self.parts.directionals.get(index) {
            let (dir, irradiance) = directional.sample(u);
            return Some(LightSample {
                dir,
                dist: f32::INFINITY,
                radiance: irradiance,
                pdf: probability,
                delta: true,
                light,
            });
        }
        let environment = self.parts.environment.as_ref()?;
        let (dir, pdf) = environment.sample(ns, u);
        let radiance = environment.radiance(dir);
        Some(LightSample { dir, dist: f32::INFINITY, radiance, pdf: probability * pdf, delta: false, light })
    }

    /// Density with which [`sample`](Self::sample) finds emissive shape `shape` along the unit direction `dir`,
    /// `dist` away; 0 on its dark side.
    #[must_use]
    pub fn pdf_shape(&self, p: Vec3, ns: Vec3, shape: u32, dir: Vec3, dist: f32) -> f32 {
        let here = self.pdf_shape_in_group(p, ns, shape, dir, dist);
        if here > 0.0 { self.group_share(0, p, ns) * here } else { 0.0 }
    }

    /// The same where its group was named.
    #[must_use]
    pub fn pdf_shape_in_group(&self, p: Vec3, ns: Vec3, shape: u32, dir: Vec3, dist: f32) -> f32 {
        let Some(lights) = &self.parts.shapes else { return 0.0 };
        let here = lights.shapes[shape as usize].seen().density(p.into(), dir.into(), dist);
        if here <= 0.0 {
            return 0.0;
        }
        let contribution = |light| self.contribution(light, p, ns);
        self.near.tree.probability(shape, p, ns, contribution) * here
    }

    /// Radiance of an emissive shape against a ray along `dir` that came `distance` far and met it at a point, and at these
    /// weights of the mesh's second and third corner.
    #[must_use]
    pub fn radiance_of_shape(&self, shape: u32, met: ([f32; 2], Vec3), dir: Vec3, distance: f32) -> Vec3 {
        let lights = self.parts.shapes.as_ref();
        lights.map_or(Vec3::ZERO, |all| all.radiance_where_met(shape as usize, met, dir, distance))
    }

    /// Density with which [`sample`](Self::sample) finds the environment along the unit direction `dir`.
    #[must_use]
    pub fn pdf_environment(&self, p: Vec3, ns: Vec3, dir: Vec3) -> f32 {
        let share = || self.group_share(self.group_count() - 1, p, ns);
        self.parts.environment.as_ref().map_or(0.0, |environment| share() * environment.pdf(ns, dir))
    }

    /// The same where its group was named.
    #[must_use]
    pub fn pdf_environment_in_group(&self, ns: Vec3, dir: Vec3) -> f32 {
        let is_sampled = self.split_groups().end == self.group_count();
        let sky = self.parts.environment.as_ref().filter(|_| is_sampled);
        sky.map_or(0.0, |environment| environment.pdf(ns, dir))
    }

    /// Whether light comes from everywhere.
    #[must_use]
    pub fn has_environment(&self) -> bool {
        self.parts.environment.is_some()
    }

    /// Radiance of the environment from the unit direction `dir`; none where that is zero, as of cameras that see nothing.
    #[must_use]
    pub fn environment(&self, dir: Vec3) -> Vec3 {
        let environment = self.parts.environment.as_ref().filter(|_| dir != Vec3::ZERO);
        environment.map_or(Vec3::ZERO, |environment| environment.radiance(dir))
    }

    /// Approximate contribution of a light of the tree to a surface; 0 if there is none.
    pub(super) fn contribution(&self, light: u32, p: Vec3, ns: Vec3) -> f32 {
        match (light as usize, &self.parts.shapes) {
            (i, Some(shapes)) if i < shapes.len() => shapes.contribution(i, p, ns),
            (i, _) => self.parts.points[i - self.parts.shape_count()].estimate(p, ns),
        }
    }
}

/// Centre and radius of a ball around a box; never without extent.
fn ball([low, high]: [Vec3; 2]) -> (Vec3, f32) {
    let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
    if centre.is_finite() && radius > 0.0 && radius.is_finite() {
        (centre, radius * 1.001)
    } else {
        (Vec3::ZERO, 1.0)
    }
}

/// Lights with a position, as the tree's input.
fn tree_lights(parts: &LightParts) -> Vec<Option<LightBounds>> {
    let shapes = parts.shapes.iter().flat_map(|lights| lights.bounds());
    let points = parts.points.iter().map(|light| LightBounds {
        min: light.position - Vec3::splat(light.radius),
        max: light.position + Vec3::splat(light.radius),
        axis: light.cone.map_or(Vec3::Z, |cone| cone.axis),
        cos_normals: light.cone.map_or(-1.0, |_| 1.0),
        cos_emission: light.cone.map_or(0.0, |cone| cone.cos_outer),
        // The mean cosine of all normals is a quarter.
        power: light.power() * light.cone.map_or(4.0, |_| 1.0),
    });
    shapes.chain(points).map(Some).collect()
}

fn bright(color: Vec3) -> f64 {
    f64::from(luminance(color.into()))
}

/// Watts of each light with a position, by brightness.
fn near_powers(parts: &LightParts) -> impl Iterator<Item = f64> + '_ {
    let shapes = parts.shapes.iter().flat_map(|lights| lights.shapes.iter().map(Shape::watts));
    let points = parts.points.iter().map(|light| f64::from(light.solid_angle()) * bright(light.intensity));
    shapes.chain(points)
}

/// Watts of each light from far away, by brightness, that a ball of radius `radius` catches.
fn far_powers(parts: &LightParts, radius: f32) -> impl Iterator<Item = f64> + '_ {
    let disk = f64::from(PI) * f64::from(radius).powi(2);
    let directionals = parts.directionals.iter().map(move |light| disk * bright(light.irradiance));
    directionals.chain(parts.environment.iter().map(move |light| disk * f64::from(light.total())))
}
