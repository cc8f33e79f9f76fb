// SPDX-License-Identifier: GPL-3.0-or-later
//! The layer of motion: where the points of a picture were in the frame before, and will be in the next one.
//! Known: cameras, instances, and vertices of bent meshes. Not known: members that move within an object; they count as
//! at rest there. Points seen in mirrors and through glass are virtual: they lie straight on from the eye, as far as the
//! way there is long, and move as mirror images in the plane of the mirror, if one mirror shows them. Space: world; pixels to the right and down.
//! Tests: the command line's `tests/program/film.rs`.

use std::sync::Arc;

use crate::denoise::film::MOTION;
use crate::image::{ChannelData, Layer, Picture};
use crate::render::CameraMatrices;
use crate::scene::{Affine, Camera, Instance, Mesh, MeshId, Scene};

/// A scene at one time, as far as it moves. Meshes are shared with the scene until it bends them.
#[derive(Clone, Debug)]
pub struct FramePose {
    camera: Camera,
    instances: Vec<Instance>,
    meshes: Vec<Arc<Mesh>>,
    /// The meshes of each object.
    objects: Vec<Vec<MeshId>>,
}

/// Points of the sky are so far away, in world units.
const FAR: f64 = 1e9;

impl FramePose {
    /// The scene as it is shown now, seen by a camera.
    #[must_use]
    pub fn of(scene: &Scene, camera: &Camera) -> Self {
        Self {
            camera: camera.clone(),
            instances: scene.instances().to_vec(),
            meshes: scene.meshes().to_vec(),
            objects: scene.objects().iter().map(|object| object.meshes.clone()).collect(),
        }
    }

    /// Adds the layer `motion` to a picture of this pose, with the poses of the frames before and after, if there are
    /// any. Without the layers `P`, `depth` and `id`, or for a camera without matrices, nothing moves in it.
    pub fn add_motion(&self, picture: &mut Picture, before: Option<&Self>, after: Option<&Self>) {
        let pixels = picture.pixel_count();
        let mut planes: [Vec<f32>; 6] = std::array::from_fn(|_| vec![0.0; pixels]);
        let aspect = picture.width as f32 / picture.height as f32;
        if let (Some(hits), Some(eye)) = (Hits::of(picture), Eye::of(&self.camera, aspect)) {
            let seen = Seen::of(picture);
            for (other, [x, y, far]) in [(before, [0, 1, 4]), (after, [2, 3, 5])] {
                let Some((other, lens)) =
                    other.and_then(|other| Some((other, Eye::of(&other.camera, aspect)?)))
                else {
                    continue;
                };
                let ways = self.ways(other);
                let size = [f64::from(picture.width), f64::from(picture.height)];
                let step = |p: usize| -> Option<[f32; 3]> {
                    let (here, there) = match (hits.point(p), &seen) {
                        (Some(point), Some(seen))
                            if seen.hits.prim[p] != hits.prim[p]
                                || seen.hits.instance[p] != hits.instance[p] =>
                        {
                            self.virtual_points(
                                other,
                                &ways,
                                [&hits, &seen.hits],
                                p,
                                (eye.at, point, seen.way[p]),
                            )?
                        }
                        (Some(point), _) => (point, self.moved(other, &ways, &hits, p, point)),
                        (None, _) => (eye.beyond(p, size), eye.beyond(p, size)),
                    };
                    let (from, to) = (eye.project(here, size)?, lens.project(there, size)?);
                    Some([to[0] - from[0], to[1] - from[1], distance(there, lens.at)].map(|x| x as f32))
                };
                let steps: Vec<[f32; 3]> = (0..pixels).map(|p| step(p).unwrap_or_default()).collect();
                for (k, plane) in [x, y, far].into_iter().enumerate() {
                    planes[plane] = steps.iter().map(|step| step[k]).collect();
                }
            }
        }
        let [x, y, z, w, nearer, later] = planes;
        let channels = [("X", x), ("Y", y), ("Z", z), ("W", w), ("before", nearer), ("after", later)];
        picture.layers.push(Layer::floats(MOTION, channels));
    }

    /// For each instance: from world to object here, and from object to world there; `None` where it rests or is gone.
    fn ways(&self, other: &Self) -> Vec<Option<[Affine; 2]>> {
        let way = |(here, there): (&Instance, &Instance)| {
            let rests = here.world_from_object == there.world_from_object;
            let inverse = here.world_from_object.inverse().filter(|_| here.object == there.object)?;
            (!rests || self.bends(other, here)).then_some([inverse, there.world_from_object])
        };
        self.instances.iter().zip(&other.instances).map(way).collect()
    }

    fn bends(&self, other: &Self, instance: &Instance) -> bool {
        let meshes = self.objects.get(instance.object.index()).into_iter().flatten();
        meshes.into_iter().any(|id| self.bent(other, *id).is_some())
    }

    /// The mesh here and there, if it differs.
    fn bent<'a>(&'a self, other: &'a Self, id: MeshId) -> Option<[&'a Mesh; 2]> {
        let (here, there) = (self.meshes.get(id.index())?, other.meshes.get(id.index())?);
        let is_same_shape = here.positions.len() == there.positions.len()
            && here.indices == there.indices
            && here.has_triangles();
        let moves = !Arc::ptr_eq(here, there) && is_same_shape && here.positions != there.positions;
        moves.then_some([here, there])
    }

    /// The apparent point that a mirror or glass shows in pixel `p`, here and in another pose, if the surface is met at
    /// `met` and the whole way is as long as `way`; `None` for the sky.
    fn virtual_points(
        &self,
        other: &Self,
        ways: &[Option<[Affine; 2]>],
        [first, seen]: [&Hits; 2],
        p: usize,
        (eye, met, way): ([f64; 3], [f64; 3], f32),
    ) -> Option<([f64; 3], [f64; 3])> {
        let real = seen.point(p).filter(|_| way.is_finite())?;
        let moved = self.moved(other, ways, seen, p, real);
        let towards = minus(met, eye);
        let scale = f64::from(way) / dot(towards, towards).sqrt().max(1e-12);
        let here = [0, 1, 2].map(|k| eye[k] + scale * towards[k]);
        // A mirror halves the way between a point and its image.
        let across = minus(here, real);
        let length = dot(across, across).sqrt();
        let middle = [0, 1, 2].map(|k| 0.5 * (here[k] + real[k]));
        let normal = across.map(|x| x / length.max(1e-12));
        let is_mirrored =
            length > 1e-3 * f64::from(way) && dot(minus(met, middle), normal).abs() < 0.02 * f64::from(way);
        if !is_mirrored {
            let by = minus(moved, real);
            return Some((here, [0, 1, 2].map(|k| here[k] + by[k])));
        }
        let with = |point: [f64; 3]| match ways.get(first.instance[p] as usize).and_then(Option::as_ref) {
            Some([inverse, there]) => there.point(inverse.point(point)),
            None => point,
        };
        let (middle, end) = (with(middle), with([0, 1, 2].map(|k| middle[k] + normal[k])));
        let normal = minus(end, middle);
        let off = 2.0 * dot(minus(moved, middle), normal) / dot(normal, normal).max(1e-12);
        Some((here, [0, 1, 2].map(|k| moved[k] - off * normal[k])))
    }

    /// Where a point of pixel `p` is in another pose.
    fn moved(
        &self,
        other: &Self,
        ways: &[Option<[Affine; 2]>],
        hits: &Hits,
        p: usize,
        point: [f64; 3],
    ) -> [f64; 3] {
        let instance = hits.instance[p] as usize;
        let Some([inverse, there]) = ways.get(instance).and_then(Option::as_ref) else { return point };
        let local = inverse.point(point);
        let object = self.instances[instance].object.index();
        let is_own = hits.object[p] as usize == object;
        let meshes = self.objects.get(object).into_iter().flatten().filter(|_| is_own);
        let on = meshes.filter_map(|&id| {
            let [here, mesh] =
                self.bent(other, id).filter(|[mesh, _]| mesh.material.0 == hits.material[p])?;
            let corners = *here.indices.get(hits.prim[p] as usize)?;
            let at = |mesh: &Mesh| corners.map(|i| mesh.positions[i as usize].map(f64::from));
            on_triangle(at(here), at(mesh), local)
        });
        let local = on.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(local, |(moved, _)| moved);
        there.point(local)
    }
}

/// The point of another triangle with the same barycentric coordinates, and the distance of the point from its plane; `None` if it
/// is not on the triangle.
fn on_triangle(from: [[f64; 3]; 3], to: [[f64; 3]; 3], p: [f64; 3]) -> Option<([f64; 3], f64)> {
    let (u, v, w) = (minus(from[1], from[0]), minus(from[2], from[0]), minus(p, from[0]));
    let (uu, uv, vv, wu, wv) = (dot(u, u), dot(u, v), dot(v, v), dot(w, u), dot(w, v));
    let area = uu * vv - uv * uv;
    let (s, t) = ((vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area);
    let rest = minus(w, [0, 1, 2].map(|k| s * u[k] + t * v[k]));
    let off = dot(rest, rest).sqrt();
    let is_on = s > -0.05 && t > -0.05 && s + t < 1.05 && off * off < 0.01 * (uu + vv);
    let moved = [0, 1, 2].map(|k| to[0][k] + s * (to[1][k] - to[0][k]) + t * (to[2][k] - to[0][k]));
    is_on.then_some((moved, off))
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// A camera with matrices.
struct Eye {
    at: [f64; 3],
    ndc_from_world: [f64; 16],
    axes: [[f64; 3]; 3],
    /// Half sides of the picture at distance 1, or of the view if it is parallel.
    half: [f64; 2],
}

impl Eye {
    fn of(camera: &Camera, aspect: f32) -> Option<Self> {
        let ndc_from_world = CameraMatrices::new(camera, aspect)?.ndc_from_world?;
        let frame = camera.frame()?;
        let high = (f64::from(camera.fov_y).to_radians() / 2.0).tan();
        let axes = [frame.right, frame.up, frame.forward].map(|axis| axis.map(f64::from));
        let half = [high * f64::from(aspect), high];
        Some(Self { at: camera.eye.map(f64::from), ndc_from_world, axes, half })
    }

    /// A point of the sky behind a pixel.
    fn beyond(&self, p: usize, [width, height]: [f64; 2]) -> [f64; 3] {
        let (column, row) = (p % width as usize, p / width as usize);
        let x = ((column as f64 + 0.5) / width * 2.0 - 1.0) * self.half[0];
        let y = (1.0 - (row as f64 + 0.5) / height * 2.0) * self.half[1];
        let [right, up, forward] = self.axes;
        [0, 1, 2].map(|k| self.at[k] + FAR * (forward[k] + x * right[k] + y * up[k]))
    }

    /// Where a point is in a picture, if it is before the camera.
    fn project(&self, p: [f64; 3], [width, height]: [f64; 2]) -> Option<[f64; 2]> {
        let m = &self.ndc_from_world;
        let row = |r: usize| m[4 * r] * p[0] + m[4 * r + 1] * p[1] + m[4 * r + 2] * p[2] + m[4 * r + 3];
        let w = row(3);
        (w > 1e-9).then(|| [row(0) / w * width, row(1) / w * height])
    }
}

/// The points that mirrors and glass show, and the lengths of the ways there.
struct Seen {
    hits: Hits,
    way: Vec<f32>,
}

impl Seen {
    fn of(picture: &Picture) -> Option<Self> {
        let ChannelData::F32(way) = &picture.layer("seen_depth")?.channel("Z")?.data else { return None };
        Some(Self { hits: Hits::of_layers(picture, "seen_P", "seen_id")?, way: way.clone() })
    }
}

/// The layers that tell points.
struct Hits {
    position: [Vec<f32>; 3],
    instance: Vec<u32>,
    object: Vec<u32>,
    prim: Vec<u32>,
    material: Vec<u32>,
}

impl Hits {
    fn of(picture: &Picture) -> Option<Self> {
        Self::of_layers(picture, "P", "id")
    }

    fn of_layers(picture: &Picture, position: &str, id: &str) -> Option<Self> {
        let channel = |layer: &str, name: &str| Some(&picture.layer(layer)?.channel(name)?.data);
        let position = |name: &str| match channel(position, name)? {
            ChannelData::F32(values) => Some(values.clone()),
            ChannelData::U32(_) => None,
        };
        let ids = |name: &str| match channel(id, name)? {
            ChannelData::U32(values) => Some(values.clone()),
            ChannelData::F32(_) => None,
        };
        Some(Self {
            position: [position("X")?, position("Y")?, position("Z")?],
            instance: ids("instance")?,
            object: ids("object")?,
            prim: ids("prim")?,
            material: ids("material")?,
        })
    }

    /// The point of a pixel; `None` for the sky.
    fn point(&self, p: usize) -> Option<[f64; 3]> {
        (self.prim[p] != u32::MAX).then(|| [0, 1, 2].map(|k| f64::from(self.position[k][p])))
    }
}
