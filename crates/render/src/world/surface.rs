// SPDX-License-Identifier: GPL-3.0-or-later
//! From hits to surface points: positions, normals, coordinates and attributes out of the meshes' arrays, as many points at a time
//! as the CPU's registers hold.
//! Source: [PJH23] section 6.8 (bounding the error of a hit point); [Hanika2021] (`lift`); original. Space: world.
//! Points are computed from barycentric weights instead of `org + t dir`: they are in their triangle's plane
//! up to rounding, and `error` bounds that from the largest coordinate involved.
//! Invariant: every CPU level gives the same bits. Tests: crates/render/tests/{offsets,terminator,appearance,lanes}.rs.

use std::sync::Arc;

use glam::{DVec3, Mat3, Vec3};
use gnurt_accel::{HitBatch, KeyInterval, RayBatch, SceneTree, SharedList};
use gnurt_scene::{Attribute, Mesh, Rate};
use gnurt_shading::lanes::LANES;
use gnurt_shading::real::{Real, Vector};
use gnurt_shading::{AttributeRequest, Detail, SampleKey, SceneNames, SurfaceBatch, Vec3s};
use gnurt_simd::{Level, dispatch_wide, f32x16, prelude::*};

use super::instance::{InstanceSlot, PlacedInstance};
use super::normals::{Columns, Precise};
use super::open::Shutter;
use super::strands;
use super::transform::Transform;
use crate::cone::Cones;

/// Rounding errors of the point, of its transform, and of the test that the next ray makes against the same triangle,
/// as a multiple of the largest coordinate.
const ERROR_SCALE: f32 = 8.0 * f32::EPSILON;

/// The input of a batch of points.
#[derive(Clone, Copy)]
pub(crate) struct HitLanes<'a> {
    pub(crate) rays: &'a RayBatch,
    pub(crate) keys: &'a [SampleKey],
    pub(crate) hits: &'a HitBatch,
    /// The rays' cones; `None` = a pixel for camera rays, unknown for others.
    pub(crate) cones: Option<&'a Cones>,
    /// Bounces that the rays had behind them.
    pub(crate) depth: u32,
}

impl HitLanes<'_> {
    /// Whether the camera sent the ray of a lane.
    pub(crate) fn is_of_camera(&self, lane: usize) -> bool {
        self.cones.map_or(self.depth == 0, |cones| cones.get(lane).is_of_camera())
    }
}

type Row = [f32; LANES];

/// Whose a leaf is that a hit names.
#[derive(Clone, Copy)]
pub(super) enum Leaves<'w> {
    /// As the tree over the instances numbers them.
    Tree(&'w SceneTree),
    /// By leaf: the index of its instance, and its number in it.
    Listed(&'w [[u32; 2]]),
}

/// The geometry of points: the world, or its emissive part.
#[derive(Clone, Copy)]
pub(crate) struct SurfacePoints<'w> {
    pub(super) instances: &'w SharedList<InstanceSlot>,
    pub(super) leaves: Leaves<'w>,
    /// The times of rays; `None` = nothing moves.
    pub(super) shutter: Option<Shutter>,
    pub(super) face_normals: bool,
    /// Whether points have curvatures, because some surface reads the width of ray cones.
    pub(super) curved: bool,
    /// Names of the scene's parts, if some shader requests them.
    pub(super) names: Option<&'w Arc<SceneNames>>,
}

/// The gathered input of some points, out of the meshes' arrays; rows of vectors follow each other.
struct Gathered<'w> {
    /// With the numbers of objects in the instances.
    instances: [Option<(&'w PlacedInstance, u32)>; LANES],
    meshes: [Option<&'w Mesh>; LANES],
    /// Of meshes that bend while the shutter is open.
    keys: [&'w [Arc<Mesh>]; LANES],
    times: Row,
    vertices: [[usize; 3]; LANES],
    /// Three corners, object space.
    corners: [Row; 9],
    /// Their normals, of any length; zero where there are none.
    normals: [Row; 9],
    /// Their texture coordinates.
    uv: [Row; 6],
    /// Of ribbons that face rays: how far a ray must start from them. World.
    widths: Row,
    /// Linear part, matrix of normals, origin, greatest intermediate coordinate.
    transform: [Row; 22],
    has: Has,
    /// Whether curvatures are needed, and all of `Detail::Full`.
    curved: bool,
    full: bool,
}

/// Optional attributes that some of them have.
#[derive(Clone, Copy, Default)]
struct Has {
    normals: bool,
    uv: bool,
    colors: bool,
    tangents: bool,
    divisors: bool,
    widths: bool,
}

impl<'w> Gathered<'w> {
    fn new() -> Self {
        Self {
            instances: [None; LANES],
            meshes: [None; LANES],
            keys: [&[]; LANES],
            times: [0.0; LANES],
            vertices: [[0; 3]; LANES],
            corners: [[0.0; LANES]; 9],
            normals: [[0.0; LANES]; 9],
            uv: [[0.0; LANES]; 6],
            widths: [0.0; LANES],
            transform: [[0.0; LANES]; 22],
            has: Has::default(),
            curved: false,
            full: false,
        }
    }

    /// Reads the input of the points of these lanes, sixteen or fewer.
    fn read(&mut self, point_sources: &SurfacePoints<'w>, from: HitLanes, lanes: &[u32]) {
        let hits = from.hits;
        if self.has.widths {
            self.widths = [0.0; LANES];
        }
        self.has = Has::default();
        let (mut last, mut known) = ([u32::MAX; 2], None);
        for (i, &lane) in lanes.iter().enumerate().take(LANES) {
            let lane = lane as usize;
            let ids = [hits.leaf_id[lane], hits.geom_id[lane]];
            if ids != last {
                let (instance, leaf) = point_sources.instance(ids[0]);
                let (object, geom_id) = (instance.leaf(leaf).0, ids[1] as usize);
                let keys = object.keys.get(geom_id).map_or(&[][..], |keys| &keys[..]);
                known = Some(((instance, leaf), &*object.meshes[geom_id], keys));
                last = ids;
            }
            let Some((instance, mesh, keys)) = known else { continue };
            (self.instances[i], self.meshes[i], self.keys[i]) = (Some(instance), Some(mesh), keys);
            if let Some(shutter) = point_sources.shutter {
                self.times[i] = shutter.time(from.keys[lane]);
            }
            let prim_id = hits.prim_id[lane] as usize;
            let vertices = mesh.corners(prim_id).expect("hits name primitives that are there");
            self.vertices[i] = vertices;
            if !mesh.has_triangles() {
                self.read_curved(i, from, lane);
                continue;
            }
            for (c, &vertex) in vertices.iter().enumerate() {
                put_vector(&mut self.corners, 3 * c, i, mesh.positions[vertex]);
            }
            self.read_attributes(i, mesh, !point_sources.face_normals);
            if !keys.is_empty() {
                self.bend(i);
            }
        }
        self.read_places(lanes.len().min(LANES));
    }

    /// Reads a hit on a curve or a sphere.
    #[cold]
    fn read_curved(&mut self, i: usize, from: HitLanes, lane: usize) {
        let (Some(mesh), Some((instance, leaf))) = (self.meshes[i], self.instances[i]) else { return };
        let (rays, hits) = (from.rays, from.hits);
        let Transform { linear, origin, .. } = instance.leaf_at(leaf, self.times[i]);
        let object_from_world = linear.as_dmat3().inverse();
        let [org, dir] = [&rays.org, &rays.dir]
            .map(|v| DVec3::new(v[0][lane].into(), v[1][lane].into(), v[2][lane].into()));
        let hit = strands::Hit {
            prim_id: hits.prim_id[lane] as usize,
            uv: [hits.u[lane], hits.v[lane]],
            point: object_from_world * (org + dir * f64::from(hits.t[lane]) - origin.as_dvec3()),
            dir: object_from_world * dir,
        };
        if !self.has.uv {
            (self.uv, self.has.uv) = ([[0.0; LANES]; 6], true);
        }
        self.has.colors |= !mesh.colors.is_empty();
        // A point without a tangent plane is one of no area: seen along the ray.
        let across = || strands::Tangent::across(hit.point, hit.dir.any_orthonormal_vector(), hit.dir);
        let tangent = hit.tangent(mesh).unwrap_or_else(across);
        for c in 0..3 {
            put_vector(&mut self.corners, 3 * c, i, tangent.corners[c]);
            (self.uv[2 * c][i], self.uv[2 * c + 1][i]) = (tangent.uv[c][0], tangent.uv[c][1]);
        }
        self.widths[i] =
            tangent.width * linear.to_cols_array().iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        self.has.widths |= tangent.width > 0.0;
    }

    /// Reads the attributes that only some meshes have.
    fn read_attributes(&mut self, i: usize, mesh: &Mesh, normals: bool) {
        let smooth = normals && !mesh.normals.is_empty();
        // Lanes without any are zero, but need not be written where no lane has some.
        if smooth && !self.has.normals {
            (self.normals, self.has.normals) = ([[0.0; LANES]; 9], true);
        }
        if !mesh.texcoords.is_empty() && !self.has.uv {
            (self.uv, self.has.uv) = ([[0.0; LANES]; 6], true);
        }
        for (c, &vertex) in self.vertices[i].iter().enumerate() {
            if let Some(&normal) = mesh.normals.get(vertex).filter(|_| smooth) {
                put_vector(&mut self.normals, 3 * c, i, normal);
            }
            if let Some(&[u, v]) = mesh.texcoords.get(vertex) {
                (self.uv[2 * c][i], self.uv[2 * c + 1][i]) = (u, v);
            }
        }
        self.has.divisors |= self.has.uv && !mesh.attributes.is_empty();
        self.has.colors |= !mesh.colors.is_empty();
        self.has.tangents |= !mesh.tangents.is_empty();
    }

    /// Corners and normals of lane `i` at its time.
    #[cold]
    fn bend(&mut self, i: usize) {
        let (interval, keys) = (KeyInterval::of(self.times[i], self.keys[i].len()), self.keys[i]);
        let (from, to) = (&keys[interval.key], &keys[interval.next]);
        for (c, &vertex) in self.vertices[i].iter().enumerate() {
            if let (Some(&a), Some(&b)) = (from.positions.get(vertex), to.positions.get(vertex)) {
                put_vector(&mut self.corners, 3 * c, i, interval.mix3(a, b));
            }
            // Without any if they are not needed.
            let has_one = (0..3).any(|k| self.normals[3 * c + k][i] != 0.0);
            if let (true, Some(&a), Some(&b)) = (has_one, from.normals.get(vertex), to.normals.get(vertex)) {
                put_vector(&mut self.normals, 3 * c, i, interval.mix3(a, b));
            }
        }
    }

    /// Reads where the first `count` lanes' objects are: once for neighbours of one object.
    fn read_places(&mut self, count: usize) {
        let mut first = 0;
        while first < count {
            let Some((instance, leaf)) = self.instances[first] else { return };
            let is_same =
                |i: &usize| self.instances[*i].is_some_and(|it| it.1 == leaf && std::ptr::eq(it.0, instance));
            let moves = instance.motion.is_some() || instance.object.members_move;
            let end = (first + 1..count)
                .find(|&i| !is_same(&i) || (moves && self.times[i] != self.times[first]))
                .unwrap_or(count);
            let Transform { linear, normals, origin, interpolated, .. } =
                instance.leaf_at(leaf, self.times[first]);
            let (linear, normals) = (linear.to_cols_array(), normals.to_cols_array());
            for k in 0..9 {
                self.transform[k][first..end].fill(linear[k]);
                self.transform[9 + k][first..end].fill(normals[k]);
            }
            for k in 0..3 {
                self.transform[18 + k][first..end].fill(origin[k]);
            }
            self.transform[21][first..end].fill(interpolated);
            first = end;
        }
    }
}

/// Appends the values of some lanes.
#[inline]
fn pick<T: Copy>(out: &mut Vec<T>, of: &[T], lanes: &[u32]) {
    out.extend(lanes.iter().map(|&lane| of[lane as usize]));
}

/// Writes lane `i` of rows `k` to `k + 2`.
#[inline(always)]
fn put_vector(rows: &mut [Row; 9], k: usize, i: usize, [x, y, z]: [f32; 3]) {
    (rows[k][i], rows[k + 1][i], rows[k + 2][i]) = (x, y, z);
}

/// Rows `k` to `k + 2` from lane `first` on.
#[inline(always)]
fn vector<R: Real>(like: R, rows: &[Row], k: usize, first: usize) -> Vector<R> {
    Vector::load(like, [&rows[k], &rows[k + 1], &rows[k + 2]], first)
}

#[inline(always)]
fn vectors<R: Real>(like: R, rows: &[Row], k: usize, first: usize) -> [Vector<R>; 3] {
    [vector(like, rows, k, first), vector(like, rows, k + 3, first), vector(like, rows, k + 6, first)]
}

#[inline(always)]
fn mix<R: Real>(values: &[Vector<R>; 3], [a, b, c]: [R; 3]) -> Vector<R> {
    values[0] * a + values[1] * b + values[2] * c
}

/// Writes `count` lanes of a batch's array from position `at` on, which is in it or its end.
#[inline(always)]
fn put<R: Real>(out: &mut Vec<f32>, (at, count): (usize, usize), value: R) {
    let mut row = [0.0; LANES];
    for (i, out) in row.iter_mut().enumerate().take(R::LANES) {
        *out = value.lane(i);
    }
    if at == out.len() {
        // All of it and back again: copying so few of a number that is known later takes longer.
        out.extend_from_slice(&row);
        out.truncate(at + count);
    } else {
        out[at..at + count].copy_from_slice(&row[..count]);
    }
}

#[inline(always)]
fn put3<R: Real>(out: &mut Vec3s, range: (usize, usize), v: Vector<R>) {
    put(&mut out.x, range, v.x);
    put(&mut out.y, range, v.y);
    put(&mut out.z, range, v.z);
}

impl<'w> SurfacePoints<'w> {
    /// The instance of a leaf, and the leaf's number in it. Panics where nothing can be hit; hits name only
    /// instances that are there.
    #[inline]
    pub(super) fn instance(&self, leaf_id: u32) -> (&'w PlacedInstance, u32) {
        let (transform, leaf) = match self.leaves {
            Leaves::Tree(tree) => tree.instance_at(leaf_id).expect("hits name objects that are there"),
            Leaves::Listed(list) => (list[leaf_id as usize][0], list[leaf_id as usize][1]),
        };
        (self.instances[transform as usize].placed().expect("hits name instances that are there"), leaf)
    }

    /// Writes the points of some lanes, all of which hit something: others panic. `epsilon`: world units added to each point's error.
    pub(crate) fn surface_points(
        &self,
        (level, epsilon): (Level, f32),
        from: HitLanes,
        lanes: &[u32],
        detail: Detail,
        attributes: &[AttributeRequest],
        points: &mut SurfaceBatch,
    ) {
        points.clear();
        points.depth = from.depth;
        let (hits, [x, y, z]) = (from.hits, &from.rays.dir);
        let Vec3s { x: dir_x, y: dir_y, z: dir_z } = &mut points.ray_dir;
        [(dir_x, x), (dir_y, y), (dir_z, z)].into_iter().for_each(|(out, of)| pick(out, of, lanes));
        pick(&mut points.key, from.keys, lanes);
        let numbers =
            [(&mut points.t, &hits.t), (&mut points.u, &hits.u), (&mut points.v, &hits.v)].into_iter();
        numbers.for_each(|(out, of)| pick(out, of, lanes));
        pick(&mut points.prim_id, &hits.prim_id, lanes);
        pick(&mut points.geom_id, &hits.geom_id, lanes);
        pick(&mut points.inst_id, &hits.inst_id, lanes);
        pick(&mut points.leaf_id, &hits.leaf_id, lanes);
        let full = detail == Detail::Full;
        let mut gathered = Gathered { curved: self.curved, full, ..Gathered::new() };
        for (block, some) in lanes.chunks(LANES).enumerate() {
            gathered.read(self, from, some);
            let at = block * LANES;
            dispatch_wide!(
                level,
                simd => gathered.points(f32x16::splat(simd, 0.0), (0, some.len()), at, epsilon, points),
                else (0..some.len()).for_each(|i| gathered.points(0.0_f32, (i, 1), at + i, epsilon, points))
            );
            gathered.rare(some.len(), at, points);
        }
        // Blocks without normals have none.
        if !points.curvature.is_empty() {
            points.curvature.resize(lanes.len(), 0.0);
        }
        points.attributes = attributes.iter().map(|request| self.attribute(request, points)).collect();
        if attributes.iter().any(|request| request.name == AttributeRequest::IDS) {
            points.names = self.names.cloned();
        }
    }

    /// Component k of lane i at `[k * lanes + i]`.
    fn attribute(&self, request: &AttributeRequest, points: &SurfaceBatch) -> Vec<f32> {
        let (lanes, components) = (points.len(), request.components as usize);
        let default = |k: usize| request.default.get(k).copied().unwrap_or(0.0);
        let mut values = vec![0.0; lanes * components];
        if request.name == AttributeRequest::WORLD_FROM_OBJECT {
            for i in 0..lanes {
                let (instance, leaf) = self.instance(points.leaf_id[i]);
                // As it is when the shutter opens.
                let Transform { linear, origin, .. } = instance.leaf_at(leaf, 0.0);
                let columns = [linear.x_axis, linear.y_axis, linear.z_axis];
                let numbers = columns.into_iter().chain([origin]).flat_map(|v| v.to_array());
                numbers.take(components).enumerate().for_each(|(k, x)| values[k * lanes + i] = x);
            }
            return values;
        }
        if request.name == AttributeRequest::TIME {
            if let Some(shutter) = self.shutter {
                values.iter_mut().zip(&points.key).for_each(|(value, &key)| *value = shutter.time(key));
            }
            return values;
        }
        if request.name == AttributeRequest::IDS {
            for i in 0..lanes {
                let (instance, leaf) = self.instance(points.leaf_id[i]);
                let (object, object_id) = instance.leaf(leaf);
                let material = object.meshes[points.geom_id[i] as usize].material.0;
                let ids = [points.inst_id[i], object_id.0, material, points.prim_id[i]];
                let numbers = ids.map(f32::from_bits).into_iter().take(components);
                numbers.enumerate().for_each(|(k, x)| values[k * lanes + i] = x);
            }
            return values;
        }
        if request.name == AttributeRequest::SHUTTER {
            values.fill(if self.shutter.is_some() { 1.0 } else { 0.0 });
            return values;
        }
        if request.name == AttributeRequest::VELOCITY {
            let Some(shutter) = self.shutter else { return values };
            for i in 0..lanes {
                let (instance, leaf) = self.instance(points.leaf_id[i]);
                let (primitive, uv) = ((points.geom_id[i], points.prim_id[i]), [points.u[i], points.v[i]]);
                let time = shutter.time(points.key[i]);
                let velocity = instance.velocity_at(leaf, primitive, uv, points.p.get(i), time).to_array();
                velocity
                    .into_iter()
                    .take(components)
                    .enumerate()
                    .for_each(|(k, x)| values[k * lanes + i] = x);
            }
            return values;
        }
        if request.name == AttributeRequest::SURFACE_AREA {
            let mut last = ([u32::MAX; 2], 0.0);
            for (i, value) in values.iter_mut().enumerate().take(lanes) {
                let ids = [points.leaf_id[i], points.geom_id[i]];
                if ids != last.0 {
                    let (instance, leaf) = self.instance(ids[0]);
                    let object = instance.leaf(leaf).0;
                    let transform = instance.leaf_at(leaf, 0.0);
                    last = (ids, object.areas.of(&object.meshes, ids[1], &transform.linear));
                }
                *value = last.1;
            }
            return values;
        }
        if let Some(name) = request.name.strip_prefix(AttributeRequest::GRADIENT) {
            for i in 0..lanes {
                let (instance, leaf) = self.instance(points.leaf_id[i]);
                let mesh = &*instance.leaf(leaf).0.meshes[points.geom_id[i] as usize];
                let time = self.shutter.map_or(0.0, |shutter| shutter.time(points.key[i]));
                let linear = instance.leaf_at(leaf, time).linear;
                let found = mesh.attributes.iter().find(|a| a.name == name);
                for k in 0..components / 3 {
                    let of_vertex = |vertex: usize| match found {
                        Some(a) if a.rate == Rate::Vertex && k < a.components as usize => {
                            a.data.get(vertex * a.components as usize + k).copied()
                        }
                        None if name == "Cd" && k < 3 => mesh.colors.get(vertex).map(|color| color[k]),
                        _ => None,
                    };
                    let slope = gradient(mesh, points.prim_id[i] as usize, of_vertex, |edge| linear * edge);
                    let slope = slope.unwrap_or(Vec3::ZERO).to_array();
                    (0..3).for_each(|c| values[(3 * k + c) * lanes + i] = slope[c]);
                }
            }
            return values;
        }
        let object_of = |leaf_id: u32| {
            let (instance, leaf) = self.instance(leaf_id);
            instance.leaf(leaf).0
        };
        // Names are compared once for lanes of one mesh that follow each other.
        let mut last: Option<(&Mesh, Option<&Attribute>)> = None;
        for i in 0..lanes {
            let mesh = &*object_of(points.leaf_id[i]).meshes[points.geom_id[i] as usize];
            let found = match last {
                Some((same, found)) if std::ptr::eq(same, mesh) => found,
                _ => mesh.attributes.iter().find(|a| a.name == request.name),
            };
            last = Some((mesh, found));
            let prim_id = points.prim_id[i] as usize;
            let weights = [1.0 - points.u[i] - points.v[i], points.u[i], points.v[i]];
            for k in 0..components {
                let value = found.and_then(|a| attribute_at(a, mesh, prim_id, weights, k));
                values[k * lanes + i] = value.unwrap_or_else(|| default(k));
            }
        }
        values
    }
}

impl Gathered<'_> {
    /// Writes points from position `at` of the batch on, `count` of the lanes from `first` on.
    #[inline(always)]
    fn points<R: Precise>(
        &self,
        like: R,
        (first, count): (usize, usize),
        at: usize,
        epsilon: f32,
        out: &mut SurfaceBatch,
    ) {
        let (zero, one, range) = (like.all(0.0), like.all(1.0), (at, count));
        let corners = vectors(zero, &self.corners, 0, first);
        let linear = Columns(vectors(zero, &self.transform, 0, first));
        let normals = Columns(vectors(zero, &self.transform, 9, first));
        let origin = vector(zero, &self.transform, 18, first);
        let (u, v) = (zero.load(&out.u, at), zero.load(&out.v, at));
        let weights = [one - u - v, u, v];
        let p = linear.times(mix(&corners, weights)) + origin;
        let ng = R::geometric_normals(&corners, &normals);
        put3(&mut out.p, range, p);
        put3(&mut out.ng, range, ng);
        let full = self.full;
        let (mut ns, mut lift) = (ng, Vector::grey(zero));
        if self.has.normals {
            // Normals of any length: each counts as a direction. The triangle is flat if one has none.
            let black = Vector::grey(zero);
            let units = vectors(zero, &self.normals, 0, first).map(
                #[inline(always)]
                |n| n.normalize_or(black),
            );
            let mixed = normals.times(mix(&units, weights)).normalize_or(black);
            let flat = units[0].is_zero() | units[1].is_zero() | units[2].is_zero() | mixed.is_zero();
            ns = Vector::pick(flat, ng, mixed);
            if full {
                // On the side that the ray comes from, as the facing shading normal is.
                let ray_dir = Vector::load(zero, [&out.ray_dir.x, &out.ray_dir.y, &out.ray_dir.z], at);
                let to_viewer = Vector::pick(ng.dot(ray_dir).above(zero), -ng, ng);
                let behind = zero.above(ns.dot(to_viewer));
                let placed = corners.map(
                    #[inline(always)]
                    |corner| linear.times(corner) + origin,
                );
                let turned = units.map(
                    #[inline(always)]
                    |unit| normals.times(unit).normalize_or(black),
                );
                for (corner, (normal, weight)) in placed.iter().zip(turned.iter().zip(weights)) {
                    let visible = Vector::pick(behind, -*normal, *normal);
                    let below = (*corner - p).dot(visible).or_more(zero);
                    lift = lift + visible * below * weight;
                }
                lift = Vector::pick(flat, black, lift);
                if self.curved {
                    out.curvature.resize(at + count, 0.0);
                    put(&mut out.curvature, range, R::pick(flat, zero, curvature(&placed, &turned)));
                }
            }
        }
        put3(&mut out.ns, range, ns);
        let mut uv = [zero; 2];
        if self.has.uv {
            for (k, uv) in uv.iter_mut().enumerate() {
                for (c, &weight) in weights.iter().enumerate() {
                    *uv = *uv + weight * zero.load(&self.uv[2 * c + k], first);
                }
            }
        }
        put(&mut out.texcoord[0], range, uv[0]);
        put(&mut out.texcoord[1], range, uv[1]);
        put3(&mut out.color, range, Vector::grey(one));
        put(&mut out.alpha, range, one);
        if full {
            let reach = corners[0].abs().max(corners[1].abs()).max(corners[2].abs());
            let [x, y, z] = linear.0;
            let most = x.abs() * reach.x + y.abs() * reach.y;
            let magnitude = (most + z.abs() * reach.z + origin.abs()).max_element();
            let magnitude = magnitude.or_more(zero.load(&self.transform[21], first));
            let width = if self.has.widths { zero.load(&self.widths, first) } else { zero };
            put(&mut out.error, range, magnitude * ERROR_SCALE + zero.all(epsilon) + width);
            put3(&mut out.lift, range, lift);
        }
        self.changes((zero, first), &corners, &linear, range, out);
    }

    /// Writes how points and texture coordinates change with each other.
    #[inline(always)]
    fn changes<R: Real>(
        &self,
        (zero, first): (R, usize),
        corners: &[Vector<R>; 3],
        linear: &Columns<R>,
        range: (usize, usize),
        out: &mut SurfaceBatch,
    ) {
        let black = Vector::grey(zero);
        let (mut dp_du, mut dp_dv, mut scale) = (black, black, zero);
        if self.has.uv {
            let uv = |c: usize, k: usize| zero.load(&self.uv[2 * c + k], first);
            let (du1, dv1) = (uv(1, 0) - uv(0, 0), uv(1, 1) - uv(0, 1));
            let (du2, dv2) = (uv(2, 0) - uv(0, 0), uv(2, 1) - uv(0, 1));
            let area = du1 * dv2 - du2 * dv1;
            let (a, b) = (corners[1] - corners[0], corners[2] - corners[0]);
            let (du, dv) = ((a * dv2 - b * dv1).over(area), (b * du1 - a * du2).over(area));
            dp_du = Vector::pick(du.is_finite(), linear.times(du), black);
            dp_dv = Vector::pick(dv.is_finite(), linear.times(dv), black);
            // Root of the triangle's area in texture coordinates over that in the world.
            let ratio = area.size() / linear.times(a).cross(linear.times(b)).length_squared().root();
            scale = R::pick(ratio.is_number(), ratio, zero).root();
        }
        put(&mut out.uv_per_length, range, scale);
        put3(&mut out.dp_du, range, dp_du);
        put3(&mut out.dp_dv, range, dp_dv);
    }

    /// Writes rare attributes: colours, tangents, coordinates with divisors.
    fn rare(&self, count: usize, at: usize, out: &mut SurfaceBatch) {
        let Has { colors, tangents, divisors, .. } = self.has;
        if !(colors || tangents || divisors) {
            return;
        }
        for i in 0..count {
            let (Some(mesh), vertices) = (self.meshes[i], self.vertices[i]) else { continue };
            let linear = Mat3::from_cols_array(&std::array::from_fn(|k| self.transform[k][i]));
            let transform = at + i;
            let (u, v) = (out.u[transform], out.v[transform]);
            let weights = [1.0 - u - v, u, v];
            let [r, g, b, a] = vertex_color(mesh, vertices, weights);
            out.color.set(transform, Vec3::new(r, g, b));
            out.alpha[transform] = a;
            if divisors && let Some(q) = mesh.texcoord_divisors(vertices) {
                let divisor = (0..3).map(|c| weights[c] * q[c]).sum::<f32>();
                (out.texcoord[0][transform], out.texcoord[1][transform]) =
                    (out.texcoord[0][transform] / divisor, out.texcoord[1][transform] / divisor);
                let mut divided = Self::new();
                divided.has.uv = true;
                for (k, row) in divided.uv.iter_mut().enumerate() {
                    row[0] = self.uv[k][i] / q[k / 2];
                }
                let corners = [0, 3, 6].map(|k| Vector::from(self.vector_of(k, i)));
                let linear = Columns([linear.x_axis, linear.y_axis, linear.z_axis].map(Vector::from));
                divided.changes((0.0_f32, 0), &corners, &linear, (transform, 1), out);
            }
            if let Some([along, across]) = self.tangents(i, weights) {
                let length = |v: Vec3| if v == Vec3::ZERO { 1.0 } else { v.length() };
                let lengths = [out.dp_du.get(transform), out.dp_dv.get(transform)].map(length);
                out.dp_du.set(transform, (linear * along).normalize_or_zero() * lengths[0]);
                out.dp_dv.set(transform, (linear * across).normalize_or_zero() * lengths[1]);
            }
        }
    }

    /// Corner `k / 3` of lane `i`.
    fn vector_of(&self, k: usize, i: usize) -> Vec3 {
        Vec3::new(self.corners[k][i], self.corners[k + 1][i], self.corners[k + 2][i])
    }

    /// The mesh's own tangents at lane `i`, where all corners have one and normals to go with them: unit, object space.
    fn tangents(&self, i: usize, weights: [f32; 3]) -> Option<[Vec3; 2]> {
        let mesh = self.meshes[i]?;
        if mesh.tangents.is_empty() {
            return None;
        }
        let (mut tangent, mut normal, mut side) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for (c, &vertex) in self.vertices[i].iter().enumerate() {
            let [x, y, z, w] = *mesh.tangents.get(vertex)?;
            let [x, y, z] = self.bent_tangent(i, vertex).unwrap_or([x, y, z]);
            tangent += Vec3::new(x, y, z).try_normalize()? * weights[c];
            let [x, y, z] = [0, 1, 2].map(|k| self.normals[3 * c + k][i]);
            normal += Vec3::new(x, y, z).try_normalize()? * weights[c];
            side += w;
        }
        let tangent = tangent.try_normalize()?;
        Some([tangent, normal.cross(tangent).try_normalize()? * 1.0_f32.copysign(side)])
    }

    /// The tangent of a vertex of lane `i` at its time, if the mesh deforms.
    fn bent_tangent(&self, i: usize, vertex: usize) -> Option<[f32; 3]> {
        let keys = self.keys[i];
        let interval = KeyInterval::of(self.times[i], keys.len());
        let at = |key: usize| keys.get(key)?.tangents.get(vertex).map(|&[x, y, z, _]| [x, y, z]);
        Some(interval.mix3(at(interval.key)?, at(interval.next)?))
    }
}

/// Mean curvature over a triangle by the rotation of its normals along its edges: the mean of the edges'
/// \[AM21\].
#[inline(always)]
fn curvature<R: Real>(corners: &[Vector<R>; 3], normals: &[Vector<R>; 3]) -> R {
    let zero = corners[0].x.all(0.0);
    let mut sum = zero;
    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
        let edge = corners[b] - corners[a];
        sum = sum + edge.dot(normals[b] - normals[a]) / edge.length_squared();
    }
    R::pick(sum.is_number(), sum * zero.all(1.0 / 3.0), zero)
}

/// Component `k` of an attribute; `None` where it has none.
fn attribute_at(a: &Attribute, mesh: &Mesh, prim_id: usize, weights: [f32; 3], k: usize) -> Option<f32> {
    let n = a.components as usize;
    let value = |i: usize| a.data.get(i * n + k).copied().filter(|_| k < n);
    match a.rate {
        Rate::Triangle => value(prim_id),
        Rate::Vertex => {
            let corners = mesh.corners(prim_id)?;
            (0..3).try_fold(0.0, |sum, c| Some(sum + weights[c] * value(corners[c])?))
        }
    }
}

/// How a value of vertices changes over a primitive: along a triangle's plane, or a segment; `None` where it does not.
fn gradient(
    mesh: &Mesh,
    prim_id: usize,
    value: impl Fn(usize) -> Option<f32>,
    to_world: impl Fn(Vec3) -> Vec3,
) -> Option<Vec3> {
    let [a, b, c] = mesh.corners(prim_id)?;
    let change = |from: usize, to: usize| Some(value(to)? - value(from)?);
    let edge = |from: usize, to: usize| {
        let [from, to] = [from, to].map(|i| mesh.positions.get(i).map(|&p| Vec3::from(p)));
        Some(to_world(to? - from?))
    };
    let (along, across) = (edge(a, b)?, edge(a, c)?);
    let (first, second) = (change(a, b)?, change(a, c)?);
    let (uu, uv, vv) = (along.dot(along), along.dot(across), across.dot(across));
    let area = uu * vv - uv * uv;
    let slope = match area > 0.0 {
        true => (along * (first * vv - second * uv) + across * (second * uu - first * uv)) / area,
        false => along * (first / uu),
    };
    slope.is_finite().then_some(slope)
}

/// Red, green, blue and opacity; white where the mesh has none.
pub(super) fn vertex_color(mesh: &Mesh, corners: [usize; 3], weights: [f32; 3]) -> [f32; 4] {
    if mesh.colors.is_empty() {
        return [1.0; 4];
    }
    let colors = corners.map(|i| mesh.colors.get(i).copied().unwrap_or([1.0; 4]));
    std::array::from_fn(|k| (0..3).map(|c| weights[c] * colors[c][k]).sum())
}
