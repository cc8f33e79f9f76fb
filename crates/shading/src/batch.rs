// SPDX-License-Identifier: GPL-3.0-or-later
//! Batches of surface points, as structures of arrays: the input of one call of a shader. Shaped by \[SIP06\],
//! section 8: a shader's author sees one point, the machine sees lanes.
//! Space: world. Invariant: all arrays of a batch have `len()` lanes, and every lane is live.

use std::sync::Arc;

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_simd::{Level, dispatch_wide, f32x16, prelude::*};

use crate::lanes::LANES;
use crate::point::{SurfacePoint, is_unbent};
use crate::real::{Real, Vector};
use crate::sampling::hash_combine;
use crate::scene_queries::{CameraProperties, SceneNames};

/// Three floats per lane: points, directions or colours.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vec3s {
    /// First components.
    pub x: Vec<f32>,
    /// Second components.
    pub y: Vec<f32>,
    /// Third components.
    pub z: Vec<f32>,
}

impl Vec3s {
    /// `n` lanes of `value`.
    #[must_use]
    pub fn splat(n: usize, value: Vec3) -> Self {
        Self { x: vec![value.x; n], y: vec![value.y; n], z: vec![value.z; n] }
    }

    /// No lanes yet, but memory for `n`.
    #[must_use]
    pub fn with_capacity(n: usize) -> Self {
        let [x, y, z] = [(); 3].map(|()| Vec::with_capacity(n));
        Self { x, y, z }
    }

    /// Number of lanes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are no lanes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Lane `i`.
    #[inline]
    #[must_use]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Writes lane `i`.
    #[inline]
    pub fn set(&mut self, i: usize, value: Vec3) {
        self.x[i] = value.x;
        self.y[i] = value.y;
        self.z[i] = value.z;
    }

    /// Adds to lane `i`.
    pub fn add(&mut self, i: usize, value: Vec3) {
        self.set(i, self.get(i) + value);
    }

    /// Appends a lane.
    #[inline]
    pub fn push(&mut self, value: Vec3) {
        self.x.push(value.x);
        self.y.push(value.y);
        self.z.push(value.z);
    }

    /// Takes all lanes away and keeps the memory.
    pub fn clear(&mut self) {
        [&mut self.x, &mut self.y, &mut self.z].into_iter().for_each(Vec::clear);
    }

    /// Resizes to `n` lanes of undefined values and keeps the memory, for callers that write all of them.
    pub fn resize(&mut self, n: usize) {
        [&mut self.x, &mut self.y, &mut self.z].into_iter().for_each(|array| array.resize(n, 0.0));
    }

    /// Makes it `n` lanes of `value` and keeps the memory.
    pub fn reset(&mut self, n: usize, value: Vec3) {
        for (array, v) in [(&mut self.x, value.x), (&mut self.y, value.y), (&mut self.z, value.z)] {
            array.clear();
            array.resize(n, v);
        }
    }
}

/// Which sample of which pixel a lane belongs to: the key of its random numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleKey {
    /// The sequence of random numbers: the pixel, row by row from the upper left one, or what the pixels of a square share.
    pub pixel: u32,
    /// The place in the sequence: the sample within the pixel, from 0, behind those of other pixels that share it.
    pub sample: u32,
    /// Hash of the path so far (0 for camera rays), so that two branches draw different numbers. It must not depend
    /// on the sample, or the samples of a pixel lose their stratification.
    pub branch: u32,
}

impl SampleKey {
    /// The key of branch `n` that leaves this path: mirrored, refracted, straight on.
    #[must_use]
    pub fn fork(self, n: u32) -> Self {
        Self { branch: hash_combine(self.branch, n.wrapping_add(1)), ..self }
    }
}

/// The origin of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum RayKind {
    /// The camera.
    Camera,
    /// A diffuse surface, here or beyond; or unknown.
    #[default]
    Diffuse,
    /// Microfacets with reflection, or fibres.
    Glossy,
    /// A mirror.
    Reflection,
    /// Glass, smooth or not: it goes through the surface.
    Refraction,
}

impl RayKind {
    /// The kind of a scattered ray: by a delta lobe, through the surface, by a wide lobe.
    #[inline]
    #[must_use]
    pub fn of(delta: bool, transmitted: bool, wide: bool) -> Self {
        match (wide, transmitted, delta) {
            (true, ..) => Self::Diffuse,
            (_, true, _) => Self::Refraction,
            (.., true) => Self::Reflection,
            _ => Self::Glossy,
        }
    }
}

/// How often a path was scattered before its ray, by the kinds of its rays, and how many transparent surfaces it passed. Counts end
/// at 255.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounces {
    /// By diffuse surfaces.
    pub diffuse: u8,
    /// By microfacets and mirrors.
    pub glossy: u8,
    /// Through glass.
    pub transmission: u8,
    /// Transparent surfaces.
    pub transparent: u8,
}

impl Bounces {
    /// After a surface sent on a ray of this kind.
    #[inline]
    #[must_use]
    pub fn and(self, kind: RayKind) -> Self {
        let Self { diffuse, glossy, transmission, .. } = self;
        match kind {
            RayKind::Camera => self,
            RayKind::Diffuse => Self { diffuse: diffuse.saturating_add(1), ..self },
            RayKind::Glossy | RayKind::Reflection => Self { glossy: glossy.saturating_add(1), ..self },
            RayKind::Refraction => Self { transmission: transmission.saturating_add(1), ..self },
        }
    }

    /// Beyond a transparent surface.
    #[inline]
    #[must_use]
    pub fn beyond(self) -> Self {
        Self { transparent: self.transparent.saturating_add(1), ..self }
    }
}

/// Cones that widen faster than this are of broad lobes: about a fifteenth of a right angle.
const VAGUE: f32 = 0.1;

/// How much of a batch is filled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// All of it.
    Full,
    /// Positions and normals: all but `error`, `lift` and `curvature`, which are empty.
    Sides,
}

/// Surface points that share one shader, world space.
#[derive(Clone, Debug, Default)]
pub struct SurfaceBatch {
    /// Points.
    pub p: Vec3s,
    /// Bounds of the points' rounding errors, world units: rays that leave start beyond them.
    pub error: Vec<f32>,
    /// Unit geometric normals, counter-clockwise, as the mesh has them: not flipped.
    pub ng: Vec3s,
    /// Unit shading normals, interpolated, as the mesh has them: not flipped; the geometric one where the mesh has none.
    pub ns: Vec3s,
    /// The same as bump maps bend them; empty = nothing does.
    pub bent: Vec3s,
    /// From the points to the curved surface that the vertex normals suggest, world units: the start of
    /// shadow rays, so that flat faces do not shadow their own mesh. Zero where the mesh is flat, or hollow
    /// on the side of the ray.
    pub lift: Vec3s,
    /// Unit directions of the rays that came here.
    pub ray_dir: Vec3s,
    /// Distances they came, world units.
    pub t: Vec<f32>,
    /// Barycentric weights of the second vertices.
    pub u: Vec<f32>,
    /// Barycentric weights of the third vertices.
    pub v: Vec<f32>,
    /// Texture coordinates, v upwards.
    pub texcoord: [Vec<f32>; 2],
    /// Change of the position per texture u, world units, not unit; zero where the mesh has no texture coordinates.
    pub dp_du: Vec3s,
    /// The same for v. If the mesh has tangents of its own, both point along these.
    pub dp_dv: Vec3s,
    /// Widths of the rays' cones at the points, across the rays, world units: the pixel's footprint. Empty or
    /// 0 where unknown.
    pub footprint: Vec<f32>,
    /// Spread of the cones per world unit of distance, where they hit the points; as long as `footprint`.
    /// Negative: narrower.
    pub cone_spread: Vec<f32>,
    /// Mean curvature of the surface that the vertex normals suggest, one over world units: positive where it bulges to where the
    /// geometric normal points. Empty or 0 where the mesh is flat.
    pub curvature: Vec<f32>,
    /// Change of texture coordinates per world unit along the surface, the mean of all directions; empty or 0 where the
    /// mesh has none.
    pub uv_per_length: Vec<f32>,
    /// Vertex colours, linear; white where the mesh has none.
    pub color: Vec3s,
    /// Vertex opacities; 1 where the mesh has none.
    pub alpha: Vec<f32>,
    /// Triangles within their meshes.
    pub prim_id: Vec<u32>,
    /// Meshes within their objects.
    pub geom_id: Vec<u32>,
    /// Instances.
    pub inst_id: Vec<u32>,
    /// Which of all objects that instances show, those of objects in objects too.
    pub leaf_id: Vec<u32>,
    /// The kinds of the rays; empty if not requested.
    pub kinds: Vec<RayKind>,
    /// How often the rays' paths were scattered; empty if not requested.
    pub bounces: Vec<Bounces>,
    /// How many bounces the rays had behind them: 0 for camera rays.
    pub depth: u32,
    /// Keys of the lanes' random numbers.
    pub key: Vec<SampleKey>,
    /// Values of the attributes that the shader requested, in its order: component k of lane i is `[k * len +
    /// i]`.
    pub attributes: Vec<Vec<f32>>,
    /// The camera of the picture; `None` = unknown, as where surfaces are sampled as lights.
    pub camera: Option<CameraProperties>,
    /// Names of the scene's parts, if some shader requests them.
    pub names: Option<Arc<SceneNames>>,
}

/// Normals of sixteen lanes by component, on the sides that their rays came from.
#[derive(Clone, Copy, Debug)]
pub struct FacingRows {
    /// The shading normal.
    pub ns: [[f32; LANES]; 3],
    /// Of the meshes.
    pub ng: [[f32; LANES]; 3],
    /// Bits of the lanes that are seen from behind.
    pub back: u32,
}

impl SurfaceBatch {
    /// Removes all lanes and keeps the memory, for a caller that appends: no lane is written twice.
    pub fn clear(&mut self) {
        self.each_row(Vec3s::clear, Vec::clear, Vec::clear);
        self.kinds.clear();
        self.bounces.clear();
        self.key.clear();
        self.attributes.clear();
        (self.camera, self.names) = (None, None);
    }

    /// Visits all rows of vectors, numbers and ids; an unknown row is empty.
    fn each_row(
        &mut self,
        vectors: impl FnMut(&mut Vec3s),
        mut numbers: impl FnMut(&mut Vec<f32>),
        ids: impl FnMut(&mut Vec<u32>),
    ) {
        let Self { p, ng, ns, bent, lift, ray_dir, dp_du, dp_dv, color, .. } = self;
        [p, ng, ns, bent, lift, ray_dir, dp_du, dp_dv, color].into_iter().for_each(vectors);
        let Self { error, t, u, v, texcoord: [s, r], uv_per_length, alpha, .. } = self;
        [error, t, u, v, s, r, uv_per_length, alpha].into_iter().for_each(&mut numbers);
        let Self { footprint, cone_spread, curvature, .. } = self;
        [footprint, cone_spread, curvature].into_iter().for_each(numbers);
        let Self { prim_id, geom_id, inst_id, leaf_id, .. } = self;
        [prim_id, geom_id, inst_id, leaf_id].into_iter().for_each(ids);
    }

    /// Resizes to `n` lanes of undefined values and keeps the memory, for a caller that writes them. Rows
    /// that `detail` excludes become empty, as do widths and attributes.
    pub fn resize(&mut self, n: usize, detail: Detail) {
        let Self { p, ng, ns, ray_dir, color, .. } = self;
        [p, ng, ns, ray_dir, color].into_iter().for_each(|array| array.resize(n));
        let Self { t, u, v, texcoord: [s, r], uv_per_length, alpha, .. } = self;
        [t, u, v, s, r, uv_per_length, alpha].into_iter().for_each(|array| array.resize(n, 0.0));
        [&mut self.prim_id, &mut self.geom_id, &mut self.inst_id, &mut self.leaf_id]
            .into_iter()
            .for_each(|array| array.resize(n, 0));
        self.key.resize(n, SampleKey::default());
        let moving = if detail == Detail::Full { n } else { 0 };
        self.error.resize(moving, 0.0);
        self.lift.resize(moving);
        self.bent.resize(0);
        [&mut self.dp_du, &mut self.dp_dv].into_iter().for_each(|array| array.resize(n));
        [&mut self.footprint, &mut self.cone_spread, &mut self.curvature].into_iter().for_each(Vec::clear);
        self.kinds.clear();
        self.bounces.clear();
        self.attributes.clear();
    }

    /// Number of lanes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there are no lanes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Geometric normal of lane `i`, flipped to the side of the ray.
    #[inline(always)]
    #[must_use]
    pub fn facing_ng(&self, i: usize) -> Vec3 {
        let ng = self.ng.get(i);
        if self.front(i) { ng } else { -ng }
    }

    /// Normal of lane `i` that scatters light, as the mesh has it, or as a bump map bends that: not flipped.
    #[inline(always)]
    #[must_use]
    pub fn scattering_ns(&self, i: usize) -> Vec3 {
        if self.bent.is_empty() { self.ns.get(i) } else { self.bent.get(i) }
    }

    /// The same, flipped to the side of [`facing_ng`](Self::facing_ng).
    #[inline(always)]
    #[must_use]
    pub fn facing_ns(&self, i: usize) -> Vec3 {
        let ns = self.scattering_ns(i);
        // Bumps tilt it, but do not flip it.
        if self.ns.get(i).dot(self.facing_ng(i)) < 0.0 { -ns } else { ns }
    }

    /// [`facing_ns`](Self::facing_ns) and [`facing_ng`](Self::facing_ng) of sixteen lanes from `first` on; lanes beyond the last one hold
    /// anything.
    #[inline]
    #[must_use]
    pub fn facing_rows(&self, first: usize) -> FacingRows {
        let count = LANES.min(self.len() - first);
        // Arrays, so that loops over them need no checks.
        let row = |of: &[f32]| {
            if let Some(row) = of[first..].first_chunk() {
                return *row;
            }
            let mut row = [0.0; LANES];
            row[..count].copy_from_slice(&of[first..first + count]);
            row
        };
        let rows = |v: &Vec3s| [row(&v.x), row(&v.y), row(&v.z)];
        let (mut ng, ray, ns) = (rows(&self.ng), rows(&self.ray_dir), rows(&self.ns));
        let mut facing = if self.bent.is_empty() { ns } else { rows(&self.bent) };
        let mut sides = [0.0_f32; LANES];
        for i in 0..LANES {
            let dot = |a: &[[f32; LANES]; 3], b: &[[f32; LANES]; 3]| {
                (a[0][i] * b[0][i]) + (a[1][i] * b[1][i]) + (a[2][i] * b[2][i])
            };
            let side = if dot(&ng, &ray) <= 0.0 { 1.0 } else { -1.0 };
            let turned = if dot(&ns, &ng) * side < 0.0 { -1.0 } else { 1.0 };
            facing.iter_mut().for_each(|row| row[i] *= turned);
            sides[i] = side;
        }
        ng.iter_mut().for_each(|row| row.iter_mut().zip(&sides).for_each(|(x, side)| *x *= side));
        let back = sides.iter().enumerate().fold(0, |bits, (i, side)| bits | u32::from(*side < 0.0) << i);
        FacingRows { ns: facing, ng, back }
    }

    /// Bits of those of sixteen lanes from `first` on whose unit normals, on the sides that their rays came from,
    /// [`SurfacePoint::bent_normal`] leaves as they are. Bits beyond the last lane mean nothing.
    #[must_use]
    pub fn unbent(&self, level: Level, first: usize, normals: &[[f32; LANES]; 3]) -> u32 {
        let count = LANES.min(self.len() - first);
        dispatch_wide!(
            level,
            simd => self.unbent_of(f32x16::splat(simd, 0.0), (first, 0), normals),
            else (0..count).fold(0, |bits, lane| bits | self.unbent_of(0.0_f32, (first, lane), normals))
        )
    }

    #[inline(always)]
    fn unbent_of<R: Real>(&self, like: R, (first, lane): (usize, usize), normals: &[[f32; LANES]; 3]) -> u32 {
        let load = |v: &Vec3s| Vector::load(like, [&v.x, &v.y, &v.z], first + lane);
        let [x, y, z] = normals;
        let n = Vector::load(like, [x, y, z], lane);
        let (ng, ns, wo) = (load(&self.ng), load(&self.ns), -load(&self.ray_dir));
        let zero = like.all(0.0);
        let ng = Vector::pick(zero.above(ng.dot(wo)), -ng, ng);
        let ns = Vector::pick(zero.above(ns.dot(ng)), -ns, ns);
        let is_flat = load(&self.lift).is_zero();
        (R::bits(is_unbent(n, wo, ns, ng, is_flat)) << lane) as u32
    }

    /// Texture coordinates of lane `i`.
    #[inline]
    #[must_use]
    pub fn uv(&self, i: usize) -> [f32; 2] {
        [self.texcoord[0][i], self.texcoord[1][i]]
    }

    /// The footprint of lane `i` in texture coordinates: their changes along the two axes of the ellipse in
    /// which the ray's cone meets the surface, as diameters. Source: \[AM21\] section 4. Zero where unknown.
    #[must_use]
    pub fn texture_axes(&self, i: usize) -> [[f32; 2]; 2] {
        let width = self.footprint.get(i).copied().unwrap_or(0.0);
        if !(width > 0.0 && width.is_finite()) || self.dp_du.is_empty() {
            return [[0.0; 2]; 2];
        }
        let (dir, ng) = (self.ray_dir.get(i), self.ng.get(i));
        let cos = dir.dot(ng);
        // Stretched where it falls on the surface aslant.
        let along = (dir - ng * cos).try_normalize().unwrap_or_else(|| ng.any_orthonormal_vector());
        let own = [self.dp_du.get(i), self.dp_dv.get(i)];
        let across = ng.cross(along);
        [uv_step(own, along * (width / cos.abs().max(1e-4))), uv_step(own, across * width)]
    }

    /// Width of the footprint of lane `i`, in texture coordinates, along its longest direction; 0 where
    /// unknown.
    #[inline]
    #[must_use]
    pub fn texture_width(&self, i: usize) -> f32 {
        let (width, cos) = self.across(i);
        width / cos
    }

    /// Width of the footprint of lane `i` at perpendicular incidence, in texture coordinates, and the cosine
    /// of incidence.
    #[inline]
    fn across(&self, i: usize) -> (f32, f32) {
        let known = |values: &[f32]| values.get(i).copied().unwrap_or(0.0);
        let cos = self.ng.get(i).dot(self.ray_dir.get(i)).abs();
        (known(&self.footprint) * known(&self.uv_per_length), cos.max(1e-4))
    }

    /// Area of the footprint of lane `i`, in texture coordinates; 0 where unknown.
    #[inline]
    #[must_use]
    pub fn texture_area(&self, i: usize) -> f32 {
        let (width, cos) = self.across(i);
        width * width / cos
    }

    /// Whether a broad lobe sent the ray of lane `i`, so that its cone gives the size of the footprint but
    /// hardly its shape.
    #[inline]
    #[must_use]
    pub fn is_vague(&self, i: usize) -> bool {
        self.depth > 0 && self.cone_spread.get(i).is_some_and(|spread| spread.abs() > VAGUE)
    }

    /// The kind of the ray of lane `i`.
    #[inline]
    #[must_use]
    pub fn ray_kind(&self, i: usize) -> RayKind {
        let unknown = if self.depth == 0 { RayKind::Camera } else { RayKind::Diffuse };
        self.kinds.get(i).copied().unwrap_or(unknown)
    }

    /// Whether the ray of lane `i` came from the side that the geometric normal points to.
    #[inline(always)]
    #[must_use]
    pub fn front(&self, i: usize) -> bool {
        self.ng.get(i).dot(self.ray_dir.get(i)) <= 0.0
    }

    /// The data for rays that leave lane `i`.
    #[must_use]
    pub fn point(&self, i: usize) -> SurfacePoint {
        let ng = self.facing_ng(i);
        SurfacePoint {
            p: self.p.get(i),
            // Excluded rows count as zero.
            error: self.error.get(i).copied().unwrap_or(0.0),
            ng,
            ns: if self.ns.get(i).dot(ng) < 0.0 { -self.ns.get(i) } else { self.ns.get(i) },
            lift: if self.lift.is_empty() { Vec3::ZERO } else { self.lift.get(i) },
        }
    }

    /// See [`SurfacePoint::spawn`].
    #[must_use]
    pub fn spawn(&self, i: usize, dir: Vec3, t_far: f32) -> Ray {
        self.point(i).spawn(dir, t_far)
    }

    /// See [`SurfacePoint::spawn_to`].
    #[must_use]
    pub fn spawn_to(&self, i: usize, dir: Vec3, dist: f32) -> Ray {
        self.point(i).spawn_to(dir, dist)
    }

    /// See [`SurfacePoint::shadow_ray`].
    #[must_use]
    pub fn shadow_ray(&self, i: usize, dir: Vec3, dist: f32) -> Option<Ray> {
        self.point(i).shadow_ray(dir, dist, false)
    }

    /// A batch of some of the lanes, in the order given.
    #[must_use]
    pub fn gather(&self, lanes: &[u32]) -> Self {
        fn pick<T: Copy>(values: &[T], lanes: &[u32]) -> Vec<T> {
            if values.is_empty() { Vec::new() } else { lanes.iter().map(|&i| values[i as usize]).collect() }
        }
        let components = |values: &Vec<f32>| values.chunks(self.len()).flat_map(|c| pick(c, lanes)).collect();
        let mut some = self.clone();
        some.each_row(
            |v| *v = Vec3s { x: pick(&v.x, lanes), y: pick(&v.y, lanes), z: pick(&v.z, lanes) },
            |row| *row = pick(row, lanes),
            |row| *row = pick(row, lanes),
        );
        (some.kinds, some.key) = (pick(&self.kinds, lanes), pick(&self.key, lanes));
        some.bounces = pick(&self.bounces, lanes);
        some.attributes = self.attributes.iter().map(components).collect();
        some
    }
}

/// How texture coordinates change along `step` within a surface whose points change by `dp_du` and `dp_dv` with them; zero where
/// they do not.
#[must_use]
pub fn uv_step([dp_du, dp_dv]: [Vec3; 2], step: Vec3) -> [f32; 2] {
    let (uu, uv, vv) = (dp_du.dot(dp_du), dp_du.dot(dp_dv), dp_dv.dot(dp_dv));
    let area = uu * vv - uv * uv;
    let (a, b) = (dp_du.dot(step), dp_dv.dot(step));
    let found = [(a * vv - b * uv) / area, (b * uu - a * uv) / area];
    if found.iter().all(|x| x.is_finite()) { found } else { [0.0; 2] }
}
